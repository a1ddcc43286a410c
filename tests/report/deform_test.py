"""The report of a contest of displacements on made-up records: marks, targets, refinement, sets, charts."""

import types
import unittest

from support import ReportTest
import synthetic
from deform import deform, deform_charts, deform_page
from shared import records
from synthetic import deformed, reference_record


class DeformTest(ReportTest):
    def run_deform(self, lines, **plan):
        """The rows of displacement.csv by label, and what the report prints."""
        synthetic.write_run(self.folder, lines, {**synthetic.DEFORM, **plan})
        code, out, err = self.report("--no-charts")
        self.assertEqual((code, err), (0, ""))
        return {row["label"]: row for row in self.table("displacement.csv")}, out

    def line_of(self, out, label):
        return next(line for line in out.splitlines() if line.split()[:1] == [label])


class Bodies(DeformTest):
    POINTS = [(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1), (1, 1, 1)]

    def write_field(self, name, values):
        path = self.folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text("vertex,ux_m,uy_m,uz_m\n" + "".join(f"{k},0,0,{value}\n" for k, value in enumerate(values)), encoding="utf-8")
        return name

    def test_answers_on_a_simplified_mesh_are_shown_on_it_behind_those_on_the_whole_one(self):
        place = "bar/simplify=refined/tets_removed_ratio=0.5"
        synthetic.write_mesh(self.folder / "problems" / "bar" / "in.mesh", self.POINTS, [(0, 1, 2, 3), (1, 2, 3, 4)])
        synthetic.write_mesh(self.folder / "problems" / place / "in.mesh", self.POINTS[:4], [(0, 1, 2, 3)])
        self.write_field("references/bar.csv", [0, 0, 0, 0, 1e-3])
        whole = self.write_field("displacements/bar/a.csv", [0, 0, 0, 0, 3e-3])
        few = self.write_field("displacements/bar/a_few.csv", [0, 0, 0, 1e-3])
        sweep = {"simplify": "refined", "tets_removed_ratio": 0.5}
        lines = [reference_record("bar"), deformed("bar", "a", 0.05, sweep=sweep, case="bar/a/simplify=refined/tets_removed_ratio=0.5", mesh_file=few,
                                                   solved_on={"name": place, "vertices": 4, "tets": 1}),
                 deformed("bar", "a", 0.02, case="bar/a", mesh_file=whole)]
        self.run_deform(lines)
        bodies = list(deform_page.bodies_of(records.read_run(self.folder)))
        self.assertEqual([(body.group, body.title, len(body.mesh.points)) for body in bodies],
                         [("bar", "reference", 5), ("bar", "a", 5), ("bar, simplify=refined, tets_removed_ratio=0.5", "a", 4)])
        self.assertEqual([[field.title for field in body.fields] for body in bodies[1:]], [["error against the reference", "quality"], ["quality"]])
        self.assertAlmostEqual(bodies[1].fields[0].values.max(), 2.0)  # mm
        self.assertAlmostEqual(bodies[2].displacement[3][2], 1e-3)
        of_few = "bar/a/simplify=refined/tets_removed_ratio=0.5"
        self.assertEqual([body.case for body in bodies], ["", "bar/a", of_few])  # as the rows of charts name them
        self.assertEqual([body.case for body in deform_page.bodies_of(records.read_run(self.folder), {of_few})], [of_few, "", "bar/a"])


