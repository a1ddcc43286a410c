"""Tetrahedra times explicit steps of a simulated second: what a mesh costs a simulator whatever the machine is.

Meshes that one model is moved on, so it stands where a plan's families are simplifiers; models have steps of different costs. A second has
1 / (0.9 explicit_step_s) steps, as `simulated_second_s` does. It is a count, without noise: where times of two runs differ, it does not.
"""

from deform.frontier import Work, asked, equal_error_rows, family_cell, ratio_cell, ratios_text
from shared.tables import align, percent_text, write_csv

SHARE_OF_STEP = 0.9  # of the longest stable one
ELEMENT_STEPS = "element_steps"  # the work of a point


def read_rows(run, scenes):
    """As frontier.equal_error_rows, of this work; nothing where families are models. It joins the works of the points."""
    if asked(run).get("of") != "simplifiers":
        return []
    for points in scenes.values():
        for point in points:
            if point.explicit_step_s and point.tets is not None:
                count = point.tets / (SHARE_OF_STEP * point.explicit_step_s)
                point.works[ELEMENT_STEPS] = Work(count, count, count)
    return [row for row in equal_error_rows(run, scenes, [ELEMENT_STEPS]) if row["times"]]


def cells(row, against):
    """Family, error, millions, and how many times as few as each other family's."""
    return [row["family"], percent_text(row["error"]), family_cell(row, lambda count: f"{count / 1e6:.3g}"), *(ratio_cell(row, name) for name in against)]


def rows_text(run, rows):
    against = [str(name) for name in asked(run).get("against", [])]
    shown = [cells(row, against) for row in rows]
    for before, line in zip(rows, shown[1:]):
        if before["family"] == line[0]:
            line[0] = ""  # named once
    return ("Tetrahedra times steps of a simulated second, the fewest of each family at equal error, median over the scenes (least to most); no time is in it\n\n"
            + align(["family", "error at most, %", "millions of them", *(f"times as few as {name}" for name in against)], shown))


def write_rows(rows, folder):
    """Writes element_steps.csv, a row a family, error and scene; returns its name."""
    write_csv(folder / "element_steps.csv",
              ["error", "family", "scene", "poisson_ratio", "label", "mesh", "case", "tets", "explicit_step_s", ELEMENT_STEPS, "times_as_few_as"],
              [[row["error"], row["family"], *key, point.label, point.mesh, point.case, point.tets, point.explicit_step_s, point.works[ELEMENT_STEPS].median, ratios_text(row, key)]
               for row in rows for key, point in row["times"].items()])
    return {"element_steps.csv"}
