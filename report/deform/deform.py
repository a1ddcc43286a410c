"""A contest of displacements: what each label reached on each problem, and how good the reference is that says so.

A problem is a scene at one Poisson ratio and one number of vertices. Answers to it are compared with its own reference
alone. A figure whose reference is not five times better than itself is marked `~` (docs/displacement.md); it is shown,
and it decides no target.
"""

from dataclasses import dataclass, field

from shared.intervals import span_of
from shared.records import figure, median, present
from shared.tables import compares_times, first_reason, outcome_text, timing_of

MARGIN = 5.0
PROBLEM_AXES = ("poisson_ratio", "vertices")
SIMPLIFY_AXES = ("simplify", "tets_removed_ratio")
NO_SIMPLIFIER = "none"
BEST, BEST_OTHER, COARSE = "*", "+", "~"

# The errors: name in the records, title, and where the reference record has its own error in that figure.
ERRORS = [("displacement_l2", "L2", "reference_error"), ("displacement_deformation", "deform", "reference_error_deformation"),
          ("displacement_energy", "energy", "reference_error_energy"),
          ("displacement_energy_whole", "whole", "reference_error_energy_whole"),
          ("displacement_max", "max", "reference_error_max"), ("pad_force", "pad", "reference_error_pad_force")]
SHARE = "stiffness_share_springs"
TIMES = [("identify_s", "identify"), ("solve_s", "solve"), ("kernel_s", "kernel")]
# What some methods report of an answer's cost once all is prepared.
COSTS = ("unknowns", "stiffness_entries", "factor_entries", "product_s", "answer_s")
MAIN = ERRORS[0][0]


@dataclass(frozen=True)
class Problem:
    """A scene at one Poisson ratio and number of vertices; `wanted_vertices` is the sweep's, None without one."""

    scene: str
    poisson_ratio: object
    wanted_vertices: object

    @property
    def name(self):
        return ", ".join([self.scene, *self.setting])

    @property
    def setting(self):
        """What is beside the scene's name: the same for all scenes of one figure."""
        ratio = [] if self.poisson_ratio is None else [f"nu {self.poisson_ratio:g}"]
        return ratio + ([] if self.wanted_vertices is None else [f"{self.wanted_vertices:,.0f} vertices"])


@dataclass
class Row:
    """What a label reached on a problem, on the scene's own mesh or a simplified one."""

    label: str
    method: str
    problem: Problem
    simplify: str  # "" without a simplifier
    ratio: object
    values: dict  # errors and times; what is not there is None
    own_errors: dict  # of the reference, by the names of the errors
    vertices: object
    note: str = ""
    has_reference: bool = True
    is_reference_kind: bool = False  # its method is one of those that the reference's belongs to: fem.p1 beside fem.p2
    marks: dict = field(default_factory=dict)
    spans: dict = field(default_factory=dict)  # of a figure whose answers differ: between what its median lies
    tets: object = None  # of the mesh that was solved on

    @property
    def is_judged(self):
        return self.values[MAIN] is not None


    def is_coarse(self, name):
        """Whether the reference cannot tell this figure: no estimate of its error, or not five times better."""
        value, own = self.values[name], self.own_errors.get(name)
        return value is not None and (own is None or value < MARGIN * own)


@dataclass
class Section:
    """All rows of one problem on one mesh."""

    problem: Problem
    simplify: str
    ratio: object
    reference: object  # its record, or None
    rows: list
    beside: object = None  # label of what a user would take instead, or None

    def find(self, label):
        return next((row for row in self.rows if row.label == label), None)

    @property
    def has_reference(self):
        """Whether answers could be judged; if not, it is nobody's fault."""
        return all(row.has_reference for row in self.rows)

    @property
    def peer(self):
        """The row that stands beside the others' figures, the plan's `beside`, or None."""
        return next((row for row in self.rows if row.label == self.beside and row.is_judged), None)

    @property
    def title(self):
        mesh = "" if not self.simplify or self.simplify == NO_SIMPLIFIER else f", {simplified_text(self.simplify, self.ratio)}"
        vertices = self.rows[0].vertices if self.rows else None
        is_said = vertices is None or self.problem.wanted_vertices is not None
        shown = "" if is_said else f", {vertices:,.0f} vertices"
        return self.problem.name + shown + mesh


def simplified_text(simplify, ratio):
    return simplify if ratio is None else f"{simplify} -{100 * ratio:g}%"


def sweep_of(record):
    return record.get("sweep") if isinstance(record.get("sweep"), dict) else {}


def problem_of(record):
    """The problem of a record: what the sweep says, else what the scene is."""
    sweep, scene = sweep_of(record), record.get("scene") if isinstance(record.get("scene"), dict) else {}
    mesh = record.get("mesh") if isinstance(record.get("mesh"), dict) else {}
    ratio = sweep.get("poisson_ratio", scene.get("poisson_ratio"))
    return Problem(str(scene.get("name", mesh.get("name"))), ratio, sweep.get("vertices"))


