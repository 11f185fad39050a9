"""What `occlab run configs/smoke.toml` leaves: measurements, run.json, tables, figures."""

import csv
import hashlib
import json
import math
import os
import re
import shutil
import subprocess

from support import METHODS, ROOT, CliTest, decode_png, read_csv, smoke_results, varied_rows


def is_number(text):
    try:
        float(text)
    except ValueError:
        return False
    return True


class Measurements(CliTest):
    def test_every_cell_is_measured_in_both_stages(self):
        rows = read_csv(smoke_results() / "measurements.csv")
        single = {(row["method"], row["parameter.samples"], row["seed"], row["stage"])
                  for row in rows if row["metric"] == "rmse" and row["view"] == "main"
                  and row["seed"] != "all"}
        self.assertEqual(single, {(method, samples, seed, stage) for method in METHODS[1:]
                                  for samples in ("8", "4") for seed in ("0", "1")
                                  for stage in ("unfiltered", "filtered")})

    def test_values_are_numbers_or_say_why_not(self):
        rows = read_csv(smoke_results() / "measurements.csv")
        self.assertGreater(len(rows), 100)
        for row in rows:
            if row["value"]:
                float(row["value"])
                self.assertEqual(row["reason"], "")
            else:
                self.assertNotEqual(row["reason"], "", row)
            self.assertEqual(bool(row["lower"]), bool(row["upper"]))

    def test_every_number_traces_to_cells_that_are_there(self):
        cells = {path.name for path in (smoke_results() / "cells").iterdir()}
        for row in read_csv(smoke_results() / "measurements.csv"):
            if not row["metric"].startswith("time_"):
                self.assertTrue(row["cells"], row)
                self.assertLessEqual(set(re.findall(r"[0-9a-f]{16}", row["cells"])), cells)
                self.assertIn(row["reference_cell"], cells | {""})

    def test_spectra_add_up_to_the_noise(self):
        rows = read_csv(smoke_results() / "measurements.csv")
        spectra = {}
        for row in rows:
            if row["metric"].startswith("noise_spectrum."):
                self.assertEqual((row["seed"], row["n"]), ("all", "2"))
                key = (row["method"], row["parameter.samples"], row["stage"])
                spectra.setdefault(key, {})[float(row["metric"].split(".", 1)[1])] = row
        self.assertEqual(len(spectra), 2 * 2 * len(METHODS[1:]))
        width, height = 160, 90
        counts = {}
        for y in range(height):
            for x in range(width):
                radius = math.hypot(min(x, width - x) / width, min(y, height - y) / height)
                middle = (int(64 * radius) + 0.5) / 64
                counts[middle] = counts.get(middle, 0) + 1
        for key, bins in spectra.items():
            self.assertEqual(set(bins), set(counts))
            total = sum(float(bins[f]["value"]) * counts[f] for f in counts) / (width * height)
            noise = next(float(row["value"]) for row in rows if row["metric"] == "noise" and
                         (row["method"], row["parameter.samples"], row["stage"]) == key)
            # Of the luminance instead of the channels, which are nearly grey here.
            self.assertLess(abs(total / noise ** 2 - 1), 0.3, key)

    def test_times_name_their_clock(self):
        rows = [row for row in read_csv(smoke_results() / "measurements.csv")
                if row["metric"].startswith("time_ms.")]
        self.assertEqual({row["method"] for row in rows}, set(METHODS[1:]))
        for row in rows:
            self.assertTrue(row["clock"] and row["device"])
            self.assertGreater(float(row["value"]), 0.0)


class RunJson(CliTest):
    def test_it_holds_what_one_needs_to_repeat_the_run(self):
        report = json.loads((smoke_results() / "run.json").read_text(encoding="utf-8"))
        self.assertRegex(report["commit"], r"^[0-9a-f]{7,}|^unknown")
        self.assertTrue(report["device"]["renderer"] and report["device"]["driver"])
        self.assertIn("rays_per_pixel = 16", report["configuration"])
        self.assertEqual(report["seeds"], [{"methods": list(METHODS[1:]), "first": 0, "last": 1}])
        self.assertEqual(set(report["libraries"]) & {"embree", "openimageio"},
                         {"embree", "openimageio"})
        for part, path in (("scene", "scenes/three_boxes/three_boxes.glb"),
                           ("probe", "scenes/probes/sky_sun.exr")):
            self.assertEqual(report[part]["sha256"],
                             hashlib.sha256((ROOT / path).read_bytes()).hexdigest())
        self.assertEqual({cell["id"] for cell in report["cells"]},
                         {path.name for path in (smoke_results() / "cells").iterdir()})
        self.assertTrue(report["timing"]["clock"] and report["timing"]["stopped_because"])

    def test_it_vouches_for_the_measurements(self):
        report = json.loads((smoke_results() / "run.json").read_text(encoding="utf-8"))
        data = (smoke_results() / "measurements.csv").read_bytes()
        self.assertEqual(report["measurements_sha256"], hashlib.sha256(data).hexdigest())

    def test_cells_hold_the_checksum_of_their_pixels(self):
        for cell in (smoke_results() / "cells").iterdir():
            stored = json.loads((cell / "cell.json").read_text(encoding="utf-8"))
            data = (cell / "layers.exr").read_bytes()
            self.assertEqual(stored["layers.exr"]["sha256"], hashlib.sha256(data).hexdigest())
            self.assertEqual(stored["key"][:16], cell.name)


