"""An FBX animation as a motion, for the search: its nodes as joints, sampled at a rate."""

from __future__ import annotations

import warnings
from dataclasses import dataclass
from fractions import Fraction

import numpy as np

from retime.arrays import FloatArray
from retime.brief import brief_repr
from retime.errors import FormatWarning
from retime.formats.curves.fbx.scene import FbxScene, Item, Layer
from retime.formats.curves.fbx.span import StackCurves
from retime.formats.curves.fbx.values import (
    ORDERS,
    ROTATION,
    SCALING,
    StackValues,
    parts_of,
    quaternions,
    rotation_order,
    stack_values,
)
from retime.formats.made_frames import Sampling
from retime.formats.read_options import Limits
from retime.motion import rotation
from retime.motion.motion import Motion, Up
from retime.motion.rate import parse_rate
from retime.motion.signal import Signal
from retime.motion.skeleton import Skeleton

TRANSLATION = "Lcl Translation"
_MOVES = {TRANSLATION, ROTATION, SCALING, "PreRotation", "PostRotation", "RotationPivot", "ScalingPivot"}
_MOVES |= {"RotationOffset", "ScalingOffset"}
_LIMBS = {"LimbNode", "Limb", "Root"}
# Frames a second by the number that a scene has for them; 14 is one of its own.
_RATES = {1: "120", 2: "100", 3: "60", 4: "50", 5: "48", 6: "30", 7: "30", 8: "30000/1001", 9: "30000/1001", 10: "25"}
_RATES |= {11: "24", 13: "24000/1001", 15: "96", 16: "72", 17: "60000/1001", 18: "120000/1001"}
_CUSTOM = 14
_COMMON = (24, 25, 30, 48, 50, 60, 90, 100, 120, 240)
_NO_RATE = Fraction(30)
# A rate that many times the scene's is finer, not the same one written otherwise.
_FINER = Fraction(3, 2)
_IGNORE_PARENT_SCALE = 2


@dataclass(frozen=True)
class Sampled:
    """An animation at a rate.

    Attributes
    ----------
    clip : Motion or Signal
        A motion where nodes move; else a signal of what does (shapes, cameras).
    nodes : tuple of (Item or None)
        The node of each joint; None for a root that stands for the scene. Empty for a signal.
    scales : float array, shape (n_joints,)
        How many units of the scene one unit of each joint's parent is, at rest: translations are given in the scene's.
    values : StackValues
    """

    clip: Motion | Signal
    nodes: tuple[Item | None, ...]
    scales: FloatArray
    values: StackValues

    __repr__ = brief_repr


def _said_rate(scene: FbxScene) -> Fraction | None:
    """Return the frame rate that a scene says."""
    mode = int(scene.setting("TimeMode", 0))
    if mode in _RATES:
        return Fraction(_RATES[mode])
    if mode == _CUSTOM and 0.001 <= scene.setting("CustomFrameRate", -1) <= 1e5:
        return parse_rate(scene.setting("CustomFrameRate", -1))
    return None


def time_mode(scene: FbxScene) -> str:
    """Say how a scene's time is counted: its number for that, and the frame rate."""
    said = _said_rate(scene)
    rate = "no frame rate of its own" if said is None else f"{float(said):.6g} Hz"
    return f"{int(scene.setting('TimeMode', 0))}: {rate}"


def frame_rate(scene: FbxScene, curves: StackCurves) -> Fraction:
    """Find the scene's frame rate, or a finer usual one where keys lie between its frames."""
    said = _said_rate(scene)
    if said is not None and said < 1 and (curves.end - curves.start) * said < 1:
        # All of the scene would be one frame.
        said = None
    keys = np.unique(curves.keys.ticks) / scene.ticks - curves.start
    # Keys that lie closer than its frames want a finer one.
    dense = said is None or float(np.diff(keys).min(initial=np.inf)) * float(said * _FINER) < 1 + 1e-6
    for rate in (said, *map(Fraction, _COMMON)):
        if rate is not None and (rate == said or (dense and rate >= _FINER * (said or 0))):
            places = keys * float(rate)
            if np.abs(places - np.rint(places)).max() < 2e-3:
                return rate
    return said or _NO_RATE


