"""How close a warp comes to the one that is known to be right."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from retime.arrays import FloatArray
from retime.evaluate.metrics import ANALYSIS_RATE, Spans
from retime.warp.curve import Warp

# Speeds beyond these are holds and cuts: their logarithms would drown all others.
_LOG_LIMITS = (1 / 20, 20.0)


@dataclass(frozen=True)
class WarpMatch:
    """How close a warp comes to the one that is known to be right.

    Attributes
    ----------
    mean_error, largest_error : float
        Analysis frames by which poses come too early or too late in the output.
    correlation : float
        Of the logarithms of playback speed, moment by moment of the input; NaN where one of them never changes.
    log_speed_error : float
        Root mean square difference of those logarithms: 0.1 is 10 % too fast or too slow.
    length_ratio : float
        Length of the output over the right one.
    """

    mean_error: float
    largest_error: float
    correlation: float
    log_speed_error: float
    length_ratio: float


def match_warps(
    warp: Warp, truth: Warp, *, rate: float = ANALYSIS_RATE, window: float = 0.1, spans: Spans | None = None
) -> WarpMatch:
    """Compare a warp with the one that is known to be right, at the same moments of the input.

    Parameters
    ----------
    warp, truth : Warp
        Forward warps of one clip; `warp` may hold and cut.
    rate : float
        Analysis rate: input times at which they are compared, and the unit of the errors.
    window : float
        Seconds of input over which a speed is taken.
    spans : sequence of (float, float), optional
        Input times to look at; left out, all. Errors in time are then counted from the start of each span.

    Examples
    --------
    >>> match_warps(Warp([0.0, 2.0], [0.0, 1.0]), Warp([0.0, 1.0], [0.0, 1.0])).largest_error
    30.0
    """
    start, end = float(truth.input_times[0]), float(truth.input_times[-1])
    errors, logs = [], []
    for low, high in [(start, end)] if spans is None else spans:
        times = np.linspace(low, high, max(2, round((high - low) * rate) + 1))
        apart = _times_shown(warp, times) - _times_shown(truth, times)
        errors.append(np.abs(apart - (0.0 if spans is None else apart[0])) * rate)
        a, b = np.maximum(times - window / 2, start), np.minimum(times + window / 2, end)
        logs.append([_log_speeds(one, a, b) for one in (warp, truth)])
    error = np.concatenate(errors)
    found, wanted = np.concatenate([pair[0] for pair in logs]), np.concatenate([pair[1] for pair in logs])
    varies = np.ptp(found) > 1e-9 and np.ptp(wanted) > 1e-9
    return WarpMatch(
        float(error.mean()),
        float(error.max()),
        float(np.corrcoef(found, wanted)[0, 1]) if varies else math.nan,
        float(np.sqrt(np.mean((found - wanted) ** 2))),
        warp.output_span / truth.output_span,
    )


def _times_shown(warp: Warp, input_times: FloatArray) -> FloatArray:
    """Return the output time at which a warp shows each input time; of a hold, its middle."""
    first = np.searchsorted(warp.input_times, input_times, side="left")
    times = np.interp(input_times, warp.input_times, warp.output_times)
    there = first < len(warp.input_times)
    held = np.flatnonzero(there & (warp.input_times[np.minimum(first, len(warp.input_times) - 1)] == input_times))
    last = np.searchsorted(warp.input_times, input_times, side="right") - 1
    times[held] = (warp.output_times[first[held]] + warp.output_times[last[held]]) / 2
    return np.asarray(times)


def _log_speeds(warp: Warp, a: FloatArray, b: FloatArray) -> FloatArray:
    shown = _times_shown(warp, b) - _times_shown(warp, a)
    return np.log(np.clip((b - a) / np.maximum(shown, 1e-9), *_LOG_LIMITS))
