"""The animations of a glTF scene as curves, and curves as samplers again.

Source: the Khronos glTF 2.0 specification, section 3.11 and appendix C (interpolation).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from retime.arrays import FloatArray
from retime.brief import brief_repr
from retime.errors import FormatError
from retime.formats.curves.gltf.file import GltfFile
from retime.formats.number_text import count_of
from retime.warp.cutting import CurveSegments, SegmentKind

# Beyond this single precision has no room for what cutting makes of a number.
_LARGEST = 1e30
PATHS = {"translation": 3, "rotation": 4, "scale": 3}


@dataclass(frozen=True)
class Sampler:
    """One sampler of an animation.

    Attributes
    ----------
    index : int
        In its animation.
    times, values : int
        Its accessors.
    interpolation : str
        LINEAR, STEP or CUBICSPLINE.
    curve : CurveSegments
        What they say, in seconds.
    in_first, out_last : float arrays, shape (k,)
        Of a CUBICSPLINE, the tangents before its first key and after its last, which nothing reads.
    """

    index: int
    times: int
    values: int
    interpolation: str
    curve: CurveSegments
    in_first: FloatArray
    out_last: FloatArray

    __repr__ = brief_repr


@dataclass(frozen=True)
class Channel:
    """What an animation moves.

    Attributes
    ----------
    sampler : int
        Index of its sampler.
    node : int or None
        The node; None where a pointer says it.
    path : str
        translation, rotation, scale, weights, or the pointer (KHR_animation_pointer).
    """

    sampler: int
    node: int | None
    path: str


@dataclass(frozen=True)
class Animation:
    """One animation.

    Attributes
    ----------
    index : int
        In the file.
    name : str
        As the file calls it, or "animation 1" counted from 0.
    channels : list of Channel
    samplers : list of Sampler
    """

    index: int
    name: str
    channels: list[Channel]
    samplers: list[Sampler]

    @property
    def start(self) -> float:
        """Time of the first key, seconds."""
        return min((float(one.curve.times[0, 0]) if len(one.curve) else one.curve.end_time) for one in self.samplers)

    @property
    def end(self) -> float:
        """Time of the last key, seconds."""
        return max(one.curve.end_time for one in self.samplers)


def name_of(item: dict[str, Any], index: int) -> str:
    """Return an animation's name."""
    name = item.get("name")
    return name if isinstance(name, str) and name else f"animation {index}"


def read_animation(file: GltfFile, index: int) -> Animation:
    """Read one animation; raise FormatError where it has no keys, or they are none."""
    item = file.item("animations", index)
    where = f"animations[{index}]"
    channels = [_channel(file, one, f"{where}.channels[{i}]") for i, one in enumerate(_objects(file, item, "channels"))]
    turned = {one.sampler for one in channels if one.path.rsplit("/", 1)[-1] == "rotation"}
    samplers = [
        _sampler(file, one, i, i in turned, f"{where}.samplers[{i}]")
        for i, one in enumerate(_objects(file, item, "samplers"))
    ]
    for one in channels:
        if one.sampler >= len(samplers):
            raise file.error(f"{where} has {len(samplers)} samplers; a channel names number {one.sampler}")
        width = PATHS.get(one.path)
        if width and len(samplers[one.sampler].curve.end_value) != width:
            raise file.error(
                f"{where}: the {one.path} of node {one.node} has {len(samplers[one.sampler].curve.end_value)} numbers "
                f"a key, expected {width}"
            )
    if not samplers:
        raise file.error(f"{where} has no samplers")
    return Animation(index, name_of(item, index), channels, samplers)


def _objects(file: GltfFile, item: dict[str, Any], name: str) -> list[dict[str, Any]]:
    found = item.get(name)
    if not isinstance(found, list) or not all(isinstance(one, dict) for one in found):
        raise file.error(f"an animation needs {name}, a list of objects")
    return found


def _channel(file: GltfFile, item: dict[str, Any], where: str) -> Channel:
    target = item.get("target")
    if not isinstance(target, dict) or not isinstance(target.get("path"), str):
        raise file.error(f"{where} needs a target with a path")
    sampler = file.whole(item, "sampler", where)
    path = target["path"]
    if path == "pointer":
        inner: Any = target
        for name in ("extensions", "KHR_animation_pointer", "pointer"):
            inner = inner.get(name) if isinstance(inner, dict) else None
        return Channel(sampler, None, inner if isinstance(inner, str) else "pointer")
    if "node" not in target:
        return Channel(sampler, None, path)
    file.item("nodes", target["node"])
    return Channel(sampler, target["node"], path)


