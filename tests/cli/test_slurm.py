"""--executor slurm on a real Slurm: submitted, killed in the middle, drained, refused."""

import json
import os
import pathlib
import signal
import subprocess
import time
import unittest

import slurm_cluster
from support import OCCLAB, SMALL_EXPERIMENT, CliTest, exr_pixels, measured, occlab

# Long enough to be met in its middle.
LONG = SMALL_EXPERIMENT.replace("[48, 27]", "[160, 90]").replace("seeds = 2", "seeds = 60")
# What a shell, sbatch's file name patterns and a batch script's directives would make something of.
HOSTILE = "it's \"a\" $(touch pwned) `touch pwned`; %a\n#SBATCH --nonsense\n"


def setUpModule():
    reason = slurm_cluster.why_not()
    if reason and os.environ.get("OCCLAB_REQUIRE_SLURM"):
        raise RuntimeError(f"OCCLAB_REQUIRE_SLURM is set, but: {reason}")
    if reason:
        raise unittest.SkipTest(reason)


class SlurmTest(CliTest):
    @classmethod
    def setUpClass(cls):
        cls.cluster = slurm_cluster.Cluster()
        cls.addClassCleanup(cls.cluster.stop)

    def setUp(self):
        super().setUp()
        self.addCleanup(self.cluster.run, "scancel", "--me")
        self.out = self.folder / "results"

    def occlab(self, *arguments, timeout=120, **settings):
        # One thread each, as two tasks run at a time.
        environment = {"LP_NUM_THREADS": "1", "OCCLAB_THREADS": "1", **self.cluster.environment}
        return occlab(*arguments, env=environment, timeout=timeout, **settings)

    def submit(self, experiment, *arguments, shards=3):
        return self.occlab("run", experiment, "--out", self.out, "--executor", "slurm",
                           "--slurm-shards", shards, *arguments)

    def finish(self, experiment, *arguments, shards=3):
        finished = self.submit(experiment, "--wait", *arguments, shards=shards)
        self.assertEqual(finished.returncode, 0, finished.stderr)
        return finished

    def status(self, out=None):
        finished = self.occlab("status", out or self.out, "--json")
        self.assertEqual(finished.returncode, 0, finished.stderr)
        return json.loads(finished.stdout)

    def states(self):
        return [shard["state"] for shard in self.status()["shards"]]

    def wait_for(self, what, condition, seconds=60):
        deadline = time.monotonic() + seconds
        while not condition():
            self.assertLess(time.monotonic(), deadline,
                            f"no {what}: {self.status()}\n{self.logs()}\n{self.cluster.queue()}")
            time.sleep(0.05)

    def cells(self, out=None):
        return sorted(path.name for path in ((out or self.out) / "cells").glob("[0-9a-f]*"))

    def logs(self):
        return "\n".join(path.read_text(errors="replace")
                         for path in sorted((self.out / "slurm").glob("*.log")))

    def equals_local_run(self, experiment, *arguments):
        local = self.folder / "local"
        self.good("run", experiment, "--out", local, *arguments)
        self.assertEqual(self.cells(), self.cells(local))
        for name in self.cells():
            # Not assertEqual, which would print both.
            self.assertTrue(exr_pixels(self.out / "cells" / name / "layers.exr") ==
                            exr_pixels(local / "cells" / name / "layers.exr"), name)
        self.assertEqual(measured(self.out / "measurements.csv"),
                         measured(local / "measurements.csv"))
        for table in sorted((local / "tables").iterdir()):
            if "time" not in table.name:
                self.assertEqual((self.out / "tables" / table.name).read_bytes(),
                                 table.read_bytes(), table.name)


