"""One skeleton's poses with the axes and proportions of another, so that positions of the same joints compare.

Skeletons differ in four ways that say nothing about the pose, and each is undone.

Axes of the root.
    The rest poses say how one root's axes lie in the other's: by the rotation that brings the one rest pose nearest to
    the other. It minimises the sum of distances, not of their squares, so that limbs which rest differently (arms out,
    arms down) don't pull it.
Proportions.
    Each stretch between neighbouring matched joints keeps the direction that it has in the pose, and gets the length
    that it has in the other skeleton. Size and length units go with it. A stretch of no length, which has no direction,
    turns with the joint before it.
Place of the root in the pelvis.
    A joint that stands still against the root in both motions (the hips, mostly) is put where the input has it: where
    it stands is the skeleton's affair.
Joints between.
    Only matched joints are used; what lies between two of them (spines of two or of four joints) is one stretch.

Limbs that rest differently need no more: with arms out in one rest pose and down in the other, equal *rotations* mean
different poses, but equal *positions* mean equal poses, whatever the rest pose. So no rest position is subtracted.
"""

from __future__ import annotations

from collections.abc import Container, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from retime.arrays import FloatArray
from retime.brief import brief_repr
from retime.errors import OptionError
from retime.motion import rotation
from retime.motion.kinematics import GlobalPoses
from retime.motion.skeleton import Skeleton

# Lengths below this share of the skeleton's size count as 0.
_NOTHING = 1e-3
_UP = np.array([0.0, 1.0, 0.0])


@dataclass(frozen=True, eq=False)
class RestPose:
    """A skeleton at rest, its root at the origin.

    Attributes
    ----------
    parents : tuple of int
        Each joint's parent; -1 for the root.
    offsets : float array, shape (n_joints, 3)
        From the parent; the root's own is zero.
    positions : float array, shape (n_joints, 3)
        Joints from the root.
    """

    parents: tuple[int, ...]
    offsets: FloatArray
    positions: FloatArray

    __repr__ = brief_repr

    @classmethod
    def of(cls, skeleton: Skeleton) -> RestPose:
        """Lay out a skeleton at rest."""
        offsets = skeleton.offsets.copy()
        offsets[0] = 0.0
        positions = offsets.copy()
        for joint in range(1, skeleton.n_joints):
            positions[joint] += positions[skeleton.parents[joint]]
        return cls(skeleton.parents, offsets, positions)

    def mirrored(self, partners: Sequence[int], lateral: FloatArray) -> RestPose:
        """Reflect along the unit vector `lateral`; joint j takes the place of its partner."""
        places = np.asarray(partners)
        parents = [self.parents[place] for place in partners]
        return RestPose(
            tuple(-1 if parent < 0 else partners[parent] for parent in parents),
            reflect(self.offsets[places], lateral),
            reflect(self.positions[places], lateral),
        )

    def stretch(self, joint: int, stops: Container[int]) -> tuple[int, float, FloatArray]:
        """Walk up from a joint to the first of `stops`.

        Returns
        -------
        ancestor : int
            Where the walk ended; -1 past the root.
        length : float
            Of the bones on the way.
        offset : float array, shape (3,)
            From there to the joint.
        """
        length, offset = 0.0, np.zeros(3)
        while joint != -1:
            length += float(np.linalg.norm(self.offsets[joint]))
            offset = offset + self.offsets[joint]
            joint = self.parents[joint]
            if joint in stops:
                break
        return joint, length, offset


def reflect(vectors: FloatArray, normal: FloatArray) -> FloatArray:
    """Reflect vectors (..., 3) in the plane through the origin with this unit normal."""
    return np.asarray(vectors - 2.0 * (vectors @ normal)[..., None] * normal)


def lateral_axis(rest: RestPose, pairs: Sequence[tuple[int, int]]) -> FloatArray:
    """Find the direction from right to left in a rest pose.

    Parameters
    ----------
    rest : RestPose
        The skeleton.
    pairs : sequence of (int, int)
        Left joints and their right partners.

    Returns
    -------
    float array, shape (3,)
        Unit vector; exactly a coordinate axis where it lies within 15 degrees of one, since no skeleton is measured so
        well that its sides are quite alike.

    Raises
    ------
    OptionError
        Left and right joints rest in the same places.
    """
    # In an order that does not depend on the file's, so that the sum is the same to the last bit.
    pairs = sorted(pairs, key=lambda pair: _places(rest, rest, pair))
    across: FloatArray = sum((rest.positions[left] - rest.positions[right] for left, right in pairs), start=np.zeros(3))
    length = float(np.linalg.norm(across))
    if not length > _NOTHING * float(np.abs(rest.positions).max()):
        raise OptionError("left and right joints rest in the same places, so there is no telling how to mirror them")
    across = across / length
    axis = int(np.argmax(np.abs(across)))
    if abs(across[axis]) > np.cos(np.radians(15)):
        return np.asarray(np.sign(across[axis]) * np.eye(3)[axis])
    return across


