"""Intervals for medians and shares, and ranks: exact at any number of repeats, nothing drawn at random.

Median. Of n independent values the i-th smallest and the i-th largest hold the true median between them with the chance

  1 - 2 P(B <= i - 1),   B ~ Binomial(n, 1/2)

for every continuous distribution; where values can be equal, with at least that. Taken is the greatest i that keeps 95%. Below 6
values there is none: the least and the greatest are shown, with the chance that they have (5: 93.75%, 3: 75%). A bootstrap of the
median takes the same kind of ranks and a chance that it does not state: at n = 7 it holds 87.5% where it says 95%.

Share. Clopper and Pearson's interval of the share of which k among n were seen: it holds the true one in at least 95%.

Rank. If b and n others came from one distribution, at most k of them are at least as good as b with the chance (k + 1) / (n + 1):
the exact permutation test of one against n. Over several strata (meshes) the counts are added up; the chance of their sum is
counted out.
"""

import functools
import itertools
import math
from dataclasses import dataclass

LEVEL = 0.95
MOST_COUNTED = 2000  # values whose ranks are counted out in whole numbers: these have as many bits


@dataclass(frozen=True)
class Interval:
    """Of a median: from the `first` to the `last` of n ordered values, and the chance that it holds the true one."""

    low: float
    high: float
    coverage: float
    first: int
    last: int
    n: int

    @property
    def keeps_level(self):
        return self.coverage >= LEVEL

    @property
    def kind(self):
        """"order statistics, 2nd to 8th of 9"."""
        return f"order statistics, {ordinal(self.first)} to {ordinal(self.last)} of {self.n}"


def ordinal(number):
    if number % 100 in (11, 12, 13):
        return f"{number}th"
    return f"{number}{ {1: 'st', 2: 'nd', 3: 'rd'}.get(number % 10, 'th') }"


def count_ranks(n, level):
    """median_ranks, counted out in whole numbers."""
    below, ways, rank, coverage = 0, 1, 1, 1 - 2 / 2**n
    all_ways = 2**n
    for candidate in range(1, n // 2 + 1):
        below += ways
        chance = 1 - 2 * below / all_ways
        if chance < level and candidate > 1:
            break
        rank, coverage = candidate, chance
        ways = ways * (n - candidate + 1) // candidate
    return rank, coverage


def sum_ranks(n, level):
    """median_ranks of many values, from logarithms: the chance to 1e-8. Ranks 20 standard deviations below the middle have none."""
    first = max(1, math.ceil(n / 2 - 10 * math.sqrt(n)))
    below, rank, coverage = 0.0, first, 1.0
    for candidate in range(first, n // 2 + 1):
        below += math.exp(math.lgamma(n + 1) - math.lgamma(candidate) - math.lgamma(n - candidate + 2) - n * math.log(2))
        chance = 1 - 2 * below
        if chance < level:
            break
        rank, coverage = candidate, chance
    return rank, coverage


@functools.cache
def median_ranks(n, level=LEVEL):
    """The rank of the lower end (1 is the least) and the chance to hold the median, for n values."""
    return count_ranks(n, level) if n <= MOST_COUNTED else sum_ranks(n, level)


def median_interval(values, level=LEVEL):
    """The interval of the median; None for fewer than 2 values."""
    n = len(values)
    if n < 2:
        return None
    ordered = sorted(values)
    rank, coverage = median_ranks(n, level)
    return Interval(ordered[rank - 1], ordered[n - rank], coverage, rank, n + 1 - rank, n)


def span_of(values):
    """Between what the median of the values lies, with 95%: a point if they all agree, everything if too few of them differ."""
    if len(set(values)) == 1:
        return values[0], values[0]
    interval = median_interval(values)
    return (interval.low, interval.high) if interval and interval.keeps_level else (-math.inf, math.inf)


def percent(coverage):
    """"96.1%" of a chance; rounded down, so that 94.99% does not pass for 95%."""
    return f"{math.floor(1000 * coverage) / 10:.1f}%"


def at_most(k, n, share):
    """P(B <= k), B ~ Binomial(n, share), 0 < share < 1."""
    chances = (math.lgamma(n + 1) - math.lgamma(i + 1) - math.lgamma(n - i + 1) + i * math.log(share) + (n - i) * math.log1p(-share)
               for i in range(k + 1))
    return math.fsum(math.exp(chance) for chance in chances)


def is_share_above(k, n, bound, level=LEVEL):
    """Whether the lower end of `share_interval` is above the bound: k or more of n would be too rare if the share were that."""
    return k > 0 and 1 - at_most(k - 1, n, bound) < (1 - level) / 2


def solve(function):
    """Where a function that falls from above 0 to below 0 on [0, 1] is 0, by halving."""
    low, high = 0.0, 1.0
    for _ in range(60):
        middle = (low + high) / 2
        low, high = (middle, high) if function(middle) > 0 else (low, middle)
    return low


def share_interval(k, n, level=LEVEL):
    """Clopper and Pearson's interval of a share: low and high; (0, 1) of nothing."""
    tail = (1 - level) / 2
    low = 0.0 if k == 0 else solve(lambda share: tail - (1 - at_most(k - 1, n, share)))
    high = 1.0 if k == n else solve(lambda share: at_most(k, n, share) - tail)
    return low, high


def rank_chance(counts):
    """The chance that of the others no more are at least as good, if nothing tells the one from the others.

    `counts` is a list of (k, n), one each stratum: k of n others are at least as good. One stratum: (k + 1) / (n + 1).
    """
    ways, total, seen = [1], 1, 0
    for k, n in counts:
        sums = [0, *itertools.accumulate(ways)]  # a place is reached from those up to n before it
        last = len(ways)
        grown = [sums[min(place + 1, last)] - sums[max(0, place - n)] for place in range(last + n)]
        ways, total, seen = grown, total * (n + 1), seen + k
    return sum(ways[: seen + 1]) / total
