"""Every verb as a user types it: what it prints, what it writes, how it ends."""

import json
import re

from support import (METHODS, ROOT, CliTest, exr_pixels, interleave, occlab, read_csv, rendered,
                     smoke_results)


class Help(CliTest):
    def test_the_program_names_its_verbs_and_exit_codes(self):
        text = self.good("--help").stdout
        for verb in ("run", "render", "compare", "table", "verify", "list", "export"):
            self.assertRegex(text, rf"(?m)^  {verb} ")
        for meaning in ("0 good", "1 a check failed", "2 bad usage or bad input", "3 the device"):
            self.assertIn(meaning, text)

    def test_every_verb_has_help(self):
        for verb in ("run", "render", "compare", "table", "verify", "list", "export"):
            with self.subTest(verb):
                self.assertIn(f"occlab {verb} [OPTIONS]", self.good(verb, "--help").stdout)

    def test_version_is_that_of_the_build_file(self):
        version = re.search(r"project\(occlab VERSION (\S+)",
                            (ROOT / "CMakeLists.txt").read_text(encoding="utf-8")).group(1)
        self.assertEqual(self.good("--version").stdout, f"occlab {version}\n")


class List(CliTest):
    EXPECTED = {
        "methods": METHODS,
        "scenes": ("gallery", "three_boxes"),
        "probes": ("cathedral", "sky_sun"),
        "devices": ("surfaceless",),
        "metrics": ("rmse", "relmse", "smape", "psnr", "ssim", "ciede2000", "rgb_angle_shadow",
                    "high_frequency_residual_2"),
    }

    def test_plain_and_json_hold_the_same_names(self):
        for what, expected in self.EXPECTED.items():
            with self.subTest(what):
                entries = json.loads(self.good("list", what, "--json").stdout)
                names = [entry["name"] for entry in entries]
                self.assertEqual(len(set(names)), len(names))
                self.assertLessEqual(set(expected), set(names))
                plain = self.good("list", what).stdout
                self.assertEqual(re.findall(r"(?m)^(\S+)$", plain), names)

    def test_methods_tell_their_parameters(self):
        for method in json.loads(self.good("list", "methods", "--json").stdout):
            self.assertTrue(method["title"] and method["paper"])
            for parameter in method["parameters"]:
                self.assertTrue(parameter["help"] and parameter["accepted"], parameter)

    def test_what_to_list_is_needed(self):
        self.refused(2, ["what", "required"], "list")
        self.refused(2, ["metods", "methods"], "list", "metods")


class Render(CliTest):
    def test_each_method_writes_its_layers(self):
        layers = {method["name"]: method["layers"]
                  for method in json.loads(self.good("list", "methods", "--json").stdout)}
        for method in METHODS:
            with self.subTest(method):
                channels, window, pixels = exr_pixels(rendered(method))
                names = {name.split(b".")[0].decode()
                         for name in re.findall(rb"([a-z_0-9]+\.\w+)\0", channels)}
                self.assertLessEqual({*layers[method], "radiance", "mask"}, names)
                self.assertEqual(window, b"\0" * 8 + (95).to_bytes(4, "little")
                                 + (53).to_bytes(4, "little"))
                self.assertGreater(len(pixels), 1000)

    def test_metadata_says_how_it_was_made(self):
        data = rendered("ssao").read_bytes()
        for fact in (b"occlab:method", b"occlab:parameters", b"samples=", b"three_boxes.glb",
                     b"sky_sun", b"occlab:device"):
            self.assertIn(fact, data)

    def test_the_same_command_gives_the_same_pixels(self):
        again = self.folder / "again.exr"
        self.good("render", "--scene", "three_boxes", "--probe", "sky_sun", "--resolution", "96",
                  "54", "--method", "s3ho", "-o", again)
        self.assertEqual(exr_pixels(again), exr_pixels(rendered("s3ho")))

    def test_settings_reach_the_method(self):
        values = {}
        for setting in ("samples=4", "samples=8"):
            path = self.folder / "set.exr"
            self.good("render", "--scene", "three_boxes", "--probe", "sky_sun", "--resolution",
                      "96", "54", "--method", "ssdo", *interleave("--set", [setting, "steps=3"]),
                      "-o", path)
            values[setting] = exr_pixels(path)
            header = path.read_bytes()
            self.assertTrue(setting.encode() in header and b" steps=3 " in header, setting)
        self.assertNotEqual(values["samples=4"], values["samples=8"])


