"""Writes a copy of a glTF file that has one more camera.

    python3 scenes/add_camera.py IN OUT --eye X Y Z --target X Y Z [--yfov DEGREES] [--name NAME]

IN and OUT are both .gltf or both .glb. A copy of a .gltf goes into the same folder, where its buffers
and textures are. Units are the file's own, +Y is up. What else the file holds stays as it is.
"""

import argparse
import json
import math
import pathlib
import sys

sys.dont_write_bytecode = True
sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))
import glb  # noqa: E402


def looking(eye, target):
    """The column-major matrix of a node at `eye` whose -Z points at `target`."""
    back = [a - b for a, b in zip(eye, target)]
    length = math.hypot(*back)
    level = math.hypot(back[0], back[2])
    if not level > 1e-6 * length:
        raise SystemExit("add_camera: the camera looks straight up or down, or at its own place")
    back = [component / length for component in back]
    right = [back[2] * length / level, 0.0, -back[0] * length / level]
    up = [back[1] * right[2] - back[2] * right[1], back[2] * right[0] - back[0] * right[2],
          back[0] * right[1] - back[1] * right[0]]
    return [*right, 0.0, *up, 0.0, *back, 0.0, *eye, 1.0]


def add_camera(document, name, eye, target, yfov_degrees):
    """The camera becomes a root node of the scene that is shown."""
    far = 100.0 * math.dist(eye, target)
    document.setdefault("cameras", []).append({
        "name": name, "type": "perspective",
        "perspective": {"yfov": math.radians(yfov_degrees), "aspectRatio": 16 / 9,
                        "znear": far / 1e5, "zfar": far}})
    document.setdefault("nodes", []).append({
        "name": name, "camera": len(document["cameras"]) - 1, "matrix": looking(eye, target)})
    scene = document["scenes"][document.get("scene", 0)]
    scene.setdefault("nodes", []).append(len(document["nodes"]) - 1)


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n", 1)[0])
    parser.add_argument("source", metavar="IN", type=pathlib.Path)
    parser.add_argument("out", metavar="OUT", type=pathlib.Path)
    for name in ("eye", "target"):
        parser.add_argument(f"--{name}", nargs=3, type=float, required=True, metavar=tuple("XYZ"))
    parser.add_argument("--yfov", type=float, default=45.0, metavar="DEGREES")
    parser.add_argument("--name", default="main")
    given = parser.parse_args()
    if {given.source.suffix, given.out.suffix} not in ({".gltf"}, {".glb"}):
        parser.error("IN and OUT are both .gltf or both .glb")
    if given.out.suffix == ".gltf" and given.out.resolve().parent != given.source.resolve().parent:
        parser.error("OUT goes into the folder of IN, where its buffers and textures are")
    camera = (given.name, given.eye, given.target, given.yfov)
    if given.source.suffix == ".gltf":
        document = json.loads(given.source.read_text(encoding="utf-8"))
        add_camera(document, *camera)
        given.out.write_text(json.dumps(document), encoding="utf-8")
    else:
        document, blob = glb.parse(given.source.read_bytes())
        add_camera(document, *camera)
        given.out.write_bytes(glb.unparse(document, blob))


if __name__ == "__main__":
    main()
