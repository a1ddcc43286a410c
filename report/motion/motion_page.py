"""What a contest of motions has for the page of its run."""

from motion import stages
from motion.motion import COARSE, MARGIN, MEASURES, UNMARKED, history_of, history_beside, label_of, own_text
from shared.page_parts import BAD, OPEN, PLAIN, Axis, Body, Chart, Column, PageParts, Section, Table
from shared.records import BadRun, median
from shared.run_file import are_numbers, is_number, read_object
from shared.run_meshes import mesh_beside, quality_field
from shared.tables import joined

MOST_POINTS = 160  # of one history
SIGNALS = [("probe_1_", "_m", 1e3, "displacement of the probe", "mm"), ("tool_", "_n", 1.0, "force of the tool", "N")]
MAIN = "probe_l2"
MOST_NEAR = 4  # labels that a verdict names


def percent(measure, value):
    return None if value is None else measure.scale * value


def nearest_text(errors, untold, over):
    """Who is nearest, and whether the reference can tell: not if it is within its own error on a problem. `untold` are the labels that are so."""
    text_of = lambda label: f"{100 * median(errors[label]):.3g}%"
    told = {label: text_of(label) for label in errors if label not in untold}
    best, worst = (choose(errors, key=lambda label: median(errors[label])) for choose in (min, max))
    off = lambda labels: f"{joined(labels)}{' alike' if len(labels) > 1 else ''}: {'their' if len(labels) > 1 else 'its'} probe is off by {text_of(labels[0])} (median)"
    if best not in untold:
        text = f"Nearest to elastodynamics over {over} is {off([label for label, said in told.items() if said == told[best]])}"
        return text + (f", where {worst} is off by {text_of(worst)}" if text_of(worst) != text_of(best) else ""), True
    near = sorted(untold, key=lambda label: median(errors[label]))
    shown = joined([*(f"{label} ({text_of(label)})" for label in near[:MOST_NEAR]), *([f"{len(near) - MOST_NEAR} more"] if len(near) > MOST_NEAR else [])])
    text = f"The reference cannot tell who is nearest to elastodynamics over {over}: {shown} {'are' if len(near) > 1 else 'is'} within {MARGIN:g} times its own error"
    if not told:
        return text, False
    first = min(told, key=lambda label: median(errors[label]))
    return f"{text}; of what it tells apart the nearest is {off([label for label, said in told.items() if said == told[first]])}", False


def verdict_of(sections):
    """Whose probe is nearest to the reference's, of the labels that finished most problems; or that the reference cannot tell."""
    errors, silent, untold = {}, 0, set()
    for section in sections:
        for row in section.rows:
            if row.values[MAIN] is None:
                silent += 1
            else:
                errors.setdefault(row.label, []).append(row.values[MAIN])
                untold |= {row.label} if COARSE in row.marks.get(MAIN, "") else set()
    if not errors:
        return "No motion could be held against the reference.", BAD
    most = max(map(len, errors.values()))
    full = {label: values for label, values in errors.items() if len(values) == most}
    text, is_told = nearest_text(full, untold & set(full), f"{most} problem{'s' if most > 1 else ''}")
    return text + (f"; {silent} answer{'s' if silent > 1 else ''} could not be judged." if silent else "."), PLAIN if is_told and not silent else OPEN


def cases_of(run):
    """{(mesh, label with its options): the case's ID}."""
    return {(group.mesh, label_of(group.records[0])): group.records[0].get("case") for group in run.groups}


def error_chart(run, sections):
    cases = cases_of(run)
    rows = []
    for section in sections:
        for row in section.rows:
            if row.values[MAIN] is None:
                continue
            found = {"problem": section.title, "label": row.label, "solve": row.solve_s, "step": row.step_s, "steps": row.steps, "integrator": row.integrator,
                     "hollow": COARSE in row.marks.get(MAIN, ""), "note": row.note, "case": cases.get((section.scene, row.label))}
            rows.append(found | {measure.name: row.values[measure.name] for measure in MEASURES})
    if not rows:
        return []
    shown = [Axis(m.name, m.title.removesuffix(" %").removesuffix(" deg"), "%" if m.scale == 100 else "deg", False, m.scale) for m in MEASURES]
    shown += [Axis("integrator", "integrator"), Axis("step", "step", "ms", False, 1000.0), Axis("steps", "steps")]
    probe = Axis(MAIN, "error of the probe's history, L2", "%", True, 100.0)
    charts = [Chart("Error of each motion", "ranges", probe, Axis("label", "model"), rows, series="label", facet="problem", shown=shown,
                    note=f"Against elastodynamics, a panel a problem. Hollow: the reference is not {MARGIN:g} times better.")]
    if any(row["solve"] for row in rows):
        charts.append(Chart("Error against the time of the steps", "points", Axis("solve", "time of the steps", "ms", True, 1000.0), probe, rows, series="label",
                            facet="problem", shown=shown))
    return charts


def widest(history, prefix, suffix):
    columns = [name for name in history if name.startswith(prefix) and name.endswith(suffix)]
    ranges = {name: max(history[name]) - min(history[name]) for name in columns}
    return max(ranges, key=ranges.get) if any(ranges.values()) else None


