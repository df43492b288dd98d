"""New timing for a USD scene: its time samples cut by a warp, or a layer over it. Runs in the child (`usd.child`).

A time sample is a key: between two of them USD goes straight (rotations along the shortest arc), or holds, where a
type knows no between. So what is cut is one curve for each attribute, of the time that it shows; a value is then that
of a sample, to the bit, or what USD itself finds between two.
"""

from __future__ import annotations

import os
import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from fractions import Fraction
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
from pxr import Gf, Sdf, Usd, Vt

from retime.arrays import FloatArray
from retime.brief import brief_repr
from retime.errors import FormatError, InvalidMotionError, OptionError
from retime.formats.curves.usd.animation import (
    Span,
    as_row,
    joint_places,
    read,
    sampled_attributes,
    skeletal_animations,
    span_of,
)
from retime.formats.curves.usd.format import motion_of
from retime.formats.curves.usd.layers import (
    ASSETS,
    TIMECODES,
    Clock,
    Clocks,
    Moves,
    layers_of,
    named_over,
    package_of,
    prims_with_clips,
    timecode_specs,
    told,
    unshown,
)
from retime.formats.curves.usd.package import packed, unpacked
from retime.formats.curves.usd.splines import cut_spline
from retime.formats.curves.usd.stage import Scene, naming, sampled_specs, spec_paths
from retime.formats.curves.usd.text import spliced_samples
from retime.formats.read_options import Limits
from retime.motion.signal import Signal
from retime.warp.apply import apply_warp
from retime.warp.curve import Warp, output_frame_times
from retime.warp.cutting import CurveSegments, SegmentKind, cut_curve
from retime.warp.moments import output_moments

# Types that USD goes through between two samples; all others it holds.
_BETWEEN = re.compile(r"float|(Vec[234][hfd]|Matrix[234][fd]|Quat[hfd]|Half|Float|Double|TimeCode)(Array)?")
_QUATERNION = re.compile(r"Quat[hfd](Array)?")
# Time codes before a jump at which the value that it leaves is said once more.
_JUST_BEFORE = 1e-8
# Beyond this, a time says that there is none (an end that is never).
_MOST_SECONDS = 1e9
# Not for a layer over a scene: what names or orders its own content, or tells of it.
_NOT_CARRIED = ("subLayers", "subLayerOffsets", "primOrder", "layerRelocates", "comment", "documentation", "owner")

Samples = list[tuple[float, Any]]


@dataclass(frozen=True)
class Track:
    """The time samples of one attribute.

    Attributes
    ----------
    codes : float array, shape (n,)
        Where they lie, time codes.
    values : list
        What they are; None where the value is blocked.
    at : function
        What USD finds at a time code.
    """

    codes: FloatArray
    values: list[Any]
    at: Callable[[float], Any]

    __repr__ = brief_repr

    def sample_at(self, code: float) -> int | None:
        """Find the sample at a time code; of two that a jump has put side by side, the nearer one."""
        place, n = int(np.searchsorted(self.codes, code)), len(self.codes)
        nearest = min((place, place - 1), key=lambda one: abs(self.codes[one] - code) if 0 <= one < n else np.inf)
        return nearest if abs(self.codes[nearest] - code) <= 1e-9 * max(1.0, abs(code)) else None

    def shown(self, code: float) -> Any:
        """Return the value at a time code; that of a sample as it is."""
        place = self.sample_at(code)
        return self.at(code) if place is None else self.values[place]

    def differs(self, a: float, b: float) -> bool:
        """Tell whether two time codes are far apart, or so near as a jump puts two samples, and are these."""
        places = self.sample_at(a), self.sample_at(b)
        return abs(a - b) > _JUST_BEFORE or (None not in places and places[0] != places[1])


