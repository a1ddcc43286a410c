#!/usr/bin/env python3
"""The man page and the shells' completions of the program, from its help texts alone, so that they say what it does.

    manual.py ROOT OUT VERSION     reads ROOT/experiments/commands/help/*.txt (held equal to --help by a test) and the first comment of
                                   ROOT/palpate; writes OUT/man/man1/palpate.1, OUT/bash-completion/completions/palpate,
                                   OUT/zsh/site-functions/_palpate and OUT/fish/vendor_completions.d/palpate.fish

The same texts give the same bytes: no date.
"""

import pathlib
import re
import sys
from dataclasses import dataclass, field

SECTIONS = ("Arguments", "Options", "Commands")
COLUMN = 26  # at which the help's descriptions start
PLACES = {"FILE": "file", "PLAN": "plan", "SCENE": "file", "MESH": "file", "SURFACE": "file", "ORGAN": "file", "TRAINING": "file", "RUN": "folder",
          "RUN_A": "file", "RUN_B": "file", "A": "file", "B": "file", "DIR": "folder", "FOLDER": "folder"}


@dataclass
class Entry:
    """An argument, an option or a command of a help text."""

    head: str  # as it stands there: "-o,--output FILE"
    text: str

    @property
    def names(self):
        return [name for name in self.head.split()[0].split(",") if name.startswith("-")]

    @property
    def value(self):
        """What stands for its value, or ""."""
        words = self.head.split()
        return words[1] if self.names and len(words) > 1 else ""

    @property
    def choices(self):
        found = re.search(r"\{(.*)\}", self.head)
        return found.group(1).split(",") if found else []


@dataclass
class Help:
    name: str
    summary: str
    usage: str
    entries: dict = field(default_factory=dict)  # section -> entries
    footer: list = field(default_factory=list)  # lines

    def options(self):
        return self.entries.get("Options", [])


def read_help(name, text):
    """A help text in its parts. Throws: ValueError if it has no usage."""
    lines = text.strip("\n").split("\n")
    start = next((place for place, line in enumerate(lines) if line.startswith("Usage: ")), None)
    if start is None:
        raise ValueError(f"{name}: no line that starts with Usage:")
    found = Help(name, " ".join(lines[:start]).strip(), lines[start][len("Usage: "):])
    section = None
    for line in lines[start + 1:]:
        if line.rstrip(":") in SECTIONS and line.endswith(":"):
            section = found.entries.setdefault(line.rstrip(":"), [])
        elif section is not None and re.match(r"  \S", line):
            head, text_ = (line[2:], "") if len(line) <= COLUMN or line[COLUMN - 1] != " " else (line[2:COLUMN].strip(), line[COLUMN:].strip())
            section.append(Entry(head.strip(), text_))
        elif section and line.startswith(" " * COLUMN):
            section[-1].text = (section[-1].text + " " + line.strip()).strip()
        elif line.strip() == "" and not found.footer:
            section = None
        else:
            section = None
            found.footer.append(line)
    return found


def read_all(root):
    """{name: Help}; "palpate" is the program itself. Commands are in its order."""
    folder = root / "experiments" / "commands" / "help"
    read = lambda name: read_help(name, (folder / f"{name}.txt").read_text(encoding="utf-8"))
    top = read("palpate")
    return {"palpate": top, **{entry.head: read(entry.head) for entry in top.entries["Commands"]}}


def read_environment(root):
    """(variable, what it does) from the launcher's first comment."""
    found = []
    for line in (root / "palpate").read_text(encoding="utf-8").split("\n"):
        match = re.match(r"#   (PALPATE_\w+=\S+) +(\S.*)", line)
        if match:
            found.append(match.groups())
    return found


# --- Man page ---------------------------------------------------------------------------------------------------------------


def roff(text):
    text = text.replace("\\", "\\e").replace("-", "\\-")
    return "\\&" + text if text[:1] in (".", "'") else text


def roff_entries(entries):
    for entry in entries:
        yield ".TP"
        yield f".B {roff(entry.head)}"
        yield roff(entry.text) or "\\&"


def roff_footer(lines):
    """Paragraphs; lines that are set in columns stay as they are."""
    paragraph = []
    for line in [*lines, ""]:
        if line.strip():
            paragraph.append(line)
            continue
        if paragraph:
            is_table = any(re.match(r"\s", each) or "   " in each for each in paragraph)
            yield ".PP"
            yield from [".nf", *map(roff, paragraph), ".fi"] if is_table else map(roff, paragraph)
        paragraph = []


