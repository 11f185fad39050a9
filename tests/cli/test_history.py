"""occlab history: runs are stored once, regressions fail, decisions are remembered, pages open."""

import base64
import collections
import csv
import json
import shutil
import sqlite3
import struct
import subprocess
import unittest
import xml.etree.ElementTree as xml
import zlib

import planted
from support import OCCLAB, CliTest, occlab, probe_with, read_csv, smoke_results

EXPERIMENT = """\
format = 1
[experiment]
name = "gated"
title = "Gated"
[scene]
source = "three_boxes"
resolution = [48, 27]
[probe]
source = "PROBE"
[reference]
method = "rtdo"
rays_per_pixel = 16
[[run]]
methods = ["ssao", "s3ho"]
samples = 4
seeds = 8
"""
# The columns that say what a row is of, parameters apart.
IDENTITY = {"experiment", "scene", "view", "resolution", "probe", "method", "stage", "metric"}


class HistoryTest(CliTest):
    def setUp(self):
        super().setUp()
        self.db = self.folder / "h.sqlite"

    def history(self, verb, *arguments, **settings):
        return occlab("history", verb, *arguments, "--db", self.db, **settings)

    def passes(self, verb, *arguments, **settings):
        finished = self.history(verb, *arguments, **settings)
        self.assertEqual(finished.returncode, 0, finished.stdout + finished.stderr)
        return finished.stdout

    def measured(self, name="gated", *settings, probe="sky_sun"):
        experiment = self.write("gated.toml", EXPERIMENT.replace("PROBE", str(probe)))
        self.good("run", experiment, "--out", self.folder / name, *settings)
        return self.folder / name

    def worsened(self, results, factor, method="s3ho", metric="rmse"):
        """A copy of a results folder in which one metric of a method is `factor` times as large."""
        copy = self.folder / f"worse-{factor}"
        shutil.copytree(results, copy)
        rows = read_csv(copy / "measurements.csv")
        for row in rows:
            if row["method"] == method and row["metric"] == metric and row["value"]:
                spread = 1 + 1e-4 * (int(row["seed"]) % 3) if row["seed"] != "all" else 1
                for column in ("value", "lower", "upper"):
                    if row[column]:
                        row[column] = repr(float(row[column]) * factor * spread)
        with open(copy / "measurements.csv", "w", newline="", encoding="utf-8") as stream:
            writer = csv.DictWriter(stream, rows[0].keys(), lineterminator="\r\n")
            writer.writeheader()
            writer.writerows(rows)
        run = json.loads((copy / "run.json").read_text(encoding="utf-8"))
        run["measurements_sha256"] = subprocess.run(
            ["sha256sum", copy / "measurements.csv"], capture_output=True, text=True,
            check=True).stdout.split()[0]
        (copy / "run.json").write_text(json.dumps(run), encoding="utf-8")
        return copy