class Rows(DeformTest):
    def test_errors_times_and_finite_elements_stand_side_by_side(self):
        rows, out = self.run_deform([reference_record("bar"), deformed("bar", "isotropy", 0.02, seconds=0.01),
                                     deformed("bar", "p1", 0.08, method="fem.p1", seconds=0.2)])
        self.assertEqual(float(rows["isotropy"]["displacement_l2"]), 0.02)
        self.assertAlmostEqual(float(rows["isotropy"]["times_p1"]), 0.25)
        self.assertAlmostEqual(float(rows["isotropy"]["identify_s"]), 0.003)
        line = self.line_of(out, "isotropy")
        for text in ("2.00*", "3.00*", "4.00*", "0.25", "10.00 ms*"):
            self.assertIn(text, line)
        self.assertIn("bar, nu 0.25, 1,503 vertices", out)

    def test_the_reference_is_no_contestant_and_is_described(self):
        rows, out = self.run_deform([reference_record("bar", own=0.0021), deformed("bar", "isotropy", 0.05)])
        self.assertEqual(list(rows), ["isotropy"])
        self.assertIn("reference: extrapolated, 3 levels, order 2.10; its own error in %: L2 0.210, energy 0.840, max 0.420", out)
        reference = self.table("references.csv")[0]
        self.assertEqual((reference["scene"], reference["order"], reference["reference_error"]), ("bar", "2.1", "0.0021"))

    def test_the_least_is_marked_and_the_least_without_finite_elements(self):
        rows, out = self.run_deform([reference_record("bar"), deformed("bar", "a", 0.02), deformed("bar", "b", 0.03),
                                     deformed("bar", "p2", 0.01, method="fem.p2", seconds=1.0)])
        self.assertIn("displacement_l2", rows["p2"]["best_in"])
        self.assertIn("displacement_l2", rows["a"]["best_without_finite_elements_in"])
        self.assertIn("kernel_s", rows["a"]["best_in"])
        self.assertEqual(rows["b"]["best_in"], "kernel_s")  # as fast as a
        self.assertIn("+ least without methods of the reference's kind", out)
        self.assertIn("2.00+", self.line_of(out, "a"))

    def test_times_that_are_not_compared_have_no_least(self):
        self.run_deform([reference_record("bar"), deformed("bar", "a", 0.03), deformed("bar", "b", 0.05, seconds=0.1)])
        run = records.read_run(self.folder)
        for repeats, expected in ((9, "*"), (1, "")):
            run.provenance |= {"repeats": repeats, "warmup": 1}
            section, = deform.read_sections(run)
            self.assertEqual([row.marks.get("kernel_s", "") for row in section.rows if row.label == "a"], [expected])

    def test_what_the_reference_cannot_tell_is_marked_figure_by_figure(self):
        # Own errors 0.004, 0.008, 0.016 in L2, max and energy; the answers have 1, 1.5 and 2 times their L2 error.
        rows, out = self.run_deform([reference_record("bar", own=0.004), deformed("bar", "fine", 0.03, own=0.004),
                                     deformed("bar", "good", 0.0199, own=0.004), deformed("bar", "far", 0.05, own=0.004)])
        self.assertEqual(rows["far"]["marked"], "")
        self.assertEqual(rows["fine"]["marked"], "displacement_energy")
        self.assertEqual(rows["good"]["marked"], "displacement_l2 displacement_energy displacement_max")
        self.assertIn("1.99~", self.line_of(out, "good"))
        self.assertIn("not 5 times better", out)

    def test_without_an_estimate_everything_is_marked(self):
        rows, out = self.run_deform([reference_record("bar", own=None, order=None), deformed("bar", "a", 0.5, own=None)])
        self.assertEqual(len(rows["a"]["marked"].split()), 3)
        self.assertIn("its own error in %: not known", out)

    def test_an_answer_that_diverged_keeps_its_row_and_its_reason(self):
        rows, out = self.run_deform([reference_record("bar"), deformed("bar", "a", None, seconds=0.001), deformed("bar", "b", 0.1)])
        self.assertEqual((rows["a"]["displacement_l2"], rows["a"]["best_in"]), ("", ""))
        self.assertIn("its outcome is diverged", self.line_of(out, "a"))

    def test_a_failed_reference_is_said(self):
        _, out = self.run_deform([reference_record("bar", valid=False, kind=None),
                                  deformed("bar", "a", None, outcome="error", judge=None, violations=[],
                                           message="nothing to judge it by")])
        self.assertIn("no reference: level 1 diverged", out)
        self.assertIn("no ref.", self.line_of(out, "a"))
        self.assertIn("nothing to judge it by", self.table("displacement.csv")[0]["note"])

    def test_each_problem_has_its_own_reference_and_its_own_best(self):
        lines = []
        for nu, own in ((0.25, 0.001), (0.45, 0.004)):
            for vertices in (1503, 10000):
                sweep = {"poisson_ratio": nu, "vertices": vertices}
                lines += [reference_record("bar", own, nu, sweep, vertices),
                          deformed("bar", "a", 0.02 if nu < 0.3 else 0.06, nu, sweep, vertices, own),
                          deformed("bar", "b", 0.04, nu, sweep, vertices, own)]
        self.run_deform(lines)
        rows = self.table("displacement.csv")
        best = {(row["poisson_ratio"], row["vertices"], row["label"]) for row in rows if "displacement_l2" in row["best_in"]}
        self.assertEqual(best, {("0.25", "1503", "a"), ("0.25", "10000", "a"), ("0.45", "1503", "b"), ("0.45", "10000", "b")})
        self.assertEqual({row["reference_error_energy"] for row in rows if row["poisson_ratio"] == "0.45"}, {"0.016"})

    def test_times_are_medians_over_the_repeats(self):
        rows, _ = self.run_deform([reference_record("bar")] + [deformed("bar", "a", 0.02, seconds=seconds, repeat=i)
                                                               for i, seconds in enumerate((0.03, 0.01, 0.5))])
        self.assertEqual(float(rows["a"]["kernel_s"]), 0.03)

    def test_the_tables_of_simplifiers_are_not_written(self):
        self.run_deform([reference_record("bar"), deformed("bar", "a", 0.02)])
        self.assertEqual({path.name for path in (self.folder / "tables").iterdir()},
                         {"displacement.csv", "displacement.txt", "displacement_sets.csv", "references.csv"})

    def test_a_run_without_answers_is_no_crash(self):
        synthetic.write_run(self.folder, [reference_record("bar")], synthetic.DEFORM)
        code, out, _ = self.report()
        self.assertEqual(code, 0)
        self.assertIn("no records", out)
        self.assertIn("no charts", out)


