"""The local score: how much three frames shown one after another move like the reference (§3.2, Eq. 2).

The paper's letters, used here and in the kernels: y an input pose, z a reference pose, a hat for the vector
[pose, τ velocity, τ² acceleration]; (i, j, k) three input frames with i < j < k, a = j - i and b = k - j the skips.
"""

from __future__ import annotations

import numpy as np

from retime.errors import OptionError
from retime.kernels import Backend, backend
from retime.motion.rotation import FloatArray
from retime.warp.features import difference_scales, timing_features

SCORES = ("joint", "conditional")


def triple_scores(
    input_poses: FloatArray,
    reference_poses: FloatArray,
    *,
    max_skip: int,
    rate: float,
    time_scale: float,
    n_neighbors: int = 3,
    use: Backend | None = None,
) -> FloatArray:
    """Score every triple of input frames against a reference (Eq. 2, the paper's joint score).

    The mean Euclidean distance from the triple's feature vector to the `n_neighbors` nearest of the reference;
    exact, and the same bits from every backend.

    Parameters
    ----------
    input_poses : float array, shape (n_input, n_numbers)
        Pose vectors offered to the search.
    reference_poses : float array, shape (n_reference, n_numbers)
        Pose vectors of consecutive reference frames at the analysis rate; at least ``n_neighbors + 2``.
    max_skip : int
        Largest step between neighbouring selected frames.
    rate : float
        Analysis rate, Hz: the output shows selected frames 1 / `rate` apart.
    time_scale : float
        τ, seconds.
    n_neighbors : int
        Neighbours averaged.
    use : Backend, optional
        The kernels to use. Left out: the fastest that is installed.

    Returns
    -------
    float array, shape (n_input, max_skip, max_skip)
        ``scores[j, a - 1, b - 1]`` is the score of frames j - a, j, j + b, in pose units; ``inf`` where one of them
        lies outside the input.

    Raises
    ------
    OptionError
        The reference is too short, or the vectors have different lengths.
    """
    check_reference(len(reference_poses), n_neighbors)
    if input_poses.ndim != 2 or reference_poses.ndim != 2 or input_poses.shape[1] != reference_poses.shape[1]:
        raise OptionError(
            f"input and reference must be described by the same numbers: found {input_poses.shape[1:]} and "
            f"{reference_poses.shape[1:]} a frame"
        )
    if max_skip < 1:
        raise OptionError(f"max_skip must be at least 1, found {max_skip}")
    velocity, acceleration = difference_scales(rate, time_scale)
    # Distances don't change with the origin, but the products that find candidates lose fewer digits near it.
    origin = reference_poses.mean(axis=0)
    reference = timing_features(reference_poses - origin, rate=rate, time_scale=time_scale)
    return (use or backend()).joint_scores(
        np.ascontiguousarray(input_poses - origin),
        np.ascontiguousarray(reference),
        max_skip,
        velocity,
        acceleration,
        n_neighbors,
    )


def check_reference(n_reference: int, n_neighbors: int) -> None:
    """Refuse a reference that is too short; raise OptionError."""
    if n_neighbors < 1:
        raise OptionError(f"n_neighbors must be at least 1, found {n_neighbors}")
    if n_reference < n_neighbors + 2:
        raise OptionError(
            f"the reference has {n_reference} frames at the analysis rate; n_neighbors={n_neighbors} needs at least "
            f"{n_neighbors + 2}: give a longer reference, a higher rate, or fewer neighbours"
        )