class Compare(CliTest):
    def metrics(self, *arguments):
        entries = json.loads(self.good("compare", *arguments, "--json").stdout)
        return {entry["metric"]: entry for entry in entries}

    def test_an_image_equals_itself(self):
        image = rendered("ssao")
        found = self.metrics(image, image)
        self.assertEqual(found["psnr"]["value"], "inf")
        self.assertEqual(found["rmse"]["value"], 0.0)
        self.assertEqual(found["ssim"]["value"], 1.0)
        self.assertEqual(found["rmse"]["pixels"], 96 * 54)
        plain = self.good("compare", image, image).stdout
        self.assertRegex(plain, r"(?m)^psnr +inf dB$")
        self.assertRegex(plain, r"(?m)^rmse +0 mean luminance$")

    def test_methods_differ_from_the_reference(self):
        for method in METHODS[1:]:
            found = self.metrics(rendered("rtdo"), rendered(method))
            self.assertGreater(found["rmse"]["value"], 0.01, method)
            self.assertLess(found["psnr"]["value"], 60.0, method)

    def test_every_listed_metric_is_there(self):
        listed = {entry["name"]
                  for entry in json.loads(self.good("list", "metrics", "--json").stdout)}
        self.assertEqual(set(self.metrics(rendered("rtdo"), rendered("ssao"))), listed)

    def test_another_layer(self):
        found = self.metrics(rendered("ssao"), rendered("ssao"), "--layer", "radiance_unfiltered",
                              "--reference-layer", "radiance_unfiltered")
        self.assertEqual(found["rmse"]["value"], 0.0)

    def test_sizes_must_be_equal(self):
        small = self.folder / "small.exr"
        self.good("render", "--scene", "three_boxes", "--resolution", "32", "18", "--method",
                  "ssao", "-o", small)
        self.refused(2, [small, rendered("ssao"), "32", "96"], "compare", rendered("ssao"), small)

    def test_an_unknown_layer_lists_those_there_are(self):
        self.refused(2, [rendered("ssao"), "'foo'", "ambient_occlusion"], "compare",
                     rendered("ssao"), rendered("ssao"), "--layer", "foo")


class Table(CliTest):
    def test_each_format(self):
        tables = {fmt: self.good("table", smoke_results(), "--format", fmt).stdout
                  for fmt in ("md", "csv", "json", "latex")}
        titles = [table["title"] for table in json.loads(tables["json"])]
        self.assertGreaterEqual(len(titles), 5)
        self.assertEqual(len(set(titles)), len(titles))
        self.assertEqual(re.findall(r"(?m)^## (.*)$", tables["md"]), titles)
        self.assertEqual(tables["latex"].count("\\begin{tabular}"), len(titles))
        self.assertIn("method,samples", tables["csv"])

    def test_markdown_is_what_run_printed(self):
        printed = occlab("run", ROOT / "configs/smoke.toml", "--out", smoke_results()).stdout
        self.assertEqual(self.good("table", smoke_results()).stdout, printed)

    def test_numbers_are_those_of_the_measurements(self):
        table = next(table for table in
                     json.loads(self.good("table", smoke_results(), "--format", "json").stdout)
                     if table["title"] == "Noise and bias, filtered")
        names = [column["name"] for column in table["columns"]]
        stored = {(row["method"], row["parameter.samples"]): float(row["value"])
                  for row in read_csv(smoke_results() / "measurements.csv")
                  if row["metric"] == "noise" and row["stage"] == "filtered"
                  and row["view"] == "main"}
        shown = {(row[names.index("method")], row[names.index("samples")]):
                 row[names.index("noise")]["value"] for row in table["rows"]}
        self.assertEqual(shown, stored)
        self.assertEqual(len(shown), 8)

    def test_a_folder_without_results(self):
        self.refused(2, [self.folder / "measurements.csv"], "table", self.folder)
        self.refused(2, ["--format", "xml", "latex"], "table", smoke_results(), "--format", "xml")
