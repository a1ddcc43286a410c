"""A chart of each series with a step: medians in the order of the runs, the repeats' range, the levels, the steps."""

import matplotlib.pyplot as plt

from history.history import share_text
from shared.chart_style import BETTER, FAINT, INK, STYLE, THAN, file_name, save

MOST_LABELS = 16


def short_case(text, most=90):
    return text if len(text) <= most else text[:most - 3] + "..."


def draw_series(series, folder, number):
    """One chart; returns the names of its files, which start with step_ and a number."""
    count = len(series.points)
    fig, ax = plt.subplots(figsize=(7.4, 3.6))
    places = range(count)
    values = [point.value for point in series.points]
    lows = [point.value - min(point.values) for point in series.points]
    highs = [max(point.values) - point.value for point in series.points]
    if any(lows) or any(highs):
        ax.errorbar(places, values, yerr=[lows, highs], fmt="none", ecolor=FAINT, elinewidth=0.8, zorder=1)
    ax.plot(places, values, "o", color=BETTER, markersize=4.5, zorder=3)
    for first, last, level in series.levels():
        ax.plot([first - 0.4, last + 0.4], [level, level], color=INK, linewidth=1.3, zorder=2)
    low, high = ax.get_ylim()
    ax.set_ylim(low, high + 0.16 * (high - low))
    for step in series.steps:
        ax.axvline(step.place - 0.5, color=THAN, linewidth=1, linestyle="--", zorder=0)
        word = series.direction(step)
        ax.annotate(share_text(step.share) + (f"\n{word}" if word else ""), (step.place - 0.5, 0.985), xycoords=("data", "axes fraction"),
                    xytext=(4, 0), textcoords="offset points", color=THAN, fontsize=8, va="top")
    every = -(-count // MOST_LABELS)
    shown = sorted({*range(0, count, every), *(step.place for step in series.steps)})
    kept = [place for place in shown if place in {step.place for step in series.steps}
            or all(abs(place - step.place) >= every for step in series.steps)]
    ax.set_xticks(kept)
    ax.set_xticklabels([f"{series.points[place].run.name}\n{series.points[place].run.started_at[:10]}" for place in kept],
                       rotation=45, ha="right", rotation_mode="anchor", fontsize=7)
    ax.set_xlim(-0.6, count - 0.4)
    unit = series.measure["unit"]
    ax.set_ylabel(series.measure["name"] + ("" if unit == "1" else f" [{unit}]"))
    ax.set_title(short_case(f"{series.plan}: {series.case}"), loc="left")
    ax.grid(axis="y")
    fig.tight_layout()
    return save(fig, folder, f"step_{number:02d}_" + file_name(series.plan, series.case, series.measure["name"])[:180])


def draw_charts(history, folder, most):
    """The series with the largest steps, at most so many; returns the names of the files, and how many series were left out."""
    ordered = list({id(series): series for series, _ in history.found()}.values())
    folder.mkdir(parents=True, exist_ok=True)
    names = []
    with plt.rc_context(STYLE):
        for number, series in enumerate(ordered[:most], start=1):
            names += draw_series(series, folder, number)
    return names, max(0, len(ordered) - most)
