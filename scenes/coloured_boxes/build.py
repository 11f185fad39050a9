"""Builds the scene of the S3HO paper's Figure 4: a point between two coloured blockers.

    blender --background --factory-startup --python-exit-code 3 \
        --python scenes/coloured_boxes/build.py -- scenes/coloured_boxes/coloured_boxes.glb

On a white floor a blue box stands on the left and a green one on the right. Light from the left falls
on the green box's side, which throws it back to the floor between them, and light from the right on
the blue one's.
"""

import pathlib
import sys

sys.dont_write_bytecode = True
sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent.parent))
import modelling as m  # noqa: E402

m.begin()
white = m.lambert("white", 0.8)
blue = m.lambert("blue", (0.08, 0.16, 0.80))
green = m.lambert("green", (0.08, 0.72, 0.14))
m.add("floor", m.box_mesh("floor", (-9, -9, -0.1), (9, 9, 0)), white)
for name, side, turn, surface in (("blue box", -1, -14.0, blue), ("green box", 1, 14.0, green)):
    m.add(name, m.box_mesh(name, (-0.34, -0.34, -m.SINK), (0.34, 0.34, 0.68)), surface,
          location=(side * 0.58, 0.10, 0.0), rotation_z=turn)
m.sun("left", (-0.62, -0.35, 0.70), (1.0, 1.0, 1.0), 1.6)
m.sun("right", (0.62, -0.35, 0.70), (1.0, 1.0, 1.0), 1.6)
m.camera("main", (0.0, -3.2, 2.3), (0.0, 0.05, 0.22), 40.0)
m.finish()
