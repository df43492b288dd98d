"""An F-curve evaluated at one frame, by Blender's rules read literally."""

from __future__ import annotations

import math


def fcurve_value(keys, frame):
    """Return what keys have at a frame: held or straight on beyond the ends, else by the key before it."""
    times, values = keys.times.tolist(), keys.values.tolist()
    if frame < times[0]:
        return values[0] - _slope(keys, 0) * (times[0] - frame)
    if frame >= times[-1]:
        return values[-1] + _slope(keys, len(times) - 1) * (frame - times[-1])
    i = max(key for key in range(len(times)) if times[key] <= frame)
    code = int(keys.interpolation[i])
    if code == 0:
        return values[i]
    if code == 1:
        return values[i] + (frame - times[i]) / (times[i + 1] - times[i]) * (values[i + 1] - values[i])
    width = times[i + 1] - times[i]
    points = [(times[i], values[i])]
    for key, handle in ((i, keys.right[i]), (i + 1, keys.left[i + 1])):
        # A handle that is longer than its segment is shortened to it.
        reach = abs(handle[0] - times[key])
        share = width / reach if reach > width else 1.0
        x = times[key] + share * (handle[0] - times[key])
        points.append((x, values[key] + share * (handle[1] - values[key])))
    points.append((times[i + 1], values[i + 1]))
    low, high = 0.0, 1.0
    for _ in range(200):
        u = (low + high) / 2
        if _bezier([x for x, _ in points], u) < frame:
            low = u
        else:
            high = u
    return _bezier([y for _, y in points], (low + high) / 2)


def _bezier(p, u):
    v = 1 - u
    return v**3 * p[0] + 3 * v * v * u * p[1] + 3 * v * u * u * p[2] + u**3 * p[3]


def _slope(keys, key):
    code = int(keys.interpolation[key])
    if not keys.straight_on or code == 0:
        return 0.0
    if code == 1:
        if len(keys.times) == 1:
            return 0.0
        other = 1 if key == 0 else key - 1
        return float((keys.values[other] - keys.values[key]) / (keys.times[other] - keys.times[key]))
    handle = keys.left[key] if key == 0 else keys.right[key]
    width = handle[0] - keys.times[key]
    return float((handle[1] - keys.values[key]) / width) if width else 0.0


def cycled_frame(keys, frame, mode, counts):
    """Return the frame between the first key and the last that a Cycles modifier shows, and what it adds to values."""
    first, last = float(keys.times[0]), float(keys.times[-1])
    width, height = last - first, float(keys.values[-1] - keys.values[0])
    if first <= frame <= last:
        return frame, 0.0
    times_round = math.floor((frame - first) / width)
    most = counts[1] if frame > last else counts[0]
    if most and (frame > last + most * width or frame < first - most * width):
        return frame, 0.0
    inner = frame - times_round * width
    if mode == "MIRROR" and times_round % 2:
        inner = first + last - inner
    return inner, height * times_round if mode == "REPEAT_OFFSET" else 0.0
