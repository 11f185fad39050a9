"""No EGL, no place to write, a full disk: exit code 3, one line, nothing half-written."""

import ctypes
import os
import resource
import signal
import subprocess

from support import OCCLAB, SMALL_EXPERIMENT, CliTest, occlab, snapshot

NO_EGL = {"__EGL_VENDOR_LIBRARY_FILENAMES": "/nonexistent"}


class Device(CliTest):
    def test_no_egl(self):
        self.refused_render(3, ["EGL", "libegl-mesa0"], "--method", "ssao", env=NO_EGL)
        self.refused_run(3, ["EGL", "libegl-mesa0"], self.write("small.toml", SMALL_EXPERIMENT),
                         env=NO_EGL)
        self.refused(3, ["EGL", "libegl-mesa0"], "list", "devices", env=NO_EGL)

    def test_what_needs_no_device_works_without_one(self):
        self.good("list", "methods", env=NO_EGL)


class Unwritable(CliTest):
    """Below a regular file and in /proc not even root can write."""

    def test_render(self):
        plain = self.write("file", "")
        for path in (plain / "out.exr", self.folder / "none/out.exr", "/proc/out.exr"):
            with self.subTest(path):
                self.refused(3, [path, "cannot be written"], "render", "--scene", "three_boxes",
                             "--method", "ssao", "--resolution", "16", "16", "-o", path)

    def test_run(self):
        plain = self.write("file", "")
        experiment = self.write("small.toml", SMALL_EXPERIMENT)
        for path in (plain, plain / "results", "/proc/results"):
            with self.subTest(path):
                self.refused(3, [path, "cannot be created"], "run", experiment, "--out", path)


class Full(CliTest):
    def fails(self, folder, *arguments, **settings):
        finished = occlab(*arguments, **settings)
        self.assertEqual(finished.returncode, 3, finished.stderr)
        last = finished.stderr.splitlines()[-1]
        self.assertTrue(last.startswith("occlab: "), last)
        self.assertIn(str(folder), last)
        self.assertIn("cannot be written", last)
        return last

    @staticmethod
    def limit_file_size():
        """No file above 8 KiB: what a full disk does, at a place that the test chooses."""
        signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
        resource.setrlimit(resource.RLIMIT_FSIZE, (8192, 8192))

    def test_render(self):
        self.fails(self.folder, "render", "--scene", "three_boxes", "--method", "ssao",
                   "--resolution", "96", "54", "-o", self.folder / "out.exr",
                   preexec_fn=self.limit_file_size)
        self.assertEqual(snapshot(self.folder), {})

    def test_run_then_goes_on_with_space(self):
        experiment = self.write("small.toml", SMALL_EXPERIMENT)
        out = self.folder / "results"
        self.fails(out, "run", experiment, "--out", out, preexec_fn=self.limit_file_size)
        self.assertEqual(list((out / "cells").iterdir()), [])
        self.good("run", experiment, "--out", out)
        self.assertEqual(len(list((out / "cells").iterdir())), 5)

    def test_a_full_disk(self):
        libc = ctypes.CDLL(None, use_errno=True)
        disk = self.folder / "disk"
        disk.mkdir()
        size = b"size=256k"
        if libc.mount(b"tmpfs", os.fsencode(disk), b"tmpfs", 0, size) != 0:
            self.skipTest(f"no small file system to fill: {os.strerror(ctypes.get_errno())}")
        self.addCleanup(libc.umount2, os.fsencode(disk), 0)
        experiment = self.write("small.toml", SMALL_EXPERIMENT)
        finished = occlab("run", experiment, "--out", disk / "results", "--set", "run[0].seeds=8")
        self.assertEqual(finished.returncode, 3, finished.stderr)
        last = finished.stderr.splitlines()[-1]
        self.assertTrue(last.startswith(f"occlab: {disk}/results/cells/"), last)
        self.assertRegex(last, "the disk is full: [0-9]+ bytes are free|No space left on device")
        kept = list((disk / "results/cells").iterdir())
        self.assertGreater(len(kept), 0)
        for cell in kept:
            self.assertEqual(sorted(path.name for path in cell.iterdir()),
                             ["cell.json", "layers.exr"])

    def test_standard_output(self):
        with open("/dev/full", "wb") as full:
            finished = subprocess.run([OCCLAB, "list", "metrics"], stdout=full,
                                      stderr=subprocess.PIPE, text=True, check=False)
        self.assertEqual(finished.returncode, 3)
        self.assertRegex(finished.stderr, r"^occlab: standard output cannot be written: .+\n$")
