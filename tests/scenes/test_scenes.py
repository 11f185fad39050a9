"""The committed scenes and probes, and the exporter that made them.

    python3 tests/scenes/test_scenes.py

Needs only Python. The tests of a Blender export run where `blender` (with its numpy) is on PATH and
are reported as skipped for that reason where it is not. OCCLAB_REQUIRE_BLENDER=1 makes its absence
a failure.
"""

import collections
import json
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
import exr  # noqa: E402
import glb  # noqa: E402

NAMES = ("three_boxes", "gallery")
BLENDER = shutil.which("blender")
LUMINANCE = (0.2126, 0.7152, 0.0722)


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


class CommittedScenes(unittest.TestCase):
    def assertClose(self, found, expected, tolerance=1e-5):
        self.assertEqual(len(found), len(expected))
        for a, b in zip(found, expected):
            self.assertAlmostEqual(a, b, delta=tolerance)

    def occlab(self, document):
        return document["scenes"][0]["extras"]["occlab"]

    def test_three_boxes_has_its_two_lights(self):
        document, _ = committed("three_boxes")
        found = {light["name"]: light for light in lights(document)}
        self.assertEqual(set(found), {"pink", "turquoise"})
        self.assertClose(found["pink"]["color"], [1.0, 0.22, 0.55])
        self.assertClose(found["turquoise"]["color"], [0.12, 0.90, 0.80])
        for light in found.values():
            self.assertEqual(light["type"], "directional")
            self.assertAlmostEqual(light["intensity"], 2.4, places=5)
        # Travelling to the right, away from the camera and down; and its mirror image.
        length = math.hypot(0.74, 0.36, 0.72)
        self.assertClose(points_along(placed(document, "pink")),
                         [0.74 / length, -0.72 / length, -0.36 / length])
        self.assertClose(points_along(placed(document, "turquoise")),
                         [-0.74 / length, -0.72 / length, -0.36 / length])

    def test_three_boxes_has_a_plane_and_three_boxes(self):
        document, blob = committed("three_boxes")
        self.assertEqual(glb.triangle_count(document), 2 + 3 * 12)
        self.assertEqual({node["name"] for node, _ in glb.placed_nodes(document) if "mesh" in node},
                         {"plane", "left box", "middle box", "right box"})
        low, high = bounds(document, blob)
        self.assertAlmostEqual(low[1], -0.001, places=6)
        self.assertAlmostEqual(high[1], 1.2, places=6)
        self.assertNotIn("world", self.occlab(document))

    def test_gallery_is_what_figure_8_needs(self):
        document, blob = committed("gallery")
        triangles = glb.triangle_count(document)
        self.assertGreaterEqual(triangles, 50_000)
        self.assertLessEqual(triangles, 300_000)
        self.assertLess((SCENES / "gallery" / "gallery.glb").stat().st_size, 4 * 2**20)
        self.assertEqual([camera["name"] for camera in document["cameras"]],
                         ["main", "corner", "relief"])
        self.assertEqual(lights(document), [])
        self.assertEqual(self.occlab(document)["world"],
                         {"probe": "cathedral", "rotation_degrees": 0.0, "strength": 1.0})
        uses = collections.Counter(node["mesh"] for node in document["nodes"] if "mesh" in node)
        self.assertEqual(sorted(uses.values())[-4:], [3, 4, 4, 4])  # balls; plinth, column, abacus
        low, high = bounds(document, blob)
        self.assertLess(high[0] - low[0], 7.0)
        self.assertGreater(high[0] - low[0], 6.0)

    def test_gallery_meshes_are_closed_and_face_outwards(self):
        document, blob = committed("gallery")
        for mesh in document["meshes"]:
            with self.subTest(mesh=mesh["name"]):
                edges, volume = collections.Counter(), 0.0
                for primitive in mesh["primitives"]:
                    points = vertices(document, blob, primitive)
                    corners = glb.accessor_values(document, blob, primitive["indices"])
                    for i in range(0, len(corners), 3):
                        a, b, c = (points[corner] for corner in corners[i:i + 3])
                        edges.update(((a, b), (b, c), (c, a)))
                        volume += (a[0] * (b[1] * c[2] - b[2] * c[1])
                                   - a[1] * (b[0] * c[2] - b[2] * c[0])
                                   + a[2] * (b[0] * c[1] - b[1] * c[0])) / 6.0
                self.assertEqual([edge for edge, count in edges.items()
                                  if edges[edge[::-1]] != count], [])
                self.assertGreater(volume, 0.0)

    def test_all_is_white_lambert(self):
        for name in NAMES:
            document, _ = committed(name)
            with self.subTest(scene=name):
                self.assertEqual(len(document["materials"]), 1)
                surface = document["materials"][0]["pbrMetallicRoughness"]
                self.assertClose(surface["baseColorFactor"], [0.8, 0.8, 0.8, 1.0], 1e-6)
                self.assertEqual(surface["metallicFactor"], 0)
                for mesh in document["meshes"]:
                    self.assertEqual([p["material"] for p in mesh["primitives"]], [0])

    def test_cameras_see_the_paper_s_format(self):
        for name in NAMES:
            document, _ = committed(name)
            with self.subTest(scene=name):
                self.assertEqual(document["cameras"][0]["name"], "main")
                self.assertEqual(self.occlab(document)["format"], 1)
                self.assertEqual(self.occlab(document)["resolution"], [1280, 720])
                self.assertEqual(self.occlab(document)["warnings"], [])
                for camera in document["cameras"]:
                    self.assertAlmostEqual(camera["perspective"]["aspectRatio"], 16 / 9, places=6)

    def test_normals_are_unit_and_indices_in_range(self):
        for name in NAMES:
            document, blob = committed(name)
            for mesh in document["meshes"]:
                for primitive in mesh["primitives"]:
                    values = glb.accessor_values(document, blob, primitive["attributes"]["NORMAL"])
                    longest = max(abs(x * x + y * y + z * z - 1.0) for x, y, z in
                                  zip(values[0::3], values[1::3], values[2::3]))
                    self.assertLess(longest, 1e-5, mesh["name"])
                    indices = glb.accessor_values(document, blob, primitive["indices"])
                    self.assertEqual(max(indices) + 1, len(values) // 3, mesh["name"])


class CommittedProbes(unittest.TestCase):
    def probe(self, name):
        """Rows of pixels, the maximum luminance and its mean over the sphere."""
        width, height, rows = exr.decode((SCENES / "probes" / f"{name}.exr").read_bytes())
        self.assertEqual((width, height), (256, 128))
        total, weight, highest = 0.0, 0.0, 0.0
        for y, row in enumerate(rows):
            solid_angle = math.sin(math.pi * (0.5 - y / height)) - math.sin(
                math.pi * (0.5 - (y + 1) / height))
            for pixel in row:
                self.assertTrue(all(0.0 <= channel < math.inf for channel in pixel))
                luminance = sum(map(float.__mul__, LUMINANCE, pixel))
                total += solid_angle * luminance
                weight += solid_angle
                highest = max(highest, luminance)
        return rows, highest, total / weight

    def test_cathedral_is_as_extreme_as_grace(self):
        rows, highest, mean = self.probe("cathedral")
        self.assertTrue(3000 <= highest <= 3500, highest)
        self.assertTrue(0.40 <= mean <= 0.45, mean)
        # The windows' hues differ: the brightest texels are led by every channel.
        bright = [pixel for row in rows for pixel in row if max(pixel) > 300]
        self.assertEqual({pixel.index(max(pixel)) for pixel in bright}, {0, 1, 2})

    def test_sky_sun_has_a_yellow_sun_on_the_right(self):
        rows, highest, _ = self.probe("sky_sun")
        brightest = max((sum(pixel), x, y, pixel) for y, row in enumerate(rows)
                        for x, pixel in enumerate(row))
        _, x, y, pixel = brightest
        azimuth = 360.0 * ((x + 0.5) / 256 - 0.5)
        elevation = 180.0 * (0.5 - (y + 0.5) / 128)
        self.assertAlmostEqual(azimuth, 18.0, delta=2.5)
        self.assertAlmostEqual(elevation, 36.0, delta=2.5)
        self.assertTrue(pixel[0] > pixel[1] > pixel[2])
        self.assertGreater(highest, 1000.0)
        zenith, nadir = rows[0][0], rows[-1][0]
        self.assertGreater(zenith[2], 2.0 * zenith[0])  # blue
        self.assertTrue(nadir[0] > nadir[2])            # brown


class ExrFile(unittest.TestCase):
    def test_round_trip_keeps_halves(self):
        rows = [[(0.5 * x, 1.0 + y, 2.0 ** -10 * (x ^ y)) for x in range(37)] for y in range(21)]
        self.assertEqual(exr.decode(exr.encode(37, 21, rows)), (37, 21, rows))

    def test_other_files_are_refused(self):
        with self.assertRaises(ValueError):
            exr.decode(b"P6 1 1 255\n\0\0\0" * 4)


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


class Rebuilding(WithBlender):
    """What is committed is what the committed scripts make."""

    def assertSame(self, found, expected, where, tolerance=1e-6):
        """Equal JSON, numbers within `tolerance`."""
        if isinstance(expected, dict):
            self.assertEqual(set(found), set(expected), where)
            for key, value in expected.items():
                self.assertSame(found[key], value, f"{where}.{key}", tolerance)
        elif isinstance(expected, list):
            self.assertEqual(len(found), len(expected), where)
            for i, value in enumerate(expected):
                self.assertSame(found[i], value, f"{where}[{i}]", tolerance)
        elif isinstance(expected, float):
            self.assertAlmostEqual(found, expected, delta=tolerance, msg=where)
        else:
            self.assertEqual(found, expected, where)

    def rebuild(self, name):
        out = self.folder / f"{name}.glb"
        made = run_blender("--python", SCENES / name / "build.py", "--", out)
        self.assertEqual(made.returncode, 0, made.stderr)
        found, found_blob = load(out)
        expected, expected_blob = committed(name)
        for part in ("nodes", "cameras", "materials", "scenes"):
            self.assertSame(found[part], expected[part], part)
        self.assertSame(lights(found), lights(expected), "lights")
        self.assertEqual([mesh["name"] for mesh in found["meshes"]],
                         [mesh["name"] for mesh in expected["meshes"]])
        for mesh, known in zip(found["meshes"], expected["meshes"]):
            self.assertEqual(len(mesh["primitives"]), len(known["primitives"]))
            for primitive, pattern in zip(mesh["primitives"], known["primitives"]):
                self.assertEqual(glb.accessor_values(found, found_blob, primitive["indices"]),
                                 glb.accessor_values(expected, expected_blob, pattern["indices"]))
                self.assertEqual(set(primitive["attributes"]), set(pattern["attributes"]))
                for attribute, index in pattern["attributes"].items():
                    a = glb.accessor_values(found, found_blob, primitive["attributes"][attribute])
                    b = glb.accessor_values(expected, expected_blob, index)
                    self.assertEqual(len(a), len(b))
                    self.assertLessEqual(max(abs(x - y) for x, y in zip(a, b)), 1e-6,
                                         f"{mesh['name']} {attribute}")
        return out

    def test_three_boxes(self):
        self.rebuild("three_boxes")

    def test_gallery(self):
        first = self.rebuild("gallery").read_bytes()
        again = self.rebuild("gallery").read_bytes()
        self.assertTrue(first == again, "two exports of one scene differ")

    def test_probes(self):
        made = run_blender("--python", SCENES / "probes" / "build.py", "--", self.folder)
        self.assertEqual(made.returncode, 0, made.stderr)
        for name in ("cathedral", "sky_sun"):
            _, _, found = exr.decode((self.folder / f"{name}.exr").read_bytes())
            _, _, expected = exr.decode((SCENES / "probes" / f"{name}.exr").read_bytes())
            worst = max(abs(a - b) / max(b, 1e-3) for row, known in zip(found, expected)
                        for pixel, pattern in zip(row, known) for a, b in zip(pixel, pattern))
            self.assertLess(worst, 1e-3, name)  # a half's last bit is 2^-11 of it


class Exporting(WithBlender):
    """export_cases.py exports a small scene for each of these, in one run of Blender."""

    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.out = cls.folder / "cases"
        cls.out.mkdir()
        made = run_blender("--python", HERE / "export_cases.py", "--", cls.out)
        if made.returncode != 0:
            raise AssertionError(f"export_cases.py failed:\n{made.stdout}\n{made.stderr}")
        cls.results = json.loads((cls.out / "results.json").read_text())

    def exported(self, case):
        self.assertIsNone(self.results[case]["refused"])
        document, blob = load(self.out / f"{case}.glb")
        return document, blob, document["scenes"][0]["extras"]["occlab"]

    def test_modifiers_are_the_renderer_s_and_equal_meshes_are_shared(self):
        document, _, extras = self.exported("modifiers_and_instances")
        meshes = {node["name"]: node["mesh"] for node in document["nodes"] if "mesh" in node}
        self.assertEqual(set(meshes), {"subdivided", "subdivided too", "plain", "plain too",
                                       "veiled"})
        self.assertEqual(meshes["subdivided"], meshes["subdivided too"])
        self.assertEqual(meshes["plain"], meshes["plain too"])
        self.assertEqual(meshes["plain"], meshes["veiled"])
        self.assertEqual(len(document["meshes"]), 2)
        self.assertEqual(glb.mesh_triangles(document, meshes["subdivided"]), 6 * 4**2 * 2)
        self.assertEqual(glb.triangle_count(document), 2 * 6 * 4**2 * 2 + 3 * 12)
        self.assertEqual(extras["warnings"], [])

    def test_collection_instances_share_their_mesh_and_materials_are_converted(self):
        document, _, _ = self.exported("collection_instances")
        self.assertEqual(len(document["meshes"]), 1)
        self.assertEqual(glb.triangle_count(document), 3 * 2 * 12)
        self.assertEqual([m["name"] for m in document["materials"]], ["red"])
        colour = document["materials"][0]["pbrMetallicRoughness"]["baseColorFactor"]
        for found, expected in zip(colour, (0.7, 0.2, 0.1, 1.0)):
            self.assertAlmostEqual(found, expected, places=6)

    def test_every_camera_is_a_view_named_as_its_object(self):
        document, _, extras = self.exported("cameras")
        self.assertEqual([camera["name"] for camera in document["cameras"]], ["front", "side"])
        self.assertEqual(extras["resolution"], [500, 400])
        for camera in document["cameras"]:
            lens = camera["perspective"]
            self.assertAlmostEqual(lens["aspectRatio"], 1.25, places=6)
            self.assertAlmostEqual(2.0 * math.atan(1.25 * math.tan(lens["yfov"] / 2.0)),
                                   math.radians(40.0), places=5)
        for found, expected in zip(points_along(placed(document, "side")), (-1.0, 0.0, 0.0)):
            self.assertAlmostEqual(found, expected, places=6)

    def test_lights_are_in_physical_units(self):
        document, _, extras = self.exported("lights")
        found = {light["name"]: light for light in lights(document)}
        self.assertEqual(set(found), {"lamp", "torch", "noon"})
        self.assertAlmostEqual(found["lamp"]["intensity"], 10.0, places=4)   # 40 pi W / 4 pi sr
        self.assertAlmostEqual(found["torch"]["intensity"], 2.0, places=4)
        self.assertAlmostEqual(found["torch"]["spot"]["outerConeAngle"], math.radians(30), places=5)
        self.assertAlmostEqual(found["noon"]["intensity"], 6.0, places=4)    # 3 W/m^2 times 2
        for a, b in zip(found["noon"]["color"], (0.5, 1.0, 0.5)):
            self.assertAlmostEqual(a, b, places=6)
        self.assertEqual(extras["lights"],
                         {"lamp": {"radius": 0.25}, "noon": {"angle_degrees": 2.0}})
        for name in ("lamp", "torch", "noon"):
            self.assertEqual(sum(f"'{name}'" in warning for warning in extras["warnings"]), 1)

    def test_materials_keep_their_colour(self):
        document, _, extras = self.exported("materials")
        found = {m["name"]: m["pbrMetallicRoughness"] for m in document["materials"]}
        for name, colour in (("grey", [0.3] * 3), ("metal", [0.1, 0.2, 0.3]),
                             ("flat", [0.4, 0.5, 0.6]), ("default", [0.8] * 3)):
            for a, b in zip(found[name]["baseColorFactor"], colour):
                self.assertAlmostEqual(a, b, places=6)
            if name != "metal":
                self.assertEqual(found[name]["metallicFactor"], 0, name)
        self.assertEqual(len(extras["warnings"]), 1)
        self.assertIn("'metal': Metallic", extras["warnings"][0])

    def test_a_diffuse_texture_survives(self):
        document, blob, _ = self.exported("textured_diffuse")
        surface = document["materials"][0]["pbrMetallicRoughness"]
        texture = document["textures"][surface["baseColorTexture"]["index"]]
        view = document["bufferViews"][document["images"][texture["source"]]["bufferView"]]
        start = view["byteOffset"]
        self.assertEqual(blob[start:start + 8], b"\x89PNG\r\n\x1a\n")
        self.assertEqual(surface["metallicFactor"], 0)
        self.assertIn("TEXCOORD_0", document["meshes"][0]["primitives"][0]["attributes"])

    def test_the_world_s_rotation_is_the_one_that_cycles_renders(self):
        for case, rotation in (("world_point", -40.0), ("world_texture", 25.0)):
            with self.subTest(case=case):
                _, _, extras = self.exported(case)
                self.assertEqual(extras["world"], {"probe": "probes/column.exr", "strength": 2.5,
                                                   "rotation_degrees": rotation})
                there, left, right, mirrored = self.results[case]["returned"]
                for found, texel in zip(there, (8.0, 4.0, 2.0)):
                    self.assertAlmostEqual(found, 2.5 * texel, delta=0.01 * 2.5 * texel)
                for pixel in (left, right, mirrored):
                    self.assertLess(max(pixel), 0.3)

    def test_known_probes_go_by_name(self):
        for case, name in (("world_studio", "courtyard"), ("world_ours", "sky_sun")):
            _, _, extras = self.exported(case)
            self.assertEqual(extras["world"],
                             {"probe": name, "rotation_degrees": 0.0, "strength": 1.0})
            self.assertEqual(extras["warnings"], [])

    def test_a_probe_outside_the_folder_is_warned_of(self):
        _, _, extras = self.exported("world_outside")
        self.assertEqual(extras["world"]["probe"], "../elsewhere/column.exr")
        self.assertTrue((self.out / extras["world"]["probe"]).is_file())
        self.assertEqual(len(extras["warnings"]), 1)

    def test_a_constant_world(self):
        _, _, extras = self.exported("world_constant")
        self.assertEqual(extras["world"], {"radiance": [0.5, 1.0, 2.0]})

    def test_a_shear_that_nodes_can_say_is_kept(self):
        document, blob, _ = self.exported("sheared_by_hierarchy")
        low, high = bounds(document, blob)
        self.assertAlmostEqual(high[0] - low[0], 3.0 * 2.0 * math.sqrt(2.0), places=5)
        self.assertAlmostEqual(high[2] - low[2], 2.0 * math.sqrt(2.0), places=5)

    def test_what_would_be_wrong_is_refused_and_nothing_is_written(self):
        expected = {
            "no_camera": "no camera", "no_mesh": "no mesh", "lens_shift": "camera 'main': lens",
            "orthographic": "type ORTHO", "area_light": "light 'window': type AREA",
            "mixed_material": "material 'mixed': its surface is a Mix Shader",
            "bright_albedo": "material 'bright': colour [1.5, 1.5, 1.5]",
            "sky_texture": "Sky Texture", "tilted_world": "turn about Z",
            "missing_probe": "gone.exr is missing", "packed_probe": "packed",
            "metaball": "object 'drop': type META", "node_instances": "object 'scattered'",
            "sheared": "not the rendered one"}
        refused = {case[len("refused_"):] for case in self.results if case.startswith("refused_")}
        self.assertEqual(refused, set(expected))
        for case, words in expected.items():
            with self.subTest(case=case):
                self.assertIn(words, str(self.results[f"refused_{case}"]["refused"]))
                self.assertFalse((self.out / f"refused_{case}.glb").exists())

    def test_no_temporary_file_is_left(self):
        self.assertEqual([path.name for path in self.out.iterdir() if path.name.startswith(".")],
                         [])

    def test_command_line(self):
        """As `occlab export` calls it."""
        script = ("--python", SCENES / "export.py", "--")
        out = self.folder / "good.glb"
        made = run_blender(self.out / "good.blend", *script, out)
        self.assertEqual(made.returncode, 0, made.stderr)
        self.assertEqual(glb.triangle_count(load(out)[0]), 12)

        shifted = run_blender(self.out / "shifted.blend", *script, self.folder / "shifted.glb")
        self.assertEqual(shifted.returncode, 2, shifted.stderr)
        self.assertIn("error: camera 'shifted': lens shift (0, 0.2)", shifted.stderr)
        self.assertFalse((self.folder / "shifted.glb").exists())

        missing = run_blender(self.folder / "none.blend", *script, self.folder / "none.glb")
        self.assertEqual(missing.returncode, 1)
        self.assertIn("none.blend", missing.stdout + missing.stderr)
        self.assertFalse((self.folder / "none.glb").exists())

    def test_an_output_that_cannot_be_written(self):
        for out in (self.folder / "no" / "folder.glb", self.folder / "scene.gltf"):
            made = run_blender("--python", SCENES / "export.py", "--", out)
            self.assertEqual(made.returncode, 2)
            self.assertIn(f"error: {out}: the output is a .glb file in a folder", made.stderr)


if __name__ == "__main__":
    unittest.main(verbosity=2)
