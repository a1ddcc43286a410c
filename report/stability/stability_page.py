"""What a contest of extremes has for the page of its run."""

from shared.page_parts import BAD, GOOD, OPEN, Axis, Chart, Column, PageParts, Section, Table
from shared.run_meshes import mesh_body
from stability.stability import (AGREEMENT, AGREEMENT_HEADER, CASE_FIGURES, GIVEN_UP, NO_ANSWER, RUN_FIGURES, SHORT, agreement_rows, endings_of, failure_rows, plain_label)


def verdict_of(cases):
    rows = agreement_rows(cases)
    compared, within = sum(row[2] for row in rows), sum(row[3] for row in rows)
    silent = sum(case.ending == NO_ANSWER for case in cases)
    given_up = sum(case.ending == GIVEN_UP for case in cases)
    named = len(cases) - silent - given_up
    rejected = sum(case.ending not in (NO_ANSWER, GIVEN_UP) and not case.is_accepted for case in cases)
    text = f"{within} of {compared} measured stable steps are within {100 * AGREEMENT:g}% of the predicted one"
    worst = max((row for row in rows if row[5] is not None), key=lambda row: abs(row[5] - 1), default=None)
    if worst:
        text += f" (worst: {worst[5]:.3f} times, {plain_label(worst[0])} on {worst[6]})"
    text += f", and {named} of {len(cases)} cases end in a way that has a name"
    text += f" ({rejected} of them rejected)" if rejected else ""
    text += f"; {given_up} {'was' if given_up == 1 else 'were'} given up before that was known" if given_up else ""
    text += f"; {silent} gave no answer" if silent else ""
    return f"{text}.", BAD if silent else GOOD if within == compared and not given_up else OPEN


def agreement_chart(cases):
    points = [{"label": plain_label(case.label), "ratio": case.number("measured_over_predicted"), "name": f"{case.extreme} {case.setting}".strip(), "mesh": case.mesh,
               "predicted": case.number("predicted_step_s"), "measured": case.number("measured_step_s"), "rows": case.number("row_sum_over_measured"),
               "note": case.note} for case in cases if case.is_accepted and case.measures and not case.is_large and case.number("measured_over_predicted")]
    if not points:
        return None
    return Chart("Measured stable step over the predicted one", "ranges", Axis("ratio", "measured over predicted"), Axis("label", "integrator"), points, series="mesh",
                 shown=[Axis("name", "extreme"), Axis("predicted", "predicted step", "s"), Axis("measured", "measured step", "s"), Axis("rows", "row sums over measured")],
                 marks=[{"value": 1.0, "title": "as predicted"}], note="A point a case of small motions.")


def step_chart(cases):
    points = [{"label": plain_label(case.label), "predicted": case.number("predicted_step_s"), "measured": case.number("measured_step_s"),
               "where": f"{case.mesh}, {case.extreme} {case.setting}".strip(), "note": case.note}
              for case in cases if case.is_accepted and case.measures and case.number("predicted_step_s") and case.number("measured_step_s")]
    if not points:
        return None
    return Chart("Longest stable step: predicted and measured", "points", Axis("predicted", "predicted step", "ms", True, 1000.0),
                 Axis("measured", "measured step", "ms", True, 1000.0), points, series="label", shown=[Axis("where", "case")])


def endings_chart(cases):
    counts = {}
    for case in cases:
        for ending in endings_of(case):
            key = (plain_label(case.label), SHORT.get(ending, str(ending)))
            counts[key] = counts.get(key, 0) + 1
    rows = [{"label": label, "ending": ending, "runs": count} for (label, ending), count in counts.items()]
    return Chart("How runs ended", "ranges", Axis("runs", "runs"), Axis("label", "integrator"), rows, series="ending", facet="ending",
                 note="Of accepted answers; of measurements: those at 1.02, 2 and 10 times the measured step.") if rows else None


def case_table(cases):
    columns = [Column("mesh"), Column("integrator"), Column("extreme"), Column("setting"), *(Column(name.replace("_", " ")) for name in CASE_FIGURES), Column("ending"),
               Column("outcome"), Column("note")]
    rows = [[case.mesh, plain_label(case.label), case.extreme, case.setting, *(case.block(name).get(name) for name in CASE_FIGURES), case.ending, case.outcome, case.note]
            for case in cases]
    return Table("Every case", columns, rows, file="tables/stability.csv")


def run_table(cases):
    columns = [Column("mesh"), Column("integrator"), Column("extreme"), Column("setting"), *(Column(name.replace("_", " ")) for name in RUN_FIGURES)]
    rows = [[case.mesh, plain_label(case.label), case.extreme, case.setting, *(entry.get(name) for name in RUN_FIGURES)] for case in cases for entry in case.runs]
    return Table("Every run: how it ended, where and when", columns, rows, file="tables/runs.csv")


def bodies_of(run, cases):
    """The bodies that were driven to extremes, as they are before."""
    seen = set()
    for case in cases:
        for path in (run.folder / "problems").glob(f"{case.mesh}*/in.mesh"):
            if path not in seen:
                seen.add(path)
                body = mesh_body(run, case.mesh, "Bodies at rest", str(path.relative_to(run.folder)), unit="m")
                if body:
                    yield body


def page_parts(run, cases):
    sentence, state = verdict_of(cases)
    agreement = Table("Agreement, integrator by integrator", [Column(title) for title in AGREEMENT_HEADER], [[plain_label(row[0]), *row[1:]] for row in agreement_rows(cases)])
    labels, endings = failure_rows(cases)
    failures = Table("How bodies end", [Column("extreme"), Column("mesh"), Column("setting"), *(Column(plain_label(label)) for label in labels)], endings,
                     note="Of measurements: at 1.02, 2 and 10 times the measured step; the number is the step at which it ended.", file="tables/failures.csv")
    charts = [chart for chart in (agreement_chart(cases), step_chart(cases), endings_chart(cases)) if chart]
    return PageParts(sentence, state, [Section("", charts), Section("", [agreement, failures, case_table(cases), run_table(cases)])], lambda: bodies_of(run, cases))
