"""What moves, and what it is to move like, whichever way people hand it over: a clip, an array, several clips."""

from __future__ import annotations

from collections.abc import Sequence
from typing import cast

import numpy as np
from numpy.typing import ArrayLike

from retime.arrays import as_real
from retime.brief import kind_of
from retime.errors import OptionError
from retime.motion.any_motion import AnyMotion
from retime.motion.rate import parse_rate
from retime.motion.signal import Signal, numbered_names
from retime.search.poses.references import Reference


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
