"""Figures of many runs, case by case and measure by measure, in the order in which the runs were started; and their steps.

A figure is the median over a case's accepted repeats after warm-up. A case with a repeat that is not accepted has none in that run;
times and memory of a process leave out repeats with a search where there are others.
"""

import math
import pathlib
from dataclasses import dataclass, field

from history import steps
from shared.records import BadRun, figure, median, read_lines, read_provenance
from shared.tables import align, write_csv

OF_PROCESS = ("wall_s", "user_s", "peak_rss_bytes")
ALWAYS = "kernel_s"
LONGEST_NAME = 16
# What may move a figure beside the code, by its key in the provenance.
SURROUNDINGS = [("plan_hash", "plan"), ("processor", "processor"), ("system", "system"), ("compiler", "compiler"),
                ("flags", "flags"), ("libraries", "libraries"), ("threads", "threads")]


def own_programs(provenance):
    """Hashes of contestants' programs and files from elsewhere; those of the project come with its commit."""
    programs = provenance.get("programs")
    return {name: hash_ for name, hash_ in programs.items() if "/" in name} if isinstance(programs, dict) else {}


@dataclass
class OneRun:
    folder: pathlib.Path
    plan: str
    started_at: str
    commit: str
    provenance: dict
    cases: dict  # records by case, in the order of the file
    name: str    # the commit of Palpate; where that is the same for all runs, the folder


@dataclass
class Point:
    run: OneRun
    value: float   # the median
    values: list   # of the repeats


@dataclass
class Step:
    place: int     # of the first point of the new level
    chance: float  # None for an exact series
    before: float  # levels: medians over the runs from step to step
    after: float

    @property
    def share(self):
        return steps.share_of(self.before, self.after)


@dataclass
class Series:
    plan: str
    case: str
    measure: dict  # name, unit, better, key, anew
    points: list
    exact: bool = False
    steps: list = field(default_factory=list)

    @property
    def name(self):
        return f"{self.case} {self.measure['name']}"

    @property
    def is_told(self):
        """Whether there are runs enough to find a step."""
        return len(self.points) >= (2 if self.exact else steps.LEAST_RUNS)

    def levels(self):
        """First and last place and the median of each level."""
        ends = [0, *(step.place for step in self.steps), len(self.points)]
        return [(first, last - 1, median([p.value for p in self.points[first:last]])) for first, last in zip(ends, ends[1:])]

    def direction(self, step):
        """"better", "worse", or nothing where neither is."""
        better = self.measure["better"]
        if not better:
            return ""
        return "better" if (step.after > step.before) == (better == "higher") else "worse"

    def surroundings(self, step):
        """What else differs between the two runs of a step."""
        before, after = (self.points[place].run.provenance for place in (step.place - 1, step.place))
        changed = [name for key, name in SURROUNDINGS if before.get(key) != after.get(key)]
        return changed + [name for name in own_programs(after) if own_programs(before).get(name) != own_programs(after)[name]]


@dataclass
class History:
    runs: list
    series: list
    notes: list

    def found(self):
        """All steps with their series, the largest first."""
        return sorted(((series, step) for series in self.series for step in series.steps), key=lambda found: -abs(found[1].share))


def find_folders(folders):
    """The run folders in these: a folder itself, those in it, and those one further down. Throws BadRun."""
    found = {}
    for name in folders:
        folder = pathlib.Path(name)
        if not folder.is_dir():
            raise BadRun(f"{folder}: expected a run, or a folder of runs, found no folder")
        paths = [folder, *sorted(folder.glob("*/")), *sorted(folder.glob("*/*/"))]
        runs = [path for path in paths if (path / "records.jsonl").is_file()]
        if not runs:
            raise BadRun(f"{folder}: expected a run (with records.jsonl), or a folder of runs, found none")
        for path in runs:
            found.setdefault(path.resolve(), path)
    return list(found.values())


def read_runs(folders, notes):
    """The runs in these folders, by their start. Those that do not say when they were made are left out, and noted."""
    runs = []
    for folder in find_folders(folders):
        provenance = read_provenance(folder)
        if not isinstance(provenance.get("started_at"), str) or not isinstance(provenance.get("plan"), str):
            notes.append(f"{folder} is left out: its provenance.json does not say of which plan it is and when it was started")
            continue
        own_notes = []
        lines = read_lines(folder / "records.jsonl", own_notes)
        notes += [f"{folder}: {note}" for note in own_notes]
        cases = {}
        for record in lines:
            cases.setdefault(str(record.get("case")), []).append(record)
        commit = str(provenance.get("commit", "unknown"))
        runs.append(OneRun(folder, provenance["plan"], provenance["started_at"], commit, provenance, cases,
                           commit + ("+" if provenance.get("dirty") else "")))
    if len({run.commit for run in runs}) == 1:
        for run in runs:
            run.name = run.folder.resolve().name[:LONGEST_NAME]
    return sorted(runs, key=lambda run: (run.started_at, str(run.folder)))


def wanted_measures(runs, measures, only):
    """Measures that are followed for each plan: the one that is asked for, or those that its runs' plans name, and the time."""
    wanted = {}
    for run in runs:
        plan_data = run.provenance.get("plan_data")
        plan_data = plan_data if isinstance(plan_data, dict) else {}
        named = plan_data.get("measure") if isinstance(plan_data.get("measure"), list) else []
        accept = plan_data.get("accept") if isinstance(plan_data.get("accept"), dict) else {}
        wanted.setdefault(run.plan, set()).update([only] if only else [*named, *accept, ALWAYS])
    return {plan: [measure for measure in measures if measure["name"] in names] for plan, names in wanted.items()}