def thin(history, column):
    """Some of a history's points: every n-th one."""
    every = -(-len(history["time_s"]) // MOST_POINTS)
    return list(zip(history["time_s"], history[column]))[::every]


def history_charts(run, section):
    """Each answer's probe and force over time, the reference's beside it."""
    path = history_of(run, section.reference)
    truth = history_beside(run, path) if path else None
    charts = []
    for prefix, suffix, factor, title, unit in SIGNALS:
        column = widest(truth, prefix, suffix) if truth else None
        if column is None:
            continue
        rows = []
        for row in section.rows:
            answer = history_beside(run, row.history) if row.history else {}
            if column in answer:
                for who, history in (("reference", truth), ("answer", answer)):
                    rows += [{"label": row.label, "who": who, "time": time, "value": value} for time, value in thin(history, column)]
        if rows:
            charts.append(Chart(f"{title[0].upper()}{title[1:]}: {section.title}", "lines", Axis("time", "time", "s"), Axis("value", title, unit, False, factor), rows,
                                series="who", facet="label", note="A panel a model; every n-th point of the history."))
    return charts


def error_table(sections):
    columns = [Column("problem"), Column("model"), *(Column(m.title.removesuffix(" %").removesuffix(" deg"), "%" if m.scale == 100 else "deg", 3) for m in MEASURES),
               Column("left", digits=2), Column("steps"), Column("step", "ms"), Column("steps took", "ms"), Column("all took", "ms"), Column("cannot be told"), Column("note")]
    scaled = lambda value: None if value is None else 1000.0 * value
    rows = []
    for section in sections:
        own = section.own
        if section.reference:
            rows.append([section.title, "the reference's own error", *(percent(m, own[m.name]) for m in MEASURES), *[None] * 5, "", ""])
        for row in section.rows:
            coarse = ", ".join(m.title for m in MEASURES if m.name not in UNMARKED and COARSE in row.marks.get(m.name, ""))
            rows.append([section.title, row.label, *(percent(m, row.values[m.name]) for m in MEASURES), row.left, row.steps, scaled(row.step_s), scaled(row.solve_s),
                         scaled(row.kernel_s), coarse, row.note])
    return Table("Errors of every motion", columns, rows, file="tables/motion.csv",
                 note="Signs are kept: an amplitude of -10% is too small, a phase of -10 degrees too late. cannot be told: the reference is not five times better.")


def stage_table(found):
    columns = [Column("scene"), Column("mesh"), Column("tetrahedra"), Column("model"), *(Column(m.title.removesuffix(" %"), "%", 3) for m in stages.ERRORS),
               *(Column(f"added to {m.title.removesuffix(' %')}", "%", 3) for m in stages.ERRORS), *(Column(title, "ms") for _, title in stages.TIMES), Column("note")]
    scaled = lambda value, factor: None if value is None else factor * value
    rows = [[stage.scene, stage.mesh, stage.tets, stage.label, *(scaled(stage.errors[m.name], 100.0) for m in stages.ERRORS),
             *(scaled(stage.added(m.name), 100.0) for m in stages.ERRORS), *(scaled(stage.times[name], 1000.0) for name, _ in stages.TIMES), stage.note] for stage in found]
    return Table("From simplifier to motion: what each stage costs and adds", columns, rows, file="tables/stages.csv")


def states_beside(run, history):
    """(time, displacement of each vertex) of the states beside a history; none where there are none, or they cannot be read, which is noted."""
    path = history.with_suffix(".states.json") if history else None
    if path is None or not path.is_file():
        return []
    from shared.mesh_view import inside  # needs numpy
    try:
        states = read_object(inside(run.folder, str(path.relative_to(run.folder)))).get("states")
        if not isinstance(states, list) or not all(isinstance(each, dict) and is_number(each.get("time_s")) and are_numbers(each.get("displacement_m"))
                                                   for each in states):
            raise BadRun(f"{path}: expected states, a time and a displacement of finite numbers each")
        return [(float(each["time_s"]), each["displacement_m"]) for each in states]
    except BadRun as error:
        run.note(f"not played: {error}")
        return []


def bodies_of(run, sections):
    """
    Each motion whose states were kept and are of its mesh, to be played: first those on the scene's own mesh, or it at rest where there is
    none, then those on each simplified mesh.
    """
    cases = cases_of(run)
    for section in sections:
        place = "/".join(["problems", section.scene, *(f"{key}={value}" for key, value in section.sweep)])
        rows = {folder: [row for row in section.rows if row.problem == folder] for folder in dict.fromkeys(["", *(row.problem for row in section.rows)])}
        for folder, own in rows.items():
            mesh = mesh_beside(run, f"{folder or place}/in.mesh")
            if mesh is None:
                continue
            title = section.title + folder.removeprefix(place).replace("/", ", ")
            quality = quality_field(mesh)
            played = 0
            for row in own:
                states = states_beside(run, row.history)
                if len(states) > 1 and all(len(field) == 3 * len(mesh.points) for _, field in states):
                    played += 1
                    yield Body(row.label, title, mesh, [quality], moves=states, unit="m", case=str(cases.get((section.scene, row.label)) or ""))
            if not played and not folder:
                yield Body(title, "Bodies at rest", mesh, [quality], unit="m")


def page_parts(run, sections):
    sentence, state = verdict_of(sections)
    histories = [chart for section in sections for chart in history_charts(run, section)]
    tables = [error_table(sections), Table("What it is judged by", [Column("problem"), Column("reference")], [[section.title, own_text(section)] for section in sections])]
    staged = stages.read_stages(run)
    tables += [stage_table(staged)] if staged else []
    return PageParts(sentence, state, [Section("", error_chart(run, sections)), Section("Histories", histories[:8]), Section("", tables)],
                     lambda: bodies_of(run, sections))
