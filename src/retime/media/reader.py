"""Frames of a stream at random, at the cost of reading on where they are asked for in order."""

from __future__ import annotations

import bisect
import itertools
from collections import OrderedDict, deque
from collections.abc import Callable, Iterator
from fractions import Fraction
from io import BytesIO
from pathlib import Path
from typing import Any, Protocol

import numpy as np

from retime.errors import FormatError
from retime.media.extras import needed
from retime.media.opening import MOST_PIXELS, Scanned, SharedFile, open_media, reason, scan, shown_seconds
from retime.media.times import FrameTimes

# Of decoded frames that are kept: enough for a group of pictures of HD played backward in a few rounds.
_KEPT_BYTES = 96 << 20
_LEAST_KEPT = 6
# So many frames before the first that can be decoded are shown as that one: some seconds, as between two key frames.
_NEAR_AFTER = 600
_READ_OVER = 8
_WITH_ALPHA = {"vp8": "libvpx", "vp9": "libvpx-vp9"}

Beat = Callable[[], None]
"""Called whenever something was decoded."""


class FrameReader(Protocol):
    """Frames by their number in the order of showing; `seconds` is how long they are shown in all."""

    times: FrameTimes
    seconds: float

    def get(self, frame: int) -> Any:
        """Return a frame of PyAV."""


class _Kept:
    """The frames that were last made, within a number of bytes."""

    def __init__(self) -> None:
        self._frames: OrderedDict[int, Any] = OrderedDict()
        self._bytes = 0

    def __contains__(self, frame: int) -> bool:
        return frame in self._frames

    def get(self, frame: int) -> Any:
        self._frames.move_to_end(frame)
        return self._frames[frame]

    def put(self, frame: int, picture: Any) -> None:
        if frame in self._frames:
            return
        self._frames[frame] = picture
        self._bytes += bytes_of(picture)
        while self._bytes > _KEPT_BYTES and len(self._frames) > _LEAST_KEPT:
            _, dropped = self._frames.popitem(last=False)
            self._bytes -= bytes_of(dropped)


def bytes_of(picture: Any) -> int:
    """Return the bytes of a frame of PyAV."""
    return sum(plane.buffer_size for plane in picture.planes)


def decoder_of(stream: Any) -> Callable[[Any], list[Any]]:
    """Return what decodes packets; of WebM with alpha, which FFmpeg's own decoders leave out, that of libvpx."""
    name = _WITH_ALPHA.get(stream.codec_context.codec.canonical_name)
    if name is None or stream.metadata.get("alpha_mode") != "1":
        return lambda packet: list(packet.decode())
    context = needed("av").CodecContext.create(name, "r")
    context.thread_count = 0
    return lambda packet: list(context.decode(packet if packet.size else None))


