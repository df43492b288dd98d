"""The frames of an AMC, read line after line on the skeleton of its ASF, with the place of every fault."""

from __future__ import annotations

import re
from collections import Counter
from fractions import Fraction
from io import BytesIO
from pathlib import Path

import numpy as np

from retime.arrays import FloatArray
from retime.errors import FormatError, OptionError
from retime.formats.amc_declaration import RATE_COMMENT
from retime.formats.asf import Asf
from retime.formats.number_rows import parse_rows
from retime.formats.number_text import NumberTextError, parse_count, parse_number, parse_numbers, part_glued, show
from retime.formats.read_options import ReadOptions
from retime.motion.rate import parse_rate

# Lines before the first frame; real files have three.
_HEADER_LINES = 10_000
# Values are parsed in pieces: small enough that their words don't fill the memory, large enough to be fast.
_PIECE_WORDS = 1 << 15


class FrameReader:
    """Reads the frames of one AMC, line after line.

    Parameters
    ----------
    path : Path
        The file, for messages.
    data : bytes
        What it holds.
    options : ReadOptions
        What the reader was told.
    asf : Asf
        Its skeleton.
    asf_path : Path
        Where that is from, for messages.

    Attributes
    ----------
    header : list of bytes
        The lines before the first frame.
    rate : Fraction, optional
        What a comment of retime's says.
    degrees : bool
        Whether angles are in degrees.
    first_frame : int
        The number of the first frame.
    order : list of int
        The joints that have channels, in the first frame's order.
    line_end : bytes
        What ends a line.
    notes : list of str
        What is to be said of the file, for warnings.
    """

    def __init__(self, path: Path, data: bytes, options: ReadOptions, asf: Asf, asf_path: Path) -> None:
        self.path = path
        self.data = data
        self.options = options
        self.asf = asf
        self.asf_path = asf_path
        self.line_end = _line_end(data)
        self.header: list[bytes] = []
        self.notes: list[str] = []
        self.degrees = asf.degrees
        self.fully_specified = False
        self.rate: Fraction | None = None
        self.first_frame = 0
        self.order: list[int] = []
        self.moving: frozenset[int] = frozenset()
        self.blocks: list[FloatArray] = []
        self.n_frames = 0
        self.counts = [len(channels) for channels in asf.channels]
        names = [name.encode(asf.encoding) for name in asf.skeleton.names]
        self.joints = {name: joint for joint, name in enumerate(names)}
        # Some programs change the case of names; names that differ by case alone can't be told apart then.
        times = Counter(name.lower() for name in names)
        self.alike = {name.lower(): joint for joint, name in enumerate(names) if times[name.lower()] == 1}
        # The frame that is being read: its number and line, and the joints with their lines and words.
        self.number = -1
        self.line = 0
        self.record: dict[int, tuple[int, list[bytes]]] = {}
        self.previous: dict[int, list[bytes]] = {}
        self.left_out: dict[int, int] = {}
        # Joints' values that ran together and were parted, and where the first stand.
        self.n_glued = 0
        self.first_glued: FormatError | None = None
        self.words: list[bytes] = []
        self.piece: list[tuple[int, dict[int, tuple[int, list[bytes]]]]] = []

    def _error(self, line: int, problem: str, column: int | None = None) -> FormatError:
        return FormatError(problem, path=self.path, line=line, column=column)

    def run(self) -> None:
        """Read all frames; raise FormatError where one is at fault, and nothing may be repaired."""
        try:
            try:
                self._read_lines()
            except FormatError:
                # A number at fault may stand in the lines before.
                self._parse_piece()
                raise
        except FormatError as error:
            if not self.options.repair or self.n_frames == 0:
                raise
            self.notes.append(f"{self.n_frames} whole frames were kept; then {error}")
        if self.first_glued is not None:
            times = f"{self.n_glued} place{'s' * (self.n_glued != 1)}"
            self.notes.append(f"numbers that ran together were parted in {times}; first {self.first_glued}")
        if self.left_out:
            shown = ", ".join(self.asf.skeleton.names[joint] for joint in list(self.left_out)[:5])
            more = ", ..." if len(self.left_out) > 5 else ""
            self.notes.append(
                f"up to {max(self.left_out.values())} of {self.n_frames} frames leave out joints ({shown}{more}), and "
                "the file is not :FULLY-SPECIFIED; each keeps the values that it had, 0 before it had any"
            )

    def _read_lines(self) -> None:
        body = self.data
        if b"\r" in body:
            body = body.replace(b"\r\n", b"\n").replace(b"\r", b"\n")
        joints, limit = self.joints, self.options.limits.line_bytes
        # The joint whose values are being read, what was read of them, and how many are wanted; -1 outside of one.
        last, wanted = -1, 0
        values: list[bytes] = []
        number = 0
        for number, line in enumerate(BytesIO(body), 1):
            if len(line) > limit:
                raise self._error(number, f"the line has {len(line)} bytes, the limit is {limit} (Limits.line_bytes)")
            words = self._without_comment(line) if b"#" in line else line.split()
            if not words:
                if self.number < 0:
                    self._header_line(line)
                continue
            name = words[0]
            joint = joints.get(name)
            if joint is None:
                joint = self.alike.get(name.lower())
            if joint is not None and self.number >= 0:
                if len(values) != wanted:
                    self._part_glued(last)
                if joint in self.record:
                    first = self.record[joint][0]
                    raise self._error(number, f"frame {self.number} gives {show(name)} twice; first in line {first}")
                del words[0]
                self.record[joint] = (number, words)
                last, values, wanted = joint, words, self.counts[joint]
            elif self._is_frame(words, len(values) == wanted):
                if len(values) != wanted:
                    self._part_glued(last)
                self._start_frame(number, words[0])
                last, values, wanted = -1, [], 0
            elif self.number < 0:
                self._keyword(number, line, words)
            elif len(values) < wanted and name[0] in b"+-.0123456789":
                # The values of some writers run on in the next line.
                values += words
                if len(values) > wanted:
                    raise self._wrong_count(last)
            else:
                raise self._unknown(number, name)
        if self.number < 0:
            raise self._error(number, "the file ends without a frame; expected a frame number")
        if len(values) != wanted:
            self._part_glued(last)
        self._finish_frame(number)
        self._parse_piece()

    def _without_comment(self, line: bytes) -> list[bytes]:
        """Split a line into words up to the first that begins with ``#``."""
        words = line.split()
        for i, word in enumerate(words):
            if word.startswith(b"#"):
                return words[:i]
        return words

    def _is_frame(self, words: list[bytes], complete: bool) -> bool:
        """Whether a line is a frame's number, rather than the last of values that run on."""
        if len(words) != 1 or not words[0].isdigit():
            return False
        return complete or int(words[0][:19]) == self.number + 1

    def _header_line(self, line: bytes) -> None:
        line = line.rstrip(b"\n")
        if line.startswith(RATE_COMMENT):
            try:
                self.rate = parse_rate(line[len(RATE_COMMENT) :].decode("ascii", "replace").strip())
            except OptionError as error:
                raise self._error(len(self.header) + 1, f"{RATE_COMMENT.decode()} {error}") from None
        else:
            self._keep_header(line)

    def _keep_header(self, line: bytes) -> None:
        if len(self.header) >= _HEADER_LINES:
            raise self._error(len(self.header) + 1, f"no frame begins in the first {_HEADER_LINES} lines")
        self.header.append(line)

    def _keyword(self, number: int, line: bytes, words: list[bytes]) -> None:
        word = words[0].lower()
        if word in (b":fully-specified", b":fully_specified"):
            self.fully_specified = True
        elif word in (b":degrees", b":radians"):
            self.degrees = word == b":degrees"
        elif not word.startswith(b":"):
            raise self._error(
                number,
                f"expected a keyword (:FULLY-SPECIFIED, :DEGREES, :RADIANS) or a frame number, found {show(words[0])}",
            )
        self._keep_header(line.rstrip(b"\n"))

    def _start_frame(self, number: int, word: bytes) -> None:
        frame = parse_count(word)
        if self.number >= 0:
            self._finish_frame(number)
            if frame != self.number + 1:
                raise self._error(number, f"frame {frame} follows frame {self.number}; frame numbers must go up by one")
        else:
            self.first_frame = frame
        # Frames that wait as words, not yet parsed, count too.
        if self.n_frames + len(self.piece) >= self.options.limits.frames:
            raise self._error(number, f"more than {self.options.limits.frames} frames (Limits.frames)")
        self.number, self.line, self.record = frame, number, {}

    def _finish_frame(self, number: int) -> None:
        """Take a frame that is whole, in the order of the first one."""
        record = self.record
        if not self.order:
            missing = [joint for joint, count in enumerate(self.counts) if count and joint not in record]
            self.order = [joint for joint in record if self.counts[joint]] + missing
            self.moving = frozenset(self.order)
        if not self.moving <= record.keys():
            self._fill_in(number)
        for joint in self.order:
            self.words += record[joint][1]
        if not self.fully_specified:
            self.previous = {joint: words for joint, (_, words) in record.items()}
        self.piece.append((self.line, record))
        if len(self.words) >= _PIECE_WORDS:
            self._parse_piece()

    def _fill_in(self, number: int) -> None:
        missing = [joint for joint in self.order if joint not in self.record]
        if self.fully_specified:
            names = ", ".join(repr(self.asf.skeleton.names[joint]) for joint in missing[:5])
            more = f" and {len(missing) - 5} more" if len(missing) > 5 else ""
            raise self._error(
                number,
                f"frame {self.number} (line {self.line}) ends without {names}{more}, which {self.asf_path} gives "
                "channels, and the file is :FULLY-SPECIFIED",
            )
        for joint in missing:
            self.left_out[joint] = self.left_out.get(joint, 0) + 1
            self.record[joint] = (self.line, self.previous.get(joint, [b"0"] * self.counts[joint]))

    def _part_glued(self, joint: int) -> None:
        """Part values that run together, for a repair, where their count is right then; else raise FormatError."""
        _, words = self.record[joint]
        wrong = self._wrong_count(joint)
        parted = part_glued(b" ".join(words), decimal_comma=self.options.decimal_comma).split()
        if not self.options.repair or len(parted) != self.counts[joint]:
            raise wrong
        words[:] = parted
        self.first_glued = self.first_glued or wrong
        self.n_glued += 1

    def _wrong_count(self, joint: int) -> FormatError:
        line, words = self.record[joint]
        name = self.asf.skeleton.names[joint]
        channels = self.asf.channels[joint]
        try:
            # Two numbers that run together look like one value too few; the message should say what they are.
            parse_numbers(b" ".join(words), decimal_comma=self.options.decimal_comma)
        except NumberTextError as error:
            number, column = self._place(line, error.index)
            return self._error(number, f"frame {self.number}, joint {name!r}: {error.problem}", column)
        free = f"{len(channels)} ({' '.join(channels)})" if channels else "none"
        return self._error(
            line,
            f"frame {self.number} has {len(words)} value{'s' * (len(words) != 1)} for {name!r}; {self.asf_path} "
            f"gives it {free}",
        )

    def _unknown(self, number: int, name: bytes) -> FormatError:
        try:
            parse_number(name)
        except NumberTextError:
            names = self.asf.skeleton.names
            shown = ", ".join(names[:8]) + (", ..." if len(names) > 8 else "")
            return self._error(
                number,
                f"frame {self.number} names the joint {show(name)}, which {self.asf_path} does not have; it has "
                f"{shown}",
            )
        return self._error(number, f"expected a joint of frame {self.number} or the next frame, found {show(name)}")

    def _parse_piece(self) -> None:
        """Turn the words of whole frames into numbers."""
        piece, words = self.piece, self.words
        self.piece, self.words = [], []
        if not piece:
            return
        comma = self.options.decimal_comma
        width = sum(self.counts)
        # Joined by a space, so that a word's index in the text is its index here.
        text = b" ".join(words)
        row = parse_rows(text, len(words), decimal_comma=comma)
        try:
            numbers = np.array(parse_numbers(text, decimal_comma=comma)) if row is None else row[0]
        except NumberTextError as error:
            whole = error.index // width
            self.blocks.append(np.array(parse_numbers(b" ".join(words[: whole * width]), decimal_comma=comma)))
            self.n_frames += whole
            raise self._bad_word(piece[whole][1], error, self.first_frame + self.n_frames) from None
        self.blocks.append(numbers)
        self.n_frames += len(piece)

    def _bad_word(self, record: dict[int, tuple[int, list[bytes]]], error: NumberTextError, frame: int) -> FormatError:
        index = error.index % sum(self.counts)
        for joint in self.order:
            line, words = record[joint]
            if index < len(words):
                break
            index -= len(words)
        name, channel = self.asf.skeleton.names[joint], self.asf.channels[joint][index]
        number, column = self._place(line, index)
        return self._error(number, f"frame {frame}, joint {name!r}, {channel}: {error.problem}", column)

    def _place(self, line: int, index: int) -> tuple[int, int]:
        """Find line and column of a joint's value, which may have been wrapped."""
        index += 1
        for number, text in enumerate(self.data.splitlines()[line - 1 :], line):
            count = len(self._without_comment(text))
            if index < count:
                start = [match.start() for match in re.finditer(rb"[^ \t\v\f]+", text)][index]
                return number, len(text[:start].decode("utf-8", "replace")) + 1
            index -= count
        raise AssertionError("the value was read from these lines")

    def joint_values(self) -> list[FloatArray]:
        """Give each joint's values, shape (n_frames, number of its channels)."""
        width = sum(self.counts)
        table = np.concatenate([np.empty(0), *self.blocks]).reshape(self.n_frames, width)
        columns = {}
        start = 0
        for joint in self.order:
            columns[joint] = table[:, start : start + self.counts[joint]]
            start += self.counts[joint]
        nothing = np.empty((self.n_frames, 0))
        return [columns.get(joint, nothing) for joint in range(len(self.counts))]


def _line_end(data: bytes) -> bytes:
    """Find how the first line ends."""
    match = re.search(rb"\r\n|\r|\n", data)
    return match[0] if match else b"\n"
