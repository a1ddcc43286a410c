"""A contest with known answers: how far each method is from them, at what order it gets nearer, and whether it keeps the
plan's bounds. The bounds hold on the finest mesh of a case.
"""

from dataclasses import dataclass

from shared.records import figure, median
from shared.tables import first_reason, pad_columns, seconds_text, timing_of, write_atomically, write_csv

FIGURES = ["solution_l2", "solution_max", "solution_order", "value", "value_known", "value_error"]
KEPT, BROKEN = "kept", "not kept"


@dataclass
class Row:
    """A method on one mesh of a case."""

    case: str
    label: str
    cells: object
    values: dict
    seconds: object
    state: str  # KEPT or BROKEN on the finest mesh; "" on the others if they were accepted
    note: str
    bounds: str


def bounds_text(run, case, label):
    """The plan's bounds for a label on a case: "solution_l2 <= 1e-10"."""
    entries = run.plan_data.get("cases")
    found = []
    for entry in entries if isinstance(entries, list) else []:
        for expected in entry.get("expect") or [] if isinstance(entry, dict) and entry.get("case") == case else []:
            if label in (expected.get("contestants") or []):
                for name, bound in expected.items():
                    found += [f"{name} {sign} {bound[side]}" for side, sign in (("min", ">="), ("max", "<="))
                              if isinstance(bound, dict) and side in bound]
    return ", ".join(found)


def read_rows(run):
    """One row a case, label and mesh, coarsest first."""
    groups = {}
    for group in run.groups:
        sweep = group.records[0].get("sweep") if isinstance(group.records[0].get("sweep"), dict) else {}
        groups.setdefault((group.mesh, group.label), []).append((sweep.get("cells") or 0, group))
    rows = []
    for (case, label), sizes in groups.items():
        sizes.sort(key=lambda size: size[0])
        for cells, group in sizes:
            judged = group.judged()
            values = {name: median([v for v in (figure(record, "judge", name) for record in judged) if v is not None])
                      for name in FIGURES}
            timing = timing_of(group)
            is_accepted = set(group.outcomes()) == {"accepted"}
            is_finest = cells == sizes[-1][0]
            bounds = bounds_text(run, case, label) if is_finest else ""
            state = BROKEN if not is_accepted else KEPT if is_finest else ""
            rows.append(Row(case, label, cells, values, timing["kernel_median_s"] if timing else None, state,
                            "" if is_accepted else first_reason(group) or "not run", bounds))
    return rows


def error_text(value):
    return "" if value is None else f"{value:.2e}"


def verification_text(rows):
    lines = [["case", "method", "cells", "L2", "max", "order", "value", "known", "off by", "kernel", "bounds", ""]]
    last = None
    for row in rows:
        lines += [""] if last not in (None, row.case) else []
        values = row.values
        plain = ["" if values[name] is None else f"{values[name]:.5g}" for name in ("value", "value_known")]
        lines.append([row.case if row.case != last else "", row.label, f"{row.cells:g}", error_text(values["solution_l2"]),
                      error_text(values["solution_max"]), "" if values["solution_order"] is None else f"{values['solution_order']:.2f}",
                      *plain, "" if values["value_error"] is None else f"{100 * values['value_error']:.2f}%",
                      seconds_text(row.seconds), row.state, "; ".join(text for text in (row.bounds, row.note) if text)])
        last = row.case
    states = [row.state for row in rows]
    return (f"Known answers: bounds kept by {states.count(KEPT)}, not kept by {states.count(BROKEN)}\n"
            "Relative errors in the L2 norm and at the worst vertex; order: against the next coarser mesh.\n\n" + pad_columns(lines))


def write_tables(rows, folder):
    """Writes verification.csv and verification.txt; returns their names."""
    folder.mkdir(parents=True, exist_ok=True)
    write_csv(folder / "verification.csv", ["case", "method", "cells", *FIGURES, "kernel_s", "state", "bounds", "note"],
              [[row.case, row.label, row.cells, *(row.values[name] for name in FIGURES), row.seconds, row.state, row.bounds, row.note]
               for row in rows])
    write_atomically(folder / "verification.txt", verification_text(rows) + "\n")
    return {"verification.csv", "verification.txt"}
