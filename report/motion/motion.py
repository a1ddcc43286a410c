"""A contest of motions: errors of frequencies, of the probe's history and of the tool's force, scene by scene, beside the
reference's own estimated error.

A figure that is not five times the reference's own error is marked `~`: the reference cannot tell it. Signs are kept where
they say something: an amplitude of -10% is too small, a phase of -10 degrees too late.
"""

import csv
import io
from array import array
from dataclasses import dataclass, field
from math import isfinite

from shared.records import BadRun, figure, median, present
from shared.run_file import open_file
from shared.tables import (first_reason, outcome_text, pad_columns, percent_text, seconds_text, timing_of, write_atomically,
                           write_csv)

MARGIN = 5.0
BEST, COARSE = "*", "~"
WHOLE = "whole"  # the mesh as it is
MOST_HISTORY_BYTES = 512 * 2**20


@dataclass(frozen=True)
class Measure:
    name: str
    title: str
    scale: float  # 100: shown in percent
    signed: bool


MEASURES = [Measure("frequency_first", "f1 %", 100, False), Measure("frequency_mean", "f1-10 %", 100, False),
            Measure("frequency_worst", "worst f %", 100, False), Measure("probe_l2", "probe %", 100, False),
            Measure("force_l2", "force %", 100, False), Measure("amplitude_error", "amplitude %", 100, True),
            Measure("phase_error_deg", "phase deg", 1, True), Measure("decay_error", "decay %", 100, True),
            Measure("unexplained", "unexplained %", 100, False), Measure("solver_probe_l2", "solver %", 100, False)]
# A part of the signal, not an error; what a solver leaves, not what the model does.
UNMARKED = {"unexplained", "solver_probe_l2"}


@dataclass
class Row:
    """What a label reached on a problem."""

    label: str
    method: str
    values: dict
    solve_s: object
    kernel_s: object
    steps: object
    step_s: object
    integrator: str
    left: object  # largest share of the forces out of balance that a step left, or None
    note: str
    history: object  # path of its history, or None
    oscillation: dict  # the reference's, that it was held against
    problem: str = ""  # folder of the simplified problem that it was solved on; empty on the scene's own mesh
    marks: dict = field(default_factory=dict)


@dataclass
class Section:
    """All rows of one problem."""

    scene: str
    sweep: tuple
    reference: dict
    rows: list

    @property
    def title(self):
        vertices = figure(self.reference, "mesh", "vertices")
        shown = "" if vertices is None else f", {vertices:,.0f} vertices"
        return self.scene + shown + "".join(f", {key} {value}" for key, value in self.sweep if key != "vertices")

    @property
    def file_part(self):
        return "_".join([self.scene, *(f"{key}{value}" for key, value in self.sweep)])

    @property
    def own(self):
        judge = self.reference.get("judge") if isinstance(self.reference.get("judge"), dict) else {}
        own = {measure.name: figure(judge, "own_error", measure.name) for measure in MEASURES}
        # What the reference's own oscillation leaves over, as the rows' leave of theirs.
        left = [figure(row.oscillation, "unexplained") for row in self.rows]
        return {**own, "unexplained": next((value for value in left if value is not None), None)}

    @property
    def has_measure(self):
        """The measures that any row has."""
        return [m for m in MEASURES if any(row.values[m.name] is not None for row in self.rows)]


def problem_sweep(record):
    sweep = record.get("sweep") if isinstance(record.get("sweep"), dict) else {}
    return tuple((key, sweep[key]) for key in ("poisson_ratio", "vertices") if key in sweep)


def mesh_of(record):
    """"whole", or the simplifier with what it removed: "refined -22%"."""
    sweep = record.get("sweep") if isinstance(record.get("sweep"), dict) else {}
    simplify, share = sweep.get("simplify", "none"), sweep.get("tets_removed_ratio")
    if simplify == "none":
        return WHOLE
    return simplify if share is None else f"{simplify} -{100 * share:g}%"


