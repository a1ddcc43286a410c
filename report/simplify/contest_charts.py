"""Charts of a contest: quality against time, and against the distance that the skin has moved."""

import math

import matplotlib.pyplot as plt
from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter

from shared.chart_style import FAINT, INK, draw_legend, file_name, lay_out, save, set_time_axis, set_title, short_name
from shared.equal_count import tolerance_of
from shared.records import figure
from simplify.contest import NONE, RANKED, short_sweep
from simplify.point_names import name_point, place_names

MEASURES = [("percent_above_0_5", "tetrahedra of quality above 0.5, %"), ("mean_quality", "mean quality"),
            ("p1_dihedral_deg", "1st percentile of angles, degrees")]


def places_along(section, family, along, measure):
    """(label, figure of `along`, value, is ranked) of each label of a family that has both."""
    found = []
    for label in family.labels:
        standing = section.find(label)
        if standing is None or standing.state == NONE:
            continue
        x, value = standing.values.get(along), standing.values.get(measure)
        if x is not None and value is not None:
            found.append((label, x, value, standing.state == RANKED))
    return found


def places(section, family, measure):
    """As places_along, with milliseconds; on an axis of decades a time of 0 has no place."""
    return [(label, 1000 * seconds, value, counts) for label, seconds, value, counts in places_along(section, family, "kernel_s", measure) if seconds]


def draw_family(ax, family, found):
    """A family's points; a curve joins them if one option tells them apart, dotted if some do not count."""
    size, width = (7, 2.0) if family.is_own else (7, 1.4)
    size += 1.5 if family.mark in "PX" else 0
    if family.option and found:
        ax.plot(*zip(*((x, y) for _, x, y, _ in found)), color=family.color, linewidth=width, zorder=2 + family.is_own,
                linestyle="-" if all(counts for *_, counts in found) else ":")
    for label, x, y, counts in found:
        ax.plot(x, y, family.mark, color=family.color, markersize=size, zorder=4 + family.is_own, clip_on=False,
                markerfacecolor=family.color if counts else "white", markeredgewidth=1.2,
                markeredgecolor="white" if counts else family.color)
    if len(family.labels) > 1:
        name_points(ax, family, found)


def name_points(ax, family, found):
    """Along a curve numbers above and below in turn; otherwise names, for which place_names finds places."""
    for place, (label, x, y, _) in enumerate(found):
        beside = (0, -6, "center", "top") if place % 2 == 1 else (0, 6, "center", "bottom")
        name_point(ax, short_name(family.names[label]), x, y, family.color, beside if family.option else None)


def time_range(sections, families):
    times = [x for section in sections for family in families for _, x, _, _ in places(section, family, MEASURES[0][0])]
    return min(times), max(times)


def draw_panel(ax, section, families, measure, input_value):
    for family in families:
        draw_family(ax, family, places(section, family, measure))
    if input_value is not None:
        ax.axhline(input_value, color=INK, linewidth=1.0, linestyle=(0, (3, 2)), zorder=1)
    ax.grid(axis="both")
    ax.margins(0.08, 0.12)


def family_name(family):
    if len(family.labels) == 1:
        return family.method
    names = ", ".join(family.names[label] for label in family.labels)
    return f"{family.method} ({family.option} {names})" if family.option else f"{family.method} ({names})"


def legend_handles(run, families, sections):
    handles = []
    for family in families:
        handles.append(plt.Line2D([], [], color=family.color, marker=family.mark, markersize=7, markeredgecolor="white",
                                  linewidth=(2.0 if family.is_own else 1.4) if family.option else 0, label=family_name(family)))
    handles.append(plt.Line2D([], [], color=INK, linewidth=1.0, linestyle=(0, (3, 2)), label="input"))
    if any(standing.state not in (RANKED, NONE) for section in sections for standing in section.standings):
        handles.append(plt.Line2D([], [], color=FAINT, marker="o", markerfacecolor="white", linewidth=0, markersize=7,
                                  label=f"hollow: rejected, or count not within {100 * tolerance_of(run):g}%"))
    return handles