def mirror_poses(poses: GlobalPoses, partners: Sequence[int], lateral: FloatArray) -> GlobalPoses:
    """Reflect global poses in the plane x = 0, with left and right joints exchanged.

    Parameters
    ----------
    poses : GlobalPoses
        Y (or Z) up: the plane must be a vertical one.
    partners : sequence of int
        For each joint the one whose place it takes.
    lateral : float array, shape (3,)
        From right to left at rest: joints' own axes are reflected along it, so that rotations stay rotations.
    """
    places = np.asarray(partners)
    # A reflection is a half turn about its normal and then a reflection in the origin; there are two of the latter,
    # in space and in the joint's own axes, and they cancel.
    half_turn = np.array([0.0, 1.0, 0.0, 0.0])
    own_half_turn = np.concatenate([[0.0], lateral])
    rotations = rotation.multiply(rotation.multiply(half_turn, poses.rotations[:, places]), own_half_turn)
    return GlobalPoses(
        poses.positions[:, places] * np.array([-1.0, 1.0, 1.0]), rotations, np.empty((len(rotations), 0, 3))
    )


def turn_poses(poses: GlobalPoses, turn: FloatArray) -> GlobalPoses:
    """Turn global poses about the origin."""
    return GlobalPoses(
        rotation.rotate(turn, poses.positions),
        rotation.multiply(turn, poses.rotations),
        rotation.rotate(turn, poses.end_positions),
    )


@dataclass(frozen=True, eq=False)
class Stretch:
    """The way from one matched joint to the next.

    Attributes
    ----------
    joint, reference_joint : int
        Where it ends.
    start, reference_start : int
        Where it begins; -1 where it is measured from the root, because the two skeletons branch differently.
    ratio : float
        Its length in the input over its length in the reference.
    offset : float array, shape (3,), optional
        In the input at rest: given where the reference has no length.
    """

    joint: int
    reference_joint: int
    start: int
    reference_start: int
    ratio: float
    offset: FloatArray | None = None

    __repr__ = brief_repr


@dataclass(frozen=True, eq=False)
class SkeletonFit:
    """How poses of a reference's skeleton become poses of the input's.

    Attributes
    ----------
    base : int
        The reference joint that is the input's root.
    scale : float
        Input lengths over reference lengths: what most of the body agrees on.
    root_scale : float
        The same for the root's height: by the length of the leg (whatever reaches lowest at rest).
    rotation : float array, shape (4,)
        Takes the reference root's axes at rest to the input's, wxyz.
    shift : float array, shape (3,)
        From the input's root to the reference's, in the input's root space and unit; zero where the two are matched.
    stretches : tuple of Stretch
        Parents first. The root itself has none.
    size : float
        Mean distance of the matched joints from the root at rest, in the input's unit.
    """

    base: int
    scale: float
    root_scale: float
    rotation: FloatArray
    shift: FloatArray
    stretches: tuple[Stretch, ...]
    size: float

    __repr__ = brief_repr

    def place(self, poses: GlobalPoses, still: Mapping[int, FloatArray]) -> GlobalPoses:
        """Pose the input's skeleton like the reference.

        Parameters
        ----------
        poses : GlobalPoses
            Of the reference.
        still : mapping of int to float array, shape (3,)
            Joints of the input that stand still against its root, and where they stand in root space.

        Returns
        -------
        GlobalPoses
            Positions of the root and of the joints of `stretches` in their order, shape (n_frames, 1 + n_stretches, 3);
            rotations of the root alone.
        """
        to_root = rotation.conjugate(poses.rotations[:, self.base])
        back = rotation.conjugate(self.rotation)
        # In the axes of the input's root, and still in the reference's unit.
        own = rotation.rotate(self.rotation, _from_base(poses, self.base))
        places: dict[int, FloatArray] = {0: np.zeros((len(own), 3))}
        for part in self.stretches:
            found = own[:, part.reference_joint]
            if part.joint in still and float(np.ptp(found, axis=0).max()) * self.scale < _NOTHING * self.size:
                places[part.joint] = np.broadcast_to(still[part.joint], found.shape)
            elif part.start < 0:
                places[part.joint] = part.ratio * found + self.shift
            elif part.offset is None:
                places[part.joint] = places[part.start] + part.ratio * (found - own[:, part.reference_start])
            else:
                turned = rotation.multiply(to_root, poses.rotations[:, part.reference_start])
                turned = rotation.multiply(rotation.multiply(self.rotation, turned), back)
                places[part.joint] = places[part.start] + rotation.rotate(turned, part.offset)
        turns = rotation.multiply(poses.rotations[:, self.base], back)
        root = self.root_scale * poses.positions[:, self.base] - rotation.rotate(turns, self.shift)
        joints = np.stack([places[0], *(places[part.joint] for part in self.stretches)], axis=1)
        return GlobalPoses(
            root[:, None] + rotation.rotate(turns[:, None], joints), turns[:, None], np.empty((len(own), 0, 3))
        )


