"""Fuzzes the readers that are vendors' libraries (gmsh, VTK) as a user meets them: damaged files given to `palpate quality`.

    /usr/bin/python3 -B tests/fuzz/foreign.py build/release SECONDS [ENDING...] [--seed N]

Each file is a small valid one of the corpus with bits, numbers and parts changed at random. It is read, or refused with one
message and exit code 2; nothing is left running, nothing but the file's own folder is touched. Exit code 1 and the file
otherwise.
"""

import argparse
import os
import pathlib
import random
import re
import subprocess
import sys
import tempfile
import time

HERE = pathlib.Path(__file__).resolve().parent
NUMBERS = [b"0", b"-1", b"1", b"3", b"255", b"65536", b"2147483647", b"2147483648", b"4294967295", b"99999999999",
           b"9223372036854775807", b"18446744073709551616", b"1e400", b"nan", b"-nan", b"inf", b""]


def mutate(data, other, dice):
    """A damaged copy; `other` is a file of the same kind whose parts may come in."""
    data = bytearray(data)
    for _ in range(dice.choice([1, 1, 1, 2, 3, 8])):
        kind = dice.randrange(7)
        place = dice.randrange(len(data) + 1) if data else 0
        if kind == 0 and data:
            data[place % len(data)] ^= 1 << dice.randrange(8)
        elif kind == 1:
            data[place:place] = bytes(dice.randrange(256) for _ in range(dice.randrange(1, 9)))
        elif kind == 2:
            del data[place:place + dice.randrange(1, 65)]
        elif kind == 3:
            del data[place:]
        elif kind == 4:
            start = dice.randrange(len(other) + 1)
            data[place:place] = other[start:start + dice.randrange(1, 200)]
        elif kind == 5:
            numbers = list(re.finditer(rb"-?\d+(\.\d+)?(e-?\d+)?", bytes(data)))
            if numbers:
                chosen = dice.choice(numbers)
                data[chosen.start():chosen.end()] = dice.choice(NUMBERS)
        else:
            lines = bytes(data).split(b"\n")
            chosen = dice.randrange(len(lines))
            lines[chosen:chosen] = [lines[chosen]] * dice.randrange(1, 4)
            data = bytearray(b"\n".join(lines))
    return bytes(data)


def left_running(folder):
    """Processes that name the folder in their command line."""
    found = []
    for entry in pathlib.Path("/proc").glob("[0-9]*"):
        try:
            if str(folder).encode() in (entry / "cmdline").read_bytes():
                found.append(entry.name)
        except OSError:
            continue
    return found


def fault_of(program, file, folder):
    """What is wrong with how a file was taken; empty if nothing is."""
    before = sorted(path.name for path in folder.iterdir())
    try:
        done = subprocess.run([program, "quality", str(file)], capture_output=True, text=True, errors="replace", timeout=240, check=False, cwd=folder,
                              env=dict(os.environ, TMPDIR=str(folder)))
    except subprocess.TimeoutExpired:
        return "it takes longer than its bounds allow"
    if done.returncode not in (0, 1, 2):
        return f"exit code {done.returncode}: {done.stderr}"
    if done.returncode == 2 and done.stderr.count("\n") != 1:
        return f"{done.stderr.count(chr(10))} lines in place of one message: {done.stderr}"
    if left_running(folder):
        return "a process is left"
    after = sorted(path.name for path in folder.iterdir())
    return "" if after == before else f"files are left: {after}"


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n", 1)[0])
    parser.add_argument("build")
    parser.add_argument("seconds", type=float)
    parser.add_argument("endings", nargs="*", default=["msh", "vtk", "vtu"])
    parser.add_argument("--seed", type=int, default=1)
    options = parser.parse_args()
    program = str(pathlib.Path(options.build).resolve() / "bin" / "palpate")
    good = True
    for ending in options.endings or ["msh", "vtk", "vtu"]:
        seeds = [path.read_bytes() for path in sorted((HERE / "corpus" / ending).iterdir())]
        dice = random.Random(f"{options.seed} {ending}")
        runs, end = 0, time.monotonic() + options.seconds
        with tempfile.TemporaryDirectory(prefix="palpate-foreign-") as name:
            folder = pathlib.Path(name)
            file = folder / f"any.{ending}"
            while time.monotonic() < end:
                data = mutate(dice.choice(seeds), dice.choice(seeds), dice)
                file.write_bytes(data)
                fault = fault_of(program, file, folder)
                runs += 1
                if fault:
                    print(f"{ending}: seed {options.seed}, input {runs}: {fault}\n{data[:3000]!r}", flush=True)
                    good = False
                    break
        print(f"{ending:18} {len(seeds):4} seeds {runs:>9} inputs, {'no finding' if good else 'FOUND'}", flush=True)
    return 0 if good else 1


if __name__ == "__main__":
    sys.exit(main())
