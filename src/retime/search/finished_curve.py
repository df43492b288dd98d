"""From the path that was found to the warp that is handed on: smoothed, mixed with the spline, its promises checked."""

from __future__ import annotations

import warnings
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from retime.arrays import IntArray
from retime.errors import InfeasibleWarpError, RetimeWarning
from retime.search.mix import mixed_within, spline_within
from retime.search.path import FramePath
from retime.search.path_curve import knots_of_path, smooth_steps
from retime.search.plan import SearchPlan
from retime.search.promised_curve import promised_curve
from retime.search.promises import broken_promises
from retime.search.reduction import Reduction
from retime.search.wishes.asked import Wishes
from retime.search.wishes.kept import speed_bounds
from retime.search.wishes.tempo import Tempo
from retime.warp.blend import as_shares, blend
from retime.warp.curve import Warp
from retime.warp.spline import spline_warp


@dataclass(frozen=True)
class FinishedCurve:
    """A warp, the staircase that it was before smoothing and mixing, and what it could not keep."""

    staircase: Warp
    warp: Warp
    given_up: tuple[str, ...]


def finish_curve(
    plan: SearchPlan,
    reduction: Reduction,
    path: FramePath,
    chosen: dict[str, Any],
    *,
    analysis_rate: float,
    tempo: Tempo | None,
) -> FinishedCurve:
    """Put the path on its keytimes, smooth it, mix it with the spline, and look whether it keeps its promises.

    Parameters
    ----------
    plan : SearchPlan
        What was asked for.
    reduction : Reduction
        The unrolled input, its length found.
    path : FramePath
        The path through it.
    chosen : dict of str to values
        The options of the stage "solve": its ``influence`` and ``smoothing`` (frames at the analysis rate) are used.
    analysis_rate : float
        Hz.
    tempo : Tempo, optional
        Tells where smoothing must not reach across the ends of a flight; left out, flights are not kept.

    Warns
    -----
    RetimeWarning
        As `check_promises`.

    Raises
    ------
    InfeasibleWarpError
        As `check_promises`.
    """
    request = plan.request
    share = as_shares(chosen["influence"], "influence")
    mixed = bool(share.ndim or share != 1.0)
    # A window of one frame averages nothing.
    window = 0.0 if chosen["smoothing"] in (0, 1) else chosen["smoothing"] / analysis_rate
    rate = float(request.motion_rate)
    if not request.wishes.any and not request.loop:
        bounds = speed_bounds(reduction, path.frames, plan.max_skip)
        staircase = knots_of_path(reduction, path.frames, bounds=bounds)
        keep = staircase.output_times[_flight_ends(tempo, reduction, path.frames)]
        warp = smooth_steps(staircase, window, rate, keep=keep)
        if mixed:
            warp = blend(spline_warp(reduction.keytimes, rate=rate), warp, share)
        given_up: tuple[str, ...] = ()
    else:
        promised = promised_curve(
            reduction,
            path.frames,
            request.wishes,
            plan.locked,
            plan.max_skip,
            motion_rate=rate,
            loop=request.loop,
        )
        staircase, given_up = promised.staircase, promised.given_up
        edges = np.array([stretch.end for stretch in promised.stretches])
        flights = promised.position_times[_flight_ends(tempo, reduction, path.frames)]
        warp = smooth_steps(staircase, window, rate, keep=np.concatenate([edges, flights]), loop=request.loop)
        if mixed:
            warp = mixed_within(spline_within(warp, promised.stretches, rate), warp, share, promised.stretches)
    warp = replace(warp, method="guided", keytimes=reduction.keytimes)
    check_promises(warp, request.wishes, loop=request.loop, given_up=given_up)
    return FinishedCurve(staircase, warp, given_up)


def _flight_ends(tempo: Tempo | None, reduction: Reduction, frames: IntArray) -> IntArray:
    """List the places in a path where flights at unit speed begin and end: smoothing must not reach across."""
    if tempo is None or not tempo.flights:
        return np.zeros(0, dtype=np.int64)
    flying = tempo.flying(reduction.input_times[frames]) > 0
    unit = np.diff(frames) == reduction.upsample_at[frames[:-1]]
    aloft = np.concatenate([[False], unit & flying[:-1] & flying[1:], [False]])
    return np.flatnonzero(aloft[1:] != aloft[:-1])


def check_promises(warp: Warp, wishes: Wishes, *, loop: bool, given_up: Sequence[str]) -> None:
    """Look at a result once more before it is handed on; say what it does not keep.

    Warns
    -----
    RetimeWarning
        Something had to be given up, by no more than lengths and times are rounded.

    Raises
    ------
    InfeasibleWarpError
        Something is not kept, and nobody said so.
    """
    broken = broken_promises(
        warp, warp.keytimes, locks=wishes.locks, slowest=wishes.slowest, fastest=wishes.fastest, loop=loop
    )
    unsaid = [one for one in broken if not given_up or one.kind in ("key", "length", "direction")]
    if unsaid:
        raise InfeasibleWarpError(
            f"no curve was found that keeps {'; '.join(map(str, unsaid))}. Loosen one of the wishes there, or move a "
            "keytime",
            output_times=(unsaid[0].start, unsaid[0].end),
        )
    for words in given_up:
        warnings.warn(f"not quite kept {words}", RetimeWarning, stacklevel=4)
