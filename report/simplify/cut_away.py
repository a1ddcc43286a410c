"""Cut-away pictures: input and answers of one mesh and count, cut open and coloured by quality, from one point of view.

The cut is a crinkled one: the tets whose centroid lies before a plane through the middle of the input are taken away whole, and
what is left shows its outer faces. Each face has the colour of its tet's quality, darkened a little by its angle to the light. Faces are
drawn from back to front.
"""

from dataclasses import dataclass

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.cm import ScalarMappable
from matplotlib.collections import PolyCollection
from matplotlib.colors import Normalize

from shared.chart_style import FAINT, INK, file_name, save
from shared.mesh_file import outer_faces, qualities, read_mesh
from shared.mesh_view import choose_view, inside, shade_front
from shared.records import BadRun, figure
from shared.run_meshes import is_left_behind
from simplify.contest import NONE, RANKED, REJECTED, section_title

COLUMNS = 4
COLORMAP = "viridis"  # lightness grows with quality, so that it reads in grey and for colour-blind eyes
QUALITY_TOLERANCE = 1e-6  # of the mean; double precision gives 1e-14


def kept_tets(mesh, view):
    """Whether the centroid of each tet lies behind the plane."""
    return (mesh.points[mesh.tets].mean(axis=1) - view.centre) @ view.normal <= 0


def visible_faces(mesh, view):
    """Polygons (faces x 3 x 2) from back to front, the quality of their tets, and their brightness in 0.72..1."""
    quality = qualities(mesh)
    kept = kept_tets(mesh, view)
    faces, owners = outer_faces(mesh.tets[kept])
    corners = (mesh.points[faces] - view.centre) @ view.frame.T
    front, order, brightness = shade_front(corners, 0.72)
    return corners[front][order][:, :, :2], quality[kept][owners][front][order], brightness[order]


def draw_mesh(ax, mesh, view, norm):
    polygons, quality, brightness = visible_faces(mesh, view)
    colors = plt.get_cmap(COLORMAP)(norm(quality))
    colors[:, :3] *= brightness[:, None]
    edge = 0.25 if len(polygons) < 4000 else 0.08
    ax.add_collection(PolyCollection(polygons, facecolors=colors, edgecolors=(0, 0, 0, 0.55), linewidths=edge,
                                     antialiaseds=True, rasterized=True))
    margin = 0.03 * (view.high - view.low).max()
    ax.set_xlim(view.low[0] - margin, view.high[0] + margin)
    ax.set_ylim(view.low[1] - margin, view.high[1] + margin)
    ax.set_aspect("equal")
    ax.axis("off")


def title_of(standing):
    """The label, with why its figures do not count."""
    if standing.state == RANKED:
        return standing.label
    return f"{standing.label} ({'rejected' if standing.state == REJECTED else 'other count'})"


def figures_text(values):
    tets, share, least = (values.get(name) for name in ("tets", "percent_above_0_5", "min_dihedral_deg"))
    return ", ".join(text for text in (
        None if tets is None else f"{tets:,.0f} tets", None if share is None else f"{share:.2f}% > 0.5",
        None if least is None else f"least angle {least:.1f}\N{DEGREE SIGN}") if text)


def record_with_mesh(group):
    """The first judged answer that kept its mesh, or {}."""
    return next((record for record in group.judged() if isinstance(record.get("mesh_file"), str)), {})


def check_quality(title, mesh, record):
    """What to say if the picture's qualities are not the judge's; each has arithmetic of its own."""
    judged, own = figure(record, "judge", "mean_quality"), float(qualities(mesh).mean())
    if judged is None or abs(judged - own) <= QUALITY_TOLERANCE:
        return ""
    return f"{title} has a mean quality of {own:.6f} by the picture's arithmetic, of {judged:.6f} by the judge's"


def panels_of(run, section):
    """(title, caption, mesh) of the input and of every answer that left a mesh; files that cannot be read are noted."""
    start = run.inputs.get(section.mesh, {})
    values = {name: figure(start, "judge", name) for name in ("tets", "percent_above_0_5", "min_dihedral_deg")}
    entries = [("input", figures_text(values), start)]
    entries += [(title_of(standing), figures_text(standing.values), record_with_mesh(standing.group))
                for standing in section.standings if standing.state != NONE]
    panels = []
    for title, text, record in entries:
        if not isinstance(record.get("mesh_file"), str) or is_left_behind(run, record["mesh_file"]):
            continue
        try:
            mesh = read_mesh(inside(run.folder, record["mesh_file"]))
        except BadRun as error:
            run.note(f"no cut-away of {title} on {section.mesh}: {error}")
            continue
        panels.append((title, text, mesh))
        doubt = check_quality(title, mesh, record)
        run.notes += [f"cut-away, {section_title(run, section)}: {doubt}"] if doubt else []
    return panels


def draw_cut_away(run, sections, folder):
    """One figure for each mesh and point of the sweep, with a panel for the input and each answer."""
    drawn = []
    for section in sections:
        panels = panels_of(run, section)
        if len(panels) < 2:
            continue
        view = choose_view(panels[0][2])
        drawn += draw_figure(run, section, panels, view, folder)
    return drawn


def draw_figure(run, section, panels, view, folder):
    columns = min(COLUMNS, len(panels))
    rows = -(-len(panels) // columns)
    span = view.high - view.low
    panel_width = 2.6
    panel_height = panel_width * span[1] / span[0] + 0.42
    width, height = columns * panel_width + 0.2, rows * panel_height + 1.0
    fig = plt.figure(figsize=(width, height))
    norm = Normalize(0.0, 1.0)
    for i, (title, text, mesh) in enumerate(panels):
        row, column = divmod(i, columns)
        left, top = 0.1 + column * panel_width, 0.4 + row * panel_height
        ax = fig.add_axes([left / width, 1 - (top + panel_height) / height, panel_width / width,
                           (panel_height - 0.42) / height])
        draw_mesh(ax, mesh, view, norm)
        fig.text((left + 0.05) / width, 1 - (top + 0.14) / height, title, fontsize=9, fontweight="bold", color=INK)
        fig.text((left + 0.05) / width, 1 - (top + 0.30) / height, text, fontsize=7, color=FAINT)
    bar = fig.add_axes([0.3 / width, 0.38 / height, min(5.0, width - 0.6) / width, 0.12 / height])
    scale = fig.colorbar(ScalarMappable(norm, COLORMAP), cax=bar, orientation="horizontal")
    scale.set_label("quality of the tetrahedron", fontsize=8, labelpad=1)
    bar.tick_params(labelsize=8)
    fig.text(0.1 / width, 1 - 0.2 / height, section_title(run, section), fontsize=11, fontweight="bold", color=INK)
    return save(fig, folder, file_name("cut_away", section.mesh, section.sweep))
