"""How fast a warp plays, and how fast joints move."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from retime.arrays import FloatArray
from retime.evaluate.metrics import ANALYSIS_RATE
from retime.motion.kinematics import global_poses, metres_per_unit
from retime.motion.motion import Motion
from retime.warp.curve import Warp

SPEED_QUANTILES = (0.5, 0.9, 0.99)


def fastest_speed(warp: Warp, *, rate: float = ANALYSIS_RATE) -> float:
    """Return the most input that a warp shows in one analysis period, as a speed: how much of the content is rushed.

    The paper forbids to go past `max_skip` (§3.1): a cut has no such bound.

    Examples
    --------
    >>> round(fastest_speed(Warp([0.0, 1.0, 1.1, 2.0], [0.0, 1.0, 4.0, 5.0])), 2)
    30.0
    """
    starts = np.unique(np.concatenate([warp.output_times, warp.output_times - 1 / rate]))
    starts = starts[(starts >= warp.output_start) & (starts <= warp.output_end - 1 / rate)]
    if not len(starts):
        return float(abs(warp.input_times[-1] - warp.input_times[0]) / warp.output_span)
    return float(np.max(np.abs(warp(starts + 1 / rate) - warp(starts)))) * rate


def joint_speeds(motion: Motion, joints: Sequence[str], *, rate: float = ANALYSIS_RATE) -> FloatArray:
    """Speeds of some joints over the ground, between neighbouring analysis frames, all in one row; metres a second."""
    times = np.arange(math.floor(motion.end_time * rate + 1e-6) + 1) / rate
    places = [motion.skeleton.index(name) for name in joints]
    positions = global_poses(motion.at(times)).positions[:, places] * metres_per_unit(motion)
    return np.asarray(np.linalg.norm(np.diff(positions, axis=0), axis=-1).ravel() * rate)


@dataclass(frozen=True)
class SpeedMatch:
    """How one distribution of speeds compares with another.

    Attributes
    ----------
    quantiles : tuple of float
        The 50th, 90th and 99th percentile, metres a second.
    wanted : tuple of float
        The same of the distribution that is wanted.
    distance : float
        By how many metres a second a speed must change, on average, to make one distribution the other (Wasserstein).
    """

    quantiles: tuple[float, ...]
    wanted: tuple[float, ...]
    distance: float


def match_speeds(speeds: ArrayLike, wanted: ArrayLike) -> SpeedMatch:
    """Compare speeds with those that are wanted.

    Examples
    --------
    >>> match_speeds([1.0, 2.0, 3.0], [2.0, 3.0, 4.0]).distance
    1.0
    """
    a, b = np.sort(np.asarray(speeds, dtype=np.float64)), np.sort(np.asarray(wanted, dtype=np.float64))
    # The area between the two distribution functions.
    together = np.sort(np.concatenate([a, b]))
    shares = [np.searchsorted(one, together[:-1], side="right") / len(one) for one in (a, b)]
    distance = float(np.sum(np.abs(shares[0] - shares[1]) * np.diff(together)))
    found = [tuple(float(q) for q in np.quantile(one, SPEED_QUANTILES)) for one in (a, b)]
    return SpeedMatch(found[0], found[1], distance)


def speed_contrast(speeds: ArrayLike) -> float:
    """Return the 99th percentile of speeds over their mean: how much blows stand out from what lies between them.

    No change of a whole clip's speed changes it; 1 where nothing moves.

    Examples
    --------
    >>> speed_contrast([1.0, 1.0, 1.0]), speed_contrast([0.0, 0.0])
    (1.0, 1.0)
    """
    values = np.asarray(speeds, dtype=np.float64)
    mean = float(values.mean())
    return float(np.quantile(values, 0.99)) / mean if mean > 0 else 1.0