class VideoReader:
    """The frames of a video stream.

    Parameters
    ----------
    shared : SharedFile
        The file.
    path : Path
        For messages.
    index : int
        Of the stream in its container.
    rate : Fraction, optional
        In place of what the file says.
    beat : function
        Called whenever something was decoded.
    whole : bool
        Make whole frames of those that are two fields, half a frame's time apart (interlaced).

    Attributes
    ----------
    in_fields : bool
        Whether a frame was met that is two fields.
    missing : set of int
        Frames that can't be decoded.
    """

    def __init__(
        self,
        shared: SharedFile,
        path: Path,
        index: int,
        rate: Fraction | None,
        beat: Beat,
        *,
        whole: bool = False,
    ) -> None:
        self._shared, self._path, self._index, self._beat = shared, path, index, beat
        self._whole = whole
        self.in_fields = False
        with open_media(shared, path) as container:
            stream = container.streams[index]
            context = stream.codec_context
            if context is None:
                raise FormatError(f"stream {index} is in a format that nothing here can decode", path=path)
            if not context.width * context.height:
                raise FormatError("no video that can be read: its frames have no size", path=path)
            if context.width * context.height > MOST_PIXELS:
                raise FormatError(
                    f"frames of {context.width} by {context.height} pixels; {MOST_PIXELS} pixels are the most",
                    path=path,
                )
            self.scanned: Scanned = scan(container, stream, path, rate)
        self.times, self.seconds = self.scanned.times, self.scanned.seconds
        self._stamps = self.scanned.times.stamps
        if rate is not None and not self.scanned.counted:
            # Frames are found by the file's own stamps, whatever rate is said for them.
            with open_media(shared, path) as container:
                self._stamps = scan(container, container.streams[index], path, None).times.stamps
        self.first_stamp = int(self._stamps[0])
        self._keys = np.flatnonzero(self.scanned.keys)
        self._kept = _Kept()
        self._container: Any = None
        self._frames: Iterator[tuple[int, Any]] = iter(())
        self._place = -1
        self.missing: set[int] = set()

    def close(self) -> None:
        """Close the file."""
        if self._container is not None:
            # The decoder's threads may be at work, and what they say of damage waits for Python, which would wait for
            # them to end: a deadlock. This lets them come to rest while Python goes on.
            self._container.streams[self._index].codec_context.flush_buffers()
            self._container.close()
            self._container = None

    def get(self, frame: int) -> Any:
        """Return a frame of PyAV; one that can't be decoded is shown as the one before it."""
        if frame not in self._kept:
            key = bisect.bisect_right(self._keys, frame) - 1
            ahead = int(self._keys[key]) - self._place
            # Reading over a few frames is cheaper than seeking.
            if self._container is None or frame <= self._place or ahead > _READ_OVER:
                self._go_before(frame, key)
            self._read_to(frame)
        return self._kept.get(frame)

    def _go_before(self, frame: int, key: int) -> None:
        """Go to the last frame that can be begun with; where the file is sought in badly, to one before it."""
        for back in (0, 1, 4, len(self._keys)):
            start = int(self._keys[max(0, key - back)])
            self._go_to(start)
            if start == 0:
                return
            first = next(self._frames, None)
            if first is not None and first[0] <= frame:
                self._frames = itertools.chain([first], self._frames)
                return

    def _go_to(self, key: int) -> None:
        """Go to a frame that can be begun with."""
        av = needed("av")
        seekable = bool(key) and not self.scanned.counted
        if self._container is None or not seekable:
            self._reopen()
        if seekable:
            try:
                stream = self._container.streams[self._index]
                self._container.seek(int(self._stamps[key]), stream=stream, backward=True)
            except av.FFmpegError:
                # It can't be sought in: begin again.
                self._reopen()
        self._frames, self._place = self._made_whole() if self._whole else self._decoded(), -1

    def _reopen(self) -> None:
        self.close()
        self._container = open_media(self._shared, self._path)
        self._container.streams[self._index].thread_type = "AUTO"

    def _decoded(self) -> Iterator[tuple[int, Any]]:
        """Decode on; frames with their numbers."""
        av = needed("av")
        number = -1
        packets = self._container.demux(self._container.streams[self._index])
        decode = decoder_of(self._container.streams[self._index])
        while True:
            try:
                packet = next(packets, None)
            except av.FFmpegError:
                # The file is cut, or damaged past what the format can find its way in.
                return
            if packet is None:
                return
            try:
                pictures = decode(packet)
            except av.FFmpegError:
                # A damaged packet; what comes after it may be whole.
                pictures = []
            self._beat()
            for picture in pictures:
                if self.scanned.counted or picture.pts is None:
                    number += 1
                else:
                    number = int(np.searchsorted(self._stamps, picture.pts, side="right")) - 1
                if 0 <= number < len(self._stamps):
                    self.in_fields |= bool(picture.interlaced_frame)
                    yield number, picture

    def _made_whole(self) -> Iterator[tuple[int, Any]]:
        """Decode on, and make whole frames of those that are two fields: the first stays, what is between is made."""
        fields: _Fields | None = None
        for number, picture in self._decoded():
            if picture.interlaced_frame:
                if fields is None:
                    fields = _Fields(picture)
                yield from fields.take(number, picture)
            else:
                if fields is not None:
                    yield from fields.rest()
                    fields = None
                yield number, picture
        if fields is not None:
            yield from fields.rest()

    def _read_to(self, frame: int) -> None:
        """Decode until a frame is there; where it never comes, the nearest before it stands for it."""
        before = None
        for number, picture in self._frames:
            self._place = max(self._place, number)
            self._kept.put(number, picture)
            if number <= frame:
                before = picture
            if number >= frame:
                break
        if frame in self._kept:
            return
        self.missing.add(frame)
        if before is None:
            # What begins in the middle of something shows nothing before its first whole frame.
            around = itertools.chain(range(frame - 1, max(-1, frame - 64), -1), range(frame + 1, frame + _NEAR_AFTER))
            near = next((other for other in around if other in self._kept), None)
            if near is None:
                raise FormatError(f"frame {frame} of the video can't be decoded, nor any near it", path=self._path)
            before = self._kept.get(near)
        self._place = max(self._place, frame)
        self._kept.put(frame, before)


