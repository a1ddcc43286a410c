"""What all charts share: colours, type, and how a figure is written. The same figure gives the same bytes."""

import math
import re

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
from matplotlib.font_manager import FontProperties
from matplotlib.ticker import FuncFormatter, LogFormatter, LogLocator, NullFormatter, NullLocator

from shared.whole_file import replacing

# Colours that stay apart for colour-blind eyes (Okabe and Ito), and apart in grey print.
BETTER, THAN, SPREAD, OTHERS = "#0072B2", "#D55E00", "#CC79A7", "#009E73"
BAND, QUARTILES = "#F0E442", "#5b3a00"
INK, FAINT, GRID = "#222222", "#767676", "#dddddd"
STYLE = {
    "font.family": "DejaVu Sans", "font.size": 9, "axes.titlesize": 10, "axes.labelsize": 9, "figure.dpi": 100,
    "savefig.dpi": 160, "svg.hashsalt": "palpate", "svg.fonttype": "path", "axes.edgecolor": FAINT,
    "axes.labelcolor": INK, "text.color": INK, "xtick.color": INK, "ytick.color": INK, "axes.spines.top": False,
    "axes.spines.right": False, "axes.axisbelow": True, "grid.color": GRID, "grid.linewidth": 0.7, "legend.frameon": False,
    "text.parse_math": False,  # a name with two $ in it is a name
}
BOX_FROM = 5  # values: a box of quartiles over fewer would show more than there is; they are drawn one by one
LINE = 0.19  # inches of a line of a title or a legend
LEAST_TITLE = 6.5  # points: a title that is too wide is not set smaller, but in lines
SUPERSCRIPTS = str.maketrans("-0123456789", "\u207b\u2070\u00b9\u00b2\u00b3\u2074\u2075\u2076\u2077\u2078\u2079")


def save(fig, folder, name):
    """Writes NAME.svg and NAME.png, each beside its place and renamed. Numbers of logarithmic axes and titles are put right first."""
    write_powers_plainly(fig)
    fit_titles(fig)
    for ending, metadata in (("svg", {"Date": None, "Creator": "palpate"}), ("png", {"Software": None})):
        with replacing(folder / f"{name}.{ending}", folder / f"{name}.part.{ending}") as beside:
            fig.savefig(beside, metadata=metadata, facecolor="white")
    plt.close(fig)
    return [f"{name}.svg", f"{name}.png"]


def file_name(*parts):
    return "_".join("".join(c if c.isalnum() or c in "-." else "_" for c in part) for part in parts if part)


def power_text(value, _place=None):
    """"0.01", "1000"; "10^6" with a raised 6 where there would be many zeros; nothing between powers of ten."""
    exponent = round(math.log10(value)) if value > 0 else 0
    if value <= 0 or abs(value / 10.0**exponent - 1) > 1e-6:
        return ""
    return f"{10.0**exponent:g}" if -3 <= exponent <= 4 else "10" + str(exponent).translate(SUPERSCRIPTS)


def write_powers_plainly(fig):
    """Gives logarithmic axes that have the library's own numbers ours: those need its mathematics, which is off."""
    for ax in fig.axes:
        for axis in (ax.xaxis, ax.yaxis):
            if axis.get_scale() == "log" and isinstance(axis.get_major_formatter(), LogFormatter):
                axis.set_major_formatter(FuncFormatter(power_text))
            if axis.get_scale() == "log" and isinstance(axis.get_minor_formatter(), LogFormatter):
                axis.set_minor_formatter(NullFormatter())


def width_of(fig, text, **style):
    """Width of a text in pixels as the figure would draw it."""
    probe = fig.text(0, 0, text, **style)
    width = probe.get_window_extent(fig.canvas.get_renderer()).width
    probe.remove()
    return width


def in_lines(fig, text, room, **style):
    """The text with line ends where it takes them to stay within `room` pixels; long names break behind / and _."""
    lines = []
    for whole in text.split("\n"):
        if width_of(fig, whole, **style) <= room:
            lines.append(whole)
            continue
        line = ""
        for part in re.findall(r"\s+|[^\s/_]+[/_]*|[/_]+", whole):
            if line and width_of(fig, (line + part).rstrip(), **style) > room:
                lines.append(line.rstrip())
                line = "" if part.isspace() else part
            else:
                line += part
        lines.append(line.rstrip())
    return "\n".join(lines)


def set_title(fig, text, x=0.01, **style):
    """The title of a figure, to the left, in as many lines as its width takes."""
    style = {"fontsize": 11, "fontweight": "bold", **style}
    own = {key: style[key] for key in ("fontsize", "fontweight")}
    fig.suptitle(in_lines(fig, text, (0.985 - x) * fig.bbox.width, **own), x=x, ha="left", **style)


def room_of(fig, ax):
    """Pixels from the left of some axes to the next ones in their row, or to the figure's right."""
    own = ax.get_position()
    rights = [other.get_position().x0 for other in fig.axes if other is not ax and other.get_position().x0 > own.x0 + 1e-6
              and other.get_position().y0 < own.y1 and other.get_position().y1 > own.y0]
    return (min(rights, default=1.0) - own.x0) * fig.bbox.width - 0.06 * fig.dpi