def sample_stack(scene: FbxScene, curves: StackCurves, rate: Fraction | None, limits: Limits) -> Sampled:
    """Sample an animation from its stack's start to its end, at a rate or at the scene's.

    Scale is taken as it is at rest, and as one number for all three axes: the search looks at how joints move, and what
    is written comes from the curves themselves.

    Raises
    ------
    FormatError
        There are more nodes, or more frames, than may be.

    Warns
    -----
    FormatWarning
        Programs read something in more than one way, or most of the frames lie where no key does.
    """
    rate = rate or frame_rate(scene, curves)
    n_frames = int(np.ceil(float(rate) * (curves.end - curves.start) - 1e-3)) + 1
    moved = _moved_nodes(scene, curves)
    joints = _joints(scene, moved, limits) if moved else []
    n_columns = max(1, len(joints), len(curves.records))
    if n_frames > limits.frames or n_frames * n_columns > limits.joint_poses:
        raise scene.file.error(
            f"{curves.stack.name!r} lasts {curves.end - curves.start:g} s, which is {n_frames} frames at "
            f"{float(rate):g} Hz: give a lower rate (--fps)",
            curves.stack.item.record,
        )
    sampling = Sampling(
        curves.start,
        curves.end,
        float(rate),
        n_frames,
        max(7 * len(joints), len(curves.records)),
        len(curves.keys.values),
        curves.keys.ticks / scene.ticks,
    )
    if problem := sampling.problem():
        raise scene.file.error(f"{curves.stack.name!r} {problem}", curves.stack.item.record)
    if doubt := sampling.doubt():
        warnings.warn(f"{scene.file.path}: {curves.stack.name!r} {doubt}", FormatWarning, stacklevel=3)
    # Frames on which a key lies must not fall beside it by a rounding.
    times = np.rint((curves.start + np.arange(n_frames) / float(rate)) * scene.ticks) / scene.ticks
    values, doubts = stack_values(scene, curves, times)
    if joints:
        sampled = _motion(scene, curves, values, joints, rate, doubts)
    else:
        sampled = Sampled(_signal(scene, curves, values, rate), (), np.zeros(0), values)
    for doubt in doubts:
        warnings.warn(f"{scene.file.path}: {doubt}", FormatWarning, stacklevel=3)
    return sampled


def _moved_nodes(scene: FbxScene, curves: StackCurves) -> list[Item]:
    """Return the nodes that the stack has curves for; none, where no curve of them changes but others do."""
    found = {}
    starts = curves.keys.starts
    changing = {
        record.item.id
        for record, start, stop in zip(curves.records, starts[:-1], starts[1:], strict=True)
        if np.ptp(curves.keys.values[start:stop])
    }
    moves, others = False, False
    for layer in curves.stack.layers:
        for node in layer.nodes:
            changes = any(curve.id in changing for curve in node.curves.values())
            for item, name in node.targets if node.curves else []:
                if item.kind == "Model" and name in _MOVES:
                    found[item.id] = item
                    moves |= changes and name != SCALING
                else:
                    others |= changes
                others |= changes and name == SCALING
    return [] if others and not moves else list(found.values())


def parent_of(scene: FbxScene, item: Item) -> Item | None:
    """Return the node above a node."""
    for parent, prop in scene.above.get(item.id, ()):
        if not prop and parent in scene.items and scene.items[parent].kind == "Model":
            return scene.items[parent]
    return None


