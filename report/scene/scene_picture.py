"""Where a scene is held and where it is loaded: the skin from above and from below, each face in the colour of what takes hold of it.

A face that lies in a region in part is coloured in part, by its weight. Faces are drawn from back to front and shaded by their angle to
the light; arrows show the way that pads move and forces pull.
"""

from dataclasses import dataclass

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.collections import PolyCollection
from matplotlib.colors import to_rgb
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from shared.chart_style import BETTER, FAINT, INK, OTHERS, STYLE, THAN, draw_legend, save
from shared.mesh_file import outer_faces
from shared.mesh_view import shade_front

SKIN = "#ecd3c6"  # pale, so that the marks stand out in colour and in grey
PANEL = 4.2  # inches
MARKS = {"support": (BETTER, "elastic support"), "held": (INK, "held hard"), "pad": (THAN, "pad that is moved"),
         "force": (OTHERS, "force")}


@dataclass
class Mark:
    kind: str
    faces: np.ndarray  # n x 3, vertices
    weight: np.ndarray
    way: np.ndarray  # of the pad, in m, or of the force; zero: none


def read_marks(problem):
    """All regions of a problem, as marks; what moves or pulls has a way."""
    marks = []
    for held in problem.get("held", []):
        way = np.array(held["by_m"], dtype=float)
        marks.append(Mark("pad" if np.any(way) else "held", np.array(held["faces"]), np.ones(len(held["faces"])), way))
    for support in problem.get("supports", []):
        way = np.array(support["by_m"], dtype=float)
        marks.append(Mark("pad" if np.any(way) else "support", np.array(support["faces"]), np.array(support["weight"]), way))
    for traction in problem.get("tractions", []):
        marks.append(Mark("force", np.array(traction["faces"]), np.array(traction["weight"]), np.array(traction["traction_pa"], dtype=float)))
    return marks


def up_of(problem):
    """Against gravity; without any, against what is pushed in, or along z."""
    gravity = np.array(problem.get("gravity_m_s2", [0, 0, 0]), dtype=float)
    for way in [gravity] + [mark.way for mark in read_marks(problem)]:
        if np.linalg.norm(way) > 0:
            return -way / np.linalg.norm(way)
    return np.array([0.0, 0.0, 1.0])


def frame_of(points, up, above):
    """Rows: right, up in the picture, to the eye. The body's longest side across lies to the right."""
    flat = points - points.mean(axis=0)
    flat = flat - np.outer(flat @ up, up)
    _, _, axes = np.linalg.svd(flat, full_matrices=False)
    right = axes[0] * np.sign(axes[0][np.argmax(np.abs(axes[0]))])
    across = np.cross(up, right)
    eye = (0.62 if above else -0.55) * up - 0.72 * across + 0.25 * right
    eye /= np.linalg.norm(eye)
    right = right - eye * right.dot(eye)
    right /= np.linalg.norm(right)
    return np.array([right, np.cross(eye, right), eye])


def face_colors(faces, marks):
    """Red, green and blue of each face: the skin's, mixed with that of the marks by their weight."""
    colors = np.tile(to_rgb(SKIN), (len(faces), 1))
    places = {tuple(sorted(face)): i for i, face in enumerate(faces.tolist())}
    for mark in marks:
        color = np.array(to_rgb(MARKS[mark.kind][0]))
        for face, weight in zip(mark.faces.tolist(), mark.weight):
            i = places.get(tuple(sorted(face)))
            if i is not None:
                colors[i] = (1 - 0.85 * weight) * colors[i] + 0.85 * weight * color
    return colors


def draw_skin(ax, points, faces, colors, frame):
    corners = points[faces] @ frame.T
    front, order, brightness = shade_front(corners, 0.62)
    shaded = (colors[front] * brightness[:, None])[order]
    width = 0.35 if len(order) < 3000 else 0.1
    ax.add_collection(PolyCollection(corners[front][order][:, :, :2], facecolors=shaded, edgecolors=(0.25, 0.18, 0.15, 0.5),
                                     linewidths=width, antialiaseds=True, rasterized=True))


