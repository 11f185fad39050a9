"""What the tests of the command line share: starting occlab as a user does, and small inputs."""

import atexit
import csv
import functools
import itertools
import os
import pathlib
import shutil
import struct
import subprocess
import sys
import tempfile
import unittest
import zlib

sys.dont_write_bytecode = True
ROOT = pathlib.Path(__file__).resolve().parents[2]
OCCLAB = pathlib.Path(os.environ.get("OCCLAB", ROOT / "build/release/occlab")).resolve()
# What a sanitizer's own library does not bear: another one before it, a process without files, and a
# look at its memory, of which it keeps what was given back.
SANITIZED = bool(os.environ.get("OCCLAB_SANITIZE"))
not_sanitized = unittest.skipIf(SANITIZED, "not with a sanitizer")
sys.path.insert(0, str(ROOT / "scenes"))
import exr  # noqa: E402
import glb  # noqa: E402

METHODS = ("rtdo", "ssao", "s3ho", "ssdo", "ssbn")
THREE_BOXES = ROOT / "scenes/three_boxes/three_boxes.glb"

# No times: all its numbers are the same in every run.
SMALL_EXPERIMENT = """\
format = 1
[experiment]
name = "small"
title = "Small"
[scene]
source = "three_boxes"
resolution = [48, 27]
[probe]
source = "sky_sun"
[reference]
method = "rtdo"
rays_per_pixel = 4
[[run]]
methods = ["ssao", "s3ho"]
samples = 4
seeds = 2
[[figure]]
name = "errors"
kind = "error_map"
methods = ["ssao", "s3ho"]
samples = 4
scale = 0.5
"""


def occlab(*arguments, timeout=120, cwd=None, env=None, **settings):
    """Runs occlab; `env` is added to the environment. With a sanitizer it may take longer."""
    return subprocess.run(
        [OCCLAB, *map(str, arguments)], capture_output=True, text=True, cwd=cwd,
        timeout=timeout * (5 if SANITIZED else 1), check=False,
        env={**os.environ, **(env or {})}, **settings)


def snapshot(folder):
    """Every file and folder below with its content's checksum and time of change."""
    found = {}
    for path in sorted(pathlib.Path(folder).rglob("*")):
        content = zlib.crc32(path.read_bytes()) if path.is_file() else None
        found[str(path.relative_to(folder))] = (content, path.stat().st_mtime_ns)
    return found


def read_csv(path):
    with open(path, newline="", encoding="utf-8") as stream:
        return list(csv.DictReader(stream))


def measured(path):
    """The rows of measurements.csv that are not times: all of them repeat exactly."""
    return [row for row in read_csv(path) if not row["metric"].startswith("time_")]


def exr_pixels(path):
    """Everything in a single-part scan-line EXR but its dates, metadata and file offsets."""
    data = pathlib.Path(path).read_bytes()
    magic, version = struct.unpack_from("<ii", data)
    if magic != exr.MAGIC or version & 0xFF != 2:
        raise ValueError(f"{path}: not a single-part scan-line OpenEXR file")
    attributes, at = {}, 8
    while data[at]:
        end = data.index(b"\0", at)
        name = data[at:end].decode()
        at = data.index(b"\0", end + 1) + 1
        size = struct.unpack_from("<i", data, at)[0]
        attributes[name] = data[at + 4:at + 4 + size]
        at += 4 + size
    first = struct.unpack_from("<Q", data, at + 1)[0]
    return attributes["channels"], attributes["dataWindow"], data[first:]


def decode_png(path):
    """(width, height, channels, bytes of all rows) of an 8-bit PNG without interlacing."""
    data = pathlib.Path(path).read_bytes()
    if data[:8] != b"\x89PNG\r\n\x1a\n":
        raise ValueError(f"{path}: not a PNG")
    packed, at, kind = b"", 8, b""
    while kind != b"IEND":
        size, kind = struct.unpack_from(">I4s", data, at)
        body = data[at + 8:at + 8 + size]
        if zlib.crc32(kind + body) != struct.unpack_from(">I", data, at + 8 + size)[0]:
            raise ValueError(f"{path}: chunk {kind} has a wrong checksum")
        if kind == b"IHDR":
            width, height, depth, colour, _, _, interlaced = struct.unpack(">IIBBBBB", body)
            channels = {0: 1, 2: 3, 6: 4}[colour]
            if depth != 8 or interlaced:
                raise ValueError(f"{path}: not 8 bits without interlacing")
        elif kind == b"IDAT":
            packed += body
        at += 12 + size
    raw = zlib.decompress(packed)
    stride = width * channels
    if len(raw) != height * (stride + 1):
        raise ValueError(f"{path}: {len(raw)} bytes of pixels")
    return width, height, channels, raw


