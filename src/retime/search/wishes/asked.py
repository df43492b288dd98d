"""What is asked for beside keytimes, as one value."""

from __future__ import annotations

import math
from dataclasses import dataclass

from retime.search.wishes.locks import Lock
from retime.warp.keytime import Keytime


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
        return bool(self.locks or self.tangents) or self._limited

    @property
    def speeds(self) -> tuple[tuple[Lock, ...], tuple[float, ...], float, float]:
        """Locks, tangents and limits, as `retime.search.wishes.upsampling.upsample_for` takes them."""
        return self.locks, self.tangents, self.slowest, self.fastest

    def words_at(self, keytimes: tuple[Keytime, Keytime], *, seam: bool = False) -> str:
        """Name what is asked for between two keytimes."""
        low, high = sorted(key.input_time for key in keytimes)
        locks = [lock for lock in self.locks if lock.start < high and lock.end > low]
        words = [f"the lock{'s' * (len(locks) > 1)} {', '.join(map(str, locks))}"] if locks else []
        words += ["the tangents"] if any(key.speed is not None for key in keytimes) else []
        words += [f"the speed limits {self.slowest:g} to {self.fastest:g}"] if self._limited else []
        words += ["one speed at the loop's seam"] if seam else []
        return " and ".join(words) or "what was asked for"

    @property
    def _limited(self) -> bool:
        return self.slowest > 0 or self.fastest < math.inf

    def __str__(self) -> str:
        words = ["the locks"] if self.locks else []
        words += ["the tangents"] if self.tangents else []
        words += ["the speed limits"] if self._limited else []
        return " and ".join(words)
