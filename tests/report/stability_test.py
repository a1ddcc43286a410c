"""The report of a contest of extremes, on made-up records."""

import unittest

from support import ReportTest
from shared import records
from stability import stability, stability_charts, stability_page
import synthetic

PLAN = {"question": "How long may a step be?", "contest": "stability", "contestants": ["motion.symplectic_euler", "motion.plain_float"]}


def ended(ending, steps=1000, step=1e-3, vertex=None):
    """A run as the judge reads it, and as it is reported."""
    return ({"ending": ending, "steps": steps, "step_s": step, "energy_start_j": 1.0, "energy_most_j": 2.0, "kinetic_end_j": 0.5,
             "drift_over_size": 0.1, "inverted_start": 0, "inverted_end": 0, "steps_unsolved": 0},
            {"outcome": "steady", "step_over_predicted": step / 1e-3, "time_s": step * steps, "vertex": vertex})


def measured(label, extreme, ratio, sweep=None, options=None, **other):
    runs = [ended("steady"), ended("energy_growing"), ended("diverged", 9, 2e-3, 5), ended("diverged", 4, 1e-2, 7)]
    judged = {"measured_step_s": ratio * 1e-3, "measured_over_predicted": ratio, "row_sum_over_measured": 0.7 / ratio}
    return case(label, extreme, "energy_growing", runs, {"task": "measure", "regime": "small", **(options or {})}, sweep, judged, **other)


def case(label, extreme, ending, runs, options, sweep=None, judged=None, mesh="cube", **other):
    judge = {"valid": True, "findings": [], "ending": ending, "runs": [judged_run for judged_run, _ in runs], **(judged or {})}
    reported = {"outcome": "steady", "predicted_step_s": 1e-3, "predicted_at_most_s": 1e-3, "row_sum_step_s": 7e-4, "measured_step_s": 9.0,
                "runs": [said for _, said in runs]}
    line = synthetic.record(mesh, label, None, judge=judge, sweep={"extreme": extreme, **(sweep or {})}, contestant=label, options=options,
                            report={}, case=f"{mesh}/{label}/{extreme}/{sweep}", message="")
    return {**line, "reported": reported, **other}


def one_run(label, extreme, outcome, sweep, step=1e-3, **options):
    return case(label, extreme, outcome, [ended(outcome, 12, step, 3)], {"task": "run", **options}, sweep)


