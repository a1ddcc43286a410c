"""Charts of a contest of displacements: errors by method and scene, error against time, against refinement, and over
simplified meshes. A hollow mark is a figure that the reference cannot tell (deform.py).
"""

import math

import matplotlib.pyplot as plt
from matplotlib.colors import LogNorm
from matplotlib.patches import Patch, Rectangle
from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter, NullLocator

from deform import convergence, count_charts, counts, frontier_charts
from deform.deform import (MAIN, MARGIN, NO_SIMPLIFIER, labels_of, root_mean_square, setting_of, setting_text, settings_of,
                           simplified_text)
from shared.chart_style import FAINT, GRID, INK, STYLE, draw_legend, file_name, lay_out, save, set_time_axis, set_title
from shared.records import median
from shared.tables import percent_text

COLORS = ["#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#7a5195", "#8c6d1f", "#b22222", "#2f8f8f", "#808000",
          "#a0522d"]
MARKS = ["o", "s", "^", "D", "v", "P", "<", "X", ">", "h", "p", "*"]
SIZES = {"*": 1.6, "P": 1.15, "X": 1.15, "p": 1.15, "h": 1.1, "D": 0.9}  # of marks that look smaller or larger than others
GREYS = [INK, "#9a9a9a"]
GREY_MARKS = ["s", "o", "D", "^", "v", "X"]
SHADE = "#ececec"
DEFORMATION = "displacement_deformation"
NAMES = ["error_bars", "error_time", "convergence", "simplified_error", "error_count", "frontier"]


