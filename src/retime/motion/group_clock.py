"""Clips that belong together (a figure, its camera, a prop): one clock for all of them."""

from __future__ import annotations

import warnings
from collections.abc import Sequence
from dataclasses import replace
from fractions import Fraction

import numpy as np

from retime.errors import RetimeWarning
from retime.motion.any_motion import AnyMotion
from retime.motion.signal import Signal

# Clocks that differ by no more frames than this, of the slower clip, are one: some formats count frames from 1.
_FRAMES_APART = 1.5


def on_clock_of(clip: AnyMotion, first: AnyMotion, offset: float) -> AnyMotion:
    """Put a clip on the clock of another, which it begins some time after.

    Parameters
    ----------
    clip : Motion or Signal
        What is put on the clock.
    first : Motion or Signal
        Whose clock it is.
    offset : float
        Seconds from the first frame of `first` to the first frame of `clip`; below 0 where `clip` begins earlier.

    Returns
    -------
    Motion or Signal
        `clip` at its own rate, as long as `first`, from the moment on that `first` begins. Beyond its ends the nearest
        frame is held. Of an offset of whole frames no number changes.

    Warns
    -----
    RetimeWarning
        For a part of `first` there are no frames.

    Examples
    --------
    >>> from retime.motion.signal import Signal
    >>> figure = Signal(("x",), np.zeros((6, 1)), 10, name="figure")
    >>> camera = Signal(("pan",), np.arange(8.0)[:, None], 10, name="camera")
    >>> on_clock_of(camera, figure, -0.2).values[:, 0].tolist()
    [2.0, 3.0, 4.0, 5.0, 6.0, 7.0]
    """
    rate = float(clip.rate)
    n_frames = round(first.end_time * rate) + 1
    before, after = max(0.0, offset), max(0.0, first.end_time - offset - clip.end_time)
    missing = [
        f"{seconds:.3g} s at {where}"
        for seconds, where in ((before, "the start"), (after, "the end"))
        if seconds * rate > 0.5
    ]
    if missing:
        warnings.warn(
            f"{_name(clip)} does not show all of {_name(first)}: its nearest frame is held for "
            + " and ".join(missing),
            RetimeWarning,
            stacklevel=2,
        )
    shown = clip.at(np.arange(n_frames) / rate - offset)
    if isinstance(shown, Signal):
        start = Fraction(_start(first)) if _clock(clip) == _clock(first) else None
        shown = replace(shown, clock=replace(shown.clock, start=start))
    return replace(shown, first_frame=round(float(first.first_frame / first.rate) * rate))


def on_clock_by_times(clip: AnyMotion, first: AnyMotion) -> AnyMotion:
    """Put a clip on the clock of another where both hold times of one clock, and these begin apart.

    Parameters
    ----------
    clip : Motion or Signal
        What is put on the clock.
    first : Motion or Signal
        Whose clock it is.

    Returns
    -------
    Motion or Signal
        As `on_clock_of` returns it; `clip` itself where the two begin together, or one of them holds no times, or
        their times have no moment in common.

    Warns
    -----
    RetimeWarning
        It was moved; says by how much.

    Examples
    --------
    >>> from retime.motion.clock import Clock
    >>> from retime.motion.signal import Signal
    >>> figure = Signal(("x",), np.zeros((6, 1)), 10, name="figure", clock=Clock(start=Fraction(2)))
    >>> camera = Signal(("pan",), np.arange(8.0)[:, None], 10, name="camera", clock=Clock(start=Fraction(18, 10)))
    >>> with warnings.catch_warnings():
    ...     warnings.simplefilter("ignore", RetimeWarning)
    ...     on_clock_by_times(camera, figure).values[:, 0].tolist()
    [2.0, 3.0, 4.0, 5.0, 6.0, 7.0]
    """
    if not (_holds_times(clip) and _holds_times(first) and _clock(clip) == _clock(first)):
        return clip
    offset = _start(clip) - _start(first)
    if abs(offset) <= _FRAMES_APART / float(min(clip.rate, first.rate)):
        return clip
    if not -clip.end_time < offset < first.end_time:
        return clip
    warnings.warn(
        f"{_name(clip)} begins {abs(offset):.6g} s {'after' if offset > 0 else 'before'} {_name(first)} by the times "
        "in both files, and is put there (an offset of 0 takes their first frames for the same moment: "
        "--also CLIP+0s=OUT; in the editor under How it is read)",
        RetimeWarning,
        stacklevel=2,
    )
    return on_clock_of(clip, first, offset)


def _holds_times(clip: AnyMotion) -> bool:
    """Tell whether a clip's file says when its rows are; the numbers of frames don't."""
    return isinstance(clip, Signal) and clip.clock.start is not None and clip.clock.form != "frames"


def hint_at_clocks(clips: Sequence[AnyMotion], *, lengths: bool = False) -> None:
    """Warn of clips whose clocks begin elsewhere than the first one's, as their files number frames or give times.

    Parameters
    ----------
    clips : sequence of Motion or Signal
        A group; the first one's clock is the group's.
    lengths : bool
        Warn also of those that last longer or shorter than the first.
    """
    first = clips[0]
    for clip in clips[1:]:
        frame = 1 / float(min(clip.rate, first.rate))
        offset = _start(clip) - _start(first)
        if _clock(clip) == _clock(first) and abs(offset) > _FRAMES_APART * frame:
            warnings.warn(
                f"{_name(clip)} begins at {_start(clip):.6g} s by its own times, {_name(first)} at "
                f"{_start(first):.6g} s: their first frames are taken for the same moment. By its own times it is "
                f"{offset:+.6g} s away: say so (--also CLIP{offset:+.6g}s=OUT; in Python on_clock_of), or use frames "
                "of both from one moment on",
                RetimeWarning,
                stacklevel=3,
            )
        apart = min(abs(clip.duration - first.duration), abs(clip.end_time - first.end_time))
        if lengths and apart > frame / 2 * (1 + 1e-9):
            warnings.warn(
                f"{_name(clip)} lasts {clip.duration:.3f} s and {_name(first)} {first.duration:.3f} s: "
                + ("its last frame is held" if clip.duration < first.duration else "the rest of it is not shown"),
                RetimeWarning,
                stacklevel=3,
            )


def _start(clip: AnyMotion) -> float:
    """Time of the first frame by the file's own times, else by its frames' numbers, seconds."""
    return clip.start_time if isinstance(clip, Signal) else float(clip.first_frame / clip.rate)


def _clock(clip: AnyMotion) -> str:
    """Say which clock a clip's times are of: times of day, and others, can't be compared."""
    return clip.clock.origin if isinstance(clip, Signal) else "clip"


def _name(clip: AnyMotion) -> str:
    return clip.name or "a clip of the group"
