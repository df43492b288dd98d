"""References: what a motion is to move like, described by the same numbers as the motion itself (§3.2).

A reference may have another skeleton, another size, other units, other names; it may be looked at in a mirror; it may
be a group of clips where the input is one. All of them end as pose vectors that compare with the input's, coordinate by
coordinate.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from fractions import Fraction

import numpy as np
from numpy.typing import ArrayLike

from retime.errors import OptionError
from retime.motion.joint_names import JointMatch, match_joints, mirror_partners, near_names, shorten, take_apart
from retime.motion.kinematics import GlobalPoses, global_poses
from retime.motion.motion import Motion
from retime.motion.proportions import (
    RestPose,
    SkeletonFit,
    fit_skeletons,
    lateral_axis,
    mirror_poses,
    still_joints,
    turn_poses,
    upright_turn,
)
from retime.motion.rotation import FloatArray
from retime.motion.signal import Signal
from retime.motion.skeleton import Skeleton
from retime.warp.features import (
    PoseOptions,
    as_pose_options,
    chosen_places,
    joint_vectors,
    low_pass,
    pose_space,
    sample,
    signal_scales,
    signal_vectors,
    space_joints,
)

Clip = Motion | Signal
# Joints that must be matched before two skeletons can be laid over each other.
_LEAST_MATCHED = 3
# Rest offsets that differ by less, as a share of the longest, are those of one skeleton.
_SAME_REST = 1e-6


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

    motion: Clip | Sequence[Clip]
    weight: float = 1.0
    mirror: bool = False
    joint_map: Mapping[str, str] = field(default_factory=dict)
    name: str = ""

    def __post_init__(self) -> None:
        _as_group(self.motion)
        if not (np.isfinite(self.weight) and self.weight > 0):
            raise OptionError(f"the weight of a reference must be a finite number above 0, found {self.weight}")
        object.__setattr__(self, "joint_map", dict(self.joint_map))

    @property
    def clips(self) -> tuple[Clip, ...]:
        """The motions of the group; one, where it is none."""
        return _as_group(self.motion)

    @property
    def label(self) -> str:
        """What to call it."""
        return self.name or self.clips[0].name or "the reference"


@dataclass(frozen=True, eq=False)
class Track:
    """Pose vectors of one clip at its own rate.

    Attributes
    ----------
    vectors : float array, shape (n_frames, n_numbers)
        One pose a frame.
    rate : Fraction
        Frames a second.
    """

    vectors: FloatArray
    rate: Fraction
    # The vectors low-passed at the last cutoff: a clip is read many times while its keytimes are dragged.
    _passed: dict[float, FloatArray] = field(default_factory=dict, init=False, repr=False)

    @property
    def duration(self) -> float:
        """Seconds from the first frame to the last."""
        return float((len(self.vectors) - 1) / self.rate)

    def at(self, times: ArrayLike, cutoff: float) -> FloatArray:
        """Low-pass at `cutoff` Hz (0 is off) and read at `times` (seconds); shape (n, n_numbers)."""
        passed = self._passed.get(cutoff)
        if passed is None:
            passed = low_pass(self.vectors, self.rate, cutoff)
            self._passed.clear()
            self._passed[cutoff] = passed
        return sample(passed, self.rate, times)


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
    """

    tracks: tuple[Track, ...]
    name: str = ""
    weight: float = 1.0
    mirrored: bool = False
    matches: tuple[JointMatch | None, ...] = ()

    @property
    def duration(self) -> float:
        """Seconds that all clips last."""
        return min(track.duration for track in self.tracks)

    @property
    def n_numbers(self) -> int:
        """Numbers that describe a pose."""
        return sum(track.vectors.shape[1] for track in self.tracks)

    def at(self, times: ArrayLike, cutoff: float) -> FloatArray:
        """Low-pass each clip at its own rate and read all of them at `times` (seconds); shape (n, n_numbers)."""
        parts = [track.at(times, cutoff) for track in self.tracks]
        return parts[0] if len(parts) == 1 else np.concatenate(parts, axis=1)

    def at_rate(self, rate: float, cutoff: float) -> FloatArray:
        """Read at `rate` Hz from the first frame to the last; shape (n_frames at that rate, n_numbers)."""
        return self.at(np.arange(int(np.floor(self.duration * rate + 1e-6)) + 1) / rate, cutoff)


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


