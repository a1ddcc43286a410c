"""Holds one label of a plan against the best of others: its key `comparisons`, on each mesh and at each point of the sweep.

With x the figure of the label `of` and b the best figure of its peers (`against_best_of`), each a median over the accepted
answers, and "better" the side that the measure has:

  no lower   x is b or better (for a measure where less is better: no higher)
  short      x is worse than b, by the difference shown
  open       the figures scatter by more than the difference: the 95% intervals of the medians (intervals.py) leave both possible,
             or there are too few values for such an interval

A peer counts if its answer is accepted and its tetrahedra are within the plan's `equal_count` of those of `of` (not of the
count asked for: two answers can lie on either side of that). A peer that does not count is named with the reason, and with the
measures in which it is better at its count. Up to the share `input_up_to_ratio` of removed tetrahedra the input is a peer too,
whatever its count; it cannot stand for the others where none of them counts. A measure that `of` or all peers lack cannot be
decided. With `equal_distance: true` a peer counts only where its skin strays no farther from the input's than that of `of`
(surface_distance_upper); the others are left out with their distance.

The time ratio is the median over rounds of kernel(`time_against`) / kernel(`of`), the two of one round taken together (of a label
with seeds its median over them), with the interval of that median. If the comparison has a `time_factor`, the whole interval is to
be at least that: below it the ratio is short, across it open. Without a factor the ratio is only shown, and so are those of the
other peers that count, each alone.

Being no worse than the best of many is hard; what each peer alone and each measure alone comes to is in standings.py.

A comparison with `required: true` holds if no finding of it is short, open or cannot be decided; the exit code says so.
"""

import math
from dataclasses import dataclass, field

from shared import intervals
from shared.equal_count import is_equal, tets_of, tolerance_of
from shared.intervals import median_interval, percent
from shared.measure_text import MET, OPEN, SCATTERS, SHORT, SHOWN, TITLES, amount
from shared.records import figure, median, present
from shared.tables import align, outcome_text, write_atomically, write_csv
from simplify.contest import short_sweep
from simplify.equal_distance import stray_text, strays_farther
from simplify.standings import standings_text

COLUMNS_A_TABLE = 5  # so that a table stays within some 100 columns


@dataclass
class Comparison:
    of: str
    peers: list
    measures: list
    time_against: str = ""
    time_factor: object = None
    input_up_to_ratio: float = -1.0
    required: bool = False
    equal_distance: bool = False

    @property
    def timed(self):
        """The labels whose times are shown: `time_against`, whose ratio a factor judges, then the other peers."""
        return list(dict.fromkeys([self.time_against, *self.peers])) if self.time_against else []


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
    interval: object = None  # of a time ratio
    by_peer: dict = field(default_factory=dict)  # label: verdict against that peer alone


@dataclass
class Row:
    """All findings of one comparison on one mesh at one point of the sweep."""

    comparison: Comparison
    mesh: str
    sweep: str
    own_tets: object
    findings: list
    left_out: list = field(default_factory=list)  # "label (reason)"

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
                                -1.0 if ratio is None else ratio, entry.get("required") is True, entry.get("equal_distance") is True))
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


def round_times(group):
    """The time of each round of repeats, by its number: of a label with seeds, the median over them."""
    rounds = {}
    for record in group.accepted() if group else []:
        if figure(record, "kernel_s"):
            rounds.setdefault(record.get("repeat"), []).append(record["kernel_s"])
    return {number: median(times) for number, times in rounds.items()}


def span_of(group, measure):
    """Between what the median of a figure lies (intervals.span_of): over the different answers, of times over the rounds."""
    judged = group.figures("judge", measure)
    if measure == "kernel_s":
        return intervals.span_of(list(round_times(group).values()))
    return intervals.span_of(judged or present(figure(record, measure) for record in group.accepted()))


def better_in(run, comparison, mesh, sweep, group):
    """In which measures a peer at another count is better than `of`: that is said even where it does not count."""
    own = find_group(run, mesh, sweep, comparison.of)
    better = []
    for measure in comparison.measures:
        verdict, *_ = decide(value_of(own, measure) if own else None, [("", value_of(group, measure))], sign_of(run, measure))
        better += [TITLES.get(measure, measure)] if verdict == SHORT else []
    return f", better in {', '.join(better)}" if better else ""


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
            left_out.append(f"{label} ({tets_of(group):,.0f} tets{better_in(run, comparison, mesh, sweep, group)})")
        elif comparison.equal_distance and strays_farther(group, find_group(run, mesh, sweep, comparison.of)):
            left_out.append(f"{label} ({stray_text(group)})")
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


def scatter_text(own, peers, sign):
    """Why the scatter of the figures leaves open who is better; "" if it does not. All are given by their spans."""
    low, high = own
    margins = [(low - greatest, high - least) if sign > 0 else (least - high, greatest - low) for least, greatest in peers]
    if not margins or all(below >= 0 for below, _ in margins) or any(above < 0 for _, above in margins):
        return ""
    if any(math.isinf(below) for below, _ in margins):
        return "too few values for a 95% interval"
    return "the figures scatter by more than the difference"


