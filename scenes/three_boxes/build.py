"""Builds the scene of the S3HO paper's Figure 5: a plane, three boxes, a pink light from the left
and a turquoise one from the right.

    blender --background --factory-startup --python-exit-code 3 \
        --python scenes/three_boxes/build.py -- scenes/three_boxes/three_boxes.glb
"""

import pathlib
import sys

sys.dont_write_bytecode = True
sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent.parent))
import modelling  # noqa: E402

modelling.begin()
white = modelling.lambert("white", 0.8)

modelling.add("plane", modelling.mesh_of(
    "plane", [(-12, -12, 0), (12, -12, 0), (12, 12, 0), (-12, 12, 0)], [(0, 1, 2, 3)]), white)

# Half-width, half-depth, height; centre; turn. Narrow gaps: between two boxes a point sees the
# light of one side only.
for name, (x, y, height), centre, turn in (
        ("left box", (0.42, 0.42, 0.85), (-1.05, -0.05), 14.0),
        ("middle box", (0.36, 0.46, 1.45), (0.05, 0.40), -6.0),
        ("right box", (0.46, 0.36, 0.60), (1.10, -0.25), -20.0)):
    mesh = modelling.box_mesh(name, (-x, -y, -modelling.SINK), (x, y, height))
    modelling.add(name, mesh, white, location=(*centre, 0.0), rotation_z=turn)

modelling.sun("pink", (-0.80, -0.28, 0.55), (1.0, 0.22, 0.55), 2.4)
modelling.sun("turquoise", (0.80, -0.28, 0.55), (0.12, 0.90, 0.80), 2.4)
modelling.camera("main", (0.0, -4.6, 2.75), (0.0, 0.15, 0.42), 44.0)

modelling.finish()
