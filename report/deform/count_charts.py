"""The chart of error against tetrahedra: a figure for each label, Poisson ratio and size, a row of panels a scene, a column a family of simplifiers.

A curve is a simplifier; where its family has several, they differ in their wanted sizes (counts.py). Those of one size are side by side in a panel, the best of
each family that the plan names. The open square is the mesh as it is, the grey band the reference's own error.
"""

import matplotlib.pyplot as plt
from matplotlib.patches import Patch
from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter

from deform.counts import DEFORMATION, ONE_SIZE, families_of_several, measure_of
from shared.chart_style import FAINT, GRID, INK, draw_legend, file_name, lay_out, save, set_title

COLORS = ["#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#7a5195", "#8c6d1f"]
DASHES = ["-", (0, (4, 1.5)), (0, (1.2, 1.2)), (0, (4, 1.2, 1, 1.2))]
MARKS = ["o", "s", "^", "D", "v", "P", "X", "h"]
SUBS = (1, 1.5, 2, 3, 5, 7)


def number_text(value, _place=None):
    return f"{value / 1000:g}k" if value >= 1000 else f"{value:g}"


def set_log_axis(axis, formatter):
    """Numbers at 1, 1.5, 2, 3, 5 and 7 where there is room, at 1 and 3 or at powers of ten where there is less."""
    low, high = sorted(axis.get_view_interval())
    axis.set_major_locator(LogLocator(subs=SUBS if high < 12 * low else (1, 3) if high < 300 * low else (1,), numticks=12))
    axis.set_major_formatter(FuncFormatter(formatter))
    axis.set_minor_formatter(NullFormatter())


def styles_of(curves):
    """Colour, dash, mark and name of each simplifier: by its sizes in a family of several, else by its label."""
    members = {}
    for curve in curves:
        members.setdefault(curve.simplifier.family, {})[curve.simplifier.label] = curve.simplifier
    names = {}
    for family in members.values():
        for label, simplifier in family.items():
            names[label] = simplifier.sizes if len(family) > 1 or simplifier.sizes != ONE_SIZE else label
    places = {name: k for k, name in enumerate(dict.fromkeys(sorted(names.values(), key=lambda name: name != ONE_SIZE)))}
    return {label: (*style_at(places[name]), name) for label, name in names.items()}


def style_at(place):
    """Colour, dash and mark of the place-th name: no two of the first 64 are the same."""
    turn = place // len(COLORS)
    return COLORS[place % len(COLORS)], DASHES[(place + turn) % len(DASHES)], MARKS[(place + 3 * turn) % len(MARKS)]


def draw_curve(ax, curve, measure, style):
    color, dash, mark, _ = style
    points = [(row.tets, 100 * row.values[measure], row.is_coarse(measure)) for row in curve.rows if row.values[measure]]
    ax.plot([x for x, _, _ in points], [y for _, y, _ in points], color=color, linestyle=dash, linewidth=1.5, zorder=3)
    for x, y, is_coarse in points:
        ax.plot([x], [y], mark, color=color, markersize=5.5, zorder=4, markerfacecolor="white" if is_coarse else color,
                markeredgecolor=color if is_coarse else "white", markeredgewidth=0.8)


def draw_count_panel(ax, own, measure, styles):
    for curve in own:
        draw_curve(ax, curve, measure, styles[curve.simplifier.label])
    whole = next((curve.whole for curve in own if curve.whole is not None), None)
    if whole is not None and whole.values[measure]:
        ax.plot([whole.tets], [100 * whole.values[measure]], "s", color=INK, markerfacecolor="white", markersize=6, zorder=5)
    owns = [row.own_errors.get(measure) for curve in own for row in curve.rows if row.own_errors.get(measure)]
    if owns:
        ax.axhspan(1e-9, 100 * max(owns), color=GRID, alpha=0.6, linewidth=0, zorder=0)
    ax.set_xscale("log")
    ax.set_yscale("log")
    ax.grid(axis="both")


def limits_of(curves, measure):
    """Of both axes, in tetrahedra and percent; all panels of a figure have the same."""
    rows = [row for curve in curves for row in [*curve.rows, *([curve.whole] if curve.whole is not None else [])] if row.values[measure]]
    tets, errors = [row.tets for row in rows], [100 * row.values[measure] for row in rows]
    return (min(tets) / 1.15, 1.15 * max(tets)), (min(errors) / 1.4, 1.4 * max(errors))


def columns_of(curves):
    """Families of several have a column each; those of one are side by side in one panel."""
    families, several = dict.fromkeys(curve.simplifier.family for curve in curves), families_of_several(curves)
    single = [family for family in families if family not in several]
    return [[family] for family in families if family in several] + ([single] if single else [])


def draw_figure(curves, measure, title, folder, name):
    scenes, columns = list(dict.fromkeys(curve.problem.scene for curve in curves)), columns_of(curves)
    styles = styles_of(curves)
    fig, grid = plt.subplots(len(scenes), len(columns), figsize=(max(6.4, 3.6 * len(columns) + 0.6), 2.5 * len(scenes) + 1.7), squeeze=False)
    x_limits, _ = limits_of(curves, measure)
    for line, scene in zip(grid, scenes):
        of_scene = [curve for curve in curves if curve.problem.scene == scene]
        _, y_limits = limits_of(of_scene, measure)
        for ax, families in zip(line, columns):
            own = [curve for curve in of_scene if curve.simplifier.family in families]
            draw_count_panel(ax, own, measure, styles)
            ax.set_xlim(*x_limits)
            ax.set_ylim(*y_limits)
            set_log_axis(ax.xaxis, number_text)
            set_log_axis(ax.yaxis, number_text)
            what = "best of each family" if any(curve.simplifier.is_best for curve in own) else families[0] if len(families) == 1 else "side by side"
            ax.set_title(scene if len(columns) == 1 else f"{scene}, {what}", loc="left", fontweight="bold")
            ax.set_xlabel("tetrahedra")
        line[0].set_ylabel("error of the deformation, %" if measure == DEFORMATION else "relative L2 error, %")
    shown = dict.fromkeys(styles.values())
    handles = [plt.Line2D([], [], color=color, linestyle=dash, marker=mark, linewidth=1.5, markeredgecolor="white", label=text) for color, dash, mark, text in shown]
    handles += [plt.Line2D([], [], color=INK, marker="s", markerfacecolor="white", linewidth=0, label="the mesh as it is"),
                Patch(color=GRID, label="the reference's own error"),
                plt.Line2D([], [], color=FAINT, marker="o", markerfacecolor="white", linewidth=0, label="hollow: reference not 5 x better")]
    set_title(fig, title)
    lay_out(fig, draw_legend(fig, handles), w_pad=1.6)
    return save(fig, folder, name)


def draw_counts(curves, folder):
    """Returns the names of the files."""
    measure, drawn = measure_of(curves), []
    for setting in dict.fromkeys((curve.label, *curve.problem.setting) for curve in curves):
        own = [curve for curve in curves if (curve.label, *curve.problem.setting) == setting]
        drawn += draw_figure(own, measure, f"Error against tetrahedra: {', '.join(setting)}", folder, file_name("error_count", *setting))
    return drawn
