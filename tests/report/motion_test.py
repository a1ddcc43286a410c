"""The report of a contest of motions, on made-up records and histories."""

import json
import math
import os
import unittest

from support import ReportTest
import synthetic
from motion import motion, motion_page
from shared import records

PLAN = {"question": "How far off?", "contest": "motion", "scenes": ["bar"], "contestants": [{"method": "moving_springs.a", "label": "a"},
                                                                                           {"method": "moving_springs.b", "label": "b"}]}
OWN = {"probe_l2": 0.01, "force_l2": 0.001, "frequency_first": 0.0001, "frequency_mean": 0.0002, "frequency_worst": 0.0005,
       "amplitude_error": 0.001, "phase_error_deg": 0.1, "decay_error": 0.002}


def history(folder, name, hz, decay, force=True):
    lines = ["time_s,kinetic_j,elastic_j,load_j,total_j," + ("tool_1_fx_n,tool_1_fy_n,tool_1_fz_n," if force else "") +
             "probe_1_ux_m,probe_1_uy_m,probe_1_uz_m"]
    for k in range(101):
        t = 0.01 * k
        lines.append(f"{t},0,0,0,0," + (f"0,{math.sin(t)},0," if force else "") + f"0,0,{1e-3 * math.exp(-decay * t) * math.cos(hz * t)}")
    path = folder / "histories" / name
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")
    return f"histories/{name}"


def moved(label, file, errors, **other):
    judge = {"valid": True, "findings": [], "frequencies_hz": [1.0], "reference_own_error": OWN, **errors}
    report = {"outcome": "completed", "steps": 1200, "time_step_s": 1e-3, "integrator": "symplectic_euler", "solve_s": 0.5}
    line = synthetic.record("bar", label, None, judge=judge, report=report, contestant=f"moving_springs.{label}", case=f"bar/{label}",
                            mesh_file=file, scene={"name": "bar", "window_s": [0.2, 1.0]})
    return {**line, **other}


def reference(file):
    judge = {"valid": True, "findings": [], "kind": "motion", "frequencies_hz": [1.0, 2.5], "own_error": OWN,
             "runs": [{"refine": 1, "kernel_s": 3.0, "from_cache": False,
                       "report": {"method": "moving_fem.p2", "dofs": 999, "time_step_s": 2e-3}}]}
    return synthetic.record("bar", "reference", None, judge=judge, contestant=None, case="bar/reference", mesh_file=file,
                            scene={"name": "bar", "window_s": [0.2, 1.0]})


