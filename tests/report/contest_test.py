"""The contest's table and its comparisons on made-up answers: who is ranked, who is marked, and what is said of the others."""

import json
import unittest

from support import ReportTest
from simplify import comparisons
from shared import measure_text
import synthetic
from synthetic import answer


def rounds(line, times=9):
    """An answer with that many repeats, whose times are all alike."""
    return [{**line, "repeat": i} for i in range(times)]


def strayed(line, distance):
    """An answer whose skin is so far from the input's."""
    return {**line, "judge": {**line["judge"], "surface_distance_upper": distance}}


class Contest(ReportTest):
    def run_contest(self, lines, plan=None):
        """The rows of contest.csv by label, and what the report prints."""
        synthetic.write_run(self.folder, lines, plan or synthetic.CONTEST)
        code, out, _ = self.report("--no-charts")
        self.assertEqual(code, 0)
        return {row["label"]: row for row in self.table("contest.csv")}, out

    def contest_file(self):
        return (self.folder / "tables" / "contest.txt").read_text(encoding="utf-8")

    def line_of(self, out, label):
        return next(line for line in out.splitlines() if line.startswith(label))

    def test_the_best_of_each_column_is_marked_whoever_it_is(self):
        rows, out = self.run_contest([answer("refined", 90, kernel_s=0.02, mean=0.66), answer("cgal_1", 95, kernel_s=0.2, mean=0.64)])
        self.assertIn("percent_above_0_5", rows["cgal_1"]["best_in"])
        self.assertIn("mean_quality", rows["refined"]["best_in"])
        self.assertIn("kernel_s", rows["refined"]["best_in"])
        self.assertNotIn("percent_above_0_5", rows["refined"]["best_in"])
        self.assertIn("95.00*", self.line_of(out, "cgal_1"))
        self.assertIn("0.6600*", self.line_of(out, "refined"))

    def test_the_interval_of_a_time_and_its_repeats_stand_beside_it(self):
        lines = [answer("refined", 90, repeat=i, kernel_s=0.01 * (i + 1)) for i in range(9)] + [answer("cgal_1", 80, kernel_s=0.2)]
        rows, out = self.run_contest(lines)
        self.assertEqual([rows["refined"][name] for name in ("n", "kernel_median_low_s", "kernel_median_high_s", "interval_covers")],
                         ["9", "0.02", "0.08", "0.9609375"])
        self.assertEqual((rows["cgal_1"]["n"], rows["cgal_1"]["interval_kind"]), ("1", "none: one value"))
        self.assertIn("Times: medians over 1 to 9 accepted repeats", out)

    def test_times_that_are_not_compared_have_no_best(self):
        lines = [answer("refined", 90, kernel_s=0.02), answer("cgal_1", 80, kernel_s=0.2)]
        for repeats, warmup, expected in ((9, 1, True), (1, 1, False), (9, 0, False)):
            synthetic.write_run(self.folder, lines, synthetic.CONTEST)
            path = self.folder / "provenance.json"
            path.write_text(json.dumps({**json.loads(path.read_text()), "repeats": repeats, "warmup": warmup}))
            self.assertEqual(self.report("--no-charts")[0], 0)
            self.assertEqual("kernel_s" in {row["label"]: row["best_in"] for row in self.table("contest.csv")}["refined"], expected, (repeats, warmup))

    def test_a_tie_marks_both(self):
        rows, _ = self.run_contest([answer("refined", 90), answer("cgal_1", 90)])
        for label in ("refined", "cgal_1"):
            self.assertIn("percent_above_0_5", rows[label]["best_in"])

    def test_rows_are_sorted_by_the_share_of_good_tets_and_others_follow(self):
        lines = [answer("late", None, outcome="timed_out", kernel_s=None, message="timed out after 5 s"),
                 answer("bad", 99, outcome="rejected", violations=["inverted_tets is 3"]), answer("far", 98, tets=7000),
                 answer("b", 80), answer("a", 90)]
        self.run_contest(lines)
        self.assertEqual([(row["label"], row["state"]) for row in self.table("contest.csv")],
                         [("a", "ranked"), ("b", "ranked"), ("far", "other count"), ("bad", "rejected"), ("late", "no answer")])

    def test_a_rejected_answer_is_shown_in_brackets_with_the_reason_and_wins_nothing(self):
        rows, out = self.run_contest([answer("refined", 90), answer("vtk", 99, outcome="rejected", kernel_s=0.001,
                                                                    violations=["inverted_tets is 3, at most 0 is accepted"])])
        self.assertEqual((rows["vtk"]["best_in"], rows["vtk"]["state"]), ("", "rejected"))
        line = self.line_of(out, "vtk")
        self.assertIn("(99.0", line)
        self.assertIn("rejected: inverted_tets is 3, at most 0 is accepted", line)
        self.assertIn("kernel_s", rows["refined"]["best_in"])

    def test_what_gave_no_answer_keeps_its_row_and_its_reason(self):
        rows, out = self.run_contest([answer("refined", 90), answer("slow", None, outcome="timed_out", kernel_s=None,
                                                                    message="timed out after 120 s")])
        self.assertEqual((rows["slow"]["percent_above_0_5"], rows["slow"]["kernel_s"]), ("", ""))
        self.assertIn("timed_out: timed out after 120 s", self.line_of(out, "slow"))

    def test_the_count_is_equal_within_the_share_that_the_plan_gives(self):
        rows, out = self.run_contest([answer("in", 90, tets=6271), answer("below", 91, tets=6209), answer("off", 92, tets=6272)])
        self.assertEqual([rows[label]["state"] for label in ("in", "below", "off")], ["ranked", "ranked", "other count"])
        self.assertIn("stopped early: 6,272 tets", self.line_of(out, "off"))
        self.assertIn("within 0.5% of the tetrahedra asked for", out)

    def test_an_overshoot_is_another_count_too(self):
        rows, _ = self.run_contest([answer("a", 90), answer("over", 92, tets=6100)])
        self.assertEqual((rows["over"]["state"], rows["over"]["note"]), ("other count", "other count: 6,100 tets"))

    def test_the_best_that_keeps_the_boundary_has_a_mark_of_its_own(self):
        rows, out = self.run_contest([answer("free", 99, changed_faces=12), answer("kept", 90)])
        self.assertIn("percent_above_0_5", rows["free"]["best_in"])
        self.assertIn("percent_above_0_5", rows["kept"]["best_with_boundary_kept_in"])
        self.assertIn("12 faces", self.line_of(out, "free"))
        self.assertIn("90.00+", self.line_of(out, "kept"))

    def test_outputs_that_differ_between_repeats_count_by_their_median(self):
        lines = [answer("cgal_1", percent, repeat=i, output_hash=f"h{i}") for i, percent in enumerate((90, 95, 80))]
        rows, _ = self.run_contest(lines)
        self.assertAlmostEqual(float(rows["cgal_1"]["percent_above_0_5"]), 90, 1)

    def test_of_several_outputs_the_median_count_decides_and_those_off_are_said(self):
        lines = [answer("cgal_1", 90, tets=tets, repeat=i, output_hash=f"h{i}") for i, tets in enumerate((6240, 6241, 6300))]
        lines += [answer("cgal_2", 90, tets=tets, repeat=i, output_hash=f"h{i}") for i, tets in enumerate((6240, 6300, 6301))]
        rows, _ = self.run_contest(lines)
        self.assertEqual((rows["cgal_1"]["state"], rows["cgal_1"]["note"]), ("ranked", "stopped early: 1 of 3 outputs"))
        self.assertEqual(rows["cgal_2"]["state"], "other count")

    def test_without_a_count_to_meet_answers_at_different_counts_are_not_ranked(self):
        limit = {"stop": {"kind": "limit", "value": None}, "sweep": {}}
        for other, state in ((5000, "other count"), (4010, "ranked")):
            rows, _ = self.run_contest([answer("a", 90, 0.5, **limit), answer("b", 80, tets=other, **limit)])
            self.assertEqual([rows[label]["state"] for label in "ab"], [state, state])
            self.assertEqual(bool(rows["a"]["best_in"]), state == "ranked")

    def test_each_mesh_and_ratio_has_its_own_best(self):
        lines = [answer(label, percent, ratio, mesh=mesh) for mesh in ("kidney", "liver") for ratio in (0.22, 0.5)
                 for label, percent in (("refined", 90 if mesh == "kidney" else 70), ("cgal_1", 80))]
        self.run_contest(lines)
        best = [(row["mesh"], row["label"]) for row in self.table("contest.csv") if "percent_above_0_5" in row["best_in"]]
        self.assertEqual(best, [("kidney", "refined")] * 2 + [("liver", "cgal_1")] * 2)


    def test_shape_and_purpose_have_tables_of_their_own_and_marks(self):
        lines = [answer("refined", 90), answer("cgal_1", 80), answer("gone", None, outcome="crashed", kernel_s=None)]
        for line, ratio, angle, error in ((lines[0], 0.8, 150.0, 0.31), (lines[1], 0.9, 140.0, 0.32)):
            line["judge"].update(mean_mean_ratio=ratio, p99_max_dihedral_deg=angle, p1_error=error)
        self.run_contest(lines)
        best = {row["label"]: row["best_in"].split() for row in self.table("contest.csv")}
        self.assertLessEqual({"mean_mean_ratio", "p99_max_dihedral_deg"}, set(best["cgal_1"]))
        self.assertIn("p1_error", best["refined"])
        familiar, shape, purpose = self.contest_file().split("label ")[1:4]
        self.assertIn("gone", familiar)
        self.assertNotIn("gone", shape + purpose)  # it has no figure there: its reason stands above
        self.assertIn("140.00*", shape)
        self.assertIn("0.3100*", purpose)

    def test_a_run_without_the_new_figures_has_the_first_table_alone(self):
        self.run_contest([answer("refined", 90), answer("cgal_1", 80)])
        self.assertNotIn("Shape", self.contest_file())