class Deformation(DeformTest):
    """The errors that show deformation stand beside the L2 error, each with the reference's own."""

    def judged(self, label, l2, **more):
        line = deformed("pad", label, l2)
        line["judge"] |= {"displacement_deformation": 4 * l2, "displacement_energy_whole": 10 * l2, "rigid_share": 0.9, **more}
        line["report"] |= {"stiffness_share_springs": 0.12}
        return line

    def test_all_errors_stand_side_by_side(self):
        rows, out = self.run_deform([reference_record("pad", reference_error_deformation=0.001, reference_error_pad_force=0.001),
                                     self.judged("a", 0.01, pad_force=0.003)])
        header = next(line for line in out.splitlines() if line.startswith("label"))
        self.assertEqual(header.split()[:13:2], ["label", "%", "%", "%", "%", "%", "%"])
        self.assertEqual(header.split()[1:13:2], ["L2", "deform", "energy", "whole", "max", "pad"])
        self.assertEqual(self.line_of(out, "a").split()[1:8], ["1.00", "4.00", "2.00", "10.0~", "1.50", "0.300~", "12"])
        self.assertEqual(rows["a"]["marked"], "displacement_energy_whole pad_force")
        self.assertEqual(rows["a"]["stiffness_share_springs"], "0.12")

    def test_sets_have_root_mean_square_and_worst_of_each(self):
        self.run_deform([reference_record("pad"), self.judged("a", 0.01), reference_record("other"), deformed("other", "a", 0.03)])
        row = self.table("displacement_sets.csv")[0]
        self.assertAlmostEqual(float(row["displacement_deformation_rms"]), 0.04)  # the scene that has none does not count
        self.assertAlmostEqual(float(row["displacement_max_rms"]), 1.5 * ((0.01**2 + 0.03**2) / 2) ** 0.5)
        self.assertEqual(row["displacement_max_worst"], "0.045")
        self.assertEqual(row["pad_force_rms"], "")

    def test_a_target_may_bound_the_deformation(self):
        targets = [{"text": "shape", "labels": ["a"], "measure": "displacement_deformation", "at_most": 0.03}]
        _, out = self.run_deform([reference_record("pad", reference_error_deformation=0.001), self.judged("a", 0.01)], targets=targets)
        row = self.table("targets.csv")[0]
        self.assertEqual((row["state"], row["worst"], row["measure"]), ("missed", "0.04", "displacement_deformation"))
        self.assertIn("deform", next(line for line in out.splitlines() if "shape" in line))