class Submitted(SlurmTest):
    def test_all_tasks_finish_and_the_tables_are_those_of_a_local_run(self):
        """Under names that are hostile to a shell."""
        strange = self.folder / HOSTILE
        strange.mkdir()
        self.out = strange / "results"
        experiment = strange / "small.toml"
        experiment.write_text(SMALL_EXPERIMENT, encoding="utf-8")
        title = "experiment.title=\"It's $(touch pwned)\""
        finished = self.finish(experiment, "--set", title, "--slurm-partition", "main",
                               "--slurm-time", "5", "--slurm-option=--comment=a b'c\"$(touch pwned)")
        self.assertRegex(finished.stdout, r"^array job \d+: shards 1-3 of 3\njob \d+ measures")
        status = self.status()
        self.assertEqual((status["cells_done"], status["cells_planned"]), (5, 5))
        self.assertEqual(status["measuring"], "finished")
        self.assertEqual([shard["state"] for shard in status["shards"]], ["rendered"] * 3)
        self.assertEqual(sum(shard["cells_done"] for shard in status["shards"]), 5)
        self.assertEqual({shard["cells_done"] > 0 for shard in status["shards"]}, {True})
        self.assertIn("5 of 5 cells, 3 of 3 shards; measuring: finished",
                      self.occlab("status", self.out).stdout)
        self.equals_local_run(experiment, "--set", title)
        for folder in (pathlib.Path.cwd(), self.folder, strange, self.out):
            self.assertFalse((folder / "pwned").exists(), folder)

        again = self.submit(experiment, "--set", title)
        self.assertIn("everything is done", again.stderr)
        self.assertEqual(again.stdout, "")
        self.assertEqual(self.cluster.queue(), [])

    def test_a_file_of_settings(self):
        experiment = self.write("small.toml", SMALL_EXPERIMENT)
        settings = self.write("cluster.toml", '[slurm]\npartition = "main"\ntime = "5"\nshards = 2\n'
                              'at_once = 1\noptions = ["--nice=1"]\n')
        finished = self.occlab("run", experiment, "--out", self.out, "--executor", "slurm",
                               "--slurm", settings, "--wait")
        self.assertEqual(finished.returncode, 0, finished.stderr)
        self.assertRegex(finished.stdout, r"^array job \d+: shards 1-2%1 of 2\n")
        self.assertEqual(len(self.cells()), 5)


    def test_a_changed_experiment_begins_anew(self):
        """A shard that was done before is not done because of that."""
        self.finish(self.write("small.toml", SMALL_EXPERIMENT), shards=2)
        changed = self.write("small.toml", SMALL_EXPERIMENT.replace("seeds = 2", "seeds = 3"))
        # These tasks say nothing of themselves: what is there to read is of the other experiment.
        held = self.submit(changed, "--slurm-option=--hold", shards=2)
        self.assertEqual(held.returncode, 0, held.stderr)
        self.cluster.run("scancel", "--me")
        self.wait_for("end of the jobs", lambda: not self.cluster.queue())
        finished = self.finish(changed, shards=2)
        self.assertRegex(finished.stdout, r"^array job \d+: shards 1-2 of 2\n")
        self.assertEqual(self.states(), ["rendered"] * 2)
        self.equals_local_run(changed)