def time_finding(run, comparison, mesh, sweep, own, label):
    """The finding on the time of `label` over that of `own`."""
    other = find_group(run, mesh, sweep, label)
    own_times, other_times = round_times(own), round_times(other)
    ratios = [other_times[key] / own_times[key] for key in own_times if key in other_times]
    if not ratios:
        missing = label if own_times else comparison.of
        return Finding("time", OPEN, best_label=label, reason=f"no accepted time of {missing}")
    ratio, interval = median(ratios), median_interval(ratios)
    factor = comparison.time_factor if label == comparison.time_against else None
    if factor is None:
        return Finding("time", SHOWN, ratio, best_label=label, interval=interval)
    finding = Finding("time", SCATTERS, ratio, factor, label, ratio - factor, interval=interval)
    if interval is None or not interval.keeps_level:
        finding.reason = f"{len(ratios)} rounds are too few for a 95% interval"
    elif interval.low >= factor or interval.high < factor:
        finding.verdict = MET if interval.low >= factor else SHORT
    else:
        finding.reason = f"the interval of the time ratio, {interval_text(interval)}, holds {factor:g}"
    return finding


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
        if verdict == MET and not peers:
            verdict = OPEN  # no worse than the input alone
        reason = ""
        if verdict == OPEN:
            reason = why_open(comparison, own, value, peers)
        else:
            spans = {label: span_of(group, measure) for label, group in peers}
            spans = [spans.get(label, (value, value)) for label, value in values if value is not None]
            reason = scatter_text(span_of(own, measure), spans, sign_of(run, measure))
            verdict = SCATTERS if reason else verdict
        alone = {peer: decide(value, [(peer, theirs)], sign_of(run, measure))[0] for peer, theirs in values if peer != "input"}
        findings.append(Finding(measure, verdict, value, best, label, margin, reason, by_peer=alone))
    counted = [label for label, _ in peers]
    findings += [time_finding(run, comparison, mesh, sweep, own, label) for label in comparison.timed
                 if label == comparison.time_against or label in counted]
    return Row(comparison, mesh, sweep, own_tets, findings, left_out)


def compare_all(run):
    """Rows of all comparisons, on every mesh and at every point of the sweep at which `of` was run."""
    rows = []
    for comparison in read_comparisons(run.plan_data):
        for mesh in run.meshes():
            for group in run.find(mesh, comparison.of):
                rows.append(compare(run, comparison, mesh, group.sweep))
    return rows


# --- In words -----------------------------------------------------------------------------------------------------------


def interval_text(interval):
    return "" if interval is None else f"[{interval.low:.3g}, {interval.high:.3g}]"


def cell(finding):
    if finding.verdict == OPEN:
        return "?"
    mark = {SHORT: " SHORT", SCATTERS: " OPEN"}.get(finding.verdict, "")
    if finding.measure == "time":
        return f"{finding.own:.3g}x {interval_text(finding.interval)}".rstrip() + mark
    text = amount(finding.measure, finding.margin)
    return (f"+{text}" if finding.margin > 0 else text if finding.margin else "0") + mark


def comparison_table(rows):
    """Margins of `of` over the best peer, one line a mesh and point of the sweep; folded where there are many measures."""
    comparison = rows[0].comparison
    cells = {}  # by row and title
    for row in rows:
        for finding in row.findings:
            title = TITLES.get(finding.measure, finding.measure)
            if finding.measure == "time":
                title = f"time, {finding.best_label}" if len(comparison.peers) > 1 else "time ratio"
            cells[id(row), title] = cell(finding)
    titles = list(dict.fromkeys(title for _, title in cells))
    blocks = []
    for start in range(0, len(titles), COLUMNS_A_TABLE):
        part = titles[start:start + COLUMNS_A_TABLE]
        is_last = start + COLUMNS_A_TABLE >= len(titles)
        lines = [[row.mesh, short_sweep(row.sweep), "" if row.own_tets is None else f"{row.own_tets:,.0f}",
                  *(cells.get((id(row), title), "") for title in part), *([row.met_text] if is_last else [])] for row in rows]
        blocks.append(align(["mesh", "", "tets", *part, *(["met"] if is_last else [])], lines))
    return "\n\n".join(blocks)


