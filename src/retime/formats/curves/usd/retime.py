"""New timing for all layers of a USD scene: time samples cut by a warp, or put on frames.

Runs in the child process (`usd.child`).
"""

from __future__ import annotations

import os
from dataclasses import dataclass
from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np
from pxr import Sdf, Usd

from retime.arrays import FloatArray
from retime.brief import brief_repr
from retime.errors import FormatError, InvalidMotionError, OptionError
from retime.formats.curves.usd.animation import joint_places, read, skeletal_animations
from retime.formats.curves.usd.layer_files import Rewritten, copy_of, layer_file, set_samples
from retime.formats.curves.usd.layers import (
    Clock,
    Clocks,
    Moves,
    layers_of,
    package_of,
    prims_with_clips,
    timecode_specs,
    told,
    unshown,
)
from retime.formats.curves.usd.motion import motion_of
from retime.formats.curves.usd.package import packed, unpacked
from retime.formats.curves.usd.splines import cut_spline
from retime.formats.curves.usd.stage import Scene, naming, sampled_specs
from retime.formats.curves.usd.timing import Timing, Track, on_clock, timing_of
from retime.formats.curves.usd.value_clips import cut_clips, refuse_old_clips
from retime.formats.read_options import Limits
from retime.warp.apply import apply_warp
from retime.warp.curve import Warp


def rewritten(
    scene: Scene,
    warp: Warp,
    work: Path,
    *,
    rate: Fraction | None,
    average: bool,
    bake: bool,
    limits: Limits,
    home: str,
    name: str,
) -> Rewritten:
    """Give the time samples of all layers of a scene new timing, each on its own clock.

    Layers beside the root that change, or name one that does, are new files beside the new root, which name each other;
    all else that a layer names is named where it was. In a package files keep their names.

    Parameters
    ----------
    scene : Scene
        The scene.
    warp : Warp
        Seconds from its start.
    work : Path
        A folder of this process's own.
    rate, average, bake, limits
        As of `retime.formats.curves.usd.format.bake`.
    home : str
        The way from the folder of what is written to that of the scene, with ``/``.
    name : str
        The name of the new file.

    Raises
    ------
    FormatError
        There are time samples in what can't be cut, or is shown on several clocks.
    """
    timing = timing_of(scene, warp)
    clocks, layers = Clocks(scene.stage), layers_of(scene)
    way = None
    if bake:
        rate = rate or timing.span.rate()
        joints = _averaged_joints(scene, timing, rate, limits) if average else {}
        way = _Way(rate, average, limits, joints)
    changed: list[tuple[Any, Any]] = []
    left: list[str] = []
    for layer in layers:
        if layer == scene.layer or moves_in_time(layer):
            copy, still = _retimed_layer(layer, timing, clocks, way, is_root=layer == scene.layer)
            left += [f"{path} in {told(layer, scene)}" for path in still]
            changed.append((layer, copy))
    left += unshown(scene, clocks, [layer for layer, _ in changed])
    if scene.package:
        files = dict(scene.package)
        for layer, copy in changed:
            member = Path(os.path.relpath(layer.realPath, scene.folder)).as_posix()
            if member not in files:
                raise FormatError(f"{told(layer, scene)} has time samples, in a package that is within this one")
            files[member] = layer_file(files[member], layer, copy, work, {})
        return Rewritten({"": packed(files)}, left)
    moves = Moves(scene, home, name)
    for layer, _ in changed[1:]:
        moves.put(layer)
    changed += [(layer, copy_of(layer)) for layer in moves.needed(layers)]
    made: dict[str, bytes] = {}
    packages: dict[str, dict[str, bytes]] = {}
    for layer, copy in changed:
        file, inner = package_of(layer)
        new = "" if layer == scene.layer else moves.put(layer)
        if not inner:
            before = scene.text if layer == scene.layer else Path(file).read_bytes()
            made[new] = layer_file(before, layer, copy, work, moves.apply(layer, copy))
            continue
        if file not in packages:
            packages[file] = unpacked(Path(file).read_bytes(), limits)
        members = packages[file]
        if inner not in members:
            raise FormatError(f"{told(layer, scene)} has time samples, in a package that is within another")
        members[inner] = layer_file(members[inner], layer, copy, work, {})
        made[new] = b""
    made |= {moves.new[file]: packed(members) for file, members in packages.items()}
    return Rewritten(made, left)


@dataclass(frozen=True)
class _Way:
    """How samples are put on frames.

    Attributes
    ----------
    rate : Fraction
        Frames a second.
    average : bool
        Average, where sped up.
    limits : Limits
        Of sizes.
    joints : dict of str to float arrays
        Averages that are known already, by attribute.
    """

    rate: Fraction
    average: bool
    limits: Limits
    joints: dict[str, FloatArray]

    __repr__ = brief_repr


def moves_in_time(layer: Any) -> bool:
    """Tell whether a layer holds anything that new timing changes."""
    return bool(sampled_specs(layer) or prims_with_clips(layer) or timecode_specs(layer))


