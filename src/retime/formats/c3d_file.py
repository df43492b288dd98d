"""The layout of a C3D file: header, parameters, and where its frames are. Every claim is compared with the bytes.

A C3D is laid out in blocks of 512 bytes: a header, a section of parameters in named groups, and the frames, each with
the points' coordinates and then the analog samples that were taken during it.
"""

from __future__ import annotations

import math
import warnings
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from fractions import Fraction
from pathlib import Path

import numpy as np

from retime.arrays import FloatArray
from retime.brief import brief_repr
from retime.errors import FormatError, FormatWarning, OptionError
from retime.formats.c3d_numbers import MACHINES, Numbers
from retime.formats.file_signatures import foreign_kind
from retime.formats.read_options import ReadOptions
from retime.motion.rate import parse_rate

BLOCK = 512
MOST_COUNTED = 65535
"""The largest frame number that the header can hold."""
# Where the header has its numbers, in bytes.
AT_FIRST, AT_LAST, AT_RATE, AT_EVENT_COUNT, AT_EVENT_TIMES, MOST_HEADER_EVENTS = 6, 8, 20, 300, 304, 18
_AT_POINTS, _AT_ANALOG, _AT_SCALE, _AT_DATA, _AT_SAMPLES = 2, 4, 12, 16, 18
_AT_LABEL_KEY, _AT_EVENT_KEY, _AT_EVENT_LABELS = 294, 298, 396
_KEY = 12345
_ITEM_BYTES = {-1: 1, 1: 1, 2: 2, 4: 4}
# Parameters beyond so many are no capture's.
_MOST_PARAMETERS = 20_000


@dataclass(frozen=True)
class Parameter:
    """A named parameter.

    Attributes
    ----------
    kind : int
        -1 text, 1 bytes, 2 16-bit numbers, 4 real numbers.
    dimensions : tuple of int
        The first one runs fastest.
    start, n_bytes : int
        Where its data is in the file.
    """

    kind: int
    dimensions: tuple[int, ...]
    start: int
    n_bytes: int


@dataclass(frozen=True)
class Layout:
    """What a frame holds.

    Attributes
    ----------
    points : int
        Points.
    channels : int
        Analog channels.
    samples : int
        Analog samples of each channel in a frame.
    """

    points: int
    channels: int
    samples: int

    @property
    def numbers(self) -> int:
        """Numbers of a frame."""
        return 4 * self.points + self.channels * self.samples


