"""The report of a real run, in headless Chromium over file://.

    OCCLAB=build/release/occlab OCCLAB_NODE_MODULES=build/release/report_page/node_modules \\
        python3 -m unittest test_report

Skipped where Chromium is not installed; OCCLAB_REQUIRE_CHROMIUM=1 makes its absence a failure.
Screenshots at three widths, bright and dark, and a print stay in $OCCLAB_SCREENSHOTS.
"""

import json
import math
import os
import pathlib
import re
import shutil
import subprocess
import sys
import unittest

sys.dont_write_bytecode = True
HERE = pathlib.Path(__file__).resolve().parent
sys.path.insert(0, str(HERE.parent / "cli"))
import exr_layers  # noqa: E402
from support import CliTest, occlab, session_folder, smoke_results  # noqa: E402

CHROMIUM = shutil.which("chromium") or shutil.which("chromium-browser")
MODULES = os.environ.get("OCCLAB_NODE_MODULES", "")
HOSTILE = "<img src=x onerror=\"window.hacked = 1\"></script><script>window.hacked = 1</script> & \u2028 'x'"
IMAGES = ("rtdo", "ssao", "s3ho", "ssdo", "ssbn")  # as the page shows them, of 8 samples


def report(folder):
    finished = occlab("report", folder)
    if finished.returncode != 0:
        raise AssertionError(finished.stderr)
    return str(folder / "report/index.html")


def page_data(index):
    text = pathlib.Path(index).read_text(encoding="utf-8")
    return json.loads(re.search(r'id="occlab-data"[^>]*>(.*?)</script>', text, re.DOTALL).group(1))


def copy_of_smoke(name):
    folder = session_folder() / name
    shutil.copytree(smoke_results(), folder, ignore=shutil.ignore_patterns("report"))
    return folder


def channels(layers, name, x, y, ends="RGB"):
    return [layers[f"{name}.{end}"][y][x] for end in ends]


def srgb(linear):
    value = min(max(linear, 0.0), 1.0)
    return round(255 * (12.92 * value if value <= 0.0031308 else 1.055 * value ** (1 / 2.4) - 0.055))


class Smoke:
    """What the smoke test's page must show."""

    def __init__(self):
        self.index = report(smoke_results())
        self.data = page_data(self.index)
        self.run = json.loads((smoke_results() / "run.json").read_text(encoding="utf-8"))
        self.layers = [exr_layers.read(smoke_results() / "cells" / self.cell(method) / "layers.exr")
                       for method in IMAGES]

    def cell(self, method):
        if method == "rtdo":
            return self.run["reference"]["cell"]
        return next(cell["id"] for cell in self.run["cells"] if cell.get("method") == method
                    and "samples=8 seed=0 " in cell["parameters"])

    def layer_id(self, method):
        return next(layer["id"] for layer in self.data["layers"]
                    if layer["name"] == "radiance" and layer["cell"] == self.cell(method))

    def pixel(self, x, y):
        return {"x": x, "y": y, "layers": {
            self.layer_id(method): [exr_layers.half(v) for v in channels(layers, "radiance", x, y)]
            for method, layers in zip(IMAGES, self.layers)}}

    def on_canvas(self, active, x, y):
        mask = self.layers[0]["mask.V"][y][x] > 0.5
        exposure = self.data["frame"]["exposure"]
        shown = [srgb(exposure * value) if mask else 128
                 for value in channels(self.layers[active], "radiance", x, y)]
        return {"active": active, "x": x, "y": y, "shown": shown}

    def lobe(self, x, y):
        coefficients = [self.layers[2][f"sh_visibility.c{i}"][y][x] for i in range(16)]
        length = math.dist(channels(self.layers[4], "bent_normal", x, y), (0, 0, 0))
        cosine = min(max(2 * length - 1, 0), 1)
        return {"x": x, "y": y, "angle": 90 * (1 - cosine),
                "irradiance": [sum(a * b for a, b in zip(light, coefficients))
                               for light in self.data["light"]["sh"]]}

    def task(self):
        places = ((3, 2), (80, 45), (156, 87), (20, 70), (130, 10), (72, 60))
        return {"index": self.index, "title": self.run["title"], "width": 160, "height": 90,
                "tables": len(list((smoke_results() / "tables").glob("*.json"))), "groups": 8,
                "cells": [cell["id"] for cell in self.run["cells"]],
                "zeroSigned": [0xF7, 0xF7, 0xF7], "zeroAngle": [0x44, 0x01, 0x54],
                "pixels": [self.pixel(x, y) for x, y in places],
                "canvas": [self.on_canvas(i, x, y) for i, (x, y) in enumerate(places[:5])],
                "lobe": self.lobe(72, 60)}


def damaged_runs(smoke):
    """Copies of the run with something wrong, and what their pages must say."""
    tasks = []

    def add(name, change, texts, panels=5, after=lambda folder: None):
        folder = copy_of_smoke(name)
        change(folder)
        index = report(folder)
        after(folder)
        tasks.append({"index": index, "texts": texts, "panels": panels})

    def flip_byte(path):
        data = bytearray(path.read_bytes())
        data[len(data) // 2] ^= 0xFF
        path.write_bytes(data)

    ssdo = smoke.cell("ssdo")
    add("damaged", lambda folder: flip_byte(folder / "cells" / ssdo / "layers.exr"),
        ["incomplete", "1 of", "layers.exr is damaged"])
    add("missing", lambda folder: shutil.rmtree(folder / "cells" / smoke.cell("ssbn")),
        ["incomplete", "seed 0: missing"])
    add("unfinished", lambda folder: (folder / "run.json").unlink(),
        ["incomplete", "run.json is missing: the run has not finished"])
    layer = smoke.layer_id("s3ho")
    add("data-missing", lambda folder: None, ["not shown: its file is missing"],
        after=lambda folder: (folder / f"report/data/{layer}.js").unlink())
    add("data-damaged", lambda folder: None, ["not shown: its file is damaged"],
        after=lambda folder: flip_byte(folder / f"report/data/{layer}.js"))
    return tasks


def hostile_run():
    folder = copy_of_smoke("hostile")
    path = folder / "run.json"
    run = json.loads(path.read_text(encoding="utf-8"))
    run["title"], run["warnings"], run["commit"] = HOSTILE, [HOSTILE], HOSTILE
    path.write_text(json.dumps(run), encoding="utf-8")
    return {"index": report(folder), "text": HOSTILE}


class Page(CliTest):
    def test_page(self):
        if not CHROMIUM:
            if os.environ.get("OCCLAB_REQUIRE_CHROMIUM"):
                self.fail("chromium is not installed")
            self.skipTest("chromium is not installed")
        out = pathlib.Path(os.environ.get("OCCLAB_SCREENSHOTS") or self.folder)
        out.mkdir(parents=True, exist_ok=True)
        smoke = Smoke()
        tasks = {"chromium": CHROMIUM, "modules": MODULES, "out": str(out), "smoke": smoke.task(),
                 "broken": damaged_runs(smoke), "hostile": hostile_run()}
        finished = subprocess.run(
            ["node", HERE / "page_checks.mjs", self.write("tasks.json", json.dumps(tasks))],
            capture_output=True, text=True, timeout=600, check=False)
        print(finished.stderr, file=sys.stderr)
        self.assertEqual(finished.returncode, 0, finished.stderr)
        checks = [json.loads(line) for line in finished.stdout.splitlines()]
        self.assertGreater(len(checks), 12)
        for check in checks:
            with self.subTest(check["name"]):
                self.assertEqual(check["problem"], "")


if __name__ == "__main__":
    unittest.main()
