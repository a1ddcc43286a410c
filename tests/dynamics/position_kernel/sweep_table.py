"""Runs the benchmark of a sweep of position-based dynamics and prints its table.

    sweep_table.py BENCH [--repetitions N] [--json FILE] [--clock wall|cpu]
    sweep_table.py --read FILE [--clock wall|cpu]

BENCH is build/release/bin/palpate_bench. What a figure, a spread and the clocks are: tests/dynamics/spring_engine/speed_table.py.
Exits with 1 if a repetition's hash differs from another's of the same row, or the two forms in lanes from each other.
"""

import pathlib
import re
import statistics
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent.parent / "spring_engine"))
from speed_table import CELLS, align, figure_text, hash_text, head_lines, print_table, repetitions, spread_of  # noqa: E402

PARTS = ("a spring", "a corotated tetrahedron", "a stable neo-Hookean tetrahedron", "`edge_node`, corotated, a tetrahedron",
         "`edge_node`, stable neo-Hookean, a tetrahedron")
KERNELS = {"kSingle": "one at a time", "kPortable": "in lanes, portable", "kBest": "in lanes, AVX2"}
NAME = re.compile(r"^bench_sweep<PositionKernel::(\w+)>/(\d+)/(\d)/([01])(?:/|$)")
BENCHES = "bench_sweep"


def read_rows(data):
    """(kernel, cells, part, is damped) -> list of rows, one a repetition."""
    rows = {}
    for match, row in repetitions(data, NAME):
        rows.setdefault((match[1], int(match[2]), int(match[3]), match[4] == "1"), []).append(row)
    return rows


def values(rows, clock):
    """ns of each repetition."""
    before = "cpu_" if clock == "cpu" else ""
    return [row.get(f"{before}ns_per_spring", row.get(f"{before}ns_per_tet")) for row in rows]


def hashes(rows):
    """(form, cells, part, is damped) -> the set of hashes; portable and AVX2 are one form."""
    found = {}
    for (kernel, *what), repeated in rows.items():
        found.setdefault(("one" if kernel == "kSingle" else "lanes", *what), set()).update(row["label"].split()[0] for row in repeated)
    return found


def render(data, clock):
    rows = read_rows(data)
    spreads = [spread_of(values(repeated, clock)) for repeated in rows.values()]
    table = [["ns, undamped / damped", *KERNELS.values()]]
    for part, name in enumerate(PARTS):
        for size in sorted({cells for _, cells, of, _ in rows if of == part}):
            cells = []
            for kernel in KERNELS:
                pair = [rows.get((kernel, size, part, is_damped)) for is_damped in (False, True)]
                cells.append(" / ".join("-" if of is None else figure_text(statistics.median(values(of, clock))) for of in pair))
            table.append([f"{name}, {CELLS[size]}", *cells])
    lines = head_lines(data, rows, clock)
    lines += [align(table), "", f"spread: {100 * statistics.median(spreads):.0f}% in the middle, {100 * max(spreads):.0f}% at the most" if spreads else ""]
    for (form, cells, part, is_damped), found in sorted(hashes(rows).items()):
        if len(found) > 1:
            lines.append(f"hash after 100 steps, {PARTS[part]}, {CELLS[cells]}, {form}{', damped' if is_damped else ''}: {hash_text(found)}")
    return "\n".join(lines)


if __name__ == "__main__":
    sys.exit(print_table(__doc__, BENCHES, render, lambda data: hashes(read_rows(data))))