@dataclass(frozen=True, eq=False)
class C3dFile:
    """A C3D that was taken apart.

    Attributes
    ----------
    path : Path
        For messages.
    data : bytes
        The file.
    numbers : Numbers
        How it stores them.
    parameters : mapping of str to Parameter
        By ``GROUP:NAME``, in capitals.
    layout : Layout
        What a frame holds.
    first, n_frames : int
        The number of its first frame, and how many there are.
    scale : float
        Of the points, where they are whole numbers; below 0 all numbers are real.
    rate : Fraction
        Frames a second.
    data_start : int
        Where the first frame begins, in bytes.
    """

    path: Path
    data: bytes
    numbers: Numbers
    parameters: Mapping[str, Parameter]
    layout: Layout
    first: int
    n_frames: int
    scale: float
    rate: Fraction
    data_start: int

    __repr__ = brief_repr

    @property
    def real(self) -> bool:
        """Whether its frames hold real numbers, not 16-bit ones."""
        return self.scale < 0

    @property
    def frame_bytes(self) -> int:
        """Bytes of a frame."""
        return self.layout.numbers * (4 if self.real else 2)

    @property
    def form(self) -> str:
        """Say how its numbers are stored, for people."""
        return f"{MACHINES[self.numbers.machine]}, {'real' if self.real else '16-bit'} numbers"

    def values(self, name: str) -> FloatArray | None:
        """Return the numbers of a parameter, flat; None where there is none such, or it holds text."""
        found = self.parameters.get(name)
        return None if found is None else numbers_of(self.data, self.numbers, found)

    def values_of(self, one: Parameter) -> FloatArray:
        """Return the numbers of a parameter that holds some, flat; they may be changed."""
        values = numbers_of(self.data, self.numbers, one)
        assert values is not None
        return values

    def number(self, name: str) -> float | None:
        """Return a parameter's first number, if it has one that is finite."""
        values = self.values(name)
        return float(values[0]) if values is not None and len(values) and math.isfinite(values[0]) else None

    def texts(self, name: str) -> list[str]:
        """Return the texts of a parameter, and of those that go on with it (LABELS, LABELS2, LABELS3 ...)."""
        found: list[str] = []
        for numbered in self.continued(name):
            one = self.parameters[numbered]
            if one.kind == -1 and one.n_bytes:
                size = one.dimensions[0] if one.dimensions else 1
                data = self.data[one.start : one.start + one.n_bytes]
                found += [_text(data[at : at + size]) for at in range(0, len(data), size)]
        return found

    def continued(self, name: str) -> Iterator[str]:
        """Name the parameters that hold one long list: NAME, NAME2, NAME3 ..."""
        number = 1
        while (numbered := name if number == 1 else f"{name}{number}") in self.parameters:
            yield numbered
            number += 1

    @property
    def event_times(self) -> list[str]:
        """Name the parameters that hold times of events: pairs of minutes and seconds."""
        return [name for name in self.continued("EVENT:TIMES") if self.parameters[name].kind == 4]

    @property
    def header_events(self) -> int:
        """How many events the header holds."""
        if self.numbers.word(self.data, _AT_EVENT_KEY) != _KEY:
            return 0
        return min(self.numbers.word(self.data, AT_EVENT_COUNT), MOST_HEADER_EVENTS)

    def events(self) -> list[tuple[float, str]]:
        """List the events, by time: seconds since frame 1, and what they are called."""
        found: list[tuple[float, str]] = []
        labels, contexts = self.texts("EVENT:LABELS"), self.texts("EVENT:CONTEXTS")
        used = self.number("EVENT:USED")
        times = [pair for name in self.event_times for pair in self._pairs(name)]
        if used is not None:
            times = times[: max(int(used), 0)]
        for place, (minutes, seconds) in enumerate(times):
            said = [texts[place] for texts in (contexts, labels) if place < len(texts) and texts[place]]
            found.append((60 * minutes + seconds, " ".join(said) or "event"))
        known = [time for time, _ in found]
        for place in range(self.header_events):
            at = _AT_EVENT_LABELS + 4 * place
            # The header counts from the first frame that is there, whatever its number.
            time = self.numbers.real(self.data, AT_EVENT_TIMES + 4 * place) + (self.first - 1) / float(self.rate)
            # Many files have an event in both places.
            if all(abs(time - other) > 0.5 / float(self.rate) for other in known):
                found.append((time, _text(self.data[at : at + 4]) or "event"))
        return sorted((time, label) for time, label in found if math.isfinite(time))

    def _pairs(self, name: str) -> list[tuple[float, float]]:
        values = self.values(name)
        flat = [] if values is None else values.tolist()
        return list(zip(flat[::2], flat[1::2], strict=False))


def numbers_of(data: bytes, numbers: Numbers, one: Parameter) -> FloatArray | None:
    """Return the numbers of a parameter, flat; None for text."""
    raw = data[one.start : one.start + one.n_bytes]
    if one.kind == 4:
        return numbers.reals(raw)
    if one.kind == 2:
        return numbers.words(raw)
    return None if one.kind == -1 else np.frombuffer(raw, dtype=np.uint8).astype(np.float64)


def _text(raw: bytes) -> str:
    raw = raw.split(b"\0")[0].strip()
    try:
        return raw.decode("utf-8")
    except UnicodeDecodeError:
        return raw.decode("latin-1")


