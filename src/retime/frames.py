"""Where a time falls among frames, and which frames a range names: one rule for motions, signals and arrays."""

from __future__ import annotations

import operator
from fractions import Fraction
from typing import SupportsIndex

import numpy as np
from numpy.typing import ArrayLike

from retime.arrays import FloatArray, as_real
from retime.brief import kind_of
from retime.errors import OptionError


def frame_positions(
    input_times: ArrayLike, rate: Fraction | float, n_frames: int
) -> tuple[np.ndarray, np.ndarray, FloatArray]:
    """Place times between frames.

    Times within about a billionth of a frame of a frame are taken to be that frame, so that a motion sampled at its own
    frames comes back bit for bit; times outside the motion are held at its ends.

    Parameters
    ----------
    input_times : float array, any shape
        Seconds from the first frame.
    rate : Fraction or float
        Frames a second.
    n_frames : int
        Number of frames, at least 1.

    Returns
    -------
    before, after : int arrays
        Neighbouring frames.
    fraction : float array
        How far from `before` to `after`, in [0, 1).

    Raises
    ------
    OptionError
        A time is not a number.
    """
    times = as_real(input_times, "times", error=OptionError)
    if np.isnan(times).any():
        raise OptionError(f"time {int(np.argwhere(np.isnan(times.ravel()))[0, 0])} of {times.size} is not a number")
    place = np.clip(times * float(rate), 0.0, n_frames - 1)
    whole = np.round(place)
    # Far into a long motion the rounding of a frame's own time is more than that billionth.
    place = np.where(np.abs(place - whole) < 1e-9 + 1e-15 * place, whole, place)
    before = np.floor(place).astype(np.intp)
    after = np.minimum(before + 1, n_frames - 1)
    return before, after, place - before


def frame_range(start: SupportsIndex, stop: SupportsIndex, n_frames: int, name: str) -> tuple[int, int]:
    """Check a range of frames, ``start`` to ``stop - 1``, counted from 0.

    Raises
    ------
    OptionError
        The range is empty, leaves the clip, or is not made of whole numbers.
    """
    try:
        first, end = operator.index(start), operator.index(stop)
    except TypeError:
        raise OptionError(f"frames are counted in whole numbers; found {start!r} and {stop!r}") from None
    if not 0 <= first < end <= n_frames:
        raise OptionError(f"frames {first} to {end - 1} are not inside {name}, which has frames 0 to {n_frames - 1}")
    return first, end


def slice_range(index: object, n_frames: int, name: str) -> tuple[int, int]:
    """Turn ``clip[start:stop]`` into a range of frames; as in a list, ends count from the end where below 0.

    Raises
    ------
    OptionError
        Not a slice, one with a step, or one that holds no frame.
    """
    if not isinstance(index, slice):
        found = f"[{index}]" if isinstance(index, SupportsIndex) else kind_of(index)
        raise OptionError(f"a clip is cut by a slice, clip[10:20]; one frame is clip[10:11]; found {found}")
    if index.step not in (None, 1):
        raise OptionError(
            f"a clip is cut in one piece, not with a step of {index.step!r}; for other times of it, and another rate: "
            "clip.at(times).with_rate(rate)"
        )
    try:
        start, stop, _ = index.indices(n_frames)
    except TypeError:
        raise OptionError(f"frames are counted in whole numbers; found {index.start!r} and {index.stop!r}") from None
    if start >= stop:
        raise OptionError(f"frames {index.start} to {index.stop} of {name}, which has {n_frames}, are none")
    return start, stop