class Sets(DeformTest):
    LINES = [line for scene, error in (("one", 0.03), ("two", 0.04), ("three", 0.3))
             for line in (reference_record(scene), deformed(scene, "a", error), deformed(scene, "p1", 0.1, method="fem.p1"))]

    def sets(self, **plan):
        self.run_deform(self.LINES, **plan)
        return {(row["set"], row["label"]): row for row in self.table("displacement_sets.csv")}

    def test_rms_and_worst_over_each_set(self):
        rows = self.sets(scene_sets={"seen": ["one", "two"], "unseen": ["three"]})
        self.assertAlmostEqual(float(rows["seen", "a"]["rms"]), ((0.03**2 + 0.04**2) / 2) ** 0.5)
        self.assertEqual((rows["seen", "a"]["worst"], rows["seen", "a"]["worst_scene"]), ("0.04", "two"))
        self.assertEqual(float(rows["unseen", "a"]["rms"]), 0.3)
        self.assertEqual(float(rows["unseen", "a"]["p1_worst"]), 0.1)

    def test_without_sets_all_scenes_are_one(self):
        rows = self.sets()
        self.assertEqual(rows["all scenes", "a"]["worst_scene"], "three")

    def test_a_scene_that_was_not_solved_is_counted(self):
        lines = [reference_record("one"), deformed("one", "a", 0.02), reference_record("two"), deformed("two", "a", None)]
        _, out = self.run_deform(lines)
        row = self.table("displacement_sets.csv")[0]
        self.assertEqual((row["scenes"], row["solved"]), ("2", "1"))
        self.assertIn("solved 1 of 2", out)


