"""Error against work on made-up records: what is on the frontier, times at equal error, targets, charts."""

import json
import unittest

from support import ReportTest
import synthetic
from deform import soonest
from deform.frontier import read_points
from shared import records
from synthetic import deformed, reference_record

PLAN = {**synthetic.DEFORM, "beside": None, "scenes": ["bar"],
        "contestants": [{"label": "quick"}, {"label": "middle"}, {"label": "exact"}, {"label": "bad"}],
        "frontier": {"families": {"ours": ["quick", "middle", "bad"], "theirs": ["exact"]}, "against": ["theirs"], "at": [0.1, 0.02],
                     "targets": [{"work": "first", "against": "theirs", "at": 0.1, "factor": 20}]}}


def repeats(label, error, seconds, count=9, spread=0.01, scene="bar", answer_s=None, **other):
    """Answers with that error; times spread evenly by that share to either side."""
    lines = []
    for repeat in range(count):
        share = 1 + spread * (2 * repeat / max(1, count - 1) - 1)
        line = deformed(scene, label, error, seconds=seconds * share, repeat=repeat, **other)
        line["judge"]["displacement_deformation"] = error
        if answer_s is not None:
            line["report"]["answer_s"] = answer_s * share
        lines.append(line)
    return lines


def reference(scene="bar", own=0.001):
    return reference_record(scene, own=own, reference_error_deformation=own)


class FrontierTest(ReportTest):
    def run_frontier(self, lines, *arguments, **plan):
        synthetic.write_run(self.folder, lines, {**PLAN, **plan})
        code, out, err = self.report(*(arguments or ("--no-charts",)))
        self.assertEqual((code, err), (0, ""))
        return {row["label"]: row for row in self.table("frontier.csv")}, out


