"""Charts of a contest of the engine: returns to rest, the organ in its phases, margins, tick times and the largest mesh."""

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.cm import ScalarMappable
from matplotlib.collections import PolyCollection
from matplotlib.colors import Normalize

from engine.engine import HOLDS, largest_meshes, returns_of
from engine.motion_file import read_motion
from shared.chart_style import FAINT, INK, STYLE, file_name, lay_out, save, set_size_axis, set_title
from shared.mesh_file import outer_faces, read_mesh
from shared.mesh_view import LIGHT, choose_view, inside
from shared.records import BadRun, figure
from shared.run_file import are_numbers

COLORS = ["#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#5b3a00", "#222222"]
MARKERS = ["o", "s", "v", "^", "D", "P", "*", "X"]
DASHES = {1: "-", 2: "--"}
PATTERNS = ["-", "--", "-.", ":"]
MOST_PANELS_A_ROW = 6


def numbered(items):
    """(item, colour, how often the colours went round before it) of each."""
    return [(item, COLORS[number % len(COLORS)], number // len(COLORS)) for number, item in enumerate(items)]


def with_several_sizes(cases, key_of):
    """The cases of keys that have more than one size of the mesh; all where no key has."""
    sizes = {}
    for case in cases:
        sizes.setdefault(key_of(case), set()).add(case.vertices)
    chosen = [case for case in cases if len(sizes[key_of(case)]) > 1]
    return chosen or cases


def column(motion, name):
    place = motion["columns"].index(name)
    return np.array([row[place] for row in motion["rows"]], dtype=float)


def probe_sizes(motion):
    """Size of the displacement of each probe over time."""
    columns = set(motion["columns"])
    numbers = [name[6:-5] for name in motion["columns"] if name.startswith("probe_") and name.endswith("_ux_m")
               and {f"{name[:-3]}{axis}_m" for axis in "yz"} <= columns]
    return [np.sqrt(sum(column(motion, f"probe_{number}_u{axis}_m") ** 2 for axis in "xyz")) for number in numbers]


def is_only(case, cases):
    """Whether no other label replays its scene on the scene's own mesh before it."""
    vertices = case.option("vertices")
    same = [each for each in cases if each.scene == case.scene and not each.option("vertices")]
    return not vertices and same[:1] == [case]


def name_of(case, cases):
    vertices = case.option("vertices")
    size = f", {vertices:,} vertices" if vertices else ""
    others = {each.label for each in cases if each.scene == case.scene and each.option("vertices") == vertices}
    return f"{case.scene}{', ' + case.label if len(others) > 1 else ''}{size}"


def shade_tools(ax, case):
    """Where a tool holds the organ."""
    spans = []
    start = 0.0
    for each in returns_of(case):
        spans.append((start, figure(each, "released_s")))
        start = figure(each, "end_s") or start
    for low, high in spans:
        if high is not None:
            ax.axvspan(low, high, color="#dddddd", alpha=0.6, linewidth=0)


def draw_returns(run, cases, folder):
    """The points that the tools pushed, over time: as they are, and on a logarithmic axis."""
    motions = [(case, motion) for case in cases if (motion := read_motion(run, case)) is not None and probe_sizes(motion)]
    if not motions:
        return []
    fig, grid = plt.subplots(2, 1, figsize=(7.4 if len(motions) <= len(COLORS) else 10.4, 6.0), sharex=True)
    shade_tools(grid[0], motions[0][0])
    shade_tools(grid[1], motions[0][0])
    for (case, motion), color, turn in numbered(motions):
        time = column(motion, "time_s")
        for number, size in enumerate(probe_sizes(motion)):
            for ax in grid:
                ax.plot(time, 1000 * np.maximum(size, 1e-12), PATTERNS[turn % 3] if number == 0 else ":", color=color, linewidth=1.3,
                        label=name_of(case, cases) if number == 0 else None)
    grid[0].set_title("The two points that are pushed (second one dotted); grey: a tool holds the organ", loc="left", color=INK)
    grid[1].set_yscale("log")
    grid[1].set_ylim(bottom=1e-6)
    grid[1].set_xlabel("simulated time in s")
    for ax in grid:
        ax.set_ylabel("displacement in mm")
        ax.grid(axis="both")
    grid[0].legend(fontsize=8, loc="upper left", bbox_to_anchor=(1.0, 1.0))
    lay_out(fig)
    return save(fig, folder, "returns")


def choose_pictures(case, frames):
    """(title, frame): the first frame, then of each palpation the last one held, one let go and the last one. None stands for another
    side of the moment at which the tool lets go; a title says when its frame is, not when it was wanted."""
    frames = sorted(frames, key=lambda each: each["time_s"])
    found = [("undeformed" if frame["time_s"] == 0 else "first frame", frame) for frame in frames[:1]]
    before = 0.0
    for number, each in enumerate(returns_of(case), start=1):
        released, end = figure(each, "released_s"), figure(each, "end_s")
        if released is None or end is None:
            continue
        rounding = 1e-9 * end
        held = [frame for frame in frames if before + rounding < frame["time_s"] <= released + rounding]
        free = [frame for frame in frames if released + rounding < frame["time_s"] <= end + rounding]
        found += [(f"palpation {number}, held", frame) for frame in held[-1:]]
        wanted = released + 0.2 * (end - released)
        nearest = min(range(len(free)), key=lambda k: abs(free[k]["time_s"] - wanted), default=None)
        for k in sorted({nearest, len(free) - 1} if free else ()):
            found.append((f"let go, {free[k]['time_s'] - released:.3g} s", free[k]))
        before = end
    return [(f"{title}\n{frame['time_s']:.4g} s", frame) for title, frame in found]


def draw_body(ax, points, faces, view, size, norm):
    corners = (points[faces] - view.centre) @ view.frame.T
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    lengths = np.linalg.norm(normals, axis=1)
    front = (normals[:, 2] > 0) & (lengths > 0)
    order = np.argsort(corners[front, :, 2].mean(axis=1), kind="stable")
    brightness = 0.55 + 0.45 * np.clip(normals[front] @ (LIGHT / np.linalg.norm(LIGHT)) / lengths[front], 0.0, 1.0)
    colors = plt.get_cmap("viridis")(norm(size[faces].mean(axis=1)[front][order]))
    colors[:, :3] *= brightness[order][:, None]
    ax.add_collection(PolyCollection(corners[front][order][:, :, :2], facecolors=colors, edgecolors=(0, 0, 0, 0.3), linewidths=0.15,
                                     rasterized=True))
    margin = 0.06 * (view.high - view.low).max()
    ax.set_xlim(view.low[0] - margin, view.high[0] + margin)
    ax.set_ylim(view.low[1] - margin, view.high[1] + margin)
    ax.set_aspect("equal")
    ax.axis("off")


def problem_of(case):
    """The folder of the case's mesh, below problems/."""
    vertices = case.option("vertices")
    return f"{case.scene}/vertices={vertices}" if vertices else case.scene


def draw_phases(run, case, cases, folder):
    """The organ in its phases, as the thesis's figures 4.6-4.14 have it; colours show how far each part is from rest."""
    motion = read_motion(run, case)
    if motion is None or not motion["frames"]:
        return []
    try:
        mesh = read_mesh(inside(run.folder, f"problems/{problem_of(case)}/in.mesh"))
    except BadRun as error:
        run.note(f"no pictures of {case.scene}: {error}")
        return []
    faces, _ = outer_faces(mesh.tets)
    view = choose_view(mesh)
    pictures = []
    for title, frame in choose_pictures(case, motion["frames"]):
        if len(frame["displacement_m"]) == 3 * len(mesh.points):
            pictures.append((title, np.array(frame["displacement_m"], dtype=float).reshape(-1, 3)))
    if not pictures:
        return []
    most = max((np.linalg.norm(field, axis=1).max() for _, field in pictures), default=0.0)
    norm = Normalize(0.0, 1000 * most if most > 0 else 1.0)
    fig, grid = plt.subplots(1, len(pictures), figsize=(1.8 * len(pictures) + 0.9, 1.9), squeeze=False, layout="constrained")
    for ax, (title, field) in zip(grid.flat, pictures):
        draw_body(ax, mesh.points + field, faces, view, 1000 * np.linalg.norm(field, axis=1), norm)
        ax.set_title(title, fontsize=8, color=INK)
    fig.colorbar(ScalarMappable(norm, "viridis"), ax=list(grid.flat), label="from rest in mm")
    set_title(fig, name_of(case, cases), x=0.02, color=INK)
    return save(fig, folder, file_name("phases", case.scene, "" if is_only(case, cases) else case.label))


def draw_margins(cases, folder):
    """Margin of the step over the size of the mesh."""
    curves = {}
    for case in cases:
        margin = case.number("stability_margin")
        if margin is not None and case.vertices:
            curves.setdefault((case.scene, case.label), []).append((case.vertices, margin))
    curves = {key: sorted(points) for key, points in curves.items() if len(points) > 1}
    if not curves:
        return []
    fig, ax = plt.subplots(figsize=(5.6, 3.6))
    for ((scene, label), points), color, turn in numbered(curves.items()):
        ax.plot([x for x, _ in points], [y for _, y in points], MARKERS[turn % len(MARKERS)] + "-", color=color, linewidth=1.4, label=f"{scene}, {label}")
    ax.axhline(1.0, color=INK, linewidth=0.8)
    ax.annotate("below: unstable", (0.01, 1.0), xycoords=("axes fraction", "data"), xytext=(0, -10), textcoords="offset points", fontsize=8,
                color=FAINT)
    set_size_axis(ax, [x for points in curves.values() for x, _ in points])
    ax.set_ylim(bottom=0)
    ax.set_xlabel("vertices")
    ax.set_ylabel("longest stable step / step")
    ax.grid(axis="both")
    ax.legend(fontsize=8)
    lay_out(fig)
    return save(fig, folder, "margins")


def setting_of(case):
    return case.label, str(case.chosen("precision")), case.threads


def setting_text(setting):
    label, precision, threads = setting
    return f"{label}, {precision}, {threads} thread{'s' if threads != 1 else ''}"


def set_size_axes(fig, grid, sizes):
    """Lays the figure out; only then it is known how many sizes have room below its axes."""
    for ax in grid:
        set_size_axis(ax, sizes)
    lay_out(fig)
    for ax in grid:
        set_size_axis(ax, sizes)


def curve_of(case):
    return case.scene, *setting_of(case)


def curves_of_ticks(cases, name):
    """{(scene, label, precision, threads): sorted (vertices, value)}."""
    curves = {}
    for case in cases:
        value = case.number(name)
        if value is not None and case.vertices:
            curves.setdefault(curve_of(case), []).append((case.vertices, value))
    return {key: sorted(points) for key, points in curves.items()}


def draw_budget(cases, folder):
    """Median, 99.9th percentile and worst tick over the size of the mesh, of what was timed at several."""
    cases = with_several_sizes(cases, curve_of)
    deadline = next((value for case in cases if (value := figure(case.record, "report", "tick_s")) is not None), None)
    scenes = {setting: len({case.scene for case in cases if setting_of(case) == setting}) for setting in map(setting_of, cases)}
    fig, grid = plt.subplots(1, 3, figsize=(11.4, 3.8), sharey=True)
    for ax, (title, name) in zip(grid, [("median", "tick_p50_s"), ("99.9% of the ticks", "tick_p99_9_s"), ("worst", "tick_worst_s")]):
        for ((scene, *setting), points), color, turn in numbered(curves_of_ticks(cases, name).items()):
            setting = tuple(setting)
            ax.plot([x for x, _ in points], [1000 * y for _, y in points], MARKERS[turn % len(MARKERS)] + DASHES.get(setting[2], ":"), color=color, linewidth=1.3,
                    markersize=4, label=setting_text(setting) + (f", {scene}" if scenes[setting] > 1 else ""))
        if deadline is not None:
            ax.axhline(1000 * deadline, color=INK, linewidth=0.8)
        ax.set_yscale("log")
        ax.set_title(title, loc="left", color=INK)
        ax.set_xlabel("vertices")
        ax.grid(axis="both")
    grid[0].set_ylabel("time of a tick in ms")
    grid[2].legend(fontsize=7, loc="upper left", bbox_to_anchor=(1.0, 1.0))
    set_size_axes(fig, grid, [case.vertices for case in cases if case.vertices])
    return save(fig, folder, "budget")


def has_distribution(case):
    """Whether it told how many ticks took how long, and how large its mesh was."""
    counts, ends = case.told("buckets"), case.told("bucket_ends_s")
    return (are_numbers(counts) and are_numbers(ends) and len(counts) == len(ends) and min(counts, default=-1) >= 0 and sum(counts) > 0
            and min(ends) > 0 and case.vertices is not None)


def draw_distribution(cases, folder):
    """How many ticks took longer than a time: both axes logarithmic."""
    chosen = [case for case in cases if has_distribution(case)]
    settings = sorted({setting_of(case) for case in chosen}, key=lambda setting: (*setting[:2], setting[2] or 0))
    if not settings:
        return []
    wide = min(len(settings), MOST_PANELS_A_ROW)
    high = -(-len(settings) // wide)
    fig, grid = plt.subplots(high, wide, figsize=(max(4.6, 3.4 * wide), 3.8 * high), sharey=True, squeeze=False)
    for ax in grid.flat[len(settings):]:
        ax.set_visible(False)
    for ax, setting in zip(grid.flat, settings):
        own = [case for case in chosen if setting_of(case) == setting]
        several = len({case.scene for case in own}) > 1
        for number, case in enumerate(own):
            counts = np.array(case.told("buckets"), dtype=float)
            longer = counts[::-1].cumsum()[::-1] / counts.sum()
            starts = 1000 * np.array(case.told("bucket_ends_s"), dtype=float) / 10 ** (1 / 20)
            ax.step(starts, longer, where="pre", color=plt.get_cmap("viridis")(0.9 * number / max(1, len(own) - 1)), linewidth=1.3,
                    label=f"{case.vertices:,.0f}" + (f", {case.scene}" if several else ""))
            deadline = figure(case.record, "report", "tick_s")
            if deadline is not None:
                ax.axvline(1000 * deadline, color=INK, linewidth=0.8)
        ax.set_xscale("log")
        ax.set_yscale("log")
        ax.set_title(setting_text(setting), loc="left", color=INK)
        ax.set_xlabel("time of a tick in ms")
        ax.grid(axis="both")
        ax.legend(fontsize=6, title="vertices", title_fontsize=6, loc="upper left", bbox_to_anchor=(0.0, -0.18), ncol=1 if several else 4)  # curves may be anywhere inside
    for row in grid:
        row[0].set_ylabel("share of ticks that take longer")
    lay_out(fig)
    return save(fig, folder, "tick_times")


def draw_largest(cases, folder):
    """The largest mesh that holds the deadline, setting by setting; what holds on none is zero."""
    largest = largest_meshes(with_several_sizes(cases, setting_of))
    fig, ax = plt.subplots(figsize=(max(5.0, 1.5 * len(largest) + 1.5), 3.6))
    width = 0.8 / len(HOLDS)
    for number, (how, _) in enumerate(HOLDS):
        heights = [row[how] or 0 for row in largest.values()]
        places = [place + (number - (len(HOLDS) - 1) / 2) * width for place in range(len(heights))]
        ax.bar(places, heights, width, color=COLORS[number], label=how)
        for place, height in zip(places, heights):
            ax.annotate(f"{height:,.0f}" if height else "none", (place, height), xytext=(0, 2), textcoords="offset points", ha="center",
                        fontsize=6.5, color=FAINT, rotation=90)
    ax.set_xticks(range(len(largest)), [f"{label}, {precision}\n{threads} thread{'s' if threads != 1 else ''}"
                                        for _, label, precision, threads in largest], fontsize=8)
    ax.set_ylabel("vertices")
    ax.margins(y=0.2)
    ax.grid(axis="y")
    ax.set_title("The largest mesh whose ticks are in time", loc="left", color=INK)
    ax.legend(fontsize=8, loc="upper left", bbox_to_anchor=(1.0, 1.0))
    lay_out(fig)
    return save(fig, folder, "largest")


def draw_force(cases, folder):
    """The held force of each method and by finite elements, and their difference beside five times the finite elements' own change."""
    names = ("held_force_size_n", "reference_force_size_n", "force_error", "reference_force_change")
    curves = {}
    for case in with_several_sizes([each for each in cases if each.threads == 1 and each.number("force_error") is not None], force_curve_of):
        numbers = [case.number(name) for name in names]
        # Labels of one method differ in what they time, not in the force.
        curves.setdefault(force_curve_of(case), {}).setdefault(case.vertices, [np.nan if number is None else number for number in numbers])
    if sum(map(len, curves.values())) < 2:
        return []
    scenes = [scene for scene, _ in curves]
    handles = []
    fig, grid = plt.subplots(1, 2, figsize=(10.4, 3.8))
    for ((scene, method), points), color, turn in numbered(sorted(curves.items())):
        size = sorted(points)
        own, other, error, change = np.array([points[each] for each in size]).T
        mark = MARKERS[turn % len(MARKERS)]
        handles += grid[0].plot(size, own, mark + "-", color=color, linewidth=1.3, markersize=4, label=scene + (f", {method}" if scenes.count(scene) > 1 else ""))
        grid[0].plot(size, other, mark + "--", color=color, linewidth=1.0, markersize=3, markerfacecolor="white")
        grid[1].plot(size, 100 * error, mark + "-", color=color, linewidth=1.3, markersize=4)
        grid[1].plot(size, 500 * change, mark + ":", color=color, linewidth=1.0, markersize=3, markerfacecolor="white")
    grid[0].set_ylabel("force of the pad in N")
    grid[0].set_title("dashed: by finite elements", loc="left", fontsize=8, color=INK)
    grid[0].set_ylim(bottom=0)
    grid[1].set_ylabel("difference in %")
    grid[1].set_title("dotted: 5 x the finite elements' change", loc="left", fontsize=8, color=INK)
    grid[1].set_ylim(bottom=0)
    grid[1].legend(handles=handles, fontsize=7, loc="upper left", bbox_to_anchor=(1.0, 1.0))
    for ax in grid:
        ax.set_xlabel("vertices")
        ax.grid(axis="both")
    set_size_axes(fig, grid, [size for points in curves.values() for size in points])
    return save(fig, folder, "force")


def force_curve_of(case):
    return case.scene, case.record.get("contestant") or case.label


def draw_charts(run, found, folder):
    """Draws all that there is; returns the names of the files."""
    folder.mkdir(parents=True, exist_ok=True)
    drawn = []
    with plt.rc_context(STYLE):
        drawn += draw_returns(run, found.replays, folder)
        for case in found.replays:
            drawn += draw_phases(run, case, found.replays, folder)
        drawn += draw_margins(found.rests, folder)
        if found.ticks:
            drawn += draw_budget(found.ticks, folder) + draw_distribution(found.ticks, folder)
            drawn += draw_largest(found.ticks, folder) + draw_force(found.ticks, folder)
    return drawn