class Stability(ReportTest):
    EULER, FLOAT = "motion.symplectic_euler", "motion.plain_float"

    def write(self, lines):
        synthetic.write_run(self.folder, lines, PLAN)
        code, self.printed, err = self.report()
        self.assertEqual((code, err), (0, ""))

    def test_ratios_are_counted_and_the_worst_is_named(self):
        self.write([measured(self.EULER, "nominal", 1.001), measured(self.EULER, "mass", 0.95, {"mass_factor": 1e9}),
                    measured(self.EULER, "large", 0.5, {"strain": 1}, {"regime": "large"}), measured(self.FLOAT, "nominal", 1.01)])
        line = next(line for line in self.printed.splitlines() if line.startswith(self.EULER))
        self.assertEqual(line.split()[1:4], ["2", "2", "1"])  # large deformation is not compared
        self.assertIn("0.9500", line)
        self.assertIn("cube, mass mass_factor 1e+09", line)

    def test_a_case_has_its_steps_and_a_run_its_vertex_and_time(self):
        self.write([measured(self.EULER, "nominal", 1.001)])
        row = self.table("stability.csv")[0]
        self.assertEqual((row["integrator"], row["predicted_step_s"], row["ending"]), ("symplectic_euler", "0.001", "energy_growing"))
        runs = self.table("runs.csv")
        self.assertEqual([run["outcome"] for run in runs], ["steady", "energy_growing", "diverged", "diverged"])
        self.assertEqual((runs[2]["vertex"], runs[2]["steps"]), ("5", "9"))
        self.assertAlmostEqual(float(runs[2]["time_s"]), 0.018)

    def test_the_words_of_a_contestant_stand_in_no_table_of_the_judges(self):
        self.write([measured(self.EULER, "nominal", 1.001)])  # it reports another step, and that all is steady
        self.assertEqual(self.table("stability.csv")[0]["measured_step_s"], "0.001001")
        self.assertNotIn("steady", [run["outcome"] for run in self.table("runs.csv")][1:])

    def test_the_failure_table_has_a_column_an_integrator(self):
        self.write([measured(self.EULER, "nominal", 1.001), one_run(self.FLOAT, "strain", "inverted", {"strain": -1})])
        rows = {row["extreme"]: row for row in self.table("failures.csv")}
        self.assertEqual(rows["nominal"]["symplectic_euler"], "grows / diverged 9 / diverged 4")
        self.assertEqual(rows["nominal"]["plain_float"], "")
        self.assertEqual(rows["strain"]["plain_float"], "inverted")

    def test_what_gave_no_answer_is_listed_and_what_was_ended_was_too_slow(self):
        crashed = one_run(self.EULER, "strain", "steady", {"strain": 2})
        crashed |= {"outcome": "crashed", "report": None, "reported": None, "judge": None, "message": "signal 11"}
        slow = one_run(self.EULER, "rest", "steady", {})
        slow |= {"report": None, "reported": None, "outcome": "timed_out", "message": "timed out after 1 s",
                 "judge": {"valid": False, "findings": ["it was too slow"], "ending": "too_slow"}}
        self.write([crashed, slow])
        self.assertIn("cube/motion.symplectic_euler/rest : timed_out: timed out after 1 s", self.printed)
        self.assertIn("cube/motion.symplectic_euler/strain strain 2: crashed: signal 11", self.printed)
        rows = {row["extreme"]: row["symplectic_euler"] for row in self.table("failures.csv")}
        self.assertEqual(rows, {"strain": "no answer", "rest": "too slow"})

    def test_what_was_given_up_has_no_ending_and_what_was_rejected_counts_in_no_figure(self):
        slow = one_run(self.EULER, "rest", "too_slow", {})
        slow |= {"outcome": "rejected", "violations": ["run 1 was given up after 5 steps for want of time: how it ends is not known"]}
        wrong = measured(self.EULER, "mass", 1.5, outcome="rejected", violations=["its words differ"])
        self.write([measured(self.EULER, "nominal", 1.001), slow, wrong])
        cases = stability.read_cases(records.read_run(self.folder))
        self.assertEqual(stability_page.verdict_of(cases), ("1 of 1 measured stable steps are within 2% of the predicted one (worst: 1.001 times, symplectic_euler on cube, nominal), and "
                                                            "2 of 3 cases end in a way that has a name (1 of them rejected); 1 was given up before that was known.", "open"))
        self.assertEqual([(row["ending"], row["runs"]) for row in stability_page.endings_chart(cases).rows], [("grows", 1), ("diverged", 2)])
        line = [line for line in self.printed.splitlines() if line.startswith("symplectic_euler")][-1]
        self.assertEqual(line.split()[1::len(line.split()) - 2], ["3", "2"])  # runs, and cases that were not accepted

    def test_slow_growth_has_its_own_name_and_colour_and_is_not_fine(self):
        self.write([one_run(self.EULER, "damping", "growing_slowly", {"damping_ratio": 5e-8})])
        self.assertEqual(self.table("failures.csv")[0]["symplectic_euler"], "grows slowly")
        colors = stability_charts.ENDING_COLORS
        self.assertEqual(len(set(colors.values())), len(colors))
        self.assertEqual(set(stability_charts.ENDING_MARKS) | {stability.NO_ANSWER}, set(colors))
        self.assertEqual(stability.worst(["steady", "growing_slowly", "oscillating", "inverted"]), "growing_slowly")

    def test_charts_are_the_same_twice(self):
        lines = [measured(self.EULER, "damping", 1.001, {"damping_ratio": ratio}, {"damping": "isotropic"}) for ratio in (0.1, 1, 10)]
        lines += [one_run(self.EULER, "map", outcome, {"damping_ratio": ratio, "step_factor": factor}, factor * 1e-3, damping="isotropic")
                  for ratio in (0.1, 1) for factor, outcome in ((0.5, "steady"), (2, "diverged"))]
        lines += [measured(self.EULER, "large", ratio, {"strain": strain}, {"regime": "large", "start": "stretch"})
                  for strain, ratio in ((-0.5, 0.7), (1, 0.8))]
        self.write(lines)
        first = self.charts()
        self.assertEqual(sorted(name for name in first if name.endswith(".png")),
                         ["endings.png", "large_deformation.png", "predicted_and_measured.png", "stability_map_cube_isotropic.png"])
        self.write(lines)
        self.assertEqual(self.charts(), first)


if __name__ == "__main__":
    unittest.main()
