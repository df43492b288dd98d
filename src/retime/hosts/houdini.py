"""Houdini: a channel for the second input of a Warp CHOP, whose method is Index.

A ``.chan`` file has a line a sample; here one channel, the time of the input in seconds, a sample an output frame. It
says neither rate nor start: the File CHOP that reads it does. With its units in seconds, "a Warp Curve value of 2
gets the Pre-Warp Channels' values at time 2 seconds"; Stretch Indices must be off.

Source: SideFX, Warp channel node (https://www.sidefx.com/docs/houdini/nodes/chop/warp.html), and the same words in
https://derivative.ca/UserGuide/Warp_CHOP.
"""

from __future__ import annotations

import numpy as np

from retime.hosts.shot import Shot, plain_rows, warp_of
from retime.hosts.text import decoded, number
from retime.warp.curve import Warp


def write(warp: Warp, shot: Shot) -> str:
    """Write a line for each frame."""
    return "".join(f"{value}\n" for value in plain_rows(warp.input_times)[: shot.count_frames(warp)])


def read(data: bytes, shot: Shot) -> Warp:
    """Read a channel; its first line is time 0."""
    values = [number(line.strip(), n) for n, line in enumerate(decoded(data).split("\n"), start=1) if line.strip()]
    return warp_of(shot.times(shot.start + np.arange(len(values), dtype=np.float64)), values)
