"""Whatever ends or disturbs a run, nothing is lost and nothing silently wrong: the same command ends
with what an undisturbed run has, bit for bit apart from times."""

import contextlib
import json
import os
import random
import resource
import shutil
import signal
import subprocess
import sys
import time

from support import OCCLAB, not_sanitized, occlab
from survival import TINY, Survival, undisturbed

KILLS = 200


class Killed(Survival):
    def test_200_kills_at_random_points(self):
        """Uniformly over the time of a whole run, so that every stage of it is met."""
        chance = random.Random(7)
        seconds = undisturbed(TINY)[1]
        longest = max(0.8, min(0.6 * seconds, 2.0))  # a slow machine gets further than its start
        kills, finished, folder = {}, 0, 0
        while sum(kills.values()) < KILLS:
            out = self.folder / f"out{folder}"
            process = self.start(out=out)
            number = chance.choice((signal.SIGKILL, signal.SIGTERM, signal.SIGINT))
            try:
                process.communicate(timeout=chance.uniform(0.05, longest))
            except subprocess.TimeoutExpired:
                process.send_signal(number)
                stderr = process.communicate(timeout=60)[1]
                if process.returncode != 0:  # else it was just done
                    self.assertIn(process.returncode, (-number, 3), stderr)
                    kills[number] = kills.get(number, 0) + 1
                    continue
            self.assertEqual(process.returncode, 0)
            self.is_whole(out)
            finished += 1
            folder += 1
        self.assertEqual(len(kills), 3)
        out = self.folder / f"out{folder}"
        self.good("run", self.experiment, "--out", out)
        self.is_whole(out)
        print(f"{KILLS} kills, {finished} runs finished in between; an undisturbed run takes "
              f"{seconds:.2f} s", file=sys.stderr)


class Machine(Survival):
    def test_a_disk_that_fills_up(self):
        """At any size: what is there is whole, and with space the same command finishes."""
        with contextlib.ExitStack() as stack:
            for kilobytes in (8, 64, 300, 700):
                with self.subTest(kilobytes):
                    disk = self.folder / f"disk{kilobytes}"
                    disk.mkdir()
                    mounted = subprocess.run(
                        ["mount", "-t", "tmpfs", "-o", f"size={kilobytes}k", "tmpfs", disk],
                        capture_output=True, text=True, check=False)
                    if mounted.returncode != 0:
                        self.skipTest(f"no small file system to fill: {mounted.stderr.strip()}")
                    stack.callback(subprocess.run, ["umount", disk], check=True)
                    self.out = disk / "out"
                    finished = occlab("run", self.experiment, "--out", self.out)
                    self.assertEqual(finished.returncode, 3, finished.stderr)
                    last = finished.stderr.splitlines()[-1]
                    self.assertRegex(last, f"^occlab: {disk}")
                    self.assertIn("cannot be written", last)
                    subprocess.run(["mount", "-o", "remount,size=64m", disk], check=True)
                    self.goes_on()

    def test_a_folder_that_cannot_be_written(self):
        """Bind-mounted read-only: root too is refused."""
        self.out.mkdir()
        mounted = subprocess.run(["mount", "--bind", self.out, self.out], capture_output=True,
                                 text=True, check=False)
        if mounted.returncode != 0:
            self.skipTest(f"no read-only folder: {mounted.stderr.strip()}")
        try:
            subprocess.run(["mount", "-o", "remount,ro,bind", self.out], check=True)
            self.refused(3, [self.out, "Read-only"], "run", self.experiment, "--out", self.out)
            self.refused(3, [self.out, "Read-only"], "run", self.experiment, "--out", self.out,
                         "--shard", "1/2")
        finally:
            subprocess.run(["umount", self.out], check=True)
        self.goes_on()

    @not_sanitized
    def test_out_of_file_handles(self):
        """From none to enough of them: finished, or said and gone on from."""
        failed = 0
        for most in range(4, 64, 4):
            with self.subTest(most):
                out = self.folder / f"out{most}"
                finished = occlab(
                    "run", self.experiment, "--out", out,
                    preexec_fn=lambda most=most: resource.setrlimit(resource.RLIMIT_NOFILE,
                                                                    (most, most)))
                if finished.returncode == 0:
                    self.is_whole(out)
                    break
                failed += 1
                self.assertEqual(finished.returncode, 3, finished.stderr)
                self.assertRegex(finished.stderr.splitlines()[-1], "^occlab: ")
                self.good("run", self.experiment, "--out", out)
                self.is_whole(out)
        else:
            self.fail("not even with 60 file handles")
        self.assertGreater(failed, 0)

    def test_a_clock_that_is_set_back(self):
        """By ten days in the middle of a run: what is there is from the future then."""
        process = self.start()
        self.wait_for_cells(process, 4)
        process.kill()
        process.communicate()
        kept = {cell.name: cell.stat().st_mtime_ns for cell in self.cells()}
        future = time.time() + 864000
        for path in [self.out, *self.out.rglob("*")]:
            os.utime(path, (future, future))
        self.goes_on()
        for name in kept:
            self.assertGreater((self.out / "cells" / name / "layers.exr").stat().st_mtime,
                               future - 10, "rendered again")
        status = json.loads(self.good("status", self.out, "--json").stdout)
        self.assertEqual(status["measuring"], "finished")
        again = self.good("run", self.experiment, "--out", self.out)
        self.assertIn("everything is done", again.stderr)

    @not_sanitized
    def test_a_clock_that_is_another(self):
        if not shutil.which("faketime"):
            self.skipTest("needs faketime")
        process = self.start()
        self.wait_for_cells(process, 3)
        process.kill()
        process.communicate()
        finished = subprocess.run(["faketime", "-m", "2019-12-24 20:30:00", OCCLAB, "run",
                                   self.experiment, "--out", self.out], capture_output=True,
                                  text=True, timeout=120, check=False,
                                  env={**os.environ, "FAKETIME_DONT_FAKE_MONOTONIC": "1"})
        self.assertEqual(finished.returncode, 0, finished.stderr)
        self.is_whole()


