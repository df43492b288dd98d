"""Local to global: forward kinematics, torso and heading spaces, size."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from weakref import WeakKeyDictionary, ref

import numpy as np

from retime.arrays import FloatArray
from retime.brief import brief_repr
from retime.kernels import PosedJoints, backend
from retime.motion import rotation
from retime.motion.body import body_of
from retime.motion.moving import Moving
from retime.motion.skeleton import Skeleton


@dataclass(frozen=True, eq=False)
class GlobalPoses:
    """Joints in global space.

    Attributes
    ----------
    positions : float array, shape (n_frames, n_joints, 3)
        Length units.
    rotations : float array, shape (n_frames, n_joints, 4)
        wxyz, joint space to global space.
    end_positions : float array, shape (n_frames, n_end_sites, 3)
        End sites.
    """

    positions: FloatArray
    rotations: FloatArray
    end_positions: FloatArray

    __repr__ = brief_repr


@dataclass(frozen=True, eq=False)
class GlobalPlaces:
    """Where joints are in global space.

    Attributes
    ----------
    positions : float array, shape (n_frames, n_joints, 3)
        Length units.
    end_positions : float array, shape (n_frames, n_end_sites, 3)
        End sites.
    """

    positions: FloatArray
    end_positions: FloatArray

    __repr__ = brief_repr


def global_poses(motion: Moving) -> GlobalPoses:
    """Forward kinematics of every frame; Y is up in global space, whatever it is in the motion's own coordinates.

    Returns
    -------
    GlobalPoses
        Positions and rotations of joints, positions of end sites.

    Examples
    --------
    >>> import numpy as np
    >>> from retime.motion.motion import Motion
    >>> from retime.motion.skeleton import Skeleton
    >>> arm = Skeleton(("upper", "lower"), (-1, 0), np.array([[0.0, 0, 0], [1.0, 0, 0]]))
    >>> turned = Motion(arm, rotation.from_euler("Z", np.array([[[np.pi / 2], [0.0]]])))
    >>> bool(np.allclose(global_poses(turned).positions[0, 1], [0, 1, 0]))
    True
    """
    known = _KNOWN.get(motion)
    if known is None:
        poses = _global_poses(motion.skeleton, motion.rotations, motion.local_translations, motion.up)
        for array in (poses.positions, poses.rotations, poses.end_positions):
            array.setflags(write=False)
        if _is_long(motion):
            return poses
        known = _KNOWN[motion] = poses
    return known


def global_places(motion: Moving) -> GlobalPlaces:
    """Forward kinematics for those who need no rotations; bit for bit the places of `global_poses`."""
    if not _is_long(motion):
        poses = global_poses(motion)
        return GlobalPlaces(poses.positions, poses.end_positions)
    held = _HELD.get(motion)
    known = None if held is None else held()
    if known is None:
        positions, _, end_positions = _posed(
            motion.skeleton, motion.rotations, motion.local_translations, motion.up, rotations=False
        )
        for array in (positions, end_positions):
            array.setflags(write=False)
        known = GlobalPlaces(positions, end_positions)
        _HELD[motion] = ref(known)
    return known


def forget_poses(motion: Moving) -> None:
    """Let go of what is kept of a motion's poses: whoever holds the motion for long, and asks for them seldom."""
    _KNOWN.pop(motion, None)


def _is_long(motion: Moving) -> bool:
    return motion.n_frames * motion.skeleton.n_joints > _MOST_KEPT


# Several stages of a job (features, flights, contacts, slip) ask for the poses of one motion, which does not change.
# They are kept as long as the motion is there, but for takes much longer than ten minutes of a body at 120 Hz, whose
# memory would count. Of those the places are shared by who holds them at one time.
_KNOWN: WeakKeyDictionary[Moving, GlobalPoses] = WeakKeyDictionary()
_HELD: WeakKeyDictionary[Moving, ref[GlobalPlaces]] = WeakKeyDictionary()
# Poses of a joint.
_MOST_KEPT = 2_500_000


