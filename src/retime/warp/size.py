"""How large an output may be, of a clip of its size."""

from __future__ import annotations

from retime.errors import OptionError
from retime.limits import MOST_NUMBERS
from retime.motion.any_motion import AnyMotion
from retime.motion.motion import Motion

# So many frames are made of any clip, and so many of each that it has.
_MOST_FRAMES, _OF_ONE = 1 << 18, 1000


def refuse_too_large(motion: AnyMotion, n_frames: int, *, asks: str) -> None:
    """Refuse an output that no reader would take again, or that a wrong number makes, before anything is allocated.

    Parameters
    ----------
    motion : Motion or Signal
        The input.
    n_frames : int
        Of the output.
    asks : str
        The end of the message: what may be wrong.

    Raises
    ------
    OptionError
        There are more than a thousand frames for each of the input's, and many; or more numbers than may be.
    """
    # A rotation and a place for each joint.
    numbers = n_frames * (7 * motion.skeleton.n_joints if isinstance(motion, Motion) else len(motion.names))
    most = max(_MOST_FRAMES, _OF_ONE * motion.n_frames)
    # What slows down a very long clip is still taken for its own.
    if numbers > MOST_NUMBERS and n_frames > 4 * motion.n_frames:
        limit = f"{8 * MOST_NUMBERS / 1e9:.2g} GB are the most"
    elif n_frames > most:
        limit = f"{most} frames are the most"
    else:
        return
    raise OptionError(
        f"the output would have {n_frames} frames, and take {8 * numbers / 1e9:.3g} GB, where the input has "
        f"{motion.n_frames} frames; {limit}. {asks}"
    )
