"""Holds one label of a plan against the best of others: its key `comparisons`, on each mesh and at each point of the sweep.

With x the figure of the label `of` and b the best figure of its peers (`against_best_of`), each a median over the accepted
answers, and "better" the side that the measure has:

  no lower   x is b or better (for a measure where less is better: no higher)
  short      x is worse than b, by the difference shown

A peer counts if its answer is accepted and its tetrahedra are within the plan's `equal_count` of those of `of` (not of the
count asked for: two answers can lie on either side of that). A peer that does not count is named with the reason. Up to the
share `input_up_to_ratio` of removed tetrahedra the input is a peer too, whatever its count. A measure that `of` or all peers
lack cannot be decided.

The time ratio is the median over repeats of kernel(`time_against`) / kernel(`of`), the two of one round taken together. If
the comparison has a `time_factor`, the ratio is to be at least that; otherwise it is only shown.
"""

from dataclasses import dataclass, field

from contest import short_sweep
from equal_count import is_equal, tets_of, tolerance_of
from records import figure, median, present
from tables import align, median_interval, outcome_text, write_atomically, write_csv

MET, SHORT, OPEN, SHOWN = "met", "short", "cannot be decided", "shown"
TITLES = {
    "percent_above_0_5": "% > 0.5", "percent_above_0_6": "% > 0.6", "mean_quality": "mean", "min_dihedral_deg": "least angle",
    "p1_dihedral_deg": "1% angle", "surface_distance_upper": "distance", "kernel_s": "kernel, s", "peak_rss_bytes": "memory, bytes",
}
DIGITS = {"percent_above_0_5": 2, "percent_above_0_6": 2, "mean_quality": 4, "min_dihedral_deg": 2, "p1_dihedral_deg": 2}


@dataclass
class Comparison:
    of: str
    peers: list
    measures: list
    time_against: str = ""
    time_factor: object = None
    input_up_to_ratio: float = -1.0


@dataclass
class Finding:
    """One figure (or the time) of one mesh and point of the sweep."""

    measure: str
    verdict: str
    own: object = None
    best: object = None
    best_label: str = ""
    margin: object = None  # positive where own is better
    reason: str = ""


@dataclass
class Row:
    """All findings of one comparison on one mesh at one point of the sweep."""

    comparison: Comparison
    mesh: str
    sweep: str
    own_tets: object
    findings: list
    left_out: list = field(default_factory=list)  # "label (reason)"
    time_low: object = None
    time_high: object = None
    repeats: int = 0

    @property
    def met_text(self):
        judged = [finding for finding in self.findings if finding.verdict != SHOWN]
        return f"{sum(finding.verdict == MET for finding in judged)} of {len(judged)}"


def read_comparisons(plan_data):
    """The plan's comparisons; an entry that names no label, peers or measures is left out (the plan reader refuses it)."""
    found = []
    entries = plan_data.get("comparisons")
    for entry in entries if isinstance(entries, list) else []:
        if not isinstance(entry, dict) or not all(entry.get(key) for key in ("of", "against_best_of", "measures")):
            continue
        ratio = figure(entry, "input_up_to_ratio")
        found.append(Comparison(entry["of"], list(entry["against_best_of"]), list(entry["measures"]),
                                str(entry.get("time_against") or ""), figure(entry, "time_factor"),
                                -1.0 if ratio is None else ratio))
    return found


def sign_of(run, measure):
    """+1 where more is better, -1 where less is; from the provenance, which has it from the list of measures."""
    directions = run.provenance.get("measures")
    entry = directions.get(measure) if isinstance(directions, dict) else None
    return -1 if isinstance(entry, dict) and entry.get("better") == "lower" else 1


def find_group(run, mesh, sweep, label):
    """The label's group at this point of the sweep, or the one that has no sweep of its own."""
    same = run.find(mesh, label)
    return next((group for group in same if group.sweep == sweep), next((group for group in same if not group.sweep), None))


def value_of(group, measure):
    """The median of a figure: the judge's over the different answers, any other (times, memory) over the repeats."""
    judged = group.figures("judge", measure)
    return median(judged or present(figure(record, measure) for record in group.accepted()))


