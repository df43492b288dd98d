"""Animation curves, literally: one segment, one time, plain numbers; a Bézier curve is solved by halving."""

from __future__ import annotations

import math

STEP, LINEAR, CUBIC, SLERP = range(4)


def value_at(times, values, kinds, end_value, time: float) -> list[float]:
    """Evaluate a curve; at a key, what begins there."""
    if len(times) and time < times[0][0]:
        return list(values[0][0])
    for handles, points, kind in zip(times, values, kinds, strict=True):
        if handles[0] <= time < handles[3]:
            return _within(handles, points, kind, time)
    return list(end_value)


def _within(handles, points, kind, time):
    if kind == STEP:
        return list(points[0])
    share = (time - handles[0]) / (handles[3] - handles[0])
    if kind == LINEAR:
        return [a + (b - a) * share for a, b in zip(points[0], points[3], strict=True)]
    if kind == SLERP:
        return slerp(points[0], points[3], share)
    low, high = 0.0, 1.0
    for _ in range(200):
        middle = (low + high) / 2
        if _bezier([h - handles[0] for h in handles], middle) <= time - handles[0]:
            low = middle
        else:
            high = middle
    return [_bezier(column, low) for column in zip(*points, strict=True)]


def _bezier(p, u):
    return (1 - u) ** 3 * p[0] + 3 * (1 - u) ** 2 * u * p[1] + 3 * (1 - u) * u**2 * p[2] + u**3 * p[3]


def slerp(a, b, share):
    """Turn from one quaternion to another, evenly and the short way."""
    cosine = sum(x * y for x, y in zip(a, b, strict=True))
    if cosine < 0:
        b, cosine = [-y for y in b], -cosine
    angle = math.acos(min(cosine, 1.0))
    if angle < 1e-7:
        return [x + (y - x) * share for x, y in zip(a, b, strict=True)]
    first, second = (math.sin(s * angle) / math.sin(angle) for s in (1 - share, share))
    return [first * x + second * y for x, y in zip(a, b, strict=True)]
