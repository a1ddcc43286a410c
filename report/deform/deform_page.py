"""What a contest of displacements has for the page of its run."""

from deform import counts, element_steps, frontier, soonest, targets
from deform.deform import COARSE, ERRORS, MAIN, MARGIN, TIMES, problem_of, root_mean_square, sweep_of
from deform.deform_tables import TITLES, reference_text, set_rows, setting_text
from shared.page_parts import BAD, GOOD, OPEN, PLAIN, Axis, Body, Chart, Column, Field, PageParts, Section, Table
from shared.run_meshes import displacement_beside, mesh_beside, quality_field
from shared.tables import timing_of

STATES = {targets.MET: GOOD, targets.MISSED: BAD, targets.OPEN: OPEN}
MOST_BODIES = 40  # read from files; the page takes as many of them as it has room for


def percent(value):
    return None if value is None else 100.0 * value


def milliseconds(value):
    return None if value is None else 1000.0 * value


# --- The verdict --------------------------------------------------------------------------------------------------------


def targets_sentence(outcomes):
    states = [outcome.state for outcome in outcomes]
    said = ", ".join(f"{states.count(state)} {state}" for state in (targets.MET, targets.MISSED, targets.OPEN) if state in states)
    text = f"Of {len(outcomes)} target{'s' if len(outcomes) > 1 else ''}: {said}"
    worst = next((outcome for outcome in outcomes if outcome.state == targets.MISSED), outcomes[0])
    if worst.worst is not None:
        text += f"; {worst.target.get('text', '')}: {worst.label} has {100 * worst.worst:.2f}% at worst, at most {100 * worst.target['at_most']:g}% was asked for"
    return text + "."


def best_sentence(sections):
    """The label with the least root mean square error over all problems that it solved."""
    errors = {}
    for section in sections:
        for row in section.rows:
            if row.is_judged and not row.is_reference_kind and row.values[MAIN] is not None:
                errors.setdefault(row.label, []).append(row.values[MAIN])
    most = max((len(values) for values in errors.values()), default=0)
    full = {label: values for label, values in errors.items() if len(values) == most}
    if not full:
        return "No answer could be judged."
    label = min(full, key=lambda name: root_mean_square(full[name]))
    return (f"Nearest to the reference over {most} problem{'s' if most > 1 else ''} is {label}: relative L2 error {100 * root_mean_square(full[label]):.3g}% root mean square, "
            f"{100 * max(full[label]):.3g}% at worst.")


def verdict_of(run, sections, points, outcomes):
    if outcomes:
        states = {outcome.state for outcome in outcomes}
        return targets_sentence(outcomes), STATES[next(state for state in (targets.MISSED, targets.OPEN, targets.MET) if state in states)]
    return (soonest.sentence(run, points) if points else best_sentence(sections)), PLAIN


# --- Charts -------------------------------------------------------------------------------------------------------------


def own_key(name):
    return f"{name}_own"


def error_rows(run, sections):
    """One row a label and problem, with all of its errors and times."""
    groups = {place_of(group): group for group in run.groups}
    rows = []
    for section in sections:
        for row in section.rows:
            if not row.is_judged:
                continue
            found = {"label": row.label, "problem": section.title, "scene": row.problem.scene, "vertices": row.vertices, "time": row.values["kernel_s"],
                     "hollow": row.is_coarse(MAIN), "note": row.note}
            for name, _, _ in ERRORS:
                found[name] = row.values[name]
                found[own_key(name)] = row.own_errors.get(name)
                if name in row.spans:
                    found[f"{name}_low"], found[f"{name}_high"] = row.spans[name]
            rows.append(found | repeat_of(groups.get((row.label, row.problem, row.simplify, row.ratio))))
    return rows


def place_of(group):
    """What tells a group's row from others': label, problem, and the simplifier of its mesh."""
    sweep = sweep_of(group.records[0])
    return group.label, problem_of(group.records[0]), str(sweep.get("simplify", "")), sweep.get("tets_removed_ratio")