class Disturbed(SlurmTest):
    def test_killed_tasks_are_submitted_again_and_render_what_is_missing(self):
        experiment = self.write("long.toml", LONG)
        submitted = self.submit(experiment, shards=2)
        self.assertEqual(submitted.returncode, 0, submitted.stderr)
        array = submitted.stdout.split()[2].rstrip(":")
        logs = [self.out / f"progress/shard-{shard}-of-2.json" for shard in (1, 2)]
        self.wait_for("first shard", lambda: logs[0].exists() and self.cells())
        os.kill(json.loads(logs[0].read_text(encoding="utf-8"))["process"], signal.SIGKILL)
        self.wait_for("second shard", logs[1].exists)
        # Held until scancel comes, which may take as long as the rest of the work.
        os.kill(json.loads(logs[1].read_text(encoding="utf-8"))["process"], signal.SIGSTOP)
        self.cluster.run("scancel", "--signal=KILL", "--full", f"{array}_2")
        self.wait_for("end of the jobs", lambda: not self.cluster.queue())

        status = self.status()
        # scancel lets a task say a last word before it kills it; SIGKILL does not.
        states = [shard["state"] for shard in status["shards"]]
        self.assertEqual(states[0], "died")
        self.assertIn(states[1], ("interrupted", "died"))
        self.assertEqual(status["measuring"], "failed")
        self.assertRegex(status["message"], rf"{status['cells_done']} of 121 cells are rendered")
        kept = {name: (self.out / "cells" / name / "layers.exr").stat().st_mtime_ns
                for name in self.cells()}
        self.assertGreater(len(kept), 0)
        self.assertLess(len(kept), 121)

        self.finish(experiment, shards=2)
        for name, changed in kept.items():
            self.assertEqual((self.out / "cells" / name / "layers.exr").stat().st_mtime_ns, changed)
        self.equals_local_run(experiment)

        # One more is lost: its shard alone is submitted.
        victim = self.out / "cells" / self.cells()[7]
        victim.rename(self.folder / "lost")
        self.assertEqual(sorted(self.states()), ["incomplete", "rendered"])
        again = self.finish(experiment, shards=2)
        self.assertRegex(again.stdout, r"^array job \d+: shards [12] of 2\n")
        self.assertTrue(victim.is_dir())

    def test_a_drained_node_keeps_the_rest_waiting(self):
        experiment = self.write("long.toml", LONG)
        self.submit(experiment, "--slurm-at-once", "1", shards=4)
        self.wait_for("first cell", lambda: self.cells())
        drained = self.cluster.run("scontrol", "update", "NodeName=localhost", "State=DRAIN",
                                   "Reason=test")
        self.assertEqual(drained.returncode, 0, drained.stderr)
        self.addCleanup(self.cluster.run, "scontrol", "update", "NodeName=localhost",
                        "State=RESUME")
        self.wait_for("drained node", lambda: self.cluster.node_state() == "drained")
        states = self.states()
        self.assertIn("rendered", states)  # what ran was let finish
        self.assertIn("queued", states)
        text = self.occlab("status", self.out).stdout
        self.assertRegex(text, r"4/4 +queued +0 of \d+ .*\w")
        # The same command adds nothing to what waits.
        again = self.submit(experiment, "--slurm-at-once", "1", shards=4)
        self.assertEqual(again.returncode, 0, again.stderr)
        self.assertEqual(again.stdout, "")
        self.assertIn("in the queue already: shards ", again.stderr)
        self.cluster.run("scontrol", "update", "NodeName=localhost", "State=RESUME")
        self.finish(experiment, shards=4)
        self.equals_local_run(experiment)

    def test_interrupted_while_waiting_leaves_the_jobs_alone(self):
        experiment = self.write("small.toml", SMALL_EXPERIMENT)
        process = subprocess.Popen(
            [OCCLAB, "run", experiment, "--out", self.out, "--executor", "slurm",
             "--slurm-shards", "2", "--wait"], stdout=subprocess.PIPE, stderr=subprocess.PIPE,
            text=True, env={**os.environ, **self.cluster.environment})
        self.addCleanup(process.kill)
        self.assertRegex(process.stdout.readline(), r"^array job \d+: shards 1-2 of 2\n")
        self.assertRegex(process.stderr.readline(), r"^\d of \d cells, ")
        process.send_signal(signal.SIGINT)
        stderr = process.communicate(timeout=30)[1]
        self.assertEqual(process.returncode, 3)
        self.assertIn(f"the jobs go on; 'occlab status {self.out}'", stderr)
        self.wait_for("end of the run", lambda: self.status()["measuring"] == "finished")
        self.equals_local_run(experiment)


class Refused(SlurmTest):
    def refuses(self, code, words, *arguments, env=None):
        experiment = self.write("small.toml", SMALL_EXPERIMENT)
        finished = occlab("run", experiment, "--out", self.out, *arguments,
                          env={**self.cluster.environment, **(env or {})})
        self.assertEqual(finished.returncode, code, finished.stderr)
        self.assertEqual(len(finished.stderr.splitlines()), 1, finished.stderr)
        for word in ("occlab: ", *words):
            self.assertIn(word, finished.stderr)
        self.assertEqual(finished.stdout, "")
        self.assertEqual(self.cluster.queue(), [])

    def test_without_sbatch(self):
        self.refuses(3, ["no sbatch on the PATH"], "--executor", "slurm", env={"PATH": "/nowhere"})

    def test_an_unknown_partition(self):
        self.refuses(3, ["sbatch refuses", "invalid partition"], "--executor", "slurm",
                     "--slurm-partition", "nowhere")

    def test_too_long_a_time(self):
        self.refuses(3, ["sbatch refuses", "time limit"], "--executor", "slurm", "--slurm-time",
                     "5-0")

    def test_no_controller(self):
        configuration = (self.cluster.folder / "slurm.conf").read_text(encoding="utf-8")
        lines = [line for line in configuration.splitlines() if "SlurmctldPort" not in line]
        path = self.write("slurm.conf", "\n".join(
            [*lines, f"SlurmctldPort={slurm_cluster.free_port()}", "MessageTimeout=2\n"]))
        self.refuses(3, ["sbatch refuses"], "--executor", "slurm", env={"SLURM_CONF": str(path)})

    def test_bad_usage(self):
        for arguments in (("--fresh",), ("--shard", "1/2")):
            with self.subTest(arguments):
                self.refuses(2, [arguments[0], "--executor slurm"], "--executor", "slurm",
                             *arguments)
        self.refuses(2, ["need --executor slurm"], "--slurm-time", "5")
        self.refuses(2, ["'account=x' is no option of sbatch"], "--executor", "slurm",
                     "--slurm-option=account=x")


if __name__ == "__main__":
    unittest.main()
