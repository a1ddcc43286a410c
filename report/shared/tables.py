"""Tables of a run: CSV files for other programs, and aligned text for people.

Only accepted answers are compared. What was not accepted is listed with its outcome and has empty figures.
"""

import csv
import io
import json
import os

from shared import load
from shared.intervals import median_interval, percent
from shared.records import BUCKETS, figure, figures_of, histogram, json_mark, median, present, quantile
from shared.whole_file import replacing

QUALITY_FIGURES = [
    "percent_above_0_5", "percent_above_0_6", "mean_quality", "min_quality", "min_dihedral_deg", "p1_dihedral_deg",
    "percent_above_0_5_input_ideal", "percent_above_0_6_input_ideal", "mean_quality_input_ideal",
]
VALIDITY_FIGURES = [
    "inverted_tets", "flat_tets", "duplicate_tets", "nonmanifold_faces", "folded_faces", "nonmanifold_edges",
    "nonmanifold_vertices", "isolated_vertices", "euler", "euler_unchanged", "components_unchanged",
    "boundary_changed_faces", "volume_drift_relative",
]


def write_atomically(path, text):
    with replacing(path) as beside, open(beside, "w", encoding="utf-8", newline="") as stream:
        stream.write(text)
        stream.flush()
        os.fsync(stream.fileno())


def write_csv(path, header, rows):
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(header)
    for row in rows:
        writer.writerow(["" if cell is None else cell for cell in row])
    write_atomically(path, text.getvalue())


def histogram_rows(run):
    """One row a mesh, label, seed and bucket, with the share of all tets."""
    for mesh in run.meshes():
        subjects = [("input", "", run.inputs[mesh])] if mesh in run.inputs else []
        subjects += [(group.label, group.sweep, case) for group in run.of_mesh(mesh) for case in group.cases()]
        for label, sweep, record in subjects:
            buckets = histogram(record)
            if not buckets or not sum(buckets):
                continue
            for bucket, tets in enumerate(buckets):
                yield [mesh, label, sweep, record.get("seed"), bucket / BUCKETS, (bucket + 1) / BUCKETS, tets,
                       100.0 * tets / sum(buckets)]


def quality_rows(run):
    for mesh in run.meshes():
        if mesh in run.inputs:
            record = run.inputs[mesh]
            figures = [figure(record, "judge", name) for name in QUALITY_FIGURES]
            spread = [cell for value in figures for cell in (value, value, value)]
            yield [mesh, "input", "", "", 1, figure(record, "judge", "vertices"), figure(record, "judge", "tets"), "", *spread]
        for group in run.of_mesh(mesh):
            spread = []
            for name in QUALITY_FIGURES:
                values = group.figures("judge", name)
                spread += [median(values), min(values, default=None), max(values, default=None)]
            yield [mesh, group.label, group.sweep, outcome_text(group), len(group.cases()),
                   median(group.figures("judge", "vertices")), median(group.figures("judge", "tets")), group.count_note, *spread]


def timed_units(answers):
    """What an interval of the time is taken over, and its name: the repeats, or, where a label has several seeds, the median of
    each seed. The repeats of a seed are no sample of the seeds."""
    times = {}
    for record in answers:
        seconds = figure(record, "kernel_s")
        if seconds is not None:
            times.setdefault(json_mark(record.get("seed")), []).append(seconds)
    if len(times) > 1:
        return [median(own) for own in times.values()], "seeds"
    return [value for own in times.values() for value in own], "repeats"


def timing_of(group):
    """Times over the accepted repeats: a dict, or None if there is none. The median is that of the units of its interval."""
    return group.once("timing", lambda: work_out_timing(group))


