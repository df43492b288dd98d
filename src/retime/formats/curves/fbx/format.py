"""FBX 7, binary and in text: read as a motion, retimed in place, or baked."""

from __future__ import annotations

import warnings
from collections.abc import Mapping
from pathlib import Path

from retime.errors import FormatError, FormatWarning
from retime.files import write_bytes
from retime.formats.curves.fbx.bake import baked_keys
from retime.formats.curves.fbx.motion import sample_stack, time_mode
from retime.formats.curves.fbx.retime import cut_keys, retimed, warps_of
from retime.formats.curves.fbx.scene import chosen_stacks, parse_fbx
from retime.formats.curves.fbx.skin import read_skin
from retime.formats.curves.fbx.span import read_stack
from retime.formats.curves.fbx.text import TextFbx
from retime.formats.curves.fbx.write import fbx_of
from retime.formats.read_options import ReadOptions
from retime.motion.any_motion import AnyMotion
from retime.motion.motion import Motion
from retime.motion.skin import Skin
from retime.warp.curve import Warp


def animation_names(path: Path, data: bytes, options: ReadOptions) -> list[str]:
    """Return the names of the stacks that are meant, in the file's order; raise FormatError where there is none."""
    return [stack.name for stack in chosen_stacks(parse_fbx(path, data, options.limits), options.animation)]


def read(path: Path, data: bytes, options: ReadOptions) -> AnyMotion:
    """Sample a stack, from where it begins to where it ends: nodes that it moves, limbs, and those above are joints.

    A stack that moves no node (shapes, a camera's lens) gives a signal.

    Warns
    -----
    FormatWarning
        There are several animations, and none was chosen: the first is read. Or programs differ in what they make of
        the file.
    """
    scene = parse_fbx(path, data, options.limits)
    stacks = chosen_stacks(scene, options.animation)
    if len(stacks) > 1:
        names = ", ".join(stack.name for stack in stacks)
        warnings.warn(
            f"{path}: {len(stacks)} animations ({names}); {stacks[0].name} is read, --animation chooses another",
            FormatWarning,
            stacklevel=2,
        )
    return sample_stack(scene, read_stack(scene, stacks[0]), options.rate, options.limits).clip


def skin(path: Path, data: bytes, options: ReadOptions) -> Skin | None:
    """Read the meshes that follow the joints of the motion which `read` returns; None where there is none.

    Raises
    ------
    FormatError
        They are damaged.
    """
    scene = parse_fbx(path, data, options.limits)
    if not any(item.kind == "Deformer" and item.subtype == "Skin" for item in scene.items.values()):
        return None
    stack = read_stack(scene, chosen_stacks(scene, options.animation)[0])
    with warnings.catch_warnings():
        # What there is to doubt was told when the motion was read.
        warnings.simplefilter("ignore", FormatWarning)
        return read_skin(scene, sample_stack(scene, stack, options.rate, options.limits))


def facts(path: Path, data: bytes, options: ReadOptions) -> dict[str, str]:
    """Say which stacks a scene has, with their layers, curves and keys; its frame rate; and what else there is."""
    scene = parse_fbx(path, data, options.limits)
    said = []
    for stack in scene.stacks:
        layers = f"{len(stack.layers)} layers" if len(stack.layers) != 1 else "1 layer"
        if len(stack.layers) > 1:
            layers += f" ({', '.join(layer.item.name for layer in stack.layers)})"
        if not stack.curves:
            said.append(f"{stack.name} ({layers}, no curves)")
            continue
        curves = read_stack(scene, stack)
        counts = f"{layers}, {len(stack.curves)} curves, {len(curves.keys.ticks)} keys"
        said.append(f"{stack.name} ({curves.end - curves.start:.3f} s, {counts})")
    section = scene.file.section("Takes")
    takes = [one for one in section.children if one.name == "Take"] if section is not None else []
    names = [str(values[0].content) for values in map(scene.file.values, takes) if values]
    kinds = [item.kind for item in scene.items.values()]
    parts = [("Model", "models"), ("Geometry", "geometries"), ("Deformer", "deformers"), ("Material", "materials")]
    axis = "XYZ"[min(max(int(scene.setting("UpAxis", 1)), 0), 2)]
    counts = ", ".join(f"{kinds.count(kind)} {name}" for kind, name in parts)
    return {
        "stored": f"{'text' if isinstance(scene.file, TextFbx) else 'binary'}, version {scene.file.version / 1000:g}",
        "animations": f"{len(said)}: {', '.join(said)}",
        "takes": f"{len(names)}: {', '.join(names)}" if names else "none",
        "time mode": time_mode(scene),
        "scene": f"{counts}; up axis {axis}, {scene.setting('UnitScaleFactor', 1.0):g} cm a unit",
    }


def write(motion: AnyMotion, path: Path, *, overwrite: bool) -> None:
    """Write a motion as a new binary FBX: a plain skeleton with one animation; raise FormatError for a signal."""
    if not isinstance(motion, Motion):
        raise FormatError("an FBX scene holds a skeleton that moves, not a signal", path=path)
    write_bytes(path, fbx_of(motion), overwrite=overwrite)


def retime(path: Path, data: bytes, warps: Warp | Mapping[str, Warp], options: ReadOptions) -> dict[str, bytes]:
    """Give animations new timing by cutting their curves; nothing is sampled.

    Parameters
    ----------
    path : Path
        The file that `data` was read from.
    data : bytes
        Its contents.
    warps : Warp, or mapping of str to Warp
        For all animations that are meant, or by their names; time 0 of its input is where the animation's stack begins,
        or its first key, if that is earlier.
    options : ReadOptions
        As it was read.

    Returns
    -------
    dict of str to bytes
        "" is the scene.

    Warns
    -----
    FormatWarning
        Curves that were repeated beyond their keys hold there now.
    """
    scene = parse_fbx(path, data, options.limits)
    done = []
    for stack, warp in warps_of(chosen_stacks(scene, options.animation), warps):
        curves = read_stack(scene, stack)
        keys, written = cut_keys(scene, curves, warp)
        done.append((curves, warp, keys, written))
    return {"": retimed(scene, done)}


def bake(
    path: Path, data: bytes, warps: Warp | Mapping[str, Warp], options: ReadOptions, *, average: bool
) -> dict[str, bytes]:
    """Give animations new timing by a key on every frame, as `retime` does; sped up, frames are averaged (§3.4)."""
    scene = parse_fbx(path, data, options.limits)
    done = []
    for stack, warp in warps_of(chosen_stacks(scene, options.animation), warps):
        curves = read_stack(scene, stack)
        sampled = sample_stack(scene, curves, options.rate, options.limits)
        keys = baked_keys(scene, curves, sampled, warp, average=average)
        # Repeated, all that was baked would be.
        sides = ("Pre-Extrapolation", "Post-Extrapolation")
        repeated = [
            (index, side)
            for index, one in enumerate(curves.records)
            for side, how in zip(sides, (one.pre, one.post), strict=True)
            if how.mode != "C"
        ]
        done.append((curves, warp, keys, repeated))
    return {"": retimed(scene, done)}
