"""A C3D with new timing: other frames, frame counts and times of events; all else stays as it was, to the byte."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from retime.arrays import FloatArray, IntArray
from retime.errors import FormatError
from retime.formats.c3d_file import (
    AT_EVENT_TIMES,
    AT_FIRST,
    AT_LAST,
    AT_RATE,
    BLOCK,
    MOST_COUNTED,
    C3dFile,
    Parameter,
    field,
    parse_c3d,
)
from retime.formats.c3d_frames import Frames, analog_labels, pack_frames, read_frames
from retime.formats.read_options import ReadOptions
from retime.frames import frame_positions
from retime.motion.channels import LINEAR, with_chosen
from retime.motion.signal import Signal, numbered_names
from retime.warp.apply import compare_ranges, shown_at
from retime.warp.curve import Warp, output_frame_times
from retime.warp.moments import output_moments


def retime_frames(
    path: Path,
    data: bytes,
    warp: Warp,
    options: ReadOptions,
    *,
    frames: tuple[int, int] | None = None,
    average: bool = True,
    held: int = 1,
) -> bytes:
    """Give a C3D new timing.

    Points, and analog samples at their own rate, are shown at the warp's times, and averaged where it speeds up; a
    point that is missing beside such a time stays missing, and no mean reaches across a gap. Residual and cameras are
    those of the nearest frame. Times of events, and the frames in which force plates are zeroed, go where the warp
    shows them.

    Parameters
    ----------
    path : Path
        The file, for messages.
    data : bytes
        What it holds.
    warp : Warp
        Its input time 0 is the first frame that is meant.
    options : ReadOptions
        As it was read; a ``rate`` is written where the file has its own.
    frames : (int, int), optional
        The first frame that is meant and the last one, as the file numbers them.
    average : bool
        Average where sped up.
    held : int
        For how many frames each pose is held; analog samples are not.

    Returns
    -------
    bytes
        The new file.

    Raises
    ------
    FormatError
        The file is not what it claims to be, or can't count so many frames.
    """
    file = parse_c3d(path, data, options)
    if not data[0] * BLOCK <= file.data_start:
        raise FormatError("the parameters stand after the frames; only what stands before is kept", path=path)
    start, stop = (0, file.n_frames) if frames is None else (frames[0] - file.first, frames[1] + 1 - file.first)
    if not 0 <= start < stop <= file.n_frames:
        raise FormatError(
            f"frames {start + file.first} to {stop + file.first - 1} are not among {file.first} to "
            f"{file.first + file.n_frames - 1}",
            path=path,
        )
    first = file.first + start
    old = read_frames(file).cut(start, stop)
    new = _shown(file, old, warp, average, held, options)
    head = bytearray(data[: file.data_start])
    _count(file, head, first, len(new.points))
    _move_events(file, head, warp, (first - 1) / float(file.rate))
    _move_header_events(file, head, warp, start / float(file.rate))
    _move_zero(file, head, warp, first)
    if options.rate is not None:
        _say_rate(file, head)
    stored = pack_frames(file, new)
    rest = data[_padded(file.data_start + file.n_frames * file.frame_bytes) :]
    return bytes(head) + stored + b"\0" * (-len(head) - len(stored) & (BLOCK - 1)) + rest


def _padded(n_bytes: int) -> int:
    return -(-n_bytes // BLOCK) * BLOCK


def _shown(file: C3dFile, old: Frames, warp: Warp, average: bool, held: int, options: ReadOptions) -> Frames:
    """Show points and analog samples at the warp's times."""
    rate, n_frames, samples = float(file.rate), len(old.points), file.layout.samples
    times = output_frame_times(warp, rate)
    kept: IntArray = np.arange(len(times)) // held * held
    clock = Signal(("frame",), np.zeros((n_frames, 1)), file.rate, file.path.stem)
    compare_ranges(clock, warp)
    points = old.points
    if file.layout.points:
        values = old.places().reshape(n_frames, -1)
        marks = Signal(
            numbered_names(values.shape[1]), values, file.rate, kinds=[LINEAR] * values.shape[1], gaps="keep"
        )
        shown = shown_at(marks, warp, times, average=average)[kept].reshape(len(times), -1, 3)
        before, after, share = frame_positions(warp(times)[kept], file.rate, n_frames)
        points = old.points[np.where(share < 0.5, before, after)]
        there = ~np.isnan(shown[..., 0])
        points[there, :3] = shown[there]
        # What is missing is written as one of its neighbours that is, so that it keeps whatever stands there.
        gone = np.where(old.missing[before], before[:, None], np.where(share == 0, before, after)[:, None])
        frame, point = np.nonzero(~there)
        points[frame, point] = old.points[gone[frame, point], point]
    else:
        points = np.zeros((len(times), 0, 4))
    analog = old.analog
    if file.layout.channels:
        # The samples of the last frame follow it: the warp goes on for a frame, as fast as a take, where it was going.
        direction = float(np.sign(warp.input_times[-1] - warp.input_times[-2]))
        longer = Warp(
            np.append(warp.output_times, warp.output_end + 1 / rate),
            np.append(warp.input_times, warp.input_times[-1] + direction / rate),
        )
        names = analog_labels(file)
        values = np.where(np.isfinite(old.analog), old.analog, np.nan)
        kinds = with_chosen([LINEAR] * len(names), names, options.channels, all_fit=False)
        signal = Signal(names, values, file.rate * samples, kinds=kinds, gaps="keep")
        moments = warp.output_start + np.arange(len(times) * samples) / (rate * samples)
        analog = shown_at(signal, longer, moments, average=average)
    else:
        analog = np.zeros((len(times) * samples, 0))
    return Frames(points, analog)


