"""One clip of the input beside its counterparts in the references: the same numbers for all of them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction

import numpy as np

from retime.brief import brief_repr
from retime.errors import OptionError
from retime.motion.any_motion import AnyMotion
from retime.motion.body import is_rigid
from retime.motion.channels import LINEAR, ChannelKind
from retime.motion.gaps import bridged
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
from retime.motion.signal import Signal
from retime.motion.skeleton import Skeleton
from retime.search.poses.carried import path_options, path_signal
from retime.search.poses.signals import signal_scales, signal_vectors, weighing_parts
from retime.search.poses.spaces import PoseOptions, Track, chosen_places, joint_vectors, pose_space, space_joints

# Joints that must be matched before two skeletons can be laid over each other.
_LEAST_MATCHED = 3
# Rest offsets that differ by less, as a share of the longest, are those of one skeleton.
_SAME_REST = 1e-6


@dataclass(frozen=True, eq=False)
class Counterpart:
    """What one clip of the input is compared with."""

    clip: AnyMotion
    joint_map: Mapping[str, str]
    mirror: bool
    label: str
    # Which of the references it belongs to, counted from 0.
    place: int = 0

    __repr__ = brief_repr

    def fault(self, message: str) -> OptionError:
        """Make an error that names the reference as what is at fault."""
        return OptionError(message, option="reference", item=self.place)


@dataclass(frozen=True, eq=False)
class Described:
    """One clip of a reference, described."""

    track: Track
    mirrored: Track | None
    match: JointMatch | None

    __repr__ = brief_repr


@dataclass(frozen=True, eq=False)
class Column:
    """One clip of the input, and its counterparts."""

    track: Track
    others: tuple[Described, ...]

    __repr__ = brief_repr


def clip_names(clip: AnyMotion) -> tuple[str, ...]:
    """Names of a clip's joints or channels."""
    return clip.skeleton.names if isinstance(clip, Motion) else clip.names


def describe(clip: AnyMotion, others: Sequence[Counterpart], options: PoseOptions, unit: float) -> Column:
    """Describe a clip of the input and its counterparts by the same numbers.

    Parameters
    ----------
    clip : Motion or Signal
        Of the input.
    others : sequence of Counterpart
        One for each reference.
    options : PoseOptions
        What counts.
    unit : float
        Multiplies lengths.

    Raises
    ------
    OptionError
        They are not of one kind, share too little, or can't be mirrored.
    """
    for other in others:
        if isinstance(other.clip, Motion) != isinstance(clip, Motion):
            kinds = ["a motion" if isinstance(of, Motion) else "a signal" for of in (clip, other.clip)]
            raise other.fault(
                f"input and reference must be of one kind: {clip.name or 'the input'} is {kinds[0]}, {other.label} is "
                f"{kinds[1]}"
            )
    if isinstance(clip, Signal):
        return _describe_signal(clip, others, options)
    plain = options.space is None and options.joints is None and not options.weights
    if plain and all(is_rigid(one) for one in (clip, *(other.clip for other in others)) if isinstance(one, Motion)):
        return _describe_carried(clip, others)
    return _MotionDescriber(clip, others, options, unit).column()


def _describe_carried(clip: Motion, others: Sequence[Counterpart]) -> Column:
    """Describe what moves as one by its path and its turn: its pose in any space of its own never changes."""
    own = path_signal(clip)
    signals = []
    for other in others:
        if other.mirror:
            raise other.fault(f"{other.label} moves as one and can't be mirrored: it has no left and right")
        assert isinstance(other.clip, Motion)
        signals.append(own if other.clip is clip else path_signal(other.clip))
    options = path_options(signals)
    paths = [replace(other, clip=signal, joint_map={}) for other, signal in zip(others, signals, strict=True)]
    return _describe_signal(own, paths, options)


def _describe_signal(clip: Signal, others: Sequence[Counterpart], options: PoseOptions) -> Column:
    """Order the references' channels as the input's, and scale all by the references' spread."""
    pose_space(clip, options)
    needed = [clip.names[place] for part in weighing_parts(clip, options) for place in part.columns]
    ordered = []
    for other in others:
        if other.mirror:
            raise other.fault(f"{other.label} is a signal, which has no left and right to mirror")
        assert isinstance(other.clip, Signal)
        if options.joints is None and not other.joint_map:
            _refuse_other_count(clip, other.clip, other)
        ordered.append(_with_channels_of(clip, other.clip, other, needed))
    kinds = _shared_kinds(clip, ordered)
    own = clip if kinds[0] == clip.kinds else replace(clip, kinds=kinds[0])
    ordered = [
        own if signal is clip else replace(signal, kinds=theirs)
        for signal, theirs in zip(ordered, kinds[1:], strict=True)
    ]
    # The search never sees a hole: gaps are bridged here, whatever their length, and marked.
    whole = {id(signal): _bridged(signal) for signal in (own, *ordered)}
    scales = signal_scales([whole[id(signal)] for signal in ordered], options)

    def track_of(signal: Signal) -> Track:
        filled = whole[id(signal)]
        lost = np.zeros(signal.n_frames, dtype=bool)
        for part in weighing_parts(signal, options):
            lost |= signal.holes[:, part.columns].any(axis=1)
        return Track(signal_vectors(filled, options, scales), signal.rate, lost if lost.any() else None)

    track = track_of(own)
    return Column(
        track, tuple(Described(track if signal is own else track_of(signal), None, None) for signal in ordered)
    )


