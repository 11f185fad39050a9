"""The scenes that stand in for the papers' figures: what the figures need is in them.

    python3 tests/scenes/test_figure_scenes.py

That the committed scripts make them is tested with the other scenes, in test_scenes.py.
"""

import collections
import json
import math
import os
import pathlib
import struct
import subprocess
import sys
import tempfile
import unittest

from scene_files import SCENES, bounds, committed, lights, load, placed, points_along
import glb  # found by scene_files

NAMES = ("skyline", "atrium", "factory", "blocks", "columns", "toes", "still_life",
         "coloured_boxes")
MIB = 2 ** 20


def materials(document):
    return {material["name"]: material for material in document["materials"]}


def material_of(document, node_name):
    """The material of what is placed under a name."""
    node = next(node for node in document["nodes"] if node.get("name") == node_name)
    primitives = document["meshes"][node["mesh"]]["primitives"]
    return document["materials"][primitives[0]["material"]]


def uses(document):
    """How often each mesh is placed."""
    return collections.Counter(node["mesh"] for node in document["nodes"] if "mesh" in node)


class FigureScenes(unittest.TestCase):
    def occlab(self, document):
        return document["scenes"][0]["extras"]["occlab"]

    def test_all_are_as_the_others(self):
        for name in NAMES:
            document, blob = committed(name)
            with self.subTest(scene=name):
                self.assertEqual(self.occlab(document)["resolution"], [1280, 720])
                self.assertEqual(self.occlab(document)["warnings"], [])
                self.assertIn(document["cameras"][0]["name"], ("main", "frame1"))
                self.assertLess((SCENES / name / f"{name}.glb").stat().st_size, 2 * MIB)
                for material in document["materials"]:
                    surface = material["pbrMetallicRoughness"]
                    self.assertEqual(surface["metallicFactor"], 0)
                    if "baseColorTexture" not in surface:
                        self.assertLessEqual(max(surface["baseColorFactor"][:3]), 0.87)
                for mesh in document["meshes"]:
                    for primitive in mesh["primitives"]:
                        normals = glb.accessor_values(document, blob,
                                                      primitive["attributes"]["NORMAL"])
                        self.assertLess(max(abs(x * x + y * y + z * z - 1.0) for x, y, z in zip(
                            normals[0::3], normals[1::3], normals[2::3])), 1e-5, mesh["name"])

    def test_skyline_has_towers_under_the_sun(self):
        document, blob = committed("skyline")
        self.assertEqual(self.occlab(document)["world"]["probe"], "sky_sun")
        self.assertEqual([m["name"] for m in document["materials"]], ["white"])
        self.assertGreater(len(uses(document)), 50)
        _, high = bounds(document, blob)
        self.assertTrue(1.0 < high[1] < 1.6, high)

    def test_atrium_is_textured_and_masked(self):
        document, _ = committed("atrium")
        self.assertTrue(200_000 <= glb.triangle_count(document) <= 500_000)
        self.assertEqual([camera["name"] for camera in document["cameras"]],
                         ["main", "drapes", "gallery"])
        found = materials(document)
        for name in ("floor", "ashlar", "marble", "red cloth", "green cloth", "blue cloth", "leaf"):
            self.assertIn("baseColorTexture", found[name]["pbrMetallicRoughness"], name)
        self.assertEqual(found["leaf"]["alphaMode"], "MASK")
        self.assertEqual(found["leaf"]["alphaCutoff"], 0.5)
        self.assertEqual([m["name"] for m in document["materials"] if "alphaMode" in m], ["leaf"])
        for mesh in document["meshes"]:
            for primitive in mesh["primitives"]:
                surface = document["materials"][primitive["material"]]["pbrMetallicRoughness"]
                self.assertEqual("baseColorTexture" in surface,
                                 "TEXCOORD_0" in primitive["attributes"], mesh["name"])

    def test_atrium_drapes_hang_the_right_way_up(self):
        """v grows downwards with the cloth: the hem is the image's lower edge."""
        document, blob = committed("atrium")
        drapes = [mesh for mesh in document["meshes"] if mesh["name"].endswith(" drape")]
        self.assertEqual(len(drapes), 3)
        for mesh in drapes:
            attributes = mesh["primitives"][0]["attributes"]
            heights = glb.accessor_values(document, blob, attributes["POSITION"])[1::3]
            below = glb.accessor_values(document, blob, attributes["TEXCOORD_0"])[1::2]
            self.assertAlmostEqual(below[heights.index(min(heights))], 1.0, places=5)
            self.assertLess(below[heights.index(max(heights))], 0.001)

    def test_factory_has_537_thousand_polygons_by_instancing(self):
        document, _ = committed("factory")
        triangles = glb.triangle_count(document)
        self.assertAlmostEqual(triangles / 537_000, 1.0, delta=0.01)
        once = sum(glb.mesh_triangles(document, mesh) for mesh in uses(document))
        self.assertLess(once, triangles / 10)
        self.assertGreaterEqual(len({tuple(m["pbrMetallicRoughness"]["baseColorFactor"])
                                     for m in document["materials"]}), 8)

    def test_columns_hide_the_pink_one(self):
        """Every ray from the camera to the pink column's outline meets the white one first."""
        document, _ = committed("columns")
        pink = material_of(document, "pink column")["pbrMetallicRoughness"]["baseColorFactor"]
        self.assertGreater(pink[0], 2.0 * max(pink[1:3]))
        camera = placed(document, "main")
        eye = (camera[0][3], -camera[2][3])  # from above: right, away from the camera
        # The foot is 3 cm wider than the shaft, and stands low enough to be hidden by the foot.
        for foot in (0.0, 0.03):
            half = math.asin((0.21 + foot) / math.dist(eye, (0.0, 0.52)))
            cover = math.asin((0.24 + foot) / math.dist(eye, (0.0, 0.0)))
            self.assertLess(half, cover)
        self.assertEqual([light["type"] for light in lights(document)], ["directional"])
        self.assertGreater(points_along(placed(document, "sun"))[0], 0.5)  # from the left

    def test_blocks_frames_go_round_the_yellow_face(self):
        """The face looks along +X; its angle to the view's direction falls from frame to frame."""
        document, _ = committed("blocks")
        self.assertEqual([c["name"] for c in document["cameras"]],
                         ["frame1", "frame2", "frame3", "frame4"])
        yellow = material_of(document, "yellow board")["pbrMetallicRoughness"]["baseColorFactor"]
        self.assertGreater(min(yellow[:2]), 5.0 * yellow[2])
        # cos between the face's normal and the way from its middle to the camera.
        facing = []
        for name in ("frame1", "frame2", "frame3", "frame4"):
            eye = [placed(document, name)[i][3] for i in range(3)]
            facing.append((eye[0] - 0.02) / math.dist(eye, (0.02, 0.3, 0.0)))
        self.assertEqual(facing, sorted(facing, reverse=True))
        self.assertGreater(facing[0], 0.4)
        self.assertLess(facing[3], -0.1)

    def test_still_life_has_a_lamp_beside_the_yellow_box(self):
        document, _ = committed("still_life")
        self.assertEqual(self.occlab(document)["world"]["probe"], "cathedral")
        self.assertEqual([light["type"] for light in lights(document)], ["point"])
        self.assertAlmostEqual(lights(document)[0]["intensity"], 5.0, places=4)
        box = placed(document, "yellow box")
        self.assertGreater(placed(document, "lamp")[0][3], box[0][3] + 0.24)
        yellow = material_of(document, "yellow box")["pbrMetallicRoughness"]["baseColorFactor"]
        self.assertGreater(min(yellow[:2]), 5.0 * yellow[2])

    def test_switched_lights_differ_in_their_places_alone(self):
        as_they_are, _ = committed("three_boxes")
        switched, _ = committed("three_boxes_switched")
        self.assertEqual(lights(as_they_are), lights(switched))
        self.assertEqual(as_they_are["meshes"], switched["meshes"])
        for one, other in (("pink", "turquoise"), ("turquoise", "pink")):
            for a, b in zip(points_along(placed(as_they_are, one)),
                            points_along(placed(switched, other))):
                self.assertAlmostEqual(a, b, places=6)

    def test_coloured_boxes_stand_on_both_sides(self):
        document, _ = committed("coloured_boxes")
        for name, side, brightest in (("blue box", -1, 2), ("green box", 1, 1)):
            self.assertGreater(side * placed(document, name)[0][3], 0.5)
            colour = material_of(document, name)["pbrMetallicRoughness"]["baseColorFactor"][:3]
            self.assertEqual(colour.index(max(colour)), brightest)
        self.assertEqual(len(lights(document)), 2)

    def test_toes_touch_the_plinth(self):
        document, blob = committed("toes")
        self.assertEqual([camera["name"] for camera in document["cameras"]], ["main", "small"])
        names = [node.get("name", "") for node in document["nodes"] if "mesh" in node]
        self.assertEqual(sum("foot" in name for name in names), 2)
        self.assertGreaterEqual(sum(name.startswith(("bead", "peg")) for name in names), 12)
        for node, matrix in glb.placed_nodes(document):
            if "mesh" not in node or not node["name"].startswith(("bead", "peg", "left", "right")):
                continue
            lowest = math.inf
            for primitive in document["meshes"][node["mesh"]]["primitives"]:
                values = glb.accessor_values(document, blob, primitive["attributes"]["POSITION"])
                lowest = min(lowest, min(
                    sum(matrix[1][j] * point[j] for j in range(3)) + matrix[1][3]
                    for point in zip(values[0::3], values[1::3], values[2::3])))
            self.assertAlmostEqual(lowest, 0.12 - 0.001, places=5, msg=node["name"])

    def test_textures_are_small(self):
        document, blob = committed("atrium")
        for image in document["images"]:
            data = glb.view_bytes(document, blob, image["bufferView"])
            self.assertEqual(data[:8], b"\x89PNG\r\n\x1a\n")
            width, height, bits, kind = struct.unpack(">IIBB", data[16:26])
            self.assertLessEqual(max(width, height), 256)
            self.assertEqual(bits, 8)
            self.assertEqual(kind, 6 if image["name"] == "leaf" else 2, image["name"])


