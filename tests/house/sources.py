"""Holds the C++ sources against the tools, and remembers what passed.

    sources.py headers|format|tidy ROOT BUILD [FILE...]
    sources.py headers|tidy ROOT BUILD --record

headers  every header of ours compiles alone, with the compiler and the include paths of the build
format   clang-format 14 would change nothing
tidy     clang-tidy 14 finds nothing, with the compile commands of the build

A file that passed is not looked at again until its text, a header of ours that it includes, the settings, the flags or
the tool changes; where it lies and what it is called counts for nothing. The marks are kept below BUILD/checked. Without FILE all files that git tracks are held (or, outside
a git checkout, all that are there). Exits with 1 if a file fails, with 2 if a tool is missing.

A fresh checkout has no marks. For it tests/house/held.txt lists the keys of what has passed, written by --record from the marks of
a build that has looked at the files itself; a file that is not in the list as it stands is looked at. With PALPATE_FULL=1 in the
environment (`palpate test --full`) the list counts for nothing.
"""

import concurrent.futures
import hashlib
import json
import os
import pathlib
import re
import shlex
import shutil
import subprocess
import sys

INCLUDE = re.compile(r'^\s*#\s*include\s*"([^"]+)"', re.MULTILINE)
INCLUDED = re.compile(r'^[ \t]*#\s*include\s*"[^"]+".*\n?', re.MULTILINE)
HOST_CPU = re.compile(rb"Host CPU: .*")  # in what clang-tidy says of its version; what it finds does not depend on the machine
BLANK = re.compile(r"\n{2,}")
FOLDERS = ("core", "live", "reference", "experiments", "tests")
HELD = "tests/house/held.txt"
RECORDED = ("headers", "tidy")
KEY_LENGTH = 20
TOGETHER = 100  # files in one run of clang-format, which takes longer to start than to read one
# Options for the compiler's own sake, where headers are precompiled and where the sources of a folder are compiled together.
COMPILER_ALONE = ("-Winvalid-pch", "-Wno-stringop-overflow", "-Wno-array-bounds", "-Wno-subobject-linkage")
# Left out of tests: what costs half of the time there and asks about paths through a program. They are run, with sanitizers too
# (preset debug); style, names and modernize stay.
OF_PROGRAMS = "-clang-analyzer-*,-bugprone-*,-performance-unnecessary-value-param"
# Checks left out of a source that reaches a vendor's header.
LEFT_OUT = {
    b"<gtest/gtest.h>": OF_PROGRAMS,
    b"<gmock/gmock.h>": OF_PROGRAMS,
    # walks the header's own functions for longer than all other checks take together
    b"<CLI/CLI.hpp>": "-performance-unnecessary-value-param",
    # alarms at the loop that the library asks for, for (auto _ : state)
    b"<benchmark/benchmark.h>": "-clang-analyzer-deadcode.DeadStores",
}


def list_sources(root, suffixes):
    """The C++ files of ours, relative to the root, sorted."""
    done = subprocess.run(["git", "-C", root, "ls-files", "-z", "--cached", "--others", "--exclude-standard", "--", *FOLDERS],
                          capture_output=True, text=True)
    if done.returncode == 0:
        names = [name for name in done.stdout.split("\0") if name and (root / name).is_file()]
    else:
        names = [path.relative_to(root).as_posix() for folder in FOLDERS for path in (root / folder).rglob("*")
                 if path.is_file()]
    return sorted(name for name in names if name.endswith(suffixes))


def headers_below(root, name, seen):
    """Adds to `seen` the files of ours that a file reaches by its includes, itself among them."""
    if name in seen or not (root / name).is_file():
        return seen
    seen.add(name)
    for match in INCLUDE.finditer((root / name).read_text(encoding="utf-8", errors="replace")):
        headers_below(root, match.group(1), seen)
    return seen


def text_with_headers(root, name):
    """The text of a file, then those of all headers of ours below it, without the lines that include ours: the same wherever they lie."""
    texts = {each: BLANK.sub("\n\n", INCLUDED.sub("", (root / each).read_text(encoding="utf-8", errors="replace")))
             for each in headers_below(root, name, set())}
    own = texts.pop(name, "")
    return "\0".join([own, *sorted(texts.values())]).encode()