def _from_base(poses: GlobalPoses, base: int) -> FloatArray:
    """Positions of all joints in the space of one of them."""
    inverse = rotation.conjugate(poses.rotations[:, base])
    return rotation.rotate(inverse[:, None], poses.positions - poses.positions[:, base : base + 1])


def still_joints(poses: GlobalPoses, rest: RestPose) -> dict[int, FloatArray]:
    """Find the joints that stand still against the root through all frames, and where they stand in its space."""
    places = _from_base(poses, 0)
    size = float(np.linalg.norm(rest.positions, axis=1).mean())
    still = np.flatnonzero(np.ptp(places, axis=0).max(axis=-1) < _NOTHING * size)
    return {int(joint): places[0, joint] for joint in still}


def fit_skeletons(rest: RestPose, reference: RestPose, pairs: Sequence[tuple[int, int]]) -> SkeletonFit:
    """Find how poses of one skeleton become poses of another.

    Parameters
    ----------
    rest : RestPose
        The input's.
    reference : RestPose
        The other one.
    pairs : sequence of (int, int)
        Joints of the input and of the reference that are the same.

    Raises
    ------
    OptionError
        The rest poses say too little: no lengths, or all matched joints in one line.
    """
    # By depth, so the root comes first where it is matched, and then by place: sums are the same to the last bit in
    # whatever order a file lists its joints.
    pairs = sorted(pairs, key=lambda pair: (_depth(rest, pair[0]), *_places(rest, reference, pair), pair))
    partner = dict(pairs)
    matched = set(partner.values())
    base = partner.get(0, 0)
    walks = {}
    for joint, other in pairs:
        start, length, offset = rest.stretch(joint, partner)
        reference_start, reference_length, _ = reference.stretch(other, matched)
        alike = start >= 0 and partner[start] == reference_start
        walks[joint] = (start if alike else -1, reference_start, length, reference_length, offset)

    ratios = [(walk[2] / walk[3], walk[3]) for walk in walks.values() if walk[0] >= 0 and walk[3] > 0]
    scale = _weighted_median(ratios)
    if scale is None or scale == 0:
        # Nothing branches alike: take the whole ways to the root.
        whole = [(rest.stretch(i, ())[1], reference.stretch(j, {base})[1]) for i, j in pairs]
        scale = _weighted_median([(a / b, b) for a, b in whole if b > 0])
    if not scale:
        raise OptionError("the matched joints all rest in one place, so the skeletons' sizes can't be compared")
    size = float(np.linalg.norm(rest.positions[[joint for joint, _ in pairs]], axis=1).mean())

    stretches = []
    for joint, other in pairs:
        if joint == 0:
            continue
        start, reference_start, length, reference_length, offset = walks[joint]
        if start < 0:
            stretches.append(Stretch(joint, other, -1, -1, scale))
        elif reference_length * scale < _NOTHING * size:
            stretches.append(Stretch(joint, other, start, reference_start, 0.0, offset))
        else:
            stretches.append(Stretch(joint, other, start, reference_start, length / reference_length))

    weights = np.array([walks[joint][2] for joint, _ in pairs])
    if 0 in partner:
        # The root has no bone of its own.
        weights[0] = weights[1:].mean()
    turn = rotation.identity()
    # Stretches of no length are turned by what is sought: a few rounds settle it.
    for _ in range(8 if any(part.offset is not None for part in stretches) else 1):
        places = _rest_places(stretches, reference, base, turn)
        turn, shift = _align(
            np.array([places[joint] for joint, _ in pairs]),
            rest.positions[[joint for joint, _ in pairs]],
            weights,
            shifted=0 not in partner,
        )
    leg = min((joint for joint, _ in pairs), key=lambda joint: rest.positions[joint, 1])
    leg_length, reference_leg = rest.stretch(leg, ())[1], reference.stretch(partner[leg], {base})[1]
    root_scale = leg_length / reference_leg if 0 in partner and leg_length > 0 and reference_leg > 0 else scale
    return SkeletonFit(base, scale, root_scale, turn, shift, tuple(stretches), size)


