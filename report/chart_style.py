"""What all charts share: colours, type, and how a figure is written. The same figure gives the same bytes."""

import os

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt

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
