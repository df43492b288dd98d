"""A skeleton as a stick figure seen from its side: which lines to draw, and where on the paper."""

from __future__ import annotations

import re
from dataclasses import dataclass

import numpy as np

from retime.arrays import FloatArray
from retime.brief import brief_repr
from retime.motion.body import body_of
from retime.motion.kinematics import GlobalPoses, global_poses, heading_rotations
from retime.motion.motion import Motion
from retime.motion.rotation import rotate
from retime.motion.skeleton import Skeleton

# The camera stands this far in front of the figure's right side, so that near limbs don't hide the far ones.
VIEW_ANGLE = np.radians(25.0)
# Seconds over which the camera follows the figure's turns: it ignores the sway of steps and keeps up with a curve.
FOLLOW_SECONDS = 1.0
# Of the figure's height.
HEAD_RADIUS = 0.067
_FINGERS = ("thumb", "finger", "index", "middle", "ring", "pinky", "pinkie", "little")


@dataclass(frozen=True)
class Chain:
    """A line to draw through some nodes of a skeleton.

    Attributes
    ----------
    side : {"left", "right", ""}
        Of the limb; "" is the trunk.
    nodes : tuple of int
        Joints, and end sites counted on after the joints.
    """

    side: str
    nodes: tuple[int, ...]


@dataclass(frozen=True, eq=False)
class FigureView:
    """Where the poses of one motion appear on paper.

    Attributes
    ----------
    chains : tuple of Chain
        The lines, far side first.
    head : int
        The joint where the head's disc stands, -1 for none.
    stature : float
        Height of the figure when it stands up, in length units.
    ground : float
        Height of the ground, in length units.
    across : float array, shape (n_frames, 2)
        The paper's horizontal axis in the ground plane (x, z) at each input frame, unit length.
    """

    chains: tuple[Chain, ...]
    head: int
    stature: float
    ground: float
    across: FloatArray

    __repr__ = brief_repr

    def project(self, motion: Motion, input_times: FloatArray) -> FloatArray:
        """Sample a motion and lay its poses on paper.

        Returns
        -------
        float array, shape (n_times, n_joints + n_end_sites, 2)
            Joints and end sites from the one on that carries the body: to the right of it, and above the ground, in
            statures.
        """
        poses = global_poses(body_of(motion).at(input_times))
        nodes = _nodes(poses)
        frame = np.clip(np.round(input_times * float(motion.rate)).astype(np.intp), 0, len(self.across) - 1)
        offset = nodes - poses.positions[:, :1]
        right = np.einsum("fnc,fc->fn", offset[:, :, [0, 2]], self.across[frame])
        return np.stack([right, nodes[:, :, 1] - self.ground], axis=-1) / self.stature


def view_of(motion: Motion) -> FigureView:
    """Choose the view of a motion: from the figure's right, so that it moves along with the time axis."""
    motion = body_of(motion)
    skeleton = motion.skeleton
    poses = global_poses(motion)
    sides = sides_of(skeleton)
    heights = _nodes(poses)[:, :, 1]
    # Quantiles: a raised arm, a jump and a frame of noise are no part of the stature, nor of the ground.
    stature = float(np.quantile(np.ptp(heights, axis=1), 0.9))
    ground = float(np.quantile(heights.min(axis=1), 0.1))
    left = _smooth(_leftward(poses, skeleton), round(FOLLOW_SECONDS * float(motion.rate)))
    # In the ground plane (x, z), forward is a quarter turn from left.
    forward = np.stack([-left[:, 1], left[:, 0]], axis=1)
    across = np.cos(VIEW_ANGLE) * forward + np.sin(VIEW_ANGLE) * left
    head = next((i for i, name in enumerate(skeleton.names) if "head" in name.lower() and not sides[i]), -1)
    chains = _chains(skeleton, sides, head)
    if not chains:
        # A lone joint is shown as a disc.
        head = 0
    return FigureView(chains, head, stature if stature > 0 else 1.0, ground, across)


def sides_of(skeleton: Skeleton) -> tuple[str, ...]:
    """Tell left joints from right ones by their names: "left", "right" or "" for each joint.

    A name is on the left only where its mirror image is a joint too ("lfemur" and "rfemur"), so that "lowerback" stays
    in the middle. A joint that has no mirror image takes its parent's side.
    """
    mirrors = _mirrors(skeleton.names)
    sides: list[str] = []
    for joint, parent in enumerate(skeleton.parents):
        if joint in mirrors:
            sides.append("left")
        elif joint in mirrors.values():
            sides.append("right")
        else:
            sides.append(sides[parent] if parent >= 0 else "")
    return tuple(sides)


