"""A comparison as text of at most 80 columns, as far as its words allow, and as JSON."""

import re
import textwrap

from compare.pairs import LEVEL_OF_TESTS, decided, medians_of, pairs_above
from shared import load
from shared.intervals import percent

WIDTH = 80
NAME_WIDTH = 30  # a longer name has a line of its own
MOST_LISTED = 12
HASH = re.compile(r"\b(xxh3:[0-9a-f]{8})[0-9a-f]{24}\b")  # its first digits are enough for a reader


def figure_text(value, unit):
    """Four digits: "12.34 ms", "1.234 MiB", "0.9876"."""
    if unit == "s":
        for scale, name in ((1.0, "s"), (1e-3, "ms"), (1e-6, "us")):
            if abs(value) >= scale:
                return f"{value / scale:.4g} {name}"
        return f"{value / 1e-9:.4g} ns"
    if unit == "bytes":
        return f"{value / 2**20:.4g} MiB"
    return f"{value:.4g}{'' if unit in ('', '1') else ' ' + unit}"


def ratio_text(value):
    return "none" if value is None else f"{value:.3f}" if 0.1 <= value < 100 else f"{value:.3g}"


def chance_text(chance):
    return f"{chance:.1e}" if chance < 0.001 else f"{chance:.3f}"


def interval_text(pair):
    if pair.ratio is None:
        return ""
    if pair.is_exact:
        return "no scatter"
    if pair.interval is None:
        return "none"
    text = f"[{ratio_text(pair.interval.low)}, {ratio_text(pair.interval.high)}]"
    return text if pair.interval.keeps_level else f"{text} {percent(pair.interval.coverage)}"


def verdict(pair, measure):
    """"slower" beyond doubt, "slower?" by its own interval alone; empty where 1 is inside."""
    if not pair.differs:
        return ""
    up, down = ("slower", "faster") if measure.is_clock and measure.unit == "s" else ("more", "less")
    word = up if pair.bounds[0] > 1 else down
    return word if pair.is_exact or pair.p_holm <= LEVEL_OF_TESTS else word + "?"


def pair_row(pair, measure):
    below, above = medians_of(pair)
    return [f"{len(pair.a)}, {len(pair.b)}", figure_text(below, measure.unit), figure_text(above, measure.unit), ratio_text(pair.ratio), interval_text(pair),
            "" if pair.is_exact else chance_text(pair.test.p), verdict(pair, measure)]


HEADER = ["repeats", "A", "B", "B / A", "interval", "p", ""]
IS_LEFT = [False, False, False, False, True, False, True]


def table_lines(result):
    rows = [pair_row(pair, result.measure) for pair in result.pairs]
    widths = [max(len(row[i]) for row in [HEADER, *rows]) for i in range(len(HEADER))]
    names = [pair.case for pair in result.pairs]
    room = min(max([len("case"), *(len(name) for name in names if len(name) <= NAME_WIDTH)]), WIDTH - sum(widths) - 2 * len(widths))
    room = max(room, len("case"))

    def line(name, cells):
        parts = [cell.ljust(width) if left else cell.rjust(width) for cell, width, left in zip(cells, widths, IS_LEFT)]
        return "  ".join([name.ljust(room), *parts]).rstrip()

    yield line("case", HEADER)
    yield line("-" * room, ["-" * width for width in widths])
    for name, row in zip(names, rows):
        if len(name) <= room:
            yield line(name, row)
        else:
            yield from wrapped(name, "")
            yield line("", row)


def listed(names):
    """The first of them, and how many more there are."""
    shown = list(names)[:MOST_LISTED]
    more = len(list(names)) - len(shown)
    return [*shown, *([f"and {more} more (--json has all)"] if more else [])]


def side_by_side(what, a, b):
    """"what: a | b", or two lines below it if that is too long."""
    a, b = (HASH.sub(r"\1", text) for text in (a, b))
    text = f"  {what}: {a} | {b}"
    return [text] if len(text) <= WIDTH else [f"  {what}:", *wrapped(f"A {a}", "    "), *wrapped(f"B {b}", "    ")]


def wrapped(text, indent="  "):
    return textwrap.wrap(text, WIDTH, initial_indent=indent, subsequent_indent=indent + "  ", break_long_words=True, break_on_hyphens=False)


def first_lines(comparison):
    """What has to be known before a figure is looked at."""
    yield from wrapped(f"A: {comparison.a.title}", "")
    yield from wrapped(f"B: {comparison.b.title}", "")
    yield ""
    yield "A and B differ in" if comparison.differences else "A and B are of one make and one machine"
    for what, a, b in comparison.differences:
        yield from side_by_side(what, a, b)
    if comparison.same and comparison.differences:
        yield from wrapped(f"same: {', '.join(comparison.same)}")
    yield from wrapped(f"load in A: {comparison.a.load}")
    yield from wrapped(f"load in B: {comparison.b.load}")
    for title, names in (("in A alone", comparison.only_in_a), ("in B alone", comparison.only_in_b)):
        if names:
            yield f"{title}, {len(names)} cases:"
            yield from (f"  {name}" for name in listed(names))
    if comparison.changed:
        yield f"not the same in A and B, {len(comparison.changed)} cases:"
        for line in listed([f"{name}: {why}" for name, why in comparison.changed.items()]):
            yield from wrapped(line)
    for note in [*(f"A: {note}" for note in comparison.a.notes), *(f"B: {note}" for note in comparison.b.notes), *comparison.warnings]:
        yield from wrapped(f"warning: {note}", "")


