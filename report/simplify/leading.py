"""The verdict of a contest of simplifiers whose plan makes no claim and no comparison: what the plan asks for first.

With the chart `scaling` that is how time grows with the mesh; else it is who has the best figure of the plan's first measure of shape or worth, at
equal count, mesh by mesh and count by count. Of figures that are the same as shown nobody is named alone.
"""

from shared.measure_text import DIGITS, TITLES, amount
from shared.records import median
from shared.tables import joined
from simplify import contest, scaling

MOST_NAMED = 4  # places, or labels
USUAL = "percent_above_0_5"


def scaling_sentence(series):
    """The power of the tetrahedra by which the time of each label grows."""
    fitted = sorted((entry for entry in series if entry.time), key=lambda entry: entry.time.slope)
    if not fitted:
        return "No label was timed on two sizes, so nothing is known of how its time grows."
    bounds = " [95% interval of the fit]" if any(entry.time.low is not None for entry in fitted) else ""
    return f"Time grows with the tetrahedra to the power{bounds} {', '.join(f'{scaling.slope_text(entry.time)} with {entry.name}' for entry in fitted)}."


def measure_of(run):
    """The first of the plan's measures that says how good a mesh is; and +1 if more of it is better, -1 if less."""
    signs = {column.name: column.sign for column in contest.COLUMNS if column.sign and column.name in DIGITS}
    named = run.plan_data.get("measure")
    name = next((str(name) for name in (named if isinstance(named, list) else []) if str(name) in signs), USUAL)
    return name, signs[name]


def winners_of(run, measure, sign):
    """[(where, the best figure as shown, whose)] at equal count, of each mesh and point of the sweep."""
    found = []
    for mesh in run.meshes():
        for sweep in dict.fromkeys(group.sweep for group in run.of_mesh(mesh)):
            own = [group for group in run.of_mesh(mesh) if group.sweep == sweep and not group.count_note]
            values = {group.label: value for group in own if (value := median(group.figures("judge", measure))) is not None}
            if values:
                shown = amount(measure, sign * max(sign * value for value in values.values()))
                where = ", ".join(text for text in (mesh, contest.short_sweep(sweep)) if text)
                found.append((where, shown, [label for label, value in values.items() if amount(measure, value) == shown]))
    return found


def tally_text(winners):
    """How often each label is the best, those first that are most often."""
    counts = {}
    for _, _, labels in winners:
        for label in labels:
            alone, shared = counts.get(label, (0, 0))
            counts[label] = (alone + (len(labels) == 1), shared + (len(labels) > 1))
    order = sorted(counts, key=lambda label: (-sum(counts[label]), -counts[label][0]))
    said = [f"{label} in {sum(counts[label])}" + (f" ({counts[label][1]} with others)" if counts[label][1] else "") for label in order[:MOST_NAMED]]
    return ", ".join([*said, *([f"{len(order) - MOST_NAMED} more labels"] if len(order) > MOST_NAMED else [])])


def best_sentence(run):
    """Who is best where."""
    measure, sign = measure_of(run)
    winners = winners_of(run, measure, sign)
    if not winners:
        return "No answer was accepted, so there is nothing to compare."
    title = f"The {'greatest' if sign > 0 else 'least'} {'share above a quality of 0.5' if measure == USUAL else TITLES[measure]}"
    if len(winners) > MOST_NAMED:
        return f"{title}, at {len(winners)} meshes and counts: {tally_text(winners)}."
    unit = "%" if measure.startswith("percent") else ""
    said = [f"{joined(labels)}{' alike' if len(labels) > 1 else ''} on {where} ({figure}{unit})" for where, figure, labels in winners]
    return f"{title}: {'; '.join(said)}."


def sentence(run, series):
    return scaling_sentence(series) if series else best_sentence(run)
