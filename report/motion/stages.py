"""From simplifier to motion: what each stage of a body costs, and what it adds to the error of its motion.

A body is a simplified mesh, springs (or elements) identified on it, and steps. Its error stands beside that of the same model on
the whole mesh: the difference is what the simplifier added, the rest what the model has anyway.
"""

from dataclasses import dataclass

from motion.motion import MEASURES, WHOLE, mesh_of, problem_sweep
from shared.records import figure, median, present
from shared.tables import align, first_reason, percent_text, seconds_text, timing_of, write_csv

ERRORS = [measure for measure in MEASURES if measure.name in ("probe_l2", "force_l2", "frequency_first")]
TIMES = [("simplify_s", "simplify"), ("identify_s", "identify"), ("solve_s", "steps"), ("kernel_s", "all but simplify")]


@dataclass
class Stage:
    """A label on one mesh of a scene."""

    scene: str
    sweep: tuple
    label: str
    mesh: str
    tets: object
    errors: dict
    times: dict
    note: str
    whole: object = None  # the same label on the whole mesh, or None

    def added(self, name):
        """What the simplifier adds to an error; None without both."""
        own, before = self.errors[name], self.whole.errors[name] if self.whole else None
        return None if own is None or before is None else abs(own) - abs(before)


def read_stage(group):
    record = (group.cases() or group.records)[0]
    accepted = group.accepted()
    tets = figure(record, "solved_on", "tets")
    timing = timing_of(group)
    times = {"simplify_s": median(present(figure(each, "solved_on", "simplify_s") for each in accepted)),
             "identify_s": median(present(figure(each, "report", "identify_s") for each in accepted)),
             "solve_s": median(present(figure(each, "report", "solve_s") for each in accepted)),
             "kernel_s": timing["kernel_median_s"] if timing else None}
    return Stage(group.mesh, problem_sweep(record), group.label, mesh_of(record), tets if tets is not None else figure(record, "mesh", "tets"),
                 {measure.name: median(group.figures("judge", measure.name)) for measure in ERRORS}, times,
                 "" if group.cases() else first_reason(group) or "not run")


def read_stages(run):
    """All of a run whose plan has simplifiers; nothing otherwise."""
    if not run.plan_data.get("simplify"):
        return []
    stages = [read_stage(group) for group in run.groups]
    wholes = {(stage.scene, stage.sweep, stage.label): stage for stage in stages if stage.mesh == WHOLE}
    for stage in stages:
        if stage.mesh != WHOLE:
            stage.whole = wholes.get((stage.scene, stage.sweep, stage.label))
    return stages


def change_text(value):
    return "" if value is None else ("-" if value < 0 else "+") + percent_text(abs(value))


def stages_text(stages):
    header = ["scene", "mesh", "tets", "label", *(f"{measure.title}" for measure in ERRORS), *(f"added {measure.title}" for measure in ERRORS),
              *(title for _, title in TIMES), "note"]
    rows = [[stage.scene, stage.mesh, "" if stage.tets is None else f"{stage.tets:,.0f}", stage.label,
             *(percent_text(stage.errors[measure.name]) for measure in ERRORS), *(change_text(stage.added(measure.name)) for measure in ERRORS),
             *(seconds_text(stage.times[name]) for name, _ in TIMES), stage.note] for stage in stages]
    return ("From simplifier to motion: errors against elastodynamics on the whole mesh; added: what the simplifier changes of them, the model on the\n"
            "whole mesh taken off. Times: medians; simplify once for all labels of a mesh.\n\n" + align(header, rows))


def write_stages(stages, folder):
    """Writes stages.csv; returns its name."""
    names = [measure.name for measure in ERRORS]
    write_csv(folder / "stages.csv", ["scene", "mesh", "tets", "label", *names, *(f"added_{name}" for name in names), *(name for name, _ in TIMES), "note"],
              [[stage.scene, stage.mesh, stage.tets, stage.label, *(stage.errors[name] for name in names), *(stage.added(name) for name in names),
                *(stage.times[name] for name, _ in TIMES), stage.note] for stage in stages])
    return {"stages.csv"}
