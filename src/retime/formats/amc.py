"""AMC, joint angles frame by frame, on the skeleton of an ASF (see `retime.formats.asf`).

An AMC is a list of frames: a line with the frame's number, then a line for each bone with its name and values. It
names neither its skeleton nor its rate. The ASF is looked for beside it, and the rate is the reader's to give; where
nobody does it is taken for 120 Hz, with a warning. When a motion of another rate is written, a comment before the
keywords says so, which this reader takes up again and others skip.
"""

from __future__ import annotations

import re
import warnings
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass
from fractions import Fraction
from io import BytesIO
from pathlib import Path

import numpy as np

from retime.arrays import FloatArray
from retime.errors import FormatError, FormatWarning, InvalidMotionError, OptionError, OutputExistsError
from retime.files import read_bytes, write_bytes
from retime.formats.asf import Asf, find_asf, make_asf, parse_asf, refuse_other_kinds, turn_order
from retime.formats.number_text import NumberTextError, parse_count, parse_number, parse_numbers, show
from retime.formats.read_options import Limits, ReadOptions
from retime.formats.text_lines import without_byte_order_mark
from retime.motion import rotation
from retime.motion.euler import angle_between, fit_angles
from retime.motion.motion import Declaration, Motion
from retime.motion.rate import parse_rate
from retime.motion.signal import Signal

ASSUMED_RATE = Fraction(120)
# Lines before the first frame; real files have three.
_HEADER_LINES = 10_000
_RATE_COMMENT = b"# frames per second:"
# Values are parsed in pieces: small enough that their words don't fill the memory, large enough to be fast.
_PIECE_WORDS = 1 << 15
_CHANNEL_NAMES = {
    "tx": "Xposition",
    "ty": "Yposition",
    "tz": "Zposition",
    "rx": "Xrotation",
    "ry": "Yrotation",
    "rz": "Zrotation",
}
# For an ASF that is already in memory: one that was read within its reader's limits, or one made here, whose helper
# bones may lead past those that the motion keeps.
_UNBOUNDED = Limits(joints=1 << 40, depth=1 << 40, line_bytes=1 << 40, name_bytes=1 << 40)
# Of the longest offset: what a program that works in 32-bit numbers leaves of a translation that doesn't move.
_STILL = 1e-5
# Radians. Near gimbal lock angles can wind up turn after turn, and would lose their decimals.
_MOST_WOUND = 8 * np.pi


@dataclass(frozen=True, repr=False)
class AsfDeclaration(Declaration):
    """What an AMC and its ASF declared.

    The ``channels`` of a joint are those of the root's ``order`` or the bone's ``dof``; they turn about fixed axes, the
    first one first, unlike BVH's.

    Attributes
    ----------
    asf : bytes
        The ASF as it was: axes, degrees of freedom, limits, units and notes.
    asf_name : str
        Its file name.
    header : tuple of bytes
        The lines before the first frame.
    degrees : bool
        Whether the AMC's angles are in degrees.
    joint_order : tuple of int
        The joints that have channels, in the order in which the AMC lists them.
    counts_from : int
        The number of the file's first frame.
    line_end : bytes
        What ends a line.
    """

    asf: bytes = b""
    asf_name: str = ""
    header: tuple[bytes, ...] = ()
    degrees: bool = True
    joint_order: tuple[int, ...] = ()
    counts_from: int = 1
    line_end: bytes = b"\n"