def solved_on(record):
    """The folder of the simplified problem that it was solved on; empty on the scene's own mesh."""
    mesh = record.get("solved_on")
    return f"problems/{mesh['name']}" if isinstance(mesh, dict) and isinstance(mesh.get("name"), str) else ""


def label_of(record):
    """The label with the options that the plan sweeps, and with the simplifier of its mesh."""
    sweep = record.get("sweep") if isinstance(record.get("sweep"), dict) else {}
    swept = [f"{key.removeprefix('option.')} {value}" for key, value in sweep.items() if key.startswith("option.")]
    swept += [mesh_of(record)] if mesh_of(record) != WHOLE else []
    return record["label"] + (f" ({', '.join(swept)})" if swept else "")


def history_of(run, record):
    path = record.get("mesh_file")
    return run.folder / path if isinstance(path, str) and (run.folder / path).is_file() else None


def read_row(run, group):
    record = (group.cases() or group.records)[0]
    values = {measure.name: median(group.figures("judge", measure.name)) for measure in MEASURES}
    timing = timing_of(group)
    report = record.get("report") if isinstance(record.get("report"), dict) else {}
    judge = record.get("judge") if isinstance(record.get("judge"), dict) else {}
    oscillation = judge.get("reference_oscillation")
    accepted = group.cases() and set(group.outcomes()) == {"accepted"}
    note = "" if accepted else f"{outcome_text(group)}: {first_reason(group)}" if group.cases() else first_reason(group) or "not run"
    return Row(label_of(record), group.contestant, values, median(present(figure(r, "report", "solve_s") for r in group.accepted())),
               timing["kernel_median_s"] if timing else None, figure(report, "steps"), figure(report, "time_step_s"),
               str(report.get("integrator", "")), figure(report, "residual_worst"), note, history_of(run, record) if group.cases() else None,
               oscillation if isinstance(oscillation, dict) else {}, solved_on(record))


def mark_rows(section):
    """Marks the least figure of each column, and those that the reference cannot tell."""
    for measure in MEASURES:
        sizes = [abs(row.values[measure.name]) for row in section.rows if row.values[measure.name] is not None]
        own = section.own[measure.name]
        for row in section.rows:
            value = row.values[measure.name]
            row.marks[measure.name] = ""
            if value is None or measure.name in UNMARKED:
                continue
            if own is None or abs(value) < MARGIN * own:
                row.marks[measure.name] = COARSE
            elif len(sizes) > 1 and abs(value) == min(sizes):
                row.marks[measure.name] = BEST


def read_sections(run):
    """One section a scene and point of the sweep, in the order of the plan."""
    references = {(str(record["mesh"]["name"]), problem_sweep(record)): record for record in run.references}
    sections = {}
    for group in run.groups:
        key = (group.mesh, problem_sweep(group.records[0]))
        sections.setdefault(key, Section(*key, references.get(key, {}), [])).rows.append(read_row(run, group))
    for section in sections.values():
        mark_rows(section)
    return list(sections.values())


def value_text(measure, value):
    if value is None:
        return ""
    if measure.scale == 1:
        return f"{value:+.1f}"
    text = percent_text(abs(value))
    return text if not measure.signed else ("-" if value < 0 else "+") + text


def own_text(section):
    judge = section.reference.get("judge") if isinstance(section.reference.get("judge"), dict) else {}
    if not judge.get("valid"):
        return f"no reference: {section.reference.get('message') or 'no record'}"
    runs = judge.get("runs") or [{}]
    finest = runs[0].get("report") if isinstance(runs[0].get("report"), dict) else {}
    hz = [value for value in judge.get("frequencies_hz", []) if isinstance(value, (int, float))]
    # A reference on one level has no estimate of its error in space, and none at all of its frequencies.
    return (f"reference: {finest.get('method', '')}, {figure(finest, 'dofs') or 0:,.0f} unknowns, step "
            f"{1e3 * (figure(finest, 'time_step_s') or 0):g} ms, {sum(figure(each, 'kernel_s') or 0 for each in runs):.0f} s; "
            f"frequencies {', '.join(f'{value:.3g}' for value in hz)} Hz")


