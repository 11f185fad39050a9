"""The page of a project's history, in headless Chromium over file://.

    OCCLAB=build/release/occlab OCCLAB_NODE_MODULES=build/release/report_page/node_modules \\
        python3 -m unittest test_history

The histories are made up (history_data.mjs), one of them of 2,000 runs with 500 series. Skipped where
Chromium is not installed; OCCLAB_REQUIRE_CHROMIUM=1 makes its absence a failure. Screenshots at three
widths, bright and dark, and a print stay in $OCCLAB_SCREENSHOTS.
"""

import json
import os
import pathlib
import shutil
import subprocess
import sys
import unittest

sys.dont_write_bytecode = True
HERE = pathlib.Path(__file__).resolve().parent
sys.path.insert(0, str(HERE.parent / "cli"))
from support import CliTest  # noqa: E402

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


if __name__ == "__main__":
    unittest.main()
