"""One clip's poses as vectors of numbers, by themselves."""

from __future__ import annotations

from retime.arrays import FloatArray
from retime.motion.any_motion import AnyMotion
from retime.motion.body import body_of
from retime.motion.kinematics import global_poses
from retime.motion.motion import Motion
from retime.motion.signal import Signal
from retime.search.poses.signals import signal_scales, signal_vectors
from retime.search.poses.spaces import (
    PoseOptions,
    PoseSpace,
    as_pose_options,
    chosen_places,
    joint_vectors,
    pose_space,
    space_joints,
)


def pose_vectors(motion: AnyMotion, options: PoseOptions | PoseSpace | None = None) -> FloatArray:
    """Describe each frame's pose by a vector of numbers.

    Parameters
    ----------
    motion : Motion or Signal
        What moves.
    options : PoseOptions or str, optional
        What counts; a text names the space alone.

    Returns
    -------
    float array, shape (n_frames, n_numbers)
        For a motion, three coordinates a joint in length units. For a signal, one number a channel, in standard
        deviations (of this signal: it is its own reference); two for an angle and ten for a rotation, none for what
        doesn't weigh (`retime.search.poses.signals`).

    Raises
    ------
    OptionError
        The space is not one for this kind of motion, or a name is not there.
    """
    options = as_pose_options(options)
    if isinstance(motion, Motion):
        motion = body_of(motion)
    space = pose_space(motion, options)
    if isinstance(motion, Signal):
        return signal_vectors(motion, options, signal_scales([motion], options))
    chosen = chosen_places(motion.skeleton.names, space_joints(motion, space), options, motion.name)
    return joint_vectors(global_poses(motion), motion.skeleton.names, chosen, space, options)
