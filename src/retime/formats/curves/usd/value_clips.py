"""Value clips that a layer has: their times, and which is active, cut by a warp. Runs in the child (`usd.child`)."""

from __future__ import annotations

from itertools import pairwise
from typing import Any

import numpy as np
from pxr import Gf, Vt

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
