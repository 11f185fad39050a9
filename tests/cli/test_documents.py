"""The documents are right: their commands run, their examples load, their names exist."""

import json
import os
import re
import shutil
import subprocess
import unittest

from support import OCCLAB, ROOT, CliTest, occlab, read_csv, smoke_results

README = (ROOT / "README.md").read_text(encoding="utf-8")
FORMAT = (ROOT / "configs/FORMAT.md").read_text(encoding="utf-8")
MOST_NOT_RUN = 7  # blocks of the README that the test has to believe


def shell_blocks(text):
    """(why it is not run or "", commands) of every ```sh block."""
    pattern = r"(?:<!-- not run: ([^\n]+?) -->\n)?```sh\n(.*?)```"
    return [(why, re.sub(r"\\\n\s*", "", block).splitlines())
            for why, block in re.findall(pattern, text, re.DOTALL)]


def settings_in(text):
    """(key, value) of every --set KEY=VALUE."""
    return re.findall(r"--set '?([^\s=']+)=([^\s']+)", text)


class Readme(CliTest):
    def test_every_command_runs(self):
        """In a folder that holds what the source tree holds, occlab on the PATH."""
        for name in ("configs", "scenes", "renderers"):
            (self.folder / name).symlink_to(ROOT / name)
        tools = self.folder / "tools"
        tools.mkdir()
        (tools / "occlab").symlink_to(OCCLAB)
        environment = {**os.environ, "PATH": os.pathsep.join((str(tools), os.environ["PATH"]))}
        run = 0
        for why, commands in shell_blocks(README):
            for command in commands if not why else []:
                if command.startswith("parallel ") and not shutil.which("parallel"):
                    continue
                with self.subTest(command):
                    self.assertRegex(command, r"^(occlab|parallel|\./)")
                    finished = subprocess.run(["bash", "-c", command], cwd=self.folder, text=True,
                                              env=environment, capture_output=True, timeout=120,
                                              check=False)
                    self.assertEqual(finished.returncode, 0, finished.stderr)
                    run += 1
        self.assertGreaterEqual(run, 8)

    def test_what_is_not_run_is_rare_and_says_why(self):
        blocks = shell_blocks(README)
        self.assertEqual(len(blocks), README.count("```sh\n"))
        not_run = [why for why, _ in blocks if why]
        self.assertEqual(len(not_run), README.count("<!-- not run"))
        self.assertLessEqual(len(not_run), MOST_NOT_RUN)
        self.assertGreater(len(blocks) - len(not_run), 2)

    def test_options_of_commands_that_are_not_run_exist(self):
        for why, commands in shell_blocks(README):
            for command in commands:
                verb = re.match(r"occlab (\w+)", command)
                if why and verb:
                    usage = self.good(verb.group(1), "--help").stdout
                    for option in re.findall(r"(?<=\s)--?[a-z]\S*", command):
                        with self.subTest(f"{verb.group(1)} {option}"):
                            self.assertRegex(usage, rf"(?<![\w-]){option}(?![\w-])")

    def test_parameters_exist(self):
        methods = json.loads(self.good("list", "methods", "--json").stdout)
        known = {parameter["name"] for method in methods for parameter in method["parameters"]}
        named = [key for key, _ in settings_in(README) if "." not in key and key.islower()]
        named += re.findall(r"\(`(\w+_\w+)`\)", README)
        self.assertGreaterEqual(len(named), 4)
        self.assertLessEqual(set(named), known)

    def test_columns_of_the_measurements_are_all_explained(self):
        section = README.split("Its columns:")[1].split("##")[0]
        documented = {name for row in re.findall(r"(?m)^\| (`[^|]+`) \|", section)
                      for name in re.findall(r"`([\w.]+)`", row)} - {"parameter.NAME"}
        columns = {name for name in read_csv(smoke_results() / "measurements.csv")[0]
                   if not name.startswith("parameter.")}
        self.assertEqual(documented, columns)

    def test_methods_are_those_there_are(self):
        methods = json.loads(self.good("list", "methods", "--json").stdout)
        self.assertEqual(set(re.findall(r"(?m)^\| `(\w+)` \|", README)),
                         {method["name"] for method in methods})

    def test_files_exist(self):
        paths = set(re.findall(r"`((?:configs|scenes|renderers)/[\w./-]+)`", README))
        paths |= {link for link in re.findall(r"\]\(([^)#]+)\)", README) if "://" not in link}
        self.assertGreaterEqual(len(paths), 5)
        for path in paths:
            if "NAME" not in path:
                self.assertTrue((ROOT / path).exists(), path)

    def test_every_verb_is_mentioned_and_has_help(self):
        listed = occlab("--help").stdout.split("Subcommands")[1]
        verbs = set(re.findall(r"(?m)^  (\w+)  +\S", listed))
        self.assertEqual(verbs, set(re.findall(r"occlab (\w+)", README)) & verbs)
        self.assertGreaterEqual(len(verbs), 10)
        for verb in re.findall(r"(?m)^occlab (\w+)", README):
            self.assertIn(f"occlab {verb} ", self.good(verb, "--help").stdout)

    def test_exit_codes_are_those_of_the_program(self):
        table = re.findall(r"(?m)^\| (\d) \| ([a-z ]+)", README)
        self.assertEqual([int(code) for code, _ in table], [0, 1, 2, 3])
        usage = occlab("--help").stdout
        for code, meaning in table:
            self.assertIn(f"{code} {meaning.split(' (')[0].strip()}", usage)


