"""The exporter: small scenes made by export_cases.py, what becomes of them and what is refused.

    python3 tests/scenes/test_export.py

Needs Blender (scene_files.py).
"""

import json
import math
import unittest

from scene_files import (HERE, SCENES, WithBlender, bounds, lights, load, placed, points_along,
                         run_blender)
import glb  # found by scene_files


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

    def test_alpha_clip_becomes_a_mask(self):
        document, _, extras = self.exported("masked")
        found = {material["name"]: material for material in document["materials"]}
        self.assertEqual(found["leaf"]["alphaMode"], "MASK")
        self.assertEqual(found["leaf"]["alphaCutoff"], 0.25)
        self.assertIn("baseColorTexture", found["leaf"]["pbrMetallicRoughness"])
        self.assertEqual([w for w in extras["warnings"] if "'leaf'" in w or "exporter" in w], [])
        self.assertTrue(any("'glass': Alpha is ignored" in w for w in extras["warnings"]), extras)

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
            "alpha_of_another_image": "takes the Alpha of the Image Texture that is its Base Color",
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
