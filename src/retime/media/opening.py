"""Opening a media file as nothing but what it is, and looking through it once."""

from __future__ import annotations

import io
import threading
from dataclasses import dataclass
from fractions import Fraction
from pathlib import Path
from typing import Any, BinaryIO, Protocol

import numpy as np

from retime.arrays import BoolArray, IntArray
from retime.brief import brief_repr
from retime.errors import FormatError
from retime.limits import MOST_FRAMES
from retime.media.extras import needed
from retime.media.kinds import FORMATS, refuse_references
from retime.media.times import FrameTimes
from retime.motion.rate import rate_from_step, usual_rate

_START = 1 << 16
# Formats (as PyAV calls them) that have a constant rate, and for packets no time at which they are shown.
_IN_ORDER_OF_DECODING = ("avi", "mxf")
MOST_PIXELS = 1 << 27
"""Of a frame: 16,384 by 8,192."""


class SharedFile:
    """A file that several readers use, each at its own place."""

    def __init__(self, file: BinaryIO) -> None:
        self._file = file
        self._lock = threading.Lock()
        self.size = file.seek(0, io.SEEK_END)

    def read(self, start: int, count: int) -> bytes:
        """Read bytes at a place."""
        with self._lock:
            self._file.seek(start)
            return self._file.read(max(0, min(count, self.size - start)))

    def view(self) -> FileView:
        """Return a reader of its own."""
        return FileView(self)


class _Bytes(Protocol):
    """Bytes that are read at any place."""

    size: int

    def read(self, start: int, count: int) -> bytes:
        """Read bytes at a place."""


class FileView:
    """What PyAV needs of a file: read, seek, tell."""

    def __init__(self, shared: _Bytes) -> None:
        self._shared = shared
        self._place = 0

    def read(self, count: int = -1) -> bytes:
        """Read on."""
        data = self._shared.read(self._place, self._shared.size if count < 0 else count)
        self._place += len(data)
        return data

    def seek(self, offset: int, whence: int = 0) -> int:
        """Go to a place."""
        self._place = max(0, offset + (0, self._place, self._shared.size)[whence])
        return self._place

    def tell(self) -> int:
        """Return the place."""
        return self._place

    def seekable(self) -> bool:
        """Say that it can go to places."""
        return True

    def readable(self) -> bool:
        """Say that it can be read."""
        return True


class OutputAgain:
    """The output, which MP4 and MOV read again to lay their table of contents before it, so that it plays at once."""

    def __init__(self, target: BinaryIO) -> None:
        self._target = target
        self.size = 0

    def read(self, start: int, count: int) -> bytes:
        """Read bytes at a place; the place at which the output is written stays."""
        place = self._target.tell()
        self._target.seek(start)
        data = self._target.read(count)
        self._target.seek(place)
        return data

    def view(self) -> FileView:
        """Return a reader of what there is by now."""
        place = self._target.tell()
        self.size = self._target.seek(0, io.SEEK_END)
        self._target.seek(place)
        return FileView(self)


def _opens_nothing(url: str, flags: int, options: Any) -> Any:
    """Stand in for the opening of other files, which never is right."""
    raise PermissionError("a media file may not open another file")


def open_media(shared: SharedFile, path: Path) -> Any:
    """Open a file for decoding, as one of the formats that name no other file.

    Raises
    ------
    FormatError
        It is none, or damaged past opening.
    """
    av = needed("av")
    refuse_references(path, shared.read(0, _START))
    options = {
        # Whatever is nested is not opened: no protocol, and only these formats.
        "protocol_whitelist": "none",
        "format_whitelist": ",".join(FORMATS),
    }
    try:
        return av.open(
            shared.view(), mode="r", container_options=options, io_open=_opens_nothing, metadata_errors="replace"
        )
    except (av.FFmpegError, OSError, ValueError, UnicodeDecodeError) as error:
        raise FormatError(
            f"no video, pictures or sound that can be read, or not whole: {reason(error)}", path=path
        ) from None


def reason(error: BaseException) -> str:
    """Say what the decoder says, without the name that it gives a file."""
    text = getattr(error, "strerror", None) or str(error)
    return text.partition(": '")[0].partition("; last error log")[0] or type(error).__name__


@dataclass(frozen=True, eq=False)
class Scanned:
    """What a stream's packets say, without decoding them.

    Attributes
    ----------
    times : FrameTimes
        Of its frames, in the order of showing.
    keys : bool array
        Which frames can be begun with.
    counted : bool
        Whether packets say no times, or not those of showing, so that frames are counted.
    n_bytes : int
        Of all packets.
    seconds : float
        From the first frame to the end of the last, which may be shown for longer than the others.
    """

    times: FrameTimes
    keys: BoolArray
    counted: bool
    n_bytes: int
    seconds: float

    __repr__ = brief_repr


