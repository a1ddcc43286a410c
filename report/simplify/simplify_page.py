"""What a contest of simplifiers has for the page of its run."""

from shared.equal_count import tets_of
from shared.page_parts import BAD, GOOD, OPEN, PLAIN, Axis, Chart, Column, Note, PageParts, Section, Table
from shared.measure_text import TITLES
from shared.records import BUCKETS, figure, median, shares_of
from shared.run_meshes import mesh_body
from shared.tables import VALIDITY_FIGURES, outcome_text, timing_of, validity_rows
from simplify import comparisons, contest, leading, verdict

STATES = {verdict.REPRODUCES: GOOD, verdict.SIGN_ONLY: OPEN, verdict.DOES_NOT: BAD, verdict.OPEN: OPEN, verdict.UNDECIDED: OPEN}
QUALITY = [("percent_above_0_5", Column("above 0.5", "%")), ("percent_above_0_6", Column("above 0.6", "%")), ("mean_quality", Column("mean quality")),
           ("min_quality", Column("least quality", digits=3)), ("min_dihedral_deg", Column("least angle", "deg")), ("p1_dihedral_deg", Column("1% angle", "deg"))]
MOST_HISTOGRAMS = 12  # charts, one a mesh and point of the sweep


def claim_sentence(claim, verdicts):
    """The verdict on a claim in one sentence, with its figures."""
    decided = [each for each in verdicts if each.verdict != verdict.UNDECIDED]
    if not decided:
        return verdict.overall_sentence(claim, verdicts)
    low, high = min(each.difference for each in decided), max(each.difference for each in decided)
    span = claim.signed(low) if low == high else f"{claim.text_of(low, '+')} to {claim.signed(high)}"
    over = f"{len(decided)} mesh{'es' if len(decided) > 1 else ''}"
    outcome = verdict.overall(verdicts)
    text = (f"The claim {'is ' if outcome == verdict.OPEN else ''}{outcome}: {claim.better} against {claim.than} has {span} "
            f"in {TITLES.get(claim.measure, claim.measure)} over {over}")
    if claim.published_difference is not None:
        text += f", where {claim.signed(claim.published_difference)} was published"
    ranked = [each for each in decided if each.spread]
    if ranked:
        text += (f", and {sum(each.as_good for each in ranked)} of {sum(len(each.spread) for each in ranked)} answers of {claim.spread} are at least as good")
    return text + "."


def verdict_of(run, claim, found):
    """The sentence, and how it stands."""
    if claim:
        return claim_sentence(claim, found.verdicts), STATES[verdict.overall(found.verdicts)]
    if found.comparisons:
        kinds = dict.fromkeys(id(row.comparison) for row in found.comparisons)
        lines = [comparisons.summary_line([row for row in found.comparisons if id(row.comparison) == kind]) for kind in kinds]
        states = {finding.verdict for row in found.comparisons for finding in row.findings}
        state = BAD if comparisons.SHORT in states else OPEN if states & {comparisons.OPEN, comparisons.SCATTERS} else GOOD
        return " ".join(lines), state
    return leading.sentence(run, found.scaling), PLAIN


# --- Charts -------------------------------------------------------------------------------------------------------------


def histogram_charts(run, claim):
    """Each mesh and point of the sweep has a chart with a panel for each label; the input is beside each bar."""
    charts = []
    for mesh in run.meshes():
        outline = shares_of(run.inputs.get(mesh)) or [None] * BUCKETS
        for sweep in dict.fromkeys(group.sweep for group in run.of_mesh(mesh)):
            rows = [row for group in run.of_mesh(mesh) if group.sweep == sweep for row in histogram_rows(group, outline)]
            if rows:
                place = ", ".join(text for text in (mesh, contest.short_sweep(sweep) if sweep else "") if text)
                charts.append(Chart(f"Quality of the tetrahedra: {place}", "bars", Axis("q", "quality"), Axis("percent", "tetrahedra", "%"), rows,
                                    series="label", facet="label", shown=[Axis("beside", "input", "%"), Axis("tets", "tetrahedra")],
                                    note="A panel a label; dashed: the input. Whiskers: least and greatest over the seeds."))
    return charts


def histogram_rows(group, outline):
    cases = group.shares()
    for bucket, values in enumerate(zip(*cases)):
        spread = {"percent_low": min(values), "percent_high": max(values)} if len(values) > 1 else {}
        yield {"label": group.label, "q": bucket / BUCKETS, "q_to": (bucket + 1) / BUCKETS, "percent": median(values), **spread, "beside": outline[bucket],
               "tets": tets_of(group), "note": group.count_note, "case": group.records[0].get("case")}


