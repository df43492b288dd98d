"""Flights: when a figure falls freely and touches nothing, as in jumps, hops, leaps and runs."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike

from retime.arrays import BoolArray, FloatArray
from retime.motion.body import body_of
from retime.motion.contacts import contacts, lowest_around, runs
from retime.motion.kinematics import GRAVITY, global_places, metres_per_unit
from retime.motion.moving import Moving

# Seconds to either side in which the ground is looked for: captured floors are not level, and stairs are not one floor.
_GROUND_WINDOW = 0.75
# Metres above that ground below which something touches it, as well as captures can tell.
_TOUCH = 0.02
# Metres above it from which a foot at rest stands on nothing: in the middle of a leap a foot may hang still.
_HANGING = 0.1
# Accelerations are second differences over these times to either side. A twentieth of a second is longer than the jerks
# of arms and legs, a thirtieth shorter than the flights of a run; either may show a fall.
_LAGS = (1 / 20, 1 / 30)
# Of gravity: what falls faster than this falls freely. The mean of the joints is not the centre of mass.
_FREE = 0.5
# Of gravity, upward: beyond this the ground pushes, though a foot has begun to lift.
_PUSHED = 0.25
# Seconds by which a fall is seen too late and given up too early, since accelerations are taken over some time.
_HIDDEN = 0.06
# Seconds from which a flight is long enough to tell from a leg that is kicked up and comes down.
_LONG = 0.2
# Falls of fewer seconds than this are noise.
_LEAST_FALL = 0.02


def flights(motion: Moving, *, clearance: float = 0.03, minimum: float = 0.06) -> list[tuple[int, int]]:
    """Find the flights of jumps, hops, leaps and runs: stretches in which the body falls freely and touches nothing.

    Where nothing touches the ground, and the mean height of the joints accelerates downward at more than half of
    gravity, a figure flies; from there a flight is followed to both sides for the moments in which a fall can't be told
    yet, as long as nothing touches the ground, and the ground does not push. Something touches the ground where it is
    within 2 cm of the lowest that anything gets within three quarters of a second, or where a foot stands (see
    `retime.motion.contacts`). Falls less than six hundredths of a second apart are one flight: arms and legs that swing
    may hide a fall for a moment, and no foot steps so fast. In a flight of a fifth of a second or more most of the
    joints fall, not only their mean: who kicks a leg up high stands on the other.

    Parameters
    ----------
    motion : Motion
        Y up; `metres_per_unit` gives its size.
    clearance : float
        Metres above the ground that everything gets, at least, at some moment of a flight.
    minimum : float
        Shortest flight, seconds.

    Returns
    -------
    list of (int, int)
        First and last frame of each flight, counted from 0.

    Examples
    --------
    >>> import retime
    >>> flights(retime.sample())
    [(367, 392), (670, 700)]
    """
    motion = body_of(motion)
    rate = float(motion.rate)
    poses = global_places(motion)
    scale = metres_per_unit(motion)
    heights = np.concatenate([poses.positions[:, :, 1], poses.end_positions[:, :, 1]], axis=1) * scale
    lowest = heights.min(axis=1)
    clear = lowest - lowest_around(lowest, max(1, round(_GROUND_WINDOW * rate)))
    # In order of height: a sum is then the same to the last bit whatever order a file lists its joints in.
    mean = np.sort(poses.positions[:, :, 1], axis=1).mean(axis=1) * scale
    lags = [max(1, round(lag * rate)) for lag in _LAGS]
    if motion.n_frames <= max(lags):
        return []
    slow, fast = (_accelerations(mean, lag, rate) for lag in lags)
    stands = contacts(motion).at_rest.any(axis=1)
    off = (clear > _TOUCH) & ~(stands & (clear < _HANGING))
    falls = off & (np.minimum(slow, fast) < -_FREE * GRAVITY)
    free = off & (fast < _PUSHED * GRAVITY)
    hidden = round(_HIDDEN * rate)
    found = []
    for start, stop in runs(off):
        joined: list[list[int]] = []
        for first, end in runs(falls[start:stop]):
            if end - first < max(1.0, _LEAST_FALL * rate):
                continue
            a, b = _grown(free, start + first, start + end, hidden, start, stop)
            if joined and a - joined[-1][1] <= hidden:
                joined[-1][1] = b
            else:
                joined.append([a, b])
        found += [
            (a, b - 1)
            for a, b in joined
            if b - a >= max(2.0, minimum * rate)
            and clear[a:b].max() > clearance
            and 2 * falls[a:b].sum() >= b - a
            and (b - a < max(4.0, _LONG * rate) or _most_fall(poses.positions[a:b, :, 1] * scale, rate))
        ]
    return found


def _accelerations(heights: FloatArray, lag: int, rate: float) -> FloatArray:
    """Second differences over `lag` frames to either side, per second squared."""
    padded = np.pad(heights, lag, mode="reflect", reflect_type="odd")
    return np.asarray((padded[2 * lag :] - 2 * padded[lag:-lag] + padded[: -2 * lag]) * (rate / lag) ** 2)


def _most_fall(heights: FloatArray, rate: float) -> bool:
    """Tell from their parabolas whether half of the joints fall freely; heights (n_frames, n_joints), metres."""
    # The least squares of a parabola, whose bend is all that is asked for: of evenly spaced times it is a sum alone.
    times = (np.arange(len(heights)) - (len(heights) - 1) / 2) / rate
    bends = times**2 - np.mean(times**2)
    parabolas = np.einsum("f,fj->j", bends, heights) / np.sum(bends**2)
    return bool(np.median(2 * parabolas) < -_FREE * GRAVITY)


def _grown(free: BoolArray, first: int, stop: int, most: int, start: int, end: int) -> tuple[int, int]:
    """Widen frames first ... stop - 1 within start ... end - 1, by `most` frames to either side while they are free."""
    low, high = first, stop
    while low > start and first - low < most and free[low - 1]:
        low -= 1
    while high < end and high - stop < most and free[high]:
        high += 1
    return low, high


def corrected_flights(
    found: Sequence[tuple[float, float]],
    *,
    flown: Sequence[tuple[float, float]] = (),
    grounded: Sequence[tuple[float, float]] = (),
) -> list[tuple[float, float]]:
    """Put right the flights that were found, by what a person says of some stretches.

    Parameters
    ----------
    found : sequence of (float, float)
        Start and end of each flight that was found, seconds.
    flown : sequence of (float, float)
        Stretches that are flights. Each stands in the place of every found one that it touches: so the ends of a flight
        are moved.
    grounded : sequence of (float, float)
        Stretches in which nothing flies, but for what `flown` names: what was found there is cut away.

    Returns
    -------
    list of (float, float)
        In the order of time.

    Examples
    --------
    >>> corrected_flights([(1.0, 1.5), (3.0, 3.5), (5.0, 5.5)], flown=[(1.1, 1.4)], grounded=[(2.9, 3.2), (5.0, 5.5)])
    [(1.1, 1.4), (3.2, 3.5)]
    """
    left = [(a, b) for a, b in found if all(b < start or a > end for start, end in flown)]
    for start, end in grounded:
        left = [part for a, b in left for part in ((a, min(b, start)), (max(a, end), b)) if part[1] > part[0]]
    return sorted([*left, *((float(start), float(end)) for start, end in flown)])


def within(times: ArrayLike, spans: Sequence[tuple[float, float]], *, margin: float = 0.0) -> BoolArray:
    """Tell which times lie in one of some stretches, ends included.

    Parameters
    ----------
    times : float array, shape (n,)
        Seconds.
    spans : sequence of (float, float)
        Start and end of each stretch, seconds, in any order.
    margin : float
        Seconds that each is widened by, to both sides.

    Returns
    -------
    bool array, shape (n,)

    Examples
    --------
    >>> within([0.0, 0.5, 1.0, 1.5], [(0.6, 1.0)], margin=0.1).tolist()
    [False, True, True, False]
    """
    asked = np.asarray(times, dtype=np.float64)
    # Times and spans are often both made of frames: a rounding must not put a frame outside.
    slack = margin + 1e-9
    starts, ends = np.array(spans, dtype=np.float64).reshape(-1, 2).T
    starts, ends = starts - slack, ends + slack
    some = starts <= ends
    # A long take has hundreds of flights: rather than look at each, count those that have begun, and those over.
    begun = np.searchsorted(np.sort(starts[some]), asked, side="right")
    over = np.searchsorted(np.sort(ends[some]), asked, side="left")
    return np.asarray(begun > over)
