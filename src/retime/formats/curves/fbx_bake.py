"""An FBX animation with a key on every frame."""

from __future__ import annotations

import numpy as np

from retime.arrays import FloatArray, IntArray
from retime.formats.curves.fbx_curve import CONSTANT, LINEAR, THIRDS, USER, Keys
from retime.formats.curves.fbx_motion import TRANSLATION, Sampled, frame_turns, pivot_shift
from retime.formats.curves.fbx_scene import FbxScene, Item
from retime.formats.curves.fbx_span import StackCurves
from retime.formats.curves.fbx_values import (
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

    Turns and places of nodes come from the motion, so that feet which stand stay; where layers lie on top of one
    another, and for all else, each curve is shown by itself. Steps stay steps.
    """
    clip = apply_warp(sampled.clip, warp, average=average)
    rate = float(clip.rate)
    frames = np.arange(clip.n_frames) / rate
    ticks = np.rint((curves.start + frames) * scene.ticks).astype(np.int64)
    inputs = np.rint((curves.start + warp(frames)) * scene.ticks) / scene.ticks
    order = np.unique(inputs, return_inverse=True)
    at_inputs, _ = stack_values(scene, curves, order[0])
    shown = {id_: column[order[1]] for id_, column in at_inputs.shown.items()}
    from_clip = _from_clip(scene, curves, sampled, clip, inputs) if isinstance(clip, Motion) else {}

    keys = curves.keys
    columns, flags = [], []
    for index, record in enumerate(curves.records):
        id_ = record.item.id
        part = slice(int(keys.starts[index]), int(keys.starts[index + 1]))
        stepped = bool((keys.flags[part][: max(1, part.stop - part.start - 1)] & CONSTANT).all())
        if stepped:
            columns.append(shown[id_])
        elif id_ in from_clip:
            columns.append(from_clip[id_])
        else:
            columns.append(apply_warp(sampled.values.shown[id_], warp, average=average, rate=clip.rate))
        flags.append(CONSTANT if stepped else LINEAR | USER)
    n = clip.n_frames
    data = np.zeros((n * len(columns), 4), dtype=np.uint32)
    data[:, 2] = THIRDS
    return Keys(
        np.full(len(columns), n),
        np.tile(ticks, len(columns)),
        np.concatenate(columns),
        np.repeat(np.array(flags, dtype=np.int64), n),
        data,
    )


def _from_clip(
    scene: FbxScene, curves: StackCurves, sampled: Sampled, clip: Motion, inputs: FloatArray
) -> dict[int, FloatArray]:
    """Return the numbers of curves for turns and places, by curve, from a motion that was retimed."""
    found: dict[int, FloatArray] = {}
    if len(curves.stack.layers) != 1:
        return found
    unique, back = np.unique(inputs, return_inverse=True)
    values, _ = stack_values(scene, curves, unique)
    by_item = {item.id: joint for joint, item in enumerate(sampled.nodes) if item is not None}
    for layer in curves.stack.layers:
        for node in layer.nodes:
            for item, name in node.targets:
                if item.id not in by_item or name not in (ROTATION, TRANSLATION) or not node.curves:
                    continue
                joint = by_item[item.id]
                near = values.vector(item, name, (0.0, 0.0, 0.0))[back]
                turned = clip.rotations[:, joint]
                if name == ROTATION:
                    numbers = _angles(scene, values, back, item, turned, near)
                else:
                    scale = sampled.scales[joint]
                    shift = pivot_shift(_at(values, back), item, turned)
                    numbers = clip.local_translations[:, joint] / (scale if scale else 1.0) - shift
                for place, axis in enumerate("XYZ"):
                    curve = node.curves.get(f"d|{axis}")
                    if curve is not None:
                        found[curve.id] = numbers[:, place]
    return found


def _angles(
    scene: FbxScene, values: StackValues, back: IntArray, item: Item, turned: FloatArray, near: FloatArray
) -> FloatArray:
    before, after = (one[back] for one in frame_turns(scene, values, item))
    own = rotation.multiply(rotation.multiply(rotation.conjugate(before), turned), rotation.conjugate(after))
    order = rotation_order(scene, item) if scene.whole(item, "RotationActive", 0) else ORDERS[0]
    return degrees(order, own, near)


def _at(values: StackValues, back: IntArray) -> StackValues:
    """Return values whose times are repeated as `back` says."""
    shown = {id_: column[back] for id_, column in values.shown.items()}
    return StackValues(values.scene, values.times[back], values.layers, values.base, shown, values.by_target)
