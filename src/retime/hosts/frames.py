"""A plain list for pipelines: the input frame that each output frame shows, one a line, to the nearest whole frame.

Line 1 is the first frame of the output; frames of the input are numbered from `Shot.start`. The form is
retime's own; what was rounded off is the error that is said.
"""

from __future__ import annotations

import numpy as np

from retime.errors import FormatError
from retime.hosts.shot import Shot, warp_of
from retime.hosts.text import decoded, number
from retime.warp.curve import Warp


def write(warp: Warp, shot: Shot) -> str:
    """Write a line for each frame."""
    frames = np.rint(shot.frames(warp.input_times)).astype(np.int64)
    return "".join(f"{frame}\n" for frame in frames.tolist()[: shot.count_frames(warp)])


def read(data: bytes, shot: Shot) -> Warp:
    """Read a list; its first line is the frame at time 0."""
    rows = []
    for line, text in enumerate(decoded(data).split("\n"), start=1):
        if text.strip():
            value = number(text.strip(), line)
            if not value.is_integer():
                raise FormatError(f"expected the number of a frame, found {text.strip()[:40]}", line=line)
            rows.append(value)
    inputs = shot.times(np.array(rows, dtype=np.float64))
    return warp_of(shot.times(shot.start + np.arange(len(rows), dtype=np.float64)), inputs)
