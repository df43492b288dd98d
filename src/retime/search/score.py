"""The local score: how much three frames shown one after another move like the reference (§3.2, Eq. 2).

The paper's letters, used here and in the kernels: y an input pose, z a reference pose, a hat for the vector
[pose, τ velocity, τ² acceleration]; (i, j, k) three input frames with i < j < k, a = j - i and b = k - j the skips.
"""

from __future__ import annotations

import hashlib
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Literal, get_args

import numpy as np

from retime.arrays import BoolArray, FloatArray, IntArray
from retime.brief import brief_repr
from retime.errors import OptionError
from retime.kernels import Backend, StepPairs, backend
from retime.kernels.numpy_backend import feature_distances, mean_in_order, nearest_features, squared_distances
from retime.limits import MAX_STEP
from retime.search.poses.spaces import difference_scales, timing_features

ScoreName = Literal["joint", "conditional"]
SCORES = get_args(ScoreName)
# Frames of a model whose bits are summed at once.
_HASHED = 2048
# Numbers in a table: two gigabytes of them. An hour at 30 Hz with steps to 8 needs 7 million.
MOST_SCORES = 250_000_000


@dataclass(frozen=True, eq=False)
class Model:
    """Reference frames as the score sees them: features of every inner frame of every reference.

    Attributes
    ----------
    features : float array, shape (n_frames, 3 * n_numbers)
        Pose, scaled velocity, scaled acceleration, about `origin`.
    poses : float array, shape (n_frames, n_numbers)
        The poses as they were given: the shift rounds, so that ties among them are told here.
    weights : float array, shape (n_frames,)
        A weight w makes distances w times shorter.
    reference : int array, shape (n_frames,)
        Which reference a frame belongs to.
    frame : int array, shape (n_frames,)
        Its frame there, at the analysis rate.
    origin : float array, shape (n_numbers,)
        Subtracted from every pose; distances don't change with it, but products lose fewer digits near it.
    velocity, acceleration : float
        Factors of first and second differences.
    """

    features: FloatArray
    poses: FloatArray
    weights: FloatArray
    reference: IntArray
    frame: IntArray
    origin: FloatArray
    velocity: float
    acceleration: float

    __repr__ = brief_repr

    @property
    def n_numbers(self) -> int:
        """Numbers that describe a pose."""
        return len(self.origin)

    def only(self, places: IntArray) -> Model:
        """Keep some of its frames."""
        return replace(
            self,
            features=np.ascontiguousarray(self.features[places]),
            poses=np.ascontiguousarray(self.poses[places]),
            weights=self.weights[places],
            reference=self.reference[places],
            frame=self.frame[places],
        )


def build_model(
    references: Sequence[FloatArray],
    *,
    rate: float,
    time_scale: float,
    n_neighbors: int = 3,
    weights: Sequence[float] = (),
    own_name: str = "",
) -> Model:
    """Collect the features of all references.

    Parameters
    ----------
    references : sequence of float array, shape (n_reference, n_numbers)
        Pose vectors of consecutive frames at the analysis rate, one array a reference.
    rate : float
        Analysis rate, Hz.
    time_scale : float
        τ, seconds.
    n_neighbors : int
        Together the references must have that many inner frames.
    weights : sequence of float
        One a reference, above 0; left out: 1.
    own_name : str
        What to call the input where it is its own reference: errors then speak of it, not of a reference.

    Raises
    ------
    OptionError
        Too few frames, different numbers a pose, or a weight that is not above 0.
    """
    weights = list(weights) or [1.0] * len(references)
    if len({poses.shape[1] for poses in references}) != 1:
        raise OptionError("all references must be described by the same numbers")
    if len(weights) != len(references) or not all(np.isfinite(w) and w > 0 for w in weights):
        raise OptionError(f"each reference needs a weight above 0; found {weights}")
    check_reference([len(poses) for poses in references], n_neighbors, rate, own_name)
    velocity, acceleration = difference_scales(rate, time_scale)
    origin = _joined(references).mean(axis=0)
    features = [timing_features(poses - origin, rate=rate, time_scale=time_scale) for poses in references]
    return Model(
        _joined(features),
        _joined([poses[1:-1] for poses in references]),
        np.concatenate([np.full(len(part), float(w)) for part, w in zip(features, weights, strict=True)]),
        np.concatenate([np.full(len(part), i, dtype=np.int64) for i, part in enumerate(features)]),
        np.concatenate([np.arange(1, len(part) + 1, dtype=np.int64) for part in features]),
        origin,
        velocity,
        acceleration,
    )