class ExperimentFormat(CliTest):
    def plan(self, *arguments, verb="run"):
        """Loads an experiment without rendering: the device is asked for after that."""
        finished = occlab(verb, *arguments, "--device", "999", "--out", self.folder / "out")
        self.assertEqual(finished.returncode, 2)
        return finished.stderr

    def test_committed_experiments_load(self):
        for path in sorted((ROOT / "configs").rglob("*.toml")):
            if path.name == "claims.toml":  # no experiment: test_claims.py
                continue
            with self.subTest(path.name):
                verb = "run" if "[[run]]" in path.read_text(encoding="utf-8") else "time"
                self.assertRegex(self.plan(path, verb=verb), "--device 999: unknown")

    def test_toml_examples_load(self):
        for index, example in enumerate(re.findall(r"```toml\n(.*?)```", FORMAT, re.DOTALL)):
            with self.subTest(index):
                path = self.write("example.toml", example)
                self.assertRegex(self.plan(path), "--device 999: unknown")

    def test_set_examples_are_accepted(self):
        examples = settings_in(FORMAT)
        examples = [(key, value) for key, value in examples if key != "KEY"]
        self.assertGreaterEqual(len(examples), 4)
        for key, value in examples:
            with self.subTest(key):
                stderr = self.plan(ROOT / "configs/papers/s3ho.toml", "--set", f"{key}={value}")
                self.assertRegex(stderr, "--device 999: unknown")

    def test_named_files_exist(self):
        for path in re.findall(r"`([\w/]+\.toml)`", FORMAT):
            self.assertTrue((ROOT / "configs" / path).is_file(), path)

    def test_keys_are_known_to_the_program(self):
        """The message about an unknown key lists the keys there are: those of the document."""
        experiment = ROOT / "configs/smoke.toml"
        for heading, table in (("[experiment], required", "experiment"),
                               ("[scene], required", "scene"), ("[probe]", "probe"),
                               ("[[run]], one or more", "run[0]"), ("[timing]", "timing"),
                               ("[[figure]]", "figure[1]"), ("[[figure]]", "figure[2]")):
            section = FORMAT.split(f"## {heading}\n")[1].split("\n## ")[0]
            documented = re.findall(r"(?m)^\| `(\w+)` \|", section)
            self.assertTrue(documented, heading)
            stderr = self.plan(experiment, "--set", f"{table}.zzzzzzzzzzzz=1")
            accepted = re.search(r"accepted: (.*)$", stderr.strip()).group(1).split(", ")
            # Only some kinds of figures have columns, rows, a scale or points.
            elsewhere = {"figure[1]": {"columns", "scale", "points", "switch"},
                         "figure[2]": {"columns", "rows", "points", "switch"}}.get(table, set())
            with self.subTest(table):
                self.assertLessEqual(set(documented) - elsewhere, set(accepted))


class Changelog(unittest.TestCase):
    def test_it_names_the_version_of_the_build_file(self):
        version = re.search(r"project\(occlab VERSION (\S+)",
                            (ROOT / "CMakeLists.txt").read_text(encoding="utf-8")).group(1)
        self.assertIn(version, (ROOT / "CHANGELOG.md").read_text(encoding="utf-8"))


if not shutil.which("bash"):
    raise RuntimeError("these tests need bash")
