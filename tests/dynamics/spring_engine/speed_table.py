"""Runs the benchmark of a step and holds it against its targets.

    speed_table.py BENCH [--large] [--repetitions N] [--json FILE] [--clock wall|cpu]
    speed_table.py --read FILE [--clock wall|cpu]

BENCH is build/release/bin/palpate_bench. --large adds 1M vertices (some minutes). All rows come from one process, in
random order, N times (default 5); a figure is the median over the repetitions, its spread (largest - smallest) / median.
A target is open where the spread of its rows (of both, in a ratio) is larger than the margin |measured / bound - 1|, or is
not known because there is one repetition.
--clock cpu takes the time that the thread ran instead of the wall clock's for what runs on one thread: for a machine
that others use too. --json keeps the rows, a line each, --read reads such a file: docs/engine_speed.md's are in
results/benchmarks.
"""

import argparse
import json
import os
import re
import statistics
import subprocess
import sys
import tempfile

CELLS = {10: "1.3k", 21: "10k", 46: "100k", 100: "1M"}
NAME = re.compile(r"^(bench_\w+(?:<\w+>)?)/(\d+)/(\d+)(?:/|$)")
OURS = "bench_plain<float>"
LABELS = {  # in the table's order
    (OURS, 1): "ours, single precision",
    (OURS, 2): "... two threads",
    ("bench_portable", 1): "ours, without AVX2",
    ("bench_portable", 2): "... two threads",
    ("bench_plain<double>", 1): "ours, double precision",
    ("bench_plain<double>", 2): "... two threads",
    ("bench_every_force", 1): "the engine of every force",
    ("bench_every_force", 2): "... two threads",
    ("bench_pointers", 1): "pointers, as made",
    ("bench_pointers_shuffled", 1): "pointers, shuffled",
    ("bench_bullet_springs", 1): "Bullet's springs",
    ("bench_bullet_constraints_step", 1): "Bullet's constraints, a step",
    ("bench_bullet_constraints_sweep", 1): "Bullet's constraints, a sweep",
}
# Of what Google Benchmark writes itself: what is no row's own, and what is the machine's.
LEFT_OUT_OF_ROW = {"family_index", "per_family_instance_index", "run_name", "repetitions", "repetition_index", "threads", "iterations", "real_time",
                   "cpu_time", "time_unit", "aggregate_name", "aggregate_unit"}
KEPT_OF_CONTEXT = ("date", "num_cpus", "mhz_per_cpu", "caches", "load_avg")
BENCHES = "bench_(plain|portable|every_force|pointers|pointers_shuffled|bullet_[a-z_]+|triad)[</]"


def few_digits(value):
    """A measured number to six digits: no clock has more. Counts stay as they are."""
    return float(f"{value:.6g}") if isinstance(value, float) and not value.is_integer() else value


def write_rows(data, path):
    """What tables are made of, a line a row: counters and labels of single repetitions, and the machine without its name."""
    context = {name: data["context"][name] for name in KEPT_OF_CONTEXT if name in data["context"]}
    rows = [{name: few_digits(value) for name, value in row.items() if name not in LEFT_OUT_OF_ROW}
            for row in data["benchmarks"] if row.get("run_type", "iteration") == "iteration"]
    with open(path, "w", encoding="utf-8") as file:
        file.write('{"context": ' + json.dumps(context) + ',\n "benchmarks": [\n')
        file.write(",\n".join(json.dumps(row) for row in rows) + "\n]}\n")


def run_bench(bench, names, repetitions, path, large=False):
    """Rows of the benchmarks that `names` finds, as JSON at `path`."""
    environment = dict(os.environ)
    environment.pop("PALPATE_BENCH_LARGE", None)
    if large:
        environment["PALPATE_BENCH_LARGE"] = "1"
    subprocess.run([bench, f"--benchmark_filter={names}", f"--benchmark_repetitions={repetitions}",
                    "--benchmark_enable_random_interleaving=true", f"--benchmark_out={path}", "--benchmark_out_format=json"],
                   check=True, env=environment, stdout=subprocess.DEVNULL)


def repetitions(data, name):
    """(match of the name, row) of each repetition that has one, without aggregates and failures."""
    for row in data["benchmarks"]:
        match = name.match(row["name"])
        if match and row.get("run_type", "iteration") == "iteration" and "error_message" not in row:
            yield match, row


