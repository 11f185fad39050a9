#!/usr/bin/env python3
"""clang-tidy over all sources: python3 tools/tidy.py BUILD [-j JOBS] [--record] [FILE...]

A file that is clean stays clean as long as it, what it includes of this repository, its flags, the
checks and clang-tidy itself are the same. tools/tidy_clean.txt, which is committed, has the hashes
of such files, and BUILD/tidy_clean.txt those found clean here; all others are checked, at 12 or so a
minute. --record writes what is clean now into tools/tidy_clean.txt. Exit code 1 if a file is not
clean.
"""

import argparse
import concurrent.futures
import functools
import hashlib
import json
import pathlib
import re
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parents[1]
RECORD = ROOT / "tools/tidy_clean.txt"
INCLUDE = re.compile(r'^\s*#\s*include\s*"([^"]+)"', re.MULTILINE)


@functools.cache
def content(path):
    data = path.read_bytes()
    return hashlib.sha256(data).hexdigest(), INCLUDE.findall(data.decode(errors="replace"))


def closure(source):
    """The source and all of this repository that it includes."""
    found, pending = set(), [source]
    while pending:
        path = pending.pop()
        if path in found:
            continue
        found.add(path)
        for name in content(path)[1]:
            for folder in (ROOT, path.parent):
                if (folder / name).is_file():
                    pending.append((folder / name).resolve())
                    break
    return sorted(found)


def key_of(entry, common):
    """What determines whether a file is clean. Paths of the build folder are no part of it."""
    flags = [word for word in entry["command"].split() if word.startswith(("-D", "-std", "-f", "-W"))
             and str(ROOT) not in word]
    text = [common, *flags]
    for path in closure(pathlib.Path(entry["file"]).resolve()):
        text += [str(path.relative_to(ROOT)), content(path)[0]]
    return hashlib.sha256("\n".join(text).encode()).hexdigest()


def read_keys(path):
    lines = path.read_text().splitlines() if path.exists() else []
    return {line.split()[0] for line in lines if line and not line.startswith("#")}


def check(source, build):
    run = subprocess.run(["clang-tidy", "--quiet", "-p", str(build), str(source)],
                         capture_output=True, text=True, check=False)
    return run.returncode, run.stdout + (run.stderr if run.returncode else "")


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("build", type=pathlib.Path, help="a build folder, for its compile commands")
    parser.add_argument("files", nargs="*", help="these only, as git knows them")
    parser.add_argument("-j", "--jobs", type=int, default=2)
    parser.add_argument("--record", action="store_true")
    options = parser.parse_intermixed_args()

    tracked = set(subprocess.run(["git", "ls-files", "*.cpp"], cwd=ROOT, capture_output=True,
                                 text=True, check=True).stdout.split())
    version = subprocess.run(["clang-tidy", "--version"], capture_output=True, text=True,
                             check=True).stdout
    common = version + (ROOT / ".clang-tidy").read_text()
    entries = {}
    for entry in json.loads((options.build / "compile_commands.json").read_text()):
        path = pathlib.Path(entry["file"]).resolve()
        name = str(path.relative_to(ROOT)) if path.is_relative_to(ROOT) else ""
        if name in tracked and (not options.files or name in options.files):
            entries.setdefault(name, entry)
    keys = {name: key_of(entry, common) for name, entry in sorted(entries.items())}
    local = options.build / "tidy_clean.txt"
    clean = read_keys(RECORD) | read_keys(local)
    pending = [name for name, key in keys.items() if key not in clean]
    print(f"clang-tidy: {len(keys)} files, {len(keys) - len(pending)} known to be clean")

    failed = []
    with concurrent.futures.ThreadPoolExecutor(options.jobs) as pool, local.open("a") as log:
        runs = {pool.submit(check, ROOT / name, options.build): name for name in pending}
        for run in concurrent.futures.as_completed(runs):
            code, output = run.result()
            if code == 0:
                clean.add(keys[runs[run]])
                print(keys[runs[run]], file=log, flush=True)
            else:
                failed.append(runs[run])
                print(output, flush=True)
    if options.record and not options.files:
        lines = [f"{key} {name}" for name, key in keys.items() if key in clean]
        RECORD.write_text("# Made by tools/tidy.py --record.\n" + "\n".join(lines) + "\n")
    print(f"clang-tidy: {len(failed)} files are not clean" if failed else
          f"clang-tidy: {len(keys)} files are clean")
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