class Tables(CliTest):
    def test_all_four_formats_of_each(self):
        folder = smoke_results() / "tables"
        stems = {path.stem for path in folder.iterdir()}
        self.assertGreaterEqual(len(stems), 5)
        self.assertEqual({path.name for path in folder.iterdir()},
                         {stem + end for stem in stems for end in (".md", ".csv", ".json", ".tex")})

    def test_json_tables_are_rectangular(self):
        for path in (smoke_results() / "tables").glob("*.json"):
            table = json.loads(path.read_text(encoding="utf-8"))
            self.assertTrue(table["rows"], path)
            for row in table["rows"]:
                self.assertEqual(len(row), len(table["columns"]))

    def test_csv_tables_are_rectangular_and_hold_the_numbers_of_json(self):
        for path in (smoke_results() / "tables").glob("*.csv"):
            with open(path, newline="", encoding="utf-8") as stream:
                header, *rows = list(csv.reader(stream, strict=True))
            table = json.loads(path.with_suffix(".json").read_text(encoding="utf-8"))
            self.assertEqual(len(rows), len(table["rows"]), path)
            self.assertEqual(len(set(header)), len(header), path)
            for row, cells in zip(rows, table["rows"]):
                self.assertEqual(len(row), len(header), path)
                numbers = [cell[key] for cell in cells if isinstance(cell, dict)
                           for key in ("value", "lower", "upper") if key in cell]
                self.assertLessEqual({float(number) for number in numbers},
                                     {float(field) for field in row if is_number(field)}, path)

    def test_latex_is_well_formed(self):
        for path in (smoke_results() / "tables").glob("*.tex"):
            text = re.sub(r"\\[{}\\%&$#_]", "", path.read_text(encoding="utf-8"))
            depth = 0
            for character in text:
                depth += {"{": 1, "}": -1}.get(character, 0)
                self.assertGreaterEqual(depth, 0, path)
            self.assertEqual(depth, 0, path)
            for rule in ("toprule", "midrule", "bottomrule"):
                self.assertEqual(text.count("\\" + rule), 1, path)
            begun = re.findall(r"\\begin\{(\w+)", text)
            self.assertEqual(sorted(begun), sorted(re.findall(r"\\end\{(\w+)", text)))

    def test_latex_compiles(self):
        if not shutil.which("pdflatex"):
            if os.environ.get("OCCLAB_REQUIRE_LATEX"):
                self.fail("pdflatex is not installed")
            self.skipTest("pdflatex is not installed")
        inputs = "".join(f"\\input{{{path}}}\\clearpage\n"
                         for path in sorted((smoke_results() / "tables").glob("*.tex")))
        source = self.write("all.tex", "\\documentclass{article}\\usepackage{booktabs,graphicx}"
                            f"\\begin{{document}}{inputs}\\end{{document}}")
        made = subprocess.run(["pdflatex", "-interaction=nonstopmode", "-halt-on-error", source],
                              cwd=self.folder, capture_output=True, text=True, check=False)
        self.assertEqual(made.returncode, 0, made.stdout[-2000:])


class Figures(CliTest):
    def test_each_is_a_picture(self):
        folder = smoke_results() / "figures"
        pictures = {"comparison.png", "closeups.png", "errors.png", "budget.png", "failures.png"}
        self.assertEqual({path.name for path in folder.iterdir()}, pictures | {"budget.exr"})
        for path in folder.glob("*.png"):
            with self.subTest(path.name):
                width, height, channels, _ = decode_png(path)
                self.assertEqual(channels, 3)
                self.assertGreater(width, 2 * 160)
                self.assertGreater(height, 90)
                self.assertGreater(varied_rows(path), height // 3)
