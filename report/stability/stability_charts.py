"""Charts of a contest of extremes: stability maps, the step that large deformation leaves, predicted and measured steps of all
cases, and how each integrator ended everywhere."""

import matplotlib.pyplot as plt
from matplotlib.colors import ListedColormap
from matplotlib.lines import Line2D
from matplotlib.ticker import NullFormatter

from shared.chart_style import FAINT, INK, STYLE, file_name, save, set_title
from stability.stability import AGREEMENT, NO_ANSWER, SHORT, as_number, plain_label, worst

ENDING_COLORS = {"steady": "#0072B2", "oscillating": "#56B4E9", "inverted": "#CC79A7", "energy_growing": "#E69F00", "growing_slowly": "#F0E442",
                 "diverged": "#D55E00", "non_finite": "#222222", "too_slow": "#999999", NO_ANSWER: "#ffffff"}
ENDING_MARKS = {"steady": "o", "oscillating": "o", "inverted": "s", "growing_slowly": "v", "energy_growing": "^", "diverged": "X", "non_finite": "P",
                "too_slow": "d"}
COLORS = ["#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#222222", "#8B6D00"]
MARKS = ["o", "s", "^", "D", "v", "P", "X", "*"]


def styles_of(cases):
    labels = list(dict.fromkeys(case.label for case in cases))
    return {label: (COLORS[i % len(COLORS)], MARKS[i % len(MARKS)]) for i, label in enumerate(labels)}


def sweeps(case, *names):
    return all(as_number(case.sweep.get(name)) is not None for name in names)


# --- Stability maps -------------------------------------------------------------------------------------------------------


def read_maps(cases):
    """By mesh, law of damping and integrator: runs (damping ratio, step, ending) and steps by damping ratio."""
    maps = {}
    for case in cases:
        if not sweeps(case, "damping_ratio") or set(case.sweep) - {"damping", "damping_ratio", "step_factor"}:
            continue
        key = (case.mesh, str(case.options.get("damping")))
        own = maps.setdefault(key, {}).setdefault(case.label, {"runs": [], "steps": {}})
        ratio = as_number(case.sweep["damping_ratio"])
        if not case.measures and sweeps(case, "step_factor"):
            own["runs"] += [(ratio, entry["step_s"], entry["outcome"]) for entry in case.runs if entry.get("step_s")]
        own["steps"].setdefault(ratio, {}).update(
            {name: case.number(name) for name in ("predicted_step_s", "row_sum_step_s", "measured_step_s") if case.number(name)})
    return {key: {label: own for label, own in labels.items() if own["runs"]} for key, labels in maps.items()
            if any(own["runs"] for own in labels.values())}


def draw_map(ax, label, own):
    for ending, mark in ENDING_MARKS.items():
        points = [(x, y) for x, y, found in own["runs"] if found == ending]
        ax.scatter([x for x, _ in points], [y for _, y in points], marker=mark, s=34, color=ENDING_COLORS[ending], linewidths=0)
    seen = [x for x, _, _ in own["runs"]]
    ratios = sorted(ratio for ratio in own["steps"] if min(seen) <= ratio <= max(seen))
    for name, style in (("predicted_step_s", "-"), ("row_sum_step_s", ":")):
        line = [(ratio, own["steps"][ratio][name]) for ratio in ratios if name in own["steps"][ratio]]
        ax.plot([x for x, _ in line], [y for _, y in line], style, color=INK, linewidth=1.3)
    line = [(ratio, own["steps"][ratio]["measured_step_s"]) for ratio in ratios if "measured_step_s" in own["steps"][ratio]]
    ax.plot([x for x, _ in line], [y for _, y in line], "o", color="none", markeredgecolor=INK, markersize=8, markeredgewidth=1.2)
    ax.set_xscale("log")
    ax.set_yscale("log")
    ax.grid(axis="both")
    ax.set_title(plain_label(label), loc="left", fontweight="bold", color=INK)
    ax.set_xlabel("damping ratio")


def draw_maps(cases, folder):
    drawn = []
    for (mesh, law), labels in read_maps(cases).items():
        fig, grid = plt.subplots(1, len(labels), figsize=(max(5.0, 3.4 * len(labels)), 4.3), squeeze=False, sharex=True, sharey=True)
        for ax, (label, own) in zip(grid.flat, labels.items()):
            draw_map(ax, label, own)
        grid[0][0].set_ylabel("time step, s")
        seen = {ending for own in labels.values() for _, _, ending in own["runs"]}
        handles = [Line2D([], [], marker=ENDING_MARKS[ending], linestyle="none", markersize=6, markeredgewidth=0,
                          color=ENDING_COLORS[ending], label=SHORT[ending]) for ending in ENDING_MARKS if ending in seen]
        handles += [Line2D([], [], color=INK, linewidth=1.3, label="predicted"),
                    Line2D([], [], color=INK, linewidth=1.3, linestyle=":", label="row sums"),
                    Line2D([], [], marker="o", linestyle="none", color="none", markeredgecolor=INK, markersize=8, label="measured")]
        fig.legend(handles=handles, loc="lower center", ncol=len(handles), fontsize=8, bbox_to_anchor=(0.5, 0.0),
                   columnspacing=1.4, handletextpad=0.5)
        set_title(fig, f"{mesh}, damping: {law}", x=0.02, fontsize=9, fontweight="normal", color=FAINT)
        fig.tight_layout(rect=(0, 0.07, 1, 0.98))
        drawn += save(fig, folder, file_name("stability_map", mesh, law))
    return drawn