def read_rows(data):
    """(name, first argument, threads) -> list of rows, one a repetition."""
    rows = {}
    for match, row in repetitions(data, NAME):
        rows.setdefault((match[1], int(match[2]), int(match[3])), []).append(row)
    return rows


def spread_of(values):
    return (max(values) - min(values)) / statistics.median(values)


def in_order(found, labels):
    """((name, threads), what it is called) of what was found: as labelled, then the rest."""
    return [*((key, label) for key, label in labels.items() if key in found), *((key, f"{key[0]}, {key[1]}") for key in sorted(found - set(labels)))]


class Figures:
    def __init__(self, rows, clock):
        self.rows, self.clock = rows, clock

    def has(self, name, size, threads=1):
        return (name, size, threads) in self.rows

    def values(self, name, size, threads=1, counter="ns_per_spring"):
        if self.clock == "cpu" and threads == 1 and counter in ("ns_per_spring", "gb_per_s"):
            counter = "cpu_" + counter
        return [row[counter] for row in self.rows[name, size, threads]]

    def median(self, *what, **which):
        return statistics.median(self.values(*what, **which))

    def spread(self, *what):
        values = self.values(*what, counter="gb_per_s" if what[0] == "bench_triad" else "ns_per_spring")
        return spread_of(values)

    def known_spread(self, *what):
        """None with one repetition."""
        return self.spread(*what) if len(self.rows[(*what, 1)[:3]]) > 1 else None

    def roofline(self, size, threads=1):
        """The least ns a spring: the layout's bytes over the triad's bytes a second."""
        return (self.median(OURS, size, threads, counter="bytes_per_spring")
                / self.median("bench_triad", 100, threads, counter="gb_per_s"))

    def ratio(self, name, size):
        return self.median(name, size) / self.median(OURS, size)


def judge(is_met, margin, spreads):
    """met, missed, or open where the rows' spread is larger than the margin."""
    if None in spreads or sum(spreads) > margin:
        return "open"
    return "met" if is_met else "missed"


def targets(figures):
    """(what, bound, measured or None, verdict): met, missed, open or not measured. Ratios are named by both rows."""
    out = []

    def add(what, sign, bound, keys, value, own=None):
        own = own or figures
        if not all(own.has(*key) for key in keys):
            out.append((what, f"{sign} {bound}", None, "not measured"))
            return
        measured = value()
        is_met = measured <= bound if sign == "<=" else measured >= bound
        out.append((what, f"{sign} {bound}", measured, judge(is_met, abs(measured / bound - 1), [own.known_spread(*key) for key in keys])))

    for size, bound in ((10, 2.0), (21, 2.0), (46, 3.0), (100, 4.5)):
        add(f"ns a spring, {CELLS[size]}", "<=", bound, [(OURS, size)], lambda s=size: figures.median(OURS, s))
    for size in (46, 100):
        # Always by the wall: that is what a second thread is for.
        wall = Figures(figures.rows, "wall")
        add(f"two threads over one, {CELLS[size]}", ">=", 1.8, [(OURS, size), (OURS, size, 2)],
            lambda s=size, w=wall: w.median(OURS, s) / w.median(OURS, s, 2), wall)
    for name, what, bound, sizes in (("bench_pointers", "pointers", 2.0, (10,)),
                                     ("bench_pointers_shuffled", "shuffled pointers", 8.0, (100,)),
                                     ("bench_bullet_springs", "Bullet's springs", 8.0, CELLS)):
        for size in sizes:
            add(f"{what} over ours, {CELLS[size]}", ">=", bound, [(name, size), (OURS, size)],
                lambda n=name, s=size: figures.ratio(n, s))
    add("ours over the roofline, 1M", "<=", 2.0, [(OURS, 100), ("bench_triad", 100)],
        lambda: figures.median(OURS, 100) / figures.roofline(100))
    return out


def hashes(rows):
    """size -> the set of hashes of single precision, over threads, repetitions and instruction sets."""
    found = {}
    for (name, size, _), repeated in rows.items():
        if name in (OURS, "bench_portable"):
            found.setdefault(size, set()).update(row["label"].split()[0] for row in repeated)
    return found


def figure_text(value):
    """Three digits, or none behind the point."""
    return f"{value:.2f}" if value < 9.995 else f"{value:.1f}" if value < 99.95 else f"{value:.0f}"


