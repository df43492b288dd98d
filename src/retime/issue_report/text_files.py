"""Text files without their names, and with fewer frames."""

from __future__ import annotations

import codecs
import re
from collections.abc import Callable, Iterator
from typing import TypeVar

from retime.issue_report.stand_ins import StandIns
from retime.issue_report.vocabulary import words_of_modules

Part = TypeVar("Part")

# What is kept of a long file: its first frames, its last ones, and those around the line that an error names.
FIRST, LAST, AROUND = 5, 2, 2
# Lines that may be the head of a table.
_TABLE_HEAD = 30

_BVH_NAMED = re.compile(
    rb"^([ \t\v\f]*(?:\{[ \t]*)?(?:ROOT|JOINT|End)[ \t\v\f]+)([^\r\n{}]*)", re.IGNORECASE | re.MULTILINE
)
_BVH_WORDS = frozenset(
    b"hierarchy root joint end site offset channels motion frames frame time "
    b"xposition yposition zposition xrotation yrotation zrotation".split()
)
_BVH_COUNT = re.compile(rb"^([ \t]*Frames[ \t]*:[ \t]*)([0-9]+)", re.IGNORECASE | re.MULTILINE)
_BVH_RATE = re.compile(rb"^[ \t]*Frame[ \t]+Time[ \t]*:[^\r\n]*(?:\r\n?|\n)", re.IGNORECASE | re.MULTILINE)
_AMC_FRAME = re.compile(rb"^[ \t]*[0-9]+[ \t]*(?=\r|\n)", re.MULTILINE)

_TABLES = (
    "retime.formats.csv_table",
    "retime.formats.tables",
    "retime.formats.channel_meaning",
    "retime.motion.channels",
    "retime.motion.clock",
)
# Axes, alone or behind a letter that says of what, and units.
UNITS_AND_AXES = frozenset(
    b"w x y z qw qx qy qz px py pz tx ty tz rx ry rz s ms us ns mm cm m deg rad degrees radians".split()
)
_RATE_COMMENT = frozenset(b"frames per second".split())
_ASF = tuple(f"retime.formats.{one}" for one in ("amc", "amc_frames", "amc_declaration", "asf", "asf_reader"))
_FBX_PARTS = ("format", "binary", "curve", "file", "keys", "motion", "scene", "text", "values", "write")
FBX_MODULES = tuple(f"retime.formats.curves.fbx.{one}" for one in _FBX_PARTS)


def mask_bvh(data: bytes, names: StandIns) -> bytes:
    r"""Replace the names of a BVH's joints, and every word that the format has not.

    Examples
    --------
    >>> mask_bvh(b"HIERARCHY\nROOT My Hips\n{ OFFSET 0 0 0 by Ann", StandIns())
    b'HIERARCHY\nROOT Nn Nnnn\n{ OFFSET 0 0 0 nb Nnn'
    """
    parts, place = [], 0
    for match in _BVH_NAMED.finditer(data):
        parts.append(names.in_words(data[place : match.end(1)], _BVH_WORDS))
        is_end = match[1].split()[-1].lower() == b"end"
        parts.append(names.in_words(match[2], frozenset((b"site",))) if is_end else names.in_name(match[2]))
        place = match.end()
    return b"".join([*parts, names.in_words(data[place:], _BVH_WORDS)])


def mask_asf(data: bytes, names: StandIns) -> bytes:
    """Replace the words of an AMC or an ASF that the format has not."""
    return names.in_words(data, words_of_modules(*_ASF) | _RATE_COMMENT)


def mask_table(data: bytes, names: StandIns) -> bytes:
    """Replace the words of a table that no reader of tables knows: names of columns, labels, comments."""
    return names.in_words(data, words_of_modules(*_TABLES) | UNITS_AND_AXES, by_parts=True)


def mask_fbx_text(data: bytes, names: StandIns) -> bytes:
    """Replace the words of an FBX in text that the reader does not know."""
    return names.in_words(data, words_of_modules(*FBX_MODULES))


