"""A layer that shows a USD scene, itself untouched, with new timing. Runs in the child (`usd.child`)."""

from __future__ import annotations

from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
from pxr import Gf, Sdf, Usd, Vt

from retime.arrays import FloatArray
from retime.errors import FormatError
from retime.formats.curves.usd.animation import sampled_attributes
from retime.formats.curves.usd.layer_files import Rewritten, layer_bytes, set_samples
from retime.formats.curves.usd.layers import ASSETS, TIMECODES, Clocks, named_over, unshown
from retime.formats.curves.usd.splines import cut_spline
from retime.formats.curves.usd.stage import Scene, naming
from retime.formats.curves.usd.timing import Timing, Track, just_before, timing_of
from retime.warp.curve import Warp

# Not for a layer over a scene: what names or orders its own content, or tells of it.
_NOT_CARRIED = ("subLayers", "subLayerOffsets", "primOrder", "layerRelocates", "comment", "documentation", "owner")


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
        set_samples(layer, path, samples)


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
                times.append((o, just_before(a, by=1e-7)))
            passed = passed[::-1]
        for code in passed.tolist():
            out = o + (code - a) / (b - a) * (p - o)
            times.append((out, code))
            if a > b:
                times.append((out, just_before(code, by=1e-7)))
    times.append((float(outs[-1]), float(ins[-1])))
    # Of more than two at one time the first is what is come from, and the last what is gone on from.
    return [
        row
        for i, row in enumerate(times)
        if not (0 < i < len(times) - 1 and times[i - 1][0] == row[0] == times[i + 1][0])
    ]


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
