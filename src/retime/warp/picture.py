"""Small pictures of warps for notebooks: plain SVG, no plotting library."""

from __future__ import annotations

import html
import itertools
import math
from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from retime.warp.curve import Warp

_WIDTH, _HEIGHT, _LEFT, _TOP = 330, 170, 44, 24
_TICKS = {0.1: "1/10", 0.25: "1/4", 0.5: "1/2", 1.0: "1", 2.0: "2", 4.0: "4", 10.0: "10"}


def warp_html(warp: Warp) -> str:
    """Return a picture of a warp: its speed on a log axis from 1/10 to 10, and its time map."""
    times, inputs = warp.output_times, warp.input_times
    kept = _thinned(len(times))
    speed = _Panel("playback speed", times[0], times[-1], -1.0, 1.0)
    for value, label in _TICKS.items():
        speed.rule(math.log10(value), label, strong=value == 1.0)
    slopes = warp.slopes
    # A log axis has no place for holds and reversals: they run along its lower edge.
    level = np.log10(np.clip(slopes, 0.1, 10.0))
    pieces = np.unique(np.concatenate([[0], np.flatnonzero(np.abs(np.diff(level)) > 1e-4) + 1, [len(level)]]))
    x, y = [], []
    for first, last in itertools.pairwise(pieces):
        x += [times[first], times[last]]
        y += [level[first], level[first]]
    speed.line(np.array(x), np.array(y))
    low, high = float(inputs.min()), float(inputs.max())
    time_map = _Panel("input time (s)", times[0], times[-1], low, high if high > low else low + 1.0)
    for value in (low, high):
        time_map.rule(value, f"{value:.3g}")
    time_map.line(times[kept], inputs[kept])
    for key in warp.keytimes:
        time_map.dot(key.output_time, key.input_time)
    return f'<div style="display:flex;gap:16px;flex-wrap:wrap">{speed.svg()}{time_map.svg()}</div>'


def facts_html(facts: Mapping[str, object]) -> str:
    """Return names and values on one line."""
    cells = "".join(
        f'<span style="margin-right:14px"><b>{name}</b> {html.escape(str(value))}</span>'
        for name, value in facts.items()
    )
    return f'<div style="font:12px sans-serif">{cells}</div>'


def _thinned(n_knots: int, most: int = 600) -> np.ndarray:
    return np.unique(np.linspace(0, n_knots - 1, min(n_knots, most)).round().astype(int))


class _Panel:
    """One set of axes."""

    def __init__(self, title: str, x0: float, x1: float, y0: float, y1: float) -> None:
        self._x, self._y = (float(x0), float(x1)), (float(y0), float(y1))
        bottom = _TOP + _HEIGHT
        self._parts = [
            f'<text x="{_LEFT}" y="14" font-weight="bold">{html.escape(title)}</text>',
            f'<text x="{_LEFT}" y="{bottom + 16}">{x0:.3g} s</text>',
            f'<text x="{_LEFT + _WIDTH}" y="{bottom + 16}" text-anchor="end">{x1:.3g} s of output</text>',
        ]

    def _place(self, x: float, y: float) -> tuple[float, float]:
        share_x = (x - self._x[0]) / (self._x[1] - self._x[0])
        share_y = (y - self._y[0]) / (self._y[1] - self._y[0])
        return _LEFT + share_x * _WIDTH, _TOP + (1 - share_y) * _HEIGHT

    def rule(self, y: float, label: str, *, strong: bool = False) -> None:
        _, place = self._place(self._x[0], y)
        color = "#8a94a6" if strong else "#dde2ea"
        self._parts.append(
            f'<line x1="{_LEFT}" x2="{_LEFT + _WIDTH}" y1="{place:.1f}" y2="{place:.1f}" stroke="{color}"/>'
            f'<text x="{_LEFT - 5}" y="{place + 4:.1f}" text-anchor="end">{label}</text>'
        )

    def line(self, x: np.ndarray, y: np.ndarray) -> None:
        points = " ".join("{:.1f},{:.1f}".format(*self._place(a, b)) for a, b in zip(x, y, strict=True))
        self._parts.append(f'<polyline points="{points}" fill="none" stroke="#0f766e" stroke-width="2"/>')

    def dot(self, x: float, y: float) -> None:
        at_x, at_y = self._place(x, y)
        self._parts.append(f'<circle cx="{at_x:.1f}" cy="{at_y:.1f}" r="4" fill="#1e293b"/>')

    def svg(self) -> str:
        width, height = _LEFT + _WIDTH + 10, _TOP + _HEIGHT + 24
        return (
            f'<svg xmlns="http://www.w3.org/2000/svg" width="{width}" height="{height}" viewBox="0 0 {width} {height}" '
            f'font-family="sans-serif" font-size="11" fill="#475569" role="img">'
            f'<rect width="{width}" height="{height}" fill="white"/>{"".join(self._parts)}</svg>'
        )