@dataclass(frozen=True)
class Timing:
    """A warp on a scene's clock.

    Attributes
    ----------
    warp : Warp
        Seconds from the scene's start.
    span : Span
        The scene's clock.
    linear : bool
        Whether the scene's values are interpolated, not held.
    """

    warp: Warp
    span: Span
    linear: bool

    def seconds(self, codes: FloatArray) -> FloatArray:
        """From time codes of the scene to seconds from its start."""
        return (codes - self.span.start) / self.span.per_second

    def code(self, seconds: float) -> float:
        """Make the reverse, without the digits that are rounding."""
        code = self.span.start + float(seconds) * self.span.per_second
        return round(code, 9) if abs(code) < 1e6 else float(f"{code:.15g}")

    @property
    def codes(self) -> tuple[FloatArray, FloatArray]:
        """The warp's knots as time codes: where they are put, and what is shown there."""
        outs = np.array([self.code(one) for one in self.warp.output_times])
        return outs, np.array([self.code(one) for one in self.warp.input_times])

    @property
    def end(self) -> float:
        """The new endTimeCode."""
        return self.code(self.warp.output_end)

    def moment(self, code: float) -> float:
        """Return the time code at which what was there at one is first shown."""
        if not abs(code - self.span.start) / self.span.per_second < _MOST_SECONDS:
            return code
        return self.code(float(output_moments(self.warp, self.seconds(np.array([code])))[0]))

    def moved(self, value: Any) -> Any:
        """Return what a value is with the new timing: one that says a time says another, any other is as it was."""
        if isinstance(value, Sdf.TimeCode):
            return Sdf.TimeCode(self.moment(float(value)))
        if isinstance(value, Sdf.TimeCodeArray):
            return Sdf.TimeCodeArray([self.moment(float(one)) for one in value])
        return value

    def cut(self, codes: FloatArray, straight: list[bool]) -> CurveSegments:
        """Cut the curve of the time that is shown; seconds. Where not straight, it stays at a sample."""
        times = self.seconds(codes)
        curve = CurveSegments.through(times, times[:, None], SegmentKind.LINEAR)
        held = ~np.array(straight, dtype=bool)
        curve.kinds[held] = SegmentKind.STEP
        curve.values[held] = curve.values[held, :1]
        return cut_curve(curve, self.warp)[0]

    def retimed(self, track: Track) -> Samples:
        """Return the samples that show a track with the new timing."""
        kinds = [self.goes_between(a, b) for a, b in pairwise(track.values)]
        curve = self.cut(track.codes, kinds)
        nexts = np.append(curve.values[1:, 0, 0], curve.end_value[0])
        found: dict[float, Any] = {}
        for i in range(len(curve)):
            start, end = self.code(curve.times[i, 0]), self.code(curve.times[i, 3])
            first = track.shown(self.code(curve.values[i, 0, 0]))
            if start == end:
                # A jump that was said by two samples, and they are one now: again two.
                found[_before(end, by=_JUST_BEFORE)] = first
                continue
            found[start] = first
            held = curve.kinds[i] == SegmentKind.STEP
            last = first if held else track.shown(self.code(curve.values[i, 3, 0]))
            jumps = track.differs(self.code(curve.values[i, 3, 0]), self.code(nexts[i]))
            # What held on is held until the jump anyway, where USD doesn't go from here to there.
            if jumps and not (held and not self.goes_between(last, track.shown(self.code(nexts[i])))):
                found[max(_before(end, by=_JUST_BEFORE), float(np.nextafter(start, end)))] = last
        found[self.code(curve.end_time)] = track.shown(self.code(curve.end_value[0]))
        return sorted(found.items())

    def goes_between(self, a: Any, b: Any) -> bool:
        """Tell whether USD goes from one value to another, rather than to hold the first."""
        if not self.linear or type(a) is not type(b) or not _BETWEEN.fullmatch(type(a).__name__):
            return False
        return not type(a).__name__.endswith("Array") or len(a) == len(b)

    def baked(
        self, track: Track, rate: Fraction, average: bool, limits: Limits, means: FloatArray | None = None
    ) -> Samples:
        """Return a sample for every output frame; averages over a few frames where sped up.

        `means` are these, a row each, where they are known.
        """
        times = output_frame_times(self.warp, float(rate))
        outs = [self.code(time) for time in times]
        plain = [track.shown(self.code(time)) for time in self.warp(times)]
        if average and self.linear and self.speeds_up:
            means = self._means(track, rate, limits) if means is None else means
            sizes = {None if value is None else np.size(np.array(value)) for value in plain}
            if means is not None and means.shape[0] == len(plain) and sizes == {means.shape[1]}:
                plain = [_typed(row, value) for row, value in zip(means, plain, strict=True)]
        return list(zip(outs, plain, strict=True))

    @property
    def speeds_up(self) -> bool:
        """Whether anything is faster than life."""
        return float(np.abs(self.warp.slopes).max()) > 1

    def _means(self, track: Track, rate: Fraction, limits: Limits) -> FloatArray | None:
        """Average a track; None where its values are no numbers that can be."""
        length = (self.span.end - self.span.start) / self.span.per_second
        n_frames = int(np.ceil(float(rate) * length - 1e-3)) + 1
        if not all(self.goes_between(a, b) for a, b in pairwise(track.values)):
            return None
        values = [track.shown(self.code(frame / float(rate))) for frame in range(n_frames)]
        make = as_row(values[0])
        if make is None or n_frames * len(make(values[0])) * 16 > limits.inflated_bytes:
            return None
        rows = np.stack([make(value) for value in values])
        if not rows.size or not np.isfinite(rows).all():
            return None
        if not _QUATERNION.fullmatch(type(values[0]).__name__):
            return apply_warp(rows, self.warp, average=True, rate=rate)
        names = [f"q{i // 4}.{'xyzw'[i % 4]}" for i in range(rows.shape[1])]
        if (np.linalg.norm(rows.reshape(-1, 4), axis=1) < 1e-6).any():
            return None
        signal = Signal(tuple(names), rows, rate=rate, kinds=["quaternion"] * len(names))
        return apply_warp(signal, self.warp, average=True).values


