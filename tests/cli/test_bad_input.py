"""Bad input: exit code 2, one line with file, key and what is accepted, nothing written."""

import json
import math
import struct

from support import (ROOT, SMALL_EXPERIMENT, THREE_BOXES, CliTest, exr, interleave, probe_with,
                     rendered, scene_with)


class Usage(CliTest):
    def test_verbs(self):
        self.refused(2, ["subcommand", "--help"])
        self.refused(2, ["'rnder'", "did you mean 'render'", "compare"], "rnder")

    def test_options(self):
        self.refused(2, ["--method", "required"], "render", "--scene", "three_boxes", "-o",
                     self.folder / "out.exr")
        self.refused_render(2, ["--colour"], "--method", "ssao", "--colour", "red")
        self.refused(2, ["-o", "out.png", ".exr"], "render", "--scene", "three_boxes", "--method",
                     "ssao", "-o", self.folder / "out.png")

    def test_resolution(self):
        for values in (("0", "16"), ("-3", "16"), ("16", "20000"), ("16", "wide"), ("16",),
                       ("1.5", "2")):
            with self.subTest(values):
                self.refused(2, ["--resolution"], "render", "--scene", "three_boxes", "--method",
                             "ssao", "-o", self.folder / "out.exr", "--resolution", *values)


class Names(CliTest):
    def test_method(self):
        self.refused_render(2, ["'s3hoo'", "did you mean 's3ho'", "rtdo, ssao, s3ho, ssdo, ssbn"],
                            "--method", "s3hoo")

    def test_view(self):
        self.refused_render(2, [THREE_BOXES.name, "'mian'", "main"], "--method", "ssao", "--view",
                            "mian")

    def test_scene(self):
        self.refused(2, ["'three_box'", "three_boxes", "gallery"], "render", "--scene", "three_box",
                     "--method", "ssao", "-o", self.folder / "out.exr")

    def test_probe(self):
        self.refused_render(2, ["'sky_sum'", "sky_sun", "cathedral"], "--method", "ssao", "--probe",
                            "sky_sum")

    def test_device(self):
        for device in ("999", "gpu", "-1", "0x"):
            self.refused_render(2, [f"--device {device}", "surfaceless"], "--method", "ssao",
                                "--device", device)


class Parameters(CliTest):
    def test_each_fault_names_the_setting_and_what_is_accepted(self):
        for setting, words in {
                "sampels=3": ["'sampels'", "did you mean 'samples'"],
                "samples=0": ["[1, 256]"],
                "samples=257": ["[1, 256]"],
                "samples=many": ["[1, 256]"],
                "samples=3.5": ["[1, 256]"],
                "samples=": ["[1, 256]"],
                "samples": ["NAME=VALUE"],
                "d_max_world=nan": ["d_max_world"],
                "d_max_world=-1": ["d_max_world"],
                "filter=gauss": ["bilateral"],
        }.items():
            with self.subTest(setting):
                self.refused_render(2, [f"--set {setting}", *words], "--method", "ssao",
                                    *interleave("--set", [setting]))

    def test_probe_settings(self):
        for option, value, key in (("--prefilter", "-1", "prefilter_degrees"),
                                   ("--prefilter", "nan", "prefilter_degrees"),
                                   ("--prefilter", "200", "prefilter_degrees"),
                                   ("--exposure", "inf", "exposure_stops"),
                                   ("--rotation", "1e9", "rotation_degrees")):
            with self.subTest(option=option, value=value):
                self.refused_render(2, ["sky_sun", key, "accepted"], "--method", "ssao", "--probe",
                                    "sky_sun", f"{option}={value}")
        self.refused_render(2, ["--prefilter", "wide"], "--method", "ssao", "--probe", "sky_sun",
                            "--prefilter", "wide")


