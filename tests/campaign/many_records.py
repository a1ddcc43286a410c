"""Run folders of as many records as one likes: a small plan is run, and its records are multiplied to those of a large one.

    /usr/bin/python3 -B tests/campaign/many_records.py PALPATE FOLDER --records N [--repeats R] [--meshes M]

FOLDER becomes what `palpate run` of FOLDER.yaml would have left: plan, meshes and provenance are the program's own (`--prepare`), each record is
one of the small run with the case, seed, repeat, hash, times and figures of its own. So the figures are made up, and the form is not.
"""

import argparse
import json
import pathlib
import random
import subprocess
import tempfile

LABELS = ("random_20", "random_40", "random_60")  # by percent of the tetrahedra removed
VARIED = ("percent_above_0_5", "percent_above_0_6", "mean_quality", "min_quality", "min_dihedral_deg", "p1_dihedral_deg")  # of the judge
TIMES = ("kernel_s", "wall_s", "user_s")


def plan_text(meshes, seeds, repeats):
    lines = ["schema: palpate/plan/1", "question: What does a report of very many records take?", "contest: simplify", "meshes:"]
    lines += [f"  - {{name: cube_{place}, make: cube, vertices: 216, jitter: 0.2, seed: {place}}}" for place in range(1, meshes + 1)]
    lines += ["contestants:"]
    lines += [f"  - {{method: tetfusion.sequential, label: {label}, set: {{order: random}}, stop: {{ratio: 0.{label[-2]}}}, seeds: {seeds}}}" for label in LABELS]
    lines += [f"run: {{repeats: {repeats}, warmup: 0, threads: 1, timeout_s: 60, memory_mib: 2048}}", "measure: [percent_above_0_5, kernel_s]", ""]
    return "\n".join(lines)


def palpate(program, *words):
    done = subprocess.run([program, *map(str, words)], capture_output=True, text=True, check=False)
    if done.returncode != 0:
        raise RuntimeError(f"palpate {' '.join(map(str, words))}: exit code {done.returncode}\n{done.stdout[-2000:]}{done.stderr[-2000:]}")


def small_run(program, meshes):
    """The records of a run of one seed: inputs, and one of each mesh and label."""
    with tempfile.TemporaryDirectory(prefix="palpate-small-") as folder:
        plan = pathlib.Path(folder) / "small.yaml"
        plan.write_text(plan_text(meshes, 1, 1), encoding="utf-8")
        palpate(program, "run", plan, "--out", f"{folder}/run", "--no-report")
        records = [json.loads(line) for line in (pathlib.Path(folder) / "run" / "records.jsonl").read_text(encoding="utf-8").splitlines()]
    if len(records) != meshes * (1 + len(LABELS)):
        raise RuntimeError(f"the small run left {len(records)} records, {meshes * (1 + len(LABELS))} expected")
    return records


def of_seed(record, plan, seed, drawn):
    """That record as if it were of another seed."""
    judge = dict(record["judge"])
    for name in VARIED:
        judge[name] *= drawn.uniform(0.9, 1.1)
    mesh_file = f"meshes/{record['mesh']['name']}/{record['label']}/seed={seed}.mesh"
    return {**record, "plan": plan, "case": f"{record['mesh']['name']}/{record['label']}/seed={seed}", "seed": seed,
            "options": {**record["options"], "seed": seed}, "judge": judge, "output_hash": f"xxh3:{drawn.getrandbits(128):032x}", "mesh_file": mesh_file}


def line_of(record):
    """As the program writes it: keys in order, no blanks."""
    return json.dumps(record, sort_keys=True, separators=(",", ":")) + "\n"


class Repeats:
    """The lines of one case's repeats, made from one text."""

    def __init__(self, record, drawn):
        marked = {**record, **{name: f"@{name}@" for name in (*TIMES, "repeat", "peak_rss_bytes", "position")}}
        self.pieces = line_of(marked).replace('"@', "@").replace('@"', "@").split("@")  # texts and names in turn
        self.record, self.drawn = record, drawn

    def line(self, repeat, position):
        factor = self.drawn.uniform(0.9, 1.3)
        values = {name: repr(self.record[name] * factor) for name in TIMES}
        values |= {"repeat": str(repeat), "position": str(position), "peak_rss_bytes": str(self.record["peak_rss_bytes"] + 4096 * self.drawn.randrange(64))}
        return "".join(values[piece] if place % 2 else piece for place, piece in enumerate(self.pieces))


def write_records(path, records, plan, seeds, repeats):
    """All lines, round by round as a run leaves them. Returns how many."""
    drawn = random.Random(20261123)
    answers = [record for record in records if record["contestant"]]
    written = 0
    with open(path, "w", encoding="utf-8") as out:
        for record in records:
            if not record["contestant"]:
                out.write(line_of({**record, "plan": plan}))
                written += 1
        if any("@" in line_of(record) for record in answers):
            raise RuntimeError("a record has the mark @ in it")
        for repeat in range(repeats):
            figures = random.Random(7)  # each round draws the same figures anew, so that no case has to be kept
            place = 0
            for seed in range(1, seeds + 1):
                for record in answers:
                    out.write(Repeats(of_seed(record, plan, seed, figures), drawn).line(repeat, place))
                    place += 1
            written += place
    return written


def make_run(program, folder, records, repeats=10, meshes=8):
    """Makes the folder; returns how many records it has: at least so many, in whole seeds."""
    folder = pathlib.Path(folder)
    seeds = -(-records // (meshes * len(LABELS) * repeats))
    plan = folder.with_suffix(".yaml")
    plan.write_text(plan_text(meshes, seeds, repeats), encoding="utf-8")
    palpate(program, "run", plan, "--out", folder, "--prepare")
    return write_records(folder / "records.jsonl", small_run(program, meshes), plan.stem, seeds, repeats)


def fail_first(path):
    """Makes the first record, an input's, one that crashed. It stays as long as it was."""
    with open(path, "r+b") as lines:
        first = lines.readline()
        lines.seek(0)
        lines.write(first.replace(b'"outcome":"accepted"', b'"outcome":"crashed" '))


def main():
    parser = argparse.ArgumentParser(description="A run folder of very many made-up records.")
    parser.add_argument("program", metavar="PALPATE")
    parser.add_argument("folder", metavar="FOLDER")
    parser.add_argument("--records", type=int, required=True)
    parser.add_argument("--repeats", type=int, default=10)
    parser.add_argument("--meshes", type=int, default=8)
    options = parser.parse_args()
    print(make_run(options.program, options.folder, options.records, options.repeats, options.meshes))


if __name__ == "__main__":
    main()
