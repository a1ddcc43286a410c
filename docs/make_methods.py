#!/usr/bin/env python3
"""docs/methods.md from the records of its five plans.

    make_methods.py AT_REST IN_MOTION LARGE SOFT STIFF -o FILE

AT_REST is a run of methods_at_rest, IN_MOTION of methods_in_motion, LARGE of methods_in_motion_large, SOFT of dynamic_error, STIFF of dynamic_error_stiff. Every
figure is of a record; what a method can do at all is told in words, in KINDS. Exit codes: 0 done; 2 a folder is no such run.
"""

import argparse
import pathlib
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent.parent / "report"))

from shared.records import BadRun, figure, median, present, read_run  # noqa: E402
from shared.tables import write_atomically  # noqa: E402

PLANS = ("methods_at_rest", "methods_in_motion", "methods_in_motion_large", "dynamic_error", "dynamic_error_stiff")
MIB = 1024.0 * 1024.0

# What each can do: small strain, large strain, motion, a pad that comes and goes, cutting while it runs, and what stands against it.
KINDS = [
    ("springs along edges", "nu near 1/4", "yes", "yes", "yes", "yes: a spring less", "cannot follow nu above 1/4; get softer as meshes get finer"),
    ("springs and a volume energy", "yes", "yes", "yes", "yes", "yes, sums of the nodes anew", "identified once, for one mesh"),
    ("linear tetrahedra", "stiff near nu 1/2", "yes", "yes", "yes", "yes", "lock"),
    ("smoothed elements (edge_node, blend)", "yes", "yes", "yes", "yes", "yes, domains anew", "three times the work of linear tetrahedra"),
    ("finite elements, quadratic", "yes", "yes", "small strain", "yes", "factors anew", "seven to eight times the unknowns of linear ones"),
    ("reduced.compliance", "yes", "no", "no inertia", "yes, any", "no", "table of one mesh and one Poisson's ratio; memory grows as the square of the skin"),
    ("reduced.modal", "yes", "no", "yes, any step", "new modes each time", "no", "few modes don't see a small pad"),
    ("reduced.pod", "no", "yes, on what it was trained for", "no", "places and supports of the training", "no", "trained in minutes for one holding, then kept in a file; a load unlike the training's is off unseen"),
    ("finite_spheres", "yes", "no", "no", "yes", "no vertex needs moving", "dear: hundreds of neighbours"),
    ("finite_spheres.collocation", "yes", "no", "no", "yes", "no vertex needs moving", "forces balance only by a share; small spheres break down near nu 1/2 (docs/finite_spheres.md)"),
    ("lattices, hexahedral or body-centred", "yes", "no", "yes", "yes", "a cell less", "a skin of steps; the answer depends on how the cells lie (docs/lattices.md)"),
    ("fem.p2_patch, fem.p2_coarse, fem.p1_modes", "yes", "no", "no", "yes", "factors anew", "spaces made for one scene's pads and supports (docs/where_error_lives.md)"),
    ("implicit steps (trapezoidal, bdf2)", "any model", "any model", "any step", "factors anew", "factors anew", "backward Euler damps by itself"),
    ("XPBD with neo-Hookean tetrahedra", "stiff near nu 1/2", "yes, inside out too", "any step", "yes", "yes, a tetrahedron less", "locks once converged; too soft before"),
    ("fixed iterations (projective, xpbd, vbd)", "any model", "any model", "any step", "yes", "projective: factors anew", "what the iterations leave looks like softness or damping"),
]

