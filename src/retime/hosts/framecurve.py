r"""Framecurve, a table for many programs: at which frame of the scene which frame of the source is shown.

Two columns with a tab between: ``at_frame``, a whole number, and ``use_frame_of_source``, a decimal. The first frame is
1 by custom. Lines are drawn between rows, never splines. The format says no rate.

Source: http://framecurve.org/ ("for framecurves we explicitly never use spline interpolations") and its
specification-v1.
"""

from __future__ import annotations

import numpy as np

from retime.errors import FormatError
from retime.hosts.shot import MOST_KEYS, Shot, plain, warp_of
from retime.hosts.text import decoded, number
from retime.warp.curve import Warp

_HEAD = "# http://framecurve.org/specification-v1\n# at_frame\tuse_frame_of_source\n"


def write(warp: Warp, shot: Shot) -> str:
    """Write a row for each knot; they stand on whole frames."""
    at = np.rint(shot.frames(warp.output_times)).astype(np.int64).tolist()
    use = shot.frames(warp.input_times).tolist()
    return _HEAD + "".join(f"{frame}\t{_with_point(value)}\n" for frame, value in zip(at, use, strict=True))


def _with_point(value: float) -> str:
    text = plain(value)
    return text if "." in text else f"{text}.00000"


def read(data: bytes, shot: Shot) -> Warp:
    """Read a table; lines that begin with # say nothing."""
    lines: list[int] = []
    rows: list[list[float]] = []
    for line, text in enumerate(decoded(data).split("\n"), start=1):
        cells = text.split()
        if not cells or cells[0].startswith("#"):
            continue
        if len(cells) != 2:
            columns = "1 column" if len(cells) == 1 else f"{len(cells)} columns"
            raise FormatError(
                f"expected at_frame and use_frame_of_source with a tab between, found {columns}", line=line
            )
        if len(rows) == MOST_KEYS:
            raise FormatError(f"more than {MOST_KEYS} keys", line=line)
        rows.append([number(cell, line) for cell in cells])
        lines.append(line)
    at, use = np.array(rows, dtype=np.float64).reshape(-1, 2).T
    return warp_of(shot.times(at), shot.times(use), place=lambda key: {"line": lines[key]})
