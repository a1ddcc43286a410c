"""Runs held against a first one, for a page of their own."""

from compare.comparison_text import LEGEND, figure_text, verdict
from compare.pairs import medians_of
from shared.page_parts import BAD, GOOD, OPEN, PLAIN, Axis, Chart, Column, Note, PageParts, Section, Table


def name_of(side):
    """The folder and the one above it: a plan's runs have the same names."""
    return f"{side.place.resolve().parent.name}/{side.place.resolve().name}"


def sentence_of(comparisons):
    """The largest change beyond doubt, and how many there are."""
    pairs = [(pair, result.measure, comparison) for comparison in comparisons for result in comparison.results for pair in result.ratios()]
    sure = [each for each in pairs if verdict(each[0], each[1]) and not verdict(each[0], each[1]).endswith("?")]
    runs = f"{len(comparisons)} run{'s' if len(comparisons) > 1 else ''}"
    if not pairs:
        return f"Nothing of the {runs} can be compared with the first.", PLAIN
    decided = sum(pair.bounds is not None for pair, _, _ in pairs)
    if not sure:
        state = GOOD if decided == len(pairs) else OPEN
        return f"Of {len(pairs)} figures of {runs} none differs from the first run's beyond doubt; {decided} have repeats enough to be decided.", state
    pair, measure, comparison = max(sure, key=lambda each: each[0].change)
    worse = any(verdict(each, own) == "slower" for each, own, _ in sure)
    return (f"Of {len(pairs)} figures of {runs} {len(sure)} differ from the first run's beyond doubt; most of all {measure.name} of {pair.case}, {pair.ratio:.3g} times "
            f"in {name_of(comparison.b)}.", BAD if worse else PLAIN)


def ratio_rows(comparisons, measure):
    for comparison in comparisons:
        for result in comparison.results:
            for pair in result.ratios() if result.measure.name == measure else ():
                low, high = pair.bounds or (None, None)
                below, above = medians_of(pair)
                yield {"case_name": pair.case, "run": name_of(comparison.b), "ratio": pair.ratio, "ratio_low": low, "ratio_high": high, "a": figure_text(below, result.measure.unit),
                       "b": figure_text(above, result.measure.unit), "p": None if pair.is_exact else pair.test.p, "word": verdict(pair, result.measure), "hollow": not pair.differs,
                       "case": pair.case}


def ratio_charts(comparisons):
    measures = dict.fromkeys(result.measure.name for comparison in comparisons for result in comparison.results if result.pairs)
    for measure in measures:
        rows = list(ratio_rows(comparisons, measure))
        if rows:
            yield Chart(f"{measure}: over the first run's", "ranges", Axis("ratio", "ratio of medians", "", True), Axis("case_name", "case"), rows, series="run", facet="run",
                        shown=[Axis("a", "first run"), Axis("b", "this run"), Axis("p", "p"), Axis("word", "verdict")], marks=[{"value": 1.0, "title": "the same"}],
                        note="Filled: the interval of the ratio leaves 1 out.")


def tables_of(comparisons):
    columns = [Column("run"), Column("measure"), Column("case"), Column("repeats"), Column("first run"), Column("this run"), Column("ratio"), Column("at least"), Column("at most"),
               Column("p", digits=2), Column("p, Holm", digits=2), Column("verdict")]
    rows, left = [], []
    for comparison in comparisons:
        for result in comparison.results:
            for pair in result.pairs:
                low, high = pair.bounds or (None, None)
                below, above = medians_of(pair)
                rows.append([name_of(comparison.b), result.measure.name, pair.case, f"{len(pair.a)}, {len(pair.b)}", figure_text(below, result.measure.unit),
                             figure_text(above, result.measure.unit), pair.ratio, low, high, None if pair.is_exact else pair.test.p, None if pair.is_exact else pair.p_holm,
                             verdict(pair, result.measure)])
            left += [[name_of(comparison.b), result.measure.name, name, why] for name, why in result.left_out.items()]
        left += [[name_of(comparison.b), "", name, "in the first run alone"] for name in comparison.only_in_a]
        left += [[name_of(comparison.b), "", name, "not in the first run"] for name in comparison.only_in_b]
        left += [[name_of(comparison.b), "", name, why] for name, why in comparison.changed.items()]
    differences = [[name_of(comparison.b), *map(str, difference)] for comparison in comparisons for difference in comparison.differences]
    return [Table("Figures, most changed first", columns, rows, note=LEGEND),
            Table("What differs between the runs", [Column("run"), Column("what"), Column("in the first"), Column("in this one")], differences),
            Table("What is not compared, and why", [Column("run"), Column("measure"), Column("case"), Column("why")], left),
            Table("The runs", [Column("run"), Column("commit"), Column("load")], side_rows(comparisons))]


def side_rows(comparisons):
    sides = [comparisons[0].a, *(comparison.b for comparison in comparisons)]
    return [[name_of(side), str(side.facts.get("commit", "")), side.load] for side in sides]


def page_parts(comparisons):
    """Of a first run with each of the others; each of `comparisons` has it as A."""
    sentence, state = sentence_of(comparisons)
    warnings = [Note(f"{name_of(comparison.b)}: {text}") for comparison in comparisons for text in comparison.warnings]
    tables = [table for table in tables_of(comparisons) if table.rows]
    return PageParts(sentence, state, [Section("", list(ratio_charts(comparisons))), Section("", [*tables, *warnings])])