class AddCamera(unittest.TestCase):
    def test_a_scene_gets_a_camera_that_looks_where_it_is_told(self):
        with tempfile.TemporaryDirectory() as folder:
            out = pathlib.Path(folder) / "seen.glb"
            self.run_script(SCENES / "blocks/blocks.glb", out, "--eye", "3", "2", "1", "--target",
                            "0", "2", "5", "--name", "extra", "--yfov", "30")
            document, _ = load(out)
            self.assertEqual(document["cameras"][-1]["name"], "extra")
            self.assertAlmostEqual(document["cameras"][-1]["perspective"]["yfov"], math.pi / 6)
            matrix = placed(document, "extra")
            for found, expected in zip(points_along(matrix), (-0.6, 0.0, 0.8)):
                self.assertAlmostEqual(found, expected, places=6)
            self.assertEqual([round(matrix[i][1], 6) for i in range(3)], [0.0, 1.0, 0.0])
            self.assertEqual([matrix[i][3] for i in range(3)], [3.0, 2.0, 1.0])

    def test_a_gltf_keeps_its_folder_and_renders(self):
        with tempfile.TemporaryDirectory() as folder:
            document, blob = committed("atrium")
            folder = pathlib.Path(folder)
            (folder / "data.bin").write_bytes(blob)
            document["buffers"][0]["uri"] = "data.bin"
            document["nodes"] = [n for n in document["nodes"] if "camera" not in n]
            document["scenes"][0]["nodes"] = list(range(len(document["nodes"])))
            del document["cameras"]
            for number, image in enumerate(document["images"]):
                name = f"texture {number}.png"
                (folder / name).write_bytes(glb.view_bytes(document, blob, image["bufferView"]))
                del image["bufferView"], image["mimeType"]
                image["uri"] = name.replace(" ", "%20")
            (folder / "bare.gltf").write_text(json.dumps(document), encoding="utf-8")
            self.run_script(folder / "bare.gltf", folder / "seen.gltf", "--eye", "0", "1.7", "-1",
                            "--target", "0", "2", "-8")
            occlab = os.environ.get("OCCLAB")
            if not occlab:
                self.skipTest("OCCLAB is not set")
            arguments = ("--probe", "sky_sun", "--resolution", "64", "36", "--method", "ssao", "-o")
            bare = subprocess.run([occlab, "render", "--scene", folder / "bare.gltf", *arguments,
                                   folder / "bare.exr"], capture_output=True, text=True, check=False)
            self.assertEqual(bare.returncode, 2)
            self.assertIn("no camera", bare.stderr)
            seen = subprocess.run([occlab, "render", "--scene", folder / "seen.gltf", *arguments,
                                   folder / "seen.exr"], capture_output=True, text=True, check=False)
            self.assertEqual(seen.returncode, 0, seen.stderr)
            (folder / "texture 0.png").unlink()
            gone = subprocess.run([occlab, "render", "--scene", folder / "seen.gltf", *arguments,
                                   folder / "gone.exr"], capture_output=True, text=True, check=False)
            self.assertEqual(gone.returncode, 2)
            self.assertIn("texture 0.png", gone.stderr)

    def test_impossible_ones_are_refused(self):
        with tempfile.TemporaryDirectory() as folder:
            out = pathlib.Path(folder) / "seen.glb"
            scene = SCENES / "blocks/blocks.glb"
            for arguments in ((scene, out, "--eye", "0", "5", "0", "--target", "0", "0", "0"),
                              (scene, out.with_suffix(".gltf"), "--eye", "1", "1", "1", "--target",
                               "0", "0", "0")):
                self.assertNotEqual(self.start(*arguments).returncode, 0)
                self.assertFalse(out.exists())

    def start(self, *arguments):
        return subprocess.run([sys.executable, SCENES / "add_camera.py", *arguments],
                              capture_output=True, text=True, check=False)

    def run_script(self, *arguments):
        finished = self.start(*arguments)
        self.assertEqual(finished.returncode, 0, finished.stderr)


if __name__ == "__main__":
    unittest.main(verbosity=2)