# Why the plan of the largest size has no scene of a kind. Others are in it: the runs that the page is made of are older.
NOT_AT_LARGEST = {
    "springs_volume": "in the engine of every force it would take an hour and more a simulated second, by the growth of the others",
    "tets_neo_hookean": "the kind stands there with another law",
    "edge_node_corotated": "the kind stands there with another law",
    "edge_node_trapezoidal": "its factors of 300,000 unknowns take longer than the four minutes that an answer has",
    "edge_node_bdf2": "its factors of 300,000 unknowns take longer than the four minutes that an answer has",
    "edge_node_projective": "left out with all steps that factor; how long its scalar factor takes there was not tried",
    "springs_projective": "left out with all steps that factor; how long its scalar factor takes there was not tried",
}
IN_THE_PLAN = "in the plan now, but not when the run behind this page was made"


def judged(run, label, vertices):
    """The accepted records of a label at a number of vertices."""
    return [record for group in run.groups if group.label == label for record in group.accepted()
            if figure(record, "sweep", "vertices") == vertices]


def reason_of(record):
    """How a record that was not accepted ended: in the contestant's word, if that says more than the judge's."""
    report = record.get("report") if isinstance(record.get("report"), dict) else {}
    own = report.get("outcome")
    return str(record.get("outcome") if own in (None, "completed", "converged") else own)


def why_none(run, label, vertices):
    """Why a label has no accepted record there."""
    for group in run.groups:
        for record in group.records:
            if group.label == label and figure(record, "sweep", "vertices") == vertices and record.get("outcome") != "accepted":
                return reason_of(record)
    return "not run"


def percent(value):
    return "" if value is None else f"{100.0 * value:.3g}"


def seconds(value):
    if value is None:
        return ""
    for unit, factor in (("s", 1.0), ("ms", 1e3)):
        if value * factor >= 1.0:
            return f"{value * factor:.3g} {unit}"
    return f"{1e6 * value:.3g} us"


def table(header, rows):
    lines = ["| " + " | ".join(header) + " |", "|" + "---|" * len(header)]
    return "\n".join([*lines, *("| " + " | ".join(row) + " |" for row in rows)])


def root_mean_square(values):
    return (sum(value * value for value in values) / len(values)) ** 0.5


def by_case(records):
    cases = {}
    for record in records:
        cases.setdefault(record["case"], []).append(record)
    return list(cases.values())


def spread_of(records, *keys):
    """The widest of the cases' spreads, (greatest - least) / median; None without repeats."""
    spreads = []
    for own in by_case(records):
        values = present(figure(record, *keys) for record in own)
        if len(values) > 1 and median(values) > 0:
            spreads.append((max(values) - min(values)) / median(values))
    return max(spreads, default=None)


ANSWER_PARTS = ("react_s", "move_skin_s", "move_inside_s")


def again_of(record):
    """Time of a further answer with all that is kept, where the report tells it."""
    parts = present(figure(record, "report", name) for name in ANSWER_PARTS)
    return sum(parts) if parts else None


MARGIN = 5.0  # as the tables of displacements have it: a figure that is not so many times the reference's own error decides nothing


def own_error(run, vertices):
    """The greatest of the references' own errors of the deformation at a number of vertices; None if it is not known."""
    return max(present(figure(record, "judge", "reference_error_deformation") for record in run.references
                       if figure(record, "sweep", "vertices") == vertices), default=None)


def rest_cells(run, label, vertices):
    records = judged(run, label, vertices)
    if not records:
        return [why_none(run, label, vertices), "", "", ""]
    cases = by_case(records)
    errors = present(figure(own[0], "judge", "displacement_deformation") for own in cases)
    memory = max(present(figure(record, "peak_rss_bytes") for record in records), default=None)
    again = present(again_of(record) for record in records)
    error = f"{percent(root_mean_square(errors))} / {percent(max(errors))}" if errors else "none"
    own = own_error(run, vertices)
    if errors and own is not None and root_mean_square(errors) < MARGIN * own:
        error += "~"
    first = median(present(figure(record, "kernel_s") for record in records))
    return [error, seconds(first), seconds(median(again)) if again else "-", f"{memory / MIB:.0f}" if memory else ""]


def sizes_of(run, key):
    values = {figure(record, *key) for group in run.groups for record in group.records}
    return sorted(value for value in values if value is not None)


