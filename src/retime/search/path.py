"""The constrained shortest path through pairs of input frames (§3.3)."""

from __future__ import annotations

import itertools
import operator
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Literal, SupportsIndex, get_args

import numpy as np
from numpy.typing import ArrayLike

from retime.arrays import FloatArray, IntArray
from retime.brief import brief_repr
from retime.errors import InfeasibleWarpError, OptionError
from retime.kernels import Backend, PathProblem, StepPairs, backend
from retime.limits import MAX_STEP

PathSearch = Literal["priced", "layered"]
SEARCHES = get_args(PathSearch)
# Bytes that a search may hold at once: back-pointers of the layered recurrence, labels of the priced search.
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

    __repr__ = brief_repr


def shortest_path(
    scores: ArrayLike,
    *,
    steps: StepPairs | None = None,
    n_output: SupportsIndex | Sequence[SupportsIndex] | None = None,
    anchors: Sequence[tuple[SupportsIndex, SupportsIndex]] = (),
    start_cost: ArrayLike | None = None,
    end_cost: ArrayLike | None = None,
    search: str = "priced",
    band: ArrayLike | None = None,
    use: Backend | None = None,
    memory_limit: int = MEMORY_LIMIT,
) -> FramePath:
    """Select the input frames whose warp has the lowest total score (§3.3, Eq. 3 and 4), exactly.

    Of paths with equal totals the shortest wins, then the one whose last step is smallest, then the step before it,
    and so on.

    Parameters
    ----------
    scores : float array, shape (n_input, max_skip, max_skip)
        ``scores[j, a - 1, b - 1]`` is the local score (Eq. 2) of frames j - a, j, j + b, in feature units; ``inf``
        forbids the triple. From `retime.search.score`. With `steps`: shape (n_input, n_pairs), a score for each pair.
    steps : StepPairs, optional
        The steps that the path may take, and which may follow which. Left out: all up to `max_skip`, in any order.
    n_output : int or (int, int), optional
        Frames to select, both ends included; or the least and the most of them. Left out, the length is free (§4.2).
    anchors : sequence of (int, int)
        Pairs (output position, input frame) that the path must pass, both counted from 0; the ends are added. Where
        the length is free, only the frames count.
    start_cost, end_cost : float arrays, shape (max_skip,), or (n_steps,) with `steps`, optional
        Added for the first and the last step; ``inf`` forbids it.
    search : {"priced", "layered"}
        Both exact, with the same result: the priced search is nearly linear and falls back to the layered
        recurrence of the paper in its worst case; the recurrence is the yardstick. A backend without the priced
        search uses the recurrence.
    band : int array, shape (n_output, 2), optional
        For each output position the first and the last frame that may be shown there: the best of the paths within,
        by the layered recurrence. The length is given.
    use : Backend, optional
        The kernels to use. Left out: the fastest that is installed.
    memory_limit : int
        Bytes of back-pointers to hold at once; beyond it part of the search is done twice.

    Returns
    -------
    FramePath
        ``total`` is the sum of its n_output - 2 scores, and of the costs at its ends.

    Raises
    ------
    InfeasibleWarpError
        No path has `n_output` frames and passes the anchors.
    OptionError
        Scores or costs have the wrong shape, are no numbers or ``-inf``; a length or an anchor is no integer.

    Examples
    --------
    >>> rng = np.random.default_rng(1)
    >>> path = shortest_path(rng.random((9, 3, 3)), n_output=5)
    >>> len(path.frames), int(path.frames[0]), int(path.frames[-1]), path.optimal
    (5, 0, 8, True)
    """
    scores, steps = _as_scores(scores, steps)
    if search not in SEARCHES:
        raise OptionError(f"the search must be one of {', '.join(SEARCHES)}; found {search!r}")
    n_input = len(scores)
    lengths = _as_lengths(n_output)
    pairs = _as_anchors(anchors, n_input)
    start, end = _as_costs("start_cost", start_cost, steps), _as_costs("end_cost", end_cost, steps)
    limit = _as_integer("memory_limit", memory_limit)
    if limit < 0:
        raise OptionError(f"memory_limit must not be negative, found {limit}")
    if n_input == 1:
        _check_single_frame(lengths, pairs)
        return FramePath(np.zeros(1, dtype=np.int64), np.zeros(0), 0.0, 0.0, True, search)
    kernels = use or backend()
    if lengths is None:
        frames = np.array(sorted({0, n_input - 1, *(j for _, j in pairs)}), dtype=np.int64)
        found = kernels.free_path(PathProblem(scores, steps, np.arange(len(frames)), frames, 0, start, end))
        return _as_path(found, scores, steps, None, "free")

    pairs, most = _with_ends(pairs, *lengths, n_input, steps)
    within = None if band is None else _as_band(band, lengths)
    problem = PathProblem(
        scores,
        steps,
        np.array([p for p, _ in pairs], dtype=np.int64),
        np.array([j for _, j in pairs], dtype=np.int64),
        most - 1,
        start,
        end,
        within,
    )
    if search == "priced" and within is None:
        priced = kernels.priced_path(problem, limit)
        if priced is not None and not priced.gave_up:
            return _as_path(priced.path, scores, steps, priced.lower_bound, "priced")
    with np.errstate(over="ignore"):
        found = kernels.layered_path(problem, limit)
    return _as_path(found, scores, steps, None, "layered")


