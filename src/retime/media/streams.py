"""What a file holds: its streams, and how the frames of its pictures are come by."""

from __future__ import annotations

from fractions import Fraction
from pathlib import Path
from typing import Any, BinaryIO, NamedTuple

import numpy as np

from retime.errors import FormatError
from retime.media.extras import needed
from retime.media.kinds import find_sequence, is_sequence
from retime.media.opening import SharedFile, frame_times, open_media, shown_seconds
from retime.media.reader import Beat, FrameReader, ListReader, PictureReader, VideoReader

USUAL_RATE = Fraction(24)
"""Frames a second of numbered pictures, which say none."""
_MOST_WEBP_BYTES = 1 << 30


class Streams(NamedTuple):
    """The streams of a container, parted by their kind, each by its number.

    Attributes
    ----------
    pictures, covers, sounds, texts, others : list of int
        Video; single pictures that stand for the file; sound; subtitles; and what nothing here knows.
    """

    pictures: list[int]
    covers: list[int]
    sounds: list[int]
    texts: list[int]
    others: list[int]


def streams_of(container: Any) -> Streams:
    """Part the streams of a container of PyAV by their kind."""
    found = Streams([], [], [], [], [])
    chapters = len(container.chapters())
    for stream in container.streams:
        if stream.type == "video":
            cover = "attached_pic" in str(stream.disposition) or "timed_thumbnails" in str(stream.disposition)
            (found.covers if cover else found.pictures).append(stream.index)
        elif stream.type == "audio":
            found.sounds.append(stream.index)
        elif stream.type == "subtitle":
            found.texts.append(stream.index)
        elif not (chapters and stream.name == "bin_data" and stream.frames == chapters):
            # MP4 and MOV have the chapters' names as a stream too; it is made anew with them.
            found.others.append(stream.index)
    return found


def uncontained_frames(path: Path, source: BinaryIO | None, fps: Fraction | None, beat: Beat) -> FrameReader | None:
    """Return a reader of what is no container of streams, numbered pictures or an animated WebP; else None.

    Parameters
    ----------
    path : Path
        The file, or the pattern of its name.
    source : file, optional
        Open; None for numbered pictures.
    fps : Fraction, optional
        Frames a second, in place of what the file says.
    beat : function
        Called whenever something was decoded.

    Raises
    ------
    FormatError
        A picture is missing among others, or the WebP is damaged.
    """
    if is_sequence(path):
        sequence = find_sequence(path)
        return PictureReader([sequence.file(number) for number in sequence.numbers], fps or USUAL_RATE, beat)
    assert source is not None
    shared = SharedFile(source)
    start = shared.read(0, 32)
    if start[:4] == b"RIFF" and start[8:16] == b"WEBPVP8X" and start[20] & 2:
        return _webp_frames(shared, path, fps)
    return None


def first_frames(path: Path, source: BinaryIO | None, fps: Fraction | None, beat: Beat) -> FrameReader:
    """Return a reader of the first stream of frames that a file has.

    Parameters
    ----------
    path, source, fps, beat
        As of `uncontained_frames`.

    Raises
    ------
    FormatError
        There is none, or it is damaged.
    """
    reader = uncontained_frames(path, source, fps, beat)
    if reader is not None:
        return reader
    assert source is not None
    shared = SharedFile(source)
    with open_media(shared, path) as container:
        pictures = streams_of(container).pictures
    if not pictures:
        raise FormatError("no video: a warp is found from what a video shows", path=path)
    return VideoReader(shared, path, pictures[0], fps, beat, whole=True)


def _webp_frames(shared: SharedFile, path: Path, fps: Fraction | None) -> ListReader:
    """Decode an animated WebP, which FFmpeg doesn't, as a whole."""
    av, cv2 = needed("av"), needed("cv2")
    data = np.frombuffer(shared.read(0, shared.size), np.uint8)
    width, height = (1 + int.from_bytes(data[at : at + 3].tobytes(), "little") for at in (24, 27))
    n_frames = data.tobytes().count(b"ANMF")
    if width * height * 4 * n_frames > _MOST_WEBP_BYTES:
        raise FormatError(
            f"an animation of {n_frames} frames of {width} by {height} pixels; a WebP is decoded as a whole, and 1 GB "
            "is the most",
            path=path,
        )
    good, animation = cv2.imdecodeanimation(data)
    if not good or not len(animation.frames):
        raise FormatError("a WebP that can't be decoded", path=path)
    pictures = []
    for frame in animation.frames:
        form = "bgra" if frame.shape[2] == 4 else "bgr24"
        pictures.append(av.VideoFrame.from_ndarray(np.ascontiguousarray(frame), format=form))
    stamps = np.concatenate([[0], np.cumsum(np.maximum(1, np.array(animation.durations[:-1], np.int64)))])
    last = max(1, int(animation.durations[-1]))
    mean = Fraction(1000 * len(stamps), int(stamps[-1]) + last)
    times = frame_times(stamps, Fraction(1, 1000), mean, fps)
    return ListReader(pictures, times, shown_seconds(times, None if fps else Fraction(last, 1000)))