class Points(FrontierTest):
    def test_what_is_surely_slower_and_no_better_is_off(self):
        points, out = self.run_frontier([reference(), *repeats("quick", 0.08, 0.01), *repeats("middle", 0.05, 0.1),
                                         *repeats("exact", 0.01, 1.0), *repeats("bad", 0.2, 0.5)])
        on = {label for label, row in points.items() if "displacement_deformation" in row["on_first"]}
        self.assertEqual(on, {"quick", "middle", "exact"})
        self.assertIn("palpate run PLAN --case ID", out)
        self.assertTrue(points["bad"]["case"])

    def test_what_is_within_noise_of_the_frontier_is_on_it(self):
        # 3% slower with times that spread by 20%: nobody can tell.
        points, _ = self.run_frontier([reference(), *repeats("quick", 0.05, 0.1, spread=0.2), *repeats("bad", 0.05, 0.103, spread=0.2)])
        self.assertIn("displacement_deformation", points["bad"]["on_first"])
        # The same with times that spread by 0.1%: it is beaten.
        points, _ = self.run_frontier([reference(), *repeats("quick", 0.05, 0.1, spread=0.001), *repeats("bad", 0.05, 0.103, spread=0.001)])
        self.assertNotIn("displacement_deformation", points["bad"]["on_first"])

    def test_an_error_within_what_the_references_leave_open_beats_nobody(self):
        lines = [*repeats("quick", 0.05, 0.1, spread=0.2), *repeats("bad", 0.051, 0.101, spread=0.2)]
        points, _ = self.run_frontier([reference(own=0.001), *lines])
        self.assertIn("displacement_deformation", points["bad"]["on_first"])
        points, _ = self.run_frontier([reference(own=0.0001), *lines])
        self.assertNotIn("displacement_deformation", points["bad"]["on_first"])

    def test_a_simulated_second_counts_its_set_up_apart(self):
        lines = [reference(), *repeats("quick", 0.05, 1.0, spread=0.001), *repeats("exact", 0.05, 1.0, spread=0.001)]
        for line in lines[1:]:
            is_modes = line["label"] == "quick"
            line["report"] |= {"simulated_second_s": 0.01 if is_modes else 0.5, "identify_s": 4.0 if is_modes else 0.2,
                               "step_engine": "modes" if is_modes else "tets"}
            line["solved_on"] = {**line.get("solved_on", {}), "simplify_s": 0.3}
        points, out = self.run_frontier(lines)
        self.assertAlmostEqual(float(points["quick"]["second_s"]), 0.01)
        self.assertAlmostEqual(float(points["quick"]["second_setup_s"]), 4.31)
        self.assertAlmostEqual(float(points["exact"]["second_setup_s"]), 1.0)
        on = [{label for label, row in points.items() if "displacement_deformation" in row[f"on_{work}"]} for work in ("second", "second_setup")]
        self.assertEqual(on, [{"quick"}, {"exact"}])
        self.assertIn("Stepped by modes: quick. Their errors are those of the body at rest", out.replace("\n", " "))
        for line in lines[1:]:
            del line["report"]["identify_s"]
            line["report"]["step_engine"] = "tets"
        points, out = self.run_frontier(lines)
        self.assertEqual((points["quick"]["second_setup_s"], points["quick"]["on_second_setup"]), ("", ""))
        self.assertNotIn("Stepped by modes", out)

    def test_too_few_repeats_beat_nobody(self):
        points, _ = self.run_frontier([reference(), *repeats("quick", 0.05, 0.1, count=3), *repeats("bad", 0.05, 9.0, count=3)])
        self.assertIn("displacement_deformation", points["bad"]["on_first"])

    def test_what_was_left_out_by_halving_is_off_and_named(self):
        lines = [reference(), *repeats("quick", 0.05, 0.1), *repeats("bad", 0.2, 0.5, count=3), *repeats("exact", 0.01, 1.0)]
        case = next(line["case"] for line in lines if line["label"] == "bad")
        synthetic.write_run(self.folder, lines, PLAN)
        provenance = json.loads((self.folder / "provenance.json").read_text())
        provenance["repeats_ended"] = {case: {"reason": "halved", "repeats": 3, "width": None, "by": "bar/quick"}}
        provenance["repeats_of"] = {case: 3}
        (self.folder / "provenance.json").write_text(json.dumps(provenance))
        code, out, _ = self.report("--no-charts")
        self.assertEqual(code, 0)
        points = {row["label"]: row for row in self.table("frontier.csv")}
        self.assertEqual((points["bad"]["on_first"], points["bad"]["halved_by"]), ("", "bar/quick"))
        self.assertEqual(points["quick"]["halved_by"], "")
        self.assertIn("Halving: 1 of 3 points", out)

    def test_the_simplifier_belongs_to_a_first_answer_and_not_to_a_further_one(self):
        sweep = {"simplify": "refined", "tets_removed_ratio": 0.5, "vertices": 1503}
        solved = {"name": "bar", "vertices": 700, "tets": 3000, "hash": "1", "ideal_volume": 1.0, "simplify_s": 0.25}
        points, _ = self.run_frontier([reference_record("bar", sweep={"vertices": 1503}), *repeats("quick", 0.05, 0.1, answer_s=0.001, sweep=sweep, solved_on=solved)])
        self.assertAlmostEqual(float(points["quick"]["first_s"]), 0.35)
        self.assertAlmostEqual(float(points["quick"]["further_s"]), 0.001)
        self.assertEqual((points["quick"]["mesh"], points["quick"]["tets"]), ("1503, refined -50%", "3000"))

    def test_what_gave_no_answer_is_kept_and_shown_apart(self):
        points, out = self.run_frontier([reference(), *repeats("quick", 0.05, 0.1), deformed("bar", "bad", None)])
        self.assertEqual((points["bad"]["first_s"], points["bad"]["on_first"]), ("", ""))
        self.assertIn("its outcome is diverged", points["bad"]["note"])
        self.assertIn("Not on any frontier", out)


class Standing(FrontierTest):
    def test_each_family_is_told_what_it_is_good_for_and_what_to_take_elsewhere(self):
        lines = [reference(), reference("ball"), *repeats("quick", 0.08, 0.01), *repeats("exact", 0.01, 1.0),
                 *repeats("middle", 0.05, 0.2, scene="ball"), *repeats("exact", 0.04, 0.1, scene="ball")]
        _, out = self.run_frontier(lines, scenes=["bar", "ball"])
        rows = {row["family"]: row for row in self.table("standing.csv") if row["work"] == "first"}
        self.assertEqual([(row["scenes"], row["scenes_on_frontier"], row["good_for"], row["elsewhere"]) for row in (rows["ours"], rows["theirs"])],
                         [("2", "1", "8.00% in 10 ms", "theirs, 2 times as fast"), ("2", "2", "1.00 to 4.00% in 100 ms to 1 s", "")])
        self.assertIn("What each family is good for", out)
        self.assertEqual([row for row in self.table("standing.csv") if row["work"] == "second"], [])