def without_copies(model: Model, n_neighbors: int) -> Model:
    """Leave out frames that are the same as others, to the last bit, beyond the first `n_neighbors` of each.

    A score asks for the `n_neighbors` nearest, of equally near ones for the earliest: it never sees the others, and
    stays the same to the last bit. A figure that stands still is scored as quickly as one that moves, though none of
    its frames is nearer than another.
    """
    repeated = _maybe_repeated(model)
    # Digests of rows: the rows themselves would take as much memory again as an hour's model does.
    seen: dict[bytes, int] = {}
    kept = []
    for place, may_repeat in enumerate(repeated.tolist()):
        if not may_repeat:
            kept.append(place)
            continue
        digest = hashlib.blake2b(digest_size=16)
        for part in (model.poses, model.features, model.weights):
            digest.update(part[place].tobytes())
        times = seen.get(key := digest.digest(), 0)
        seen[key] = times + 1
        if times < n_neighbors:
            kept.append(place)
    if len(kept) == len(model.weights):
        return model
    return model.only(np.array(kept))


def _maybe_repeated(model: Model) -> BoolArray:
    """Mark every frame that is the same as another, to the last bit; and, hardly ever, one that is not."""
    sums = np.zeros(len(model.weights), dtype=np.uint64)
    generator = np.random.default_rng(0)
    for part in (model.poses, model.features, model.weights[:, None]):
        # Whole numbers of their bits, each times an odd one of its column: the sums of equal rows are equal.
        factors = generator.integers(0, 1 << 63, size=part.shape[1], dtype=np.uint64) * np.uint64(2) + np.uint64(1)
        for start in range(0, len(part), _HASHED):
            bits = np.ascontiguousarray(part[start : start + _HASHED]).view(np.uint64)
            sums[start : start + _HASHED] += (bits * factors).sum(axis=1, dtype=np.uint64)
    order = np.argsort(sums)
    same = sums[order[1:]] == sums[order[:-1]]
    repeated = np.zeros(len(sums), dtype=bool)
    repeated[order[1:][same]] = True
    repeated[order[:-1][same]] = True
    return repeated


def _joined(arrays: Sequence[FloatArray]) -> FloatArray:
    """Return arrays one after another; a single one as it is, where it may."""
    return np.ascontiguousarray(arrays[0] if len(arrays) == 1 else np.concatenate(list(arrays)), dtype=np.float64)


def check_reference(n_frames: Sequence[int], n_neighbors: int, rate: float, own_name: str = "") -> None:
    """Refuse references that are too short together; raise OptionError."""
    if n_neighbors < 1:
        raise OptionError(f"n_neighbors must be at least 1, found {n_neighbors}", option="n_neighbors")
    if sum(max(0, n - 2) for n in n_frames) >= n_neighbors:
        return
    found = " + ".join(str(n) for n in n_frames)
    frames = f"{found} frame{'s' * (found != '1')} at {rate:g} Hz, as the search looks at it"
    needed = f"n_neighbors={n_neighbors} needs at least {n_neighbors + 2}"
    if own_name:
        raise OptionError(
            f"{own_name} is too short to search: it has {frames}, and {needed}. Play it evenly instead (--method "
            "linear; linear_warp), or give a reference to imitate",
            option="motion",
        )
    raise OptionError(
        f"the reference has {frames}; {needed}: give a longer reference, a higher rate, or fewer neighbours",
        option="reference",
    )