def read(path: Path, data: bytes, options: ReadOptions) -> Motion:
    """Read an AMC and its ASF.

    Parameters
    ----------
    path : Path
        The file; its ASF is looked for beside it: the same stem, the same subject number (``02.asf`` of
        ``02_04.amc``), or the only one there. ``options.skeleton`` names another.
    data : bytes
        What it holds.
    options : ReadOptions
        What the reader was told.

    Returns
    -------
    Motion
        Lengths are in the file's own numbers; ``metres_per_unit`` is known where the ASF's length unit is not 1.

    Raises
    ------
    FormatError
        One of the two files is not what it claims to be, or the ASF can't be found.
    OSError
        The ASF can't be opened.

    Warns
    -----
    FormatWarning
        The rate was assumed, joints were left out of frames, or a damaged end was cut (``options.repair``).
    """
    data = without_byte_order_mark(path, data)
    refuse_other_kinds(path, data, "an AMC motion")
    asf_path = options.skeleton
    if asf_path is None:
        asf_path, searched = find_asf(path)
        if asf_path is None:
            raise FormatError(f"its ASF skeleton was not found: {searched}; name it with --skeleton", path=path)
    asf_data = read_bytes(asf_path, options.limits.file_bytes)
    asf = parse_asf(asf_path, asf_data, options.limits)
    for note in asf.notes:
        warnings.warn(f"{asf_path}: {note}", FormatWarning, stacklevel=3)
    reader = _Reader(path, data, options, asf, asf_path)
    reader.run()
    for note in reader.notes:
        warnings.warn(f"{path}: {note}", FormatWarning, stacklevel=3)
    rate = options.rate or reader.rate
    if rate is None:
        rate = ASSUMED_RATE
        warnings.warn(
            f"{path}: AMC files carry no rate; 120 Hz assumed (most CMU trials); --fps sets it",
            FormatWarning,
            stacklevel=3,
        )
    rotations, translations, angles = _pose(asf, reader.joint_values(), degrees=reader.degrees)
    declaration = AsfDeclaration(
        format="amc",
        channels=tuple(tuple(_CHANNEL_NAMES[name] for name in names) for names in asf.channels),
        asf=asf_data,
        asf_name=asf_path.name,
        header=tuple(reader.header),
        degrees=reader.degrees,
        joint_order=tuple(reader.order),
        counts_from=reader.first_frame,
        line_end=reader.line_end,
    )
    try:
        return Motion(
            asf.skeleton,
            rotations,
            translations,
            rate=rate,
            name=path.stem,
            first_frame=reader.first_frame,
            metres_per_unit=asf.metres_per_unit,
            declaration=declaration,
            declared_angles=angles,
        )
    except InvalidMotionError as error:
        raise FormatError(str(error), path=path) from None


