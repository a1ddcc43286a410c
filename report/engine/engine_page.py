"""What a contest of the engine has for the page of its run."""

from engine.engine import HOLDS, largest_meshes, returns_of
from engine.motion_file import read_motion
from shared.page_parts import BAD, OPEN, PLAIN, Axis, Body, Chart, Column, PageParts, Section, Table
from shared.records import figure
from shared.run_meshes import mesh_beside, quality_field

MOST_POINTS = 400  # of one history
MILLI = 1000.0


def scaled(value, factor):
    return None if value is None else factor * value


def name_of(case):
    """Scene, label, and the options that tell cases of a label apart."""
    threads = case.threads
    more = [f"{case.vertices:,.0f} vertices" if case.vertices else "", str(case.chosen("precision") or ""), f"{threads} thread{'s' if threads != 1 else ''}" if threads else ""]
    return ", ".join([case.scene, case.label, *(text for text in more if text)])


# --- The verdict --------------------------------------------------------------------------------------------------------


def ticks_sentence(found):
    best = {}
    for (scene, label, precision, threads), row in largest_meshes(found.ticks).items():
        for how, _ in HOLDS:
            if row[how] and row[how] > best.get(how, (0, ""))[0]:
                best[how] = (row[how], f"{label}, {threads} thread{'s' if threads != 1 else ''} on {scene}")
    deadline = next((value for case in found.ticks if (value := figure(case.record, "report", "tick_s")) is not None), None)
    ticks = "a tick" if deadline is None else f"ticks of {MILLI * deadline:g} ms"
    how = HOLDS[2][0]
    if how not in best:
        return f"No mesh holds {ticks} in 99.9% of them."
    return f"The largest mesh that holds {ticks} in {how} of them has {best[how][0]:,.0f} vertices ({best[how][1]})."


def replay_sentence(found):
    accepted = [case for case in found.replays if case.is_accepted]
    returned = [(case, each) for case in accepted for each in returns_of(case) if figure(each, "error") is not None]
    if not returned:
        return f"{len(accepted)} of {len(found.replays)} replayed motions were accepted; none of them came to a return."
    case, worst = max(returned, key=lambda pair: figure(pair[1], "error"))
    margins = [case.number("stability_margin") for case in accepted if case.number("stability_margin") is not None]
    text = f"Of {len(returned)} returns to rest the worst keeps {100 * figure(worst, 'error'):.3g}% of where it was let go ({case.scene}, {case.label})"
    return text + (f"; the stable step of the replays is at least {min(margins):.3g} times their step." if margins else ".")


def rest_sentence(found):
    margins = [(case.number("stability_margin"), case) for case in found.rests if case.is_accepted and case.number("stability_margin") is not None]
    if not margins:
        return f"{len(found.rests)} bodies at rest, none of them with a stable step."
    least, case = min(margins, key=lambda pair: pair[0])
    return f"The stable step of bodies at rest is at least {least:.3g} times the step ({case.scene}, {case.label})."


def verdict_of(found):
    parts = [sentence(found) for kind, sentence in ((found.ticks, ticks_sentence), (found.replays, replay_sentence), (found.rests, rest_sentence)) if kind]
    if not parts:
        return "No case answered.", BAD
    return " ".join(parts[:2]), OPEN if found.silent else PLAIN


# --- Charts -------------------------------------------------------------------------------------------------------------