def scan(container: Any, stream: Any, path: Path, rate: Fraction | None) -> Scanned:
    """Look through the packets of a video stream.

    Parameters
    ----------
    container, stream
        Of PyAV.
    path : Path
        For messages.
    rate : Fraction, optional
        Frames a second, in place of what the file says.

    Raises
    ------
    FormatError
        No frame, or more than a clip may have.
    """
    av = needed("av")
    stamps: list[int] = []
    keys: list[bool] = []
    n_bytes, counted, stop = 0, False, 0
    try:
        for packet in container.demux(stream):
            if not packet.size:
                continue
            n_bytes += packet.size
            if packet.is_discard:
                continue
            counted |= packet.pts is None
            stamps.append(0 if packet.pts is None else packet.pts)
            stop = max(stop, stamps[-1] + (packet.duration or 0))
            keys.append(bool(packet.is_keyframe))
            if len(stamps) > MOST_FRAMES:
                raise FormatError(f"more than {MOST_FRAMES} frames", path=path)
    except av.FFmpegError as error:
        if not stamps:
            raise FormatError(f"its frames can't be read: {reason(error)}", path=path) from None
    if not stamps:
        raise FormatError("the video has no frame", path=path)
    said = stream.average_rate or stream.guessed_rate or Fraction(25)
    if container.format.name in _IN_ORDER_OF_DECODING and stream.codec_context.has_b_frames:
        # What the file numbers are packets as they are decoded, and frames are shown in another order.
        counted |= bool((np.diff(stamps) > 0).all())
    if counted:
        shown = rate or said
        times = FrameTimes(np.arange(len(stamps)), 1 / shown, shown, True)
        flags = np.zeros(len(stamps), dtype=bool)
        flags[0] = True
        return Scanned(times, flags, True, n_bytes, shown_seconds(times))
    array = np.array(stamps, dtype=np.int64)
    order = np.argsort(array, kind="stable")
    array, flags = array[order], np.array(keys)[order]
    fresh = np.append(True, np.diff(array) > 0)
    array, flags = array[fresh], flags[fresh]
    flags[0] = True
    times = frame_times(array, stream.time_base, said, rate)
    last = None if rate is not None else (stop - int(array[-1])) * stream.time_base
    return Scanned(times, flags, False, n_bytes, shown_seconds(times, last))


def shown_seconds(times: FrameTimes, last: Fraction | None = None) -> float:
    """Return how long frames are shown in all.

    Parameters
    ----------
    times : FrameTimes
        When each is.
    last : Fraction, optional
        For how many seconds the last one is, where somebody says so; it counts where it is more than rounding.
    """
    usual = 1 / times.rate
    shown = last if last is not None and last > usual * Fraction(3, 2) else usual
    return float(times.seconds[-1]) + float(shown)


def frame_times(stamps: IntArray, base: Fraction, said: Fraction, rate: Fraction | None) -> FrameTimes:
    """Find whether frames are evenly spaced, rounding to ticks aside, and their exact rate.

    Parameters
    ----------
    stamps : int array
        Increasing.
    base : Fraction
        Seconds a tick.
    said : Fraction
        The rate that the file says.
    rate : Fraction, optional
        The rate that a person says, which holds for evenly spaced frames whatever their stamps.
    """
    n = len(stamps)
    if rate is not None:
        return FrameTimes(np.arange(n), 1 / rate, rate, True)
    if n == 1:
        return FrameTimes(stamps, base, said, True)
    span = Fraction(int(stamps[-1] - stamps[0])) * base
    measured = (n - 1) / span
    for candidate in (said, rate_from_step(1 / measured, base / (n - 1) + Fraction(1, 10**12)), measured):
        off = (stamps - stamps[0]) * float(base) - np.arange(n) / float(candidate)
        # Half a tick each way, for stamps that are rounded, and as much for those that are cut; or of milliseconds,
        # which Matroska counts in, and which stay when a file becomes an MP4.
        tick = max(float(base), min(1e-3, 0.25 / float(candidate)))
        if np.abs(off).max() <= tick * 1.01 + 1e-9:
            return FrameTimes(stamps, base, Fraction(candidate), True)
    return FrameTimes(stamps, base, usual_rate(float(measured)), False)
