"""Intervals and ranks against closed forms and against simulation; the rule that they replaced has to fail the same test."""

import itertools
import math
import unittest

import numpy

import support  # finds the report
from shared import intervals

SAMPLES = 6000
SEED = 20080501


def draw(shape, generator, size):
    """Times of a kind that repeats have, with their true median."""
    if shape == "normal":
        return generator.normal(1.0, 0.1, size), 1.0
    if shape == "lognormal":
        return generator.lognormal(0.0, 0.8, size), 1.0
    if shape == "heavy tails":  # the ratio of two normal values: no mean, no variance
        return generator.standard_cauchy(size), 0.0
    # Two speeds of a processor, one time in four the slow one: the median is at 2/3 of the fast ones.
    slow = generator.random(size) < 0.25
    return numpy.where(slow, 2.0 + 0.1 * generator.random(size), 1.0 + 0.1 * generator.random(size)), 1.0 + 0.1 * 2 / 3


def seen_coverage(rule, shape, n, count=SAMPLES):
    """How often the rule's intervals of n values hold the true median. The rule takes sorted samples, one a row."""
    generator = numpy.random.default_rng([SEED, n, len(shape)])
    values, true = draw(shape, generator, (count, n))
    low, high = rule(numpy.sort(values, axis=1))
    return float(numpy.mean((low <= true) & (true <= high)))


def by_order_statistics(samples):
    n = samples.shape[1]
    found = intervals.median_interval(list(range(n)))  # of ranks: the ends are places
    return samples[:, found.low], samples[:, found.high]


def by_bootstrap(samples, draws=400):
    """The 95% percentile bootstrap of the median, which was the rule before."""
    picks = numpy.random.default_rng(SEED).integers(0, samples.shape[1], (draws, samples.shape[1]))
    return numpy.quantile(numpy.median(samples[:, picks], axis=2), [0.025, 0.975], axis=1)


def allowance(coverage, samples=SAMPLES):
    """Four standard deviations of a share that is counted in so many samples."""
    return 4 * math.sqrt(coverage * (1 - coverage) / samples)


class Median(unittest.TestCase):
    SHAPES = ("normal", "lognormal", "heavy tails", "two speeds")

    def test_it_covers_what_it_says_for_every_shape(self):
        for shape, n in itertools.product(self.SHAPES, (3, 5, 6, 7, 9, 10, 15, 40)):
            stated = intervals.median_ranks(n)[1]
            self.assertAlmostEqual(seen_coverage(by_order_statistics, shape, n), stated, delta=allowance(stated), msg=f"{shape}, {n}")
            self.assertEqual(stated >= 0.95, n >= 6)

    def test_the_bootstrap_fails_that_test_at_seven_repeats(self):
        for shape in ("normal", "two speeds"):
            seen = seen_coverage(by_bootstrap, shape, 7, 1500)
            self.assertLess(seen, 0.95 - allowance(0.95, 1500), shape)
            self.assertAlmostEqual(seen, 1 - 2 * 8 / 128, delta=allowance(0.875, 1500))  # the 2nd to the 6th of 7

    def test_equal_values_are_held_at_least_as_often(self):
        generator = numpy.random.default_rng(SEED)
        samples = numpy.sort(generator.integers(0, 3, (SAMPLES, 9)), axis=1)  # the median is 1
        low, high = by_order_statistics(samples)
        stated = intervals.median_ranks(9)[1]
        self.assertGreater(float(numpy.mean((low <= 1) & (1 <= high))), stated - allowance(stated))

    def test_ranks_in_closed_form(self):
        self.assertEqual(intervals.median_ranks(5), (1, 1 - 2 / 32))
        self.assertEqual(intervals.median_ranks(6), (1, 1 - 2 / 64))
        self.assertEqual(intervals.median_ranks(9), (2, 1 - 2 * (1 + 9) / 512))
        self.assertEqual(intervals.median_ranks(12), (3, 1 - 2 * (1 + 12 + 66) / 4096))

    def test_it_names_itself(self):
        found = intervals.median_interval([5, 3, 9, 1, 7, 2, 8, 4, 6])
        self.assertEqual((found.low, found.high, found.kind), (2, 8, "order statistics, 2nd to 8th of 9"))
        self.assertTrue(found.keeps_level)
        self.assertFalse(intervals.median_interval([1, 2, 3, 4, 5]).keeps_level)
        self.assertIsNone(intervals.median_interval([1]))
        self.assertEqual([intervals.ordinal(i) for i in (1, 2, 3, 4, 11, 12, 13, 21, 112)],
                         ["1st", "2nd", "3rd", "4th", "11th", "12th", "13th", "21st", "112th"])
        self.assertEqual(intervals.percent(0.94999), "94.9%")


class Shares(unittest.TestCase):
    def test_ends_in_closed_form(self):
        for n in (1, 5, 40):
            self.assertAlmostEqual(intervals.share_interval(0, n)[1], 1 - 0.025 ** (1 / n), 9)
            self.assertAlmostEqual(intervals.share_interval(n, n)[0], 0.025 ** (1 / n), 9)
        self.assertEqual((intervals.share_interval(0, 7)[0], intervals.share_interval(7, 7)[1]), (0.0, 1.0))

    def test_the_tails_beyond_the_ends_hold_a_fortieth(self):
        low, high = intervals.share_interval(3, 20)
        tail = lambda share, counts: sum(math.comb(20, i) * share**i * (1 - share) ** (20 - i) for i in counts)
        self.assertAlmostEqual(tail(low, range(3, 21)), 0.025, 9)
        self.assertAlmostEqual(tail(high, range(4)), 0.025, 9)

    def test_it_covers_at_least_what_it_says(self):
        n = 25
        ends = [intervals.share_interval(k, n) for k in range(n + 1)]
        for share in [0.01 * i for i in range(1, 100)]:
            held = sum(math.comb(n, k) * share**k * (1 - share) ** (n - k) for k in range(n + 1) if ends[k][0] <= share <= ends[k][1])
            self.assertGreaterEqual(held, 0.95)

    def test_above_a_bound_agrees_with_the_interval(self):
        for n, bound in itertools.product((3, 19, 60), (0.05, 0.3)):
            for k in range(n + 1):
                self.assertEqual(intervals.is_share_above(k, n, bound), intervals.share_interval(k, n)[0] > bound, (k, n))


class Ranks(unittest.TestCase):
    def test_one_stratum(self):
        self.assertEqual(intervals.rank_chance([(1, 39)]), 2 / 40)
        self.assertEqual(intervals.rank_chance([(39, 39)]), 1.0)

    def test_strata_by_brute_force(self):
        sizes, seen = (3, 5, 2), (1, 0, 2)
        all_ranks = list(itertools.product(*(range(n + 1) for n in sizes)))
        expected = sum(sum(ranks) <= sum(seen) for ranks in all_ranks) / len(all_ranks)
        self.assertEqual(intervals.rank_chance(list(zip(seen, sizes))), expected)


if __name__ == "__main__":
    unittest.main()
