"""The page of a project's history, in headless Chromium over file://.

    OCCLAB=build/release/occlab OCCLAB_NODE_MODULES=build/release/report_page/node_modules \\
        python3 -m unittest test_history

The histories of most checks are made up (history_data.mjs), one of them of 2,000 runs with 500
series; that of the last is stored and reported by occlab, with a step that is planted. Skipped where
Chromium is not installed; OCCLAB_REQUIRE_CHROMIUM=1 makes its absence a failure. Screenshots at three
widths, bright and dark, and a print stay in $OCCLAB_SCREENSHOTS.
"""

import csv
import hashlib
import json
import os
import pathlib
import random
import shutil
import subprocess
import sys
import unittest

sys.dont_write_bytecode = True
HERE = pathlib.Path(__file__).resolve().parent
sys.path.insert(0, str(HERE.parent / "cli"))
from support import OCCLAB, CliTest, smoke_results  # noqa: E402

CHROMIUM = shutil.which("chromium") or shutil.which("chromium-browser")
MODULES = os.environ.get("OCCLAB_NODE_MODULES", "")


class HistoryPage(CliTest):
    def checks(self, script, tasks):
        """Runs a script of checks; each of its lines is a subtest."""
        out = pathlib.Path(os.environ.get("OCCLAB_SCREENSHOTS") or self.folder)
        out.mkdir(parents=True, exist_ok=True)
        tasks = {"chromium": CHROMIUM, "modules": MODULES, "out": str(out),
                 "folder": str(self.folder), "dist": str(pathlib.Path(MODULES).parent / "dist"),
                 **tasks}
        finished = subprocess.run(
            ["node", HERE / script, self.write("tasks.json", json.dumps(tasks))],
            capture_output=True, text=True, timeout=600, check=False)
        print(finished.stderr, file=sys.stderr)
        self.assertEqual(finished.returncode, 0, finished.stderr)
        checks = [json.loads(line) for line in finished.stdout.splitlines()]
        for check in checks:
            with self.subTest(check["name"]):
                self.assertEqual(check["problem"], "")
        return len(checks)

    def setUp(self):
        super().setUp()
        if not CHROMIUM:
            if os.environ.get("OCCLAB_REQUIRE_CHROMIUM"):
                self.fail("chromium is not installed")
            self.skipTest("chromium is not installed")

    def test_page(self):
        self.assertGreater(self.checks("history_checks.mjs", {}), 12)

    def run_of(self, number, factor):
        """A copy of the smoke test's run whose errors vary a little; S3HO's RMSE is times factor."""
        folder = self.folder / "run"
        shutil.rmtree(folder, ignore_errors=True)
        shutil.copytree(smoke_results(), folder, ignore=shutil.ignore_patterns("report"))
        path = folder / "measurements.csv"
        with open(path, newline="", encoding="utf-8") as stream:
            header, *rows = list(csv.reader(stream))
        at = {name: header.index(name) for name in header}
        noise = random.Random(number)
        for row in rows:
            if row[at["metric"]] != "rmse":
                continue
            times = 1 + 0.001 * noise.uniform(-1, 1)
            if row[at["method"]] == "s3ho" and row[at["stage"]] == "filtered":
                times *= factor
            for name in ("value", "lower", "upper"):
                if row[at[name]]:
                    row[at[name]] = repr(times * float(row[at[name]]))
        with open(path, "w", newline="", encoding="utf-8") as stream:
            csv.writer(stream, lineterminator="\n").writerows([header, *rows])
        run = json.loads((folder / "run.json").read_text(encoding="utf-8"))
        run["measurements_sha256"] = hashlib.sha256(path.read_bytes()).hexdigest()
        (folder / "run.json").write_text(json.dumps(run), encoding="utf-8")
        return folder

    def test_real_history(self):
        commits = [hashlib.sha1(str(i).encode()).hexdigest() for i in range(20)]
        database, page = self.folder / "h.sqlite", self.folder / "page"
        for i, commit in enumerate(commits):
            self.good("history", "add", self.run_of(i, 1.2 if i >= 12 else 1.0), "--db", database,
                      "--commit", commit, "--subject", f"Change <b>{i}</b>",
                      "--commit-time", f"2026-01-{i + 1:02d}T12:00:00Z",
                      *(() if i in (11, 12, 19) else ("--no-images",)))
        report = ("history", "report", "--db", database, "-o", page, "--project", "Real & small")
        self.good(*report)
        tasks = {"index": str(page / "index.html"), "commits": commits, "step": 12,
                 "command": str(self.folder / "command")}
        self.checks("history_real.mjs", {**tasks, "intended": ""})
        # What the page gives to copy is what a shell runs.
        tools = self.folder / "tools"
        tools.mkdir()
        (tools / "occlab").symlink_to(OCCLAB)
        command = (self.folder / "command").read_text(encoding="utf-8")
        environment = {**os.environ, "PATH": f"{tools}{os.pathsep}{os.environ['PATH']}"}
        finished = subprocess.run(["bash", "-c", command], env=environment, capture_output=True,
                                  text=True, timeout=60, check=False)
        self.assertEqual(finished.returncode, 0, finished.stderr)
        self.good(*report)
        self.checks("history_real.mjs", {**tasks, "intended": "it's $(meant)"})


if __name__ == "__main__":
    unittest.main()
