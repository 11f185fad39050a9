"""occlab claims as a user types it: verdicts of planted measurements, the record, bad input."""

import csv
import json
import re
import subprocess
import sys

from support import OCCLAB, ROOT, CliTest, occlab

HEADER = ("experiment,scene,view,resolution,probe,method,parameter.samples,seed,stage,metric,unit,"
          "value,lower,upper,n,device,clock,cells,reference_cell,reason").split(",")
CLAIMS = """\
format = 1
[experiments]
planted = "occlab run planted.toml"
[[claim]]
id = "noise"
paper = "s3ho"
place = "section 4"
text = "SSDO is noisier"
experiment = "planted"
statement = "rmse(ssdo, N) > rmse(s3ho, N)"
over = {N = [32, 8]}
where = {stage = "filtered"}
[[claim]]
id = "value"
paper = "ssdo"
place = "Table 1"
text = "twice as much"
experiment = "planted"
value = "rmse(ssdo, 32) / rmse(s3ho, 32)"
published = 2.0
where = {stage = "filtered"}
[[claim]]
id = "peeling"
paper = "ssdo"
place = "section 4"
text = "peeling costs 30%"
untestable = "peeling is not built"
[[contradiction]]
id = "rows"
paper = "ssdo"
place = "Table 1"
text = "22.2 is printed, the rates give 42.1"
reading = "42.2 is meant"
"""
DEVIATIONS = (-0.9, 0.4, 1.1, -0.3, 0.6, -1.2, 0.1, 0.2)


