"""The report of a contest with known answers, on made-up records."""

import unittest

from support import ReportTest
import synthetic

PLAN = {"question": "Do they solve it?", "contest": "verify", "contestants": ["fem.p1", "fem.p2"],
        "cases": [{"case": "patch", "cells": [2, 4], "expect": [{"contestants": ["fem.p1"], "solution_l2": {"max": 1e-10}}]},
                  {"case": "smooth", "cells": [4, 8], "expect": [{"contestants": ["fem.p1", "fem.p2"], "solution_order": {"min": 1.9}}]}]}


def solved(case, label, cells, error, order=None, **other):
    judged = {"valid": True, "findings": [], "solution_l2": error, "solution_max": 2 * error}
    judged |= {} if order is None else {"solution_order": order}
    line = synthetic.record(case, label, None, judge={**judged, **other.pop("figures", {})}, sweep={"cells": cells}, contestant=label,
                            case=f"{case}/{label}/cells={cells}")
    return {**line, **other}


class Verification(ReportTest):
    LINES = [solved("smooth", "fem.p1", 4, 0.04), solved("smooth", "fem.p1", 8, 0.01, 2.0), solved("patch", "fem.p1", 4, 1e-13),
             solved("smooth", "fem.p2", 4, 0.004), solved("patch", "fem.p1", 2, 2e-13),
             solved("smooth", "fem.p2", 8, 0.002, 1.0, outcome="rejected", violations=["solution_order is 1, at least 1.9 is accepted"])]

    def rows(self, lines=None):
        synthetic.write_run(self.folder, self.LINES if lines is None else lines, PLAN)
        code, self.printed, err = self.report()
        self.assertEqual((code, err), (0, ""))
        return {(row["case"], row["method"], row["cells"]): row for row in self.table("verification.csv")}

    def test_cases_in_the_plans_order_and_meshes_from_coarse_to_fine(self):
        self.assertEqual(list(self.rows()), [("patch", "fem.p1", "2"), ("patch", "fem.p1", "4"), ("smooth", "fem.p1", "4"),
                                             ("smooth", "fem.p1", "8"), ("smooth", "fem.p2", "4"), ("smooth", "fem.p2", "8")])

    def test_bounds_hold_on_the_finest_mesh(self):
        rows = self.rows()
        self.assertEqual((rows["smooth", "fem.p1", "8"]["state"], rows["smooth", "fem.p1", "4"]["state"]), ("kept", ""))
        self.assertEqual(rows["smooth", "fem.p1", "8"]["bounds"], "solution_order >= 1.9")
        self.assertEqual(rows["patch", "fem.p1", "4"]["bounds"], "solution_l2 <= 1e-10")
        self.assertEqual(rows["smooth", "fem.p2", "8"]["state"], "not kept")
        self.assertIn("solution_order is 1, at least 1.9 is accepted", self.printed)
        self.assertIn("bounds kept by 2, not kept by 1", self.printed)

    def test_a_published_value_stands_beside_what_was_found(self):
        figures = {"value": 92.1, "value_known": 92.7, "value_error": 0.6 / 92.7}
        self.rows([solved("membrane", "fem.p2", 8, 0.1, figures=figures)])
        self.assertIn("92.1   92.7   0.65%", self.printed)

    def test_what_gave_no_answer_keeps_its_row(self):
        rows = self.rows([solved("smooth", "fem.p1", 4, 0.1, outcome="timed_out", judge=None, message="timed out", kernel_s=None)])
        row = rows["smooth", "fem.p1", "4"]
        self.assertEqual((row["state"], row["solution_l2"], row["note"]), ("not kept", "", "timed_out: timed out"))

    def test_the_chart_is_the_same_twice_and_leaves_out_what_is_exact(self):
        self.rows()
        first = self.charts()
        self.assertEqual(sorted(first), ["verification.png", "verification.svg"])
        self.rows()
        self.assertEqual(self.charts(), first)
        self.rows([solved("patch", "fem.p1", 2, 1e-13), solved("patch", "fem.p1", 4, 1e-13)])
        self.assertEqual(self.charts(), {})


if __name__ == "__main__":
    unittest.main()
