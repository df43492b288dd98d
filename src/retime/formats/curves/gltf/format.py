"""glTF 2.0 and GLB: read as a motion, retimed in place, or baked."""

from __future__ import annotations

import warnings
from collections.abc import Callable, Mapping
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from retime.errors import FormatError, FormatWarning
from retime.files import write_bytes
from retime.formats.curves.gltf.animation import Animation, Sampler, chosen_animations, keys_of, name_of, read_animation
from retime.formats.curves.gltf.file import GltfFile, parse_gltf
from retime.formats.curves.gltf.retime import NewKeys, with_keys
from retime.formats.curves.gltf.scene import Sampled, rate_of_keys, sample_animation
from retime.formats.curves.gltf.skin import read_skin
from retime.formats.curves.gltf.write import glb_of, gltf_of
from retime.formats.read_options import ReadOptions
from retime.motion import rotation
from retime.motion.any_motion import AnyMotion
from retime.motion.motion import Motion
from retime.motion.skin import Skin
from retime.warp.apply import apply_warp
from retime.warp.curve import Warp
from retime.warp.cutting import cut_curve

# What a key may be off by, in frames, before it is told.
_COARSE_FRAMES = 0.1


def animation_names(path: Path, data: bytes, options: ReadOptions) -> list[str]:
    """Return the names of the animations that are meant, in the file's order; raise FormatError where there is none."""
    file = parse_gltf(path, data, options.limits)
    items = file.items("animations")
    return [name_of(items[index], index) for index in chosen_animations(file, options.animation)]


def read(path: Path, data: bytes, options: ReadOptions) -> AnyMotion:
    """Sample an animation, from its first key to its last: the nodes that it moves, and those above them, are joints.

    A scene whose animation moves no node (weights of morph targets) gives a signal.

    Warns
    -----
    FormatWarning
        There are several animations, and none was chosen: the first is read.
    """
    file = parse_gltf(path, data, options.limits)
    chosen = chosen_animations(file, options.animation)
    animation = read_animation(file, chosen[0])
    if len(chosen) > 1:
        names = ", ".join(name_of(file.items("animations")[index], index) for index in chosen)
        warnings.warn(
            f"{path}: {len(chosen)} animations ({names}); {animation.name} is read, --animation chooses another",
            FormatWarning,
            stacklevel=2,
        )
    return sample_animation(file, animation, options.rate, options.limits).clip


def skin(path: Path, data: bytes, options: ReadOptions) -> Skin | None:
    """Read the meshes that follow the joints of the motion which `read` returns; None where there is none.

    Raises
    ------
    FormatError
        They are damaged or compressed.
    """
    file = parse_gltf(path, data, options.limits)
    animation = read_animation(file, chosen_animations(file, options.animation)[0])
    return read_skin(file, animation, options.limits)


def facts(path: Path, data: bytes, options: ReadOptions) -> dict[str, str]:
    """Say which animations a scene has: how long each is, what it moves and how; and what else there is."""
    file = parse_gltf(path, data, options.limits)
    said = []
    for index in chosen_animations(file, None):
        one = read_animation(file, index)
        kinds = sorted({sampler.interpolation for sampler in one.samplers})
        paths = sorted({channel.path for channel in one.channels})
        n_keys = sum(len(sampler.curve) + 1 for sampler in one.samplers)
        said.append(
            f"{one.name} ({one.end - one.start:.3f} s, {n_keys} keys, {' and '.join(kinds)}: {', '.join(paths)})"
        )
    counts = [f"{len(file.items(name))} {name}" for name in ("nodes", "meshes", "skins", "cameras")]
    return {"animations": f"{len(said)}: {', '.join(said)}", "scene": ", ".join(counts)}


def write(motion: AnyMotion, path: Path, *, overwrite: bool) -> None:
    """Write a motion as a new scene, in one file: a skeleton with one animation; raise FormatError for a signal."""
    if not isinstance(motion, Motion):
        raise FormatError("a glTF scene holds a skeleton that moves, not a signal", path=path)
    write_bytes(path, glb_of(motion) if path.suffix.lower() == ".glb" else gltf_of(motion), overwrite=overwrite)


def retime(path: Path, data: bytes, warps: Warp | Mapping[str, Warp], options: ReadOptions) -> dict[str, bytes]:
    """Give animations new timing by cutting their curves; nothing is sampled.

    Parameters
    ----------
    path : Path
        The file that `data` was read from.
    data : bytes
        Its contents.
    warps : Warp, or mapping of str to Warp
        For all animations that are meant, or by their names; time 0 of its input is the animation's first key.
    options : ReadOptions
        As it was read.

    Returns
    -------
    dict of str to bytes
        "" is the scene; other names are files beside it. ``{stem}`` in a name stands for the scene's own.
    """
    return _rewritten(path, data, warps, options, _cut)