class _Reader:
    """Reads the frames of one AMC, line after line."""

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
        # The joints that have channels, in the first frame's order, and as a set.
        self.order: list[int] = []
        self.moving: frozenset[int] = frozenset()
        self.blocks: list[FloatArray] = []
        self.n_frames = 0
        self.counts = [len(channels) for channels in asf.channels]
        names = [name.encode(asf.encoding) for name in asf.skeleton.names]
        self.joints = {name: joint for joint, name in enumerate(names)}
        # Some programs change the case of names; that helps where no two differ by it alone.
        times = Counter(name.lower() for name in names)
        self.alike = {name.lower(): joint for joint, name in enumerate(names) if times[name.lower()] == 1}
        # The frame that is being read: its number and line, and the joints with their lines and words.
        self.number = -1
        self.line = 0
        self.record: dict[int, tuple[int, list[bytes]]] = {}
        self.previous: dict[int, list[bytes]] = {}
        self.left_out: dict[int, int] = {}
        self.words: list[bytes] = []
        self.piece: list[tuple[int, dict[int, tuple[int, list[bytes]]]]] = []

    def error(self, line: int, problem: str, column: int | None = None) -> FormatError:
        return FormatError(problem, path=self.path, line=line, column=column)

    def run(self) -> None:
        try:
            try:
                self.read_lines()
            except FormatError:
                # A number at fault may stand in the lines before.
                self.parse_piece()
                raise
        except FormatError as error:
            if not self.options.repair or self.n_frames == 0:
                raise
            self.notes.append(f"{self.n_frames} whole frames were kept; then {error}")
        if self.left_out:
            shown = ", ".join(self.asf.skeleton.names[joint] for joint in list(self.left_out)[:5])
            more = ", ..." if len(self.left_out) > 5 else ""
            self.notes.append(
                f"up to {max(self.left_out.values())} of {self.n_frames} frames leave out joints ({shown}{more}), and "
                "the file is not :FULLY-SPECIFIED; each keeps the values that it had, 0 before it had any"
            )

    def read_lines(self) -> None:
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
                raise self.error(number, f"the line has {len(line)} bytes, the limit is {limit} (Limits.line_bytes)")
            words = self.without_comment(line) if b"#" in line else line.split()
            if not words:
                if self.number < 0:
                    self.header_line(line)
                continue
            name = words[0]
            joint = joints.get(name)
            if joint is None:
                joint = self.alike.get(name.lower())
            if joint is not None and self.number >= 0:
                if len(values) != wanted:
                    raise self.wrong_count(last)
                if joint in self.record:
                    first = self.record[joint][0]
                    raise self.error(number, f"frame {self.number} gives {show(name)} twice; first in line {first}")
                del words[0]
                self.record[joint] = (number, words)
                last, values, wanted = joint, words, self.counts[joint]
            elif self.is_frame(words, len(values) == wanted):
                if len(values) != wanted:
                    raise self.wrong_count(last)
                self.start_frame(number, words[0])
                last, values, wanted = -1, [], 0
            elif self.number < 0:
                self.keyword(number, line, words)
            elif len(values) < wanted and name[0] in b"+-.0123456789":
                # The values of some writers run on in the next line.
                values += words
                if len(values) > wanted:
                    raise self.wrong_count(last)
            else:
                raise self.unknown(number, name)
        if self.number < 0:
            raise self.error(number, "the file ends without a frame; expected a frame number")
        if len(values) != wanted:
            raise self.wrong_count(last)
        self.finish_frame(number)
        self.parse_piece()

    def without_comment(self, line: bytes) -> list[bytes]:
        """Split a line into words up to the first that begins with ``#``."""
        words = line.split()
        for i, word in enumerate(words):
            if word.startswith(b"#"):
                return words[:i]
        return words

    def is_frame(self, words: list[bytes], complete: bool) -> bool:
        """Whether a line is a frame's number, rather than the last of values that run on."""
        if len(words) != 1 or not words[0].isdigit():
            return False
        return complete or int(words[0][:19]) == self.number + 1

    def header_line(self, line: bytes) -> None:
        line = line.rstrip(b"\n")
        if line.startswith(_RATE_COMMENT):
            try:
                self.rate = parse_rate(line[len(_RATE_COMMENT) :].decode("ascii", "replace").strip())
            except OptionError as error:
                raise self.error(len(self.header) + 1, f"{_RATE_COMMENT.decode()} {error}") from None
        else:
            self.keep_header(line)

    def keep_header(self, line: bytes) -> None:
        if len(self.header) >= _HEADER_LINES:
            raise self.error(len(self.header) + 1, f"no frame begins in the first {_HEADER_LINES} lines")
        self.header.append(line)

    def keyword(self, number: int, line: bytes, words: list[bytes]) -> None:
        word = words[0].lower()
        if word in (b":fully-specified", b":fully_specified"):
            self.fully_specified = True
        elif word in (b":degrees", b":radians"):
            self.degrees = word == b":degrees"
        elif not word.startswith(b":"):
            raise self.error(
                number,
                f"expected a keyword (:FULLY-SPECIFIED, :DEGREES, :RADIANS) or a frame number, found {show(words[0])}",
            )
        self.keep_header(line.rstrip(b"\n"))

    def start_frame(self, number: int, word: bytes) -> None:
        frame = parse_count(word)
        if self.number >= 0:
            self.finish_frame(number)
            if frame != self.number + 1:
                raise self.error(number, f"frame {frame} follows frame {self.number}; frame numbers must go up by one")
        else:
            self.first_frame = frame
        # The frames of this piece that are still words count too.
        if self.n_frames + len(self.piece) >= self.options.limits.frames:
            raise self.error(number, f"more than {self.options.limits.frames} frames (Limits.frames)")
        self.number, self.line, self.record = frame, number, {}

    def finish_frame(self, number: int) -> None:
        """Take a frame that is whole, in the order of the first one."""
        record = self.record
        if not self.order:
            missing = [joint for joint, count in enumerate(self.counts) if count and joint not in record]
            self.order = [joint for joint in record if self.counts[joint]] + missing
            self.moving = frozenset(self.order)
        if not self.moving <= record.keys():
            self.fill_in(number)
        for joint in self.order:
            self.words += record[joint][1]
        if not self.fully_specified:
            self.previous = {joint: words for joint, (_, words) in record.items()}
        self.piece.append((self.line, record))
        if len(self.words) >= _PIECE_WORDS:
            self.parse_piece()

    def fill_in(self, number: int) -> None:
        missing = [joint for joint in self.order if joint not in self.record]
        if self.fully_specified:
            names = ", ".join(repr(self.asf.skeleton.names[joint]) for joint in missing[:5])
            more = f" and {len(missing) - 5} more" if len(missing) > 5 else ""
            raise self.error(
                number,
                f"frame {self.number} (line {self.line}) ends without {names}{more}, which {self.asf_path} gives "
                "channels, and the file is :FULLY-SPECIFIED",
            )
        for joint in missing:
            self.left_out[joint] = self.left_out.get(joint, 0) + 1
            self.record[joint] = (self.line, self.previous.get(joint, [b"0"] * self.counts[joint]))

    def wrong_count(self, joint: int) -> FormatError:
        line, words = self.record[joint]
        name = self.asf.skeleton.names[joint]
        channels = self.asf.channels[joint]
        try:
            # Two numbers run together are one too few, and the better thing to say.
            parse_numbers(b" ".join(words), decimal_comma=self.options.decimal_comma)
        except NumberTextError as error:
            number, column = self.place(line, error.index)
            return self.error(number, f"frame {self.number}, joint {name!r}: {error.problem}", column)
        free = f"{len(channels)} ({' '.join(channels)})" if channels else "none"
        return self.error(
            line,
            f"frame {self.number} has {len(words)} value{'s' * (len(words) != 1)} for {name!r}; {self.asf_path} "
            f"gives it {free}",
        )

    def unknown(self, number: int, name: bytes) -> FormatError:
        try:
            parse_number(name)
        except NumberTextError:
            names = self.asf.skeleton.names
            shown = ", ".join(names[:8]) + (", ..." if len(names) > 8 else "")
            return self.error(
                number,
                f"frame {self.number} names the joint {show(name)}, which {self.asf_path} does not have; it has "
                f"{shown}",
            )
        return self.error(number, f"expected a joint of frame {self.number} or the next frame, found {show(name)}")

    def parse_piece(self) -> None:
        """Turn the words of whole frames into numbers."""
        piece, words = self.piece, self.words
        self.piece, self.words = [], []
        if not piece:
            return
        comma = self.options.decimal_comma
        width = sum(self.counts)
        try:
            # Joined by a space, so that a word's index in the text is its index here.
            numbers = parse_numbers(b" ".join(words), decimal_comma=comma)
        except NumberTextError as error:
            whole = error.index // width
            self.blocks.append(np.array(parse_numbers(b" ".join(words[: whole * width]), decimal_comma=comma)))
            self.n_frames += whole
            raise self.bad_word(piece[whole][1], error, self.first_frame + self.n_frames) from None
        self.blocks.append(np.array(numbers))
        self.n_frames += len(piece)

    def bad_word(self, record: dict[int, tuple[int, list[bytes]]], error: NumberTextError, frame: int) -> FormatError:
        index = error.index % sum(self.counts)
        for joint in self.order:
            line, words = record[joint]
            if index < len(words):
                break
            index -= len(words)
        name, channel = self.asf.skeleton.names[joint], self.asf.channels[joint][index]
        number, column = self.place(line, index)
        return self.error(number, f"frame {frame}, joint {name!r}, {channel}: {error.problem}", column)

    def place(self, line: int, index: int) -> tuple[int, int]:
        """Find line and column of a joint's value, which may have been wrapped."""
        index += 1
        for number, text in enumerate(self.data.splitlines()[line - 1 :], line):
            count = len(self.without_comment(text))
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


