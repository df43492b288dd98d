"""Frames that a file puts in front of what was captured: a T-pose, most often."""

from __future__ import annotations

import warnings

import numpy as np

from retime.errors import RetimeWarning
from retime.motion.any_motion import AnyMotion
from retime.motion.motion import Motion

# There are one or a few of such frames. In the step from the last of them many joints turn by this many degrees at
# least, as they don't in a movement.
_MOST_FRAMES = 3
_LEAST_JUMP = 25.0
# But where all of the next second is as wild (a low rate, a depth camera) that is how it moves: the step must be three
# times as large as any that follows.
_LEAST_RATIO = 3.0
_SECONDS_AFTER, _FRAMES_AFTER = 1.0, 8
# A single joint may turn over between two frames (Euler angles at their limit); so many don't at once.
_JOINTS = 4


def frames_before_capture(motion: Motion) -> int:
    """Count the frames at the start that are no part of the movement; 0 for most clips.

    The pose jumps from the last of them to the next frame, by tens of degrees in several joints, and nothing in the
    second after that comes near to it.

    Examples
    --------
    >>> import retime
    >>> frames_before_capture(retime.sample())
    0
    """
    return _before_capture(motion)[0]


def _before_capture(motion: Motion) -> tuple[int, float, float]:
    """Return how many such frames there are, the jump after them, and the largest step that follows; degrees."""
    after = max(_FRAMES_AFTER, round(_SECONDS_AFTER * float(motion.rate)))
    q = motion.rotations[: _MOST_FRAMES + after + 1]
    if len(q) < 4:
        return 0, 0.0, 0.0
    cosines = np.clip(np.abs(np.einsum("fjc,fjc->fj", q[:-1], q[1:])), 0.0, 1.0)
    steps = np.degrees(2 * np.arccos(np.sort(cosines, axis=1)[:, min(_JOINTS, cosines.shape[1]) - 1]))
    jump = int(np.argmax(steps[: min(_MOST_FRAMES, len(steps) - 2)]))
    most = float(steps[jump + 1 : jump + 1 + after].max())
    if steps[jump] < _LEAST_JUMP or steps[jump] < _LEAST_RATIO * most:
        return 0, 0.0, 0.0
    return jump + 1, float(steps[jump]), most


def hint_at_first_frames(clip: AnyMotion, *, reference: bool = False) -> None:
    """Warn where the first frames seem to be no part of the movement, and say how to leave them out.

    Parameters
    ----------
    clip : Motion or Signal
        What was read.
    reference : bool
        It is to be imitated: the command line has another option then.
    """
    count, jump, most = _before_capture(clip) if isinstance(clip, Motion) else (0, 0.0, 0.0)
    if not count:
        return
    frames, them = ("first frame is", "it") if count == 1 else (f"first {count} frames are", "them")
    begin = clip.first_frame + count
    option = f"--reference-frames {begin}:" if reference else f"--drop-first {count}"
    warnings.warn(
        f"{clip.name or 'the clip'}: the {frames} probably no part of the movement (a T-pose in front of it?): then "
        f"the pose jumps by {jump:.0f} degrees, and by no more than {most:.0f} a frame in the second after. Leave "
        f"{them} out: {option} (in Python clip[{count}:]; in the editor use frames from {begin})",
        RetimeWarning,
        stacklevel=3,
    )