class OfSimplifiers(FrontierTest):
    def test_a_family_may_be_the_meshes_that_a_simplifier_left(self):
        frontier = {**PLAN["frontier"], "of": "simplifiers", "families": {"as it is": ["none"], "ours": ["one"], "theirs": ["other"]}}
        lines = [reference(), *repeats("quick", 0.08, 1.0)]
        for simplify, seconds in (("one", 0.1), ("other", 0.4)):
            lines += repeats("quick", 0.08, seconds, sweep={"simplify": simplify, "tets_removed_ratio": 0.5})
        _, out = self.run_frontier(lines, frontier=frontier)
        rows = {row["family"]: row for row in self.table("equal_error.csv") if row["work"] == "first" and float(row["error"]) == 0.1}
        self.assertEqual(set(rows), {"as it is", "ours", "theirs"})
        self.assertAlmostEqual(float(rows["theirs"]["time_s"]) / float(rows["ours"]["time_s"]), 4, delta=0.1)
        self.assertIn("ours", out)
        self.assertFalse((self.folder / "tables" / "element_steps.csv").exists())

    def test_elements_times_steps_are_counted_without_a_time(self):
        frontier = {**PLAN["frontier"], "of": "simplifiers", "families": {"as it is": ["none"], "ours": ["one"], "theirs": ["other"]}}
        lines = [reference(), *repeats("quick", 0.01, 1.0)]
        for simplify, error in (("one", 0.08), ("other", 0.05)):
            lines += repeats("quick", error, 0.1, sweep={"simplify": simplify, "tets_removed_ratio": 0.5})
        counts = {None: (9000, 1e-4), "one": (3000, 2e-4), "other": (4500, 1e-4)}
        for line in lines[1:]:
            tets, step = counts[line.get("sweep", {}).get("simplify")]
            line["solved_on"] = {**line.get("solved_on", {}), "tets": tets}
            line["report"]["explicit_step_s"] = step
        _, out = self.run_frontier(lines, frontier=frontier)
        rows = {(row["family"], float(row["error"])): row for row in self.table("element_steps.csv")}
        self.assertEqual({family for family, error in rows if error == 0.1}, {"as it is", "ours", "theirs"})
        self.assertEqual({family for family, error in rows if error == 0.02}, {"as it is"})  # too far off is not counted
        self.assertAlmostEqual(float(rows[("ours", 0.1)]["element_steps"]), 3000 / (0.9 * 2e-4), places=3)
        self.assertEqual(rows[("ours", 0.1)]["times_as_few_as"], "theirs=3")
        self.assertEqual(rows[("theirs", 0.1)]["times_as_few_as"], "")
        self.assertIn("times as few as theirs", out)


