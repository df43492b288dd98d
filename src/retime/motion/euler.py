"""Angles for the channels that a file declares: three, two, one or none; continuous in time, or near given ones."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from retime.arrays import FloatArray
from retime.motion import rotation

_AXIS = {"X": 0, "Y": 1, "Z": 2}
# Radians. Rotations closer than this are written alike, for files have six decimals of a degree.
_SAME = 1e-9


def angle_between(a: ArrayLike, b: ArrayLike) -> FloatArray:
    """Measure the angle between two rotations.

    Parameters
    ----------
    a, b : float array, shape (..., 4)
        Unit quaternions, wxyz.

    Returns
    -------
    float array, shape (...)
        Radians, 0 to pi; accurate for small angles too.
    """
    a = np.asarray(a, dtype=np.float64)
    b = np.asarray(b, dtype=np.float64)
    side = np.where(np.sum(a * b, axis=-1, keepdims=True) < 0, -1.0, 1.0)
    chord = np.sqrt(np.sum((a - side * b) ** 2, axis=-1))
    # Opposite sides of the sphere are one rotation, so the chord is at most the root of 2.
    angles: FloatArray = 4.0 * np.arcsin(np.minimum(chord / 2.0, np.sqrt(0.5)))
    return angles


def fit_angles(order: str, q: ArrayLike, *, near: ArrayLike | None = None) -> FloatArray:
    """Find the intrinsic Euler angles whose rotation is `q`, or comes nearest to it.

    Three different axes make every rotation; two, one or none make some, and the nearest of those is taken.

    Parameters
    ----------
    order : str
        Different letters of X, Y, Z in the order of multiplication: three, two, one or none.
    q : float array, shape (n_frames, ..., 4)
        Unit quaternions, wxyz.
    near : float array, shape (n_frames, ..., len(order)), optional
        Angles to stay close to, radians. They come back bit for bit where they mean the rotation already. Left out:
        each frame stays close to the one before.

    Returns
    -------
    float array, shape (n_frames, ..., len(order))
        Radians.

    Examples
    --------
    >>> turned = rotation.from_euler("ZY", np.radians([[200.0, 10.0], [210.0, 20.0]]))
    >>> bool(np.allclose(np.degrees(fit_angles("ZY", turned)), [[-160, 10], [-150, 20]]))
    True
    """
    q = np.asarray(q, dtype=np.float64)
    if not order:
        return np.zeros((*q.shape[:-1], 0))
    if near is not None:
        angles = np.array(near, dtype=np.float64)
        differs = angle_between(rotation.from_euler(order, angles), q) > _SAME
        if np.any(differs):
            angles[differs] = _fit(order, q[differs], angles[differs])
        return angles
    angles = _fit(order, q, np.zeros((*q.shape[:-1], len(order))))
    if len(order) == 3:
        _follow_through_locks(order, q, angles)
        angles = _stay_on_one_branch(angles)
    return np.asarray(np.unwrap(angles, axis=0))


def _fit(order: str, q: FloatArray, near: FloatArray) -> FloatArray:
    if len(order) == 3:
        return rotation.to_euler(order, q, near=near)
    i = _AXIS[order[0]]
    if len(order) == 1:
        angles = 2.0 * np.arctan2(q[..., 1 + i], q[..., 0])[..., None]
    else:
        # The turns a about i and b about j make a quaternion with the parts (cos a/2 cos b/2), (sin a/2 cos b/2) on i,
        # (cos a/2 sin b/2) on j and +-(sin a/2 sin b/2) on the third axis k. Its product with q splits into
        #     1/2 [(w - k) cos s + (i + j) sin s] + 1/2 [(w + k) cos d + (i - j) sin d],  s, d = (a +- b) / 2,
        # so each half is greatest in a direction of its own.
        j = _AXIS[order[1]]
        k = (1.0 if (j - i) % 3 == 1 else -1.0) * q[..., 4 - i - j]
        w, qi, qj = q[..., 0], q[..., 1 + i], q[..., 1 + j]
        s = np.arctan2(qi + qj, w - k)
        d = np.arctan2(qi - qj, w + k)
        angles = np.stack([s + d, s - d], axis=-1)
    return angles + 2.0 * np.pi * np.round((near - angles) / (2.0 * np.pi))


def _follow_through_locks(order: str, q: FloatArray, angles: FloatArray) -> None:
    """Where the middle angle is a right angle the outer two are free: keep the first from the frame before."""
    locked = np.abs(np.cos(angles[..., 1])) < 1e-9
    for frame in np.flatnonzero(locked.reshape(len(q), -1).any(axis=1)):
        if frame:
            here = locked[frame]
            angles[frame][here] = rotation.to_euler(order, q[frame][here], near=angles[frame - 1][here])


def _stay_on_one_branch(angles: FloatArray) -> FloatArray:
    """Choose between the two triples of each rotation so that a frame follows the one before.

    Either triple leads to the other by the same step, so whether to change over between two frames does not depend on
    the choice before: a running count of the changes settles all frames at once.
    """
    other = np.stack([angles[..., 0] + np.pi, np.pi - angles[..., 1], angles[..., 2] + np.pi], axis=-1)
    stays = np.sum(_wrap(angles[1:] - angles[:-1]) ** 2, axis=-1)
    changes = np.sum(_wrap(other[1:] - angles[:-1]) ** 2, axis=-1) < stays
    odd = np.zeros(angles.shape[:-1], dtype=bool)
    odd[1:] = np.cumsum(changes, axis=0) % 2 == 1
    return np.where(odd[..., None], other, angles)


def _wrap(angles: FloatArray) -> FloatArray:
    return angles - 2.0 * np.pi * np.round(angles / (2.0 * np.pi))
