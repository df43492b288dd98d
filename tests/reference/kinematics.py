"""Forward kinematics as the textbook has it: one 4 x 4 matrix a joint, each found by asking its parent's."""

from __future__ import annotations

import numpy as np
from scipy.spatial.transform import Rotation

from retime.motion.motion import Motion


def local_matrix(motion: Motion, frame: int, joint: int) -> np.ndarray:
    """Take points of the joint's space to its parent's."""
    matrix = np.eye(4)
    matrix[:3, :3] = Rotation.from_quat(motion.rotations[frame, joint], scalar_first=True).as_matrix()
    matrix[:3, 3] = motion.local_translations[frame, joint]
    return matrix


def global_matrix(motion: Motion, frame: int, joint: int) -> np.ndarray:
    """Take points of the joint's space to global space."""
    local = local_matrix(motion, frame, joint)
    parent = motion.skeleton.parents[joint]
    return local if parent == -1 else global_matrix(motion, frame, parent) @ local


def end_position(motion: Motion, frame: int, site: int) -> np.ndarray:
    """Find the place of an end site in global space."""
    end = motion.skeleton.end_sites[site]
    return (global_matrix(motion, frame, end.parent) @ [*end.offset, 1.0])[:3]
