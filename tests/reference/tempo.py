"""The price on tempo by its definition, number by number: METHOD's sums written out."""

from __future__ import annotations

import math
from collections.abc import Sequence


def movement(poses: Sequence[Sequence[float]], rate: float, time_scale: float) -> list[float]:
    """τ |y'| of every frame, averaged over a Hann window of 0.3 s; frames beyond the ends are as the ends."""
    n = len(poses)
    speeds = []
    for frame in range(n):
        before, after = max(frame - 1, 0), min(frame + 1, n - 1)
        seconds = max(after - before, 1) / rate
        change = math.sqrt(sum((b - a) ** 2 for a, b in zip(poses[before], poses[after], strict=True)))
        speeds.append(time_scale * change / seconds)
    width = max(1, round(0.3 * rate))
    weights = [math.sin(math.pi * (i + 1) / (width + 1)) ** 2 for i in range(width)]
    return [
        sum(weight * speeds[min(max(frame + i - width // 2, 0), n - 1)] for i, weight in enumerate(weights))
        / sum(weights)
        for frame in range(n)
    ]


def activity(moved: Sequence[float]) -> tuple[float, list[float]]:
    """The clip's scale, and for each frame 1.09 m² / (m² + (0.3 r)²)."""
    scale = math.sqrt(sum(m * m for m in moved) / len(moved))
    return scale, [1.09 * m * m / (m * m + (0.3 * scale) ** 2) if scale else 0.0 for m in moved]


def price(
    step: int,
    upsample: int,
    activities: Sequence[float],
    flying: Sequence[float],
    *,
    scale: float,
    evenness: float,
    keep_flights: float,
) -> float:
    """What a step costs that passes frames of these activities (its ends included)."""
    v = step / upsample
    a, f = sum(activities) / len(activities), sum(flying) / len(flying)
    return scale * max(1.0, v) * (evenness * a * math.log(v) ** 2 + keep_flights * f * abs(math.log(v)))
