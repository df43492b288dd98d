"""The clock of a signal: how its file counts time, so that it can be written as it was read."""

from __future__ import annotations

from dataclasses import dataclass, replace
from fractions import Fraction
from typing import Literal, get_args

from retime.errors import OptionError

ClockForm = Literal["s", "ms", "us", "ns", "frames", "timecode", "date"]
TICKS = {"s": 1, "ms": 10**3, "us": 10**6, "ns": 10**9}
"""How many there are in a second, of each form that is a number of them."""
LONGEST_CLIP = 10**7
"""Seconds: later than this is no clip, so that times count from some day."""
_SAID = {
    "s": "seconds",
    "ms": "milliseconds",
    "us": "microseconds",
    "ns": "nanoseconds",
    "frames": "frames",
    "timecode": "timecode",
    "date": "date and time of day",
}


@dataclass(frozen=True)
class Clock:
    """How a file writes the times of its rows, and when the first one is.

    Attributes
    ----------
    form : {"s", "ms", "us", "ns", "frames", "timecode", "date"}
        Seconds and parts of them; the numbers of frames; ``hh:mm:ss:ff``; ``2024-05-01T12:00:00.033Z``, or the time of
        day alone.
    start : Fraction, optional
        The time of the first frame, seconds: of a timecode and a time of day since midnight, of a date since 1970.
        Where it is not known, frames are counted from time 0.
    sample : str
        The first time as written: it shows how many decimals there are, and what stands between.
    base : int
        Frames that a timecode counts to its second.

    Examples
    --------
    >>> Clock("ms", Fraction(5, 2), "2500").later(Fraction(1, 2)).start
    Fraction(3, 1)
    """

    form: ClockForm = "s"
    start: Fraction | None = None
    sample: str = ""
    base: int = 0

    def __post_init__(self) -> None:
        if self.form not in get_args(ClockForm):
            raise OptionError(f"the form of a clock is one of {', '.join(get_args(ClockForm))}; found {self.form!r}")
        if self.form == "timecode" and self.base < 1:
            raise OptionError(f"a timecode counts 1 frame a second or more; found {self.base}")

    def __str__(self) -> str:
        counted = f", {self.base} frames to a second" if self.form == "timecode" else ""
        if self.form in ("timecode", "date"):
            return f"{_SAID[self.form]}{counted}, such as {self.sample}"
        return _SAID[self.form] + ("" if self.start is None else f", from {float(self.start):.10g} s")

    @property
    def origin(self) -> Literal["clip", "midnight", "date", "1970"]:
        """What its times count from: clocks can be compared where that is the same.

        Dates have time zones, which numbers since 1970 have not, so these two are not the same.
        """
        since_long_ago = self.start is not None and abs(self.start) > LONGEST_CLIP
        if self.form in ("timecode", "date"):
            return "date" if since_long_ago else "midnight"
        return "1970" if since_long_ago else "clip"

    def later(self, seconds: Fraction) -> Clock:
        """Let the first frame be some seconds later, as where frames before it are cut off."""
        return self if self.start is None or not seconds else replace(self, start=self.start + seconds)
