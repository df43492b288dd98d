"""What moves, for those who know a motion by its parts alone."""

from __future__ import annotations

from fractions import Fraction
from typing import Protocol, runtime_checkable

from retime.arrays import FloatArray
from retime.motion.skeleton import Skeleton


@runtime_checkable
class Moving(Protocol):
    """What is read of a motion, here and by what looks for contacts and flights.

    A motion (`retime.motion.motion.Motion`) offers what they find as methods, so they know it by this alone.
    """

    @property
    def name(self) -> str:
        """What to call it in messages."""

    @property
    def n_frames(self) -> int:
        """Number of frames."""

    @property
    def skeleton(self) -> Skeleton:
        """The joints."""

    @property
    def rotations(self) -> FloatArray:
        """Local rotations, shape (n_frames, n_joints, 4), wxyz."""

    @property
    def local_translations(self) -> FloatArray:
        """Local translations, shape (n_frames, n_joints, 3)."""

    @property
    def rate(self) -> Fraction:
        """Frames a second."""

    @property
    def metres_per_unit(self) -> float | None:
        """Length of one unit in metres, where known."""

    @property
    def up(self) -> str:
        """Which axis of its own coordinates is vertical, "y" or "z"."""

    @property
    def root(self) -> str | None:
        """The joint that carries the body, where it was named; see `retime.motion.body`."""
