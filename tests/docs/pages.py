"""The pages that a reader meets, and what of them can be tested: code blocks, commands, links, headings."""

import os
import pathlib
import re
import shlex
from dataclasses import dataclass, field

ROOT = pathlib.Path(__file__).resolve().parents[2]
HELP = ROOT / "experiments" / "commands" / "help"
PROGRAM = pathlib.Path(os.environ.get("PALPATE_PROGRAM", ROOT / "build" / "release" / "bin" / "palpate"))

SHELLS = ("sh", "console")
# Marks behind the language: run in the full mode alone; there too, but of each run of a plan its first case alone; run by another test, which
# the mark names: `by NAME`, a test of ctest or a stage of .ci/run full.
LONG, PART, BY = "long", "part", "by "
EXIT_CODE = re.compile(r"#.*\bexit code (\d+)")


def pages():
    """README, what belongs to it, and all of docs/."""
    own = [ROOT / name for name in ("README.md", "CONTRIBUTING.md", "ARCHITECTURE.md", "CHANGELOG.md", "reference/PROTOCOL.md", "results/README.md")]
    return [*own, *sorted((ROOT / "docs").rglob("*.md"))]


@dataclass
class Block:
    page: pathlib.Path
    line: int  # of its fence, from 1
    language: str
    mark: str  # "", LONG, PART or BY with a name
    lines: list

    @property
    def place(self):
        return f"{self.page.relative_to(ROOT)}:{self.line}"


@dataclass
class Command:
    text: str  # as the shell takes it, continuation lines joined
    exit_code: int = 0
    expected: list = field(default_factory=list)  # lines of output that the page shows ("..." stands for anything)


def fenced_blocks(page):
    """All fenced blocks of a page; what is no page of ours may be given as text for tests."""
    text = page.read_text(encoding="utf-8") if isinstance(page, pathlib.Path) else page
    where = page if isinstance(page, pathlib.Path) else ROOT / "a_text"
    blocks, current = [], None
    for number, line in enumerate(text.split("\n"), start=1):
        if current is None and line.startswith("```"):
            words = line[3:].split()
            current = Block(where, number, words[0] if words else "", " ".join(words[1:]), [])
        elif current is not None and line.startswith("```"):
            blocks.append(current)
            current = None
        elif current is not None:
            current.lines.append(line)
    return blocks


def indented_commands(page):
    """(line number, text) of commands in indented blocks: none may be there, since no test would see them."""
    text, found, is_fenced = page.read_text(encoding="utf-8"), [], False
    for number, line in enumerate(text.split("\n"), start=1):
        is_fenced ^= line.startswith("```")
        if not is_fenced and re.match(r"(    |\t)(\./)?palpate [a-z]", line):
            found.append((number, line.strip()))
    return found


def commands_of(block):
    """The commands of a block, in order."""
    commands, pending = [], ""
    for line in block.lines:
        if block.language == "console":
            if not line.startswith("$ ") and not pending:
                if commands:
                    commands[-1].expected.append(line)
                continue
            line = line.removeprefix("$ ")
        pending += line
        if pending.endswith("\\"):
            pending = pending[:-1] + " "
            continue
        text, pending = pending.strip(), ""
        if text and not text.startswith("#"):
            said = EXIT_CODE.search(text)
            commands.append(Command(text, int(said.group(1)) if said else 0))
    return commands


def inline_commands(page):
    """(line number, text) of the commands in running text: `palpate ...` or `./palpate ...` with at least a command."""
    text, found = page.read_text(encoding="utf-8"), []
    for match in re.finditer(r"(?<!`)`((?:\./)?palpate [a-z][^`]*)`", re.sub(r"(?ms)^```.*?^```", lambda block: "\n" * block.group().count("\n"), text)):
        found.append((text.count("\n", 0, match.start()) + 1, " ".join(match.group(1).split())))
    return found


# --- Parsing without running -----------------------------------------------------------------------------------------------


def help_of(command):
    """The text of a command's help, or None if there is no such command."""
    path = HELP / f"{command}.txt"
    return path.read_text(encoding="utf-8") if path.exists() else None


def options_of(help_text):
    """{"--out": takes a value} of every option of a help text."""
    found = {}
    for match in re.finditer(r"^  (-\S+)( \S+)?", help_text, re.MULTILINE):
        names = match.group(1)
        takes_value = bool(match.group(2) and re.match(r" [A-Z]", match.group(2)))
        for name in names.split(","):
            found[name] = takes_value
    return found


def is_placeholder(word):
    """RUN, DIR, PLAN|SCENE...: what the reader is to replace."""
    return word == "..." or bool(re.fullmatch(r"[A-Z][A-Z_|.0-9]*", word))


def check_words(words):
    """What is wrong with a command of ours by its help texts and the files that it names; "" if nothing."""
    while words and re.fullmatch(r"[A-Z_]+=.*", words[0]):
        words = words[1:]
    if not words or words[0] not in ("./palpate", "palpate"):
        return missing_file(words)
    command = next((word for word in words[1:] if not word.startswith("-")), None)
    text = help_of(command or "palpate")
    if text is None:
        return f"no such command: {command}"
    options, rest, place = options_of(text), [], words.index(command) + 1 if command else 1
    if command == "list":
        options["--json"] = False
    while place < len(words):
        word = words[place]
        place += 1
        if not word.startswith("-") or word == "-":
            rest.append(word)
            continue
        name, _, value = word.partition("=")
        if name not in options:
            return f"{command} has no option {name}"
        if options[name] and not value:
            if place >= len(words):
                return f"{command} {name}: a value is missing"
            place += 1
    return check_files(command, rest)


def missing_file(words):
    """"no file NAME" for the first word that names a file of the repository that is not there; else ""."""
    own = ("experiments/", "docs/", "results/accepted", "tests/", "cmake/", "report/", "reference/")
    return next((f"no file {word}" for word in words if word.startswith(own) and not word.endswith("/yours.yaml") and not any(ROOT.glob(word))), "")


def check_files(command, words):
    """Whether the plans and scenes of the repository that a command names exist."""
    missing = missing_file(words)
    if missing:
        return missing
    if command == "run" and words and "/" not in words[0] and not is_placeholder(words[0]):
        name = words[0].removesuffix(".yaml")
        if not (ROOT / "experiments" / "plans" / f"{name}.yaml").exists() and not words[0].endswith(".yaml"):
            return f"no plan {words[0]}"
    return ""


def check_command(text):
    """What is wrong with a line of a shell by its words alone; "" if nothing."""
    try:
        words = shlex.split(text, comments=True)
    except ValueError as error:
        return str(error)
    if not words:
        return ""
    parts, current = [], []
    for word in words:
        if word in ("&&", "||", ";", "|"):
            parts.append(current)
            current = []
        else:
            current.append(word)
    return next((said for said in map(check_words, [*parts, current]) if said), "")
