"""RTDO against Blender's Cycles, small; and that a wrong light, distance or picture is found out.

    OCCLAB=build/release/occlab python3 tests/scenes/test_cycles.py

The planted errors come in through `--blender`: a script that changes what Blender is asked for, or
what it answers. Skipped where `blender` is not on PATH; OCCLAB_REQUIRE_BLENDER=1 makes its absence a
failure.
"""

import json
import os
import pathlib
import shutil
import subprocess
import sys
import tempfile
import unittest

sys.dont_write_bytecode = True
ROOT = pathlib.Path(__file__).resolve().parents[2]
OCCLAB = pathlib.Path(os.environ.get("OCCLAB", ROOT / "build/release/occlab")).resolve()
BLENDER = shutil.which("blender")

# Seeds of both renderers are fixed: this passes or fails the same way in every run.
SMALL = ("--scene", "three_boxes", "--probe", "sky_sun", "--prefilter", "8", "--resolution",
         "96", "64", "--samples", "256", "--rays-per-pixel", "4096")

# What stands between occlab and Blender. The last argument is the job (scenes/cycles.py).
BETWEEN = """#!{python}
import json, os, pathlib, subprocess, sys
path = pathlib.Path(sys.argv[-1])
job = json.loads(path.read_text())
folder = pathlib.Path(job["output"])
os.environ["PATH"] = {folder!r} + os.pathsep + os.environ["PATH"]  # Blender's own python3
def give(): path.write_text(json.dumps(job))
def ask():
    code = subprocess.run([{blender!r}, *sys.argv[1:]]).returncode
    if code: sys.exit(code)
{change}
"""


class Cycles(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory(prefix="occlab-cycles-test-")
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)
        if BLENDER:
            return
        if os.environ.get("OCCLAB_REQUIRE_BLENDER") == "1":
            self.fail("OCCLAB_REQUIRE_BLENDER=1 and blender is not on the PATH")
        self.skipTest("blender is not on the PATH")

    def verify(self, *arguments):
        return subprocess.run(
            [OCCLAB, "verify", "--only", "cycles", *SMALL, "--out", self.folder / "images", "--format",
             "json", *map(str, arguments)], capture_output=True, text=True, timeout=300,
            check=False)

    def with_change(self, change):
        """verify with a Blender whose job or answer is changed."""
        program = self.folder / "blender-between"
        program.write_text(BETWEEN.format(python=sys.executable, blender=BLENDER, change=change,
                                          folder=str(pathlib.Path(BLENDER).parent)))
        program.chmod(0o755)
        return self.verify("--blender", program)

    @staticmethod
    def rows(finished):
        table = json.loads(finished.stdout)
        names = [column["name"] for column in table["columns"]]
        return [dict(zip(names, row)) for row in table["rows"]]

    def failures(self, finished):
        """(quantity, case) of each check that fails."""
        self.assertEqual(finished.returncode, 1, finished.stderr)
        return [(row["quantity"], row["case"]) for row in self.rows(finished)
                if row["verdict"] == "FAILS"]

    def test_equal_within_half_a_percent_and_the_noise(self):
        finished = self.verify()
        self.assertEqual(finished.returncode, 0, finished.stdout + finished.stderr)
        rows = self.rows(finished)
        self.assertEqual(len(rows), 7)
        self.assertEqual({row["subject"] for row in rows}, {"cycles"})
        for name in ("cycles_light.exr", "cycles_ao.exr"):
            self.assertTrue((self.folder / "images" / "cycles" / name).is_file())

    def test_a_probe_turned_by_five_degrees_is_found_out(self):
        failed = self.failures(self.with_change(
            'job["light"]["rotation_degrees"] += 5; give(); ask()'))
        self.assertTrue(any("block" in quantity for quantity, _ in failed))
        self.assertFalse(any("k_A" in case for _, case in failed))

    def test_a_distance_of_a_tenth_more_is_found_out(self):
        failed = self.failures(self.with_change(
            'job["ao"]["distance"] *= 1.1; give(); ask()'))
        self.assertTrue(failed)
        self.assertTrue(all("k_A" in case for _, case in failed))

    def test_a_blender_that_fails(self):
        quick = "job['light']['samples'] = job['ao']['samples'] = 1; "
        for code, change, words in (
                (3, "print('no memory left'); sys.exit(3)", "no memory left"),
                (3, "sys.exit(0)", "without writing it"),
                (3, quick + "give(); ask(); (folder / 'light_2.exr').unlink()", "light_2.exr: Cycles wrote none"),
                (3, quick + "job['width'] = 95; give(); ask()", "95x64"),
                (2, "job['camera'] = 'gone'; give(); ask()", "'gone'")):
            with self.subTest(words=words):
                finished = self.with_change(change)
                self.assertEqual(finished.returncode, code, finished.stdout + finished.stderr)
                self.assertIn(words, finished.stderr)
                self.assertEqual(finished.stdout, "")

    def test_no_blender(self):
        finished = self.verify("--blender", "no-such-blender")
        self.assertEqual(finished.returncode, 2)
        self.assertIn("--blender no-such-blender", finished.stderr)


if __name__ == "__main__":
    unittest.main(verbosity=2)