def check_table(n_input: int, steps: StepPairs) -> None:
    """Refuse a table of scores that no memory holds; raise OptionError."""
    if (n_scores := n_input * steps.n_pairs) > MOST_SCORES:
        raise OptionError(
            f"a search through {n_input} frames in steps of up to {steps.longest} needs a table of "
            f"{n_scores:.2g} scores; {MOST_SCORES:.2g} is the most. Take a shorter part of the motion, or ask for a "
            "lower rate or narrower speed limits"
        )


def triple_scores(
    input_poses: FloatArray,
    model: Model,
    *,
    max_skip: int | None = None,
    steps: StepPairs | None = None,
    n_neighbors: int = 3,
    score: ScoreName = "joint",
    use: Backend | None = None,
) -> FloatArray:
    """Score every triple of input frames against the references; exact, and the same bits from every backend.

    ``joint`` is the paper's Eq. 2: the mean distance from the triple's feature vector to the `n_neighbors` nearest
    of the references. ``conditional`` asks how this pose should move: it finds the reference frames nearest in pose
    to the middle frame, and takes the mean distance from the triple's velocity and acceleration to theirs.

    Parameters
    ----------
    input_poses : float array, shape (n_input, n_numbers)
        Pose vectors offered to the search, shown one analysis period apart where selected one after another.
    model : Model
        The references.
    max_skip : int
        Largest step between neighbouring selected frames: each step up to it is scored beside each.
    steps : StepPairs
        In place of `max_skip`: the steps to score, and which of them follow which.
    n_neighbors : int
        Neighbours averaged.
    score : {"joint", "conditional"}
        Which score. A weight w makes all distances to a reference w times shorter in the joint score; in the
        conditional one it makes its poses nearer.
    use : Backend, optional
        The kernels to use. Left out: the fastest that is installed.

    Returns
    -------
    float array, shape (n_input, max_skip, max_skip)
        ``scores[j, a - 1, b - 1]`` is the score of frames j - a, j, j + b, in pose units; ``inf`` where one of them
        lies outside the input. With `steps`: shape (n_input, n_pairs), the score of each pair.

    Raises
    ------
    OptionError
        No such score, or the vectors have different lengths.
    """
    if score not in SCORES:
        raise OptionError(f"the score must be one of {', '.join(SCORES)}; found {score!r}")
    if input_poses.ndim != 2 or input_poses.shape[1] != model.n_numbers:
        raise OptionError(
            f"input and reference must be described by the same numbers: found {input_poses.shape[1:]} and "
            f"({model.n_numbers},) a frame"
        )
    if (max_skip is None) == (steps is None):
        raise OptionError("scores need either max_skip or steps")
    if max_skip is not None:
        if not 1 <= max_skip <= MAX_STEP:
            raise OptionError(f"max_skip must be from 1 to {MAX_STEP}, found {max_skip}")
        scores = triple_scores(
            input_poses, model, steps=StepPairs.up_to(max_skip), n_neighbors=n_neighbors, score=score, use=use
        )
        return scores.reshape(-1, max_skip, max_skip)
    assert steps is not None
    check_table(len(input_poses), steps)
    kernels = use or backend()
    inputs = np.ascontiguousarray(input_poses - model.origin)
    scales = model.velocity, model.acceleration
    groups = _groups(model)
    if score == "conditional":
        nearest = _nearest_in_pose(input_poses, model, groups, n_neighbors, kernels)
        return kernels.conditional_scores(inputs, model.features, nearest, steps, *scales)
    if len(groups) == 1 and model.weights[0] == 1.0:
        return kernels.joint_scores(inputs, model.features, steps, *scales, n_neighbors)
    found = []
    for group in groups:
        features = np.ascontiguousarray(model.features[group])
        n_found = min(n_neighbors, len(features))
        distances = kernels.joint_scores(inputs, features, steps, *scales, n_found, each=True)
        found.append(distances / model.weights[group][0])
    return mean_in_order(np.sort(np.concatenate(found, axis=-1), axis=-1)[..., :n_neighbors])