def _mirrors(names: tuple[str, ...]) -> dict[int, int]:
    """Left joint -> right joint."""
    place = {name.lower(): joint for joint, name in reversed(list(enumerate(names)))}
    pairs = {}
    for joint, name in enumerate(names):
        low = name.lower()
        candidates = [low.replace("left", "right")]
        # A lone l: at the start, at the end, or between marks ("lfemur", "hand.l", "hand_l", "bip01 l thigh").
        candidates += [
            low[: m.start()] + "r" + low[m.end() :] for m in re.finditer(r"(?<![^\W_])l(?![^\W_])|^l|l$", low)
        ]
        # ... or after a name space ("mixamorig:lfoot").
        candidates += [re.sub(r"([:|])l", r"\1r", low)]
        for mirror in candidates:
            if mirror != low and mirror in place:
                pairs[joint] = place[mirror]
                break
    return pairs


def _nodes(poses: GlobalPoses) -> FloatArray:
    return np.concatenate([poses.positions, poses.end_positions], axis=1)


def _leftward(poses: GlobalPoses, skeleton: Skeleton) -> FloatArray:
    """Horizontal direction (x, z) to the figure's left, not scaled: long where it is sure."""
    best, found = np.inf, None
    for left, right in _mirrors(skeleton.names).items():
        across = poses.positions[:, left] - poses.positions[:, right]
        width = np.linalg.norm(across, axis=1)
        # Hips and shoulders keep their width; hands and feet don't.
        if width.mean() > 1e-9 and (steadiness := float(width.std() / width.mean())) < best - 1e-6:
            best, found = steadiness, across
    if found is None:
        # Nothing to tell left from right: take +Z of the root for forward, as most files do.
        found = rotate(heading_rotations(poses), np.array([1.0, 0.0, 0.0]))
    return np.ascontiguousarray(found[:, [0, 2]])


def _smooth(directions: FloatArray, window: int) -> FloatArray:
    """Mean over a moving window that is cut off at the ends, scaled to unit length."""
    n = len(directions)
    total = np.vstack([np.zeros((1, 2)), np.cumsum(directions, axis=0)])
    frames = np.arange(n)
    half = window // 2
    mean = total[np.minimum(frames + half + 1, n)] - total[np.maximum(frames - half, 0)]
    length = np.linalg.norm(mean, axis=1)
    sure = length > 1e-9
    if not sure.any():
        return np.tile([1.0, 0.0], (n, 1))
    # Where the mean vanishes (shoulders upright in a cartwheel) keep the last direction that was known.
    last = np.maximum.accumulate(np.where(sure, frames, int(np.argmax(sure))))
    return np.asarray(mean[last] / length[last, None])


def _chains(skeleton: Skeleton, sides: tuple[str, ...], head: int) -> tuple[Chain, ...]:
    """Walk down the tree; a chain goes on while the side stays the same."""
    hidden = {joint for joint, name in enumerate(skeleton.names) if _is_finger(name)}
    below: list[list[int]] = [[] for _ in range(skeleton.n_joints)]
    for joint, parent in enumerate(skeleton.parents):
        if parent in hidden or parent == head >= 0:
            hidden.add(joint)
        if parent >= 0 and joint not in hidden:
            below[parent].append(joint)
    for i, site in enumerate(skeleton.end_sites):
        if site.parent not in hidden and site.parent != head:
            below[site.parent].append(skeleton.n_joints + i)
    side = [*sides, *(sides[site.parent] for site in skeleton.end_sites)]

    chains: list[Chain] = []
    # Each item: the node that a chain starts from (or -1) and its first own node.
    todo = [(-1, 0)]
    while todo:
        start, node = todo.pop()
        nodes = [node] if start < 0 else [start, node]
        own = side[node]
        while node < skeleton.n_joints and below[node]:
            follow, *others = sorted(below[node], key=lambda child: side[child] != own)
            if side[follow] != own:
                others = [follow, *others]
                todo.extend((node, child) for child in others)
                break
            todo.extend((node, child) for child in others)
            nodes.append(follow)
            node = follow
        if len(nodes) > 1:
            chains.append(Chain(own, tuple(nodes)))
    # Seen from its right: the left limbs are behind.
    return tuple(sorted(chains, key=lambda chain: ("left", "", "right").index(chain.side)))


def _is_finger(name: str) -> bool:
    low = name.lower()
    return any(word in low for word in _FINGERS)
