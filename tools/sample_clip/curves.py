"""Curves over time that the parts of the figure follow."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from retime.arrays import FloatArray
from sample_clip.plan import FINE, RATE, TIMES

Knot = tuple[float, ...]  # time, value, and as far as given: rate, acceleration
AFTER: Knot = (float(TIMES[-1]) + 1.0, 0.0)


def quintic(knots: Sequence[Knot], times: FloatArray, order: int = 0) -> FloatArray:
    """Evaluate the curve, or a derivative, that takes value, rate and acceleration at each knot (0 where left out).

    Held flat outside.
    """
    table = np.array([tuple(knot) + (0.0,) * (4 - len(knot)) for knot in knots])
    place = np.clip(np.searchsorted(table[:, 0], times, side="right") - 1, 0, len(table) - 2)
    a, b = table[place], table[place + 1]
    span = b[:, 0] - a[:, 0]
    s = (times - a[:, 0]) / span
    inside = (s >= 0.0) & (s <= 1.0)
    s = np.clip(s, 0.0, 1.0)
    p0, v0, a0 = a[:, 1], a[:, 2] * span, a[:, 3] * span**2
    p1, v1, a1 = b[:, 1], b[:, 2] * span, b[:, 3] * span**2
    c = (
        p0,
        v0,
        a0 / 2,
        10 * (p1 - p0) - 6 * v0 - 4 * v1 - (3 * a0 - a1) / 2,
        -15 * (p1 - p0) + 8 * v0 + 7 * v1 + (3 * a0 - 2 * a1) / 2,
        6 * (p1 - p0) - 3 * (v0 + v1) - (a0 - a1) / 2,
    )
    result = np.zeros_like(s)
    for power in range(order, 6):
        factor = np.prod(np.arange(power, power - order, -1))
        result = result + c[power] * factor * s ** (power - order)
    return result / span**order if order == 0 else np.where(inside, result / span**order, 0.0)


def soften(values: FloatArray, seconds: float) -> FloatArray:
    """Blur along the first axis with a Gaussian; the ends are held."""
    reach = int(np.ceil(4 * seconds * RATE * FINE))
    kernel = np.exp(-0.5 * (np.arange(-reach, reach + 1) / (seconds * RATE * FINE)) ** 2)
    padded = np.pad(values, [(reach, reach)] + [(0, 0)] * (values.ndim - 1), mode="edge")
    columns = padded.reshape(len(padded), -1).T
    blurred = np.array([np.convolve(column, kernel / kernel.sum(), mode="valid") for column in columns])
    return blurred.T.reshape(values.shape)


def flow(keys: Sequence[tuple[float, float]], seconds: float = 0.03) -> FloatArray:
    """Pass near keys without overshooting any: monotone cubic pieces, a little blurred."""
    t, v = np.array(keys).T
    steps, slopes = np.diff(t), np.diff(v) / np.diff(t)
    rates = np.zeros(len(t))
    same = slopes[:-1] * slopes[1:] > 0
    w0, w1 = 2 * steps[1:] + steps[:-1], steps[1:] + 2 * steps[:-1]
    with np.errstate(divide="ignore", invalid="ignore"):
        rates[1:-1] = np.where(same, (w0 + w1) / (w0 / slopes[:-1] + w1 / slopes[1:]), 0.0)
    place = np.clip(np.searchsorted(t, TIMES, side="right") - 1, 0, len(t) - 2)
    s = np.clip((TIMES - t[place]) / steps[place], 0.0, 1.0)
    h = steps[place]
    curve = (
        v[place] * (1 + 2 * s) * (1 - s) ** 2
        + rates[place] * h * s * (1 - s) ** 2
        + v[place + 1] * s**2 * (3 - 2 * s)
        + rates[place + 1] * h * s**2 * (s - 1)
    )
    return soften(curve, seconds)


def wander(seed: int) -> FloatArray:
    """Sway slowly between about -1 and 1, never quite repeating; another `seed`, another course."""
    phase = 2 * np.pi * np.modf(seed * np.array([0.618034, 0.754878, 0.569840]))[0]
    speed = 2 * np.pi * np.array([0.21, 0.37, 0.61]) * (1 + 0.13 * np.sin(3.0 * seed))
    return np.asarray(np.sin(TIMES[:, None] * speed + phase) @ np.array([0.5, 0.35, 0.2]))
