"""`occlab verify` as a user types it: what it measures, what fails, what it leaves behind."""

import csv
import io
import json
import re
import unittest

from support import ROOT, CliTest, exr_pixels, glb, occlab

WALL = ROOT / "scenes/analytic/wall.glb"
IMAGES = ("image.exr", "expected.exr", "error.exr", "p_value.exr")
# Large enough for a t-test, small enough to be quick.
POINT = {"name": "corner", "source": "k = 0.657481 [projected disc area]", "methods": ["rtdo"],
         "quantity": "ambient_occlusion",
         "set": ["rays_per_pixel=1024", "estimator=cosine", "d_max_world=1"],
         "point": {"position": [0.25, 0, 0], "normal": [0, 0, 1]}, "seeds": 16,
         "sky": {"constant": [1, 1, 1]}, "expected": [0.657481], "bound": 1e-6,
         "bound_source": "six digits"}
VIEW = {"name": "white", "source": "E/pi = k", "methods": ["ssao", "s3ho"], "quantity": "radiance",
        "set": ["samples=16"], "view": {"camera": "kappa 0.25", "resolution": [32, 14],
                                        "pixels": [4, 2, 8, 4]},
        "sky": {"constant": [1, 1, 1]}, "bound": 2e-3, "bound_source": "half floats",
        "equals": {"method": "ssao", "quantity": "ambient_occlusion", "set": ["samples=16"]}}


class VerifyTest(CliTest):
    def scene(self, *cases, name="own.glb", **extras):
        """The wall's scene with other cases."""
        document, blob = glb.parse(WALL.read_bytes())
        verify = document["scenes"][0]["extras"]["occlab_verify"]
        verify.update(cases=list(cases), **extras)
        path = self.folder / name
        path.write_bytes(glb.unparse(document, blob))
        return path

    def verify(self, *arguments):
        return occlab("verify", "--out", self.folder / "out", *arguments, timeout=600)


class Everything(VerifyTest):
    def test_what_comes_with_occlab_is_right(self):
        finished = self.verify("--format", "json")
        self.assertEqual(finished.returncode, 0, finished.stdout[-2000:] + finished.stderr)
        table = json.loads(finished.stdout)
        names = [column["name"] for column in table["columns"]]
        rows = [dict(zip(names, row)) for row in table["rows"]]
        self.assertEqual({row["verdict"] for row in rows}, {"passes"})
        counted = re.fullmatch(r"(\d+) checks, 0 failed, family false-alarm rate (\S+)\n",
                               finished.stderr)
        self.assertEqual(int(counted.group(1)), len(rows))
        self.assertLess(float(counted.group(2)), 1e-5)
        self.assertEqual({row["subject"] for row in rows},
                         {"reference", "passes", "representations", "metrics"})
        # Every method, and the corner that the papers' claim is about.
        methods = {row["quantity"].split()[0] for row in rows if row["subject"] == "passes"}
        self.assertEqual(methods, {"ssao", "s3ho", "ssdo", "ssbn", "s3hogi"})
        corner = [row for row in rows if row["case"] == "corner: floor, E = 1.761062, traced"]
        self.assertEqual({row["quantity"].split()[0] for row in corner}, {"s3ho", "ssdo"})
        for row in corner:
            self.assertLess(abs(row["measured"]["value"] * 3.14159265 - 1.761062), 1e-3)
        self.assertFalse((self.folder / "out").exists(), "nothing failed, nothing is written")


class OwnCases(VerifyTest):
    def test_a_good_case_passes(self):
        finished = self.verify("--cases", self.scene(POINT, VIEW))
        self.assertEqual(finished.returncode, 0, finished.stdout + finished.stderr)
        self.assertRegex(finished.stdout,
                         r"\| reference +\| own: corner +\| rtdo ambient_occlusion")
        self.assertRegex(finished.stdout, r"\| passes +\| own: white +\| s3ho radiance")
        self.assertRegex(finished.stdout, r"standard errors \(t, 15 d\.f\., Sidak over 1 tests at "
                                          r"1e-06\)")
        self.assertTrue(finished.stdout.endswith(
            "\n3 checks, 0 failed, family false-alarm rate 2e-06\n"))

    def test_a_wrong_value_fails_and_leaves_its_images(self):
        wrong = {**POINT, "name": "wrong value", "expected": [0.67]}
        finished = self.verify("--cases", self.scene(POINT, wrong))
        self.assertEqual(finished.returncode, 1, finished.stdout + finished.stderr)
        self.assertIn("2 checks, 1 failed", finished.stdout)
        verdicts = re.findall(r"(?m)^\| reference .*\| (\w+) +\|$", finished.stdout)
        self.assertEqual(verdicts, ["passes", "FAILS"])
        folder = self.folder / "out/own_wrong_value-rtdo"
        self.assertEqual({path.name for path in folder.iterdir()}, set(IMAGES))
        self.assertIn(str(folder), finished.stdout)
        pixels = {name: exr_pixels(folder / name) for name in IMAGES}
        self.assertEqual(len({content for _, _, content in pixels.values()}), 4)
        self.assertIn(b"occlab:source", (folder / "image.exr").read_bytes())

    def test_a_wrong_pass_fails(self):
        value = {key: VIEW[key] for key in VIEW if key != "equals"}
        for expectation in ({"expected": [2, 2, 2]},
                            {"equals": {**VIEW["equals"], "set": ["samples=16", "d_max_world=3"]}}):
            with self.subTest(next(iter(expectation))):
                finished = self.verify("--cases", self.scene({**value, **expectation}))
                self.assertEqual(finished.returncode, 1, finished.stdout + finished.stderr)
                self.assertIn("2 checks, 2 failed", finished.stdout)
                for method in VIEW["methods"]:
                    folder = self.folder / f"out/own_white-{method}"
                    self.assertEqual({path.name for path in folder.iterdir()}, set(IMAGES))

    def test_a_folder_of_cases(self):
        self.scene(POINT, name="one.glb")
        self.scene(POINT, name="two.glb")
        finished = self.verify("--cases", self.folder, "--only", "reference", "--format", "csv")
        self.assertEqual(finished.returncode, 0, finished.stderr)
        rows = list(csv.DictReader(io.StringIO(finished.stdout)))
        self.assertEqual([row["case"] for row in rows], ["one: corner", "two: corner"])
        self.assertLess(abs(float(rows[0]["measured"]) - 0.657481), float(rows[0]["bound"]))

    def test_one_subject(self):
        finished = self.verify("--only", "metrics")
        self.assertEqual(finished.returncode, 0, finished.stdout)
        self.assertEqual(set(re.findall(r"(?m)^\| (\w+) ", finished.stdout)),
                         {"subject", "metrics"})