class Comparisons(ReportTest):
    def text(self, name):
        return (self.folder / "tables" / name).read_text(encoding="utf-8")

    def compare(self, lines, plan=None):
        """The rows of comparisons.csv by measure, and comparisons.txt."""
        synthetic.write_run(self.folder, lines, plan or synthetic.CONTEST)
        code, self.printed, _ = self.report("--no-charts")
        self.assertEqual(code, 0)
        text = (self.folder / "tables" / "comparisons.txt").read_text(encoding="utf-8")
        return {row["measure"]: row for row in reversed(self.table("comparisons.csv"))}, text  # of times the judged one

    def test_against_the_best_peer_figure_by_figure(self):
        rows, out = self.compare([*rounds(answer("refined", 96, 0.5, mean=0.66, least=12, kernel_s=0.02)),
                                  *rounds(answer("cgal_1", 95, 0.5, mean=0.64, least=18, kernel_s=0.21)),
                                  answer("cgal_2", 94, 0.5, mean=0.68, least=17, kernel_s=0.4)])
        self.assertEqual([rows[m]["verdict"] for m in ("percent_above_0_5", "mean_quality", "min_dihedral_deg", "time")],
                         ["met", "short", "short", "met"])
        self.assertEqual([rows[m]["best_label"] for m in ("percent_above_0_5", "mean_quality", "min_dihedral_deg")],
                         ["cgal_1", "cgal_2", "cgal_1"])
        self.assertAlmostEqual(float(rows["min_dihedral_deg"]["margin"]), -6)
        self.assertAlmostEqual(float(rows["time"]["value"]), 10.5)
        self.assertIn("least angle 12.00, short of cgal_1 (18.00) by 6.00.", out)
        self.assertIn("-6.00 SHORT", self.printed)
        self.assertIn("refined: 1 of 3 figures no worse than the best of cgal_1, cgal_2; at least 10 times as fast as cgal_1 in 1 of 1.",
                      out)

    def test_a_tie_is_met_and_the_least_shortfall_is_told_from_zero(self):
        rows, out = self.compare([answer("refined", 95, 0.5, mean=0.6399999), answer("cgal_1", 95, 0.5, mean=0.64)])
        self.assertEqual((rows["percent_above_0_5"]["verdict"], rows["mean_quality"]["verdict"]), ("met", "short"))
        self.assertIn("by 1e-07", out)

    def test_too_slow_is_short(self):
        rows, out = self.compare(rounds(answer("refined", 96, 0.5, kernel_s=0.1)) + rounds(answer("cgal_1", 95, 0.5, kernel_s=0.5)))
        self.assertEqual(rows["time"]["verdict"], "short")
        self.assertIn("5.00 times as fast as cgal_1, 10 times is asked for.", out)

    def test_without_a_factor_the_time_is_shown_and_not_judged(self):
        entry = {key: value for key, value in synthetic.CONTEST["comparisons"][0].items() if key != "time_factor"}
        rows, out = self.compare([answer("refined", 96, 0.5, kernel_s=0.1), answer("cgal_1", 95, 0.5, kernel_s=0.05)],
                                 {**synthetic.CONTEST, "comparisons": [entry]})
        self.assertEqual((rows["time"]["verdict"], float(rows["time"]["value"])), ("shown", 0.5))
        self.assertIn("0.5x", out)
        self.assertNotIn("times as fast", out)

    def test_each_peer_has_its_own_time_ratio_and_the_factor_judges_one(self):
        lines = [answer(label, 95, 0.5, kernel_s=seconds, repeat=repeat) for repeat in range(9)
                 for label, seconds in (("refined", 0.02), ("cgal_1", 0.1), ("cgal_2", 0.4))]
        self.compare(lines)
        times = [row for row in self.table("comparisons.csv") if row["measure"] == "time"]
        self.assertEqual([(row["best_label"], row["verdict"], float(row["value"])) for row in times],
                         [("cgal_1", "short", 5.0), ("cgal_2", "shown", 20.0)])
        self.assertIn("5.00 times as fast as cgal_1, 10 times is asked for.", self.text("comparisons.txt"))

    def test_each_peer_alone_and_each_measure_alone(self):
        lines = [answer("refined", 96, ratio, mean=0.66, least=12 if ratio == 0.5 else 20, kernel_s=0.02) for ratio in (0.5, 0.7)]
        lines += [answer("cgal_1", 95, ratio, mean=0.64, least=18, kernel_s=0.2) for ratio in (0.5, 0.7)]
        lines += [answer("cgal_2", 94, 0.5, mean=0.68, least=11, kernel_s=0.4), answer("cgal_2", 99, 0.7, tets=3000)]
        rows = [line.split() for line in self.compare(lines)[1].splitlines()]
        self.assertIn(["cgal_1", "5", "1", "6", "10", "10", "10"], rows)  # the least angle at 50%
        self.assertIn(["cgal_2", "2", "1", "3", "20", "20", "20"], rows)  # the mean at 50%; at 70% its count is another
        self.assertIn(["least", "angle", "1", "1", "-2.00", "-6.00", "cgal_1,", "kidney,", "50%", "removed"], rows)
        self.assertIn(["mean", "1", "1", "0.0000", "-0.0200", "cgal_2,", "kidney,", "50%", "removed"], rows)

    def test_many_measures_are_folded_so_that_no_line_gets_too_long(self):
        names = list(measure_text.TITLES)[:14]
        entry = {**synthetic.CONTEST["comparisons"][0], "measures": names}
        lines = [answer(label, 95, 0.5) for label in ("refined", "cgal_1", "cgal_2")]
        for line in lines:
            line["judge"].update({name: 0.123456 for name in names})
        self.compare(lines, {**synthetic.CONTEST, "comparisons": [entry]})
        title, *blocks = self.text("comparisons.txt").split("\n\n")
        lines = [line for block in blocks for line in block.splitlines() if not line.startswith("refined: ")]
        self.assertLessEqual(max(map(len, lines)), 100)
        for name in names:
            self.assertIn(measure_text.TITLES[name], "".join(blocks))

    def test_the_time_ratio_is_taken_round_by_round(self):
        lines = []
        for i, load in enumerate((1, 5, 1, 2, 1, 7, 1, 1, 1)):  # the machine is five times slower in the second round
            lines += [answer("refined", 96, 0.5, repeat=i, kernel_s=0.01 * load), answer("cgal_1", 95, 0.5, repeat=i, kernel_s=0.12 * load)]
        rows, _ = self.compare(lines)
        self.assertAlmostEqual(float(rows["time"]["value"]), 12)
        self.assertAlmostEqual(float(rows["time"]["ratio_low"]), 12)
        self.assertEqual((rows["time"]["rounds"], rows["time"]["ratio_covers"]), ("9", "0.9609375"))
        self.assertIn("order statistics, 2nd to 8th of 9 rounds, covers 96.0%", self.printed)

    def ratios(self, values):
        """The finding on time of such ratios, round by round, where a factor of 10 is asked for."""
        lines = [line for i, ratio in enumerate(values)
                 for line in (answer("refined", 96, 0.5, repeat=i, kernel_s=0.01), answer("cgal_1", 95, 0.5, repeat=i, kernel_s=0.01 * ratio))]
        rows, out = self.compare(lines)
        return rows["time"]["verdict"], rows["time"]["reason"], out

    def test_a_ratio_whose_interval_holds_the_factor_is_open(self):
        self.assertEqual(self.ratios([11, 12, 13, 11, 12, 13, 11, 12, 9])[0], "met")  # the 2nd to the 8th of 9 are above
        verdict, reason, out = self.ratios([11, 12, 13, 11, 12, 13, 11, 9, 9])
        self.assertEqual((verdict, reason), ("open", "the interval of the time ratio, [9, 13], holds 10"))
        self.assertIn("11x [9, 13] OPEN", self.printed)
        self.assertIn("in 0 of 1; 1 open.", out)
        self.assertEqual(self.ratios([7, 8, 9, 7, 8, 9, 7, 8, 13])[0], "short")

    def test_a_comparison_that_is_required_decides_the_exit_code(self):
        entry = {"of": "refined", "against_best_of": ["cgal_1"], "measures": ["percent_above_0_5"], "required": True}
        plan = {**synthetic.CONTEST, "comparisons": [entry]}
        last = "required, and does not hold: the comparison of refined with cgal_1: "
        cases = (([answer("refined", 96), answer("cgal_1", 95)], 0, None), ([answer("refined", 94), answer("cgal_1", 95)], 1, "1 short"),
                 ([answer("refined", 96), answer("cgal_1", 95, tets=5000)], 1, "1 cannot be decided"),
                 ([answer("cgal_1", 95)], 1, "it was not run"),
                 ([*(answer("refined", 90 + i, output_hash=f"h{i}", repeat=i) for i in range(9)), answer("cgal_1", 95)], 1, "1 open"))
        for lines, code, said in cases:
            synthetic.write_run(self.folder, lines, plan)
            found, out, _ = self.report("--no-charts")
            self.assertEqual(found, code, said)
            self.assertEqual(out.strip().splitlines()[-1] == f"{last}{said}", code == 1, out[-300:])
        synthetic.write_run(self.folder, cases[1][0], {**plan, "comparisons": [{**entry, "required": False}]})
        self.assertEqual(self.report("--no-charts")[0], 0)

    def test_few_rounds_decide_nothing_on_time(self):
        self.assertEqual(self.ratios([12, 12, 13, 12, 12])[:2], ("open", "5 rounds are too few for a 95% interval"))
        self.assertEqual(self.ratios([12, 12, 13, 12, 12, 14])[0], "met")

    def test_a_label_with_seeds_is_timed_by_its_median_over_them(self):
        lines = [answer("refined", 96, 0.5, seed=seed, repeat=i, kernel_s=0.01 * seed, case=f"kidney/refined/seed={seed}") for i in range(9) for seed in (1, 2, 3)]
        rows, _ = self.compare(lines + rounds(answer("cgal_1", 95, 0.5, kernel_s=0.3)))
        self.assertEqual((rows["time"]["verdict"], float(rows["time"]["value"])), ("met", 15))

    def test_figures_that_scatter_by_more_than_their_difference_are_open(self):
        def compare(own, peer):
            lines = [answer("refined", percent, 0.5, repeat=i, output_hash=f"r{i}") for i, percent in enumerate(own)]
            lines += [answer("cgal_1", percent, 0.5, repeat=i, output_hash=f"c{i}") for i, percent in enumerate(peer)]
            row = self.compare(lines)[0]["percent_above_0_5"]
            return row["verdict"], row["reason"]
        self.assertEqual(compare([90, 91, 92, 93, 94, 95], [80, 81, 82, 83, 84, 85]), ("met", ""))
        self.assertEqual(compare([80, 81, 82, 83, 84, 85], [86]), ("short", ""))
        self.assertEqual(compare([80, 81, 82, 83, 84, 85], [83]), ("open", "the figures scatter by more than the difference"))
        self.assertEqual(compare([90, 91, 92], [80]), ("open", "too few values for a 95% interval"))

    def test_a_peer_at_another_count_or_rejected_is_left_out_and_said(self):
        rows, out = self.compare([answer("refined", 90, 0.5), answer("cgal_1", 99, 0.5, tets=4100),
                                  answer("cgal_2", 99, 0.5, outcome="rejected", violations=["flat_tets 1"])])
        self.assertEqual(rows["percent_above_0_5"]["verdict"], "cannot be decided")
        self.assertIn("left out: cgal_1 (4,100 tets, better in % > 0.5), cgal_2 (1 rejected).", out)
        self.assertIn("3 cannot be decided.", out)

    def test_counts_are_held_against_each_other_not_against_what_was_asked(self):
        rows, _ = self.compare([answer("refined", 90, 0.5, tets=3985), answer("cgal_1", 95, 0.5, tets=4015)])
        self.assertEqual(rows["percent_above_0_5"]["verdict"], "cannot be decided")

    def test_without_an_own_answer_nothing_is_decided(self):
        rows, out = self.compare([answer("refined", None, 0.5, outcome="crashed", kernel_s=None), answer("cgal_1", 95, 0.5)])
        self.assertEqual({row["verdict"] for row in rows.values()}, {"cannot be decided"})
        self.assertIn("no accepted answer of refined", out)
        self.assertIn("no accepted time of refined", out)

    def test_a_figure_that_the_judge_could_not_give_is_not_decided(self):
        lines = [answer("refined", 90, 0.5), answer("cgal_1", 80, 0.5)]
        lines[0]["judge"]["mean_quality"] = None
        rows, out = self.compare(lines)
        self.assertEqual((rows["mean_quality"]["verdict"], rows["percent_above_0_5"]["verdict"]), ("cannot be decided", "met"))
        self.assertIn("mean cannot be decided: refined has no such figure.", out)

    def test_the_input_is_a_peer_up_to_its_ratio(self):
        start = {**answer("input", 97, 0), "judge": {**synthetic.judge(97, 8000), "mean_quality": 0.5, "min_dihedral_deg": 1.0}}
        for ratio, verdict, best in ((0.22, "short", "input"), (0.5, "met", "cgal_1")):
            rows, _ = self.compare([start, answer("refined", 96, ratio), answer("cgal_1", 95, ratio)])
            self.assertEqual((rows["percent_above_0_5"]["verdict"], rows["percent_above_0_5"]["best_label"]), (verdict, best))

    def test_the_input_alone_does_not_stand_for_the_peers(self):
        start = {**answer("input", 80, 0), "judge": {**synthetic.judge(80, 8000), "mean_quality": 0.7, "min_dihedral_deg": 1.0}}
        rows, _ = self.compare([start, answer("refined", 96), answer("cgal_1", 95, tets=7000)])
        self.assertEqual((rows["percent_above_0_5"]["verdict"], rows["mean_quality"]["verdict"]), ("cannot be decided", "short"))

    def test_at_equal_distance_only_peers_that_stray_no_farther_count(self):
        entry = {"of": "refined", "against_best_of": ["cgal_1", "cgal_2"], "measures": ["percent_above_0_5"]}
        lines = [strayed(answer("refined", 90, kernel_s=0.02), 2.0), strayed(answer("cgal_1", 95, kernel_s=0.2), 5.0),
                 strayed(answer("cgal_2", 80, kernel_s=0.2), 2.0)]
        far, _ = self.compare(lines, {**synthetic.CONTEST, "comparisons": [entry]})
        self.assertEqual(far["percent_above_0_5"]["verdict"], "short")
        near, text = self.compare(lines, {**synthetic.CONTEST, "comparisons": [{**entry, "equal_distance": True}]})
        self.assertEqual(near["percent_above_0_5"]["verdict"], "met")
        self.assertIn("cgal_1 (strays 5)", text)
        self.assertIn("that stray no farther", text)
        alone, text = self.compare([strayed(answer("refined", 90, kernel_s=0.02), 1.0), *lines[1:]],
                                   {**synthetic.CONTEST, "comparisons": [{**entry, "equal_distance": True}]})
        self.assertEqual(alone["percent_above_0_5"]["verdict"], "cannot be decided")

    def test_a_measure_where_less_is_better(self):
        plan = {**synthetic.CONTEST, "comparisons": [{"of": "refined", "against_best_of": ["cgal_1", "cgal_2"], "measures": ["kernel_s"]}]}
        lines = [line for label, time in (("refined", 0.3), ("cgal_1", 0.2), ("cgal_2", 0.4))
                 for line in rounds(answer(label, 90, kernel_s=time))]
        rows, _ = self.compare(lines, plan)
        self.assertEqual((rows["kernel_s"]["verdict"], rows["kernel_s"]["best_label"]), ("short", "cgal_1"))
        self.assertAlmostEqual(float(rows["kernel_s"]["margin"]), -0.1)

    def test_the_rule(self):
        self.assertEqual(comparisons.decide(1.0, [("a", 1.0), ("b", None)], 1), ("met", 1.0, "a", 0.0))
        self.assertEqual(comparisons.decide(1.0, [("a", 2.0), ("b", 3.0)], 1), ("short", 3.0, "b", -2.0))
        self.assertEqual(comparisons.decide(1.0, [("a", 2.0), ("b", 3.0)], -1), ("met", 2.0, "a", 1.0))
        self.assertEqual(comparisons.decide(1.0, [], 1)[0], "cannot be decided")
        self.assertEqual(comparisons.decide(None, [("a", 1.0)], 1)[0], "cannot be decided")