def repeat_of(group):
    """The case by which a row is repeated, and the interval of its time."""
    if group is None:
        return {}
    timing = timing_of(group) or {}
    return {"case": case_of(group), "time_low": timing.get("kernel_median_low_s"), "time_high": timing.get("kernel_median_high_s")}


def words_of(name):
    """A measure as it stands in a sentence."""
    return TITLES[name].lower().replace("l2", "L2")


def error_axis(name):
    return Axis(name, words_of(name), "%", True, 100.0)


def error_charts(run, sections):
    rows = error_rows(run, sections)
    if not rows:
        return []
    shown = [Axis(name, words_of(name), "%", False, 100.0) for name, _, _ in ERRORS if any(row.get(name) is not None for row in rows)]
    own = Axis(own_key("displacement_deformation"), "the reference's own error of it", "%", False, 100.0)
    name = "displacement_deformation" if any(row.get("displacement_deformation") for row in rows) else MAIN
    charts = [Chart("Error of each model", "ranges", error_axis(name), Axis("label", "model"), rows, series="label", facet="problem", shown=[*shown, own],
                    note=f"{TITLES[name]}, a panel a problem. Hollow: the reference is not {MARGIN:g} times better, so it decides nothing.")]
    if any(row["time"] for row in rows):
        charts.append(Chart("Error against time", "points", Axis("time", "time of the method", "ms", True, 1000.0), error_axis(name), rows, series="label", facet="problem",
                            shown=shown, note="Whiskers: the interval of the median time."))
    return charts


def frontier_charts(points):
    """Error against each kind of work, a panel a scene; points beaten for certain are hollow."""
    charts = []
    for work, title in frontier.WORKS:
        rows = [frontier_row(key, point, work) for key, own in points.items() for point in own if point.has(work, frontier.MEASURE)]
        if rows:
            charts.append(Chart(f"What accuracy costs: {title}", "points", Axis("time", f"time of a {title}", "ms", True, 1000.0), error_axis(frontier.MEASURE), rows,
                                series="family", facet="scene", shown=[Axis("model", "model"), Axis("mesh", "mesh"), Axis("tets", "tetrahedra"),
                                                                       Axis("own", "the reference's own error", "%", False, 100.0)],
                                note="Filled: on the frontier, nothing is surely faster and as good. A point opens its model and the command that repeats it."))
    return charts


def frontier_row(key, point, work):
    own = point.works[work]
    return {"scene": frontier.scene_text(key), "family": point.family, "model": point.label, "mesh": point.mesh, "tets": point.tets, "time": own.median,
            "time_low": frontier.finite(own.low), "time_high": frontier.finite(own.high), frontier.MEASURE: point.errors[frontier.MEASURE],
            "own": point.own_errors.get(frontier.MEASURE), "hollow": (work, frontier.MEASURE) not in point.on, "case": point.case, "note": point.note}


def convergence_chart(series):
    rows = [{"label": one.label, "scene": frontier.scene_text((one.scene, one.poisson_ratio)), "vertices": row.vertices, "error": row.values[MAIN],
             "own": row.own_errors.get(MAIN)} for one in series for row in one.rows]
    return Chart("Error against refinement", "lines", Axis("vertices", "vertices", "", True), Axis("error", "relative L2 error", "%", True, 100.0), rows, series="label",
                 facet="scene", shown=[Axis("own", "the reference's own error", "%", False, 100.0)])


def count_charts(curves):
    """Error against tetrahedra, a chart a label; a panel a scene and family of simplifiers, a curve each of its sizes."""
    charts, name, several = [], counts.measure_of(curves), counts.families_of_several(curves)
    for label in dict.fromkeys(curve.label for curve in curves):
        rows = []
        for curve in curves:
            if curve.label != label:
                continue
            has_sizes = curve.simplifier.family in several
            place = ", ".join([curve.problem.name, *([curve.simplifier.family] if has_sizes else [])])
            for row in curve.rows:
                if row.values[name] is not None:
                    rows.append({"place": place, "sizes": curve.simplifier.sizes if has_sizes else curve.simplifier.label, "simplify": curve.simplifier.label,
                                 "tets": row.tets, name: row.values[name], "own": row.own_errors.get(name), "hollow": row.is_coarse(name)})
        charts.append(Chart(f"Error against tetrahedra: {label}", "lines", Axis("tets", "tetrahedra", "", True), error_axis(name), rows, series="sizes", facet="place",
                            shown=[Axis("simplify", "simplifier"), Axis("own", "the reference's own error", "%", False, 100.0)]))
    return charts