def counted_peers(run, comparison, mesh, sweep, own_tets):
    """The peers that count, as (label, group), and what is left out, as texts."""
    peers, left_out = [], []
    for label in comparison.peers:
        group = find_group(run, mesh, sweep, label)
        if group is None:
            left_out.append(f"{label} (not run)")
        elif not group.cases():
            left_out.append(f"{label} ({outcome_text(group)})")
        elif not is_equal(tets_of(group), own_tets, tolerance_of(run)):
            left_out.append(f"{label} ({tets_of(group):,.0f} tets)")
        else:
            peers.append((label, group))
    return peers, left_out


def input_counts(comparison, sweep):
    name, _, value = sweep.partition(" ")
    return name == "tets_removed_ratio" and "," not in value and float(value) <= comparison.input_up_to_ratio


def decide(own, peers, sign):
    """Verdict, best value, its label and the margin, of a value and a list of (label, value)."""
    peers = [(label, value) for label, value in peers if value is not None]
    if own is None or not peers:
        return OPEN, None, "", None
    label, best = max(peers, key=lambda peer: sign * peer[1])
    margin = sign * (own - best)
    return (MET if margin >= 0 else SHORT), best, label, margin


def time_finding(run, comparison, mesh, sweep, own):
    """The finding on time, its interval over repeats and their number."""
    other = find_group(run, mesh, sweep, comparison.time_against)
    times = [{}, {}]
    for group, found in zip((own, other), times):
        for record in group.accepted() if group else []:
            if figure(record, "kernel_s"):
                found[record.get("repeat"), str(record.get("seed"))] = record["kernel_s"]
    own_times, other_times = times
    ratios = [other_times[key] / own_times[key] for key in own_times if key in other_times]
    if not ratios:
        missing = comparison.of if not own_times else comparison.time_against
        return Finding("time", OPEN, reason=f"no accepted time of {missing}"), None, None, 0
    ratio = median(ratios)
    low, high = median_interval(ratios)
    low, high = (min(ratios), max(ratios)) if low is None else (low, high)
    factor = comparison.time_factor
    if factor is None:
        return Finding("time", SHOWN, ratio), low, high, len(ratios)
    finding = Finding("time", MET if ratio >= factor else SHORT, ratio, factor, comparison.time_against, ratio - factor)
    return finding, low, high, len(ratios)


def why_open(comparison, own, value, peers):
    if own is None or not own.cases():
        return f"no accepted answer of {comparison.of}"
    if value is None:
        return f"{comparison.of} has no such figure"
    return "no peer has such a figure" if peers else "no peer at equal count"


def compare(run, comparison, mesh, sweep):
    """One row."""
    own = find_group(run, mesh, sweep, comparison.of)
    own_tets = tets_of(own)
    peers, left_out = counted_peers(run, comparison, mesh, sweep, own_tets)
    findings = []
    for measure in comparison.measures:
        values = [(label, value_of(group, measure)) for label, group in peers]
        if input_counts(comparison, sweep):
            values.append(("input", figure(run.inputs.get(mesh, {}), "judge", measure)))
        value = value_of(own, measure) if own else None
        verdict, best, label, margin = decide(value, values, sign_of(run, measure))
        reason = ""
        if verdict == OPEN:
            reason = why_open(comparison, own, value, peers)
        findings.append(Finding(measure, verdict, value, best, label, margin, reason))
    row = Row(comparison, mesh, sweep, own_tets, findings, left_out)
    if comparison.time_against:
        finding, row.time_low, row.time_high, row.repeats = time_finding(run, comparison, mesh, sweep, own)
        findings.append(finding)
    return row


def compare_all(run):
    """Rows of all comparisons, on every mesh and at every point of the sweep at which `of` was run."""
    rows = []
    for comparison in read_comparisons(run.plan_data):
        for mesh in run.meshes():
            for group in run.find(mesh, comparison.of):
                rows.append(compare(run, comparison, mesh, group.sweep))
    return rows


# --- In words -----------------------------------------------------------------------------------------------------------


def amount(measure, value):
    """A difference or figure of a measure, with as many digits as it takes to tell it from zero."""
    digits = DIGITS.get(measure)
    if digits is None or (value and round(abs(value), digits) == 0):
        return f"{value:.2g}" if value else "0"
    return f"{value:.{digits}f}"


def cell(finding):
    if finding.verdict == OPEN:
        return "?"
    if finding.measure == "time":
        return f"{finding.own:.3g}x" + (" SHORT" if finding.verdict == SHORT else "")
    text = amount(finding.measure, finding.margin)
    return f"{text} SHORT" if finding.verdict == SHORT else (f"+{text}" if finding.margin else "0")