def parse_c3d(path: Path, data: bytes, options: ReadOptions) -> C3dFile:
    """Take a C3D apart.

    Parameters
    ----------
    path : Path
        The file, for messages.
    data : bytes
        What it holds.
    options : ReadOptions
        What the reader was told: with ``repair`` the frames that are there of a file that was cut short are kept.

    Raises
    ------
    FormatError
        Not a C3D, parameters that lead out of their section, fewer frames than are claimed, or sizes past the limits.

    Warns
    -----
    FormatWarning
        Header and parameters disagree, or frames were left out.
    """
    section, numbers = _section(path, data)
    data_start = (numbers.word(data, _AT_DATA) - 1) * BLOCK
    end = data_start if section < data_start <= len(data) else len(data)
    parameters = _parameters(path, data, numbers, section + 4, end)

    def said(name: str) -> float | None:
        found = parameters.get(name)
        values = None if found is None else numbers_of(data, numbers, found)
        return float(values[0]) if values is not None and len(values) else None

    def number(name: str) -> float | None:
        value = said(name)
        return value if value is not None and math.isfinite(value) else None

    if data_start <= 0 and (start := number("POINT:DATA_START")):
        data_start = (int(start) - 1) * BLOCK
    if not BLOCK <= data_start <= len(data):
        raise FormatError(f"the frames begin at byte {data_start}; the file has {len(data)}", path=path, byte=_AT_DATA)
    scale = number("POINT:SCALE")
    if not scale:
        scale = numbers.real(data, _AT_SCALE)
    if not math.isfinite(scale):
        raise FormatError("the scale of the points is not a number", path=path, byte=_AT_SCALE)
    rate = _rate(path, said("POINT:RATE"), numbers.real(data, AT_RATE), options)
    word_bytes = 4 if scale < 0 else 2
    first, counts = _counts(numbers, data, parameters, number)
    there = len(data) - data_start
    layout, n_frames = _fitting(path, _layouts(numbers, data, number, float(rate)), counts, word_bytes, there)
    if layout.numbers == 0:
        raise FormatError("the file holds neither points nor analog channels", path=path)
    if scale == 0 and layout.points:
        raise FormatError("the points have the scale 0, so that all of them are at the origin", path=path)
    if 3 * layout.points > options.limits.channels or layout.channels > options.limits.channels:
        raise FormatError(
            f"{layout.points} points and {layout.channels} analog channels, the limit is {options.limits.channels} "
            "numbers (Limits.channels)",
            path=path,
        )
    if n_frames < 1:
        raise FormatError(f"frames {first} to {first + n_frames - 1} are none", path=path, byte=AT_FIRST)
    n_frames = _frames_there(path, n_frames, layout.numbers * word_bytes, there, len(data), repair=options.repair)
    if n_frames > options.limits.frames or n_frames * layout.samples > 8 * options.limits.frames:
        raise FormatError(f"{n_frames} frames, the limit is {options.limits.frames} (Limits.frames)", path=path)
    return C3dFile(path, data, numbers, parameters, layout, first, n_frames, scale, rate, data_start)


def _section(path: Path, data: bytes) -> tuple[int, Numbers]:
    """Find where the section of parameters begins, and how the file stores numbers; refuse what is no C3D."""
    if not data:
        raise FormatError("the file is empty; expected a C3D capture", path=path)
    if len(data) < 2 * BLOCK or data[1] != 0x50 or foreign_kind(data) not in (None, "a C3D capture"):
        kind = foreign_kind(data)
        if data[1:2] == b"\x50" and kind in (None, "a C3D capture"):
            raise FormatError(f"the file ends after {len(data)} bytes, before its parameters", path=path)
        raise FormatError(
            f"expected a C3D capture, {kind or 'found the bytes ' + data[:4].hex(' ')}", path=path, byte=0
        )
    section = (data[0] - 1) * BLOCK
    if data[0] < 2 or section + 4 > len(data):
        raise FormatError(f"the parameters begin in block {data[0]}, of {len(data) // BLOCK}", path=path, byte=0)
    machine = data[section + 3]
    if machine not in MACHINES:
        named = ", ".join(f"{number} ({name})" for number, name in MACHINES.items())
        raise FormatError(f"numbers of an unknown machine, {machine}; known are {named}", path=path, byte=section + 3)
    return section, Numbers(machine)


