"""The joint that carries the body, which need not be a skeleton's root, and a motion from there on."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any, TypeVar, cast
from weakref import WeakKeyDictionary

import numpy as np

from retime.arrays import FloatArray
from retime.errors import OptionError
from retime.motion import rotation
from retime.motion.joint_names import near_names
from retime.motion.moving import Moving
from retime.motion.skeleton import Skeleton

# What moves by less than this share of the skeleton's size, or turns by less than so many radians, stays put: files
# round their numbers.
_STILL = 1e-4

AnyMoving = TypeVar("AnyMoving", bound=Moving)


def body_joint(motion: Moving) -> int:
    """Find the joint that carries the body: the hips of a figure, whatever a file puts above them.

    Where the motion names it (`Motion.root`), that one. Else it is looked for from the root down:

    * below a joint that stays put, with one child: that child;
    * below a joint that keeps its tilt (it stays put, slides over the ground, as the path that game engines write, or
      follows the height of the body, or both; and turns about the vertical at most): the child that moves in it and
      holds more than half of the joints below it, or all of them;
    * below a joint that moves and never turns, with one child: that child, where it turns and parts into limbs.

    A joint that only turns does not move in its parent: so hips that stay put keep their legs. Where joints are told
    by places alone, and never turn, limbs move in the hips, but keep their distance. Names don't count, and neither
    does the order of the joints. A path that has the height of the body, and its turns too, is not told from hips: name
    the joint there.

    Raises
    ------
    OptionError
        The motion names a joint that it has not.

    Examples
    --------
    >>> from retime.motion.motion import Motion
    >>> path = np.array([[[0.0, 0, 0], [x, 1, 0], [0, 1, 0]] for x in range(3)])
    >>> rig = Skeleton(("Armature", "Hips", "Spine"), (-1, 0, 1), path[0])
    >>> body_joint(Motion(rig, rotation.identity(3, 3), path))
    1
    """
    names = motion.skeleton.names
    if motion.root is not None:
        if motion.root not in names:
            where = motion.name or "the motion"
            raise OptionError(
                f"no joint of {where} is called {motion.root!r}{near_names(motion.root, names)}", option="root"
            )
        return names.index(motion.root)
    known = _JOINTS.get(motion)
    if known is None:
        known = _JOINTS[motion] = _find(motion)
    return known


def body_of(motion: AnyMoving) -> AnyMoving:
    """Return the motion of the joint that carries the body and of all below it; the same motion where that is the root.

    Nodes above the body are folded into its first joint, so nothing that hangs elsewhere (props, targets of inverse
    kinematics) and no origin of a scene is part of the figure. Global places and turns stay what they are, to the last
    bit where the nodes above are at the origin and don't turn.
    """
    joint = body_joint(motion)
    if joint == 0:
        return motion
    known = _BODIES.get(motion)
    if known is None or known[0] != joint:
        known = _BODIES[motion] = joint, _cut(motion, joint)
    return cast(AnyMoving, known[1])


def body_name(motion: Moving) -> str | None:
    """Return what names the body's joint in any stretch of a motion, however still; None where it is the root."""
    joint, names = body_joint(motion), motion.skeleton.names
    return None if joint == 0 or names.index(names[joint]) != joint else names[joint]


def body_joints(motion: Moving) -> list[int]:
    """List the joints of `body_of` by their places in the whole skeleton, increasing: the body's first."""
    return _below(motion.skeleton.parents, body_joint(motion))


def above_body(motion: Moving) -> list[int]:
    """List the joints that carry all of the body, increasing: from the root to the one that `body_joint` finds."""
    found, parents = [body_joint(motion)], motion.skeleton.parents
    while parents[found[-1]] >= 0:
        found.append(parents[found[-1]])
    return found[::-1]


def is_rigid(motion: Moving) -> bool:
    """Tell whether nothing moves in the body: a camera, a prop, or a figure that is only carried along."""
    known = _RIGID.get(motion)
    if known is None:
        body = body_of(motion)
        still = _STILL * max(_extent(body.skeleton), 1e-12)
        known = _RIGID[motion] = not any(
            _moves(body.local_translations[:, joint], still) or _largest_turn(body.rotations[:, joint]) > _STILL
            for joint in range(1, body.skeleton.n_joints)
        )
    return known


# Kept as long as the motion is, which does not change.
_JOINTS: WeakKeyDictionary[Moving, int] = WeakKeyDictionary()
_BODIES: WeakKeyDictionary[Moving, tuple[int, Moving]] = WeakKeyDictionary()
_RIGID: WeakKeyDictionary[Moving, bool] = WeakKeyDictionary()