def _as_numbers(name: str, values: ArrayLike) -> FloatArray:
    """Real numbers as a contiguous array; anything else is refused."""
    try:
        array = np.asarray(values)
    except ValueError as error:
        raise OptionError(f"{name} must be an array of numbers: {error}") from None
    if array.dtype.kind not in "buif":
        raise OptionError(f"{name} must hold real numbers, found an array of {array.dtype}")
    # Unlike ascontiguousarray this leaves a single number without dimensions.
    return np.asarray(array, dtype=np.float64, order="C")


def _as_scores(scores: ArrayLike, steps: StepPairs | None) -> tuple[FloatArray, StepPairs]:
    """Scores (n_input, n_pairs), and the pairs; anything else is refused."""
    array = _as_numbers("scores", scores)
    if steps is not None:
        if array.ndim != 2 or not len(array) or array.shape[1] != steps.n_pairs:
            raise OptionError(
                f"expected scores of shape (n_input >= 1, {steps.n_pairs}), one for each pair of steps; "
                f"found {array.shape}"
            )
    elif array.ndim != 3 or not len(array) or array.shape[1] != array.shape[2] or not 1 <= array.shape[1] <= MAX_STEP:
        raise OptionError(
            f"expected scores of shape (n_input >= 1, max_skip, max_skip) with max_skip from 1 to {MAX_STEP}, "
            f"found {array.shape}"
        )
    else:
        steps = StepPairs.up_to(array.shape[1])
        array = array.reshape(len(array), -1)
    # The minimum is nan where any score is, so one pass over many megabytes is enough.
    least = array.min()
    if np.isnan(least) or least == -np.inf:
        j, pair = (int(i) for i in np.argwhere(np.isnan(array) | (array == -np.inf))[0])
        raise OptionError(
            f"scores must be numbers, or inf where a triple is forbidden: found {array[j, pair]} for frame {j} "
            f"between a step of {steps.steps[steps.before[pair]]} and one of {steps.steps[steps.after[pair]]}"
        )
    return array, steps


def _as_costs(name: str, costs: ArrayLike | None, steps: StepPairs) -> FloatArray:
    if costs is None:
        return np.zeros(steps.n_steps)
    array = _as_numbers(name, costs)
    if array.shape != (steps.n_steps,):
        upto = "step up to max_skip" if steps.every else "step"
        raise OptionError(f"{name} must have shape ({steps.n_steps},), one cost for each {upto}; found {array.shape}")
    bad = np.flatnonzero(np.isnan(array) | (array == -np.inf))
    if len(bad):
        raise OptionError(
            f"{name} must be numbers, or inf where a step is forbidden: found {array[bad[0]]} for a step of "
            f"{steps.steps[bad[0]]}"
        )
    return array


