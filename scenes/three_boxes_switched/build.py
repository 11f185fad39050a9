"""Builds the lower half of the S3HO paper's Figure 5: three_boxes with its two lights in each other's
places.

    blender --background --factory-startup --python-exit-code 3 \
        --python scenes/three_boxes_switched/build.py -- \
        scenes/three_boxes_switched/three_boxes_switched.glb
"""

import importlib.util
import pathlib
import sys

sys.dont_write_bytecode = True
SCENES = pathlib.Path(__file__).resolve().parent.parent
spec = importlib.util.spec_from_file_location("three_boxes", SCENES / "three_boxes" / "build.py")
three_boxes = importlib.util.module_from_spec(spec)
spec.loader.exec_module(three_boxes)

three_boxes.build(three_boxes.RIGHT, three_boxes.LEFT)
