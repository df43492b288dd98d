"""The paper's search from coarse to fine (§3.3): a path at 5 Hz says where the full rate looks for its own.

The paper takes the coarse path for keytimes, and says that it "eventually performs a pruned search at full resolution".
There are two readings: keytimes that the fine path must meet, or a band around the coarse path that it must not leave.
The second gives away far less (docs/method.md), and is what the option means.
"""

from __future__ import annotations

import bisect
import itertools
import math
from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from retime.arrays import BoolArray, FloatArray, IntArray
from retime.errors import InfeasibleWarpError, OptionError
from retime.search.methods.exact import PathTask
from retime.search.path import FramePath, shortest_path
from retime.search.reduction import Reduction
from retime.search.wishes.feasible import steps_fit

# Analysis rate of the paper's coarse search, Hz.
COARSE_RATE = 5.0
# Steps of the coarse grid by which the fine path may leave the coarse one.
SLACK = 3


def heuristic_path(
    task: PathTask, every: int, coarse_scores: Callable[[IntArray, int], FloatArray], *, slack: int | None = SLACK
) -> tuple[FramePath, float]:
    """Find a path from coarse to fine.

    Parameters
    ----------
    task : PathTask
        What is to be found; its length is given.
    every : int
        About every so many frames belong to the coarse grid.
    coarse_scores : function of (unrolled frames, max_skip)
        Scores the triples of the coarse grid.
    slack : int, optional
        How many steps of the coarse grid the path may be off the coarse one; None: that is keytimes, to be met.

    Returns
    -------
    (FramePath, float)
        The path, and by what share its total exceeds the optimum.

    Raises
    ------
    OptionError
        The length is free.
    InfeasibleWarpError
        There is no path on the coarse grid.
    """
    plan = task.plan
    if not isinstance(plan.n_output, int):
        raise OptionError("the heuristic search needs a given length")
    frames = _coarse_grid(plan.reduction.n_input, every)
    positions = _coarse_grid(plan.n_output, every)
    nearest = [(_nearest(positions, p), _nearest(frames, j)) for p, j in plan.anchors]
    # At 5 Hz a cycle of a walk is a few frames: a longer step than the keytimes need leaps over whole cycles
    # for nothing.
    mean = [(j1 - j0) / max(1, p1 - p0) for (p0, j0), (p1, j1) in itertools.pairwise(nearest)]
    coarse_skip = min(plan.max_skip, max(2, math.ceil(max(mean))))
    try:
        coarse = shortest_path(coarse_scores(frames, coarse_skip), n_output=len(positions), anchors=nearest)
    except InfeasibleWarpError as error:
        rate = plan.reduction.rate / every
        raise InfeasibleWarpError(
            f"the heuristic search, which looks at {rate:g} Hz first, finds no way through these keytimes there: take "
            "search='priced' (--search priced)",
            option="search",
        ) from error
    found = frames[coarse.frames]
    if slack is None:
        keys = list(zip(positions.tolist(), found.tolist(), strict=True))
        path = task.through(_with_feasible(plan.anchors, keys, plan.allowed))
    else:
        path = _within_band(task, positions, found, slack * every)
    best = task.through()
    excess = (path.total - best.total) / best.total if best.total > 0 else 0.0
    return replace(path, lower_bound=best.lower_bound, optimal=path.total <= best.total, search="heuristic"), excess


def _within_band(task: PathTask, positions: IntArray, frames: IntArray, slack: int) -> FramePath:
    """Find the best path that is never farther than `slack` frames from the coarse step that it is beside."""
    n_output, n_input = int(positions[-1]) + 1, task.plan.reduction.n_input
    at = np.arange(n_output)
    before = np.clip(np.searchsorted(positions, at, side="right") - 1, 0, len(positions) - 1)
    after = np.searchsorted(positions, at, side="left")
    while True:
        band = np.stack([frames[before] - slack, frames[after] + slack], axis=1)
        for position, frame in task.plan.anchors:
            band[position] = min(band[position, 0], frame), max(band[position, 1], frame)
        try:
            return task.through(band=band)
        except InfeasibleWarpError:
            # Locks and limits may ask for more than the coarse path knew of.
            if slack >= n_input:
                raise
            slack = max(1, 2 * slack)


def coarse_reduction(reduction: Reduction, frames: IntArray, every: int) -> Reduction:
    """Return what the coarse search is offered: these frames of a reduction, at a lower rate."""
    places = tuple(_nearest(frames, frame) for frame in reduction.frames)
    return replace(reduction, frames=places, input_times=reduction.input_times[frames], rate=reduction.rate / every)


def _coarse_grid(n_frames: int, every: int) -> IntArray:
    """About every so many frames, both ends included."""
    return np.round(np.linspace(0, n_frames - 1, max(2, round((n_frames - 1) / every) + 1))).astype(np.int64)


def _nearest(grid: IntArray, value: int) -> int:
    return int(np.argmin(np.abs(grid - value)))


def _with_feasible(
    anchors: Sequence[tuple[int, int]], more: Sequence[tuple[int, int]], allowed: BoolArray
) -> tuple[tuple[int, int], ...]:
    """Add those anchors that leave a way to their neighbours."""
    merged = sorted(anchors)
    for p, j in more:
        place = bisect.bisect(merged, (p, j))
        if place in (0, len(merged)):
            continue
        (p0, j0), (p1, j1) = merged[place - 1], merged[place]
        if steps_fit(allowed[j0:j], p - p0) and steps_fit(allowed[j:j1], p1 - p):
            merged.insert(place, (p, j))
    return tuple(merged)