def summary_lines(result):
    tested, found = result.tested, result.ratios()
    if result.geometric_mean is not None and len(found) > 1:
        worst, best = max(found, key=lambda pair: pair.ratio), min(found, key=lambda pair: pair.ratio)
        yield from wrapped(f"geometric mean {ratio_text(result.geometric_mean)} of {len(found)} ratios; most {ratio_text(worst.ratio)} ({worst.case}), "
                           f"least {ratio_text(best.ratio)} ({best.case})", "")
    if tested:
        beyond = sum(1 for pair in tested if pair.p_holm <= LEVEL_OF_TESTS)
        alone = sum(1 for pair in tested if pair.test.p <= LEVEL_OF_TESTS)
        yield from wrapped(f"{alone} of {len(tested)} pairs have p <= {LEVEL_OF_TESTS:g}, where {LEVEL_OF_TESTS * len(tested):.1f} would by chance if nothing "
                           f"differed; {beyond} differ with {100 * LEVEL_OF_TESTS:.0f}% for one wrong among all (Holm)", "")


def measure_lines(result):
    unit = result.measure.unit
    yield f"{result.measure.name}, B over A, {len(result.pairs)} pairs, most changed first" if result.pairs else f"{result.measure.name}{f' ({unit})' if unit else ''}: no pair"
    if result.pairs:
        yield ""
        yield from table_lines(result)
        yield ""
        yield from summary_lines(result)
    if result.left_out:
        yield f"no comparison of {result.measure.name}, {len(result.left_out)} cases:"
        for line in listed([f"{name}: {why}" for name, why in result.left_out.items()]):
            yield from wrapped(line)


LEGEND = ("A, B: medians. Interval: 95% of the ratio, by Mann and Whitney's test, whose p stands beside it; another chance is said. "
          "A word says that 1 is outside; with \"?\", that chance may account for it among so many pairs (docs/compare.md).")


def bound_lines(comparison, bound):
    above = pairs_above(comparison, bound)
    known, total = decided(comparison)
    for name, pair in above:
        yield from wrapped(f"above {bound:g}: {name} of {pair.case}: {ratio_text(pair.ratio)}, at least {ratio_text(pair.bounds[0])}", "")
    if not above:
        yield f"no ratio is above {bound:g} beyond doubt ({known} of {total} pairs can be decided)"


def comparison_text(comparison, bound=None):
    lines = list(first_lines(comparison))
    for result in comparison.results:
        lines += ["", *measure_lines(result)]
    if any(result.pairs for result in comparison.results):
        lines += ["", *wrapped(LEGEND, "")]
    if bound is not None:
        lines += ["", *bound_lines(comparison, bound)]
    return "\n".join(lines)


# --- JSON ---------------------------------------------------------------------------------------------------------------


def ratio_json(ratio):
    return None if ratio is None else {"low": ratio.low, "high": ratio.high, "coverage": ratio.coverage}


def pair_json(pair, measure):
    below, above = medians_of(pair)
    return {"case": pair.case, "repeats_a": len(pair.a), "repeats_b": len(pair.b), "median_a": below, "median_b": above, "ratio": pair.ratio,
            "interval": ratio_json(pair.interval), "order_statistics": ratio_json(pair.order_statistics), "no_scatter": pair.is_exact,
            "u": pair.test.u, "p": pair.test.p, "method": pair.test.method, "p_holm": pair.p_holm, "differs": pair.differs,
            "verdict": verdict(pair, measure)}


def result_json(result):
    tested = result.tested
    return {"measure": result.measure.name, "unit": result.measure.unit, "geometric_mean": result.geometric_mean,
            "expected_by_chance": LEVEL_OF_TESTS * len(tested), "below_level": sum(1 for pair in tested if pair.test.p <= LEVEL_OF_TESTS),
            "below_level_holm": sum(1 for pair in tested if pair.p_holm <= LEVEL_OF_TESTS),
            "pairs": [pair_json(pair, result.measure) for pair in result.pairs],
            "no_comparison": [{"case": name, "why": why} for name, why in result.left_out.items()]}


def load_json(side):
    return {name: [{"load_1min": one.load_1min, "processor_s": one.processor_s, "others_s": one.others_s} for one in case.loads]
            for name, case in side.cases.items()}


def comparison_json(comparison, bound=None):
    sides = {key: {"place": str(side.place), "facts": side.facts, "load": side.load, "loads": load_json(side), "notes": side.notes}
             for key, side in (("a", comparison.a), ("b", comparison.b))}
    found = {"schema": "palpate/comparison/1", **sides,
             "differences": [{"what": what, "a": a, "b": b} for what, a, b in comparison.differences],
             "only_in_a": comparison.only_in_a, "only_in_b": comparison.only_in_b, "changed": comparison.changed,
             "warnings": comparison.warnings, "busy_share": load.BUSY, "measures": [result_json(result) for result in comparison.results]}
    if bound is not None:
        known, total = decided(comparison)
        found["fail_above"] = {"bound": bound, "decided": known, "pairs": total,
                               "above": [{"measure": name, "case": pair.case, "ratio": pair.ratio, "low": pair.bounds[0]} for name, pair in pairs_above(comparison, bound)]}
    return found
