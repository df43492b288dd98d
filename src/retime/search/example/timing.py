"""How fast a hand's warp plays each moment of its input."""

from __future__ import annotations

import itertools
import math

import numpy as np
from numpy.typing import ArrayLike

from retime.arrays import FloatArray
from retime.warp.curve import Warp

# Slower is a hold and faster a cut, which no other stretch of a clip should get.
SLOWEST, FASTEST = 1 / 24, 24.0


def hand_log_speeds(hand: Warp, input_times: ArrayLike, window: float) -> FloatArray:
    """Return the logarithm of the speed that a warp gives to moments of its input, shape (n,).

    The speed is input time over output time, within `window` around the moment. What is shown several times (a hold,
    a stretch that runs back) counts as long as it is shown in all: so it plays slowly, in whatever direction.

    Parameters
    ----------
    hand : Warp
        May hold and run backward.
    input_times : float array, shape (n,)
        Seconds. Beyond the input that the warp shows, its first and last moments are meant.
    window : float
        Seconds of input.

    Examples
    --------
    >>> hand_log_speeds(Warp([0.0, 2.0, 3.0], [0.0, 1.0, 3.0]), [0.5, 2.0], 0.1).round(3).tolist()
    [-0.693, 0.693]
    """
    low, high = float(hand.input_times.min()), float(hand.input_times.max())
    half = min(window, high - low) / 2
    middle = np.clip(np.asarray(input_times, dtype=np.float64), low + half, high - half)
    before, after = middle - half, middle + half
    shown = _shown_until(hand, after) - _shown_until(hand, before)
    slowness = np.clip(shown / (2 * half), 1 / FASTEST, 1 / SLOWEST)
    return np.asarray(-np.log(slowness))


def extreme_speeds(log_speeds: FloatArray) -> tuple[float, float]:
    """Return the slowest and the fastest of some speeds; 1 is among them, for what no hand touched."""
    return math.exp(min(0.0, float(log_speeds.min()))), math.exp(max(0.0, float(log_speeds.max())))


def _shown_until(hand: Warp, input_times: FloatArray) -> FloatArray:
    """Seconds of output in which the input up to some times is shown, shape (n,)."""
    signs = np.sign(np.diff(hand.input_times))
    # A hold goes with the run that it interrupts; a warp that begins with one runs on as it does afterwards.
    moving = np.flatnonzero(signs)
    run_of = signs[moving[np.maximum(np.searchsorted(moving, np.arange(len(signs)), side="right") - 1, 0)]]
    edges = [0, *(np.flatnonzero(run_of[1:] != run_of[:-1]) + 1).tolist(), len(run_of)]
    total = np.zeros(len(input_times))
    for first, last in itertools.pairwise(edges):
        inputs = hand.input_times[first : last + 1]
        seconds = hand.output_times[first : last + 1] - hand.output_times[first]
        if run_of[first] < 0:
            inputs, seconds = inputs[::-1], (seconds[-1] - seconds)[::-1]
        total += np.interp(input_times, inputs, seconds)
    return total
