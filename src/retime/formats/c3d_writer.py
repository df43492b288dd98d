"""A plain C3D of a signal: markers, and its other channels as analog ones with one sample a frame."""

from __future__ import annotations

import re
import struct
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from retime.errors import FormatError
from retime.formats.c3d_file import BLOCK, MOST_COUNTED
from retime.formats.c3d_numbers import INTEL
from retime.motion.signal import Signal

_AXIS = re.compile(r"(?P<stem>.+)[._ ](?P<axis>[xyz])", flags=re.IGNORECASE)
# A parameter's list goes on in the next one where it would be longer: a byte counts its items, and not all programs
# take more bytes than a signed 16-bit number counts.
_MOST_ITEMS, _MOST_BYTES, _LONGEST = 255, 30_000, 127


def markers_of(signal: Signal) -> dict[str, tuple[int, int, int]]:
    """Find the markers among channels, by name: places of NAME.x, NAME.y and NAME.z (or NAME_X ..., NAME x ...)."""
    stems: dict[str, dict[str, int]] = {}
    for place, (name, kind) in enumerate(zip(signal.names, signal.kinds, strict=True)):
        if kind.kind == "linear" and (found := _AXIS.fullmatch(name)):
            stems.setdefault(found["stem"], {}).setdefault(found["axis"].lower(), place)
    return {stem: (axes["x"], axes["y"], axes["z"]) for stem, axes in stems.items() if len(axes) == 3}


def c3d_of(signal: Signal, path: Path) -> bytes:
    """Make a C3D, of real numbers as an Intel machine has them.

    Parameters
    ----------
    signal : Signal
        Channels called NAME.x, NAME.y, NAME.z are markers, in the unit of their kinds; the others are analog channels.
        A gap is a missing point.
    path : Path
        For messages.

    Raises
    ------
    FormatError
        There is no marker, a channel holds text, or names or numbers are more than a C3D can hold.
    """
    markers = markers_of(signal)
    if not markers:
        raise FormatError(
            "a C3D holds markers, and no three channels are called NAME.x, NAME.y, NAME.z; .csv and .npz hold any "
            "channels",
            path=path,
        )
    marked = {place for axes in markers.values() for place in axes}
    others = [place for place in range(len(signal.names)) if place not in marked]
    words = [signal.names[place] for place in others if signal.kinds[place].words]
    if words:
        raise FormatError(f"a C3D holds numbers, and channel {words[0]!r} holds text; .csv holds both", path=path)
    values = signal.values
    if np.nanmax(np.abs(values), initial=0.0) > np.finfo(np.float32).max:
        raise FormatError("a number is beyond what single precision, which a C3D has, can hold", path=path)
    n_frames = signal.n_frames
    points = np.zeros((n_frames, len(markers), 4))
    points[..., :3] = values[:, list(markers.values())]
    missing = np.isnan(points).any(axis=2)
    points[missing] = (0.0, 0.0, 0.0, -1.0)
    first = round(signal.start_time * float(signal.rate)) + 1 if signal.clock.start is not None else signal.first_frame
    first = first if 1 <= first <= MOST_COUNTED else 1
    head = _head(signal, markers, others, first, path)
    rows = np.concatenate([points.reshape(n_frames, -1), values[:, others]], axis=1).astype("<f4").tobytes()
    return head + rows + b"\0" * (-len(rows) & (BLOCK - 1))


