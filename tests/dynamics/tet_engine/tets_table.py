"""Runs the benchmark of a step of a continuum and holds it against its targets.

    tets_table.py BENCH [--repetitions N] [--json FILE] [--clock wall|cpu]
    tets_table.py --read FILE [--clock wall|cpu]

BENCH is build/release/bin/palpate_bench. All rows come from one process, in random order, N times (default 5); a figure is
the median over the repetitions, a spread (largest - smallest) / median. What a target's verdict is, and what the clocks
are: tests/dynamics/spring_engine/speed_table.py. Exits with 1 if hashes of single or of double precision differ between
threads and instruction sets.
"""

import pathlib
import re
import statistics
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent.parent / "spring_engine"))
from speed_table import align, figure_text, hash_text, head_lines, in_order, judge, print_table, repetitions, spread_of, target_lines  # noqa: E402

CELLS = {10: "1.3k", 21: "10k", 46: "100k"}
LAWS = {0: "linear", 1: "corotated", 2: "neo-Hookean"}
NAME = re.compile(r"^(bench_\w+(?:<\w+>)?)/(\d+)/(\d+)(?:/(\d))?(?:/|$)")
SINGLE = {"tets": "bench_tets<float>", "edge_node": "bench_edge_node<float>"}
LABELS = {  # in the table's order
    ("bench_tets<float>", 1): "tets, single precision",
    ("bench_tets<float>", 2): "... two threads",
    ("bench_tets_portable<float>", 1): "... without AVX2",
    ("bench_tets_damped<float>", 1): "... damped",
    ("bench_tets<double>", 1): "tets, double precision",
    ("bench_tets<double>", 2): "... two threads",
    ("bench_general_tets", 1): "the engine of every force, tets",
    ("bench_edge_node<float>", 1): "edge_node, single precision",
    ("bench_edge_node<float>", 2): "... two threads",
    ("bench_edge_node_portable<float>", 1): "... without AVX2",
    ("bench_edge_node<double>", 1): "edge_node, double precision",
    ("bench_edge_node<double>", 2): "... two threads",
    ("bench_general_edge_node", 1): "the engine of every force, edge_node",
}
TARGETS = (("tets", 6.0), ("edge_node", 15.0))
ROOFLINES = 3.0
BENCHES = "bench_(tets|edge_node|general|triad)"


def read_rows(data):
    """(name, cells, threads, law) -> list of rows, one a repetition. The triad has law -1."""
    rows = {}
    for match, row in repetitions(data, NAME):
        if match[1] != "bench_triad" and match[4] is None:
            continue  # the rows of another table
        law = -1 if match[1] == "bench_triad" else int(match[4])
        rows.setdefault((match[1], int(match[2]), int(match[3]), law), []).append(row)
    return rows


class Figures:
    def __init__(self, rows, clock):
        self.rows, self.clock = rows, clock

    def values(self, key, counter):
        if self.clock == "cpu" and key[2] == 1 and counter in ("ns_per_tet", "gb_per_s"):
            counter = "cpu_" + counter
        return [row[counter] for row in self.rows[key]]

    def median(self, key, counter="ns_per_tet"):
        return statistics.median(self.values(key, counter))

    def spread(self, key, counter="ns_per_tet"):
        """None with one repetition."""
        values = self.values(key, counter)
        return spread_of(values) if len(values) > 1 else None

    def roofline(self, key):
        """The least ns a tet: the layout's bytes over the triad's bytes a second."""
        triad = ("bench_triad", 100, key[2], -1)
        return self.median(key, "bytes_per_tet") / self.median(triad, "gb_per_s")


def targets(figures):
    out = []
    for kind, bound in TARGETS:
        for law, name in LAWS.items():
            key = (SINGLE[kind], 21, 1, law)
            if key not in figures.rows:
                out.append((f"{kind} {name}, 10k", f"<= {bound}", None, "not measured"))
                continue
            value = figures.median(key)
            out.append((f"{kind} {name}, 10k", f"<= {bound}", value,
                        judge(value <= bound, abs(value / bound - 1), [figures.spread(key)])))
            over = value / figures.roofline(key)
            spreads = [figures.spread(key), figures.spread(("bench_triad", 100, 1, -1), "gb_per_s")]
            out.append((f"{kind} {name} over its roofline, 10k", f"<= {ROOFLINES}", over,
                        judge(over <= ROOFLINES, abs(over / ROOFLINES - 1), spreads)))
    return out


def hashes(rows):
    """(body, precision, cells, law) -> the set of hashes, over threads, repetitions and instruction sets."""
    found = {}
    for (name, cells, _, law), repeated in rows.items():
        match = re.match(r"bench_(tets|edge_node|tets_damped)(?:_portable)?<(\w+)>", name)
        if match:
            kind = found.setdefault((match[1], match[2], cells, law), set())
            kind.update(row["label"].split()[0] for row in repeated)
    return found


def cell_text(figures, key):
    """The median and its spread in brackets."""
    if key not in figures.rows:
        return "-"
    spread = figures.spread(key)
    return figure_text(figures.median(key)) + ("" if spread is None else f" ({100 * spread:.0f}%)")


def render(data, clock):
    rows = read_rows(data)
    figures = Figures(rows, clock)
    lines = head_lines(data, rows, clock)
    triad = ("bench_triad", 100, 1, -1)
    found = {(name, threads) for name, _, threads, law in rows if law >= 0}
    for size, size_name in CELLS.items():
        table = [[f"ns a tet and step, {size_name}", *LAWS.values()]]
        for (name, threads), label in in_order(found, LABELS):
            keys = [(name, size, threads, law) for law in LAWS]
            if any(key in rows for key in keys):
                table.append([label, *(cell_text(figures, key) for key in keys)])
        for kind, name in SINGLE.items():
            key = (name, size, 1, 0)
            if triad in rows and key in rows:
                bytes_read = figures.median(key, "bytes_per_tet")
                table.append([f"roofline of {kind} ({bytes_read:.0f} bytes, {figures.median(triad, 'gb_per_s'):.1f} GB/s)", *len(LAWS) * [figure_text(figures.roofline(key))]])
        lines += [align(table), ""] if len(table) > 1 else []
    lines += target_lines(targets(figures) if triad in rows else [])
    for (kind, precision, cells, law), found in sorted(hashes(rows).items()):
        lines.append(f"hash after 100 steps, {kind} {precision} {CELLS[cells]} {LAWS[law]}: {hash_text(found)}")
    for kind, name in SINGLE.items():
        for size in CELLS:
            if (name, size, 1, 0) in rows:
                row = rows[name, size, 1, 0][0]
                lines.append(f"{kind}, {CELLS[size]}: {row['bytes_per_tet']:.0f} bytes a tet, "
                             f"halo {100 * row['halo']:.0f}% of the vertices")
    return "\n".join(lines)


if __name__ == "__main__":
    sys.exit(print_table(__doc__, BENCHES, render, lambda data: hashes(read_rows(data))))
