"""Steps in a series: a level that changed and stayed.

A series is **exact** where nothing scatters: the figure comes from no clock, the repeats within each run agree, and it did not
change from most runs to the next. Every change of it beyond rounding (1e-6 of its size) is then a step, with two runs already.

Any other series **scatters**, and has to show more than its scatter. Let r_1 ... r_n be the ranks of its medians (middle ranks
where values are equal), with the mean m and the variance s^2. For a split after k runs

  z_k = |sum_{i <= k} (r_i - m)| / sqrt(s^2 k (n - k) / (n - 1)),   3 <= k <= n - 3

is how far the two sides lie apart, in standard deviations of a random order. The largest z_k is held against the largest of each of
9999 orders drawn at random (always the same ones): it is a step if at most 1% of them, itself counted, reach it. Then both sides are
searched in the same way (binary segmentation). In a series without a step one is found with a chance of 1%, whatever the
distribution, as long as its order means nothing: a slow drift is taken for steps. Fewer than 10 runs cannot tell.

Ranks: one run that went wrong moves them little. The statistic is Wilcoxon's rank sum at each split (Pettitt 1979, standardised).
"""

import functools
import math

import numpy as np

LEVEL = 0.01        # chance to find a step where there is none
PERMUTATIONS = 9999
LEAST_SIDE = 3      # runs on each side of a split
LEAST_RUNS = 10     # the rarest order of fewer is not rare enough for LEVEL
ROUNDING = 1e-6     # relative change that rounding may make: another processor, another libm
SEED = 20080


def differs(before, after):
    """Whether a figure changed by more than rounding."""
    return abs(after - before) > ROUNDING * max(abs(before), abs(after))


def is_exact(values, repeats_agree, measured_anew):
    """Whether a series does not scatter by itself. `repeats_agree`: within each run all repeats are equal; `measured_anew`: it
    comes from a clock or the system."""
    if measured_anew or not repeats_agree:
        return False
    changes = sum(differs(a, b) for a, b in zip(values, values[1:]))
    return len(values) < 4 or 2 * changes <= len(values) - 1


def middle_ranks(values):
    """Ranks from 1, equal values with the mean of theirs."""
    values = np.asarray(values, dtype=float)
    _, inverse, counts = np.unique(values, return_inverse=True, return_counts=True)
    last = np.cumsum(counts)
    return (last - (counts - 1) / 2)[inverse]


def split_statistics(ranks):
    """z_k of each row of `ranks`, for k = LEAST_SIDE ... n - LEAST_SIDE. Zero where all values are equal."""
    ranks = np.atleast_2d(ranks)
    n = ranks.shape[1]
    k = np.arange(LEAST_SIDE, n - LEAST_SIDE + 1)
    sums = np.abs(np.cumsum(ranks - ranks.mean(axis=1, keepdims=True), axis=1)[:, k - 1])
    variance = ranks.var(axis=1, keepdims=True) * k * (n - k) / (n - 1)
    return np.divide(sums, np.sqrt(variance), out=np.zeros_like(sums), where=variance > 0)


@functools.lru_cache(maxsize=512)
def random_maxima(ranks):
    """The largest z_k of PERMUTATIONS random orders of these (sorted) ranks, sorted. The same for the same ranks."""
    generator = np.random.default_rng(SEED)
    rows = np.tile(np.array(ranks), (PERMUTATIONS, 1))
    return np.sort(split_statistics(generator.permuted(rows, axis=1)).max(axis=1))


def best_split(values):
    """After how many values the series is best split, and the chance that a random order splits as well."""
    ranks = middle_ranks(values)
    statistics = split_statistics(ranks)[0]
    place = int(np.argmax(statistics))
    maxima = random_maxima(tuple(np.sort(ranks)))
    reached = len(maxima) - int(np.searchsorted(maxima, statistics[place] - 1e-9))
    return place + LEAST_SIDE, (1 + reached) / (1 + len(maxima))


def scattering_steps(values, level=LEVEL):
    """Places where a new level begins and the chance of each, in order."""
    found = []
    parts = [(0, len(values))]
    while parts:
        first, last = parts.pop()
        if last - first < LEAST_RUNS:
            continue
        split, chance = best_split(values[first:last])
        if chance <= level:
            found.append((first + split, chance))
            parts += [(first, first + split), (first + split, last)]
    return sorted(found)


def exact_steps(values):
    """Places where a new value begins; there is no chance to tell."""
    return [(place, None) for place in range(1, len(values)) if differs(values[place - 1], values[place])]


def share_of(before, after):
    """The change over the size before; infinite from zero."""
    if before == after:
        return 0.0
    return (after - before) / abs(before) if before else math.copysign(math.inf, after)