def model_poses(
    input_motion: Clip | Sequence[Clip],
    references: Sequence[Reference] = (),
    options: PoseOptions | str | Sequence[PoseOptions] | None = None,
) -> ModelPoses:
    """Describe the poses of an input and of its references by the same numbers.

    A reference with the input's skeleton (the same names in the same order, the same rest offsets) is described as the
    input is. One with another skeleton is posed on the input's: joints are matched by name (see `match_joints` in
    `retime.motion.joint_names`), and axes and proportions are made the input's (`retime.motion.proportions`), so that a
    child and a giant in the same pose get the same numbers, whatever their units. Then only joints that all references
    share are compared. In heading space a Z-up reference is stood upright, and one that stays far above or below the
    input's floor is put on it. Channels of signals are matched by name, and scaled by their standard deviation over all
    references together.

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
    _check_durations(clips, "the input")
    for reference in references:
        if len(reference.clips) != len(clips):
            raise OptionError(
                f"the input has {len(clips)} clip{'s' * (len(clips) > 1)} and {reference.label} has "
                f"{len(reference.clips)}: a reference needs a counterpart for each, in the same order"
            )
        _check_durations(reference.clips, reference.label)
    own_options = _options_of_clips(clips, options)
    own_maps = [_maps_of_clips(clips, reference) for reference in references]

    columns = []
    for place, clip in enumerate(clips):
        others = [
            _Counterpart(reference.clips[place], maps[place], reference.mirror, reference.label)
            for reference, maps in zip(references, own_maps, strict=True)
        ]
        unit = _units_per_unit(clips[0], clip)
        columns.append(_describe(clip, others, own_options[place], unit))

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


@dataclass(frozen=True, eq=False)
class _Counterpart:
    """What one clip of the input is compared with."""

    clip: Clip
    joint_map: Mapping[str, str]
    mirror: bool
    label: str


@dataclass(frozen=True, eq=False)
class _Described:
    """One clip of a reference, described."""

    track: Track
    mirrored: Track | None
    match: JointMatch | None


@dataclass(frozen=True, eq=False)
class _Column:
    """One clip of the input, and its counterparts."""

    track: Track
    others: tuple[_Described, ...]


def _as_group(motion: Clip | Sequence[Clip]) -> tuple[Clip, ...]:
    clips = (motion,) if isinstance(motion, Motion | Signal) else tuple(motion)
    if not clips:
        raise OptionError("a group needs at least one clip")
    for clip in clips:
        if not isinstance(clip, Motion | Signal):
            raise OptionError(f"a group is made of motions and signals, found {type(clip).__name__}")
    return clips


def _check_durations(clips: Sequence[Clip], whose: str) -> None:
    """Refuse a group whose clips don't last alike, within half a frame of the slowest."""
    shortest, longest = min(clips, key=lambda clip: clip.duration), max(clips, key=lambda clip: clip.duration)
    tolerance = 0.5 / float(min(clip.rate for clip in clips))
    if longest.duration - shortest.duration > tolerance * (1 + 1e-9):
        names = [f"{clip.name or f'clip {clips.index(clip)}'} {clip.duration:.3f} s" for clip in (shortest, longest)]
        raise OptionError(
            f"the clips of a group must last alike (within {tolerance:.3f} s); in {whose} are {names[0]} and {names[1]}"
        )


