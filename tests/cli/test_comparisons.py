"""Winners and comparisons from end to end: what few and what different seeds can tell."""

import json
import re

from support import CliTest, read_csv

HEAD = """format = 1
[experiment]
name = "seeds"
title = "Seeds"
[scene]
source = "three_boxes"
resolution = [64, 36]
[probe]
source = "sky_sun"
[parameters]
samples = 4
[reference]
method = "rtdo"
rays_per_pixel = 16
"""


def run_table(methods, seeds):
    return f"[[run]]\nmethods = {json.dumps(methods)}\nseeds = {seeds}\n"


class Winners(CliTest):
    def test_every_format_marks_the_same_numbers(self):
        path = self.write("six.toml", HEAD + run_table(["ssao", "ssdo"], 6))
        out = self.folder / "six"
        self.good("run", path, "--out", out)
        marked = 0
        for stem in ("accuracy_unfiltered", "accuracy_filtered", "noise_unfiltered"):
            table = json.loads((out / "tables" / f"{stem}.json").read_text(encoding="utf-8"))
            names = [column["name"] for column in table["columns"]]
            winners = {(row[names.index("method")], name) for row in table["rows"]
                       for name, cell in zip(names, row)
                       if isinstance(cell, dict) and cell.get("winner")}
            marked += len(winners)
            in_csv = {(row["method"], re.sub(r" \(.*", "", key))
                      for row in read_csv(out / "tables" / f"{stem}.csv")
                      for key, value in row.items() if key.endswith(" winner") and value == "yes"}
            self.assertEqual(in_csv, winners)
            for end, mark in (("md", r"\*\*[^*]+\*\* \["), ("tex", r"\\textbf\{\\boldmath\$")):
                text = (out / "tables" / f"{stem}.{end}").read_text(encoding="utf-8")
                self.assertEqual(len(re.findall(mark, text)), len(winners), (stem, end))
        self.assertGreater(marked, 5)

    def test_the_comparisons_are_behind_the_marks(self):
        path = self.write("six.toml", HEAD + run_table(["ssao", "ssdo"], 6))
        out = self.folder / "six"
        self.good("run", path, "--out", out)
        better = {row["metric"]: row["better"]
                  for row in read_csv(out / "tables/comparisons_filtered.csv")}
        table = json.loads((out / "tables/accuracy_filtered.json").read_text(encoding="utf-8"))
        names = [column["name"] for column in table["columns"]]
        for row in table["rows"]:
            for name, cell in zip(names, row):
                if isinstance(cell, dict):
                    self.assertEqual(bool(cell.get("winner")), better[name] == row[0], name)
        for row in read_csv(out / "tables/comparisons_filtered.csv"):
            resolved = float(row["a - b lower"]) > 0 or float(row["a - b upper"]) < 0
            self.assertEqual(resolved, row["better"] != "", row)


class Seeds(CliTest):
    def test_different_seeds_make_no_pairs(self):
        path = self.write("uneven.toml",
                          HEAD + run_table(["ssao"], 2) + run_table(["ssdo"], 3))
        out = self.folder / "uneven"
        self.good("run", path, "--out", out)
        rows = {(row["metric"], row["stage"]): row for row in read_csv(out / "measurements.csv")
                if row["seed"] == "all"}
        for metric in ("noise_ratio.ssdo/ssao", "rmse_ratio.ssdo/ssao",
                       "bias_squared_difference.ssdo/ssao"):
            row = rows[metric, "filtered"]
            self.assertEqual(row["value"], "")
            self.assertIn("only equal seeds make pairs", row["reason"])
        for row in read_csv(out / "tables/comparisons_filtered.csv"):
            self.assertEqual(row["verdict"], "could not tell: measured with different seeds")
        self.assertNotIn("**", (out / "tables/accuracy_filtered.md").read_text(encoding="utf-8"))

    def test_one_seed_tells_nothing(self):
        path = self.write("one.toml", HEAD + run_table(["ssao", "ssdo"], 1))
        out = self.folder / "one"
        self.good("run", path, "--out", out)
        for row in read_csv(out / "tables/comparisons_filtered.csv"):
            self.assertEqual(row["verdict"], "could not tell: one seed")
        for table in (out / "tables").iterdir():
            self.assertNotRegex(table.read_text(encoding="utf-8"), r"\*\*|textbf|\"winner\"")
