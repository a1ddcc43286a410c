"""The nightly mode of continuous integration: `.ci/run full`.

    .ci/run full [STAGE...] [--folder DIR] [--list] [--no-build] [--seed N] [--audited N] [--operations N] [--fuzz-seconds S]
                         [--readers NAME...] [--fit-scenes N] [--soak-wall S]

Every stage by itself, one after another: one that fails, crashes or hangs does not stop the others. Without names all of them;
with names those, in the order of the list. DIR (made; build/nightly/DATE by default) gets a log a stage, what a stage leaves, and
the summary as summary.txt and summary.json, written anew after each stage. A DIR that has a summary already is gone on with: what
is named is done anew, the rest keeps its row.

The last lines are the summary. Exit code 1 if any row of it is not `passed`, 2 for bad usage, 130 after Ctrl-C (what was done is
in the summary). Seeds of what is drawn at random come from --seed, by default the date as a number, so that each night looks elsewhere; so does
which scenes are fitted.
"""

import argparse
import dataclasses
import datetime
import json
import os
import pathlib
import signal
import subprocess
import sys
import time

ROOT = pathlib.Path(__file__).resolve().parent.parent
PYTHON = [sys.executable, "-B"]
BUILD = ROOT / "build" / "release"
TESTS = str(BUILD / "bin" / "palpate_tests")
HOUR = 3600
FIT_SCENES = 40  # that tests/experiments/fit/fit_scenes.py has
PASSED, FAILED, TIMED_OUT, INTERRUPTED = "passed", "failed", "timed out", "interrupted"
STOPS = []  # not empty once somebody wants it to end


@dataclasses.dataclass
class Stage:
    """A command and what it is for. `limit_s`: it is killed then, with all that it started."""
    name: str
    what: str
    command: list
    environment: dict = dataclasses.field(default_factory=dict)
    limit_s: float = 4 * HOUR


def list_stages(options, folder):
    """All stages, in their order."""
    palpate = str(ROOT / "palpate")
    seed = str(options.seed)
    tidy, browser, slurm = r"^house\.(tidy|headers)$", r"^page\.|^live\.page", r"^campaign\."
    own_stages = "|".join([tidy, browser, slurm, r"^fuzz\.", r"^OperationFuzz\.AnyOrder"])
    without_cpp = r"^(house|report|docs|page|bench|campaign|fuzz)\.|^live\.page"
    pages = {"PALPATE_PAGES": str(folder / "contests")}
    soak = [*PYTHON, str(ROOT / "tests" / "soak" / "soak.py"), str(BUILD), "--seed", seed, "--wall", str(options.soak_wall)]
    fuzz = [*PYTHON, str(ROOT / "tests" / "fuzz" / "fuzz.py"), str(BUILD), str(options.fuzz_seconds), *options.readers, "--seed", seed, "--keep", str(folder / "fuzz")]
    foreign = [*PYTHON, str(ROOT / "tests" / "fuzz" / "foreign.py"), str(BUILD), str(options.fuzz_seconds), "--seed", seed]
    every = -(-FIT_SCENES // options.fit_scenes)  # rounded up: nights in a row leave none out
    fits = [*PYTHON, str(ROOT / "tests" / "experiments" / "fit" / "fit_scenes.py"), str(BUILD / "bin" / "palpate"), str(folder / "fits"),
            "--first", str(options.seed % every), "--every", str(every), "--scenes", str(options.fit_scenes)]
    return [
        Stage("build", "everything is built", [palpate, "test", "--full", "-N"]),
        Stage("contests", "small contests and their gates", [str(ROOT / ".ci" / "run"), "contests", str(folder / "contests")]),
        Stage("tests", "all tests in full, but those below", [palpate, "test", "--full", "-E", own_stages], limit_s=8 * HOUR),
        Stage("tidy", "each source through clang-tidy, each header by itself, from nothing", [palpate, "test", "--full", "-R", tidy]),
        Stage("browser", "the pages in a real browser", [palpate, "test", "--full", "-R", browser], pages),
        Stage("slurm", "a plan as jobs, on this machine and on a Slurm of its own", [palpate, "test", "--full", "-R", slurm]),
        Stage("audit", f"{options.audited:,} operations of whole methods", [TESTS, "--gtest_filter=Audit.*"],
              {"PALPATE_AUDIT_OPERATIONS": str(options.audited), "PALPATE_AUDIT_SEED": seed}),
        Stage("operations", f"{options.operations:,} single operations in any order", [TESTS, "--gtest_filter=OperationFuzz.AnyOrder*"],
              {"PALPATE_OPERATIONS_TOTAL": str(options.operations), "PALPATE_OPERATIONS_SEED": seed}),
        Stage("fuzz", f"{options.fuzz_seconds} s a reader under libFuzzer", fuzz),
        Stage("foreign", f"{options.fuzz_seconds} s a reader of a vendor's", foreign),
        Stage("sanitize", "the tests of C++ under the sanitizers", [palpate, "test", "-E", without_cpp], {"PALPATE_PRESET": "sanitize"},
              8 * HOUR),
        Stage("fits", f"at most {options.fit_scenes} of {FIT_SCENES} scenes are fitted, and held to what was promised", fits, limit_s=8 * HOUR),
        Stage("bench", "all benchmarks, the large ones too", [str(BUILD / "bin" / "palpate_bench"), f"--benchmark_out={folder / 'bench.json'}",
                                                             "--benchmark_out_format=json"], {"PALPATE_BENCH_LARGE": "1"}),
        Stage("soak", "24 simulated hours of palpation, springs", [*soak, "--model", "springs", "-o", str(folder / "soak")]),
        Stage("soak_tets", "the same, smoothed elements", [*soak, "--model", "smoothed", "-o", str(folder / "soak_tets")]),
    ]


def end_group(process, patience_s=20.0):
    """Ends a process and all of its group: asked first, then killed."""
    for signal_number in (signal.SIGTERM, signal.SIGKILL):
        try:
            os.killpg(process.pid, signal_number)
        except (ProcessLookupError, PermissionError):  # none left that is ours
            return
        try:
            process.wait(patience_s)
        except subprocess.TimeoutExpired:
            continue


def last_line(path):
    """The last line of a log that says anything."""
    with open(path, "rb") as file:
        file.seek(max(0, path.stat().st_size - 4096))
        lines = file.read().decode("utf-8", "replace").splitlines()
    return next((line.strip() for line in reversed(lines) if line.strip()), "")


def catch_stops():
    """From now on Ctrl-C and kill are noted, and end the stage that runs: not wherever they happen to come."""
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, lambda *_: STOPS.append(1))


