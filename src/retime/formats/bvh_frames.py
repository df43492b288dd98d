"""The MOTION section of a BVH file: its counts, its frame time, and its frames as a table of numbers."""

from __future__ import annotations

import re
import warnings
from dataclasses import dataclass
from fractions import Fraction
from os import fspath
from typing import NoReturn, Protocol

import numpy as np

from retime.arrays import FloatArray
from retime.errors import FormatWarning
from retime.formats.bvh_hierarchy import Hierarchy
from retime.formats.number_rows import parse_rows
from retime.formats.number_text import (
    NumberTextError,
    parse_count,
    parse_number,
    parse_numbers,
    part_glued,
    show,
)
from retime.formats.read_options import ReadOptions
from retime.formats.text_lines import LINE_END, Lines, count_line_ends
from retime.kernels import RowFormat
from retime.motion.rate import rate_from_frame_time, rate_meant_by
from retime.motion.size import LARGEST

_FRAMES = re.compile(rb"frames\s*:\s*(.*)", re.IGNORECASE | re.DOTALL)
_FRAME_TIME = re.compile(rb"frame\s*time\s*:\s*(.*)", re.IGNORECASE | re.DOTALL)
_CUT_NUMBER = re.compile(rb"[+-]?\.?|[+-]?(?:[0-9]+\.?[0-9]*|\.[0-9]+)[eE][+-]?")
_REPAIR = "; --repair (repair=True) keeps what is there"
# Bytes parsed at once: many rows, whose numbers stay in the processor's cache.
_BLOCK = 1 << 18


@dataclass(frozen=True)
class Frames:
    """What the MOTION section says.

    Attributes
    ----------
    rate : Fraction
        Frames a second.
    frame_time : str
        The frame time as written; "" where there is no valid one.
    n_frames : int
        How many there are.
    """

    rate: Fraction
    frame_time: str
    n_frames: int


class Taker(Protocol):
    """Takes frames as they are parsed."""

    def take(self, table: FloatArray, more: int) -> None:
        """Take frames, shape (n, n_channels), degrees and length units; about so many more will follow."""

    def take_text(self, text: bytes, start: int, piece_bytes: int, rows: RowFormat, most: int) -> tuple[int, int]:
        """Take plain frames from a place of the text on, at most so many: returns how many, and their bytes.

        As `retime.kernels.Backend.read_joint_rows`; none where that can't be, or where there is no room.
        """


def parse_frames(lines: Lines, hierarchy: Hierarchy, options: ReadOptions, taker: Taker) -> Frames:
    """Parse what follows the word MOTION.

    Frames go to `taker` as soon as they are parsed, some at a time: a long take's table of numbers and what is made of
    them need not lie in memory together.

    Raises
    ------
    FormatError
        With the line, the frame (counted from 0), and the joint and channel where one is at fault.

    Warns
    -----
    FormatWarning
        The file holds another count of frames than it says; with ``options.repair``, frames were dropped, or
        numbers that ran together were parted.
    """
    claimed = _frame_count(lines)
    table = _Table(lines, hierarchy, options, claimed, taker)
    rate, frame_time = _frame_time(lines, options)
    table.parse()
    return Frames(rate, frame_time, table.n_frames)


def _frame_count(lines: Lines) -> int:
    token = lines.token()
    if token is None:
        lines.fail("expected 'Frames:', found the end of the file")
    lines.put_back(token)
    text = lines.rest()
    match = _FRAMES.fullmatch(text)
    if match is None:
        lines.fail(f"expected 'Frames:', found {show(text)}")
    try:
        return parse_count(match[1])
    except NumberTextError as error:
        lines.fail(f"Frames: {error.problem}")


def _frame_time(lines: Lines, options: ReadOptions) -> tuple[Fraction, str]:
    """Read the frame time; where it is missing or wrong the rate must come from the options."""
    remedy = "; where the file is no help, give the rate (--fps, rate=)"
    token = lines.token()
    if token is None:
        lines.fail("expected 'Frame Time:', found the end of the file")
    lines.put_back(token)
    text = lines.rest()
    match = _FRAME_TIME.fullmatch(text)
    if match is None:
        if options.rate is None:
            lines.fail(f"expected 'Frame Time:', found {show(text)}{remedy}")
        lines.put_back_line()
        return options.rate, ""
    written = match[1].replace(b",", b".") if options.decimal_comma else match[1]
    try:
        parse_number(written)
        declared = written.decode("ascii")
        rate = rate_from_frame_time(declared)
    except ValueError as error:
        if options.rate is None:
            lines.fail(f"Frame Time: {error}{remedy}")
        return options.rate, ""
    if options.rate is not None:
        return options.rate, declared
    if rate < 1 and (meant := rate_meant_by(declared)) is not None:
        what, rate = meant
        # Written back it is seconds.
        note = (
            f"a frame time of {declared} s is hardly meant: taken for {what}, {float(rate):g} Hz (--fps gives another)"
        )
        warnings.warn(FormatWarning(f"{fspath(lines.path)}:{lines.number}: {note}"), stacklevel=2)
        return rate, ""
    return rate, declared


