"""The contest's table: every answer of every contestant, mesh by mesh and count by count, none left out.

Ranked, and marked where best, are the accepted answers at equal count (equal_count.py), by the median where a method gives
several. Three tables, so that none is too wide: what simplifiers are known by; shape by measures that none of them is made to
raise; what the mesh is worth to linear finite elements. An accepted answer at another count is shown with its count. A rejected one is shown in brackets, with the judge's
reason; what gave no answer to judge, with its outcome.
"""

from dataclasses import dataclass, field

from shared.equal_count import asked_tets, is_at_equal_count, tolerance_of
from shared.records import figure, median
from shared.tables import compares_times, first_reason, outcome_text, seconds_text, timing_of, write_atomically, write_csv
from simplify.verdict import read_claim

RANKED, OTHER_COUNT, REJECTED, NONE = "ranked", "other count", "rejected", "no answer"
BEST, BEST_KEPT = "*", "+"


@dataclass(frozen=True)
class Column:
    name: str
    title: str
    form: str = ""
    sign: int = 0  # +1 if more is better, -1 if less, 0 if neither: only then a best one is marked

    def text(self, value):
        if value is None:
            return ""
        if self.form == "time":
            return seconds_text(value)
        if self.form == "MiB":
            return f"{value / 2**20:.0f} MiB"
        if self.form == "boundary":
            return "kept" if value == 0 else f"{value:,.0f} faces"
        return format(value, self.form)


FAMILIAR = [
    Column("tets", "tets", ",.0f"),
    Column("percent_above_0_5", "% > 0.5", ".2f", 1),
    Column("percent_above_0_6", "% > 0.6", ".2f", 1),
    Column("mean_quality", "mean", ".4f", 1),
    Column("min_dihedral_deg", "least angle", ".2f", 1),
    Column("p1_dihedral_deg", "1% angle", ".2f", 1),
    Column("boundary_changed_faces", "boundary", "boundary"),
    Column("surface_distance_upper", "distance", ".3g"),
    Column("volume_drift_relative", "volume", ".1e"),
    Column("kernel_s", "kernel", "time", -1),
    Column("peak_rss_bytes", "memory", "MiB", -1),
]
SHAPE = [
    Column("mean_mean_ratio", "ratio", ".4f", 1),
    Column("p5_mean_ratio", "5%", ".3f", 1),
    Column("mean_radius_ratio", "3r/R", ".4f", 1),
    Column("p5_radius_ratio", "5%", ".3f", 1),
    Column("mean_edge_ratio", "edges", ".4f", 1),
    Column("p5_edge_ratio", "5%", ".3f", 1),
    Column("p5_dihedral_deg", "5% angle", ".2f", 1),
    Column("p99_max_dihedral_deg", "99% angle", ".2f", -1),
    Column("max_dihedral_deg", "greatest", ".2f", -1),
]
PURPOSE = [
    Column("p1_error", "error", ".4f", -1),
    Column("p1_error_worst", "worst error", ".4f", -1),
    Column("explicit_step", "explicit step", ".4f", 1),
    Column("stiffness_condition", "condition", ",.0f", -1),
    Column("scaled_condition", "scaled", ",.0f", -1),
    Column("max_stiffness_eigenvalue", "eigenvalue", ".3f", -1),
    Column("max_scaled_eigenvalue", "scaled eigenvalue", ".3f", -1),
]
COLUMNS = [*FAMILIAR, *SHAPE, *PURPOSE]
TABLES = [
    ("", FAMILIAR),
    ("Shape, by measures beside the thesis's (palpate.refined raises the mean ratio): mean, radius and edge ratio with their 5th percentiles;\n"
     "5th percentile of the least, 99th percentile and greatest of the greatest dihedral angles", SHAPE),
    ("What the mesh is worth to linear finite elements: error on bendings and twists in the energy norm, root mean square and worst;\n"
     "longest explicit step; condition and greatest eigenvalue of the stiffness, as it is and scaled by its diagonal blocks", PURPOSE),
]


OF_ANSWERS = ("boundary_changed_faces", "surface_distance_upper", "volume_drift_relative", "kernel_s", "peak_rss_bytes")


@dataclass
class Standing:
    """What a label reached on one mesh at one point of the sweep."""

    group: object
    state: str
    values: dict
    note: str
    marks: dict = field(default_factory=dict)

    @property
    def label(self):
        return self.group.label

    @property
    def keeps_boundary(self):
        return self.values.get("boundary_changed_faces") == 0


