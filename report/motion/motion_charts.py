"""Charts of a contest of motions: a table of errors, and the histories of probe and tool against the reference's."""

import math

import matplotlib.pyplot as plt
from matplotlib.colors import LinearSegmentedColormap

from motion.motion import COARSE, MEASURES, history_beside, history_of, value_text
from shared.chart_style import BAND, BETTER, FAINT, INK, STYLE, file_name, save, set_title

HEAT = LinearSegmentedColormap.from_list("errors", ["#f4f9f4", "#fbe9c6", "#e98a5b"])
LEAST, MOST = 1e-3, 1.0  # shares between which colours change; a degree counts as 1/57.3
COLUMNS = 3


def heat_of(measure, value):
    """0 to 1, by the logarithm of the error."""
    share = abs(value) / (1.0 if measure.scale == 100 else 57.3)
    return min(1.0, max(0.0, math.log(max(share, 1e-300) / LEAST) / math.log(MOST / LEAST)))


def draw_errors(section, folder):
    """One table, coloured; the reference's own error is its first row."""
    measures = section.has_measure
    lines = [("reference's own error", section.own, {}, "")]
    lines += [(row.label, row.values, row.marks, "" if row.solve_s is None else f"{row.solve_s:.2g} s") for row in section.rows]
    left = 0.35 + 0.075 * max(len(label) for label, *_ in lines)  # inches
    fig, axes = plt.subplots(figsize=(left + 1.0 * (len(measures) + 1), 0.9 + 0.27 * len(lines)))
    for y, (label, values, marks, time) in enumerate(lines):
        axes.text(-0.1, y + 0.5, label, ha="right", va="center", color=FAINT if y == 0 else INK)
        axes.text(len(measures) + 0.9, y + 0.5, time, ha="right", va="center")
        for x, measure in enumerate(measures):
            value = values.get(measure.name)
            if value is None:
                continue
            if y > 0:
                axes.add_patch(plt.Rectangle((x, y), 1, 1, facecolor=HEAT(heat_of(measure, value)), edgecolor="white"))
            text = value_text(measure, value)
            text = (text.lstrip("+") if y == 0 else text) + (COARSE if COARSE in marks.get(measure.name, "") else "")
            axes.text(x + 0.92, y + 0.5, text, ha="right", va="center", color=FAINT if y == 0 else INK)
    for x, title in enumerate([*(measure.title for measure in measures), "solve"]):
        axes.text(x + 0.92, -0.25, title, ha="right", va="bottom", color=FAINT, fontsize=8)
    axes.set(xlim=(0, len(measures) + 1), ylim=(len(lines), -0.6))
    axes.axis("off")
    set_title(fig, section.title, x=0.02, fontsize=10)
    fig.text(0.02, 0.01, f"{COARSE}: less than five times the reference's own error. solve: time of all steps", color=FAINT, fontsize=8, va="bottom")
    fig.subplots_adjust(left=left / fig.get_size_inches()[0], right=0.99, top=1 - 0.42 / fig.get_size_inches()[1],
                        bottom=0.25 / fig.get_size_inches()[1])
    return save(fig, folder, file_name("motion_errors", section.file_part))


def widest(history, prefix, suffix):
    """The column of these with the largest range, or None."""
    names = [name for name in history if name.startswith(prefix) and name.endswith(suffix)]
    spread = {name: max(history[name]) - min(history[name]) for name in names}
    best = max(spread, key=spread.get, default=None)
    return best if best is not None and spread[best] > 0 else None


def draw_panels(section, truth, histories, column, scale, label, name, folder):
    """A small panel a label: the reference behind, the answer before it."""
    rows = math.ceil(len(histories) / COLUMNS)
    fig, grid = plt.subplots(rows, COLUMNS, figsize=(9.6, 0.7 + 1.45 * rows), sharex=True, sharey=True, squeeze=False)
    window = (section.reference.get("scene") or {}).get("window_s")
    low, high = min(truth[column]) * scale, max(truth[column]) * scale
    for axes in grid.flat[len(histories):]:
        axes.axis("off")
    for axes, (row, history) in zip(grid.flat, histories):
        if isinstance(window, list):
            axes.axvspan(*window, color=BAND, alpha=0.18, lw=0)
        axes.plot(truth["time_s"], [scale * value for value in truth[column]], color="#b5b5b5", lw=2.6, label="reference")
        axes.plot(history["time_s"], [scale * value for value in history[column]], color=BETTER, lw=0.9, label="answer")
        axes.set_ylim(low - 0.25 * (high - low), high + 0.25 * (high - low))
        axes.set_title(row.label, loc="left", fontsize=8)
        axes.grid(True)
    for column_of, axes in enumerate(grid.T):
        lowest = axes[(len(histories) - 1 - column_of) // COLUMNS]
        lowest.set_xlabel("time, s")
        lowest.tick_params(labelbottom=True)
    for axes in grid[:, 0]:
        axes.set_ylabel(label)
    fig.legend(*grid[0][0].get_legend_handles_labels(), fontsize=8, loc="upper right", ncols=2, handlelength=1.4)
    set_title(fig, f"{section.title}: {column}", fontsize=10)
    fig.tight_layout(rect=(0, 0, 1, 0.985))
    return save(fig, folder, file_name(name, section.file_part))


def draw_histories(run, section, folder):
    path = history_of(run, section.reference)
    histories = [(row, history_beside(run, row.history)) for row in section.rows if row.history]
    if path is None or not histories:
        return []
    truth = history_beside(run, path)
    drawn = []
    for prefix, suffix, scale, label, name in (("probe_1_", "_m", 1e3, "probe, mm", "motion_probe"),
                                               ("tool_", "_n", 1.0, "force, N", "motion_force")):
        column = widest(truth, prefix, suffix)
        with_it = [(row, history) for row, history in histories if column in history]
        if column is not None and with_it:
            drawn += draw_panels(section, truth, with_it, column, scale, label, name, folder)
    return drawn


def draw_charts(run, sections, folder):
    """Draws what the plan asks for (all without a list); returns the names of the files."""
    wanted = run.plan_data.get("charts") or ["motion_errors", "motion_histories"]
    folder.mkdir(parents=True, exist_ok=True)
    drawn = []
    with plt.rc_context(STYLE):
        for section in sections:
            if not any(row.values[measure.name] is not None for row in section.rows for measure in MEASURES):
                continue
            if "motion_errors" in wanted:
                drawn += draw_errors(section, folder)
            if "motion_histories" in wanted:
                drawn += draw_histories(run, section, folder)
    return drawn
