"""Tables in a terminal fit its width, and lose no number; in a pipe they are Markdown as ever."""

import fcntl
import os
import pty
import re
import struct
import subprocess
import termios
import unittest

from support import METHODS, OCCLAB, CliTest, smoke_results

WIDTHS = (80, 120, 200)


def in_terminal(columns, *arguments, env=None):
    """What occlab prints into a terminal of this width; 0: one that does not know it."""
    master, slave = pty.openpty()
    fcntl.ioctl(slave, termios.TIOCSWINSZ, struct.pack("HHHH", 50, columns, 0, 0))
    environment = {name: value for name, value in os.environ.items() if name != "COLUMNS"}
    process = subprocess.Popen([OCCLAB, *map(str, arguments)], stdout=slave, stderr=subprocess.PIPE,
                               env={**environment, **(env or {})})
    os.close(slave)
    printed = b""
    while True:
        try:
            part = os.read(master, 65536)
        except OSError:  # the other end is closed
            break
        if not part:
            break
        printed += part
    os.close(master)
    problem = process.stderr.read().decode()
    process.stderr.close()
    if process.wait(timeout=60) != 0:
        raise AssertionError(problem)
    return printed.decode().replace("\r\n", "\n")


def numbers(text):
    """All that are in cells of tables, and the ends of their intervals."""
    rows = "\n".join(line for line in text.splitlines() if line.startswith("|"))
    return set(re.findall(r"-?\d+\.?\d*(?:e[-+]?\d+)?", rows))


class Terminal(CliTest):
    def setUp(self):
        super().setUp()
        self.piped = self.good("table", smoke_results()).stdout
        self.assertGreater(max(map(len, self.piped.splitlines())), 200)

    def test_every_line_fits_and_every_number_is_there(self):
        for columns in WIDTHS:
            with self.subTest(columns=columns):
                text = in_terminal(columns, "table", smoke_results())
                longest = max(text.splitlines(), key=len)
                self.assertLessEqual(len(longest), columns, longest)
                self.assertEqual(numbers(text) ^ numbers(self.piped), set())

    def test_blocks_repeat_what_their_rows_are_of(self):
        text = in_terminal(80, "table", smoke_results())
        part = text[text.index("## Accuracy, filtered"):text.index("## Accuracy in the closeups")]
        titles = [line for line in part.splitlines() if line.startswith("| method")]
        self.assertGreater(len(titles), 2)
        for block in part.split("\n\n")[1:len(titles)]:
            rows = [[cell.strip() for cell in line.split("|")[1:3]]
                    for line in block.split("-- |\n", 1)[-1].split("-: |\n", 1)[-1].splitlines()]
            self.assertEqual([row for row in rows if row[0]],
                             [[method, samples] for method in METHODS[1:]
                              for samples in ("8", "4")], block)

    def test_the_environment_comes_first(self):
        for columns, env in ((0, {"COLUMNS": "100"}), (200, {"COLUMNS": "100"})):
            text = in_terminal(columns, "table", smoke_results(), env=env)
            self.assertLessEqual(max(map(len, text.splitlines())), 100)

    def test_without_a_width_nothing_is_broken(self):
        self.assertEqual(in_terminal(0, "table", smoke_results()), self.piped)
        self.assertEqual(in_terminal(0, "table", smoke_results(), env={"COLUMNS": "wide"}), self.piped)

    def test_a_pipe_has_markdown_and_other_formats_stay(self):
        narrow = self.good("table", smoke_results(), env={"COLUMNS": "60"}).stdout
        self.assertEqual(narrow, self.piped)
        for kind in ("csv", "json", "latex"):
            self.assertEqual(
                in_terminal(60, "table", smoke_results(), "--format", kind).replace("\r", ""),
                self.good("table", smoke_results(), "--format", kind).stdout)

    def test_a_very_narrow_terminal_has_lists(self):
        text = in_terminal(24, "table", smoke_results())
        self.assertIn("- method: ssao", text)
        values = set(re.findall(r"\d+\.\d+", self.piped))
        self.assertEqual(values - set(re.findall(r"\d+\.\d+", text)), set())


if __name__ == "__main__":
    unittest.main()
