"""Pairs the cases of two sides, and works out what is said of them."""

import math
from dataclasses import dataclass, field

from compare import two_samples
from shared.intervals import LEVEL
from shared.records import BadRun, median

ENOUGH_REPEATS = 9  # at fewer a single slow repeat moves an end of the interval far
LEAST_REPEATS = 4  # of each side, for an interval of 95%
LEVEL_OF_TESTS = 0.05


@dataclass
class Pair:
    """One measure of a case in both."""

    case: str
    a: list
    b: list
    ratio: float  # of the medians; None where one is not positive
    interval: two_samples.Ratio  # or None
    order_statistics: two_samples.Ratio  # or None
    test: two_samples.RankTest
    is_clock: bool
    p_holm: float = 1.0

    @property
    def is_exact(self):
        """Whether all values of each side are the same: there is no scatter, and the ratio is what it is. One time is not that."""
        return len(set(self.a)) == 1 and len(set(self.b)) == 1 and not (self.is_clock and min(len(self.a), len(self.b)) < LEAST_REPEATS)

    @property
    def bounds(self):
        """Between what the ratio lies, as far as 95% can be had; None if it cannot."""
        if self.ratio is not None and self.is_exact:
            return self.ratio, self.ratio
        return (self.interval.low, self.interval.high) if self.interval and self.interval.keeps_level else None

    @property
    def differs(self):
        """Whether its interval leaves 1 out."""
        return self.bounds is not None and not self.bounds[0] <= 1 <= self.bounds[1]

    @property
    def change(self):
        return abs(math.log(self.ratio)) if self.ratio is not None else -1.0


@dataclass
class MeasureResult:
    measure: object
    pairs: list = field(default_factory=list)  # most changed first
    left_out: dict = field(default_factory=dict)  # case -> why its pair says nothing

    def ratios(self):
        return [pair for pair in self.pairs if pair.ratio is not None]

    @property
    def geometric_mean(self):
        found = self.ratios()
        return math.exp(math.fsum(math.log(pair.ratio) for pair in found) / len(found)) if found else None

    @property
    def tested(self):
        """Pairs with scatter: the others need no test."""
        return [pair for pair in self.pairs if not pair.is_exact]


@dataclass
class Comparison:
    a: object
    b: object
    differences: list  # (what, in A, in B)
    same: list  # what is the same
    only_in_a: list
    only_in_b: list
    changed: dict  # case -> what else is not the same there
    results: list
    warnings: list


def differences_of(a, b):
    """What the sides' facts differ in, entry by entry; and the names of those that are the same."""
    found, same = [], []
    for name, value in a.facts.items():
        other = b.facts.get(name)
        if value == other:
            same.append(name)
        elif isinstance(value, dict) and isinstance(other, dict):
            for key in dict.fromkeys([*value, *other]):
                if value.get(key) != other.get(key):
                    found.append((f"{name}: {key}", value.get(key, "none"), other.get(key, "none")))
        else:
            found.append((name, str(value), str(other)))
    return found, same


def why_incomparable(case_a, case_b, measure):
    """Why figures of a case say nothing about A and B; empty if they do."""
    for side, case in (("A", case_a), ("B", case_b)):
        if case.refused:
            return f"{side}: {case.refused}"
    if case_a.inputs != case_b.inputs:
        return "another input"
    one_each = len(case_a.answers) == 1 and len(case_b.answers) == 1
    if measure.is_clock and one_each and case_a.answers != case_b.answers:
        return f"another answer: {short_hash(case_a)} in A, {short_hash(case_b)} in B"
    for side, case in (("A", case_a), ("B", case_b)):
        if not case.values.get(measure.name):
            return f"{side}: no figure"
    return ""


def short_hash(case):
    return next(iter(case.answers)).removeprefix("xxh3:")[:8]


def build_pair(name, a, b, is_clock):
    return Pair(name, a, b, two_samples.median_ratio(a, b), two_samples.ratio_interval(a, b), two_samples.order_statistics(a, b),
                two_samples.mann_whitney(a, b), is_clock)