def align(table):
    widths = [max(len(row[k]) for row in table) for k in range(len(table[0]))]
    lines = ["| " + " | ".join(cell.ljust(width) for cell, width in zip(row, widths)) + " |" for row in table]
    lines.insert(1, "|" + "|".join("-" * (width + 2) for width in widths) + "|")
    return "\n".join(lines)


def head_lines(data, rows, clock):
    """The machine, its load, and what a figure is."""
    context = data.get("context", {})
    load = ", ".join(f"{value:.2f}" for value in context.get("load_avg", []))
    repetitions = max((len(repeated) for repeated in rows.values()), default=0)
    return [f"{context.get('num_cpus', '?')} processors of {context.get('mhz_per_cpu', '?')} MHz, load {load} at the start, "
            f"medians of {repetitions} repetitions, {clock} clock", ""]


def target_lines(found):
    table = [["target", "bound", "measured", ""]]
    for what, bound, value, verdict in found:
        table.append([what, bound, "-" if value is None else figure_text(value), verdict])
    return [align(table), ""]


def hash_text(found, where=""):
    return f"{next(iter(found))}{where}" if len(found) == 1 else "DIFFERS: " + ", ".join(sorted(found))


def render(data, clock):
    rows = read_rows(data)
    figures = Figures(rows, clock)
    lines = head_lines(data, rows, clock)
    table = [["ns a spring and step", *CELLS.values(), "spread"]]
    springs = {(name, threads) for name, _, threads in rows if name != "bench_triad"}
    for (name, threads), label in in_order(springs, LABELS):
        sizes = [size for size in CELLS if figures.has(name, size, threads)]
        cells = [figure_text(figures.median(name, size, threads)) if size in sizes else "-" for size in CELLS]
        spread = max(figures.spread(name, size, threads) for size in sizes)
        table.append([label, *cells, f"{100 * spread:.0f}%"])
    for threads in (1, 2):
        if figures.has("bench_triad", 100, threads):
            cells = [figure_text(figures.roofline(size, threads)) if figures.has(OURS, size, threads) else "-" for size in CELLS]
            rate = figures.median("bench_triad", 100, threads, counter="gb_per_s")
            name = f"roofline{', 2 threads' if threads == 2 else ''} ({rate:.1f} GB/s)"
            table.append([name, *cells, f"{100 * figures.spread('bench_triad', 100, threads):.0f}%"])
    lines += [align(table), "", *target_lines(targets(figures))]
    for size, found in sorted(hashes(rows).items()):
        lines.append(f"hash of the state after 100 steps, {CELLS[size]}: {hash_text(found, ' in all rows')}")
    for size in CELLS:
        if figures.has(OURS, size):
            row = rows[OURS, size, 1][0]
            lines.append(f"single against double precision, {CELLS[size]}: {row['error_m']:.1e} m at the most, "
                         f"{row['error_relative']:.1e} of the displacement; {row['bytes_per_spring']:.1f} bytes a spring, "
                         f"{100 * row['across']:.0f}% of the springs across blocks")
    return "\n".join(lines)


def print_table(description, benches, render, find_hashes, has_large=False):
    """What either table does with its command line; returns 1 if hashes differ."""
    parser = argparse.ArgumentParser(description=description, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("bench", nargs="?")
    parser.add_argument("--read")
    parser.add_argument("--json")
    if has_large:
        parser.add_argument("--large", action="store_true")
    parser.add_argument("--repetitions", type=int, default=5)
    parser.add_argument("--clock", choices=("wall", "cpu"), default="wall")
    given = parser.parse_args()
    if (given.bench is None) == (given.read is None):
        parser.error("give the benchmark program, or --read FILE")
    with tempfile.TemporaryDirectory() as folder:
        path = given.read or given.json or os.path.join(folder, "rows.json")
        if given.read is None:
            run_bench(given.bench, benches, given.repetitions, path, has_large and given.large)
        with open(path, encoding="utf-8") as file:
            data = json.load(file)
        if given.read is None:
            write_rows(data, path)
    print(render(data, given.clock))
    return 1 if any(len(found) > 1 for found in find_hashes(data).values()) else 0


if __name__ == "__main__":
    sys.exit(print_table(__doc__, BENCHES, render, lambda data: hashes(read_rows(data)), has_large=True))
