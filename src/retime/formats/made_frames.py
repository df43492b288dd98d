"""How many frames may be made between those that a file holds: what a few of them claim is not taken on their word."""

from __future__ import annotations

from retime.limits import MOST_NUMBERS

# So many frames, of so many numbers, or so many of each that is there.
_MOST_FRAMES = 1 << 18
_MOST_NUMBERS_MADE = 1 << 22
_OF_ONE = 100


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
    numbers = n_frames * n_channels
    return (
        n_frames > max(_MOST_FRAMES, _OF_ONE * n_rows)
        or numbers > max(_MOST_NUMBERS_MADE, _OF_ONE * n_numbers)
        or numbers > max(MOST_NUMBERS, n_numbers)
    )
