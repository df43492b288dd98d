"""What is asked for beside keytimes, as one value."""

from __future__ import annotations

import math
from dataclasses import dataclass

from retime.search.wishes.locks import Lock


@dataclass(frozen=True)
class Wishes:
    """What is asked for beside keytimes.

    Attributes
    ----------
    input_end : float
        Time of the last input frame, seconds.
    locks : tuple of Lock
        Spans of the input at given speeds.
    tangents : tuple of float
        Speeds at keytimes.
    slowest, fastest : float
        Playback speeds for the whole clip.
    """

    input_end: float
    locks: tuple[Lock, ...]
    tangents: tuple[float, ...]
    slowest: float
    fastest: float

    @property
    def any(self) -> bool:
        """Whether there is a lock, a tangent or a speed limit."""
        return bool(self.locks or self.tangents) or self.slowest > 0 or self.fastest < math.inf

    @property
    def speeds(self) -> tuple[tuple[Lock, ...], tuple[float, ...], float, float]:
        """Locks, tangents and limits, as `retime.search.wishes.upsampling.upsample_for` takes them."""
        return self.locks, self.tangents, self.slowest, self.fastest

    def __str__(self) -> str:
        words = ["the locks"] if self.locks else []
        words += ["the tangents"] if self.tangents else []
        words += ["the speed limits"] if self.slowest > 0 or self.fastest < math.inf else []
        return " and ".join(words)