def _split(channels: tuple[str, ...]) -> tuple[list[int], list[int]]:
    """Tell a joint's places of translations from those of rotations."""
    moves = [i for i, channel in enumerate(channels) if channel[0] == "t"]
    turns = [i for i, channel in enumerate(channels) if channel[0] == "r"]
    return moves, turns


def _axis(channel: str) -> int:
    return "xyz".index(channel[1])


def _pose(asf: Asf, values: list[FloatArray], *, degrees: bool) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Turn the values of an AMC into local rotations, local translations and declared angles."""
    n_frames, n_joints = len(values[0]), len(values)
    rotations = np.empty((n_frames, n_joints, 4))
    translations = np.empty((n_frames, n_joints, 3))
    angles = np.zeros((n_frames, n_joints, 3))
    for joint, channels in enumerate(asf.channels):
        moves, turns = _split(channels)
        place = asf.skeleton.offsets[joint]
        if moves:
            shift = np.zeros((n_frames, 3))
            shift[:, [_axis(channels[i]) for i in moves]] = values[joint][:, moves]
            # Numbers near the largest may overflow; Motion refuses what is not finite and says where.
            with np.errstate(over="ignore", invalid="ignore"):
                place = place + rotation.rotate(asf.before[joint], shift)
        translations[:, joint] = place
        turned = values[joint][:, turns]
        turned = np.deg2rad(turned) if degrees else turned
        angles[:, joint, : len(turns)] = turned
        rotations[:, joint] = _compose(asf, joint, turned)
    return rotations, translations, angles


def _compose(asf: Asf, joint: int, angles: FloatArray) -> FloatArray:
    """Give a joint's local rotations (n_frames, 4) for its angles (n_frames, number of turns), radians."""
    turns = [channel for channel in asf.channels[joint] if channel[0] == "r"]
    turned = rotation.from_euler(turn_order(turns), angles[:, ::-1])
    return rotation.multiply(rotation.multiply(asf.before[joint], turned), asf.after[joint])