class Beside(Survival):
    def test_two_runs_and_two_shards_on_one_folder_at_once(self):
        processes = [self.start(), self.start(), self.start("--shard", "1/2"),
                     self.start("--shard", "2/2")]
        for process in processes:
            stderr = process.communicate(timeout=120)[1]
            self.assertEqual(process.returncode, 0, stderr)
        self.is_whole()
        self.assertFalse((self.out / "damaged").exists())
        self.assertEqual(list((self.out / "cells").glob(".tmp-*")), [])
        self.assertIn("everything is done", self.goes_on().stderr)

    def test_shards_in_any_order_and_twice(self):
        for shard in ("3/3", "1/3", "3/3", "2/3"):
            finished = self.good("run", self.experiment, "--out", self.out, "--shard", shard)
            self.assertEqual(finished.stdout, "")
            self.assertFalse((self.out / "measurements.csv").exists())
        whole = self.goes_on()
        self.assertRegex(whole.stderr, r"\d+ cells, 0 to render")
        self.good("run", self.experiment, "--out", self.out, "--shard", "2/3")
        self.assertIn("everything is done", self.goes_on().stderr)

    def test_bad_shards(self):
        for shard in ("0/3", "4/3", "1", "/", "1/0", "a/b", "1/3/4", "-1/3", "1/9999999"):
            with self.subTest(shard):
                self.refused_run(2, ["--shard", shard, "I/N"], self.experiment, f"--shard={shard}")
        self.refused_run(2, ["--fresh"], self.experiment, "--fresh", "--shard", "1/2")

    def test_what_another_process_is_at_is_left_to_it_until_it_dies(self):
        """The other one holds the lock of one cell, as occlab does while it renders it."""
        self.goes_on()
        report = json.loads((self.out / "run.json").read_text(encoding="utf-8"))
        # A part of the reference would not be missed once their mean is there.
        victim = next(cell for cell in report["cells"] if cell.get("method") == "ssao")
        shutil.rmtree(self.out / "cells" / victim["id"])
        (self.out / "measurements.csv").unlink()
        hold = ("import fcntl, struct, sys, time\n"
                "lock = struct.pack('hhqqi4x', fcntl.F_WRLCK, 0, int(sys.argv[2], 16), 1, 0)\n"
                "file = open(sys.argv[1], 'r+b')\n"
                "fcntl.fcntl(file, 37, lock)\n"  # F_OFD_SETLK
                "print('held', flush=True)\n"
                "time.sleep(600)\n")
        other = subprocess.Popen([sys.executable, "-c", hold, self.out / "locks",
                                  victim["hash"][:15]], stdout=subprocess.PIPE, text=True)
        self.addCleanup(other.communicate)
        self.addCleanup(other.kill)
        self.assertEqual(other.stdout.readline(), "held\n")
        process = self.start()
        with self.assertRaises(subprocess.TimeoutExpired):
            process.wait(timeout=2 + 2 * undisturbed(TINY)[1])
        self.assertFalse((self.out / "measurements.csv").exists())
        other.kill()
        stderr = process.communicate(timeout=60)[1]
        self.assertEqual(process.returncode, 0, stderr)
        self.is_whole()


