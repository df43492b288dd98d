"""Natural hurry: a price on tempo. What moves is hurried evenly, pauses give way first, jumps keep their speed.

Eq. 2 alone is about linear in the number of output frames that a stretch gets, so all of a change lands on the few
cheapest stretches and the rest stays as it is (docs/method.md). The price here is strictly convex in the speed, is
nothing where nothing moves, and has a kink at unit speed in flight. It is charged on every step, by the step alone: the
search stays exact.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from retime.arrays import FloatArray
from retime.brief import brief_repr
from retime.kernels import StepPairs
from retime.motion.any_motion import AnyMotion
from retime.motion.body import is_rigid
from retime.motion.flights import within
from retime.motion.motion import Motion
from retime.search.reduction import Reduction

# Seconds over which movement is averaged: longer than the sway of standing, shorter than half a stride.
_WINDOW = 0.3
# Of the clip's own movement (root mean square): what moves at this share of it is half way between idle and moving.
_IDLE = 0.3
# Weights of the price on tempo, by docs/study: how evenly moving parts share a hurry, for a figure that moves like
# itself and for one that moves like another; and how strongly flights keep their own speed.
_EVENNESS, _EVENNESS_OF_ANOTHER, _KEEP_FLIGHTS = 4.0, 0.1, 24.0


@dataclass(frozen=True, eq=False)
class Tempo:
    """How much an input moves over its time, and when it flies.

    Attributes
    ----------
    rate : float
        Samples a second; the first one stands at input time 0.
    activity : float array, shape (n_samples,)
        0 where it is idle, 1 where it moves as it mostly does, at most 1.09.
    scale : float
        The clip's movement, root mean square, in pose units: what prices are measured in.
    flights : tuple of (float, float)
        Input times between which it flies, seconds.
    """

    rate: float
    activity: FloatArray
    scale: float
    flights: tuple[tuple[float, float], ...]

    __repr__ = brief_repr

    def activity_at(self, input_times: FloatArray) -> FloatArray:
        """Read the activity at input times (seconds), shape (n,)."""
        return np.interp(input_times * self.rate, np.arange(len(self.activity)), self.activity)

    def flying(self, input_times: FloatArray) -> FloatArray:
        """Say at which input times it flies, 1 or 0; one analysis frame to either side counts as flight too."""
        return within(input_times, self.flights, margin=1 / self.rate).astype(np.float64)


def chosen_weights(
    clips: Sequence[AnyMotion], evenness: float | None, keep_flights: float | None, *, itself: bool, paper: bool
) -> tuple[float, float]:
    """Choose the weights of the price on tempo, evenness and keep_flights, where they are left out.

    Parameters
    ----------
    clips : sequence of Motion or Signal
        The input.
    evenness, keep_flights : float, optional
        Those that were given.
    itself : bool
        Whether the input is its own reference.
    paper : bool
        Whether the search is that of the paper, which has no such price.
    """
    figure = not paper and any(isinstance(clip, Motion) and not is_rigid(clip) for clip in clips)
    usual = (_EVENNESS, _KEEP_FLIGHTS) if itself else (_EVENNESS_OF_ANOTHER, 0.0)
    return tuple(  # type: ignore[return-value]
        (default if figure else 0.0) if given is None else given
        for given, default in zip((evenness, keep_flights), usual, strict=True)
    )


def flights_of(clips: Sequence[AnyMotion]) -> list[tuple[float, float]]:
    """Find the flights of clips that move together: start and end of each, seconds, in the order of time."""
    return sorted(
        (first / float(clip.rate), last / float(clip.rate))
        for clip in clips
        if isinstance(clip, Motion)
        for first, last in clip.flights()
    )


def tempo_of(poses: FloatArray, rate: float, time_scale: float, flights: Sequence[tuple[float, float]]) -> Tempo:
    """Measure how much a motion moves.

    Parameters
    ----------
    poses : float array, shape (n_frames, n_numbers)
        Pose vectors of the input at the analysis rate.
    rate : float
        Analysis rate, Hz.
    time_scale : float
        τ, seconds.
    flights : sequence of (float, float)
        Input times between which it flies.

    Examples
    --------
    Two seconds of standing, two of moving evenly:

    >>> poses = np.concatenate([np.zeros(60), np.arange(60.0)])[:, None]
    >>> tempo_of(poses, 30.0, 0.2, []).activity[[10, 100]].round(2).tolist()
    [0.0, 1.04]
    """
    last = len(poses) - 1
    frames = np.arange(len(poses))
    before, after = np.maximum(frames - 1, 0), np.minimum(frames + 1, last)
    change = poses[after] - poses[before]
    seconds = np.maximum(after - before, 1) / rate
    movement = time_scale * np.sqrt(np.einsum("fn,fn->f", change, change)) / seconds
    movement = _averaged(movement, max(1, round(_WINDOW * rate)))
    scale = math.sqrt(math.fsum(movement * movement) / len(movement))
    squares = movement * movement
    idle = (_IDLE * scale) ** 2
    activity = (1 + _IDLE**2) * squares / (squares + idle) if scale > 0 else np.zeros(len(poses))
    return Tempo(rate, activity, scale, tuple((float(start), float(end)) for start, end in flights))


def _averaged(values: FloatArray, width: int) -> FloatArray:
    """Average over a Hann window of some frames; values go on at the ends as they are there."""
    # One sample after the other: a convolution of NumPy's sums in an order that depends on the machine.
    weights = np.sin(np.pi * np.arange(1, width + 1) / (width + 1)) ** 2
    reach = width // 2
    padded = np.concatenate([np.full(reach, values[0]), values, np.full(width - 1 - reach, values[-1])])
    total = np.zeros(len(values))
    for i, weight in enumerate(weights / math.fsum(weights)):
        total += weight * padded[i : i + len(values)]
    return total


def tempo_prices(
    tempo: Tempo, reduction: Reduction, steps: StepPairs, *, evenness: float, keep_flights: float
) -> FloatArray:
    """Return what each step costs where it begins, shape (n_input, n_steps).

    The step from frame j to j + b plays at the speed v = b / upsample, and costs::

        r max(1, v) [ W A ln² v + K F |ln v| ]

    W is the evenness and K the weight of flights, r the clip's scale; A and F are the activity and the flying of
    frames j ... j + b, averaged. The factor max(1, v) keeps the price convex in what an *input* frame pays. A hold
    costs nothing: stopping is a keytime's wish.
    """
    n_input = reduction.n_input
    activity = _sums(tempo.activity_at(reduction.input_times))
    flying = _sums(tempo.flying(reduction.input_times))
    prices = np.zeros((n_input, steps.n_steps))
    upsample_at = reduction.upsample_at
    for place, step in enumerate(steps.steps.tolist()):
        if step >= n_input:
            continue
        starts = slice(0, n_input - step)
        logs = np.log(step / upsample_at[starts])
        moving = (activity[step + 1 :] - activity[: n_input - step]) / (step + 1)
        aloft = (flying[step + 1 :] - flying[: n_input - step]) / (step + 1)
        fast = np.maximum(1.0, step / upsample_at[starts])
        prices[starts, place] = fast * (evenness * moving * logs**2 + keep_flights * aloft * np.abs(logs))
    prices *= tempo.scale
    prices[reduction.held] = 0.0
    return prices


def _sums(values: FloatArray) -> FloatArray:
    """Add up the first 0, 1, ... values, shape (n + 1,)."""
    return np.concatenate([[0.0], np.cumsum(values)])
