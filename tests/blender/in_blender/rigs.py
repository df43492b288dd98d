"""Rigs and motions that tests make in Blender, and poses as its depsgraph has them."""

from __future__ import annotations

import math
import random

import bpy
import numpy as np

CURVE = '["retime_curve"]'


def select(*objects):
    """Select objects and nothing else; the first one is active."""
    for one in bpy.context.view_layer.objects:
        one.select_set(False)
    for one in objects:
        one.select_set(True)
    bpy.context.view_layer.objects.active = objects[0]


def link(one):
    """Put an object into the scene."""
    bpy.context.scene.collection.objects.link(one)
    return one


def empty(name="prop"):
    """Make an object that is nothing but a place."""
    return link(bpy.data.objects.new(name, None))


def walker(name="walker", *, n_frames=120, seed=1, step=4, mode="QUATERNION", extra_bones=True):
    """Make a figure that walks: keys on every `step` frames, Bézier curves, bones in an order that means nothing.

    Hips sway and go forward, legs swing, arms swing against them; a root bone and a control bone deform nothing.
    """
    rng = random.Random(seed)
    data = bpy.data.armatures.new(name)
    rig = link(bpy.data.objects.new(name, data))
    select(rig)
    bpy.ops.object.mode_set(mode="EDIT")
    places = {
        "hips": (None, (0, 0, 1.0), (0, 0, 1.2)),
        "spine": ("hips", (0, 0, 1.2), (0, 0, 1.6)),
        "head": ("spine", (0, 0, 1.6), (0, 0, 1.8)),
    }
    for side, x in (("L", 0.1), ("R", -0.1)):
        places |= {
            f"thigh.{side}": ("hips", (x, 0, 1.0), (x, -0.02, 0.55)),
            f"shin.{side}": (f"thigh.{side}", (x, -0.02, 0.55), (x, 0, 0.1)),
            f"foot.{side}": (f"shin.{side}", (x, 0, 0.1), (x, -0.15, 0.0)),
            f"arm.{side}": ("spine", (2 * x, 0, 1.55), (4 * x, 0, 1.2)),
        }
    made = {}
    if extra_bones:
        root = data.edit_bones.new("root")
        root.head, root.tail, root.use_deform = (0, 0, 0), (0, 0.3, 0), False
        made["root"] = root
    for bone, (parent, head, tail) in places.items():
        new = data.edit_bones.new(bone)
        new.head, new.tail = head, tail
        made[bone] = new
        new.parent = made.get(parent) or made.get("root")
    if extra_bones:
        control = data.edit_bones.new("look_at")
        control.head, control.tail, control.use_deform = (0, -1, 1.7), (0, -1, 1.8), False
    bpy.ops.object.mode_set(mode="OBJECT")
    for bone in rig.pose.bones:
        bone.rotation_mode = mode
    # A slow start, a hurry, and a pause, so that there is timing to find.
    phase = 0.0
    for frame in range(1, n_frames + 1):
        share = frame / n_frames
        speed = 0.6 + 0.8 * math.sin(math.pi * share) ** 2 if share < 0.75 else max(0.0, 1.2 - 4.8 * (share - 0.75))
        phase += speed * 0.25
        if (frame - 1) % step and frame != n_frames:
            continue
        hips = rig.pose.bones["hips"]
        hips.location = (0.03 * math.sin(phase), 0.02 * math.cos(2 * phase), 0.25 * phase / 3)
        hips.keyframe_insert("location", frame=frame)
        for side, sign in (("L", 1), ("R", -1)):
            swing = {"thigh": 0.5 * sign * math.sin(phase), "shin": 0.4 + 0.4 * math.cos(phase + 1.5 * sign)}
            swing |= {"foot": 0.2 * math.sin(phase + sign), "arm": -0.4 * sign * math.sin(phase)}
            for bone, angle in swing.items():
                turn(
                    rig.pose.bones[f"{bone}.{side}"], (angle, 0.1 * rng.random(), 0.05 * sign * math.sin(phase)), frame
                )
        turn(rig.pose.bones["spine"], (0.05 * math.sin(2 * phase), 0.1 * math.sin(phase), 0), frame)
    return rig


