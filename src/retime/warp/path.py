"""The constrained shortest path through pairs of input frames (§3.3)."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from retime.errors import InfeasibleWarpError, OptionError
from retime.kernels import Backend, FloatArray, IntArray, backend
from retime.warp.score import path_scores

_MEMORY_LIMIT = 256 << 20


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
        Their sum, added from the first to the last (Eq. 1).
    lower_bound : float
        No path that meets the same anchors can total less.
    """

    frames: IntArray
    scores: FloatArray
    total: float
    lower_bound: float

    @property
    def optimal(self) -> bool:
        """Whether the total is proved to be the least."""
        return self.total <= self.lower_bound


def shortest_path(
    scores: FloatArray,
    *,
    n_output: int,
    anchors: Sequence[tuple[int, int]] = (),
    use: Backend | None = None,
    memory_limit: int = _MEMORY_LIMIT,
) -> FramePath:
    """Select the input frames whose warp has the lowest total score (§3.3, Eq. 3 and 4), exactly.

    Ties go to the smaller skip, read back from the end: among all best paths this is the one whose last step is
    smallest, then the step before it, and so on.

    Parameters
    ----------
    scores : float array, shape (n_input, max_skip, max_skip)
        ``scores[j, a - 1, b - 1]`` is the local score (Eq. 2) of frames j - a, j, j + b, in feature units; ``inf``
        forbids the triple. From `retime.warp.score`.
    n_output : int
        Frames to select, both ends included; at least 2.
    anchors : sequence of (int, int)
        Pairs (output position, input frame) that the path must pass; the ends are added.
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
    n_input, max_skip = scores.shape[:2]
    pairs = sorted({(0, 0), (n_output - 1, n_input - 1), *((int(p), int(j)) for p, j in anchors)})
    check_feasible(pairs, max_skip)
    if n_input == 1:
        return FramePath(np.zeros(1, dtype=np.int64), np.zeros(0), 0.0, 0.0)
    positions = np.array([p for p, _ in pairs], dtype=np.int64)
    frames = np.array([j for _, j in pairs], dtype=np.int64)
    found = (use or backend()).layered_path(scores, positions, frames, memory_limit)
    if found is None:
        raise InfeasibleWarpError(
            f"every path of {n_output} frames through the anchors uses a forbidden triple",
            n_input=n_input, n_output=n_output, max_skip=max_skip,
        )  # fmt: skip
    path, total = found
    return FramePath(path, path_scores(scores, path), total, total)


def check_feasible(anchors: Sequence[tuple[int, int]], max_skip: int) -> None:
    """Refuse anchors (position, frame) between which no path fits; raise InfeasibleWarpError.

    ``n_output - 1 <= n_input - 1 <= max_skip (n_output - 1)`` must hold in each span.
    """
    for span, ((p0, j0), (p1, j1)) in enumerate(itertools.pairwise(anchors)):
        n_output, n_input = p1 - p0 + 1, j1 - j0 + 1
        least = -(-(n_input - 1) // max_skip) + 1
        if p1 > p0 and n_output <= n_input and n_output >= least:
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
            if n_output < least
            else f"Use at most {n_input} frames, or upsample by {-(-(n_output - 1) // (n_input - 1))} or more."
        )
        raise InfeasibleWarpError(
            f"cannot fit input frames {j0}–{j1} into {n_output} output frames: max_skip={max_skip} allows {least} to "
            f"{n_input}. {remedy}",
            span=span, n_input=n_input, n_output=n_output, max_skip=max_skip, min_output=least, max_output=n_input,
        )  # fmt: skip