def shortfall_lines(row, with_shortfalls):
    """A line for each finding that is short or cannot be decided, and one for peers that were left out."""
    comparison = row.comparison
    place = ", ".join(text for text in (row.mesh, short_sweep(row.sweep)) if text)
    undecided = {}
    for finding in row.findings:
        title = TITLES.get(finding.measure, finding.measure)
        if finding.measure == "time" and len(comparison.peers) > 1:
            title += f" against {finding.best_label}"
        if finding.verdict in (OPEN, SCATTERS):
            undecided.setdefault((finding.verdict, finding.reason), []).append(title)
        elif finding.verdict != SHORT or not with_shortfalls:
            continue
        elif finding.measure == "time":
            yield (f"{place}: {finding.own:.2f} times as fast as {finding.best_label}, "
                   f"{comparison.time_factor:g} times is asked for.")
        else:
            yield (f"{place}: {title} {amount(finding.measure, finding.own)}, short of "
                   f"{finding.best_label} ({amount(finding.measure, finding.best)}) by "
                   f"{amount(finding.measure, -finding.margin)}.")
    for (verdict, reason), titles in undecided.items():
        yield f"{place}: {', '.join(titles)} {verdict}: {reason}."
    if row.left_out:
        yield f"{place}: left out: {', '.join(row.left_out)}."


def peers_text(comparison):
    text = ("the best of " if len(comparison.peers) > 1 else "") + ", ".join(comparison.peers)
    return text + (" that stray no farther" if comparison.equal_distance else "")


def summary_line(rows):
    comparison = rows[0].comparison
    figures = [finding for row in rows for finding in row.findings if finding.measure != "time"]
    times = [finding for row in rows for finding in row.findings if finding.measure == "time" and finding.verdict != SHOWN]
    met = lambda findings: sum(finding.verdict == MET for finding in findings)
    text = f"{comparison.of}: {met(figures)} of {len(figures)} figures no worse than {peers_text(comparison)}"
    if times and comparison.time_factor is not None:
        text += f"; at least {comparison.time_factor:g} times as fast as {comparison.time_against} in {met(times)} of {len(times)}"
    for verdict in (SCATTERS, OPEN):
        count = sum(finding.verdict == verdict for finding in [*figures, *times])
        text += f"; {count} {verdict}" if count else ""
    return text + "."


def time_line(rows):
    """What the brackets behind the time ratios are; None without any."""
    kinds = {(f.interval.kind, percent(f.interval.coverage)) for row in rows for f in row.findings if f.interval}
    if not kinds:
        return None
    return "Time ratio: median over rounds [its interval: " + "; ".join(
        f"{kind} rounds, covers {covers}" for kind, covers in sorted(kinds)) + "]."


def failed_requirements(run, rows):
    """A sentence for each comparison with `required: true` that does not hold."""
    for comparison in [entry for entry in read_comparisons(run.plan_data) if entry.required]:
        own = [row for row in rows if row.comparison == comparison]
        bad = [finding for row in own for finding in row.findings if finding.verdict not in (MET, SHOWN)]
        if bad or not own:
            counts = [f"{count} {verdict}" for verdict in (SHORT, SCATTERS, OPEN)
                      if (count := sum(finding.verdict == verdict for finding in bad))]
            yield f"the comparison of {comparison.of} with {peers_text(comparison)}: {', '.join(counts) or 'it was not run'}"


def comparisons_text(run, rows, with_shortfalls=True):
    """The tables; below each every shortfall with both figures, or only what was left out or cannot be decided."""
    blocks = []
    for comparison in dict.fromkeys(map(id, (row.comparison for row in rows))):
        own = [row for row in rows if id(row.comparison) == comparison]
        plan = own[0].comparison
        title = (f"{plan.of} against {peers_text(plan)}, counts within {100 * tolerance_of(run):g}%: "
                 f"by how much it is better (+), SHORT or OPEN")
        if plan.input_up_to_ratio >= 0:
            title += f"; up to {100 * plan.input_up_to_ratio:g}% removed the input is a peer too"
        lines = [line for row in own for line in shortfall_lines(row, with_shortfalls)]
        lines += [line for line in [time_line(own)] if line]
        parts = [title, "", comparison_table(own), "", *lines, summary_line(own)]
        if len(plan.peers) > 1 or len(own) > 1:
            parts += ["", standings_text(own)]
        blocks.append("\n".join(parts))
    return "\n\n".join(blocks)


def write_comparisons(run, rows, folder):
    """Writes comparisons.csv and comparisons.txt; returns their names."""
    lines = []
    for row in rows:
        for finding in row.findings:
            interval = finding.interval
            lines.append([row.mesh, row.sweep, row.comparison.of, row.own_tets, finding.measure, finding.own, finding.best,
                          finding.best_label, finding.margin, finding.verdict, finding.reason, "; ".join(row.left_out),
                          *((interval.low, interval.high, interval.coverage, interval.n) if interval else [None] * 4)])
    write_csv(folder / "comparisons.csv",
              ["mesh", "sweep", "of", "tets", "measure", "value", "best_of_peers", "best_label", "margin", "verdict", "reason",
               "left_out", "ratio_low", "ratio_high", "ratio_covers", "rounds"], lines)
    write_atomically(folder / "comparisons.txt", comparisons_text(run, rows) + "\n")
    return {"comparisons.csv", "comparisons.txt"}