def write(motion: Motion | Signal, path: Path, *, overwrite: bool) -> None:
    """Write an AMC, and an ASF where none that fits would be found beside it.

    A motion that was read from an AMC is written on its own ASF. One from elsewhere gets an ASF with its skeleton:
    a joint whose children stand in different places has bones without freedom to each of them, called
    ``<joint>_to_<child>``, and the root is called root.

    Parameters
    ----------
    motion : Motion
        What to write.
    path : Path
        The AMC. The ASF, where one is needed, is written first, with the same stem.
    overwrite : bool
        Replace files that are there.

    Raises
    ------
    OutputExistsError
        The AMC, or an ASF of its stem that belongs to another skeleton, is there, and `overwrite` is not set.
    FormatError
        A joint moves against its parent, and the skeleton gives it no channels for that.

    Warns
    -----
    FormatWarning
        A joint turns about an axis that its ASF does not free, and the nearest angles were written; or joints were
        renamed.
    """
    if not isinstance(motion, Motion):
        raise FormatError("an AMC holds a motion, not a signal", path=path)
    if not overwrite and path.exists():
        raise OutputExistsError(path)
    output = _output(motion, path)
    values = _values(motion, output, path)
    place = _place_for_asf(output, path, overwrite)
    parts = _amc_parts(motion, output, values)
    if place is None:
        write_bytes(path, parts, overwrite=overwrite)
        return
    replaced = place.exists()
    write_bytes(place, output.asf_data, overwrite=overwrite)
    try:
        write_bytes(path, parts, overwrite=overwrite)
    except BaseException:
        # An ASF alone is no output; one that was there before can't be brought back.
        if not replaced:
            place.unlink(missing_ok=True)
        raise


