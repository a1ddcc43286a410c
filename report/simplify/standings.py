"""What the rows of one comparison (comparisons.py) come to: against each peer alone, and measure by measure.

Against one peer, the figures are those of the meshes and points at which that peer counts. Measure by measure, the peers are the
best of all again: how many figures are no worse, the median margin, and the worst one with who has it and where. Both go by
medians; what scatters by more than its margin is said in the comparison itself.
"""

from shared.measure_text import MET, OPEN, SCATTERS, SHORT, TITLES, amount
from shared.records import median
from shared.tables import align
from simplify.contest import short_sweep


def times_against(rows, label):
    return [finding.own for row in rows for finding in row.findings
            if finding.measure == "time" and finding.best_label == label and finding.own is not None]


def peer_lines(rows):
    """A line for each peer: figures no worse than its own, and its time over that of `of`."""
    comparison = rows[0].comparison
    for label in dict.fromkeys([*comparison.peers, *comparison.timed]):
        verdicts = [finding.by_peer[label] for row in rows for finding in row.findings if label in finding.by_peer]
        decided = [verdict for verdict in verdicts if verdict != OPEN]
        met = sum(verdict == MET for verdict in decided)
        times = times_against(rows, label)
        yield [label, str(met) if decided else "", str(len(decided) - met) if decided else "", str(len(decided) or ""),
               f"{median(times):.3g}" if times else "", f"{min(times):.3g}" if times else "", f"{max(times):.3g}" if times else ""]


def measure_lines(rows):
    """A line for each measure against the best of all peers."""
    for i, measure in enumerate(rows[0].comparison.measures):
        decided = [(row, row.findings[i]) for row in rows if row.findings[i].verdict in (MET, SHORT, SCATTERS)]
        if not decided:
            continue
        row, worst = min(decided, key=lambda pair: pair[1].margin)
        met = sum(finding.margin >= 0 for _, finding in decided)
        where = ", ".join(text for text in (worst.best_label, row.mesh, short_sweep(row.sweep)) if text)
        yield [TITLES.get(measure, measure), str(met), str(len(decided) - met), signed(measure, median([f.margin for _, f in decided])),
               signed(measure, worst.margin), where]


def signed(measure, margin):
    return f"+{amount(measure, margin)}" if margin > 0 else amount(measure, margin)


def standings_text(rows):
    """Both tables."""
    of = rows[0].comparison.of
    peers = align([f"{of} against", "no worse", "worse", "of", "time ratio", "least", "most"], list(peer_lines(rows)))
    measures = list(measure_lines(rows))
    if not measures:
        return peers
    return f"{peers}\n\n" + align(["against the best of them", "no worse", "worse", "median margin", "worst margin", "there best, where"],
                                  measures)
