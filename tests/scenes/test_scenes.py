"""The committed scenes and probes: what they hold, and that the committed scripts make them.

    python3 tests/scenes/test_scenes.py

Needs only Python, and Blender to make them again (scene_files.py).
"""

import collections
import math
import unittest

from scene_files import (SCENES, WithBlender, bounds, committed, lights, load, placed,
                         points_along, run_blender, vertices)
import exr  # found by scene_files
import glb  # found by scene_files

NAMES = ("three_boxes", "gallery")
LUMINANCE = (0.2126, 0.7152, 0.0722)


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

    def test_cathedral_ldr_is_the_same_clipped(self):
        rows, _, _ = self.probe("cathedral")
        clipped, highest, _ = self.probe("cathedral_ldr")
        self.assertEqual(clipped, [[tuple(min(channel, 1.0) for channel in pixel) for pixel in row]
                                   for row in rows])
        self.assertLessEqual(highest, 1.0)

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


    def test_dusk_is_smooth_and_warm_on_the_right(self):
        rows, highest, _ = self.probe("dusk")
        self.assertLess(highest, 3.0)
        steepest = max(abs(a - b) for row in rows for left, right in zip(row, row[1:] + row[:1])
                       for a, b in zip(left, right))
        self.assertLess(steepest, 0.1)
        at = [rows[56][int(256 * (0.5 + azimuth / 360.0))] for azimuth in (55.0, -125.0)]
        self.assertGreater(at[0][0], 1.2 * at[0][2])  # the glow
        self.assertGreater(at[1][2], 1.2 * at[1][0])  # the sky opposite


class ExrFile(unittest.TestCase):
    def test_round_trip_keeps_halves(self):
        rows = [[(0.5 * x, 1.0 + y, 2.0 ** -10 * (x ^ y)) for x in range(37)] for y in range(21)]
        self.assertEqual(exr.decode(exr.encode(37, 21, rows)), (37, 21, rows))

    def test_other_files_are_refused(self):
        with self.assertRaises(ValueError):
            exr.decode(b"P6 1 1 255\n\0\0\0" * 4)


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
        for image, known in zip(found.get("images", []), expected.get("images", []), strict=True):
            self.assertEqual(image["name"], known["name"])
            self.assertEqual(glb.view_bytes(found, found_blob, image["bufferView"]),
                             glb.view_bytes(expected, expected_blob, known["bufferView"]))
        return out

    def test_scenes_of_figures(self):
        for name in ("skyline", "atrium", "factory", "blocks", "columns", "toes", "still_life",
                     "coloured_boxes"):
            with self.subTest(scene=name):
                self.rebuild(name)

    def test_three_boxes(self):
        self.rebuild("three_boxes")
        self.rebuild("three_boxes_switched")

    def test_gallery(self):
        first = self.rebuild("gallery").read_bytes()
        again = self.rebuild("gallery").read_bytes()
        self.assertTrue(first == again, "two exports of one scene differ")

    def test_probes(self):
        made = run_blender("--python", SCENES / "probes" / "build.py", "--", self.folder)
        self.assertEqual(made.returncode, 0, made.stderr)
        for name in ("cathedral", "cathedral_ldr", "sky_sun", "dusk"):
            _, _, found = exr.decode((self.folder / f"{name}.exr").read_bytes())
            _, _, expected = exr.decode((SCENES / "probes" / f"{name}.exr").read_bytes())
            worst = max(abs(a - b) / max(b, 1e-3) for row, known in zip(found, expected)
                        for pixel, pattern in zip(row, known) for a, b in zip(pixel, pattern))
            self.assertLess(worst, 1e-3, name)  # a half's last bit is 2^-11 of it


if __name__ == "__main__":
    unittest.main(verbosity=2)