class Targets(DeformTest):
    def judge(self, lines, **target):
        """The row of the one target."""
        target = {"text": "near enough", "labels": ["a"], "at_most": 0.02, **target}
        _, self.printed = self.run_deform(lines, targets=[target])
        return self.table("targets.csv")[0]

    def problem(self, scene, error, own=0.001, label="a", **other):
        return [reference_record(scene, own, other.get("nu", 0.25), other.get("sweep")), deformed(scene, label, error, own=own, **other)]

    def test_met_if_the_worst_scene_is_within_the_bound(self):
        row = self.judge(self.problem("one", 0.012) + self.problem("two", 0.0189))
        self.assertEqual((row["state"], row["worst"], row["worst_on"]), ("met", "0.0189", "two, nu 0.25"))

    def test_missed_by_how_much(self):
        row = self.judge(self.problem("one", 0.012) + self.problem("two", 0.03))
        self.assertEqual(row["state"], "missed")
        self.assertIn("1.00 over (1.50 x)", self.printed)
        row = self.judge(self.problem("one", 0.012))
        self.assertIn("0.800 under", self.printed)

    def test_finite_elements_stand_beside_it(self):
        row = self.judge(self.problem("one", 0.012) + [deformed("one", "p1", 0.07, method="fem.p1")])
        self.assertEqual(row["p1_worst"], "0.07")

    def test_where_the_reference_cannot_tell_it_is_open(self):
        self.assertEqual(self.judge(self.problem("one", 0.018, own=0.004))["state"], "open")
        self.assertEqual(self.judge(self.problem("one", 0.021, own=0.0045))["state"], "open")
        self.assertEqual(self.judge(self.problem("one", 0.018, own=None))["state"], "open")

    def test_a_margin_smaller_than_the_references_error_is_open_even_if_the_figure_is_not_marked(self):
        for error, state in ((0.0188, "met"), (0.0195, "open"), (0.0205, "open"), (0.0212, "missed")):
            row = self.judge(self.problem("one", error, own=0.001))
            self.assertEqual((row["state"], "open: one" in row["note"]), (state, state == "open"), error)

    def test_answers_that_scatter_across_the_bound_leave_it_open(self):
        def state(errors):
            lines = [reference_record("one", own=0.0001)]
            return self.judge(lines + [deformed("one", "a", error, own=0.0001, seed=i, output_hash=f"h{i}", case=f"one/a/seed={i}")
                                       for i, error in enumerate(errors)])["state"]
        self.assertEqual(state([0.010, 0.011, 0.012, 0.013, 0.014, 0.015]), "met")
        self.assertEqual(state([0.015, 0.016, 0.017, 0.018, 0.019, 0.021]), "open")
        self.assertEqual(state([0.03, 0.04, 0.05, 0.06, 0.07, 0.08]), "missed")
        self.assertEqual(state([0.010, 0.011, 0.012]), "open", "three values have no 95% interval")

    def test_a_target_that_is_required_decides_the_exit_code(self):
        target = {"text": "near enough", "labels": ["a"], "at_most": 0.02, "required": True}
        for error, code, said in ((0.012, 0, ""), (0.0195, 1, "open, 0.0500 under with a"), (0.03, 1, "missed, 1.00 over (1.50 x) with a"),
                                  (None, 1, "missed")):
            synthetic.write_run(self.folder, self.problem("one", error), {**synthetic.DEFORM, "targets": [target]})
            found, out, _ = self.report("--no-charts")
            self.assertEqual(found, code, error)
            wanted = f'required, and does not hold: the target "near enough": {said}'
            self.assertEqual(out.strip().splitlines()[-1] == wanted, code == 1, out[-200:])
        synthetic.write_run(self.folder, self.problem("one", 0.03), {**synthetic.DEFORM, "targets": [{**target, "required": False}]})
        self.assertEqual(self.report("--no-charts")[0], 0)

    def test_where_the_bound_is_outside_of_what_the_reference_leaves_open_it_is_decided(self):
        self.assertEqual(self.judge(self.problem("one", 0.002, own=0.001))["state"], "met")
        self.assertEqual(self.judge(self.problem("one", 0.05, own=0.015))["state"], "missed")

    def test_one_missed_scene_decides_even_if_another_is_open(self):
        self.assertEqual(self.judge(self.problem("one", 0.018, own=0.004) + self.problem("two", 0.05))["state"], "missed")

    def test_a_scene_that_was_not_solved_is_missed_and_one_that_was_not_run_is_open(self):
        row = self.judge(self.problem("one", 0.01) + self.problem("two", None))
        self.assertEqual(row["state"], "missed")
        self.assertIn("not solved: two", row["note"])
        row = self.judge(self.problem("one", 0.01), scenes=["one", "two"])
        self.assertEqual(row["state"], "open")
        self.assertIn("not run: two", row["note"])

    def test_without_a_reference_it_is_open_and_nobody_failed(self):
        failed = {"outcome": "error", "judge": None, "violations": [], "message": "there is nothing to judge it by"}
        lines = self.problem("one", 0.01) + [reference_record("two", valid=False, kind=None), deformed("two", "a", None, **failed)]
        row = self.judge(lines)
        self.assertEqual(row["state"], "open")
        self.assertIn("no reference: two", row["note"])
        row = self.table("displacement_sets.csv")[0]
        self.assertEqual((row["scenes"], row["solved"], row["without_reference"]), ("1", "1", "1"))

    def test_of_several_labels_the_best_over_all_scenes_counts(self):
        lines = self.problem("one", 0.001) + self.problem("two", 0.05)
        lines += [deformed("one", "b", 0.015), deformed("two", "b", 0.015)]
        row = self.judge(lines, labels=["a", "b"])
        self.assertEqual((row["label"], row["state"]), ("b", "met"))

    def test_one_that_solved_fewer_scenes_is_not_the_best(self):
        lines = self.problem("one", 0.001) + self.problem("two", None) + [deformed("one", "b", 0.015), deformed("two", "b", 0.015)]
        self.assertEqual(self.judge(lines, labels=["a", "b"])["label"], "b")

    def test_at_picks_from_the_sweep(self):
        lines = []
        for nu, error in ((0.25, 0.01), (0.45, 0.05)):
            sweep = {"poisson_ratio": nu}
            lines += self.problem("one", error, nu=nu, sweep=sweep)
        self.assertEqual(self.judge(lines, at={"poisson_ratio": 0.25})["state"], "met")
        self.assertEqual(self.judge(lines, at={"poisson_ratio": [0.25, 0.45]})["state"], "missed")
        self.assertEqual(self.judge(lines)["state"], "missed")

    def test_sets_of_scenes_and_other_errors(self):
        lines = self.problem("one", 0.01) + self.problem("two", 0.5)
        _, _ = self.run_deform(lines, scene_sets={"near": ["one"]}, targets=[
            {"text": "t", "labels": "a", "scenes": "near", "measure": "displacement_max", "at_most": 0.0125}])
        row = self.table("targets.csv")[0]  # max is 1.5 times the L2 error
        self.assertEqual((row["state"], row["worst"]), ("missed", "0.015"))

    def test_simplified_meshes_have_no_part_in_targets(self):
        lines = self.problem("one", 0.01, sweep={"simplify": "none"})
        lines += [deformed("one", "a", 0.5, sweep={"simplify": "refined", "tets_removed_ratio": 0.5})]
        self.assertEqual(self.judge(lines)["state"], "met")