# --- Tables -------------------------------------------------------------------------------------------------------------


def error_table(sections):
    columns = [Column("problem"), Column("model"), *(Column(title, "%", 3) for _, title, _ in ERRORS), Column("reference's own L2", "%", 3), Column("marked"),
               *(Column(title, "ms") for _, title in TIMES), Column("note")]
    rows = []
    for section in sections:
        for row in section.rows:
            marked = ", ".join(title for name, title, _ in ERRORS if row.is_judged and row.is_coarse(name)) if row.is_judged else ""
            rows.append([section.title, row.label, *(percent(row.values[name]) for name, _, _ in ERRORS), percent(row.own_errors.get(MAIN)), marked,
                         *(milliseconds(row.values[name]) for name, _ in TIMES), row.note])
    return Table("Errors of every answer", columns, rows, file="tables/displacement.csv",
                 note=f"deform: after the best rigid motion is taken off. marked ({COARSE}): figures that the reference cannot tell.")


def set_table(run, sections):
    columns = [Column("scenes"), Column("problem"), Column("model"), Column("solved"), Column("of"), Column("L2, rms", "%", 3), Column("L2, worst", "%", 3), Column("worst on")]
    rows = [[entry["set"], setting_text(entry["setting"]), entry["label"], entry["solved"], entry["scenes"], percent(entry["rms"]), percent(entry["worst"]), entry["worst_scene"]]
            for entry in set_rows(run, sections)]
    return Table("Errors over sets of scenes", columns, rows, file="tables/displacement_sets.csv")


def target_table(outcomes):
    columns = [Column("target"), Column("what"), Column("error"), Column("best label"), Column("at most", "%"), Column("worst", "%", 3), Column("worst on"), Column("by"), Column("note")]
    rows = [[outcome.state, str(outcome.target.get("text", "")), targets.TITLES.get(outcome.measure, outcome.measure), outcome.label, percent(outcome.target["at_most"]),
             percent(outcome.worst), outcome.worst_row.problem.name if outcome.worst_row else "", targets.gap_text(outcome), outcome.note] for outcome in outcomes]
    return Table("Targets", columns, rows, file="tables/targets.csv")


def frontier_table(points):
    columns = [Column("scene"), Column("family"), Column("model"), Column("mesh"), Column("tetrahedra"), Column("deform", "%", 3),
               *(Column(title, "ms") for _, title in frontier.WORKS), Column("on the frontier of"), Column("note")]
    rows = []
    for key, own in points.items():
        for point in own:
            on = ", ".join(title for work, title in frontier.WORKS if (work, frontier.MEASURE) in point.on)
            rows.append([frontier.scene_text(key), point.family, point.label, point.mesh, point.tets, percent(point.errors[frontier.MEASURE]),
                         *(milliseconds(point.works[work].median) if point.works[work] else None for work, _ in frontier.WORKS), on, point.note])
    rows.sort(key=lambda row: (row[0], row[-2] == ""))
    return Table("Points of error and work; those on a frontier first", columns, rows, file="tables/frontier.csv")


def equal_table(run, points):
    against = [str(name) for name in frontier.asked(run).get("against", [])]
    columns = [Column("work"), Column("family"), Column("error at most", "%"), Column("time over the scenes"), *(Column(f"times as fast as {name}") for name in against)]
    rows = [[dict(frontier.WORKS)[row["work"]], row["family"], percent(row["error"]), frontier.family_cell(row), *(frontier.ratio_cell(row, name) for name in against)]
            for row in frontier.equal_error_rows(run, points) if row["times"]]
    return Table("The fastest of each family at equal error", columns, rows, file="tables/equal_error.csv", note="Median over the scenes (least to most).")


