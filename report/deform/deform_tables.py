"""Tables of a contest of displacements: problem by problem, scene by scene, over sets of scenes, and of the references."""

from deform.deform import (BEST, BEST_OTHER, COARSE, ERRORS, MAIN, MARGIN, SHARE, TIMES, labels_of, root_mean_square, scene_sets,
                           setting_of, setting_text, settings_of, shown_errors)
from shared.records import figure
from shared.tables import align, pad_columns, percent_text, seconds_text, write_atomically, write_csv


def reference_text(section):
    """What the section is judged by, in a line."""
    record = section.reference
    if record is None:
        return "no record of the reference"
    judge = record.get("judge") if isinstance(record.get("judge"), dict) else {}
    if not judge.get("valid"):
        return f"no reference: {record.get('message') or 'it is not valid'}"
    errors = ", ".join(f"{title} {percent_text(figure(record, 'judge', own))}" for _, title, own in ERRORS
                       if figure(record, "judge", own) is not None)
    order = figure(record, "judge", "order")
    shown = "" if order is None else f", order {order:.2f}"
    return (f"reference: {judge.get('kind')}, {figure(record, 'judge', 'levels'):.0f} levels{shown}; "
            f"its own error in %: {errors or 'not known'}")


def factor_of(row, section):
    """The row's L2 error over that of the plan's `beside` on the same mesh."""
    other = section.peer
    if other is None or not row.is_judged or not other.values[MAIN]:
        return None
    return row.values[MAIN] / other.values[MAIN]


def row_cells(row, section, errors):
    cells = [row.label]
    for name, _, _ in errors:
        cells.append(percent_text(row.values[name]) + row.marks.get(name, "").ljust(2))
    factor = factor_of(row, section)
    cells.append("" if factor is None else f"{factor:.2f}")
    share = row.values[SHARE]
    cells.append("" if share is None else f"{100 * share:.0f}")
    for name, _ in TIMES:
        cells.append(seconds_text(row.values[name]) + (row.marks.get(name, "").ljust(1) if name == "kernel_s" else ""))
    return [*cells, row.note]


def sections_text(sections):
    """The whole table, problem by problem."""
    errors = shown_errors(sections)
    beside = sections[0].beside if sections else None
    titles = [f"{title} %  " for _, title, _ in errors]
    lines = [["label", *titles, f"x {beside}" if beside else "", "springs %", *(title + (" " if name == "kernel_s" else "") for name, title in TIMES), "note"]]
    for section in sections:
        lines += ["", section.title, f"  {reference_text(section)}"]
        # Without a reference no row has a figure; the line above says why.
        lines += [row_cells(row, section, errors) for row in section.rows] if section.has_reference else []
    return pad_columns(lines) + "\n\n" + legend_text(sections)


def legend_text(sections):
    marks = "".join(mark for section in sections for row in section.rows for mark in row.marks.values())
    lines = ["Errors in % of the reference, at the vertices of the scene's own mesh. deform: L2 after the best rigid motion is taken off error and",
             "reference. energy: in the norm of the strains, of the vertices alone; whole: with what happens between them. pad: force of the pads that",
             "move. springs: share of the elastic energy that springs hold. Times: median over repeats; kernel holds identify, assembly and solve."]
    if sections and sections[0].beside:
        lines.append(f"x {sections[0].beside}: the L2 error over that of {sections[0].beside} on the same mesh.")
    if BEST in marks:
        lines.append(f"{BEST} least of the column" + (f"; {BEST_OTHER} least without methods of the reference's kind." if BEST_OTHER in marks else "."))
    if COARSE in marks:
        lines.append(f"{COARSE} the reference is not {MARGIN:g} times better than this figure, or its error is not known: it decides nothing.")
    return "\n".join(lines)


def matrix_cell(section, row, name):
    if row is None:
        return ""
    if row.is_judged:
        return percent_text(row.values[name]) + row.marks.get(name, "").ljust(2)
    return "failed  " if section.has_reference else "no ref.  "


def matrix_text(sections):
    """Each error, label by scene: one table for each error, Poisson ratio, number of vertices and mesh."""
    out = []
    for setting in settings_of(sections):
        own = [section for section in sections if setting_of(section) == setting]
        for name, title, _ in shown_errors(own):
            rows = [[label, *(matrix_cell(section, section.find(label), name) for section in own), ""] for label in labels_of(own)]
            header = ["label", *(section.problem.scene + "  " for section in own), ""]
            heading = setting_text(setting)
            out.append(f"{TITLES[name]} in %{f', {heading}' if heading else ''}\n\n" + pad_columns([header, *rows]))
    return "\n\n".join(out)


TITLES = {"displacement_l2": "Relative L2 error", "displacement_deformation": "Error of the deformation", "displacement_energy": "Energy error",
          "displacement_energy_whole": "Energy error with midpoints", "displacement_max": "Greatest error over greatest displacement",
          "pad_force": "Error of the pads' force"}


def set_rows(run, sections):
    """One entry a set, setting and label: how many scenes, how many it solved, rms and worst L2 error, marks, P1's own."""
    found = []
    for name, scenes in scene_sets(run, sections).items():
        for setting in settings_of(sections):
            every = [section for section in sections if setting_of(section) == setting and section.problem.scene in scenes]
            own = [section for section in every if section.has_reference]
            for label in labels_of(own):
                rows = [row for row in (section.find(label) for section in own) if row is not None]
                if not rows:
                    continue
                judged = [row for row in rows if row.is_judged]
                values = [row.values[MAIN] for row in judged]
                worst = max(judged, key=lambda row: row.values[MAIN], default=None)
                peers = [section.peer for section in own if section.find(label) and section.find(label).is_judged]
                peer_values = [peer.values[MAIN] for peer in peers if peer]
                found.append({"set": name, "setting": setting, "label": label, "scenes": len(rows), "solved": len(judged),
                              "without_reference": len(every) - len(own),
                              "coarse": sum(row.is_coarse(MAIN) for row in judged), "rms": root_mean_square(values),
                              "worst": max(values, default=None), "worst_scene": worst.problem.scene if worst else "",
                              "p1_rms": root_mean_square(peer_values), "p1_worst": max(peer_values, default=None),
                              "errors": {name: spread_of(judged, name) for name, _, _ in ERRORS}})
    return found


