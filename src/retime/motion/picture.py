"""Small pictures of motions, signals and contacts for notebooks."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from retime.arrays import FloatArray, IntArray
from retime.svg import INKS, Panel, facts_html, stacked, thinned

_POSES, _CELL, _HEIGHT, _MARGIN = 12, 66, 120, 8
_CHANNELS = len(INKS)


def pictured_frames(n_frames: int) -> IntArray:
    """Choose the frames of a motion that its picture shows, counted from 0."""
    return np.unique(np.linspace(0, n_frames - 1, min(_POSES, n_frames)).round().astype(int))


def poses_html(
    nodes: FloatArray, parents: Sequence[int], times: FloatArray, root: FloatArray, facts: Mapping[str, object]
) -> str:
    """Return poses, seen from beside the way that they go, and facts below them.

    Parameters
    ----------
    nodes : float array, shape (n_poses, n_nodes, 3)
        Joints and end sites, Y up; the root first.
    parents : sequence of int, length n_nodes
        To which node each is joined; below 0 to none.
    times : float array, shape (n_poses,)
        Seconds.
    root : float array, shape (n_frames, 3)
        Where the root goes.
    facts : mapping of str to object
        Names and values.
    """
    # Heights are kept, so that a jump is seen; the way over the ground is not, so that each pose has its own place.
    right = (nodes - nodes[:, :1])[:, :, [0, 2]] @ _way(root[:, [0, 2]])
    height = nodes[:, :, 1] - nodes[:, :, 1].min()
    extent = max(float(height.max()), float(np.ptp(right)) * (_HEIGHT / _CELL), 1e-12)
    scale = (_HEIGHT - 2 * _MARGIN) / extent
    parts = []
    for i, time in enumerate(times):
        x = (i + 0.5) * _CELL + right[i] * scale
        y = _HEIGHT - _MARGIN - height[i] * scale
        bones = "".join(
            f"M{x[parent]:.1f},{y[parent]:.1f}L{x[joint]:.1f},{y[joint]:.1f}"
            for joint, parent in enumerate(parents)
            if parent >= 0
        )
        # A lone joint has no bone; a round end makes it a dot.
        bones = bones or f"M{x[0]:.1f},{y[0]:.1f}h0"
        parts.append(
            f'<path d="{bones}" fill="none" stroke="{INKS[0]}" stroke-width="2" stroke-linecap="round"/>'
            f'<text x="{(i + 0.5) * _CELL:.1f}" y="{_HEIGHT + 12}" text-anchor="middle">'
            f"{time:.2f} s</text>"
        )
    width, tall = len(times) * _CELL, _HEIGHT + 18
    drawn = (
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{width}" height="{tall}" viewBox="0 0 {width} {tall}" '
        f'font-family="sans-serif" font-size="10" fill="#475569" role="img">'
        f'<rect width="{width}" height="{tall}" fill="white"/>{"".join(parts)}</svg>'
    )
    return stacked(drawn, facts_html(facts))


def _way(root: FloatArray) -> FloatArray:
    """Return the direction over the ground (x, z) in which the root goes farthest; x for one that stays."""
    away = root - root[0]
    farthest = away[np.argmax(np.sum(away * away, axis=1))]
    length = float(np.hypot(*farthest))
    return farthest / length if length > 1e-9 else np.array([1.0, 0.0])


def channels_html(values: FloatArray, names: Sequence[str], rate: float, facts: Mapping[str, object]) -> str:
    """Return the first channels of a signal, each scaled to its own range, and facts below them.

    Parameters
    ----------
    values : float array, shape (n_frames, n_channels)
        In whatever units.
    names : sequence of str, length n_channels
        Of the channels.
    rate : float
        Frames a second.
    facts : mapping of str to object
        Names and values.
    """
    times = np.arange(len(values)) / rate
    kept = thinned(len(values))
    panel = Panel("values", 0.0, float(times[-1]), 0.0, 1.0, of="s")
    for channel in range(min(_CHANNELS, len(names))):
        column = values[:, channel]
        # Holes hide nothing of the rest; the line ends before them, and begins again.
        there = np.isfinite(column)
        low = float(column.min(where=there, initial=np.inf))
        high = float(column.max(where=there, initial=-np.inf))
        share = (column - low) / (high - low) if high > low else np.full(len(column), 0.5)
        for run in np.split(kept, np.flatnonzero(np.diff(there[kept])) + 1):
            if there[run[0]]:
                panel.line(times[run], share[run], ink=INKS[channel])
    panel.legend(names[:_CHANNELS])
    drawn = f"; the first {_CHANNELS} are drawn" if len(names) > _CHANNELS else ""
    return stacked(panel.svg(), facts_html({**facts, "channels": f"{len(names)}, each in its own range{drawn}"}))


def contacts_html(feet: Sequence[str], spans: Sequence[tuple[int, int, int]], n_frames: int, rate: float) -> str:
    """Return when each foot stands, as bars over time.

    Parameters
    ----------
    feet : sequence of str
        What each is called.
    spans : sequence of (int, int, int)
        Of each contact the foot, counted from 0, and the first and last frame.
    n_frames : int
        Of the motion.
    rate : float
        Frames a second.
    """
    panel = Panel("feet that stand", 0.0, n_frames / rate, -0.5, max(len(feet), 1) - 0.5, of="s")
    for foot, name in enumerate(feet):
        panel.rule(foot, name)
    for foot, first, last in spans:
        panel.bar(first / rate, (last + 1) / rate, foot, ink=INKS[foot % len(INKS)])
    return stacked(panel.svg(), facts_html({"feet": len(feet), "contacts": len(spans), "frames": n_frames}))
