"""Sweeps over scenes, views, resolutions and probes: planned, killed, resumed, asked about."""

import csv
import json
import os
import pathlib
import re
import signal
import sqlite3
import statistics
import subprocess
import time

from support import (OCCLAB, SMALL_EXPERIMENT, CliTest, exr_pixels, measured, not_sanitized,
                     read_csv, snapshot)

SWEEP = """\
format = 1
[experiment]
name = "sweep"
title = "A small sweep"
[scene]
source = ["three_boxes", "gallery"]
resolution = ["48x27", "32x18"]
[probe]
source = "sky_sun"
prefilter_degrees = [0, 10]
rotation_degrees = [0, 90]
[sweep]
exclude = [{scene.source = "gallery", scene.resolution = "48x27"}]
[reference]
method = "rtdo"
rays_per_pixel = 4
[[run]]
methods = ["ssao", "s3ho"]
samples = {from = 2, to = 4, factor = 2}
steps = [1, 2]
zip = [["samples", "steps"]]
seeds = 2
"""
BENCHES = 12  # 2 scenes x 2 resolutions less one, x 4 probes
CELLS = BENCHES * (1 + 2 * 2 * 2)


def cells_of(folder):
    return {cell.name: exr_pixels(cell / "layers.exr")
            for cell in (folder / "cells").iterdir() if not cell.name.startswith(".")}


def bench_of(row):
    return row["scene"], row["view"], row["resolution"], row["probe"]


