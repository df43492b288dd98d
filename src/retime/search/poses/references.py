"""References: what a motion is to move like, described by the same numbers as the motion itself (§3.2).

A reference may have another skeleton, another size, other units, other names; it may be looked at in a mirror; it may
be a group of clips where the input is one. All of them end as pose vectors that compare with the input's, coordinate by
coordinate.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import ArrayLike

from retime.arrays import BoolArray, FloatArray, IntArray
from retime.brief import brief_repr, kind_of
from retime.checks import real
from retime.errors import OptionError
from retime.limits import LEAST_WEIGHT, MOST_WEIGHT
from retime.motion.any_motion import AnyMotion
from retime.motion.body import body_of
from retime.motion.joint_names import JointMatch, near_names
from retime.motion.motion import Motion
from retime.motion.signal import Signal
from retime.search.poses.counterparts import Counterpart, clip_names, describe
from retime.search.poses.spaces import PoseOptions, PoseSpace, Track, as_pose_options


@dataclass(frozen=True, eq=False)
class Reference:
    """A motion whose timing is wanted.

    Parameters
    ----------
    motion : Motion, Signal, or sequence of them
        What moves as is wanted; a group where the input is one, with as many clips in the same order. A stretch of a
        clip is given by ``motion.frames(start, stop)``; a few frames suffice.
    weight : float
        Divides this reference's distances: 2 makes it look twice as near as it is. Above 0.
    mirror : bool
        Offer its mirror image too (beside the motion itself, not in its place).
    joint_map : mapping of str to str
        Input joint (or channel) to the reference's, where names don't say it.
    name : str
        What to call it in messages; left out, the motion's name.

    Raises
    ------
    OptionError
        The weight is not above 0, or the group is empty.

    Examples
    --------
    >>> from fractions import Fraction
    >>> pan = Signal(("yaw",), np.linspace(0, 90, 46)[:, None], Fraction(30), name="pan")
    >>> Reference(pan, weight=2).label
    'pan'
    """

    motion: AnyMotion | Sequence[AnyMotion]
    weight: float = 1.0
    mirror: bool = False
    joint_map: Mapping[str, str] = field(default_factory=dict)
    name: str = ""

    __repr__ = brief_repr

    def __post_init__(self) -> None:
        _as_group(self.motion)
        object.__setattr__(self, "weight", real(self.weight, "the weight of a reference"))
        if not LEAST_WEIGHT <= self.weight <= MOST_WEIGHT:
            raise OptionError(
                f"the weight of a reference must be a finite number above 0, from {LEAST_WEIGHT:g} to "
                f"{MOST_WEIGHT:g}; found {self.weight}"
            )
        if not isinstance(self.joint_map, Mapping):
            raise OptionError(
                f"a joint map is a mapping from the input's names to the reference's; found {kind_of(self.joint_map)}"
            )
        object.__setattr__(self, "joint_map", dict(self.joint_map))

    @property
    def clips(self) -> tuple[AnyMotion, ...]:
        """The motions of the group; one, where it is none."""
        return _as_group(self.motion)

    @property
    def label(self) -> str:
        """What to call it."""
        return self.name or self.clips[0].name or "the reference"


@dataclass(frozen=True, eq=False)
class PoseTracks:
    """Pose vectors of a clip, or of the clips of a group side by side.

    Attributes
    ----------
    tracks : tuple of Track
        One a clip.
    name : str
        What to call it.
    weight : float
        Divides distances to it.
    mirrored : bool
        Whether this is the mirror image.
    matches : tuple of JointMatch or None
        For each clip which joints were matched with the input's; None where the skeleton is the same, and for signals.
    order : int array, shape (n_numbers,), optional
        Which numbers come first when the clips are read; left out, they stay in the clips' order.
    """

    tracks: tuple[Track, ...]
    name: str = ""
    weight: float = 1.0
    mirrored: bool = False
    matches: tuple[JointMatch | None, ...] = ()
    order: IntArray | None = None

    __repr__ = brief_repr

    @property
    def end_time(self) -> float:
        """Time of the last frame that all clips have, seconds."""
        return min(track.end_time for track in self.tracks)

    @property
    def n_numbers(self) -> int:
        """Numbers that describe a pose."""
        return sum(track.vectors.shape[1] for track in self.tracks)

    def at(self, times: ArrayLike, cutoff: float) -> FloatArray:
        """Low-pass each clip at its own rate and read all of them at `times` (seconds); shape (n, n_numbers)."""
        return self._joined([track.at(times, cutoff) for track in self.tracks])

    def _joined(self, parts: Sequence[FloatArray]) -> FloatArray:
        joined = parts[0] if len(parts) == 1 else np.concatenate(parts, axis=1)
        return joined if self.order is None else np.take(joined, self.order, axis=1)

    @property
    def has_gaps(self) -> bool:
        """Whether something is lost of any clip."""
        return any(track.missing is not None for track in self.tracks)

    def missing_at(self, times: ArrayLike) -> BoolArray:
        """Tell at which times (n,), seconds, something of any clip is lost."""
        return np.asarray(np.any([track.missing_at(times) for track in self.tracks], axis=0))

    def at_rate(self, rate: float, cutoff: float) -> FloatArray:
        """Read at `rate` Hz from the first frame to the last; shape (n_frames at that rate, n_numbers)."""
        n_frames = self.count_at(rate)
        return self._joined([track.at_rate(n_frames, rate, cutoff) for track in self.tracks])

    def count_at(self, rate: float) -> int:
        """How many frames `at_rate` reads."""
        return int(np.floor(self.end_time * rate + 1e-6)) + 1


@dataclass(frozen=True, eq=False)
class ModelPoses:
    """Input and references, described by the same numbers.

    Attributes
    ----------
    input : PoseTracks
        The input.
    references : tuple of PoseTracks
        Each reference, followed by its mirror image where that is wanted.
    """

    input: PoseTracks
    references: tuple[PoseTracks, ...]

    __repr__ = brief_repr

    def in_own_order(self) -> ModelPoses:
        """Order the numbers by what they are, where the clips' files have them by joint or by channel.

        Sums over them are then the same to the last bit whatever order a file lists its joints in, and whatever it
        calls them; so is the choice between paths that are equally good.
        """
        everything = [
            [column for track in poses.tracks for column in track.vectors.T] for poses in (self.input, *self.references)
        ]
        first = [float(column[0]) for column in everything[0]]
        shared = Counter(first)

        def key(number: int) -> tuple[float, bytes]:
            # Joints that begin in one place are told apart by all their numbers; those alike in all may be exchanged.
            alike = shared[first[number]] > 1
            return first[number], b"".join(columns[number].tobytes() for columns in everything) if alike else b""

        order = np.array(sorted(range(len(first)), key=key), dtype=np.intp)
        return ModelPoses(
            replace(self.input, order=order), tuple(replace(poses, order=order) for poses in self.references)
        )


def model_poses(
    input_motion: AnyMotion | Sequence[AnyMotion],
    references: Sequence[Reference] = (),
    options: PoseOptions | PoseSpace | Sequence[PoseOptions] | None = None,
) -> ModelPoses:
    """Describe the poses of an input and of its references by the same numbers.

    A reference with the input's skeleton (the same names from the root, in any order, and the same rest offsets) is
    described as the input is. One with another skeleton is posed on the input's: joints are matched by name (see
    `match_joints` in `retime.motion.joint_names`), and axes and proportions are made the input's
    (`retime.motion.proportions`), so that a child and a giant in the same pose get the same numbers, whatever their
    units. Then only joints that all references share are compared. In heading space a Z-up reference is stood upright,
    and one that stays far above or below the input's floor is put on it. Channels of signals are matched by name, and
    scaled by their standard deviation over all references together, the axes of points alike.

    The clips of a group are compared each with its counterpart, in its own space: how they stand to each other is not
    looked at. Lengths of a group are in the unit of its first clip, where units are known.

    Parameters
    ----------
    input_motion : Motion, Signal, or sequence of them
        The input; a sequence is a group that gets one warp.
    references : sequence of Reference
        None given: the input itself.
    options : PoseOptions, str, or sequence of PoseOptions
        What counts. One for all clips of a group, each of which looks for its own joints in it; or one for each.

    Returns
    -------
    ModelPoses
        Pose vectors at the clips' own rates.

    Raises
    ------
    OptionError
        A clip and its counterpart are not of one kind, too few joints are matched, a name is not there, the clips of a
        group last differently, or there is no left and right to mirror.

    Examples
    --------
    >>> from fractions import Fraction
    >>> t = np.arange(60) / 30
    >>> wave = Signal(("x", "y"), np.stack([np.sin(t), np.cos(t)], axis=1), Fraction(30))
    >>> fast = Signal(("y", "x"), np.stack([np.cos(2 * t), np.sin(2 * t)], axis=1), Fraction(60))
    >>> model = model_poses(wave, [Reference(fast)], PoseOptions(scale_signals=False))
    >>> model.references[0].at_rate(30, 0).shape
    (30, 2)
    """
    clips = _as_group(input_motion)
    references = tuple(references) or (Reference(input_motion),)
    # Nodes above the body are no part of any pose.
    clips = tuple(_body(clip) for clip in clips)
    references = tuple(
        replace(reference, motion=tuple(_body(clip) for clip in reference.clips)) for reference in references
    )
    _check_durations(clips, "the input")
    for i, reference in enumerate(references):
        if len(reference.clips) != len(clips):
            raise OptionError(
                f"the input has {len(clips)} clip{'s' * (len(clips) > 1)} and {reference.label} has "
                f"{len(reference.clips)}: a reference needs a counterpart for each, in the same order",
                option="reference",
                item=i,
            )
        _check_durations(reference.clips, reference.label, i)
    own_options = _options_of_clips(clips, options)
    own_maps = [_maps_of_clips(clips, reference, i) for i, reference in enumerate(references)]

    columns = []
    for place, clip in enumerate(clips):
        others = [
            Counterpart(reference.clips[place], maps[place], reference.mirror, reference.label, i)
            for i, (reference, maps) in enumerate(zip(references, own_maps, strict=True))
        ]
        unit = _units_per_unit(clips[0], clip)
        columns.append(describe(clip, others, own_options[place], unit))

    found = []
    for i, reference in enumerate(references):
        parts = [column.others[i] for column in columns]
        matches = tuple(part.match for part in parts)
        found.append(PoseTracks(tuple(part.track for part in parts), reference.label, reference.weight, False, matches))
        if reference.mirror:
            mirrored = tuple(part.mirrored for part in parts if part.mirrored is not None)
            found.append(PoseTracks(mirrored, f"{reference.label}, mirrored", reference.weight, True, matches))
    name = clips[0].name or "the input"
    return ModelPoses(PoseTracks(tuple(column.track for column in columns), name), tuple(found))


def _as_group(motion: AnyMotion | Sequence[AnyMotion]) -> tuple[AnyMotion, ...]:
    if not isinstance(motion, AnyMotion | Sequence) or isinstance(motion, str):
        raise OptionError(f"expected a motion, a signal, or several of them; found {kind_of(motion)}")
    clips = (motion,) if isinstance(motion, AnyMotion) else tuple(motion)
    if not clips:
        raise OptionError("a group needs at least one clip")
    for clip in clips:
        if not isinstance(clip, AnyMotion):
            raise OptionError(f"a group is made of motions and signals, found {type(clip).__name__}")
    return clips


def _body(clip: AnyMotion) -> AnyMotion:
    return body_of(clip) if isinstance(clip, Motion) else clip


def _check_durations(clips: Sequence[AnyMotion], whose: str, reference: int | None = None) -> None:
    """Refuse a group whose clips don't last alike, within half a frame of the slowest.

    At different rates clips may be as long as one another, or have their last frames at one time: either will do.
    """
    shortest, longest = min(clips, key=lambda clip: clip.duration), max(clips, key=lambda clip: clip.duration)
    ends = [clip.end_time for clip in clips]
    tolerance = 0.5 / float(min(clip.rate for clip in clips))
    if min(longest.duration - shortest.duration, max(ends) - min(ends)) > tolerance * (1 + 1e-9):
        names = [f"{clip.name or f'clip {clips.index(clip)}'} {clip.duration:.3f} s" for clip in (shortest, longest)]
        raise OptionError(
            f"the clips of a group must last alike (within {tolerance:.3f} s); in {whose} are {names[0]} and "
            f"{names[1]}",
            option="motion" if reference is None else "reference",
            item=reference,
        )


def _units_per_unit(first: AnyMotion, clip: AnyMotion) -> float:
    """How long a clip's unit is in the first one's, where both are known."""
    units = [of.metres_per_unit if isinstance(of, Motion) else None for of in (first, clip)]
    if clip is first or units[0] is None or units[1] is None:
        return 1.0
    return units[1] / units[0]


def _options_of_clips(
    clips: Sequence[AnyMotion], options: PoseOptions | PoseSpace | Sequence[PoseOptions] | None
) -> list[PoseOptions]:
    """Give each clip its options; of one for all, each takes what it has joints for."""
    if isinstance(options, Sequence) and not isinstance(options, str):
        if len(options) != len(clips):
            raise OptionError(f"{len(clips)} clips need as many pose options, or one for all; found {len(options)}")
        return list(options)
    shared = as_pose_options(options)
    if len(clips) == 1:
        return [shared]
    signals = [clip for clip in clips if isinstance(clip, Signal)]
    for mentioned, where in (((*(shared.joints or ()), *shared.weights), clips), (shared.scales, signals)):
        everyone = {name for clip in where for name in clip_names(clip)}
        for name in mentioned:
            if name not in everyone:
                raise OptionError(f"no clip of the group has {name!r}{near_names(name, everyone)}")
    mixed = 0 < len(signals) < len(clips)
    result = []
    for clip in clips:
        names = set(clip_names(clip))
        signal = isinstance(clip, Signal)
        joints = None if shared.joints is None else tuple(name for name in shared.joints if name in names)
        if joints == ():
            raise OptionError(
                f"none of the chosen joints is in {clip.name or 'a clip of the group'}: give pose options for each clip"
            )
        result.append(
            replace(
                shared,
                space=None if mixed and signal != (shared.space == "signal") else shared.space,
                joints=joints,
                weights={name: weight for name, weight in shared.weights.items() if name in names},
                scales={name: scale for name, scale in shared.scales.items() if name in names and signal},
            )
        )
    return result


def _maps_of_clips(clips: Sequence[AnyMotion], reference: Reference, place: int) -> list[dict[str, str]]:
    """Give each clip of a group the part of the joint map that names its joints."""
    everyone = {name for clip in clips for name in clip_names(clip)}
    for name in reference.joint_map:
        if name not in everyone:
            raise OptionError(
                f"the joint map names {name!r}, which the input has not{near_names(name, everyone)}",
                option="reference",
                item=place,
            )
    return [{name: to for name, to in reference.joint_map.items() if name in clip_names(clip)} for clip in clips]
