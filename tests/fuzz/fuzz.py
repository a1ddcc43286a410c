"""Fuzzes the readers: every one for some seconds, from the corpus and the repository's own files.

    /usr/bin/python3 -B tests/fuzz/fuzz.py build/fuzz SECONDS [READER...] [--keep FOLDER]

Exit code 1 and the input that did it if a reader crashes, hangs for 10 s, takes more than 2 GB, or throws anything but an
InputError. --keep FOLDER collects the corpus that was grown, a folder a reader.
"""

import argparse
import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile

HERE = pathlib.Path(__file__).resolve().parent
ROOT = HERE.parent.parent
LARGEST_SEED = 16384

# Files of the repository that a reader takes, beside its own folder in the corpus.
OWN_FILES = {
    "plan": ["experiments/plans/*.yaml"],
    "scene": ["experiments/scenes/*.yaml"],
    "training": ["experiments/training/*.yaml"],
    "candidates": ["experiments/fit/candidates.yaml"],
    "contestant": ["reference/*/contestant.yaml"],
    "accepted": ["results/accepted/ci*.json"],
}
DICTIONARIES = {"medit": "medit.dict", "off": "surface.dict", "stl": "surface.dict", "obj": "surface.dict", "ply": "surface.dict",
                "off_surface": "surface.dict", "plan": "yaml.dict", "scene": "yaml.dict", "training": "yaml.dict",
                "candidates": "yaml.dict", "contestant": "yaml.dict"}


def gather_seeds(reader, folder):
    """Copies the seeds of a reader into a folder. Returns how many there are."""
    sources = [path for pattern in OWN_FILES.get(reader, []) for path in sorted(ROOT.glob(pattern))]
    sources += sorted((HERE / "corpus" / reader).glob("*"))
    for number, path in enumerate(sources):
        if path.stat().st_size <= LARGEST_SEED:
            shutil.copyfile(path, folder / f"{number:04}_{path.name}")
    return len(list(folder.iterdir()))


def fuzz(program, reader, seconds, keep):
    """Returns the line that is shown, and whether nothing was found."""
    with tempfile.TemporaryDirectory(prefix="palpate-fuzz-run-") as name:
        work = pathlib.Path(name)
        for part in ("seeds", "grown", "found"):
            (work / part).mkdir()
        seeds = gather_seeds(reader, work / "seeds")
        words = [str(program), f"-max_total_time={seconds}", "-timeout=10", "-rss_limit_mb=2048", "-seed=1", "-verbosity=1",
                 f"-max_len={LARGEST_SEED}", "-print_final_stats=1", f"-artifact_prefix={work}/found/"]
        if reader in DICTIONARIES or not reader.endswith("csv"):
            words.append(f"-dict={HERE / DICTIONARIES.get(reader, 'json.dict')}")
        environment = dict(os.environ, PALPATE_FUZZ_READER=reader, TMPDIR=str(work), ASAN_OPTIONS="detect_leaks=1")
        done = subprocess.run([*words, str(work / "grown"), str(work / "seeds")], env=environment, capture_output=True, text=True,
                              errors="replace", check=False)
        runs = re.search(r"number_of_executed_units:\s*(\d+)", done.stderr)
        covered = re.findall(r"cov: (\d+)", done.stderr)
        line = f"{reader:18} {seeds:4} seeds {runs.group(1) if runs else '?':>9} inputs, {covered[-1] if covered else '?':>6} edges"
        if keep:
            shutil.copytree(work / "grown", pathlib.Path(keep) / reader, dirs_exist_ok=True)
        found = list((work / "found").iterdir())
        if done.returncode == 0 and not found:
            return f"{line}, no finding", True
        tail = "\n".join(done.stderr.splitlines()[-60:])
        shown = "".join(f"\n{path.name}: {path.read_bytes()[:2000]!r}" for path in found)
        return f"{line}, FOUND\n{tail}{shown}", False


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n", 1)[0])
    parser.add_argument("build")
    parser.add_argument("seconds", type=int)
    parser.add_argument("readers", nargs="*")
    parser.add_argument("--keep")
    options = parser.parse_args()
    program = pathlib.Path(options.build).resolve() / "bin" / "palpate_fuzz"
    environment = {key: value for key, value in os.environ.items() if key != "PALPATE_FUZZ_READER"}
    listed = subprocess.run([str(program), "-runs=1"], env=environment, capture_output=True, text=True, check=False)
    known = [word for word in listed.stdout.split() if re.fullmatch(r"[a-z_]+", word)]
    unknown = [reader for reader in options.readers if reader not in known]
    if not known or unknown:
        print(f"unknown readers {unknown}; known are {known}", file=sys.stderr)
        return 2
    good = True
    for reader in options.readers or known:
        line, is_good = fuzz(program, reader, options.seconds, options.keep)
        print(line, flush=True)
        good = good and is_good
    return 0 if good else 1


if __name__ == "__main__":
    sys.exit(main())