def history_chart(run, found):
    rows = []
    for case in found.replays:
        motion = read_motion(run, case)
        columns = motion["columns"] if motion else []
        if not {"largest_displacement_m", "total_j"} <= set(columns):
            continue
        time, size, energy = (columns.index(name) for name in ("time_s", "largest_displacement_m", "total_j"))
        every = -(-len(motion["rows"]) // MOST_POINTS)
        rows += [{"name": name_of(case), "time": line[time], "size": line[size], "energy": line[energy], "case": case.record.get("case")} for line in motion["rows"][::every]]
    if not rows:
        return None
    return Chart("How far each body is from rest", "lines", Axis("time", "simulated time", "s"), Axis("size", "largest displacement", "mm", False, MILLI), rows,
                 series="name", shown=[Axis("energy", "energy", "J")], note="The largest displacement of any vertex.", drawn="returns")


def tick_chart(found):
    rows = [{"name": f"{case.label}, {case.chosen('precision')}, {case.threads} thread{'s' if case.threads != 1 else ''}", "scene": case.scene,
             "vertices": case.vertices, "how": how, "time": case.number(key), "missed": case.number("ticks_missed"), "ticks": case.number("ticks"),
             "case": case.record.get("case"), "note": case.note} for case in found.ticks for how, key in HOLDS if case.number(key) and case.vertices]
    deadline = next((value for case in found.ticks if (value := figure(case.record, "report", "tick_s")) is not None), None)
    if not rows:
        return None
    scenes = {name: {row["scene"] for row in rows if row["name"] == name} for name in {row["name"] for row in rows}}
    for row in rows:
        row["name"] += f", {row['scene']}" if len(scenes[row["name"]]) > 1 else ""
        row["how"] = {"median": "median tick", "none missed": "worst tick"}.get(row["how"], f"{row['how']} of the ticks")
    note = "" if deadline is None else f"A tick is in time below {MILLI * deadline:g} ms."
    return Chart("Time of a tick", "lines", Axis("vertices", "vertices", "", True), Axis("time", "time of a tick", "ms", True, MILLI), rows, series="name", facet="how",
                 shown=[Axis("missed", "ticks missed"), Axis("ticks", "of"), Axis("scene", "scene")], note=note, drawn="budget")


def margin_chart(found):
    rows = [{"name": f"{case.scene}, {case.label}", "vertices": case.vertices, "margin": case.number("stability_margin"), "hollow": not case.is_accepted,
             "note": case.note, "case": case.record.get("case")}
            for case in [*found.rests, *found.replays] if case.vertices and case.number("stability_margin") is not None]
    if not rows:
        return None
    return Chart("Longest stable step over the step", "ranges", Axis("margin", "longest stable step over step"), Axis("name", "body"), rows, series="name",
                 shown=[Axis("vertices", "vertices")], marks=[{"value": 1.0, "title": "unstable to the left"}], note="Hollow: rejected.")


# --- Tables -------------------------------------------------------------------------------------------------------------


def replay_table(cases):
    columns = [Column("scene"), Column("label"), Column("vertices"), Column("engine"), Column("integrator"), Column("step", "ms"), Column("margin", digits=3), Column("peak speed", "m/s", 3),
               Column("speeds cut"), Column("inverted at most"), Column("left over", digits=2), Column("simulated over wall", digits=3), Column("one step a 5 ms tick", digits=3),
               Column("set-up", "s", 3), Column("memory", "MB", 3), Column("note")]
    rows = [[case.scene, case.label, case.vertices, str(case.told("engine") or ""), str(case.told("integrator") or ""), scaled(figure(case.record, "report", "time_step_s"), MILLI), case.number("stability_margin"),
             case.number("peak_speed_m_s"), case.number("speeds_cut"), case.number("inverted_tets_most"), case.number("residual_worst"), case.number("real_time_factor"),
             case.number("tick_real_time_factor"), case.number("setup_s"), scaled(figure(case.record, "peak_rss_bytes"), 1e-6), case.note] for case in cases]
    return Table("Replayed", columns, rows, file="tables/replays.csv",
                 note="speeds cut: vertices times steps whose speed was cut to the limit; left over: the largest share of the forces out of balance in a step, where measured.")


def return_table(cases):
    columns = [Column("scene"), Column("label"), Column("vertices"), Column("return"), Column("let go at", "s"), Column("until", "s"), Column("then", "mm"), Column("left", "mm"), Column("left of it", "%", 3),
               Column("half after", "s", 3), Column("a twentieth after", "s", 3)]
    rows = [[case.scene, case.label, case.vertices, number, figure(each, "released_s"), figure(each, "end_s"), scaled(figure(each, "released_m"), MILLI), scaled(figure(each, "left_m"), MILLI),
             scaled(figure(each, "error"), 100.0), figure(each, "half_s"), figure(each, "twentieth_s")] for case in cases for number, each in enumerate(returns_of(case), start=1)]
    return Table("Returns to rest, by the largest displacement of any vertex", columns, rows, file="tables/returns.csv", note="Empty: not yet.")


def rest_table(cases):
    columns = [Column("scene"), Column("label"), Column("vertices"), Column("stable step", "ms"), Column("step", "ms"), Column("margin", digits=3), Column("slowest decay", "s", 3), Column("note")]
    rows = [[case.scene, case.label, case.vertices, scaled(case.number("stable_step_s"), MILLI), scaled(figure(case.record, "report", "time_step_s"), MILLI),
             case.number("stability_margin"), case.number("slowest_decay_s"), case.note] for case in cases]
    return Table("At rest", columns, rows, file="tables/rest.csv", note="The slowest decay falls to 1/e.")


def tick_table(cases):
    columns = [Column("scene"), Column("label"), Column("precision"), Column("threads"), Column("vertices"), Column("steps a tick"), *(Column(how, "ms", 3) for how in ("p50", "p99", "p99.9", "worst")),
               Column("missed"), Column("of"), Column("left over", "", 2), Column("force", "N"), Column("reference", "N"), Column("its change", "%", 3), Column("off by", "%", 3),
               Column("set-up", "s", 3), Column("first tick", "ms", 3), Column("memory", "MB", 3), Column("note")]
    rows = [[case.scene, case.label, str(case.chosen("precision")), case.threads, case.vertices, case.number("steps_per_tick"),
             *(scaled(case.number(name), MILLI) for _, name in HOLDS), case.number("ticks_missed"), case.number("ticks"), case.number("residual_worst"), case.number("held_force_size_n"),
             case.number("reference_force_size_n"), scaled(case.number("reference_force_change"), 100.0), scaled(case.number("force_error"), 100.0), case.number("setup_s"),
             scaled(case.number("first_tick_s"), MILLI), scaled(figure(case.record, "peak_rss_bytes"), 1e-6), case.note] for case in cases]
    return Table("Ticks of a haptic loop", columns, rows, file="tables/ticks.csv", note="left over: the largest share of the forces out of balance in a step, where measured; reference: the pad's force by finite elements; its change: by their last refinement; set-up: to the first tick; memory: of the process.")


def largest_table(found):
    columns = [Column("scene"), Column("label"), Column("precision"), Column("threads"), *(Column(how) for how, _ in HOLDS)]
    rows = [[*key, *(row[how] for how, _ in HOLDS)] for key, row in largest_meshes(found.ticks).items()]
    return Table("Vertices of the largest mesh that holds the deadline", columns, rows, file="tables/largest.csv", note="Empty: none does.")


# --- Meshes -------------------------------------------------------------------------------------------------------------


def bodies_of(run, found):
    """Each replayed motion, to be played."""
    for case in found.replays:
        motion = read_motion(run, case)
        vertices = case.option("vertices")
        place = f"{case.scene}/vertices={vertices}" if vertices else case.scene
        mesh = mesh_beside(run, f"problems/{place}/in.mesh")
        if mesh is None or not motion:
            continue
        frames = [(each["time_s"], each["displacement_m"]) for each in motion["frames"] if len(each["displacement_m"]) == 3 * len(mesh.points)]
        yield Body(case.label, name_of(case), mesh, [quality_field(mesh)], moves=frames, unit="m", case=str(case.record.get("case", "")))
    seen = set()
    for case in [*found.rests, *found.ticks]:
        vertices = case.option("vertices")
        place = f"{case.scene}/vertices={vertices}" if vertices else case.scene
        mesh = None if place in seen else mesh_beside(run, f"problems/{place}/in.mesh")
        seen.add(place)
        if mesh is not None:
            yield Body(place.replace("/", ", "), "Bodies at rest", mesh, [quality_field(mesh)], unit="m")


def page_parts(run, found):
    sentence, state = verdict_of(found)
    charts = [chart for chart in (history_chart(run, found), tick_chart(found), margin_chart(found)) if chart]
    tables = [replay_table(found.replays)] if found.replays else []
    tables += [return_table(found.replays)] if any(returns_of(case) for case in found.replays) else []
    tables += [rest_table(found.rests)] if found.rests else []
    tables += [tick_table(found.ticks), largest_table(found)] if found.ticks else []
    tables += [Table("Methods that never answered", [Column("scene"), Column("label"), Column("note")], [[case.scene, case.label, case.note] for case in found.silent])] if found.silent else []
    return PageParts(sentence, state, [Section("", charts), Section("", tables)], lambda: bodies_of(run, found))
