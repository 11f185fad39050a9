"""The stored golden values are those that their script makes."""

import shutil
import subprocess
import sys
import unittest
from pathlib import Path

SCRIPT = Path(__file__).resolve().parents[1] / "golden" / "make_golden.py"


def python_with_numpy():
    """The first Python that has NumPy, or None."""
    for python in (sys.executable, shutil.which("python3"), "/usr/bin/python3"):
        if python and Path(python).exists():
            found = subprocess.run([python, "-c", "import numpy"], capture_output=True, timeout=60)
            if found.returncode == 0:
                return python
    return None


class GoldenValues(unittest.TestCase):
    def test_are_what_the_script_makes(self):
        python = python_with_numpy()
        if python is None:
            self.skipTest("no Python with NumPy")
        done = subprocess.run([python, str(SCRIPT), "--check"], capture_output=True, text=True,
                              timeout=300)
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)


if __name__ == "__main__":
    unittest.main()