def _typed(row: FloatArray, like: Any) -> Any:
    """Make a value of a type of numbers, laid out as `as_row` does."""
    kind = type(like)
    if isinstance(like, float):
        return float(row[0])
    if kind.__name__.endswith("Array"):
        old = np.array(like)
        return kind.FromNumpy(row.reshape(old.shape).astype(old.dtype))
    numbers = [float(number) for number in row]
    if hasattr(like, "GetImaginary"):
        return kind(numbers[3], *numbers[:3])
    return kind(*numbers)


def timing_of(scene: Scene, warp: Warp) -> Timing:
    """Lay a warp on a scene's clock."""
    return Timing(warp, span_of(scene), True)


def _copy(layer: Any) -> Any:
    copy = Sdf.Layer.CreateAnonymous(".usda")
    copy.TransferContent(layer)
    return copy


def _set_samples(layer: Any, path: Any, samples: Samples) -> None:
    spec = layer.GetAttributeAtPath(path)
    spec.ClearInfo("timeSamples")
    for code, value in samples:
        layer.SetTimeSample(path, code, Sdf.ValueBlock() if value is None else value)


@dataclass(frozen=True)
class Rewritten:
    """A scene made anew.

    Attributes
    ----------
    files : dict of str to bytes
        "" is the root; other names are of layers beside it.
    left : list of str
        What has time samples that stayed as they were, as no prim of the scene shows them.
    """

    files: dict[str, bytes]
    left: list[str]

    __repr__ = brief_repr


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
            files[member] = _layer_file(files[member], layer, copy, work, {})
        return Rewritten({"": packed(files)}, left)
    moves = Moves(scene, home, name)
    for layer, _ in changed[1:]:
        moves.put(layer)
    changed += [(layer, _copy(layer)) for layer in moves.needed(layers)]
    made: dict[str, bytes] = {}
    packages: dict[str, dict[str, bytes]] = {}
    for layer, copy in changed:
        file, inner = package_of(layer)
        new = "" if layer == scene.layer else moves.put(layer)
        if not inner:
            before = scene.text if layer == scene.layer else Path(file).read_bytes()
            made[new] = _layer_file(before, layer, copy, work, moves.apply(layer, copy))
            continue
        if file not in packages:
            packages[file] = unpacked(Path(file).read_bytes(), limits)
        members = packages[file]
        if inner not in members:
            raise FormatError(f"{told(layer, scene)} has time samples, in a package that is within another")
        members[inner] = _layer_file(members[inner], layer, copy, work, {})
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


def _on(timing: Timing, clock: Clock) -> Timing:
    """Lay a timing on the clock of a layer."""
    span, (offset, scale) = timing.span, clock
    start, end = (span.start - offset) / scale, (span.end - offset) / scale
    return replace(timing, span=Span(start, end, span.per_second / scale, span.keys))


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
    layer = _copy(source)
    left: list[Any] = []
    used: set[Clock] = set()

    def timing_at(path: Any) -> Timing | None:
        clock = clocks.of(source, path.GetPrimOrPrimVariantSelectionPath())
        if clock is None:
            left.append(path)
            return None
        used.add(clock)
        return _on(timing, clock)

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
        _set_samples(scratch, copied, list(zip(codes.tolist(), values, strict=True)))
        attribute = stage.GetAttributeAtPath(copied)
        track = Track(codes, values, lambda code, one=attribute: one.Get(code))  # type: ignore[misc]
        if way is None:
            samples = own.retimed(track)
        else:
            shown = clocks.prim_of(source, path.GetPrimOrPrimVariantSelectionPath())
            means = way.joints.get(f"{shown}.{spec.name}")
            samples = own.baked(track, way.rate, way.average, way.limits, means)
        _set_samples(layer, path, [(code, own.moved(value)) for code, value in samples])
        del scratch.rootPrims[prim.name]
    for spec in timecode_specs(layer):
        own = timing_at(spec.path)
        if own is not None:
            spec.default = own.moved(spec.default)
    for path in prims_with_clips(layer):
        own = timing_at(path)
        if own is not None:
            cut_clips(layer, path, own)
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
        own = _on(timing, next(iter(used)))
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


