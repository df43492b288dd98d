"""What moves, and what it is to move like, whichever way people hand it over: a clip, an array, several clips."""

from __future__ import annotations

import warnings
from collections.abc import Sequence
from typing import cast

import numpy as np
from numpy.typing import ArrayLike

from retime.arrays import as_real
from retime.brief import kind_of
from retime.errors import OptionError, RetimeWarning
from retime.motion.any_motion import AnyMotion
from retime.motion.rate import parse_rate
from retime.motion.signal import Signal, numbered_names
from retime.search.estimate import check_fits
from retime.search.poses.references import Reference

# Hz. An analysis finer than this, and than twice the clips, sees nothing more.
_FINEST = 240.0


def as_clips(
    motion: AnyMotion | ArrayLike | Sequence[AnyMotion | Reference] | None,
    rate: float | str | None = None,
    *,
    what: str = "the array",
) -> tuple[AnyMotion, ...]:
    """Take a motion, a signal, an array of numbers, or several clips that move together.

    Parameters
    ----------
    motion : Motion, Signal, sequence of them, or float array of shape (n_frames,) or (n_frames, n_channels)
        What moves.
    rate : float or str, optional
        Frames a second of an array.
    what : str
        What to call an array in messages.

    Raises
    ------
    OptionError
        An array with no rate, or nothing at all.
    """
    if isinstance(motion, AnyMotion):
        return (motion,)
    if isinstance(motion, Sequence) and motion and all(isinstance(clip, AnyMotion) for clip in motion):
        return tuple(clip for clip in motion if isinstance(clip, AnyMotion))
    try:
        values = as_real(cast(ArrayLike, motion), what, error=OptionError)
    except OptionError:
        if isinstance(motion, np.ndarray) and motion.dtype != object:
            raise
        found = [type(one).__name__ for one in motion] if isinstance(motion, list | tuple) else kind_of(motion)
        raise OptionError(
            "expected a motion, an array of numbers, or several motions and signals (a group holds no arrays and no "
            f"groups; a file is read by retime.read); found {found}"
        ) from None
    if values.ndim == 1:
        values = values[:, None]
    if values.ndim != 2 or values.shape[0] == 0:
        raise OptionError(f"expected a motion, or an array of shape (n_frames, n_channels); found shape {values.shape}")
    if rate is None:
        raise OptionError("an array of numbers needs its rate: guided_warp(array, rate=30)")
    return (Signal(numbered_names(values.shape[1]), values, parse_rate(rate), name="array"),)


def as_references(
    reference: AnyMotion | ArrayLike | Reference | Sequence[AnyMotion | Reference] | None,
    n_clips: int,
    rate: float | str | None,
) -> list[Reference]:
    """Tell one reference from several: for a group of clips, that many plain clips are one reference."""
    if isinstance(reference, Reference):
        return [reference]
    if isinstance(reference, Sequence) and any(isinstance(one, Reference) for one in reference):
        return [one if isinstance(one, Reference) else Reference(as_clips(one, rate)) for one in reference]
    clips = as_clips(reference, rate, what="the reference")
    return [Reference(clips)] if n_clips > 1 else [Reference(clip) for clip in clips]


def check_rates(clips: Sequence[AnyMotion], rate: float) -> None:
    """Refuse an analysis rate that tells nothing more of the clips, and clips too long to be looked at at it.

    Parameters
    ----------
    clips : sequence of Motion or Signal
        The input.
    rate : float
        Analysis rate, Hz.

    Raises
    ------
    OptionError
        The rate is many times that of the clips, or the clips are longer at it than memory holds.

    Warns
    -----
    RetimeWarning
        A clip has less than a frame a second.
    """
    for clip in clips:
        if problem := slow_clock(clip):
            warnings.warn(problem, RetimeWarning, stacklevel=4)
    fastest = float(max(clip.rate for clip in clips))
    if rate > max(_FINEST, 2 * fastest):
        raise OptionError(
            f"an analysis at {rate:g} Hz sees no more of a clip at {fastest:g} Hz than one at "
            f"{max(_FINEST, 2 * fastest):g} Hz, the most: use a lower rate (30 Hz is usual)",
            option="rate",
        )
    frames = sum((float(clip.end_time) * rate + 1) * _numbers(clip) for clip in clips)
    check_fits(
        what=f"an analysis of {float(max(clip.end_time for clip in clips)):.6g} s at {rate:g} Hz",
        remedy="Take a part of it (frames), use a lower rate (rate=, --rate), or correct the clip's own (--fps)",
        n_bytes=8 * 12 * frames,
        option="rate",
    )


def slow_clock(clip: AnyMotion) -> str | None:
    """Say that a clip has less than a frame a second, which hardly one is meant to have; None where it has more."""
    if clip.rate >= 1:
        return None
    return (
        f"{clip.name or 'the input'} has {float(clip.rate):.3g} frames a second, and so is "
        f"{float(clip.duration):.6g} s long: are its times in milliseconds, or its rate a time? Give the rate of the "
        "file (--fps; for an array rate=) where that is wrong"
    )


def _numbers(clip: AnyMotion) -> int:
    """About as many numbers as describe a pose."""
    return len(clip.names) if isinstance(clip, Signal) else 3 * clip.skeleton.n_joints
