"""What a signal shows between frames, one number at a time, as one would say it."""

from __future__ import annotations

import math

from retime.motion.channels import FULL_TURN, ChannelKind


def shown(column: list[float], kind: ChannelKind, place: float) -> float:
    """Show one channel (no quaternion, no event) at a place in frames."""
    place = min(max(place, 0.0), len(column) - 1.0)
    before = math.floor(place)
    share = place - before
    if share == 0:
        return column[before]
    a, b = column[before], column[before + 1]
    if kind.kind == "label":
        return a if share < 0.5 else b
    if kind.kind == "angle":
        turn = FULL_TURN[kind.unit]
        while b - a > turn / 2:
            b -= turn
        while b - a < -turn / 2:
            b += turn
    return a + share * (b - a)


def turned(a: list[float], b: list[float], share: float) -> list[float]:
    """Turn evenly from one unit quaternion to another, the short way."""
    dot = sum(x * y for x, y in zip(a, b, strict=True))
    if dot < 0:
        b, dot = [-x for x in b], -dot
    angle = math.acos(min(dot, 1.0))
    if angle < 1e-7:
        return [x + share * (y - x) for x, y in zip(a, b, strict=True)]
    weights = math.sin((1 - share) * angle) / math.sin(angle), math.sin(share * angle) / math.sin(angle)
    return [weights[0] * x + weights[1] * y for x, y in zip(a, b, strict=True)]


def events_forward(column: list[float], places: list[float]) -> list[float]:
    """Show events at increasing places: each by the output frame that is nearest to it, the first of two alike."""
    out = [0.0] * len(places)
    for frame in reversed(range(len(column))):
        if column[frame] == 0:
            continue
        away = [abs(place - frame) for place in places]
        nearest = away.index(min(away))
        inside = places[0] - 0.5 < frame <= places[-1] + 0.5
        if inside:
            out[nearest] = column[frame]
    return out