def _head(signal: Signal, markers: dict[str, tuple[int, int, int]], others: list[int], first: int, path: Path) -> bytes:
    rate, n_frames = float(signal.rate), signal.n_frames
    last = first + n_frames - 1
    units = {signal.kinds[place].unit for axes in markers.values() for place in axes}
    unit = units.pop() if len(units) == 1 else ""
    names = [signal.names[place] for place in others]
    for name in (*markers, *names):
        if len(name.encode()) > _LONGEST:
            raise FormatError(f"a name of more than {_LONGEST} bytes: {name[:60]!r} ...", path=path)
    if max(4 * len(markers), len(others)) > MOST_COUNTED:
        raise FormatError(f"{len(markers)} markers and {len(others)} channels are more than a C3D counts", path=path)

    def section(start: int) -> bytes:
        groups = {
            "POINT": _word("USED", len(markers))
            + _real("SCALE", -1.0)
            + _real("RATE", rate)
            + _word("DATA_START", start)
            + _word("FRAMES", min(n_frames, MOST_COUNTED))
            + _texts("LABELS", list(markers))
            + (_texts("UNITS", [unit]) if unit else []),
            "ANALOG": _word("USED", len(others)) + _real("RATE", rate) + _real("GEN_SCALE", 1.0),
            "TRIAL": _words("ACTUAL_START_FIELD", [first & 0xFFFF, first >> 16])
            + _words("ACTUAL_END_FIELD", [last & 0xFFFF, last >> 16]),
        }
        if others:
            groups["ANALOG"] += _texts("LABELS", names) + _words("OFFSET", [0] * len(others))
            groups["ANALOG"] += _reals("SCALE", [1.0] * len(others))
            groups["ANALOG"] += _texts("UNITS", [signal.kinds[place].unit for place in others])
        parts = []
        for number, (group, parameters) in enumerate(groups.items(), start=1):
            parts.append(_linked(group, -number, b"\0"))
            parts += [_linked(name, number, body + b"\0") for name, body in parameters]
        data = b"".join(parts) + b"\0\0"
        n_blocks = -(-(len(data) + 4) // BLOCK)
        if n_blocks > 255:
            raise FormatError(f"the names of {len(markers)} markers are more than a C3D can hold", path=path)
        return (bytes([1, 0x50, n_blocks, INTEL]) + data).ljust(n_blocks * BLOCK, b"\0")

    start = 2 + len(section(0)) // BLOCK
    header = struct.pack(
        "<BBHHHHHfHHf",
        2,
        0x50,
        len(markers),
        len(others),
        first,
        min(last, MOST_COUNTED),
        0,
        -1.0,
        start,
        1,
        rate,
    )
    return header.ljust(BLOCK, b"\0") + section(start)


_Bodies = list[tuple[str, bytes]]


def _linked(name: str, group: int, body: bytes) -> bytes:
    """Put a group or parameter together, with how far the next one is."""
    text = name.encode()
    return struct.pack("<bb", len(text), group) + text + struct.pack("<H", 2 + len(body)) + body


def _word(name: str, value: int) -> _Bodies:
    return [(name, struct.pack("<bBH", 2, 0, value))]


def _real(name: str, value: float) -> _Bodies:
    return [(name, struct.pack("<bBf", 4, 0, value))]


def _words(name: str, values: Sequence[int]) -> _Bodies:
    return _lists(name, 2, [struct.pack("<H", value) for value in values])


def _reals(name: str, values: Sequence[float]) -> _Bodies:
    return _lists(name, 4, [struct.pack("<f", value) for value in values])


def _texts(name: str, texts: Sequence[str]) -> _Bodies:
    size = max(1, *(len(text.encode()) for text in texts))
    return _lists(name, -1, [text.encode().ljust(size) for text in texts])


def _lists(name: str, kind: int, items: Sequence[bytes]) -> _Bodies:
    """Lay a list out, over NAME, NAME2, NAME3 ... where it is long."""
    size = len(items[0])
    most = min(_MOST_ITEMS, _MOST_BYTES // size)
    found = []
    for number, at in enumerate(range(0, len(items), most), start=1):
        part = items[at : at + most]
        dimensions = bytes([size, len(part)] if kind == -1 else [len(part)])
        body = struct.pack("<bB", kind, len(dimensions)) + dimensions + b"".join(part)
        found.append((name if number == 1 else f"{name}{number}", body))
    return found
