"""A glTF animation as a motion, for the search: its nodes as joints, sampled at a rate."""

from __future__ import annotations

import warnings
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

import numpy as np

from retime.arrays import FloatArray
from retime.brief import brief_repr
from retime.errors import FormatWarning
from retime.formats.curves.gltf.animation import Animation
from retime.formats.curves.gltf.file import GltfFile
from retime.formats.curves.key_grid import grid_rate
from retime.formats.made_frames import Sampling
from retime.formats.read_options import Limits
from retime.motion import rotation
from retime.motion.motion import Motion
from retime.motion.signal import Signal
from retime.motion.skeleton import Skeleton


@dataclass(frozen=True)
class Node:
    """A node at rest."""

    name: str
    parent: int
    translation: FloatArray
    rotation: FloatArray
    scale: FloatArray

    __repr__ = brief_repr


def read_nodes(file: GltfFile, limits: Limits) -> list[Node]:
    """Read the nodes; raise FormatError where they are no forest."""
    items = file.items("nodes")
    parents = [-1] * len(items)
    for index, item in enumerate(items):
        children = item.get("children", [])
        if not isinstance(children, list):
            raise file.error(f"nodes[{index}].children must be a list")
        for child in children:
            file.item("nodes", child)
            if parents[child] != -1:
                raise file.error(f"node {child} is a child of node {parents[child]} and of node {index}")
            parents[child] = index
    depth = [0] * len(items)
    for index in range(len(items)):
        up, steps = index, 0
        while parents[up] != -1 and not depth[up]:
            up, steps = parents[up], steps + 1
            if steps > len(items):
                raise file.error(f"node {index} is its own ancestor")
        depth[index] = depth[up] + steps
        if depth[index] > limits.depth:
            raise file.error(f"its nodes are nested more than {limits.depth} deep (Limits.depth)")
    return [_node(file, item, index, parents[index]) for index, item in enumerate(items)]


def _node(file: GltfFile, item: dict[str, Any], index: int, parent: int) -> Node:
    name = item.get("name")
    name = name if isinstance(name, str) and name else f"node_{index}"
    if "matrix" in item:
        matrix = _numbers(file, item, "matrix", [0.0] * 16, index).reshape(4, 4).T
        scale = np.linalg.norm(matrix[:3, :3], axis=0)
        axes = matrix[:3, :3] / np.where(scale > 0, scale, 1.0)
        if np.linalg.det(axes) < 0:
            # A mirror: which axis is turned over does not matter, for the product is the same.
            scale[0], axes[:, 0] = -scale[0], -axes[:, 0]
        turned = rotation.from_matrix(axes) if np.linalg.det(axes) > 0.1 else rotation.identity()
        return Node(name, parent, matrix[:3, 3], turned, scale)
    xyzw = _numbers(file, item, "rotation", [0.0, 0.0, 0.0, 1.0], index)
    if not np.linalg.norm(xyzw) > 1e-6:
        raise file.error(f"the rotation of node {index} has length 0")
    return Node(
        name,
        parent,
        _numbers(file, item, "translation", [0.0] * 3, index),
        rotation.normalize(np.roll(xyzw, 1)),
        _numbers(file, item, "scale", [1.0] * 3, index),
    )


def _numbers(file: GltfFile, item: dict[str, Any], name: str, missing: list[float], index: int) -> FloatArray:
    value = item.get(name, missing)
    right = isinstance(value, list) and len(value) == len(missing)
    if not right or not all(isinstance(one, int | float) and not isinstance(one, bool) for one in value):
        raise file.error(f"nodes[{index}].{name} must be {len(missing)} numbers")
    try:
        numbers = np.array(value, dtype=np.float64)
    except OverflowError:
        numbers = np.array([np.inf])
    if not np.isfinite(numbers).all():
        raise file.error(f"nodes[{index}].{name} holds a number that is not finite")
    return numbers


@dataclass(frozen=True)
class Sampled:
    """An animation at a rate.

    Attributes
    ----------
    clip : Motion or Signal
        A motion where nodes move; else a signal of what does (weights of morph targets).
    nodes : tuple of int
        The node of each joint; -1 for a root that stands for the scene. Empty for a signal.
    scales : float array, shape (n_joints,)
        How many units of the scene one unit of each joint's parent is, at rest: translations are given in the scene's.
    """

    clip: Motion | Signal
    nodes: tuple[int, ...]
    scales: FloatArray

    __repr__ = brief_repr


def rate_of_keys(animation: Animation) -> Fraction:
    """Return the rate on whose frames an animation's keys lie."""
    return grid_rate(_key_times(animation), animation.start)


def _key_times(animation: Animation) -> list[FloatArray]:
    return [np.append(one.curve.times[:, 0], one.curve.end_time) for one in animation.samplers]


