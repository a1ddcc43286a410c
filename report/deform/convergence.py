"""Error against the number of vertices: whether a model gets better when its mesh is refined.

A step to a finer mesh is worse if the error grows by more than what the references of the two meshes leave open together.
"""

import math
from dataclasses import dataclass

from deform.deform import ERRORS, MAIN, NO_SIMPLIFIER
from shared.tables import align, percent_text, write_csv

BETTER, WORSE, UNCLEAR = "better", "worse", "unclear"


@dataclass
class Series:
    """A label on one scene at one Poisson ratio, over the sizes of its mesh, coarsest first."""

    scene: str
    poisson_ratio: object
    label: str
    method: str
    rows: list  # judged ones

    @property
    def steps(self):
        """Better, worse or unclear, from each size to the next."""
        return [step_of(coarse, fine) for coarse, fine in zip(self.rows, self.rows[1:])]

    @property
    def slope(self):
        """Of the logarithm of the error against that of the vertices, from the coarsest to the finest; -2/3 is order 2."""
        first, last = self.rows[0], self.rows[-1]
        if len(self.rows) < 2 or first.vertices == last.vertices or not first.values[MAIN] or not last.values[MAIN]:
            return None
        return math.log(last.values[MAIN] / first.values[MAIN]) / math.log(last.vertices / first.vertices)


def step_of(coarse, fine):
    change = fine.values[MAIN] - coarse.values[MAIN]
    owns = [row.own_errors.get(MAIN) for row in (coarse, fine)]
    if None in owns:
        return UNCLEAR
    return UNCLEAR if abs(change) <= sum(owns) else WORSE if change > 0 else BETTER


def read_series(sections):
    """All series that have at least two sizes."""
    found = {}
    for section in sections:
        if section.problem.wanted_vertices is None or section.simplify not in ("", NO_SIMPLIFIER):
            continue
        for row in section.rows:
            key = (section.problem.scene, section.problem.poisson_ratio, row.label)
            series = found.setdefault(key, Series(*key, row.method, []))
            if row.is_judged and row.vertices is not None:
                series.rows.append(row)
    for series in found.values():
        series.rows.sort(key=lambda row: row.vertices)
    return [series for series in found.values() if len(series.rows) > 1]


def errors_text(series, name):
    """The errors of one kind, coarsest first: "4.3 > 2.1~"."""
    shown = [f"{percent_text(row.values[name])}{row.marks.get(name, '').strip('*+')}" for row in series.rows if row.values[name] is not None]
    return " > ".join(shown)


def convergence_text(all_series):
    """The L2 error with its order and verdict, and the other errors beside it."""
    others = [(name, title) for name, title, _ in ERRORS
              if name != MAIN and any(row.values[name] is not None for series in all_series for row in series.rows)]
    rows = []
    for series in all_series:
        ratio = "" if series.poisson_ratio is None else f"{series.poisson_ratio:g}"
        errors = errors_text(series, MAIN)
        slope = "" if series.slope is None else f"{-3 * series.slope:.1f}"
        steps = series.steps
        note = "worse when refined" if WORSE in steps else "" if set(steps) == {BETTER} else "the reference cannot tell"
        rows.append([series.scene, ratio, series.label, errors, slope, note, *(errors_text(series, name) for name, _ in others)])
    rows = [row if i == 0 or rows[i - 1][:2] != row[:2] else ["", "", *row[2:]] for i, row in enumerate(rows)]
    sizes = sorted({series_row.problem.wanted_vertices for series in all_series for series_row in series.rows})
    return (f"Refined: L2 error in % at {', '.join(f'{size:,.0f}' for size in sizes)} vertices; order: of the error in the edge length, "
            "coarsest to finest\n\n" + align(["scene", "nu", "label", "errors", "order", "note", *(title for _, title in others)], rows))


def write_convergence(all_series, folder):
    rows = []
    for series in all_series:
        for row, step in zip(series.rows, ["", *series.steps]):
            rows.append([series.scene, series.poisson_ratio, series.label, series.method, row.vertices, row.values[MAIN],
                         row.own_errors.get(MAIN), row.values["kernel_s"], step,
                         *(row.values[name] for name, _, _ in ERRORS if name != MAIN)])
    write_csv(folder / "convergence.csv", ["scene", "poisson_ratio", "label", "method", "vertices", MAIN, "reference_error",
                                           "kernel_s", "step", *(name for name, _, _ in ERRORS if name != MAIN)], rows)
    return {"convergence.csv"}
