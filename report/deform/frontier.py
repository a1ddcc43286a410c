"""Error against work: what each model on each mesh of a scene costs and how far it is off, and which of them nothing beats.

A point is one label on one mesh of a scene (made at some size, simplified by some share). Its error is taken at the vertices of
the mesh that was made, against that mesh's own reference. Work is one of four:

  first         the first displacement: simplifier, identification, assembly, factors, solve
  further       the displacement of another load once all of that is there
  second        a simulated second of explicit steps, nine tenths of the stable step each, undamped; of modes, a thousand exact steps and
                sixty displacements of all vertices
  second_setup  the same with what has to be there before the first step: simplifier, and identification (of modes: all that finds them)

A point is off the frontier if another is surely faster (their 95% intervals of the median don't meet) and has no greater error,
or is better by more than both references leave open, and no slower in the median. What is within noise of the frontier is on it.
A point whose repeats were left out by halving (`run: {halving_from: ...}`) was surely beaten when they were, and is off it.
Failed and unsolved points are kept, and shown apart.
"""

import math
import statistics
from dataclasses import dataclass, field

from deform.deform import COARSE, ERRORS, MARGIN, NO_SIMPLIFIER, own_errors_of, problem_of, simplified_text, sweep_of
from shared.intervals import span_of
from shared.records import figure, median, present
from shared.tables import align, first_reason, percent_text, write_csv

MEASURE = "displacement_deformation"
WORKS = [("first", "first answer"), ("further", "further answer"), ("second", "simulated second"),
         ("second_setup", "simulated second with its set-up")]
MODES = "modes"  # the engine of a simulated second that is stepped by them


@dataclass(frozen=True)
class Work:
    """A time in s: the median, and between what it lies."""

    median: float
    low: float
    high: float


@dataclass
class Point:
    """A label on one mesh of a scene."""

    scene: str
    poisson_ratio: object
    label: str
    family: str
    mesh: str  # "1503", "10000, refined -50%"
    tets: object
    case: str
    errors: dict
    own_errors: dict
    works: dict  # by the names of WORKS; None where there is none
    note: str = ""
    engine: str = ""  # that steps a simulated second
    explicit_step_s: float | None = None
    halved_by: str = ""  # the case that beat it when its other repeats were left out
    on: set = field(default_factory=set)  # (work, measure) of the frontiers that it is on

    @property
    def name(self):
        return f"{self.label}, {self.mesh}"

    def has(self, work, measure):
        return self.errors.get(measure) is not None and self.works.get(work) is not None

    def is_coarse(self, measure):
        own = self.own_errors.get(measure)
        return own is None or self.errors[measure] < MARGIN * own


def asked(run):
    """What the plan asks of its frontier, or None."""
    found = run.plan_data.get("frontier")
    return found if isinstance(found, dict) else None


def names_by_label(found):
    """{label: the name of its family}."""
    return {str(label): str(name) for name, labels in found["families"].items() for label in labels}


def work_of(values, more=0.0):
    """From repeats; `more` was spent once before. With repeats too few to hold a median, its interval is everything."""
    if not values:
        return None
    low, high = span_of(values)
    return Work(median(values) + more, max(0.0, low + more), high + more)


def second_with_setup(record):
    """A simulated second and what its model took to be made; None where one of the two is not told."""
    parts = [figure(record, "report", name) for name in ("simulated_second_s", "identify_s")]
    return None if None in parts else sum(parts)


def works_of(group):
    records = group.accepted()
    simplify_s = median(present(figure(record, "solved_on", "simplify_s") for record in records)) or 0.0
    return {"first": work_of(present(figure(record, "kernel_s") for record in records), simplify_s),
            "further": work_of(present(figure(record, "report", "answer_s") for record in records)),
            "second": work_of(present(figure(record, "report", "simulated_second_s") for record in records)),
            "second_setup": work_of(present(second_with_setup(record) for record in records), simplify_s)}


