"""A motion: a skeleton, its joints' local translations and rotations, and an exact rate."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING, Literal, get_args

import numpy as np
from numpy.typing import ArrayLike

from retime.arrays import FloatArray, as_real
from retime.brief import brief, brief_repr, kind_of
from retime.errors import InvalidMotionError, OptionError
from retime.frames import frame_positions, frame_range, slice_range
from retime.kernels import backend
from retime.motion import kinematics, rotation
from retime.motion.body import body_joint, body_name, body_of
from retime.motion.picture import pictured_frames, poses_html
from retime.motion.rate import RateField, RateLike
from retime.motion.size import LARGEST, extent, size_problem, within_size
from retime.motion.skeleton import Skeleton

Up = Literal["y", "z"]
UPS = get_args(Up)
"""Axes that may be vertical in a motion's own coordinates."""

# Frames sampled at once.
_SAMPLED = 512


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

    __repr__ = brief_repr


RotationForm = Literal["wxyz", "xyzw", "matrix", "rotvec"]
"""How an array holds rotations: quaternions with the real part first or last, matrices, axis times angle (radians)."""


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
    rate : Fraction, number or str
        Frames a second: 120, 29.97, ``"30000/1001"``. Kept as an exact fraction (`retime.motion.rate.parse_rate`).
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
    root : str, optional
        The joint that carries the body, of joints of one name the first. Left out, it is found
        (`retime.motion.body.body_joint`): the skeleton's first joint in most files.

    Raises
    ------
    InvalidMotionError
        No frame, shapes that disagree, or a number that is not finite or beyond 1e100 (named by joint and
        frame).
    OptionError
        The rate is none.

    Examples
    --------
    >>> import retime
    >>> clip = retime.sample()
    >>> clip, len(clip[10:20])
    (Motion('sample', 816 frames at 60 Hz, 22 joints), 10)
    """

    skeleton: Skeleton
    rotations: FloatArray
    translations: FloatArray | None = None
    rate: RateField = RateField(30)  # noqa: RUF009
    name: str = ""
    first_frame: int = 0
    metres_per_unit: float | None = None
    declaration: Declaration | None = None
    declared_angles: FloatArray | None = None
    up: Up = "y"
    root: str | None = None

    # What the constructor takes. A dataclass alone could declare only what its fields hold afterwards.
    if TYPE_CHECKING:

        def __init__(
            self,
            skeleton: Skeleton,
            rotations: ArrayLike,
            translations: ArrayLike | None = None,
            rate: RateLike = 30,
            name: str = "",
            first_frame: int = 0,
            metres_per_unit: float | None = None,
            declaration: Declaration | None = None,
            declared_angles: ArrayLike | None = None,
            up: Up = "y",
            root: str | None = None,
        ) -> None: ...

    def __post_init__(self) -> None:
        if not isinstance(self.skeleton, Skeleton):
            raise InvalidMotionError(
                f"expected a Skeleton, found {kind_of(self.skeleton)}; Motion.from_arrays takes parents and offsets"
            )
        n_joints = self.skeleton.n_joints
        rotations = as_real(self.rotations, "rotations")
        if rotations.ndim != 3 or rotations.shape[1:] != (n_joints, 4) or len(rotations) == 0:
            raise InvalidMotionError(
                f"expected rotations of shape (n_frames >= 1, {n_joints}, 4), found {rotations.shape}"
            )
        if self.translations is None:
            translations = np.broadcast_to(self.skeleton.offsets, (len(rotations), n_joints, 3))
        else:
            translations = as_real(self.translations, "translations")
        if translations.shape != (len(rotations), n_joints, 3):
            raise InvalidMotionError(
                f"expected translations of shape ({len(rotations)}, {n_joints}, 3), found {translations.shape}"
            )
        # Any length will do, for they are scaled to unit length below; one that has it has no number out of bounds.
        shortest, longest = backend(warn=False).squared_lengths(np.ascontiguousarray(rotations))
        are_unit = shortest >= 1.0 - 2e-12 and longest <= 1.0 + 2e-12
        if not are_unit:
            self._refuse_unbounded("rotation", rotations, np.finfo(np.float64).max)
        self._refuse_unbounded("translation", translations)
        if self.up not in UPS:
            raise InvalidMotionError(f"the vertical axis must be one of {', '.join(UPS)}; found {self.up!r}")
        if self.root is not None:
            body_joint(self)
        if not are_unit:
            zero = ~np.any(rotations, axis=-1)
            if np.any(zero):
                frame, joint = (int(i) for i in np.argwhere(zero)[0])
                raise InvalidMotionError(
                    f"the rotation of joint {self.skeleton.names[joint]!r} at frame {frame} has length 0"
                )
            rotations = rotation.normalize(rotations)
        frozen = [("rotations", rotations), ("translations", translations)]
        if self.declared_angles is not None:
            angles = as_real(self.declared_angles, "declared angles")
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
        # The least and the greatest number are enough, and need no second array.
        if within_size(extent(values), largest).all():
            return
        frame, joint, _ = (int(i) for i in np.argwhere(~within_size(values, largest))[0])
        problem = size_problem(values[frame, joint])
        raise InvalidMotionError(f"the {what} of joint {self.skeleton.names[joint]!r} at frame {frame} {problem}")

    @classmethod
    def from_arrays(
        cls,
        rotations: ArrayLike,
        *,
        parents: Sequence[int],
        offsets: ArrayLike,
        rate: RateLike,
        names: Sequence[str] | None = None,
        root_positions: ArrayLike | None = None,
        form: RotationForm = "wxyz",
        name: str = "",
        metres_per_unit: float | None = None,
        up: Up = "y",
    ) -> Motion:
        """Make a motion of the arrays that data sets and simulators have.

        Positions without rotations are a `retime.Signal`, or a plain array: `retime.guided_warp` takes both.

        Parameters
        ----------
        rotations : float array, shape (n_frames, n_joints, 4), (n_frames, n_joints, 3, 3) or (n_frames, n_joints, 3)
            Local rotations (a joint's space to its parent's), as `form` says.
        parents : sequence of int, length n_joints
            Each joint's parent, which stands before it; -1 for the root, which comes first.
        offsets : float array, shape (n_joints, 3)
            Rest offset of each joint from its parent.
        rate : number or str
            Frames a second.
        names : sequence of str, optional
            Joint names; left out, ``joint0``, ``joint1`` and so on. What feet and counterparts are is told by names.
        root_positions : float array, shape (n_frames, 3), optional
            Where the root is; left out, at its offset.
        form : {"wxyz", "xyzw", "matrix", "rotvec"}
            Quaternions with the real part first or last, rotation matrices, or rotation vectors (axis times angle,
            radians).
        name : str
            What to call it in messages and plots.
        metres_per_unit : float, optional
            Length of one unit in metres, where known.
        up : {"y", "z"}
            Which axis is vertical.

        Raises
        ------
        InvalidMotionError
            Shapes that disagree, numbers that are not finite, or matrices that are no rotations.
        OptionError
            No such form, or no rate.

        Examples
        --------
        >>> turn = np.zeros((20, 2, 3))
        >>> turn[:, 1, 2] = np.linspace(0, np.pi / 2, 20)
        >>> arm = Motion.from_arrays(turn, form="rotvec", parents=[-1, 0], offsets=[[0, 0, 0], [1, 0, 0]], rate=30)
        >>> arm, arm.positions[-1, 1].tolist()
        (Motion(20 frames at 30 Hz, 2 joints), [1.0, 0.0, 0.0])
        """
        if form not in get_args(RotationForm):
            raise OptionError(f"the form must be one of {', '.join(get_args(RotationForm))}; found {form!r}")
        parents = tuple(int(parent) for parent in parents)
        names = [f"joint{joint}" for joint in range(len(parents))] if names is None else names
        skeleton = Skeleton(tuple(names), parents, as_real(offsets, "offsets"))
        quaternions = _quaternions(as_real(rotations, "rotations"), skeleton.n_joints, form)
        translations = None
        if root_positions is not None:
            places = as_real(root_positions, "root positions")
            if places.shape != (len(quaternions), 3):
                raise InvalidMotionError(
                    f"expected root positions of shape ({len(quaternions)}, 3), found {places.shape}"
                )
            translations = np.tile(skeleton.offsets, (len(quaternions), 1, 1))
            translations[:, 0] = places
        return cls(skeleton, quaternions, translations, rate, name, metres_per_unit=metres_per_unit, up=up)

    def __repr__(self) -> str:
        named = f"{brief(self.name)}, " if self.name else ""
        return f"Motion({named}{self.n_frames} frames at {self.rate} Hz, {self.skeleton.n_joints} joints)"

    def _repr_html_(self) -> str:
        times = pictured_frames(self.n_frames) / float(self.rate)
        body = body_of(self)
        poses = kinematics.global_poses(body.at(times))
        named = {"motion": self.name} if self.name else {}
        return poses_html(
            np.concatenate([poses.positions, poses.end_positions], axis=1),
            [*body.skeleton.parents, *(site.parent for site in body.skeleton.end_sites)],
            times,
            body.positions[:, 0],
            {
                **named,
                "frames": self.n_frames,
                "rate": f"{self.rate} Hz",
                "joints": self.skeleton.n_joints,
                "up": self.up,
                "flights": len(self.flights()),
            },
        )

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

    def __len__(self) -> int:
        return self.n_frames

    def __getitem__(self, index: slice) -> Motion:
        """Cut out frames, as `frames` does, by ``clip[start:stop]``."""
        return self.frames(*slice_range(index, self.n_frames, self.name or "the motion"))

    # Without this a loop over a clip, or np.array(clip), would ask for single frames; a clip gives ranges only.
    __iter__ = None

    @cached_property
    def positions(self) -> FloatArray:
        """Joint origins in global space, shape (n_frames, n_joints, 3): Y up, in length units.

        Computed when first asked for, and read-only. `retime.motion.kinematics.global_poses` has rotations too.
        """
        positions = kinematics.global_poses(self).positions
        positions.setflags(write=False)
        return positions

    def flights(self, *, clearance: float = 0.03, minimum: float = 0.06) -> list[tuple[int, int]]:
        """Find the flights of jumps, leaps and runs: first and last frame of each, counted from 0.

        Parameters
        ----------
        clearance : float
            Metres above the ground that everything gets, at least, at some moment of a flight.
        minimum : float
            Shortest flight, seconds.

        Returns
        -------
        list of (int, int)
            As `retime.motion.flights.flights` finds them, which says how.

        Examples
        --------
        >>> import retime
        >>> len(retime.sample().flights())
        2
        """
        from retime.motion.flights import flights

        return flights(self, clearance=clearance, minimum=minimum)

    def frames(self, start: int, stop: int) -> Motion:
        """Cut out frames ``start`` to ``stop - 1``, counted from 0.

        Raises
        ------
        OptionError
            The range is empty or leaves the motion.
        """
        start, stop = frame_range(start, stop, self.n_frames, self.name or "the motion")
        angles = self.declared_angles
        return replace(
            self,
            rotations=self.rotations[start:stop],
            translations=self.local_translations[start:stop],
            first_frame=self.first_frame + start,
            declared_angles=None if angles is None else angles[start:stop],
            root=self.root or body_name(self),
        )

    def with_rate(self, rate: RateLike) -> Motion:
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
        rotations, translations, angles = self.arrays_at(input_times)
        return replace(self, rotations=rotations, translations=translations, first_frame=0, declared_angles=angles)

    def arrays_at(self, input_times: ArrayLike) -> tuple[FloatArray, FloatArray, FloatArray | None]:
        """Sample as `at` does: rotations, translations and declared angles, in new arrays that may be written to."""
        before, after, fraction = frame_positions(input_times, self.rate, self.n_frames)
        rotations = np.empty((len(fraction), *self.rotations.shape[1:]))
        translations = np.empty((len(fraction), *self.local_translations.shape[1:]))
        # In pieces that stay in the cache, and need no memory beside a long take.
        for piece in range(0, len(fraction), _SAMPLED):
            here = slice(piece, piece + _SAMPLED)
            whole, between = np.flatnonzero(fraction[here] == 0) + piece, np.flatnonzero(fraction[here]) + piece
            earlier, later, share = before[between], after[between], fraction[between]
            rotations[whole] = self.rotations[before[whole]]
            rotations[between] = rotation.slerp(self.rotations[earlier], self.rotations[later], share[:, None])
            start, step = self.local_translations[earlier], self.local_translations[later]
            step -= start
            step *= share[:, None, None]
            step += start
            translations[whole] = self.local_translations[before[whole]]
            translations[between] = step
        angles = self.declared_angles
        if angles is not None:
            angles = angles[np.where(fraction < 0.5, before, after)]
        return rotations, translations, angles


def _quaternions(rotations: FloatArray, n_joints: int, form: RotationForm) -> FloatArray:
    """Rotations of any form as quaternions, wxyz."""
    numbers = {"wxyz": (4,), "xyzw": (4,), "matrix": (3, 3), "rotvec": (3,)}[form]
    if rotations.shape[1:] != (n_joints, *numbers) or len(rotations) == 0:
        wanted = ", ".join(map(str, (n_joints, *numbers)))
        raise InvalidMotionError(
            f"expected rotations of shape (n_frames >= 1, {wanted}) where form is {form!r}, found {rotations.shape}"
        )
    if form == "wxyz":
        return rotations
    if form == "xyzw":
        return rotations[..., [3, 0, 1, 2]]
    if not within_size(rotations).all():
        frame, joint = (int(i) for i in np.argwhere(~within_size(rotations))[0][:2])
        problem = size_problem(rotations[frame, joint])
        raise InvalidMotionError(f"the rotation of joint {joint} at frame {frame} {problem}")
    if form == "rotvec":
        return rotation.from_rotation_vectors(rotations)
    off = np.abs(np.swapaxes(rotations, -1, -2) @ rotations - np.eye(3)).max(axis=(-1, -2))
    wrong = (off > 1e-3) | (np.linalg.det(rotations) < 0)
    if wrong.any():
        frame, joint = (int(i) for i in np.argwhere(wrong)[0])
        raise InvalidMotionError(f"the matrix of joint {joint} at frame {frame} is no rotation")
    return rotation.from_matrix(rotations)
