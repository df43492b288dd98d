"""A motion: a skeleton, its joints' local translations and rotations, and an exact rate."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from fractions import Fraction

import numpy as np
from numpy.typing import ArrayLike

from retime.errors import InvalidMotionError, OptionError
from retime.motion import rotation
from retime.motion.rotation import FloatArray
from retime.motion.size import LARGEST, size_problem, within_size
from retime.motion.skeleton import Skeleton

UPS = ("y", "z")
"""Axes that may be vertical in a motion's own coordinates."""


@dataclass(frozen=True)
class Declaration:
    """What a file declared beyond the motion itself, kept so that writing gives the file back.

    Attributes
    ----------
    format : str
        The format's name ("bvh").
    channels : tuple of tuple of str
        For each joint the channels in file order: ``Xposition`` ... ``Zrotation``.
    frame_time : str
        The frame time as written, or "".
    """

    format: str
    channels: tuple[tuple[str, ...], ...]
    frame_time: str = ""


def frame_positions(input_times: ArrayLike, rate: Fraction, n_frames: int) -> tuple[np.ndarray, np.ndarray, FloatArray]:
    """Place times between frames.

    Times within about a billionth of a frame of a frame are taken to be that frame, so that a motion sampled at its own
    frames comes back bit for bit; times outside the motion are held at its ends.

    Parameters
    ----------
    input_times : float array, any shape
        Seconds from the first frame.
    rate : Fraction
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
    times = np.asarray(input_times, dtype=np.float64)
    if np.isnan(times).any():
        raise OptionError(f"time {int(np.argwhere(np.isnan(times.ravel()))[0, 0])} of {times.size} is not a number")
    place = np.clip(times * float(rate), 0.0, n_frames - 1)
    whole = np.round(place)
    # Far into a long motion a frame's own time, in floating point, is off by more than the billionth.
    place = np.where(np.abs(place - whole) < 1e-9 + 1e-15 * place, whole, place)
    before = np.floor(place).astype(np.intp)
    after = np.minimum(before + 1, n_frames - 1)
    return before, after, place - before


@dataclass(frozen=True, eq=False)
class Motion:
    """A moving skeleton.

    Parameters
    ----------
    skeleton : Skeleton
        The joints.
    rotations : float array, shape (n_frames, n_joints, 4)
        Local rotations, wxyz; scaled to unit length here.
    translations : float array, shape (n_frames, n_joints, 3)
        Local translations (joint origin in its parent's space), in length units. Left out: the rest offsets.
    rate : Fraction
        Frames a second, exact.
    name : str
        What to call it in messages and plots.
    first_frame : int
        The number that the file gives its first frame (AMC and C3D count from 1).
    metres_per_unit : float, optional
        Length of one unit in metres, where known.
    declaration : Declaration, optional
        What its file declared.
    declared_angles : float array, shape (n_frames, n_joints, 3), optional
        Euler angles as the file wrote them (radians, in each joint's declared order, unused places 0). They only choose
        among the many triples that mean one rotation when the motion is written again.
    up : {"y", "z"}
        Which axis of its own coordinates is vertical. Global space has Y up in any case (`retime.motion.kinematics`).

    Raises
    ------
    InvalidMotionError
        No frame, shapes that disagree, or a number that is not finite or beyond 1e100 (named by joint and
        frame).
    """

    skeleton: Skeleton
    rotations: FloatArray
    translations: FloatArray | None = None
    rate: Fraction = field(default=Fraction(30))
    name: str = ""
    first_frame: int = 0
    metres_per_unit: float | None = None
    declaration: Declaration | None = None
    declared_angles: FloatArray | None = None
    up: str = "y"

    def __post_init__(self) -> None:
        n_joints = self.skeleton.n_joints
        rotations = np.asarray(self.rotations, dtype=np.float64)
        if rotations.ndim != 3 or rotations.shape[1:] != (n_joints, 4) or len(rotations) == 0:
            raise InvalidMotionError(
                f"expected rotations of shape (n_frames >= 1, {n_joints}, 4), found {rotations.shape}"
            )
        if self.translations is None:
            translations = np.broadcast_to(self.skeleton.offsets, (len(rotations), n_joints, 3))
        else:
            translations = np.asarray(self.translations, dtype=np.float64)
        if translations.shape != (len(rotations), n_joints, 3):
            raise InvalidMotionError(
                f"expected translations of shape ({len(rotations)}, {n_joints}, 3), found {translations.shape}"
            )
        # Scaled to unit length below, they may have any.
        self._refuse_unbounded("rotation", rotations, np.finfo(np.float64).max)
        self._refuse_unbounded("translation", translations)
        if not (isinstance(self.rate, Fraction) and self.rate > 0):
            raise InvalidMotionError(f"expected an exact rate above 0 (a Fraction), found {self.rate!r}")
        if self.up not in UPS:
            raise InvalidMotionError(f"the vertical axis must be one of {', '.join(UPS)}; found {self.up!r}")
        squares = np.einsum("fjc,fjc->fj", rotations, rotations)
        if squares.min() < 1.0 - 2e-12 or squares.max() > 1.0 + 2e-12:
            zero = ~np.any(rotations, axis=-1)
            if np.any(zero):
                frame, joint = (int(i) for i in np.argwhere(zero)[0])
                raise InvalidMotionError(
                    f"the rotation of joint {self.skeleton.names[joint]!r} at frame {frame} has length 0"
                )
            rotations = rotation.normalize(rotations)
        frozen = [("rotations", rotations), ("translations", translations)]
        if self.declared_angles is not None:
            angles = np.asarray(self.declared_angles, dtype=np.float64)
            if angles.shape != (len(rotations), n_joints, 3):
                raise InvalidMotionError(
                    f"expected declared angles of shape ({len(rotations)}, {n_joints}, 3), found {angles.shape}"
                )
            self._refuse_unbounded("declared angle", angles)
            frozen.append(("declared_angles", angles))
        for name, array in frozen:
            view = array.view()
            view.setflags(write=False)
            object.__setattr__(self, name, view)

    def _refuse_unbounded(self, what: str, values: FloatArray, largest: float = LARGEST) -> None:
        # The least and the greatest number tell, without an array of answers; one that is NaN is both.
        if within_size([values.min(), values.max()], largest).all():
            return
        frame, joint, _ = (int(i) for i in np.argwhere(~within_size(values, largest))[0])
        problem = size_problem(values[frame, joint])
        raise InvalidMotionError(f"the {what} of joint {self.skeleton.names[joint]!r} at frame {frame} {problem}")

    @property
    def n_frames(self) -> int:
        """Number of frames."""
        return len(self.rotations)

    @property
    def duration(self) -> float:
        """Length in seconds, ``n_frames / rate``: every frame is shown for a frame period, the last one too."""
        return float(self.n_frames / self.rate)

    @property
    def end_time(self) -> float:
        """Time of the last frame, seconds, ``(n_frames - 1) / rate``: where the motion's own time ends."""
        return float((self.n_frames - 1) / self.rate)

    @property
    def local_translations(self) -> FloatArray:
        """Local translations, shape (n_frames, n_joints, 3): never None."""
        assert self.translations is not None
        return self.translations

    def frames(self, start: int, stop: int) -> Motion:
        """Cut out frames ``start`` to ``stop - 1``, counted from 0.

        Raises
        ------
        OptionError
            The range is empty or leaves the motion.
        """
        if not 0 <= start < stop <= self.n_frames:
            raise OptionError(
                f"frames {start} to {stop - 1} are not inside {self.name or 'the motion'}, which has frames 0 to "
                f"{self.n_frames - 1}"
            )
        angles = self.declared_angles
        return replace(
            self,
            rotations=self.rotations[start:stop],
            translations=self.local_translations[start:stop],
            first_frame=self.first_frame + start,
            declared_angles=None if angles is None else angles[start:stop],
        )

    def with_rate(self, rate: Fraction) -> Motion:
        """Play the same frames at another rate (for files that declare a wrong one)."""
        return replace(self, rate=rate)

    def at(self, input_times: ArrayLike) -> Motion:
        """Sample at any times: slerp for rotations, linear for translations.

        Parameters
        ----------
        input_times : float array, shape (n,)
            Seconds from the first frame; held at the ends outside the motion.

        Returns
        -------
        Motion
            `n` frames, at this motion's rate whatever the spacing of the times: the caller says what they mean.
        """
        before, after, fraction = frame_positions(input_times, self.rate, self.n_frames)
        whole, between = np.flatnonzero(fraction == 0), np.flatnonzero(fraction)
        earlier, later, share = before[between], after[between], fraction[between]
        rotations = np.empty((len(fraction), *self.rotations.shape[1:]))
        rotations[whole] = self.rotations[before[whole]]
        rotations[between] = rotation.slerp(self.rotations[earlier], self.rotations[later], share[:, None])
        start, step = self.local_translations[earlier], self.local_translations[later]
        step -= start
        step *= share[:, None, None]
        step += start
        translations = np.empty((len(fraction), *start.shape[1:]))
        translations[whole] = self.local_translations[before[whole]]
        translations[between] = step
        angles = self.declared_angles
        if angles is not None:
            angles = angles[np.where(fraction < 0.5, before, after)]
        return replace(self, rotations=rotations, translations=translations, first_frame=0, declared_angles=angles)
