"""The best path of a cycle: its first and its last step agree, and the triple across the seam costs too."""

from __future__ import annotations

import heapq
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from retime.arrays import FloatArray
from retime.errors import InfeasibleWarpError, OptionError
from retime.search.methods.exact import PathTask
from retime.search.path import FramePath
from retime.warp.keytime import Keytime


def check_loop(keytimes: Sequence[Keytime], search: str) -> None:
    """Refuse a loop whose ends can't agree in speed.

    Raises
    ------
    OptionError
        Its ends run in different directions, or have different tangents, or the search can't keep a loop.
    """
    if search == "heuristic":
        raise OptionError(
            "the search from coarse to fine (heuristic) can't keep a loop: take an exact one (priced)", option="search"
        )
    first, last = (np.sign(b.input_time - a.input_time) for a, b in (keytimes[:2], keytimes[-2:]))
    if first != last:
        words = {1.0: "plays forward", 0.0: "holds", -1.0: "runs backward"}
        raise OptionError(
            f"a loop needs the same direction at both ends: it {words[float(first)]} at first and "
            f"{words[float(last)]} at last",
            option="loop",
        )
    speeds = [key.speed for key in (keytimes[0], keytimes[-1])]
    if None not in speeds and speeds[0] != speeds[1]:
        raise OptionError(
            f"a loop has one speed at its seam: found {speeds[0]:g} at first and {speeds[1]:g} at last", option="loop"
        )


def loop_path(task: PathTask, seam: FloatArray) -> FramePath:
    """Find the best path whose first and last step are one.

    A search for paths that begin with any step of a set, and end with any of it, is as long as one for a single step.
    What it finds costs no more than the best loop of the set, so sets are looked at from the cheapest on: one through
    which nothing leads, or which costs more than a loop that is known, is done with; what begins and ends with one
    step is the best loop of its set; else the set is divided between the two steps.

    Parameters
    ----------
    task : PathTask
        What is to be found.
    seam : float array, shape (n_steps,)
        What the triple across the seam costs, for each step.

    Returns
    -------
    FramePath
        Of loops that cost the same, the one with the smaller first step.

    Raises
    ------
    InfeasibleWarpError
        No path begins and ends with the same step.
    """
    start, end = task.ends
    best: tuple[float, int] = (np.inf, -1)
    loop: FramePath | None = None
    bounds: list[float] = []

    def best_within(steps: list[int]) -> FramePath | None:
        ends = np.full((2, len(seam)), np.inf)
        ends[:, steps] = start[steps], end[steps] + seam[steps]
        try:
            return task.through(start_cost=ends[0], end_cost=ends[1])
        except InfeasibleWarpError:
            # Only if there is no path for any step is there no loop.
            return None

    # What a loop of the set costs at least, its smallest step, and the set.
    open_sets = [(-np.inf, 0, np.flatnonzero(np.isfinite(start + end + seam)).tolist())]
    while open_sets:
        least, _, steps = heapq.heappop(open_sets)
        if not steps or (least, steps[0]) > best:
            bounds.append(least)
            continue
        path = best_within(steps)
        if path is None:
            continue
        first, last = np.searchsorted(task.steps.steps, np.diff(path.frames)[[0, -1]]).tolist()
        if first == last:
            bounds.append(path.lower_bound)
            if (path.total, first) < best:
                best, loop = (path.total, first), path
            # A smaller step may do as well.
            parts = [[step for step in steps if step < first]]
        else:
            middle = (steps.index(first) + steps.index(last)) // 2 + 1
            parts = [steps[:middle], steps[middle:]]
        for part in filter(None, parts):
            heapq.heappush(open_sets, (path.total, part[0], part))
    if loop is None:
        raise InfeasibleWarpError(
            "no path begins and ends at one speed between these keytimes: loosen a lock, a tangent or a speed "
            "limit, or give the output a frame more"
        )
    return replace(loop, lower_bound=min(bounds))
