"""An FBX animation with a key on every frame."""

from __future__ import annotations

import numpy as np

from retime.arrays import FloatArray, IntArray
from retime.formats.curves.fbx.curve import CONSTANT, LINEAR, THIRDS, USER, Keys
from retime.formats.curves.fbx.motion import TRANSLATION, Sampled, frame_turns, joint_poses, pivot_shift
from retime.formats.curves.fbx.scene import FbxScene, Item
from retime.formats.curves.fbx.span import StackCurves
from retime.formats.curves.fbx.values import (
    ORDERS,
    ROTATION,
    StackValues,
    degrees,
    rotation_order,
    stack_values,
)
from retime.motion import rotation
from retime.motion.motion import Motion
from retime.warp.apply import apply_warp
from retime.warp.curve import Warp


def baked_keys(scene: FbxScene, curves: StackCurves, sampled: Sampled, warp: Warp, *, average: bool) -> Keys:
    """Return keys for every curve of a stack, one on each frame; sped up, frames are averaged (§3.4).

    Each key is what the curve has at the warp's time, and what averaging changes of that: of turns and places of nodes
    as it does of the motion, so that feet which stand stay; where layers lie on top of one another, and of all else, by
    each curve itself. Steps stay steps.
    """
    n = warp.count_frames(sampled.clip.rate)
    frames = np.arange(n) / float(sampled.clip.rate)
    ticks = np.rint((curves.start + frames) * scene.ticks).astype(np.int64)
    inputs, back = np.unique(np.rint((curves.start + warp(frames)) * scene.ticks) / scene.ticks, return_inverse=True)
    values, _ = stack_values(scene, curves, inputs)
    values = _at(values, back)
    averaged = _averaged_nodes(scene, curves, sampled, values, warp) if average else {}

    keys = curves.keys
    columns, flags = [], []
    for index, record in enumerate(curves.records):
        id_ = record.item.id
        part = slice(int(keys.starts[index]), int(keys.starts[index + 1]))
        stepped = bool((keys.flags[part][: max(1, part.stop - part.start - 1)] & CONSTANT).all())
        column = averaged.get(id_, values.shown[id_])
        if average and not stepped and id_ not in averaged:
            mean, plain = (
                apply_warp(sampled.values.shown[id_], warp, average=one, rate=sampled.clip.rate)
                for one in (True, False)
            )
            column = column + (mean - plain)
        columns.append(values.shown[id_] if stepped else column)
        flags.append(CONSTANT if stepped else LINEAR | USER)
    data = np.zeros((n * len(columns), 4), dtype=np.uint32)
    data[:, 2] = THIRDS
    return Keys(
        np.full(len(columns), n),
        np.tile(ticks, len(columns)),
        np.concatenate(columns),
        np.repeat(np.array(flags, dtype=np.int64), n),
        data,
    )


def _averaged_nodes(
    scene: FbxScene, curves: StackCurves, sampled: Sampled, values: StackValues, warp: Warp
) -> dict[int, FloatArray]:
    """Return what curves for turns and places have where the motion is averaged, by curve; none with several layers."""
    found: dict[int, FloatArray] = {}
    if len(curves.stack.layers) != 1 or not isinstance(sampled.clip, Motion):
        return found
    mean, plain = (apply_warp(sampled.clip, warp, average=one) for one in (True, False))
    joints = {item.id: joint for joint, item in enumerate(sampled.nodes) if item is not None}
    for node in curves.stack.layers[0].nodes:
        for item, name in node.targets:
            if item.id not in joints or name not in (ROTATION, TRANSLATION) or not node.curves:
                continue
            joint = joints[item.id]
            turned, placed = joint_poses(scene, values, item)
            change = rotation.multiply(rotation.conjugate(plain.rotations[:, joint]), mean.rotations[:, joint])
            turned = rotation.multiply(turned, change)
            if name == ROTATION:
                numbers = _angles(scene, values, item, turned)
            else:
                moved = mean.local_translations[:, joint] - plain.local_translations[:, joint]
                scale = sampled.scales[joint]
                numbers = placed + moved / (scale if scale else 1.0) - pivot_shift(values, item, turned)
            for place, axis in enumerate("XYZ"):
                curve = node.curves.get(f"d|{axis}")
                if curve is not None:
                    found[curve.id] = numbers[:, place]
    return found


def _angles(scene: FbxScene, values: StackValues, item: Item, turned: FloatArray) -> FloatArray:
    before, after = frame_turns(scene, values, item)
    own = rotation.multiply(rotation.multiply(rotation.conjugate(before), turned), rotation.conjugate(after))
    order = rotation_order(scene, item) if scene.whole(item, "RotationActive", 0) else ORDERS[0]
    return degrees(order, own, values.vector(item, ROTATION, (0.0, 0.0, 0.0)))


def _at(values: StackValues, back: IntArray) -> StackValues:
    """Return values whose times are repeated as `back` says."""
    shown = {id_: column[back] for id_, column in values.shown.items()}
    return StackValues(values.scene, values.times[back], values.layers, values.base, shown, values.by_target)
