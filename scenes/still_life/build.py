"""Builds the stand-in for the SSDO paper's Figures 3 and 13: things on a table in the corner of a room,
under an environment map and one lamp.

    blender --background --factory-startup --python-exit-code 3 \
        --python scenes/still_life/build.py -- scenes/still_life/still_life.glb

The probe's windows have several colours, so that what blocks one of them has a shadow in the colours
of the others. The lamp, a point, hangs on the right and lights the yellow box's side, which throws
yellow light on the ground beside it.
"""

import math
import pathlib
import sys

sys.dont_write_bytecode = True
sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent.parent))
import modelling as m  # noqa: E402

SINK = m.SINK

m.begin()
white = m.lambert("white", 0.8)
yellow = m.lambert("yellow", (0.85, 0.62, 0.05))
m.add("floor", m.box_mesh("floor", (-6, -6, -0.1), (6, 6, 0)), white)
m.add("wall", m.box_mesh("wall", (-6, 1.3, -0.1), (6, 1.5, 1.9)), white)

# Half-width, half-depth, height; centre; turn.
for name, (x, y, height), centre, turn, surface in (
        ("yellow box", (0.24, 0.24, 0.46), (-0.10, 0.15), 16.0, yellow),
        ("tall box", (0.17, 0.15, 0.95), (-0.80, 0.70), -12.0, white),
        ("low box", (0.30, 0.16, 0.16), (0.62, 0.86), 8.0, white)):
    m.add(name, m.box_mesh(name, (-x, -y, -SINK), (x, y, height)), surface,
          location=(*centre, 0.0), rotation_z=turn)
m.add("large ball", m.sphere_mesh("large ball", 0.24, 5), white, location=(-0.62, -0.28, 0.238))
m.add("small ball", m.sphere_mesh("small ball", 0.13, 5), white, location=(0.50, -0.30, 0.128))
# A ring of pegs, whose shadows cross.
for i in range(7):
    angle = 2.0 * math.pi * i / 7
    m.add(f"peg {i}", m.box_mesh(f"peg {i}", (-0.025, -0.025, -SINK), (0.025, 0.025, 0.20)), white,
          location=(1.02 + 0.20 * math.cos(angle), 0.12 + 0.20 * math.sin(angle), 0.0),
          rotation_z=math.degrees(angle))

m.lamp("lamp", (1.35, -0.75, 1.25), (1.0, 0.96, 0.88), 5.0)
m.camera("main", (0.10, -3.3, 1.75), (0.10, 0.25, 0.28), 40.0)
m.probe_world("cathedral")
m.finish()
