"""Poses of objects at frames of a scene, as Blender evaluates them: constraints, drivers and the NLA included.

A scene of our own holds nothing but these objects (and what they depend on): neither a heavy mesh nor anything else of
the person's scene is evaluated, and its frame stays where it is.
"""

from __future__ import annotations

import contextlib
from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np

from retime.arrays import FloatArray
from retime.errors import OptionError
from retime.motion.any_motion import AnyMotion
from retime.motion.signal import Signal

from .animated import Thing, blocks_of, fcurves_of, units_of
from .figure import Bones, figure_of


def rate_of(scene: Thing) -> float:
    """Return a scene's frames a second."""
    return float(scene.render.fps) / float(scene.render.fps_base)


@contextlib.contextmanager
def stepping(data: Thing, scene: Thing, objects: Sequence[Thing]) -> Iterator[Any]:
    """Give a function that evaluates the objects at a frame and returns the depsgraph.

    Parameters
    ----------
    data : bpy.data
    scene : Scene
        Whose clock and units they have.
    objects : sequence of Object
    """
    own = data.scenes.new("retime")
    with contextlib.ExitStack() as after:
        after.callback(data.scenes.remove, own)
        for one in objects:
            after.enter_context(_posed(one))
        own.render.fps, own.render.fps_base = scene.render.fps, scene.render.fps_base
        own.unit_settings.scale_length = scene.unit_settings.scale_length
        for one in objects:
            own.collection.objects.link(one)

        def step(frame: float) -> Thing:
            whole = int(np.floor(frame))
            own.frame_set(whole, subframe=float(frame - whole))
            return own.view_layers[0].depsgraph

        yield step


@contextlib.contextmanager
def _posed(one: Thing) -> Iterator[None]:
    """Have Blender evaluate an object whether it is shown or not, in its poses and not at rest, for a while."""
    kept: list[tuple[Thing, str, Any]] = []

    def put(holder: Thing, name: str, value: object) -> None:
        kept.append((holder, name, getattr(holder, name)))
        setattr(holder, name, value)

    try:
        # What hides and shows it by keys or by a driver would hide it from the search too.
        if one.animation_data is not None:
            curves = [curve for unit in units_of(one) for curve in fcurves_of(unit.action, unit.slot)]
            for curve in [*curves, *one.animation_data.drivers]:
                if curve.data_path == "hide_viewport" and not curve.mute:
                    put(curve, "mute", True)
        if one.hide_viewport:
            put(one, "hide_viewport", False)
        if one.type == "ARMATURE" and one.data.pose_position != "POSE":
            put(one.data, "pose_position", "POSE")
        yield
    finally:
        for holder, name, value in reversed(kept):
            setattr(holder, name, value)


def bones_of(armature: Thing) -> Bones:
    """Read the bones of an armature at rest; Blender lists parents before their children."""
    bones = armature.data.bones
    place = {bone.name: i for i, bone in enumerate(bones)}
    return Bones(
        [bone.name for bone in bones],
        [-1 if bone.parent is None else place[bone.parent.name] for bone in bones],
        np.array([bone.matrix_local for bone in bones], dtype=np.float64).reshape(-1, 4, 4),
        np.array([bone.length for bone in bones]),
        np.array([bone.use_deform for bone in bones], dtype=bool),
    )


def clips_of(
    data: Thing, scene: Thing, objects: Sequence[Thing], first: int, last: int, *, root: str = ""
) -> list[AnyMotion]:
    """Sample what the search looks at, from frame `first` to `last`: figures; where there are none, what is animated.

    Parameters
    ----------
    data, scene, objects
        As `stepping` has them.
    first, last : int
        Frames of the scene, both included.
    root : str
        The bone that carries the body; left out, it is found.

    Returns
    -------
    list of Motion, or of one Signal

    Raises
    ------
    OptionError
        Nothing of the objects is animated, or an armature has no bone called `root`.
    """
    figures = [one for one in objects if one.type == "ARMATURE" and len(one.data.bones)]
    rate, metres = rate_of(scene), float(scene.unit_settings.scale_length)
    frames = range(first, last + 1)
    with stepping(data, scene, objects) as step:
        if not figures:
            return [_signal(objects, frames, step, rate)]
        buffers = [np.empty((len(frames), len(one.pose.bones), 16), dtype=np.float32) for one in figures]
        worlds = [np.empty((len(frames), 4, 4)) for _ in figures]
        for i, frame in enumerate(frames):
            depsgraph = step(frame)
            for one, buffer, world in zip(figures, buffers, worlds, strict=True):
                evaluated = one.evaluated_get(depsgraph)
                evaluated.pose.bones.foreach_get("matrix", buffer[i].ravel())
                world[i] = evaluated.matrix_world
    clips: list[AnyMotion] = []
    for one, buffer, world in zip(figures, buffers, worlds, strict=True):
        bones = bones_of(one)
        deforming = bones.deforming()
        if root and root in bones.names and root not in deforming.names:
            deforming = bones
        chosen = [bones.names.index(name) for name in deforming.names]
        # Blender lists a matrix column by column, and pose bones as it lists bones.
        matrices = buffer.reshape(len(frames), -1, 4, 4).swapaxes(-1, -2)[:, chosen].astype(np.float64)
        clips.append(
            figure_of(deforming, matrices, world, rate=rate, name=one.name, metres_per_unit=metres, root=root or None)
        )
    return clips


def _signal(objects: Sequence[Thing], frames: range, step: Any, rate: float) -> Signal:
    """Read every animated number of objects that are no figures."""
    wanted: dict[tuple[str, str, str, int], Thing] = {}
    for block in blocks_of(objects):
        for unit in units_of(block):
            for curve in fcurves_of(unit.action, unit.slot):
                # A camera and its lens are two blocks, which often have one name.
                name = (block.rna_type.identifier, block.name, curve.data_path, curve.array_index)
                wanted.setdefault(name, block)
    rows = np.full((len(frames), len(wanted)), np.nan)
    for i, frame in enumerate(frames):
        depsgraph = step(frame)
        for column, ((*_, path, index), block) in enumerate(wanted.items()):
            rows[i, column] = _number(block.evaluated_get(depsgraph), path, index)
    known = np.flatnonzero(np.isfinite(rows).all(axis=0) & (np.ptp(np.nan_to_num(rows), axis=0) > 0))
    if not len(known):
        names = ", ".join(one.name for one in objects)
        raise OptionError(
            f"nothing of {names} moves from frame {frames.start} to {frames.stop - 1}", option="selection"
        )
    channels = [f"{name} {path}[{index}]" for _, name, path, index in wanted]
    return Signal([channels[i] for i in known], rows[:, known], rate, objects[0].name, kinds=["linear"] * len(known))


def _number(block: Thing, path: str, index: int) -> FloatArray | float:
    """Return a property's number now; NaN where it is none."""
    try:
        value = block.path_resolve(path)
    except ValueError:
        return float("nan")
    if hasattr(value, "__len__") and not isinstance(value, str):
        value = value[index]
    return float(value) if isinstance(value, int | float) else float("nan")