def sample_animation(file: GltfFile, animation: Animation, rate: Fraction | None, limits: Limits) -> Sampled:
    """Sample an animation from its first key to its last, at a rate or at that of its keys.

    Scale is taken as it is at rest, and as one number for all three axes: the search looks at how joints move, and what
    is written comes from the curves themselves.

    Raises
    ------
    FormatError
        The nodes are no forest, or there are more, or more frames, than may be.

    Warns
    -----
    FormatWarning
        Most of the frames lie where no key does.
    """
    start = animation.start
    rate = rate or rate_of_keys(animation)
    n_frames = int(np.ceil(float(rate) * (animation.end - start) - 1e-3)) + 1
    moved = _moved(animation)
    nodes = read_nodes(file, limits)
    if n_frames > limits.frames or n_frames * max(1, len(moved)) > limits.joint_poses:
        raise file.error(
            f"{animation.name!r} lasts {animation.end - start:g} s, which is {n_frames} frames at {float(rate):g} Hz: "
            "give a lower rate (--fps)"
        )
    joints = _with_ancestors(nodes, moved) if moved else []
    if len(joints) > limits.joints:
        raise file.error(f"{len(joints)} nodes move or carry others, the limit is {limits.joints} (Limits.joints)")
    curves = [animation.samplers[one.sampler].curve for one in animation.channels]
    sampling = Sampling(
        start,
        animation.end,
        float(rate),
        n_frames,
        7 * len(joints) or sum(len(one.end_value) for one in curves),
        sum((len(one) + 1) * len(one.end_value) for one in curves),
        np.concatenate(_key_times(animation)),
    )
    if problem := sampling.problem():
        raise file.error(f"{animation.name!r} {problem}")
    if doubt := sampling.doubt():
        warnings.warn(f"{file.path}: {animation.name!r} {doubt}", FormatWarning, stacklevel=3)
    times = start + np.arange(n_frames) / float(rate)
    if not moved:
        return Sampled(_signal(file, animation, times, rate), (), np.zeros(0))
    place = {node: joint for joint, node in enumerate(joints)}
    parents = [-1 if node < 0 else place.get(nodes[node].parent, 0 if joints[0] < 0 else -1) for node in joints]
    rest = [
        nodes[node] if node >= 0 else Node("scene", -1, np.zeros(3), rotation.identity(), np.ones(3)) for node in joints
    ]
    rotations = np.repeat(np.stack([one.rotation for one in rest])[None], n_frames, axis=0)
    translations = np.repeat(np.stack([one.translation for one in rest])[None], n_frames, axis=0)
    for channel in animation.channels:
        if channel.node is None or channel.path not in ("translation", "rotation"):
            continue
        shown = animation.samplers[channel.sampler].curve(times)
        if channel.path == "translation":
            translations[:, place[channel.node]] = shown
        else:
            rotations[:, place[channel.node]] = np.roll(shown, 1, axis=1)
    scales = np.ones(len(joints))
    for joint, parent in enumerate(parents):
        if parent >= 0:
            scales[joint] = scales[parent] * np.cbrt(np.abs(np.prod(rest[parent].scale)))
    offsets = np.stack([one.translation for one in rest]) * scales[:, None]
    skeleton = Skeleton([one.name for one in rest], parents, offsets)
    motion = Motion(
        skeleton,
        rotations,
        translations * scales[:, None],
        rate,
        name=animation.name,
    )
    return Sampled(motion, tuple(joints), scales)


def _moved(animation: Animation) -> list[int]:
    return sorted({one.node for one in animation.channels if one.node is not None and one.path != "weights"})


def joint_nodes(nodes: list[Node], animation: Animation) -> list[int]:
    """Name the node of each joint of an animation read as a motion; -1 for a root that stands for the scene."""
    moved = _moved(animation)
    return _with_ancestors(nodes, moved) if moved else []


def _with_ancestors(nodes: list[Node], moved: list[int]) -> list[int]:
    """Order the nodes that move and those above them, parents first; -1 in front where they have no common root."""
    wanted = set(moved)
    for node in moved:
        while nodes[node].parent >= 0 and nodes[node].parent not in wanted:
            node = nodes[node].parent
            wanted.add(node)
    roots = [node for node in sorted(wanted) if nodes[node].parent < 0]
    children: dict[int, list[int]] = {}
    for node in sorted(wanted):
        children.setdefault(nodes[node].parent, []).append(node)
    ordered = [-1] if len(roots) > 1 else []
    waiting = roots[::-1]
    while waiting:
        node = waiting.pop()
        ordered.append(node)
        waiting += children.get(node, [])[::-1]
    return ordered


def _signal(file: GltfFile, animation: Animation, times: FloatArray, rate: Fraction) -> Signal:
    if not animation.channels:
        raise file.error(f"{animation.name!r} moves nothing: it has no channels")
    names: list[str] = []
    columns = []
    for channel in animation.channels:
        curve = animation.samplers[channel.sampler].curve
        of = "" if channel.node is None else str(file.item("nodes", channel.node).get("name") or f"node_{channel.node}")
        for part in range(len(curve.end_value)):
            name = f"{of}.{channel.path}.{part}".removeprefix(".")
            names.append(name if name not in names else f"{name} ({len(names)})")
        columns.append(curve(times))
    return Signal(tuple(names), np.concatenate(columns, axis=1), rate, name=animation.name)