def compare_measure(a, b, names, measure):
    result = MeasureResult(measure)
    for name in names:
        why = why_incomparable(a.cases[name], b.cases[name], measure)
        if why:
            result.left_out[name] = why
        else:
            values = [side.cases[name].values[measure.name] for side in (a, b)]
            result.pairs.append(build_pair(name, *values, measure.is_clock))
    tested = result.tested
    for pair, adjusted in zip(tested, two_samples.holm([pair.test.p for pair in tested])):
        pair.p_holm = adjusted
    result.pairs.sort(key=lambda pair: -pair.change)
    return result


def changes_of(a, b, names):
    """What else differs in a case: options, or answers that differ from repeat to repeat."""
    changed = {}
    for name in names:
        case_a, case_b = a.cases[name], b.cases[name]
        said = []
        if case_a.options != case_b.options and case_a.options and case_b.options:
            said.append("other options")
        if len(case_a.answers) > 1 or len(case_b.answers) > 1:
            said.append(f"answers differ between repeats ({len(case_a.answers)} in A, {len(case_b.answers)} in B)")
        for side, case in (("A", case_a), ("B", case_b)):
            bad = sum(count for outcome, count in case.outcomes.items() if outcome != "accepted")
            if bad and not case.refused:
                said.append(f"{bad} repeats of {side} were not accepted, and are left out")
        if said:
            changed[name] = "; ".join(said)
    return changed


def warnings_of(results):
    said = []
    for result in results:
        few = [min(len(pair.a), len(pair.b)) for pair in result.pairs
               if not pair.is_exact and min(len(pair.a), len(pair.b)) < ENOUGH_REPEATS]
        if few:
            said.append(f"{result.measure.name}: fewer than {ENOUGH_REPEATS} repeats in {len(few)} of {len(result.pairs)} pairs (least {min(few)})")
        unkept = [pair for pair in result.pairs if pair.bounds is None]
        if unkept:
            said.append(f"{result.measure.name}: {len(unkept)} of {len(result.pairs)} pairs have no interval of {100 * LEVEL:.0f}% (it takes {LEAST_REPEATS} repeats each, and "
                        "positive figures): they decide nothing")
        shape = [pair for pair in result.pairs if pair.bounds and pair.ratio is not None and not pair.bounds[0] <= pair.ratio <= pair.bounds[1]]
        if shape:
            said.append(f"{result.measure.name}: the medians' ratio lies outside its interval in {len(shape)} pairs ({shape[0].case}): the samples differ in shape, "
                        "not by a factor; see order_statistics in --json")
    return said


def compare_sides(a, b, measures):
    """Throws BadRun if no case is in both, or none has a measure."""
    names = [name for name in a.cases if name in b.cases]
    if not names:
        raise BadRun(f"{a.place} and {b.place}: no case is in both (A has {len(a.cases)}: {first_of(a.cases)}; B has {len(b.cases)}: {first_of(b.cases)})")
    results = [compare_measure(a, b, names, measure) for measure in measures]
    for result in results:
        if not any(case.values.get(result.measure.name) for side in (a, b) for case in side.cases.values()):
            raise BadRun(f"{a.place} and {b.place}: no accepted repeat has a figure {result.measure.name}")
    differences, same = differences_of(a, b)
    return Comparison(a, b, differences, same, [name for name in a.cases if name not in b.cases], [name for name in b.cases if name not in a.cases],
                      changes_of(a, b, names), results, warnings_of(results))


def first_of(cases):
    return ", ".join(list(cases)[:3]) + (", ..." if len(cases) > 3 else "")


def pairs_above(comparison, bound):
    """(measure, pair) whose interval lies wholly above the bound."""
    return [(result.measure.name, pair) for result in comparison.results for pair in result.pairs if pair.bounds and pair.bounds[0] > bound]


def decided(comparison):
    """How many pairs of all can be decided by a bound, and how many there would be."""
    pairs = [pair for result in comparison.results for pair in result.pairs]
    left_out = sum(len(result.left_out) for result in comparison.results)
    return sum(1 for pair in pairs if pair.bounds), len(pairs) + left_out


def medians_of(pair):
    return median(pair.a), median(pair.b)