# --- Large deformation ----------------------------------------------------------------------------------------------------


def read_shrinkage(cases):
    """By mesh and start, by integrator: (length over rest, measured, predicted at the start), over what is predicted at rest."""
    panels = {}
    for case in cases:
        rest, measured = case.number("predicted_step_s"), case.number("measured_step_s")
        if not case.is_large or not sweeps(case, "strain") or as_number(case.sweep["strain"]) <= -1 or not rest or measured is None:
            continue
        start = case.number("predicted_at_start_s")
        point = (1 + as_number(case.sweep["strain"]), measured / rest, start / rest if start else None)
        panels.setdefault((case.mesh, str(case.options.get("start"))), {}).setdefault(case.label, []).append(point)
    return panels


def draw_shrinkage(cases, folder):
    panels = read_shrinkage(cases)
    if not panels:
        return []
    styles = styles_of([case for case in cases if case.is_large])
    fig, grid = plt.subplots(1, len(panels), figsize=(max(5.4, 4.4 * len(panels)), 4.1), squeeze=False, sharey=True)
    for ax, ((mesh, start), labels) in zip(grid.flat, panels.items()):
        for label, points in labels.items():
            color, mark = styles[label]
            points = sorted(points)
            ax.plot([x for x, _, _ in points], [y for _, y, _ in points], mark + "-", color=color, linewidth=1.3, markersize=5.5,
                    markeredgecolor="white", markeredgewidth=0.6)
            at_start = [(x, y) for x, _, y in points if y is not None]
            ax.plot([x for x, _ in at_start], [y for _, y in at_start], "--", color=color, linewidth=0.9, alpha=0.7)
        ax.axhline(1.0, color=INK, linewidth=0.8)
        ax.set_xscale("log")
        ticks = sorted({x for points in labels.values() for x, _, _ in points})
        apart = [tick for place, tick in enumerate(ticks) if place == 0 or tick > 1.25 * ticks[place - 1]]
        ax.set_xticks(ticks, [f"{tick:.3g}" if tick in apart else "" for tick in ticks], fontsize=8)
        ax.xaxis.set_minor_formatter(NullFormatter())
        ax.minorticks_off()
        ax.grid(axis="y")
        ax.set_title(f"{mesh}, released from a {start}", loc="left", fontweight="bold", color=INK)
        ax.set_xlabel("length over that at rest")
    grid[0][0].set_ylim(bottom=0)
    grid[0][0].set_ylabel("longest stable step over that predicted at rest")
    handles = [Line2D([], [], color=styles[label][0], marker=styles[label][1], markeredgecolor="white", linewidth=1.3,
                      label=plain_label(label)) for label in styles]
    handles.append(Line2D([], [], color=FAINT, linestyle="--", linewidth=0.9, label="predicted at the start"))
    fig.legend(handles=handles, loc="lower center", ncol=min(5, len(handles)), fontsize=8, bbox_to_anchor=(0.5, 0.0))
    fig.tight_layout(rect=(0, 0.08, 1, 1))
    return save(fig, folder, "large_deformation")


# --- Predicted and measured -----------------------------------------------------------------------------------------------