class Sweep(CliTest):
    def setUp(self):
        super().setUp()
        self.experiment = self.write("sweep.toml", SWEEP)

    def run_to(self, name, *arguments):
        return self.good("run", self.experiment, "--out", self.folder / name, *arguments)

    def forecast(self, name, *arguments):
        return json.loads(self.good("run", self.experiment, "--out", self.folder / name,
                                    "--dry-run", "--json", *arguments).stdout)

    def test_every_bench_is_what_a_run_of_its_own_makes(self):
        """The same cells to the bit and the same numbers, bench by bench."""
        finished = self.run_to("sweep")
        self.assertIn(f"{CELLS} cells, {CELLS} to render", finished.stderr)
        cells = cells_of(self.folder / "sweep")
        rows = measured(self.folder / "sweep/measurements.csv")
        self.assertEqual(len(cells), CELLS)
        self.assertEqual(len({bench_of(row) for row in rows}), BENCHES)
        self.run_to("one", "--set", "scene.source=gallery", "--set", "scene.resolution=[32, 18]",
                    "--set", "probe.prefilter_degrees=10", "--set", "probe.rotation_degrees=90",
                    "--set", "sweep={}")
        alone = cells_of(self.folder / "one")
        self.assertEqual(len(alone), 9)
        self.assertEqual(alone, {name: cells[name] for name in alone})
        rows_alone = measured(self.folder / "one/measurements.csv")
        bench = bench_of(rows_alone[0])
        self.assertEqual(rows_alone, [row for row in rows if bench_of(row) == bench])
        report = json.loads((self.folder / "sweep/run.json").read_text(encoding="utf-8"))
        self.assertEqual(len(report["benches"]), BENCHES)
        self.assertEqual(report["measurement_count"], len(rows))
        for entry in report["benches"]:
            self.assertIn("verdict", entry["reference"])
        self.assertNotIn("reference", report)

    def test_a_finished_sweep_does_nothing(self):
        first = self.run_to("sweep")
        before = snapshot(self.folder)
        second = self.run_to("sweep")
        self.assertIn("everything is done", second.stderr)
        self.assertEqual(second.stdout, first.stdout)
        self.assertEqual(snapshot(self.folder), before)

    def test_a_killed_sweep_goes_on(self):
        self.run_to("whole")
        out = self.folder / "killed"
        process = subprocess.Popen([OCCLAB, "run", self.experiment, "--out", out],
                                   stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        self.addCleanup(process.kill)
        deadline = time.monotonic() + 60
        while len(list(out.glob("cells/[0-9a-f]*"))) < CELLS // 2:
            self.assertIsNone(process.poll(), "it ended before it could be killed")
            self.assertLess(time.monotonic(), deadline)
            time.sleep(0.002)
        process.send_signal(signal.SIGKILL)
        process.wait()
        left = len(list(out.glob("cells/[0-9a-f]*")))
        self.assertLess(left, CELLS)
        self.assertIn(f"{CELLS} cells, {CELLS - left} to render", self.run_to("killed").stderr)
        self.assertEqual(cells_of(out), cells_of(self.folder / "whole"))
        self.assertEqual(measured(out / "measurements.csv"),
                         measured(self.folder / "whole/measurements.csv"))

    def test_dry_run(self):
        before = snapshot(self.folder)
        nothing = self.forecast("sweep", "--device", "auto")
        self.assertEqual(snapshot(self.folder), before, "a dry run writes nothing")
        self.assertEqual((len(nothing["cells"]), nothing["finished"]), (CELLS, 0))
        self.assertEqual({cell["id"] for cell in nothing["cells"]}, {None})
        self.assertTrue(any("no finished cell" in note for note in nothing["notes"]))
        self.assertGreater(nothing["seconds_to_render"], 0)
        self.run_to("sweep")
        whole = self.forecast("sweep")
        self.assertEqual((whole["finished"], whole["to_render"]), (CELLS, 0))
        self.assertEqual({cell["id"] for cell in whole["cells"]},
                         set(cells_of(self.folder / "sweep")))
        self.assertEqual({cell["seconds_from"] for cell in whole["cells"]}, {"measured"})
        longer = self.forecast("sweep", "--set", "run[0].seeds=3")
        self.assertEqual((longer["finished"], longer["to_render"]), (CELLS, BENCHES * 4))
        new = [cell for cell in longer["cells"] if not cell["finished"]]
        self.assertEqual({cell["parameters"]["seed"] for cell in new}, {"2"})
        self.assertEqual({cell["seconds_from"] for cell in new}, {"estimated"})
        self.assertTrue(any(re.match(r"seconds of s3ho: the model times .* \d+ finished", note)
                            for note in longer["notes"]))
        table = self.good("run", self.experiment, "--out", self.folder / "sweep",
                          "--dry-run").stdout
        self.assertIn(f"{CELLS} cells, {CELLS} finished, 0 to render", table)
        self.assertEqual(len(re.findall(r"(?m)^\| [0-9a-f]{16} \|", table)), CELLS)
        opened = self.forecast("sweep", "--device", "surfaceless")
        self.assertEqual(opened["finished"], CELLS)

    def test_why(self):
        out = self.folder / "sweep"
        nothing = self.good("why", self.experiment, "--out", out).stdout
        self.assertIn("nothing is stored", nothing)
        self.run_to("sweep")
        done = self.good("why", self.experiment, "--out", out).stdout
        self.assertIn(f"{CELLS} of {CELLS} cells are up to date", done)
        known = sorted(cells_of(out))[0]
        self.assertIn("is up to date",
                      self.good("why", self.experiment, known, "--out", out).stdout)
        change = ("--set", "probe.exposure_stops=1")
        reasons = json.loads(self.good("why", self.experiment, "--out", out, *change,
                                       "--json").stdout)
        self.assertEqual(len(reasons), CELLS)
        for reason in reasons:
            self.assertFalse(reason["finished"])
            self.assertEqual([(fact["name"], fact["stored"], fact["wanted"])
                              for fact in reason["differences"]],
                             [("probe_settings.exposure_stops", "0", "1")])
        one = self.good("why", self.experiment, reasons[5]["cell"], "--out", out, *change).stdout
        self.assertRegex(one, r"probe_settings\.exposure_stops *\| 0 *\| 1")
        self.refused(2, (known, "does not make it"), "why", self.experiment, known, "--out", out,
                     *change)
        self.refused(2, ("0123", "no such cell"), "why", self.experiment, "0123456789abcdef",
                     "--out", out)

    def test_why_names_parameters(self):
        self.run_to("sweep")
        reasons = json.loads(self.good(
            "why", self.experiment, "--out", self.folder / "sweep", "--json", "--set",
            "run[0].steps=[1, 3]").stdout)
        new = [reason for reason in reasons if not reason["finished"]]
        self.assertEqual(len(new), BENCHES * 2 * 2)
        for reason in new:
            self.assertEqual([fact["name"] for fact in reason["differences"]], ["parameters.steps"])
            self.assertEqual(reason["differences"][0]["wanted"], "3")

    def test_query_has_the_rows_of_the_file(self):
        out = self.folder / "sweep"
        self.run_to("sweep")
        rows = [row for row in read_csv(out / "measurements.csv")
                if row["metric"] == "rmse" and row["parameter.samples"] == "4"
                and row["scene"] == "gallery"]
        query = ("query", out, "--where", "metric=rmse", "--where", "samples=4", "--where",
                 "scene=gallery", "--format", "csv")
        first = self.good(*query)
        self.assertIn("made from measurements.csv", first.stderr)
        found = list(csv.DictReader(first.stdout.splitlines()))
        self.assertEqual([row["value"] for row in found], [row["value"] for row in rows])
        self.assertEqual([row["method"] for row in found], [row["method"] for row in rows])
        again = self.good(*query)
        self.assertEqual((again.stdout, again.stderr), (first.stdout, ""))
        for words in (("metric=rmsee", "no measurement has that", "did you mean 'rmse'"),
                      ("sample=4", "there is no such column", "samples"), ("metric", "NAME=VALUE")):
            with self.subTest(words[0]):
                self.refused(2, words[1:], "query", out, "--where", words[0])

    def test_a_stale_or_damaged_index_is_made_again(self):
        out = self.folder / "sweep"
        self.run_to("sweep")
        query = ("query", out, "--where", "metric=rmse", "--where", "seed=0", "--format", "json")
        first = self.good(*query).stdout
        table = out / "measurements.csv"
        text = table.read_text(encoding="utf-8")
        stamps = os.stat(table)
        value = next(row["value"] for row in read_csv(table)
                     if row["metric"] == "rmse" and row["seed"] == "0")
        at = value.index(".") + 3
        changed = value[:at] + str((int(value[at]) + 1) % 10) + value[at + 1:]
        table.write_text(text.replace(f",{value},", f",{changed},", 1), encoding="utf-8")
        os.utime(table, ns=(stamps.st_atime_ns, stamps.st_mtime_ns))  # same size, same time
        second = self.good(*query)
        self.assertIn("made from", second.stderr)
        self.assertTrue(value in first and value not in second.stdout)
        self.assertIn(changed.rstrip("0"), second.stdout)
        (out / "measurements.sqlite").write_bytes(b"no database" * 1000)
        self.assertEqual(self.good(*query).stdout, second.stdout)
        self.assertEqual(sqlite3.connect(out / "measurements.sqlite").execute(
            "SELECT count(*) FROM rows").fetchone()[0], len(read_csv(table)))


@not_sanitized
class Memory(CliTest):
    def quarters(self, *arguments, until):
        """Mean resident pages in the second and the last quarter of a run."""
        process = subprocess.Popen([OCCLAB, *map(str, arguments)], stdout=subprocess.DEVNULL,
                                   stderr=subprocess.DEVNULL)
        self.addCleanup(process.kill)
        pages = []
        while process.poll() is None:
            statm = pathlib.Path(f"/proc/{process.pid}/statm").read_text(encoding="utf-8")
            if not until.exists():
                pages.append(int(statm.split()[1]))
            time.sleep(0.01)
        self.assertEqual(process.returncode, 0)
        quarter = len(pages) // 4
        self.assertGreater(quarter, 20, "too few samples to tell")
        return statistics.fmean(pages[quarter:2 * quarter]), statistics.fmean(pages[-quarter:])

    def test_it_does_not_grow_with_the_cells(self):
        """481 cells, rendered and then measured: the last quarter is within 5% of the second.
        Tables, made of up to 50,000 measurements, come after that and have a bound of their own."""
        experiment = self.write("many.toml", SMALL_EXPERIMENT.split("[[figure]]")[0])
        out = self.folder / "many"
        run = ("run", experiment, "--out", out, "--set", "run[0].seeds=240")
        for arguments in (run + ("--shard", "1/1"), run):
            second, last = self.quarters(*arguments, until=out / "measurements.csv")
            with self.subTest(arguments[-1]):
                self.assertLess(abs(last / second - 1), 0.05)
