"""A mix of two warps, by a share that may change over time (§5)."""

from __future__ import annotations

import itertools

import numpy as np
from numpy.typing import ArrayLike

from retime.arrays import FloatArray, as_real
from retime.errors import OptionError
from retime.warp.curve import Warp
from retime.warp.knots import add_times


def blend(a: Warp, b: Warp, weight: ArrayLike) -> Warp:
    """Mix two warps of the same ends: ``(1 - weight) a + weight b`` (§5).

    A mix of monotone maps is monotone where the weight is constant. A weight that changes with time can turn it
    back; between two keytimes where that happens, the weight's changes are scaled down to the most that keep the
    mix monotone.

    Parameters
    ----------
    a, b : Warp
        With the same output range. The result has `a`'s keytimes.
    weight : float, or float array of shape (n, 2)
        0 gives `a`, 1 gives `b`. An array is a curve: output times (seconds, increasing) and weights, straight
        lines in between, constant outside.

    Raises
    ------
    OptionError
        Different ranges, or weights that are not from 0 to 1.

    Examples
    --------
    >>> slow, fast = Warp([0.0, 1.0, 2.0], [0.0, 0.5, 2.0]), Warp([0.0, 1.0, 2.0], [0.0, 1.5, 2.0])
    >>> float(blend(slow, fast, 0.5)(1.0))
    1.0
    """
    curve = as_shares(weight)
    if not np.allclose([a.output_start, a.output_end], [b.output_start, b.output_end], rtol=0, atol=1e-9):
        raise OptionError(
            f"only warps of the same output range can be mixed: {a.output_start:g}–{a.output_end:g} s and "
            f"{b.output_start:g}–{b.output_end:g} s"
        )
    inner = b.output_times if curve.ndim == 0 else np.concatenate([b.output_times, curve[:, 0]])
    times = add_times(a.output_times, inner[(inner > a.output_start) & (inner < a.output_end)])
    one, other = a(times), b(times)
    other[0], other[-1] = b.input_times[0], b.input_times[-1]
    if curve.ndim == 0:
        # Written like this, times on which both agree stay the same to the last bit.
        mixed = one + float(curve) * (other - one) if curve < 1 else other
        return Warp(times, mixed, a.keytimes, method="blend", name=a.name)
    share = np.interp(times, curve[:, 0], curve[:, 1])
    inner_keys = [key.output_time for key in a.keytimes if a.output_start < key.output_time < a.output_end]
    ends = np.unique(np.searchsorted(times, [a.output_start, *inner_keys, a.output_end]))
    mixed = one.copy()
    for first, last in itertools.pairwise(ends.tolist()):
        piece = slice(first, last + 1)
        mixed[piece] = _mix_monotone(one[piece], other[piece], share[piece])
    return Warp(times, mixed, a.keytimes, method="blend", name=a.name)


def as_shares(weight: ArrayLike, what: str = "the weights of a blend") -> FloatArray:
    """Take a share from 0 to 1, or a curve of them: rows of (output time, share) with times that increase.

    `what` is what messages call it.

    Raises
    ------
    OptionError
        Neither of them.
    """
    curve = as_real(weight, what, error=OptionError)
    if curve.ndim != 0 and curve.size == 0:
        raise OptionError("a blend's curve needs one or more rows of (output time, weight)", option="influence")
    if not np.all((curve if curve.ndim == 0 else curve[..., -1]) >= 0) or not np.all(
        (curve if curve.ndim == 0 else curve[..., -1]) <= 1
    ):
        raise OptionError(f"{what} must be from 0 to 1, found {weight!r}", option="influence")
    if curve.ndim != 0 and (
        curve.ndim != 2 or curve.shape[1:] != (2,) or not np.all(np.diff(curve[:, 0], prepend=-np.inf) > 0)
    ):
        raise OptionError(
            "a blend's curve needs rows of (output time, weight) with times that increase", option="influence"
        )
    return curve


def _mix_monotone(one: FloatArray, other: FloatArray, share: FloatArray) -> FloatArray:
    """Mix one span by a changing share; scale the share's changes down until the mix never turns back."""
    sign = np.sign(one[-1] - one[0])

    def mixed(scale: float) -> FloatArray:
        weight = middle + scale * (share - middle)
        # A weight of 1 gives the other one to the last bit.
        return np.where(weight == 1.0, other, one + weight * (other - one))

    def turns(values: FloatArray) -> bool:
        return bool(np.any(np.diff(values) * sign < 0))

    middle = float(share.mean())
    if sign == 0 or not turns(mixed(1.0)) or turns(one) or turns(other):
        return mixed(1.0)
    low, high = 0.0, 1.0
    for _ in range(40):
        scale = (low + high) / 2
        low, high = (low, scale) if turns(mixed(scale)) else (scale, high)
    return mixed(low)