def _fitting(path: Path, layouts: list[Layout], counts: list[int], word_bytes: int, there: int) -> tuple[Layout, int]:
    """Choose what frames hold and how many there are: the first that is said, or what fits the bytes that are there."""

    def fits(layout: Layout, count: int) -> bool:
        # Frames end with a whole block, or just so.
        return 0 <= there - layout.numbers * word_bytes * count < BLOCK

    if fits(layouts[0], counts[0]):
        return layouts[0], counts[0]
    others = [(one, count) for one in layouts for count in counts if fits(one, count)]
    if not others:
        return layouts[0], counts[0]
    layout, n_frames = others[0]
    warnings.warn(
        f"{path}: header and parameters disagree about points, samples or frames; {n_frames} frames of "
        f"{layout.points} points fit the size of the file",
        FormatWarning,
        stacklevel=5,
    )
    return layout, n_frames


def _frames_there(path: Path, n_frames: int, frame_bytes: int, there: int, n_bytes: int, *, repair: bool) -> int:
    """Compare how many frames are claimed with the bytes that are there; return how many to read."""
    whole = there // frame_bytes
    if n_frames > whole:
        if not (repair and whole):
            raise FormatError(
                f"{n_frames} frames are claimed, and {whole} are there: the file ends after {n_bytes} bytes, and "
                f"would have {n_bytes - there + frame_bytes * n_frames}; --repair keeps what is there",
                path=path,
            )
        warnings.warn(f"{path}: {whole} of {n_frames} frames are there and were kept", FormatWarning, stacklevel=5)
        return whole
    if there - frame_bytes * n_frames >= BLOCK and whole > n_frames:
        warnings.warn(
            f"{path}: {n_frames} frames are claimed, but there is room for {whole}; the others are not read",
            FormatWarning,
            stacklevel=5,
        )
    return n_frames


def _parameters(path: Path, data: bytes, numbers: Numbers, start: int, end: int) -> dict[str, Parameter]:
    """Read the groups and parameters between two places of the file."""
    groups: dict[int, str] = {}
    found: list[tuple[int, str, Parameter]] = []
    at = start
    while at + 2 <= end:
        name_bytes, group = abs(_signed(data[at])), _signed(data[at + 1])
        if name_bytes == 0 or group == 0:
            break
        name = _text(data[at + 2 : at + 2 + name_bytes]).upper()
        link = at + 2 + name_bytes
        if link + 2 > end:
            raise FormatError("the parameters run past the end of their section", path=path, byte=at)
        step = numbers.word(data, link)
        if group < 0:
            groups[-group] = name
        else:
            found.append((group, name, _parameter(path, data, link + 2, end)))
        if step == 0:
            break
        if step < 2:
            raise FormatError(f"parameter {name!r} is followed {step} bytes on, inside itself", path=path, byte=link)
        at = link + step
        if len(found) + len(groups) > _MOST_PARAMETERS:
            raise FormatError(f"more than {_MOST_PARAMETERS} parameters", path=path, byte=at)
    parameters: dict[str, Parameter] = {}
    for group, name, one in found:
        # Of two with one name the first is meant.
        parameters.setdefault(f"{groups.get(group, group)}:{name}", one)
    return parameters


