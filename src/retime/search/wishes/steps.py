"""Steps of the search and the speeds that they play."""

from __future__ import annotations

import math
from dataclasses import dataclass

from retime.limits import MAX_STEP

# A step may be beyond a limit by so much: that is rounding.
_CLOSE = 1e-6
# A fixed speed may be played by a step that differs from it by this share.
_NEAR = 0.03


@dataclass(frozen=True)
class Named:
    """The limits that a person set by name: messages name these, and speak of all others as speeds.

    Attributes
    ----------
    upsample, max_skip : int, optional
        None where it was left out, and chosen.
    """

    upsample: int | None = None
    max_skip: int | None = None

    @property
    def names(self) -> tuple[str, ...]:
        """The names of those that are set."""
        return tuple(name for name in ("upsample", "max_skip") if getattr(self, name) is not None)

    def __str__(self) -> str:
        return " and ".join(f"{name}={getattr(self, name)}" for name in self.names)


NOTHING_NAMED = Named()


def fixed_step(speed: float, upsample: int, most: int = MAX_STEP) -> int | None:
    """Return the step nearest to a fixed speed, if it is near enough."""
    # Beyond the longest step a speed may be any, up to what no integer holds.
    step = max(1, round(min(speed * upsample, 2.0 * MAX_STEP)))
    return step if step <= most and abs(step - speed * upsample) <= _NEAR * speed * upsample else None


def steps_between(slowest: float, fastest: float, upsample: int, most: int = MAX_STEP) -> range:
    """Return the steps whose speed lies in a range."""
    return range(
        max(1, math.ceil(min(slowest * upsample, 2.0 * MAX_STEP) - _CLOSE)),
        math.floor(min(fastest * upsample, float(most)) + _CLOSE) + 1,
    )


def slowest_words(upsample: int) -> str:
    """Write the speed of the shortest step."""
    return "1" if upsample == 1 else f"1/{upsample}"


def playable(upsample: int, max_skip: int, named: Named) -> str:
    """Say which speeds can be played, for messages."""
    by = f"with {named} " if named.names else ""
    return f"{by}speeds are multiples of {slowest_words(upsample)}, up to {max_skip / upsample:g}"