def _units_per_unit(first: Clip, clip: Clip) -> float:
    """How long a clip's unit is in the first one's, where both are known."""
    units = [of.metres_per_unit if isinstance(of, Motion) else None for of in (first, clip)]
    if clip is first or units[0] is None or units[1] is None:
        return 1.0
    return units[1] / units[0]


def _names(clip: Clip) -> tuple[str, ...]:
    return clip.skeleton.names if isinstance(clip, Motion) else clip.names


def _options_of_clips(
    clips: Sequence[Clip], options: PoseOptions | str | Sequence[PoseOptions] | None
) -> list[PoseOptions]:
    """Give each clip its options; of one for all, each takes what it has joints for."""
    if isinstance(options, Sequence) and not isinstance(options, str):
        if len(options) != len(clips):
            raise OptionError(f"{len(clips)} clips need as many pose options, or one for all; found {len(options)}")
        return list(options)
    shared = as_pose_options(options)
    if len(clips) == 1:
        return [shared]
    everyone = {name for clip in clips for name in _names(clip)}
    for name in (*(shared.joints or ()), *shared.weights, *shared.scales):
        if name not in everyone:
            raise OptionError(f"no clip of the group has {name!r}{near_names(name, everyone)}")
    result = []
    for clip in clips:
        names = set(_names(clip))
        signal = isinstance(clip, Signal)
        joints = None if shared.joints is None else tuple(name for name in shared.joints if name in names)
        if joints == ():
            raise OptionError(
                f"none of the chosen joints is in {clip.name or 'a clip of the group'}: give pose options for each clip"
            )
        result.append(
            replace(
                shared,
                space=shared.space if signal == (shared.space == "signal") else None,
                joints=joints,
                weights={name: weight for name, weight in shared.weights.items() if name in names},
                scales={name: scale for name, scale in shared.scales.items() if name in names and signal},
            )
        )
    return result


def _maps_of_clips(clips: Sequence[Clip], reference: Reference) -> list[dict[str, str]]:
    """Give each clip of a group the part of the joint map that names its joints."""
    everyone = {name for clip in clips for name in _names(clip)}
    for name in reference.joint_map:
        if name not in everyone:
            raise OptionError(f"the joint map names {name!r}, which the input has not{near_names(name, everyone)}")
    return [{name: to for name, to in reference.joint_map.items() if name in _names(clip)} for clip in clips]


def _describe(clip: Clip, others: Sequence[_Counterpart], options: PoseOptions, unit: float) -> _Column:
    for other in others:
        if isinstance(other.clip, Motion) != isinstance(clip, Motion):
            kinds = ["a motion" if isinstance(of, Motion) else "a signal" for of in (clip, other.clip)]
            raise OptionError(
                f"input and reference must be of one kind: {clip.name or 'the input'} is {kinds[0]}, {other.label} is "
                f"{kinds[1]}"
            )
    if isinstance(clip, Signal):
        return _describe_signal(clip, others, options)
    return _MotionDescriber(clip, others, options, unit).column()


def _describe_signal(clip: Signal, others: Sequence[_Counterpart], options: PoseOptions) -> _Column:
    """Order the references' channels as the input's, and scale all by the references' spread."""
    pose_space(clip, options)
    needed = [clip.names[place] for place in chosen_places(clip.names, range(len(clip.names)), options, clip.name)]
    ordered = []
    for other in others:
        if other.mirror:
            raise OptionError(f"{other.label} is a signal, which has no left and right to mirror")
        assert isinstance(other.clip, Signal)
        ordered.append(_with_channels_of(clip, other.clip, other, needed))
    scales = signal_scales(clip.names, [signal.values for signal in ordered], options)
    track = Track(signal_vectors(clip, options, scales), clip.rate)
    return _Column(
        track,
        tuple(
            _Described(
                track if signal is clip else Track(signal_vectors(signal, options, scales), signal.rate), None, None
            )
            for signal in ordered
        ),
    )