@dataclass(frozen=True, eq=False)
class _Output:
    """What an AMC is written with: a skeleton, the motion's joint for each of its joints (-1: none), and a manner."""

    asf: Asf
    asf_data: bytes
    joints: tuple[int, ...]
    declaration: AsfDeclaration
    declared: bool


def _output(motion: Motion, path: Path) -> _Output:
    declaration = motion.declaration
    if isinstance(declaration, AsfDeclaration):
        asf = parse_asf(Path(declaration.asf_name), declaration.asf, _UNBOUNDED)
        skeleton = motion.skeleton
        if (
            asf.skeleton.names == skeleton.names
            and asf.skeleton.parents == skeleton.parents
            and np.array_equal(asf.skeleton.offsets, skeleton.offsets)
        ):
            return _Output(asf, declaration.asf, tuple(range(skeleton.n_joints)), declaration, True)
    offsets = motion.local_translations[0].copy()
    text, names = make_asf(motion.skeleton, offsets, motion.metres_per_unit)
    renamed = [
        f"{old!r} to {new!r}" for old, new in zip(motion.skeleton.names[1:], names[1:], strict=True) if old != new
    ]
    if renamed:
        shown = ", ".join(renamed[:5]) + (", ..." if len(renamed) > 5 else "")
        warnings.warn(
            f"{path}: an AMC can't hold {len(renamed)} of the joints' names; renamed {shown}",
            FormatWarning,
            stacklevel=4,
        )
    asf = parse_asf(path.with_suffix(".asf"), text, _UNBOUNDED)
    place = {name: joint for joint, name in enumerate(names)}
    joints = tuple(place.get(name, -1) for name in asf.skeleton.names)
    made = AsfDeclaration(
        format="amc",
        channels=(),
        header=(b":FULLY-SPECIFIED", b":DEGREES"),
        joint_order=tuple(joint for joint, channels in enumerate(asf.channels) if channels),
    )
    return _Output(asf, text, joints, made, False)


def _place_for_asf(output: _Output, path: Path, overwrite: bool) -> Path | None:
    """Say where the ASF must be written; None where a reader of the AMC would find one that fits."""
    found, _ = find_asf(path)
    if found is not None:
        try:
            data = read_bytes(found)
            if data == output.asf_data or parse_asf(found, data, Limits()).same_as(output.asf):
                return None
        except FormatError:
            pass
        if found.stem.casefold() == path.stem.casefold():
            if not overwrite:
                raise OutputExistsError(found)
            return found
    return path.with_suffix(".asf")


def _values(motion: Motion, output: _Output, path: Path) -> list[FloatArray]:
    """Find each joint's values in the order of its channels, shape (n_frames, number of channels)."""
    asf = output.asf
    values = []
    scale = float(np.max(np.abs(asf.skeleton.offsets[1:]), initial=0.0))
    worst: tuple[float, int, int] = (0.0, 0, 0)
    n_off = 0
    for joint, source in enumerate(output.joints):
        channels = asf.channels[joint]
        moves, turns = _split(channels)
        columns = np.zeros((motion.n_frames, len(channels)))
        if source >= 0:
            shift = motion.local_translations[:, source]
            # A joint's place was made from its first frame where the ASF is made up; helper bones lead to it.
            shift = shift - (
                motion.local_translations[0, source] if not output.declared and joint else asf.skeleton.offsets[joint]
            )
            shift = rotation.rotate(rotation.conjugate(asf.before[joint]), shift)
            columns[:, moves] = shift[:, [_axis(channels[i]) for i in moves]]
            _refuse_moving(shift, {_axis(channels[i]) for i in moves}, scale, motion, source, path)
            angles, off = _angles(motion, output, joint, source)
            columns[:, turns] = np.rad2deg(angles) if output.declaration.degrees else angles
            n_off += bool(off.max() > 1e-3)
            worst = max(worst, (float(off.max()), source, int(off.argmax())))
        values.append(columns)
    if worst[0] > 1e-3:
        angle, source, frame = worst
        others = f" (the largest of {n_off} joints)" if n_off > 1 else ""
        warnings.warn(
            f"{path}: the nearest angles were written where the ASF frees too few: joint "
            f"{motion.skeleton.names[source]!r} is off by up to {angle:.3g} degrees, at frame {frame}{others}",
            FormatWarning,
            stacklevel=4,
        )
    return values