def fit_titles(fig):
    """Sets titles of panels that reach into the next one or out of the figure smaller, and then in lines; returns how many lines that
    adds to the tallest of them."""
    renderer, more = fig.canvas.get_renderer(), 0
    for ax in fig.axes:
        if not ax.get_visible():
            continue
        for place in ("left", "center"):
            title = {"left": ax._left_title, "center": ax.title}[place]
            room = room_of(fig, ax)
            while title.get_text() and title.get_window_extent(renderer).width > room and title.get_fontsize() > LEAST_TITLE:
                title.set_fontsize(max(LEAST_TITLE, title.get_fontsize() - 0.5))
            if title.get_text() and title.get_window_extent(renderer).width > room:
                own = {"fontsize": title.get_fontsize(), "fontweight": title.get_fontweight()}
                before = title.get_text().count("\n")
                title.set_text(in_lines(fig, title.get_text(), room, **own))
                more = max(more, title.get_text().count("\n") - before)
    return more


def lay_out(fig, foot=0.0, **spacing):
    """Puts the panels between the title and what stands below (`foot` inches high); the figure grows where titles take more lines."""
    write_powers_plainly(fig)  # whose own numbers would ask for more room
    rows = max((ax.get_subplotspec().get_gridspec().nrows for ax in fig.axes if ax.get_subplotspec()), default=1)
    arrange = lambda: fig.tight_layout(rect=(0, foot / fig.get_figheight(), 1, 1), **spacing)
    if fig._suptitle is not None:
        fig.set_figheight(fig.get_figheight() + LINE * fig._suptitle.get_text().count("\n"))
        fig._suptitle.set_y(1 - 0.12 / fig.get_figheight())
        fig._suptitle.set_va("top")
    arrange()
    more = fit_titles(fig)
    if more:
        fig.set_figheight(fig.get_figheight() + rows * more * 0.85 * LINE)
        if fig._suptitle is not None:
            fig._suptitle.set_y(1 - 0.12 / fig.get_figheight())
        arrange()


def short_name(text, most=22):
    """A name that is long, cut in its middle: where the whole stands elsewhere in the chart."""
    return text if len(text) <= most else f"{text[:most // 2]}\u2026{text[-(most // 2 - 1):]}"


def time_text(milliseconds):
    return f"{milliseconds:g} ms" if milliseconds < 1000 else f"{milliseconds / 1000:g} s"


def set_time_axis(ax, low, high):
    """A logarithmic axis over these milliseconds, with as many numbers as there is room for."""
    ax.set_xscale("log")
    ax.set_xlim(low / 1.25, high * 1.25)
    ax.xaxis.set_major_locator(LogLocator(subs=(1, 2, 5) if high < 60 * low else (1,), numticks=12))
    ax.xaxis.set_major_formatter(FuncFormatter(lambda value, _: time_text(value)))
    ax.xaxis.set_minor_locator(LogLocator(subs=range(2, 10), numticks=12))
    ax.xaxis.set_minor_formatter(NullFormatter())


def set_size_axis(ax, sizes):
    """A logarithmic axis over these sizes (vertices), with those as numbers that have room."""
    ax.set_xscale("log")
    sizes = sorted(set(sizes))
    span = math.log(sizes[-1] / sizes[0]) if len(sizes) > 1 else 1.0
    digit = 0.65 * FontProperties(size=plt.rcParams["xtick.labelsize"]).get_size_in_points() / 72 * ax.figure.dpi / ax.bbox.width * span
    apart = []
    for size in sizes:
        text = f"{size:,.0f}"
        if not apart or math.log(size / apart[-1][0]) > digit * (1 + (len(text) + len(apart[-1][1])) / 2):
            apart.append((size, text))
    ax.set_xticks([size for size, _ in apart], [text for _, text in apart])
    ax.xaxis.set_minor_locator(NullLocator())


def draw_legend(fig, handles):
    """Puts the legend below, in as many columns as fit; returns the inches that it takes, and makes the figure higher where it takes more than two lines."""
    for handle in handles:
        handle.set_label(in_lines(fig, handle.get_label(), 0.88 * fig.bbox.width, fontsize=8))
    for columns in (4, 3, 2, 1):
        legend = fig.legend(handles=handles, loc="lower left", ncol=columns, fontsize=8, bbox_to_anchor=(0.02, 0.0),
                            handlelength=2.2)
        if columns == 1 or legend.get_window_extent(fig.canvas.get_renderer()).x1 <= 0.99 * fig.bbox.x1:
            break
        legend.remove()
    lines = sum(max(1 + handle.get_label().count("\n") for handle in handles[row::-(-len(handles) // columns)]) for row in range(-(-len(handles) // columns)))
    fig.set_figheight(fig.get_figheight() + LINE * max(0, lines - 2))
    return 0.25 + LINE * lines
