"""A reference is certified, or it is said that it is not."""

import json

from support import SMALL_EXPERIMENT, CliTest, exr_pixels, measured, occlab, snapshot

REFERENCE = 'method = "rtdo"\nrays_per_pixel = 4\n'


def experiment(tolerance, most, rays=16):
    return SMALL_EXPERIMENT.replace(
        REFERENCE, f'method = "rtdo"\nrays_per_pixel = {rays}\ntolerance = {tolerance}\n'
                   f"max_rays_per_pixel = {most}\n")


class Certification(CliTest):
    def run_experiment(self, text, out="results", *arguments):
        return self.good("run", self.write("small.toml", text), "--out", self.folder / out,
                         *arguments)

    def reference(self, out="results"):
        return json.loads((self.folder / out / "run.json").read_text())["reference"]

    def reference_rows(self, out="results"):
        return {row["metric"]: row
                for row in measured(self.folder / out / "measurements.csv")
                if row["metric"].startswith("reference_")}

    def test_a_tight_tolerance_traces_more_rays(self):
        loose = self.run_experiment(experiment(10, 4096), "loose")
        self.assertTrue(self.reference("loose")["certified"])
        self.assertEqual(self.reference("loose")["parts"], [16])
        self.assertIn("- certified: the reference's 95% half-width is ", loose.stdout)
        tight = self.run_experiment(experiment(0.15, 65536), "tight")
        found = self.reference("tight")
        self.assertTrue(found["certified"], found)
        self.assertGreater(len(found["parts"]), 1)
        self.assertEqual(found["rays_per_pixel"], sum(found["parts"]))
        self.assertLessEqual(found["share"], 0.15)
        self.assertLess(found["half_width"], self.reference("loose")["half_width"])
        self.assertIn(found["verdict"], tight.stdout)
        # All numbers are against the mean of the parts, and so is the interval.
        rows = self.reference_rows("tight")
        self.assertEqual(float(rows["reference_interval"]["value"]), found["half_width"])
        self.assertEqual(float(rows["reference_rays_per_pixel"]["value"]), found["rays_per_pixel"])
        errors = [row for row in measured(self.folder / "tight/measurements.csv")
                  if row["metric"] == "rmse" and row["seed"] == "all"]
        self.assertEqual({row["reference_cell"] for row in errors}, {found["cell"]})
        self.assertEqual(min(float(row["value"]) for row in errors), found["smallest_error"])

    def test_an_ended_budget_is_said(self):
        run = self.run_experiment(experiment(0.001, 96))
        found = self.reference()
        self.assertFalse(found["certified"])
        self.assertEqual(found["rays_per_pixel"], 96)
        self.assertRegex(found["verdict"], "^NOT certified: .* more than 0.1%; the budget of 96 rays "
                                           "a pixel ended$")
        self.assertIn(found["verdict"], run.stdout)
        table = (self.folder / "results/tables/reference.md").read_text()
        self.assertIn(found["verdict"], table)
        # The table verb says the same of the stored numbers.
        self.assertIn(found["verdict"], self.good("table", self.folder / "results").stdout)

    def test_without_a_budget_the_rays_are_those_given(self):
        run = self.run_experiment(SMALL_EXPERIMENT)
        found = self.reference()
        self.assertEqual(found["parts"], [4])
        self.assertEqual(found["tolerance"], 0.1)
        self.assertIn(found["verdict"], run.stdout)

    def test_a_second_run_does_nothing(self):
        first = self.run_experiment(experiment(0.001, 96))
        before = snapshot(self.folder / "results")
        second = self.run_experiment(experiment(0.001, 96))
        self.assertIn("everything is done", second.stderr)
        self.assertEqual(second.stdout, first.stdout)
        self.assertEqual(snapshot(self.folder / "results"), before)

    def test_a_larger_budget_goes_on_from_what_there_is(self):
        self.run_experiment(experiment(0.001, 64))
        parts = self.reference()["parts"]
        cells = snapshot(self.folder / "results/cells")
        self.run_experiment(experiment(0.001, 200))
        longer = self.reference()["parts"]
        self.assertEqual(sum(longer), 200)
        self.assertEqual(longer[:len(parts)], parts)
        after = snapshot(self.folder / "results/cells")
        changed = [name for name in cells if after.get(name) != cells[name] and "/" in name]
        self.assertEqual(changed, [])

    def test_damaged_parts_come_back_as_they_were(self):
        self.run_experiment(experiment(0.001, 96))
        found = self.reference()
        cells = self.folder / "results/cells"
        mean = exr_pixels(cells / found["cell"] / "layers.exr")
        before = measured(self.folder / "results/measurements.csv")
        for cell in list(cells.iterdir()):
            (cell / "layers.exr").write_bytes(b"damaged")
        self.run_experiment(experiment(0.001, 96))
        self.assertEqual(exr_pixels(cells / found["cell"] / "layers.exr"), mean)
        self.assertEqual(measured(self.folder / "results/measurements.csv"), before)

    def test_a_reference_without_variance_is_not_certified(self):
        self.run_experiment(SMALL_EXPERIMENT.replace(REFERENCE, 'method = "ssdo"\nsamples = 64\n'))
        found = self.reference()
        self.assertFalse(found["certified"])
        self.assertEqual(found["verdict"], "NOT certified: method 'ssdo' states no variance")
        self.assertIsNone(found["share"])

    def refused(self, change):
        path = self.write("small.toml", SMALL_EXPERIMENT.replace(REFERENCE, change))
        run = occlab("run", path, "--out", self.folder / "refused")
        self.assertEqual(run.returncode, 2, run.stderr)
        self.assertFalse((self.folder / "refused").exists())
        return run.stderr

    def test_bad_budgets_are_refused(self):
        self.assertIn("key 'reference.max_rays_per_pixel': accepted are at least rays_per_pixel, 4",
                      self.refused(REFERENCE + "max_rays_per_pixel = 3\n"))
        self.assertIn("key 'reference.max_rays_per_pixel': method 'ssao' does not trace rays",
                      self.refused('method = "ssao"\nsamples = 64\nmax_rays_per_pixel = 30\n'))
        self.assertIn("key 'reference.tolerance': found 0 (an integer); accepted is",
                      self.refused(REFERENCE + "tolerance = 0\n"))