class Verdict(FrontierTest):
    """Who comes soonest, in a sentence."""

    def sentence(self, lines, **frontier):
        run = records.read_run(synthetic.write_run(self.folder, lines, {**PLAN, "frontier": {**PLAN["frontier"], **frontier}}))
        return soonest.sentence(run, read_points(run))

    def test_it_is_said_scene_by_scene_at_the_error_of_the_target(self):
        lines = [reference(), reference("ball"), *repeats("quick", 0.08, 0.01), *repeats("quick", 0.015, 0.1, scene="ball"), *repeats("exact", 0.01, 1.0),
                 *repeats("exact", 0.01, 0.02, scene="ball")]
        self.assertEqual(self.sentence(lines, targets=[]), "At an error of at most 10% the first answer comes soonest from ours on bar, nu 0.25 (10 ms), from theirs on ball, nu 0.25 (20 ms).")
        self.assertEqual(self.sentence(lines, targets=[{"work": "first", "against": "theirs", "at": 0.02, "factor": 2}]),
                         "At an error of at most 2% the first answer comes soonest from theirs on bar, nu 0.25 (1 s) and ball, nu 0.25 (20 ms).")

    def test_figures_that_are_the_same_as_shown_have_no_winner(self):
        lines = [reference(), *repeats("quick", 0.08, 0.01), *repeats("exact", 0.01, 0.010001)]
        self.assertIn("from ours and theirs alike on bar, nu 0.25 (10 ms).", self.sentence(lines))

    def test_many_scenes_are_counted_and_those_without_an_answer_are_said(self):
        scenes = [f"s{number}" for number in range(6)]
        lines = [line for place, scene in enumerate(scenes) for line in (reference(scene), *repeats("quick", 0.08 if place else 0.3, 0.01 * (1 + place), scene=scene))]
        self.assertEqual(self.sentence(lines), "At an error of at most 10% the first answer comes soonest from ours on 5 of 6 scenes, at 40 ms (20 ms to 60 ms); none comes within it on 1 of 6 scenes.")

    def test_where_no_time_was_taken_elements_times_steps_are_said(self):
        lines = [reference()]
        for simplify, tets in (("one", 3000), ("other", 4500)):
            line = deformed("bar", "quick", 0.08, sweep={"simplify": simplify, "tets_removed_ratio": 0.5})
            line["judge"]["displacement_deformation"] = 0.08
            line |= {"kernel_s": None, "solved_on": {"tets": tets}, "report": {"explicit_step_s": 2e-4}}
            lines.append(line)
        self.assertEqual(self.sentence(lines, of="simplifiers", families={"ours": ["one"], "theirs": ["other"]}),
                         "At an error of at most 10% the fewest tetrahedra times steps of a simulated second come from ours on bar, nu 0.25 (16.7 million).")
        self.assertEqual(self.sentence([reference(), deformed("bar", "quick", None)]), "No model came within an error that the plan names.")


class EqualError(FrontierTest):
    def lines(self):
        return [reference(), *repeats("quick", 0.08, 0.01), *repeats("middle", 0.015, 0.1), *repeats("exact", 0.01, 1.0)]

    def test_each_family_is_taken_at_its_fastest(self):
        _, out = self.run_frontier(self.lines())
        rows = {(row["family"], row["error"]): row for row in self.table("equal_error.csv") if row["work"] == "first"}
        self.assertEqual(rows[("ours", "0.1")]["label"], "quick")
        self.assertEqual(rows[("ours", "0.02")]["label"], "middle")
        self.assertAlmostEqual(float(rows[("ours", "0.1")]["times_as_fast_as"].split("=")[1]), 100.0, places=6)
        self.assertAlmostEqual(float(rows[("ours", "0.02")]["times_as_fast_as"].split("=")[1]), 10.0, places=6)
        self.assertIn("times as fast as theirs", out)

    def test_targets_say_what_was_found(self):
        _, out = self.run_frontier(self.lines())
        line = next(line for line in out.splitlines() if line.startswith("first answer at 10.0%"))
        self.assertEqual(line.split()[-3:], ["20", "100", "yes"])
        slow = [*self.lines()[:10], *repeats("exact", 0.01, 0.15)]
        _, out = self.run_frontier(slow)
        line = next(line for line in out.splitlines() if line.startswith("first answer at 10.0%"))
        self.assertEqual(line.split()[-1], "no")

    def test_a_target_without_a_pair_is_open(self):
        _, out = self.run_frontier([reference(), *repeats("quick", 0.08, 0.01)])
        line = next(line for line in out.splitlines() if line.startswith("first answer at 10.0%"))
        self.assertIn("open", line)
        self.assertIn("no pair on 1 of 1 scenes", line)


class Charts(FrontierTest):
    def test_one_a_scene_and_measure_with_the_same_bytes_twice(self):
        lines = [reference(), *repeats("quick", 0.08, 0.01, answer_s=0.001), *repeats("exact", 0.01, 1.0), deformed("bar", "bad", None)]
        self.run_frontier(lines, "--no-charts")
        drawn = []
        for _ in range(2):
            self.assertEqual(self.report()[0], 0)
            drawn.append({name: data for name, data in self.charts().items() if name.startswith("frontier")})
        self.assertIn("frontier_bar__nu_0.25.svg", drawn[0])
        self.assertEqual(drawn[0], drawn[1])


if __name__ == "__main__":
    unittest.main()