def _parameter(path: Path, data: bytes, at: int, end: int) -> Parameter:
    if at + 2 > end:
        raise FormatError("the parameters run past the end of their section", path=path, byte=at)
    kind, n_dimensions = _signed(data[at]), data[at + 1]
    if kind not in _ITEM_BYTES:
        raise FormatError(
            f"a parameter of kind {kind}; known are {', '.join(map(str, _ITEM_BYTES))}", path=path, byte=at
        )
    start = at + 2 + n_dimensions
    dimensions = tuple(data[at + 2 : start])
    n_bytes = math.prod(dimensions) * _ITEM_BYTES[kind]
    if start + n_bytes > end:
        raise FormatError(f"a parameter of {n_bytes} bytes runs past the end of its section, {end}", path=path, byte=at)
    return Parameter(kind, dimensions, start, n_bytes)


def _signed(byte: int) -> int:
    return byte - 256 if byte > 127 else byte


def _rate(path: Path, by_parameter: float | None, by_header: float, options: ReadOptions) -> Fraction:
    if options.rate is not None:
        return options.rate
    rate = by_header if by_parameter is None else by_parameter
    if not (math.isfinite(rate) and rate > 0):
        raise FormatError(f"a rate of {rate:g} frames a second; --fps says the right one", path=path, byte=AT_RATE)
    try:
        # The decimal that a person would write: as single precision it has digits that nobody meant.
        return parse_rate(str(np.float32(rate)))
    except OptionError as error:
        raise FormatError(f"{error}; --fps says the right one", path=path, byte=AT_RATE) from None


def _layouts(numbers: Numbers, data: bytes, number: Callable[[str], float | None], rate: float) -> list[Layout]:
    """List what a frame holds by the header, and by the parameters where they say something else."""
    points, total = numbers.word(data, _AT_POINTS), numbers.word(data, _AT_ANALOG)
    samples = max(numbers.word(data, _AT_SAMPLES), 1)
    used, own_points, analog_rate = _whole(number("ANALOG:USED")), _whole(number("POINT:USED")), number("ANALOG:RATE")
    if total % samples:
        samples = total // used if used and total % used == 0 else 1
    found = [Layout(points, total // samples, samples if total else 1)]
    own = Layout(
        points if own_points is None else own_points,
        found[0].channels if used is None else used,
        min(max(round(analog_rate / rate), 1), MOST_COUNTED) if analog_rate else samples,
    )
    if own.numbers != found[0].numbers:
        found.append(own)
    return found


def _whole(value: float | None) -> int | None:
    """Return a count, where a number is one that a C3D can hold."""
    return int(value) if value is not None and 0 <= value <= MOST_COUNTED else None


def _counts(
    numbers: Numbers, data: bytes, parameters: Mapping[str, Parameter], number: Callable[[str], float | None]
) -> tuple[int, list[int]]:
    """Return the number of the first frame, and how many there are by each place that says so, the likeliest first."""
    first, last = numbers.word(data, AT_FIRST), numbers.word(data, AT_LAST)
    start, end = (field(data, numbers, parameters.get(f"TRIAL:ACTUAL_{which}_FIELD")) for which in ("START", "END"))
    counts = []
    if start is not None and end is not None and 0 <= start <= end:
        first = start
        counts.append(end - start + 1)
    for name in ("POINT:LONG_FRAMES", "POINT:FRAMES"):
        claimed = number(name)
        if claimed is not None and claimed >= 1:
            counts.append(int(claimed))
    counts.append(last - numbers.word(data, AT_FIRST) + 1)
    return first, list(dict.fromkeys(counts))


def field(data: bytes, numbers: Numbers, one: Parameter | None) -> int | None:
    """Read the number of a frame, which may be a real number or two halves of a whole one; None where it is none."""
    values = None if one is None else numbers_of(data, numbers, one)
    if values is None or not len(values) or not math.isfinite(values[0]):
        return None
    if one is not None and one.kind == 2 and len(values) > 1:
        return int(values[0]) + (int(values[1]) << 16)
    return int(values[0])