class _Damage(Exception):
    """A frame that can't be read; those before it can."""

    def __init__(self, problem: str, *, line: int, column: int | None = None) -> None:
        self.problem = problem
        self.line = line
        self.column = column
        super().__init__(problem)


class _Table:
    """The rows of numbers. A frame begins on a new line and may go on over several."""

    def __init__(self, lines: Lines, hierarchy: Hierarchy, options: ReadOptions, claimed: int, taker: Taker) -> None:
        self.lines = lines
        self.taker = taker
        self.hierarchy = hierarchy
        self.options = options
        self.limits = options.limits
        self.claimed = claimed
        self.claim_line = lines.number
        self.n_channels = sum(map(len, hierarchy.channels))
        self.n_frames = 0
        # Bytes of the block at work, and those behind it.
        self.block_bytes = self.left_bytes = 0
        # Lines up to this place of the file; counted only where one is to be named.
        self.line = 0
        self.counted = 0
        # The values of a frame that is not whole yet, and the line where it begins.
        self.begun: list[float] = []
        self.begun_line = 0
        # Numbers of that frame that ran together and were parted; the first such place, and the frames that came of it.
        self.glued: _Damage | None = None
        self.first_glued: _Damage | None = None
        self.n_glued = 0

    def parse(self) -> None:
        if self.n_channels == 0:
            self._fail("no joint has a channel, so nothing moves")
        if not self.options.repair:
            self._check_claim()
        try:
            self._parse_blocks()
        except _Damage as damage:
            self._refuse_or_repair(damage)
        else:
            self._compare_counts()
        if self.first_glued is not None:
            frames = f"{self.n_glued} frame{'s' * (self.n_glued != 1)}"
            self._warn(f"{self.first_glued.problem} They were parted, in {frames}.", self.first_glued.line)

    def _taken(self, table: FloatArray) -> None:
        """Hand on some frames; they are counted."""
        n_joints = len(self.hierarchy.names)
        if self.n_frames * n_joints > self.limits.joint_poses:
            self._fail(
                f"{self.n_frames} frames of {n_joints} joints, the limit is {self.limits.joint_poses} poses of a "
                "joint (Limits.joint_poses)"
            )
        # Lines of one file are about as long as each other, those of a pose at rest, in front, perhaps twice as long as
        # the others; what it claims may be anything. Room that nothing comes to costs nothing.
        more = len(table) * self.left_bytes // max(1, self.block_bytes)
        self.taker.take(table, max(0, min(2 * more + 1, self.claimed - self.n_frames)))

    def _fail(self, problem: str) -> NoReturn:
        self.lines.fail(f"Frames: {problem}", line=self.claim_line)

    def _warn(self, problem: str, line: int) -> None:
        warnings.warn(FormatWarning(f"{fspath(self.lines.path)}:{line}: {problem}"), stacklevel=2)

    def _check_claim(self) -> None:
        left = len(self.lines.data) - self.lines.next_start
        # A value takes two bytes at least, a digit and a separator; only the last one has no separator.
        most = (left + 1) // (2 * self.n_channels)
        if self.claimed > most + 1:
            claim = "10**18 or more" if self.claimed >= 10**18 else str(self.claimed)
            self._fail(
                f"{claim} claimed, but the {left} bytes left hold at most {most} frames of {self.n_channels} "
                f"channels{_REPAIR}"
            )
        if self.claimed > self.limits.frames:
            self._fail(f"{self.claimed} claimed, the limit is {self.limits.frames} (Limits.frames)")

    def _compare_counts(self) -> None:
        n = self.n_frames
        if n == 0:
            self._fail(f"{self.claimed} claimed, none there")
        if self.claimed < n or self.claimed == n + 1:
            self._warn(f"Frames: {self.claimed} claimed, {n} there; kept all {n}", self.claim_line)
        elif self.claimed > n:
            if not self.options.repair:
                self._fail(f"{self.claimed} claimed, {n} there{_REPAIR}")
            self._warn(f"Frames: {self.claimed} claimed, {n} there; kept the {n}", self.claim_line)

    def _refuse_or_repair(self, damage: _Damage) -> None:
        if not self.options.repair or self.n_frames == 0:
            self.lines.fail(damage.problem, line=damage.line, column=damage.column)
        kept = f"Kept the whole frames before it: {self.n_frames} of {self.claimed} claimed."
        self._warn(f"{damage.problem} {kept}", damage.line)

    def _parse_blocks(self) -> None:
        data = self.lines.data
        position = self.lines.next_start
        self.line, self.counted = self.lines.number, position
        is_plain = False
        while position < len(data):
            if is_plain and not self.begun:
                n_bytes = self._take_plain(position)
                position += n_bytes
                # A file that is not written so would be begun in vain again and again.
                is_plain = n_bytes > 0
                if position == len(data):
                    break
            match = LINE_END.search(data, position + _BLOCK)
            stop = len(data) if match is None else match.end()
            text = data[position:stop]
            self.block_bytes, self.left_bytes = len(text), len(data) - stop
            comma, longest = self.options.decimal_comma, self.limits.line_bytes
            table = None
            if not self.begun:
                table = parse_rows(text, self.n_channels, decimal_comma=comma, line_bytes=longest)
            if table is not None:
                self.n_frames += len(table)
                self._taken(table)
                is_plain = is_plain or position == self.lines.next_start
            else:
                self._count_lines(position)
                if len(text) > longest:
                    self._check_lengths(text)
                self._parse_lines(text.splitlines(), ends_file=stop == len(data))
                self.counted = stop
            if self.n_frames > self.limits.frames:
                self._fail(f"more than {self.limits.frames} there (Limits.frames)")
            position = stop
        if self.begun:
            raise self.glued or self._cut(len(self.begun))

    def _take_plain(self, position: int) -> int:
        """Have plain frames taken right from the text, as many as may be; return their bytes."""
        limits, n_joints = self.limits, len(self.hierarchy.names)
        most = min(limits.frames, limits.joint_poses // n_joints) - self.n_frames
        rows = RowFormat(self.n_channels, "", self.options.decimal_comma, LARGEST, limits.line_bytes)
        n_frames, n_bytes = self.taker.take_text(self.lines.data, position, _BLOCK, rows, most)
        self.n_frames += n_frames
        return n_bytes

    def _count_lines(self, position: int) -> None:
        self.line += count_line_ends(self.lines.data[self.counted : position])
        self.counted = position

    def _check_lengths(self, text: bytes) -> None:
        longest = self.limits.line_bytes
        for number, row in enumerate(text.splitlines(), start=self.line + 1):
            if len(row) > longest:
                self.lines.fail(f"the line is longer than {longest} bytes (Limits.line_bytes)", line=number)

    def _parse_lines(self, rows: list[bytes], *, ends_file: bool) -> None:
        """Parse a block that the fast way could not take: join wrapped lines, or find what is wrong."""
        frames: list[list[float]] = []
        try:
            for i, row in enumerate(rows):
                self.line += 1
                values = self._numbers(row, ends_file=ends_file and i == len(rows) - 1)
                if not values:
                    continue
                if not self.begun:
                    self.begun_line = self.line
                if len(self.begun) + len(values) > self.n_channels:
                    raise self.glued or self._miscounted(len(self.begun) or len(values))
                self.begun += values
                if len(self.begun) == self.n_channels:
                    frames.append(self.begun)
                    self.n_frames += 1
                    self.begun = []
                    if self.glued is not None:
                        self.first_glued = self.first_glued or self.glued
                        self.n_glued += 1
                        self.glued = None
        finally:
            if frames:
                self._taken(np.array(frames))

    def _numbers(self, row: bytes, *, ends_file: bool) -> list[float]:
        """Parse one line; for a repair, part numbers that run together; the frame's count tells if that is right."""
        comma = self.options.decimal_comma
        try:
            return parse_numbers(row, decimal_comma=comma)
        except NumberTextError as error:
            damage = self._not_a_number(row, error, ends_file=ends_file)
        parted = part_glued(row, decimal_comma=comma) if self.options.repair else row
        if parted == row:
            raise damage
        try:
            values = parse_numbers(parted, decimal_comma=comma)
        except NumberTextError:
            raise damage from None
        self.glued = self.glued or damage
        return values

    def _not_a_number(self, row: bytes, error: NumberTextError, *, ends_file: bool) -> _Damage:
        index = len(self.begun) + error.index
        if ends_file and index < self.n_channels and _CUT_NUMBER.fullmatch(row[error.offset :]):
            if not self.begun:
                self.begun_line = self.line
            return self._cut(index)
        place = self.hierarchy.column(index)
        column = len(row[: error.offset].decode("utf-8", "replace")) + 1
        return _Damage(f"frame {self.n_frames}, {place}: {error.problem}.", line=self.line, column=column)

    def _miscounted(self, found: int) -> _Damage:
        last = self.line - 1 if self.begun else self.line
        lines = f" (lines {self.begun_line} to {last})" if last > self.begun_line else ""
        return _Damage(
            f"frame {self.n_frames}{lines} has {found} values, but the hierarchy declares {self.n_channels} channels.",
            line=self.begun_line,
        )

    def _cut(self, found: int) -> _Damage:
        return _Damage(
            f"frame {self.n_frames} has {found} values, but the hierarchy declares {self.n_channels} channels. "
            "The file ends here.",
            line=self.begun_line,
        )
