"""NPY and NPZ: a signal as NumPy's arrays.

A .npy file is one array: (n_frames,), (n_frames, n_channels) or points (n_frames, n_points, n_numbers); a 1 before
these is passed over. Fours of unit length are rotations. It holds no rate, which must be given. A .npz archive holds
such arrays by name: ``values``, ``poses`` and ``trans`` side by side, the only one that could be meant, or those that
were chosen. It may hold a rate (``rate``, ``fps``, ``mocap_framerate`` ...: text such as "24000/1001", or a number),
``names`` of all channels or ``joint_names`` of the points, ``first_frame``, the time of that (``start_time``,
seconds), and what the channels hold (``kinds``, ``words``).

Only plain numbers and text are read: nothing is unpickled or evaluated, and a claimed size is compared with the bytes
that are there before anything is made of it.
"""

from __future__ import annotations

import math
import warnings
import zipfile
from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace
from fractions import Fraction
from io import BytesIO
from pathlib import Path

import numpy as np

from retime.arrays import FloatArray
from retime.errors import FormatError, FormatWarning, OptionError
from retime.files import write_bytes
from retime.formats.channel_meaning import make_signal
from retime.formats.file_signatures import foreign_kind
from retime.formats.npy_arrays import (
    MAGIC,
    RATES,
    StoredArray,
    archive_of,
    array_bytes,
    floats_of,
    member_bytes,
    number_of,
    parse_array,
    rate_of,
    texts_of,
)
from retime.formats.read_options import Limits, ReadOptions
from retime.motion.any_motion import AnyMotion
from retime.motion.channels import ChannelKind
from retime.motion.clock import Clock
from retime.motion.signal import Signal, numbered_names

# Seconds, thirty million years: beyond it a time since whenever is a mistake.
_LATEST = 1e15
_KNOWN_MEMBERS = ("names", "first_frame", "start_time", "kinds", "words", "word_counts")
_POINT_NAMES = ("joint_names", "joints_names", "keypoint_names", "point_names", "marker_names")
# Arrays that are the frames where an archive has them: retime's own, and those of a capture of body parameters.
_USUAL = (("values",), ("poses", "trans"), ("poses",))
# Fours of numbers are rotations where none is further from length 1.
_UNIT_LENGTH = 0.02


