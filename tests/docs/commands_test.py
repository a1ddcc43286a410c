"""Every command that the pages show is run, or, where it is marked, parsed.

    commands_test.py [--full] [PAGE...]

Blocks of ```sh and ```console are taken page by page and in order, each page in a scratch folder of its own that looks like the top of
the repository. A block ```sh long is run in the full mode and parsed otherwise; ```sh parsed is parsed alone: command, options and files
have to exist, plans have to pass `palpate check`. A command ends with 0 unless its comment says "exit code N". What a ```console block
shows has to come out, "..." standing for anything.
"""

import fnmatch
import os
import pathlib
import re
import shlex
import subprocess
import sys
import tempfile
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))
import pages
from pages import LONG, PARSED, ROOT, SHELLS

FULL = False
ONLY = []
NOT_LINKED = (".git", "build", "palpate", "results")  # what commands would write to, and the launcher, which builds
MARK = "@@@ palpate"


def prepare(folder):
    """What the top of the repository looks like to a command, with a home of its own beside it."""
    top, home = folder / "palpate", folder / "home"
    top.mkdir()
    home.mkdir()
    for each in ROOT.iterdir():
        if each.name not in NOT_LINKED:
            (top / each.name).symlink_to(each)
    (top / "results").mkdir()
    for name in ("README.md", "accepted"):
        (top / "results" / name).symlink_to(ROOT / "results" / name)
    program = top / "palpate"
    program.write_text(f'#!/bin/sh\nexec "{pages.PROGRAM}" "$@"\n', encoding="utf-8")
    program.chmod(0o755)
    return top, {**os.environ, "HOME": str(home), "PATH": f"{top}:/usr/bin:/bin", "COLUMNS": "80", "NO_COLOR": "1", "LC_ALL": "C.UTF-8"}


def run_commands(commands, top, environment):
    """Runs commands in one shell; returns for each (exit code, output), or None for those behind an `exit`."""
    lines = []
    for command in commands:
        lines += [command.text, f'printf "\\n{MARK} %s\\n" "$?"']
    done = subprocess.run(["/bin/bash"], input="\n".join(lines), text=True, cwd=top, env=environment, stdout=subprocess.PIPE,
                          stderr=subprocess.STDOUT, timeout=3600, check=False)
    found = re.split(rf"\n{MARK} (\d+)\n", done.stdout)
    answers = [(int(code), out) for out, code in zip(found[::2], found[1::2])]
    return answers + [None] * (len(commands) - len(answers))


def missing_line(expected, out):
    """The first line that a page shows and the output does not have, in order; None if all are there."""
    lines, place = out.split("\n"), 0
    for line in expected:
        wanted = line.rstrip()
        if wanted in ("", "..."):
            continue
        pattern = re.sub(r"[\[\]*?]", lambda match: f"[{match.group()}]", wanted).replace("...", "*")
        while place < len(lines) and not fnmatch.fnmatchcase(lines[place].rstrip(), pattern):
            place += 1
        if place == len(lines):
            return wanted
        place += 1
    return None


def blocks_of(page):
    return [block for block in pages.fenced_blocks(page) if block.language in SHELLS]


def is_run(block):
    return block.mark == "" or (FULL and block.mark == LONG)


