"""When moments of the input are shown: events have a time, not a frame, and go where the warp shows it."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from retime.arrays import FloatArray, as_real
from retime.errors import OptionError
from retime.warp.curve import Warp


def output_moments(warp: Warp, input_times: ArrayLike) -> FloatArray:
    """Return the output time at which each input time is first shown.

    What lies before the warp's first input time or after its last goes on at unit speed, so that nothing is lost: an
    event a second before the start stays a second before it. What a warp never shows in between is put where the
    nearest time is shown.

    Parameters
    ----------
    warp : Warp
        The warp; it may hold and run backward.
    input_times : float array, any shape
        Seconds.

    Examples
    --------
    >>> hold = Warp([0.0, 1.0, 2.0, 3.0], [0.0, 2.0, 2.0, 0.0])
    >>> output_moments(hold, [1.0, 2.0, -0.5]).tolist()
    [0.5, 1.0, -0.5]
    """
    times = as_real(input_times, "the moments", error=OptionError)
    return np.array([_first_shown(warp, float(time)) for time in times.ravel()]).reshape(times.shape)


def _first_shown(warp: Warp, time: float) -> float:
    shown, inputs = warp.output_times, warp.input_times
    start, end = inputs[:-1], inputs[1:]
    crossed = np.flatnonzero((np.minimum(start, end) <= time) & (time <= np.maximum(start, end)))
    if len(crossed):
        piece = int(crossed[0])
        share = 0.0 if start[piece] == end[piece] else (time - start[piece]) / (end[piece] - start[piece])
        return float(shown[piece] + share * (shown[piece + 1] - shown[piece]))
    if time < inputs[0] == inputs.min():
        return float(shown[0] + time - inputs[0])
    if time > inputs[-1] == inputs.max():
        return float(shown[-1] + time - inputs[-1])
    return float(shown[np.argmin(np.abs(inputs - time))])
