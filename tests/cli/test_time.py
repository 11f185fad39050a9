"""occlab time: tables of times and nothing else."""

import hashlib
import json
import os
import re

from support import ROOT, SMALL_EXPERIMENT, CliTest, decode_png, occlab, read_csv

CPUS = min(os.cpu_count(), 32)  # more threads llvmpipe does not take
TINY = """\
format = 1
[experiment]
name = "tiny"
title = "Tiny"
[scene]
source = "three_boxes"
resolution = [48, 27]
[probe]
source = "sky_sun"
[parameters]
samples = 4
steps = 1
[timing]
methods = ["ssao", "s3ho"]
baseline = "ssao"
repetitions = 6
budget_seconds = 0.1
"""
ONE_BY_ONE = TINY + """\
axes = "one_by_one"
samples = [4, 8]
resolution = ["48x27", "96x54"]
triangles = [38, 342]
threads = [1, 2]
note = "A note of the experiment"
"""


class Time(CliTest):
    def time(self, text, *arguments, **settings):
        return self.good("time", self.write("tiny.toml", text), *arguments, **settings)

    def test_prints_the_table_and_leaves_nothing(self):
        finished = self.time(TINY)
        self.assertEqual([path.name for path in self.folder.iterdir()], ["tiny.toml"])
        self.assertIn("## Times on ", finished.stdout)
        self.assertRegex(finished.stdout, r"\| ssao +\|.*\| +1 \[1, 1\] \|")
        self.assertRegex(finished.stdout, r"\| s3ho +\|")
        for words in ("rasteriser: ", "threads that rasterise ", "load ", "Drift: ", "repetitions in ",
                      "ended because ", "interpolated between order statistics"):
            self.assertIn(words, finished.stdout)
        self.assertNotIn("Accuracy", finished.stdout)

    def test_json(self):
        tables = json.loads(self.time(TINY, "--json").stdout)
        self.assertEqual([table["name"] for table in tables], ["timing"])

    def test_stored_results(self):
        out = self.folder / "out"
        finished = self.time(TINY, "--out", out)
        self.assertEqual({path.name for path in out.iterdir()},
                         {"measurements.csv", "run.json", "tables"})
        rows = read_csv(out / "measurements.csv")
        report = json.loads((out / "run.json").read_text(encoding="utf-8"))
        data = (out / "measurements.csv").read_bytes()
        self.assertEqual(report["measurements_sha256"], hashlib.sha256(data).hexdigest())
        for key in ("clock", "calibration", "device", "driver", "rasteriser", "cpu", "threads",
                    "rasteriser_threads", "load_before", "load_after", "repetitions", "seconds",
                    "widest_interval", "stopped_because", "drift_last_over_first_third",
                    "rejected_passes", "overrun_frames", "notes"):
            self.assertIn(key, report["timing"])
        self.assertGreaterEqual(report["timing"]["repetitions"], 6)
        values = {(row["method"], row["metric"]): float(row["value"]) for row in rows}
        for method in ("ssao", "s3ho"):
            passes = [values[method, f"time_ms.{name}"]
                      for name in ("gbuffer", "occlusion", "filter", "lighting")]
            self.assertTrue(all(time > 0 for time in passes))
            self.assertGreater(values[method, "time_ms.frame"], max(passes))
            self.assertIn((method, "time_ms.rest"), values)
            for row in rows:
                if row["metric"].startswith("time_ms."):
                    self.assertLessEqual(float(row["lower"]), float(row["value"]))
                    self.assertLessEqual(float(row["value"]), float(row["upper"]))
        # The same table again from what was stored, notes and all.
        self.assertEqual(self.good("table", out).stdout, finished.stdout)

    def test_layers_and_cameras_are_passes_and_ratios_are_to_one_of_the_axis(self):
        out = self.folder / "out"
        finished = self.time(
            TINY.replace('methods = ["ssao", "s3ho"]',
                         'methods = ["ssao"]\nvisibility = ["depth", "peeled", "multiview"]\n'
                         'baseline_at = {visibility = "depth"}'), "--out", out)
        self.assertIn("ratios are to ssao with visibility = depth", finished.stdout)
        of = {(row["parameter.visibility"], row["metric"]): float(row["value"])
              for row in read_csv(out / "measurements.csv")}
        self.assertEqual(of["depth", "time_ratio.frame"], 1.0)
        self.assertNotEqual(of["peeled", "time_ratio.frame"], 1.0)
        self.assertGreater(of["peeled", "time_ms.layers"], 0)
        self.assertGreater(of["multiview", "time_ms.cameras"], 0)
        self.assertNotIn(("depth", "time_ms.layers"), of)

    def test_one_axis_at_a_time(self):
        out = self.folder / "out"
        finished = self.time(ONE_BY_ONE, "--out", out)
        self.assertIn("A note of the experiment", finished.stdout)
        self.assertIn("How times grow", finished.stdout)
        self.assertEqual({path.stem for path in (out / "figures").iterdir()},
                         {f"scaling_{axis}" for axis in
                          ("samples", "resolution", "triangles", "threads")})
        for path in (out / "figures").iterdir():
            width, height, channels, _ = decode_png(path)
            self.assertTrue(1200 < width < 1350 and height > 500 and channels == 3)
        rows = read_csv(out / "measurements.csv")
        points = {(row["resolution"], row["parameter.samples"], row["parameter.triangles"],
                   row["parameter.threads"])
                  for row in rows if row["metric"] == "time_ms.frame"}
        base = str(CPUS)
        self.assertEqual(points, {
            ("48x27", "4", "38", base), ("48x27", "8", "38", base), ("96x54", "4", "38", base),
            ("48x27", "4", "342", base), ("48x27", "4", "38", "1"), ("48x27", "4", "38", "2")})
        exponents = {row["metric"] for row in rows if row["metric"].startswith("time_exponent.")}
        for axis in ("samples", "resolution", "triangles", "threads"):
            for name in ("gbuffer", "occlusion", "filter", "lighting", "frame"):
                self.assertIn(f"time_exponent.{axis}.{name}", exponents)
        sessions = json.loads((out / "run.json").read_text(encoding="utf-8"))["timing"]["sessions"]
        self.assertEqual({session["rasteriser_threads"] for session in sessions},
                         {1, 2, CPUS})

    def test_beside_the_published_frame_rates(self):
        finished = self.good("time", ROOT / "configs/papers/ssdo_table1.toml",
                             "--set", 'timing.resolution=["1024x768"]', "--set", "timing.samples=8",
                             "--set", "scene.source=three_boxes", "--set", "probe.source=sky_sun",
                             "--set", "timing.repetitions=3", "--set", "timing.budget_seconds=0.1",
                             "--set", 'timing.methods=["ssao", "ssdo"]')
        self.assertRegex(finished.stdout, r"\| ssdogi +\| +– \(\d\) \| +– \(\d\) \| +65.8 ")
        self.assertEqual(finished.stdout.count("Contradiction in the published table"), 2)
        self.assertIn("stands in for it", finished.stdout)
        self.assertIn("their range, which covers less than 95%", finished.stdout)

    def test_run_does_the_same_for_a_file_of_times_alone(self):
        out = self.folder / "out"
        finished = self.good("run", self.write("tiny.toml", TINY), "--out", out)
        self.assertIn("## Times on ", finished.stdout)
        self.assertRegex(finished.stderr, r"of [\d.]+ s, [\d.]+% were neither rendering")


