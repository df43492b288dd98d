"""Value clips that a layer has: their times, and which is active, cut by a warp. Runs in the child (`usd.child`)."""

from __future__ import annotations

from itertools import pairwise
from typing import Any

import numpy as np
from pxr import Gf, Sdf, Vt

from retime.arrays import FloatArray
from retime.errors import FormatError
from retime.formats.curves.usd.stage import spec_paths
from retime.formats.curves.usd.timing import Timing
from retime.warp.cutting import CurveSegments, SegmentKind, cut_curve


def refuse_old_clips(layer: Any) -> None:
    """Raise FormatError where a layer has value clips in the form that came before."""
    for path in spec_paths(layer):
        prim = layer.GetPrimAtPath(path)
        for legacy in ("clipTimes", "clipActive", "clipTemplateAssetPath"):
            if prim is not None and prim.HasInfo(legacy):
                raise FormatError(f"{path} has value clips in a form that USD has given up ({legacy})")


def cut_clips(layer: Any, path: Any, timing: Timing, source: Any) -> None:
    """Give the times of a prim's value clips new timing; raise FormatError where they can't be.

    `source` is the layer as it was read: from there its clips are found.
    """
    prim = layer.GetPrimAtPath(path)
    sets = dict(prim.GetInfo("clips"))
    for name, one in sets.items():
        if not isinstance(one, dict):
            raise FormatError(f"{path} has value clips {name!r} that are no dictionary but {type(one).__name__}")
        where = f"{path}, clips {name!r}"
        _refuse_blends(dict(one), timing, source, where)
        sets[name] = _cut_clip_set(dict(one), timing, where)
    prim.SetInfo("clips", sets)


def _clip_rows(clips: dict[str, Any], name: str, where: str) -> list[tuple[float, float]]:
    """Return pairs of numbers of value clips; none where there are none."""
    found = clips.get(name)
    if found is None:
        return []
    if not isinstance(found, Vt.Vec2dArray):
        raise FormatError(f"{where}: {name} must be pairs of numbers (double2[]), and are {type(found).__name__}")
    return [(float(a), float(b)) for a, b in found]


def _refuse_blends(clips: dict[str, Any], timing: Timing, source: Any, where: str) -> None:
    """Raise FormatError where a knot of the warp lies between the last time that a clip says and the next clip.

    There USD blends from the one to the other. A knot is a time at which it asks the clip itself: the blend would be
    gone, without a word.
    """
    active, times = sorted(_clip_rows(clips, "active", where)), sorted(_clip_rows(clips, "times", where))
    assets = clips.get("assetPaths")
    if len(active) < 2 or not isinstance(assets, Sdf.AssetPathArray):
        return
    starts = np.array([at for at, _ in active])
    said: dict[int, FloatArray] = {}
    for knot in np.unique(timing.codes[1]).tolist():
        place = max(int(np.searchsorted(starts, knot + 1e-6, side="right")) - 1, 0)
        index = int(active[place][1])
        if place + 1 >= len(active) or not 0 <= index < len(assets):
            continue
        if index not in said:
            said[index] = np.array([*_sample_codes(source, assets[index].path), *(inside for _, inside in times)])
        shown, end = (
            float(np.interp(code, *np.array(times).T)) if times else code for code in (knot, starts[place + 1])
        )
        # Backward as forward: what is said on the way from here to the end, the end aside, for there the next one is.
        way = np.sign(end - shown)
        if way and not ((said[index] - shown) * way >= -1e-6)[(end - said[index]) * way > 1e-6].any():
            raise FormatError(
                f"{where}: at time code {knot:g} the warp bends, or ends, after the last time that "
                f"{assets[index].path} says before the next clip; USD blends there from one to the other, which clips' "
                "times can't say: flatten the scene first (usdcat --flatten)"
            )


def _sample_codes(source: Any, asset: str) -> list[float]:
    """Return the times of a clip's samples; none where it is not there."""
    layer = Sdf.Layer.FindOrOpenRelativeToLayer(source, asset)
    return [] if layer is None else [float(code) for code in layer.ListAllTimeSamples()]


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
