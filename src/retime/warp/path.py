"""The constrained shortest path through pairs of input frames (§3.3)."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from retime.errors import InfeasibleWarpError, OptionError
from retime.kernels import Backend, FloatArray, IntArray, PathProblem, backend

SEARCHES = ("priced", "layered")
# Bytes: of back-pointers that the layered recurrence holds at once, of labels that the priced search may carry.
MEMORY_LIMIT = 192 << 20


@dataclass(frozen=True, eq=False)
class FramePath:
    """The input frames that the output shows, one after another.

    Attributes
    ----------
    frames : int array, shape (n_output,)
        Strictly increasing input frames.
    scores : float array, shape (n_output - 2,)
        The local score of each inner frame.
    total : float
        Their sum, added from the first to the last (Eq. 1), and the costs of the first and last step where given.
    lower_bound : float
        No path that meets the same anchors can total less; found by other means than the path.
    optimal : bool
        Whether the total is proved to be the least.
    search : str
        How it was found: "priced", "layered" or "free".
    """

    frames: IntArray
    scores: FloatArray
    total: float
    lower_bound: float
    optimal: bool
    search: str


def shortest_path(
    scores: FloatArray,
    *,
    n_output: int | tuple[int, int] | None = None,
    anchors: Sequence[tuple[int, int]] = (),
    start_cost: FloatArray | None = None,
    end_cost: FloatArray | None = None,
    search: str = "priced",
    use: Backend | None = None,
    memory_limit: int = MEMORY_LIMIT,
) -> FramePath:
    """Select the input frames whose warp has the lowest total score (§3.3, Eq. 3 and 4), exactly.

    Ties go to the smaller skip, read back from the end: among all best paths this is the shortest, then the one
    whose last step is smallest, then the step before it, and so on.

    Parameters
    ----------
    scores : float array, shape (n_input, max_skip, max_skip)
        ``scores[j, a - 1, b - 1]`` is the local score (Eq. 2) of frames j - a, j, j + b, in feature units; ``inf``
        forbids the triple. Not negative where the length is free. From `retime.warp.score`.
    n_output : int or (int, int), optional
        Frames to select, both ends included; or the least and the most of them. Left out, the length is free (§4.2).
    anchors : sequence of (int, int)
        Pairs (output position, input frame) that the path must pass; the ends are added. Where the length is free,
        only the frames count.
    start_cost, end_cost : float arrays, shape (max_skip,), optional
        Added for the first and the last step; ``inf`` forbids it.
    search : {"priced", "layered"}
        Both exact, with the same result: the priced search is nearly linear and falls back to the layered
        recurrence of the paper in its worst case; the recurrence is the yardstick. A backend without the priced
        search uses the recurrence.
    use : Backend, optional
        The kernels to use. Left out: the fastest that is installed.
    memory_limit : int
        Bytes of back-pointers to hold at once; beyond it part of the search is done twice.

    Returns
    -------
    FramePath
        ``total`` is the sum of its n_output - 2 scores.

    Raises
    ------
    InfeasibleWarpError
        No path has `n_output` frames and passes the anchors.
    OptionError
        The scores have the wrong shape or are not numbers.

    Examples
    --------
    >>> rng = np.random.default_rng(1)
    >>> path = shortest_path(rng.random((9, 3, 3)), n_output=5)
    >>> len(path.frames), int(path.frames[0]), int(path.frames[-1]), path.optimal
    (5, 0, 8, True)
    """
    scores = np.ascontiguousarray(scores, dtype=np.float64)
    if scores.ndim != 3 or scores.shape[1] != scores.shape[2] or not 1 <= scores.shape[1] <= 255:
        raise OptionError(f"expected scores of shape (n_input, max_skip <= 255, max_skip), found {scores.shape}")
    if np.isnan(scores).any():
        raise OptionError("the scores hold values that are not numbers (nan)")
    if search not in SEARCHES:
        raise OptionError(f"the search must be one of {', '.join(SEARCHES)}; found {search!r}")
    n_input, max_skip = scores.shape[:2]
    if n_input == 1:
        return FramePath(np.zeros(1, dtype=np.int64), np.zeros(0), 0.0, 0.0, True, search)
    kernels = use or backend()
    start = np.zeros(max_skip) if start_cost is None else np.ascontiguousarray(start_cost, dtype=np.float64)
    end = np.zeros(max_skip) if end_cost is None else np.ascontiguousarray(end_cost, dtype=np.float64)
    if n_output is None:
        frames = np.array(sorted({0, n_input - 1, *(int(j) for _, j in anchors)}), dtype=np.int64)
        found = kernels.free_path(PathProblem(scores, np.arange(len(frames)), frames, 0, start, end))
        return _as_path(found, scores, n_input, max_skip, None, "free")

    least, most = (n_output, n_output) if isinstance(n_output, int) else n_output
    pairs = sorted({(0, 0), (least - 1, n_input - 1), *((int(p), int(j)) for p, j in anchors)})
    check_feasible(pairs, max_skip, last_position_max=most - 1)
    problem = PathProblem(
        scores,
        np.array([p for p, _ in pairs], dtype=np.int64),
        np.array([j for _, j in pairs], dtype=np.int64),
        most - 1,
        start,
        end,
    )
    if search == "priced":
        priced = kernels.priced_path(problem, memory_limit)
        if priced is not None and not priced.gave_up:
            return _as_path(priced.path, scores, n_input, max_skip, priced.lower_bound, "priced")
    found = kernels.layered_path(problem, memory_limit)
    return _as_path(found, scores, n_input, max_skip, None, "layered")


def _as_path(
    found: tuple[IntArray, float] | None,
    scores: FloatArray,
    n_input: int,
    max_skip: int,
    lower_bound: float | None,
    search: str,
) -> FramePath:
    if found is None:
        raise InfeasibleWarpError(
            "every path through the keytimes uses a step that a lock, a tangent or a speed limit forbids: "
            "loosen one of them",
            n_input=n_input,
            max_skip=max_skip,
        )
    frames, total = found
    bound = total if lower_bound is None else min(lower_bound, total)
    return FramePath(frames, path_scores(scores, frames), total, bound, True, search)


def path_scores(scores: FloatArray, path: IntArray) -> FloatArray:
    """Return the score of each inner frame of a path, shape (n_output - 2,); their sum is the objective (Eq. 1)."""
    steps = np.diff(path)
    return np.asarray(scores[path[1:-1], steps[:-1] - 1, steps[1:] - 1])


def check_feasible(anchors: Sequence[tuple[int, int]], max_skip: int, *, last_position_max: int | None = None) -> None:
    """Refuse anchors (position, frame) between which no path fits; raise InfeasibleWarpError.

    ``n_output - 1 <= n_input - 1 <= max_skip (n_output - 1)`` must hold in each span; in the last one for some
    length up to ``last_position_max + 1``.
    """
    for span, ((p0, j0), (p1, j1)) in enumerate(itertools.pairwise(anchors)):
        p1_max = p1 if last_position_max is None or span < len(anchors) - 2 else last_position_max
        n_output, n_input = p1 - p0 + 1, j1 - j0 + 1
        least = -(-(n_input - 1) // max_skip) + 1
        if p1 > p0 and n_output <= n_input and p1_max - p0 + 1 >= least:
            continue
        if p1 <= p0 or n_input < 2:
            raise InfeasibleWarpError(
                f"output positions and input frames of anchors must both increase: ({p0}, {j0}) is followed by "
                f"({p1}, {j1})",
                span=span,
            )
        need = -(-(n_input - 1) // (n_output - 1))
        remedy = (
            f"Use at least {least} frames, or max_skip >= {need}."
            if n_output <= n_input
            else f"Use at most {n_input} frames, or upsample by {-(-(n_output - 1) // (n_input - 1))} or more."
        )
        raise InfeasibleWarpError(
            f"cannot fit input frames {j0}–{j1} into {n_output} output frames: max_skip={max_skip} allows {least} to "
            f"{n_input}. {remedy}",
            span=span,
            n_input=n_input,
            n_output=n_output,
            max_skip=max_skip,
            min_output=least,
            max_output=n_input,
        )
