"""What a large campaign costs: measures the figures of docs/scaling.md anew, and prints them as its tables.

    /usr/bin/python3 -B tests/campaign/scaling_figures.py PALPATE [--only NAME]... [--most RECORDS] [--most-jobs JOBS]

NAME is one of run, report, gate, jobs, take, side_by_side, ranks. Times are of processor and of the clock; where something else runs on the machine only those of
the processor are worth something, and they too grow by a third or more. It is a tool, no test: nothing is held against a bound.
"""

import argparse
import json
import os
import pathlib
import statistics
import subprocess
import tempfile
import time
from dataclasses import dataclass

from many_records import LABELS, fail_first, make_run, plan_text

LONGEST_S = 900  # of one command


@dataclass
class Cost:
    wall_s: float
    processor_s: float
    memory_mb: float
    code: int


def cost_of(*words, cwd=None):
    """Runs a command to its end, or for as long as it may."""
    began = time.monotonic()
    running = subprocess.Popen(["timeout", str(LONGEST_S), *map(str, words)], cwd=cwd, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    _, status, usage = os.wait4(running.pid, 0)
    running.returncode = os.waitstatus_to_exitcode(status)
    return Cost(time.monotonic() - began, usage.ru_utime + usage.ru_stime, usage.ru_maxrss / 1000, running.returncode)


def table(title, heads, rows):
    print(f"\n{title}\n\n| {' | '.join(heads)} |\n|{'---|' * len(heads)}")
    for row in rows:
        print(f"| {' | '.join(str(each) for each in row)} |", flush=True)


def cost_cells(cost):
    if cost.code != 0:
        return [f"ended with {cost.code} after {cost.wall_s:.0f} s", "", f"{cost.memory_mb:.0f}"]
    return [f"{cost.wall_s:.1f}", f"{cost.processor_s:.1f}", f"{cost.memory_mb:.0f}"]


COST_HEADS = ["clock, s", "processor, s", "memory, MB"]


def write_plan(folder, meshes, seeds, repeats, timed=True):
    plan = pathlib.Path(folder) / "plan.yaml"
    text = plan_text(meshes, seeds, repeats)
    untimed = text.replace("warmup: 0,", "warmup: 0, timed: false,").replace(", kernel_s]", "]")
    plan.write_text(text if timed else untimed, encoding="utf-8")
    return plan


def measure_run(options):
    """A record's bytes, a case's files, and what the runner adds to what a contestant takes."""
    with tempfile.TemporaryDirectory(prefix="palpate-scaling-") as folder:
        plan = write_plan(folder, 4, 10, 3)
        cost = cost_of(options.program, "run", plan, "--out", f"{folder}/run", "--no-report")
        lines = (pathlib.Path(folder) / "run" / "records.jsonl").read_text(encoding="utf-8").splitlines()
        records = [json.loads(line) for line in lines]
        answers = [record for record in records if record["contestant"]]
        own = sum(record["wall_s"] for record in answers)
        files = list((pathlib.Path(folder) / "run" / "meshes").rglob("*.mesh"))
        table("A small run, a cube of 216 vertices", ["what", "figure"], [
            ["repeats", len(answers)], ["bytes a record", round(statistics.mean(map(len, lines)))],
            ["files a case", f"{(len(files) - 4) * 3 / len(answers):.2f}"],
            ["bytes of provenance.json", (pathlib.Path(folder) / "run" / "provenance.json").stat().st_size],
            ["clock, ms a repeat", f"{1000 * cost.wall_s / len(answers):.1f}"], ["of it the contestant's process, ms", f"{1000 * own / len(answers):.1f}"]])


def measure_report(options):
    rows, size = [], 10_000
    while size <= options.most:
        with tempfile.TemporaryDirectory(prefix="palpate-scaling-") as folder:
            run = pathlib.Path(folder) / "run"
            count = make_run(options.program, run, size)
            began = time.process_time()
            with open(run / "records.jsonl", "rb") as lines:
                for line in lines:
                    json.loads(line)
            alone = time.process_time() - began
            report = cost_of(options.program, "report", run)
            again = cost_of(options.program, "run", run.with_suffix(".yaml"), "--out", run, "--resume", "--no-report")
            page = (run / "report.html").stat().st_size
            rows.append([f"{count:,}", f"{(run / 'records.jsonl').stat().st_size / 1e6:.0f}", *cost_cells(report), f"{report.processor_s / alone:.2f}",
                         f"{page / 1e6:.1f}", *cost_cells(again)])
        size *= 10
    table("A report and a resumption with nothing to run, ten repeats a case", ["records", "MB of records", *(f"report: {head}" for head in COST_HEADS),
          "report over json.loads of all lines", "page, MB", *(f"resumption: {head}" for head in COST_HEADS)], rows)


def measure_gate(options):
    """A run held against all figures that it has, newly accepted and again; and a resumption that runs anew what failed, which is one input."""
    rows, size = [], 10_000
    while size <= options.most:
        with tempfile.TemporaryDirectory(prefix="palpate-scaling-") as folder:
            run = pathlib.Path(folder) / "run"
            count = make_run(options.program, run, size)
            accepted = pathlib.Path(folder) / "accepted.json"
            gate = [options.program, "gate", run, "--accepted"]
            figures = [cost_of(*gate, accepted, "--update"), cost_of(*gate, accepted)]
            fail_first(run / "records.jsonl")
            again = cost_of(options.program, "run", run.with_suffix(".yaml"), "--out", run, "--resume", "--retry-failed", "--no-report")
            rows.append([f"{count:,}", f"{len(json.loads(accepted.read_text(encoding='utf-8'))['figures']):,}",
                         *(cell for cost in (*figures, again) for cell in cost_cells(cost))])
        size *= 10
    table("A gate and a resumption that runs one failed repeat anew, ten repeats a case",
          ["records", "figures", *(f"{what}: {head}" for what in ("gate --update", "gate", "--retry-failed") for head in COST_HEADS)], rows)


def measure_jobs(options):
    """The workflow of one job a case, Snakemake's look at all of it, and its run of jobs that do nothing."""
    rows, jobs = [], 100
    while jobs <= options.most_jobs:
        for seconds in (1, 1000) if jobs >= 1000 else (1,):
            with tempfile.TemporaryDirectory(prefix="palpate-scaling-") as folder:
                meshes = max(2, jobs // 10_000)
                seeds = -(-jobs // (meshes * len(LABELS)))
                plan = write_plan(folder, meshes, seeds, 1, timed=False)
                written = cost_of(options.program, "workflow", plan, "-o", f"{folder}/jobs", "--job-seconds", seconds, "--unknown-seconds", 1)
                parts = len(list((pathlib.Path(folder) / "jobs" / "cases").glob("*.txt")))
                looked = cost_of("/usr/bin/snakemake", "-n", "-q", "-j2", cwd=f"{folder}/jobs")
                idle = idle_run(pathlib.Path(folder) / "jobs") if parts <= options.most_idle else ["not run", "", ""]
                rows.append([f"{seeds * meshes * len(LABELS):,}", f"{parts:,}", *cost_cells(written), *cost_cells(looked), *idle])
        jobs *= 10
    table("Jobs", ["cases", "parts", *(f"{what}: {head}" for what in ("palpate workflow", "snakemake -n", "snakemake, idle jobs") for head in COST_HEADS)], rows)


def idle_run(jobs):
    """What Snakemake takes for its jobs where these do nothing."""
    campaign = json.loads((jobs / "campaign.json").read_text(encoding="utf-8"))
    (jobs / "campaign.json").write_text(json.dumps({**campaign, "palpate": "/bin/true"}), encoding="utf-8")
    return cost_cells(cost_of("/usr/bin/snakemake", "-q", "-j2", cwd=jobs))


def measure_take(options):
    rows = []
    for parts in (4, 16, 64):
        with tempfile.TemporaryDirectory(prefix="palpate-scaling-") as folder:
            plan = write_plan(folder, 2, parts * 2, 1, timed=False)
            cost_of(options.program, "workflow", plan, "-o", f"{folder}/jobs", "--job-seconds", 12, "--unknown-seconds", 1)
            named = sorted((pathlib.Path(folder) / "jobs" / "cases").glob("*.txt"))
            each = [cost_of(options.program, "run", plan, "--part", part, "--out", f"{folder}/parts/{part.stem}").wall_s for part in named]
            taken = cost_of(options.program, "run", plan, "--take", f"{folder}/parts", "--out", f"{folder}/run", "--no-report")
            rows.append([len(named), parts * 2 * 2 * len(LABELS), f"{statistics.median(each):.2f}", *cost_cells(taken)])
    table("Parts taken into one run", ["parts", "records", "a part's own run, s", *COST_HEADS], rows)


def measure_side_by_side(options):
    """Cases without times, one and two at once: the same work (strong), and work that grows with the processes (weak)."""
    rows = []
    for what, jobs, seeds in (("strong", 1, 16), ("strong", 2, 16), ("weak", 1, 8), ("weak", 2, 16)):
        with tempfile.TemporaryDirectory(prefix="palpate-scaling-") as folder:
            plan = write_plan(folder, 4, seeds, 2, timed=False)
            plan.write_text(plan.read_text(encoding="utf-8").replace("vertices: 216", "vertices: 8000"), encoding="utf-8")
            cost_of(options.program, "run", plan, "--out", f"{folder}/first", "--prepare")
            cost = cost_of(options.program, "run", plan, "--out", f"{folder}/run", "--no-report", "--jobs", jobs)
            rows.append([what, jobs, 4 * seeds * len(LABELS) * 2, *cost_cells(cost)])
    table("Side by side, a cube of 8,000 vertices", ["scaling", "--jobs", "repeats", *COST_HEADS], rows)


RANKS_PLAN = """schema: palpate/plan/1
question: What do two MPI ranks bring?
contest: deform
scenes: [kidney_gravity]
sweep: {vertices: [VERTICES]}
reference: {method: fem.p1, levels: 1}
contestants:
  - {method: fem.METHOD, label: it}
run: {repeats: 5, warmup: 1, timeout_s: 600, memory_mib: 8192, mpi_ranks: RANKS}
measure: [displacement_l2, kernel_s]
"""


def measure_ranks(options):
    """Finite elements on one rank and two: the same mesh (strong), and a mesh that grows with the ranks (weak)."""
    rows = []
    for method, size in (("p1", 20_000), ("p2", 3_000)):
        for what, ranks, vertices in (("strong", 1, size), ("strong", 2, size), ("weak", 1, size), ("weak", 2, 2 * size)):
            with tempfile.TemporaryDirectory(prefix="palpate-scaling-") as folder:
                plan = pathlib.Path(folder) / "plan.yaml"
                text = RANKS_PLAN.replace("METHOD", method).replace("VERTICES", str(vertices)).replace("RANKS", str(ranks))
                plan.write_text(text, encoding="utf-8")
                cost_of(options.program, "run", plan, "--out", f"{folder}/run", "--no-report")
                lines = (pathlib.Path(folder) / "run" / "records.jsonl").read_text(encoding="utf-8").splitlines()
                records = [record for record in map(json.loads, lines) if record["label"] == "it" and not record["warmup"]]
                kernel = [record["kernel_s"] for record in records if record["outcome"] == "accepted"]
                whole = [record["wall_s"] for record in records if record["outcome"] == "accepted"]
                memory = max((record["peak_rss_bytes"] for record in records), default=0)
                spread = f"{statistics.median(kernel):.2f} ({min(kernel):.2f} to {max(kernel):.2f})" if kernel else "none"
                rows.append([f"fem.{method}", what, ranks, f"{vertices:,}", len(kernel), spread,
                             f"{statistics.median(whole):.2f}" if whole else "none", f"{memory / 1e6:.0f}"])
    table("Ranks, a kidney under gravity", ["method", "scaling", "ranks", "vertices", "repeats", "kernel by the clock, s", "whole process, s", "memory, MB"], rows)


MEASURES = {"run": measure_run, "report": measure_report, "gate": measure_gate, "jobs": measure_jobs, "take": measure_take, "side_by_side": measure_side_by_side, "ranks": measure_ranks}


def main():
    parser = argparse.ArgumentParser(description="Measures the figures of docs/scaling.md on campaigns anew.")
    parser.add_argument("program", metavar="PALPATE")
    parser.add_argument("--only", action="append", choices=list(MEASURES))
    parser.add_argument("--most", type=int, default=1_000_000, metavar="RECORDS")
    parser.add_argument("--most-jobs", type=int, default=10_000, metavar="JOBS")
    parser.add_argument("--most-idle", type=int, default=2000, metavar="JOBS")
    options = parser.parse_args()
    print(f"load at the start {os.getloadavg()[0]:.2f}, {os.cpu_count()} processors")
    for name in options.only or MEASURES:
        MEASURES[name](options)
    print(f"\nload at the end {os.getloadavg()[0]:.2f}")


if __name__ == "__main__":
    main()
