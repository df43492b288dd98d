"""C3D: read as a signal of its markers, or of its analog channels; retimed in place; written anew.

The file itself is taken apart in `retime.formats.c3d_file`.
"""

from __future__ import annotations

import warnings
from dataclasses import replace
from fractions import Fraction
from pathlib import Path

import numpy as np

from retime.arrays import FloatArray
from retime.errors import FormatError, FormatWarning
from retime.files import write_bytes
from retime.formats.c3d_file import C3dFile, parse_c3d
from retime.formats.c3d_frames import Frames, analog_labels, analog_scales, point_labels, read_frames
from retime.formats.c3d_retime import retime_frames
from retime.formats.c3d_writer import c3d_of
from retime.formats.channel_meaning import GAPS_HINT, make_signal
from retime.formats.read_options import ReadOptions
from retime.motion.any_motion import AnyMotion
from retime.motion.channels import ChannelKind
from retime.motion.clock import Clock
from retime.motion.gaps import GapPolicy
from retime.motion.signal import Signal

__all__ = ["facts", "read", "retime_frames", "write"]
POINTS, ANALOG = "points", "analog"
"""What `--array` calls the two parts of a C3D."""
# Results of a model that are stored as if they were points, in units of their own.
_RESULTS = ("ANGLE", "FORCE", "MOMENT", "POWER", "SCALAR")
# So much of a take without a look is worth a word.
_MUCH = 0.5


def read(path: Path, data: bytes, options: ReadOptions) -> Signal:
    """Read the markers, or, where there are none or ``options.arrays`` says so, the analog channels.

    Parameters
    ----------
    path : Path
        The file, for messages.
    data : bytes
        What it holds.
    options : ReadOptions
        What the reader was told; ``arrays`` may be ``("points",)`` or ``("analog",)``.

    Returns
    -------
    Signal
        Channels ``LABEL.x``, ``LABEL.y``, ``LABEL.z`` in the file's unit, at the rate of the points; or the analog
        channels by their labels, scaled, at theirs. Frame 1 is at time 0, and a file's first frame may be a later one.
        A point that is missing is a gap, which is kept unless ``options.gaps`` says otherwise; one that is never there
        is left out.

    Raises
    ------
    FormatError
        The file is not what it claims to be, or lacks what is asked for.

    Warns
    -----
    FormatWarning
        Points are missing, or never there.
    """
    file = parse_c3d(path, data, options)
    layout = file.layout
    chosen = options.arrays or ((POINTS if layout.points else ANALOG),)
    there = [name for name, count in ((POINTS, layout.points), (ANALOG, layout.channels)) if count]
    if len(chosen) > 1 or chosen[0] not in there:
        raise FormatError(
            f"--array names {' or '.join(there)} of this file, which have rates of their own; found "
            f"{', '.join(chosen)}",
            path=path,
        )
    if options.gaps is None:
        options = replace(options, gaps=GapPolicy())
    frames = read_frames(file)
    return _markers(file, frames, options) if chosen[0] == POINTS else _channels(file, frames, options)


def write(signal: AnyMotion, path: Path, *, overwrite: bool) -> None:
    """Write a new C3D: channels NAME.x, NAME.y, NAME.z as markers, others as analog channels.

    Raises
    ------
    FormatError
        There is no marker, or what a C3D can't hold (`retime.formats.c3d_writer.c3d_of`).
    OutputExistsError
        The file is there, and `overwrite` is not set.
    """
    if not isinstance(signal, Signal):
        raise FormatError("a C3D holds markers, not a skeleton", path=path)
    write_bytes(path, c3d_of(signal, path), overwrite=overwrite)


def _markers(file: C3dFile, frames: Frames, options: ReadOptions) -> Signal:
    missing = frames.missing
    never = np.asarray(missing.all(axis=0))
    labels = point_labels(file)
    if never.all():
        raise FormatError(f"none of the {len(labels)} points is there in any frame", path=file.path)
    if never.any():
        gone = [label for label, absent in zip(labels, never.tolist(), strict=True) if absent]
        more = f" and {len(gone) - 6} more" if len(gone) > 6 else ""
        warnings.warn(
            f"{file.path}: never there, and so left out: {', '.join(gone[:6])}{more}", FormatWarning, stacklevel=4
        )
    seen = np.flatnonzero(~never)
    values = frames.places()[:, seen] * (1.0 if file.real else file.scale)
    units = _units(file, labels)
    names = [f"{labels[point]}.{axis}" for point in seen for axis in "xyz"]
    known = {3 * place + axis: ChannelKind(unit=units[point]) for place, point in enumerate(seen) for axis in range(3)}
    unseen = float(missing[:, seen].any(axis=1).mean())
    if unseen > _MUCH and options.gaps == GapPolicy():
        warnings.warn(
            f"{file.path}: a point is missing in {unseen:.0%} of the frames, at which the search doesn't look; "
            f"{GAPS_HINT.split(',')[0]}",
            FormatWarning,
            stacklevel=4,
        )
    return _signal(file, names, values.reshape(len(values), -1), file.rate, file.first, options, known)


def _channels(file: C3dFile, frames: Frames, options: ReadOptions) -> Signal:
    scales, offsets = analog_scales(file)
    values = (frames.analog - offsets) * scales
    labels = analog_labels(file)
    units = file.texts("ANALOG:UNITS")
    known = {place: ChannelKind(unit=unit) for place, unit in enumerate(units[: len(labels)]) if unit}
    samples = file.layout.samples
    first = (file.first - 1) * samples + 1
    return _signal(
        file, labels, np.where(np.isfinite(values), values, np.nan), file.rate * samples, first, options, known
    )


def _signal(
    file: C3dFile,
    names: list[str],
    values: FloatArray,
    rate: Fraction,
    first: int,
    options: ReadOptions,
    known: dict[int, ChannelKind],
) -> Signal:
    clock = Clock(start=Fraction(file.first - 1) / file.rate)
    return make_signal(file.path, names, values, rate, options, known, first_frame=first, clock=clock)


def _units(file: C3dFile, labels: list[str]) -> list[str]:
    """Say in which unit each point is: those that are results of a model have others than the markers."""
    units = dict.fromkeys(labels, next(iter(file.texts("POINT:UNITS")), ""))
    for result in _RESULTS:
        unit = next(iter(file.texts(f"POINT:{result}_UNITS")), "")
        for label in file.texts(f"POINT:{result}S"):
            if label in units:
                units[label] = unit
    return [units[label] for label in labels]


def facts(path: Path, data: bytes, options: ReadOptions) -> dict[str, str]:
    """Say what a file holds beside its markers: how numbers are stored, analog channels, events, force plates."""
    file = parse_c3d(path, data, options)
    layout = file.layout
    unit = next(iter(file.texts("POINT:UNITS")), "")
    said = {"stored": file.form, "points": f"{layout.points}{f', in {unit}' if unit else ''}"}
    if layout.channels:
        rate = float(file.rate * layout.samples)
        said["analog"] = (
            f"{layout.channels} channels at {rate:.6g} Hz: {', '.join(analog_labels(file))} (--array analog)"
        )
    else:
        said["analog"] = "none"
    events = [f"{label} {time:.3f} s" for time, label in file.events()]
    said["events"] = f"{len(events)}: {', '.join(events)}" if events else "none"
    plates = file.number("FORCE_PLATFORM:USED")
    if plates:
        said["force plates"] = f"{int(plates)}"
    return said