class Pages(unittest.TestCase):
    def test_marks_are_known_and_no_command_hides_in_an_indented_block(self):
        for page in pages.pages():
            self.assertEqual(pages.indented_commands(page), [], page)
            for block in blocks_of(page):
                self.assertIn(block.mark, ("", LONG, PARSED), block.place)
                self.assertTrue(pages.commands_of(block), f"{block.place}: no command in it")

    def test_every_command_parses(self):
        for page in pages.pages():
            for block in blocks_of(page):
                for command in pages.commands_of(block):
                    self.assertEqual(pages.check_command(command.text), "", f"{block.place}: {command.text}")

    def test_commands_in_running_text_parse(self):
        count = 0
        for page in pages.pages():
            for line, text in pages.inline_commands(page):
                count += 1
                said = pages.check_command(text)
                self.assertTrue(said == "" or said.endswith("a value is missing"), f"{page.relative_to(ROOT)}:{line}: {text}: {said}")  # an option may be named alone
        self.assertGreater(count, 20)

    def test_plans_that_are_named_are_sound(self):
        plans = set()
        for page in pages.pages():
            for block in blocks_of(page):
                for command in pages.commands_of(block):
                    plans |= {word for word in shlex.split(command.text, comments=True) if re.fullmatch(r"experiments/plans/\w+\.yaml", word)}
        done = subprocess.run([pages.PROGRAM, "check", *sorted(plans)], cwd=ROOT, capture_output=True, text=True, check=False)
        self.assertGreater(len(plans), 5)
        self.assertEqual(done.returncode, 0, done.stderr)

    def test_every_command_does_what_the_page_says(self):
        ran, parsed = 0, []
        for page in pages.pages():
            blocks = [block for block in blocks_of(page) if is_run(block)]
            parsed += [f"{block.place} ({block.mark})" for block in blocks_of(page) if not is_run(block)]
            if not blocks or (ONLY and str(page.relative_to(ROOT)) not in ONLY):
                continue
            with tempfile.TemporaryDirectory() as folder:
                top, environment = prepare(pathlib.Path(folder))
                commands = [command for block in blocks for command in pages.commands_of(block)]
                for command, answer in zip(commands, run_commands(commands, top, environment)):
                    with self.subTest(page=page.name, command=command.text):
                        self.assertIsNotNone(answer, "the shell ended before it")
                        code, out = answer
                        self.assertEqual(code, command.exit_code, out)
                        self.assertIsNone(missing_line(command.expected, out), out)
                ran += len(commands)
        print(f"run: {ran} commands; parsed alone: {', '.join(parsed)}", file=sys.stderr)
        self.assertTrue(ran or ONLY)


class Oracle(unittest.TestCase):
    """What the tests above would say of pages that are wrong."""

    def test_a_wrong_command_option_file_or_quote_is_noticed(self):
        for text, said in (("./palpate runn x", "no such command: runn"), ("./palpate run --reume", "run has no option --reume"),
                           ("./palpate run experiments/plans/no_such.yaml", "no file experiments/plans/no_such.yaml"),
                           ("./palpate run no_such_plan", "no plan no_such_plan"), ("./palpate make 'kidney", "No closing quotation"),
                           ("true && ./palpate make cube --vertices", "make --vertices: a value is missing")):
            self.assertEqual(pages.check_command(text), said)
        for text in ("./palpate run thesis_histograms --only 'liver/*=0.5'  # some", "A=b palpate list contestants cgal --json", "cp a b | wc"):
            self.assertEqual(pages.check_command(text), "")

    def test_output_that_is_not_there_is_noticed(self):
        self.assertIsNone(missing_line(["tets  8130", "...", "Written: a.mesh"], "\ntets  8130\nmore\nWritten: a.mesh\n"))
        self.assertEqual(missing_line(["tets  8131"], "tets  8130\n"), "tets  8131")
        self.assertEqual(missing_line(["b", "a"], "a\nb\n"), "a")
        self.assertIsNone(missing_line(["[1] took ... s"], "[1] took 0.3 s"))

    def test_blocks_are_read_as_a_shell_would(self):
        block, = pages.fenced_blocks("```console\n$ one \\\n  two\nout\n$ three  # exit code 2\n```")
        first, second = pages.commands_of(block)
        self.assertEqual((first.text, first.expected, first.exit_code), ("one    two", ["out"], 0))
        self.assertEqual((second.expected, second.exit_code), ([], 2))

    def test_a_failing_command_is_noticed(self):
        with tempfile.TemporaryDirectory() as folder:
            top, environment = prepare(pathlib.Path(folder))
            answers = run_commands([pages.Command("echo a"), pages.Command("false"), pages.Command("exit 3"), pages.Command("true")], top, environment)
        self.assertEqual(answers[:2], [(0, "a\n"), (1, "")])
        self.assertEqual(answers[2:], [None, None])


if __name__ == "__main__":
    words = sys.argv[1:]
    FULL = "--full" in words
    ONLY = [word for word in words if not word.startswith("-")]
    unittest.main(argv=sys.argv[:1])
