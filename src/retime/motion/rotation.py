"""Unit quaternions, wxyz, batched over arrays of shape (..., 4).

A rotation q takes a vector v of the child space to the parent space. ``multiply(a, b)`` turns by b first, then
by a. Euler angles are intrinsic, in the order in which a file lists its channels: "ZYX" multiplies the
rotation about Z by the rotation about Y by the rotation about X, as BVH does.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from retime.arrays import FloatArray
from retime.kernels import LARGEST_TURN, backend

_AXIS = {"X": 0, "Y": 1, "Z": 2}
# Up to here the radians of an angle are as exact as the angle, and it may be wound up on purpose.
MANY_DEGREES = 1e6


def identity(*shape: int) -> FloatArray:
    """Return identity rotations, shape (*shape, 4)."""
    quaternions = np.zeros((*shape, 4))
    quaternions[..., 0] = 1.0
    return quaternions


def normalize(q: ArrayLike) -> FloatArray:
    """Scale quaternions (..., 4) to unit length; raise ZeroDivisionError where one has no direction."""
    scaled: FloatArray = np.asarray(q, dtype=np.float64)
    squares = np.einsum("...c,...c->...", scaled, scaled)
    if squares.size and not (squares.min() > 1e-200 and squares.max() < 1e200):
        # By a power of two first, which is exact: the squares of very long or short ones overflow or vanish.
        _, exponent = np.frexp(np.max(np.abs(scaled), axis=-1, keepdims=True))
        scaled = np.ldexp(scaled, -exponent)
        squares = np.einsum("...c,...c->...", scaled, scaled)
        if not np.all((squares > 0) & np.isfinite(squares)):
            raise ZeroDivisionError("a quaternion of length 0, or that is not finite, is no rotation")
    unit: FloatArray = scaled / np.sqrt(squares)[..., None]
    return unit


def multiply(a: ArrayLike, b: ArrayLike) -> FloatArray:
    """Compose rotations (..., 4): first `b`, then `a`."""
    a = np.asarray(a, dtype=np.float64)
    b = np.asarray(b, dtype=np.float64)
    aw, ax, ay, az = a[..., 0], a[..., 1], a[..., 2], a[..., 3]
    bw, bx, by, bz = b[..., 0], b[..., 1], b[..., 2], b[..., 3]
    out = np.empty(np.broadcast_shapes(a.shape, b.shape))
    out[..., 0] = aw * bw - ax * bx - ay * by - az * bz
    out[..., 1] = aw * bx + ax * bw + ay * bz - az * by
    out[..., 2] = aw * by - ax * bz + ay * bw + az * bx
    out[..., 3] = aw * bz + ax * by - ay * bx + az * bw
    return out


def conjugate(q: ArrayLike) -> FloatArray:
    """Invert unit quaternions (..., 4)."""
    inverse: FloatArray = np.asarray(q, dtype=np.float64) * np.array([1.0, -1.0, -1.0, -1.0])
    return inverse


def rotate(q: ArrayLike, v: ArrayLike) -> FloatArray:
    """Turn vectors (..., 3) by unit quaternions (..., 4)."""
    q = np.asarray(q, dtype=np.float64)
    v = np.asarray(v, dtype=np.float64)
    w, x, y, z = q[..., 0], q[..., 1], q[..., 2], q[..., 3]
    vx, vy, vz = v[..., 0], v[..., 1], v[..., 2]
    # v + w t + u x t with t = 2 u x v
    tx, ty, tz = 2 * (y * vz - z * vy), 2 * (z * vx - x * vz), 2 * (x * vy - y * vx)
    out = np.empty((*np.broadcast_shapes(q.shape[:-1], v.shape[:-1]), 3))
    out[..., 0] = vx + w * tx + y * tz - z * ty
    out[..., 1] = vy + w * ty + z * tx - x * tz
    out[..., 2] = vz + w * tz + x * ty - y * tx
    return out


def slerp(a: ArrayLike, b: ArrayLike, fraction: ArrayLike) -> FloatArray:
    """Interpolate between unit quaternions along the shorter arc.

    Parameters
    ----------
    a, b : float array, shape (..., 4)
        Rotations at fraction 0 and 1.
    fraction : float array, shape (...)
        Exactly 0 gives `a` and exactly 1 gives `b` (up to sign), bit for bit.
    """
    a = np.asarray(a, dtype=np.float64)
    b = np.asarray(b, dtype=np.float64)
    fraction = np.asarray(fraction, dtype=np.float64)
    shape = np.broadcast_shapes(a.shape[:-1], b.shape[:-1], fraction.shape)
    out = np.empty((*shape, 4))
    rows = out.reshape(-1, 4)
    a_rows, b_rows = (np.broadcast_to(q, (*shape, 4)).reshape(-1, 4) for q in (a, b))
    shares = np.broadcast_to(fraction, shape).reshape(-1)
    # In pieces that stay in the cache, one contiguous row a component.
    for start in range(0, len(rows), 4096):
        piece = slice(start, start + 4096)
        rows[piece] = _slerp_rows(a_rows[piece].T.copy(), b_rows[piece].T.copy(), shares[piece]).T
    return out


def _slerp_rows(a: FloatArray, b: FloatArray, share: FloatArray) -> FloatArray:
    """Slerp quaternions (4, n) by shares (n,); overwrites both."""
    b *= np.where(a[0] * b[0] + a[1] * b[1] + a[2] * b[2] + a[3] * b[3] < 0, -1.0, 1.0)
    # atan2 of the two chords keeps small angles accurate where arccos loses half the digits.
    angle = 2.0 * np.arctan2(_length(a - b), _length(a + b))
    sine = np.sin(angle)
    near = sine < 1e-9
    safe = np.where(near, 1.0, sine)
    rest = 1.0 - share
    # At share 0 and 1 the weights come out as 0 and 1 to the last bit: one sine is 0, the other is divided by itself.
    wa = np.where(near, rest, np.sin(rest * angle) / safe)
    wb = np.where(near, share, np.sin(share * angle) / safe)
    a *= wa
    b *= wb
    a += b
    return a


def _length(rows: FloatArray) -> FloatArray:
    rows *= rows
    return np.asarray(np.sqrt(rows[0] + rows[1] + rows[2] + rows[3]))


def radians(angles: ArrayLike, *, degrees: bool = True) -> FloatArray:
    """Return a file's angles in radians; of very large ones whole turns are left out.

    Leaving out turns of 360 degrees is exact, and so is what the sine and cosine make of radians. The radians of 5e26
    degrees, or the degrees of so many radians, would be rounded by more than a turn.

    Parameters
    ----------
    angles : float array
        As the file has them.
    degrees : bool
        What they are in; if not, in radians.

    Examples
    --------
    >>> int(5e26) % 360, round(float(np.rad2deg(radians(5e26))), 9)
    (176, 176.0)
    """
    angles = np.asarray(angles, dtype=np.float64)
    large = np.abs(angles) > (MANY_DEGREES if degrees else np.deg2rad(MANY_DEGREES))
    if np.any(large):
        few = np.fmod(angles, 360.0) if degrees else np.arctan2(np.sin(angles), np.cos(angles))
        angles = np.where(large, few, angles)
    return np.deg2rad(angles) if degrees else angles


def about_axis(axis: int, angle: ArrayLike) -> FloatArray:
    """Return rotations (..., 4) about coordinate axis 0, 1 or 2 by `angle` (...), radians."""
    half = np.asarray(angle, dtype=np.float64) * 0.5
    q = np.zeros((*half.shape, 4))
    q[..., 0] = np.cos(half)
    q[..., 1 + axis] = np.sin(half)
    return q


def from_euler(order: str, angles: ArrayLike) -> FloatArray:
    """Compose rotations from intrinsic Euler angles.

    Parameters
    ----------
    order : str
        One to three of the letters X, Y, Z, in the order of multiplication ("ZYX").
    angles : float array, shape (..., len(order))
        Radians, in that order.
    """
    angles = np.asarray(angles, dtype=np.float64)
    if not order:
        return identity(*angles.shape[:-1])
    if len(set(order)) == 3:
        return _from_three_turns(order, angles)
    q = about_axis(_AXIS[order[0]], angles[..., 0])
    for i, letter in enumerate(order[1:], start=1):
        q = multiply(q, about_axis(_AXIS[letter], angles[..., i]))
    return q


def _from_three_turns(order: str, angles: FloatArray) -> FloatArray:
    """Multiply out the three turns."""
    triples = angles.reshape(-1, 3)
    large = np.abs(triples) > LARGEST_TURN
    if np.any(large):
        triples = np.where(large, np.arctan2(np.sin(triples), np.cos(triples)), triples)
    turned = backend(warn=False).three_turns(order, np.ascontiguousarray(triples))
    return turned.reshape(*angles.shape[:-1], 4)


def to_matrix(q: ArrayLike) -> FloatArray:
    """Return rotation matrices (..., 3, 3) of unit quaternions (..., 4)."""
    q = np.asarray(q, dtype=np.float64)
    w, x, y, z = q[..., 0], q[..., 1], q[..., 2], q[..., 3]
    m = np.empty((*q.shape[:-1], 3, 3))
    m[..., 0, 0] = 1 - 2 * (y * y + z * z)
    m[..., 0, 1] = 2 * (x * y - w * z)
    m[..., 0, 2] = 2 * (x * z + w * y)
    m[..., 1, 0] = 2 * (x * y + w * z)
    m[..., 1, 1] = 1 - 2 * (x * x + z * z)
    m[..., 1, 2] = 2 * (y * z - w * x)
    m[..., 2, 0] = 2 * (x * z - w * y)
    m[..., 2, 1] = 2 * (y * z + w * x)
    m[..., 2, 2] = 1 - 2 * (x * x + y * y)
    return m


def from_matrix(m: ArrayLike) -> FloatArray:
    """Return unit quaternions (..., 4) of rotation matrices (..., 3, 3); of nearly one, a rotation near it."""
    m = np.asarray(m, dtype=np.float64)
    xx, yy, zz = m[..., 0, 0], m[..., 1, 1], m[..., 2, 2]
    # The products of the quaternion's parts, times four. Each row is the quaternion, times four times one of its parts:
    # that with the largest part loses no digits.
    products = np.empty((*m.shape[:-2], 4, 4))
    products[..., 0, 0] = 1 + xx + yy + zz
    products[..., 1, 1] = 1 + xx - yy - zz
    products[..., 2, 2] = 1 - xx + yy - zz
    products[..., 3, 3] = 1 - xx - yy + zz
    for i, j, k in ((0, 1, 2), (1, 2, 0), (2, 0, 1)):
        products[..., 0, 1 + i] = products[..., 1 + i, 0] = m[..., k, j] - m[..., j, k]
        products[..., 1 + i, 1 + j] = products[..., 1 + j, 1 + i] = m[..., i, j] + m[..., j, i]
    largest = np.argmax(np.einsum("...ii->...i", products), axis=-1)
    return normalize(np.take_along_axis(products, largest[..., None, None], axis=-2)[..., 0, :])


def from_rotation_vectors(vectors: ArrayLike) -> FloatArray:
    """Return unit quaternions (..., 4) of rotation vectors (..., 3): the axis, as long as the angle in radians."""
    v = np.asarray(vectors, dtype=np.float64)
    angle = np.sqrt(np.sum(v * v, axis=-1, keepdims=True))
    # sinc is 1 where the angle is 0: sin(angle / 2) / angle is one half there.
    return normalize(np.concatenate([np.cos(angle / 2), 0.5 * np.sinc(angle / (2 * np.pi)) * v], axis=-1))


def to_rotation_vectors(q: ArrayLike, *, near: ArrayLike | None = None) -> FloatArray:
    """Find rotation vectors of rotations: the axis, as long as the angle in radians.

    Whole turns about the axis can be added. Among these vectors this picks the one closest to `near`, so that what is
    written to a file stays continuous.

    Parameters
    ----------
    q : float array, shape (..., 4)
        Unit quaternions.
    near : float array, shape (..., 3), optional
        Vectors to stay close to. Left out: zeros, so that no angle is beyond half a turn.

    Returns
    -------
    float array, shape (..., 3)

    Examples
    --------
    >>> quarter = from_rotation_vectors([0.0, 0.0, np.pi / 2])
    >>> (to_rotation_vectors(quarter) / np.pi).round(9).tolist()
    [0.0, 0.0, 0.5]
    >>> ((to_rotation_vectors(quarter, near=[0.0, 0.0, -4.0]) / np.pi).round(9) + 0.0).tolist()
    [0.0, 0.0, -1.5]
    """
    q = np.asarray(q, dtype=np.float64)
    q = np.where(q[..., :1] < 0, -q, q)
    sine = np.sqrt(np.sum(q[..., 1:] ** 2, axis=-1, keepdims=True))
    angle = 2 * np.arctan2(sine, q[..., :1])
    # sin(angle / 2) / angle is one half at angle 0, where the quotient of both is nothing over nothing.
    vectors = q[..., 1:] / (0.5 * np.sinc(angle / (2 * np.pi)))
    if near is None:
        return np.asarray(vectors)
    near = np.asarray(near, dtype=np.float64)
    length = np.sqrt(np.sum(near * near, axis=-1, keepdims=True))
    # Where it hardly turns its axis says nothing: the one that is near will do.
    own = sine > 1e-9
    axis = np.where(own, q[..., 1:] / np.where(own, sine, 1.0), near / np.where(length > 0, length, 1.0))
    along = np.sum(axis * near, axis=-1, keepdims=True)
    turns = np.round((along - angle) / (2 * np.pi))
    return np.asarray(np.where(turns == 0, vectors, axis * (angle + 2 * np.pi * turns)))


def to_euler(order: str, q: ArrayLike, *, near: ArrayLike | None = None) -> FloatArray:
    """Find intrinsic Euler angles of rotations.

    Every rotation has many triples of angles. Among them this picks the one closest to `near`, so that curves
    written to a file stay continuous and a file's own angles come back.

    Parameters
    ----------
    order : str
        Three different letters of X, Y, Z.
    q : float array, shape (..., 4)
        Unit quaternions.
    near : float array, shape (..., 3), optional
        Angles to stay close to, radians. Left out: zeros.

    Returns
    -------
    float array, shape (..., 3)
        Radians. At gimbal lock (the middle angle at a right angle) the first angle is kept from `near`.
    """
    if sorted(order) != ["X", "Y", "Z"]:
        raise ValueError(f"expected three different axes, found {order!r}")
    i, j, k = (_AXIS[letter] for letter in order)
    sign = 1.0 if (j - i) % 3 == 1 else -1.0
    m = to_matrix(q)
    target = np.zeros((*m.shape[:-2], 3)) if near is None else np.asarray(near, dtype=np.float64)
    first = np.arctan2(-sign * m[..., j, k], m[..., k, k])
    horizontal = np.hypot(m[..., i, i], m[..., i, j])
    middle = np.arctan2(sign * m[..., i, k], horizontal)
    locked = horizontal < 1e-9
    first = np.where(locked, target[..., 0], first)
    # With the first turn undone, the last one can be read without the lock's 0/0.
    c, s = np.cos(first), np.sin(first)
    third = np.arctan2(
        sign * (c * m[..., j, i]) + s * m[..., k, i],
        c * m[..., j, j] + sign * s * m[..., k, j],
    )
    a = np.stack([first, middle, third], axis=-1)
    b = np.stack([first + np.pi, np.pi - middle, third + np.pi], axis=-1)
    b[..., 0] = np.where(locked, first, b[..., 0])
    b[..., 2] = np.where(locked, third, b[..., 2])
    a = a + 2 * np.pi * np.round((target - a) / (2 * np.pi))
    b = b + 2 * np.pi * np.round((target - b) / (2 * np.pi))
    closer = np.sum((a - target) ** 2, axis=-1) <= np.sum((b - target) ** 2, axis=-1)
    return np.where((closer | locked)[..., None], a, b)


def mean(q: ArrayLike, weights: ArrayLike, *, axis: int = 0) -> FloatArray:
    """Average rotations that lie close together.

    The weighted sum of quaternions, each flipped to the side of the middle one, scaled to unit length: for
    rotations within a few tens of degrees it agrees with the chordal mean to third order.

    Parameters
    ----------
    q : float array, shape (..., 4)
        Unit quaternions.
    weights : float array
        Broadcasts against ``q`` without its last axis; not negative, not all zero along `axis`.
    axis : int
        The axis to average over (not the last).
    """
    q = np.asarray(q, dtype=np.float64)
    w: Any = np.asarray(weights, dtype=np.float64)[..., None]
    middle = np.take(q, [q.shape[axis] // 2], axis=axis)
    side = np.where(np.sum(q * middle, axis=-1, keepdims=True) < 0, -1.0, 1.0)
    return normalize(np.sum(q * side * w, axis=axis))