def _bridged(signal: Signal) -> Signal:
    """Fill all gaps; raise OptionError where a channel that weighs has no value at all."""
    if not signal.holes.any():
        return signal
    values = bridged(signal.values, signal.names, signal.kinds)
    for place in np.flatnonzero(np.isnan(values).any(axis=0)):
        if signal.kinds[place].weighs:
            raise OptionError(f"channel {signal.names[place]!r} of {signal.name or 'the signal'} has no value at all")
    return replace(signal, values=values)


def _shared_kinds(clip: Signal, others: Sequence[Signal]) -> list[tuple[ChannelKind, ...]]:
    """Agree on what each channel holds, where only one of the clips shows it: an angle that goes round, say.

    Angles keep their own units. Where the input says something else than linear that holds, else what the first
    reference says that does.
    """
    kinds = [list(signal.kinds) for signal in (clip, *others)]
    for place in range(len(clip.names)):
        said = next((own[place] for own in kinds if own[place].kind != "linear" or not own[place].weighs), None)
        if said is not None:
            for own in kinds:
                if own[place].kind != said.kind or own[place].weighs != said.weighs:
                    own[place] = said
    return [tuple(own) for own in kinds]


def _refuse_other_count(clip: Signal, signal: Signal, other: Counterpart) -> None:
    """Refuse to match columns that have only their numbers, where there are more of them, or fewer."""
    if clip.numbered and signal.numbered and len(clip.names) != len(signal.names):
        raise other.fault(
            f"{other.label} has {len(signal.names)} channel{'s' * (len(signal.names) > 1)} and the input "
            f"{len(clip.names)}, without names that say which are the same: pass arrays with the same columns in the "
            "same order, signals with names (retime.Signal), or a joint map"
        )


def _with_channels_of(clip: Signal, signal: Signal, other: Counterpart, needed: Sequence[str]) -> Signal:
    """Order a signal's channels as the input's; those that nobody needs may be missing, and are zero."""
    if signal.names == clip.names and not other.joint_map:
        return signal
    places: list[int | None] = []
    for name in clip.names:
        wanted = other.joint_map.get(name, name)
        if wanted not in signal.names and (name in needed or name in other.joint_map):
            unnamed = "the input" if clip.numbered else other.label if signal.numbered else ""
            raise other.fault(
                f"{other.label} has no channel {wanted!r}{near_names(wanted, signal.names)}; choose channels that both "
                "have, or map the input's names to its names"
                + (f" ({unnamed} has none, only numbers; a retime.Signal has names)" if unnamed else "")
            )
        places.append(signal.names.index(wanted) if wanted in signal.names else None)
    zero = np.zeros(signal.n_frames)
    values = np.stack([zero if place is None else signal.values[:, place] for place in places], axis=1)
    # Of what is missing the kind is the input's, but for a rotation, which zeros are none.
    kinds = tuple(
        signal.kinds[place] if place is not None else LINEAR if own.kind == "quaternion" or own.words else own
        for place, own in zip(places, clip.kinds, strict=True)
    )
    return replace(signal, names=clip.names, values=values, kinds=kinds)