def man_page(commands, environment, version):
    top = commands["palpate"]
    out = [f'.TH PALPATE 1 "" "palpate {version}" "User Commands"', ".SH NAME", f"palpate \\- {roff(top.summary)}", ".SH SYNOPSIS",
           ".B palpate", roff(top.usage.removeprefix("palpate ")), ".SH DESCRIPTION",
           "Each command takes", ".BR \\-\\-help .", "What stands here is what", ".B \\-\\-help", "prints.", ".SH OPTIONS",
           *roff_entries(top.options()), ".SH COMMANDS"]
    for name, help_ in commands.items():
        if name == "palpate":
            continue
        out += [f".SS {roff(name)}", roff(help_.summary) + ".", ".PP", f".B {roff(help_.usage)}"]
        for section in ("Arguments", "Options", "Commands"):
            out += roff_entries([entry for entry in help_.entries.get(section, []) if entry.names != ["-h", "--help"]])
        out += roff_footer(help_.footer)
    out += [".SH EXIT STATUS", *exit_codes(), ".SH ENVIRONMENT"]
    for name, text in environment:
        out += [".TP", f".B {roff(name)}", roff(text)]
    out += [".TP", ".B PALPATE_CONTESTANTS", "folders of contestants of your own, separated by colons", ".TP", ".B COLUMNS",
            "the width that tables fold to", ".TP", ".B NO_COLOR", "no colours"]
    return "\n".join(out) + "\n"


def exit_codes():
    for code, text in (("0", "done and accepted"), ("1", "done, but a gate, an acceptance or something that a plan requires did not hold, or a mesh is not valid"),
                       ("2", "bad input or usage"), ("3", "something needed could not run, or simulate came to its time\\-out"),
                       ("130", "a run was interrupted")):
        yield from (".TP", f".B {code}", text)


# --- Completions ------------------------------------------------------------------------------------------------------------


def positional(help_):
    """What a command's own words are: "plan", "file", "folder", a list of words, or "" for none."""
    commands = [entry.head for entry in help_.entries.get("Commands", [])]
    if commands:
        return commands
    arguments = help_.entries.get("Arguments", [])
    if help_.name in ("run", "check"):
        return "plan"
    return PLACES.get(arguments[0].head.split()[0], "") if arguments else ""


def place_of(option):
    return PLACES.get(option.value.split(":")[0], "")


def words_of(help_):
    return " ".join(name for entry in help_.options() for name in entry.names)


def bash_completion(commands):
    own = {name: help_ for name, help_ in commands.items() if name != "palpate"}
    out = ["# bash completion of palpate; made by cmake/manual/manual.py from the help texts", "_palpate() {",
           "  local current=${COMP_WORDS[COMP_CWORD]} before=${COMP_WORDS[COMP_CWORD-1]} command='' word",
           "  COMPREPLY=()",
           "  for word in \"${COMP_WORDS[@]:1:COMP_CWORD-1}\"; do", "    if [[ $word != -* ]]; then command=$word; break; fi", "  done",
           "  _palpate_words() { mapfile -t COMPREPLY < <(compgen -W \"$1\" -- \"$current\"); }",
           "  _palpate_files() { compopt -o filenames 2>/dev/null; mapfile -t COMPREPLY < <(compgen \"$1\" -- \"$current\"); }",
           "  _palpate_plans() {", "    _palpate_files -f", "    local root name", "    root=$(dirname -- \"$(readlink -f -- \"$(type -P -- \"${COMP_WORDS[0]}\")\")\" 2>/dev/null)",
           "    for name in \"$root\"/{,../../share/palpate/}experiments/plans/\"$current\"*.yaml; do  # in the sources, or installed", "      [[ -e $name ]] && name=${name##*/} && COMPREPLY+=(\"${name%.yaml}\")",
           "    done", "  }", "  case $command in",
           f"    '') _palpate_words '{' '.join(own)} {words_of(commands['palpate'])}' ;;"]
    for name, help_ in own.items():
        out.append(f"    {name})")
        cases = []
        for entry in help_.options():
            if not entry.value and not entry.choices:
                continue
            action = f"_palpate_words '{' '.join(entry.choices)}'" if entry.choices else {
                "file": "_palpate_files -f", "folder": "_palpate_files -d", "plan": "_palpate_plans"}.get(place_of(entry), ":")
            cases.append(f"        {'|'.join(entry.names)}) {action}; return ;;")
        if cases:
            out += ["      case $before in", *cases, "      esac"]
        kind = positional(help_)
        rest = f"_palpate_words '{' '.join(kind)}'" if isinstance(kind, list) else {
            "plan": "_palpate_plans", "file": "_palpate_files -f", "folder": "_palpate_files -d"}.get(kind, ":")
        out += [f"      if [[ $current == -* ]]; then _palpate_words '{words_of(help_)}'; else {rest}; fi", "      ;;"]
    out += ["  esac", "}", "complete -F _palpate palpate ./palpate"]
    return "\n".join(out) + "\n"