class Refined(DeformTest):
    def series(self, errors, owns=None):
        lines = []
        for i, (vertices, error) in enumerate(zip((1000, 8000, 64000), errors)):
            own = owns[i] if owns else 0.001
            sweep = {"vertices": vertices}
            lines += [reference_record("bar", own, 0.25, sweep, vertices), deformed("bar", "a", error, 0.25, sweep, vertices, own)]
        _, self.printed = self.run_deform(lines)
        return [row["step"] for row in self.table("convergence.csv")]

    def test_better_and_worse(self):
        self.assertEqual(self.series((0.16, 0.04, 0.01)), ["", "better", "better"])
        self.assertIn("16.0 > 4.00 > 1.00", self.printed)
        self.assertIn("2.0", self.printed.splitlines()[-1])  # twice as many vertices a side, a quarter of the error
        self.assertEqual(self.series((0.03, 0.05, 0.08)), ["", "worse", "worse"])
        self.assertIn("worse when refined", self.printed)

    def test_what_the_references_cannot_tell(self):
        self.assertEqual(self.series((0.03, 0.031, 0.02)), ["", "unclear", "better"])
        self.assertEqual(self.series((0.03, 0.05, 0.08), (0.001, None, 0.001)), ["", "unclear", "unclear"])
        self.assertIn("the reference cannot tell", self.printed)

    def test_one_size_is_no_series(self):
        self.run_deform([reference_record("bar"), deformed("bar", "a", 0.1)])
        self.assertFalse((self.folder / "tables" / "convergence.csv").exists())