def _joints(scene: FbxScene, moved: list[Item], limits: Limits) -> list[Item | None]:
    """Order the nodes that move, limbs, and the nodes above them, parents first; None in front where there is no root.

    Raises
    ------
    FormatError
        A node is its own ancestor, or there are too many.
    """
    limbs = [one for one in scene.items.values() if one.kind == "Model" and one.subtype in _LIMBS]
    wanted: dict[int, Item] = {}
    for node in [*moved, *limbs]:
        up: Item | None = node
        depth = 0
        while up is not None and up.id not in wanted:
            wanted[up.id] = up
            up, depth = parent_of(scene, up), depth + 1
            if depth > limits.depth:
                break
        if depth > limits.depth:
            raise scene.file.error(f"nodes lie under each other more than {limits.depth} deep", node.record)
    if len(wanted) > limits.joints:
        raise scene.file.error(
            f"{len(wanted)} nodes move or carry others, the limit is {limits.joints} (Limits.joints)"
        )
    children: dict[int, list[Item]] = {}
    roots = []
    for item in scene.items.values():
        if item.id in wanted:
            parent = parent_of(scene, item)
            if parent is None:
                roots.append(item)
            else:
                children.setdefault(parent.id, []).append(item)
    ordered: list[Item | None] = []
    waiting = roots[::-1]
    while waiting:
        node = waiting.pop()
        ordered.append(node)
        waiting += children.get(node.id, [])[::-1]
    if len(ordered) != len(wanted):
        lost = next(item for item in wanted.values() if item not in ordered)
        raise scene.file.error(f"node {lost.name!r} is its own ancestor", lost.record)
    depths: dict[int | None, int] = {}
    for one in ordered:
        assert one is not None
        parent = parent_of(scene, one)
        depths[one.id] = 1 + (depths[parent.id] if parent else 0)
        if depths[one.id] > limits.depth:
            raise scene.file.error(f"nodes lie under each other more than {limits.depth} deep", one.record)
    return [None, *ordered] if len(roots) > 1 or _upright(scene) is not None else ordered


def _upright(scene: FbxScene) -> FloatArray | None:
    """Return the rotation that brings the scene's vertical axis up; None where it is Y or Z already."""
    axis, sign = int(scene.setting("UpAxis", 1)), scene.setting("UpAxisSign", 1)
    if axis in (1, 2) and sign >= 0:
        return None
    if axis == 0:
        return rotation.about_axis(2, np.pi / 2 if sign >= 0 else -np.pi / 2)
    return rotation.about_axis(0, np.pi if axis == 1 else np.pi / 2)


def _motion(
    scene: FbxScene,
    curves: StackCurves,
    values: StackValues,
    joints: list[Item | None],
    rate: Fraction,
    doubts: list[str],
) -> Sampled:
    n_frames, n_joints = len(values.times), len(joints)
    rotations = np.tile(rotation.identity(), (n_frames, n_joints, 1))
    translations = np.zeros((n_frames, n_joints, 3))
    offsets = np.zeros((n_joints, 3))
    scales, total = np.ones(n_joints), np.ones(n_joints)
    place = {None if one is None else one.id: joint for joint, one in enumerate(joints)}
    parents = [-1] * n_joints
    unsure = []
    for joint, item in enumerate(joints):
        if item is None:
            upright = _upright(scene)
            if upright is not None:
                rotations[:, joint] = upright
            continue
        above = parent_of(scene, item)
        if joint:
            parents[joint] = place[above.id] if above is not None else 0
        turned, placed = joint_poses(scene, values, item)
        at_rest = _rest(scene, item)
        if not np.isfinite(turned).all() or not np.isfinite(placed).all():
            raise scene.file.error(f"node {item.name!r} is nowhere: its numbers are beyond use", item.record)
        rotations[:, joint], translations[:, joint], offsets[joint] = turned, placed, at_rest
        own = float(np.cbrt(np.abs(np.prod(scene.numbers(item, SCALING, (1.0, 1.0, 1.0))))))
        carried = total[parents[joint]] if above is not None else 1.0
        scales[joint] = carried
        if above is not None and scene.whole(item, "InheritType", 0) == _IGNORE_PARENT_SCALE:
            above_scale = float(np.cbrt(np.abs(np.prod(scene.numbers(above, SCALING, (1.0, 1.0, 1.0))))))
            carried = carried / above_scale if above_scale else carried
        total[joint] = carried * own
        if not scene.whole(item, "RotationActive", 0) and scene.numbers(item, "PreRotation", (0.0,) * 3).any():
            unsure.append(item.name)
    if unsure:
        doubts.append(
            f"{len(unsure)} nodes ({unsure[0]}, ...) have a PreRotation that RotationActive switches off; some "
            "programs turn them all the same"
        )
    odd = [
        one.name for one in joints if one is not None and not 0 <= scene.whole(one, "RotationOrder", 0) < len(ORDERS)
    ]
    if odd:
        doubts.append(f"{len(odd)} nodes ({odd[0]}, ...) turn in the spheric order, which is read as XYZ")
    if any(item.kind == "Constraint" for item in scene.items.values()):
        doubts.append("the scene has constraints; the poses that are searched are those of its keys alone")
    names = [one.name or f"node_{one.id}" if one is not None else "scene" for one in joints]
    up: Up = "z" if int(scene.setting("UpAxis", 1)) == 2 and _upright(scene) is None else "y"
    unit = scene.setting("UnitScaleFactor", 1.0) / 100
    if max(np.abs(translations).max(), np.abs(offsets).max()) * scales.max() > 1e30 or not np.isfinite(scales).all():
        raise scene.file.error("a node lies beyond any use, or its scale does")
    motion = Motion(
        Skeleton(names, parents, offsets * scales[:, None]),
        rotations,
        translations * scales[:, None],
        rate,
        name=curves.stack.name,
        metres_per_unit=unit if 1e-6 <= unit <= 1e6 else None,
        up=up,
    )
    return Sampled(motion, tuple(joints), scales, values)


