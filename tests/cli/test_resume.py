"""A run goes on where it was: after it finished, was changed, damaged, interrupted or killed."""

import hashlib
import json
import os
import shutil
import signal
import subprocess
import time

from support import (OCCLAB, ROOT, SMALL_EXPERIMENT, CliTest, exr_pixels, measured, occlab,
                     smoke_results, snapshot)

# Long enough to be met in its middle.
LONG = SMALL_EXPERIMENT.replace("[48, 27]", "[96, 54]").replace("seeds = 2", "seeds = 24")
LONG_CELLS = 49


class Finished(CliTest):
    def setUp(self):
        super().setUp()
        self.experiment = self.write("small.toml", SMALL_EXPERIMENT)
        self.out = self.folder / "results"
        self.first = self.good("run", self.experiment, "--out", self.out)

    def again(self, *arguments):
        return self.good("run", self.experiment, "--out", self.out, *arguments)

    def cells(self):
        return sorted((self.out / "cells").iterdir())

    def test_a_second_run_does_nothing_and_says_so(self):
        before = snapshot(self.out)
        second = self.again()
        self.assertIn(f"{self.out}: everything is done", second.stderr)
        self.assertIn("5 cells, 0 to render", second.stderr)
        self.assertEqual(second.stdout, self.first.stdout)
        self.assertEqual(snapshot(self.out), before)

    def test_a_change_of_what_is_measured_renders_nothing(self):
        before = snapshot(self.out / "cells")
        old = (self.out / "measurements.csv").read_bytes()
        text = SMALL_EXPERIMENT + ('[[figure]]\nname = "parts"\nkind = "closeups"\nmethods = '
                                   '["ssao"]\nrows = [{label = "middle", rectangle = [12, 6, 24, '
                                   '15], samples = 4}]\n')
        self.experiment.write_text(text, encoding="utf-8")
        second = self.again()
        self.assertIn("5 cells, 0 to render", second.stderr)
        self.assertNotIn("everything is done", second.stderr)
        self.assertEqual(snapshot(self.out / "cells"), before)
        self.assertNotEqual((self.out / "measurements.csv").read_bytes(), old)
        self.assertIn("main [middle]", {row["view"] for row in measured(self.out /
                                                                         "measurements.csv")})
        self.assertTrue((self.out / "figures/parts.png").is_file())

    def test_a_deleted_cell_is_the_only_one_rendered(self):
        victim, *others = self.cells()
        pixels = exr_pixels(victim / "layers.exr")
        numbers = measured(self.out / "measurements.csv")
        before = [snapshot(cell) for cell in others]
        shutil.rmtree(victim)
        self.assertIn("5 cells, 1 to render", self.again().stderr)
        self.assertEqual(exr_pixels(victim / "layers.exr"), pixels)
        self.assertEqual([snapshot(cell) for cell in others], before)
        self.assertEqual(measured(self.out / "measurements.csv"), numbers)

    def test_a_cut_cell_is_said_and_rendered_again(self):
        victim = self.cells()[2]
        pixels = exr_pixels(victim / "layers.exr")
        numbers = measured(self.out / "measurements.csv")
        os.truncate(victim / "layers.exr", 5000)
        second = self.again()
        self.assertRegex(second.stderr, rf"occlab: {victim}: damaged: layers.exr has 5000 bytes")
        self.assertIn("5 cells, 1 to render", second.stderr)
        self.assertEqual(exr_pixels(victim / "layers.exr"), pixels)
        self.assertEqual(measured(self.out / "measurements.csv"), numbers)
        self.assertTrue(any("damaged" in text for text in json.loads(
            (self.out / "run.json").read_text(encoding="utf-8"))["warnings"]))

    def test_changed_pixels_are_never_measured(self):
        """Same size, another byte: found by the checksum when the cell is read."""
        victim = self.cells()[1]
        pixels = exr_pixels(victim / "layers.exr")
        numbers = measured(self.out / "measurements.csv")
        with open(victim / "layers.exr", "r+b") as stream:
            stream.seek(-100, os.SEEK_END)
            byte = stream.read(1)
            stream.seek(-100, os.SEEK_END)
            stream.write(bytes([byte[0] ^ 1]))
        (self.out / "measurements.csv").unlink()
        second = self.again()
        self.assertRegex(second.stderr, rf"occlab: {victim}: damaged: the checksum .* is wrong")
        self.assertEqual(exr_pixels(victim / "layers.exr"), pixels)
        self.assertEqual(measured(self.out / "measurements.csv"), numbers)

    def test_numbers_that_were_changed_are_measured_again(self):
        csv = self.out / "measurements.csv"
        whole = csv.read_text(encoding="utf-8")
        for name, text in {"cut": whole[:len(whole) // 2],
                           "row lost": whole[:whole.rindex("\n", 0, -1) + 1],
                           "digit": whole.replace(",0.", ",0.1", 1)}.items():
            with self.subTest(name):
                csv.write_text(text, encoding="utf-8")
                self.assertIn(f"{csv} is not the one", self.again().stderr)
                self.assertEqual(csv.read_text(encoding="utf-8"), whole)

    def test_a_broken_report_is_written_again(self):
        report = self.out / "run.json"
        whole = json.loads(report.read_text(encoding="utf-8"))
        report.write_text("{", encoding="utf-8")
        self.again()
        now = json.loads(report.read_text(encoding="utf-8"))
        self.assertEqual(now["cells"], whole["cells"])
        self.assertEqual(now["measurements_sha256"], whole["measurements_sha256"])

    def test_fresh_renders_everything_and_keeps_what_is_not_ours(self):
        note = self.out / "note.txt"
        note.write_text("mine", encoding="utf-8")
        numbers = measured(self.out / "measurements.csv")
        self.assertIn("5 cells, 5 to render", self.again("--fresh").stderr)
        self.assertEqual(note.read_text(encoding="utf-8"), "mine")
        self.assertEqual(measured(self.out / "measurements.csv"), numbers)

    def test_fresh_with_bad_input_drops_nothing(self):
        before = snapshot(self.out)
        finished = occlab("run", self.experiment, "--out", self.out, "--fresh", "--set",
                          "scene.view=mian")
        self.assertEqual(finished.returncode, 2)
        self.assertEqual(snapshot(self.out), before)


class Smoke(CliTest):
    def test_times_too_are_not_taken_twice(self):
        before = snapshot(smoke_results())
        second = self.good("run", ROOT / "configs/smoke.toml", "--out", smoke_results())
        self.assertIn("everything is done", second.stderr)
        self.assertEqual(snapshot(smoke_results()), before)


class Interrupted(CliTest):
    def start(self, experiment, out):
        process = subprocess.Popen([OCCLAB, "run", experiment, "--out", out],
                                   stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        self.addCleanup(process.kill)
        return process

    def wait_for_cells(self, process, out, count):
        deadline = time.monotonic() + 60
        while process.poll() is None and time.monotonic() < deadline:
            if len(list(out.glob("cells/[0-9a-f]*"))) >= count:
                return
            time.sleep(0.002)
        self.fail("the run ended before it could be interrupted: " + process.communicate()[1])

    def check_message(self, process, out, total):
        process_output = process.communicate(timeout=60)
        self.assertEqual(process.returncode, 3, process_output)
        names = [path.name for path in (out / "cells").iterdir()]
        self.assertFalse([name for name in names if name.startswith(".")], names)
        self.assertEqual(process_output[1].splitlines()[-1],
                         f"occlab: interrupted; {len(names)} of {total} cells are finished and "
                         "kept, the same command goes on from there")
        self.assertFalse((out / "run.json").exists())
        return len(names)

    def test_interrupted_ended_and_killed_runs_all_end_as_an_undisturbed_one(self):
        experiment = self.write("long.toml", LONG)
        disturbed, undisturbed = self.folder / "disturbed", self.folder / "undisturbed"
        kept = 0
        for number in (signal.SIGINT, signal.SIGTERM):
            process = self.start(experiment, disturbed)
            self.wait_for_cells(process, disturbed, kept + 3)
            process.send_signal(number)
            now = self.check_message(process, disturbed, LONG_CELLS)
            self.assertGreater(now, kept)
            self.assertLess(now, LONG_CELLS)
            kept = now
        process = self.start(experiment, disturbed)
        self.wait_for_cells(process, disturbed, kept + 3)
        process.kill()
        process.communicate()
        for left_over in (disturbed / "cells").glob(".tmp-*"):  # as if it were old
            os.utime(left_over, (0, 0))
        self.good("run", experiment, "--out", disturbed)
        self.good("run", experiment, "--out", undisturbed)

        names = sorted(path.name for path in (undisturbed / "cells").iterdir())
        self.assertEqual(len(names), LONG_CELLS)
        self.assertEqual(sorted(path.name for path in (disturbed / "cells").iterdir()), names)
        for name in names:
            self.assertEqual(exr_pixels(disturbed / "cells" / name / "layers.exr"),
                             exr_pixels(undisturbed / "cells" / name / "layers.exr"))
        for path in ("measurements.csv", "figures/errors.png"):
            self.assertEqual(*(hashlib.sha256((out / path).read_bytes()).hexdigest()
                               for out in (disturbed, undisturbed)))

    def test_during_the_timing_all_cells_are_kept(self):
        experiment = self.write("timed.toml", SMALL_EXPERIMENT + (
            '[timing]\nmethods = ["ssao", "s3ho"]\nsamples = 4\nbaseline = "ssao"\n'
            'repetitions = 100000\nbudget_seconds = 100.0\n'))
        out = self.folder / "results"
        process = self.start(experiment, out)
        for line in process.stderr:
            if line.startswith("timing: repetition 2"):
                break
        process.send_signal(signal.SIGINT)
        self.assertEqual(self.check_message(process, out, 5), 5)
        second = self.good("run", experiment, "--out", out, "--set", "timing.repetitions=3",
                           "--set", "timing.budget_seconds=0.1")
        self.assertIn("5 cells, 0 to render", second.stderr)