def spread_of(rows, name):
    """(rms, worst, how many figures the reference cannot tell) of an error; pads are not in every scene."""
    values = [row.values[name] for row in rows if row.values[name] is not None]
    return root_mean_square(values), max(values, default=None), sum(row.is_coarse(name) for row in rows)


def spread_text(spread):
    rms, worst, coarse = spread
    return "" if rms is None else f"{percent_text(rms)} / {percent_text(worst)}{COARSE if coarse else ''}"


def sets_text(run, sections):
    """rms and worst over each set of scenes, of all errors side by side."""
    rows = []
    errors = shown_errors(sections)
    for entry in set_rows(run, sections):
        note = [] if entry["solved"] == entry["scenes"] else [f"solved {entry['solved']} of {entry['scenes']}"]
        note += [f"no reference on {entry['without_reference']}"] if entry["without_reference"] else []
        note += [f"{entry['coarse']} marked {COARSE}"] if entry["coarse"] else []
        rows.append([entry["set"], setting_text(entry["setting"]), entry["label"],
                     *(spread_text(entry["errors"][name]) for name, _, _ in errors), entry["worst_scene"], "; ".join(note)])
    header = ["scenes", "problem", "label", *(f"{title} %" for _, title, _ in errors), "worst on", "note"]
    return ("Errors over sets of scenes: root mean square / worst. worst on, note: of the L2 error\n\n"
            + align(header, without_repeated_names(rows)))


def without_repeated_names(rows):
    shown = []
    for i, row in enumerate(rows):
        same_set = i > 0 and rows[i - 1][0] == row[0]
        same_setting = same_set and rows[i - 1][1] == row[1]
        shown.append(["" if same_set else row[0], "" if same_setting else row[1], *row[2:]])
    return shown


ROW_HEADER = ["scene", "poisson_ratio", "vertices_wanted", "vertices", "simplify", "tets_removed_ratio", "label", "method",
              *(name for name, _, _ in ERRORS), *(own for _, _, own in ERRORS), "marked", "best_in",
              "best_without_finite_elements_in", "times_p1", SHARE,
              *(name for name, _ in TIMES), "iterations", "note"]


def write_rows(sections, folder):
    rows = []
    for section in sections:
        for row in section.rows:
            marked = " ".join(name for name, _, _ in ERRORS if row.is_coarse(name))
            best, other = (" ".join(name for name, marks in row.marks.items() if mark in marks) for mark in (BEST, BEST_OTHER))
            rows.append([row.problem.scene, row.problem.poisson_ratio, row.problem.wanted_vertices, row.vertices, row.simplify,
                         row.ratio, row.label, row.method, *(row.values[name] for name, _, _ in ERRORS),
                         *(row.own_errors[name] for name, _, _ in ERRORS), marked, best, other, factor_of(row, section),
                         row.values[SHARE],
                         *(row.values[name] for name, _ in TIMES), row.values["iterations"], row.note])
    write_csv(folder / "displacement.csv", ROW_HEADER, rows)


def write_references(run, folder):
    header = ["scene", "poisson_ratio", "vertices", "kind", "levels", "order", "alignment", "differences",
              *(own for _, _, own in ERRORS), "rule", "message"]
    rows = []
    for record in run.references:
        judge = record.get("judge") if isinstance(record.get("judge"), dict) else {}
        scene = record.get("scene") if isinstance(record.get("scene"), dict) else {}
        differences = judge.get("differences") if isinstance(judge.get("differences"), list) else []
        rows.append([scene.get("name"), scene.get("poisson_ratio"), figure(record, "mesh", "vertices"), judge.get("kind"),
                     judge.get("levels"), judge.get("order"), judge.get("alignment"), " ".join(map(str, differences)),
                     *(judge.get(own) for _, _, own in ERRORS), judge.get("rule"), record.get("message")])
    write_csv(folder / "references.csv", header, rows)


def write_sets(run, sections, folder):
    header = ["set", "poisson_ratio", "vertices", "simplify", "tets_removed_ratio", "label", "scenes", "solved",
              "without_reference", "coarse", "rms", "worst", "worst_scene", "p1_rms", "p1_worst"]
    spreads = [f"{name}_{kind}" for name, _, _ in ERRORS for kind in ("rms", "worst", "coarse")]
    rows = [[entry["set"], *entry["setting"], *(entry[name] for name in header[5:]),
             *(value for name, _, _ in ERRORS for value in entry["errors"][name])] for entry in set_rows(run, sections)]
    write_csv(folder / "displacement_sets.csv", [*header, *spreads], rows)


def write_tables(run, sections, folder):
    """Writes them all; returns their names."""
    folder.mkdir(parents=True, exist_ok=True)
    write_rows(sections, folder)
    write_references(run, folder)
    write_sets(run, sections, folder)
    write_atomically(folder / "displacement.txt", summary_text(run, sections) + "\n")
    return {"displacement.csv", "references.csv", "displacement_sets.csv", "displacement.txt"}


def summary_text(run, sections):
    if not sections:
        return "no records"
    return "\n\n".join([sections_text(sections), matrix_text(sections), sets_text(run, sections)])
