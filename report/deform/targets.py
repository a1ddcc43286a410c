"""The plan's targets: a bound on an error over a set of scenes, and by how much it is met or missed.

A target is met if every scene of it is. Where it names several labels, the one that is best over its scenes counts for all
of them. A scene is met if its figure is within the bound with the reference's own error added, and missed if it is above the bound
with that error taken away. Where answers differ (seeds), the ends of the interval of their median stand for the figure. Between the
two, or without a reference or an estimate of its error, it is open: what is not known is larger than the margin. A scene that a
label did not solve is missed.
"""

from dataclasses import dataclass

from deform.deform import COARSE, ERRORS, MAIN, NO_SIMPLIFIER, root_mean_square, scene_sets
from shared.tables import align, percent_text, write_atomically, write_csv

MET, MISSED, OPEN = "met", "missed", "open"
TITLES = {name: title for name, title, _ in ERRORS}


@dataclass
class Outcome:
    """How one label stands to a target."""

    target: dict
    label: str
    state: str
    rows: list
    p1_rows: list
    note: str
    measure: str

    def values(self, rows):
        return [row.values[self.measure] for row in rows if row is not None and row.values[self.measure] is not None]

    @property
    def worst(self):
        return max(self.values(self.rows), default=None)

    @property
    def worst_row(self):
        return max((row for row in self.rows if row is not None and row.values[self.measure] is not None),
                   key=lambda row: row.values[self.measure], default=None)


def as_list(value):
    return value if isinstance(value, list) else [] if value is None else [value]


def is_wanted(section, target, scenes):
    at = target.get("at") if isinstance(target.get("at"), dict) else {}
    problem = section.problem
    return (problem.scene in scenes and section.simplify in ("", NO_SIMPLIFIER)
            and problem.poisson_ratio in (as_list(at.get("poisson_ratio")) or [problem.poisson_ratio])
            and problem.wanted_vertices in (as_list(at.get("vertices")) or [problem.wanted_vertices]))


def scenes_of(run, sections, target):
    """The target's scenes, with names of sets put in their place; all without any."""
    sets = scene_sets(run, sections)
    named = [scene for name in as_list(target.get("scenes")) for scene in sets.get(name, [name])]
    return list(dict.fromkeys(named)) or list(dict.fromkeys(section.problem.scene for section in sections))


def state_of(row, measure, bound):
    """How one row stands to the bound."""
    if row is None:
        return OPEN
    value, own = row.values[measure], row.own_errors.get(measure)
    if value is None:
        return MISSED if row.has_reference else OPEN
    if own is None:
        return OPEN
    low, high = row.spans.get(measure, (value, value))
    # The reference's error is relative to the reference.
    low = max(low, 0.0)
    return MET if high + own * (1 + high) <= bound else MISSED if low - own * (1 + low) > bound else OPEN


def judge_label(target, label, sections, missing):
    """The outcome of one label."""
    measure, bound = target.get("measure", MAIN), target["at_most"]
    rows = [section.find(label) for section in sections]
    states = [state_of(row, measure, bound) for row in rows] + [OPEN for _ in missing]
    notes = []
    for text, chosen in (
            ("not run", [s.title for s, row in zip(sections, rows) if row is None] + missing),
            ("no reference", [s.title for s, row in zip(sections, rows) if row is not None and not row.has_reference]),
            ("not solved", [s.title for s, row in zip(sections, rows)
                            if row is not None and row.has_reference and row.values[measure] is None]),
            (OPEN, [s.title for s, row, state in zip(sections, rows, states) if row is not None and row.has_reference and state == OPEN]),
            (f"marked {COARSE}", [s.title for s, row in zip(sections, rows) if row is not None and row.is_coarse(measure)])):
        if chosen:
            notes.append(f"{text}: {len(chosen)} of {len(states)}" if len(chosen) > 2 else f"{text}: {'; '.join(chosen)}")
    state = MISSED if MISSED in states else OPEN if OPEN in states or not states else MET
    peers = [section.peer for section in sections]
    return Outcome(target, label, state, rows, peers, "; ".join(notes), measure)


def order_of(outcome):
    solved = len(outcome.values(outcome.rows))
    return (-solved, outcome.worst if outcome.worst is not None else float("inf"))


def judge_targets(run, sections):
    """One outcome a target: that of the best of its labels."""
    found = []
    for target in as_list(run.plan_data.get("targets")):
        if not isinstance(target, dict) or not isinstance(target.get("at_most"), (int, float)):
            continue
        scenes = scenes_of(run, sections, target)
        own = [section for section in sections if is_wanted(section, target, scenes)]
        missing = [scene for scene in scenes if all(section.problem.scene != scene for section in own)]
        labels = as_list(target.get("labels"))
        found.append(min((judge_label(target, label, own, missing) for label in labels), key=order_of))
    return found


def gap_text(outcome):
    """By how much, in points and as a factor: "0.31 under", "1.20 over (1.6 x)"."""
    if outcome.worst is None:
        return ""
    bound = outcome.target["at_most"]
    if outcome.worst <= bound:
        return f"{percent_text(bound - outcome.worst)} under"
    return f"{percent_text(outcome.worst - bound)} over ({outcome.worst / bound:.2f} x)"


def failed_requirements(outcomes):
    """A sentence for each target with `required: true` that is not met."""
    for outcome in outcomes:
        if outcome.target.get("required") is True and outcome.state != MET:
            gap = gap_text(outcome)
            yield f"the target \"{outcome.target.get('text', '')}\": {outcome.state}" + (f", {gap} with {outcome.label}" if gap else "")


def targets_text(outcomes):
    rows = []
    for outcome in outcomes:
        p1 = outcome.values(outcome.p1_rows)
        worst = outcome.worst_row
        rows.append([outcome.state, str(outcome.target.get("text", "")), TITLES.get(outcome.measure, outcome.measure), outcome.label, percent_text(outcome.target["at_most"]),
                     percent_text(outcome.worst), gap_text(outcome), percent_text(root_mean_square(outcome.values(outcome.rows))),
                     "" if worst is None else worst.problem.name, percent_text(max(p1, default=None)), outcome.note])
    header = ["target", "what", "error", "best label", "at most %", "worst %", "by", "rms %", "worst on", "beside worst %", "note"]
    states = [outcome.state for outcome in outcomes]
    count = ", ".join(f"{states.count(state)} {state}" for state in (MET, MISSED, OPEN) if state in states)
    return (f"Targets: {count} ({OPEN}: the bound is within the error of the reference or the scatter of the answers, or scenes are missing)\n\n" + align(header, rows))


def write_targets(outcomes, folder):
    """Writes targets.csv and targets.txt; returns their names."""
    rows = []
    for outcome in outcomes:
        p1 = outcome.values(outcome.p1_rows)
        worst = outcome.worst_row
        rows.append([outcome.target.get("text"), outcome.state, outcome.label, outcome.measure, outcome.target["at_most"],
                     outcome.worst, root_mean_square(outcome.values(outcome.rows)), None if worst is None else worst.problem.name,
                     max(p1, default=None), root_mean_square(p1), outcome.note])
    write_csv(folder / "targets.csv", ["text", "state", "label", "measure", "at_most", "worst", "rms", "worst_on", "p1_worst",
                                       "p1_rms", "note"], rows)
    write_atomically(folder / "targets.txt", targets_text(outcomes) + "\n")
    return {"targets.csv", "targets.txt"}