class Overhead(CliTest):
    def test_a_run_says_where_its_time_went(self):
        out = self.folder / "out"
        finished = self.good("run", self.write("small.toml", SMALL_EXPERIMENT), "--out", out)
        stated = re.search(r"of ([\d.]+) s, ([\d.]+)% were neither rendering", finished.stderr)
        spent = json.loads((out / "run.json").read_text(encoding="utf-8"))["wall_time"]
        self.assertAlmostEqual(sum(spent["seconds"].values()), spent["total_seconds"], places=6)
        self.assertAlmostEqual(float(stated.group(2)), 100 * spent["overhead_share"], places=1)
        for kind in ("rendering", "tracing", "measuring", "storing"):
            self.assertGreater(spent["seconds"][kind], 0)
        work = sum(spent["seconds"].get(kind, 0)
                   for kind in ("rendering", "tracing", "measuring", "timing"))
        self.assertAlmostEqual(spent["overhead_seconds"], spent["total_seconds"] - work, places=6)


class BadInput(CliTest):
    def refused_time(self, words, text, *arguments):
        path = self.write("bad.toml", text)
        self.refused(2, words, "time", path, *arguments, "--out", self.folder / "out")

    def test_no_timing(self):
        self.refused_time(["bad.toml", "key 'timing': missing"], SMALL_EXPERIMENT)

    def test_keys(self):
        for line, words in (
                ("repetitionz = 5", ["bad.toml:16", "timing.repetitionz", "'repetitions'"]),
                ('resolution = ["48"]', ["bad.toml:18", "timing.resolution", "found '48'"]),
                ('axes = "one_by_one"', ["bad.toml:18", "timing.axes", "needs an axis"]),
                ("threads = [0]", ["bad.toml:18", "timing.threads", "found 0", "[1, 32]"])):
            with self.subTest(line):
                text = (TINY + line + "\n" if "repetitionz" not in line
                        else TINY.replace("repetitions = 6", line))
                self.refused_time(words, text)

    def test_baseline(self):
        self.refused_time(["timing.baseline", "'ssbn'", "accepted: ssao, s3ho"],
                          TINY.replace('baseline = "ssao"', 'baseline = "ssbn"'))

    def test_set(self):
        self.refused_time(["--set timing.triangles=[0]", "found 0"], TINY,
                          "--set", "timing.triangles=[0]")

    def test_published_that_is_broken(self):
        self.refused_time(["timing.published", "there is no file"], TINY + 'published = "nobody"\n')

    def test_folder_of_a_run(self):
        out = self.folder / "out"
        path = self.write("small.toml", SMALL_EXPERIMENT)
        self.good("run", path, "--out", out)
        self.refused(2, ["--out", "holds the cells"], "time", self.write("tiny.toml", TINY),
                     "--out", out)

    def fails_after_start(self, words, text):
        """Where the device has been opened, its clock has already been spoken of."""
        path = self.write("bad.toml", text)
        finished = occlab("time", path, "--out", self.folder / "out")
        self.assertEqual(finished.returncode, 2, finished.stderr)
        error = finished.stderr.splitlines()[-1]
        self.assertTrue(error.startswith("occlab: "), error)
        for word in words:
            self.assertIn(word, error)
        self.assertFalse((self.folder / "out" / "measurements.csv").exists())

    def test_triangles(self):
        self.fails_after_start(["20 triangles were asked for", "has 38"], TINY + "triangles = 20\n")
        self.fails_after_start(["timing.triangles", "340 and 345 both come to 342"],
                               TINY + "triangles = [340, 345]\n")

    def test_threads_of_a_run(self):
        self.refused_run(2, ["timing.threads", "'occlab time' only"],
                         self.write("bad.toml", TINY + "threads = [1]\n"))
