"""The warp's operations by definition: linear scans, bisection, numerical integration."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Sequence

import numpy as np


def evaluate(output_times: Sequence[float], input_times: Sequence[float], time: float) -> float:
    """Read the polyline at one output time; held at the ends outside."""
    if time <= output_times[0]:
        return input_times[0]
    if time >= output_times[-1]:
        return input_times[-1]
    piece = 0
    while output_times[piece + 1] < time:
        piece += 1
    share = (time - output_times[piece]) / (output_times[piece + 1] - output_times[piece])
    return input_times[piece] * (1 - share) + input_times[piece + 1] * share


def speed(output_times: Sequence[float], input_times: Sequence[float], time: float) -> float:
    """Slope of the piece that holds a time; at a knot, of the piece after it."""
    last = len(output_times) - 2
    piece = 0
    while piece < last and output_times[piece + 1] <= time:
        piece += 1
    rise = input_times[piece + 1] - input_times[piece]
    return rise / (output_times[piece + 1] - output_times[piece])


def inverse_at(output_times: Sequence[float], input_times: Sequence[float], input_time: float) -> float:
    """Find by bisection the output time that shows an input time, for a warp that only plays forward."""
    low, high = output_times[0], output_times[-1]
    for _ in range(200):
        middle = (low + high) / 2
        if evaluate(output_times, input_times, middle) < input_time:
            low = middle
        else:
            high = middle
    return (low + high) / 2


def integral(function: Callable[[float], float], low: float, high: float, corners: Sequence[float] = ()) -> float:
    """Integrate by Simpson's rule between the corners: exact up to rounding where the pieces are cubic at most."""
    inside = sorted({low, high, *(float(corner) for corner in corners if low < corner < high)})
    area = 0.0
    for a, b in itertools.pairwise(inside):
        area += (b - a) / 6 * (function(a) + 4 * function((a + b) / 2) + function(b))
    return area


def moving_average(
    output_times: Sequence[float], input_times: Sequence[float], keytimes: Sequence[float], window: float, time: float
) -> float:
    """Average a warp around one output time.

    The warp goes on beyond its ends by point reflection. The window is no wider than the warp, and reaches no keytime.
    """
    start, end = output_times[0], output_times[-1]

    def continued(t: float) -> float:
        if t < start:
            return 2 * input_times[0] - evaluate(output_times, input_times, 2 * start - t)
        if t > end:
            return 2 * input_times[-1] - evaluate(output_times, input_times, 2 * end - t)
        return evaluate(output_times, input_times, t)

    half = min([window / 2, (end - start) / 2, *(abs(time - key) for key in keytimes if start < key < end)])
    if half < 1e-12 or time in (start, end):
        return continued(time)
    corners = [*output_times, *(2 * start - t for t in output_times), *(2 * end - t for t in output_times)]
    low, high = time - half, time + half
    return integral(continued, low, high, corners) / (high - low)


def window_mean(values: np.ndarray, low: float, high: float) -> np.ndarray:
    """Mean over [low, high] (in frames) of the polyline through a column's values, for each column."""
    frames = list(range(len(values)))
    return np.array(
        [
            integral(lambda t, c=column: evaluate(frames, c, t), low, high, frames) / (high - low)  # type: ignore[misc]
            for column in values.T.tolist()
        ]
    )
