"""Timecode: hours, minutes, seconds and frames, as editing programs count.

At 29.97 Hz a timecode counts 30 frames to its second, so that it falls behind the clock by 3.6 s an hour. Drop-frame
timecode, written with a semicolon before the frames, catches up by skipping numbers (never frames): at the start of
every minute that ten does not divide, 00 and 01 are left out.
"""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction

from retime.errors import OptionError


@dataclass(frozen=True)
class Timecode:
    """A timecode as written; which frame it names depends on the rate.

    Attributes
    ----------
    hours, minutes, seconds, frames : int
        Its parts; minutes and seconds below 60.
    drop : bool
        Whether it counts as drop-frame timecode does.
    text : str
        As it was written, for messages.
    """

    hours: int
    minutes: int
    seconds: int
    frames: int
    drop: bool
    text: str

    def frame(self, rate: Fraction) -> int:
        """Return the frame that it names, counted from 0 at 00:00:00:00.

        Parameters
        ----------
        rate : Fraction
            Frames a second of the clip.

        Raises
        ------
        OptionError
            This rate has no timecode, no drop-frame timecode, or none with this many frames.

        Examples
        --------
        >>> Timecode(0, 0, 3, 15, drop=False, text="00:00:03:15").frame(Fraction(60))
        195
        >>> Timecode(0, 1, 0, 2, drop=True, text="00:01:00;02").frame(Fraction(30000, 1001))
        1800
        """
        counted = counted_rate(rate)
        if counted is None:
            raise OptionError(
                "a timecode needs a whole rate, or one such as 23.976 or 29.97, and the clip has "
                f"{float(rate):.6g} Hz: write seconds or frames, found {self.text!r}"
            )
        if self.frames >= counted:
            raise OptionError(
                f"frames of a timecode go from 0 to {counted - 1} at {float(rate):.6g} Hz, found {self.text!r}"
            )
        minutes = 60 * self.hours + self.minutes
        number = (60 * minutes + self.seconds) * counted + self.frames
        if not self.drop:
            return number
        if rate.denominator != 1001 or counted % 30:
            raise OptionError(
                f"drop-frame timecode (with ;) is for 29.97 and 59.94 Hz, and the clip has {float(rate):.6g} Hz: "
                f"write : before the frames, found {self.text!r}"
            )
        skipped = counted // 15
        if self.seconds == 0 and self.frames < skipped and self.minutes % 10:
            raise OptionError(
                f"drop-frame timecode has no frames 0 to {skipped - 1} at the start of a minute that ten does not "
                f"divide, found {self.text!r}"
            )
        return number - skipped * (minutes - minutes // 10)


def counted_rate(rate: Fraction) -> int | None:
    """Return how many frames a timecode counts to its second, or None where the rate has no timecode.

    Examples
    --------
    >>> counted_rate(Fraction(120)), counted_rate(Fraction(24000, 1001)), counted_rate(Fraction(25, 2))
    (120, 24, None)
    """
    if rate.denominator == 1:
        return rate.numerator
    counted = rate * 1001 / 1000
    return counted.numerator if counted.denominator == 1 else None
