"""Every command that the pages show is run: here, or by the test that its block names.

    commands_test.py [--full] [PAGE...]

Blocks of ```sh and ```console are taken page by page and in order, each page in a scratch folder of its own that looks like the top of
the repository. A block ```sh long is run in the full mode; of a block ```sh part, whose plans take hours, only the first case of each run is,
there too. What another test runs says so, ```sh by NAME, where NAME is a test of ctest or a stage of .ci/run full. All are parsed at each
change: command, options and files have to exist, plans have to pass `palpate check`. What a reader has of their own is made first (own_files.py).
A command ends with 0 unless its comment says "exit code N". What a ```console block shows has to come out, "..." standing for anything.
"""

import fnmatch
import os
import pathlib
import re
import shlex
import subprocess
import sys
import tempfile
import time
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))
import own_files
import pages
from pages import BY, LONG, PART, ROOT, SHELLS

FULL = False
ONLY = []
NOT_LINKED = (".git", "build", "palpate", "results")  # what commands would write to, and the launcher, which builds
MARK = "@@@ palpate"
PAGE_LIMIT_S = 2 * 3600  # a page's commands together; trainings, fits and envelopes, on a core that others share


def prepare(folder):
    """What the top of the repository looks like to a command, with a home of its own beside it."""
    top, home = folder / "palpate", folder / "home"
    top.mkdir()
    home.mkdir()
    for each in ROOT.iterdir():
        if each.name not in NOT_LINKED:
            (top / each.name).symlink_to(each)
    (top / "results").mkdir()
    for name in ("README.md", "accepted", "published"):
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
                          stderr=subprocess.STDOUT, timeout=PAGE_LIMIT_S, check=False)
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
    return block.mark == "" or (FULL and block.mark in (LONG, PART))


def is_this_test(text):
    """`palpate test` runs what runs this."""
    return re.fullmatch(r"(\./)?palpate test( --full)?", text) is not None


def first_case_of(text):
    """A run of a plan with its first case alone; other commands as they are."""
    words = shlex.split(text, comments=True)
    if words[:2] not in (["./palpate", "run"], ["palpate", "run"]):
        return text
    return f'PLAN_CASES=$({shlex.join(words)} --list-cases) && {shlex.join(words)} --case "$(head -n 1 <<< "$PLAN_CASES")" --out runs/{pathlib.Path(words[2]).stem}'


def commands_to_run(blocks):
    """[(block, command)] of the blocks that are run, as a reader would type them but for what `part` shortens."""
    found = []
    for block in blocks:
        for command in pages.commands_of(block):
            if not is_this_test(command.text):
                text = first_case_of(command.text) if block.mark == PART else command.text
                found.append((block, pages.Command(text, command.exit_code, command.expected)))
    return found


def names_of_tests():
    """The tests of ctest, those that a loop names too, and the stages of .ci/run full."""
    names = set()
    for path in [*ROOT.glob("tests/**/CMakeLists.txt"), ROOT / "tests" / "CMakeLists.txt"]:
        names |= set(re.findall(r"add_test\(NAME\s+([\w.]+)", path.read_text(encoding="utf-8")))
        for line, prefix in re.findall(r"foreach\(\w+ ([\w ]+)\)\s*add_test\(NAME (\w+)\.\$", path.read_text(encoding="utf-8")):
            names |= {f"{prefix}.{each}" for each in line.split()}
    listed = subprocess.run(["/usr/bin/python3", "-B", ROOT / ".ci" / "nightly.py", "--list"], capture_output=True, text=True, check=True).stdout
    return {name for name in names if not name.endswith(".")} | {f"stage {line.split()[0]}" for line in listed.splitlines() if line.strip()}


class Pages(unittest.TestCase):
    def test_marks_are_known_and_no_command_hides_in_an_indented_block(self):
        known = names_of_tests()
        self.assertIn("page.browser", known)
        for page in pages.pages():
            self.assertEqual(pages.indented_commands(page), [], page)
            for block in blocks_of(page):
                if block.mark.startswith(BY):
                    for name in block.mark.removeprefix(BY).split(", "):
                        self.assertIn(name, known, block.place)
                else:
                    self.assertIn(block.mark, ("", LONG, PART), block.place)
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
        ran, others = 0, []
        for page in pages.pages():
            blocks = [block for block in blocks_of(page) if is_run(block)]
            others += [f"{block.place} ({block.mark})" for block in blocks_of(page) if not is_run(block)]
            if not blocks or (ONLY and str(page.relative_to(ROOT)) not in ONLY):
                continue
            begun = time.monotonic()
            with tempfile.TemporaryDirectory() as folder:
                top, environment = prepare(pathlib.Path(folder))
                commands = [command for _, command in commands_to_run(blocks)]
                own = [pages.Command(text) for text in own_files.making([command.text for command in commands if FULL])]
                for command, answer in zip([*own, *commands], run_commands([*own, *commands], top, environment)):
                    with self.subTest(page=page.name, command=command.text):
                        self.assertIsNotNone(answer, "the shell ended before it")
                        code, out = answer
                        self.assertEqual(code, command.exit_code, out)
                        self.assertIsNone(missing_line(command.expected, out), out)
                ran += len(commands)
            print(f"{page.relative_to(ROOT)}: {len(commands)} commands, {time.monotonic() - begun:.0f} s", file=sys.stderr, flush=True)
        print(f"run: {ran} commands; not run here: {', '.join(others)}", file=sys.stderr)
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
