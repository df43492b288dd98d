"""Resample a motion by a warp (§3.4)."""

from __future__ import annotations

import warnings
from dataclasses import replace
from typing import Literal, TypeVar, overload

import numpy as np
from numpy.typing import ArrayLike

from retime.arrays import FloatArray
from retime.brief import kind_of
from retime.errors import OptionError, RetimeWarning
from retime.motion.any_motion import AnyMotion
from retime.motion.body import above_body
from retime.motion.contacts import Contacts
from retime.motion.contacts import contacts as find_contacts
from retime.motion.motion import Motion
from retime.motion.rate import RateLike
from retime.motion.signal import Signal, signal_of
from retime.warp.averaging import (
    JointGroup,
    Windows,
    average_channels,
    average_columns,
    average_rotations,
    joint_groups,
    windows_of,
)
from retime.warp.curve import Warp, WarpLike, as_warp, output_frame_times
from retime.warp.size import refuse_too_large

# A motion stays a motion, and a signal a signal.
Retimed = TypeVar("Retimed", Motion, Signal)


@overload
def apply_warp(
    motion: Retimed,
    warp: WarpLike,
    *,
    average: bool = True,
    contacts: Contacts | Literal["find"] | None = "find",
    keep_root_path: bool = True,
    loop: bool = False,
) -> Retimed: ...


@overload
def apply_warp(
    motion: ArrayLike, warp: WarpLike, *, average: bool = True, loop: bool = False, rate: RateLike
) -> FloatArray: ...


def apply_warp(
    motion: AnyMotion | ArrayLike,
    warp: WarpLike,
    *,
    average: bool = True,
    contacts: Contacts | Literal["find"] | None = "find",
    keep_root_path: bool = True,
    loop: bool = False,
    rate: RateLike | None = None,
) -> AnyMotion | FloatArray:
    """Show a motion with a warp's timing, at the motion's own rate (§3.4).

    Rotations are slerped, and places interpolated linearly; the channels of a signal are shown as their kinds have it
    (`Signal.kinds`: an angle goes the short way, a label is that of the nearest frame). Where the warp plays faster
    than life by c, each output frame is the mean of the input over a window of c frames, so that sway does not become
    jitter; where it does not, poses come straight from the input. The window closes at the ends, whose poses are kept.

    Two things are not averaged unless asked for. While a foot stands, the joints from the root to that foot come
    straight from the input, so that averaging makes no foot slide; toward a contact their window closes, after it it
    opens again, and the other joints go on being averaged. And the root's place is always one that it has in the
    input. The paper averages everything: ``contacts=None, keep_root_path=False``.

    Parameters
    ----------
    motion : Motion, Signal, or array of shape (n_frames, ...)
        The clip that the warp was found for, its full-rate original, another character, a camera; or plain numbers.
    warp : Warp or GuidedWarp
        From output time to input time.
    average : bool
        Average where sped up.
    contacts : Contacts, "find" or None
        When the input's feet stand, frame by frame; "find" looks (`retime.motion.contacts.contacts`). None averages
        feet like everything else. Signals have no feet.
    keep_root_path : bool
        Don't average the root's translation: the output's root goes where the input's went, however fast. All
        joints from the root to the one that carries the body are meant (`retime.motion.body.body_joint`).
    loop : bool
        The clip is a cycle, its last frame the first one again, and the warp plays all of it. The averaging window
        then goes on across the seam instead of closing at the ends, so that the seam has no corner. This holds for all
        joints but the root, which may have walked on and turned since the first frame: its window closes as ever. A
        signal goes on from its last value as it did from its first.
    rate : number or str, optional
        Frames a second of an array, which needs it; a clip has its own.

    Returns
    -------
    Motion, Signal or float array, as `motion` is
        Same rate, names and channels; ``warp.count_frames(rate)`` frames.

    Raises
    ------
    OptionError
        The contacts are of another number of frames, something else was passed than is expected, or the output would
        be larger than any file may be (`retime.limits`).

    Warns
    -----
    RetimeWarning
        The warp and the motion don't cover the same input times, or a loop's last pose is not its first.

    Examples
    --------
    >>> from fractions import Fraction
    >>> ramp = Signal(("x",), np.arange(5.0)[:, None], Fraction(1))
    >>> apply_warp(ramp, Warp([0.0, 2.0], [0.0, 4.0]), average=False).values[:, 0].tolist()
    [0.0, 2.0, 4.0]
    >>> apply_warp([0.0, 1.0, 2.0, 3.0, 4.0], Warp([0.0, 2.0], [0.0, 4.0]), rate=1, average=False).tolist()
    [0.0, 2.0, 4.0]
    """
    if isinstance(motion, Warp) or isinstance(getattr(motion, "warp", None), Warp):
        raise OptionError("the clip comes first: apply_warp(motion, warp)")
    warp = as_warp(warp, "apply_warp(motion, warp)")
    if not (contacts is None or isinstance(contacts, Contacts) or (isinstance(contacts, str) and contacts == "find")):
        raise OptionError(f"contacts must be Contacts, 'find' or None; found {kind_of(contacts)}")
    if isinstance(motion, Motion):
        if rate is not None:
            raise OptionError("a motion has its own rate; rate= is for arrays")
        compare_ranges(motion, warp)
        if isinstance(contacts, Contacts):
            contacts.refuse_other(motion)
        if loop:
            check_seam(motion)
        return resampled(motion, warp, average, contacts, keep_root_path, loop)
    if isinstance(motion, Signal):
        if rate is not None:
            raise OptionError("a signal has its own rate; rate= is for arrays")
        compare_ranges(motion, warp)
        return resampled(motion, warp, average, contacts, keep_root_path, loop)
    signal = signal_of(motion, rate, call="apply_warp(array, warp, rate=30)")
    compare_ranges(signal, warp)
    shown = resampled(signal, warp, average, contacts, keep_root_path, loop).values
    return shown.reshape(len(shown), *np.shape(motion)[1:])


