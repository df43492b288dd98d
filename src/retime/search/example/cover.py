"""Which frames an example is made of: its own, and where it is no whole cycle, the rest of one around it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from retime.arrays import FloatArray, IntArray
from retime.brief import brief_repr

# Distances are told in medians of the distances between any two frames of a clip (docs/method.md has the choice).
_ENDS_MEET = 0.55
_CYCLE_RETURNS = 0.6
# A cycle of anything that a person does, seconds: at least so long, and at most.
_SHORTEST_CYCLE = 0.5
_LAGS = (0.4, 2.5)
# Seconds to either side of an example that is no part of a cycle.
_BESIDE = 0.5
# Of an example's frames, those that must have a counterpart a period away.
_COUNTERPARTS = 0.5


@dataclass(frozen=True, eq=False)
class Cover:
    """The frames that an example is made of, at the analysis rate.

    Attributes
    ----------
    first, last : int
        The stretch that was retimed by hand.
    frames : int array, shape (n,)
        Those frames, and the ones that join them at their own speed; in rising order.
    closed : bool
        The stretch ends as it begins: it is a cycle by itself.
    period : int, optional
        Frames of the cycle that was found around it; None where it is closed, and where none was found.
    """

    first: int
    last: int
    frames: IntArray
    closed: bool
    period: int | None

    __repr__ = brief_repr


def cover_of(features: FloatArray, first: int, last: int, *, rate: float, median: float) -> Cover:
    """Find the frames that an example is made of.

    Where its ends meet, it is a cycle: it says of every phase how fast it should play. Else it is a part of one (one
    step of a walk, say), and the rest of the cycle, which nobody retimed, must be told apart from it: that joins at
    its own speed. The period is the first lag at which the example's surroundings come back to it.

    Parameters
    ----------
    features : float array, shape (n_frames, n_numbers)
        Of the clip in which the example lies.
    first, last : int
        The example.
    rate : float
        Frames a second.
    median : float
        The unit of distances.
    """
    n_frames = len(features)
    seconds = (last - first) / rate
    closed = seconds > _SHORTEST_CYCLE and _distance(features[first], features[last]) < _ENDS_MEET * median
    period = None if closed else _period(features, first, last, rate, median)
    if closed:
        before = after = 0
    elif period is None:
        before = after = round(_BESIDE * rate)
    else:
        rest = max(0, period - (last - first))
        # Half on either side; at an end of the clip more on the other one.
        before = min(first, max(rest // 2, rest - (n_frames - 1 - last)))
        after = rest - before
    frames = np.arange(max(0, first - before), min(n_frames - 1, last + after) + 1)
    return Cover(first, last, frames, closed, period)


def _period(features: FloatArray, first: int, last: int, rate: float, median: float) -> int | None:
    """Find the first lag at which the example comes near itself, before it or after it; None where it never does."""
    example = np.arange(first, last + 1)
    lags = np.arange(round(_LAGS[0] * rate), round(_LAGS[1] * rate) + 1)
    means = np.full(len(lags), np.inf)
    for place, lag in enumerate(lags.tolist()):
        sides = np.full((2, len(example)), np.inf)
        for side, sign in enumerate((-1, 1)):
            there = example + sign * lag
            inside = (there >= 0) & (there < len(features))
            sides[side, inside] = np.sqrt(np.sum((features[example[inside]] - features[there[inside]]) ** 2, axis=1))
        nearest = sides.min(axis=0)
        known = np.isfinite(nearest)
        if known.sum() >= max(1.0, _COUNTERPARTS * len(example)):
            means[place] = float(np.mean(nearest[known]))
    inner = np.arange(1, len(lags) - 1)
    low = (means[inner] <= means[inner - 1]) & (means[inner] <= means[inner + 1])
    found = inner[low & (means[inner] < _CYCLE_RETURNS * median)]
    return int(lags[found[0]]) if len(found) else None


def _distance(one: FloatArray, other: FloatArray) -> float:
    return float(np.sqrt(np.sum((one - other) ** 2)))
