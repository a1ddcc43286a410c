"""Error against the number of tetrahedra in the report of a contest of displacements: curves, gradings, charts, the page."""

import json
import unittest

from support import ReportTest
import synthetic
from deform import count_charts, counts, deform, deform_page
from shared import records
from synthetic import deformed, reference_record


class Counts(ReportTest):
    def draw(self, lines, **plan):
        synthetic.write_run(self.folder, lines, {**synthetic.DEFORM, **plan})
        code, out, err = self.report()
        self.assertEqual((code, err), (0, ""), out)
        return self.charts()

    def graded_lines(self):
        """Two scenes, one method, three counts: a simplifier of one size and one graded by its loads, whose errors are known."""
        lines = []
        for scene, factor in (("bar", 1.0), ("rod", 2.0)):
            lines.append(reference_record(scene, sweep={"poisson_ratio": 0.25}))
            none = deformed(scene, "a", 0.01 * factor, sweep={"poisson_ratio": 0.25, "simplify": "none"})
            lines.append(none)
            for simplify, gain in (("refined", 1.0), ("refined_near", 0.8)):
                for ratio in (0.3, 0.5, 0.85):
                    sweep = {"poisson_ratio": 0.25, "simplify": simplify, "tets_removed_ratio": ratio}
                    line = deformed(scene, "a", 0.02 * factor * gain / (1 - ratio), sweep=sweep,
                                    solved_on={"name": "x", "vertices": 9, "tets": round(8000 * (1 - ratio))})
                    line["judge"]["displacement_deformation"] = 1.5 * line["judge"]["displacement_l2"]
                    lines.append(line)
        return lines

    SIMPLIFY = ["none", {"method": "palpate.refined", "label": "refined"},
                {"method": "palpate.refined", "label": "refined_near", "grade": {"near": ["loads"]}}]

    def test_error_against_tetrahedra_of_one_size_and_graded(self):
        drawn = self.draw(self.graded_lines(), charts=["error_count"], simplify=self.SIMPLIFY)
        self.assertEqual(sorted(drawn), ["error_count_a_nu_0.25.png", "error_count_a_nu_0.25.svg"])
        self.assertEqual(self.draw(self.graded_lines(), charts=["error_count"], simplify=self.SIMPLIFY), drawn)
        rows = self.table("error_count.csv")
        self.assertEqual(len(rows), 12)
        points = {(row["scene"], row["sizes"], int(row["tets"])): float(row["displacement_deformation"]) for row in rows}
        self.assertAlmostEqual(points["rod", "near loads", 1200], 1.5 * 0.04 * 0.8 / 0.15)
        for (scene, sizes, tets), error in points.items():
            if sizes == "near loads":
                self.assertAlmostEqual(error / points[scene, "one size", tets], 0.8)
        self.assertEqual({row["family"] for row in rows}, {"refined"})
        pairs = self.table("gradings.csv")
        self.assertEqual([(row["scene"], row["tets_removed_ratio"], row["sizes"]) for row in pairs], [(scene, ratio, "near loads") for scene in ("bar", "rod") for ratio in ("0.3", "0.5", "0.85")])
        for row in pairs:
            self.assertAlmostEqual(float(row["deformation_over_one_size"]), 0.8)
            self.assertEqual((row["deformation_better"], row["energy_better"], row["tets"] == row["tets_of_one_size"]), ("yes", "yes", True))

    def test_a_graded_mesh_with_other_tetrahedra_or_no_better_error_is_no_gain(self):
        lines = self.graded_lines()
        for line in lines:
            sweep = line.get("sweep") or {}
            if sweep.get("simplify") == "refined_near" and sweep["tets_removed_ratio"] == 0.3:
                line["solved_on"]["tets"] = round(line["solved_on"]["tets"] * 0.99)
            if sweep.get("simplify") == "refined_near" and sweep["tets_removed_ratio"] == 0.5:
                line["judge"]["displacement_deformation"] *= 2
        self.draw(lines, charts=["error_count"], simplify=self.SIMPLIFY)
        self.assertEqual([(row["scene"], row["tets_removed_ratio"], row["deformation_better"]) for row in self.table("gradings.csv")],
                         [("bar", "0.5", "no"), ("bar", "0.85", "yes"), ("rod", "0.5", "no"), ("rod", "0.85", "yes")])
        self.draw(lines, charts=["error_count"])
        self.assertFalse((self.folder / "tables" / "gradings.csv").exists())

    def test_a_curve_takes_two_counts_and_a_simplifier_in_the_plan_or_not(self):
        lines = [line for line in self.graded_lines() if (line.get("sweep") or {}).get("tets_removed_ratio") in (None, 0.5)]
        self.assertEqual(self.draw(lines, charts=["error_count"], simplify=self.SIMPLIFY), {})
        self.assertFalse((self.folder / "tables" / "error_count.csv").exists())
        self.assertEqual(len(self.draw(self.graded_lines(), charts=["error_count"])), 2)  # a plan of which nothing is known
        self.assertEqual({row["sizes"] for row in self.table("error_count.csv")}, {"one size"})

    def test_of_families_that_the_plan_names_the_best_is_shown_count_by_count(self):
        lines = self.graded_lines()
        for line in self.graded_lines():  # as many peers that are better at one count and worse at the others
            sweep = line.get("sweep") or {}
            if sweep.get("simplify") == "refined":
                for label, factor in (("peer_1", 0.5 if sweep["tets_removed_ratio"] == 0.5 else 2.0), ("peer_2", 1.5)):
                    peer = json.loads(json.dumps(line).replace('"refined"', f'"{label}"').replace("simplify=refined", f"simplify={label}"))
                    peer["case"] = peer["case"].replace('"refined"', f'"{label}"')
                    peer["judge"]["displacement_deformation"] *= factor
                    lines.append(peer)
        simplify = [*self.SIMPLIFY, {"method": "peer.a", "label": "peer_1"}, {"method": "peer.b", "label": "peer_2"}]
        frontier = {"of": "simplifiers", "families": {"ours": ["refined", "refined_near"], "peers": ["peer_1", "peer_2"]}}
        synthetic.write_run(self.folder, lines, {**synthetic.DEFORM, "simplify": simplify, "frontier": frontier})
        run = records.read_run(self.folder)
        curves = counts.read_curves(run, deform.read_sections(run))
        shown = {(curve.problem.scene, curve.simplifier.label): [row.values["displacement_deformation"] for row in curve.rows]
                 for curve in counts.shown_curves(curves, run.plan_data)}
        self.assertEqual({label for _, label in shown}, {"refined", "refined_near", "ours", "peers"})
        for scene in ("bar", "rod"):
            refined = shown[scene, "refined"]
            self.assertEqual(shown[scene, "ours"], shown[scene, "refined_near"])
            self.assertEqual(shown[scene, "peers"], [1.5 * refined[0], 0.5 * refined[1], 1.5 * refined[2]])
        self.assertEqual(counts.shown_curves(curves, {}), curves)
        self.assertEqual(len({count_charts.style_at(place) for place in range(64)}), 64)

    def test_the_page_has_the_curves(self):
        synthetic.write_run(self.folder, self.graded_lines(), {**synthetic.DEFORM, "simplify": self.SIMPLIFY})
        run = records.read_run(self.folder)
        sections = deform.read_sections(run)
        charts = [chart for chart in deform_page.page_parts(run, (sections, [], {})).sections[0].parts if chart.title.startswith("Error against tetrahedra")]
        self.assertEqual([(chart.title, chart.kind, len(chart.rows)) for chart in charts], [("Error against tetrahedra: a", "lines", 12)])
        self.assertEqual({row["sizes"] for row in charts[0].rows}, {"one size", "near loads"})
        self.assertEqual({row["place"] for row in charts[0].rows}, {"bar, nu 0.25, refined", "rod, nu 0.25, refined"})


if __name__ == "__main__":
    unittest.main()