def _groups(model: Model) -> list[BoolArray]:
    """Return the frames of each weight."""
    # NumPy's own unique would import its masked arrays, which takes longer than most scores.
    return [model.weights == weight for weight in sorted(set(model.weights.tolist()))]


def _nearest_in_pose(
    inputs: FloatArray, model: Model, groups: Sequence[np.ndarray], n_neighbors: int, kernels: Backend
) -> IntArray:
    """Model frames nearest in pose to each input frame, (n_input, n_neighbors); ties to the earlier frame."""
    inputs, poses = np.ascontiguousarray(inputs, dtype=np.float64), model.poses
    if len(groups) == 1:
        return kernels.nearest_poses(inputs, poses, n_neighbors)
    rows, distances = [], []
    for group in groups:
        members = np.flatnonzero(group)
        nearest = members[kernels.nearest_poses(inputs, poses[members], min(n_neighbors, len(members)))]
        rows.append(nearest)
        distances.append(np.sqrt(squared_distances(inputs[:, None], poses[nearest])) / model.weights[nearest])
    row, distance = np.concatenate(rows, axis=1), np.concatenate(distances, axis=1)
    order = np.lexsort((row, distance), axis=1)[:, :n_neighbors]
    return np.ascontiguousarray(np.take_along_axis(row, order, axis=1))


def matched_frames(
    input_poses: FloatArray, path: IntArray, model: Model, *, n_neighbors: int = 3, score: ScoreName = "joint"
) -> tuple[IntArray, FloatArray]:
    """Find which reference frames gave each inner frame of a path its score.

    Returns
    -------
    rows : int array, shape (n_output - 2, n_neighbors)
        Rows of the model, the nearest first.
    distances : float array, shape (n_output - 2, n_neighbors)
        Their distances, weighted; the mean over the last axis is the score.
    """
    features = _features_of_path(input_poses, path, model)
    n_numbers = model.n_numbers
    groups = _groups(model)
    if score == "conditional":
        near = _nearest_in_pose(input_poses[path[1:-1]], model, groups, n_neighbors, backend())
        apart = np.empty(near.shape)
        block = max(1, (4 << 20) // (2 * n_numbers * near.shape[1]))
        for start in range(0, len(features), block):
            part = slice(start, start + block)
            moves = model.features[near[part], n_numbers:]
            apart[part] = np.sqrt(squared_distances(features[part, None, n_numbers:], moves))
        found = [(near, apart)]
    else:
        found = []
        for group in groups:
            members = np.flatnonzero(group)
            nearest, apart = nearest_features(features, model.features[members], min(n_neighbors, len(members)))
            found.append((members[nearest], apart / model.weights[members[0]]))
    rows, distances = (np.concatenate(parts, axis=1) for parts in zip(*found, strict=True))
    order = np.lexsort((rows, distances), axis=1)[:, :n_neighbors]
    rows, distances = np.take_along_axis(rows, order, axis=1), np.take_along_axis(distances, order, axis=1)
    return rows, distances


def distances_to(input_poses: FloatArray, path: IntArray, model: Model, rows: IntArray) -> FloatArray:
    """Measure how far each inner frame of a path is from given rows of the model, one a frame; (n_output - 2,)."""
    return feature_distances(_features_of_path(input_poses, path, model), model.features[rows])


def _features_of_path(input_poses: FloatArray, path: IntArray, model: Model) -> FloatArray:
    """Features of the inner frames of a path, (n_output - 2, 3 n_numbers)."""
    inputs = input_poses - model.origin
    before, here, after = inputs[path[:-2]], inputs[path[1:-1]], inputs[path[2:]]
    return np.concatenate(
        [here, (after - before) * model.velocity, ((after - here) - (here - before)) * model.acceleration], axis=1
    )