def read_styles(sections):
    """Colour and mark of each label, the same in every chart; methods of the reference's kind are black and grey, squares first."""
    styles, place, greys = {}, 0, 0
    kinds = {row.label: row.is_reference_kind for section in sections for row in section.rows}
    for label, is_reference_kind in kinds.items():
        if is_reference_kind:
            styles[label] = (GREYS[greys % len(GREYS)], GREY_MARKS[greys // len(GREYS) % len(GREY_MARKS)])
            greys += 1
            continue
        # After one round of colours and marks the colours go on with other marks.
        styles[label] = (COLORS[place % len(COLORS)], MARKS[(place + place // len(COLORS)) % len(MARKS)])
        place += 1
    return styles


def draw_mark(ax, x, y, style, size, hollow):
    color, mark = style
    ax.plot(x, y, mark, color=color, markersize=size * SIZES.get(mark, 1.0), zorder=5, markerfacecolor="white" if hollow else color,
            markeredgecolor=color if hollow else "white", markeredgewidth=0.18 * size if hollow else 0.1 * size)


def finish(fig, title, handles, **spacing):
    """Title above, legend below."""
    set_title(fig, title)
    lay_out(fig, draw_legend(fig, handles), **spacing)


def percent_number(value):
    return f"{value:g}" if value < 1e5 else f"{value:.0e}"


def set_percent_axis(axis):
    """Numbers at 1, 2, 5 (and between, on a short axis) where there is room for them; at every second power of ten where there is little."""
    low, high = sorted(axis.get_view_interval())
    if high > 2e4 * low:
        axis.set_major_locator(LogLocator(base=100, numticks=12))
    else:
        subs = (1, 1.5, 2, 3, 4, 5, 7) if high < 10 * low else (1, 2, 5) if high < 300 * low else (1,)
        axis.set_major_locator(LogLocator(subs=subs, numticks=12))
    axis.set_major_formatter(FuncFormatter(lambda value, _: percent_number(value)))
    axis.set_minor_locator(LogLocator(subs=range(2, 10), numticks=12))
    axis.set_minor_formatter(NullFormatter())


def percent_range(sections, measure=MAIN):
    """Limits of an axis of errors that holds all figures, or None without any."""
    values = [100 * row.values[measure] for section in sections for row in section.rows if row.values[measure]]
    if not values:
        return None
    return min(values) / 1.6, min(max(values), 1e4) * 1.5


def plain(sections):
    """Those on the scene's own mesh that have a reference."""
    return [section for section in sections if section.simplify in ("", NO_SIMPLIFIER) and section.has_reference]


def by_setting(sections):
    return [(setting, [section for section in sections if setting_of(section) == setting]) for setting in settings_of(sections)]


def legend_of(styles, labels, more=()):
    handles = [plt.Line2D([], [], color=styles[label][0], marker=styles[label][1], linewidth=0, markeredgecolor="white", label=label,
                          markersize=6.5 * SIZES.get(styles[label][1], 1.0)) for label in labels]
    return [*handles, *more]


def hollow_handle():
    return plt.Line2D([], [], color=FAINT, marker="o", markerfacecolor="white", linewidth=0, markersize=6.5,
                      label=f"hollow: reference not {MARGIN:g} x better")


# --- Errors by method and scene -----------------------------------------------------------------------------------------


def bar_measure(sections):
    """What the bars show: the error of the deformation, or, in runs of before it was judged, the L2 error."""
    is_judged = any(row.values.get(DEFORMATION) for section in sections for row in section.rows)
    return DEFORMATION if is_judged else MAIN


def draw_row(ax, row, y, style, measure):
    """A figure with the reference's error as its whisker; hollow if marked."""
    color, _ = style
    value, own = 100 * row.values[measure], row.own_errors.get(measure)
    if own is not None:
        spread = 100 * own
        ax.plot([max(value - spread, value / 50), value + spread], [y, y], color=color, linewidth=1.6, alpha=0.6,
                solid_capstyle="butt", zorder=3)
    draw_mark(ax, value, y, style, 6.5, row.is_coarse(measure))


def draw_error_panel(ax, section, labels, styles, limits, measure):
    owns = [row.own_errors.get(measure) for row in section.rows if row.own_errors.get(measure) is not None]
    if owns:
        ax.axvspan(limits[0] / 10, MARGIN * 100 * max(owns), color=SHADE, linewidth=0, zorder=0)
    if section.peer:
        ax.axvline(100 * section.peer.values[measure], color=INK, linewidth=1.0, linestyle=(0, (3, 2)), zorder=1)
    for y, label in enumerate(labels):
        row = section.find(label)
        if row is None:
            continue
        if row.values[measure]:
            draw_row(ax, row, y, styles[label], measure)
        text = percent_text(row.values[measure]) if row.is_judged else "failed"
        ax.annotate(text, (1.015, y), xycoords=("axes fraction", "data"), fontsize=7.5, va="center", color=INK if row.is_judged else FAINT)
    ax.set_xscale("log")
    ax.set_xlim(*limits)
    set_percent_axis(ax.xaxis)
    ax.set_ylim(len(labels) - 0.4, -0.6)
    ax.set_yticks(range(len(labels)), labels)
    ax.tick_params(axis="y", length=0)
    ax.grid(axis="both")
    ax.set_title(section.problem.scene, loc="left", fontweight="bold", fontsize=9.5)


def draw_error_bars(sections, styles, folder):
    """One figure for each Poisson ratio and size: a panel a scene, a line a label."""
    drawn = []
    for setting, own in by_setting(plain(sections)):
        measure = bar_measure(own)
        limits = percent_range(own, measure)
        if limits is None:
            continue
        labels = labels_of(own)
        columns = 3 if len(own) in (5, 6, 9) else min(4, len(own))
        rows = -(-len(own) // columns)
        height = rows * (0.21 * len(labels) + 0.75) + 1.1
        width = max(6.4, 2.75 * columns + 0.3 + 0.075 * max(len(label) for label in labels))
        fig, grid = plt.subplots(rows, columns, figsize=(width, height), sharey=True, squeeze=False)
        for ax, section in zip(grid.flat, own):
            draw_error_panel(ax, section, labels, styles, limits, measure)
        for ax in list(grid.flat)[len(own):]:
            ax.set_visible(False)
        for ax in list(grid.flat)[max(0, len(own) - columns):len(own)]:
            ax.set_xlabel("error of the deformation, %" if measure == DEFORMATION else "relative L2 error, %")
        handles = [plt.Line2D([], [], color=FAINT, linewidth=1.6, label="whisker: the reference's own error"), hollow_handle(),
                   Patch(color=SHADE, label=f"below {MARGIN:g} x the reference's error")]
        if any(section.peer for section in own):
            handles.append(plt.Line2D([], [], color=INK, linewidth=1.0, linestyle=(0, (3, 2)), label=f"{own[0].beside}, same mesh"))
        heading = setting_text(setting)
        what = "Error of the deformation" if measure == DEFORMATION else "Displacement error"
        finish(fig, f"{what} by method and scene{f': {heading}' if heading else ''}", handles, w_pad=2.2)
        drawn += save(fig, folder, file_name("error_bars", heading))
    return drawn


# --- Error against time -------------------------------------------------------------------------------------------------


def places_of(own, label):
    """(milliseconds, percent, row) of a label on each scene that it solved."""
    rows = [section.find(label) for section in own]
    return [(1000 * row.values["kernel_s"], 100 * row.values[MAIN], row) for row in rows
            if row is not None and row.values[MAIN] and row.values["kernel_s"]]


def front_of(points):
    """Corners of the staircase below which no point lies."""
    corners, least = [], math.inf
    for x, y in sorted(points):
        if y < least:
            corners.append((x, y))
            least = y
    return corners


def draw_time_panel(ax, own, styles, setting):
    middles = []
    for label in labels_of(own):
        found = places_of(own, label)
        if not found:
            continue
        color, mark = styles[label]
        ax.plot([x for x, _, _ in found], [y for _, y, _ in found], mark, color=color, markersize=3, alpha=0.25, linewidth=0,
                markeredgewidth=0, zorder=2)
        # Only one that solved every scene has a place among the others.
        if len(found) < len([section for section in own if section.find(label)]):
            continue
        x, y = median([x for x, _, _ in found]), root_mean_square([y for _, y, _ in found])
        coarse = any(row.is_coarse(MAIN) for _, _, row in found)
        draw_mark(ax, x, y, styles[label], 8, coarse)
        middles.append((x, y))
    front = front_of(middles)
    if len(front) > 1:
        ax.step([x for x, _ in front], [y for _, y in front], where="post", color=FAINT, linewidth=1.0, linestyle=(0, (4, 2)), zorder=1)
    ax.set_title(setting_text(setting) or "all scenes", loc="left", fontweight="bold")
    ax.grid(axis="both")


def draw_error_time(sections, styles, folder):
    """Speed and accuracy: median time and rms error over the scenes; faint marks are single scenes."""
    groups = [(setting, own) for setting, own in by_setting(plain(sections)) if any(places_of(own, label) for label in labels_of(own))]
    if not groups:
        return []
    columns = min(3, len(groups))
    rows = -(-len(groups) // columns)
    height = 3.3 * rows + 1.9
    fig, grid = plt.subplots(rows, columns, figsize=(max(6.4, 3.7 * columns + 0.4), height), squeeze=False, sharey=True)
    times = [x for _, own in groups for label in labels_of(own) for x, _, _ in places_of(own, label)]
    limits = percent_range(plain(sections))
    for ax, (setting, own) in zip(grid.flat, groups):
        draw_time_panel(ax, own, styles, setting)
        set_time_axis(ax, min(times), max(times))
        ax.set_yscale("log")
        ax.set_ylim(*limits)
        set_percent_axis(ax.yaxis)
        ax.set_xlabel("time (kernel, median)")
    for ax in list(grid.flat)[len(groups):]:
        ax.set_visible(False)
    for row in grid:
        row[0].set_ylabel("relative L2 error, %")
    more = [plt.Line2D([], [], color=FAINT, marker="o", markersize=3, alpha=0.5, linewidth=0, label="small: one scene"), hollow_handle(),
            plt.Line2D([], [], color=FAINT, linewidth=1.0, linestyle=(0, (4, 2)), label="front: nothing is faster and better")]
    finish(fig, "Accuracy against time: rms error over the scenes", legend_of(styles, labels_of(plain(sections)), more))
    return save(fig, folder, "error_time")


# --- Refinement ---------------------------------------------------------------------------------------------------------


def draw_refinement_panel(ax, own, styles):
    references = {}
    for series in own:
        color, _ = styles[series.label]
        x = [row.vertices for row in series.rows]
        y = [100 * row.values[MAIN] for row in series.rows]
        ax.plot(x, y, color=color, linewidth=1.4, zorder=3, linestyle=(0, (3, 1.5)) if convergence.WORSE in series.steps else "-")
        for row, x_, y_ in zip(series.rows, x, y):
            draw_mark(ax, x_, y_, styles[series.label], 6, row.is_coarse(MAIN))
            if row.own_errors.get(MAIN) is not None:
                references[x_] = 100 * row.own_errors[MAIN]
    if references:
        x = sorted(references)
        ax.fill_between(x, [references[v] for v in x], 1e-9, color=GRID, linewidth=0, zorder=0)
        ax.plot(x, [MARGIN * references[v] for v in x], color=FAINT, linewidth=0.9, linestyle=":", zorder=1)
    ax.set_xscale("log")
    ax.set_yscale("log")
    ax.grid(axis="both")


def vertices_text(value):
    return f"{value / 1000:.2g}k" if value >= 1000 else f"{value:g}"


def finish_refinement_axes(axes, all_series):
    """The same limits in all panels, with the sizes that were asked for as numbers."""
    rows = [row for series in all_series for row in series.rows if row.values[MAIN]]
    sizes = sorted({row.problem.wanted_vertices for row in rows})
    errors = [100 * row.values[MAIN] for row in rows]
    for ax in axes:
        ax.set_xlabel("vertices")
        ax.set_xlim(min(row.vertices for row in rows) / 1.2, max(row.vertices for row in rows) * 1.2)
        ax.set_ylim(min(errors) / 1.6, 1.5 * max(errors))
        ax.set_xticks(sizes, [vertices_text(size) for size in sizes])
        ax.xaxis.set_minor_locator(NullLocator())
        set_percent_axis(ax.yaxis)


def draw_convergence(sections, styles, folder):
    """A figure for each Poisson ratio, a panel a scene: error against vertices; dashed lines got worse on the way."""
    drawn = []
    every = convergence.read_series(sections)
    for ratio in dict.fromkeys(series.poisson_ratio for series in every):
        all_series = [series for series in every if series.poisson_ratio == ratio]
        scenes = list(dict.fromkeys(series.scene for series in all_series))
        columns = min(3, len(scenes)) if len(scenes) != 4 else 2
        rows = -(-len(scenes) // columns)
        height = 2.9 * rows + 1.9
        fig, grid = plt.subplots(rows, columns, figsize=(max(6.4, 3.4 * columns + 0.5), height), squeeze=False, sharey=True)
        for ax, scene in zip(grid.flat, scenes):
            draw_refinement_panel(ax, [series for series in all_series if series.scene == scene], styles)
            ax.set_title(scene, loc="left", fontweight="bold")
        finish_refinement_axes(list(grid.flat)[:len(scenes)], all_series)
        for ax in list(grid.flat)[len(scenes):]:
            ax.set_visible(False)
        for row in grid:
            row[0].set_ylabel("relative L2 error, %")
        more = [hollow_handle(), Patch(color=GRID, label="the reference's own error"),
                plt.Line2D([], [], color=FAINT, linewidth=0.9, linestyle=":", label=f"{MARGIN:g} x that")]
        if any(convergence.WORSE in series.steps for series in all_series):
            more.append(plt.Line2D([], [], color=FAINT, linewidth=1.4, linestyle=(0, (3, 1.5)), label="dashed: got worse when refined"))
        labels = list(dict.fromkeys(series.label for series in all_series))
        heading = "" if ratio is None else f"nu {ratio:g}"
        finish(fig, f"Does it get better when its mesh is refined?{f' {heading}' if heading else ''}", legend_of(styles, labels, more))
        drawn += save(fig, folder, file_name("convergence", heading))
    return drawn


# --- Simplified meshes --------------------------------------------------------------------------------------------------


def draw_cell(ax, x, y, row, norm, colors):
    if row is None:
        return
    if not row.is_judged:
        ax.add_patch(Rectangle((x - 0.5, y - 0.5), 1, 1, facecolor="white", edgecolor=GRID, hatch="///", linewidth=0))
        ax.text(x, y, "failed", ha="center", va="center", fontsize=7, color=FAINT)
        return
    value = max(100 * row.values[MAIN], norm.vmin)
    shade = colors(norm(value))
    ax.add_patch(Rectangle((x - 0.5, y - 0.5), 1, 1, facecolor=shade, edgecolor="white", linewidth=1))
    light = 0.3 * shade[0] + 0.59 * shade[1] + 0.11 * shade[2] > 0.55
    text = percent_text(row.values[MAIN]) + ("~" if row.is_coarse(MAIN) else "")
    ax.text(x, y, text, ha="center", va="center", fontsize=8, color=INK if light else "white")


def draw_simplified(sections, folder):
    """A heat map a problem: simplifiers and reductions down, methods across."""
    drawn = []
    problems = list(dict.fromkeys(section.problem for section in sections if section.simplify))
    for problem in problems:
        own = [section for section in sections if section.problem == problem]
        values = [100 * row.values[MAIN] for section in own for row in section.rows if row.values[MAIN]]
        if len(own) < 2 or not values:
            continue
        own.sort(key=lambda section: (section.simplify != NO_SIMPLIFIER, section.ratio or 0))
        labels = labels_of(own)
        norm = LogNorm(min(values) / 1.01, max(max(values), 1.05 * min(values)))
        colors = plt.get_cmap("viridis_r")
        fig, ax = plt.subplots(figsize=(0.78 * len(labels) + 2.9, 0.3 * len(own) + 2.1))
        for y, section in enumerate(own):
            for x, label in enumerate(labels):
                draw_cell(ax, x, y, section.find(label), norm, colors)
        ax.set_xlim(-0.5, len(labels) - 0.5)
        ax.set_ylim(len(own) - 0.5, -0.5)
        ax.set_xticks(range(len(labels)), labels, rotation=30, ha="right", rotation_mode="anchor")
        names = [simplified_text("as it is" if section.simplify == NO_SIMPLIFIER else section.simplify, section.ratio) for section in own]
        ax.set_yticks(range(len(own)), names)
        ax.tick_params(length=0)
        for spine in ax.spines.values():
            spine.set_visible(False)
        ax.set_title(f"{problem.name}: L2 error in % on simplified meshes", loc="left", fontweight="bold")
        bar = fig.colorbar(plt.cm.ScalarMappable(norm, colors), ax=ax, fraction=0.04, pad=0.02)
        set_percent_axis(bar.ax.yaxis)
        bar.outline.set_visible(False)
        fig.tight_layout()
        drawn += save(fig, folder, file_name("simplified_error", problem.name))
    return drawn


def draw_charts(run, sections, _series, points, folder):
    """Draws the charts that the plan names (all without a list) and the run has figures for; returns the names of the files."""
    folder.mkdir(parents=True, exist_ok=True)
    names = run.plan_data.get("charts") or NAMES
    styles = read_styles(sections)
    drawn = []
    with plt.rc_context(STYLE):
        if "error_bars" in names:
            drawn += draw_error_bars(sections, styles, folder)
        if "error_time" in names:
            drawn += draw_error_time(sections, styles, folder)
        if "convergence" in names:
            drawn += draw_convergence(sections, styles, folder)
        if "simplified_error" in names:
            drawn += draw_simplified(sections, folder)
        if "error_count" in names:
            drawn += count_charts.draw_counts(counts.shown_curves(counts.read_curves(run, sections), run.plan_data), folder)
        if "frontier" in names and points:
            drawn += frontier_charts.draw_frontiers(run, points, folder)
    return drawn
