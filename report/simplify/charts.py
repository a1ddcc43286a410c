"""Charts of a run, as SVG and PNG. The same records give the same bytes: no dates, fixed ids, one bundled font."""

import matplotlib.pyplot as plt
from matplotlib.patches import Patch
from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter

from shared.chart_style import BAND, BETTER, BOX_FROM, FAINT, INK, OTHERS, QUARTILES, SPREAD, STYLE, THAN, draw_legend, file_name, lay_out, save, set_title
from shared.equal_count import tets_of, tolerance_of
from shared.families import family_of, read_families
from shared.records import BUCKETS, figure, figures_of, median, quantile, shares_of
from shared.tables import timing_of
from simplify import contest, contest_charts, cut_away, scaling, scaling_charts
from simplify.verdict import values_of

MEASURE_NAMES = {
    "percent_above_0_5": "tetrahedra of quality above 0.5, %",
    "percent_above_0_6": "tetrahedra of quality above 0.6, %",
    "kernel_s": "time of the method, s",
    "min_dihedral_deg": "least dihedral angle, degrees",
    "mean_quality": "mean quality",
}


def draw_outline(ax, values):
    """The input's histogram as a dashed outline."""
    edges = [bucket / BUCKETS for bucket in range(BUCKETS + 1)]
    ax.stairs(values, edges, color=INK, linewidth=1.2, linestyle=(0, (3, 2)), zorder=4)


def draw_bars(ax, values, color):
    centres = [(bucket + 0.5) / BUCKETS for bucket in range(BUCKETS)]
    ax.bar(centres, values, width=0.092, color=color, zorder=2)


def draw_band(ax, group):
    """Least to greatest share of each bucket over seeds, and its quartiles."""
    columns = list(zip(*group.shares()))
    for bucket, column in enumerate(columns):
        left, right = bucket / BUCKETS, (bucket + 1) / BUCKETS
        ax.fill_between([left + 0.004, right - 0.004], min(column), max(column), color=BAND, linewidth=0, zorder=3)
        if len(column) >= BOX_FROM:
            low, high = quantile(column, 0.25), quantile(column, 0.75)
            ax.fill_between([left + 0.004, right - 0.004], low, high, color=QUARTILES, linewidth=0, zorder=3)
    return bool(columns)


def histogram_title(group, name=""):
    above = [median(group.figures("judge", f"percent_above_0_{digit}")) for digit in (5, 6)]
    text = ", ".join(f"{value:.1f}% above 0.{digit}" for value, digit in zip(above, (5, 6)) if value is not None)
    tets = "" if tets_of(group) is None else f", {tets_of(group):,.0f} tets"
    return f"{name or group.name}{f', {group.count_note}' if group.count_note else tets}\n{text}"


def finish_histogram_axes(ax):
    ax.set_xlim(0, 1)
    ax.set_xticks([bucket / BUCKETS for bucket in range(0, BUCKETS + 1)])
    ax.tick_params(axis="x", labelsize=8)
    ax.grid(axis="y")
    ax.axvline(0.5, color=FAINT, linewidth=0.8, linestyle=":", zorder=1)
    ax.set_xlabel("quality")


def subtitle(run, mesh):
    tets = figure(run.inputs.get(mesh, {}), "judge", "tets")
    return mesh if tets is None else f"{mesh}, {tets:,.0f} tetrahedra at the start"


def draw_pair(run, claim, mesh, sweep, folder):
    """The thesis's figures 4.2 and 4.3 side by side: both sides of the claim, and the band of the random orders."""
    pick = lambda label: next((g for g in run.find(mesh, label) if g.sweep == sweep and g.shares()), None)
    pair = [(pick(claim.better), BETTER), (pick(claim.than), THAN)]
    if not all(group for group, _ in pair):
        return []
    fig, axes = plt.subplots(1, 2, figsize=(9.6, 4.3), sharey=True)
    outline = shares_of(run.inputs.get(mesh))
    spread = pick(claim.spread) if claim.spread else None
    handles = []
    for ax, (group, color) in zip(axes, pair):
        draw_bars(ax, shares_of(group.cases()[0]), color)
        handles.append(Patch(color=color, label=group.label))
        if outline:
            draw_outline(ax, outline)
        ax.set_title(histogram_title(group), loc="left")
        finish_histogram_axes(ax)
    if spread and draw_band(axes[1], spread):
        seeds = len(spread.cases())
        handles.append(Patch(color=BAND, label=f"{spread.label}: least to greatest of {seeds}"))
        if seeds >= BOX_FROM:
            handles.append(Patch(color=QUARTILES, label="its quartiles"))
    if outline:
        handles.append(plt.Line2D([], [], color=INK, linewidth=1.2, linestyle=(0, (3, 2)), label="input"))
    axes[0].set_ylabel("tetrahedra, %")
    axes[0].set_ylim(0, None)
    set_title(fig, subtitle(run, mesh) + (f" ({sweep})" if sweep else ""))
    lay_out(fig, draw_legend(fig, handles))
    return save(fig, folder, file_name("histogram", mesh, sweep))