def measure_chart(run, claim):
    """The claim's measure, or the share above 0.5, of each label on each mesh."""
    measure = claim.measure if claim else "percent_above_0_5"
    rows = []
    for group in run.groups:
        values = verdict.values_of(group, measure)
        if values:
            rows.append({"name": group.name, "label": group.label, "mesh": group.mesh, "value": median(values), "value_low": min(values), "value_high": max(values),
                         "seeds": len(values), "hollow": bool(group.count_note), "note": group.count_note, "case": group.records[0].get("case")})
    if not rows:
        return None
    marks = [{"facet": mesh, "value": figure(run.inputs[mesh], "judge", measure), "title": "input"} for mesh in run.meshes()
             if mesh in run.inputs and figure(run.inputs[mesh], "judge", measure) is not None]
    if claim and claim.published_difference is not None:
        marks += [{"value": claim.published_better, "title": f"published, {claim.better}"}, {"value": claim.published_than, "title": f"published, {claim.than}"}]
    title = TITLES.get(measure, measure)
    unit = "%" if measure.startswith("percent") else ""
    return Chart("Tetrahedra above a quality of 0.5" if measure == "percent_above_0_5" else title, "ranges",
                 Axis("value", "tetrahedra above 0.5" if measure == "percent_above_0_5" else title, unit), Axis("name", "label"), rows,
                 series="label", facet="mesh", shown=[Axis("seeds", "values")], marks=marks, drawn="overview",
                 note="Median; line: least and greatest over seeds. Hollow: at another count, not to be compared.")


def timing_chart(run):
    rows = []
    for group in run.groups:
        timing = timing_of(group)
        if timing and timing["kernel_median_s"]:
            rows.append({"name": group.name, "label": group.label, "mesh": group.mesh, "time": timing["kernel_median_s"], "time_low": timing["kernel_median_low_s"],
                         "time_high": timing["kernel_median_high_s"], "n": timing["n"], "rate": timing["tets_removed_per_s"],
                         "covers": timing["interval_covers"], "hollow": bool(group.count_note), "note": group.count_note,
                         "case": group.records[0].get("case")})
    if not rows:
        return None
    return Chart("Time of the methods", "ranges", Axis("time", "time of the method", "ms", True, 1000.0), Axis("name", "label"), rows, series="label", facet="mesh",
                 shown=[Axis("n", "repeats"), Axis("covers", "the interval covers", "%", factor=100.0), Axis("rate", "tetrahedra removed a second")],
                 drawn="timing", note="Median over accepted repeats, with its interval by order statistics.")


def quality_time_chart(run, sections):
    rows = []
    for section in sections:
        place = ", ".join(text for text in (section.mesh, contest.short_sweep(section.sweep)) if text)
        for standing in section.standings:
            values = standing.values
            if values.get("kernel_s") and values.get("percent_above_0_5") is not None:
                timing = timing_of(standing.group) or {}
                rows.append({"label": standing.label, "place": place, "time": values["kernel_s"], "time_low": timing.get("kernel_median_low_s"),
                             "time_high": timing.get("kernel_median_high_s"), "above": values["percent_above_0_5"], "mean": values.get("mean_quality"),
                             "angle": values.get("p1_dihedral_deg"), "tets": values.get("tets"), "hollow": standing.state != contest.RANKED,
                             "note": standing.note, "case": standing.group.records[0].get("case")})
    if not rows:
        return None
    return Chart("Quality against time", "points", Axis("time", "time of the method", "ms", True, 1000.0), Axis("above", "tetrahedra above 0.5", "%"), rows,
                 series="label", facet="place", shown=[Axis("mean", "mean quality"), Axis("angle", "1% angle", "deg"), Axis("tets", "tetrahedra")],
                 note="A point a label; hollow: rejected, or at another count. Whiskers: the interval of the median time.")


# --- Tables -------------------------------------------------------------------------------------------------------------


def quality_table(run):
    columns = [Column("mesh"), Column("label"), Column("cases"), Column("tetrahedra"), *(column for _, column in QUALITY), Column("note")]
    rows = []
    for mesh in run.meshes():
        if mesh in run.inputs:
            record = run.inputs[mesh]
            rows.append([mesh, "input", None, figure(record, "judge", "tets"), *(figure(record, "judge", name) for name, _ in QUALITY), ""])
        for group in run.of_mesh(mesh):
            note = "; ".join(text for text in ("" if outcome_text(group) == "accepted" else outcome_text(group), group.count_note) if text)
            rows.append([mesh, group.name, len(group.cases()), tets_of(group), *(median(group.figures("judge", name)) for name, _ in QUALITY), note])
    return Table("Quality of accepted answers, medians over seeds", columns, rows, file="tables/quality.csv")


