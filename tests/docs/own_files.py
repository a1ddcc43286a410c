"""The files that the pages' commands take for a reader's own: how the tests make them before they run such a command."""

import re

# A scene with a tolerance, on a body that is small, and coarse enough at its skin to be simplified.
SCENE = """schema: palpate/scene/1
mesh: {make: kidney, vertices: 1000}
material: {young_modulus_pa: 10000, poisson_ratio: 0.45, density_kg_m3: 1050}
clamp: [{half_space: {normal: [0, 1, 0], share: 0.2}, elastic_pa_per_m: 1.0e+6}]
load:
  - force: {sphere: {surface_point: {direction: [0, 1, 0]}, radius_m: 0.015}, total_n: [0, -0.4, 0]}
model: {smoothed: edge_node}
analysis: static
require: {error: {measure: deformation_l2, at_most: 0.2}, time_per_second_s: 1000}
"""

# With as many repeats as a comparison takes.
RUN = "sed -E 's/repeats: [0-9]+/repeats: 6/' experiments/plans/ci.yaml > ci.yaml && ./palpate run ci.yaml --only cube --out {place} > /dev/null"
BENCHMARKS = ('{"context": {"date": "2026-01-01"}, "benchmarks": ['
              + ", ".join(f'{{"name": "a/1", "run_name": "a/1", "run_type": "iteration", "repetition_index": {k}, "iterations": 1, "real_time": {100 + k}, '
                          f'"cpu_time": {100 + k}, "time_unit": "us"}}' for k in range(9)) + "]}")

# What makes each of them at the top of the repository, in the order in which they need each other.
OWN = {
    "organ.mesh": "./palpate make kidney -o organ.mesh --vertices 400",
    "organ.stl": "/usr/bin/python3 docs/examples/skin_as_stl.py organ.mesh organ.stl",
    # as fine as a scanner's, so that it is remeshed and its pad is some edges wide
    "spleen.stl": "./palpate make kidney -o fine.mesh --vertices 10000 && /usr/bin/python3 docs/examples/skin_as_stl.py fine.mesh spleen.stl && rm fine.mesh",
    "my_plan.yaml": "cp experiments/plans/ci.yaml my_plan.yaml",
    "my_scene.yaml": f"cat > my_scene.yaml <<'END'\n{SCENE}END",
    "results/ci/run": RUN.format(place="results/ci/run"),
    "results/ci_contest/20261101T": "mkdir -p results/ci_contest && cp -r results/ci/run results/ci_contest/20261101T000000Z",
    "results/ci_contest/20261123T": "cp -r results/ci/run results/ci_contest/20261123T000000Z",
    "RUN_A": "cp -r results/ci/run RUN_A",
    "RUN_B": "cp -r results/ci/run RUN_B",
    "before.json": f"echo '{BENCHMARKS}' > before.json",
    "after.json": "cp before.json after.json",
    "benchmarks": "true",  # made by its block
}
NEEDS = {"organ.stl": ["organ.mesh"], "after.json": ["before.json"],
         **{name: ["results/ci/run"] for name in ("results/ci_contest/20261101T", "results/ci_contest/20261123T", "RUN_A", "RUN_B", "results/ci")}}


def names_in(texts):
    """The files of OWN that commands name, with what those are made of."""
    found = [name for name in [*OWN, "results/ci"] if any(re.search(rf"(?<![\w/.]){re.escape(name)}(?![\w.-]|/\w)", text) or (name.endswith("T") and name in text) for text in texts)]
    wanted = {need for name in found for need in [name, *NEEDS.get(name, [])]}
    return [name for name in OWN if name in wanted]


def is_drafted(name, texts):
    """Whether the first command that names a scene is the one that writes it: it writes over none."""
    first = next((text for text in texts if name in text), "")
    return re.search(rf" scene .* -o {re.escape(name)}(?!\S)", first) is not None


def making(texts):
    """Commands for a shell that make those files, each where it is not there yet."""
    return [f"if ! compgen -G '{name}*' > /dev/null; then {OWN[name]}\nfi" for name in names_in(texts) if not is_drafted(name, texts)]
