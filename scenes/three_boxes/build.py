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

LEFT, RIGHT = (-0.74, -0.36, 0.72), (0.74, -0.36, 0.72)


def build(pink_from, turquoise_from):
    modelling.begin()
    white = modelling.lambert("white", 0.8)

    modelling.add("plane", modelling.mesh_of(
        "plane", [(-12, -12, 0), (12, -12, 0), (12, 12, 0), (-12, 12, 0)], [(0, 1, 2, 3)]), white)

    # Half-width, half-depth, height; centre; turn. Narrow gaps: between two boxes a point sees the
    # light of one side only.
    for name, (x, y, height), centre, turn in (
            ("left box", (0.36, 0.40, 0.66), (-1.06, -0.10), 24.0),
            ("middle box", (0.34, 0.38, 1.20), (0.02, 0.42), 38.0),
            ("right box", (0.44, 0.34, 0.48), (1.06, -0.20), -28.0)):
        mesh = modelling.box_mesh(name, (-x, -y, -modelling.SINK), (x, y, height))
        modelling.add(name, mesh, white, location=(*centre, 0.0), rotation_z=turn)

    modelling.sun("pink", pink_from, (1.0, 0.22, 0.55), 2.4)
    modelling.sun("turquoise", turquoise_from, (0.12, 0.90, 0.80), 2.4)
    modelling.camera("main", (0.0, -4.5, 3.10), (0.0, 0.10, 0.38), 44.0)

    modelling.finish()


if __name__ == "__main__":
    build(LEFT, RIGHT)
