"""Tetrahedra times explicit steps of a simulated second: what a mesh costs a simulator whatever the machine is.

Meshes that one model is moved on, so it stands where a plan's families are simplifiers; models have steps of different costs. A second has
1 / (0.9 explicit_step_s) steps, as `simulated_second_s` does. It is a count, without noise: where times of two runs differ, it does not.
"""

from deform.frontier import MEASURE, asked, families_of, span_text
from shared.tables import align, percent_text, write_csv

SHARE_OF_STEP = 0.9  # of the longest stable one


def element_steps(point):
    """Of a point of the frontier; None where no step was predicted."""
    if not point.explicit_step_s or point.tets is None:
        return None
    return point.tets / (SHARE_OF_STEP * point.explicit_step_s)


def fewest(points, family, error):
    """The point of a family with the fewest among those whose error is at most that; None without one."""
    good = [point for point in points if point.family == family and element_steps(point) is not None
            and point.errors.get(MEASURE) is not None and point.errors[MEASURE] <= error]
    return min(good, key=element_steps, default=None)


def read_rows(run, scenes):
    """[(error, family, {scene: its point}, {family that it is held against: {scene: times as few}})], nothing where families are models."""
    if asked(run).get("of") != "simplifiers":
        return []
    rows = []
    for family in families_of(run):
        for error in asked(run)["at"]:
            own = {key: found for key, points in scenes.items() if (found := fewest(points, family, error)) is not None}
            ratios = {}
            for name in map(str, asked(run).get("against", [])):
                peers = {} if name == family else {key: fewest(scenes[key], name, error) for key in own}
                ratios[name] = {key: element_steps(peer) / element_steps(own[key]) for key, peer in peers.items() if peer is not None}
            if own:
                rows.append((error, family, own, ratios))
    return rows


def count_text(value):
    return f"{value:.3g}"


def cells(row, against, scenes):
    """Family, error, counts, and how many times as few as each other family's."""
    error, family, own, ratios = row
    text = span_text([element_steps(point) / 1e6 for point in own.values()], count_text)
    if len(own) < scenes:
        text += f" on {len(own)} of {scenes}"
    return [family, percent_text(error), text, *(span_text(list(ratios[name].values()), count_text) if ratios.get(name) else "" for name in against)]


def rows_text(run, scenes, rows):
    against = [str(name) for name in asked(run).get("against", [])]
    shown = [cells(row, against, len(scenes)) for row in rows]
    for before, line in zip(rows, shown[1:]):
        if before[1] == line[0]:
            line[0] = ""  # named once
    return ("Tetrahedra times steps of a simulated second, the fewest of each family at equal error, median over the scenes (least to most); no time is in it\n\n"
            + align(["family", "error at most, %", "millions of them", *(f"times as few as {name}" for name in against)],
                    shown))


def write_rows(rows, folder):
    """Writes element_steps.csv, a row an error, family and scene; returns its name."""
    write_csv(folder / "element_steps.csv",
              ["error", "family", "scene", "poisson_ratio", "label", "mesh", "case", "tets", "explicit_step_s", "element_steps", "times_as_few_as"],
              [[error, family, *key, point.label, point.mesh, point.case, point.tets, point.explicit_step_s, element_steps(point),
                " ".join(f"{name}={found[key]:.4g}" for name, found in ratios.items() if key in found)]
               for error, family, own, ratios in rows for key, point in own.items()])
    return {"element_steps.csv"}