def _rest_places(
    stretches: Sequence[Stretch], reference: RestPose, base: int, turn: FloatArray
) -> dict[int, FloatArray]:
    """Rest positions of the reference with the input's lengths, in the reference's own axes."""
    places: dict[int, FloatArray] = {0: np.zeros(3)}
    for part in stretches:
        here = reference.positions[part.reference_joint]
        if part.start < 0:
            places[part.joint] = part.ratio * (here - reference.positions[base])
        elif part.offset is None:
            places[part.joint] = places[part.start] + part.ratio * (here - reference.positions[part.reference_start])
        else:
            places[part.joint] = places[part.start] + rotation.rotate(rotation.conjugate(turn), part.offset)
    return places


def _places(rest: RestPose, reference: RestPose, pair: tuple[int, int]) -> tuple[float, ...]:
    return (*rest.positions[pair[0]].tolist(), *reference.positions[pair[1]].tolist())


def _depth(rest: RestPose, joint: int) -> int:
    depth = 0
    while joint != -1:
        joint, depth = rest.parents[joint], depth + 1
    return depth


def _weighted_median(pairs: Sequence[tuple[float, float]]) -> float | None:
    """Value at which half the weight of (value, weight) pairs is reached; None where there is no weight."""
    total = sum(weight for _, weight in pairs)
    reached = 0.0
    for value, weight in sorted(pairs):
        reached += weight
        if reached >= total / 2:
            return value
    return None


def _align(
    points: FloatArray, onto: FloatArray, weights: FloatArray, *, shifted: bool
) -> tuple[FloatArray, FloatArray]:
    """Find the rotation (and shift) that minimises the weighted sum of distances between `points` and `onto`.

    By least squares, repeated with weights over the distances that remained (Weiszfeld).
    """
    size = float(np.linalg.norm(onto, axis=1).mean())
    near = np.ones(len(points))
    for _ in range(50):
        turn, shift = _least_squares(points, onto, weights * near, shifted=shifted)
        near = 1.0 / np.maximum(np.linalg.norm(rotation.rotate(turn, points) + shift - onto, axis=1) / size, 0.01)
    return turn, shift


def _least_squares(
    points: FloatArray, onto: FloatArray, weights: FloatArray, *, shifted: bool
) -> tuple[FloatArray, FloatArray]:
    """Horn's closed form: the best rotation is the eigenvector of a symmetric matrix made of the covariances."""
    weights = weights / weights.sum()
    middle, onto_middle = (weights @ points, weights @ onto) if shifted else (np.zeros(3), np.zeros(3))
    s = ((points - middle) * weights[:, None]).T @ (onto - onto_middle)
    matrix = np.empty((4, 4))
    matrix[0, 0] = np.trace(s)
    matrix[0, 1:] = matrix[1:, 0] = s[1, 2] - s[2, 1], s[2, 0] - s[0, 2], s[0, 1] - s[1, 0]
    matrix[1:, 1:] = s + s.T - np.trace(s) * np.eye(3)
    values, vectors = np.linalg.eigh(matrix)
    # Where the two largest are equal, any turn about some axis fits as well.
    if not values[3] - values[2] > 1e-6 * np.abs(values).max():
        raise OptionError(
            "the matched joints rest in one line, so there is no telling how one skeleton is turned against the other"
        )
    turn = vectors[:, 3] * (1.0 if vectors[0, 3] >= 0 else -1.0)
    shift = onto_middle - rotation.rotate(turn, middle)
    return turn, shift


def upright_turn(fit: SkeletonFit, input_rotations: FloatArray, reference_rotations: FloatArray) -> FloatArray:
    """Find the turn that stands a reference upright whose vertical axis is not Y (many programs have Z).

    A skeleton that both rests along another axis and mostly moves along it lives in a space where that axis is up. One
    that rests so but moves upright has only odd rest axes; one that rests upright and lies down is lying down.

    Parameters
    ----------
    fit : SkeletonFit
        Of the two skeletons.
    input_rotations, reference_rotations : float array, shape (n_frames, 4)
        Of the input's root and of the reference's `base`, in global space.

    Returns
    -------
    float array, shape (4,)
        The identity where Y is up.
    """
    up = rotation.rotate(rotation.conjugate(input_rotations), _UP).mean(axis=0)
    length = float(np.linalg.norm(up))
    if length < 0.5:
        return rotation.identity()
    at_rest = rotation.rotate(rotation.conjugate(fit.rotation), up / length)
    k = int(np.argmax(np.abs(at_rest)))
    axis = np.sign(at_rest[k]) * np.eye(3)[k]
    moving = rotation.rotate(reference_rotations, at_rest).mean(axis=0)
    if moving @ axis < max(0.5, moving[1] + 0.25):
        return rotation.identity()
    half = np.concatenate([[1.0 + axis[1]], np.cross(axis, _UP)])
    return rotation.normalize(half) if axis[1] > -0.5 else np.array([0.0, 1.0, 0.0, 0.0])