def turn(bone, angles, frame):
    """Turn a bone by Euler angles, however it holds its turn, and key it."""
    from mathutils import Euler

    q = Euler(angles).to_quaternion()
    if bone.rotation_mode == "QUATERNION":
        bone.rotation_quaternion = q
        bone.keyframe_insert("rotation_quaternion", frame=frame)
    elif bone.rotation_mode == "AXIS_ANGLE":
        axis, angle = q.to_axis_angle()
        bone.rotation_axis_angle = (angle, *axis)
        bone.keyframe_insert("rotation_axis_angle", frame=frame)
    else:
        bone.rotation_euler = q.to_euler(bone.rotation_mode)
        bone.keyframe_insert("rotation_euler", frame=frame)


def swinging(one, *, frames=range(1, 61, 6), seed=3, path="location"):
    """Key a property of an object at random, with Bézier curves."""
    rng = random.Random(seed)
    for frame in frames:
        value = [rng.uniform(-2, 2) for _ in getattr(one, path)]
        setattr(one, path, value)
        one.keyframe_insert(path, frame=frame)
    return one


def fcurves(block, action=None):
    """List the F-curves of a data-block, in any version of Blender."""
    animation = block.animation_data
    action = action or animation.action
    if not hasattr(action, "layers"):
        return list(action.fcurves)
    bags = [strip.channelbag(animation.action_slot) for layer in action.layers for strip in layer.strips]
    return [curve for bag in bags if bag for curve in bag.fcurves]


def poses(objects, frames):
    """Return world matrices of objects and of all their bones at frames, by the depsgraph: (n_frames, n, 4, 4)."""
    scene = bpy.context.scene
    rows = []
    for frame in np.asarray(frames, dtype=float):
        scene.frame_set(math.floor(frame), subframe=frame - math.floor(frame))
        depsgraph = bpy.context.evaluated_depsgraph_get()
        found = []
        for one in objects:
            evaluated = one.evaluated_get(depsgraph)
            found.append(np.array(evaluated.matrix_world))
            if evaluated.pose:
                found += [np.array(evaluated.matrix_world @ bone.matrix) for bone in evaluated.pose.bones]
        rows.append(found)
    return np.array(rows)


def values(block, path, frames, index=None):
    """Return an evaluated property at frames."""
    scene = bpy.context.scene
    rows = []
    for frame in np.asarray(frames, dtype=float):
        scene.frame_set(math.floor(frame), subframe=frame - math.floor(frame))
        value = block.evaluated_get(bpy.context.evaluated_depsgraph_get()).path_resolve(path)
        rows.append(value if index is None else value[index])
    return np.array(rows)


def draw_curve(pairs):
    """Draw the new timing by hand: (output frame, input frame), straight lines between."""
    scene = bpy.context.scene
    scene["retime_curve"] = 0.0
    for to, frame in pairs:
        scene["retime_curve"] = float(frame)
        scene.keyframe_insert(CURVE, frame=to)
    for curve in fcurves(scene):
        for point in curve.keyframe_points:
            point.interpolation = "LINEAR"


def timing():
    """Return the new timing as (output frames, input frames) of its knots."""
    curve = next(curve for curve in fcurves(bpy.context.scene) if curve.data_path == CURVE)
    rows = np.array([point.co for point in curve.keyframe_points])
    return rows[:, 0], rows[:, 1]


def shown(frames):
    """Return which input frame is shown at output frames; what lies beyond the range moves with its ends."""
    to, at = timing()
    frames = np.asarray(frames, dtype=float)
    inner = np.interp(frames, to, at)
    return np.where(frames > to[-1], at[-1] + frames - to[-1], np.where(frames < to[0], at[0] + frames - to[0], inner))


def run(name, **given):
    """Press a button, as one undo step."""
    return getattr(bpy.ops.retime, name)("EXEC_DEFAULT", True, **given)