def _refuse_moving(shift: FloatArray, free: set[int], scale: float, motion: Motion, source: int, path: Path) -> None:
    held = np.linalg.norm(shift[:, [axis for axis in range(3) if axis not in free]], axis=-1)
    if held.max() > _STILL * scale:
        frame = int(held.argmax())
        raise FormatError(
            f"joint {motion.skeleton.names[source]!r} is {held.max():.6g} units from its place at frame {frame}, "
            "and the ASF gives it no translation; write a BVH instead",
            path=path,
        )


def _angles(motion: Motion, output: _Output, joint: int, source: int) -> tuple[FloatArray, FloatArray]:
    """Find a joint's angles, shape (n_frames, number of turns), radians, and how far they miss, in degrees."""
    asf = output.asf
    q = motion.rotations[:, source]
    turns = [channel for channel in asf.channels[joint] if channel[0] == "r"]
    m = rotation.multiply(
        rotation.multiply(rotation.conjugate(asf.before[joint]), q), rotation.conjugate(asf.after[joint])
    )
    near = _declared(motion, output, source, turns)
    # Intrinsic angles in the order of multiplication are the file's, backwards.
    angles = fit_angles(turn_order(turns), m, near=None if near is None else near[:, ::-1])[:, ::-1]
    if near is None and np.abs(angles).max(initial=0.0) > _MOST_WOUND:
        angles = angles - 2.0 * np.pi * np.round(angles / (2.0 * np.pi))
    return angles, np.rad2deg(angle_between(q, _compose(asf, joint, angles)))


def _declared(motion: Motion, output: _Output, source: int, turns: list[str]) -> FloatArray | None:
    """Find the angles that a joint's file gave it, where they mean the same here, shape (n_frames, number of turns)."""
    declaration, angles = motion.declaration, motion.declared_angles
    if angles is None or declaration is None:
        return None
    if output.declared:
        return angles[:, source, : len(turns)]
    if declaration.format == "bvh" and len(declaration.channels) == motion.skeleton.n_joints:
        # BVH multiplies in the order in which it lists its rotations, ASF the other way round.
        letters = [channel[0] for channel in declaration.channels[source] if channel.endswith("rotation")]
        if "".join(letters) == turn_order(turns):
            return angles[:, source, ::-1]
    return None


def _amc_parts(motion: Motion, output: _Output, values: list[FloatArray]) -> Iterator[bytes]:
    """Yield the file's bytes, some frames at a time."""
    declaration, asf = output.declaration, output.asf
    end = declaration.line_end
    header = [line + end for line in declaration.header]
    if motion.rate != ASSUMED_RATE:
        header.insert(0, b"%b %b" % (_RATE_COMMENT, str(motion.rate).encode()) + end)
    yield b"".join(header)
    layout = "%d\n"
    columns = []
    for joint in declaration.joint_order:
        layout += asf.skeleton.names[joint].replace("%", "%%") + " %.10g" * len(asf.channels[joint]) + "\n"
        columns.append(values[joint])
    layout = layout.replace("\n", end.decode())
    table = np.concatenate([np.empty((motion.n_frames, 0)), *columns], axis=1)
    # Sampling resets the count to 0, but most files count from 1.
    first = motion.first_frame or min(declaration.counts_from, 1)
    for start in range(0, motion.n_frames, 256):
        rows = table[start : start + 256].tolist()
        text = "".join([layout % (first + start + i, *row) for i, row in enumerate(rows)])
        yield text.encode(asf.encoding)