def _layer_file(before: bytes, source: Any, layer: Any, work: Path, assets: Mapping[str, str]) -> bytes:
    """Write a layer as the file was that it comes from: text, or crate; `assets` are names of files that changed."""
    if before.startswith(b"#usda"):
        return spliced_samples(before, source.ExportToString(), layer, assets)
    return layer_bytes(layer, work, text=False)


def layer_bytes(layer: Any, work: Path, *, text: bool) -> bytes:
    """Return a layer's file."""
    if text:
        written: str = layer.ExportToString()
        return written.encode("utf-8", "surrogateescape")
    place = work / "written.usdc"
    if not layer.Export(str(place)):
        raise FormatError("USD could not write the layer")
    return place.read_bytes()


def refuse_old_clips(layer: Any) -> None:
    """Raise FormatError where a layer has value clips in the form that came before."""
    for path in spec_paths(layer):
        prim = layer.GetPrimAtPath(path)
        for legacy in ("clipTimes", "clipActive", "clipTemplateAssetPath"):
            if prim is not None and prim.HasInfo(legacy):
                raise FormatError(f"{path} has value clips in a form that USD has given up ({legacy})")


def cut_clips(layer: Any, path: Any, timing: Timing) -> None:
    """Give the times of a prim's value clips new timing; raise FormatError where they can't be."""
    prim = layer.GetPrimAtPath(path)
    sets = dict(prim.GetInfo("clips"))
    for name, one in sets.items():
        if not isinstance(one, dict):
            raise FormatError(f"{path} has value clips {name!r} that are no dictionary but {type(one).__name__}")
        sets[name] = _cut_clip_set(dict(one), timing, f"{path}, clips {name!r}")
    prim.SetInfo("clips", sets)


def _clip_rows(clips: dict[str, Any], name: str, where: str) -> list[tuple[float, float]]:
    """Return pairs of numbers of value clips; none where there are none."""
    found = clips.get(name)
    if found is None:
        return []
    if not isinstance(found, Vt.Vec2dArray):
        raise FormatError(f"{where}: {name} must be pairs of numbers (double2[]), and are {type(found).__name__}")
    return [(float(a), float(b)) for a, b in found]


def _cut_clip_set(clips: dict[str, Any], timing: Timing, where: str) -> dict[str, Any]:
    _, ins = timing.codes
    times = _clip_rows(clips, "times", where) or list(zip(ins.tolist(), ins.tolist(), strict=True))
    times = sorted(dict.fromkeys(times), key=lambda row: row[0])
    numbers = [number for row in times for number in row]
    if not np.isfinite(numbers).all() or np.abs(numbers).max(initial=0.0) / timing.span.per_second > 1e7:
        raise FormatError(f"{where}: a time that is none")
    stage_times = [a for a, _ in times]
    if any(a == b for a, b in pairwise(stage_times)):
        raise FormatError(f"{where} jump in time: such clips can't be cut; write a layer over the scene (--layer over)")
    if len(times) > 1:
        shown = timing.seconds(np.array(stage_times))
        curve = CurveSegments.through(shown, np.array([[b] for _, b in times]), SegmentKind.LINEAR)
        cut = cut_curve(curve, timing.warp)[0]
        rows = [(timing.code(cut.times[i, 0]), round(float(cut.values[i, 0, 0]), 9)) for i in range(len(cut))]
        rows.append((timing.code(cut.end_time), round(float(cut.end_value[0]), 9)))
        clips["times"] = Vt.Vec2dArray([Gf.Vec2d(*row) for row in dict.fromkeys(rows)])
    active = _clip_rows(clips, "active", where)
    if len(active) > 1:
        shown = timing.seconds(np.array(sorted(a for a, _ in active)))
        order = np.array([[b] for _, b in sorted(active)])
        # Before its first entry, the first is active; after the last the last.
        cut = cut_curve(CurveSegments.through(shown, order, SegmentKind.STEP), timing.warp)[0]
        rows = [(timing.code(cut.times[i, 0]), float(cut.values[i, 0, 0])) for i in range(len(cut))]
        rows.append((timing.code(cut.end_time), float(cut.end_value[0])))
        clips["active"] = Vt.Vec2dArray([Gf.Vec2d(*row) for row in dict(rows).items()])
    return clips