class Adding(HistoryTest):
    def test_a_run_is_stored_once_with_all_its_numbers(self):
        results = smoke_results()
        first = self.passes("add", results, "--commit", "abcd1234", "--subject", "it's \"new\"",
                            "--commit-time", "2026-11-22T11:57:39+01:00")
        self.assertIn("run 1 of commit abcd1234", first)
        before = self.db.read_bytes()
        again = self.passes("add", results, "--commit", "abcd1234", "--subject", "it's \"new\"",
                            "--commit-time", "2026-11-22T11:57:39+01:00")
        self.assertIn("nothing changed", again)
        self.assertEqual(self.db.read_bytes(), before)
        run, = json.loads(self.passes("list", "--json"))["runs"]
        self.assertEqual((run["commit"], run["subject"], run["commit_time"]),
                         ("abcd1234", "it's \"new\"", "2026-11-22T10:57:39Z"))
        rows = [row for row in read_csv(results / "measurements.csv")
                if "_spectrum." not in row["metric"] and "/" not in row["metric"]]
        series = collections.defaultdict(list)
        for row in rows:
            series[tuple(row[name] for name in row if name in IDENTITY
                         or name.startswith("parameter."))].append(row)
        database = sqlite3.connect(self.db)
        # Where one seed is all there is, it stands for all.
        for table, wanted in (("over_seeds", [r for rows_of_one in series.values()
                                              for r in rows_of_one
                                              if r["seed"] == "all" or len(rows_of_one) == 1]),
                              ("per_seed", [r for r in rows if r["seed"] != "all"])):
            stored = sorted(value for value, in database.execute(
                f"SELECT value FROM {table} WHERE value IS NOT NULL"))
            self.assertEqual(stored, sorted(float(r["value"]) for r in wanted if r["value"]))
        pictures = database.execute("SELECT method, png FROM run_images JOIN images USING (hash)")
        methods = {method: png for method, png in pictures}
        self.assertEqual(set(methods), {"rtdo", "ssao", "s3ho", "ssdo", "ssbn"})
        self.assertEqual(len(set(methods.values())), 5)
        database.close()

    def test_two_processes_at_once(self):
        results = smoke_results()
        processes = [subprocess.Popen([OCCLAB, "history", "add", results, "--db", self.db,
                                       "--commit", f"{digit}" * 8], stdout=subprocess.DEVNULL)
                     for digit in (1, 2, 3)]
        self.assertEqual([process.wait(120) for process in processes], [0, 0, 0])
        self.assertEqual(len(json.loads(self.passes("list", "--json"))["runs"]), 3)

    def test_what_is_no_finished_run_is_refused(self):
        for words, arguments in ((["is not there"], ["none"]),
                                 (["not a results folder"], [self.folder]),
                                 (["--commit-time", "2026-11-22T"],
                                  [smoke_results(), "--commit-time", "yesterday"])):
            self.refused(2, words, "history", "add", *arguments, "--db", self.db)
        edited = self.folder / "edited"
        shutil.copytree(smoke_results(), edited)
        with open(edited / "measurements.csv", "a", encoding="utf-8") as stream:
            stream.write("\r\n")
        self.refused(2, ["measurements.csv", "not the one that run.json describes"], "history",
                     "add", edited, "--db", self.db)

    def test_files_that_are_no_history_are_refused(self):
        self.refused(2, [self.db, "there is no such history"], "history", "list", "--db", self.db)
        self.db.write_text("a text of some length\n" * 99, encoding="utf-8")
        self.refused(2, [self.db, "is not an SQLite database"], "history", "list", "--db", self.db)
        self.refused(2, [self.db, "is not an SQLite database"], "history", "add", smoke_results(),
                     "--db", self.db)
        self.db.unlink()
        database = sqlite3.connect(self.db)
        database.execute("CREATE TABLE cats (name TEXT)")
        database.close()
        self.refused(2, [self.db, "another program"], "history", "list", "--db", self.db)
        self.db.unlink()
        self.passes("add", smoke_results(), "--no-images", "--commit", "abcd1234")
        database = sqlite3.connect(self.db)
        database.execute("PRAGMA user_version = 99")
        database.close()
        self.refused(2, [self.db, "99", "newer occlab"], "history", "list", "--db", self.db)

    def test_a_file_that_cannot_be_written(self):
        self.refused(3, ["/proc/h.sqlite", "cannot be opened"], "history", "add", smoke_results(),
                     "--db", "/proc/h.sqlite")


