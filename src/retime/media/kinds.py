"""What a media file is: by its name, and by what it holds.

A decoder library opens whatever it takes a file for: a playlist called ``take.mp4`` makes it open other files, or
addresses in the network. So a file is looked at here first, and opened only as one of the formats listed, none of which
names other files.
"""

from __future__ import annotations

import itertools
import re
from dataclasses import dataclass
from pathlib import Path

from retime.errors import FormatError, OptionError

VIDEO_SUFFIXES = (
    ".mp4", ".mov", ".m4v", ".mkv", ".webm", ".avi", ".ts", ".mts", ".m2ts", ".mpg", ".mpeg", ".mxf", ".3gp", ".ogv",
)  # fmt: skip
ANIMATION_SUFFIXES = (".gif", ".webp", ".apng")
SOUND_SUFFIXES = (".wav", ".flac", ".opus", ".ogg", ".mp3", ".m4a", ".aac", ".mka", ".aiff", ".aif")
PICTURE_SUFFIXES = (".png", ".jpg", ".jpeg", ".tif", ".tiff", ".exr", ".dpx", ".bmp", ".webp")
_PATTERN = re.compile(r"%0?(\d{0,2})d", re.ASCII)

# Names of demuxers. Each reads one file and nothing else (mov: only with options that stay off).
FORMATS = (
    "mov,mp4,m4a,3gp,3g2,mj2", "matroska,webm", "avi", "mpegts", "mpeg", "mxf", "ogg", "gif", "apng", "wav", "w64",
    "flac", "mp3", "aac", "aiff", "nut", "flv", "asf", "h264", "hevc", "m4v", "mpegvideo", "ivf", "dv", "yuv4mpegpipe",
    "png_pipe", "jpeg_pipe", "tiff_pipe", "exr_pipe", "dpx_pipe", "bmp_pipe", "webp_pipe",
)  # fmt: skip

# What a file begins with that names other files; blanks and a byte order mark aside, in any case.
_NAMES_OTHERS = (
    (b"#extm3u", "a playlist (M3U, HLS)"),
    (b"ffconcat", "a list of files to join (concat)"),
    (b"file ", "a list of files to join (concat)"),
    (b"file\t", "a list of files to join (concat)"),
    (b"[playlist]", "a playlist (PLS)"),
    (b"<asx", "a playlist (ASX)"),
    (b"v=0", "a description of a session (SDP)"),
    (b"rtsptext", "a reference to a stream (RTSP)"),
    (b"smptetext", "a reference to a stream"),
    (b"[reference]", "a playlist (ASF reference)"),
    (b";ffmetadata", "metadata without media"),
    (b"http://", "an address in the network"),
    (b"https://", "an address in the network"),
    (b"rtmp", "an address in the network"),
)
_XML_OTHERS = ((b"<mpd", "a playlist (DASH)"), (b"<smil", "a playlist (SMIL)"), (b"<playlist", "a playlist (XSPF)"))


@dataclass(frozen=True)
class Sequence:
    """Numbered pictures: ``take.%04d.png``.

    Attributes
    ----------
    path : Path
        With the pattern in its name.
    numbers : tuple of int
        Of the files that are there, increasing, without gaps.
    """

    path: Path
    numbers: tuple[int, ...]

    def file(self, number: int) -> Path:
        """Return the file with a number."""
        return self.path.with_name(numbered(self.path.name, number))


def numbered(name: str, number: int) -> str:
    """Put a number where a name's pattern is."""
    match = _PATTERN.search(name)
    assert match is not None
    width = int(match[1] or 0)
    return f"{name[: match.start()]}{number:0{width}d}{name[match.end() :]}"


def is_sequence(path: Path) -> bool:
    """Tell whether a name stands for numbered pictures."""
    return _PATTERN.search(path.name) is not None and path.suffix.lower() in PICTURE_SUFFIXES


def is_media(path: Path) -> bool:
    """Tell by a file's name whether it holds video, pictures or sound."""
    suffix = path.suffix.lower()
    return suffix in VIDEO_SUFFIXES + ANIMATION_SUFFIXES + SOUND_SUFFIXES or is_sequence(path)


def is_sound(path: Path) -> bool:
    """Tell by a file's name whether it holds sound alone."""
    return path.suffix.lower() in SOUND_SUFFIXES


def find_sequence(path: Path) -> Sequence:
    """Find the files of numbered pictures.

    Raises
    ------
    FormatError
        There is none, or one is missing between others.
    OptionError
        The name has several patterns.
    """
    patterns = list(_PATTERN.finditer(path.name))
    if len(patterns) != 1:
        raise OptionError(f"{path}: expected one pattern such as %04d in the name, found {len(patterns)}")
    before, after = path.name[: patterns[0].start()], path.name[patterns[0].end() :]
    name = re.compile(re.escape(before) + r"(\d{1,12})" + re.escape(after), re.ASCII)
    found = sorted(
        number
        for entry in path.parent.iterdir()
        if (match := name.fullmatch(entry.name)) and numbered(path.name, number := int(match[1])) == entry.name
    )
    if not found:
        raise FormatError("no file has such a name", path=path)
    missing = next((a + 1 for a, b in itertools.pairwise(found) if b != a + 1), None)
    if missing is not None:
        raise FormatError(f"picture {missing} is missing between {found[0]} and {found[-1]}", path=path)
    return Sequence(path, tuple(found))


def refuse_references(path: Path, start: bytes) -> None:
    """Raise FormatError where the first bytes of a file show that it names other files, or that it is empty."""
    if not start:
        raise FormatError("empty; expected video, pictures or sound", path=path)
    text = start.removeprefix(b"\xef\xbb\xbf")
    if text[:2] in (b"\xff\xfe", b"\xfe\xff"):
        text = text.decode("utf-16", "replace").encode("utf-8", "replace")
    text = text.replace(b"\0", b"").lstrip().lower()
    # Comments may stand before what a list begins with.
    lines = [line.strip() for line in text.splitlines()[:200]]
    first = next((line for line in lines if line and (line == b"#extm3u" or not line.startswith((b"#", b";")))), b"")
    for mark, what in _NAMES_OTHERS:
        if text.startswith(mark) or (first + b" ").startswith(mark):
            raise FormatError(
                f"this is {what}, which names other files; they are not opened. Give one of them", path=path
            )
    if text.startswith(b"<"):
        for mark, what in _XML_OTHERS:
            if mark in text:
                raise FormatError(f"this is {what}, which names other files; they are not opened", path=path)
        raise FormatError("this is a text of markup (XML, SVG); expected video, pictures or sound", path=path)
