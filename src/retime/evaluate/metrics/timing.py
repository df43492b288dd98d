"""How far a motion's local timing is from a reference's."""

from __future__ import annotations

import math

import numpy as np

from retime.arrays import FloatArray
from retime.errors import OptionError
from retime.evaluate.metrics import ANALYSIS_RATE
from retime.motion.any_motion import AnyMotion
from retime.motion.kinematics import metres_per_unit
from retime.motion.motion import Motion
from retime.search.options import default_of
from retime.search.poses.references import Reference, model_poses
from retime.search.poses.spaces import PoseOptions, PoseSpace, timing_features


def timing_distance(
    motion: AnyMotion,
    reference: AnyMotion | Reference,
    *,
    features: PoseSpace | PoseOptions | None = None,
    rate: float = ANALYSIS_RATE,
    time_scale: float = default_of("time_scale"),
    low_pass: float = 4.0,
    n_neighbors: int = 3,
) -> float:
    """Distance of a motion's local timing to a reference's: Eq. 2 of its own consecutive frames, averaged.

    It is measured on a motion as it will be seen, whatever made it, after all smoothing and averaging; so it compares
    methods that never knew an objective.

    Returns
    -------
    float
        The mean over frames. For a motion in metres, root mean square over the joints; velocity and acceleration count
        as in Eq. 2, times τ and τ².

    Raises
    ------
    OptionError
        Either of them is too short.
    """
    tracks = model_poses(motion, [reference if isinstance(reference, Reference) else Reference(reference)], features)
    poses = tracks.input.at_rate(rate, low_pass)
    shortest = min(len(poses), *(len(track.at_rate(rate, low_pass)) for track in tracks.references))
    if shortest < 3:
        raise OptionError(f"a timing needs three analysis frames or more; found {shortest}")
    shape: dict[str, float] = {"rate": rate, "time_scale": time_scale}
    wanted = [timing_features(track.at_rate(rate, low_pass), **shape) for track in tracks.references]
    distances = _nearest_distances(timing_features(poses, **shape), np.concatenate(wanted), n_neighbors)
    scale = metres_per_unit(motion) if isinstance(motion, Motion) else 1.0
    coordinates = 3 if isinstance(motion, Motion) else 1
    return float(distances.mean()) * scale / math.sqrt(tracks.input.n_numbers / coordinates)


def _nearest_distances(here: FloatArray, there: FloatArray, n_neighbors: int) -> FloatArray:
    """Distances from each row to the nearest rows of another array; shape (n, n_neighbors)."""
    origin = there.mean(axis=0)
    here, there = here - origin, there - origin
    squares = np.sum(here**2, axis=1)[:, None] + np.sum(there**2, axis=1) - 2 * here @ there.T
    n_found = min(n_neighbors, len(there))
    nearest = np.partition(squares, n_found - 1, axis=1)[:, :n_found]
    return np.sqrt(np.maximum(nearest, 0.0))