def bake(
    path: Path, data: bytes, warps: Warp | Mapping[str, Warp], options: ReadOptions, *, average: bool
) -> dict[str, bytes]:
    """Give animations new timing by a key on every frame, as `retime` does; sped up, frames are averaged (§3.4)."""

    def baked(file: GltfFile, animation: Animation, warp: Warp) -> list[NewKeys]:
        return _baked(animation, sample_animation(file, animation, options.rate, options.limits), warp, average)

    return _rewritten(path, data, warps, options, baked)


def _rewritten(
    path: Path,
    data: bytes,
    warps: Warp | Mapping[str, Warp],
    options: ReadOptions,
    keys_of_animation: Callable[[GltfFile, Animation, Warp], list[NewKeys]],
) -> dict[str, bytes]:
    file = parse_gltf(path, data, options.limits)
    animations = [read_animation(file, index) for index in chosen_animations(file, options.animation)]
    timings = {one.name: warps for one in animations} if isinstance(warps, Warp) else warps
    animations = [one for one in animations if one.name in timings]
    keys = []
    for one in animations:
        made = keys_of_animation(file, one, timings[one.name])
        _warn_of_coarse_times(path, one, made, float(options.rate or rate_of_keys(one)))
        keys += made
    return with_keys(file, keys, animations)


def _warn_of_coarse_times(path: Path, animation: Animation, keys: list[NewKeys], rate: float) -> None:
    """Warn where keys lie so late that single precision, which glTF's times have, puts them off by what is seen."""
    latest = max(float(np.abs(one.times).max()) for one in keys)
    off = float(np.spacing(np.float32(latest))) / 2
    if off * rate > _COARSE_FRAMES:
        warnings.warn(
            f"{path}: keys of {animation.name} lie at {latest:.6g} s, where glTF's times (single precision) are up to "
            f"{off:.2g} s off ({off * rate:.2g} frames at {rate:g} Hz); in the program that made it, let the animation "
            "begin near 0",
            FormatWarning,
            stacklevel=5,
        )


def _cut(file: GltfFile, animation: Animation, warp: Warp) -> list[NewKeys]:
    start = animation.start
    moved = Warp(warp.output_times + start, warp.input_times + start)
    found = []
    for sampler in animation.samplers:
        times, values = keys_of(cut_curve(sampler.curve, moved)[0], sampler)
        found.append(NewKeys(animation.index, sampler, times, values, sampler.interpolation))
    return found


def _baked(animation: Animation, sampled: Sampled, warp: Warp, average: bool) -> list[NewKeys]:
    """Return a key for every frame: what the curve has at the warp's time, and what averaging changes of that.

    The change is that of the motion for turns and places of nodes, so that feet which stand stay, and that of the
    curve's own samples for all else. Steps stay steps.
    """
    clip, rate = sampled.clip, float(sampled.clip.rate)
    frames = np.arange(warp.count_frames(clip.rate)) / rate
    times = (animation.start + frames).astype(np.float32)
    inputs = animation.start + np.arange(clip.n_frames) / rate
    mean, plain = (apply_warp(clip, warp, average=one) if average else None for one in (True, False))
    moved = {one.sampler: one for one in reversed(animation.channels) if one.node is not None}
    found = []
    for sampler in animation.samplers:
        channel = moved.get(sampler.index)
        values: NDArray[np.float64] = sampler.curve(animation.start + warp(frames))
        kind = "STEP" if sampler.interpolation == "STEP" else "LINEAR"
        if average and kind == "LINEAR":
            if isinstance(mean, Motion) and isinstance(plain, Motion) and channel and channel.path == "rotation":
                joint = sampled.nodes.index(channel.node)
                change = rotation.multiply(rotation.conjugate(plain.rotations[:, joint]), mean.rotations[:, joint])
                turned = rotation.multiply(rotation.normalize(np.roll(values, 1, axis=1)), change)
                values = np.roll(turned, -1, axis=1)
            elif isinstance(mean, Motion) and isinstance(plain, Motion) and channel and channel.path == "translation":
                joint = sampled.nodes.index(channel.node)
                scale = sampled.scales[joint]
                change = mean.local_translations[:, joint] - plain.local_translations[:, joint]
                values = values + change / (scale if scale else 1.0)
            else:
                own = sampler.curve(inputs)
                averaged, read_off = (apply_warp(own, warp, average=one, rate=clip.rate) for one in (True, False))
                values = values + (averaged - read_off)
        found.append(NewKeys(animation.index, sampler, times, _rows(values, sampler), kind))
    return found


def _rows(values: NDArray[np.float64], sampler: Sampler) -> NDArray[np.float32]:
    return np.asarray(values, dtype=np.float32).reshape(len(values), len(sampler.curve.end_value))