def own_errors_of(reference, record):
    """The reference's error in each figure: from its own record, the L2 error from the answer's if there is none."""
    found = {name: figure(reference, "judge", own) if reference else None for name, _, own in ERRORS}
    if found[MAIN] is None:
        found[MAIN] = figure(record, "judge", "reference_error")
    return found


def is_valid(reference):
    """Whether the record of a reference has a field to judge by. Where there is no record, the answers' own are believed."""
    judge = reference.get("judge") if reference else None
    return reference is None or isinstance(judge, dict) and judge.get("valid") is True


def values_of(group):
    values = {name: median(group.figures("judge", name)) for name, _, _ in ERRORS}
    for name in ("identify_s", "solve_s", "iterations", SHARE, *COSTS):
        values[name] = median(present(figure(record, "report", name) for record in group.accepted()))
    timing = timing_of(group)
    values["kernel_s"] = timing["kernel_median_s"] if timing else None
    return values


def note_of(group):
    """Why it has no figures, or that not all repeats were accepted."""
    if group.cases() and set(group.outcomes()) == {"accepted"}:
        return ""
    if group.cases():
        return f"{outcome_text(group)}: {first_reason(group)}"
    return first_reason(group) or "not run"


def kind_of(method):
    """What a method's name begins with: "fem" of "fem.p2"."""
    return str(method).split(".", maxsplit=1)[0]


def read_row(group, references, reference_method):
    record = group.records[0]
    problem, sweep = problem_of(record), sweep_of(record)
    reference = references.get(problem)
    own_errors = own_errors_of(reference, (group.cases() or [record])[0])
    spans = {name: span_of(group.figures("judge", name)) for name, _, _ in ERRORS if len(set(group.figures("judge", name))) > 1}
    return Row(group.label, group.contestant, problem, str(sweep.get("simplify", "")), sweep.get("tets_removed_ratio"),
               values_of(group), own_errors, figure(record, "mesh", "vertices"), note_of(group), is_valid(reference),
               bool(reference_method) and kind_of(group.contestant) == kind_of(reference_method), spans=spans,
               tets=figure(record, "solved_on", "tets") or figure(record, "mesh", "tets"))


def mark_rows(rows, with_times=True):
    """Marks what the reference cannot tell, the least figure of each column, whoever has it, and the least without methods
    of the reference's kind where that is another one."""
    for name in [name for name, _, _ in ERRORS] + (["kernel_s"] if with_times else []):
        judged = [row for row in rows if row.is_judged and row.values[name] is not None]
        for row in rows:
            row.marks[name] = ""
        for mark, field_ in ((BEST, judged), (BEST_OTHER, [row for row in judged if not row.is_reference_kind])):
            winners = [row for row in field_ if row.values[name] == min(row.values[name] for row in field_)] if len(rows) > 1 else []
            if name != "kernel_s" and any(row.is_coarse(name) for row in winners):
                continue  # who has the least cannot be told
            if not any(row.marks[name] for row in winners):
                for row in winners:
                    row.marks[name] = mark
        for row in judged:
            if name != "kernel_s" and row.is_coarse(name):
                row.marks[name] += COARSE


def read_sections(run):
    """All sections: scenes in the order of the plan, then Poisson ratio, vertices and simplifier as they come."""
    references = {problem_of(record): record for record in run.references}
    reference_method = (run.plan_data.get("reference") or {}).get("method")
    beside = run.plan_data.get("beside")
    sections = {}
    for group in run.groups:
        row = read_row(group, references, reference_method)
        key = (row.problem, row.simplify, row.ratio)
        sections.setdefault(key, Section(*key, references.get(row.problem), [], beside)).rows.append(row)
    for section in sections.values():
        mark_rows(section.rows, compares_times(run))
    return list(sections.values())


def shown_errors(sections):
    """Those of the errors that any row has: a run without pads has no column for them."""
    return [error for error in ERRORS if error[0] == MAIN
            or any(row.values[error[0]] is not None for section in sections for row in section.rows)]


def labels_of(sections):
    return list(dict.fromkeys(row.label for section in sections for row in section.rows))


def settings_of(sections):
    """What the problems have beside their scenes, each once: (Poisson ratio, vertices, simplifier, share removed)."""
    keys = dict.fromkeys(setting_of(section) for section in sections)
    return list(keys)


def setting_of(section):
    return (section.problem.poisson_ratio, section.problem.wanted_vertices, section.simplify, section.ratio)


def setting_text(setting):
    ratio, vertices, simplify, share = setting
    parts = Problem("", ratio, vertices).setting
    if simplify and simplify != NO_SIMPLIFIER:
        parts.append(simplified_text(simplify, share))
    return ", ".join(parts)


def scene_sets(run, sections):
    """The plan's sets of scenes by name; without any, all scenes."""
    given = run.plan_data.get("scene_sets")
    scenes = list(dict.fromkeys(section.problem.scene for section in sections))
    sets = {str(name): [str(scene) for scene in members] for name, members in given.items()
            if isinstance(members, list)} if isinstance(given, dict) else {}
    return sets or {"all scenes": scenes}


def root_mean_square(values):
    return (sum(value * value for value in values) / len(values)) ** 0.5 if values else None
