"""Error against the number of tetrahedra: what each simplifier leaves of a scene's answer, count by count.

Simplifiers of one method and one setting that differ only in `grade` (docs/graded.md) are one family: sizes by the scene beside one size.
"""

import json
from dataclasses import dataclass

from deform import frontier
from deform.deform import ERRORS, MAIN, NO_SIMPLIFIER
from shared.equal_count import is_equal
from shared.tables import write_csv

DEFORMATION = "displacement_deformation"
ENERGY = "displacement_energy"
ONE_SIZE = "one size"
AS_MANY = 0.005  # counts of tetrahedra that are this near are the same


@dataclass(frozen=True)
class Simplifier:
    """One of the plan's."""

    label: str
    family: str  # label of the first with the same method and setting
    sizes: str  # what the wanted sizes are: "one size", "near loads", "by a pilot", ...
    is_best: bool = False  # of a family that the plan names: not one simplifier, but the best of them, count by count


@dataclass
class Curve:
    """A label on the meshes of one simplifier, from many tetrahedra to few. `rows` are judged; `whole` is the row on the mesh as it is."""

    problem: object
    label: str
    simplifier: Simplifier
    rows: list
    whole: object


def sizes_text(grade):
    if not isinstance(grade, dict):
        return ONE_SIZE
    near = grade.get("near") or []
    parts = [f"near {', '.join(str(place) for place in near)}"] if near else []
    return " + ".join(parts + (["by a pilot"] if "pilot" in grade else [])) or ONE_SIZE


def read_simplifiers(plan_data):
    """Those of the plan by their labels; `none` is not among them."""
    found, families = {}, {}
    given = plan_data.get("simplify")
    for entry in given if isinstance(given, list) else []:
        entry = entry if isinstance(entry, dict) else {"method": str(entry)}
        label = str(entry.get("label", entry.get("method")))
        if label == NO_SIMPLIFIER:
            continue
        setting = (str(entry.get("method")), json.dumps(entry.get("set"), sort_keys=True), json.dumps(entry.get("keep")))
        found[label] = Simplifier(label, families.setdefault(setting, label), sizes_text(entry.get("grade")))
    return found


def read_curves(run, sections):
    """All curves with at least two counts, in the order of the plan."""
    simplifiers = read_simplifiers(run.plan_data)
    curves, wholes = {}, {}
    for section in sections:
        for row in section.rows:
            if not row.is_judged or row.tets is None:
                continue
            if section.simplify == NO_SIMPLIFIER:
                wholes[row.problem, row.label] = row
            elif section.simplify and section.ratio is not None:
                simplifier = simplifiers.get(section.simplify) or Simplifier(section.simplify, section.simplify, ONE_SIZE)
                key = (row.problem, row.label, simplifier)
                curves.setdefault(key, Curve(*key, [], None)).rows.append(row)
    for (problem, label, _), curve in curves.items():
        curve.whole = wholes.get((problem, label))
        curve.rows.sort(key=lambda row: -row.tets)
    place = {label: k for k, label in enumerate(simplifiers)}
    found = [curve for curve in curves.values() if len({row.tets for row in curve.rows}) > 1]
    return sorted(found, key=lambda curve: place.get(curve.simplifier.label, len(place)))


def named_families(plan_data):
    """{label: name} where the plan gives its simplifiers to families (`frontier`)."""
    asked = plan_data.get("frontier")
    is_given = isinstance(asked, dict) and asked.get("of") == "simplifiers" and isinstance(asked.get("families"), dict)
    return frontier.names_by_label(asked) if is_given and all(isinstance(labels, list) for labels in asked["families"].values()) else {}


def families_of_several(curves):
    """Those of more than one simplifier."""
    members = {}
    for curve in curves:
        members.setdefault(curve.simplifier.family, set()).add(curve.simplifier.label)
    return {family for family, labels in members.items() if len(labels) > 1}


def best_curve(name, own, measure):
    """The best of a family, count by count: of each share that is removed the row with the least error."""
    best = {}
    for row in (row for curve in own for row in curve.rows if row.values[measure] is not None):
        if row.ratio not in best or row.values[measure] < best[row.ratio].values[measure]:
            best[row.ratio] = row
    rows = sorted(best.values(), key=lambda row: -row.tets)
    return Curve(own[0].problem, own[0].label, Simplifier(name, name, ONE_SIZE, is_best=True), rows,
                 next((curve.whole for curve in own if curve.whole is not None), None))


def shown_curves(curves, plan_data):
    """What a chart can show of many simplifiers: those with several sizes as they are; of the others, where the plan has named families, the best of each
    family in their place, graded ones among them. All of them without named families."""
    names, measure, several = named_families(plan_data), measure_of(curves), families_of_several(curves)
    shown = [curve for curve in curves if curve.simplifier.family in several or curve.simplifier.label not in names]
    members = {}
    for curve in curves:
        if curve.simplifier.label in names:
            members.setdefault((curve.problem, curve.label, names[curve.simplifier.label]), []).append(curve)
    return shown + [best_curve(name, own, measure) for (_, _, name), own in members.items()]


def measure_of(curves):
    """What is shown: the error of the deformation, or, in runs of before it was judged, the L2 error."""
    return DEFORMATION if any(row.values.get(DEFORMATION) for curve in curves for row in curve.rows) else MAIN


def write_counts(curves, folder):
    """One line a point."""
    names = [name for name, _, _ in ERRORS]
    rows = []
    for curve in curves:
        for row in curve.rows:
            problem, simplifier = curve.problem, curve.simplifier
            rows.append([problem.scene, problem.poisson_ratio, problem.wanted_vertices, curve.label, simplifier.label, simplifier.family, simplifier.sizes,
                         row.ratio, row.tets, *(row.values[name] for name in names), row.own_errors.get(DEFORMATION)])
    write_csv(folder / "error_count.csv", ["scene", "poisson_ratio", "vertices", "label", "simplify", "family", "sizes", "tets_removed_ratio", "tets",
                                           *names, "reference_error_deformation"], rows)
    return {"error_count.csv"}


def write_gradings(curves, folder):
    """One line a graded mesh whose simplifier also made one of one size with as many tetrahedra: its errors over that one's."""
    usual = {(curve.problem, curve.label, curve.simplifier.family, row.ratio): row
             for curve in curves if curve.simplifier.sizes == ONE_SIZE for row in curve.rows}
    rows = []
    for curve in curves:
        for row in curve.rows if curve.simplifier.sizes != ONE_SIZE else []:
            problem, simplifier = curve.problem, curve.simplifier
            other = usual.get((problem, curve.label, simplifier.family, row.ratio))
            if other is None or not is_equal(row.tets, other.tets, AS_MANY):
                continue
            cells = []
            for name in (DEFORMATION, ENERGY):
                share = row.values[name] / other.values[name] if row.values.get(name) is not None and other.values.get(name) else None
                cells += [share, None if share is None else "yes" if share < 1 else "no"]
            rows.append([problem.scene, problem.poisson_ratio, problem.wanted_vertices, curve.label, simplifier.label, simplifier.family, simplifier.sizes,
                         row.ratio, row.tets, other.tets, *cells])
    if not rows:
        return set()
    write_csv(folder / "gradings.csv", ["scene", "poisson_ratio", "vertices", "label", "simplify", "family", "sizes", "tets_removed_ratio", "tets",
                                        "tets_of_one_size", "deformation_over_one_size", "deformation_better", "energy_over_one_size", "energy_better"], rows)
    return {"gradings.csv"}