class Scenes(CliTest):
    def refused_scene(self, path, *words):
        """By both verbs that load scenes."""
        self.refused(2, [path.name, *words], "render", "--scene", path, "--method", "ssao",
                     "--resolution", "16", "16", "-o", self.folder / "out.exr")
        experiment = self.write("scene.toml", SMALL_EXPERIMENT)
        self.refused_run(2, [path.name, *words], experiment, "--set", f"scene.source={path}")

    def test_missing(self):
        self.refused_scene(self.folder / "none.glb", "no such file")

    def test_corrupt(self):
        whole = THREE_BOXES.read_bytes()
        for name, data in {"text": b"not a scene at all", "empty": b"",
                           "cut": whole[:len(whole) // 2], "header": whole[:12]}.items():
            with self.subTest(name):
                path = self.folder / f"{name}.glb"
                path.write_bytes(data)
                self.refused_scene(path)

    def test_no_camera(self):
        def change(document, _):
            del document["cameras"]
            for node in document["nodes"]:
                node.pop("camera", None)
        self.refused_scene(scene_with(self.folder / "blind.glb", change), "camera")

    def test_no_triangles(self):
        def change(document, _):
            for key in ("meshes", "accessors", "bufferViews"):
                document.pop(key)
            for node in document["nodes"]:
                node.pop("mesh", None)
        self.refused_scene(scene_with(self.folder / "void.glb", change), "triangle")

    def test_vertices_that_are_not_numbers(self):
        for name, value in (("nan", math.nan), ("inf", math.inf)):
            def change(document, blob, value=value):
                position = document["meshes"][0]["primitives"][0]["attributes"]["POSITION"]
                accessor = document["accessors"][position]
                view = document["bufferViews"][accessor["bufferView"]]
                at = view.get("byteOffset", 0) + accessor.get("byteOffset", 0) + 4
                struct.pack_into("<f", blob, at, value)
            with self.subTest(name):
                self.refused_scene(scene_with(self.folder / f"{name}.glb", change), "POSITION")

    def test_nothing_lights_it(self):
        def change(document, _):
            document["extensions"]["KHR_lights_punctual"]["lights"].clear()
            del document["extensions"]
            for node in document["nodes"]:
                node.get("extensions", {}).pop("KHR_lights_punctual", None)
            for key in ("extensionsUsed", "extensionsRequired"):
                document.pop(key, None)
        path = scene_with(self.folder / "dark.glb", change)
        self.refused(2, [path, "light", "probe"], "render", "--scene", path, "--method", "ssao",
                     "-o", self.folder / "out.exr")

    def run_warnings(self, path, *settings):
        experiment = self.write("warned.toml", SMALL_EXPERIMENT)
        out = self.folder / "-".join(["out", path.stem, *settings]).replace("/", "_")
        done = self.good("run", experiment, "--out", out, "--set", f"scene.source={path}",
                         *interleave("--set", settings))
        warnings = json.loads((out / "run.json").read_text())["warnings"]
        for warning in warnings:
            self.assertIn(warning, done.stderr)
        return warnings

    def test_a_light_inside_of_geometry_is_named(self):
        def lamp_at(height):
            def change(document, _):
                lights = document["extensions"]["KHR_lights_punctual"]["lights"]
                lights.append({"name": "lamp", "type": "point", "intensity": 3})
                document["nodes"].append({
                    "name": "lamp", "translation": [-1.06, height, 0.1],
                    "extensions": {"KHR_lights_punctual": {"light": len(lights) - 1}}})
                document["scenes"][0]["nodes"].append(len(document["nodes"]) - 1)
            return change
        inside = self.run_warnings(scene_with(self.folder / "inside.glb", lamp_at(0.3)))
        self.assertEqual(len(inside), 1)
        for words in ("'lamp'", "'left box'", "'main'"):
            self.assertIn(words, inside[0])
        above = scene_with(self.folder / "above.glb", lamp_at(0.9))
        self.assertEqual(self.run_warnings(above), [])

    def test_darkness_is_named(self):
        black = self.folder / "black.exr"
        black.write_bytes(exr.encode(16, 8, [[(0.0, 0.0, 0.0)] * 16 for _ in range(8)]))
        warnings = self.run_warnings(THREE_BOXES, f"probe.source={black}")
        self.assertEqual(len(warnings), 1)
        self.assertIn("black.exr: the probe is black", warnings[0])
        self.assertEqual(self.run_warnings(THREE_BOXES), [])


class Probes(CliTest):
    def refused_probe(self, path, *words):
        self.refused_render(2, [path.name, *words], "--method", "ssao", "--probe", path)
        experiment = self.write("probe.toml", SMALL_EXPERIMENT)
        self.refused_run(2, [path.name, *words], experiment, "--set", f"probe.source={path}")

    def test_a_good_one_made_the_same_way_is_taken(self):
        self.good("render", "--scene", "three_boxes", "--method", "ssao", "--resolution", "16",
                  "16", "--probe", probe_with(self.folder / "good.exr", 2.0), "-o",
                  self.folder / "out.exr")

    def test_texels_that_are_not_numbers(self):
        self.refused_probe(probe_with(self.folder / "nan.exr", math.nan), "(nan, 0.5, 0.5)")
        self.refused_probe(probe_with(self.folder / "inf.exr", math.inf), "(inf, 0.5, 0.5)")
        self.refused_probe(probe_with(self.folder / "negative.exr", -3.0), "-3")

    def test_size(self):
        self.refused_probe(probe_with(self.folder / "zero.exr", 0.5, (0, 0)))
        self.refused_probe(probe_with(self.folder / "square.exr", 0.5, (16, 16)), "twice as wide")

    def test_missing_or_corrupt(self):
        self.refused_probe(self.folder / "none.exr", "no such file")
        cut = self.folder / "cut.exr"
        cut.write_bytes((ROOT / "scenes/probes/sky_sun.exr").read_bytes()[:9000])
        self.refused_probe(cut)
        self.refused_probe(self.write("text.hdr", "#?not RADIANCE\n"))
        self.refused_probe(self.write("picture.png", "x"), ".exr", ".hdr")


class Images(CliTest):
    def test_compare_reads_whole_images_only(self):
        cut = self.folder / "cut.exr"
        cut.write_bytes(rendered("ssao").read_bytes()[:20000])
        self.refused(2, [cut], "compare", rendered("ssao"), cut)
        self.refused(2, [self.folder / "none.exr"], "compare", self.folder / "none.exr",
                     rendered("ssao"))
        text = self.write("text.exr", "no image")
        self.refused(2, [text], "compare", text, text)


class Experiments(CliTest):
    def test_file(self):
        self.refused_run(2, ["none.toml"], self.folder / "none.toml")
        self.refused_run(2, ["broken.toml:2"], self.write("broken.toml", "format = 1\n[[[x\n"))
        self.refused_run(2, ["empty.toml", "format"], self.write("empty.toml", ""))
        self.refused_run(2, [self.folder], self.folder)

    def test_keys(self):
        experiment = self.write("small.toml", SMALL_EXPERIMENT)
        for setting, words in {
                "run[0].samplse=3": ["run[0].samplse", "did you mean 'samples'"],
                "run[0].samples=300": ["run[0].samples", "[1, 256]"],
                "run[0].samples='x'": ["run[0].samples"],
                "run[0].methods=['ssoa']": ["run[0].methods", "did you mean 'ssao'"],
                "run[0].seeds=0": ["run[0].seeds", "[1, 4096]"],
                "run[7].seeds=2": ["run[7]"],
                "scene.view=mian": ["mian", "main"],
                "scene.source=three_box": ["three_box", "three_boxes"],
                "scene.resolution=[48]": ["scene.resolution"],
                "scene.resolution=[8, 8]": ["scene.resolution", "16"],
                "probe.source=sky_sum": ["sky_sum", "sky_sun"],
                "probe.prefilter_degrees=nan": ["probe.prefilter_degrees"],
                "reference.method=truth": ["reference.method", "rtdo"],
                "figure[0].kind=pie": ["figure[0].kind", "error_map"],
                "figure[0].kind=failure_classes": ["figure[0]"],
                "budget.tolerance=0": ["budget.tolerance", "1e-05"],
                "budget.tolerence=0.1": ["budget.tolerence", "did you mean 'tolerance'"],
                "budget.budget_seconds=-1": ["budget.budget_seconds"],
                "reference.max_rays_per_pixel=1": ["reference.max_rays_per_pixel"],
                "figure[0].samples=64": ["figure[0]"],
                "experiment.name=''": ["experiment.name"],
                "experiment.name='A/B'": ["experiment.name"],
                "format=2": ["format"],
                "nothing": ["KEY=VALUE"],
        }.items():
            with self.subTest(setting):
                self.refused_run(2, words, experiment, *interleave("--set", [setting]))

    def test_the_file_names_the_line(self):
        text = SMALL_EXPERIMENT.replace("samples = 4\nseeds", "sampels = 4\nseeds", 1)
        line = 1 + text.splitlines().index("sampels = 4")
        self.refused_run(2, [f"bad.toml:{line}", "sampels", "did you mean 'samples'"],
                         self.write("bad.toml", text))

    def test_device(self):
        self.refused_run(2, ["--device 99"], self.write("small.toml", SMALL_EXPERIMENT), "--device",
                         "99")
