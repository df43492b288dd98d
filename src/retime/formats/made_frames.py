"""How many frames may be made between those that a file holds: what a few of them claim is not taken on their word."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from retime.arrays import FloatArray
from retime.brief import brief_repr
from retime.limits import MOST_NUMBERS

# So many frames, of so many numbers, or so many of each that is there.
_MOST_FRAMES = 1 << 18
_MOST_NUMBERS_MADE = 1 << 22
_OF_ONE = 100
# Between the keys of a scene frames are made in any case, and of every node, though few of them have keys.
_MOST_NUMBERS_SAMPLED = 1 << 25
_OF_ONE_KEY = 1000
# A stretch without a key that is worth a word: so many frames, and so large a share of all.
_LONG_STRETCH, _MOST_OF_IT = 10_000, 0.9
# Keys that are worth a word where so few frames show them.
_MANY_KEYS, _KEYS_OF_A_FRAME = 8, 4


def too_many_made(n_frames: int, n_channels: int, *, n_rows: int, n_numbers: int) -> bool:
    """Tell whether a clip has so many frames that a time or a number in its file is wrong, more likely than not.

    One time that is hours off makes millions of frames of a few.

    Parameters
    ----------
    n_frames, n_channels : int
        Of the clip that would be made.
    n_rows, n_numbers : int
        What the file holds.
    """
    return _beyond(n_frames, n_channels, n_rows, n_numbers, _MOST_NUMBERS_MADE, _OF_ONE)


def _beyond(n_frames: int, n_channels: int, n_rows: int, n_numbers: int, most_numbers: int, of_one: int) -> bool:
    numbers = n_frames * n_channels
    return (
        n_frames > max(_MOST_FRAMES, of_one * n_rows)
        or numbers > max(most_numbers, of_one * n_numbers)
        or numbers > max(MOST_NUMBERS, n_numbers)
    )


@dataclass(frozen=True, eq=False)
class Sampling:
    """The frames that are made of a scene's keys.

    Attributes
    ----------
    start, end : float
        Seconds: what the scene spans.
    rate : float
        Frames a second.
    n_frames, n_channels : int
        Of the clip that would be made.
    n_numbers : int
        What the keys hold.
    keys : float array
        When they are, in any order, seconds; those outside of the span don't count.
    """

    start: float
    end: float
    rate: float
    n_frames: int
    n_channels: int
    n_numbers: int
    keys: FloatArray

    __repr__ = brief_repr

    def _places(self) -> tuple[FloatArray, int]:
        """Return the ends of the span and the keys within, each time once, and how many of them are keys."""
        within = np.unique(self.keys[(self.keys >= self.start) & (self.keys <= self.end)])
        return np.unique(np.concatenate([within, [self.start, self.end]])), len(within)

    def _stretch(self, places: FloatArray) -> tuple[float, str]:
        """Return how long no key is at most, seconds, and the words for it."""
        steps = np.diff(places)
        longest = int(steps.argmax())
        words = f"no key lies between {places[longest]:.6g} and {places[longest + 1]:.6g} s"
        return float(steps[longest]), words

    def problem(self) -> str | None:
        """Say why so many frames are not made; None where they are."""
        places, n_keys = self._places()
        made = self.n_frames, self.n_channels, n_keys, self.n_numbers
        if not _beyond(*made, _MOST_NUMBERS_SAMPLED, _OF_ONE_KEY):
            return None
        return (
            f"lasts {self.end - self.start:.6g} s, and {self._stretch(places)[1]}: {self.n_frames} frames "
            f"would be made of keys at {n_keys} times; is that time right? A lower rate makes fewer (--fps)"
        )

    def doubt(self) -> str | None:
        """Say that nearly all frames, which are many, lie where no key does, or that most keys are shown by none."""
        places, n_keys = self._places()
        if n_keys > _MANY_KEYS and n_keys > _KEYS_OF_A_FRAME * self.n_frames:
            return (
                f"lasts {self.end - self.start:.3g} s, and has keys at {n_keys} times, of which {self.n_frames} frames "
                f"at {self.rate:.6g} Hz are made: is its clock right? A higher rate makes more (--fps)"
            )
        if self.n_frames <= _LONG_STRETCH:
            return None
        longest, words = self._stretch(places)
        if longest * self.rate <= _LONG_STRETCH or longest < _MOST_OF_IT * (self.end - self.start):
            return None
        return f"lasts {self.end - self.start:.6g} s, {self.n_frames} frames, and {words}: is that time right?"