# Frames posed at once: what they need beside themselves is small.
_FRAMES = 1 << 14
# A quarter turn about X, which brings Z to where Y is.
_Z_TO_Y = rotation.about_axis(0, -np.pi / 2)


def _global_poses(skeleton: Skeleton, rotations: FloatArray, translations: FloatArray, up: str) -> GlobalPoses:
    return GlobalPoses(*_posed(skeleton, rotations, translations, up, rotations=True))


def _posed(
    skeleton: Skeleton, local_rotations: FloatArray, local_translations: FloatArray, up: str, *, rotations: bool
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Pose all frames: positions, rotations (left out, those of the last frames alone), positions of end sites."""
    n_frames, n_joints = local_rotations.shape[:2]
    sites = skeleton.end_sites
    joints = PosedJoints(
        np.array(skeleton.parents, dtype=np.int64),
        np.array([site.parent for site in sites], dtype=np.int64),
        np.array([site.offset for site in sites], dtype=np.float64).reshape(-1, 3),
        _Z_TO_Y if up == "z" else np.zeros(0),
    )
    positions, end_positions = np.empty((n_frames, n_joints, 3)), np.empty((n_frames, len(sites), 3))
    turns = np.empty((n_frames if rotations else min(n_frames, _FRAMES), n_joints, 4))
    for start in range(0, n_frames, _FRAMES):
        frames = slice(start, min(start + _FRAMES, n_frames))
        out = turns[frames] if rotations else turns[: frames.stop - start]
        local = np.ascontiguousarray(local_rotations[frames]), np.ascontiguousarray(local_translations[frames])
        backend(warn=False).pose_joints(joints, *local, (positions[frames], out, end_positions[frames]))
    return positions, turns, end_positions


def limb_places(motion: Moving, points: Sequence[tuple[int, int | None]]) -> FloatArray:
    """Pose no more than what some points hang on: the feet, of a whole body.

    Parameters
    ----------
    motion : Motion
        What moves.
    points : sequence of (joint, end site or None)
        The points: a joint's origin, or one of the motion's end sites.

    Returns
    -------
    float array, shape (n_frames, n_points, 3)
        Their places in global space, bit for bit those of `global_poses`.
    """
    known = _KNOWN.get(motion)
    places = np.empty((motion.n_frames, len(points), 3))
    if known is not None:
        for i, (joint, site) in enumerate(points):
            places[:, i] = known.positions[:, joint] if site is None else known.end_positions[:, site]
        return places
    whole = motion.skeleton
    joints = chain_of(whole, [joint if site is None else whole.end_sites[site].parent for joint, site in points])
    skeleton = part_of(whole, joints)
    sites = [i for i, site in enumerate(whole.end_sites) if site.parent in joints]
    for start in range(0, motion.n_frames, _FRAMES):
        frames = slice(start, start + _FRAMES)
        local = motion.rotations[frames, joints], motion.local_translations[frames, joints]
        poses = _global_poses(skeleton, *local, motion.up)
        for i, (joint, site) in enumerate(points):
            if site is None:
                places[frames, i] = poses.positions[:, joints.index(joint)]
            else:
                places[frames, i] = poses.end_positions[:, sites.index(site)]
    return places


def chain_of(skeleton: Skeleton, joints: Iterable[int]) -> list[int]:
    """List these joints and all above them, increasing; the root is always among them."""
    chain = {0}
    for joint in joints:
        while joint not in chain:
            chain.add(joint)
            joint = skeleton.parents[joint]
    return sorted(chain)


def part_of(skeleton: Skeleton, joints: Sequence[int]) -> Skeleton:
    """Cut out some joints, increasing and each with its parent; their end sites go with them."""
    place = {joint: i for i, joint in enumerate(joints)}
    return Skeleton(
        tuple(skeleton.names[joint] for joint in joints),
        tuple(place.get(skeleton.parents[joint], -1) for joint in joints),
        skeleton.offsets[list(joints)],
        tuple(replace(site, parent=place[site.parent]) for site in skeleton.end_sites if site.parent in place),
    )


def torso_positions(poses: GlobalPoses) -> FloatArray:
    """Positions of all joints but the root in the root's own space (the paper's §3.2).

    Returns
    -------
    float array, shape (n_frames, n_joints - 1, 3)
        The root's position and orientation are removed.
    """
    return rotation.rotate(rotation.conjugate(poses.rotations[:, :1]), poses.positions[:, 1:] - poses.positions[:, :1])


def heading_rotations(poses: GlobalPoses) -> FloatArray:
    """Turn of the root about the vertical axis, shape (n_frames, 4): the root's rotation with its tilt removed.

    The twist about Y is what is left of a rotation (w, x, y, z) when x and z are dropped; a root on its head (w and y
    both 0) has none and keeps the identity.
    """
    root = poses.rotations[:, 0]
    twist = np.zeros_like(root)
    twist[:, 0], twist[:, 2] = root[:, 0], root[:, 2]
    length = np.sqrt(np.sum(twist * twist, axis=-1, keepdims=True))
    return np.where(length > 1e-9, twist / np.where(length > 1e-9, length, 1.0), rotation.identity(1))


def heading_positions(poses: GlobalPoses) -> FloatArray:
    """Positions of all joints in the heading space: ground position and turn removed, height and tilt kept.

    Returns
    -------
    float array, shape (n_frames, n_joints, 3)
    """
    ground = poses.positions[:, :1] * np.array([1.0, 0.0, 1.0])
    turn = rotation.conjugate(heading_rotations(poses))[:, None]
    return rotation.rotate(turn, poses.positions - ground)


# How high a figure must be, as a share of its longest extent: a person who stands has 1, one who lies a fifth, a dog
# on its feet two thirds.
_LEAST_RISE = 0.5


def rises_along_y(motion: Moving) -> bool:
    """Tell whether Y can be up: whether the figure is not flat along it, in most of the clip.

    What stands along another axis (a Z-up file), or lies down all the time, is flat; a single joint is not.

    Examples
    --------
    >>> import retime
    >>> rises_along_y(retime.sample())
    True
    """
    return _rises_along(motion, 1)


def seems_z_up(motion: Moving) -> bool:
    """Tell whether the figure stands along Z and is flat along Y, so that its file may have Z up and not say so.

    A figure that lies along Z all the time looks the same: this is for a hint, not for a decision.
    """
    return motion.up == "y" and not _rises_along(motion, 1) and _rises_along(motion, 2)


def _rises_along(motion: Moving, axis: int) -> bool:
    motion = body_of(motion)
    every = max(1, motion.n_frames // 64)
    some = _global_poses(motion.skeleton, motion.rotations[::every], motion.local_translations[::every], motion.up)
    extents = np.ptp(some.positions, axis=1)
    return bool(np.median(extents[:, axis] - _LEAST_RISE * extents.max(axis=1)) >= 0)


GRAVITY = 9.81
"""Metres per second squared."""

# Metres.
_LARGEST_UNIT = 1e30


def metres_per_unit(motion: Moving) -> float:
    """Length of one unit in metres: the file's own statement, else a guess.

    The guess takes the rest skeleton, from the joint on that carries the body, for a person of 1.7 m. It serves for
    thresholds, not for measurements. A unit of more than 1e30 m is taken for one of that: no figure has such, and the
    places of a motion, which may be numbers up to 1e100, would overflow in metres.
    """
    if motion.metres_per_unit is not None:
        return min(motion.metres_per_unit, _LARGEST_UNIT)
    motion = body_of(motion)
    rest = np.zeros((motion.skeleton.n_joints, 3))
    for joint, parent in enumerate(motion.skeleton.parents):
        if parent >= 0:
            rest[joint] = rest[parent] + motion.skeleton.offsets[joint]
    ends = [rest[site.parent] + np.array(site.offset) for site in motion.skeleton.end_sites]
    # A rest pose may lie along any axis; its longest extent is the height, or the span of the arms, about as long.
    extent = float(np.ptp(np.vstack([rest, *ends]), axis=0).max())
    return 1.7 / max(extent, 1.7 / _LARGEST_UNIT) if extent > 0 else 1.0
