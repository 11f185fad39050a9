"""Planted regressions: what `occlab history check` says of changes whose truth is known.

python3 tests/cli/planted.py [REPETITIONS [BASE SIGN DARK [TIMES.csv...]]] prints the tables of
docs/regression.md, the last from stored runs; test_history.py
runs a few repetitions. A repetition compares 8 seeds; all repetitions have seeds of their own. The
changed programs are copies in whose embedded shader text one function was rewritten: real passes
drew the images.
"""

import collections
import csv
import json
import pathlib
import random
import sys
import tempfile

from support import OCCLAB, ROOT, interleave, occlab, read_csv

SEEDS = 8
SH_DOT = b"""SHARED float sh_dot(Sh4 a, Sh4 b) {
  return dot(a.c0, b.c0) + dot(a.c1, b.c1) + dot(a.c2, b.c2) + dot(a.c3, b.c3);
}"""
# The light's product with the coefficients, band 1 with the wrong sign.
WRONG_SIGN = (b"SHARED float sh_dot(Sh4 a,Sh4 b){return 2*a.c0.x*b.c0.x-dot(a.c0,b.c0)"
              b"+dot(a.c1,b.c1)+dot(a.c2,b.c2)+dot(a.c3,b.c3);}")
# S3HO's light 1% darker; the reference's is not.
DARKER = (b"SHARED float sh_dot(Sh4 a,Sh4 b){return .99*(dot(a.c0,b.c0)"
          b"+dot(a.c1,b.c1)+dot(a.c2,b.c2)+dot(a.c3,b.c3));}")


def changed_program(path, change):
    """A copy of occlab whose shaders have `change` in place of sh_dot()."""
    program = OCCLAB.read_bytes()
    if program.count(SH_DOT) != 1 or len(change) > len(SH_DOT):
        raise AssertionError("the text of sh_dot() in the program is not the one expected here")
    path.write_bytes(program.replace(SH_DOT, change.ljust(len(SH_DOT))))
    path.chmod(0o755)
    return path


def run(folder, name, seeds, program=OCCLAB, resolution="[80,45]"):
    """The measurements of configs/regression.toml's methods SSAO and S3HO, without times."""
    text = (ROOT / "configs/regression.toml").read_text(encoding="utf-8").split("[timing]")[0]
    experiment = folder / "planted.toml"
    experiment.write_text(text, encoding="utf-8")
    finished = occlab("run", experiment, "--set", f"scene.resolution={resolution}", "--set",
                      'run[0].methods=["ssao","s3ho"]', "--set", f"run[0].seeds={seeds}",
                      "--out", folder / name, timeout=1200, executable=program)
    if finished.returncode != 0:
        raise AssertionError(finished.stderr)
    return read_csv(folder / name / "measurements.csv")


def by_seed(rows):
    """The rows of every seed."""
    seeds = collections.defaultdict(list)
    for row in rows:
        if row["seed"] != "all":
            seeds[int(row["seed"])].append(row)
    return seeds


def repetition(path, seeds, first, shown_first=0):
    """Writes the measurements of SEEDS seeds from `first` on, called `shown_first`, ...; what is
    over all seeds is their mean."""
    chosen, sums = [], collections.defaultdict(list)
    rows = [row for seed in range(first, first + SEEDS) for row in seeds[seed]]
    for row in rows:
        copy = dict(row, seed=str(int(row["seed"]) - first + shown_first))
        chosen.append(copy)
        identity = tuple((key, value) for key, value in row.items() if key not in
                         ("seed", "value", "lower", "upper", "n", "cells"))
        sums[identity].append(float(row["value"]) if row["value"] else None)
    for identity, values in sums.items():
        if None not in values:
            chosen.append(dict(identity, seed="all", value=repr(sum(values) / len(values)),
                               lower="", upper="", n=str(len(values)), cells=""))
    with open(path, "w", newline="", encoding="utf-8") as stream:
        writer = csv.DictWriter(stream, rows[0].keys(), lineterminator="\r\n")
        writer.writeheader()
        writer.writerows(chosen)
    return path