def varied_rows(path):
    """How many different rows a PNG has, filter bytes included: 1 or 2 in an empty picture."""
    width, height, channels, raw = decode_png(path)
    stride = width * channels + 1
    return len({raw[y * stride:(y + 1) * stride] for y in range(height)})


def scene_with(path, change):
    """Writes three_boxes to `path` after change(document, blob as a bytearray)."""
    document, blob = glb.parse(THREE_BOXES.read_bytes())
    blob = bytearray(blob)
    change(document, blob)
    path.write_bytes(glb.unparse(document, bytes(blob)))
    return path


def probe_with(path, value, size=(16, 8)):
    """Writes a grey probe with one texel of `value`."""
    width, height = size
    rows = [[(0.5, 0.5, 0.5)] * width for _ in range(height)]
    if rows and rows[0]:
        rows[height // 2][width // 3] = (value, 0.5, 0.5)
    path.write_bytes(exr.encode(width, height, rows))
    return path


@functools.cache
def session_folder():
    folder = pathlib.Path(tempfile.mkdtemp(prefix="occlab-cli-"))
    atexit.register(shutil.rmtree, folder, ignore_errors=True)
    return folder


@functools.cache
def smoke_results():
    """A finished run of configs/smoke.toml. For reading only: all tests share it."""
    folder = session_folder() / "smoke"
    finished = occlab("run", ROOT / "configs/smoke.toml", "--out", folder)
    if finished.returncode != 0:
        raise AssertionError(finished.stderr)
    return folder


@functools.cache
def rendered(method):
    """A small EXR of a method. For reading only."""
    path = session_folder() / f"{method}.exr"
    finished = occlab("render", "--scene", "three_boxes", "--probe", "sky_sun", "--resolution",
                      "96", "54", "--method", method, "-o", path,
                      *(("--set", "rays_per_pixel=4") if method == "rtdo" else ()))
    if finished.returncode != 0:
        raise AssertionError(finished.stderr)
    return path


class CliTest(unittest.TestCase):
    """Each test has a fresh folder of its own."""

    def setUp(self):
        folder = tempfile.TemporaryDirectory(prefix="occlab-cli-")
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)

    def write(self, name, text):
        path = self.folder / name
        path.write_text(text, encoding="utf-8")
        return path

    def good(self, *arguments, **settings):
        finished = occlab(*arguments, **settings)
        self.assertEqual(finished.returncode, 0, finished.stderr)
        return finished

    def refused(self, code, words, *arguments, **settings):
        """The exit code; one line of error that has all `words`; nothing printed, nothing left."""
        before = snapshot(self.folder)
        finished = occlab(*arguments, **settings)
        self.assertEqual(finished.returncode, code, finished.stderr)
        lines = finished.stderr.splitlines()
        self.assertEqual(len(lines), 1, finished.stderr)
        self.assertTrue(lines[0].startswith("occlab: "), lines[0])
        for word in words:
            self.assertIn(str(word), lines[0])
        self.assertEqual(finished.stdout, "")
        self.assertEqual(snapshot(self.folder), before)

    def refused_render(self, code, words, *arguments, **settings):
        self.refused(code, words, "render", "--scene", "three_boxes", "--resolution", "16", "16",
                     *arguments, "-o", self.folder / "out.exr", **settings)

    def refused_run(self, code, words, *arguments, **settings):
        self.refused(code, words, "run", *arguments, "--out", self.folder / "results", **settings)


def interleave(flag, values):
    return list(itertools.chain.from_iterable((flag, value) for value in values))
