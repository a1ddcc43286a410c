"""Fuzzes the readers: every one for some seconds, from the corpus and the repository's own files.

    /usr/bin/python3 -B tests/fuzz/fuzz.py build/release SECONDS [READER...] [--seed N] [--keep FOLDER]

The readers' sources are compiled anew by clang, with coverage and sanitizers; what they call besides comes from the libraries of
the build, so that there is no second build of everything. Exit code 1 and the input that did it if a reader crashes, hangs for 10 s, takes more than 2 GB, or throws anything but an
InputError. --seed N (1) is libFuzzer's: the same inputs again, as far as they get in the time. --keep FOLDER collects the corpus that was grown, a folder a
reader, and the inputs that were found, in READER.found.
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

# The sources of the readers.
SOURCES = ["tests/fuzz/reader_fuzz.cpp", "core/base/*.cpp", "core/mesh/io/medit.cpp", "core/mesh/io/off.cpp", "core/mesh/io/word_reader.cpp", "core/simplify/sizing/size_file.cpp",
           "core/springs/network/*_csv.cpp", "reference/door/*.cpp", "reference/reduced/pod_file.cpp", "reference/cgal/surface_file.cpp",
           "reference/cgal/*_claims.cpp", "experiments/text/yaml_value.cpp", "experiments/contestants/answer_form.cpp",
           "experiments/registry/*.cpp", "experiments/contestants/stop.cpp",
           "experiments/records/record_file.cpp", "experiments/gates/accepted_figures.cpp", "experiments/fit/candidates/fit_candidates.cpp",
           "experiments/plan_reader/*.cpp", "experiments/runner/read_plan.cpp", "experiments/contests/*/plan_*.cpp",
           "experiments/contests/stability/stability_answer.cpp", "experiments/contests/engine/engine_judge.cpp", "experiments/scene_reader/*.cpp",
           "experiments/spring_training/training_plan.cpp"]
COMPILER = "clang++-14"
FLAGS = ["-std=c++20", f"-I{ROOT}", "-isystem/usr/include/eigen3", "-O1", "-gline-tables-only", "-ffp-contract=off", "-DPALPATE_FUZZ_SURFACES",
         "-fsanitize=fuzzer-no-link,address,undefined", "-fno-sanitize-recover=all"]
LIBRARIES = ["experiments/libpalpate_experiments.a", "reference/libpalpate_adapter.a", "core/libpalpate_moving.a", "core/libpalpate_elastic.a",
             "reference/closed_form/libpalpate_closed_form.a", "core/libpalpate_core.a"]

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
                "candidates": "yaml.dict", "contestant": "yaml.dict", "pod_body": "numbers.dict"}


def is_newer(source, target, headers):
    return not target.exists() or max(source.stat().st_mtime, headers) > target.stat().st_mtime


def build_target(build):
    """Compiles and links the target below build/fuzz, as far as it has changed. Returns its path, or None after a message."""
    place = build / "fuzz"
    place.mkdir(exist_ok=True)
    headers = max(path.stat().st_mtime for part in ("core", "reference", "experiments") for path in (ROOT / part).rglob("*.h"))
    launcher = os.environ.get("CMAKE_CXX_COMPILER_LAUNCHER", "").split()
    objects = []
    for source in (path for pattern in SOURCES for path in sorted(ROOT.glob(pattern))):
        target = place / (str(source.relative_to(ROOT)).replace("/", "_") + ".o")
        objects.append(str(target))
        if not is_newer(source, target, headers):
            continue
        done = subprocess.run([*launcher, COMPILER, *FLAGS, "-c", str(source), "-o", str(target)], capture_output=True, text=True, check=False)
        if done.returncode != 0:
            print(done.stderr[-4000:], file=sys.stderr)
            return None
    program = build / "bin" / "palpate_fuzz"
    # The libraries have these sources too: the first definition, with coverage, is taken.
    words = [COMPILER, "-fsanitize=fuzzer,address,undefined", "-Wl,--allow-multiple-definition", "-o", str(program), *objects,
             *(str(build / library) for library in LIBRARIES), "-lyaml-cpp"]
    done = subprocess.run(words, capture_output=True, text=True, check=False)
    if done.returncode != 0:
        print(done.stderr[-4000:], file=sys.stderr)
        return None
    return program


def gather_seeds(reader, folder):
    """Copies the seeds of a reader into a folder. Returns how many there are."""
    sources = [path for pattern in OWN_FILES.get(reader, []) for path in sorted(ROOT.glob(pattern))]
    sources += sorted((HERE / "corpus" / reader).glob("*"))
    for number, path in enumerate(sources):
        if path.stat().st_size <= LARGEST_SEED:
            shutil.copyfile(path, folder / f"{number:04}_{path.name}")
    return len(list(folder.iterdir()))


def fuzz(program, reader, seconds, seed, keep):
    """Returns the line that is shown, and whether nothing was found."""
    with tempfile.TemporaryDirectory(prefix="palpate-fuzz-run-") as name:
        work = pathlib.Path(name)
        for part in ("seeds", "grown", "found"):
            (work / part).mkdir()
        seeds = gather_seeds(reader, work / "seeds")
        words = [str(program), f"-max_total_time={seconds}", "-timeout=10", "-rss_limit_mb=2048", f"-seed={seed}", "-verbosity=1",
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
        if keep and found:
            shutil.copytree(work / "found", pathlib.Path(keep) / f"{reader}.found", dirs_exist_ok=True)
        if done.returncode == 0 and not found:
            return f"{line}, no finding", True
        tail = "\n".join(done.stderr.splitlines()[-60:])
        shown = "".join(f"\n{path.name}: {path.read_bytes()[:2000]!r}" for path in found)
        return f"{line}, FOUND\n{tail}{shown}", False


def positive(text):
    """A seed: 0 would be another one each time."""
    number = int(text)
    if not 0 < number < 2**32:
        raise argparse.ArgumentTypeError(f"expected a whole number from 1 to {2**32 - 1}, found {text}")
    return number


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n", 1)[0])
    parser.add_argument("build")
    parser.add_argument("seconds", type=int)
    parser.add_argument("readers", nargs="*")
    parser.add_argument("--seed", type=positive, default=1, metavar="N")
    parser.add_argument("--keep", metavar="FOLDER")
    options = parser.parse_args()
    program = build_target(pathlib.Path(options.build).resolve())
    if program is None:
        return 3
    environment = {key: value for key, value in os.environ.items() if key != "PALPATE_FUZZ_READER"}
    # It ends before it runs, which libFuzzer keeps as a finding: in the build folder.
    listed = subprocess.run([str(program), "-runs=1"], cwd=program.parent, env=environment, capture_output=True, text=True, check=False)
    known = [word for word in listed.stdout.split() if re.fullmatch(r"[a-z_]+", word)]
    unknown = [reader for reader in options.readers if reader not in known]
    if not known or unknown:
        print(f"unknown readers {unknown}; known are {known}", file=sys.stderr)
        return 2
    good = True
    for reader in options.readers or known:
        line, is_good = fuzz(program, reader, options.seconds, options.seed, options.keep)
        print(line, flush=True)
        good = good and is_good
    return 0 if good else 1


if __name__ == "__main__":
    sys.exit(main())