def work_out_timing(group):
    answers = group.accepted()
    kernel = figures_of(answers, "kernel_s")
    if not kernel:
        return None
    plain = [record for record in answers if not record.get("searched")] or answers  # a search counts into both
    wall = figures_of(plain, "wall_s")
    memory = figures_of(plain, "peak_rss_bytes")
    removed = {}
    for record in answers:
        report = record.get("report")
        if not isinstance(report, dict):
            continue
        if id(report) not in removed:  # repeats share theirs; it is kept, so that its id stays its own
            before, after = figure(report, "tets_in"), figure(report, "tets_out")
            removed[id(report)] = (None if None in (before, after) else before - after, report)
    tets, seconds = median(present(count for count, _ in removed.values())), median(timed_units(answers)[0])
    loads = load.loads_of(group)
    units, over = timed_units(answers)
    interval = median_interval(units)
    return {"n": len(kernel), "kernel_median_s": median(units), "kernel_min_s": min(kernel), "kernel_max_s": max(kernel),
            "kernel_q1_s": quantile(kernel, 0.25), "kernel_q3_s": quantile(kernel, 0.75), "kernel_median_low_s": interval and interval.low,
            "kernel_median_high_s": interval and interval.high, "interval_covers": interval and interval.coverage,
            "interval_kind": f"{interval.kind} {over}" if interval else "none: one value", "wall_median_s": median(wall), "peak_rss_max_bytes": max(memory, default=None),
            "tets_removed_per_s": tets / seconds if tets is not None and seconds else None, "load_1min_max": max(present(one.load_1min for one in loads), default=None),
            "others_share": load.share_of(loads)}


TIMING_FIGURES = ["n", "kernel_median_s", "kernel_min_s", "kernel_max_s", "kernel_q1_s", "kernel_q3_s",
                  "kernel_median_low_s", "kernel_median_high_s", "interval_covers", "interval_kind", "wall_median_s",
                  "peak_rss_max_bytes", "tets_removed_per_s", "load_1min_max", "others_share"]


def compares_times(run):
    """Whether the run has the repeats and the warm-up that times are compared by; one that does not say is taken to."""
    repeats, warmup = figure(run.provenance, "repeats"), figure(run.provenance, "warmup")
    return (repeats is None or repeats >= LEAST_REPEATS) and (warmup is None or warmup >= 1)


def timing_rows(run):
    for group in run.groups:
        timing = timing_of(group) or {"n": 0}
        yield [group.mesh, group.label, group.sweep, outcome_text(group), group.count_note,
               *(timing.get(name) for name in TIMING_FIGURES)]


def rejection_rows(run):
    for group in run.groups:
        for record in group.cases():
            report = record.get("report") if isinstance(record.get("report"), dict) else {}
            rejected = report.get("rejected") if isinstance(report.get("rejected"), dict) else {}
            for reason, count in rejected.items():
                yield [group.mesh, group.label, group.sweep, record.get("seed"), report.get("fusions"), reason, count]


def validity_rows(run):
    """One row a case: its first repeat, and every later one whose outcome differs."""
    for mesh in run.meshes():
        if mesh in run.inputs:
            yield validity_row(mesh, "input", "", run.inputs[mesh])
        for group in run.of_mesh(mesh):
            yield from group.once("validity", lambda group=group: [validity_row(mesh, group.label, group.sweep, record) for record in endings_of(group)])


def endings_of(group):
    """The first record of each seed and outcome."""
    first = {}
    for record in group.records:
        first.setdefault((json_mark(record.get("seed")), record.get("outcome")), record)
    return first.values()


def validity_row(mesh, label, sweep, record):
    judge = record.get("judge")
    figures = [figure(judge, name) for name in VALIDITY_FIGURES] if isinstance(judge, dict) else [None] * len(VALIDITY_FIGURES)
    return [mesh, label, sweep, record.get("seed"), record.get("repeat"), record.get("outcome"), violations_text(record), record.get("message"), *figures]


def violations_text(record):
    violations = record.get("violations")
    if not isinstance(violations, list):
        return violations
    return "; ".join(item if isinstance(item, str) else json.dumps(item, sort_keys=True) for item in violations)


