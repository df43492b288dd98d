"""Beats from a table of times, or from sound (librosa)."""

from __future__ import annotations

import csv
import io
import tempfile
from os import PathLike
from pathlib import Path
from typing import Any, Literal

import numpy as np

from retime.checks import path_of
from retime.errors import FormatError
from retime.files import read_bytes, resolved, scratch
from retime.media.extras import needed, refuse_without
from retime.media.kinds import is_media, is_sequence
from retime.media.process import check_media, run

Found = list[tuple[float, float, str]]

_MOST_BYTES, _MOST_BEATS = 1 << 20, 4000
_TIMES = ("time", "beat", "seconds", "t", "start", "onset", "position")
_STRENGTHS = ("strength", "weight")
_NAMES = ("name", "label", "marker", "text")
# Samples a second that beats are looked for in.
RATE = 22_050


def read_beats(path: str | PathLike[str], *, on: Literal["beats", "onsets"] = "beats") -> Found:
    """Read beats or markers from a table, or find them in sound or in a video's sound.

    Parameters
    ----------
    path : path-like
        A CSV or text with a time in seconds in each row, in a column of that name (time, beat, seconds, start) or the
        first; a column "strength" (from 0 up) and one "name" may stand beside. Or sound.
    on : {"beats", "onsets"}
        Of sound: its regular beats, or whenever something begins.

    Returns
    -------
    list of (float, float, str)
        Seconds, strength from 0 to 1, and name, in their order.

    Raises
    ------
    FormatError
        No such table, a time that is none, or sound without beats.
    MissingExtraError
        There is no librosa, or no PyAV.
    """
    path = path_of(path, "read_beats(path)")
    if is_media(path) and not is_sequence(path):
        return _beats_of_sound(path, on)
    return _beats_of_table(path)


def _beats_of_table(path: Path) -> Found:
    try:
        text = read_bytes(path, _MOST_BYTES).decode("utf-8-sig")
    except UnicodeDecodeError:
        raise FormatError("expected a table of times, found something that is no text (UTF-8)", path=path) from None
    rows = [(number, row) for number, row in enumerate(_rows(text, path), start=1) if any(map(str.strip, row))]
    if not rows:
        raise FormatError("no row; expected a time in seconds in each", path=path)
    columns = {"time": 0}
    head = [cell.strip().lower() for cell in rows[0][1]]
    if not _is_number(head[0]) or any(name in head for name in _TIMES):
        for what, names in (("time", _TIMES), ("strength", _STRENGTHS), ("name", _NAMES)):
            place = next((head.index(name) for name in names if name in head), None)
            if place is not None:
                columns[what] = place
        rows = rows[1:]
    found: Found = []
    for number, row in rows:
        cells = {what: row[place].strip() if place < len(row) else "" for what, place in columns.items()}
        if not _is_number(cells["time"]):
            raise FormatError(f"expected a time in seconds, found {cells['time'][:40]!r}", path=path, line=number)
        strength = cells.get("strength", "1")
        if not _is_number(strength) or float(strength) < 0:
            raise FormatError(f"expected a strength from 0 up, found {strength[:40]!r}", path=path, line=number)
        found.append((float(cells["time"]), float(strength), cells.get("name", "")))
        if len(found) > _MOST_BEATS:
            raise FormatError(f"more than {_MOST_BEATS} beats", path=path)
    return _in_order(found, path)


def _rows(text: str, path: Path) -> list[list[str]]:
    delimiter = next((mark for mark in ("\t", ";", ",") if mark in text), ",")
    try:
        return list(csv.reader(io.StringIO(text), delimiter=delimiter))
    except csv.Error as error:
        raise FormatError(f"no table: {error}", path=path) from None


def _is_number(text: str) -> bool:
    """Tell whether a text is a plain number: no inf, no nan, no underscores."""
    plain = text.removeprefix("-").removeprefix("+")
    return bool(plain) and plain.isascii() and plain.replace(".", "", 1).isdigit() and len(plain) < 30


def _in_order(found: Found, path: Path) -> Found:
    """Sort, drop what is there twice, and scale strengths to 1."""
    if not found:
        raise FormatError("no beat in it", path=path)
    most = max(strength for _, strength, _ in found) or 1.0
    ordered: Found = []
    for time, strength, name in sorted(found):
        if not ordered or time - ordered[-1][0] > 1e-6:
            ordered.append((time, strength / most, name))
    return ordered


def _beats_of_sound(path: Path, on: Literal["beats", "onsets"]) -> Found:
    librosa = needed("librosa")
    refuse_without("av")
    check_media(path)
    with scratch(tempfile.gettempdir()) as file:
        run({"do": "sound", "path": str(resolved(path)), "beside": file.name}, path)
        samples = np.frombuffer(file.read(), np.float32)
    envelope = librosa.onset.onset_strength(y=samples, sr=RATE)
    if not len(envelope) or float(envelope.max()) <= 0:
        raise FormatError("nothing is heard in it: no beats", path=path)
    if on == "beats":
        frames = librosa.beat.beat_track(onset_envelope=envelope, sr=RATE)[1]
    else:
        frames = librosa.onset.onset_detect(onset_envelope=envelope, sr=RATE)
    if not len(frames):
        raise FormatError(f"no {on} were found in it", path=path)
    times = librosa.frames_to_time(frames, sr=RATE)
    return _in_order([(float(t), float(envelope[f]), "") for t, f in zip(times, frames, strict=True)], path)


def write_samples(path: Path, source: Any, target: Any, spool: Any, report: Any) -> None:
    """Write a file's sound as one channel of floats. Runs in the process that may die of it."""
    from retime.media.opening import SharedFile, open_media
    from retime.media.sound_reader import SoundReader

    av = needed("av")
    shared = SharedFile(source)
    with open_media(shared, path) as container:
        index = next((stream.index for stream in container.streams.audio), None)
    if index is None:
        raise FormatError("no sound: beats are found in what is heard", path=path)
    sound = SoundReader(shared, path, index, None, spool, report.beat)
    resampler = av.AudioResampler(format="flt", layout="mono", rate=RATE)
    total = round(sound.seconds * sound.rate)
    if total > 3 * 3600 * sound.rate:
        raise FormatError("more than three hours of sound; cut out what is needed", path=path)
    for first in range(0, total, sound.rate):
        block = sound.read(first, min(sound.rate, total - first))
        frame = av.AudioFrame.from_ndarray(np.ascontiguousarray(block), format="fltp", layout=sound.layout)
        frame.sample_rate = sound.rate
        for one in resampler.resample(frame):
            target.write(one.to_ndarray().astype(np.float32).tobytes())
    for one in resampler.resample(None):
        target.write(one.to_ndarray().astype(np.float32).tobytes())
