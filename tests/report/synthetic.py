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


def thesis_records(better=75.0, than=80.0, spread=(78.0, 82.0), meshes=("kidney", "bean"), seeds=12, repeats=3):
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


def write_run(folder, lines, plan=None):
    """Writes a run folder; `plan` None takes PLAN, {} writes no claim."""
    folder = pathlib.Path(folder)
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "records.jsonl").write_text("".join(json.dumps(line) + "\n" for line in lines), encoding="utf-8")
    provenance = {"schema": "palpate/provenance/1", "plan_data": PLAN if plan is None else plan}
    (folder / "provenance.json").write_text(json.dumps(provenance), encoding="utf-8")
    return folder