def layer_over(scene: Scene, warp: Warp, asset: str, kind: str, work: Path, *, text: bool) -> Rewritten:
    """Make a layer that shows a scene, which is not touched, with new timing.

    Parameters
    ----------
    scene : Scene
        The scene.
    warp : Warp
        Seconds from its start.
    asset : str
        How the new layer names the scene's file.
    kind : "clips" or "over"
        By value clips, whose times are the warp; or with new samples for each attribute.
    work : Path
        A folder of this process's own.
    text : bool
        Text, or crate.
    """
    timing = timing_of(scene, warp)
    clocks = Clocks(scene.stage)
    layer = Sdf.Layer.CreateAnonymous(".usda")
    root = scene.layer.pseudoRoot
    for key in root.ListInfoKeys():
        if key not in _NOT_CARRIED:
            layer.pseudoRoot.SetInfo(key, root.GetInfo(key))
    layer.timeCodesPerSecond = timing.span.per_second
    layer.startTimeCode, layer.endTimeCode = timing.code(warp.output_start), timing.end
    attributes = sampled_attributes(scene.stage)
    if kind == "over":
        _add_samples(scene, layer, timing, asset, attributes)
        layer.subLayerPaths.append(asset)
    else:
        _add_clips(scene, layer, timing, asset, attributes)
    _add_timecodes(scene, layer, timing)
    return Rewritten({"": layer_bytes(layer, work, text=text)}, unshown(scene, clocks, []))


def _add_timecodes(scene: Scene, layer: Any, timing: Timing) -> None:
    """Write times over times: of attributes that have one value, and say when something is."""
    for prim in Usd.PrimRange.Stage(scene.stage, Usd.TraverseInstanceProxies(Usd.PrimAllPrimsPredicate)):
        for attribute in prim.GetAuthoredAttributes():
            if attribute.GetTypeName() not in TIMECODES or attribute.GetNumTimeSamples() > 1:
                continue
            value = attribute.Get()
            new = timing.moved(value)
            if value is None or new == value:
                continue
            if prim.IsInstanceProxy():
                raise FormatError(f"{attribute.GetPath()} is part of an instance, which no layer can write over")
            _spec_over(layer, attribute).default = new


def _spec_over(layer: Any, attribute: Any) -> Any:
    """Make what writes over an attribute."""
    prim = Sdf.CreatePrimInLayer(layer, attribute.GetPrim().GetPath())
    spec = Sdf.AttributeSpec(prim, attribute.GetName(), attribute.GetTypeName())
    spec.custom = attribute.IsCustom()
    return spec


def _add_samples(
    scene: Scene, layer: Any, timing: Timing, asset: str, attributes: list[tuple[Any, FloatArray]]
) -> None:
    for attribute, codes in attributes:
        path, prim = attribute.GetPath(), attribute.GetPrim()
        if prim.IsInstanceProxy():
            raise FormatError(f"{path} is part of an instance, which no layer can write over")
        source = attribute.GetResolveInfo(Usd.TimeCode(float(codes[0]))).GetSource()
        if source == Usd.ResolveInfoSourceValueClips:
            raise FormatError(f"{path} comes from value clips: retime the file in place, which cuts their times")
        spec = _spec_over(layer, attribute)
        if attribute.HasSpline():
            spec.SetSpline(cut_spline(attribute.GetSpline(), timing.warp, timing.span, str(path)))
            continue
        with naming(path, attribute.GetTypeName()):
            values = [attribute.Get(code) for code in codes.tolist()]
        track = Track(codes, values, lambda code, one=attribute: one.Get(code))  # type: ignore[misc]
        samples = [(code, timing.moved(value)) for code, value in timing.retimed(track)]
        if attribute.GetTypeName() in ASSETS:
            said_in = attribute.GetPropertyStack(Usd.TimeCode(float(codes[0])))[0].layer
            samples = [(code, named_over(scene, asset, said_in, value)) for code, value in samples]
        _set_samples(layer, path, samples)


