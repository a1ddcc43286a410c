"""Order of convergence against known answers: one panel a case that is not solved exactly."""

import matplotlib.pyplot as plt
from matplotlib.ticker import NullFormatter, NullLocator

from shared.chart_style import INK, STYLE, save

COLORS = ["#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00"]
MARKS = ["o", "s", "^", "D", "v"]
ROUNDING = 1e-8  # errors below have no order


def read_curves(rows):
    """Per case and label the points (cells, error) above rounding; only with two of them."""
    curves = {}
    for row in rows:
        error = row.values["solution_l2"]
        if error is not None and error > ROUNDING and row.cells:
            curves.setdefault(row.case, {}).setdefault(row.label, []).append((row.cells, error, row.values["solution_order"]))
    return {case: {label: points for label, points in labels.items() if len(points) > 1} for case, labels in curves.items()
            if any(len(points) > 1 for points in labels.values())}


def draw_case(ax, case, curves, styles):
    sizes = sorted({cells for points in curves.values() for cells, _, _ in points})
    for label, points in curves.items():
        color, mark = styles[label]
        ax.plot([x for x, _, _ in points], [y for _, y, _ in points], mark + "-", color=color, linewidth=1.4, markersize=6,
                markeredgecolor="white", markeredgewidth=0.7)
        x, y, order = points[-1]
        if order is not None:
            ax.annotate(f"order {order:.2f}", (x, y), xytext=(6, 0), textcoords="offset points", fontsize=8, va="center", color=color)
    ax.set_xscale("log")
    ax.set_yscale("log")
    ax.set_xlim(sizes[0] / 1.2, sizes[-1] * 1.9)
    ax.set_xticks(sizes, [f"{size:g}" for size in sizes])
    ax.xaxis.set_minor_locator(NullLocator())
    ax.yaxis.set_minor_formatter(NullFormatter())
    ax.grid(axis="both")
    ax.set_title(case, loc="left", fontweight="bold", color=INK)
    ax.set_xlabel("cells a side")


def draw_charts(rows, folder):
    """Draws the figure; returns the names of the files."""
    folder.mkdir(parents=True, exist_ok=True)
    curves = read_curves(rows)
    if not curves:
        return []
    labels = list(dict.fromkeys(label for case in curves.values() for label in case))
    styles = {label: (COLORS[i % len(COLORS)], MARKS[i % len(MARKS)]) for i, label in enumerate(labels)}
    with plt.rc_context(STYLE):
        fig, grid = plt.subplots(1, len(curves), figsize=(max(4.6, 3.3 * len(curves)), 3.9), squeeze=False)
        for ax, (case, own) in zip(grid.flat, curves.items()):
            draw_case(ax, case, own, styles)
        grid[0][0].set_ylabel("relative L2 error")
        handles = [plt.Line2D([], [], color=styles[label][0], marker=styles[label][1], markeredgecolor="white", linewidth=1.4, label=label)
                   for label in labels]
        fig.legend(handles=handles, loc="lower left", ncol=len(handles), fontsize=8, bbox_to_anchor=(0.02, 0.0))
        fig.tight_layout(rect=(0, 0.08, 1, 1))
        return save(fig, folder, "verification")