class _Fields:
    """FFmpeg's filter bwdif, which looks a frame ahead and gives a frame for each."""

    def __init__(self, picture: Any) -> None:
        av = needed("av")
        self._again: tuple[type[BaseException], ...] = (av.BlockingIOError, av.EOFError)
        self._numbers: deque[int] = deque()
        self._graph = av.filter.Graph()
        source = self._graph.add_buffer(
            width=picture.width, height=picture.height, format=picture.format, time_base=Fraction(1, 1000)
        )
        whole = self._graph.add("bwdif", "mode=send_frame:parity=auto:deint=all")
        # In the format that it came in, whichever the filter takes.
        kept = self._graph.add("format", f"pix_fmts={picture.format.name}")
        self._graph.link_nodes(source, whole, kept, self._graph.add("buffersink")).configure()
        self._count = 0

    def take(self, number: int, picture: Any) -> Iterator[tuple[int, Any]]:
        """Take a frame; those that are done by now, with their numbers."""
        self._numbers.append(number)
        # Stamps of its own: a damaged file's may go back.
        self._count += 1
        picture.pts, picture.time_base = self._count, Fraction(1, 1000)
        self._graph.push(picture)
        yield from self._done()

    def rest(self) -> Iterator[tuple[int, Any]]:
        """Return the last frames."""
        self._graph.push(None)
        yield from self._done()

    def _done(self) -> Iterator[tuple[int, Any]]:
        while self._numbers:
            try:
                made = self._graph.pull()
            except self._again:
                return
            yield self._numbers.popleft(), made


class PictureReader:
    """Numbered pictures as frames.

    Parameters
    ----------
    files : list of Path
        In their order.
    rate : Fraction
        Frames a second.
    beat : function
        Called whenever something was decoded.
    """

    def __init__(self, files: list[Path], rate: Fraction, beat: Beat) -> None:
        self._files, self._beat = files, beat
        self.times = FrameTimes(np.arange(len(files)), 1 / rate, rate, True)
        self.seconds = shown_seconds(self.times)
        self._kept = _Kept()

    def get(self, frame: int) -> Any:
        """Return a frame of PyAV."""
        if frame not in self._kept:
            path = self._files[frame]
            av = needed("av")
            from retime.files import read_bytes

            shared = SharedFile(BytesIO(read_bytes(path)))
            with open_media(shared, path) as container:
                if not container.streams.video:
                    raise FormatError("no picture", path=path)
                context = container.streams.video[0].codec_context
                if not 0 < context.width * context.height <= MOST_PIXELS:
                    raise FormatError(
                        f"a picture of {context.width} by {context.height} pixels is too large", path=path
                    )
                try:
                    picture = next(container.decode(video=0), None)
                except av.FFmpegError as error:
                    raise FormatError(f"a damaged picture: {reason(error)}", path=path) from None
            if picture is None:
                raise FormatError("no picture", path=path)
            self._kept.put(frame, picture)
            self._beat()
        return self._kept.get(frame)


class ListReader:
    """Frames that are in memory: those of an animated WebP, which is decoded as a whole.

    Parameters
    ----------
    pictures : list of VideoFrame
        Of PyAV.
    times : FrameTimes
        When they are shown.
    seconds : float
        For how long in all.
    """

    def __init__(self, pictures: list[Any], times: FrameTimes, seconds: float) -> None:
        self._pictures, self.times, self.seconds = pictures, times, seconds

    def get(self, frame: int) -> Any:
        """Return a frame of PyAV."""
        return self._pictures[frame]
