#!/usr/bin/env python3
"""A page of each contest, from made-up run folders, for the tests in a browser.

    make_pages.py OUT SCRIPTS [NAME...]

Writes OUT/NAME/report.html with the scripts of the folder SCRIPTS; OUT/bare/report.html without any; OUT/thesis/histograms and palpation, the runs of the
thesis's figures, only where they are named. The names of meshes and labels of
OUT/simplify are markup, which has to stay text.
"""

import json
import pathlib
import sys

HERE = pathlib.Path(__file__).resolve().parent
sys.path[:0] = [str(HERE.parents[0] / "report"), str(HERE.parents[1] / "report")]
import engine_test
import frontier_test
import motion_test
import stability_test
import synthetic
import verification_test
from support import make_report

EVIL_MESH = "<script>alert(1)</script>"
EVIL_LABEL = "</script><img src=x onerror=alert(2)>"
TETS_OF_CUBE = [(0, 1, 3, 7), (0, 3, 2, 7), (0, 2, 6, 7), (0, 6, 4, 7), (0, 4, 5, 7), (0, 5, 1, 7)]


def block(cells, size=1.0):
    """A block of cells[0] x cells[1] x cells[2] cubes of six tetrahedra each: points and tets."""
    counts = [cell + 1 for cell in cells]
    number = lambda i, j, k: (i * counts[1] + j) * counts[2] + k
    points = [(size * i / cells[0], size * j / cells[0], size * k / cells[0]) for i in range(counts[0]) for j in range(counts[1]) for k in range(counts[2])]
    tets = []
    for i in range(cells[0]):
        for j in range(cells[1]):
            for k in range(cells[2]):
                corner = [number(i + (c & 1), j + (c >> 1 & 1), k + (c >> 2 & 1)) for c in range(8)]
                tets += [tuple(corner[v] for v in tet) for tet in TETS_OF_CUBE]
    return points, tets


def write_displacements(path, field):
    path.parent.mkdir(parents=True, exist_ok=True)
    lines = ["vertex,ux_m,uy_m,uz_m"] + [",".join(map(str, (vertex, *each))) for vertex, each in enumerate(field)]
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")


def bent(points, size):
    """Bent upwards, more and more along x."""
    return [(0.0, 0.0, size * x * x) for x, _, _ in points]


def make_simplify(folder):
    lines = synthetic.thesis_records(meshes=("kidney", EVIL_MESH), seeds=25)
    for name, cells in (("input", (8, 4, 4)), ("hierarchical", (6, 3, 3)), ("sequential", (5, 3, 3))):
        synthetic.write_mesh(folder / "meshes" / f"{name}.mesh", *block(cells))
    for line in lines:
        line["mesh_file"] = f"meshes/{line['label']}.mesh"
    lines.append(synthetic.record("kidney", EVIL_LABEL, 50, outcome="rejected", violations=[f"inverted_tets 3 > 0 {EVIL_LABEL}"]))
    plan = {**synthetic.PLAN, "question": f"Which order keeps more? {EVIL_MESH}"}
    synthetic.write_run(folder, lines, plan)
    (folder / "plan.yaml").write_text(f"# {EVIL_LABEL}\nschema: palpate/plan/1\n", encoding="utf-8")


def make_contest(folder):
    labels = [("refined", 81.0, 0.002), ("cgal_1", 80.0, 0.025), ("cgal_2", 82.5, 0.05)]
    lines = [synthetic.input_record("kidney", 70)]
    for repeat in range(9):
        for label, percent, seconds in labels:
            lines.append(synthetic.answer(label, percent, repeat=repeat, kernel_s=seconds * (1 + 0.01 * repeat)))
    synthetic.write_run(folder, lines, synthetic.CONTEST)


