"""Which parts of a warp's output show given stretches of the input."""

from __future__ import annotations

import numpy as np

from retime.evaluate.metrics import Spans
from retime.warp.curve import Warp


def output_intervals(warp: Warp, low: float, high: float) -> tuple[tuple[float, float], ...]:
    """Output times during which a warp shows the input between two times.

    More than one interval where the warp comes back to it; none where it never gets there.

    Examples
    --------
    >>> output_intervals(Warp([0.0, 1.0, 3.0], [0.0, 2.0, 4.0]), 1.0, 3.0)
    ((0.5, 2.0),)
    """
    t0, t1 = warp.output_times[:-1], warp.output_times[1:]
    w0, w1 = warp.input_times[:-1], warp.input_times[1:]
    change = w1 - w0
    held = change == 0
    slope = np.where(held, 1.0, change)
    # Shares of each piece at which it crosses the two times; a hold is inside for all of its length or for none.
    ends = np.sort(np.clip([(low - w0) / slope, (high - w0) / slope], 0.0, 1.0), axis=0)
    a = np.where(held, 0.0, ends[0])
    b = np.where(held, ((low <= w0) & (w0 <= high)).astype(float), ends[1])
    starts, stops = t0 + a * (t1 - t0), t0 + b * (t1 - t0)
    merged: list[tuple[float, float]] = []
    for piece in np.flatnonzero(stops > starts):
        start, stop = float(starts[piece]), float(stops[piece])
        if merged and start <= merged[-1][1] + 1e-9:
            merged[-1] = (merged[-1][0], stop)
        else:
            merged.append((start, stop))
    return tuple(merged)


def seconds_shown(warp: Warp, spans: Spans) -> float:
    """Return for how many seconds of output a warp shows some stretches of the input.

    Examples
    --------
    >>> seconds_shown(Warp([0.0, 2.0], [0.0, 4.0]), [(1.0, 2.0)])
    0.5
    """
    return sum(stop - start for span in spans for start, stop in output_intervals(warp, *span))