class Charts(DeformTest):
    def test_no_two_labels_look_alike(self):
        row = lambda label, is_reference_kind: types.SimpleNamespace(label=label, is_reference_kind=is_reference_kind)
        section = types.SimpleNamespace(rows=[row(f"{kind}{k}", kind == "fem") for k in range(12) for kind in ("fem", "springs")])
        styles = deform_charts.read_styles([section])
        self.assertEqual(len(set(styles.values())), 24)
        self.assertEqual([styles["fem0"][1], styles["fem1"][1]], ["s", "s"])

    def lines(self):
        lines = []
        for vertices in (1503, 10000):
            for scene in ("bar", "kidney"):
                sweep = {"poisson_ratio": 0.25, "vertices": vertices}
                lines += [reference_record(scene, 0.002, 0.25, sweep, vertices),
                          deformed(scene, "a", 0.02, 0.25, sweep, vertices), deformed(scene, "b", None, 0.25, sweep, vertices),
                          deformed(scene, "p1", 0.07, 0.25, sweep, vertices, method="fem.p1"),
                          deformed(scene, "exact", 0.0, 0.25, sweep, vertices), deformed(scene, "far", 1e9, 0.25, sweep, vertices)]
        return lines

    def draw(self, lines, **plan):
        synthetic.write_run(self.folder, lines, {**synthetic.DEFORM, **plan})
        code, out, err = self.report()
        self.assertEqual((code, err), (0, ""), out)
        return self.charts()

    def test_each_chart_is_drawn_in_both_forms_and_the_same_twice(self):
        first = self.draw(self.lines())
        names = ["convergence_nu_0.25", "error_bars_nu_0.25__1_503_vertices", "error_bars_nu_0.25__10_000_vertices", "error_time"]
        self.assertEqual(sorted(first), sorted(f"{name}.{ending}" for name in names for ending in ("png", "svg")))
        self.assertEqual(self.draw(self.lines()), first)

    def test_the_plan_picks_the_charts_and_old_ones_go(self):
        self.draw(self.lines())
        self.assertEqual(sorted(self.draw(self.lines(), charts=["error_time"])), ["error_time.png", "error_time.svg"])

    def test_simplified_meshes_are_a_heat_map(self):
        lines = [reference_record("bar", sweep={"poisson_ratio": 0.25})]
        for simplify, ratio in (("none", None), ("refined", 0.22), ("refined", 0.5)):
            sweep = {"poisson_ratio": 0.25, "simplify": simplify, **({} if ratio is None else {"tets_removed_ratio": ratio})}
            lines += [deformed("bar", "a", 0.02 + (ratio or 0), sweep=sweep), deformed("bar", "b", None, sweep=sweep)]
        drawn = self.draw(lines, charts=["simplified_error"])
        self.assertEqual(sorted(drawn), ["simplified_error_bar__nu_0.25.png", "simplified_error_bar__nu_0.25.svg"])
        rows, out = self.run_deform(lines)
        self.assertIn("bar, nu 0.25, 1,503 vertices, refined -22%", out)
        self.assertIn("reference: extrapolated", out.split("refined -22%")[1])

    def test_figures_of_which_none_can_be_drawn(self):
        self.assertEqual(self.draw([reference_record("bar"), deformed("bar", "a", None)]), {})


class Costs(DeformTest):
    def test_costs_stand_beside_the_deformation_over_scenes(self):
        def answer(scene, label, off, entries):
            line = deformed(scene, label, off, method="fem.p2_patch")
            line["judge"]["displacement_deformation"] = off
            if entries:
                line["report"] |= {"unknowns": 9, "stiffness_entries": entries, "factor_entries": 70, "product_s": 1e-4, "answer_s": 2e-3}
            return line
        lines = [line for scene, factor in (("bar", 1), ("rod", 1)) for line in
                 (reference_record(scene), answer(scene, "beside", 0.03, 100), answer(scene, "patch", 0.01 * factor, 250),
                  answer(scene, "silent", 0.02, None))]
        lines[-2]["judge"]["displacement_deformation"] = 0.07  # of the patch on the rod
        _, out = self.run_deform(lines, beside="beside")
        costs = {row["label"]: row for row in self.table("cost.csv")}
        self.assertEqual(list(costs), ["beside", "patch"])  # who reports none has no row
        self.assertAlmostEqual(float(costs["patch"]["rms"]), 0.05)
        self.assertAlmostEqual(float(costs["patch"]["worst"]), 0.07)
        self.assertAlmostEqual(float(costs["patch"]["products"]), 2.5)
        self.assertIn("5.00 / 7.00", out)

    def test_without_costs_there_is_no_such_table(self):
        _, out = self.run_deform([reference_record("bar"), deformed("bar", "isotropy", 0.02)])
        self.assertNotIn("what one answer costs", out)
        self.assertFalse((self.folder / "tables" / "cost.csv").exists())


if __name__ == "__main__":
    unittest.main()