def draw_agreement(cases, folder):
    points = [(case.number("measured_over_predicted"), case) for case in cases
              if case.is_accepted and case.measures and not case.is_large and case.number("measured_over_predicted") is not None]
    if not points:
        return []
    extremes = list(dict.fromkeys(case.extreme for _, case in points))
    styles = styles_of([case for _, case in points])
    fig, ax = plt.subplots(figsize=(7.2, 1.5 + 0.27 * len(extremes)))
    ax.axvspan(1 - AGREEMENT, 1 + AGREEMENT, color="#eeeeee", zorder=0)
    ax.axvline(1.0, color=FAINT, linewidth=0.8)
    labels = list(styles)
    for value, case in points:
        color, mark = styles[case.label]
        shift = (labels.index(case.label) - (len(labels) - 1) / 2) * 0.7 / max(len(labels), 1)
        ax.plot(value, extremes.index(case.extreme) + shift, mark, color=color, markersize=4, markeredgewidth=0)
    ax.set_yticks(range(len(extremes)), [extreme.replace("_", " ") for extreme in extremes])
    ax.set_ylim(len(extremes) - 0.4, -0.6)
    low, high = min(value for value, _ in points), max(value for value, _ in points)
    ax.set_xlim(min(1 - 1.5 * AGREEMENT, low - 0.005), max(1 + 1.5 * AGREEMENT, high + 0.005))
    ax.grid(axis="x")
    ax.set_xlabel("longest stable step, measured over predicted (grey: within 2%)")
    handles = [Line2D([], [], color=styles[label][0], marker=styles[label][1], linestyle="none", markersize=5, markeredgewidth=0,
                      label=plain_label(label)) for label in labels]
    fig.legend(handles=handles, loc="lower center", ncol=4, fontsize=8, bbox_to_anchor=(0.5, 0.0))
    fig.tight_layout(rect=(0, 0.55 / fig.get_figheight(), 1, 1))
    return save(fig, folder, "predicted_and_measured")


# --- Endings --------------------------------------------------------------------------------------------------------------


def ending_of(case):
    """Of a measurement at twice the measured step, where every integrator with a bound fails; of a run its own."""
    if not case.runs:
        return case.ending
    return str((case.runs[2] if case.measures and len(case.runs) > 2 else case.runs[-1]).get("outcome"))


def row_name(extreme, setting):
    """"factors: stiffness factor 1, mass ratio 1e-09": a number alone says nothing."""
    return f"{extreme}: {setting}".replace("_", " ") if setting else extreme.replace("_", " ")


def draw_endings(cases, folder):
    """A table in colours: a row an extreme and setting, a column an integrator; over meshes the worst."""
    own = [case for case in cases if not sweeps(case, "step_factor", "damping_ratio")]
    labels = list(dict.fromkeys(case.label for case in own))
    cells = {}
    for case in own:
        cells.setdefault((case.extreme, case.setting), {}).setdefault(case.label, []).append(ending_of(case))
    if not cells:
        return []
    names = [*reversed(list(ENDING_MARKS)), NO_ANSWER]
    rows = list(cells)
    grid = [[names.index(worst(cells[row][label])) if label in cells[row] else -1 for label in labels] for row in rows]
    longest = max(len(row_name(extreme, setting)) for extreme, setting in rows)
    fig, ax = plt.subplots(figsize=(max(2.9, 0.4 + 0.05 * longest) + 0.62 * len(labels), 1.7 + 0.165 * len(rows)))
    palette = ListedColormap(["#f4f4f4", *(ENDING_COLORS[name] for name in names)])
    ax.pcolormesh([[value + 1 for value in line] for line in grid], cmap=palette, vmin=-0.5, vmax=len(names) + 0.5,
                  edgecolors="white", linewidth=0.8)
    ax.set_xticks([i + 0.5 for i in range(len(labels))], [plain_label(label).replace("_", "\n") for label in labels], fontsize=7)
    ax.xaxis.tick_top()
    ax.set_yticks([i + 0.5 for i in range(len(rows))],
                  [row_name(extreme, setting) for extreme, setting in rows], fontsize=6.5)
    ax.set_ylim(len(rows), 0)
    ax.tick_params(length=0)
    for place, (extreme, _) in enumerate(rows):
        if place and extreme != rows[place - 1][0]:
            ax.axhline(place, color=INK, linewidth=0.6)
    for side in ax.spines.values():
        side.set_visible(False)
    seen = {names[value] for line in grid for value in line if value >= 0}
    handles = [Line2D([], [], marker="s", linestyle="none", markersize=7, markeredgewidth=0, color=ENDING_COLORS[name], label=SHORT[name])
               for name in ENDING_MARKS if name in seen]
    fig.legend(handles=handles, loc="lower center", ncol=max(4, int(fig.get_figwidth() / 1.3)), fontsize=7.5, bbox_to_anchor=(0.5, 0.0), columnspacing=1.4)
    height = fig.get_figheight()
    fig.text(0.01, 1 - 0.1 / height, "How bodies end: runs as set; measured ones at twice their longest stable step (implicit: 100 times a\n"
             "reference). Of several meshes the worst.", fontsize=7.5, color=FAINT, va="top")
    fig.tight_layout(rect=(0, 0.5 / height, 1, 1 - 0.4 / height))
    return save(fig, folder, "endings")


def draw_charts(cases, folder):
    """Draws all; returns the names of the files."""
    folder.mkdir(parents=True, exist_ok=True)
    with plt.rc_context(STYLE):
        return [*draw_maps(cases, folder), *draw_shrinkage(cases, folder), *draw_agreement(cases, folder), *draw_endings(cases, folder)]
