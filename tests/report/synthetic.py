"""Run folders with made-up records, for the tests of the report. Every number here is invented for its test."""

import json
import pathlib
import random

PLAN = {
    "question": "Which order keeps more well-shaped tetrahedra?",
    "meshes": [{"name": "kidney"}, {"name": "bean"}],
    "contestants": [{"label": "hierarchical"}, {"label": "sequential"}, {"label": "sequential random"}],
    "claim": {"text": "The innermost level first keeps better tetrahedra.", "source": "a made-up paper",
              "measure": "percent_above_0_5", "better": "hierarchical", "than": "sequential",
              "spread": "sequential random", "published": {"better": 63.33, "than": 45.71}},
}


def judge(percent, tets=6300):
    """A judged mesh with that share of tets above 0.5, spread over the buckets on either side."""
    above = round(tets * percent / 100)
    weights = [1, 2, 4, 7, 10]
    low = [(tets - above) * weight // sum(weights) for weight in weights]
    high = [above * weight // 30 for weight in (8, 10, 7, 4, 1)]
    low[4] += tets - above - sum(low)
    high[1] += above - sum(high)
    return {"vertices": 1200, "edges": 8000, "faces": 13000, "tets": tets, "euler": 1, "inverted_tets": 0,
            "histogram": low + high, "percent_above_0_5": 100 * above / tets,
            "percent_above_0_6": 100 * (above - high[0]) / tets, "mean_quality": 0.6, "min_quality": 0.02,
            "min_dihedral_deg": 1.5, "p1_dihedral_deg": 6.5, "boundary_changed_faces": 0, "volume_drift_relative": 0.0}


def record(mesh, label, percent, seed=None, repeat=0, kernel_s=0.01, outcome="accepted", **other):
    line = {"schema": "palpate/record/1", "plan": "made_up", "case": f"{mesh}/{label}/{seed}",
            "mesh": {"name": mesh, "vertices": 1500, "tets": 8100, "hash": "0"}, "contestant": "palpate.made_up",
            "label": label, "required": True, "options": {}, "stop": {"kind": "fusions", "value": 87}, "sweep": {},
            "seed": seed, "repeat": repeat, "warmup": False, "outcome": outcome, "violations": [], "message": None,
            "kernel_s": kernel_s, "wall_s": (kernel_s or 5.0) + 0.02, "user_s": kernel_s, "peak_rss_bytes": 20 * 2**20,
            "report": {"method": "made_up", "tets_in": 8100, "tets_out": 6300, "fusions": 87, "stop": "fusions",
                       "rejected": {"boundary": 900, "flip": 40, "quality": 0}},
            "judge": judge(percent) if percent is not None else None}
    line.update(other)
    return line


def input_record(mesh, percent):
    return {**record(mesh, "input", percent), "judge": judge(percent, 8100), "kernel_s": None, "report": None}


def thesis_records(better=75.0, than=80.0, spread=(78.0, 82.0), meshes=("kidney", "bean"), seeds=39, repeats=3):
    """A whole contest: both sides of the claim and a band of random orders between the two values of `spread`."""
    generator = random.Random(3)
    lines = []
    for shift, mesh in enumerate(meshes):
        lines.append(input_record(mesh, 94.0 - shift))
        for repeat in range(repeats):
            lines.append(record(mesh, "hierarchical", better - shift, repeat=repeat,
                                kernel_s=0.010 * generator.uniform(0.9, 1.3)))
            lines.append(record(mesh, "sequential", than - shift, repeat=repeat,
                                kernel_s=0.004 * generator.uniform(0.9, 1.3)))
        for seed in range(seeds):
            share = seed / max(1, seeds - 1)
            lines.append(record(mesh, "sequential random", spread[0] + share * (spread[1] - spread[0]) - shift, seed=seed,
                                kernel_s=0.004 * generator.uniform(0.9, 1.6)))
    return lines


CONTEST = {
    "question": "Which simplifier is best?", "equal_count": 0.005, "charts": ["quality_time"],
    "meshes": [{"name": "kidney"}], "contestants": [{"label": "refined"}, {"label": "cgal_1"}, {"label": "cgal_2"}],
    "comparisons": [{"of": "refined", "against_best_of": ["cgal_1", "cgal_2"], "time_against": "cgal_1", "time_factor": 10,
                     "measures": ["percent_above_0_5", "mean_quality", "min_dihedral_deg"], "input_up_to_ratio": 0.22}],
}
MEASURES = {"percent_above_0_5": {"better": "higher", "unit": "%"}, "mean_quality": {"better": "higher", "unit": "1"},
            "min_dihedral_deg": {"better": "higher", "unit": "deg"}, "kernel_s": {"better": "lower", "unit": "s"}}


def answer(label, percent, ratio=0.22, tets=None, mesh="kidney", start=8000, mean=0.6, least=10.0, method="cgal.remesh", **other):
    """An answer of a contest with a sweep: `tets` None is exactly the count that is asked for."""
    tets = round(start * (1 - ratio)) if tets is None else tets
    judged = None if percent is None else {**judge(percent, tets), "mean_quality": mean, "min_dihedral_deg": least,
                                           "boundary_changed_faces": other.pop("changed_faces", 0)}
    facts = {"name": mesh, "vertices": 1500, "tets": start, "hash": "0"}
    line = {"contestant": method, "judge": judged, "stop": {"kind": "ratio", "value": ratio},
            "sweep": {"tets_removed_ratio": ratio}, "case": f"{mesh}/{label}/tets_removed_ratio={ratio}", **other}
    return {**record(mesh, label, percent, **line), "mesh": facts}


def sized(label, tets, seconds, memory=None, **other):
    """An answer on a mesh of that many tets."""
    mesh = f"m{tets}"
    facts = {"name": mesh, "vertices": tets // 5, "tets": tets, "hash": "0"}
    line = record(mesh, label, None if seconds is None else 70, kernel_s=seconds, peak_rss_bytes=memory,
                  stop={"kind": "limit", "value": None}, **other)
    return {**line, "mesh": facts}


def write_mesh(path, points, tets):
    """An ASCII MEDIT file."""
    path.parent.mkdir(parents=True, exist_ok=True)
    lines = ["MeshVersionFormatted 2", "Dimension 3", "Vertices", str(len(points))]
    lines += [" ".join(map(str, (*point, 0))) for point in points]
    lines += ["Tetrahedra", str(len(tets))] + [" ".join(str(v + 1) for v in tet) + " 0" for tet in tets] + ["End"]
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")


def write_run(folder, lines, plan=None):
    """Writes a run folder; `plan` None takes PLAN, {} writes no claim."""
    folder = pathlib.Path(folder)
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "records.jsonl").write_text("".join(json.dumps(line) + "\n" for line in lines), encoding="utf-8")
    provenance = {"schema": "palpate/provenance/1", "plan": "made_up", "plan_data": PLAN if plan is None else plan, "timeout_s": 120.0,
                  "measures": MEASURES}
    (folder / "provenance.json").write_text(json.dumps(provenance), encoding="utf-8")
    return folder


# --- Displacements --------------------------------------------------------------------------------------------------------

DEFORM = {"question": "Which springs move like the organ?", "contest": "deform",
          "scenes": ["bar_tension", "kidney_gravity"], "contestants": [{"label": "isotropy"}, {"label": "p1"}],
          "reference": {"method": "fem.p2"}, "beside": "p1"}


def deform_scene(scene, nu):
    return {"name": scene, "problem_hash": "0", "strain": "small", "young_modulus_pa": 10000.0, "poisson_ratio": nu}


def deformed(scene, label, l2, nu=0.25, sweep=None, vertices=1503, own=0.001, method="springs.isotropy", seconds=0.02, **other):
    """An answer to a problem; `l2` None is one that did not converge."""
    judged = {"valid": False, "findings": ["its outcome is diverged"]}
    if l2 is not None:
        judged = {"valid": True, "findings": [], "displacement_l2": l2, "displacement_max": 1.5 * l2, "displacement_energy": 2 * l2,
                  "reference_error": own, "reference_ratio": None if not own else l2 / own,
                  "reference_too_coarse": own is None or l2 < 5 * own, "max_displacement_m": 0.004, "worst_vertex": 3}
    line = {"contestant": method, "judge": judged, "sweep": sweep or {}, "stop": None, "kernel_s": seconds,
            "case": f"{scene}/{label}/{json.dumps(sweep)}", "scene": deform_scene(scene, nu),
            "report": {"method": method, "outcome": "converged" if l2 is not None else "diverged", "identify_s": 0.3 * seconds,
                       "solve_s": 0.6 * seconds, "iterations": 12}}
    if l2 is None:
        line |= {"outcome": "rejected", "violations": ["its outcome is diverged"]}
    line |= other
    return {**record(scene, label, None, **line), "mesh": {"name": scene, "vertices": vertices, "tets": 5 * vertices, "hash": "0"}}


def reference_record(scene, own=0.001, nu=0.25, sweep=None, vertices=1503, order=2.1, **judged):
    """The record of a reference: its own error in the three figures is own, 2 own and 4 own."""
    figures = {"valid": True, "findings": [], "kind": "extrapolated", "levels": 3, "order": order, "alignment": 0.98,
               "differences": [0.02, 0.005], "rule": "extrapolated with the observed order", "reference_error": own,
               "reference_error_max": None if own is None else 2 * own, "reference_error_energy": None if own is None else 4 * own,
               "max_displacement_m": 0.004, "level_reports": [], **judged}
    line = deformed(scene, "reference", 0.0, nu, sweep, vertices, own)
    return {**line, "contestant": None, "judge": figures, "report": None, "kernel_s": None, "message": "" if figures["valid"] else "level 1 diverged"}