def without_precompiled(words):
    """A command without the compiler's own precompiled header and the options for its sake: no other tool reads it, nothing depends on it."""
    kept, is_file = [], False
    for word, following in zip(words, [*words[1:], ""]):
        if is_file or word in COMPILER_ALONE:
            is_file = False
        elif word == "-include" and following.endswith("/cmake_pch.hxx"):
            is_file = True
        else:
            kept.append(word)
    return kept


def read_commands(build):
    """The compile command of each source, as a list of words, by its absolute path. A source that is compiled together with others
    (cmake/unite.cmake) has the command that it would have alone."""
    commands = {}
    for entry in json.loads((build / "compile_commands.json").read_text(encoding="utf-8")):
        file, words = entry["file"], without_precompiled(shlex.split(entry["command"]))
        if "/Unity/" not in file:
            commands[file] = words
            continue
        for each in INCLUDE.findall((pathlib.Path(entry["directory"]) / file).read_text(encoding="utf-8")):
            commands[each] = [each if word == file else word for word in words]
    return commands


def write_commands(build, commands):
    """The same commands for clang-tidy; returns their folder."""
    folder = build / "checked" / "commands"
    folder.mkdir(parents=True, exist_ok=True)
    entries = [{"directory": str(build), "file": file, "arguments": words} for file, words in commands.items()]
    (folder / "compile_commands.json").write_text(json.dumps(entries), encoding="utf-8")
    return folder


def flags_near(root, commands, header):
    """Compiler and language flags of a source beside the header, or of one in a folder above it."""
    folder = (root / header).parent
    while True:
        for source, words in sorted(commands.items()):
            if pathlib.Path(source).is_relative_to(folder):
                kept = [words[0]]
                for i, word in enumerate(words[1:], start=1):
                    if word.startswith(("-I", "-D", "-std", "-W", "-f")):
                        kept.append(word)
                    elif words[i - 1] == "-isystem":
                        kept += ["-isystem", word]
                return kept
        if folder == root:
            raise SystemExit("no compile command below the root: configure the build first")
        folder = folder.parent


def output_of(words):
    """The files that a compile command writes."""
    return [word for before, word in zip(words, words[1:]) if before in ("-o", "-MF", "-MT", "-MQ")]


