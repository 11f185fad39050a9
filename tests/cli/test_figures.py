"""Figures of single points: lights switched, ambient occlusion apart, their numbers and bad input."""

import json
import math

from support import CliTest, decode_png, occlab, read_csv, scene_with, varied_rows

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


GRID = """\
format = 1
[experiment]
name = "grid"
title = "Grid"
[scene]
source = "three_boxes"
resolution = [160, 90]
[probe]
source = "sky_sun"
rotation_degrees = [0, 180]
[parameters]
samples = 4
[reference]
method = "rtdo"
rays_per_pixel = 4
[[run]]
methods = ["ssao", "ssdo"]
seeds = 2
[[region]]
label = "ground"
rectangle = [0.0, 0.8, 0.5, 0.2]
probe.rotation_degrees = 180
[[figure]]
name = "grid"
kind = "grid"
caption = "What to see."
columns = [{label = "as it is", probe.rotation_degrees = 0},
           {label = "turned", probe.rotation_degrees = 180}]
rows = [{label = "SSDO", method = "ssdo"},
        {label = "box", method = "ssdo", rectangle = [60, 20, 30, 30]},
        {label = "traced", method = "rtdo"}]
"""


class Grids(CliTest):
    def test_panels_of_several_probes(self):
        path = self.write("grid.toml", GRID)
        self.good("run", path, "--out", self.folder / "out")
        width, height, _, _ = decode_png(self.folder / "out/figures/grid.png")
        self.assertGreater(width, 2 * 160)
        self.assertGreater(height, 2 * 90 + 160)
        self.assertGreater(varied_rows(self.folder / "out/figures/grid.png"), 200)
        rows = [row for row in read_csv(self.folder / "out/measurements.csv")
                if row["metric"] == "mean_luminance" and row["seed"] == "all"
                and row["method"] == "ssdo" and row["stage"] == "filtered"]
        found = {(row["view"], "180" in row["probe"]): row for row in rows}
        self.assertEqual(set(found), {("main", False), ("main", True), ("main [box]", False),
                                      ("main [box]", True), ("main [ground]", True)})
        for row in rows:
            self.assertLess(float(row["lower"]), float(row["value"]))
            self.assertEqual((row["unit"], row["n"]), ("radiance", "2"))
        # The sun is on the box's other side.
        self.assertNotAlmostEqual(float(found["main [box]", False]["value"]),
                                  float(found["main [box]", True]["value"]), places=2)
        tables = (self.folder / "out/tables/brightness_filtered.md").read_text(encoding="utf-8")
        self.assertIn("mean_blue", tables)
        accuracy = (self.folder / "out/tables/accuracy_filtered.md").read_text(encoding="utf-8")
        self.assertNotIn("mean_", accuracy)

    def test_a_panel_of_no_one_probe_is_refused(self):
        path = self.write("bad.toml", GRID.replace('"turned", probe.rotation_degrees = 180',
                                                   '"turned"'))
        self.refused_run(2, ["figure[0].rows[0].label", "probe.rotation_degrees is '0', '180'"],
                         path)


BOUNCE = """\
format = 1
[experiment]
name = "bounce"
title = "Bounce"
[scene]
source = "coloured_boxes"
resolution = [160, 90]
[parameters]
samples = 32
steps = 4
[reference]
method = "rtgi_unoccluded"
rays_per_pixel = 4
[[run]]
methods = ["s3hogi"]
keep_bounce = "yes"
[[figure]]
name = "bounce"
kind = "lobes"
methods = ["s3hogi"]
points = [{label = "p", pixel = [0.5, 0.62]}]
"""


class BounceLobes(CliTest):
    def test_the_colour_follows_the_light(self):
        """S3HO, Fig. 4: light from the left comes back green, light from the right blue."""
        path = self.write("bounce.toml", BOUNCE)
        self.good("run", path, "--out", self.folder / "out")
        figures = self.folder / "out/figures"
        self.assertGreater(varied_rows(figures / "bounce.png"), 50)
        point = json.loads((figures / "bounce.json").read_text(encoding="utf-8"))["points"][0]
        left = point["indirect_of_light_from_the_left"]
        right = point["indirect_of_light_from_the_right"]
        self.assertGreater(left[1], 2 * left[2])
        self.assertGreater(right[2], 2 * right[1])
        # The picture's radiance at the point is rho E / pi of both parts.
        row = next(row for row in read_csv(self.folder / "out/measurements.csv")
                   if row["view"] == "main [p]" and row["metric"] == "mean_blue"
                   and row["stage"] == "filtered" and row["seed"] == "all")
        self.assertAlmostEqual(float(row["value"]), 0.8 / math.pi * point["irradiance"][2],
                               delta=2e-3)


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
            # The same as measurements: L = rho E / pi.
            rows = read_csv(self.folder / "out/measurements.csv")
            found = {row["metric"]: float(row["value"]) for row in rows
                     if row["view"] == f"main [{point['label']}]" and row["seed"] == "all"
                     and row["method"] == "s3ho" and row["stage"] == "filtered"}
            self.assertEqual(set(found), {"mean_red", "mean_green", "mean_blue", "mean_luminance"})
            for c, name in enumerate(("mean_red", "mean_green", "mean_blue")):
                self.assertAlmostEqual(found[name], 0.8 / math.pi * lit[c], delta=1e-3)

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