class Checking(HistoryTest):
    def test_the_first_baseline_is_accepted_and_compared_with(self):
        results = self.measured()
        self.refused(2, ["--against main", "--accept"], "history", "check", results, "--against",
                     "main", "--db", self.db)
        self.refused(2, ["--why"], "history", "check", results, "--against", "main", "--accept",
                     "--db", self.db)
        self.passes("check", results, "--against", "main", "--accept", "--why", "first")
        self.assertRegex(self.passes("check", results, "--against", "main"), "passed: [0-9]+ SAME")
        commit = json.loads(self.passes("list", "--json"))["runs"][0]["commit"]
        for against in (commit, results, results / "measurements.csv"):
            self.assertIn("passed", self.passes("check", results, "--against", against))

    def test_a_changed_experiment_can_be_accepted(self):
        self.passes("check", self.measured(), "--against", "main", "--accept", "--why", "first")
        larger = self.measured("larger", "--set", "scene.resolution=[64,36]")
        refused = self.history("check", larger, "--against", "main")
        self.assertEqual(refused.returncode, 2, refused.stdout)
        self.assertIn("nothing was compared: resolution:", refused.stderr)
        self.passes("check", larger, "--against", "main", "--accept", "--why", "larger images")
        self.assertIn("passed", self.passes("check", larger, "--against", "main"))

    def test_the_first_baseline_is_compared_with_nothing(self):
        self.refused(2, ["--junit", "compared with nothing"], "history", "check", smoke_results(),
                     "--against", "main", "--accept", "--why", "first", "--junit",
                     self.folder / "junit.xml", "--db", self.db)
        self.assertFalse(self.db.exists())

    def test_a_run_does_not_repeat_itself(self):
        results = smoke_results()
        self.refused(2, ["is the same run as"], "history", "check", results, results, "--against",
                     results, "--db", self.db)
        self.refused(2, ["is the same run as"], "history", "check", results, "--against", results,
                     "--against", results, "--db", self.db)

    def test_a_sweep_is_stored_and_judged(self):
        results = self.measured("sweep", "--set", 'scene.resolution=["48x27", "64x36"]')
        self.passes("check", results, "--against", "main", "--accept", "--why", "first")
        worse = self.worsened(results, 1.1)
        finished = self.history("check", worse, "--against", "main")
        self.assertEqual(finished.returncode, 1, finished.stderr)
        self.assertRegex(finished.stdout, "FAILED: 4 WORSE, [0-9]+ SAME")
        for size in ("48x27", "64x36"):  # a line says which image it is of
            self.assertRegex(finished.stdout, rf"WORSE .*s3ho rmse .*{size}")

    def test_a_level_that_is_given_is_before_that_of_the_file(self):
        settings = self.write("gate.toml", "level = 0.2\n")
        results = smoke_results()
        for option, level in (((), "20%"), (("--level", "0.01"), "1%")):
            out = self.passes("check", results, "--against", results, "--all", "--settings",
                              settings, *option)
            self.assertIn(f"at most {level}", " ".join(out.split()))

    def test_a_regression_fails_everywhere_and_stays_visible_when_accepted(self):
        results = self.measured()
        self.passes("check", results, "--against", "main", "--accept", "--why", "first")
        worse = self.worsened(results, 1.1)
        files = [self.folder / name for name in ("junit.xml", "pr.md", "check.json")]
        outputs = ("--junit", files[0], "--markdown", files[1], "--json", files[2])
        finished = self.history("check", worse, "--against", "main", *outputs)
        self.assertEqual(finished.returncode, 1, finished.stderr)
        self.assertRegex(finished.stdout, "FAILED: 2 WORSE, [0-9]+ SAME")
        suite = xml.parse(files[0]).getroot().find("testsuite")
        self.assertEqual(suite.get("failures"), "2")
        self.assertEqual(len(suite.findall("testcase")), int(suite.get("tests")))
        self.assertEqual(len(suite.findall("testcase/failure")), 2)
        self.assertIn("FAILED", files[1].read_text(encoding="utf-8").splitlines()[0])
        report = json.loads(files[2].read_text(encoding="utf-8"))
        self.assertEqual([finding["verdict"] for finding in report["findings"][:3]],
                         ["WORSE", "WORSE", "SAME"])
        for finding in report["findings"][:2]:
            self.assertAlmostEqual(finding["effect"], 0.1, delta=0.001)
            self.assertEqual((finding["method"], finding["metric"]), ("s3ho", "rmse"))
            self.assertGreater(finding["noise_floor"], 0)
        # Within a larger minimum effect it is the same.
        settings = self.write("gate.toml", "[minimum_effect]\nerror = 0.2\n")
        for option in (("--minimum-effect", "error=0.2"), ("--settings", settings)):
            self.assertIn("passed", self.passes("check", worse, "--against", "main", *option))
        self.passes("check", worse, "--against", "main", "--accept", "--why", "wanted")
        listed = self.passes("list")
        self.assertEqual(listed.count("accepted although WORSE: s3ho rmse"), 2)
        self.assertIn("wanted", listed)
        self.assertIn("passed", self.passes("check", worse, "--against", "main"))
        self.assertEqual(self.history("check", results, "--against", "main").returncode, 0)

    def test_nothing_compared_is_no_pass(self):
        results = self.measured()
        other = self.measured("other", "--set", "probe.exposure_stops=-0.0145")
        self.refused_check = self.history("check", other, "--against", results)
        self.assertEqual(self.refused_check.returncode, 2)
        self.assertIn("nothing was compared: probe:", self.refused_check.stderr)

    def test_what_is_missing_fails_unless_allowed(self):
        results = self.measured()
        fewer = self.measured("fewer", "--set", 'run[0].methods=["ssao"]')
        finished = self.history("check", fewer, "--against", results)
        self.assertEqual(finished.returncode, 1)
        self.assertIn("MISSING", finished.stdout)
        self.passes("check", fewer, "--against", results, "--allow-missing")

    def test_a_darker_probe_file_is_another_input(self):
        probe = probe_with(self.folder / "probe.exr", 50.0)
        bright = self.measured("bright", probe=probe)
        probe_with(probe, 49.5)
        dark = self.measured("dark", probe=probe)
        finished = self.history("check", dark, "--against", bright)
        self.assertEqual(finished.returncode, 1, finished.stdout)
        self.assertIn("the probe's file is another", finished.stdout)

    def test_wrong_settings_are_refused(self):
        results = smoke_results()
        for words, option in ((["tim", "did you mean 'time'"], ("--minimum-effect", "tim=0.1")),
                              (["error=x"], ("--minimum-effect", "error=x")),
                              (["CLASS=VALUE"], ("--minimum-effect", "0.1")),
                              (["levle"], ("--settings", self.write("g.toml", "levle = 0.1\n")))):
            self.refused(2, words, "history", "check", results, "--against", results, "--db",
                         self.db, *option)


