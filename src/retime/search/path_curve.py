"""From the frames of a path to a smooth curve that meets every keytime (§3.4)."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike

from retime.arrays import BoolArray, FloatArray, IntArray
from retime.search.reduction import Reduction
from retime.warp.curve import Warp
from retime.warp.knots import add_times


def knots_of_path(
    reduction: Reduction,
    path: IntArray,
    *,
    bounds: tuple[FloatArray, FloatArray] | None = None,
) -> Warp:
    """Turn a frame path into the polyline through its frames, meeting every keytime exactly.

    Ends and keytimes rarely fall on analysis frames. In each span the rest, at most one period, goes to the steps that
    do not play at unit speed anyway, so that what the search kept at unit speed stays there; where there are too few
    of those, to all. None is driven beyond its bounds by that: what it can't take, the others do. (Where locks,
    tangents or limits are asked for, `retime.search.promised_curve` does it.)

    Parameters
    ----------
    reduction : Reduction
        Not free.
    path : int array, shape (n_output,)
        Unrolled frames.
    bounds : (float array, float array), each of shape (n_output - 1,), optional
        The slowest and the fastest that each step may play, without sign (`retime.search.wishes.kept.speed_bounds`).
        Where the mean speed of a span lies beyond them, because its keytimes are a
        fraction of a frame too close for its steps, that mean is the bound.
    """
    output_times: list[FloatArray] = [np.array([reduction.keytimes[0].output_time])]
    input_times: list[FloatArray] = [np.array([reduction.keytimes[0].input_time])]
    period = 1.0 / reduction.rate
    for span in range(len(reduction.keytimes) - 1):
        before, after = reduction.keytimes[span], reduction.keytimes[span + 1]
        first, last = reduction.positions[span], reduction.positions[span + 1]
        steps = np.diff(path[first : last + 1]).astype(np.float64)
        change, length = after.input_time - before.input_time, after.output_time - before.output_time
        held = reduction.still[span]
        moved = steps * (0.0 if held else period / reduction.upsamples[span])
        spacing = np.full(len(steps), period)
        if held:
            moved = np.full(len(steps), abs(change) / len(steps))
        low, high = np.zeros(len(steps)), np.full(len(steps), np.inf)
        if bounds is not None and not held:
            low, high = bounds[0][first:last], bounds[1][first:last]
            mean = abs(change) / length
            low, high = np.minimum(low, mean), np.maximum(high, mean)
        not_unit = steps != reduction.upsamples[span]
        spacing, moved = _stretched(spacing, moved, length, abs(change), not_unit, low, high)
        output_times.append(before.output_time + np.cumsum(spacing))
        input_times.append(before.input_time + math.copysign(1.0, change) * np.cumsum(moved))
        output_times[-1][-1], input_times[-1][-1] = after.output_time, after.input_time
    return Warp(np.concatenate(output_times), np.concatenate(input_times), reduction.keytimes, method="guided")


def _stretched(
    spacing: FloatArray,
    moved: FloatArray,
    output: float,
    change: float,
    not_unit: BoolArray,
    low: FloatArray,
    high: FloatArray,
) -> tuple[FloatArray, FloatArray]:
    """Change the steps so that they add up to given lengths of output and input.

    Those that are not at unit speed change where they need not by more than a quarter; else all, by as much as it
    takes. What can't be done between the bounds is done without the slowest ones, and at last without any.
    """
    every = np.ones(len(spacing), dtype=bool)
    usual = [(not_unit, 0.25), (every, 0.25), (every, 0.75)]
    zero, beyond = np.zeros_like(low), np.full_like(high, np.inf)
    attempts = [(*one, low, high) for one in (*usual, (every, 0.999))]
    attempts += [(*one, zero, limit) for limit in (high, beyond) for one in usual]
    for choice, most, slowest, fastest in attempts:
        pieces = [
            (lengths, total - lengths.sum(), lengths[choice].sum())
            for lengths, total in ((spacing, output), (moved, change))
        ]
        if all(abs(rest) <= most * loose for _, rest, loose in pieces):
            first, second = (
                np.where(choice, lengths * (1 + (rest / loose if loose else 0.0)), lengths)
                for lengths, rest, loose in pieces
            )
            found = bounded(first, second, change, choice, slowest, fastest)
            if found is not None:
                return first, found
    spacing, moved = spacing * (output / spacing.sum()), moved * (change / moved.sum() if change else 0.0)
    # Steps with narrow bounds of their own may leave too little to the others: the widest bounds serve all.
    found = bounded(spacing, moved, change, every, np.full_like(low, low.min()), np.full_like(high, high.max()))
    return spacing, moved if found is None else found


def bounded(
    spacing: FloatArray, moved: FloatArray, change: float, choice: BoolArray, low: FloatArray, high: FloatArray
) -> FloatArray | None:
    """Scale the speeds of chosen steps by one factor, each stopping at its bounds: the moves then add up to `change`.

    None where even all of them at their bounds don't add up to it. Moves that add up and lie between their bounds come
    back as they are.
    """
    least, most = low[choice] * spacing[choice], high[choice] * spacing[choice]
    some = moved[choice]
    if not (some > 0).all() or bool(((some >= least) & (some <= most)).all()):
        return moved
    wanted = change - moved[~choice].sum()
    near = 1e-12 * change
    if not least.sum() - near <= wanted <= most.sum() + near:
        return None
    # The sum grows with the factor, straight between the factors at which a step meets a bound.
    corners = np.unique(np.concatenate([least / some, most / some]))

    def total(factor: float) -> float:
        return float(np.clip(factor * some, least, most).sum())

    first, last = 0, len(corners) - 1
    while last - first > 1:
        middle = (first + last) // 2
        first, last = (middle, last) if total(corners[middle]) <= wanted else (first, middle)
    a, b = float(corners[first]), float(corners[last])
    rise = total(b) - total(a)
    factor = a + (b - a) * (wanted - total(a)) / rise if rise > 0 else a
    result = moved.copy()
    result[choice] = np.clip(factor * some, least, most)
    return result


def smooth_steps(steps: Warp, window: float, rate: float, *, keep: ArrayLike = (), loop: bool = False) -> Warp:
    """Smooth a staircase, with a knot at every output frame of the motion that it will be applied to.

    It stays as it is at the output times `keep`.
    """
    n_knots = steps.count_frames(rate)
    times = np.append(steps.output_start + np.arange(n_knots - 1) / rate, steps.output_end)
    at = add_times(steps.output_times, times) if window == 0 else times
    return steps.smooth(window, at=at, keep=keep, loop=loop)