def figures_of(records, measure):
    """The figures of a case's repeats; empty if one of them is not accepted or has none."""
    counted = [record for record in records if not record.get("warmup")]
    if any(record.get("outcome") != "accepted" for record in counted):
        return []
    if measure["name"] in OF_PROCESS and any(not record.get("searched") for record in counted):
        counted = [record for record in counted if not record.get("searched")]
    values = [figure(record, *measure["key"].strip("/").split("/")) for record in counted]
    return [] if None in values else values


def follow(series):
    """Finds the steps of a series."""
    values = [point.value for point in series.points]
    agree = all(len(set(point.values)) == 1 for point in series.points)
    series.exact = steps.is_exact(values, agree, series.measure["anew"])
    if not series.is_told:
        return
    places = steps.exact_steps(values) if series.exact else steps.scattering_steps(values)
    ends = [0, *(place for place, _ in places), len(values)]
    levels = [median(values[first:last]) for first, last in zip(ends, ends[1:])]
    series.steps = [Step(place, chance, levels[i], levels[i + 1]) for i, (place, chance) in enumerate(places)]


def read_history(folders, measures, only=None):
    """All series of at least two runs, and their steps. Throws BadRun."""
    notes = []
    runs = read_runs(folders, notes)
    found = {}
    for plan, followed in wanted_measures(runs, measures, only).items():
        for run in (run for run in runs if run.plan == plan):
            for case, records in run.cases.items():
                for measure in followed:
                    values = figures_of(records, measure)
                    if values:
                        key = (plan, case, measure["name"])
                        found.setdefault(key, Series(plan, case, measure, [])).points.append(Point(run, median(values), values))
    history = History(runs, [series for series in found.values() if len(series.points) > 1], notes)
    for series in history.series:
        follow(series)
    return history


def number_text(value):
    return f"{value:.6g}"


def share_text(share):
    return "from 0" if math.isinf(share) else f"{100 * share:+.3g}%"


def step_cells(series, step):
    before, after = series.points[step.place - 1].run, series.points[step.place].run
    unit = "" if series.measure["unit"] == "1" else series.measure["unit"]
    beside = series.surroundings(step)
    return [f"{series.plan} {series.case}", series.measure["name"], share_text(step.share), number_text(step.before), number_text(step.after), unit,
            f"{before.name} -> {after.name}", after.started_at, "exact" if step.chance is None else f"{step.chance:.2g}",
            series.direction(step) + (f" ({', '.join(beside)} changed too)" if beside else "")]


def history_text(history):
    """Steps, the largest first, and what was looked at."""
    found = history.found()
    text = ""
    if found:
        header = ["case", "measure", "step", "before", "after", "unit", "runs", "since", "chance", "note"]
        text = align(header, [step_cells(series, step) for series, step in found]) + "\n\n"
    told = [series for series in history.series if series.is_told]
    tested = sum(not series.exact for series in told)
    text += f"{len(found)} steps in {len(told)} series of {len(history.runs)} runs"
    if tested:
        text += f"; {tested} of them scatter, of which {tested * steps.LEVEL:.2g} would show a step by chance"
    few = len(history.series) - len(told)
    if few:
        text += f". {few} series scatter and have fewer than {steps.LEAST_RUNS} runs: nothing is said of them"
    return text + "." + "".join(f"\nnote: {note}" for note in history.notes)


def describe(history):
    """The same for other programs."""
    finite = lambda value: value if math.isfinite(value) else None
    return {
        "runs": [{"folder": str(run.folder), "plan": run.plan, "started_at": run.started_at, "commit": run.commit,
                  "dirty": bool(run.provenance.get("dirty"))} for run in history.runs],
        "series": len(history.series), "told": sum(series.is_told for series in history.series),
        "level": steps.LEVEL, "notes": history.notes,
        "steps": [{"plan": series.plan, "case": series.case, "measure": series.measure["name"], "unit": series.measure["unit"],
                   "before": step.before, "after": step.after, "share": finite(step.share), "chance": step.chance,
                   "exact": series.exact, "direction": series.direction(step),
                   "commit_before": series.points[step.place - 1].run.commit, "commit": series.points[step.place].run.commit,
                   "since": series.points[step.place].run.started_at, "run": str(series.points[step.place].run.folder),
                   "surroundings": series.surroundings(step)} for series, step in history.found()]}


def write_history(history, folder):
    """history.csv: a row a figure and run; steps.csv: a row a step."""
    rows = []
    for series in history.series:
        starts = {step.place for step in series.steps}
        for place, point in enumerate(series.points):
            run = point.run
            rows.append([series.plan, series.case, series.measure["name"], series.measure["unit"], run.started_at, run.commit,
                         int(bool(run.provenance.get("dirty"))), point.value, min(point.values), max(point.values),
                         len(point.values), int(place in starts), str(run.folder)])
    write_csv(folder / "history.csv", ["plan", "case", "measure", "unit", "started_at", "commit", "dirty", "median", "least",
                                       "greatest", "repeats", "step", "run"], rows)
    header = ["plan", "case", "measure", "unit", "before", "after", "share", "chance", "direction", "commit_before", "commit", "since",
              "run", "changed_too"]
    rows = [[each[key] for key in header[:-1]] + [", ".join(each["surroundings"])] for each in describe(history)["steps"]]
    write_csv(folder / "steps.csv", header, rows)