class Claims(CliTest):
    def plant(self, name, means):
        """A results folder; `means`: (method, samples) -> mean over 8 seeds, which spread by 2%."""
        folder = self.folder / name
        folder.mkdir()
        with open(folder / "measurements.csv", "w", newline="", encoding="utf-8") as stream:
            writer = csv.DictWriter(stream, HEADER, restval="")
            writer.writeheader()
            for index, ((method, samples), mean) in enumerate(means.items()):
                for seed in range(8):
                    value = mean * (1 + 0.02 * DEVIATIONS[(3 * seed + index) % 8])
                    writer.writerow({"experiment": "planted", "scene": "gallery", "view": "main",
                                     "resolution": "64x36", "probe": "sky", "method": method,
                                     "parameter.samples": samples, "seed": seed,
                                     "stage": "filtered", "metric": "rmse",
                                     "unit": "mean luminance", "value": value, "n": 2304,
                                     "device": "llvmpipe (software)"})
        return folder

    def setUp(self):
        super().setUp()
        self.file = self.write("claims.toml", CLAIMS)
        self.record = self.folder / "record.json"
        self.good_results = self.plant("good", {("ssdo", 32): 2.0, ("s3ho", 32): 1.0,
                                                ("ssdo", 8): 3.0, ("s3ho", 8): 1.2})
        self.bad_results = self.plant("bad", {("ssdo", 32): 1.0, ("s3ho", 32): 1.0,
                                              ("ssdo", 8): 3.0, ("s3ho", 8): 1.2})
        self.other_results = self.plant("other", {("ssao", 32): 1.0})

    def claims(self, *arguments):
        return ("claims", *arguments, "--claims", self.file, "--record", self.record)

    def verdicts(self, *arguments):
        found = json.loads(self.good(*self.claims(*arguments, "--json")).stdout)
        return {claim["id"]: claim["verdict"] for claim in found["claims"]}

    def test_verdicts(self):
        self.assertEqual(self.verdicts(self.good_results),
                         {"noise": "reproduced as an ordering", "value": "reproduced in value",
                          "peeling": "not testable here"})
        self.assertEqual(self.verdicts(self.bad_results),
                         {"noise": "not reproduced", "value": "not reproduced",
                          "peeling": "not testable here"})
        self.assertEqual(set(self.verdicts(self.other_results).values()), {"not testable here"})

    def test_json_holds_the_evidence(self):
        found = json.loads(self.good(*self.claims(self.bad_results, "--json")).stdout)
        noise, value, peeling = found["claims"]
        self.assertEqual(noise["holds"], 1)
        self.assertEqual([case["case"] for case in noise["cases"]], ["N=32", "N=8"])
        first = noise["cases"][0]["statement"]
        self.assertEqual(first["outcome"], "unresolved")
        self.assertTrue(first["interval"]["low"] < 1.0 < first["interval"]["high"])
        self.assertEqual(noise["cases"][1]["statement"]["outcome"], "holds")
        self.assertEqual(value["cases"][0]["value"]["remark"], "not the published value")
        self.assertEqual(peeling["reason"], "peeling is not built")
        self.assertEqual(found["tested"], 1)
        self.assertEqual(found["false_alarm_rate"], 0.05)
        self.assertEqual(found["contradictions"][0]["reading"], "42.2 is meant")

    def test_formats_hold_the_same_verdicts(self):
        text = self.good(*self.claims(self.good_results)).stdout
        self.assertIn("reproduced in value", text)
        self.assertIn("5% at most", text)
        tables = json.loads(self.good(*self.claims(self.good_results, "--format", "json")).stdout)
        self.assertEqual([table["name"] for table in tables],
                         ["claims", "claims_evidence", "contradictions"])
        for form, words in (("csv", "noise,reproduced as an ordering,2 of 2,SSDO is noisier"), ("latex", r"\begin{tabular}")):
            self.assertIn(words,
                          self.good(*self.claims(self.good_results, "--format", form)).stdout)

    def test_a_claim_that_is_lost_fails(self):
        self.assertEqual(occlab(*self.claims(self.bad_results)).returncode, 0)  # nothing recorded
        self.good(*self.claims(self.good_results, "--accept"))
        self.good(*self.claims(self.good_results))
        lost = occlab(*self.claims(self.bad_results))
        self.assertEqual(lost.returncode, 1, lost.stderr)
        self.assertIn("LOST: noise: was reproduced as an ordering", lost.stderr)
        self.assertIn("LOST: value: was reproduced in value", lost.stderr)
        self.assertIn("not reproduced", lost.stdout)
        # What cannot be tested is said, and is no failure.
        self.assertIn("2 claims", self.good(*self.claims(self.other_results)).stderr)
        # Taken for good, it no longer fails.
        self.good(*self.claims(self.bad_results, "--accept"))
        again = self.good(*self.claims(self.good_results))
        self.assertIn("noise: was not reproduced, is reproduced", again.stderr)

    def test_only_accepting_writes(self):
        self.good(*self.claims(self.good_results))
        self.assertFalse(self.record.exists())

    def test_without_names_all_results_are_read(self):
        (self.folder / "results").mkdir()
        self.good_results.rename(self.folder / "results/planted")
        found = self.good(*self.claims("--json"), cwd=self.folder)
        self.assertEqual(json.loads(found.stdout)["claims"][0]["verdict"],
                         "reproduced as an ordering")

    def test_bad_claims_are_refused(self):
        for old, new, words in (
                ("rmse(ssdo, N) >", "rmse(ssdo N) >", ["key 'claim[0].statement'", "character 11"]),
                ("rmse(ssdo, N) >", "rmsee(ssdo, N) >", ["rmsee", "did you mean 'rmse'"]),
                ("rmse(ssdo, N) >", "rmse(sdo, N) >", ["did you mean 'ssdo'"]),
                ("rmse(ssdo, N) >", "rmse(ssdo, N, setps=2) >", ["did you mean 'steps'"]),
                ("rmse(ssdo, N) > rmse(s3ho, N)", "rmse(ssdo, 32) > rmse(s3ho, 32)",
                 ["claim[0].over", "N is not used"]),
                ("over = {N = [32, 8]}", "over = {n = [32, 8]}", ["claim[0].over.n", "capitals"]),
                ("{N = [32, 8]}", "{N = {from = 1, to = 40, step = 1}, M = {from = 1, to = 40, "
                 "step = 1}}", ["claim[0].over", "more than 1000 cases"]),
                ('id = "value"', 'id = "noise"', ["claim[1].id", "'noise' is there twice"]),
                ('id = "rows"', 'id = "noise"', ["contradiction[0].id", "there twice"]),
                ("published = 2.0\n", "", ["claim[1].published", "missing"]),
                ("published = 2.0", "published = [2, 3]", ["2 numbers", "1 cases"]),
                ("published = 2.0", "published = -1", ["above 0"]),
                ('paper = "s3ho"', 'paper = "s4ho"', ["claim[0].paper", "s3ho"]),
                ('experiment = "planted"', 'experiment = "plantd"', ["did you mean 'planted'"]),
                ('untestable = "peeling is not built"', "", ["claim[2]", "'untestable'"]),
                ('text = "SSDO is noisier"', 'txt = "SSDO"', ["claim[0].text", "missing"]),
                ('where = {stage = "filtered"}', 'where = {stag = "filtered"}', ["claim[0].where.stag", "did you mean 'stage'"]),
                ("format = 1", "format = 2", ["'format'", "[1, 1]"]),
                ("[[claim]]", "[[claim]", ["claims.toml"])):
            with self.subTest(new):
                self.file.write_text(CLAIMS.replace(old, new, 1), encoding="utf-8")
                self.refused(2, words, *self.claims(self.good_results))

    def test_bad_files_are_refused(self):
        self.refused(2, ["none/measurements.csv"], *self.claims(self.folder / "none"))
        self.refused(2, ["none.toml"], "claims", "--claims", self.folder / "none.toml")
        self.refused(2, ["there twice"], *self.claims(self.good_results, self.good_results))
        self.refused(2, ["several measurements fit", "good", "bad"],
                     *self.claims(self.good_results, self.bad_results))
        self.record.write_text("[]", encoding="utf-8")
        self.refused(2, ["record.json", "'format'"], *self.claims(self.good_results))
        self.record.write_text("{", encoding="utf-8")
        self.refused(2, ["record.json"], *self.claims(self.good_results))
        self.refused(2, ["--format"], *self.claims(self.good_results, "--format", "html"))

    def test_a_terminal_is_not_exceeded(self):
        """Through a pseudo-terminal, as the layout asks for one."""
        script = ("import os, pty, sys; os.environ['COLUMNS'] = '80'; "
                  "sys.exit(os.waitstatus_to_exitcode(pty.spawn(sys.argv[1:])))")
        finished = subprocess.run(
            [sys.executable, "-c", script, OCCLAB, *map(str, self.claims(self.good_results))],
            capture_output=True, text=True, timeout=60, check=False)
        self.assertEqual(finished.returncode, 0, finished.stderr)
        lines = finished.stdout.replace("\r", "").splitlines()
        self.assertIn("reproduced in value", re.sub(r"[\s|]+", " ", finished.stdout))
        self.assertLessEqual(max(map(len, lines)), 80)