class Planted(HistoryTest):
    """A short form of docs/regression.md: its table is of 50 repetitions."""

    def test_verdicts_on_planted_changes(self):
        repetitions = 2
        base = planted.run(self.folder, "base", 2 * planted.SEEDS * repetitions)
        sign = planted.run(self.folder, "sign", planted.SEEDS * repetitions,
                           planted.changed_program(self.folder / "changed", planted.WRONG_SIGN))
        results = planted.planted_accuracy(self.folder, repetitions, base, {"sign": sign})
        for code, findings in results["nothing"]:
            self.assertEqual(code, 0)
            self.assertEqual({finding["verdict"] for finding in findings}, {"SAME"})
        for code, findings in results["sign"]:
            self.assertEqual(code, 1)
            verdicts = {(f["method"], f["metric"], f["stage"]): f["verdict"] for f in findings}
            self.assertEqual(verdicts["s3ho", "rmse", "filtered"], "WORSE")
            self.assertEqual({verdict for (method, _, _), verdict in verdicts.items()
                              if method == "ssao"}, {"SAME"})


class Page(HistoryTest):
    @staticmethod
    def values(data, name):
        raw = zlib.decompress(base64.b64decode(data[name]))
        return struct.unpack(f"<{len(raw) // 4}f", raw)

    def test_the_page_has_the_numbers_steps_and_pictures(self):
        results = self.measured()
        worse = self.worsened(results, 1.1)
        for day, folder in enumerate([results] * 3 + [worse] * 2):
            self.passes("add", folder, "--commit", f"{day}abc1234", "--commit-time",
                        f"2026-01-0{day + 1}T00:00:00Z")
        page = self.folder / "page"
        self.passes("report", "-o", page)
        text = (page / "index.html").read_text(encoding="utf-8")
        data, numbers = (json.loads(part.split("</script>")[0])
                         for part in text.split('type="application/json">')[1:])
        self.assertEqual([run["commit"][0] for run in data["runs"]], list("01234"))
        values = self.values(numbers, "value")
        self.assertEqual(len(values), 5 * len(data["series"]))
        self.assertEqual({(step["run"], step["before_run"], step["verdict"])
                          for step in data["steps"]}, {(3, 2, "WORSE")})
        index = data["steps"][0]["series"]
        series = data["series"][index]
        self.assertEqual((series["method"], series["metric"]), ("s3ho", "rmse"))
        self.assertAlmostEqual(values[5 * index + 4] / values[5 * index], 1.1, places=3)
        for image in data["images"]:
            self.assertTrue((page / image["file"]).is_file())
        self.assertEqual(len(list((page / "images").iterdir())), 3)  # stored once for five runs
        # Marked as intended with the key that the page shows; then the page says so.
        self.passes("accept", "--series", series["key"], "--commit", "3abc1234", "--why", "wanted")
        self.refused(2, ["no series has the key"], "history", "accept", "--series", "0", "--commit",
                     "3abc1234", "--why", "wanted", "--db", self.db)
        self.passes("report", "-o", page)
        text = (page / "index.html").read_text(encoding="utf-8")
        data = json.loads(text.split('type="application/json">')[1].split("</script>")[0])
        self.assertEqual([step["intended"]["why"] for step in data["steps"]
                          if step["series"] == index], ["wanted"])

    def test_it_overwrites_nothing_but_a_page(self):
        self.passes("add", smoke_results(), "--no-images", "--commit", "abcd1234")
        (self.folder / "mine").mkdir()
        self.write("mine/notes.txt", "mine")
        self.refused(2, ["mine", "is not the page of a history"], "history", "report", "-o",
                     self.folder / "mine", "--db", self.db)


if __name__ == "__main__":
    unittest.main()
