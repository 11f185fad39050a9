"""What tests of disturbed runs share: an experiment with every stage, and what a whole folder holds."""

import functools
import pathlib
import subprocess
import tempfile
import time

from support import OCCLAB, CliTest, exr_pixels, measured, occlab, session_folder

# All stages but timing: a reference of several parts, an error budget, figures.
TINY = """\
format = 1
[experiment]
name = "tiny"
title = "Tiny"
[scene]
source = "three_boxes"
resolution = [64, 36]
[probe]
source = "sky_sun"
[reference]
method = "rtdo"
rays_per_pixel = 4
max_rays_per_pixel = 64
[[run]]
methods = ["ssao", "s3ho", "ssdo", "ssbn"]
samples = 4
seeds = 3
[budget]
tolerance = 0.2
budget_seconds = 20.0
[[figure]]
name = "errors"
kind = "error_map"
methods = ["ssao", "s3ho"]
samples = 4
scale = 0.5
"""


def digest(out):
    """All that a finished folder holds but its times: pixels of every cell, numbers, figures."""
    cells = {}
    for cell in sorted((out / "cells").iterdir()):
        if not cell.name.startswith("."):  # what a killed writer left goes after a minute
            cells[cell.name] = exr_pixels(cell / "layers.exr")
    pictures = {path.name: path.read_bytes() for path in sorted((out / "figures").glob("*.png"))}
    tables = {path.name: path.read_bytes() for path in sorted((out / "tables").iterdir())
              if "time" not in path.name}
    return cells, measured(out / "measurements.csv"), pictures, tables


@functools.cache
def undisturbed(text):
    """(digest, seconds) of a run that nothing disturbs."""
    folder = pathlib.Path(tempfile.mkdtemp(dir=session_folder()))
    experiment = folder / "tiny.toml"
    experiment.write_text(text, encoding="utf-8")
    start = time.monotonic()
    finished = occlab("run", experiment, "--out", folder / "out")
    if finished.returncode != 0:
        raise AssertionError(finished.stderr)
    return digest(folder / "out"), time.monotonic() - start


class Survival(CliTest):
    def setUp(self):
        super().setUp()
        self.experiment = self.write("tiny.toml", TINY)
        self.out = self.folder / "out"

    def start(self, *arguments, out=None, **settings):
        process = subprocess.Popen(
            [OCCLAB, "run", self.experiment, "--out", out or self.out, *arguments],
            stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, **settings)
        self.addCleanup(process.communicate)
        self.addCleanup(process.kill)
        return process

    def is_whole(self, out=None, text=TINY):
        """As an undisturbed run: compared part by part, for a message that can be read."""
        names = ("cells", "measurements", "figures", "tables")
        for name, mine, whole in zip(names, digest(out or self.out), undisturbed(text)[0]):
            if isinstance(mine, dict):
                self.assertEqual(list(mine), list(whole), name)
                self.assertEqual([key for key in mine if mine[key] != whole[key]], [], name)
            else:
                self.assertEqual(mine, whole, name)

    def goes_on(self, *arguments, **settings):
        """The same command finishes and has everything."""
        finished = self.good("run", self.experiment, "--out", self.out, *arguments, **settings)
        self.is_whole()
        return finished

    def cells(self, out=None):
        return sorted((out or self.out).glob("cells/[0-9a-f]*"))

    def wait_for_cells(self, process, count):
        deadline = time.monotonic() + 60
        while len(self.cells()) < count:
            self.assertIsNone(process.poll(), "the run ended too early")
            self.assertLess(time.monotonic(), deadline)
            time.sleep(0.002)