def element_step_tables(run, points):
    """What a mesh costs whatever the machine is; none where families are models."""
    rows = element_steps.read_rows(run, points)
    if not rows:
        return []
    against = [str(name) for name in frontier.asked(run).get("against", [])]
    columns = [Column("family"), Column("error at most", "%"), Column("millions of them"), *(Column(f"times as few as {name}") for name in against)]
    shown = [[row["family"], percent(row["error"]), *element_steps.cells(row, against)[2:]] for row in rows]
    return [Table("Tetrahedra times steps at equal error", columns, shown, file="tables/element_steps.csv", note="Median over the scenes (least to most); no time is in it.")]


def reference_table(sections):
    rows = [[section.title, reference_text(section)] for section in sections]
    return Table("What it is judged by", [Column("problem"), Column("reference")], list(map(list, dict.fromkeys(map(tuple, rows)))), file="tables/references.csv")


# --- Meshes -------------------------------------------------------------------------------------------------------------


OF_ANSWERS = ("simplify=", "tets_removed_ratio=", "option.")  # what a sweep has besides the problem


def case_of(group):
    """The case that stands for a group, in charts and in 3D alike."""
    return str(group.records[0].get("case", ""))


def problem_folder(case, label):
    """Where the mesh of a case's problem is: the case SCENE/LABEL/SWEEP solves problems/SCENE/SWEEP."""
    scene, *rest = str(case).split("/")
    kept = [part for part in rest if part != label and not part.startswith(OF_ANSWERS)]
    return "/".join(["problems", scene, *kept])


def bodies_of(run, first=frozenset()):
    """
    Of each problem the reference's shape and that of each answer, coloured by their displacement and by how far they are from it; then the
    answers on each simplified mesh, which share no vertices with the reference. The cases `first` come before the others.
    """
    import numpy as np
    references, count = {}, 0
    for group in sorted(run.groups, key=lambda each: (case_of(each) not in first, bool(each.records[0].get("solved_on")))):
        if count >= MOST_BODIES or not group.cases():
            continue
        case = case_of(group)
        record = group.cases()[0]
        solved_on = record.get("solved_on")
        is_simplified = isinstance(solved_on, dict)
        folder = f"problems/{solved_on.get('name')}" if is_simplified else problem_folder(record.get("case"), group.label)
        mesh = mesh_beside(run, f"{folder}/in.mesh")
        field = None if mesh is None else displacement_beside(run, record.get("mesh_file"), len(mesh.points))
        if field is None:
            continue
        title = folder.removeprefix("problems/").replace("/", ", ")
        if folder not in references:
            references[folder] = None if is_simplified else displacement_beside(run, f"{folder.replace('problems', 'references', 1)}.csv", len(mesh.points))
            if references[folder] is not None:
                yield Body("reference", title, mesh, [quality_field(mesh)], displacement=references[folder], unit="m")
        fields = [quality_field(mesh)]
        if references[folder] is not None:
            fields.insert(0, Field("error against the reference", "mm", "vertex", 1000 * np.linalg.norm(field - references[folder], axis=1), scale="cividis"))
        count += 1
        yield Body(group.label, title, mesh, fields, displacement=field, unit="m", case=case)


def page_parts(run, found):
    """All of it; `found` is what the tables were made from."""
    sections, series, points = found
    outcomes = targets.judge_targets(run, sections)
    sentence, state = verdict_of(run, sections, points, outcomes)
    on_frontier = {point.case for own in points.values() for point in own if point.on}
    charts = frontier_charts(points) if points else error_charts(run, sections)
    charts += count_charts(counts.shown_curves(counts.read_curves(run, sections), run.plan_data))
    chart = convergence_chart(series) if series else None
    tables = [target_table(outcomes)] if outcomes else []
    tables += [frontier_table(points), equal_table(run, points), *element_step_tables(run, points)] if points else []
    tables += [error_table(sections), set_table(run, sections), reference_table(sections)]
    return PageParts(sentence, state, [Section("", [*charts, *([chart] if chart else [])]), Section("", tables)], lambda: bodies_of(run, on_frontier))
