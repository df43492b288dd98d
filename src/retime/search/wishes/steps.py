"""Steps of the search and the speeds that they play."""

from __future__ import annotations

import math

# The kernels keep a step in a byte.
MAX_STEP = 255


_CLOSE = 1e-6


# How far a step may be from a fixed speed that it stands for.
_NEAR = 0.03


def fixed_step(speed: float, upsample: int, most: int = MAX_STEP) -> int | None:
    """Return the step nearest to a fixed speed, if it is near enough."""
    step = max(1, round(speed * upsample))
    return step if step <= most and abs(step - speed * upsample) <= _NEAR * speed * upsample else None


def steps_between(slowest: float, fastest: float, upsample: int, most: int = MAX_STEP) -> range:
    """Return the steps whose speed lies in a range."""
    return range(
        max(1, math.ceil(slowest * upsample - _CLOSE)),
        math.floor(min(fastest * upsample, float(most)) + _CLOSE) + 1,
    )


def playable(upsample: int, max_skip: int) -> str:
    """Say which speeds steps play, for messages."""
    least = "1" if upsample == 1 else f"1/{upsample}"
    return f"they play multiples of {least} up to {max_skip / upsample:g}"