class QualityTimeChart(ReportTest):
    CURVE = [answer("refined_0", 90, kernel_s=0.01, method="palpate.refined", options={"effort": 0, "flips": True}),
             answer("refined_2", 97, kernel_s=0.04, method="palpate.refined", options={"effort": 2, "flips": True}),
             answer("refined_1", 95, kernel_s=0.02, method="palpate.refined", options={"effort": 1, "flips": True})]

    def families(self, lines):
        from shared import families
        from shared import records
        synthetic.write_run(self.folder, lines, synthetic.CONTEST)
        return {family.method: family for family in families.read_families(records.read_run(self.folder))}

    def test_one_option_of_whole_numbers_makes_a_curve_in_its_order(self):
        family = self.families(self.CURVE)["palpate.refined"]
        self.assertEqual((family.option, family.labels), ("effort", ["refined_0", "refined_1", "refined_2"]))
        self.assertEqual(family.names, {"refined_0": "0", "refined_1": "1", "refined_2": "2"})

    def test_two_differing_options_or_names_make_none(self):
        other = answer("refined_9", 90, method="palpate.refined", options={"effort": 3, "flips": False})
        self.assertEqual(self.families([*self.CURVE, other])["palpate.refined"].option, "")
        named = [answer(f"c_{cost}", 90, method="cgal.collapse", options={"cost": cost}) for cost in ("lt", "gh")]
        family = self.families(named)["cgal.collapse"]
        self.assertEqual((family.option, family.names), ("", {"c_lt": "lt", "c_gh": "gh"}))
        bounds = [answer(f"s_{bound}", 90, method="palpate.surface", options={"max_error": bound}) for bound in (0.1, 0.2)]
        self.assertEqual(self.families(bounds)["palpate.surface"].option, "")

    def test_the_chart_holds_every_answer_that_has_a_time(self):
        from unittest import mock
        from simplify import charts
        from simplify import contest_charts
        from shared import records
        lines = [*self.CURVE, answer("vtk", 70, method="vtk.quadric", kernel_s=0.005, outcome="rejected", violations=["flat_tets 1"])]
        synthetic.write_run(self.folder, lines, synthetic.CONTEST)
        drawn = {}
        with mock.patch.object(contest_charts, "save", lambda figure, _, name: drawn.update({name: figure}) or [name]):
            charts.draw_charts(records.read_run(self.folder), None, self.folder / "charts")
        ax = drawn["quality_time_kidney"].axes[0]
        marks = [line for line in ax.get_lines() if line.get_marker() not in ("None", None) and len(line.get_xdata()) == 1]
        self.assertEqual(sorted(float(line.get_xdata()[0]) for line in marks), [5.0, 10.0, 20.0, 40.0])
        hollow = [line for line in marks if line.get_markerfacecolor() == "white"]
        self.assertEqual([float(line.get_xdata()[0]) for line in hollow], [5.0])
        curve, = [line for line in ax.get_lines() if len(line.get_xdata()) == 3]
        self.assertEqual(list(curve.get_xdata()), [10.0, 20.0, 40.0])

    def test_the_other_chart_holds_every_answer_that_has_a_distance(self):
        from unittest import mock
        from simplify import charts
        from simplify import contest_charts
        from shared import records
        lines = [strayed(answer("s_1", 90, method="palpate.surface"), 0.5), strayed(answer("free", 95, method="cgal.remesh_free"), 4.0),
                 answer("kept", 80, method="palpate.refined")]
        synthetic.write_run(self.folder, lines, {**synthetic.CONTEST, "charts": ["quality_distance"]})
        drawn = {}
        with mock.patch.object(contest_charts, "save", lambda figure, _, name: drawn.update({name: figure}) or [name]):
            charts.draw_charts(records.read_run(self.folder), None, self.folder / "charts")
        ax = drawn["quality_distance_kidney"].axes[0]
        marks = [line for line in ax.get_lines() if line.get_marker() not in ("None", None) and len(line.get_xdata()) == 1]
        self.assertEqual(sorted((float(line.get_xdata()[0]), float(line.get_ydata()[0])) for line in marks), [(0.5, 90.0), (4.0, 95.0)])

    def test_names_of_points_meet_neither_each_other_nor_the_edge_of_their_panel(self):
        from unittest import mock
        from matplotlib.text import Text
        from simplify import charts, contest_charts, point_names
        from shared import records
        bounds = [strayed(answer(f"s_{bound}", 90 + shift, method="palpate.surface", kernel_s=seconds, options={"max_error": bound}), distance)
                  for bound, shift, seconds, distance in (("half_mm", 0.0, 0.010, 0.5), ("1_mm", 0.1, 0.0101, 1.0), ("2_mm", 0.2, 0.0102, 1.01),
                                                          ("8_mm_spent", 0.3, 0.0103, 1.02))]
        synthetic.write_run(self.folder, [*bounds, strayed(answer("free", 60, method="cgal.remesh_free", kernel_s=0.02), 4.0)],
                            {**synthetic.CONTEST, "charts": ["quality_time", "quality_distance"]})
        drawn = {}
        with mock.patch.object(contest_charts, "save", lambda figure, _, name: drawn.update({name: figure}) or [name]):
            charts.draw_charts(records.read_run(self.folder), None, self.folder / "charts")
        for figure in drawn.values():
            renderer = figure.canvas.get_renderer()
            ax = figure.axes[0]
            boxes = [Text.get_window_extent(text, renderer) for text in ax.texts if text.get_gid() == point_names.NAME]
            self.assertEqual(len(boxes), 4)
            frame = ax.get_window_extent(renderer)
            for place, box in enumerate(boxes):
                self.assertAlmostEqual(point_names.shared_area(box, frame), box.width * box.height, delta=1.0)
                for other in [*boxes[:place], *point_names.marks_of(ax, figure.dpi / 72)]:
                    self.assertLess(point_names.shared_area(box, other), 1.0)

    def test_the_same_records_give_the_same_bytes(self):
        synthetic.write_run(self.folder, self.CURVE, synthetic.CONTEST)
        self.assertEqual(self.report()[0], 0)
        first = self.charts()
        self.assertEqual(set(first), {"quality_time_kidney.svg", "quality_time_kidney.png"})
        self.report()
        self.assertEqual(first, self.charts())


if __name__ == "__main__":
    unittest.main()