def read(path: Path, data: bytes, options: ReadOptions) -> Signal:
    """Read a .npy array or a .npz archive, whichever the bytes are.

    Parameters
    ----------
    path : Path
        The file, for messages.
    data : bytes
        What it holds.
    options : ReadOptions
        What the reader was told; a .npy needs a ``rate``.

    Returns
    -------
    Signal
        Channels are called c0, c1 ..., those of points m0.x, m0.y, m0.z, m1.x ..., or as the archive says.

    Raises
    ------
    FormatError
        Not an array of finite numbers in one of the shapes, a claim that the bytes don't bear out, or no rate.

    Warns
    -----
    FormatWarning
        Frames that were cut off were left out (``options.repair``).

    Examples
    --------
    >>> file = BytesIO()
    >>> np.save(file, np.array([[1.0, 2.0], [3.0, 4.0]]))
    >>> signal = read(Path("two.npy"), file.getvalue(), ReadOptions(rate=Fraction(30)))
    >>> signal.names, signal.values[:, 1].tolist()
    (('c0', 'c1'), [2.0, 4.0])
    """
    if data.startswith(MAGIC):
        members = {"values": parse_array(path, data, "the array", options)}
        meant: tuple[str, ...] = ("values",)
    elif data.startswith(b"PK"):
        members, meant = _members(path, data, options)
    elif not data:
        raise FormatError("the file is empty; expected a NumPy array (NPY) or archive (NPZ)", path=path)
    else:
        kind = foreign_kind(data) or f"found the bytes {data[:6].hex(' ')}"
        raise FormatError(f"expected a NumPy array (NPY) or archive (NPZ), {kind}", path=path, byte=0)
    points = _point_names(path, members, options.limits)
    tables = [_values(path, members[name], name if len(meant) > 1 else "", points, options.limits) for name in meant]
    lengths = {len(table.values) for table in tables}
    if len(lengths) > 1:
        counts = ", ".join(f"{name} {len(table.values)}" for name, table in zip(meant, tables, strict=True))
        raise FormatError(f"arrays side by side have as many frames as one another; found {counts}", path=path)
    values = np.concatenate([table.values for table in tables], axis=1)
    names = tuple(name for table in tables for name in table.names)
    if values.shape[1] > options.limits.channels:
        raise FormatError(
            f"{values.shape[1]} channels, the limit is {options.limits.channels} (Limits.channels)", path=path
        )
    if "names" in members and meant == ("values",):
        names = _names(path, members["names"], values.shape[1], options.limits)
    rate = options.rate
    key = next((key for key in RATES if key in members), None)
    if rate is None and key is not None:
        rate = rate_of(path, members[key], key)
    if rate is None:
        raise FormatError("the file holds no rate, so it must be given (--fps)", path=path)
    first_frame = 0
    if "first_frame" in members:
        first_frame = int(number_of(path, members["first_frame"], "first_frame", "iu"))
    clock = Clock()
    if "start_time" in members:
        start = number_of(path, members["start_time"], "start_time", "iuf")
        if not abs(start) < _LATEST:
            raise FormatError(f"start_time is {start:g}; expected seconds, of {_LATEST:g} at most", path=path)
        # The decimal that a person would write: 2.235 is no double.
        clock = Clock(start=Fraction(repr(start)))
    known = _kinds(path, members, len(names))
    if not known:
        # Fours of an array that are rotations have no names that could say so.
        start = 0
        for table in tables:
            known |= {start + column: ChannelKind("quaternion") for column in table.rotations}
            start += len(table.names)
    return make_signal(path, names, values, rate, options, known, first_frame=first_frame, clock=clock)


@dataclass(frozen=True, eq=False)
class _Columns:
    """An array laid out: values (n_frames, n_channels), their plain names, and which columns are rotations by fours."""

    values: FloatArray
    names: tuple[str, ...]
    rotations: tuple[int, ...]


def _values(path: Path, array: StoredArray, prefix: str, points: tuple[str, ...], limits: Limits) -> _Columns:
    """Lay an array out as columns: (n_frames,), (n_frames, n_channels), (n_frames, n_points, n_numbers)."""
    shape = array.shape
    # A batch of one, as networks give it.
    if (len(shape) > 3 or (len(shape) == 3 and shape[1] > 1)) and shape[0] == 1:
        shape = shape[1:]
    if not 1 <= len(shape) <= 3 or 0 in shape:
        raise FormatError(
            f"{prefix or 'values'} have shape {array.shape}; expected (n_frames,), (n_frames, n_channels) or "
            "(n_frames, n_points, n_numbers)",
            path=path,
        )
    n_channels = math.prod(shape[1:])
    if n_channels > limits.channels:
        raise FormatError(f"{n_channels} channels, the limit is {limits.channels} (Limits.channels)", path=path)
    if shape[0] > limits.frames:
        raise FormatError(f"{shape[0]} frames, the limit is {limits.frames} (Limits.frames)", path=path)
    values = np.ascontiguousarray(floats_of(path, prefix or "values", array)).reshape(shape[0], n_channels)
    names = _plain_names(shape[1:], points, prefix)
    rotations: tuple[int, ...] = ()
    if len(shape) == 3 and shape[2] == 4:
        lengths = np.linalg.norm(values.reshape(-1, 4), axis=1)
        if np.isfinite(lengths).any() and np.nanmax(np.abs(lengths - 1)) < _UNIT_LENGTH:
            rotations = tuple(range(n_channels))
    return _Columns(values, names, rotations)


