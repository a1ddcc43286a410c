"""Charts of error against work: one figure for each scene and measure, a panel for each kind of work.

A colour is a family, a filled mark is on the frontier, a hollow one is not; whiskers are the 95% interval of the median. Names
stand at the points of the frontier alone. What gave no answer is counted in a corner: it has neither place nor time.
"""

import math

import matplotlib.pyplot as plt
from matplotlib.patches import Patch

from deform.frontier import MEASURE, WORKS, families_of, scene_text
from shared.chart_style import FAINT, GRID, INK, draw_legend, file_name, lay_out, save, set_time_axis, set_title

COLORS = ["#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#7a5195", "#8c6d1f"]
MARKS = ["o", "s", "^", "D", "v", "P", "X", "h"]
STEP = 0.95  # a corner is named if its error is below this times that of the last that was
MOST_STEPS = 9  # for which there is room below a panel
MEASURES = {"displacement_deformation": "error of the deformation, %", "displacement_l2": "relative L2 error, %",
            "displacement_energy": "error in energy, %", "pad_force": "error of the pads' force, %"}


def styles_of(run):
    return {name: (COLORS[k % len(COLORS)], MARKS[(k + k // len(COLORS)) % len(MARKS)]) for k, name in enumerate(families_of(run))}


def percent(value):
    return 100.0 * value


def draw_point(ax, point, work, measure, style):
    color, mark = style
    is_on = (work, measure) in point.on
    own = point.works[work]
    x, y = 1000 * own.median, percent(point.errors[measure])
    if is_on and math.isfinite(own.low) and math.isfinite(own.high):
        ax.plot([1000 * own.low, 1000 * own.high], [y, y], color=color, linewidth=1.4, alpha=0.6, zorder=3)
    ax.plot([x], [y], mark, color=color, markersize=7 if is_on else 4.2, zorder=5 if is_on else 2, alpha=1.0 if is_on else 0.45,
            markerfacecolor=color if is_on else "white", markeredgecolor="white" if is_on else color, markeredgewidth=0.7)


def corners_of(points, work, measure):
    """The points that have less error than everything faster, by medians, fastest first."""
    least, found = math.inf, []
    for point in sorted(points, key=lambda each: (each.works[work].median, each.errors[measure])):
        if point.errors[measure] < least:
            least = point.errors[measure]
            found.append(point)
    return found


def place_of(point, work, measure):
    return 1000 * point.works[work].median, percent(point.errors[measure])


def draw_border(ax, corners, work, measure):
    """The border below which no point lies, by medians; a number at each corner that is a step of some size. Returns what the
    numbers stand for."""
    places = [place_of(point, work, measure) for point in corners]
    ax.step([x for x, _ in places], [y for _, y in places], where="post", color=FAINT, linewidth=1.0, linestyle=(0, (4, 2)), zorder=1)
    lines, named = [], math.inf
    for point, (x, y) in zip(corners, places):
        if y > STEP * named and point is not corners[-1]:
            continue
        named = y
        lines.append(f"{len(lines) + 1}  {point.name}")
        ax.annotate(str(len(lines)), (x, y), xytext=(-6, -8), textcoords="offset points", fontsize=7, ha="right", va="center", color=INK)
    return lines


def draw_panel(ax, points, work, title, measure, styles):
    own = [point for point in points if point.has(work, measure)]
    for point in own:
        draw_point(ax, point, work, measure, styles[point.family])
    lines = draw_border(ax, corners_of(own, work, measure), work, measure)
    references = [percent(point.own_errors[measure]) for point in own if point.own_errors.get(measure) is not None]
    set_time_axis(ax, min(1000 * point.works[work].median for point in own), max(1000 * point.works[work].median for point in own))
    ax.set_yscale("log")
    if references:
        ax.axhspan(1e-9, max(references), color=GRID, alpha=0.6, linewidth=0, zorder=0)
    ax.set_title(f"{title} ({len(own)} points)", loc="left", fontweight="bold")
    ax.set_xlabel(f"time of a {title}")
    ax.grid(axis="both")
    ax.annotate("\n".join(lines), (0, 0), xytext=(0, -38), xycoords="axes fraction", textcoords="offset points", fontsize=7, va="top", ha="left",
                color=INK)
    return len(lines)


def limits_of(points, measure):
    values = [percent(point.errors[measure]) for point in points if point.errors.get(measure)]
    return min(values) / 1.5, min(max(values) * 1.5, 1000.0)


def draw_frontier(run, key, points, measure, styles):
    from deform.deform_charts import set_percent_axis  # the same axis as all errors
    works = [(work, title) for work, title in WORKS if any(point.has(work, measure) for point in points)]
    if not works:
        return None
    steps = max(len(corners_of([point for point in points if point.has(work, measure)], work, measure)) for work, _ in works)
    height = 4.2 + 0.135 * min(steps, MOST_STEPS)
    fig, axes = plt.subplots(1, len(works), figsize=(4.1 * len(works) + 0.7, height), squeeze=False, sharey=True)
    for ax, (work, title) in zip(axes[0], works):
        draw_panel(ax, points, work, title, measure, styles)
    axes[0][0].set_ylim(*limits_of(points, measure))
    set_percent_axis(axes[0][0].yaxis)
    axes[0][0].set_ylabel(MEASURES[measure])
    lost = sum(1 for point in points if point.note)
    families = [name for name in styles if any(point.family == name for point in points)]
    handles = [plt.Line2D([], [], color=styles[name][0], marker=styles[name][1], linewidth=0, markersize=6.5, label=name) for name in families]
    handles += [plt.Line2D([], [], color=FAINT, marker="o", markerfacecolor="white", linewidth=0, markersize=4.2, label="hollow: beaten for certain"),
                plt.Line2D([], [], color=FAINT, linewidth=1.0, linestyle=(0, (4, 2)), label="least error for the time, by medians"),
                Patch(color=GRID, label="within the reference's own error")]
    if lost:
        handles.append(plt.Line2D([], [], linewidth=0, label=f"{lost} gave no answer: see the table"))
    set_title(fig, f"What accuracy costs: {scene_text(key)}")
    lay_out(fig, draw_legend(fig, handles))
    return fig


def draw_frontiers(run, scenes, folder):
    """Returns the names of the files."""
    drawn = []
    styles = styles_of(run)
    for key, points in scenes.items():
        for measure in MEASURES:
            if not any(point.errors.get(measure) for point in points):
                continue
            fig = draw_frontier(run, key, points, measure, styles)
            if fig is not None:
                name = file_name("frontier", scene_text(key), "" if measure == MEASURE else measure)
                drawn += save(fig, folder, name)
    return drawn