def masked_text(mask: Callable[[bytes, StandIns], bytes], data: bytes, names: StandIns) -> bytes:
    """Mask a text, in UTF-16 too, where a mark says so."""
    for mark, encoding in ((codecs.BOM_UTF16_LE, "utf-16-le"), (codecs.BOM_UTF16_BE, "utf-16-be")):
        if data.startswith(mark):
            try:
                text = data[len(mark) :].decode(encoding).encode()
                return mark + mask(text, names).decode().encode(encoding)
            except UnicodeError:
                # No such text: its first bytes are what it is refused for.
                return data[: len(mark) + 1]
    for mark in (codecs.BOM_UTF8,):
        if data.startswith(mark):
            return mark + mask(data[len(mark) :], names)
    return mask(data, names)


def shorter_bvh(data: bytes, line: int | None) -> Iterator[bytes]:
    """Make shorter files of a BVH, the one that keeps least first: its first frames, its last ones, those at fault."""
    match = _BVH_RATE.search(data)
    if match is None:
        return
    head, rows = data[: match.end()], _lines(data[match.end() :])
    at = None if line is None else line - 1 - len(_lines(head))
    frames = sum(1 for row in rows if row.strip())
    for kept in _choices(rows, at):
        left_out = frames - sum(1 for row in kept if row.strip())
        count = _BVH_COUNT.search(head)
        fewer = head
        if count is not None:
            fewer = head[: count.start(2)] + b"%d" % max(int(count[2]) - left_out, 1) + head[count.end(2) :]
        yield fewer + b"".join(kept)


def shorter_amc(data: bytes, line: int | None) -> Iterator[bytes]:
    """Make shorter files of an AMC; the frames that are kept are counted on from the first."""
    starts = [match.start() for match in _AMC_FRAME.finditer(data)]
    if not starts:
        return
    blocks = [data[start:end] for start, end in zip(starts, [*starts[1:], len(data)], strict=True)]
    at = None
    if line is not None:
        lines = _lines(data)
        place = sum(len(one) for one in lines[: line - 1])
        at = sum(1 for start in starts if start <= place) - 1
    first = int(blocks[0].split(maxsplit=1)[0])
    for kept in _choices(list(enumerate(blocks)), at):
        counted = [
            # One that is not where it should be keeps its distance.
            _AMC_FRAME.sub(b"%d" % (int(block.split(maxsplit=1)[0]) - index + place), block, count=1)
            if int(block.split(maxsplit=1)[0]) == first + index
            else block
            for place, (index, block) in enumerate(kept)
        ]
        yield data[: starts[0]] + b"".join(counted)


def shorter_table(data: bytes, line: int | None) -> Iterator[bytes]:
    """Make shorter files of a table."""
    lines = _lines(data)
    head, rows = lines[:_TABLE_HEAD], lines[_TABLE_HEAD:]
    at = None if line is None else line - 1 - len(head)
    for kept in _choices(rows, at):
        yield b"".join([*head, *kept])


def _choices(parts: list[Part], at: int | None) -> Iterator[list[Part]]:
    """Choose from the frames of a file, the fewest first; `at` is the one at fault."""
    n = len(parts)
    here = set() if at is None else set(range(max(at - AROUND, 0), min(at + AROUND + 1, n)))
    first, last = set(range(min(FIRST, n))), set(range(max(n - LAST, 0), n))
    # A gap in the middle may itself be what a reader complains of.
    for chosen in (first | here | last, first | here, set(range((at or 0) + AROUND + 1)), set(range(n // 2))):
        kept = [parts[index] for index in sorted(chosen) if index < n]
        if len(kept) < n:
            yield kept


def _lines(data: bytes) -> list[bytes]:
    """Split as `bytes.splitlines` does, at LF, CR and CRLF, line ends kept."""
    return data.splitlines(keepends=True)
