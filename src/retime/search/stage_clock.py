"""How long the stages of a search took."""

from __future__ import annotations

import time


class StageClock:
    """Measures the stages of a job."""

    def __init__(self) -> None:
        self._last = time.perf_counter()

    def lap(self) -> float:
        """Return the seconds since the last lap."""
        now = time.perf_counter()
        lap, self._last = now - self._last, now
        return lap
