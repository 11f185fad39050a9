"""What the tests of scenes share: reading .glb files, and Blender where it is.

Tests of a Blender export run where `blender` (with its numpy) is on PATH and are reported as skipped
for that reason where it is not. OCCLAB_REQUIRE_BLENDER=1 makes its absence a failure.
"""

import math
import os
import pathlib
import shutil
import subprocess
import sys
import tempfile
import unittest

sys.dont_write_bytecode = True
HERE = pathlib.Path(__file__).resolve().parent
SCENES = HERE.parents[1] / "scenes"
sys.path.insert(0, str(SCENES))
import glb  # noqa: E402

BLENDER = shutil.which("blender")


def load(path):
    return glb.parse(pathlib.Path(path).read_bytes())


def committed(name):
    return load(SCENES / name / f"{name}.glb")


def run_blender(*arguments):
    # Blender takes its Python from where PATH's first python3 is: let that be its own neighbour,
    # not the one of a virtual environment that runs this test.
    path = os.pathsep.join((str(pathlib.Path(BLENDER).parent), os.environ["PATH"]))
    return subprocess.run(
        [BLENDER, "--background", "--factory-startup", "--python-exit-code", "3",
         *map(str, arguments)], capture_output=True, text=True, timeout=300, check=False,
        env={**os.environ, "PATH": path})


def lights(document):
    return document.get("extensions", {}).get("KHR_lights_punctual", {}).get("lights", [])


def placed(document, name):
    """World matrix of the node called `name`."""
    found = [matrix for node, matrix in glb.placed_nodes(document) if node.get("name") == name]
    if len(found) != 1:
        raise AssertionError(f"{len(found)} nodes are called {name}")
    return found[0]


def points_along(matrix):
    """Where a camera or a light at this matrix looks."""
    length = math.hypot(*(matrix[i][2] for i in range(3)))
    return [-matrix[i][2] / length for i in range(3)]


def vertices(document, blob, primitive):
    values = glb.accessor_values(document, blob, primitive["attributes"]["POSITION"])
    return list(zip(values[0::3], values[1::3], values[2::3]))


def bounds(document, blob):
    low, high = [math.inf] * 3, [-math.inf] * 3
    for node, matrix in glb.placed_nodes(document):
        if "mesh" in node:
            for primitive in document["meshes"][node["mesh"]]["primitives"]:
                for point in vertices(document, blob, primitive):
                    for i in range(3):
                        value = sum(matrix[i][j] * point[j] for j in range(3)) + matrix[i][3]
                        low[i], high[i] = min(low[i], value), max(high[i], value)
    return low, high


class WithBlender(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        if BLENDER is None:
            if os.environ.get("OCCLAB_REQUIRE_BLENDER") == "1":
                raise AssertionError("blender is not on PATH, and OCCLAB_REQUIRE_BLENDER is 1")
            raise unittest.SkipTest("blender is not on PATH (Debian: blender, python3-numpy)")
        folder = tempfile.TemporaryDirectory()
        cls.addClassCleanup(folder.cleanup)
        cls.folder = pathlib.Path(folder.name)