def wait_for(process, until):
    """Waits for the end of a process, a stop or a time. Returns what became of it, and the exit code if it has one."""
    while True:
        try:
            code = process.wait(0.2)
            return PASSED if code == 0 else FAILED, code
        except subprocess.TimeoutExpired:
            if STOPS:
                return INTERRUPTED, None
            if time.monotonic() > until:
                return TIMED_OUT, None


def run_stage(stage, folder):
    """Runs one stage with its output in FOLDER/NAME.log. Returns its row of the summary."""
    log = folder / f"{stage.name}.log"
    row = {"stage": stage.name, "what": stage.what, "log": log.name, "code": None,
           "began": datetime.datetime.now(datetime.timezone.utc).isoformat(timespec="seconds")}
    began = time.monotonic()
    with open(log, "wb") as file:
        try:
            process = subprocess.Popen(stage.command, cwd=ROOT, env={**os.environ, **stage.environment}, stdin=subprocess.DEVNULL,
                                       stdout=file, stderr=subprocess.STDOUT, start_new_session=True)
        except OSError as error:
            file.write(f"cannot start {stage.command[0]}: {error.strerror}\n".encode())
            row["result"] = FAILED
        else:
            row["result"], row["code"] = wait_for(process, began + stage.limit_s)
            end_group(process)  # what a stage left running, too
    row["wall_s"] = round(time.monotonic() - began, 1)
    row["note"] = "" if row["result"] == PASSED else last_line(log)
    return row


def duration(seconds):
    whole = round(seconds)
    return f"{whole // 3600}:{whole // 60 % 60:02}:{whole % 60:02}"


def table(rows):
    """The summary as text: one line a stage, the note of what did not pass below its line; where stages ran at several commits, at which."""
    lines = [f"{'stage':11} {'result':11} {'time':>8}  what"]
    commits = {row.get("commit") for row in rows}
    places = {commit: f", at {commit or 'an unknown commit'}" for commit in commits} if len(commits) > 1 else {}
    for row in rows:
        lines.append(f"{row['stage']:11} {row['result']:11} {duration(row['wall_s']):>8}  {row['what']}{places.get(row.get('commit'), '')}")
        if row["result"] != PASSED:
            code = "" if row["code"] is None else f"exit code {row['code']}; "
            lines.append(f"{'':12}{code}{row['log']} ends: {row['note'][:160]}")
    bad = [row["stage"] for row in rows if row["result"] != PASSED]
    total = duration(sum(row["wall_s"] for row in rows))
    lines.append(f"{len(rows) - len(bad)} of {len(rows)} stages passed in {total}" + (f"; not: {', '.join(bad)}" if bad else ""))
    return "\n".join(lines) + "\n"


