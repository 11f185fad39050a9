"""Builds the stand-in for the SSDO paper's Figure 4: light that a yellow surface throws on the floor.

    blender --background --factory-startup --python-exit-code 3 \
        --python scenes/blocks/build.py -- scenes/blocks/blocks.glb

Blocks on a floor; a block's right face is yellow and lit by the sun. The four frames are four cameras,
`frame1` to `frame4`, that go round the blocks from right to left, so that the yellow face gets
smaller on the screen until it is not seen at all. What it throws on the floor stays the same in truth,
so that what a screen-space bounce loses from frame to frame is its own error.
"""

import math
import pathlib
import sys

sys.dont_write_bytecode = True
sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent.parent))
import modelling as m  # noqa: E402

SINK = m.SINK
TARGET = (0.25, 0.0, 0.22)

m.begin()
white = m.lambert("white", 0.8)
yellow = m.lambert("yellow", (0.85, 0.65, 0.05))
blue = m.lambert("blue", (0.10, 0.22, 0.70))
m.add("floor", m.box_mesh("floor", (-9, -9, -0.1), (9, 9, 0)), white)

# Half-width, half-depth, height; centre; turn.
for name, (x, y, height), centre, turn, surface in (
        ("block", (0.20, 0.42, 0.62), (-0.22, 0.0), 0.0, white),
        ("blue block", (0.22, 0.16, 0.34), (0.30, 0.85), 20.0, blue),
        ("low block", (0.26, 0.18, 0.16), (-0.95, 0.55), -14.0, white)):
    m.add(name, m.box_mesh(name, (-x, -y, -SINK), (x, y, height)), surface,
          location=(*centre, 0.0), rotation_z=turn)
# The yellow face: a board on the block's right side, open to the sun.
m.add("yellow board", m.box_mesh("yellow board", (-0.021, -0.40, -SINK), (0.02, 0.40, 0.60)), yellow)

m.sun("sun", (0.80, -0.25, 0.52), (1.0, 0.96, 0.88), 3.0)
for number, degrees in enumerate((32.0, 6.0, -8.0, -30.0)):
    angle = math.radians(degrees)
    m.camera(f"frame{number + 1}", (TARGET[0] + 3.0 * math.sin(angle), -3.0 * math.cos(angle), 1.55),
             TARGET, 38.0)
m.probe_world("dusk", 0.6)
m.finish()
