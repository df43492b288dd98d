"""What moves in a video, as a signal: so that a warp is found from footage alone.

Between two frames the motion of the picture is found by optical flow, at a small size, and averaged in the cells of a
coarse grid, edges counting most (where there are none nothing is known to move). A search compares places and how they
change, not speeds, so the flow of each cell is summed up over time, and forgotten again within a second, or it would
drift. Beside it stands how edges lie in larger cells: histograms of the directions of gradients, which say what the
picture looks like, as a pose does. Both blocks weigh the same.
"""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction
from os import PathLike
from pathlib import Path
from typing import Any

import numpy as np

from retime.arrays import FloatArray
from retime.checks import path_of
from retime.errors import FormatError
from retime.files import resolved
from retime.media.extras import needed, refuse_without
from retime.media.kinds import is_sound
from retime.media.process import check_media, run
from retime.motion.rate import parse_rate, usual_rate
from retime.motion.signal import Signal

# The picture in which motion is looked for, and its cells, across and down; of a tall one the other way round.
_LONG = 192
_CELLS, _LARGE_CELLS = (8, 6), (4, 3)
_DIRECTIONS = 8
# Seconds after which summed flow is forgotten (to 1/e).
_FORGET = 1.0


def video_signal(path: str | PathLike[str], *, fps: Fraction | str | float | None = None) -> Signal:
    """Find what moves in a video, frame by frame.

    Parameters
    ----------
    path : path-like
        The video, or numbered pictures.
    fps : Fraction, str or float, optional
        Frames a second, in place of what the file says.

    Returns
    -------
    Signal
        ``flow x 3 2`` and ``flow y 3 2``: how far what is in a cell of the grid has moved of late, in heights of the
        picture; ``edges 1 0 5``: how many edges of a direction a cell has. All are scaled so that they compare: search
        with ``features=PoseOptions(scale_signals=False)``. A frame for each of the video; of a variable rate, as many
        a second as usual.

    Raises
    ------
    FormatError, OSError, MissingExtraError
        As of `retime.media.apply.retime_media`; or the file has no video, or one frame.
    """
    path = path_of(path, "video_signal(path)")
    refuse_without("av", "cv2")
    if is_sound(path):
        raise FormatError("sound alone: a warp is found from what a video shows", path=path)
    check_media(path)
    request = {"do": "features", "path": str(resolved(path)), "fps": None if fps is None else str(parse_rate(fps))}
    told: dict[str, Any] = {}
    rows: list[list[float]] = []

    def take(fact: dict[str, Any]) -> None:
        if "rows" in fact:
            rows.extend(fact["rows"])
        elif "names" in fact:
            told.update(fact)

    run(request, path, take)
    values, rate = np.array(rows), Fraction(told["rate"])
    if len(values) < 2:
        raise FormatError("the video has a single frame: nothing moves", path=path)
    seconds = np.array(told["seconds"]) if told["seconds"] else None
    if seconds is not None:
        rate = usual_rate(float(rate))
        even = np.arange(int(seconds[-1] * float(rate)) + 1) / float(rate)
        values = np.stack([np.interp(even, seconds, column) for column in values.T], axis=1)
    n_flow = sum(name.startswith("flow") for name in told["names"])
    values = np.concatenate([_remembered(values[:, :n_flow], float(rate)), values[:, n_flow:]], axis=1)
    for block in (slice(0, n_flow), slice(n_flow, None)):
        spread = float(np.sqrt(values[:, block].var(axis=0).sum()))
        if spread > 0:
            values[:, block] /= spread
    return replace(Signal(tuple(told["names"]), values, rate), name=path.stem)


def _remembered(flow: FloatArray, rate: float) -> FloatArray:
    """Sum up flow, and forget it."""
    kept = float(np.exp(-1 / (rate * _FORGET)))
    summed = np.zeros_like(flow)
    for frame in range(1, len(flow)):
        summed[frame] = kept * summed[frame - 1] + flow[frame]
    return summed


def find_features(path: Path, source: Any, fps: Fraction | None, report: Any) -> None:
    """Tell what moves, frame by frame. Runs in the process that may die of it."""
    from retime.media.streams import first_frames

    cv2 = needed("cv2")
    reader = first_frames(path, source, fps, report.beat)
    times = reader.times
    first = reader.get(0)
    tall = first.height > first.width
    scale = _LONG / max(first.width, first.height)
    size = max(16, round(first.width * scale)), max(16, round(first.height * scale))
    cells, large = ((a[::-1] if tall else a) for a in (_CELLS, _LARGE_CELLS))
    names = [f"flow {axis} {x} {y}" for axis in "xy" for y in range(cells[1]) for x in range(cells[0])]
    names += [f"edges {x} {y} {turn}" for y in range(large[1]) for x in range(large[0]) for turn in range(_DIRECTIONS)]
    report.tell({"names": names, "rate": str(times.rate), "seconds": None if times.even else times.seconds.tolist()})
    flow = cv2.DISOpticalFlow_create(cv2.DISOPTICAL_FLOW_PRESET_FAST)
    before = None
    waiting: list[list[float]] = []
    n = len(times.stamps)
    for frame in range(n):
        grey = np.ascontiguousarray(reader.get(frame).reformat(*size, format="gray").to_ndarray())
        row = features_of(cv2, flow, before, grey, cells, large)
        waiting.append([float(f"{number:.6g}") for number in row.tolist()])
        before = grey
        if len(waiting) == 64 or frame == n - 1:
            report.tell({"rows": waiting})
            waiting = []
        report.total = n
        report.share(frame + 1)


def features_of(
    cv2: Any, flow: Any, before: Any, grey: Any, cells: tuple[int, int], large: tuple[int, int]
) -> FloatArray:
    """Return the flow of each cell since the frame before, x then y, and the edges of each large cell."""
    picture = grey.astype(np.float32)
    gx, gy = cv2.Sobel(picture, cv2.CV_32F, 1, 0, scale=1 / 8), cv2.Sobel(picture, cv2.CV_32F, 0, 1, scale=1 / 8)
    strength = np.hypot(gx, gy)
    if before is None:
        moved = np.zeros((*grey.shape, 2), np.float32)
    else:
        moved = flow.calc(before, grey, None) / grey.shape[0]
    weight = strength + 1e-3
    total = _in_cells(cv2, weight, cells)
    found = [_in_cells(cv2, moved[:, :, axis] * weight, cells) / total for axis in (0, 1)]
    turn = np.mod(np.arctan2(gy, gx), np.pi) / np.pi * _DIRECTIONS
    edges = []
    for direction in range(_DIRECTIONS):
        # A gradient between two directions counts for both.
        away = np.abs(turn - direction)
        away = np.minimum(away, _DIRECTIONS - away)
        edges.append(_in_cells(cv2, np.maximum(0, 1 - away) * strength, large))
    return np.concatenate([*found, np.sqrt(np.stack(edges, axis=1)).ravel()]).astype(np.float64)


def _in_cells(cv2: Any, picture: Any, cells: tuple[int, int]) -> FloatArray:
    """Return the mean of a picture in each cell, row by row."""
    return np.asarray(cv2.resize(picture, cells, interpolation=cv2.INTER_AREA).ravel(), np.float64)
