"""The clip's own timing, where a reference has little to say and the length is free.

A reference that never shows a pose scores all speeds through it nearly alike, so that a free length drifts. A small
share of how far each triple moves unlike the clip itself, played at unit speed, settles what the reference leaves open.
"""

from __future__ import annotations

import numpy as np

from retime.arrays import FloatArray
from retime.kernels import Backend, StepPairs, backend
from retime.search.reduction import Reduction
from retime.search.score import Model


def own_timing_costs(
    poses: FloatArray, reduction: Reduction, steps: StepPairs, model: Model, *, use: Backend | None = None
) -> FloatArray:
    """Measure how far each triple moves unlike the unrolled input at unit speed, shape (n_input, n_pairs); pose units.

    For frames j - a, j, j + b it is the distance from the triple's velocity and acceleration to those of j - U, j,
    j + V, where U and V are the upsamplings before and after j: 0 at unit speed. At the ends, where no such frames are,
    it is the nearest frame's that has them. A triple that reaches outside the input costs ``inf``.

    Parameters
    ----------
    poses : float array, shape (n_input, n_numbers)
        Of the unrolled input.
    reduction : Reduction
        The spans.
    steps : StepPairs
        The steps, and which of them follow which.
    model : Model
        Says how much differences weigh.
    use : Backend, optional
        The kernels to use. Left out: the fastest that is installed.
    """
    frames = np.arange(len(poses))
    upsample_after = reduction.upsample_at
    upsample_before = np.concatenate([upsample_after[:1], upsample_after[:-1]])
    inside = np.flatnonzero((frames >= upsample_before) & (frames + upsample_after < len(poses)))
    if not len(inside):
        # Fewer frames than a triple at unit speed: there is no timing of its own to keep.
        return (use or backend()).conditional_scores(
            poses, np.zeros((1, 3 * poses.shape[1])), np.zeros((len(poses), 1), dtype=np.int64), steps, 0.0, 0.0
        )
    inputs = np.ascontiguousarray(poses - model.origin)
    here = inputs[inside]
    before, after = inputs[inside - upsample_before[inside]], inputs[inside + upsample_after[inside]]
    features = np.concatenate(
        [here, (after - before) * model.velocity, ((after - here) - (here - before)) * model.acceleration], axis=1
    )
    row = np.clip(np.searchsorted(inside, frames), 0, len(inside) - 1)
    return (use or backend()).conditional_scores(
        inputs, np.ascontiguousarray(features), row[:, None], steps, model.velocity, model.acceleration
    )