def comparison_table(rows):
    """Margins of `of` over the best peer, one line a mesh and point of the sweep."""
    comparison = rows[0].comparison
    header = ["mesh", "", "tets", *(TITLES.get(measure, measure) for measure in comparison.measures)]
    header += ["time ratio"] if comparison.time_against else []
    lines = [[row.mesh, short_sweep(row.sweep), "" if row.own_tets is None else f"{row.own_tets:,.0f}",
              *map(cell, row.findings), row.met_text] for row in rows]
    return align([*header, "met"], lines)


def shortfall_lines(row, with_shortfalls):
    """A line for each finding that is short or cannot be decided, and one for peers that were left out."""
    comparison = row.comparison
    place = ", ".join(text for text in (row.mesh, short_sweep(row.sweep)) if text)
    undecided = {}
    for finding in row.findings:
        title = TITLES.get(finding.measure, finding.measure)
        if finding.verdict == OPEN:
            undecided.setdefault(finding.reason, []).append(title)
        elif finding.verdict != SHORT or not with_shortfalls:
            continue
        elif finding.measure == "time":
            yield (f"{place}: {finding.own:.2f} times as fast as {comparison.time_against}, "
                   f"{comparison.time_factor:g} times is asked for.")
        else:
            yield (f"{place}: {title} {amount(finding.measure, finding.own)}, short of "
                   f"{finding.best_label} ({amount(finding.measure, finding.best)}) by "
                   f"{amount(finding.measure, -finding.margin)}.")
    for reason, titles in undecided.items():
        yield f"{place}: {', '.join(titles)} {OPEN}: {reason}."
    if row.left_out:
        yield f"{place}: left out: {', '.join(row.left_out)}."


def peers_text(comparison):
    return ("the best of " if len(comparison.peers) > 1 else "") + ", ".join(comparison.peers)


def summary_line(rows):
    comparison = rows[0].comparison
    figures = [finding for row in rows for finding in row.findings if finding.measure != "time"]
    times = [finding for row in rows for finding in row.findings if finding.measure == "time" and finding.verdict != SHOWN]
    met = lambda findings: sum(finding.verdict == MET for finding in findings)
    text = f"{comparison.of}: {met(figures)} of {len(figures)} figures no worse than {peers_text(comparison)}"
    if times and comparison.time_factor is not None:
        text += f"; at least {comparison.time_factor:g} times as fast as {comparison.time_against} in {met(times)} of {len(times)}"
    undecided = sum(finding.verdict == OPEN for finding in [*figures, *times])
    return text + (f"; {undecided} cannot be decided." if undecided else ".")


def comparisons_text(run, rows, with_shortfalls=True):
    """The tables; below each every shortfall with both figures, or only what was left out or cannot be decided."""
    blocks = []
    for comparison in dict.fromkeys(map(id, (row.comparison for row in rows))):
        own = [row for row in rows if id(row.comparison) == comparison]
        plan = own[0].comparison
        title = (f"{plan.of} against {peers_text(plan)}, counts within {100 * tolerance_of(run):g}%: "
                 f"by how much it is better (+) or SHORT")
        if plan.input_up_to_ratio >= 0:
            title += f"; up to {100 * plan.input_up_to_ratio:g}% removed the input is a peer too"
        lines = [line for row in own for line in shortfall_lines(row, with_shortfalls)]
        blocks.append("\n".join([title, "", comparison_table(own), "", *lines, summary_line(own)]))
    return "\n\n".join(blocks)


def write_comparisons(run, rows, folder):
    """Writes comparisons.csv and comparisons.txt; returns their names."""
    lines = []
    for row in rows:
        for finding in row.findings:
            is_time = finding.measure == "time"
            lines.append([row.mesh, row.sweep, row.comparison.of, row.own_tets, finding.measure, finding.own, finding.best,
                          finding.best_label, finding.margin, finding.verdict, finding.reason, "; ".join(row.left_out),
                          row.time_low if is_time else None, row.time_high if is_time else None,
                          row.repeats if is_time else None])
    write_csv(folder / "comparisons.csv",
              ["mesh", "sweep", "of", "tets", "measure", "value", "best_of_peers", "best_label", "margin", "verdict", "reason",
               "left_out", "ratio_low", "ratio_high", "repeats"], lines)
    write_atomically(folder / "comparisons.txt", comparisons_text(run, rows) + "\n")
    return {"comparisons.csv", "comparisons.txt"}