def resampled(
    motion: Retimed,
    warp: Warp,
    average: bool,
    contacts: Contacts | Literal["find"] | None,
    keep_root_path: bool,
    loop: bool,
) -> Retimed:
    """Do what `apply_warp` says, without its warnings."""
    _refuse_too_large(motion, warp)
    output_times = output_frame_times(warp, float(motion.rate))
    input_times = warp(output_times)
    windows = windows_of(motion, warp, output_times, input_times, loop=loop) if average else None
    if windows is not None and not windows.any_open:
        windows = None
    if isinstance(motion, Signal):
        values = motion.at(input_times).values
        return replace(motion, values=values if windows is None else average_channels(values, motion, windows))
    rotations, translations, angles = motion.arrays_at(input_times)
    if windows is not None:
        standing = find_contacts(motion) if contacts == "find" else contacts
        _average_motion(
            rotations, translations, motion, windows, joint_groups(motion, windows, standing), keep_root_path
        )
    return replace(motion, rotations=rotations, translations=translations, declared_angles=angles)


def _average_motion(
    rotations: FloatArray,
    translations: FloatArray,
    motion: Motion,
    windows: Windows,
    groups: list[JointGroup],
    keep_root_path: bool,
) -> None:
    """Average what was sampled of a motion, in place: a long take has no room for another copy."""
    # Joints that stay where they are in their parents, as most do, have nothing to average.
    moving = np.any(motion.local_translations != motion.local_translations[0], axis=(0, 2))
    moving[list(windows.roots)] &= not keep_root_path
    for group in groups:
        for joints, half in windows.of(group.joints, group.half):
            average_columns(translations, motion.local_translations, joints[moving[joints]], windows, half)
    average_rotations(rotations, motion, windows, groups)


def quietly_applied(signal: Signal, warp: Warp, *, average: bool) -> Signal:
    """Do what `apply_warp` does for a signal that goes with a clip which it warned of already."""
    return resampled(signal, warp, average, None, True, False)


def shown_at(signal: Signal, warp: Warp, output_times: FloatArray, *, average: bool) -> FloatArray:
    """Show a signal at evenly spaced output times that are not its own frames'; values, shape (n, n_channels)."""
    _refuse_too_large(signal, warp)
    input_times = warp(output_times)
    values = signal.at(input_times).values
    windows = windows_of(signal, warp, output_times, input_times, loop=False) if average else None
    return values if windows is None or not windows.any_open else average_channels(values, signal, windows)


def _refuse_too_large(motion: AnyMotion, warp: Warp) -> None:
    refuse_too_large(
        motion, warp.count_frames(motion.rate), asks="Is it the warp of another clip, or is one of its times wrong?"
    )


def compare_ranges(motion: AnyMotion, warp: Warp) -> None:
    """Warn where the warp and the motion don't cover the same input times, half a frame aside."""
    problem = warp.range_problem(motion.end_time, float(motion.rate), motion.name or "the motion")
    if problem:
        warnings.warn(problem, RetimeWarning, stacklevel=3)


def check_seam(motion: Motion) -> None:
    """Warn where a loop's last pose is no repetition of its first: where a joint has to turn to get there."""
    others = sorted({*range(motion.skeleton.n_joints)} - {*above_body(motion)})
    q = motion.rotations[:, others]
    if motion.n_frames < 2 or not q.size:
        return
    steps, seam = _turns(q[1:], q[:-1]).max(axis=1), _turns(q[-1], q[0])
    joint = int(np.argmax(seam))
    # A clip that ends one frame before its first has a seam of one step. A thousandth of a radian can't be seen.
    if seam[joint] > max(float(np.median(steps)) / 2, 1e-3):
        warnings.warn(
            f"the last pose of {motion.name or 'the motion'} is not its first one again, as a loop's should be: "
            f"{motion.skeleton.names[others[joint]]!r} is {np.degrees(seam[joint]):.1f} degrees away",
            RetimeWarning,
            stacklevel=3,
        )


def _turns(a: FloatArray, b: FloatArray) -> FloatArray:
    """Angles between rotations (..., 4), radians."""
    return np.asarray(2 * np.arccos(np.minimum(np.abs(np.einsum("...c,...c->...", a, b)), 1.0)))