def checked(folder, after, before):
    """The exit code and the findings of a check of some files against others."""
    out = folder / "check.json"
    finished = occlab("history", "check", *after, *interleave("--against", before), "--db",
                      folder / "none", "--json", out)
    if finished.returncode not in (0, 1):
        raise AssertionError(finished.stderr)
    return finished.returncode, json.loads(out.read_text(encoding="utf-8"))["findings"]


def planted_accuracy(folder, repetitions, base, changes):
    """{change: [(exit code, findings)]}; `base` has twice as many seeds as the repetitions need."""
    results = collections.defaultdict(list)
    base = by_seed(base)
    changes = {name: by_seed(rows) for name, rows in changes.items()}
    for number in range(repetitions):
        first = number * SEEDS
        before = repetition(folder / "before.csv", base, first)
        for name, rows in {"nothing": base, **changes}.items():
            after = repetition(folder / "after.csv", rows, first)
            results[name].append(checked(folder, [after], [before]))
        other = first + repetitions * SEEDS
        after = repetition(folder / "after.csv", base, other, shown_first=1000)
        results["other seeds"].append(checked(folder, [after], [before]))
        after = repetition(folder / "after.csv", base, other)
        results["other samples under the same seeds"].append(checked(folder, [after], [before]))
    return results


def scaled_times(path, rows, factor, method="s3ho"):
    """The times of a run, those of a method's occlusion pass times `factor`."""
    changed = [dict(row) for row in rows if row["metric"].startswith("time_ratio.")]
    for row in changed:
        if row["method"] == method and row["metric"] == "time_ratio.occlusion":
            for column in ("value", "lower", "upper"):
                row[column] = repr(float(row[column]) * factor) if row[column] else ""
    with open(path, "w", newline="", encoding="utf-8") as stream:
        writer = csv.DictWriter(stream, rows[0].keys(), lineterminator="\r\n")
        writer.writeheader()
        writer.writerows(changed)
    return path


def planted_times(folder, repetitions, runs, factor, each):
    """`each` runs against as many others, dealt at random; the new ones' pass `factor` slower."""
    results = []
    deal = random.Random(1)
    for _ in range(repetitions):
        order = deal.sample(runs, 2 * each)
        before = [scaled_times(folder / f"b{i}.csv", rows, 1.0)
                  for i, rows in enumerate(order[:each])]
        after = [scaled_times(folder / f"a{i}.csv", rows, factor)
                 for i, rows in enumerate(order[each:])]
        results.append(checked(folder, after, before))
    return results


def main():
    repetitions = int(sys.argv[1]) if len(sys.argv) > 1 else 50
    with tempfile.TemporaryDirectory(prefix="occlab-planted-") as name:
        folder = pathlib.Path(name)
        if len(sys.argv) > 2:  # folders of runs that are there: base, sign, dark
            base, sign, dark = (read_csv(pathlib.Path(path) / "measurements.csv")
                                for path in sys.argv[2:5])
        else:
            base = run(folder, "base", 2 * SEEDS * repetitions)
            sign = run(folder, "sign", SEEDS * repetitions,
                       changed_program(folder / "occlab-sign", WRONG_SIGN))
            dark = run(folder, "dark", SEEDS * repetitions,
                       changed_program(folder / "occlab-dark", DARKER))
        results = planted_accuracy(folder, repetitions, base, {
            "wrong sign of band 1": sign, "1% darker light of S3HO": dark})
        for each in (3, 5, 7):
            runs = [read_csv(path) for path in sys.argv[5:]]
            if len(runs) < 2 * each:
                continue
            for factor in (1.0, 1.1, 1.2):
                key = f"pass times {factor:g}, {each} runs against {each}"
                results[key] = planted_times(folder, repetitions, runs, factor, each)
    print_table(results)


def print_table(results):
    print("| planted | checks that failed | verdicts of S3HO | of SSAO |\n|---|---|---|---|")
    for name, checks in results.items():
        failed = sum(code == 1 for code, _ in checks)
        cells = []
        for method in ("s3ho", "ssao"):
            counts = collections.Counter(finding["verdict"] for _, findings in checks
                                         for finding in findings if finding["method"] == method)
            cells.append(", ".join(f"{count} {verdict}" for verdict, count in counts.items()))
        print(f"| {name} | {failed} of {len(checks)} | {cells[0]} | {cells[1]} |")


if __name__ == "__main__":
    main()
