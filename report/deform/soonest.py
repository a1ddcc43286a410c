"""The verdict of a plan with a frontier: whose meshes or models come soonest at one error, scene by scene. A median over scenes of different
sizes would hide who is fastest on which.

The error is that of the plan's target for the work, or else the first that the plan names. The work is that of its first target, or else a simulated
second where simplifiers are compared, whose meshes are moved on; then the first of frontier.WORKS that was measured; where none was,
tetrahedra times steps (element_steps.py).
"""

from deform import element_steps, frontier
from shared.tables import joined

MOST_NAMED = 4  # scenes that are named; of more it is said how many
NOBODY = "No model came within an error that the plan names."


def count_text(count):
    return f"{count / 1e6:.3g} million"


def error_of(run, work, rows):
    """The error that the verdict is about: the target's, where any family comes within it."""
    wanted = [target.get("at") for target in frontier.asked(run).get("targets", []) if target.get("work") == work]
    found = [row["error"] for row in rows]
    return next((error for error in wanted if error in found), found[0])


def work_of(run, rows):
    measured = [row["work"] for row in rows]
    wanted = [target.get("work") for target in frontier.asked(run).get("targets", [])]
    wanted += ["second"] if frontier.asked(run).get("of") == "simplifiers" else []
    return next((work for work in wanted if work in measured), measured[0])


def winners_of(rows, scenes, work, text_of):
    """{families: {scene: the shown figure of the best}}: several families where their figures are the same as shown."""
    winners = {}
    for key in scenes:
        own = {row["family"]: row["times"][key].works[work].median for row in rows if key in row["times"]}
        if not own:
            continue
        least = text_of(min(own.values()))
        families = tuple(family for family, value in own.items() if text_of(value) == least)
        winners.setdefault(families, {})[key] = min(own.values())
    return dict(sorted(winners.items(), key=lambda item: -len(item[1])))


def winner_text(families, found, scenes, text_of):
    who = joined(families) + (" alike" if len(families) > 1 else "")
    if scenes <= MOST_NAMED:
        return f"from {who} on {joined(f'{frontier.scene_text(key)} ({text_of(value)})' for key, value in found.items())}"
    return f"from {who} on {len(found)} of {scenes} scenes, at {frontier.span_text(list(found.values()), text_of)}"


def sentence(run, scenes):
    """Who is the best at that error, on which scenes, by how much."""
    rows = [row for row in frontier.equal_error_rows(run, scenes) if row["times"]] or element_steps.read_rows(run, scenes)
    if not rows:
        return NOBODY
    work = work_of(run, rows)
    is_count = work == element_steps.ELEMENT_STEPS
    text_of = count_text if is_count else frontier.short_seconds
    said = "the fewest tetrahedra times steps of a simulated second come" if is_count else f"the {dict(frontier.WORKS)[work]} comes soonest"
    own = [row for row in rows if row["work"] == work]
    error = error_of(run, work, own)
    own = [row for row in own if row["error"] == error]
    winners = winners_of(own, scenes, work, text_of)
    parts = [winner_text(families, found, len(scenes), text_of) for families, found in winners.items()]
    missed = len(scenes) - sum(map(len, winners.values()))
    left = f"; none comes within it on {missed} of {len(scenes)} scenes" if missed else ""
    return f"At an error of at most {100 * error:g}% {said} {', '.join(parts)}{left}."