class Damaged(Survival):
    def read_cells(self):
        """All but the reference's parts, which nobody reads again once their mean is there."""
        report = json.loads((self.out / "run.json").read_text(encoding="utf-8"))
        read = {cell["id"] for cell in report["cells"] if cell.get("method") != "rtdo"}
        read.add(report["reference"]["cell"])
        cells = [cell for cell in self.cells() if cell.name in read]
        self.assertEqual(len(cells), len(read))
        return cells

    def test_flipped_bits_are_found_wherever_they_are(self):
        """Any bit of any file of a cell: the cell is rendered again and this is said, or the bit
        means nothing and the numbers are the same. Never are other numbers measured."""
        self.goes_on()
        cells = self.read_cells()
        chance = random.Random(11)
        found = 0
        for _ in range(16):
            victim = chance.choice(cells)
            path = victim / chance.choice(("cell.json", "layers.exr"))
            data = bytearray(path.read_bytes())
            at = chance.randrange(len(data))
            data[at] ^= 1 << chance.randrange(8)
            path.write_bytes(data)
            (self.out / "measurements.csv").unlink()
            with self.subTest(file=path.name, at=at):
                finished = self.goes_on()
                if "damaged" in finished.stderr:
                    found += 1
                    self.assertIn(f"{victim}: damaged: ", finished.stderr)
                else:  # a space or a line end between two values
                    self.assertEqual(path.name, "cell.json")
        self.assertGreater(found, 8)

    def test_what_killed_writers_leave_is_removed(self):
        self.goes_on()
        (self.out / "measurements.csv").unlink()
        left = [self.out / name for name in ("tables/.noise.csv.77-3", "figures/.fig.77.png",
                                             ".measurements.csv.77", ".run.json.77-1")]
        mine = self.out / ".mine"
        for path in (*left, mine):
            path.parent.mkdir(exist_ok=True)
            path.write_text("half", encoding="utf-8")
        self.goes_on()
        self.assertEqual([path for path in left if path.exists()], [])
        self.assertTrue(mine.exists())
        self.is_whole()

    def test_cut_files(self):
        self.goes_on()
        chance = random.Random(12)
        for index, name in enumerate(("cell.json", "layers.exr", "cell.json", "layers.exr")):
            victim = self.read_cells()[3 * index]
            size = (victim / name).stat().st_size
            os.truncate(victim / name, chance.randrange(size))
            (self.out / "measurements.csv").unlink()
            with self.subTest(name):
                self.assertIn(f"{victim}: damaged: ", self.goes_on().stderr)