def _as_band(band: ArrayLike, lengths: tuple[int, int]) -> IntArray:
    array = np.ascontiguousarray(band, dtype=np.int64)
    if lengths[0] != lengths[1] or array.shape != (lengths[0], 2):
        raise OptionError(
            f"a band must have shape (n_output, 2), for a given length; found {array.shape} for {lengths[0]} to "
            f"{lengths[1]} frames"
        )
    return array


def _as_integer(name: str, value: SupportsIndex) -> int:
    try:
        return operator.index(value)
    except TypeError:
        raise OptionError(f"{name} must be an integer, found {value!r}") from None


def _as_lengths(n_output: SupportsIndex | Sequence[SupportsIndex] | None) -> tuple[int, int] | None:
    """Least and most frames of the output; None where its length is free."""
    if n_output is None:
        return None
    try:
        least = most = operator.index(n_output)  # type: ignore[arg-type]
    except TypeError:
        if isinstance(n_output, str) or not isinstance(n_output, Iterable) or len(pair := tuple(n_output)) != 2:
            raise OptionError(
                f"n_output must be an integer, or the least and the most frames; found {n_output!r}"
            ) from None
        least, most = (_as_integer("n_output", n) for n in pair)
    if least > most:
        raise OptionError(f"the least length in n_output, {least}, is more than the most, {most}: swap them")
    return least, most


def _as_anchors(anchors: Sequence[tuple[SupportsIndex, SupportsIndex]], n_input: int) -> list[tuple[int, int]]:
    """Anchors as pairs of integers; those outside the problem are refused."""
    pairs = []
    for anchor in anchors:
        try:
            position, frame = anchor
        except (TypeError, ValueError):
            raise OptionError(f"an anchor is an output position and an input frame, found {anchor!r}") from None
        pair = _as_integer("an anchor's position", position), _as_integer("an anchor's frame", frame)
        if pair[0] < 0 or not 0 <= pair[1] < n_input:
            raise InfeasibleWarpError(
                f"the anchor at output position {pair[0]} and input frame {pair[1]} lies outside: positions begin with "
                f"0, frames go from 0 to {n_input - 1}",
                n_input=n_input,
            )
        pairs.append(pair)
    return sorted(set(pairs))


def _check_single_frame(lengths: tuple[int, int] | None, anchors: Sequence[tuple[int, int]]) -> None:
    """Refuse all but one output frame of one input frame."""
    least, most = lengths or (1, 1)
    if not least <= 1 <= most:
        raise InfeasibleWarpError(
            f"cannot fit a single input frame into {least if least > 1 else most} output frames: it allows 1. "
            "Use n_output=1, or more input frames",
            n_input=1,
            n_output=least if least > 1 else most,
            min_output=1,
            max_output=1,
        )
    if lengths is not None and any(position != 0 for position, _ in anchors):
        raise InfeasibleWarpError(f"a single input frame has no output position {anchors[-1][0]}", n_input=1)


