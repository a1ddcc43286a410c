"""Names beside the points of a chart: each where it meets no mark, no other name and no edge of its panel, if there is such a place."""

from matplotlib.patheffects import withStroke
from matplotlib.text import Text
from matplotlib.transforms import Bbox

NAME = "name of a point"  # the gid of a name that may be moved
BESIDE = [(7, 0, "left", "center"), (-7, 0, "right", "center"), (0, 6, "center", "bottom"), (0, -6, "center", "top"),
          (6, 5, "left", "bottom"), (-6, 5, "right", "bottom"), (6, -5, "left", "top"), (-6, -5, "right", "top")]
FARTHER = [(x * step, y * step, ha, va) for step in (2.2, 3.4) for x, y, ha, va in BESIDE]
MARK = 4.0  # half of a mark's width, in points
PADDING = 1.0  # pixels between two names


def name_point(ax, text, x, y, color, at=None):
    """Writes a name beside a point: at (points to the right, up, horizontal and vertical alignment), or where place_names finds a place."""
    right, up, ha, va = at or BESIDE[0]
    made = ax.annotate(text, (x, y), xytext=(right, up), textcoords="offset points", ha=ha, va=va, fontsize=7, color=color, zorder=7, gid=None if at else NAME,
                       path_effects=[withStroke(linewidth=2, foreground="white")],
                       arrowprops=None if at else {"arrowstyle": "-", "color": color, "linewidth": 0.6, "shrinkA": 0, "shrinkB": 3})
    if not at:
        made.arrow_patch.set_visible(False)  # until the name stands farther away
        made.set_in_layout(False)  # it takes what room there is


def box_at(point, size, place, pixels_a_point):
    """Where a text of that size, in pixels, stands."""
    right, up, ha, va = place
    width, height = size
    x = point[0] + right * pixels_a_point - {"left": 0.0, "center": 0.5, "right": 1.0}[ha] * width
    y = point[1] + up * pixels_a_point - {"bottom": 0.0, "center": 0.5, "top": 1.0}[va] * height
    return Bbox.from_bounds(x, y, width, height)


def shared_area(a, b):
    width, height = min(a.x1, b.x1) - max(a.x0, b.x0), min(a.y1, b.y1) - max(a.y0, b.y0)
    return max(0.0, width) * max(0.0, height)


def marks_of(ax, pixels_a_point):
    """The boxes of all marks of a panel, in pixels."""
    half = MARK * pixels_a_point
    points = [point for line in ax.get_lines() if line.get_marker() not in ("None", "", None) for point in ax.transData.transform(line.get_xydata())]
    return [Bbox.from_bounds(x - half, y - half, 2 * half, 2 * half) for x, y in points]


def place_names(fig):
    """Moves the names of all panels, once these have their size. The first place of BESIDE, then of FARTHER, that is free; else where least is covered."""
    fig.draw_without_rendering()
    renderer = fig.canvas.get_renderer()
    pixels_a_point = fig.dpi / 72.0
    for ax in fig.axes:
        frame = ax.get_window_extent(renderer)
        taken = marks_of(ax, pixels_a_point) + [text.get_window_extent(renderer) for text in ax.texts if text.get_gid() != NAME]
        names = [(Text.get_window_extent(child, renderer), child) for child in ax.texts if child.get_gid() == NAME]
        for extent, text in sorted(names, key=lambda name: -name[0].width):  # long ones first: they have fewer places
            point = ax.transData.transform(text.xy)
            size = (extent.width, extent.height)

            def covered(place, point=point, size=size, taken=taken, frame=frame):
                box = box_at(point, size, place, pixels_a_point)
                return box.width * box.height - shared_area(box, frame) + sum(shared_area(box.padded(PADDING), other) for other in taken)

            best = min((*BESIDE, *FARTHER), key=lambda place: round(covered(place), 6))  # the first of equals
            text.set_position(best[:2])
            text.set_ha(best[2])
            text.set_va(best[3])
            text.arrow_patch.set_visible(best in FARTHER)
            taken.append(box_at(point, size, best, pixels_a_point))
