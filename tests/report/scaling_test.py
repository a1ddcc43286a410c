"""Growth with the mesh: known power laws, the interval against its closed form, and rows that timed out."""

import math
import random
import unittest
from unittest import mock

from support import ReportTest
from simplify import charts
from shared import records
from simplify import scaling
from simplify import scaling_charts
import synthetic
from synthetic import sized

PLAN = {"question": "How does it grow?", "charts": ["scaling"], "contestants": [{"label": "a"}, {"label": "b"}]}
SIZES = (1000, 4000, 16000, 64000, 256000)


class Fits(unittest.TestCase):
    def test_student_quantiles_against_the_table(self):
        for freedom, expected in ((1, 12.7062), (2, 4.3027), (3, 3.1824), (4, 2.7764), (5, 2.5706), (10, 2.2281), (30, 2.0423)):
            self.assertAlmostEqual(scaling.student_quantile(0.975, freedom), expected, 4)
        self.assertAlmostEqual(scaling.student_quantile(0.95, 7), 1.8946, 4)

    def test_student_cdf_in_closed_form(self):
        for t in (0.0, 0.3, 2.0, 40.0):
            self.assertAlmostEqual(scaling.student_cdf(t, 1), 0.5 + math.atan(t) / math.pi, 12)
            self.assertAlmostEqual(scaling.student_cdf(t, 2), 0.5 + t / (2 * math.sqrt(2 + t * t)), 12)

    def test_an_exact_power_law_has_its_slope_and_no_width(self):
        for slope in (1.0, 1.37, -0.5):
            fit = scaling.fit_power(SIZES, [3e-6 * n**slope for n in SIZES])
            self.assertAlmostEqual(fit.slope, slope, 12)
            self.assertAlmostEqual(math.exp(fit.intercept), 3e-6, 14)
            self.assertAlmostEqual(fit.high - fit.low, 0, 9)
            self.assertAlmostEqual(fit.at(10_000), 3e-6 * 10_000**slope, 9)

    def test_three_points_by_hand(self):
        # log y = 0, 1, 5 over log x = 0, 1, 2: slope 5/2, intercept -1/2, residuals 1/2, -1, 1/2, RSS 3/2, one degree of freedom.
        fit = scaling.fit_power([1, math.e, math.e**2], [1, math.e, math.e**5])
        half = math.tan(math.pi * 0.475) * math.sqrt(1.5 / 2)
        self.assertAlmostEqual(fit.slope, 2.5, 12)
        self.assertAlmostEqual(fit.intercept, -0.5, 12)
        self.assertAlmostEqual(fit.low, 2.5 - half, 9)
        self.assertAlmostEqual(fit.high, 2.5 + half, 9)

    def test_the_interval_holds_the_true_slope_as_often_as_it_says(self):
        seed = 20261121
        generator = random.Random(seed)
        hits = 0
        for _ in range(2000):
            fit = scaling.fit_power(SIZES, [1e-6 * n**1.2 * math.exp(generator.gauss(0, 0.3)) for n in SIZES])
            hits += fit.low <= 1.2 <= fit.high
        # 2000 draws of 95%: the standard deviation of the share is 0.0049; five of them on either side
        self.assertAlmostEqual(hits / 2000, 0.95, delta=0.0245, msg=f"seed {seed}")

    def test_too_few_sizes(self):
        self.assertIsNone(scaling.fit_power([10], [1]))
        self.assertIsNone(scaling.fit_power([10, 10], [1, 2]))
        fit = scaling.fit_power([10, 100], [1, 10])
        self.assertAlmostEqual(fit.slope, 1)
        self.assertIsNone(fit.low)


class Scaling(ReportTest):
    def lines(self):
        quick = [sized("a", n, 1e-6 * n, memory=int(5e6 + 80 * n)) for n in SIZES]
        slow = [sized("b", n, 1e-8 * n**1.5, memory=100 * n) for n in SIZES[:-1]]
        return [*quick, *slow, sized("b", SIZES[-1], None, outcome="timed_out", message="timed out after 120 s")]

    def test_slopes_and_rows(self):
        synthetic.write_run(self.folder, self.lines(), PLAN)
        code, out, _ = self.report()
        self.assertEqual(code, 0)
        slopes = {(row["label"], row["measure"]): float(row["slope"]) for row in self.table("scaling_fits.csv")}
        self.assertAlmostEqual(slopes["a", "kernel_s"], 1.0, 9)
        self.assertAlmostEqual(slopes["b", "kernel_s"], 1.5, 9)
        self.assertAlmostEqual(slopes["b", "peak_rss_bytes"], 1.0, 9)
        rows = [row for row in self.table("scaling.csv") if row["label"] == "b"]
        self.assertEqual(len(rows), len(SIZES))
        self.assertEqual((rows[-1]["kernel_median_s"], rows[-1]["timed_out_at_s"]), ("", "120.0"))
        self.assertIn("m256000: timed_out: timed out after 120 s", out)
        self.assertAlmostEqual(float(rows[0]["bytes_per_tet"]), 100)
        self.assertEqual(set(self.charts()), {"scaling.svg", "scaling.png"})

    def test_a_timed_out_size_is_an_open_mark_at_the_limit(self):
        synthetic.write_run(self.folder, self.lines(), PLAN)
        drawn = {}
        with mock.patch.object(scaling_charts, "save", lambda figure, _, name: drawn.update({name: figure}) or [name]):
            charts.draw_charts(records.read_run(self.folder), None, self.folder / "charts")
        time_panel = drawn["scaling"].axes[0]
        open_marks = [line for line in time_panel.get_lines() if line.get_markerfacecolor() == "white" and line.get_marker() != "None"]
        self.assertEqual([(line.get_xdata()[0], line.get_ydata()[0]) for line in open_marks], [(256000, 120.0)])
        texts = [text.get_text() for text in drawn["scaling"].findobj(charts.plt.Text)]
        self.assertIn("a: 1.00 [1.00, 1.00]", texts)

    def test_a_size_that_was_rejected_is_no_part_of_the_fit(self):
        lines = [sized("a", n, 1e-6 * n) for n in SIZES[:4]]
        lines.append(sized("a", SIZES[-1], 99.0, outcome="rejected", violations=["flat_tets 2"]))
        synthetic.write_run(self.folder, lines, PLAN)
        _, out, _ = self.report("--no-charts")
        row, = self.table("scaling_fits.csv")
        self.assertEqual((row["sizes"], round(float(row["slope"]), 9)), ("4", 1.0))
        self.assertIn("m256000: rejected: flat_tets 2", out)

    def test_nothing_to_fit(self):
        synthetic.write_run(self.folder, [sized("a", 1000, None, outcome="crashed", message="signal 11")], PLAN)
        code, out, _ = self.report()
        self.assertEqual(code, 0)
        self.assertIn("m1000: crashed: signal 11", out)
        self.assertEqual(self.charts(), {})


if __name__ == "__main__":
    unittest.main()