def draw_ways(ax, points, marks, frame, reach):
    """An arrow that ends at the middle of each mark that moves or pulls, if that side is seen."""
    for mark in marks:
        size = np.linalg.norm(mark.way)
        if size == 0:
            continue
        corners = points[mark.faces]
        areas = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]) * mark.weight[:, None]
        if areas.sum(axis=0) @ frame[2] <= 0:
            continue
        weights = np.linalg.norm(areas, axis=1)
        tip = (corners.mean(axis=1) * weights[:, None]).sum(axis=0) / weights.sum()
        tail = tip - reach * mark.way / size
        color = MARKS[mark.kind][0]
        ax.annotate("", xy=(frame @ tip)[:2], xytext=(frame @ tail)[:2], zorder=5,
                    arrowprops={"arrowstyle": "-|>,head_width=0.35,head_length=0.7", "color": color, "linewidth": 2.2,
                                "shrinkA": 0, "shrinkB": 0})


def scale_bar(ax, low, high):
    """A bar of a round length, about a fifth of the picture wide, in the lower left corner."""
    span = high[0] - low[0]
    power = 10.0 ** np.floor(np.log10(span / 4))
    length = max(step * power for step in (1, 2, 5) if step * power <= span / 4)
    text = f"{length * 1000:g} mm" if length < 0.01 else f"{length * 100:g} cm" if length < 1 else f"{length:g} m"
    ax.plot([low[0], low[0] + length], [low[1], low[1]], color=INK, linewidth=2, solid_capstyle="butt")
    ax.text(low[0] + length / 2, low[1] + 0.02 * span, text, ha="center", va="bottom", fontsize=8)


def legend_handles(marks):
    handles = []
    for kind, (color, text) in MARKS.items():
        own = [mark for mark in marks if mark.kind == kind]
        if own:
            faces = sum(len(mark.faces) for mark in own)
            handles.append(Patch(facecolor=color, edgecolor="none", label=f"{text}: {faces} faces"))
            if kind == "pad":
                way = max(np.linalg.norm(mark.way) for mark in own)
                handles.append(Line2D([], [], color=color, marker=">", linewidth=2, markersize=5,
                                      label=f"its way in, {1000 * way:.3g} mm (not to scale)"))
    return handles


def draw_scene(mesh, problem, folder, name):
    """Writes NAME.svg and NAME.png to the folder; returns their names."""
    plt.rcParams.update(STYLE)
    marks, up = read_marks(problem), up_of(problem)
    faces, _ = outer_faces(mesh.tets)
    colors = face_colors(faces, marks)
    size = mesh.points.max(axis=0) - mesh.points.min(axis=0)
    frames = [frame_of(mesh.points, up, above) for above in (True, False)]
    flats = [mesh.points @ frame.T for frame in frames]
    reach = 0.25 * size.max()
    spans = [flat[:, :2].max(axis=0) - flat[:, :2].min(axis=0) for flat in flats]
    margin = np.array([0.04, 0.04]) * size.max()
    tall = max(spans[0][1] + reach, spans[1][1]) + 3 * margin[1]
    wide = max(span[0] for span in spans) + 2 * margin[0]
    width, panel_height = 2 * PANEL + 0.4, PANEL * tall / wide
    height = panel_height + 1.25
    fig = plt.figure(figsize=(width, height))
    for i, (frame, flat, title) in enumerate(zip(frames, flats, ("from above", "from below"))):
        ax = fig.add_axes([(0.15 + i * (PANEL + 0.1)) / width, 0.55 / height, PANEL / width, panel_height / height])
        draw_skin(ax, mesh.points, faces, colors, frame)
        draw_ways(ax, mesh.points, marks, frame, reach)
        centre = (flat[:, 0].max() + flat[:, 0].min()) / 2
        low = np.array([centre - wide / 2, flat[:, 1].min() - 2 * margin[1]])
        ax.set_xlim(low[0], low[0] + wide)
        ax.set_ylim(low[1], low[1] + tall)
        ax.set_aspect("equal")
        ax.axis("off")
        if i == 0:
            scale_bar(ax, low + margin, low + np.array([wide, tall]))
        fig.text((0.2 + i * (PANEL + 0.1)) / width, 1 - 0.62 / height, title, fontsize=9, color=FAINT)
    fig.text(0.2 / width, 1 - 0.24 / height, name, fontsize=11, fontweight="bold", color=INK)
    material = problem["material"]
    fig.text(0.2 / width, 1 - 0.43 / height,
             f"{100 * size[0]:.3g} x {100 * size[1]:.3g} x {100 * size[2]:.3g} cm, {len(mesh.points):,} vertices, {len(mesh.tets):,} "
             f"tetrahedra; {material['young_modulus_pa'] / 1000:g} kPa, Poisson's ratio {material['poisson_ratio']:g}",
             fontsize=8, color=FAINT)
    draw_legend(fig, legend_handles(marks))
    return save(fig, folder, name)
