"""Figures of single points: lights switched, ambient occlusion apart, their numbers and bad input."""

import json

from support import CliTest, occlab, scene_with, varied_rows

HEAD = """\
format = 1
[experiment]
name = "points"
title = "Points"
[scene]
source = "three_boxes"
resolution = [160, 90]
[parameters]
samples = 16
[reference]
method = "rtdo"
rays_per_pixel = 4
[[run]]
methods = ["s3ho", "ssao", "ssdo"]
"""
LOBES = """\
[[figure]]
name = "lobes"
kind = "lobes"
caption = "What to see."
methods = ["s3ho"]
points = [{label = "p1", pixel = [0.3, 0.6]}, {label = "p2", pixel = [110, 60]}]
switch = ["pink", "turquoise"]
"""
OCCLUSION = """\
[[figure]]
name = "occlusion"
kind = "ambient_occlusion"
methods = ["ssao"]
"""
# scenes/three_boxes/build.py: irradiance of the two suns.
PINK = [2.4 * c for c in (1.0, 0.22, 0.55)]
TURQUOISE = [2.4 * c for c in (0.12, 0.90, 0.80)]


class PointFigures(CliTest):
    def test_switched_lights(self):
        path = self.write("points.toml", HEAD + LOBES + OCCLUSION)
        self.good("run", path, "--out", self.folder / "out")
        figures = self.folder / "out/figures"
        self.assertGreater(varied_rows(figures / "lobes.png"), 50)
        numbers = json.loads((figures / "lobes.json").read_text(encoding="utf-8"))
        self.assertLess(numbers["relighting_rms_in_mean_luminances"], 0.01)
        self.assertEqual([point["pixel"] for point in numbers["points"]], [[48, 54], [110, 60]])
        for point in numbers["points"]:
            # E is pink a + turquoise b, switched pink b + turquoise a: six numbers from two.
            lit, switched = point["irradiance"], point["irradiance_switched"]
            determinant = PINK[0] * TURQUOISE[1] - PINK[1] * TURQUOISE[0]
            a = (lit[0] * TURQUOISE[1] - lit[1] * TURQUOISE[0]) / determinant
            b = (PINK[0] * lit[1] - PINK[1] * lit[0]) / determinant
            for c in range(3):
                self.assertAlmostEqual(lit[c], PINK[c] * a + TURQUOISE[c] * b, delta=1e-3)
                self.assertAlmostEqual(switched[c], PINK[c] * b + TURQUOISE[c] * a, delta=1e-3)
            self.assertAlmostEqual(point["ambient_occlusion"],
                                   1.1283791671 * point["sh_visibility"][0], places=5)

    def test_occlusion_apart(self):
        path = self.write("points.toml", HEAD + OCCLUSION)
        self.good("run", path, "--out", self.folder / "out")
        figures = self.folder / "out/figures"
        self.assertGreater(varied_rows(figures / "occlusion.png"), 30)
        numbers = json.loads((figures / "occlusion.json").read_text(encoding="utf-8"))
        self.assertTrue(0.5 < numbers["mean_ambient_occlusion"] < 1.0)
        self.assertLessEqual(numbers["share_below_0.5"], numbers["share_below_0.9"])
        self.assertEqual(numbers["method"], "ssao")

    def test_bad_figures_are_refused(self):
        for old, new, words in (
                ('methods = ["s3ho"]', 'methods = ["ssao"]', ["figure[0].methods", "sh_visibility"]),
                ('methods = ["s3ho"]', 'methods = ["s3ho", "ssdo"]', ["one method"]),
                ("[0.3, 0.6]", "[1.3, 0.6]", ["points[0].pixel", "160x90"]),
                ("[110, 60]", "[160, 60]", ["points[1].pixel", "outside"]),
                ('label = "p1", ', "", ["points[0].label", "missing"]),
                ('switch = ["pink", "turquoise"]', 'switch = ["pink"]', ["figure[0].switch", "two"]),
                ('caption = "What to see."', 'stage = "unfiltered"', ["figure[0].stage"]),
                ('kind = "lobes"', 'kind = "lobe"', ["did you mean 'lobes'"]),
                ("switch =", "swich =", ["swich"])):
            with self.subTest(new):
                path = self.write("bad.toml", HEAD + LOBES.replace(old, new))
                self.refused_run(2, words, path)
        path = self.write("bad.toml", HEAD + OCCLUSION.replace("ssao", "ssdo"))
        self.refused_run(2, ["figure[0].methods", "'ssdo'", "scalar"], path)

    def fails(self, words, text):
        path = self.write("bad.toml", text)
        finished = occlab("run", path, "--out", self.folder / "out")
        self.assertEqual(finished.returncode, 2, finished.stderr)
        for word in words:
            self.assertIn(word, finished.stderr)

    def test_unknown_lights_are_named(self):
        self.fails(["figure 'lobes'", "did you mean 'turquoise'"],
                   HEAD + LOBES.replace('"turquoise"', '"turquose"'))

    def test_points_without_a_surface_are_named(self):
        def step_back(document, _):
            camera = next(node for node in document["nodes"] if "camera" in node)
            camera["translation"] = [12 * x for x in camera["translation"]]
            document["cameras"][camera["camera"]]["perspective"]["zfar"] = 1000.0

        scene_with(self.folder / "far.glb", step_back)
        self.fails(["point 'p1' shows no surface"],
                   HEAD.replace('"three_boxes"', '"./far.glb"')
                   + LOBES.replace("[0.3, 0.6]", "[0, 0]"))
