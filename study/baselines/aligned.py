"""Timing carried over by alignment: dynamic time warping."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from retime.arrays import FloatArray
from retime.errors import OptionError
from retime.evaluate.metrics import ANALYSIS_RATE
from retime.motion.motion import Motion
from retime.search.poses.references import Reference, model_poses
from retime.search.poses.spaces import PoseOptions, PoseSpace
from retime.warp.curve import Warp


def align_warp(
    motion: Motion,
    reference: Motion,
    *,
    loop: bool = False,
    features: PoseSpace | PoseOptions | None = None,
    rate: float = ANALYSIS_RATE,
    low_pass: float = 4.0,
) -> Warp:
    """Carry a reference's timing over by dynamic time warping: align poses, then take the reference's clock.

    Parameters
    ----------
    motion : Motion
        The input.
    reference : Motion
        Whose timing is wanted.
    loop : bool
        Align with the reference played over and over, from any frame to any frame. Left out: from its first frame to
        its last.
    features, rate, low_pass
        The poses that are aligned, as the guided search sees them.

    Returns
    -------
    Warp
        One knot for each frame of the reference that was used: the mean of the input frames aligned with it.

    Raises
    ------
    OptionError
        Either of them has fewer than two frames at `rate`.
    """
    tracks = model_poses(motion, [Reference(reference)], features)
    here = tracks.input.at_rate(rate, low_pass)
    there = tracks.references[0].at_rate(rate, low_pass)
    if len(here) < 2 or len(there) < 2:
        raise OptionError(f"an alignment needs two frames of each; found {len(here)} and {len(there)}")
    if loop:
        # A path that never dwells passes each reference frame once a frame: twice that leaves room.
        there = np.tile(there, (2 * -(-len(here) // len(there)) + 1, 1))
    path = align(here, there, anywhere=loop)
    used = np.unique(path[:, 1])
    sums = np.bincount(path[:, 1] - used[0], weights=path[:, 0].astype(np.float64))
    places = sums / np.bincount(path[:, 1] - used[0])
    places[0], places[-1] = 0.0, len(here) - 1
    input_times = np.minimum(places / rate, motion.end_time)
    input_times[-1] = motion.end_time
    return Warp(np.arange(len(used)) / rate, input_times, method="aligned")


def align(here: FloatArray, there: FloatArray, *, anywhere: bool = False) -> np.ndarray:
    """Align two sequences by dynamic time warping (steps in one, the other, or both).

    Parameters
    ----------
    here, there : float array, shape (n, n_numbers) and (m, n_numbers)
        Poses; the cost of a pair is their Euclidean distance.
    anywhere : bool
        Begin and end anywhere in `there`.

    Returns
    -------
    int array, shape (n_pairs, 2)
        Pairs of frames, from the first of `here` to its last.

    Examples
    --------
    >>> align(np.array([[0.0], [1.0], [5.0]]), np.array([[0.0], [5.0], [5.0]])).tolist()
    [[0, 0], [1, 0], [2, 1], [2, 2]]
    """
    squares = np.sum(here**2, axis=1)[:, None] + np.sum(there**2, axis=1) - 2 * here @ there.T
    cost = np.sqrt(np.maximum(squares, 0.0))
    n, m = cost.shape
    total = np.empty((n, m))
    total[0] = cost[0] if anywhere else np.cumsum(cost[0])
    for i in range(1, n):
        above = np.minimum(total[i - 1], np.concatenate([[np.inf], total[i - 1, :-1]]))
        # Along a row: total[j] = cost[j] + min(above[j], total[j - 1]), a running least of sums.
        sums = np.cumsum(cost[i])
        total[i] = sums + np.minimum.accumulate(above - np.concatenate([[0.0], sums[:-1]]))
    i, j = n - 1, int(np.argmin(total[-1])) if anywhere else m - 1
    pairs = [(i, j)]
    while i > 0 or (j > 0 and not anywhere):
        options: list[tuple[float, int, int]] = []
        if i > 0 and j > 0:
            options.append((float(total[i - 1, j - 1]), i - 1, j - 1))
        if i > 0:
            options.append((float(total[i - 1, j]), i - 1, j))
        if j > 0 and (i > 0 or not anywhere):
            options.append((float(total[i, j - 1]), i, j - 1))
        _, i, j = min(options, key=_least)
        pairs.append((i, j))
    return np.array(pairs[::-1], dtype=np.int64)


def _least(option: Sequence[float]) -> float:
    return option[0]
