"""The best path in step with a reference: output frame p is compared with reference frame p, and with no other."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from retime.arrays import FloatArray
from retime.errors import InfeasibleWarpError
from retime.kernels import Backend, PathProblem, StepPairs, backend
from retime.search.path import MEMORY_LIMIT, FramePath, path_scores
from retime.search.score import Model, distances_to


def aligned_path(
    input_poses: FloatArray,
    model: Model,
    prices: FloatArray,
    *,
    steps: StepPairs,
    anchors: Sequence[tuple[int, int]],
    start_cost: FloatArray,
    end_cost: FloatArray,
    use: Backend | None = None,
    memory_limit: int = MEMORY_LIMIT,
) -> FramePath:
    """Select the input frames that, shown at the reference's clock, move as it does; exact.

    Of paths with equal totals the one whose last step is smallest wins, then the step before it, and so on.

    Parameters
    ----------
    input_poses : float array, shape (n_input, n_numbers)
        Pose vectors offered to the search.
    model : Model
        The reference at the clock of the output: row p - 1 is its frame p. It has n_output - 2 rows.
    prices : float array, shape (n_input, n_pairs)
        Added to the distances of triples; ``inf`` forbids one. Those of triples that leave the input are set to that:
        the array may be large, so it is changed in place.
    steps : StepPairs
        The steps that the path may take, and which may follow which.
    anchors : sequence of (int, int)
        Pairs (output position, input frame) that the path must pass, in order, both ends among them.
    start_cost, end_cost : float arrays, shape (n_steps,)
        Added for the first and the last step; ``inf`` forbids it.
    use : Backend, optional
        The kernels to use. Left out: the fastest that is installed.
    memory_limit : int
        Bytes of back-pointers to hold at once; beyond it the search is done twice.

    Returns
    -------
    FramePath
        Its scores are distances and prices; ``total`` is their sum.

    Raises
    ------
    InfeasibleWarpError
        Every path takes a step that is forbidden.
    """
    # What lies outside the input is no triple, whatever its price.
    lengths = steps.steps
    for j in range(min(steps.longest, len(prices))):
        prices[j, lengths[steps.before] > j] = np.inf
        prices[-1 - j, lengths[steps.after] > j] = np.inf
    positions, frames = (np.array(column, dtype=np.int64) for column in zip(*anchors, strict=True))
    problem = PathProblem(prices, steps, positions, frames, int(positions[-1]), start_cost, end_cost)
    found = (use or backend()).aligned_path(
        problem,
        np.ascontiguousarray(input_poses - model.origin),
        model.features,
        model.velocity,
        model.acceleration,
        memory_limit,
    )
    if found is None:
        raise InfeasibleWarpError(
            "every path through the keytimes uses a step that a lock, a tangent or a speed limit forbids: "
            "loosen one of them",
            n_input=len(input_poses),
            max_skip=steps.longest,
        )
    path, _ = found
    distances = distances_to(input_poses, path, model, np.arange(len(path) - 2))
    scores = distances + path_scores(prices, path, steps)
    taken = np.searchsorted(lengths, np.diff(path))
    # Added in the search's order.
    total = float(np.cumsum([start_cost[taken[0]], *scores, end_cost[taken[-1]]])[-1])
    return FramePath(path, scores, total, total, True, "aligned")