def _add_clips(scene: Scene, layer: Any, timing: Timing, asset: str, attributes: list[tuple[Any, FloatArray]]) -> None:
    moving = set()
    for attribute, _ in attributes:
        path = attribute.GetPath()
        if attribute.HasSpline() or scene.layer.GetNumTimeSamplesForPath(path) < 2:
            raise FormatError(
                f"the samples of {path} are not in the file itself, or are a spline, which value clips don't show: "
                "write a layer over the scene (--layer over)"
            )
        if attribute.GetTypeName() in TIMECODES:
            raise FormatError(f"{path} says times, which value clips don't move: write a layer over (--layer over)")
        moving.add(path.GetPrefixes()[0].name)
    _refuse_ties(scene.stage)
    times = _clip_times(timing, _held_codes(timing, attributes))
    for prim in scene.layer.rootPrims:
        spec = Sdf.PrimSpec(layer, prim.name, prim.specifier)
        spec.referenceList.Prepend(Sdf.Reference(asset, prim.path))
        if prim.name in moving:
            spec.SetInfo(
                "clips",
                {
                    "default": {
                        "active": Vt.Vec2dArray([Gf.Vec2d(times[0][0], 0.0)]),
                        "assetPaths": Sdf.AssetPathArray([Sdf.AssetPath(asset)]),
                        "primPath": prim.path.pathString,
                        "times": Vt.Vec2dArray([Gf.Vec2d(*row) for row in times]),
                    }
                },
            )


def _held_codes(timing: Timing, attributes: list[tuple[Any, FloatArray]]) -> FloatArray:
    """Find the time codes at which a value steps: samples that one held before them goes on to."""
    found: set[float] = set()
    for attribute, codes in attributes:
        values = [attribute.Get(code) for code in codes.tolist()]
        found |= {
            code
            for code, (a, b) in zip(codes[1:].tolist(), pairwise(values), strict=True)
            if not timing.goes_between(a, b)
        }
    return np.array(sorted(found))


def _clip_times(timing: Timing, held: FloatArray) -> list[tuple[float, float]]:
    """Make a warp the times of value clips: pairs of a scene's time code and the clip's; two at one time are a jump.

    Where a value steps, the pair says its code to the bit: what USD computes may fall short of it, and show the value
    before. Backward, USD would hold each value from its own sample on; a jump to just before it says what was held.
    """
    outs, ins = timing.codes
    for place in range(len(ins) if len(held) else 0):
        near = held[np.abs(held - ins[place]).argmin()]
        if abs(near - ins[place]) < 1e-6:
            ins[place] = near
    times: list[tuple[float, float]] = []
    for i in range(len(outs) - 1):
        (o, p), (a, b) = outs[i : i + 2].tolist(), ins[i : i + 2].tolist()
        times.append((o, a))
        if o == p:
            continue
        passed = held[(held > min(a, b)) & (held < max(a, b))]
        if a > b:
            if len(held) and (held == a).any():
                times.append((o, _before(a, by=1e-7)))
            passed = passed[::-1]
        for code in passed.tolist():
            out = o + (code - a) / (b - a) * (p - o)
            times.append((out, code))
            if a > b:
                times.append((out, _before(code, by=1e-7)))
    times.append((float(outs[-1]), float(ins[-1])))
    # Of more than two at one time the first is what is come from, and the last what is gone on from.
    return [
        row
        for i, row in enumerate(times)
        if not (0 < i < len(times) - 1 and times[i - 1][0] == row[0] == times[i + 1][0])
    ]


def _before(code: float, *, by: float) -> float:
    return min(code - by, float(np.nextafter(code, -np.inf)))


def _refuse_ties(stage: Any) -> None:
    """Refuse root prims that point at each other: a reference to one doesn't take the other along."""
    for prim in stage.Traverse():
        root = prim.GetPath().GetPrefixes()[0]
        targets = [target for one in prim.GetRelationships() for target in one.GetTargets()]
        targets += [target for one in prim.GetAttributes() for target in one.GetConnections()]
        for target in targets:
            if target.GetPrefixes()[0] != root:
                raise FormatError(
                    f"{prim.GetPath()} points at {target}, which a reference to {root} doesn't take along: write a "
                    "layer over the scene (--layer over)"
                )