def mesh_text(record):
    sweep = sweep_of(record)
    vertices = sweep.get("vertices", figure(record, "mesh", "vertices"))
    simplify = str(sweep.get("simplify", NO_SIMPLIFIER))
    made = "" if vertices is None else f"{vertices:g}"
    return made if simplify == NO_SIMPLIFIER else f"{made}, {simplified_text(simplify, sweep.get('tets_removed_ratio'))}"


def family_of(group, record, families, of_simplifiers):
    label = str(sweep_of(record).get("simplify", NO_SIMPLIFIER)) if of_simplifiers else group.label
    return families.get(label, label)


def halved_cases(run):
    """{case: the case that beats it} of those whose repeats were left out."""
    ended = run.provenance.get("repeats_ended")
    return {case: str(end.get("by", "")) for case, end in (ended or {}).items() if end.get("reason") == "halved"}


def halving_text(scenes):
    """What was skipped, or an empty text."""
    halved = [point for points in scenes.values() for point in points if point.halved_by]
    if not halved:
        return ""
    return (f"Halving: {len(halved)} of {sum(map(len, scenes.values()))} points got no more repeats once another of their family was surely faster "
            "and had no greater error; they are off the frontier, with the repeats that they have:\n"
            + "\n".join(f"  {point.case}, beaten by {point.halved_by}" for point in halved))


def read_point(group, references, families, of_simplifiers):
    record = (group.accepted() or group.records)[0]
    problem = problem_of(record)
    tets = figure(record, "solved_on", "tets")
    note = "" if group.cases() else first_reason(group) or "not run"
    return Point(problem.scene, problem.poisson_ratio, group.label, family_of(group, record, families, of_simplifiers), mesh_text(record),
                 tets if tets is not None else figure(record, "mesh", "tets"), str(record.get("case", "")),
                 {name: median(group.figures("judge", name)) for name, _, _ in ERRORS},
                 own_errors_of(references.get(problem), record), works_of(group), note,
                 str((record.get("report") or {}).get("step_engine") or ""), explicit_step_s=figure(record, "report", "explicit_step_s"))


def is_beaten(point, other, work, measure):
    """Whether `other` surely beats `point` in one and is no worse in the other."""
    own, theirs = point.works[work], other.works[work]
    error, their_error = point.errors[measure], other.errors[measure]
    open_ = sum(each.own_errors.get(measure) or 0.0 for each in (point, other))
    return ((theirs.high < own.low and their_error <= error)
            or (their_error + open_ < error and theirs.median <= own.median))


def mark_frontier(points):
    """Fills `on` of the points of one scene."""
    for work, _ in WORKS:
        for measure, _, _ in ERRORS:
            own = [point for point in points if point.has(work, measure)]
            for point in own:
                if point.halved_by:
                    continue
                if not any(is_beaten(point, other, work, measure) for other in own if other is not point):
                    point.on.add((work, measure))


def read_points(run):
    """The points scene by scene, Poisson's ratios apart: {(scene, ratio): points}."""
    families = names_by_label(asked(run))
    of_simplifiers = asked(run).get("of") == "simplifiers"
    references = {problem_of(record): record for record in run.references}
    scenes = {}
    halved = halved_cases(run)
    for group in run.groups:
        point = read_point(group, references, families, of_simplifiers)
        point.halved_by = halved.get(point.case, "")
        scenes.setdefault((point.scene, point.poisson_ratio), []).append(point)
    for points in scenes.values():
        mark_frontier(points)
    return scenes


def families_of(run):
    return [str(name) for name in asked(run)["families"]]


def fastest(points, work, error, measure=MEASURE):
    """The point with the least work among those whose error is at most that; None without one."""
    good = [point for point in points if point.has(work, measure) and point.errors[measure] <= error]
    return min(good, key=lambda point: point.works[work].median, default=None)


def scene_text(key):
    scene, ratio = key
    return scene if ratio is None else f"{scene}, nu {ratio:g}"