def write_summary(folder, about, rows):
    """Both forms of the summary, each beside its place and renamed."""
    for name, text in (("summary.txt", table(rows)), ("summary.json", json.dumps({**about, "stages": rows}, indent=1) + "\n")):
        beside = folder / f"{name}.part"
        beside.write_text(text, encoding="utf-8")
        os.replace(beside, folder / name)


def earlier_rows(folder):
    """The rows of a folder that is gone on with; a row without a commit of its own ran at its summary's."""
    path = folder / "summary.json"
    if not path.exists():
        return {}
    summary = json.loads(path.read_text(encoding="utf-8"))
    return {row["stage"]: {"commit": summary.get("commit"), **row} for row in summary["stages"]}


def run_stages(stages, all_names, folder, about, run=run_stage):
    """Runs the stages and keeps the summary in `folder`, rows in the order of `all_names`. Returns the rows."""
    done = {}
    rows = earlier_rows(folder)
    for stage in stages:
        print(f"== {stage.name}: {stage.what}", flush=True)
        done[stage.name] = {**run(stage, folder), "commit": about.get("commit")}
        rows = {**earlier_rows(folder), **done}  # read anew: another run may have written its own there meanwhile
        write_summary(folder, about, [rows[name] for name in all_names if name in rows])
        print(f"   {done[stage.name]['result']} after {duration(done[stage.name]['wall_s'])}", flush=True)
        if STOPS:
            break
    return [rows[name] for name in all_names if name in rows]


def read_options(arguments):
    today = datetime.datetime.now(datetime.timezone.utc)
    parser = argparse.ArgumentParser(prog=".ci/run full", description="Everything that holds this project, a stage at a time.")
    parser.add_argument("stages", nargs="*", metavar="STAGE")
    parser.add_argument("--folder", type=pathlib.Path, default=ROOT / "build" / "nightly" / f"{today:%Y%m%d-%H%M%S}")
    parser.add_argument("--list", action="store_true", help="list the stages, run none")
    parser.add_argument("--no-build", action="store_true", help="leave the stage build out: all is built")
    parser.add_argument("--seed", type=int, default=int(f"{today:%Y%m%d}"), help="of audit, operations, fuzz, foreign and soak (the date)")
    parser.add_argument("--audited", type=int, default=1_200_000, metavar="N", help="operations of the stage audit (1200000)")
    parser.add_argument("--operations", type=int, default=20_000_000, metavar="N", help="of the stage operations (20000000)")
    parser.add_argument("--fuzz-seconds", type=int, default=30, help="a reader (30)")
    parser.add_argument("--readers", nargs="+", default=[], metavar="NAME", help="that are fuzzed (all)")
    parser.add_argument("--fit-scenes", type=int, default=10, choices=range(1, FIT_SCENES + 1), metavar="N", help="of the stage fits, others each night (10)")
    parser.add_argument("--soak-wall", type=float, default=float(HOUR), help="seconds that a soak may take (3600)")
    options = parser.parse_args(arguments)
    options.folder = options.folder.resolve()
    known = [stage.name for stage in list_stages(options, options.folder)]
    unknown = [name for name in options.stages if name not in known]
    if unknown:
        parser.error(f"no stage {', '.join(unknown)}; there are {', '.join(known)}")
    return options


def main(arguments=None):
    options = read_options(arguments)
    stages = list_stages(options, options.folder)
    names = [stage.name for stage in stages]
    if options.list:
        print("\n".join(f"{stage.name:11} {stage.what}" for stage in stages))
        return 0
    chosen = [stage for stage in stages if not options.stages or stage.name in options.stages]
    if options.no_build:
        chosen = [stage for stage in chosen if stage.name != "build"]
    options.folder.mkdir(parents=True, exist_ok=True)
    try:
        earlier_rows(options.folder)
    except (ValueError, KeyError, TypeError) as error:
        print(f".ci/run full: {options.folder / 'summary.json'}: expected an earlier summary, found another thing: {error}", file=sys.stderr)
        return 2
    commit = subprocess.run(["git", "describe", "--always", "--dirty"], cwd=ROOT, capture_output=True, text=True, check=False).stdout.strip()
    about = {"commit": commit or None, "seed": options.seed, "processors": os.cpu_count()}
    catch_stops()
    rows = run_stages(chosen, names, options.folder, about)
    print(f"== summary, in {options.folder}")
    print(table(rows), end="")
    if STOPS:
        return 130
    return 0 if all(row["result"] == PASSED for row in rows) else 1


if __name__ == "__main__":
    sys.exit(main())