def _with_ends(
    anchors: list[tuple[int, int]], least: int, most: int, n_input: int, steps: StepPairs
) -> tuple[list[tuple[int, int]], int]:
    """Anchors with both ends, and the most frames: lengths that the last anchor rules out are left out of the range."""
    inner = [(p, j) for p, j in anchors if j < n_input - 1]
    position, frame = inner[-1] if inner else (0, 0)
    ahead = n_input - 1 - frame
    # An anchor at the last frame says how long the path is.
    low = max([least, position + -(-ahead // steps.longest) + 1, *(p + 1 for p, j in anchors if j == n_input - 1)])
    high = min([most, position + ahead // steps.shortest + 1, *(p + 1 for p, j in anchors if j == n_input - 1)])
    if low > high:
        # No length fits: the error names the one that comes nearest.
        low = high = least if least > high else most
    if anchors and anchors[-1][0] >= high:
        raise InfeasibleWarpError(
            f"the anchor at output position {anchors[-1][0]} and input frame {anchors[-1][1]} lies beyond the last "
            f"of {high} output frames, position {high - 1}. Move it, or use a longer output",
            n_output=high,
        )
    pairs = sorted({(0, 0), (low - 1, n_input - 1), *anchors})
    check_feasible(pairs, steps.longest, min_skip=steps.shortest, last_position_max=high - 1)
    return pairs, high


def _as_path(
    found: tuple[IntArray, float] | None,
    scores: FloatArray,
    steps: StepPairs,
    lower_bound: float | None,
    search: str,
) -> FramePath:
    if found is None:
        n_input, max_skip = len(scores), steps.longest
        largest = np.abs(scores[np.isfinite(scores)]).max(initial=0.0)
        if largest > np.finfo(np.float64).max / n_input:
            raise OptionError(f"the scores are too large to be added up: found {largest:g}. Divide them by {largest:g}")
        raise InfeasibleWarpError(
            "every path through the keytimes uses a step that a lock, a tangent or a speed limit forbids: "
            "loosen one of them",
            n_input=n_input,
            max_skip=max_skip,
        )
    frames, total = found
    bound = total if lower_bound is None else min(lower_bound, total)
    return FramePath(frames, path_scores(scores, frames, steps), total, bound, True, search)


def path_scores(scores: FloatArray, path: IntArray, steps: StepPairs | None = None) -> FloatArray:
    """Return the score of each inner frame of a path, shape (n_output - 2,); their sum is the objective (Eq. 1).

    Scores have the shape (n_input, max_skip, max_skip), or with `steps` (n_input, n_pairs).
    """
    taken = np.diff(path)
    if steps is None:
        return np.asarray(scores[path[1:-1], taken[:-1] - 1, taken[1:] - 1])
    return np.asarray(scores[path[1:-1], steps.pair_of(taken[:-1], taken[1:])])


def check_feasible(
    anchors: Sequence[tuple[int, int]], max_skip: int, *, min_skip: int = 1, last_position_max: int | None = None
) -> None:
    """Refuse anchors (position, frame) between which no path fits; raise InfeasibleWarpError.

    ``min_skip (n_output - 1) <= n_input - 1 <= max_skip (n_output - 1)`` must hold in each span; in the last
    one for some length up to ``last_position_max + 1``.
    """
    for span, ((p0, j0), (p1, j1)) in enumerate(itertools.pairwise(anchors)):
        p1_max = p1 if last_position_max is None or span < len(anchors) - 2 else last_position_max
        n_output, n_input = p1 - p0 + 1, j1 - j0 + 1
        least, most = -(-(n_input - 1) // max_skip) + 1, (n_input - 1) // min_skip + 1
        if p1 > p0 and n_output <= most and p1_max - p0 + 1 >= least:
            continue
        if p1 <= p0 or n_input < 2:
            raise InfeasibleWarpError(
                f"output positions and input frames of anchors must both increase: ({p0}, {j0}) is followed by "
                f"({p1}, {j1})",
                span=span,
            )
        need = -(-(n_input - 1) // (n_output - 1))
        remedy = (
            f"Use at least {least} frames, or steps of up to {need}."
            if n_output <= most
            else f"Use at most {most} frames, or {-(-(n_output - 1) // (n_input - 1))} times as many of input."
        )
        limits = f"steps of {min_skip} to {max_skip} allow" if min_skip < max_skip else f"steps of {max_skip} allow"
        raise InfeasibleWarpError(
            f"cannot fit input frames {j0}–{j1} into {n_output} output frames: {limits} {least} to {most}. {remedy}",
            span=span,
            n_input=n_input,
            n_output=n_output,
            max_skip=max_skip,
            min_output=least,
            max_output=most,
        )