def first_reason(group):
    """The first outcome that is not acceptance, with what the judge or the runner says of it."""
    for record in group.records:
        if record.get("outcome") != "accepted" and not record.get("warmup"):
            why = violations_text(record) or record.get("message") or ""
            return f"{record.get('outcome')}: {why}" if why else str(record.get("outcome"))
    return ""


def outcome_text(group):
    """"accepted", or how often each outcome occurred."""
    outcomes = group.outcomes()
    if set(outcomes) == {"accepted"}:
        return "accepted"
    return ", ".join(f"{count} {outcome}" for outcome, count in outcomes.items())


def write_tables(run, folder):
    """Writes the five tables of every run; returns their paths."""
    place = ["mesh", "label", "sweep"]
    spread = [f"{name}_{kind}" for name in QUALITY_FIGURES for kind in ("median", "min", "max")]
    tables = {
        "histogram.csv": ([*place, "seed", "quality_from", "quality_to", "tets", "percent"], histogram_rows(run)),
        "quality.csv": ([*place, "outcome", "cases", "vertices", "tets", "note", *spread], quality_rows(run)),
        "timing.csv": ([*place, "outcome", "note", *TIMING_FIGURES], timing_rows(run)),
        "rejections.csv": ([*place, "seed", "fusions", "reason", "tets"], rejection_rows(run)),
        "validity.csv": ([*place, "seed", "repeat", "outcome", "violations", "message", *VALIDITY_FIGURES],
                         validity_rows(run)),
    }
    folder.mkdir(parents=True, exist_ok=True)
    for name, (header, rows) in tables.items():
        write_csv(folder / name, header, rows)
    return [folder / name for name in tables]


# --- For people ---------------------------------------------------------------------------------------------------------


def align(header, rows):
    """Text columns: the first ones to the left, figures to the right; no trailing blanks."""
    cells = [header, *rows]
    widths = [max(len(row[i]) for row in cells) for i in range(len(header))]
    left = [name == "note" or all(not row[i][:1].isdigit() and row[i][:1] not in "-+" for row in rows if row[i])
            for i, name in enumerate(header)]
    lines = []
    for number, row in enumerate(cells):
        parts = [cell.ljust(width) if is_left else cell.rjust(width) for cell, width, is_left in zip(row, widths, left)]
        lines.append("  ".join(parts).rstrip())
        if number == 0:
            lines.append("  ".join("-" * width for width in widths))
    return "\n".join(lines)


def decimals(value, digits):
    return "" if value is None else f"{value:.{digits}f}"


def with_range(values, digits):
    """"80.1" for one value, "80.1 [79.0, 81.2]" for several."""
    if not values:
        return ""
    middle = decimals(median(values), digits)
    if len(values) == 1 or min(values) == max(values):
        return middle
    return f"{middle} [{decimals(min(values), digits)}, {decimals(max(values), digits)}]"


def seconds_text(value):
    if value is None:
        return ""
    return f"{1000 * value:.2f} ms" if value < 1 else f"{value:.2f} s"


def quality_summary(run):
    """Quality of each mesh and label: the median over seeds, with its range."""
    rows = []
    for mesh in run.meshes():
        if mesh in run.inputs:
            record = run.inputs[mesh]
            get = lambda name: figure(record, "judge", name)
            rows.append([mesh, "input", "", decimals(get("tets"), 0), decimals(get("percent_above_0_5"), 1),
                         decimals(get("percent_above_0_6"), 1), decimals(get("mean_quality"), 3),
                         decimals(get("min_dihedral_deg"), 1), decimals(get("p1_dihedral_deg"), 1), ""])
        for group in run.of_mesh(mesh):
            outcome = outcome_text(group)
            rows.append([mesh, group.name, with_range(group.figures("report", "fusions"), 0),
                         with_range(group.figures("judge", "tets"), 0),
                         with_range(group.figures("judge", "percent_above_0_5"), 1),
                         with_range(group.figures("judge", "percent_above_0_6"), 1),
                         with_range(group.figures("judge", "mean_quality"), 3),
                         with_range(group.figures("judge", "min_dihedral_deg"), 1),
                         with_range(group.figures("judge", "p1_dihedral_deg"), 1),
                         "; ".join(text for text in ("" if outcome == "accepted" else outcome, group.count_note) if text)])
    header = ["mesh", "label", "fusions", "tets", "% above 0.5", "% above 0.6", "mean", "min angle", "p1 angle", "note"]
    return align(without_repeats(header, rows), without_repeats_rows(header, rows)) if rows else "no records"