def draw_quality_time(run, sections, families, folder):
    """One figure a mesh: a row for each measure, a column for each point of the sweep."""
    drawn = []
    for mesh in run.meshes():
        own = [section for section in sections if section.mesh == mesh and any(
            places(section, family, MEASURES[0][0]) for family in families)]
        if not own:
            continue
        height = 2.5 * len(MEASURES) + 1.6
        fig, grid = plt.subplots(len(MEASURES), len(own), figsize=(max(5.0, 3.4 * len(own) + 0.5), height), sharex=True,
                                 squeeze=False)
        shown = [family for family in families if any(places(section, family, MEASURES[0][0]) for section in own)]
        for row, (measure, title) in enumerate(MEASURES):
            for column, section in enumerate(own):
                ax = grid[row][column]
                draw_panel(ax, section, shown, measure, figure(run.inputs.get(mesh, {}), "judge", measure))
                set_time_axis(ax, *time_range(own, shown))
                if row == 0:
                    ax.set_title(short_sweep(section.sweep) or mesh, loc="left", fontweight="bold")
                if row == len(MEASURES) - 1:
                    ax.set_xlabel("time of the method (kernel, median)")
                if column == 0:
                    ax.set_ylabel(title)
        foot = draw_legend(fig, legend_handles(run, shown, own))
        tets = figure(run.inputs.get(mesh, {}), "judge", "tets")
        set_title(fig, f"{mesh}: quality against time" + ("" if tets is None else f", {tets:,.0f} tetrahedra at the start"))
        lay_out(fig, foot)
        place_names(fig)
        drawn += save(fig, folder, file_name("quality_time", mesh))
    return drawn


def distance_places(section, family, measure):
    """As places_along, with the distance of the skins, the nearest first."""
    return sorted(places_along(section, family, "surface_distance_upper", measure), key=lambda place: place[1])


def draw_quality_distance(run, sections, families, folder):
    """One figure a mesh: a row for each measure, a column for each point of the sweep; along, how far the skin strays."""
    drawn = []
    for mesh in run.meshes():
        own = [section for section in sections if section.mesh == mesh and any(
            distance_places(section, family, MEASURES[0][0]) for family in families)]
        if not own:
            continue
        fig, grid = plt.subplots(len(MEASURES), len(own), figsize=(max(5.0, 3.4 * len(own) + 0.5), 2.5 * len(MEASURES) + 1.6),
                                 sharex="col", squeeze=False)
        shown = [family for family in families if any(distance_places(section, family, MEASURES[0][0]) for section in own)]
        for row, (measure, title) in enumerate(MEASURES):
            for column, section in enumerate(own):
                ax = grid[row][column]
                for family in shown:
                    draw_family(ax, family, distance_places(section, family, measure))
                most = max((x for family in shown for _, x, _, _ in distance_places(section, family, measure)), default=0.0) or 1.0
                near = most / 50
                ax.set_xscale("symlog", linthresh=near)  # skins that stay are at 0, bounds and strays a decade or two apart
                decades = [10.0**n for n in range(math.ceil(math.log10(1.5 * near)), math.floor(math.log10(5 * most)) + 1)]
                ax.set_xticks([0.0, *decades], minor=False)
                ax.set_xlim(-most / 100, 5 * most)  # with room for names
                ax.xaxis.set_major_formatter(lambda x, _: f"{x:g}")
                value = figure(run.inputs.get(mesh, {}), "judge", measure)
                if value is not None:
                    ax.axhline(value, color=INK, linewidth=1.0, linestyle=(0, (3, 2)), zorder=1)
                ax.grid(axis="both")
                ax.margins(0.08, 0.2)
                if row == 0:
                    ax.set_title(short_sweep(section.sweep) or mesh, loc="left", fontweight="bold")
                if row == len(MEASURES) - 1:
                    ax.set_xlabel("distance of the skins, in the mesh's unit")
                if column == 0:
                    ax.set_ylabel(title)
        foot = draw_legend(fig, legend_handles(run, shown, own))
        set_title(fig, f"{mesh}: quality against how far the skin strays")
        lay_out(fig, foot)
        place_names(fig)
        drawn += save(fig, folder, file_name("quality_distance", mesh))
    return drawn