def _with_channels_of(clip: Signal, signal: Signal, other: _Counterpart, needed: Sequence[str]) -> Signal:
    """Order a signal's channels as the input's; those that nobody needs may be missing, and are zero."""
    if signal.names == clip.names and not other.joint_map:
        return signal
    places: list[int | None] = []
    for name in clip.names:
        wanted = other.joint_map.get(name, name)
        if wanted not in signal.names and (name in needed or name in other.joint_map):
            raise OptionError(
                f"{other.label} has no channel {wanted!r}{near_names(wanted, signal.names)}; choose channels that both "
                "have, or map the input's names to its names"
            )
        places.append(signal.names.index(wanted) if wanted in signal.names else None)
    zero = np.zeros(signal.n_frames)
    values = np.stack([zero if place is None else signal.values[:, place] for place in places], axis=1)
    return replace(signal, names=clip.names, values=values)


class _MotionDescriber:
    """Describes a motion and its counterparts by the joints that all of them have."""

    def __init__(self, clip: Motion, others: Sequence[_Counterpart], options: PoseOptions, unit: float) -> None:
        self.clip, self.others, self.options, self.unit = clip, others, options, unit
        self.space = pose_space(clip, options)
        self.names = clip.skeleton.names
        self.rest = RestPose.of(clip.skeleton)
        self.poses = global_poses(clip)
        self.matches = [self._match(other) for other in others]
        self.partners = [mirror_partners(_names(other.clip)) if other.mirror else None for other in others]
        self.joints = self._common_joints()

    def column(self) -> _Column:
        """Describe all of them."""
        track = self._track(self.poses, self.clip.rate)
        return _Column(track, tuple(self._described(i, track) for i in range(len(self.others))))

    def _track(self, poses: GlobalPoses, rate: Fraction) -> Track:
        vectors = joint_vectors(poses, self.names, self.joints, self.space, self.options)
        return Track(vectors if self.unit == 1.0 else vectors * self.unit, rate)

    def _match(self, other: _Counterpart) -> JointMatch | None:
        """Match the joints; None where the skeletons are the same."""
        assert isinstance(other.clip, Motion)
        if not other.joint_map and _same_skeleton(self.clip.skeleton, other.clip.skeleton):
            return None
        match = match_joints(self.names, other.clip.skeleton.names, other.joint_map)
        if len(match.pairs) < _LEAST_MATCHED:
            matched = shorten((self.names[joint] for joint, _ in match.pairs), 3)
            raise OptionError(
                f"{other.label} has another skeleton, and too few of its joints could be matched with the input's: "
                f"{len(match.pairs)} ({matched}) of at least {_LEAST_MATCHED}. Without a match are "
                f"{shorten(match.unmatched_input, 8)} of the input and {shorten(match.unmatched_reference, 8)} of the "
                "reference. Give a joint map that says which is which (joint_map, from input joint to reference joint)"
            )
        return match

    def _common_joints(self) -> list[int]:
        """List the joints that count and that every reference has, mirrored too where it is."""
        chosen = chosen_places(self.names, space_joints(self.clip, self.space), self.options, self.clip.name)
        why_not: dict[int, str] = {}
        for other, match, partners in zip(self.others, self.matches, self.partners, strict=True):
            partner = {joint: joint for joint in chosen} if match is None else dict(match.pairs)
            for joint in chosen:
                if joint not in partner:
                    left = "" if match is None else near_names(self.names[joint], match.unmatched_reference)
                    why_not.setdefault(joint, f"{other.label} has no joint that is known to be the same{left}")
                elif partners is not None and partners[partner[joint]] is None:
                    why_not.setdefault(joint, f"{other.label} has it on one side only, so it has no mirror image")
        common = [joint for joint in chosen if joint not in why_not]
        for name in self.options.joints or ():
            if not any(self.names[joint] == name for joint in common):
                reason = next(why for joint, why in why_not.items() if self.names[joint] == name)
                raise OptionError(f"the chosen joint {name!r} can't be compared: {reason}. A joint map may help")
        if not any(self.options.weights.get(self.names[joint], 1.0) for joint in common):
            raise OptionError(
                f"no joint that counts is left to compare {self.clip.name or 'the input'} by: "
                + "; ".join(f"{self.names[joint]!r}: {why}" for joint, why in list(why_not.items())[:3])
            )
        return common

    def _described(self, i: int, track: Track) -> _Described:
        other, match, partners = self.others[i], self.matches[i], self.partners[i]
        motion = other.clip
        assert isinstance(motion, Motion)
        poses = self.poses if motion is self.clip else global_poses(motion)
        rest = RestPose.of(motion.skeleton)
        pairs = tuple((joint, joint) for joint in range(len(self.names))) if match is None else match.pairs
        if match is None:
            plain = track if motion is self.clip else self._track(poses, motion.rate)
        else:
            plain = self._fitted(motion, rest, poses, pairs, other)
        mirrored = None
        if partners is not None:
            apart = take_apart(motion.skeleton.names)
            sides = [(joint, to) for joint, to in enumerate(partners) if to is not None and apart[joint].side == "left"]
            if not sides:
                raise OptionError(
                    f"{other.label} can't be mirrored: no two of its joints are called left and right "
                    f"({shorten(motion.skeleton.names, 8)})"
                )
            # Joints of one side only stay where they are; nobody looks at them.
            places = [joint if to is None else to for joint, to in enumerate(partners)]
            lateral = lateral_axis(rest, sides)
            pairs = tuple((joint, to) for joint, to in pairs if partners[to] is not None)
            poses = mirror_poses(poses, places, lateral)
            mirrored = self._fitted(motion, rest.mirrored(places, lateral), poses, pairs, other)
        return _Described(plain, mirrored, match)

    def _fitted(
        self,
        motion: Motion,
        rest: RestPose,
        poses: GlobalPoses,
        pairs: Sequence[tuple[int, int]],
        other: _Counterpart,
    ) -> Track:
        """Pose the input's skeleton like the reference."""
        try:
            fit = fit_skeletons(self.rest, rest, pairs)
        except OptionError as error:
            raise OptionError(f"{other.label} can't be compared with the input: {error}") from None
        if self.space == "heading":
            turn = upright_turn(fit, self.poses.rotations[:, 0], poses.rotations[:, fit.base])
            poses = turn_poses(poses, turn)
        placed = fit.place(poses, still_joints(self.poses, self.rest))
        if self.space == "heading":
            joints = [part.joint for part in fit.stretches]
            placed = _on_floor(placed, float(self.poses.positions[:, joints, 1].min()), fit.size)
        return self._track(_in_input_order(placed, fit, len(self.names)), motion.rate)


def _on_floor(placed: GlobalPoses, lowest: float, size: float) -> GlobalPoses:
    """Lift or lower poses that never come near the input's lowest point, by more than any jump: their floor is not at 0."""
    lift = lowest - float(placed.positions[:, 1:, 1].min())
    if abs(lift) < size:
        return placed
    return replace(placed, positions=placed.positions + np.array([0.0, lift, 0.0]))


def _in_input_order(placed: GlobalPoses, fit: SkeletonFit, n_joints: int) -> GlobalPoses:
    """Spread the matched joints over the places that they have in the input; the others stay at zero."""
    positions = np.zeros((len(placed.positions), n_joints, 3))
    positions[:, [0, *(part.joint for part in fit.stretches)]] = placed.positions
    return GlobalPoses(positions, placed.rotations, placed.end_positions)


def _same_skeleton(a: Skeleton, b: Skeleton) -> bool:
    if a.names != b.names or a.parents != b.parents:
        return False
    longest = float(np.abs(a.offsets[1:]).max(initial=0.0))
    return float(np.abs(a.offsets[1:] - b.offsets[1:]).max(initial=0.0)) <= _SAME_REST * longest