def equal_error_rows(run, scenes, works=tuple(work for work, _ in WORKS)):
    """One entry a work, family and error: the fastest point on each scene that has one, and its ratio to each family that the plan
    holds the others against."""
    rows = []
    for work in works:
        for family in families_of(run):
            for error in asked(run)["at"]:
                times, ratios = {}, {str(name): {} for name in asked(run).get("against", []) if str(name) != family}
                for key, points in scenes.items():
                    best = fastest([point for point in points if point.family == family], work, error)
                    if best is None:
                        continue
                    times[key] = best
                    for name, found in ratios.items():
                        peer = fastest([point for point in points if point.family == name], work, error)
                        if peer is not None:
                            found[key] = peer.works[work].median / best.works[work].median
                rows.append({"work": work, "family": family, "error": error, "times": times, "ratios": ratios,
                             "scenes": len(scenes)})
    return rows


def span_text(values, text):
    values = sorted(values)
    return text(values[0]) if len(values) == 1 else f"{text(statistics.median(values))} ({text(values[0])} to {text(values[-1])})"


def short_seconds(value):
    for unit, name in ((1.0, "s"), (1e-3, "ms"), (1e-6, "us")):
        if value >= unit:
            return f"{value / unit:.3g} {name}"
    return f"{value / 1e-6:.2g} us"


def family_cell(row, text_of=short_seconds):
    """The work over the scenes."""
    if not row["times"]:
        return "-"
    text = span_text([point.works[row["work"]].median for point in row["times"].values()], text_of)
    if len(row["times"]) < row["scenes"]:
        text += f" on {len(row['times'])} of {row['scenes']}"
    return text


def ratios_text(row, key):
    """Of one scene, for a table of comma-separated values: "CGAL=1.5 gmsh=2"."""
    return " ".join(f"{name}={found[key]:.4g}" for name, found in row["ratios"].items() if key in found)


def ratio_cell(row, name):
    found = row["ratios"].get(name)
    return "" if not found else span_text(list(found.values()), lambda value: f"{value:.3g}")


def equal_error_text(run, rows):
    """The table of times at equal error."""
    against = [str(name) for name in asked(run).get("against", [])]
    out = []
    for work, title in WORKS:
        own = [row for row in rows if row["work"] == work and any(other["times"] for other in rows
                                                                  if other["work"] == work and other["family"] == row["family"])]
        if not own:
            continue
        shown = []
        for row in own:
            first = row["error"] == asked(run)["at"][0]
            shown.append([row["family"] if first else "", f"{percent_text(row['error'])}", family_cell(row),
                          *(ratio_cell(row, name) for name in against)])
        header = ["family", "error at most, %", title, *(f"times as fast as {name}" for name in against)]
        out.append(f"{title[0].upper()}{title[1:]}: the fastest model and mesh of each family, median over the scenes (least to most)\n\n"
                   + align(header, shown))
    return "\n\n".join(out)


def frontier_rows(scenes, work):
    for key, points in scenes.items():
        own = sorted((point for point in points if (work, MEASURE) in point.on), key=lambda point: point.works[work].median)
        for place, point in enumerate(own):
            others = [title for name, title, _ in ERRORS if name != MEASURE and (work, name) in point.on]
            yield [scene_text(key) if place == 0 else "", short_seconds(point.works[work].median),
                   percent_text(point.errors[MEASURE]) + (COARSE if point.is_coarse(MEASURE) else ""), point.label, point.mesh,
                   " ".join(others)]


def frontier_text(run, scenes, rows):
    """All tables, and the command that repeats a point."""
    out = []
    for work, title in WORKS:
        shown = list(frontier_rows(scenes, work))
        if shown:
            out.append(f"On the frontier of error and {title}: nothing is surely faster and as good\n\n"
                       + align(["scene", "time", "deform %", "label", "mesh", "on it too by"], shown))
    out.append(equal_error_text(run, rows))
    outcomes = judge_targets(run, scenes)
    if outcomes:
        out.append(targets_text(outcomes))
    if halving_text(scenes):
        out.append(halving_text(scenes))
    if modes_text(scenes):
        out.append(modes_text(scenes))
    lost = [point for points in scenes.values() for point in points if point.note]
    if lost:
        out.append("Not on any frontier, since there is no answer:\n\n"
                   + align(["scene", "label", "mesh", "note"],
                           [[scene_text((point.scene, point.poisson_ratio)), point.label, point.mesh, point.note[:90]] for point in lost]))
    out.append(f"A point again: palpate run PLAN --case ID, with the ID that tables/frontier.csv has. {COARSE}: the reference is not {MARGIN:g} times better.")
    return "\n\n".join(out)