def draw_all_histograms(run, claim, mesh, groups, folder, sweep=""):
    """One small histogram for each of these labels of a mesh; seeds are pooled into a band."""
    groups = [group for group in groups if group.shares()]
    if not groups:
        return []
    columns = min(4, len(groups))
    rows = -(-len(groups) // columns)
    height = 2.45 * rows + 0.75
    fig, grid = plt.subplots(rows, columns, figsize=(max(5.0, 2.9 * columns), height), sharey=True, squeeze=False)
    outline = shares_of(run.inputs.get(mesh))
    families = read_families(run) if sweep else []
    for i, ax in enumerate(grid.flat):
        if i >= len(groups):
            ax.set_visible(False)
            continue
        group = groups[i]
        several = group.shares()
        draw_bars(ax, [median(column) for column in zip(*several)], color_of(group, claim, families))
        if len(several) > 1:
            draw_band(ax, group)
        if outline:
            draw_outline(ax, outline)
        ax.set_title(histogram_title(group, group.label if sweep else ""), loc="left", fontsize=8)
        finish_histogram_axes(ax)
        ax.set_xticks([0, 0.2, 0.4, 0.6, 0.8, 1])
        ax.set_xlabel("quality" if i + columns >= len(groups) else "")
        ax.set_ylabel("tetrahedra, %" if i % columns == 0 else "")
    grid[0][0].set_ylim(0, None)
    place = f" ({contest.short_sweep(sweep)})" if sweep else ""
    set_title(fig, subtitle(run, mesh) + place + "; dashed: input")
    lay_out(fig)
    return save(fig, folder, file_name("histograms_all", mesh, sweep))


def color_of(group, claim, families=()):
    family = family_of(families, group.label)
    if family:
        return family.color
    if claim and group.label in (claim.better, claim.than, claim.spread):
        return {claim.better: BETTER, claim.than: THAN}.get(group.label, SPREAD)
    return OTHERS if claim else BETTER


def draw_spread(ax, y, values, color):
    """The range of several values as a line; the quartiles as a bar where there are enough for one, else each value as a tick."""
    if len(values) < 2:
        return
    ax.plot([min(values), max(values)], [y, y], color=color, linewidth=1.3, zorder=3, solid_capstyle="butt")
    if len(values) >= BOX_FROM:
        ax.plot([quantile(values, 0.25), quantile(values, 0.75)], [y, y], color=color, linewidth=6, alpha=0.55, zorder=3,
                solid_capstyle="butt")
    else:
        ax.plot(values, [y] * len(values), "|", color=color, markersize=10, markeredgewidth=1.3, zorder=3)


def draw_values(ax, y, values, color, note=""):
    """A dot at the median; with several seeds also what `draw_spread` shows.

    A label that is not to be compared has a hollow dot, with its note on the side that has more room.
    """
    draw_spread(ax, y, values, color)
    if not note:
        ax.plot(median(values), y, "o", color=color, markersize=5.5, markeredgecolor="white", markeredgewidth=0.7, zorder=4)
        return
    ax.plot(median(values), y, "o", markerfacecolor="white", markersize=5.5, markeredgecolor=color, markeredgewidth=1.2, zorder=4)
    low, high = ax.get_xlim()
    to_left = median(values) > (low + high) / 2
    ax.annotate(note, (min(values) if to_left else max(values), y), xytext=(-6 if to_left else 6, 0), textcoords="offset points",
                ha="right" if to_left else "left", va="center", fontsize=7, color=FAINT, zorder=5,
                bbox={"facecolor": "white", "edgecolor": "none", "pad": 1.0})


def draw_overview(run, claim, folder):
    """The claim's measure (or the share above 0.5) of each label on each mesh, with the published two values."""
    measure = claim.measure if claim else "percent_above_0_5"
    meshes = [mesh for mesh in run.meshes() if any(values_of(group, measure) for group in run.of_mesh(mesh))]
    if not meshes:
        return []
    names = run.group_names()
    columns = min(3, len(meshes))
    rows = -(-len(meshes) // columns)
    width = 0.075 * max(len(name) for name in names) + 0.35
    height = rows * (0.27 * len(names) + 0.75) + 0.95
    fig, grid = plt.subplots(rows, columns, figsize=(width + 2.9 * columns, height), sharex=True, sharey=True, squeeze=False)
    low, high = overview_range(run, claim, meshes, measure)
    grid[0][0].set_xlim(low, high)
    for i, ax in enumerate(grid.flat):
        if i >= len(meshes):
            ax.set_visible(False)
            continue
        draw_overview_panel(ax, run, claim, meshes[i], measure, names)
        if i + columns >= len(meshes):
            ax.set_xlabel(MEASURE_NAMES.get(measure, measure))
            ax.tick_params(labelbottom=True)
    handles = [plt.Line2D([], [], color=INK, linewidth=1.2, linestyle=(0, (3, 2)), label="input")]
    handles.append(plt.Line2D([], [], color=FAINT, marker="o", linewidth=1.3, markersize=5, label="median, range over seeds; bar: quartiles"))
    if any(group.count_note for group in run.groups):
        handles.append(plt.Line2D([], [], color=FAINT, marker="o", markerfacecolor="white", linewidth=0, markersize=5,
                                  label=f"hollow: count not within {100 * tolerance_of(run):g}%, not to be compared"))
    if claim and claim.published_difference is not None:
        for value, color, side in ((claim.published_better, BETTER, claim.better), (claim.published_than, THAN, claim.than)):
            handles.append(plt.Line2D([], [], color=color, linewidth=1.2, label=f"published, {side}: {value:.2f}"))
    foot = draw_legend(fig, handles)
    if run.plan_data.get("question"):
        set_title(fig, str(run.plan_data["question"]))
    lay_out(fig, foot)
    return save(fig, folder, "overview")


def overview_range(run, claim, meshes, measure):
    """The least and the greatest value that the overview shows, with a margin."""
    shown = [value for group in run.groups if group.mesh in meshes for value in values_of(group, measure)]
    shown += [figure(run.inputs[mesh], "judge", measure) for mesh in meshes if mesh in run.inputs]
    if claim and claim.published_difference is not None:
        shown += [claim.published_better, claim.published_than]
    shown = [value for value in shown if value is not None]
    margin = 0.05 * (max(shown) - min(shown)) or 1.0
    return min(shown) - margin, max(shown) + margin


def draw_overview_panel(ax, run, claim, mesh, measure, names):
    value = figure(run.inputs.get(mesh, {}), "judge", measure)
    if value is not None:
        ax.axvline(value, color=INK, linewidth=1.2, linestyle=(0, (3, 2)), zorder=2)
    if claim and claim.published_difference is not None:
        ax.axvline(claim.published_better, color=BETTER, linewidth=1.2, zorder=1)
        ax.axvline(claim.published_than, color=THAN, linewidth=1.2, zorder=1)
    for group in run.of_mesh(mesh):
        values = values_of(group, measure)
        y = names.index(group.name)
        if values:
            draw_values(ax, y, values, color_of(group, claim), group.count_note)
        else:
            ax.annotate("no accepted answer", (0.02, y), xycoords=("axes fraction", "data"), fontsize=7, color=FAINT,
                        va="center", bbox={"facecolor": "white", "edgecolor": "none", "pad": 1.5}, zorder=5)
    ax.set_yticks(range(len(names)), names)
    ax.set_ylim(len(names) - 0.4, -0.6)
    ax.tick_params(axis="y", length=0)
    ax.grid(axis="both")
    ax.set_title(mesh, loc="left", fontweight="bold")


def draw_timing(run, claim, folder):
    """Time of the method for each label and mesh, on a logarithmic scale, with the tets removed a second."""
    entries = [(group, timing_of(group)) for group in run.groups]
    entries = [(group, timing) for group, timing in entries if timing and timing["kernel_min_s"] > 0]
    if not entries:
        return []
    rows, marks = [], {}
    for group, timing in entries:
        if group.mesh not in marks:
            marks[group.mesh] = len(rows) + 0.9 * len(marks)
        rows.append((len(rows) + 0.9 * len(marks), group, timing))
    width = 0.072 * max(len(group.name) for group, _ in entries) + 6.2
    last = rows[-1][0]
    fig, ax = plt.subplots(figsize=(width, 0.22 * (last + 2) + 0.95))
    for y, group, timing in rows:
        color = color_of(group, claim)
        draw_spread(ax, y, [1000 * value for value in figures_of(group.accepted(), "kernel_s")], color)
        ax.plot(1000 * timing["kernel_median_s"], y, "o", markersize=5.5, zorder=4, markerfacecolor="white" if group.count_note else color,
                markeredgecolor=color if group.count_note else "white", markeredgewidth=1.2 if group.count_note else 0.7)
        if timing["tets_removed_per_s"] is not None:
            ax.annotate(f"{timing['tets_removed_per_s']:,.0f}", (1.02, y), xycoords=("axes fraction", "data"), fontsize=8,
                        va="center", color=INK)
    for mesh, y in marks.items():
        ax.annotate(mesh, (0.004, y), xycoords=("axes fraction", "data"), fontsize=9, fontweight="bold", va="center")
    ax.set_xscale("log")
    ax.xaxis.set_major_locator(LogLocator(subs=(1, 2, 5)))
    ax.xaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
    ax.xaxis.set_minor_formatter(NullFormatter())
    ax.set_yticks([y for y, _, _ in rows], [group.name for _, group, _ in rows], fontsize=8)
    ax.set_ylim(last + 0.8, -0.8)
    ax.tick_params(axis="y", length=0)
    ax.grid(axis="x", which="both")
    hollow = "; hollow: at another count" if any(group.count_note for group, _ in entries) else ""
    ax.set_xlabel(f"time of the method, ms: median and range over repeats and seeds,\nquartiles from {BOX_FROM} on, else each as a tick{hollow}")
    ax.annotate("tets removed\na second", (1.02, 1), xycoords="axes fraction", fontsize=8, va="bottom", color=FAINT)
    fig.tight_layout()
    return save(fig, folder, "timing")


DEFAULT_CHARTS = ["histograms", "overview", "timing"]
MOST_MESHES = 24  # a picture or more each


def draw_mesh_histograms(run, claim, mesh, folder):
    """The pair of the claim, and all labels; a contest at equal count has a figure for each point of its sweep."""
    drawn = []
    if claim:
        for sweep in dict.fromkeys(group.sweep for group in run.find(mesh, claim.better)):
            drawn += draw_pair(run, claim, mesh, sweep, folder)
    if "equal_count" not in run.plan_data:
        return drawn + draw_all_histograms(run, claim, mesh, run.of_mesh(mesh), folder)
    for sweep in dict.fromkeys(group.sweep for group in run.of_mesh(mesh)):
        groups = [group for group in run.of_mesh(mesh) if group.sweep == sweep]
        drawn += draw_all_histograms(run, claim, mesh, groups, folder, sweep)
    return drawn


def draw_charts(whole, claim, folder):
    """Draws the charts that the plan names and the run has figures for; returns the names of the files. A run of very many meshes has charts of
    the first ones, and a note that says so."""
    run = whole.of_first_meshes(MOST_MESHES)
    if run is not whole:
        whole.notes.append(f"charts show the first {MOST_MESHES} of {len(whole.meshes()):,} meshes; tables/ has all")
    folder.mkdir(parents=True, exist_ok=True)
    names = run.plan_data.get("charts") or DEFAULT_CHARTS
    drawn = []
    with plt.rc_context(STYLE):
        if "histograms" in names:
            for mesh in run.meshes():
                drawn += draw_mesh_histograms(run, claim, mesh, folder)
        if "overview" in names:
            drawn += draw_overview(run, claim, folder)
        if "timing" in names:
            drawn += draw_timing(run, claim, folder)
        if "quality_time" in names:
            drawn += contest_charts.draw_quality_time(run, contest.read_sections(run), read_families(run), folder)
        if "quality_distance" in names:
            drawn += contest_charts.draw_quality_distance(run, contest.read_sections(run), read_families(run), folder)
        if "scaling" in names:
            drawn += scaling_charts.draw_scaling(scaling.read_series(run), read_families(run), folder)
        if "cut_away" in names:
            drawn += cut_away.draw_cut_away(run, contest.read_sections(run), folder)
    return drawn
