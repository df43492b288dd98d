"""The samples of a sound stream at random: decoded once, onto the disk."""

from __future__ import annotations

import contextlib
from collections.abc import Callable
from fractions import Fraction
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np

from retime.errors import FormatError
from retime.media.extras import needed
from retime.media.opening import SharedFile, open_media
from retime.media.sound import Samples

# Of samples that there may be: two days of stereo.
_MOST_BYTES = 64 << 30
# Stamps are rounded to their clocks; a jump of more seconds than this is a gap.
_JUMP = 0.03


def _layout_of(stream: Any) -> str:
    """Name where a stream's channels are heard; where the file doesn't say, as is usual for so many.

    Examples of the names are "mono", "stereo" and "5.1"; more channels than anybody places are just counted.
    """
    av = needed("av")
    name = str(stream.layout.name)
    if name == f"{stream.layout.nb_channels} channels":
        with contextlib.suppress(ValueError):
            return str(av.AudioLayout(f"{stream.layout.nb_channels}c").name)
    return name


class SoundReader:
    """The samples of one stream.

    Parameters
    ----------
    shared : SharedFile
        The file.
    path : Path
        For messages.
    index : int
        Of the stream in its container.
    origin : Fraction, optional
        Seconds of the file's clock that count as 0; left out, the stream's own first sample.
    spool : file
        Empty, for the samples.
    beat : function
        Called whenever something was decoded.
    """

    def __init__(
        self,
        shared: SharedFile,
        path: Path,
        index: int,
        origin: Fraction | None,
        spool: BinaryIO,
        beat: Callable[[], None],
    ) -> None:
        av = needed("av")
        self._file = spool
        with open_media(shared, path) as container:
            stream = container.streams[index]
            if stream.codec_context is None:
                raise FormatError(f"stream {index} is in a format that nothing here can decode", path=path)
            self.rate = int(stream.rate)
            self.layout = _layout_of(stream)
            self.n_channels: int = stream.layout.nb_channels
            if not (1 <= self.n_channels <= 64 and 1000 <= self.rate <= 768_000):
                raise FormatError(
                    f"sound of {self.n_channels} channels at {self.rate} Hz; 1 to 64 channels at 1 to 768 kHz are "
                    "expected",
                    path=path,
                )
            resampler = av.AudioResampler(format="flt", layout=self.layout, rate=self.rate)
            self._count = 0
            self.start = 0
            self.damaged = False
            known = origin
            packets = container.demux(stream)
            while True:
                try:
                    packet = next(packets, None)
                except av.FFmpegError:
                    self.damaged = True
                    break
                if packet is None:
                    break
                try:
                    frames = packet.decode()
                except av.FFmpegError:
                    self.damaged, frames = True, []
                for frame in frames:
                    if known is None:
                        known = Fraction(0) if frame.pts is None else frame.pts * frame.time_base
                    self._take(frame, resampler, known, path)
                beat()
            if known is not None:
                for frame in resampler.resample(None):
                    self._append(frame)
        if not self._count:
            raise FormatError("its sound has no sample that can be decoded", path=path)

    @property
    def seconds(self) -> float:
        """When the last sample ends, after time 0."""
        return (self.start + self._count) / self.rate

    def _take(self, frame: Any, resampler: Any, origin: Fraction, path: Path) -> None:
        """Write a frame where its stamp has it."""
        if frame.pts is not None:
            place = round((frame.pts * frame.time_base - origin) * self.rate)
            if not self._count:
                self.start = place
            gap = place - self.start - self._count
            if gap > _JUMP * self.rate:
                self._silence(gap, path)
        frame.pts = None
        for made in resampler.resample(frame):
            self._append(made)
        if self._count * self.n_channels * 4 > _MOST_BYTES:
            raise FormatError(f"its sound is more than {_MOST_BYTES >> 30} GB long", path=path)

    def _silence(self, count: int, path: Path) -> None:
        if (self._count + count) * self.n_channels * 4 > _MOST_BYTES:
            raise FormatError("the stamps of its sound jump further than sound can be long", path=path)
        self._file.seek(self._count * self.n_channels * 4)
        self._count += count
        block = bytes(self.n_channels * 4 * self.rate)
        while count > 0:
            self._file.write(block[: min(count, self.rate) * self.n_channels * 4])
            count -= self.rate

    def _append(self, frame: Any) -> None:
        samples = frame.to_ndarray().reshape(-1)
        self._file.seek(self._count * self.n_channels * 4)
        self._file.write(np.ascontiguousarray(samples, np.float32).tobytes())
        self._count += len(samples) // self.n_channels

    def read(self, first: int, count: int) -> Samples:
        """Return samples (n_channels, count) from one on, counted from time 0; silence where there are none."""
        made = np.zeros((self.n_channels, count), np.float32)
        low, high = max(first, self.start), min(first + count, self.start + self._count)
        if high > low:
            self._file.seek((low - self.start) * self.n_channels * 4)
            data = self._file.read((high - low) * self.n_channels * 4)
            made[:, low - first : high - first] = np.frombuffer(data, np.float32).reshape(-1, self.n_channels).T
        return made