def _retimed_layer(
    source: Any, timing: Timing, clocks: Clocks, way: _Way | None, *, is_root: bool
) -> tuple[Any, list[Any]]:
    """Make a copy of a layer with its samples cut or, by `way`, put on frames.

    Returns
    -------
    layer : Sdf.Layer
        The copy.
    left : list of Sdf.Path
        What stayed as it was: no prim of the scene shows it, and the layer has no one clock.
    """
    layer = copy_of(source)
    left: list[Any] = []
    used: set[Clock] = set()

    def timing_at(path: Any) -> Timing | None:
        clock = clocks.of(source, path.GetPrimOrPrimVariantSelectionPath())
        if clock is None:
            left.append(path)
            return None
        used.add(clock)
        return on_clock(timing, clock)

    scratch = Sdf.Layer.CreateAnonymous(".usda")
    stage = Usd.Stage.Open(scratch)
    for number, spec in enumerate(sampled_specs(layer)):
        path = spec.path
        own = timing_at(path)
        if own is None:
            continue
        if spec.HasSpline():
            if way is not None:
                raise FormatError(f"{path} is a spline: it is cut, not baked (leave out --bake)")
            spec.SetSpline(cut_spline(spec.GetSpline(), own.warp, own.span, str(path)))
            continue
        prim = Sdf.CreatePrimInLayer(scratch, f"/a{number}")
        Sdf.AttributeSpec(prim, spec.name, spec.typeName)
        codes = np.array(layer.ListTimeSamplesForPath(path), dtype=np.float64)
        with naming(path, spec.typeName):
            values = [_value(layer.QueryTimeSample(path, code)) for code in codes.tolist()]
        copied = prim.path.AppendProperty(spec.name)
        set_samples(scratch, copied, list(zip(codes.tolist(), values, strict=True)))
        attribute = stage.GetAttributeAtPath(copied)
        track = Track(codes, values, lambda code, one=attribute: one.Get(code))  # type: ignore[misc]
        if way is None:
            samples = own.retimed(track)
        else:
            shown = clocks.prim_of(source, path.GetPrimOrPrimVariantSelectionPath())
            means = way.joints.get(f"{shown}.{spec.name}")
            samples = own.baked(track, way.rate, way.average, way.limits, means)
        set_samples(layer, path, [(code, own.moved(value)) for code, value in samples])
        del scratch.rootPrims[prim.name]
    for spec in timecode_specs(layer):
        own = timing_at(spec.path)
        if own is not None:
            spec.default = own.moved(spec.default)
    for path in prims_with_clips(layer):
        own = timing_at(path)
        if own is not None:
            cut_clips(layer, path, own, source)
    refuse_old_clips(layer)
    _move_ends(layer, timing, used, is_root=is_root)
    return layer, left


def _move_ends(layer: Any, timing: Timing, used: set[Clock], *, is_root: bool) -> None:
    """Say where a layer begins and ends now; the scene's is the root's, and others' are of what they hold."""
    if is_root:
        if layer.HasStartTimeCode():
            layer.startTimeCode = timing.code(timing.warp.output_start)
        if layer.HasEndTimeCode():
            layer.endTimeCode = timing.end
    elif len(used) == 1:
        own = on_clock(timing, next(iter(used)))
        if layer.HasStartTimeCode():
            layer.startTimeCode = own.moment(layer.startTimeCode)
        if layer.HasEndTimeCode():
            layer.endTimeCode = own.moment(layer.endTimeCode)


def _averaged_joints(scene: Scene, timing: Timing, rate: Fraction, limits: Limits) -> dict[str, FloatArray]:
    """Average skeletons as `apply_warp` does motions, standing feet exempt.

    Returns
    -------
    dict of str to float arrays, shape (n_frames, n)
        By the paths of the attributes of skeletal animations: a row for each output frame.
    """
    found: dict[str, FloatArray] = {}
    if not timing.speeds_up:
        return found
    for one in skeletal_animations(scene.stage):
        if not one.query.JointTransformsMightBeTimeVarying():
            continue
        message = read(scene, one.path, rate, limits)
        try:
            moved = apply_warp(motion_of(message), timing.warp)
        except (InvalidMotionError, OptionError):
            # No one body, or sizes that no motion has: each attribute is averaged by itself.
            continue
        places = joint_places(one, message)
        if len(places) < len(one.query.GetJointOrder()):
            continue
        rotations = np.roll(moved.rotations[:, places], -1, axis=2)
        translations = moved.local_translations[:, places] / message.arrays["scales"][places, None]
        n_frames = len(rotations)
        found[f"{one.path}.rotations"] = rotations.reshape(n_frames, -1)
        found[f"{one.path}.translations"] = translations.reshape(n_frames, -1)
    return found


def _value(value: Any) -> Any:
    return None if isinstance(value, Sdf.ValueBlock) else value
