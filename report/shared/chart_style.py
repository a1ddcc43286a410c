"""What all charts share: colours, type, and how a figure is written. The same figure gives the same bytes."""

import os

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter

# Colours that stay apart for colour-blind eyes (Okabe and Ito), and apart in grey print.
BETTER, THAN, SPREAD, OTHERS = "#0072B2", "#D55E00", "#CC79A7", "#009E73"
BAND, QUARTILES = "#F0E442", "#5b3a00"
INK, FAINT, GRID = "#222222", "#767676", "#dddddd"
STYLE = {
    "font.family": "DejaVu Sans", "font.size": 9, "axes.titlesize": 10, "axes.labelsize": 9, "figure.dpi": 100,
    "savefig.dpi": 160, "svg.hashsalt": "palpate", "svg.fonttype": "path", "axes.edgecolor": FAINT,
    "axes.labelcolor": INK, "text.color": INK, "xtick.color": INK, "ytick.color": INK, "axes.spines.top": False,
    "axes.spines.right": False, "axes.axisbelow": True, "grid.color": GRID, "grid.linewidth": 0.7, "legend.frameon": False,
}


def save(fig, folder, name):
    """Writes NAME.svg and NAME.png, each beside its place and renamed."""
    for ending, metadata in (("svg", {"Date": None, "Creator": "palpate"}), ("png", {"Software": None})):
        beside = folder / f"{name}.part.{ending}"
        fig.savefig(beside, metadata=metadata, facecolor="white")
        os.replace(beside, folder / f"{name}.{ending}")
    plt.close(fig)
    return [f"{name}.svg", f"{name}.png"]


def file_name(*parts):
    return "_".join("".join(c if c.isalnum() or c in "-." else "_" for c in part) for part in parts if part)


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


def draw_legend(fig, handles, height):
    """Puts the legend below, in as many columns as fit; returns the share of the height that it takes."""
    for columns in (4, 3, 2, 1):
        legend = fig.legend(handles=handles, loc="lower left", ncol=columns, fontsize=8, bbox_to_anchor=(0.02, 0.0),
                            handlelength=2.2)
        if columns == 1 or legend.get_window_extent(fig.canvas.get_renderer()).x1 <= 0.99 * fig.bbox.x1:
            break
        legend.remove()
    return (0.25 + 0.19 * -(-len(handles) // columns)) / height
