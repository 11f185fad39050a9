"""`occlab report`: what it writes, what it refuses, and what it says of a run with something wrong."""

import json
import re
import shutil
import unittest

from support import CliTest, smoke_results, snapshot


def page_data(folder):
    text = (folder / "report/index.html").read_text(encoding="utf-8")
    return json.loads(re.search(r'id="occlab-data"[^>]*>(.*?)</script>', text, re.DOTALL).group(1))


def planned_cells(folder):
    """The cells that the run set out to make; those of the reference's further rays are not."""
    plan, = (folder / "progress").glob("plan-*.json")
    work = json.loads(plan.read_text(encoding="utf-8"))["work"]
    return sorted({item["id"] for item in work})


TWO_TRUTHS = """\
format = 1
[experiment]
name = "truths"
title = "Truths"
[scene]
source = "coloured_boxes"
resolution = [64, 36]
[parameters]
samples = 4
[reference]
method = ["rtgi_unoccluded", "rtgi_shaded"]
rays_per_pixel = 4
[[run]]
methods = ["s3hogi", "ssdogi"]
seeds = 2
"""


class Report(CliTest):
    def results(self, change=lambda folder: None):
        """A copy of the smoke test's results, changed."""
        folder = self.folder / "results"
        shutil.copytree(smoke_results(), folder, ignore=shutil.ignore_patterns("report"))
        change(folder)
        return folder

    def change_run(self, **changes):
        def change(folder):
            path = folder / "run.json"
            run = json.loads(path.read_text(encoding="utf-8"))
            run.update(changes)
            path.write_text(json.dumps(run), encoding="utf-8")
        return change

    def test_it_writes_one_folder_and_touches_nothing_else(self):
        folder = self.results()
        before = snapshot(folder)
        finished = self.good("report", folder)
        self.assertIn(str(folder / "report/index.html"), finished.stdout)
        after = {path: content for path, content in snapshot(folder).items()
                 if not path.startswith("report")}
        self.assertEqual(after, before)
        data = page_data(folder)
        self.assertTrue(data["complete"])
        self.assertEqual(data["problems"], [])
        for layer in data["layers"]:
            self.assertEqual((folder / f"report/data/{layer['id']}.js").stat().st_size,
                             layer["bytes"])

    def test_every_method_is_compared_with_its_own_truth(self):
        out = self.folder / "out"
        self.good("run", self.write("truths.toml", TWO_TRUTHS), "--out", out)
        self.good("report", out)
        data = page_data(out)
        methods = [group["method"] for group in data["groups"]]
        truths = {group["method"]: methods[group["truth"]] for group in data["groups"]}
        self.assertEqual(truths, {"rtgi_unoccluded": "rtgi_unoccluded", "s3hogi": "rtgi_unoccluded",
                                  "rtgi_shaded": "rtgi_shaded", "ssdogi": "rtgi_shaded"})

    def test_tables_are_those_of_the_table_verb(self):
        folder = self.results()
        self.good("report", folder)
        printed = json.loads(self.good("table", folder, "--format", "json").stdout)
        self.assertEqual(page_data(folder)["tables"], printed)

    def test_a_second_report_takes_the_place_of_the_first(self):
        folder = self.results()
        self.good("report", folder)
        (folder / "report/data/old.js").write_text("old", encoding="utf-8")
        self.good("report", folder)
        self.assertFalse((folder / "report/data/old.js").exists())
        self.assertEqual([path.name for path in folder.iterdir() if path.name.startswith(".")], [])

    def test_what_does_not_fit_is_left_out_and_named(self):
        folder = self.results()
        finished = self.good("report", folder, "--megabytes", "1.5")
        self.assertIn("--megabytes 1.5 is too little: images before the filter", finished.stderr)
        data = page_data(folder)
        self.assertIn("images before the filter", data["leftOut"])
        self.assertNotIn("radiance_unfiltered", {layer["name"] for layer in data["layers"]})
        written = sum(path.stat().st_size for path in (folder / "report").rglob("*")
                      if path.is_file())
        self.assertLessEqual(written, 1.5e6)

    def test_a_damaged_a_missing_and_an_unknown_cell_are_told_apart(self):
        def change(folder):
            cells = sorted(path for path in (folder / "cells").iterdir())
            (cells[0] / "layers.exr").write_bytes(b"no EXR")
            shutil.rmtree(cells[1])
            path = cells[2] / "cell.json"
            path.write_text(path.read_text(encoding="utf-8").replace('"format": 1', '"format": 99'),
                            encoding="utf-8")
        names = sorted(path.name for path in (smoke_results() / "cells").iterdir())
        folder = self.results(change)
        finished = self.good("report", folder)
        self.assertRegex(finished.stderr, r"3 of \d+ cells are missing or damaged")
        data = page_data(folder)
        self.assertFalse(data["complete"])
        cells = {cell["id"]: cell["problem"] for group in data["groups"] for cell in group["cells"]}
        cells.update((cell["id"], cell["problem"]) for cell in data["otherCells"])
        self.assertIn("layers.exr is damaged", cells[names[0]])
        self.assertEqual(cells[names[1]], "missing")
        self.assertIn("has format 99, this occlab reads 1", cells[names[2]])
        self.assertEqual(sum(1 for problem in cells.values() if problem), 3)

    def test_a_half_finished_run_is_incomplete(self):
        def change(folder):
            for name in ("run.json", "measurements.csv"):
                (folder / name).unlink()
            for name in ("tables", "figures"):
                shutil.rmtree(folder / name)
        folder = self.results(change)
        finished = self.good("report", folder)
        self.assertIn("the run has not finished", finished.stderr)
        count = len(planned_cells(folder))
        self.assertIn(f"{count} of {count} cells are there", finished.stderr)
        data = page_data(folder)
        self.assertFalse(data["complete"])
        self.assertEqual(data["tables"], [])
        self.assertGreater(len(data["layers"]), 10)

    def test_a_half_finished_run_says_how_many_cells_it_planned(self):
        def change(folder):
            (folder / "run.json").unlink()
            for cell in planned_cells(folder)[:5]:
                shutil.rmtree(folder / "cells" / cell)
        folder = self.results(change)
        there = len(planned_cells(folder)) - 5
        self.assertIn(f"{there} of {there + 5} cells are there", self.good("report", folder).stderr)
        self.assertTrue(any(f"{there} of {there + 5} cells are there" in problem
                            for problem in page_data(folder)["problems"]))
        shutil.rmtree(folder / "progress")
        there = len(list((folder / "cells").iterdir()))
        self.assertIn(f"{there} finished cells are there", self.good("report", folder).stderr)

    def test_measurements_of_another_run_are_called_so(self):
        def change(folder):
            path = folder / "measurements.csv"
            lines = path.read_text(encoding="utf-8").splitlines(keepends=True)
            path.write_text("".join(lines[:-3]), encoding="utf-8")
        folder = self.results(change)
        self.good("report", folder)
        data = page_data(folder)
        self.assertFalse(data["complete"])
        self.assertIn("is not the one that run.json describes", " ".join(data["problems"]))

    def test_unknown_schema_is_refused_with_a_hint(self):
        folder = self.results(self.change_run(schema=99))
        self.refused(2, ("run.json", "schema", "99", "accepted: 1", "run the experiment again"),
                     "report", folder)

    def test_what_is_no_run_is_refused(self):
        self.refused(2, ("not a results folder", "occlab run"), "report", self.folder)
        folder = self.results(lambda copied: (copied / "run.json").write_text("{", "utf-8"))
        self.refused(2, ("run.json", "schema"), "report", folder)

    def test_a_folder_of_somebody_else_stays(self):
        def change(folder):
            (folder / "report").mkdir()
            (folder / "report/thesis.tex").write_text("mine", encoding="utf-8")
        folder = self.results(change)
        self.refused(2, ("report", "move it away"), "report", folder)

    def test_text_cannot_leave_its_script(self):
        folder = self.results(self.change_run(title="</script><!--<script>"))
        self.good("report", folder)
        self.assertEqual(page_data(folder)["run"]["title"], "</script><!--<script>")
        page = (folder / "report/index.html").read_text(encoding="utf-8")
        self.assertEqual(page.count("</script>"), 2)


if __name__ == "__main__":
    unittest.main()