class _MotionDescriber:
    """Describes a motion and its counterparts by the joints that all of them have."""

    def __init__(self, clip: Motion, others: Sequence[Counterpart], options: PoseOptions, unit: float) -> None:
        self.clip, self.options, self.unit = clip, options, unit
        self.others = [replace(other, clip=_in_order_of(clip, other.clip)) for other in others]
        self.space = pose_space(clip, options)
        self.names = clip.skeleton.names
        self.rest = RestPose.of(clip.skeleton)
        self.poses = global_poses(clip)
        self.matches = [self._match(other) for other in self.others]
        self.partners = [self._mirror_partners(other) for other in self.others]
        self.joints = self._common_joints()

    def column(self) -> Column:
        """Describe all of them."""
        track = self._track(self.poses, self.clip.rate)
        return Column(track, tuple(self._described(i, track) for i in range(len(self.others))))

    def _track(self, poses: GlobalPoses, rate: Fraction) -> Track:
        vectors = joint_vectors(poses, self.names, self.joints, self.space, self.options)
        return Track(vectors if self.unit == 1.0 else vectors * self.unit, rate)

    def _match(self, other: Counterpart) -> JointMatch | None:
        """Match the joints; None where the skeletons are the same."""
        assert isinstance(other.clip, Motion)
        if not other.joint_map and _same_skeleton(self.clip.skeleton, other.clip.skeleton):
            return None
        try:
            match = match_joints(self.names, other.clip.skeleton.names, other.joint_map)
        except OptionError as error:
            raise other.fault(str(error)) from None
        if len(match.pairs) < _LEAST_MATCHED:
            matched = shorten((self.names[joint] for joint, _ in match.pairs), 3)
            raise other.fault(
                f"{other.label} has another skeleton, and too few of its joints could be matched with the input's: "
                f"{len(match.pairs)} ({matched}) of at least {_LEAST_MATCHED}. Without a match are "
                f"{shorten(match.unmatched_input, 8)} of the input and {shorten(match.unmatched_reference, 8)} of the "
                "reference. Give a joint map that says which is which (joint_map, from input joint to reference joint)"
            )
        return match

    def _mirror_partners(self, other: Counterpart) -> tuple[int | None, ...] | None:
        assert isinstance(other.clip, Motion)
        return mirror_partners(other.clip.skeleton.names, other.clip.skeleton.parents) if other.mirror else None

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

    def _described(self, i: int, track: Track) -> Described:
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
                raise other.fault(
                    f"{other.label} can't be mirrored: no two of its joints are called left and right "
                    f"({shorten(motion.skeleton.names, 8)})"
                )
            # Joints without a partner on the other side stay where they are; they are not compared.
            places = [joint if to is None else to for joint, to in enumerate(partners)]
            lateral = lateral_axis(rest, sides)
            pairs = tuple((joint, to) for joint, to in pairs if partners[to] is not None)
            poses = mirror_poses(poses, places, lateral)
            mirrored = self._fitted(motion, rest.mirrored(places, lateral), poses, pairs, other)
        return Described(plain, mirrored, match)

    def _fitted(
        self,
        motion: Motion,
        rest: RestPose,
        poses: GlobalPoses,
        pairs: Sequence[tuple[int, int]],
        other: Counterpart,
    ) -> Track:
        """Pose the input's skeleton like the reference."""
        try:
            fit = fit_skeletons(self.rest, rest, pairs)
        except OptionError as error:
            raise other.fault(f"{other.label} can't be compared with the input: {error}") from None
        if self.space == "heading":
            turn = upright_turn(fit, self.poses.rotations[:, 0], poses.rotations[:, fit.base])
            poses = turn_poses(poses, turn)
        placed = fit.place(poses, still_joints(self.poses, self.rest))
        if self.space == "heading":
            joints = [part.joint for part in fit.stretches]
            placed = _on_floor(placed, float(self.poses.positions[:, joints, 1].min()), fit.size)
        return self._track(_in_input_order(placed, fit, len(self.names)), motion.rate)


def _on_floor(placed: GlobalPoses, lowest: float, size: float) -> GlobalPoses:
    """Lift or lower poses that stay farther from the input's lowest point than any jump: their floor is not at 0."""
    lift = lowest - float(placed.positions[:, 1:, 1].min())
    if abs(lift) < size:
        return placed
    return replace(placed, positions=placed.positions + np.array([0.0, lift, 0.0]))


def _in_input_order(placed: GlobalPoses, fit: SkeletonFit, n_joints: int) -> GlobalPoses:
    """Spread the matched joints over the places that they have in the input; the others stay at zero."""
    positions = np.zeros((len(placed.positions), n_joints, 3))
    positions[:, [0, *(part.joint for part in fit.stretches)]] = placed.positions
    return GlobalPoses(positions, placed.rotations, placed.end_positions)


def _in_order_of(clip: Motion, other: AnyMotion) -> AnyMotion:
    """Put a motion's joints into the order that another's have, where they are the same by all names from the root."""
    if not isinstance(other, Motion) or (other.skeleton.names, other.skeleton.parents) == (
        clip.skeleton.names,
        clip.skeleton.parents,
    ):
        return other
    wanted, ways = _ways(clip.skeleton), _ways(other.skeleton)
    places = {way: joint for joint, way in enumerate(ways)}
    if not len(places) == len(ways) == len(wanted) or places.keys() != set(wanted):
        return other
    order = [places[way] for way in wanted]
    return Motion(
        Skeleton(clip.skeleton.names, clip.skeleton.parents, other.skeleton.offsets[order]),
        other.rotations[:, order],
        other.local_translations[:, order],
        other.rate,
        other.name,
        metres_per_unit=other.metres_per_unit,
        up=other.up,
    )


def _ways(skeleton: Skeleton) -> list[tuple[str, ...]]:
    """List the names from the root to each joint."""
    ways: list[tuple[str, ...]] = []
    for name, parent in zip(skeleton.names, skeleton.parents, strict=True):
        ways.append((*(ways[parent] if parent >= 0 else ()), name))
    return ways


def _same_skeleton(a: Skeleton, b: Skeleton) -> bool:
    if a.names != b.names or a.parents != b.parents:
        return False
    longest = float(np.abs(a.offsets[1:]).max(initial=0.0))
    return float(np.abs(a.offsets[1:] - b.offsets[1:]).max(initial=0.0)) <= _SAME_REST * longest