def _sampler(file: GltfFile, item: dict[str, Any], index: int, turned: bool, where: str) -> Sampler:
    interpolation = item.get("interpolation", "LINEAR")
    if interpolation not in ("LINEAR", "STEP", "CUBICSPLINE"):
        raise file.error(f"{where}.interpolation must be LINEAR, STEP or CUBICSPLINE; found {interpolation!r}")
    times = file.accessor(item.get("input"))
    if times.shape[1] != 1 or not len(times):
        raise file.error(f"{where}.input must hold one number a key, and a key; found shape {times.shape}")
    times = times[:, 0]
    if np.abs(times).max() > 1e7:
        raise file.error(f"{where}.input: a key at {np.abs(times).max():g} s is no time a clip can have")
    stuck = np.flatnonzero(np.diff(times) <= 0)
    if len(stuck):
        key = int(stuck[0])
        raise file.error(
            f"{where}.input: times must increase; key {key + 1} is at {times[key + 1]:g} s, after one at {times[key]:g}"
        )
    values = file.accessor(item.get("output"))
    parts = 3 if interpolation == "CUBICSPLINE" else 1
    if not values.size or values.size % (parts * len(times)):
        raise file.error(
            f"{where}: {len(times)} keys need a multiple of {parts * len(times)} values, its output has {values.size}"
        )
    if np.abs(values).max() > _LARGEST:
        raise file.error(f"{where}.output holds {np.abs(values).max():g}, which is beyond any place or weight")
    rows = values.reshape(len(times), parts, -1)
    kind = SegmentKind.STEP if interpolation == "STEP" else SegmentKind.LINEAR
    if interpolation == "LINEAR" and turned and rows.shape[2] == 4:
        kind = SegmentKind.SLERP
    nothing = np.zeros(rows.shape[2])
    if parts == 1:
        curve = CurveSegments.through(times, rows[:, 0], kind)
        return Sampler(index, item["input"], item["output"], interpolation, curve, nothing, nothing)
    curve = CurveSegments.through(times, rows[:, 1], SegmentKind.CUBIC)
    third = np.diff(times)[:, None] / 3
    curve.values[:, 1] = rows[:-1, 1] + third * rows[:-1, 2]
    curve.values[:, 2] = rows[1:, 1] - third * rows[1:, 0]
    return Sampler(index, item["input"], item["output"], interpolation, curve, rows[0, 0], rows[-1, 2])


def keys_of(curve: CurveSegments, sampler: Sampler) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
    """Return a curve's keys as a sampler's accessors hold them, rounded to single precision.

    Times that single precision can't tell apart become one key: what arrives there arrives as at the first of them,
    what leaves leaves as from the last.

    Returns
    -------
    times : float32 array, shape (n_keys,)
    values : float32 array, shape (n_keys, k), or (3 n_keys, k) for a CUBICSPLINE
    """
    if len(curve.jumps):
        # A sampler is of one kind, and none of them jumps on its own.
        raise AssertionError("a glTF curve has a jump")
    times = np.append(curve.times[:, 0], curve.end_time).astype(np.float32)
    values = np.concatenate([curve.values[:, 0], curve.end_value[None]])
    last = np.append(times[1:] > times[:-1], True)
    first = np.append(True, last[:-1])
    if sampler.interpolation != "CUBICSPLINE":
        return times[last], values[last].astype(np.float32)
    # A tangent between keys that lie all but in one place may be beyond any number: nothing reads it there.
    width = np.maximum(np.diff(curve.times[:, [0, 3]], axis=1), 1e-7)
    leaving = np.concatenate([3 * (curve.values[:, 1] - curve.values[:, 0]) / width, sampler.out_last[None]])
    arriving = np.concatenate([sampler.in_first[None], 3 * (curve.values[:, 3] - curve.values[:, 2]) / width])
    keyed = np.stack([arriving[first], values[last], leaving[last]], axis=1)
    return times[last], keyed.reshape(-1, keyed.shape[2]).astype(np.float32)


def chosen_animations(file: GltfFile, name: str | None) -> list[int]:
    """Return the indices of the animations of a name; all of them where none is given.

    A number counts from 0 where no animation is called so.

    Raises
    ------
    FormatError
        None is called so, or the file has none.
    """
    names = [name_of(item, index) for index, item in enumerate(file.items("animations"))]
    if not names:
        raise file.error("the scene has no animation")
    if name is None:
        return list(range(len(names)))
    found = [index for index, one in enumerate(names) if one == name]
    number = count_of(name)
    if not found and number is not None and number < len(names):
        found = [number]
    if not found:
        raise FormatError(f"no animation is called {name[:100]!r}; there are {', '.join(names)}", path=file.path)
    return found