def labels_of(run):
    return list(dict.fromkeys(group.label for group in run.groups))


def at_rest(run):
    sizes = sizes_of(run, ("sweep", "vertices"))
    header = ["model"]
    for size in sizes:
        header += [f"{size:.0f}: deformation, %", "first answer", "a further one", "MiB"]
    rows = [[f"`{label}`", *(cell for size in sizes for cell in rest_cells(run, label, size))] for label in labels_of(run)]
    own = {size: own_error(run, size) for size in sizes}
    known = ", ".join(f"{percent(value)}% at {size:.0f} vertices" for size, value in own.items() if value is not None)
    spread = spread_of([record for group in run.groups for record in group.accepted()], "kernel_s")
    text = [table(header, rows), ""]
    text.append(f"Root mean square / worst of {len({record['scene']['name'] for g in run.groups for record in g.accepted()})} scenes (weight, a pad, a force). "
                "First answer: everything from the mesh on, median; a further one: another load on the same supports, where the method tells it apart.")
    if known:
        text.append(f"The reference's own error, the greatest of the scenes: {known}; what is not {MARGIN:g} times larger is marked ~ and not told apart from its neighbours.")
    if spread is not None:
        text.append(f"The widest spread of a case's repeats: {100 * spread:.0f}% of their median.")
    return "\n".join(text)


def motion_cells(records):
    step = median(present(figure(record, "report", "time_step_s") for record in records))
    cost = median([figure(record, "kernel_s") / figure(record, "report", "steps") for record in records])
    second = median([figure(record, "kernel_s") / figure(record, "report", "simulated_s") for record in records])
    memory = max(present(figure(record, "peak_rss_bytes") for record in records), default=0.0)
    return [seconds(step), seconds(cost), f"{second:.3g}", f"{memory / MIB:.0f}"]


def why_not_run(groups, size):
    """Why kinds have no record at the largest size; nothing where all have one."""
    ran = {group.mesh for group in groups for record in group.records if figure(record, "options", "vertices") == size}
    reasons = {}
    for scene in dict.fromkeys(group.mesh for group in groups):
        if scene not in ran:
            kind = scene.removeprefix("methods_")
            reasons.setdefault(NOT_AT_LARGEST.get(kind, IN_THE_PLAN), []).append(f"`{kind}`")
    if not reasons:
        return ""
    return f"\n\nNot run at {size:.0f} vertices: " + "; ".join(f"{', '.join(kinds)} ({reason})" for reason, kinds in reasons.items()) + "."


def in_motion(runs):
    sizes = sorted({size for run in runs for size in sizes_of(run, ("options", "vertices"))})
    groups = [group for run in runs for group in run.groups]
    header = ["model"]
    for size in sizes:
        header += [f"{size:.0f}: step", "a step takes", "s a simulated s", "MiB"]
    rows = []
    for scene in dict.fromkeys(group.mesh for group in groups):
        row = [f"`{scene.removeprefix('methods_')}`"]
        for size in sizes:
            every = [record for group in groups if group.mesh == scene for record in group.records
                     if figure(record, "options", "vertices") == size]
            records = [record for record in every if record.get("outcome") == "accepted"]
            row += motion_cells(records) if records else [reason_of(every[0]) if every else "not run", "", "", ""]
        rows.append(row)
    spread = spread_of([record for group in groups for record in group.accepted()], "kernel_s")
    text = table(header, rows) + why_not_run(groups, sizes[-1])
    return text if spread is None else f"{text}\n\nThe widest spread of a case's repeats: {100 * spread:.0f}% of their median."