def table_text(sections):
    lines = [["label", *(m.title + "  " for m in MEASURES), "left", "steps", "solve", "kernel", "note"]]
    for section in sections:
        lines += ["", section.title, f"  {own_text(section)}"]
        own = section.own
        if section.reference:
            lines.append(["  its own error", *(("" if own[m.name] is None else value_text(m, own[m.name]).lstrip("+")) + "  "
                                              for m in MEASURES), "", "", "", "", ""])
        for row in section.rows:
            lines.append([row.label, *(value_text(m, row.values[m.name]) + row.marks[m.name].ljust(2) for m in MEASURES),
                          "" if row.left is None else f"{row.left:.1g}", "" if row.steps is None else f"{row.steps:,.0f}", seconds_text(row.solve_s), seconds_text(row.kernel_s),
                          row.note])
    return (pad_columns(lines) + f"\n\n{BEST} least of the column; {COARSE} less than {MARGIN:g} times the reference's own error, or no "
            "estimate of it: the reference cannot tell.\nf1, f1-10, worst f: natural frequencies; probe: its displacement over the whole "
            "history (L2); force: the tool's, while it is there (L2); amplitude, phase, decay: of the probe's strongest oscillation;\n"
            "unexplained: what the fitted oscillations leave over of its motion (rms); above 20% there is no amplitude, phase and decay to "
            "compare.\nsolver: the probe's distance from the motion of the same body with a solver that leaves nothing (L2); left: the largest "
            "share of the forces out of balance that a step left.")


def write_tables(sections, folder):
    """Writes motion.csv and motion.txt; returns their names."""
    folder.mkdir(parents=True, exist_ok=True)
    names = [measure.name for measure in MEASURES]
    write_csv(folder / "motion.csv", ["problem", "label", "method", "integrator", *names, *(f"own_{name}" for name in names), "residual_worst", "steps",
                                      "time_step_s", "solve_s", "kernel_s", "note"],
              [[section.title, row.label, row.method, row.integrator, *(row.values[name] for name in names),
                *(section.own[name] for name in names), row.left, row.steps, row.step_s, row.solve_s, row.kernel_s, row.note]
               for section in sections for row in section.rows])
    write_atomically(folder / "motion.txt", table_text(sections) + "\n")
    return {"motion.csv", "motion.txt"}


def read_history(path):
    """The columns of a history by name. Throws BadRun."""
    if path.stat().st_size > MOST_HISTORY_BYTES:
        raise BadRun(f"{path}: expected at most {MOST_HISTORY_BYTES:,} bytes, found {path.stat().st_size:,}")
    try:
        with io.TextIOWrapper(open_file(path), encoding="utf-8", newline="") as file:
            rows = csv.reader(file)
            columns = {name: array("d") for name in next(rows)}
            for number, row in enumerate(rows, start=2):
                values = [float(cell) for cell in row]
                if len(values) != len(columns) or not all(map(isfinite, values)):
                    raise BadRun(f"{path}:{number}: expected {len(columns)} finite numbers")
                for column, value in zip(columns.values(), values):
                    column.append(value)
    except (StopIteration, ValueError, csv.Error) as error:
        raise BadRun(f"{path}: expected a history, found {str(error) or 'nothing'}") from error
    if not columns.get("time_s"):
        raise BadRun(f"{path}: expected a history, found no times")
    return columns


def history_beside(run, path):
    """The columns of a history that a case left; none where it cannot be read, which is noted."""
    try:
        return read_history(path)
    except BadRun as error:
        run.note(f"not drawn: {error}")
        return {}
