"""The pose of what moves as one: where it is, and which way it is turned."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from retime.motion.channels import ChannelKind
from retime.motion.kinematics import global_poses
from retime.motion.motion import Motion
from retime.motion.signal import Signal
from retime.search.poses.signals import signal_scales
from retime.search.poses.spaces import PoseOptions

_PLACE, _TURN = ("x", "y", "z"), ("qw", "qx", "qy", "qz")
# What is divided by is no less than this, in radians: so that a turn that a file only rounds does not weigh.
_LEAST_TURN = 1e-3


def path_signal(motion: Motion) -> Signal:
    """Return place and turn of a motion's body in global space, as a signal.

    A camera, or a prop, has no pose of its own: in a space that moves and turns with it nothing ever changes.
    """
    poses = global_poses(motion)
    return Signal(
        (*_PLACE, *_TURN),
        np.concatenate([poses.positions[:, 0], poses.rotations[:, 0]], axis=1),
        motion.rate,
        name=motion.name,
        kinds=(ChannelKind(),) * 3 + (ChannelKind("quaternion"),) * 4,
    )


def path_options(references: Sequence[Signal]) -> PoseOptions:
    """Weigh place against turn: each by how far it spreads over the references, places alike along all axes."""
    spread = signal_scales(references, PoseOptions())
    places = np.concatenate([reference.values[:, :3] for reference in references])
    away = float(np.sqrt(places.var(axis=0).sum()))
    # As for a constant channel, what does not spread is left as it is.
    place = away if away > 1e-9 * max(float(np.abs(places).max()), 1e-300) else 1.0
    turn = max(float(spread[3]), _LEAST_TURN)
    return replace(PoseOptions(), scales=dict.fromkeys(_PLACE, place) | dict.fromkeys(_TURN, turn))