def dynamic_rows(run):
    for scene in dict.fromkeys(group.mesh for group in run.groups):
        for group in run.groups:
            if group.mesh != scene:
                continue
            records = group.accepted()
            if not records:
                yield [scene, f"`{group.label}`", reason_of(group.records[0]), "", "", "", ""]
                continue
            record = records[0]
            seconds_simulated = figure(record, "report", "steps") * figure(record, "report", "time_step_s")
            yield [scene, f"`{group.label}`", percent(figure(record, "judge", "probe_l2")), percent(figure(record, "judge", "solver_probe_l2")),
                   percent(figure(record, "judge", "force_l2")), f"{figure(record, 'report', 'steps'):.0f}",
                   f"{figure(record, 'report', 'solve_s') / seconds_simulated:.3g}"]


def dynamic(run):
    own = [f"{record['scene']['name']}: {percent(figure(record, 'judge', 'own_error', 'probe_l2'))}" for record in run.references]
    return table(["scene", "model", "probe, %", "of it the solver's, %", "force, %", "steps", "s a simulated s"], list(dynamic_rows(run))) + \
        f"\n\nThe reference's own error of the probe, in %: {'; '.join(own)}."


def machine_of(runs):
    """Processor, commits and loads, for the reader."""
    facts = []
    for run in runs:
        known = run.provenance
        load = known.get("load") or [None]
        facts.append(f"{run.plan}: commit {known.get('commit')}{' (changed)' if known.get('dirty') else ''}, {known.get('started_at', '')[:10]}, load {load[0]} at its start")
    return f"{runs[0].provenance.get('processor')}, {runs[0].provenance.get('processors')} cores. " + "; ".join(facts) + "."


def page_text(runs):
    rest, motion, large, soft, stiff = runs
    kinds = table(["kind", "small strain", "large strain", "motion", "pads", "cutting while it runs", "what stands against it"], [list(kind) for kind in KINDS])
    return f"""# Which method for which organ

Made by `docs/make_methods.sh`; don't edit. Every figure comes from a record of the plans that stand above its table (`results/published` has them); what a method can do at all is told in words.

## What each can do

{kinds}

## At rest

`methods_at_rest.yaml`: a kidney on elastic supports, Poisson's ratio 0.45, one thread. Nothing was chosen on this body.

{at_rest(rest)}

## What a step costs

`methods_in_motion.yaml`, `methods_in_motion_large.yaml`: a pad presses a kidney of 10 kPa, one thread. Explicit steps are nine tenths of the predicted bound, on the engine that is fastest for the model
(single precision for the plain and the tet engine; `springs_volume` in the engine of every force); the others have the step of their name, in the engine of every force. `springs_xpbd` and `tets_xpbd` sweep
eight springs or domains at a time in double precision (docs/integrators.md): on the kidney of 1,503 vertices, old and new in turns on a busy machine, a step of one sweep takes a fifth of what one spring at a time
took, and a ninth with tetrahedra. `vbd` is one vertex at a time, so that its rows are dearer than they have to be, and no verdict on the method. The time is that of all steps over their number: factorisations are in it. At another Young's modulus the explicit bound
goes with 1 / sqrt(E) (damped: with less), and the others stay.

{in_motion([motion, large])}

## How far motions are off

`dynamic_error.yaml`, 10 kPa, some 600 vertices (docs/dynamic_error.md has what the columns mean):

{dynamic(soft)}

`dynamic_error_stiff.yaml`, 1 MPa:

{dynamic(stiff)}

## The machine

{machine_of(runs)}
"""


def main(words=None):
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("runs", nargs=len(PLANS), type=pathlib.Path, metavar="RUN")
    parser.add_argument("-o", dest="page", type=pathlib.Path, required=True)
    arguments = parser.parse_args(words)
    try:
        runs = [read_run(folder) for folder in arguments.runs]
        for run, plan in zip(runs, PLANS):
            if run.plan != plan:
                raise BadRun(f"{run.folder}: expected a run of {plan}, found one of {run.plan}")
    except BadRun as error:
        print(error, file=sys.stderr)
        return 2
    write_atomically(arguments.page, page_text(runs))
    return 0


if __name__ == "__main__":
    sys.exit(main())