class Motion(ReportTest):
    A = {"probe_l2": 0.2, "force_l2": 0.05, "frequency_first": 0.01, "frequency_mean": 0.02, "frequency_worst": 0.04,
         "amplitude_error": -0.3, "phase_error_deg": -12.0, "decay_error": 0.5}
    B = {"probe_l2": 0.02, "force_l2": 0.02, "frequency_first": 0.02, "frequency_mean": 0.03, "frequency_worst": 0.05,
         "amplitude_error": 0.1, "phase_error_deg": 3.0, "unexplained": 0.03, "reference_oscillation": {"unexplained": 0.015}}

    def write(self, *more):
        self.folder.mkdir(parents=True, exist_ok=True)
        files = [history(self.folder, f"{name}.csv", hz, 0.5) for name, hz in (("reference", 12.0), ("a", 13.0), ("b", 12.2))]
        synthetic.write_run(self.folder, [reference(files[0]), moved("b", files[2], self.B), moved("a", files[1], self.A), *more], PLAN)
        code, self.printed, err = self.report()
        self.assertEqual((code, err), (0, ""))
        return {row["label"]: row for row in self.table("motion.csv")}

    def test_rows_in_the_plans_order_with_signs(self):
        rows = self.write()
        self.assertEqual(list(rows), ["a", "b"])
        self.assertEqual((float(rows["a"]["probe_l2"]), float(rows["a"]["own_probe_l2"])), (0.2, 0.01))
        self.assertEqual(rows["b"]["decay_error"], "")
        self.assertIn("-30.0", self.printed)
        self.assertIn("-12.0", self.printed)
        self.assertIn("999 unknowns", self.printed)
        self.assertIn("1, 2.5 Hz", self.printed)

    def test_what_the_reference_cannot_tell_is_marked(self):
        self.write()
        self.assertRegex(self.printed, r"2\.00~")  # twice the reference's own error: whether it is the least, nobody can tell
        self.assertNotRegex(self.printed, r"\*~|20\.0\*")
        self.assertRegex(self.printed, r"4\.00\*")
        self.assertNotRegex(self.printed, r"20\.0~")

    def test_what_a_fit_leaves_over_is_shown_and_not_ranked(self):
        rows = self.write(moved("c", None, {"probe_l2": 0.5, "unexplained": 0.71}))
        self.assertEqual([float(rows[label]["unexplained"] or -1) for label in "abc"], [-1, 0.03, 0.71])
        self.assertEqual(float(rows["b"]["own_unexplained"]), 0.015)
        self.assertEqual(rows["c"]["amplitude_error"], "")
        self.assertRegex(self.printed, r"3\.00 ")
        self.assertNotRegex(self.printed, r"3\.00[*~]|71\.0[*~]")

    def test_what_gave_no_answer_keeps_its_row(self):
        failed = moved("c", None, {}, outcome="bad_input", judge=None, report=None, message="a step over the bound", kernel_s=None)
        rows = self.write(failed)
        self.assertEqual((rows["c"]["probe_l2"], rows["c"]["note"]), ("", "bad_input: a step over the bound"))

    def test_charts_of_errors_and_histories_are_the_same_twice(self):
        self.write()
        first = self.charts()
        self.assertEqual(sorted(first), [f"motion_{kind}_bar.{end}" for kind in ("errors", "force", "probe") for end in ("png", "svg")])
        self.write()
        self.assertEqual(self.charts(), first)

    def test_a_history_that_is_none_is_named_and_not_drawn(self):
        self.write()
        header = "time_s,probe_1_ux_m,probe_1_uy_m,probe_1_uz_m\n"
        for text in ("time_s\nsoon\n", "", header, header + "0,0,0\n", header + "0,0,0,nan\n", header + "x" * 200_000, "probe_1_uz_m\n1\n", "\xff"):
            (self.folder / "histories" / "a.csv").write_text(text, encoding="latin-1")
            code, said, err = self.report()
            self.assertEqual((code, err), (0, ""), text[:80])
            self.assertIn("not drawn: histories/a.csv", " ".join(said.split()))
        os.truncate(self.folder / "histories" / "a.csv", 2**30)
        self.assertIn("536,870,912 bytes", self.report()[1])
        os.remove(self.folder / "histories" / "a.csv")

    def verdict(self):
        return motion_page.verdict_of(motion.read_sections(records.read_run(self.folder)))

    def test_the_verdict_names_nobody_nearest_whom_the_reference_cannot_tell(self):
        self.write(moved("c", None, {"probe_l2": 0.3}))  # b is at 2%, twice the reference's own error
        self.assertEqual(self.verdict(), ("The reference cannot tell who is nearest to elastodynamics over 1 problem: b (2%) is within 5 times its own error; "
                                          "of what it tells apart the nearest is a: its probe is off by 20% (median).", "open"))
        synthetic.write_run(self.folder, [reference(None), moved("a", None, self.A), moved("c", None, {"probe_l2": 0.3}), moved("d", None, {"probe_l2": 0.2001})], PLAN)
        self.assertEqual(self.verdict(), ("Nearest to elastodynamics over 1 problem is a and d alike: their probe is off by 20% (median), where c is off by 30%.", "plain"))

    def bodies(self):
        """What the page shows in 3D, by title, and what it says of what it does not."""
        run = records.read_run(self.folder)
        return {body.title: body for body in motion_page.bodies_of(run, motion.read_sections(run))}, " ".join(run.notes)

    def keep_states(self, name, states):
        (self.folder / "histories" / f"{name}.states.json").write_text(
            json.dumps({"schema": "palpate/states/1", "states": [{"time_s": time, "displacement_m": field} for time, field in states]}), encoding="utf-8")

    def test_states_beside_a_history_are_played_and_broken_ones_are_said(self):
        synthetic.write_mesh(self.folder / "problems" / "bar" / "in.mesh", [(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)], [(0, 1, 2, 3)])
        self.write()
        self.assertEqual([body.group for body in self.bodies()[0].values()], ["Bodies at rest"])
        self.keep_states("a", [(0.0, [0.0] * 12), (0.5, [0.1] * 12), (1.0, [0.0] * 12)])
        self.keep_states("b", [(0.0, [0.0] * 12), (1.0, [0.1] * 9)])  # of a mesh of three vertices: another one
        found, notes = self.bodies()
        self.assertEqual([(title, [time for time, _ in body.moves]) for title, body in found.items()], [("a", [0.0, 0.5, 1.0])])
        self.assertNotIn("not played", notes)
        for broken in ("{", "[]", '{"states": [{"time_s": 0, "displacement_m": [NaN]}]}', '{"states": 3}', '{"states": [{"time_s": "now"}]}'):
            (self.folder / "histories" / "b.states.json").write_text(broken, encoding="utf-8")
            found, notes = self.bodies()
            self.assertEqual(list(found), ["a"], broken)
            self.assertIn("not played: histories/b.states.json", notes, broken)

    def test_motions_on_a_simplified_mesh_are_played_beside_each_other_on_it(self):
        place = "bar/simplify=refined/tets_removed_ratio=0.5"
        synthetic.write_mesh(self.folder / "problems" / "bar" / "in.mesh", [(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1), (1, 1, 1)], [(0, 1, 2, 3), (1, 2, 3, 4)])
        synthetic.write_mesh(self.folder / "problems" / place / "in.mesh", [(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)], [(0, 1, 2, 3)])
        on = {"sweep": {"simplify": "refined", "tets_removed_ratio": 0.5}, "solved_on": {"name": place, "vertices": 4, "tets": 1}}
        self.write(*(moved(label, history(self.folder, f"{label}_few.csv", 12.0, 0.5), self.A, case=f"bar/{label}/simplify=refined", **on) for label in "ab"))
        self.keep_states("a", [(0.0, [0.0] * 15), (1.0, [0.1] * 15)])
        for label in "ab":
            self.keep_states(f"{label}_few", [(0.0, [0.0] * 12), (1.0, [0.1] * 12)])
        run = records.read_run(self.folder)
        bodies = list(motion_page.bodies_of(run, motion.read_sections(run)))
        whole = "bar, 1,500 vertices"
        few = f"{whole}, simplify=refined, tets_removed_ratio=0.5"
        self.assertEqual([(body.group, body.title, len(body.mesh.points), len(body.moves)) for body in bodies],
                         [(whole, "a", 5, 2), (few, "a (refined -50%)", 4, 2), (few, "b (refined -50%)", 4, 2)])

    def test_without_histories_there_are_still_errors(self):
        synthetic.write_run(self.folder, [reference(None), moved("a", None, self.A)], PLAN)
        code, _, err = self.report()
        self.assertEqual((code, err), (0, ""))
        self.assertEqual(sorted(self.charts()), ["motion_errors_bar.png", "motion_errors_bar.svg"])


if __name__ == "__main__":
    unittest.main()
