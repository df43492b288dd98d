r"""A table of knots: output time and input time, in seconds from 0, straight lines between them.

The first line names the columns, ``output_time,input_time``; read are also ``output_frame,input_frame``, which count
frames from `Shot.start`. Numbers are written so that they come back bit for bit. The form is retime's own.
"""

from __future__ import annotations

import re

import numpy as np

from retime.errors import FormatError, OptionError
from retime.hosts.shot import MOST_KEYS, Shot, warp_of
from retime.hosts.text import decoded, number
from retime.warp.curve import Warp

_TIMES, _FRAMES = ["output_time", "input_time"], ["output_frame", "input_frame"]
_BETWEEN = re.compile(r"[,;\t]")


def write(warp: Warp, shot: Shot) -> str:
    """Write the knots."""
    rows = zip(warp.output_times.tolist(), warp.input_times.tolist(), strict=True)
    return "".join([",".join(_TIMES) + "\n", *(f"{output!r},{input_!r}\n" for output, input_ in rows)])


def read(data: bytes, shot: Shot) -> Warp:
    """Read a table of two columns; without a line of names they are seconds."""
    frames, rows, lines = _table(data)
    if shot.said and not frames:
        raise OptionError(
            f"{', '.join(shot.said)} would have no effect: the table counts seconds. Where it counts frames, name its "
            f"columns {','.join(_FRAMES)}"
        )
    outputs, inputs = np.array(rows, dtype=np.float64).reshape(-1, 2).T
    if frames:
        outputs, inputs = shot.times(outputs), shot.times(inputs)
    return warp_of(outputs, inputs, place=lambda key: {"line": lines[key]})


def _table(data: bytes) -> tuple[bool, list[list[float]], list[int]]:
    """Return whether a table counts frames, its rows, and the line of each."""
    frames, seen = False, False
    lines: list[int] = []
    rows: list[list[float]] = []
    for line, text in enumerate(decoded(data).split("\n"), start=1):
        cells = [cell.strip() for cell in _BETWEEN.split(text)]
        if cells == [""]:
            continue
        if len(cells) != 2:
            raise FormatError(
                "expected two columns, output time and input time, with a comma, semicolon or tab between and points "
                f"in numbers, found {len(cells)}",
                line=line,
            )
        if not seen and not re.match(r"[-+.\d]", cells[0]):
            seen = True
            names = [cell.strip('"').lower() for cell in cells]
            if names not in (_TIMES, _FRAMES):
                raise FormatError(
                    f"expected the columns {','.join(_TIMES)} (seconds) or {','.join(_FRAMES)}, found {cells!r:.80}; "
                    "name them so that it is certain which is which",
                    line=line,
                )
            frames = names == _FRAMES
            continue
        seen = True
        if len(rows) == MOST_KEYS:
            raise FormatError(f"more than {MOST_KEYS} keys", line=line)
        rows.append([number(cell, line) for cell in cells])
        lines.append(line)
    return frames, rows, lines
