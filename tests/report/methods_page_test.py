"""The page of methods (docs/make_methods.py), on made-up records of its five plans."""

import contextlib
import io
import sys
import unittest

from support import HERE, ReportTest
import synthetic

sys.path.insert(0, str(HERE.parents[1] / "docs"))
import make_methods  # noqa: E402

MIB = 2**20


def at_rest(label, scene, error, kernel_s, repeat=0, **other):
    own = {"judge": {"valid": True, "displacement_deformation": error}, "report": {"outcome": "converged"}, **other}
    return synthetic.record(scene, label, None, repeat=repeat, kernel_s=kernel_s, case=f"{scene}/{label}", contestant="some.method",
                            sweep={"poisson_ratio": 0.45, "vertices": 1503}, scene={"name": scene}, peak_rss_bytes=30 * MIB, **own)


def stepped(scene, vertices, steps, kernel_s, outcome="accepted"):
    report = {"outcome": "completed", "steps": steps, "time_step_s": 5e-4, "simulated_s": steps * 5e-4}
    return synthetic.record(scene, "replay", None, kernel_s=kernel_s, case=f"{scene}/{vertices}", contestant="engine.replay", outcome=outcome,
                            judge={"valid": True}, options={"vertices": vertices}, scene={"name": scene}, report=report)


def moved(label, probe):
    report = {"outcome": "completed", "steps": 100, "time_step_s": 1e-3, "solve_s": 0.05}
    return synthetic.record("bar", label, None, case=f"bar/{label}", contestant="moving.some", report=report,
                            judge={"valid": True, "probe_l2": probe, "solver_probe_l2": 0.0123}, scene={"name": "bar"})


class MethodsPage(ReportTest):
    def setUp(self):
        super().setUp()
        self.page = self.folder.parent / "methods.md"

    def write(self, name, records, contest):
        folder = self.folder.parent / name
        records = [{**record, "plan": name} for record in records]
        synthetic.write_run(folder, records, {"question": "?", "contest": contest, "scenes": [], "contestants": []})
        return str(folder)

    def runs(self):
        own = {"valid": True, "reference_error_deformation": 0.004}
        rest = [synthetic.record("press", "reference", None, contestant=None, case="press/reference", judge=own, scene={"name": "press"},
                                 sweep={"poisson_ratio": 0.45, "vertices": 1503}),
                at_rest("edge_node", "press", 0.03, 0.2), at_rest("edge_node", "press", 0.03, 0.3, repeat=1), at_rest("edge_node", "weight", 0.04, 0.2),
                at_rest("table", "press", 0.01, 9.0, report={"outcome": "converged", "react_s": 2e-5, "move_skin_s": 6e-5}),
                at_rest("broken", "press", None, 0.1, outcome="rejected", judge=None)]
        motion = [stepped("methods_tets", 1503, 100, 0.05), stepped("methods_slow", 1503, 10, 1.0, "rejected")]
        return [self.write("methods_at_rest", rest, "deform"), self.write("methods_in_motion", motion, "engine"),
                self.write("methods_in_motion_large", [stepped("methods_tets", 100000, 100, 0.5)], "engine"),
                self.write("dynamic_error", [moved("euler", 0.25)], "motion"), self.write("dynamic_error_stiff", [moved("newton", 0.5)], "motion")]

    def make(self, runs):
        err = io.StringIO()
        with contextlib.redirect_stderr(err):
            code = make_methods.main([*runs, "-o", str(self.page)])
        return code, err.getvalue()

    def row(self, start):
        rows = [line for line in self.page.read_text(encoding="utf-8").splitlines() if line.startswith(f"| {start} |")]
        self.assertEqual(len(rows), 1, start)
        return [cell.strip() for cell in rows[0].strip("|").split("|")]

    def test_every_figure_is_of_a_record(self):
        self.assertEqual(self.make(self.runs()), (0, ""))
        # root of (9 + 16) / 2 percent; the median of 0.2, 0.3 and 0.2 s
        self.assertEqual(self.row("`edge_node`"), ["`edge_node`", "3.54 / 4", "200 ms", "-", "30"])
        self.assertEqual(self.row("`table`"), ["`table`", "1 / 1~", "9 s", "80 us", "30"])
        self.assertEqual(self.row("`broken`")[1:3], ["rejected", ""])
        self.assertEqual(self.row("`tets`"), ["`tets`", "500 us", "500 us", "1", "20", "500 us", "5 ms", "10", "20"])
        self.assertEqual(self.row("bar | `euler`"), ["bar", "`euler`", "25", "1.23", "", "100", "0.5"])
        self.assertIn("spread of a case's repeats: 40%", self.page.read_text(encoding="utf-8"))

    def test_a_row_that_was_not_accepted_says_why(self):
        self.make(self.runs())
        self.assertEqual(self.row("`slow`")[1:], ["rejected", "", "", "", "not run", "", "", ""])
        self.assertIn("Not run at 100000 vertices: `slow` (in the plan now, ", self.page.read_text(encoding="utf-8"))

    def test_a_kind_that_the_largest_plan_leaves_out_has_its_reason(self):
        runs = self.runs()
        motion = [stepped("methods_tets", 1503, 100, 0.05), stepped("methods_edge_node_bdf2", 1503, 10, 1.0)]
        runs[1] = self.write("methods_in_motion", motion, "engine")
        self.make(runs)
        text = self.page.read_text(encoding="utf-8")
        self.assertIn("Not run at 100000 vertices: `edge_node_bdf2` (its factors of 300,000 unknowns", text)
        self.assertNotIn("`tets` (", text)

    def test_the_words_have_every_kind_once(self):
        self.make(self.runs())
        for kind in ("reduced.pod", "finite_spheres.collocation", "XPBD with neo-Hookean tetrahedra"):
            self.assertEqual(len(self.row(kind)), 7)

    def test_another_run_is_refused_and_nothing_is_written(self):
        runs = self.runs()
        code, said = self.make([runs[1], runs[0], *runs[2:]])
        self.assertEqual(code, 2)
        self.assertIn("expected a run of methods_at_rest, found one of methods_in_motion", said)
        self.assertEqual(self.make([*runs[:4], str(self.folder)])[0], 2)
        self.assertFalse(self.page.exists())


if __name__ == "__main__":
    unittest.main()
