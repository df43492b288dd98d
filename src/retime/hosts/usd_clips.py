"""OpenUSD: a layer that plays the animation of another by value clips.

``times`` are pairs of stage time and clip time, with lines between: a warp, to the letter, holds and reverse included.
The layer refers to the prim of the other layer, which stays as it is, and takes its time samples by the clip. Times are
codes, here frames from `Shot.start`: the other layer's ``timeCodesPerSecond`` must be the rate, as clip times are not
scaled.

Source: OpenUSD, "Sequencable, Re-timable Animated Value Clips"
(https://openusd.org/release/api/_usd__page__value_clips.html).
"""

from __future__ import annotations

import re

import numpy as np

from retime.errors import FormatError, OptionError
from retime.hosts.shot import Shot, plain, plain_rows, warp_of
from retime.hosts.text import decoded, number
from retime.warp.curve import Warp

_ITEM = re.compile(r"@?([^@<>\"\\]+?)@?<(/[A-Za-z_]\w*(?:/[A-Za-z_]\w*)*)>")
_TIMES = re.compile(r"^\s*double2\[\] times = \[([^\]]*)\]$", re.MULTILINE)
_PAIR = re.compile(r"\(\s*([^\s,()]+)\s*,\s*([^\s,()]+)\s*\)")


def write(warp: Warp, shot: Shot) -> str:
    """Write the layer, as text."""
    match = _ITEM.fullmatch(shot.item)
    if match is None:
        raise OptionError(f"--item {shot.item}: expected a layer and a prim in it, such as walk.usd</World/Char>")
    asset, prim = match.groups()
    name = prim.rsplit("/", 1)[1]
    rate = float(shot.exact_rate)
    at, use = plain_rows(shot.frames(warp.output_times)), plain_rows(shot.frames(warp.input_times))
    times = ", ".join(f"({a}, {b})" for a, b in zip(at, use, strict=True))
    return (
        "#usda 1.0\n(\n"
        f'    defaultPrim = "{name}"\n'
        f"    startTimeCode = {at[0]}\n    endTimeCode = {at[-1]}\n"
        f"    timeCodesPerSecond = {plain(rate)}\n    framesPerSecond = {plain(rate)}\n)\n\n"
        f'def "{name}" (\n'
        f"    prepend references = @{asset}@<{prim}>\n"
        "    clips = {\n        dictionary retime = {\n"
        f"            double2[] active = [({at[0]}, 0)]\n"
        f"            asset[] assetPaths = [@{asset}@]\n"
        f'            string primPath = "{prim}"\n'
        f"            double2[] times = [{times}]\n"
        "        }\n    }\n)\n{\n}\n"
    )


def read(data: bytes, shot: Shot) -> Warp:
    """Read the times of a layer that `write` made, to compare them."""
    match = _TIMES.search(decoded(data))
    if match is None:
        raise FormatError("expected a layer that retime wrote, with the times of a value clip")
    pairs = np.array([[number(a), number(b)] for a, b in _PAIR.findall(match[1])]).reshape(-1, 2)
    return warp_of(shot.times(pairs[:, 0]), shot.times(pairs[:, 1]))
