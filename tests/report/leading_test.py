"""The verdict of a contest of simplifiers whose plan makes no claim and no comparison, on made-up answers."""

import unittest

from support import ReportTest
from shared import records
from shared.equal_count import add_count_notes
from simplify import leading, scaling
import synthetic
from synthetic import answer, sized


class Leading(ReportTest):
    def lead(self, lines, **plan):
        run = records.read_run(synthetic.write_run(self.folder, lines, {**synthetic.CONTEST, "comparisons": None, **plan}))
        add_count_notes(run, None)
        return leading.sentence(run, scaling.read_series(run) if plan.get("charts") == ["scaling"] else [])

    def test_it_is_on_the_plans_first_measure_of_a_mesh(self):
        lines = [answer("refined", 90, mean=0.66), answer("cgal_1", 95, mean=0.64)]
        self.assertEqual(self.lead(lines), "The greatest share above a quality of 0.5: cgal_1 on kidney, 22% removed (95.00%).")
        self.assertEqual(self.lead(lines, measure=["tets", "mean_quality", "percent_above_0_5"]), "The greatest mean: refined on kidney, 22% removed (0.6600).")
        self.assertEqual(self.lead([]), "No answer was accepted, so there is nothing to compare.")

    def test_what_is_the_same_as_shown_has_no_winner_and_what_has_another_count_is_none(self):
        lines = [answer("refined", 90), answer("cgal_1", 90), answer("cgal_2", 99, tets=7000)]
        lines[1]["judge"]["percent_above_0_5"] += 0.001
        self.assertEqual(self.lead(lines), "The greatest share above a quality of 0.5: refined and cgal_1 alike on kidney, 22% removed (90.00%).")

    def test_many_meshes_and_counts_are_counted(self):
        lines = [answer(label, percent, ratio=ratio) for ratio in (0.1, 0.2, 0.3, 0.4, 0.5) for label, percent in (("refined", 90), ("cgal_1", 90 if ratio < 0.15 else 80))]
        self.assertEqual(self.lead([*lines, answer("cgal_2", 99, ratio=0.5, tets=7000)]),
                         "The greatest share above a quality of 0.5, at 5 meshes and counts: refined in 5 (1 with others), cgal_1 in 1 (1 with others).")

    def test_where_the_plan_draws_how_time_grows_it_says_so(self):
        lines = [sized(label, n, scale * n**power) for n in (1000, 4000, 16000) for label, scale, power in (("a", 1e-6, 1.0), ("b", 1e-8, 1.5))]
        self.assertEqual(self.lead(lines, charts=["scaling"]), "Time grows with the tetrahedra to the power [95% interval of the fit] 1.00 [1.00, 1.00] with a, 1.50 [1.50, 1.50] with b.")
        self.assertEqual(self.lead(lines[:2], charts=["scaling"]), "No label was timed on two sizes, so nothing is known of how its time grows.")


if __name__ == "__main__":
    unittest.main()
