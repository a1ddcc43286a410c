"""A contest of extremes: how long a step each integrator was to keep, how long it kept, and how bodies end beyond."""

from dataclasses import dataclass, field

from shared.records import figure, median
from shared.tables import pad_columns, violations_text, write_atomically, write_csv

SHORT = {"steady": "steady", "oscillating": "moves", "energy_growing": "grows", "diverged": "diverged", "inverted": "inverted",
         "non_finite": "no number", "too_slow": "too slow", "growing_slowly": "grows slowly"}
WORST_FIRST = ["too_slow", "non_finite", "diverged", "energy_growing", "growing_slowly", "inverted", "oscillating", "steady"]
NO_ANSWER = "no answer"
GIVEN_UP = "too_slow"  # no ending: how it would have ended is not known
# What the judge alone says; all else of a case is what the contestant reports.
JUDGED = ["measured_step_s", "measured_over_predicted", "row_sum_over_measured", "min_dihedral_deg"]
AGREEMENT = 0.02


@dataclass
class Case:
    """One body, integrator and setting."""

    mesh: str
    label: str
    extreme: str
    sweep: dict  # without the extreme's name
    options: dict
    reported: dict  # what the contestant says of itself
    judge: dict
    outcome: str
    ending: str  # as judged; NO_ANSWER where there is none
    note: str
    seconds: object
    runs: list = field(default_factory=list)

    @property
    def setting(self):
        return ", ".join(f"{name} {number_text(value)}" for name, value in self.sweep.items())

    @property
    def measures(self):
        return self.options.get("task", "measure") == "measure"

    @property
    def is_accepted(self):
        return self.outcome == "accepted"

    @property
    def is_large(self):
        return self.options.get("regime") == "large"

    def number(self, name):
        return figure(self.block(name), name)

    def block(self, name):
        """Where a figure of the case stands: with the judge, or among what is reported."""
        return self.judge if name in JUDGED else self.reported


def number_text(value):
    return f"{value:g}" if isinstance(value, (int, float)) and not isinstance(value, bool) else str(value)


def as_number(value):
    """A sweep's value, which the plan may have as text ("1e+6"); None where it is no number."""
    try:
        return float(value)
    except (TypeError, ValueError):
        return None


def read_cases(run):
    """The first record of each case, in the order of the plan."""
    cases, seen = [], set()
    for group in run.groups:
        for record in group.records:
            if record.get("warmup") or record.get("case") in seen:
                continue
            seen.add(record.get("case"))
            sweep = dict(record.get("sweep") or {})
            extreme = str(sweep.pop("extreme", ""))
            reported = record.get("reported") if isinstance(record.get("reported"), dict) else {}
            judge = record.get("judge") if isinstance(record.get("judge"), dict) else {}
            ending = judge.get("ending") if judge.get("ending") in SHORT else NO_ANSWER
            note = str(record.get("message") or violations_text(record) or "")
            cases.append(Case(group.mesh, group.label, extreme, sweep, record.get("options") or {}, reported, judge,
                              str(record.get("outcome")), ending, note, figure(record, "kernel_s"), read_runs(judge, reported)))
    return cases


def read_runs(judge, reported):
    """The runs as the judge reads them, each with what the contestant alone can tell of it."""
    judged = [entry for entry in judge.get("runs") or [] if isinstance(entry, dict)] if isinstance(judge.get("runs"), list) else []
    said = reported.get("runs") if isinstance(reported.get("runs"), list) else []
    told = [said[k] if k < len(said) and isinstance(said[k], dict) else {} for k in range(len(judged))]
    return [{**{name: own.get(name) for name in REPORTED_OF_RUN}, **entry, "outcome": entry.get("ending")} for own, entry in zip(told, judged)]


# Of a run: the vertex that offended first and when, and the growth of small motions.
REPORTED_OF_RUN = ["step_over_predicted", "time_s", "vertex", "growth_per_step"]


def worst(endings):
    """The one that stands first in WORST_FIRST."""
    return min(endings, key=lambda ending: WORST_FIRST.index(ending) if ending in WORST_FIRST else -1)


def run_text(entry):
    """"diverged 9": the ending, and the step of it where it came before the end."""
    ending = entry.get("outcome")
    text = SHORT.get(ending, str(ending))
    return f"{text} {entry.get('steps')}" if ending in ("diverged", "non_finite", "too_slow") else text


def agreement_rows(cases):
    """Per integrator: cases of small motions with both steps, their ratio, its worst, and the row sums' share."""
    rows = []
    for label in dict.fromkeys(case.label for case in cases):
        own = [case for case in cases if case.label == label and case.is_accepted and case.measures and not case.is_large]
        ratios = [(case.number("measured_over_predicted"), case) for case in own if case.number("measured_over_predicted") is not None]
        shares = [share for share in (case.number("row_sum_over_measured") for case in own) if share]
        if not own:
            continue
        worst_ratio, where = max(ratios, key=lambda pair: abs(pair[0] - 1), default=(None, None))
        within = sum(abs(ratio - 1) <= AGREEMENT for ratio, _ in ratios)
        rows.append([label, len(own), len(ratios), within, median([ratio for ratio, _ in ratios]), worst_ratio,
                     f"{where.mesh}, {where.extreme} {where.setting}".strip() if where else "",
                     min(shares, default=None), max(shares, default=None)])
    return rows