def make_long_names(folder):
    """A contest whose labels and meshes have long names, at two counts; the fewer tetrahedra the fewer labels."""
    labels = [("refined_with_a_rather_long_label", 81.0, 0.002), ("cgal_1_iteration_with_a_bound_of_half_a_millimetre", 80.0, 2.5), ("another label of several words that goes on", 82.5, 300.0)]
    lines = []
    for mesh in ("kidney", "a_mesh_with_a_rather_long_name_too", "bean"):
        lines.append(synthetic.input_record(mesh, 70))
        for ratio in (0.5, 0.22):
            lines += [synthetic.answer(label, percent, ratio, mesh=mesh, kernel_s=seconds) for label, percent, seconds in labels[ratio < 0.3:]]
    synthetic.write_run(folder, lines, synthetic.CONTEST | {"meshes": [{"name": "kidney"}], "comparisons": []})


def make_deform(folder):
    points, tets = block((10, 2, 2), 0.1)
    lines, scenes = [], ("bar_tension", "kidney_gravity")
    for scene in scenes:
        lines.append(synthetic.reference_record(scene))
        synthetic.write_mesh(folder / "problems" / scene / "in.mesh", points, tets)
        write_displacements(folder / "references" / f"{scene}.csv", bent(points, 1.0))
        for label, error in (("isotropy", 0.05), ("p1", 0.03), ("third", 0.0008)):
            name = f"displacements/{scene}/{label}.csv"
            write_displacements(folder / name, bent(points, 1.0 + error))
            lines.append(synthetic.deformed(scene, label, error, mesh_file=name, case=f"{scene}/{label}"))
    lines.append(synthetic.deformed("bar_tension", "failing", None))
    plan = {**synthetic.DEFORM, "targets": [{"text": "Springs", "labels": ["isotropy"], "at_most": 0.02}]}
    synthetic.write_run(folder, lines, plan)


def make_frontier(folder):
    lines = [frontier_test.reference()]
    for label, error, seconds in (("fast", 0.2, 0.001), ("good", 0.01, 0.01), ("beaten", 0.3, 0.02)):
        lines += frontier_test.repeats(label, error, seconds, answer_s=0.1 * seconds)
    plan = {**synthetic.DEFORM, "frontier": {"families": {"springs": ["fast", "beaten"], "elements": ["good"]}, "at": [0.25, 0.02], "against": ["elements"]}}
    synthetic.write_run(folder, lines, plan)


def make_motion(folder):
    folder.mkdir(parents=True, exist_ok=True)
    files = [motion_test.history(folder, f"{name}.csv", hz, 0.5) for name, hz in (("reference", 12.0), ("a", 13.0), ("b", 12.2))]
    points, tets = block((6, 2, 2))
    synthetic.write_mesh(folder / "problems" / "bar" / "in.mesh", points, tets)
    for name in ("a", "b"):
        states = [{"time_s": 0.1 * k, "displacement_m": [value for each in bent(points, 0.1 * k) for value in each]} for k in range(11)]
        (folder / "histories" / f"{name}.states.json").write_text(json.dumps({"schema": "palpate/states/1", "states": states}), encoding="utf-8")
    test = motion_test.Motion
    synthetic.write_run(folder, [motion_test.reference(files[0]), motion_test.moved("b", files[2], test.B), motion_test.moved("a", files[1], test.A)], motion_test.PLAN)


def renamed(value, names):
    """Whatever holds these words as strings or as parts of a path, with others in their place."""
    if isinstance(value, dict):
        return {key: renamed(each, names) for key, each in value.items()}
    if isinstance(value, list):
        return [renamed(each, names) for each in value]
    return "/".join(names.get(part, part) for part in value.split("/")) if isinstance(value, str) else value


