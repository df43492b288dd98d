"""Beats from a table of times, or from sound (librosa)."""

from __future__ import annotations

import csv
import io
import itertools
import re
import tempfile
from os import PathLike
from pathlib import Path
from typing import Any, Literal

import numpy as np

from retime.checks import path_of
from retime.errors import FormatError, OptionError
from retime.files import read_bytes, resolved, scratch
from retime.media.extras import needed, refuse_without
from retime.media.kinds import is_media, is_sequence
from retime.media.process import check_media, run
from retime.motion.grammar import read_time

Found = list[tuple[float, float, str]]

_MOST_BYTES, _MOST_BEATS = 1 << 20, 4000
_TIMES = ("time", "seconds", "start", "in", "onset", "position", "timestamp", "t", "beat")
_STRENGTHS = ("strength", "weight")
_NAMES = ("name", "marker name", "label", "marker", "text", "description")
# A unit that may stand behind a column's name, names that mean something else, and numbers with a comma.
_UNIT = re.compile(r"[\s_]*[(\[](s|sec|secs|seconds)[)\]]$")
_NOT_SECONDS = re.compile(r"frame|sample|timecode|tick|bar|measure|milli|\bms\b|minute|^(#|nr|no|id|index|number)$")
_COMMA = re.compile(r"^\s*([+-]?\d+),(\d+)\s*$")
# Samples a second that beats are looked for in.
RATE = 22_050


def read_beats(path: str | PathLike[str], *, on: Literal["beats", "onsets"] = "beats") -> Found:
    """Read beats or markers from a table, or find them in sound or in a video's sound.

    Parameters
    ----------
    path : path-like
        A CSV or text with a time in each row (63.5 or 1:03.500), in a column of that name (time, seconds, start, in,
        ...) or, where no names are given, the first; a column "strength" (from 0 up) and one "name" may stand beside.
        Markers as Audacity, Audition and REAPER write them are such tables. Or sound.
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
    rows = [(number, row) for number, row in enumerate(_rows(_text(path), path), start=1) if any(map(str.strip, row))]
    if not rows:
        raise FormatError("no row; expected a time in seconds in each", path=path)
    columns = {"time": 0}
    head = [_plain_name(cell) for cell in rows[0][1]]
    if _is_head(head):
        columns = _columns(head, path)
        rows = rows[1:]
    else:
        _refuse_counted(rows, path)
    found: Found = []
    for number, row in rows:
        cells = {what: row[place].strip() if place < len(row) else "" for what, place in columns.items()}
        strength = cells.get("strength", "1")
        if not _is_number(strength) or float(strength) < 0:
            raise FormatError(f"expected a strength from 0 up, found {strength[:40]!r}", path=path, line=number)
        found.append((_seconds(cells["time"], path, number), float(strength), cells.get("name", "")))
        if len(found) > _MOST_BEATS:
            raise FormatError(f"more than {_MOST_BEATS} beats", path=path)
    return _in_order(found, path)


def _text(path: Path) -> str:
    """Read a text: UTF-8, or UTF-16 as spreadsheets and editing programs write it."""
    data = read_bytes(path, _MOST_BYTES)
    try:
        return data.decode("utf-16" if data[:2] in (b"\xff\xfe", b"\xfe\xff") else "utf-8-sig")
    except UnicodeDecodeError:
        raise FormatError("expected a table of times, found something that is no text (UTF-8)", path=path) from None


def _rows(text: str, path: Path) -> list[list[str]]:
    delimiter = next((mark for mark in ("\t", ";", ",") if mark in text), None)
    if delimiter is None:
        # A time, a blank, and whatever is said of it.
        return [line.split(None, 1) if line.strip()[:1].isdigit() else [line] for line in text.splitlines()]
    try:
        rows = list(csv.reader(io.StringIO(text), delimiter=delimiter))
    except csv.Error as error:
        raise FormatError(f"no table: {error}", path=path) from None
    if delimiter == ",":
        return rows
    # Where commas part no cells they may stand in numbers.
    return [[_COMMA.sub(r"\1.\2", cell) for cell in row] for row in rows]


def _plain_name(cell: str) -> str:
    """Return the name of a column without its unit, where that is the second: ``Time (s)``."""
    return _UNIT.sub("", cell.strip().lower()).strip()


def _is_head(head: list[str]) -> bool:
    """Tell whether a first row names columns: no time begins with a letter."""
    return any(name in head for name in _TIMES) or not head[0].lstrip("+-.")[:1].isdigit()


def _columns(head: list[str], path: Path) -> dict[str, int]:
    """Find which columns say what; raise FormatError where none says a time."""
    columns = {}
    for what, names in (("time", _TIMES), ("strength", _STRENGTHS), ("name", _NAMES)):
        place = next((head.index(name) for name in names if name in head), None)
        if place is not None:
            columns[what] = place
    if "time" not in columns:
        if len(head) > 1 or _NOT_SECONDS.search(head[0]):
            raise FormatError(
                f"no column of times among {', '.join(repr(name[:20]) for name in head[:8])}: call the one with the "
                "seconds 'time'",
                path=path,
            )
        columns["time"] = 0
    return columns


def _refuse_counted(rows: list[tuple[int, list[str]]], path: Path) -> None:
    """Raise FormatError where a first column without a name counts rows, and the second one has the times."""
    firsts = [row[0].strip() for _, row in rows]
    seconds = [row[1].strip() if len(row) > 1 else "" for _, row in rows]
    counted = any(firsts == [str(start + k) for k in range(len(rows))] for start in (0, 1))
    if len(rows) > 2 and counted and all(map(_is_number, seconds)):
        values = [float(text) for text in seconds]
        if all(a < b for a, b in itertools.pairwise(values)):
            raise FormatError(
                "its first column may count the rows or be the seconds: name the columns in a first row (time, ...)",
                path=path,
            )


def _seconds(text: str, path: Path, line: int) -> float:
    """Read a time: seconds, or a clock; frames need a rate, which a table doesn't say."""
    try:
        written = read_time(text)
    except OptionError:
        raise FormatError(
            f"expected a time in seconds (63.5, 1:03.500), found {text[:40]!r}", path=path, line=line
        ) from None
    if written.seconds is None:
        raise FormatError(
            f"{text[:40]!r} counts frames, whose rate this table doesn't say: write seconds (63.5, 1:03.500)",
            path=path,
            line=line,
        )
    return float(written.seconds)


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