def frame_turns(scene: FbxScene, values: StackValues, item: Item) -> tuple[FloatArray, FloatArray]:
    """Return what is turned before a node's own turn, and what after it is undone, (n_frames, 4) each."""
    if not scene.whole(item, "RotationActive", 0):
        one = rotation.identity(len(values.times))
        return one, one
    pre = quaternions("ZYX", values.vector(item, "PreRotation", (0.0, 0.0, 0.0)))
    post = quaternions("ZYX", values.vector(item, "PostRotation", (0.0, 0.0, 0.0)))
    return pre, rotation.conjugate(post)


def pivot_shift(values: StackValues, item: Item, turned: FloatArray) -> FloatArray:
    """Return by how much pivots and offsets move a node's origin from its translation, (n_frames, 3)."""
    names = ("RotationOffset", "RotationPivot", "ScalingOffset", "ScalingPivot")
    offset, pivot, scaling_offset, scaling_pivot = (values.vector(item, name, (0.0, 0.0, 0.0)) for name in names)
    scaled = values.vector(item, SCALING, (1.0, 1.0, 1.0)) * scaling_pivot
    return offset + pivot + rotation.rotate(turned, scaling_offset - pivot + scaling_pivot - scaled)


def joint_poses(scene: FbxScene, values: StackValues, item: Item) -> tuple[FloatArray, FloatArray]:
    """Return a node's rotations (n_frames, 4) and where its origin is in its parent (n_frames, 3)."""
    order = rotation_order(scene, item) if scene.whole(item, "RotationActive", 0) else ORDERS[0]
    before, after = frame_turns(scene, values, item)
    own = quaternions(order, values.vector(item, ROTATION, (0.0, 0.0, 0.0)))
    turned = rotation.multiply(rotation.multiply(before, own), after)
    return turned, values.vector(item, TRANSLATION, (0.0, 0.0, 0.0)) + pivot_shift(values, item, turned)


def _rest(scene: FbxScene, item: Item) -> FloatArray:
    """Return where a node's origin is where nothing moves it, (3,)."""
    still = StackValues(scene, np.zeros(1), [], Layer(item), {}, {})
    return np.asarray(joint_poses(scene, still, item)[1][0])


def _signal(scene: FbxScene, curves: StackCurves, values: StackValues, rate: Fraction) -> Signal:
    """Return everything that the stack moves as columns."""
    names: list[str] = []
    columns = []
    for (id_, prop), stacked in values.by_target.items():
        item = scene.items[id_]
        parts = parts_of(scene, stacked[0][1])
        n = 3 if set(parts) & {"d|X", "d|Y", "d|Z"} else 1
        shown = values.vector(item, prop, (0.0,) * n) if _has(scene, item, prop, n) else None
        if shown is None:
            shown = values.node_values(stacked[0][1], n)
        for part in range(n):
            name = f"{item.name}.{prop}" + (f".{'XYZ'[part]}" if n == 3 else "")
            names.append(name if name not in names else f"{name} ({len(names)})")
            columns.append(shown[:, part])
    if not columns:
        raise scene.file.error(
            f"the animation {curves.stack.name!r} moves nothing that is there", curves.stack.item.record
        )
    return Signal(tuple(names), np.stack(columns, axis=1), rate, name=curves.stack.name)


def _has(scene: FbxScene, item: Item, prop: str, n: int) -> bool:
    """Tell whether a property is numbers, as many as its curves move."""
    found = scene.properties(item).get(prop)
    return found is None or len(found[1]) == 4 + n
