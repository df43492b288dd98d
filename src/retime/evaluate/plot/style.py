"""Colours, dashes and letters of the plots."""

from __future__ import annotations

import itertools
from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    # A command line that refuses a picture's name does not wait for numpy.
    from retime.warp.curve import Warp

INK, GREY, PALE = "#1f2933", "#64748b", "#e2e8f0"
FLIGHT, FLIGHT_INK, FLIGHT_FAR = "#fdebcb", "#b45309", "#e3ae7d"
NEAR, TRUNK, FAR = "#334155", "#52627a", "#a9b6c6"
# Far limbs first: what is drawn later lies on top.
STANDING_SIDES = {"left": FAR, "": TRUNK, "right": NEAR}
FLYING_SIDES = {"left": FLIGHT_FAR, "": FLIGHT_INK, "right": FLIGHT_INK}
KEY_MARKS: dict[str, Any] = {
    "linestyle": "none",
    "marker": "D",
    "markersize": 5,
    "color": INK,
    "clip_on": False,
    "zorder": 5,
}


@dataclass(frozen=True)
class Pen:
    """How one warp is drawn: told apart by dashes too, for those who don't see or print the colours."""

    color: str
    dashes: tuple[float, ...]
    width: float

    @property
    def line(self) -> dict[str, Any]:
        """Its colour, dashes and width, as matplotlib's functions take them."""
        dashes = (0, self.dashes) if self.dashes else "solid"
        return {"color": self.color, "linestyle": dashes, "linewidth": self.width}


def shown(text: str, most: int, *, legend: bool = False) -> str:
    """Fit a name from a stranger's file: one line, no control characters (SVG can't hold them), not too long."""
    text = "".join(letter if letter.isprintable() else " " for letter in text)
    text = text if len(text) <= most else text[: most - 1] + "…"
    # A legend leaves out what begins with an underscore.
    return "\u2009" + text if legend and text.startswith("_") else text


_BY_METHOD = {
    "guided": Pen("#0f766e", (), 2.2),
    "align": Pen("#b45309", (), 2.2),
    "linear": Pen("#475569", (5, 2), 1.7),
    "spline": Pen("#7c3aed", (7, 2, 1.5, 2), 1.7),
}
_OTHERS = (
    Pen("#be185d", (1.5, 1.2), 2.0),
    Pen("#1d4ed8", (3, 1.2), 1.7),
    Pen("#4d7c0f", (8, 1.6, 1.5, 1.6, 1.5, 1.6), 1.7),
    Pen("#0e7490", (11, 3), 1.7),
    Pen("#9f1239", (4, 1, 1, 1), 1.7),
)


def pens_for(warps: Mapping[str, Warp]) -> dict[str, Pen]:
    """Choose a pen for each warp: a method's own goes to its namesake, else to the first of the method."""
    owners = {method: method for method in _BY_METHOD if method in warps}
    for label, warp in warps.items():
        if warp.method in _BY_METHOD and label not in owners.values():
            owners.setdefault(warp.method, label)
    pens = {label: _BY_METHOD[method] for method, label in owners.items()}
    rest = itertools.cycle(_OTHERS)
    return {label: pens[label] if label in pens else next(rest) for label in warps}


# Everything that a style sheet of the user's could change, and that would then change the file.
PLOT_SUFFIXES = (".svg", ".pdf", ".png")
"""Endings of the files that plots are written to."""

STYLE: dict[Any, Any] = {
    # Text that can be selected, and edited in a drawing program.
    "pdf.fonttype": 42,
    "font.family": ["sans-serif"],
    "font.sans-serif": ["DejaVu Sans"],
    "font.size": 9.5,
    "axes.edgecolor": "#94a3b8",
    "axes.facecolor": "white",
    "axes.grid": False,
    "axes.labelcolor": INK,
    "axes.labelsize": 9.5,
    "axes.linewidth": 0.8,
    "axes.spines.right": False,
    "axes.spines.top": False,
    "axes.unicode_minus": True,
    "figure.facecolor": "white",
    "figure.dpi": 100,
    "legend.fontsize": 9.5,
    "path.simplify": True,
    "path.simplify_threshold": 1 / 9,
    "savefig.bbox": None,
    "savefig.facecolor": "auto",
    "svg.fonttype": "none",
    "svg.hashsalt": "retime",
    "text.color": INK,
    "text.usetex": False,
    "xtick.color": "#475569",
    "ytick.color": "#475569",
    "xtick.labelsize": 9,
    "ytick.labelsize": 9,
}
