"""A motion as a table: where its joints are, or how they are turned, as the named channels of a signal."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Literal, get_args

import numpy as np

from retime.arrays import FloatArray
from retime.brief import kind_of
from retime.errors import OptionError
from retime.motion import rotation
from retime.motion.blending import one_side
from retime.motion.body import body_of
from retime.motion.channels import ChannelKind
from retime.motion.kinematics import global_poses, heading_positions, heading_rotations, torso_positions
from retime.motion.motion import Motion
from retime.motion.signal import Signal

JointSpace = Literal["global", "torso", "heading", "local"]
JOINT_SPACES = get_args(JointSpace)
# What a unit of so many metres is called.
_UNITS = {1.0: "m", 0.01: "cm", 0.001: "mm"}


def joint_signal(motion: Motion, *, rotations: bool = False, space: JointSpace | None = None) -> Signal:
    """Lay out what the joints of a motion do as channels: ``Hips.x``, ``Hips.y``, ``Hips.z`` ...

    Parameters
    ----------
    motion : Motion
        The motion.
    rotations : bool
        Give rotations, as quaternions ``Hips.qw``, ``Hips.qx``, ``Hips.qy``, ``Hips.qz``, whose signs agree from frame
        to frame. Else positions, in length units.
    space : {"global", "torso", "heading", "local"}, optional
        What they are seen from. ``global``: the world, Y up (for positions, if left out). ``torso``: the joint that
        carries the body (`retime.motion.body.body_joint`), which has no channels then. ``heading``: the place on the
        ground below it, turned as it is about the vertical axis. ``local``: each joint's parent (for rotations, if left
        out). In torso and heading space only the body has channels, not what hangs above it.

    Returns
    -------
    Signal
        At the motion's rate, with its frames' numbers; places in metres, centimetres or millimetres say so as the unit
        of their kind. Of joints with the same name the second is ``Hand#2``.

    Raises
    ------
    OptionError
        No motion, no such space, or nothing but a root in torso space.

    Examples
    --------
    >>> import retime
    >>> table = joint_signal(retime.sample(), space="heading")
    >>> table.names[:4], table.values.shape
    (('Hips.x', 'Hips.y', 'Hips.z', 'Spine.x'), (816, 66))
    >>> str(joint_signal(retime.sample(), rotations=True).kinds[0])
    'quaternion'
    """
    if not isinstance(motion, Motion):
        raise OptionError(f"expected joint_signal(motion) with a motion, found {kind_of(motion)}")
    if space is None:
        space = "local" if rotations else "global"
    if space not in JOINT_SPACES:
        raise OptionError(f"the space of joints is one of {', '.join(JOINT_SPACES)}; found {space!r}")
    if space in ("torso", "heading"):
        motion = body_of(motion)
    names = distinct_names(motion.skeleton.names)
    if space == "torso":
        names = names[1:]
        if not names:
            raise OptionError(
                f"{motion.name or 'the motion'} has one joint in its body, which is the origin of torso space"
            )
    values = _rotations(motion, space) if rotations else _positions(motion, space)
    axes, kind = (("qw", "qx", "qy", "qz"), "quaternion") if rotations else (("x", "y", "z"), "linear")
    unit = "" if rotations else _UNITS.get(motion.metres_per_unit or 0.0, "")
    channels = tuple(f"{name}.{axis}" for name in names for axis in axes)
    return Signal(
        channels,
        values.reshape(motion.n_frames, len(channels)),
        motion.rate,
        name=motion.name,
        first_frame=motion.first_frame,
        kinds=[ChannelKind.parse(f"{kind}:{unit}" if unit else kind)] * len(channels),
    )


def distinct_names(names: Sequence[str]) -> list[str]:
    """Tell joints of one name apart by a number.

    Examples
    --------
    >>> distinct_names(["Hand", "Hand#2", "Hand"])
    ['Hand', 'Hand#2', 'Hand#3']
    """
    taken = set(names)
    seen: set[str] = set()
    distinct = []
    for name in names:
        own, number = name, 2
        while own in seen or (own != name and own in taken):
            own, number = f"{name}#{number}", number + 1
        seen.add(own)
        distinct.append(own)
    return distinct


def _positions(motion: Motion, space: JointSpace) -> FloatArray:
    """Positions of joints, shape (n_frames, n_joints, 3); of all but the root in torso space."""
    if space == "local":
        return motion.local_translations
    poses = global_poses(motion)
    if space == "torso":
        return torso_positions(poses)
    return heading_positions(poses) if space == "heading" else poses.positions


def _rotations(motion: Motion, space: JointSpace) -> FloatArray:
    """Rotations of joints, shape (n_frames, n_joints, 4); of all but the root in torso space."""
    if space == "local":
        return _continuous(motion.rotations)
    turned = global_poses(motion).rotations
    if space == "torso":
        turned = rotation.multiply(rotation.conjugate(turned[:, :1]), turned[:, 1:])
    elif space == "heading":
        turned = rotation.multiply(rotation.conjugate(heading_rotations(global_poses(motion)))[:, None], turned)
    return _continuous(turned)


def _continuous(rotations: FloatArray) -> FloatArray:
    """Flip quaternions, shape (n_frames, n_joints, 4), so that each lies on the side of the one before."""
    return np.stack([one_side(joint) for joint in rotations.transpose(1, 0, 2)], axis=1)