def quoted(text):
    return text.replace("\\", "\\\\").replace("'", "'\\''").replace("[", "\\[").replace("]", "\\]").replace(":", "\\:")


def zsh_action(kind):
    if isinstance(kind, list):
        return f"({' '.join(kind)})"
    return {"file": "_files", "folder": "_files -/", "plan": "_palpate_plans"}.get(kind, " ")


def zsh_option(entry):
    value = f":{quoted(entry.value or 'value')}:{zsh_action(entry.choices or place_of(entry))}" if entry.value or entry.choices else ""
    names = "'{" + ",".join(entry.names) + "}'" if len(entry.names) > 1 else entry.names[0]
    return f"'*{names}[{quoted(entry.text)}]{value}'"


def zsh_completion(commands):
    own = {name: help_ for name, help_ in commands.items() if name != "palpate"}
    out = ["#compdef palpate", "# zsh completion of palpate; made by cmake/manual/manual.py from the help texts", "",
           "_palpate_plans() {", "  local root=${${:-=${words[1]}}:A:h}", "  local -a plans=($root/experiments/plans/*.yaml(N:t:r) $root/../../share/palpate/experiments/plans/*.yaml(N:t:r))",
           "  _files", "  compadd -a plans", "}", "", "_palpate() {", "  local -a commands=("]
    out += [f"    '{name}:{quoted(help_.summary)}'" for name, help_ in own.items()]
    out += ["  )", "  if (( CURRENT == 2 )); then", "    _describe command commands", "    return", "  fi", "  local command=$words[2]", "  case $command in"]
    for name, help_ in own.items():
        out.append(f"    {name})")
        kind = positional(help_)
        arguments = [zsh_option(entry) for entry in help_.options()]
        arguments.append(f"'*: :{zsh_action(kind)}'")
        out.append("      shift words; (( CURRENT-- )); _arguments " + " \\\n        ".join(arguments) + " ;;")
    out += ["  esac", "}", "", '_palpate "$@"']
    return "\n".join(out) + "\n"


def fish_completion(commands):
    quote = lambda text: "'" + text.replace("\\", "\\\\").replace("'", "\\'") + "'"
    own = {name: help_ for name, help_ in commands.items() if name != "palpate"}
    out = ["# fish completion of palpate; made by cmake/manual/manual.py from the help texts", "complete -c palpate -f"]
    out += [f"complete -c palpate -n __fish_use_subcommand -a {name} -d {quote(help_.summary)}" for name, help_ in own.items()]
    for name, help_ in own.items():
        where = f"complete -c palpate -n '__fish_seen_subcommand_from {name}'"
        kind = positional(help_)
        if isinstance(kind, list):
            out.append(f"{where} -a {quote(' '.join(kind))}")
        elif kind:
            out.append(f"{where} -F")
        for entry in help_.options():
            names = " ".join(f"-l {each[2:]}" if each.startswith("--") else f"-s {each[1:]}" for each in entry.names)
            value = f" -x -a {quote(' '.join(entry.choices))}" if entry.choices else " -r -F" if place_of(entry) else " -x" if entry.value else ""
            out.append(f"{where} {names}{value} -d {quote(entry.text)}")
    return "\n".join(out) + "\n"


def files_of(root, version):
    """{path below OUT: text}."""
    commands = read_all(root)
    return {"man/man1/palpate.1": man_page(commands, read_environment(root), version),
            "bash-completion/completions/palpate": bash_completion(commands), "zsh/site-functions/_palpate": zsh_completion(commands),
            "fish/vendor_completions.d/palpate.fish": fish_completion(commands)}


def main():
    if len(sys.argv) != 4:
        print(__doc__, file=sys.stderr)
        return 2
    root, out = map(pathlib.Path, sys.argv[1:3])
    for name, text in files_of(root, sys.argv[3]).items():
        (out / name).parent.mkdir(parents=True, exist_ok=True)
        (out / name).write_text(text, encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main())