@dataclass
class Section:
    """One mesh at one point of the sweep."""

    mesh: str
    sweep: str
    asked: object  # the count that the stops ask for, or None
    standings: list

    def find(self, label):
        return next((standing for standing in self.standings if standing.label == label), None)

    @property
    def ranked(self):
        return [standing for standing in self.standings if standing.state == RANKED]


def values_of_group(group):
    """Median of each column over the answers that were judged, accepted or else rejected."""
    judged = group.judged()
    values = {}
    for column in COLUMNS:
        found = [figure(record, "judge", column.name) for record in judged]
        values[column.name] = median([value for value in found if value is not None])
    timing = timing_of(group)
    if timing:
        values["kernel_s"], values["peak_rss_bytes"] = timing["kernel_median_s"], timing["peak_rss_max_bytes"]
    elif judged:
        for name in ("kernel_s", "peak_rss_bytes"):
            values[name] = median([value for value in (figure(record, name) for record in judged) if value is not None])
    return values


def stand(run, group):
    """The standing of one group."""
    if not group.judged():
        return Standing(group, NONE, values_of_group(group), first_reason(group) or "not run")
    if not group.cases():
        return Standing(group, REJECTED, values_of_group(group), first_reason(group))
    note = group.count_note
    if set(group.outcomes()) != {"accepted"}:
        note = "; ".join(text for text in (note, outcome_text(group), first_reason(group)) if text)
    state = RANKED if is_at_equal_count(run, read_claim(run.plan_data), group) else OTHER_COUNT
    return Standing(group, state, values_of_group(group), note)


def set_apart(standings, tolerance):
    """Where no count was asked for (limits), answers at different counts are not ranked."""
    ranked = [standing for standing in standings if standing.state == RANKED]
    counts = [standing.values["tets"] for standing in ranked]
    if not counts or None in counts or max(counts) - min(counts) <= tolerance * max(counts):
        return
    for standing in ranked:
        standing.state = OTHER_COUNT
        standing.note = "; ".join(text for text in ("a count of its own", standing.note) if text)


def mark_best(standings, with_times=True):
    """Marks the best of each column among the ranked, and the best that keeps the boundary where no best does."""
    ranked = [standing for standing in standings if standing.state == RANKED]
    for column in COLUMNS if with_times else [column for column in COLUMNS if column.form != "time"]:
        for mark, field_ in ((BEST, ranked), (BEST_KEPT, [standing for standing in ranked if standing.keeps_boundary])):
            values = [standing.values[column.name] for standing in field_ if standing.values[column.name] is not None]
            if not column.sign or not values:
                continue
            best = max(values) if column.sign > 0 else min(values)
            winners = [standing for standing in field_ if standing.values[column.name] == best]
            if any(standing.marks.get(column.name) for standing in winners):
                continue
            for standing in winners:
                standing.marks[column.name] = mark


def order_of(standing):
    """Ranked ones first, by their shares of good tetrahedra and the mean; then the others."""
    quality = [-(standing.values.get(name) or 0.0) for name in ("percent_above_0_5", "percent_above_0_6", "mean_quality")]
    return [(RANKED, OTHER_COUNT, REJECTED, NONE).index(standing.state), *quality]


def read_sections(run):
    """All sections, in the order of the plan."""
    sections = []
    for mesh in run.meshes():
        for sweep in dict.fromkeys(group.sweep for group in run.of_mesh(mesh)):
            groups = [group for group in run.of_mesh(mesh) if group.sweep == sweep]
            asked = next((asked_tets(group.records[0]) for group in groups if asked_tets(group.records[0])), None)
            standings = [stand(run, group) for group in groups]
            if asked is None:
                set_apart(standings, tolerance_of(run))
            standings.sort(key=order_of)
            mark_best(standings, compares_times(run))
            sections.append(Section(mesh, sweep, asked, standings))
    return sections


# --- As text and as a file ----------------------------------------------------------------------------------------------


def short_sweep(sweep):
    """"22% removed" for "tets_removed_ratio 0.22"; anything else as it is."""
    name, _, value = sweep.partition(" ")
    return f"{100 * float(value):g}% removed" if name == "tets_removed_ratio" and "," not in value else sweep


def section_title(run, section):
    start = figure(run.inputs.get(section.mesh, {}), "judge", "tets")
    title = ", ".join(text for text in (section.mesh, short_sweep(section.sweep)) if text)
    if section.asked is None or start is None:
        return title
    return f"{title}: {section.asked:,.0f} of {start:,.0f} tetrahedra asked for"


