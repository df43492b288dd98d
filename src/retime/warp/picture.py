"""Small pictures of warps for notebooks."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterable

import numpy as np

from retime.arrays import FloatArray
from retime.svg import Panel, side_by_side, thinned

_TICKS = {0.1: "1/10", 0.25: "1/4", 0.5: "1/2", 1.0: "1", 2.0: "2", 4.0: "4", 10.0: "10"}


def warp_html(
    times: FloatArray, inputs: FloatArray, slopes: FloatArray, keytimes: Iterable[tuple[float, float]]
) -> str:
    """Return a picture of a warp: its speed on a log axis from 1/10 to 10, and its time map.

    Parameters
    ----------
    times, inputs : float arrays, shape (n_knots,)
        Output and input times of its knots, seconds.
    slopes : float array, shape (n_knots - 1,)
        Playback speeds between them.
    keytimes : iterable of (float, float)
        Output and input time of each keytime.
    """
    kept = thinned(len(times))
    speed = Panel("playback speed", times[0], times[-1], -1.0, 1.0)
    for value, label in _TICKS.items():
        speed.rule(math.log10(value), label, strong=value == 1.0)
    # A log axis has no place for holds and reversals: they run along its lower edge.
    level = np.log10(np.clip(slopes, 0.1, 10.0))
    pieces = np.unique(np.concatenate([[0], np.flatnonzero(np.abs(np.diff(level)) > 1e-4) + 1, [len(level)]]))
    x, y = [], []
    for first, last in itertools.pairwise(pieces):
        x += [times[first], times[last]]
        y += [level[first], level[first]]
    speed.line(np.array(x), np.array(y))
    low, high = float(inputs.min()), float(inputs.max())
    time_map = Panel("input time (s)", times[0], times[-1], low, high if high > low else low + 1.0)
    for value in (low, high):
        time_map.rule(value, f"{value:.3g}")
    time_map.line(times[kept], inputs[kept])
    for output_time, input_time in keytimes:
        time_map.dot(output_time, input_time)
    return side_by_side(speed.svg(), time_map.svg())
