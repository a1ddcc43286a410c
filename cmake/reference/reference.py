"""Builds the reference of core's public headers with Doxygen, from the comments in them.

    reference.py ROOT OUT     writes OUT/html/index.html; prints every warning; exits with 1 if there is any, with 3 without doxygen
    reference.py --heading    a filter for Doxygen: makes the heading comment of a header the description of its file

Every type, function and constant has to be described. Members whose names say it may go without: a member that is not described is no
warning, a member that is described wrongly is one.
"""

import pathlib
import re
import shutil
import subprocess
import sys

# A member of a described struct or class, or an operator that does what is written.
SAYS_IT_ITSELF = re.compile(r"(Member .* of (class|struct) .*|Member operator.*) is not documented\.$")


def with_heading(text):
    """A header with its heading comment as a description that Doxygen sees."""
    lines = text.split("\n")
    end = next((i for i, line in enumerate(lines) if not line.startswith("//")), len(lines))
    return "\n".join(["/** @file"] + [line[2:] for line in lines[:end]] + ["*/"] + lines[end:]) if end > 0 else text


def build(root, out):
    """Runs Doxygen; returns its warnings, without those that are none here."""
    out.mkdir(parents=True, exist_ok=True)
    settings = (root / "cmake/reference/Doxyfile").read_text(encoding="utf-8")
    settings += f'\nOUTPUT_DIRECTORY = "{out}"\nINPUT_FILTER = "{sys.executable} -B {root}/cmake/reference/reference.py --heading"\n'
    done = subprocess.run(["doxygen", "-"], input=settings, capture_output=True, text=True, cwd=root, check=False)
    if done.returncode != 0:
        return [f"doxygen ended with {done.returncode}:\n{done.stdout[-2000:]}{done.stderr[-2000:]}"]
    return [line for line in done.stderr.splitlines() if line.strip() and not SAYS_IT_ITSELF.search(line)]


def main():
    if sys.argv[1] == "--heading":
        sys.stdout.write(with_heading(pathlib.Path(sys.argv[2]).read_text(encoding="utf-8")))
        return 0
    if shutil.which("doxygen") is None:
        print("doxygen is not installed: see packages.txt")
        return 3
    root, out = (pathlib.Path(each).resolve() for each in sys.argv[1:3])
    warnings = build(root, out)
    print("\n".join(warnings) if warnings else f"{out}/html/index.html: built without a warning")
    return 1 if warnings else 0


if __name__ == "__main__":
    sys.exit(main())
