"""Time and memory against the number of tetrahedra, on logarithmic scales."""

import matplotlib.pyplot as plt
from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter

from shared.chart_style import FAINT, INK, draw_legend, lay_out, save, set_title
from shared.families import family_of
from simplify.scaling import slope_text

SIDE_STEP = 1.12
LINES = ["-", (0, (5, 2)), (0, (1, 1.5)), (0, (5, 2, 1, 2))]  # labels of one method


def count_text(value):
    for size, letter in ((1e6, "M"), (1e3, "k")):
        if value >= size:
            return f"{value / size:g}{letter}"
    return f"{value:g}"


def byte_text(value):
    return f"{value / 1e9:g} GB" if value >= 1e9 else f"{value / 1e6:g} MB"


def set_log_axis(axis, form):
    """Numbers at the powers of ten, and between them where the axis spans few."""
    low, high = sorted(axis.get_view_interval())
    axis.set_major_locator(LogLocator(subs=(1, 2, 5) if high < 60 * low else (1,), numticks=12))
    axis.set_major_formatter(FuncFormatter(lambda value, _: form(value)))
    axis.set_minor_locator(LogLocator(subs=range(2, 10), numticks=12))
    axis.set_minor_formatter(NullFormatter())


def draw_series(ax, entry, family, place, fit, value_of):
    """Filled marks at what was measured, and the fitted line; without a fit a line from mark to mark."""
    points = [(size.tets, value_of(size)) for size in entry.sizes if size.seconds and value_of(size)]
    color, mark = family.color, family.mark
    if points:
        line = [(x, fit.at(x)) for x in (points[0][0], points[-1][0])] if fit else points
        ax.plot(*zip(*line), color=color, linewidth=1.8 if family.is_own else 1.0, linestyle=LINES[place % len(LINES)], zorder=2)
        ax.plot(*zip(*points), mark, color=color, markersize=6.5, markeredgecolor="white", markeredgewidth=0.7, zorder=4)


def draw_limits(ax, entry, family, limits):
    """An open mark at the limit where a size timed out; several of one size stand side by side."""
    for size in entry.sizes:
        if size.limit_s:
            beside = limits[size.limit_s, size.tets] = limits.get((size.limit_s, size.tets), 0) + 1
            ax.plot(size.tets * SIDE_STEP ** (beside - 1), size.limit_s, family.mark, markersize=6.5, markerfacecolor="white", markeredgecolor=family.color,
                    markeredgewidth=1.2, zorder=5, clip_on=False)


def draw_scaling(series, families, folder):
    """One figure: time on the left, memory on the right; slopes with their intervals in the legend."""
    shown = [entry for entry in series if any(size.seconds or size.limit_s for size in entry.sizes)]
    if not any(entry.time for entry in shown):
        return []
    fig, (left, right) = plt.subplots(1, 2, figsize=(9.6, 4.6))
    limits, handles = {}, []
    for entry in shown:
        family = family_of(families, entry.label)
        place = family.labels.index(entry.label)
        draw_series(left, entry, family, place, entry.time, lambda size: size.seconds)
        draw_limits(left, entry, family, limits)
        draw_series(right, entry, family, place, None, lambda size: size.memory)
        handles.append(plt.Line2D([], [], color=family.color, marker=family.mark, markersize=6.5, markeredgecolor="white",
                                  linewidth=1.8 if family.is_own else 1.0, linestyle=LINES[place % len(LINES)],
                                  label=f"{entry.name}: {slope_text(entry.time)}" if entry.time else entry.name))
    for limit in {limit for limit, _ in limits}:
        left.axhline(limit, color=FAINT, linewidth=1.0, linestyle=(0, (3, 2)), zorder=1)
    if limits:
        handles.append(plt.Line2D([], [], color=FAINT, marker="o", markerfacecolor="white", linestyle=(0, (3, 2)), linewidth=1.0,
                                  markersize=6.5, label="hollow: timed out, at the limit"))
    finish(left, "time of the method (kernel, median), s", lambda value: f"{value:g}")
    finish(right, "greatest memory of the process, bytes", byte_text)
    set_title(fig, "Growth with the mesh; lines on the left and in the legend: slope of time, with its 95% interval", color=INK)
    lay_out(fig, draw_legend(fig, handles))
    return save(fig, folder, "scaling")


def finish(ax, title, form):
    ax.set_xscale("log")
    ax.set_yscale("log")
    set_log_axis(ax.xaxis, count_text)
    set_log_axis(ax.yaxis, form)
    ax.grid(axis="both")
    ax.set_xlabel("tetrahedra of the input")
    ax.set_ylabel(title)
