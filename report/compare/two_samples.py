"""Two samples against each other, whatever their distribution: Mann and Whitney's test, and the interval of a ratio that goes with it.

Test. U counts the pairs (a, b) with b > a, ties half. If both samples came from one continuous distribution, all (m + n)! / (m! n!) ways
to deal the ranks are equally likely; the ways that give U = u are the coefficients of the Gaussian binomial

  prod_{i = 1..m} (1 - q^(n + i)) / (1 - q^i),

so that p = min(1, 2 P(U <= min(u, m n - u))) is exact. With ties, or many values, U is taken as normal with mean m n / 2 and variance
m n / 12 ((N + 1) - sum (t^3 - t) / (N (N - 1))), N = m + n, t the number of values in a tie, half a step towards the mean.

Interval of the ratio r. If B's values are distributed as r times A's, the test of A r against B rejects the true r with the chance that it says.
The r that it does not reject lie between the k-th smallest and the k-th largest of the m n ratios b / a, and

  coverage = 1 - 2 P(U <= k - 1)

is exact for every continuous distribution, at any m and n. Taken is the greatest k that keeps the level; where even k = 1 does not (3 and 3:
90%), that one, with the chance that it has. (Moses 1965; Hodges and Lehmann 1963, of the logarithms.) It is no interval of the ratio of medians
where the samples differ in more than a factor; `order_statistics` is, and pays for it with its width: the ends of both medians' intervals
crossed, each at 97.5%, hold it together in at least the product of their chances.
"""

import functools
import math
from dataclasses import dataclass

from shared.intervals import LEVEL, median_interval
from shared.records import median

MOST_EXACT = 10_000  # pairs: beyond them the normal distribution is as good


@dataclass(frozen=True)
class RankTest:
    u: float
    p: float
    method: str  # "exact", or "normal" (ties, or many values)


@dataclass(frozen=True)
class Ratio:
    """Of a quantity of B over that of A."""

    low: float
    high: float
    coverage: float  # that is stated; at least that, for `order_statistics`

    @property
    def keeps_level(self):
        return self.coverage >= LEVEL


@functools.lru_cache(maxsize=256)
def rank_counts(m, n):
    """In how many ways U is 0, 1, ..., m n."""
    counts = [1] + [0] * (m * n)
    for i in range(1, m + 1):
        for u in range(m * n, n + i - 1, -1):
            counts[u] -= counts[u - n - i]
        for u in range(i, m * n + 1):
            counts[u] += counts[u - i]
    return tuple(counts)


@functools.lru_cache(maxsize=256)
def rank_chances(m, n):
    """P(U <= u) for u = 0, 1, ..., m n."""
    total, below, chances = math.comb(m + n, m), 0, []
    for count in rank_counts(m, n):
        below += count
        chances.append(below / total)
    return chances


def count_above(a, b):
    """U: pairs with b > a, ties half."""
    return sum((y > x) + 0.5 * (y == x) for x in a for y in b)


def tie_sizes(values):
    sizes = {}
    for value in values:
        sizes[value] = sizes.get(value, 0) + 1
    return [size for size in sizes.values() if size > 1]


def normal_tail(z):
    """P(|Z| >= z) of a standard normal Z, z >= 0."""
    return math.erfc(z / math.sqrt(2))


def mann_whitney(a, b):
    """The two-sided test of whether b's values are above or below a's. Needs one value each."""
    m, n = len(a), len(b)
    u = count_above(a, b)
    ties = tie_sizes([*a, *b])
    if not ties and m * n <= MOST_EXACT:
        return RankTest(u, min(1.0, 2 * rank_chances(m, n)[int(min(u, m * n - u))]), "exact")
    total = m + n
    variance = m * n / 12 * ((total + 1) - sum(t**3 - t for t in ties) / (total * (total - 1)))
    if variance <= 0:  # one value throughout
        return RankTest(u, 1.0, "normal")
    return RankTest(u, min(1.0, normal_tail(max(0.0, abs(u - m * n / 2) - 0.5) / math.sqrt(variance))), "normal")


def critical_rank(m, n, level=LEVEL):
    """k as above, and the chance to hold the true ratio."""
    if m * n <= MOST_EXACT:
        chances = rank_chances(m, n)
        k = 1
        while k < m * n // 2 and 1 - 2 * chances[k] >= level:
            k += 1
        return k, 1 - 2 * chances[k - 1]
    spread = math.sqrt(m * n * (m + n + 1) / 12)
    tail = lambda k: normal_tail((m * n / 2 - (k - 1) - 0.5) / spread)  # of both sides, at U <= k - 1
    low, high = 1, m * n // 2
    while low < high:
        middle = (low + high + 1) // 2
        low, high = (middle, high) if tail(middle) <= 1 - level else (low, middle - 1)
    return low, 1 - tail(low)


def ratio_interval(a, b, level=LEVEL):
    """The interval of the ratio of B to A; None for values that are not positive, or one value each."""
    if min(*a, *b) <= 0 or len(a) * len(b) < 2:
        return None
    k, coverage = critical_rank(len(a), len(b), level)
    ratios = sorted(y / x for x in a for y in b)
    return Ratio(ratios[k - 1], ratios[-k], coverage)


def order_statistics(a, b, level=LEVEL):
    """An interval of the ratio of the medians that asks nothing of how the samples' shapes compare; None as above."""
    each = (1 + level) / 2
    if min(*a, *b) <= 0 or min(len(a), len(b)) < 2:
        return None
    of_a, of_b = median_interval(a, each), median_interval(b, each)
    return Ratio(of_b.low / of_a.high, of_b.high / of_a.low, of_a.coverage * of_b.coverage)


def median_ratio(a, b):
    """The ratio of the medians, or None where one is not positive."""
    below, above = median(a), median(b)
    return above / below if below > 0 and above > 0 else None


def holm(chances):
    """Holm's adjusted chances of several tests: those at most 0.05 differ, with 5% for a single wrong one among all of them."""
    order = sorted(range(len(chances)), key=lambda i: chances[i])
    adjusted, most = [0.0] * len(chances), 0.0
    for place, i in enumerate(order):
        most = max(most, min(1.0, (len(chances) - place) * chances[i]))
        adjusted[i] = most
    return adjusted