class CommittedClaims(CliTest):
    def test_they_load_and_are_many(self):
        found = json.loads(self.good("claims", "--json", cwd=self.folder).stdout)
        self.assertGreaterEqual(len(found["claims"]), 25)
        self.assertEqual({claim["paper"] for claim in found["claims"]}, {"s3ho", "ssdo"})
        self.assertEqual({claim["verdict"] for claim in found["claims"]}, {"not testable here"})
        for claim in found["claims"]:
            self.assertTrue(claim["reason"], claim["id"])

    def test_contradictions_are_what_the_published_numbers_say(self):
        """The numbers in the texts are those of results/published."""
        with open(ROOT / "results/published/ssdo_table1.csv", newline="",
                  encoding="utf-8") as stream:
            rates = {(row["width"], row["samples"], row["method"]): float(row["fps"])
                     for row in csv.DictReader(stream)}
        found = json.loads(self.good("claims", "--json", cwd=self.folder).stdout)
        texts = {entry["id"]: entry["text"] for entry in found["contradictions"]}

        def drop(width, samples, method):
            return 100 * (1 - rates[width, samples, method] / rates[width, samples, "ssao"])

        self.assertIn(f"{drop('1200', '16', 'ssdogi'):.1f}%", texts["ssdo-bounce-22"])
        self.assertIn(f"{drop('1024', '8', 'ssdogi'):.1f}%", texts["ssdo-bounce-19"])
        self.assertGreater(rates["1024", "8", "ssdo"], rates["1024", "8", "ssao"])
        slower = rates["1024", "8", "ssao"] / rates["1200", "8", "ssao"]
        self.assertIn(f"{slower:.2f} times as long", texts["ssdo-pixels"])
        published = {claim["id"]: claim for claim in found["claims"]}["ssdo-frame-rate"]
        self.assertEqual(len(published["cases"]), 6)