def modes_text(scenes):
    """What the error of a simulated second by modes does not have in it, or an empty text."""
    labels = sorted({point.label for points in scenes.values() for point in points if point.engine == MODES})
    if not labels:
        return ""
    return (f"Stepped by modes: {', '.join(labels)}. Their errors are those of the body at rest, where the static correction makes any number of "
            "modes as exact as their elements: what the modes leave out of a motion is in none of them. The plan dynamic_error has motions, and "
            "palpate fit holds modes against the same elements stepped whole.")


def judge_targets(run, scenes):
    """For each target of the plan: the factor between the fastest of the others and the family that it names, scene by scene."""
    outcomes = []
    for target in asked(run).get("targets", []):
        work, name, error = target["work"], str(target["against"]), target["at"]
        found = {}
        for key, points in scenes.items():
            best = fastest([point for point in points if point.family != name], work, error)
            peer = fastest([point for point in points if point.family == name], work, error)
            found[key] = (best, peer)
        outcomes.append((target, found))
    return outcomes


def targets_text(outcomes):
    rows = []
    for target, found in outcomes:
        ratios = [peer.works[target["work"]].median / best.works[target["work"]].median
                  for best, peer in found.values() if best and peer]
        missing = sum(1 for best, peer in found.values() if not best or not peer)
        met = "" if not ratios else "yes" if min(ratios) >= target["factor"] and not missing else "no"
        note = f"no pair on {missing} of {len(found)} scenes" if missing else ""
        rows.append([f"{dict(WORKS)[target['work']]} at {percent_text(target['at'])}%, against {target['against']}", f"{target['factor']:g}",
                     span_text(ratios, lambda value: f"{value:.3g}") if ratios else "-", met or "open", note])
    return "Targets: times as fast, the fastest of all others against a family\n\n" + align(["target", "wanted", "found", "met", "note"], rows)


POINT_HEADER = ["scene", "poisson_ratio", "family", "label", "mesh", "tets", "case", *(name for name, _, _ in ERRORS),
                *(own for _, _, own in ERRORS),
                *(f"{work}_{what}" for work, _ in WORKS for what in ("s", "low_s", "high_s")),
                *(f"on_{work}" for work, _ in WORKS), "halved_by", "note"]


def finite(value):
    return value if value is not None and math.isfinite(value) else None


def point_row(point):
    works = []
    for work, _ in WORKS:
        found = point.works[work]
        works += [None] * 3 if found is None else [found.median, finite(found.low), finite(found.high)]
    return [point.scene, point.poisson_ratio, point.family, point.label, point.mesh, point.tets, point.case,
            *(point.errors[name] for name, _, _ in ERRORS), *(point.own_errors[name] for name, _, _ in ERRORS), *works,
            *(" ".join(name for name, _, _ in ERRORS if (work, name) in point.on) for work, _ in WORKS), point.halved_by, point.note]


def write_frontier(scenes, rows, folder):
    """Writes frontier.csv, a row a point, and equal_error.csv; returns their names."""
    write_csv(folder / "frontier.csv", POINT_HEADER, [point_row(point) for points in scenes.values() for point in points])
    write_csv(folder / "equal_error.csv", ["work", "family", "error", "scene", "poisson_ratio", "label", "mesh", "case", "time_s", "times_as_fast_as"],
              [[row["work"], row["family"], row["error"], *key, point.label, point.mesh, point.case, point.works[row["work"]].median,
                ratios_text(row, key)]
               for row in rows for key, point in row["times"].items()])
    return {"frontier.csv", "equal_error.csv"}
