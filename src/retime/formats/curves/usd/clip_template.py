"""Value clips that are named by a template, made clips that are named one by one. Runs in the child (`usd.child`).

A template (``walk.###.usdc``, times from 1 to 48 by 1) stands for the files that are there, each active from its own
time on, at that time. Written out they can be given other times, and copied with the scene.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable
from typing import Any

from pxr import Gf, Sdf, Vt

from retime.errors import FormatError

_TEMPLATE = re.compile(r"([^#]*)(#+)(?:\.(#+))?([^#]*)")
_NUMBERS = ("templateStartTime", "templateEndTime", "templateStride")
_NAMES = ("templateAssetPath", "templateActiveOffset", *_NUMBERS)
# Of the files that a template may stand for.
_MOST_NAMES = 100_000


def unroll_templates(layer: Any, is_there: Callable[[str], bool]) -> bool:
    """Name a layer's value clips one by one, where a template names them.

    Parameters
    ----------
    layer : Sdf.Layer
        Changed in place.
    is_there : callable
        Tells whether a file is there, by its name as the layer would write it.

    Returns
    -------
    bool
        Whether there were any.

    Raises
    ------
    FormatError
        The template is none, names too many files, or its numbers are said by another layer.
    """
    found = False
    paths: list[Any] = []
    layer.Traverse(Sdf.Path.absoluteRootPath, paths.append)
    for path in paths:
        prim = layer.GetPrimAtPath(path) if path.IsPrimPath() or path.IsPrimVariantSelectionPath() else None
        if prim is None or prim.path != path or not prim.HasInfo("clips"):
            continue
        sets = dict(prim.GetInfo("clips"))
        for name, one in sets.items():
            if isinstance(one, dict) and "templateAssetPath" in one:
                sets[name] = _unrolled(dict(one), is_there, f"{path}, clips {name!r}")
                found = True
        prim.SetInfo("clips", sets)
    return found


def _unrolled(clips: dict[str, Any], is_there: Callable[[str], bool], where: str) -> dict[str, Any]:
    if {"assetPaths", "active", "times"} & clips.keys():
        raise FormatError(f"{where} are named by a template, and one by one as well")
    template = clips["templateAssetPath"]
    match = _TEMPLATE.fullmatch(template.path if isinstance(template, Sdf.AssetPath) else str(template))
    if match is None:
        raise FormatError(f"{where}: {str(template)[:100]!r} is no template, such as clip.###.usdc")
    start, end, stride = (_number(clips, name, where) for name in _NUMBERS)
    offset = _number(clips, "templateActiveOffset", where) if "templateActiveOffset" in clips else 0.0
    if not stride > 0 or end < start or abs(offset) > stride or (end - start) / stride > _MOST_NAMES:
        raise FormatError(f"{where}: times from {start:g} to {end:g} by {stride:g} name no clips, or too many")
    before, whole, part, after = match.groups()
    times, assets = [], []
    for number in range(math.floor((end - start) / stride + 1e-9) + 1):
        time = start + number * stride
        shown = f"{int(time):0{len(whole)}d}"
        if part is not None:
            shown += f"{abs(time) % 1:.{len(part)}f}"[1:]
        name = f"{before}{shown}{after}"
        if is_there(name):
            times.append(time)
            assets.append(name)
    written = {name: value for name, value in clips.items() if name not in _NAMES}
    if assets:
        edge = abs(offset)
        shown_at = [times[0] - edge, *times, times[-1] + edge] if edge else times
        written["assetPaths"] = Sdf.AssetPathArray([Sdf.AssetPath(name) for name in assets])
        written["active"] = Vt.Vec2dArray([Gf.Vec2d(time + offset, i) for i, time in enumerate(times)])
        written["times"] = Vt.Vec2dArray([Gf.Vec2d(time, time) for time in shown_at])
    return written


def _number(clips: dict[str, Any], name: str, where: str) -> float:
    value = clips.get(name)
    if not isinstance(value, int | float) or not abs(value) < 1e12:
        raise FormatError(f"{where} are named by a template, whose {name} is not there, or is no number")
    return float(value)
