"""Small pictures for notebooks: plain SVG, no plotting library."""

from __future__ import annotations

import html
from collections.abc import Mapping, Sequence

import numpy as np

_WIDTH, _HEIGHT, _LEFT, _TOP = 330, 170, 52, 24
INK = "#0f766e"
"""The colour of what is shown; the others tell several lines apart."""
INKS = (INK, "#b45309", "#6d28d9", "#be123c", "#0369a1", "#4d7c0f", "#0f766e", "#a21caf")


def facts_html(facts: Mapping[str, object]) -> str:
    """Return names and values on one line."""
    cells = "".join(
        f'<span style="margin-right:14px"><b>{name}</b> {html.escape(str(value))}</span>'
        for name, value in facts.items()
    )
    return f'<div style="font:12px sans-serif">{cells}</div>'


def thinned(n_knots: int, most: int = 600) -> np.ndarray:
    """Choose at most so many of the points of a line, both ends included."""
    return np.unique(np.linspace(0, n_knots - 1, min(n_knots, most)).round().astype(int))


def side_by_side(*parts: str) -> str:
    """Return parts of a page in a row, or below one another where there is no room."""
    return f'<div style="display:flex;gap:16px;flex-wrap:wrap">{"".join(parts)}</div>'


def stacked(*parts: str) -> str:
    """Return parts of a page below one another."""
    return f"<div>{''.join(parts)}</div>"


class Panel:
    """One set of axes."""

    def __init__(self, title: str, x0: float, x1: float, y0: float, y1: float, *, of: str = "s of output") -> None:
        # The axis of a single frame, or of a constant, has no length; any but 0 will do.
        self._x = float(x0), float(x1) if x1 > x0 else x0 + 1.0
        self._y = float(y0), float(y1) if y1 > y0 else y0 + 1.0
        bottom = _TOP + _HEIGHT
        self._parts = [
            f'<text x="{_LEFT}" y="14" font-weight="bold">{html.escape(title)}</text>',
            f'<text x="{_LEFT}" y="{bottom + 16}">{x0:.3g}</text>',
            f'<text x="{_LEFT + _WIDTH}" y="{bottom + 16}" text-anchor="end">{x1:.3g} {html.escape(of)}</text>',
        ]

    def _place(self, x: float, y: float) -> tuple[float, float]:
        share_x = (x - self._x[0]) / (self._x[1] - self._x[0])
        share_y = (y - self._y[0]) / (self._y[1] - self._y[0])
        return _LEFT + share_x * _WIDTH, _TOP + (1 - share_y) * _HEIGHT

    def rule(self, y: float, label: str, *, strong: bool = False) -> None:
        """Draw a level across, with its label at the left."""
        _, place = self._place(self._x[0], y)
        color = "#8a94a6" if strong else "#dde2ea"
        self._parts.append(
            f'<line x1="{_LEFT}" x2="{_LEFT + _WIDTH}" y1="{place:.1f}" y2="{place:.1f}" stroke="{color}"/>'
            f'<text x="{_LEFT - 5}" y="{place + 4:.1f}" text-anchor="end">{html.escape(label)}</text>'
        )

    def line(self, x: np.ndarray, y: np.ndarray, *, ink: str = INK) -> None:
        """Draw a polyline."""
        points = " ".join("{:.1f},{:.1f}".format(*self._place(a, b)) for a, b in zip(x, y, strict=True))
        self._parts.append(f'<polyline points="{points}" fill="none" stroke="{ink}" stroke-width="2"/>')

    def bar(self, x0: float, x1: float, y: float, *, ink: str = INK) -> None:
        """Draw a bar along a level."""
        (left, place), (right, _) = self._place(x0, y), self._place(x1, y)
        # Wide enough to be seen, however short.
        width = max(right - left, 1.5)
        self._parts.append(f'<rect x="{left:.1f}" y="{place - 4:.1f}" width="{width:.1f}" height="8" fill="{ink}"/>')

    def note(self, y: float, text: str) -> None:
        """Write above a level, at its left."""
        _, place = self._place(self._x[0], y)
        self._parts.append(f'<text x="{_LEFT + 4}" y="{place - 8:.1f}">{html.escape(text)}</text>')

    def legend(self, names: Sequence[str]) -> None:
        """Name lines at the top right, each in its colour."""
        shown = " &#160; ".join(
            f'<tspan fill="{ink}">{html.escape(name[:24])}</tspan>' for name, ink in zip(names, INKS, strict=False)
        )
        self._parts.append(f'<text x="{_LEFT + _WIDTH}" y="14" text-anchor="end">{shown}</text>')

    def dot(self, x: float, y: float) -> None:
        """Draw a dot."""
        at_x, at_y = self._place(x, y)
        self._parts.append(f'<circle cx="{at_x:.1f}" cy="{at_y:.1f}" r="4" fill="#1e293b"/>')

    def svg(self) -> str:
        """Return the picture."""
        width, height = _LEFT + _WIDTH + 10, _TOP + _HEIGHT + 24
        return (
            f'<svg xmlns="http://www.w3.org/2000/svg" width="{width}" height="{height}" viewBox="0 0 {width} {height}" '
            f'font-family="sans-serif" font-size="11" fill="#475569" role="img">'
            f'<rect width="{width}" height="{height}" fill="white"/>{"".join(self._parts)}</svg>'
        )