def _plain_names(shape: tuple[int, ...], points: tuple[str, ...] = (), prefix: str = "") -> tuple[str, ...]:
    """Name the columns of an array: c0 ..., of points m0.x ..., of a named array by its name."""
    n_channels = math.prod(shape)
    if len(shape) < 2:
        if prefix and n_channels == 3:
            return tuple(f"{prefix}.{axis}" for axis in "xyz")
        return tuple(f"{prefix}.{i}" for i in range(n_channels)) if prefix else numbered_names(n_channels)
    n_points, n_numbers = shape
    axes = tuple("xyz"[:n_numbers]) if n_numbers in (2, 3) else tuple(map(str, range(n_numbers)))
    named = points if len(points) == n_points else tuple(f"m{i}" for i in range(n_points))
    start = f"{prefix}." if prefix else ""
    return tuple(f"{start}{point}.{axis}" for point in named for axis in axes)


def _point_names(path: Path, members: dict[str, StoredArray], limits: Limits) -> tuple[str, ...]:
    """Return the names of points or joints that the archive has, if any."""
    for key in _POINT_NAMES:
        if key in members and members[key].kind in "SU" and len(members[key].shape) == 1:
            return _names(path, members[key], members[key].shape[0], limits)
    return ()


def _kinds(path: Path, members: dict[str, StoredArray], n_channels: int) -> dict[int, ChannelKind]:
    """Read what channels hold, as `write` writes it."""
    if "kinds" not in members:
        return {}
    texts = texts_of(path, "kinds", members["kinds"]) if members["kinds"].kind in "SU" else []
    if len(texts) != n_channels:
        raise FormatError(f"kinds are {n_channels} texts, one a channel; found {len(texts)}", path=path)
    words = [[] for _ in texts] if "words" not in members else _words(path, members, n_channels)
    try:
        return {
            place: replace(ChannelKind.parse(text), words=tuple(own))
            for place, (text, own) in enumerate(zip(texts, words, strict=True))
        }
    except OptionError as error:
        raise FormatError(f"kinds: {error}", path=path) from None


def _words(path: Path, members: dict[str, StoredArray], n_channels: int) -> list[list[str]]:
    """Part the words of all channels by how many each has."""
    counts = members.get("word_counts")
    words = members["words"]
    if counts is None or counts.kind not in "iu" or counts.shape != (n_channels,) or words.kind not in "SU":
        raise FormatError(f"words need word_counts, {n_channels} whole numbers, one a channel", path=path)
    texts = texts_of(path, "words", words)
    ends = np.cumsum(floats_of(path, "word_counts", counts)).astype(np.int64)
    if np.any(np.diff(ends, prepend=0) < 0) or int(ends[-1]) != len(texts):
        raise FormatError(f"word_counts say {int(ends[-1])} words, and {len(texts)} are there", path=path)
    return [texts[start:stop] for start, stop in zip([0, *ends[:-1].tolist()], ends.tolist(), strict=True)]


def _names(path: Path, array: StoredArray, n_channels: int, limits: Limits) -> tuple[str, ...]:
    if array.kind not in "SU" or array.shape != (n_channels,):
        raise FormatError(
            f"names have shape {array.shape} and kind {array.kind!r}; expected {n_channels} texts, one a channel",
            path=path,
        )
    if array.item_bytes > 4 * limits.name_bytes:
        raise FormatError(
            f"names of up to {array.item_bytes} bytes, the limit is {limits.name_bytes} (Limits.name_bytes)", path=path
        )
    names = texts_of(path, "names", array)
    first: dict[str, int] = {}
    for i, name in enumerate(names):
        if first.setdefault(name, i) != i:
            raise FormatError(f"channels {first[name]} and {i} are both called {name!r}", path=path)
    return tuple(names)


def _members(path: Path, data: bytes, options: ReadOptions) -> tuple[dict[str, StoredArray], tuple[str, ...]]:
    """Read the arrays of an archive that matter, and say which of them are the frames."""
    arrays: dict[str, StoredArray] = {}
    with archive_of(path, data, options.limits) as archive:
        by_name = {member.filename.removesuffix(".npy"): member for member in archive.infolist()}

        def parse(name: str) -> StoredArray:
            inflated = member_bytes(archive, by_name[name])
            if not inflated.startswith(MAGIC):
                raise FormatError(f"{by_name[name].filename} is no NumPy array", path=path)
            return parse_array(path, inflated, name, options)

        for name in (*_KNOWN_MEMBERS, *RATES, *_POINT_NAMES):
            if name in by_name:
                arrays[name] = parse(name)
        meant = _meant(path, by_name, options.arrays, parse)
        for name in meant:
            if name not in arrays:
                arrays[name] = parse(name)
    return arrays, meant


