"""How far a fitted model may be taken: along each axis, the error at every factor that was looked at, the tolerance, and the border.

What came to no error (a motion that diverged, a model that refused) is a cross at the top, with its name.
"""

import matplotlib.pyplot as plt
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter

from shared.chart_style import BETTER, FAINT, INK, STYLE, THAN, draw_legend, lay_out, save

COLUMNS = 3
PANEL = (3.2, 2.7)  # inches
TITLES = {"stiffer": "stiffer", "lighter": "lighter", "larger": "larger loads, large strain", "faster": "faster loads",
          "step": "coarser in step"}


def parts_of(probe):
    """Error at rest, the reference's own and the step's, in percent; None if the probe came to none."""
    if probe["rest_error"] is None:
        return None
    return [100.0 * (probe[key] or 0.0) for key in ("rest_error", "reference_error", "step_error")]


def draw_panel(axes, axis, tolerance):
    points = [(probe["factor"], parts_of(probe)) for probe in axis["probes"]]
    judged = [(factor, parts) for factor, parts in points if parts is not None]
    top = max([1.6 * tolerance] + [1.25 * sum(parts) for _, parts in judged if sum(parts) < 5 * tolerance])
    if judged:
        factors = [factor for factor, _ in judged]
        axes.plot(factors, [sum(parts) for _, parts in judged], color=BETTER, marker="o", markersize=3.5, linewidth=1.2)
        axes.plot(factors, [parts[0] for _, parts in judged], color=FAINT, linewidth=1.0, linestyle=":")
    axes.axhline(tolerance, color=INK, linewidth=0.9)
    for probe in axis["probes"]:
        if probe["rest_error"] is None:
            axes.plot([probe["factor"]], [0.96 * top], color=THAN, marker="x", markersize=5, linestyle="none")
    low, high = 1.0, max(1.5, max(factor for factor, _ in points))
    if axis["fails_at"] is not None:
        axes.axvspan(axis["fails_at"], 1.15 * high, color=THAN, alpha=0.12, linewidth=0)
    axes.set_xscale("log")
    axes.set_xlim(low / 1.08, 1.15 * high)
    axes.set_ylim(0, top)
    axes.xaxis.set_major_locator(LogLocator(subs=(1, 2, 5), numticks=8))
    axes.xaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
    axes.xaxis.set_minor_formatter(NullFormatter())
    axes.set_xlabel(axis["text"])
    axes.set_ylabel("error, %")
    axes.set_title(f"{TITLES.get(axis['name'], axis['name'])}\n{border_text(axis)}", loc="left", fontsize=9)


def border_text(axis):
    if axis["holds_to"] is None:
        return "does not hold as it is"
    if axis["fails_at"] is None:
        return f"holds up to {axis['holds_to']:.3g}, no further looked at"
    why = str(axis["ending"]).replace("not_measured", "no error could be measured")
    return f"holds up to {axis['holds_to']:.3g}; at {axis['fails_at']:.3g}: {why}"


def draw_envelope(envelope, folder):
    """Writes envelope.svg and envelope.png; returns their names."""
    plt.rcParams.update(STYLE)
    axes_found = envelope["axes"]
    columns = min(COLUMNS, len(axes_found))
    rows = -(-len(axes_found) // columns)
    fig, grid = plt.subplots(rows, columns, figsize=(PANEL[0] * columns, PANEL[1] * rows + 0.55), squeeze=False)
    tolerance = 100.0 * envelope["at_most"]
    for place, axes in enumerate(grid.flat):
        if place < len(axes_found):
            draw_panel(axes, axes_found[place], tolerance)
        else:
            axes.set_axis_off()
    handles = [Line2D([], [], color=BETTER, marker="o", markersize=3.5, label="error, the reference's own and the step's on top"),
               Line2D([], [], color=FAINT, linestyle=":", label="error at rest alone"), Line2D([], [], color=INK, label="tolerance"),
               Line2D([], [], color=THAN, marker="x", linestyle="none", label="no error: the motion or the model ended, or the reference"),
               Patch(color=THAN, alpha=0.12, label="beyond the border")]
    lay_out(fig, draw_legend(fig, handles))
    return save(fig, folder, "envelope")