def _put(file: C3dFile, head: bytearray, one: Parameter, values: FloatArray) -> None:
    """Write the numbers of a parameter where they were."""
    packed = file.numbers.pack_reals(values) if one.kind == 4 else file.numbers.pack_words(values)
    head[one.start : one.start + one.n_bytes] = packed[: one.n_bytes]


def _put_field(file: C3dFile, head: bytearray, one: Parameter, number: int) -> None:
    """Write the number of a frame in the form in which the parameter holds it."""
    values = file.values_of(one)
    if one.kind == 2 and len(values) > 1:
        values[:2] = number & 0xFFFF, number >> 16
    else:
        values[0] = number
    _put(file, head, one, values)


def _count(file: C3dFile, head: bytearray, first: int, n_frames: int) -> None:
    """Say which frames there are wherever the file says it; raise FormatError where it can't count so far."""
    last = first + n_frames - 1
    able = last <= MOST_COUNTED
    for name, number in (
        ("TRIAL:ACTUAL_START_FIELD", first),
        ("TRIAL:ACTUAL_END_FIELD", last),
        ("POINT:LONG_FRAMES", n_frames),
        ("POINT:FRAMES", n_frames),
    ):
        one = file.parameters.get(name)
        if one is None or field(file.data, file.numbers, one) is None or one.kind == 1:
            continue
        wide = one.kind == 4 or (one.kind == 2 and one.n_bytes >= 4)
        able |= wide
        _put_field(file, head, one, number if wide else min(number, MOST_COUNTED))
    if not able:
        raise FormatError(
            f"{n_frames} frames would end at number {last}, and this file has no place for one above {MOST_COUNTED} "
            "(TRIAL:ACTUAL_END_FIELD); write a table (.csv), or a new C3D from one",
            path=file.path,
        )
    for at, number in ((AT_FIRST, first), (AT_LAST, last)):
        head[at : at + 2] = file.numbers.pack_words(np.array([min(number, MOST_COUNTED)], dtype=np.float64))


def _move_events(file: C3dFile, head: bytearray, warp: Warp, start: float) -> None:
    """Put events where the warp shows them; their times, and `start`, that of the first frame, count from frame 1."""
    used = file.number("EVENT:USED")
    left = None if used is None else max(int(used), 0)
    for name in file.event_times:
        one = file.parameters[name]
        values = file.values_of(one)
        n_pairs = len(values) // 2 if left is None else min(left, len(values) // 2)
        left = None if left is None else left - n_pairs
        pairs = values[: 2 * n_pairs].reshape(-1, 2)
        times = 60 * pairs[:, 0] + pairs[:, 1]
        moved = np.flatnonzero(np.isfinite(times))
        new = start + output_moments(warp, times[moved] - start)
        # Whole minutes go in front where they did before; many programs write all in seconds.
        minutes = np.where(pairs[moved, 0] != 0, np.floor(new / 60), 0.0)
        pairs[moved] = np.column_stack([minutes, new - 60 * minutes])
        _put(file, head, one, values)


def _move_header_events(file: C3dFile, head: bytearray, warp: Warp, start: float) -> None:
    """Do so with the header's events, whose times count from the first frame that is there, before and after.

    `start` is how much later the first frame is that is meant, seconds.
    """
    size = 4 * file.header_events
    if size:
        times = file.numbers.reals(file.data[AT_EVENT_TIMES : AT_EVENT_TIMES + size])
        finite = np.isfinite(times)
        times[finite] = output_moments(warp, times[finite] - start)
        head[AT_EVENT_TIMES : AT_EVENT_TIMES + size] = file.numbers.pack_reals(times)


def _move_zero(file: C3dFile, head: bytearray, warp: Warp, first: int) -> None:
    """Let force plates be zeroed over the same part of the take: two numbers of frames, the first being 1."""
    one, values = file.parameters.get("FORCE_PLATFORM:ZERO"), file.values("FORCE_PLATFORM:ZERO")
    if one is None or values is None or len(values) != 2 or not (values > 0).all() or one.kind == 1:
        return
    rate, n_frames = float(file.rate), warp.count_frames(file.rate)
    shown = np.rint(output_moments(warp, (values - 1) / rate) * rate) + 1
    _put(file, head, one, np.clip(np.sort(shown), 1, n_frames))


def _say_rate(file: C3dFile, head: bytearray) -> None:
    """Write the rate that was given where the file has its own."""
    rate = float(file.rate)
    head[AT_RATE : AT_RATE + 4] = file.numbers.pack_reals(np.array([rate]))
    for name, value in (("POINT:RATE", rate), ("ANALOG:RATE", rate * file.layout.samples)):
        one = file.parameters.get(name)
        if one is not None and one.kind == 4 and one.n_bytes >= 4:
            values = file.values_of(one)
            values[0] = value
            _put(file, head, one, values)