def interval_text(timing):
    """"[0.21 ms, 0.24 ms]" and what it covers; two empty cells for one value."""
    if timing["interval_covers"] is None:
        return ["", ""]
    ends = [seconds_text(timing[f"kernel_median_{end}_s"]) for end in ("low", "high")]
    return [f"[{ends[0]}, {ends[1]}]", percent(timing["interval_covers"])]


LEAST_REPEATS = 9  # from which on times are compared
WORDY = ("", "note")  # heads of last columns of words
TIMING_TITLE = ("Time of accepted answers: median, [its interval by order statistics], and the chance that such an interval holds the "
                "true median\n(95% takes 6 repeats; of a label with seeds it is over the seeds)")


def timing_summary(run):
    rows = []
    for group in run.groups:
        timing = timing_of(group)
        if timing is None:
            continue
        memory, rate = timing["peak_rss_max_bytes"], timing["tets_removed_per_s"]
        rows.append([group.mesh, group.name, str(timing["n"]), seconds_text(timing["kernel_median_s"]),
                     *interval_text(timing), seconds_text(timing["wall_median_s"]), "" if memory is None else f"{memory / 2**20:.0f} MiB",
                     "" if rate is None else f"{rate:,.0f}", group.count_note])
    header = ["mesh", "label", "n", "kernel", "interval", "covers", "process", "memory", "tets removed/s", "note"]
    return align(without_repeats(header, rows), without_repeats_rows(header, rows)) if rows else "no accepted answers with times: nothing to compare"


def without_repeats(header, rows):
    """The header without the last column if no row has anything in it."""
    return header if any(row[-1] for row in rows) else header[:-1]


def without_repeats_rows(header, rows):
    """The rows with the mesh named once, and cut to the header that `without_repeats` gives."""
    width = len(without_repeats(header, rows))
    shown = []
    for i, row in enumerate(rows):
        first = "" if i and rows[i - 1][0] == row[0] else row[0]
        shown.append([first, *row[1:width]])
    return shown


def percent_text(value):
    """Three digits: "0.0123", "1.23", "12.3", "123"; a whole number above."""
    if value is None:
        return ""
    percent = 100 * value
    if percent == 0:
        return "0"
    text = f"{percent:.0f}" if abs(percent) >= 100 else f"{percent:#.3g}"
    return f"{percent:.1e}" if abs(percent) >= 1e5 or abs(percent) < 1e-3 else text


def joined(names):
    """"a", "a and b", "a, b and c"."""
    names = list(names)
    return " and ".join([", ".join(names[:-1]), names[-1]]) if len(names) > 1 else "".join(names)


def pad_columns(lines):
    """Aligned text of lines that are lists (cells) or texts; the first cell is to the left, and so is the last if it holds words (notes)."""
    rows = [line for line in lines if isinstance(line, list)]
    if rows[0][-1] not in WORDY:
        lines = [[*line, ""] if isinstance(line, list) else line for line in lines]
        rows = [line for line in lines if isinstance(line, list)]
    widths = [max(len(row[i]) for row in rows) for i in range(len(rows[0]) - 1)]
    out = []
    for line in lines:
        if isinstance(line, str):
            out.append(line)
            continue
        parts = [line[0].ljust(widths[0]), *(cell.rjust(width) for cell, width in zip(line[1:-1], widths[1:])), line[-1]]
        out.append("  ".join(parts).rstrip())
        if line is rows[0]:
            out.append("  ".join("-" * width for width in widths))
    return "\n".join(out)