def make_engine(folder, scenes=("soft", "stiff"), times=range(21), sizes=tuple(0.05 * (1 - abs(k - 10) / 10) for k in range(21))):
    points, tets = block((8, 3, 3), 0.1)
    names = dict(zip(("soft", "stiff"), scenes))
    synthetic.write_run(folder, renamed(engine_test.Engine.LINES, names), renamed(engine_test.PLAN, names))
    columns = ["time_s", "total_j", "largest_displacement_m", "probe_1_ux_m", "probe_1_uy_m", "probe_1_uz_m"]
    for scene in scenes:
        rows = [[float(time), 1e-3 * size, size, 0.0, 0.0, size] for time, size in zip(times, sizes)]
        frames = [{"time_s": float(time), "displacement_m": [value for each in bent(points, 100 * size) for value in each]} for time, size in zip(times, sizes)]
        path = folder / "motions" / scene / "replay.json"
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(json.dumps({"columns": columns, "rows": rows, "frames": frames}), encoding="utf-8")
        synthetic.write_mesh(folder / "problems" / scene / "in.mesh", points, tets)


def make_palpation(folder):
    """A motion at the times of the thesis's figures: pressed and let go, twice, and back."""
    moments = {0.0: 0.0, 0.16: 0.027, 0.3: 0.05, 0.32: 0.04, 0.34: 0.03, 0.36: 0.02, 1.66: 0.017, 1.8: 0.033, 1.82: 0.025, 1.86: 0.015, 1.94: 0.005, 3.0: 0.0}
    make_engine(folder, ("better_palpation_springs",), tuple(moments), tuple(moments.values()))


def make_histograms(folder):
    """A body before and after the simplifiers that the thesis's histograms compare."""
    names = {"hierarchical": "hierarchical_87", "sequential": "sequential_index", "sequential random": "sequential_random"}
    lines = [{**line, "mesh_file": f"meshes/{line['label']}.mesh"} for line in renamed(synthetic.thesis_records(meshes=("kidney",), seeds=25), names)]
    for name, cells in (("input", (8, 4, 4)), ("hierarchical_87", (6, 3, 3)), ("sequential_index", (5, 3, 3))):
        synthetic.write_mesh(folder / "meshes" / f"{name}.mesh", *block(cells))
    synthetic.write_run(folder, lines, renamed(synthetic.PLAN, names))


def make_stability(folder):
    test = stability_test
    lines = [test.measured("motion.symplectic_euler", "nominal", 1.0), test.measured("motion.plain_float", "nominal", 0.98),
             {**test.measured("motion.plain_float", "nominal", 0.99), "mesh": {"name": "kidney"}, "case": "kidney/plain_float"},
             test.one_run("motion.symplectic_euler", "rest", "steady", {})]
    synthetic.write_mesh(folder / "problems" / "cube" / "in.mesh", *block((3, 3, 3)))
    synthetic.write_run(folder, lines, {"contest": "stability", "question": "Where do they break?"})


def make_verify(folder):
    lines = [verification_test.solved("cantilever", "p2", cells, 0.1 / cells**2, 2.0) for cells in (2, 4, 8)]
    plan = {"contest": "verify", "question": "Are the known answers found?",
            "cases": [{"case": "cantilever", "expect": [{"contestants": ["p2"], "solution_l2": {"max": 0.01}}]}]}
    synthetic.write_run(folder, lines, plan)


PAGES = {"simplify": make_simplify, "contest": make_contest, "long_names": make_long_names, "deform": make_deform, "frontier": make_frontier, "motion": make_motion, "engine": make_engine,
         "stability": make_stability, "verify": make_verify, "bare": make_simplify}
RUNS_OF_THESIS = {"thesis/histograms": make_histograms, "thesis/palpation": make_palpation}
WITH_CHARTS = ("simplify", "bare", "long_names", "thesis/histograms")


def main(arguments):
    out, scripts, *names = arguments
    out, scripts = pathlib.Path(out), pathlib.Path(scripts)
    for name in names or PAGES:
        folder = out / name
        {**PAGES, **RUNS_OF_THESIS}[name](folder)
        code = make_report.main([str(folder), "--scripts", str(scripts if name != "bare" else out / "none"), *(["--no-charts"] if name not in WITH_CHARTS else [])])
        if code not in (0, 1):
            return code
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
