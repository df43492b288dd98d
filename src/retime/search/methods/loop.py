"""The best path of a cycle: its first and its last step agree, and the triple across the seam costs too."""

from __future__ import annotations

import contextlib
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
    """Search once for each first step, which the last one must equal.

    Parameters
    ----------
    task : PathTask
        What is to be found.
    seam : float array, shape (n_steps,)
        What the triple across the seam costs, for each step.

    Raises
    ------
    InfeasibleWarpError
        No path begins and ends with the same step.
    """
    start, end = task.ends
    found: list[FramePath] = []
    for step in np.flatnonzero(np.isfinite(start + end + seam)).tolist():
        only, seamed = np.full((2, len(seam)), np.inf)
        only[step], seamed[step] = start[step], seam[step]
        # Some of these searches find no path; only if none finds one is there no loop.
        with contextlib.suppress(InfeasibleWarpError):
            found.append(task.through(start_cost=only, end_cost=seamed))
    if not found:
        raise InfeasibleWarpError(
            "no path begins and ends at one speed between these keytimes: loosen a lock, a tangent or a speed "
            "limit, or give the output a frame more"
        )
    best = min(found, key=lambda path: path.total)
    return replace(best, lower_bound=min(path.lower_bound for path in found))