class BadInput(VerifyTest):
    def refuses(self, words, *arguments):
        self.refused(2, words, "verify", "--out", self.folder / "out", *arguments)

    def test_keys_of_a_case(self):
        place = "scenes[0].extras.occlab_verify.cases[0]"
        without = {key: value for key, value in POINT.items() if key != "expected"}
        for change, words in (
                ({"expectd": [1]}, [place, "'expectd'", "did you mean 'expected'"]),
                ({"expected": ["NaN"]}, [place + ".expected[0]", "NaN", "a number"]),
                ({"expected": []}, [place + ".expected", "empty"]),
                ({"expected": [0.5, 0.5]}, [place + ".expected", "2 numbers", "1"]),
                ({"bound": -1}, [place + ".bound", "-1", "at least 0"]),
                ({"bound": 1, "bound_source": 3}, [place + ".bound_source", "3", "a text"]),
                ({"methods": ["ssaoo"]}, [place + ".methods[0]", "'ssaoo'", "ssao"]),
                ({"methods": []}, [place + ".methods", "empty"]),
                ({"methods": ["ssao"], "set": []}, [place + ".point", "ssao", "'view'"]),
                ({"quantity": "irradiance"}, [place + ".quantity", "'irradiance'", "radiance"]),
                ({"set": ["rays=4"]}, [place + ".set[0]", "rays", "rays_per_pixel"]),
                ({"set": ["d_max_world"]}, [place + ".set[0]", "NAME=VALUE"]),
                ({"seeds": 2}, [place + ".seeds", "2", "[4, 4096]"]),
                ({"view": VIEW["view"]}, [place, "'point'", "'view'"]),
                ({"same_under": "turn"}, [place, "exactly one"]),
                ({"point": {"position": [0, 0, 0], "normal": [0, 0, 2]}},
                 [place + ".point.normal", "2", "unit"]),
                ({"sky": {"constant": [1, 1]}}, [place + ".sky.constant", "3 numbers"]),
                ({"sky": {"linear": {"constant": [1, 1, 1], "x": [2, 0, 0]}}},
                 [place + ".sky.linear", "at least 0"]),
                ({"sky": {"sunny": 1}}, [place + ".sky", "'sunny'", "constant"])):
            with self.subTest(change):
                self.refuses([self.folder / "own.glb", *words], "--cases",
                             self.scene({**POINT, **change}))
        self.refuses([place, "exactly one"], "--cases", self.scene(without))

    def test_a_view(self):
        place = "scenes[0].extras.occlab_verify.cases[0].view"
        for change, words in (({"camera": "nobody"}, ["nobody", "kappa 0.25"]),
                              ({"pixels": [30, 0, 4, 1]}, [place + ".pixels[2]", "4", "[1, 2]"]),
                              ({"resolution": [64, 14], "pixels": [0, 0, 64, 14]},
                               [place + ".pixels", "no surface"])):
            with self.subTest(change):
                self.refuses(words, "--cases",
                             self.scene({**VIEW, "view": {**VIEW["view"], **change}}))

    def test_files(self):
        self.refuses(["format", "2", "accepted: 1"], "--cases", self.scene(POINT, format=2))
        self.refuses(["cases", "empty"], "--cases", self.scene())
        self.refuses([self.folder / "no.glb"], "--cases", self.folder / "no.glb")
        (self.folder / "empty").mkdir()
        self.refuses([self.folder / "empty", ".glb"], "--cases", self.folder / "empty")
        self.refuses(["occlab_verify"], "--cases", ROOT / "scenes/three_boxes/three_boxes.glb")
        self.refuses(["no case"], "--cases", self.scene(POINT), "--only", "passes")

    def test_usage(self):
        self.refuses(["--only", "metric"], "--only", "metric")
        self.refuses(["--format", "xml"], "--format", "xml")
        self.refused(2, ["--device", "999"], "verify", "--only", "passes", "--device", "999")


if __name__ == "__main__":
    unittest.main()