def _find(motion: Moving) -> int:
    parents = motion.skeleton.parents
    sizes = np.ones(len(parents), dtype=np.intp)
    children: list[list[int]] = [[] for _ in parents]
    for joint in range(len(parents) - 1, 0, -1):
        sizes[parents[joint]] += sizes[joint]
        children[parents[joint]].insert(0, joint)
    size = max(_extent(motion.skeleton), 1e-12)
    still = _STILL * size
    places = motion.local_translations
    joint = 0
    while children[joint]:
        child, *beside = sorted(children[joint], key=lambda one: -int(sizes[one]))
        if not beside and _stays_put(motion, joint, still):
            joint = child
            continue
        if not _keeps_its_tilt(motion, joint):
            break
        if _moves(places[:, child], still):
            # What never turns may be a limb of a body that is told by places alone; but such a one keeps its distance,
            # as well as it can be measured.
            limb = _largest_turn(motion.rotations[:, child]) <= _STILL
            if limb and _changes_by(places[:, child]) <= size:
                break
            # The child must hold more than half of what is below.
            if 2 * sizes[child] <= sizes[joint] - 1:
                break
        else:
            # It turns about a point that it carries: a joint of a body does, and so do hips, which have limbs.
            turns = _largest_turn(motion.rotations[:, joint]) > _STILL
            if beside or turns or len(children[child]) < 2 or _stays_put(motion, child, still):
                break
        joint = child
    # Where nothing moves at all, the root is as good as any.
    return joint if any(not _stays_put(motion, one, still) for one in _below(parents, joint)) else 0


def _extent(skeleton: Skeleton) -> float:
    """Length of the longest bone but the root's: a size that no place in a scene changes."""
    ends = [np.linalg.norm(site.offset) for site in skeleton.end_sites]
    return float(max([*np.linalg.norm(skeleton.offsets[1:], axis=1), *ends], default=0.0))


def _moves(places: FloatArray, still: float) -> bool:
    return bool(np.any(np.ptp(places, axis=0) > still))


def _stays_put(motion: Moving, joint: int, still: float) -> bool:
    q = motion.rotations[:, joint]
    return not _moves(motion.local_translations[:, joint], still) and _largest_turn(q) <= _STILL


def _largest_turn(q: FloatArray) -> float:
    """Largest angle from the first frame's rotation, radians; from sines, which small angles need."""
    away = rotation.multiply(rotation.conjugate(q[:1]), q)
    return float(2 * np.arcsin(min(1.0, float(np.linalg.norm(away[:, 1:], axis=1).max()))))


def _changes_by(places: FloatArray) -> float:
    """By how much a joint's distance from its parent changes."""
    return float(np.ptp(np.linalg.norm(places, axis=1)))


def _keeps_its_tilt(motion: Moving, joint: int) -> bool:
    """Tell whether a joint turns about one axis of its space alone, Y or Z: whichever is vertical."""
    back = rotation.conjugate(motion.rotations[:, joint])
    # Where the axis lies in the joint: the same in all frames, unless that tilts.
    return any(not _moves(rotation.rotate(back, axis), _STILL) for axis in np.eye(3)[1:])


def _below(parents: Sequence[int], joint: int) -> list[int]:
    found = {joint}
    for other in range(joint + 1, len(parents)):
        if parents[other] in found:
            found.add(other)
    return sorted(found)


def _cut(motion: Moving, joint: int) -> Moving:
    skeleton = motion.skeleton
    kept = _below(skeleton.parents, joint)
    place = {old: new for new, old in enumerate(kept)}
    q, p = motion.rotations[:, joint], motion.local_translations[:, joint]
    parent = skeleton.parents[joint]
    while parent >= 0:
        turn = motion.rotations[:, parent]
        p = rotation.rotate(turn, p) + motion.local_translations[:, parent]
        q = rotation.multiply(turn, q)
        parent = skeleton.parents[parent]
    rotations, translations = motion.rotations[:, kept], motion.local_translations[:, kept]
    rotations[:, 0], translations[:, 0] = q, p
    cut = Skeleton(
        tuple(skeleton.names[old] for old in kept),
        tuple(place.get(skeleton.parents[old], -1) for old in kept),
        skeleton.offsets[kept],
        tuple(replace(site, parent=place[site.parent]) for site in skeleton.end_sites if site.parent in place),
    )
    # A motion is a dataclass, of which this module knows no more than the protocol.
    return cast(
        Moving,
        replace(
            cast(Any, motion),
            skeleton=cut,
            rotations=rotations,
            translations=translations,
            declaration=None,
            declared_angles=None,
            root=cut.names[0],
        ),
    )
