"""How much faster a clip moves than its reference, so that the reference's timing can be taken without its tempo.

A slow reference makes all of the output slow, where only the length is free. Its velocities can be scaled to the
clip's first: then what is imitated is where it hurries and where it lingers, not how quick it is as a whole.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from retime.arrays import FloatArray
from retime.search.score import Model

_NEIGHBORS = 3
# A clip that moves four times as fast as another does something else.
_MOST = 4.0
# Frames of the clip that are looked at, evenly spread: more change nothing that can be seen.
_MOST_FRAMES = 600
_BLOCK = 64


def tempo_ratio(features: FloatArray, model: Model) -> float:
    """Say how many times as fast a clip moves as the reference does in the same poses.

    The mean logarithm, over the clip's frames, of its speed over the mean speed of the three reference frames nearest
    in pose; a frame counts by the lesser of the two speeds, so that stillness says nothing. Between ¼ and 4.

    Parameters
    ----------
    features : float array, shape (n_frames, 3 * n_numbers)
        Of the clip's inner frames, at unit speed: pose about the model's origin, velocity, acceleration.
    model : Model
        The reference.

    Returns
    -------
    float
        1 where one of them never moves.
    """
    n = model.n_numbers
    if len(features) > _MOST_FRAMES:
        features = features[np.linspace(0, len(features) - 1, _MOST_FRAMES).round().astype(np.intp)]
    speeds = np.linalg.norm(model.features[:, n : 2 * n], axis=1)
    own = np.linalg.norm(features[:, n : 2 * n], axis=1)
    squares = np.einsum("ij,ij->i", model.features[:, :n], model.features[:, :n])
    near = min(_NEIGHBORS, len(speeds))
    there = np.empty(len(features))
    for start in range(0, len(features), _BLOCK):
        poses = features[start : start + _BLOCK, :n]
        # Squared distances, but for what is the same in a row.
        away = squares - 2 * poses @ model.features[:, :n].T
        nearest = np.argpartition(away, near - 1, axis=1)[:, :near]
        there[start : start + _BLOCK] = speeds[nearest].mean(axis=1)
    weights = np.minimum(own, there)
    moving = weights > 1e-12 * max(float(own.max(initial=0.0)), float(there.max(initial=0.0)))
    if not moving.any():
        return 1.0
    logs = np.log(own[moving] / there[moving])
    mean = float(np.average(logs, weights=weights[moving]))
    return float(np.clip(np.exp(mean), 1 / _MOST, _MOST))


def at_tempo(model: Model, ratio: float) -> Model:
    """Play a reference faster: its velocities by `ratio`, its accelerations by the square of that."""
    n = model.n_numbers
    features = model.features.copy()
    features[:, n : 2 * n] *= ratio
    features[:, 2 * n :] *= ratio * ratio
    return replace(model, features=features)
