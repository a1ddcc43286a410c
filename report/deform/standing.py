"""What each family of a frontier is good for: on how many scenes it has a point that nothing beats, at which errors, and where it has none,
which model takes its place.
"""

from dataclasses import dataclass, field

from deform.frontier import MEASURE, WORKS, families_of, fastest, short_seconds, span_text
from shared.tables import align, percent_text, write_csv


@dataclass
class Standing:
    """A family's place by one kind of work, over the scenes where it has a time at all."""

    work: str
    family: str
    scenes: int = 0
    on: dict = field(default_factory=dict)  # scene: its points on the frontier, the fastest first
    beaten: dict = field(default_factory=dict)  # scene: (its most accurate point, the fastest of others that is no worse or None)


def read_standings(run, scenes):
    """One entry a work and family that has a time somewhere."""
    standings = []
    for work, _ in WORKS:
        for family in families_of(run):
            one = Standing(work, family)
            for key, points in scenes.items():
                own = [point for point in points if point.family == family and point.has(work, MEASURE)]
                if not own:
                    continue
                one.scenes += 1
                on = sorted((point for point in own if (work, MEASURE) in point.on), key=lambda point: point.works[work].median)
                if on:
                    one.on[key] = on
                    continue
                best = min(own, key=lambda point: (point.errors[MEASURE], point.works[work].median))
                others = [point for point in points if point.family != family]
                one.beaten[key] = (best, fastest(others, work, best.errors[MEASURE]))
            if one.scenes:
                standings.append(one)
    return standings


def good_for(one):
    """Where it is on the frontier: errors and times of its points there, over all scenes."""
    points = [point for own in one.on.values() for point in own]
    if not points:
        return ""
    errors = [point.errors[MEASURE] for point in points]
    times = [point.works[one.work].median for point in points]
    both = [(percent_text(min(errors)), percent_text(max(errors))), (short_seconds(min(times)), short_seconds(max(times)))]
    error, time = (low if low == high else f"{low} to {high}" for low, high in both)
    return f"{error}% in {time}"


def instead(one):
    """What is as good and faster where it has no point on the frontier: families, and how many times as fast."""
    found = {}
    for best, other in one.beaten.values():
        if other is not None:
            found.setdefault(other.family, []).append(best.works[one.work].median / other.works[one.work].median)
    return "; ".join(f"{family}, {span_text(ratios, lambda value: f'{value:.3g}')} times as fast" for family, ratios in found.items())


def standing_text(standings):
    """The table, or an empty text where no family has a time."""
    rows = []
    titles = dict(WORKS)
    for one in standings:
        title = titles[one.work] if not rows or rows[-1][-1] != one.work else ""
        rows.append([title, one.family, f"{len(one.on)} of {one.scenes}", good_for(one), instead(one), one.work])
    if not rows:
        return ""
    return ("What each family is good for: scenes on whose frontier it is, errors and times of its points there; elsewhere what is as good as its "
            "most accurate point and faster (median over the scenes, least to most)\n\n"
            + align(["work", "family", "on it", "good for", "elsewhere take"], [row[:-1] for row in rows]))


def write_standings(standings, folder):
    """Writes standing.csv; returns its name."""
    write_csv(folder / "standing.csv", ["work", "family", "scenes", "scenes_on_frontier", "good_for", "elsewhere"],
              [[one.work, one.family, one.scenes, len(one.on), good_for(one), instead(one)] for one in standings])
    return {"standing.csv"}