def used_columns(sections, columns=tuple(COLUMNS)):
    return [column for column in columns
            if any(standing.values.get(column.name) is not None for section in sections for standing in section.standings)]


def standing_cells(standing, columns, with_note):
    cells = [standing.label]
    for column in columns:
        text = column.text(standing.values.get(column.name))
        if text and standing.state == REJECTED:
            cells.append(f"({text})")
        else:
            cells.append(text + standing.marks.get(column.name, " "))
    return [*cells, standing.note if with_note else ""]


def input_cells(run, section, columns):
    record = run.inputs.get(section.mesh)
    if record is None:
        return None
    quality = [(column.text(figure(record, "judge", column.name)) if column.name not in OF_ANSWERS else "") + " " for column in columns]
    return ["input", *quality, ""]


def table_text(run, sections, columns, with_note):
    """One table with one header; a title line opens each section."""
    header = ["label", *(column.title + " " for column in columns), "note" if with_note else ""]
    lines = [header]
    for section in sections:
        lines.append(section_title(run, section))
        cells = input_cells(run, section, columns)
        lines += [cells] if cells else []
        lines += [standing_cells(standing, columns, with_note) for standing in section.standings
                  if with_note or any(standing.values.get(column.name) is not None for column in columns)]
    widths = [max(len(line[i]) for line in lines if isinstance(line, list)) for i in range(len(header) - 1)]
    out = []
    for line in lines:
        if isinstance(line, str):
            out += ["", line]
            continue
        parts = [line[0].ljust(widths[0]), *(cell.rjust(width) for cell, width in zip(line[1:-1], widths[1:])), line[-1]]
        out.append("  ".join(parts).rstrip())
        if line is header:
            out.append("  ".join("-" * width for width in widths))
    return "\n".join(out)


def contest_text(run, sections):
    """All tables, then what the marks mean. Notes stand in the first one alone; the others leave out who has no figures."""
    blocks = []
    for title, columns in TABLES:
        used = used_columns(sections, columns)
        if used:
            blocks += [f"{title}\n" if title else None, table_text(run, sections, used, not title), ""]
    return "\n".join([*(block for block in blocks if block is not None), legend_text(run, sections)])


def legend_text(run, sections):
    marks = {mark for section in sections for standing in section.standings for mark in standing.marks.values()}
    states = {standing.state for section in sections for standing in section.standings}
    lines = [f"Ranked: accepted answers within {100 * tolerance_of(run):g}% of the tetrahedra asked for."]
    if marks:
        lines[0] += " * best of the column"
        lines[0] += "; + best of those that keep the boundary to the bit." if BEST_KEPT in marks else "."
    if REJECTED in states:
        lines.append("(in brackets): the judge rejects the answer, for the reason beside it; its figures decide nothing.")
    counts = [timing["n"] for timing in (timing_of(standing.group) for section in sections for standing in section.standings) if timing]
    if counts:
        said = f"{min(counts)}" if min(counts) == max(counts) else f"{min(counts)} to {max(counts)}"
        lines.append(f"Times: medians over {said} accepted repeats (and seeds); contest.csv has their intervals and what they cover.")
    return "\n".join(lines)


TIMING_INTERVAL = ["n", "kernel_median_low_s", "kernel_median_high_s", "interval_covers", "interval_kind"]


def write_contest(run, sections, folder):
    """Writes contest.csv and contest.txt; returns their names."""
    rows = []
    for section in sections:
        for standing in section.standings:
            timing = timing_of(standing.group) or {}
            rows.append([section.mesh, section.sweep, section.asked, standing.label, standing.group.contestant,
                         standing.state, *(standing.values.get(column.name) for column in COLUMNS),
                         " ".join(name for name, mark in standing.marks.items() if mark == BEST),
                         " ".join(name for name, mark in standing.marks.items() if mark == BEST_KEPT),
                         *(timing.get(name) for name in TIMING_INTERVAL), standing.note])
    write_csv(folder / "contest.csv",
              ["mesh", "sweep", "tets_asked", "label", "method", "state", *(column.name for column in COLUMNS), "best_in",
               "best_with_boundary_kept_in", *TIMING_INTERVAL, "note"], rows)
    write_atomically(folder / "contest.txt", contest_text(run, sections) + "\n")
    return {"contest.csv", "contest.txt"}