AGREEMENT_HEADER = ["integrator", "cases", "compared", "within 2%", "median ratio", "worst ratio", "where", "row sums least", "row sums most"]


def agreement_text(rows):
    lines = [AGREEMENT_HEADER]
    lines += [[row[0], *map(str, row[1:4]), *("" if value is None else f"{value:.4f}" for value in row[4:6]), row[6],
               *("" if value is None else f"{value:.3f}" for value in row[7:])] for row in rows]
    return pad_columns(lines)


def failure_cell(case):
    if not case.runs:
        return SHORT.get(case.ending, NO_ANSWER)
    if not case.measures:
        return run_text(case.runs[0])
    return " / ".join(run_text(entry) for entry in case.runs[1:])


def failure_rows(cases):
    """One row a mesh, extreme and setting, with one cell an integrator."""
    labels = list(dict.fromkeys(case.label for case in cases))
    rows = {}
    for case in cases:
        rows.setdefault((case.extreme, case.mesh, case.setting), {})[case.label] = failure_cell(case)
    return labels, [[*key, *(cells.get(label, "") for label in labels)] for key, cells in rows.items()]


def plain_label(label):
    return label.removeprefix("motion.")


def failure_text(cases):
    labels, rows = failure_rows(cases)
    lines = [["extreme", "mesh", "setting", *map(plain_label, labels)]]
    last = None
    for row in rows:
        lines.append(["" if row[0] == last else row[0], *row[1:]])
        last = row[0]
    widths = [max(len(line[i]) for line in lines) for i in range(len(lines[0]))]
    return "\n".join("  ".join(cell.ljust(width) for cell, width in zip(line, widths)).rstrip() for line in lines)


def endings_of(case):
    """How the runs of an accepted case ended: of a measurement those beyond the measured step."""
    return [entry.get("outcome") for entry in (case.runs[1:] if case.measures else case.runs)] if case.is_accepted else []


def endings_text(cases):
    """How often each integrator ended how, over the accepted cases; and how many cases were not accepted."""
    labels = list(dict.fromkeys(case.label for case in cases))
    names = [ending for ending in reversed(WORST_FIRST) if ending != GIVEN_UP]
    lines = [["integrator", "runs", *(SHORT[ending] for ending in names), "not accepted"]]
    for label in labels:
        own = [case for case in cases if case.label == label]
        endings = [ending for case in own for ending in endings_of(case)]
        lines.append([plain_label(label), str(len(endings)), *(str(endings.count(ending)) for ending in names), str(sum(not case.is_accepted for case in own))])
    return pad_columns(lines)


def trouble_lines(cases):
    return [f"{case.mesh}/{case.label}/{case.extreme} {case.setting}: {case.outcome}: {case.note}" for case in cases
            if case.outcome != "accepted"]


def summary_text(cases):
    parts = [f"Extremes: {len(cases)} cases, {sum(case.outcome == 'accepted' for case in cases)} accepted",
             "Longest stable step of small motions, measured over predicted; row sums over measured:\n" + agreement_text(agreement_rows(cases)),
             "How runs of accepted cases ended (of measurements those at 1.02, 2 and 10 times the measured step):\n" + endings_text(cases)]
    trouble = trouble_lines(cases)
    if trouble:
        parts.append("Not accepted:\n" + "\n".join(trouble[:40]) + (f"\n... and {len(trouble) - 40} more" if len(trouble) > 40 else ""))
    return "\n\n".join(parts)


CASE_FIGURES = ["predicted_step_s", "predicted_at_most_s", "predicted_at_start_s", "row_sum_step_s", "measured_step_s",
                "measured_stable_s", "measured_unstable_s", "measured_over_predicted", "trials", "trial_steps", "vertices", "springs",
                "min_dihedral_deg", "mass_ratio", "volume_ratio"]
RUN_FIGURES = ["step_over_predicted", "step_s", "outcome", "steps", "time_s", "vertex", "energy_start_j", "energy_most_j",
               "kinetic_end_j", "drift_over_size", "inverted_start", "inverted_end", "growth_per_step", "steps_unsolved"]


def write_tables(cases, folder):
    """Writes stability.csv (a row a case), runs.csv (a row a run), failures.csv and stability.txt; returns their names."""
    folder.mkdir(parents=True, exist_ok=True)
    key = ["mesh", "integrator", "extreme", "setting"]
    keys = lambda case: [case.mesh, plain_label(case.label), case.extreme, case.setting]
    write_csv(folder / "stability.csv", [*key, *CASE_FIGURES, "ending", "outcome", "kernel_s", "note"],
              [[*keys(case), *(case.block(name).get(name) for name in CASE_FIGURES), case.ending, case.outcome, case.seconds, case.note]
               for case in cases])
    write_csv(folder / "runs.csv", [*key, *RUN_FIGURES], [[*keys(case), *(entry.get(name) for name in RUN_FIGURES)]
                                                          for case in cases for entry in case.runs])
    labels, rows = failure_rows(cases)
    write_csv(folder / "failures.csv", ["extreme", "mesh", "setting", *map(plain_label, labels)], rows)
    legend = ("Of measurements: how the body ends at 1.02, 2 and 10 times the measured step; of runs: how it ended. The number is\n"
              "the step at which it did. vertex and time of each: runs.csv.")
    write_atomically(folder / "stability.txt", summary_text(cases) + f"\n\n{legend}\n\n" + failure_text(cases) + "\n")
    return {"stability.csv", "runs.csv", "failures.csv", "stability.txt"}
