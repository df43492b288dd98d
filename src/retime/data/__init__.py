"""The sample clip that the project ships. `tools/make_sample.py` makes it."""

from __future__ import annotations

from pathlib import Path

from retime.formats.registry import read
from retime.motion.motion import Motion

SAMPLE = Path(__file__).parent / "sample.bvh"


def sample() -> Motion:
    """Return the sample clip: a figure that stands, walks, pauses, crouches and jumps, twice.

    Examples
    --------
    >>> clip = sample()
    >>> float(clip.rate), clip.skeleton.names[0]
    (60.0, 'Hips')
    """
    motion = read(SAMPLE)
    assert isinstance(motion, Motion)
    return motion
