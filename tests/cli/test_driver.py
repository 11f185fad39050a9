"""An OpenGL that hangs, is lost or refuses a shader: said, and nothing wrong is kept."""

import functools
import json
import pathlib
import subprocess
import time

from support import ROOT, not_sanitized, occlab, session_folder
from survival import Survival


@not_sanitized
class Driver(Survival):
    """A library in front of the driver makes it fail (broken_driver.c)."""

    @staticmethod
    @functools.cache
    def broken_driver():
        library = session_folder() / "broken_driver.so"
        subprocess.run(["gcc", "-shared", "-fPIC", "-O1", "-o", library,
                        ROOT / "tests/cli/broken_driver.c"], check=True)
        return library

    def broken(self, kind, *arguments, after, line=""):
        environment = {"LD_PRELOAD": str(self.broken_driver()), "BROKEN": kind,
                       "BROKEN_AFTER": str(after), "BROKEN_LINE": line}
        finished = occlab("run", self.experiment, "--out", self.out, *arguments, env=environment)
        self.assertEqual(finished.returncode, 3, finished.stderr)
        return finished.stderr

    def test_a_shader_that_hangs_ends_with_its_time(self):
        start = time.monotonic()
        stderr = self.broken("hang", "--cell-time-limit", "3", after=20)
        self.assertGreater(time.monotonic() - start, 3)
        self.assertRegex(stderr.splitlines()[-1],
                         r"^occlab: cell [0-9a-f]{16}, \w+ .*: not finished within 3 s "
                         r"\(--cell-time-limit\); finished cells are kept")
        self.assertGreater(len(self.cells()), 1)
        status = json.loads(self.good("status", self.out, "--json").stdout)
        self.assertEqual(status["measuring"], "failed")
        self.assertIn("not finished within 3 s", status["message"])
        self.goes_on("--cell-time-limit", "60")

    def test_a_lost_context_is_said_and_its_picture_not_kept(self):
        stderr = self.broken("lost", after=20)
        self.assertRegex(stderr.splitlines()[-1], "^occlab: the graphics context was lost in ")
        self.assertGreater(len(self.cells()), 1)
        self.assertLess(len(self.cells()), 13)
        self.goes_on()

    def test_a_shader_that_does_not_compile_names_the_original_line(self):
        """Of an included file as of a method's own."""
        for path, line in (("renderers/methods/s3ho_lighting.frag", "  Sh4 c = sh_unpack("),
                           ("renderers/shared/march.h", "SHARED vec3 march_point(")):
            text = (ROOT / path).read_text(encoding="utf-8").splitlines()
            number = 1 + next(i for i, one in enumerate(text) if one.startswith(line))
            with self.subTest(path):
                self.out = self.folder / pathlib.Path(path).name
                stderr = self.broken("shader", after=1, line=line)
                self.assertRegex(stderr, r"(?m)^occlab: renderers/\S+ does not compile:$")
                self.assertIn(f"{path}:{number}: error", stderr)
                self.goes_on()