def _meant(
    path: Path, there: Iterable[str], chosen: tuple[str, ...], parse: Callable[[str], StoredArray]
) -> tuple[str, ...]:
    """Say which arrays hold the frames: those that were chosen, usual ones, or the only one that could."""
    names = list(there)
    listed = ", ".join(repr(name[:80]) for name in names[:8]) + (" ..." if len(names) > 8 else "") or "nothing"
    if chosen:
        for name in chosen:
            if name not in names:
                raise FormatError(f"the archive has no array called {name}; it has {listed}", path=path)
        return chosen
    for usual in _USUAL:
        if all(name in names for name in usual):
            return usual
    possible = []
    for name in names:
        if name in (*_KNOWN_MEMBERS, *RATES, *_POINT_NAMES):
            continue
        try:
            array = parse(name)
        except FormatError:
            # What is no plain array (an object, a picture) can't be the frames.
            continue
        if array.kind in "iuf" and len(array.shape) >= 2 and max(array.shape[:2]) > 1:
            possible.append(name)
    if len(possible) == 1:
        return (possible[0],)
    if possible:
        raise FormatError(
            f"the archive has no array called values; say which is meant (--array): {', '.join(possible[:8])}",
            path=path,
        )
    raise FormatError(f"the archive has no array called values; it has {listed}", path=path)


def write(signal: AnyMotion, path: Path, *, overwrite: bool) -> None:
    """Write a .npz archive with values, names and rate, or a .npy array of the values alone, of points as points.

    Parameters
    ----------
    signal : Signal
        What to write.
    path : Path
        Where; its ending says which.
    overwrite : bool
        Replace a file that is there.

    Raises
    ------
    OutputExistsError
        The file is there, and `overwrite` is not set.

    Warns
    -----
    FormatWarning
        A .npy can't hold the channels' names. (It never holds the rate: a reader asks for it.)
    """
    if not isinstance(signal, Signal):
        raise FormatError("a NumPy array holds a signal, not a motion", path=path)
    n_channels = len(signal.names)
    if path.suffix.lower() != ".npz":
        shapes = [(n_channels,), *((n_channels // n, n) for n in (3, 2, 4, 6) if n_channels % n == 0)]
        shape = next((shape for shape in shapes if _plain_names(shape) == signal.names), None)
        if shape is None:
            warnings.warn(
                f"{path}: a .npy holds numbers alone; the names of {n_channels} channels are not kept "
                "(a .npz keeps them)",
                FormatWarning,
                stacklevel=3,
            )
        write_bytes(path, array_bytes(signal.values.reshape(-1, *(shape or (n_channels,)))), overwrite=overwrite)
        return
    members = {"values": signal.values, "rate": np.array(str(signal.rate)), "names": np.array(signal.names)}
    members["kinds"] = np.array([str(kind) for kind in signal.kinds])
    words = [word for kind in signal.kinds for word in kind.words]
    if words:
        members["words"] = np.array(words)
        members["word_counts"] = np.array([len(kind.words) for kind in signal.kinds])
    if signal.first_frame:
        members["first_frame"] = np.array(signal.first_frame)
    if signal.clock.start is not None and signal.clock.start != signal.first_frame / signal.rate:
        members["start_time"] = np.array(signal.start_time)
    file = BytesIO()
    with zipfile.ZipFile(file, "w", zipfile.ZIP_STORED) as archive:
        for name, array in members.items():
            # The date is fixed, so that the same signal gives the same bytes.
            archive.writestr(zipfile.ZipInfo(f"{name}.npy"), array_bytes(array))
    write_bytes(path, file.getvalue(), overwrite=overwrite)