class Check:
    """What one kind of check runs for a file, and on which files."""

    def __init__(self, kind, root, build):
        self.kind, self.root, self.build = kind, root, build
        self.suffixes = {"headers": (".h",), "format": (".h", ".cpp"), "tidy": (".cpp",)}[kind]
        self.held = set() if os.environ.get("PALPATE_FULL") == "1" else set(read_held(root, kind).values())
        self.settings = b""
        self.clean = set()  # by `run_together`
        if kind != "format":
            self.commands = read_commands(build)
        if kind == "tidy":
            self.commands_folder = write_commands(build, self.commands)
        if kind != "headers":
            self.tool = find_tool("clang-" + kind)
            self.settings = (root / f".clang-{kind}").read_bytes()
            version = subprocess.run([self.tool, "--version"], capture_output=True, check=True).stdout
            self.settings += HOST_CPU.sub(b"Host CPU: (unknown)", version)

    def command(self, name):
        """The words to run; None for a source that this build leaves out (its vendor is missing, or tests/consumer)."""
        path = str(self.root / name)
        if self.kind == "format":
            return [self.tool, "--dry-run", "-Werror", path]
        if self.kind == "tidy":
            return self.tidy_command(name) if path in self.commands else None
        return flags_near(self.root, self.commands, name) + ["-fsyntax-only", "-x", "c++", "-include", path, "/dev/null"]

    def tidy_command(self, name):
        text = text_with_headers(self.root, name)
        left_out = [checks for header, checks in LEFT_OUT.items() if b"#include " + header in text]
        checks = ["--checks=" + ",".join(left_out)] if left_out else []
        return [self.tool, "--quiet", *checks, "-p", str(self.commands_folder), str(self.root / name)]

    def key(self, name, words):
        """What the outcome depends on, the same in every checkout and in every folder: paths and a compiler's cache count for nothing."""
        build_words = self.commands.get(str(self.root / name), []) if self.kind == "tidy" else []
        own_paths = {str(self.root / name), "ccache", *output_of(build_words)}
        words = [str(self.build) if self.kind == "tidy" and word == str(self.commands_folder) else word for word in words]
        command = "\0".join(word for word in [*words, *build_words] if word not in own_paths)
        digest = hashlib.sha256(self.settings)
        digest.update(command.replace(str(self.build), "BUILD").replace(str(self.root), "ROOT").encode())
        digest.update((self.root / name).read_bytes() if self.kind == "format" else text_with_headers(self.root, name))
        return digest.hexdigest()

    def mark(self, key):
        return self.build / "checked" / self.kind / key

    def is_known(self, key):
        return self.mark(key).exists() or key[:KEY_LENGTH] in self.held

    def run_together(self, names, pool):
        """Formats alone: many files in one run of the tool. Where it finds nothing in any of them, none needs a run of its own."""
        if self.kind != "format":
            return
        unknown = [name for name in names if not self.is_known(self.key(name, self.command(name)))]
        parts = [unknown[first:first + TOGETHER] for first in range(0, len(unknown), TOGETHER)]

        def is_clean(part):
            return subprocess.run([*self.command(part[0])[:-1], *part], capture_output=True, cwd=self.root, check=False).returncode == 0

        for part, clean in zip(parts, pool.map(is_clean, parts)):
            self.clean.update(part if clean else [])

    def hold(self, name):
        """("passed" | "known" | "left out" | "failed", what the tool said)."""
        words = self.command(name)
        if words is None:
            return "left out", ""
        key = self.key(name, words)
        mark = self.mark(key)
        if self.is_known(key):
            return "known", ""
        if name not in self.clean:
            done = subprocess.run([word for word in words if word != "ccache"], capture_output=True, text=True, cwd=self.root)
            if done.returncode != 0:
                return "failed", done.stdout + done.stderr
        mark.parent.mkdir(parents=True, exist_ok=True)
        mark.touch()
        return "passed", ""

    def record(self, names):
        """Writes the keys of the files that passed here or were known into the list, beside those of the other kinds; returns their number."""
        keys = {name: self.key(name, words) for name in names if (words := self.command(name)) is not None}
        keys = {name: key[:KEY_LENGTH] for name, key in keys.items() if self.is_known(key)}
        lines = [f"{kind} {name} {key}" for kind in RECORDED
                 for name, key in sorted((keys if kind == self.kind else read_held(self.root, kind)).items())]
        (self.root / HELD).parent.mkdir(parents=True, exist_ok=True)
        (self.root / HELD).write_text("\n".join(lines) + "\n", encoding="utf-8")
        return len(keys)


def read_held(root, kind):
    """The recorded key of each file, by its name."""
    path = root / HELD
    lines = path.read_text(encoding="utf-8").splitlines() if path.is_file() else []
    return {name: key for kind_of_line, name, key in map(str.split, filter(None, lines)) if kind_of_line == kind}


def find_tool(name):
    """The tool of the version that the settings are for."""
    for candidate in (name + "-14", name):
        path = shutil.which(candidate)
        if path and " 14." in subprocess.run([path, "--version"], capture_output=True, text=True).stdout:
            return path
    print(f"{name} 14 is missing (packages.txt)", file=sys.stderr)
    raise SystemExit(2)


def main():
    kind, root, build = sys.argv[1], pathlib.Path(sys.argv[2]).resolve(), pathlib.Path(sys.argv[3]).resolve()
    check = Check(kind, root, build)
    if sys.argv[4:] == ["--record"]:
        print(f"{kind}: {check.record(list_sources(root, check.suffixes))} files recorded")
        return 0
    names = sys.argv[4:] or list_sources(root, check.suffixes)
    counts = {"passed": 0, "known": 0, "left out": 0, "failed": 0}
    with concurrent.futures.ThreadPoolExecutor(max_workers=len(os.sched_getaffinity(0))) as pool:
        check.run_together(names, pool)
        for name, (outcome, said) in zip(names, pool.map(check.hold, names)):
            counts[outcome] += 1
            if outcome == "failed":
                print(f"{name}:\n{said}")
    print(f"{kind}: {len(names)} files: " + ", ".join(f"{count} {outcome}" for outcome, count in counts.items()))
    return 1 if counts["failed"] or not names else 0


if __name__ == "__main__":
    sys.exit(main())