def timing_table(run):
    columns = [Column("mesh"), Column("label"), Column("repeats"), Column("time", "ms"), Column("at least", "ms"), Column("at most", "ms"), Column("covers", "%", 3),
               Column("process", "ms"), Column("memory", "MiB"), Column("removed", "tets/s"), Column("note")]
    rows = []
    for group in run.groups:
        timing = timing_of(group)
        if timing:
            scaled = lambda name, factor: None if timing[name] is None else factor * timing[name]
            rows.append([group.mesh, group.name, timing["n"], *(scaled(f"kernel_median{end}_s", 1000.0) for end in ("", "_low", "_high")),
                         scaled("interval_covers", 100.0), scaled("wall_median_s", 1000.0), scaled("peak_rss_max_bytes", 2.0**-20),
                         timing["tets_removed_per_s"], group.count_note])
    return Table("Time of accepted answers: median and its interval", columns, rows, file="tables/timing.csv")


def verdict_table(claim, verdicts):
    columns = [Column("mesh"), Column("at"), Column("input"), Column(claim.better), Column(claim.than), Column("difference", claim.unit), Column("seeds"),
               Column("at least as good"), Column("verdict"), Column("reason")]
    rows = [[each.mesh, each.sweep, each.input_value, each.better, each.than, each.difference, len(each.spread), each.as_good, each.verdict, each.reason]
            for each in verdicts]
    text = claim.text + (f" ({claim.source})" if claim.source else "")
    return Table(f"The claim, mesh by mesh: {TITLES.get(claim.measure, claim.measure)}", columns, rows, note=text, file="tables/verdict.csv")


def comparison_table(rows):
    columns = [Column("of"), Column("mesh"), Column("at"), Column("measure"), Column("its figure"), Column("best of the peers"), Column("whose"), Column("better by"),
               Column("verdict"), Column("reason")]
    lines = [[row.comparison.of, row.mesh, contest.short_sweep(row.sweep), "times as fast as" if finding.measure == "time" else TITLES.get(finding.measure, finding.measure),
              finding.own, finding.best, finding.best_label, finding.margin, finding.verdict, finding.reason] for row in rows for finding in row.findings]
    return Table("Held against others, figure by figure", columns, lines, file="tables/comparisons.csv")


def contest_table(run, sections):
    used = contest.used_columns(sections)
    rows = []
    for section in sections:
        for standing in section.standings:
            rows.append([section.mesh, contest.short_sweep(section.sweep), standing.label, standing.state, *(standing.values.get(column.name) for column in used),
                         ", ".join(TITLES.get(name, name) for name, mark in standing.marks.items() if mark == contest.BEST), standing.note])
    heads = [Column("mesh"), Column("at"), Column("label"), Column("state"), *(Column(TITLES.get(column.name, column.title)) for column in used), Column("best in"), Column("note")]
    return Table("Every answer", heads, rows, note=contest.legend_text(run, sections), file="tables/contest.csv")


def validity_table(run):
    columns = [Column("mesh"), Column("label"), Column("at"), Column("seed"), Column("repeat"), Column("outcome"), Column("violations"), Column("message"),
               *(Column(name.replace("_", " ")) for name in VALIDITY_FIGURES)]
    return Table("Validity, as the judge found it", columns, list(validity_rows(run)), file="tables/validity.csv")


# --- Meshes -------------------------------------------------------------------------------------------------------------


def bodies_of(run):
    """Input and answers of each mesh, side by side."""
    for mesh in run.meshes():
        for sweep in dict.fromkeys(group.sweep for group in run.of_mesh(mesh)):
            group_name = ", ".join(text for text in (mesh, contest.short_sweep(sweep) if sweep else "") if text)
            found = [mesh_body(run, "input", group_name, run.inputs.get(mesh, {}).get("mesh_file"))]
            for group in run.of_mesh(mesh):
                if group.sweep == sweep and group.cases():
                    found.append(mesh_body(run, group.label, group_name, group.cases()[0].get("mesh_file"), note=group.count_note,
                                           case=str(group.records[0].get("case", ""))))
            yield from (body for body in found if body is not None)


def page_parts(run, claim, found):
    """All of it; `found` is what the tables were made from."""
    sentence, state = verdict_of(run, claim, found)
    charts = [measure_chart(run, claim), quality_time_chart(run, found.sections) if found.sections else None, timing_chart(run)]
    histograms = histogram_charts(run, claim)
    left = len(histograms) - MOST_HISTOGRAMS
    tables = [verdict_table(claim, found.verdicts)] if claim else []
    tables += [contest_table(run, found.sections)] if found.sections else []
    tables += [comparison_table(found.comparisons)] if found.comparisons else []
    tables += [quality_table(run), timing_table(run), validity_table(run)]
    more = [Note(f"{left} more histograms are in charts/.")] if left > 0 else []
    return PageParts(sentence, state, [Section("", [chart for chart in charts if chart]), Section("Histograms of quality", histograms[:MOST_HISTOGRAMS]),
                                       Section("", [*tables, *more])], lambda: bodies_of(run))
