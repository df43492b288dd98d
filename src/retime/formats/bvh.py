"""BVH: a hierarchy of joints with channels, then a row of numbers for each frame.

What the numbers mean, where programs differ:

* A joint's rotation channels multiply in the order in which they are declared: ``Zrotation Yrotation Xrotation`` is
  Rz Ry Rx, with angles in degrees. Fewer than three are fine.
* A joint's position channels replace its OFFSET along their axes; an axis without a channel keeps it. Blender writes
  such channels for every joint that is not connected to its parent.
* Frames are counted from 0 in messages.
* Names are UTF-8, else Latin-1; a name may hold anything but a line end, and no white space at its ends.
"""

from __future__ import annotations

import warnings
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from decimal import Context, Decimal
from fractions import Fraction
from os import fspath
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from retime.arrays import FloatArray
from retime.errors import FormatError, FormatWarning
from retime.files import write_bytes
from retime.formats.bvh_frames import parse_frames
from retime.formats.bvh_hierarchy import CHANNELS, parse_hierarchy
from retime.formats.number_text import format_table
from retime.formats.read_options import ReadOptions
from retime.formats.text_lines import Lines, without_byte_order_mark, without_end_padding
from retime.kernels import JointArrays, JointChannels, RowFormat, TurnedJoints, backend
from retime.motion import rotation
from retime.motion.any_motion import AnyMotion
from retime.motion.euler import angle_between, fit_angles
from retime.motion.motion import Declaration, Motion
from retime.motion.rate import rate_from_frame_time
from retime.motion.skeleton import Skeleton

IntArray = NDArray[np.intp]

_AXIS = {"X": 0, "Y": 1, "Z": 2}
# Numbers are written with six decimals; what is nearer than half of the last one comes out the same.
_UNSEEN = 0.5e-6
# Degrees by which a rotation may miss what its joint's channels can express before that is worth a warning.
_MISSED = 1e-3
# Frames written at once: few enough to stay in the processor's cache, which is twice as fast.
_ROWS = 256


@dataclass(frozen=True, repr=False)
class BvhDeclaration(Declaration):
    """What a BVH file declared.

    Attributes
    ----------
    encoding : str
        How its names are written, "utf-8" or "latin-1".
    """

    encoding: str = "utf-8"


def read(path: Path, data: bytes, options: ReadOptions) -> Motion:
    """Read a BVH file.

    Parameters
    ----------
    path : Path
        Where the bytes come from, for messages and for the motion's name.
    data : bytes
        The whole file.
    options : ReadOptions
        Rate, repair, decimal comma and limits.

    Returns
    -------
    Motion
        In the file's own length units, with a `BvhDeclaration` and its declared angles.

    Raises
    ------
    FormatError
        The file is not a BVH motion: with the line, what was expected and what was found.

    Warns
    -----
    FormatWarning
        The file holds more frames than it says, or one less; with ``options.repair``, frames were dropped.
    """
    lines = Lines(without_end_padding(without_byte_order_mark(path, data)), path, options.limits)
    hierarchy = parse_hierarchy(lines, options)
    if hierarchy.encoding != "utf-8":
        _warn(path, "the joint names are not UTF-8; read as Latin-1")
    skeleton = Skeleton(hierarchy.names, hierarchy.parents, np.array(hierarchy.offsets), hierarchy.end_sites)
    joints = _Joints(skeleton, _Layout(hierarchy.channels))
    frames = parse_frames(lines, hierarchy, options, joints)
    rotations, translations, angles = joints.arrays()
    return Motion(
        skeleton,
        rotations,
        translations,
        frames.rate,
        name=path.stem,
        declaration=BvhDeclaration("bvh", hierarchy.channels, frames.frame_time, encoding=hierarchy.encoding),
        declared_angles=angles,
    )


class _Joints:
    """Rotations, translations and angles of joints, made of frames as these come."""

    def __init__(self, skeleton: Skeleton, layout: _Layout) -> None:
        self.skeleton, self.layout = skeleton, layout
        threefold = tuple(turns.threefold for turns in layout.turns if turns.threefold is not None)
        self.channels: JointChannels | None = None
        if len(threefold) == len(layout.turns):
            self.channels = JointChannels(threefold, layout.position_columns, layout.position_places, skeleton.offsets)
        self.n_frames = 0
        self.rotations, self.translations, self.angles = self._room(0)

    def _room(self, n_frames: int) -> tuple[FloatArray, FloatArray, FloatArray]:
        shape = (n_frames, self.skeleton.n_joints)
        return np.empty((*shape, 4)), np.empty((*shape, 3)), np.zeros((*shape, 3))

    def take(self, table: FloatArray, more: int) -> None:
        """Take frames, shape (n, n_channels); about so many more will follow."""
        rows = slice(self.n_frames, self.n_frames + len(table))
        if rows.stop > len(self.rotations):
            before, room = self.arrays(), self._room(rows.stop + more)
            for array, known in zip(room, before, strict=True):
                array[: self.n_frames] = known
            self.rotations, self.translations, self.angles = room
        self.n_frames = rows.stop
        layout, rotations, angles = self.layout, self.rotations[rows], self.angles[rows]
        self.translations[rows] = self.skeleton.offsets
        coordinates = self.translations[rows].reshape(len(table), -1)
        coordinates[:, layout.position_places] = table[:, layout.position_columns]
        for turns in layout.turns:
            if turns.threefold is not None:
                backend(warn=False).turn_joints(table, turns.threefold, angles, rotations)
                continue
            radians = rotation.radians(turns.take(table))
            angles[:, turns.joints, : len(turns.order)] = radians
            rotations[:, turns.joints] = rotation.from_euler(turns.order, radians)

    def take_text(self, text: bytes, start: int, piece_bytes: int, rows: RowFormat, most: int) -> tuple[int, int]:
        """Take plain frames from a place of the text on, at most so many: returns how many, and their bytes."""
        room = slice(self.n_frames, min(len(self.rotations), self.n_frames + most))
        if self.channels is None or room.stop <= room.start:
            return 0, 0
        into = JointArrays(self.rotations[room], self.translations[room], self.angles[room])
        found = backend(warn=False).read_joint_rows(text, start, piece_bytes, rows, self.channels, into)
        if found is None:
            return 0, 0
        self.n_frames += found[0]
        return found

    def arrays(self) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Return rotations, translations and angles of the frames that came."""
        n = self.n_frames
        return self.rotations[:n], self.translations[:n], self.angles[:n]


@dataclass(frozen=True, eq=False)
class _Turns:
    """The joints that declare one rotation order.

    Attributes
    ----------
    order : str
        None to three of the letters X, Y, Z.
    joints : slice or int array, shape (n,)
        A slice where the joints follow one another, which is far faster to copy.
    columns : slice or int array, shape (n * len(order),)
        Their rotation channels in a frame.
    threefold : TurnedJoints, optional
        The same for the kernels, where these are three different axes.
    """

    order: str
    joints: slice | IntArray
    columns: slice | IntArray
    threefold: TurnedJoints | None

    def take(self, values: FloatArray) -> FloatArray:
        """Take these channels out of frames, shape (n_frames, n, len(order))."""
        n = self.joints.stop - self.joints.start if isinstance(self.joints, slice) else len(self.joints)
        return values[:, self.columns].reshape(len(values), n, len(self.order))


class _Layout:
    """Where the channels of a frame lie.

    Attributes
    ----------
    position_columns, position_places : int array
        Columns of position channels, and where each belongs among a frame's (n_joints * 3) coordinates.
    turns : list of _Turns
        One for each rotation order; together they hold every joint once.
    n_columns : int
        Channels in all.
    """

    def __init__(self, channels: Sequence[tuple[str, ...]]) -> None:
        position_columns: list[int] = []
        position_places: list[int] = []
        turns: dict[str, tuple[list[int], list[int]]] = {}
        column = 0
        for joint, names in enumerate(channels):
            order = "".join(name[0] for name in names if name.endswith("rotation"))
            joints, columns = turns.setdefault(order, ([], []))
            joints.append(joint)
            for name in names:
                if name.endswith("rotation"):
                    columns.append(column)
                else:
                    position_columns.append(column)
                    position_places.append(3 * joint + _AXIS[name[0]])
                column += 1
        self.n_columns = column
        self.position_columns = np.array(position_columns, dtype=np.int64)
        self.position_places = np.array(position_places, dtype=np.int64)
        self.turns = [
            _Turns(order, _run(joints), _run(columns), _threefold(order, joints, columns))
            for order, (joints, columns) in turns.items()
        ]


def _threefold(order: str, joints: list[int], columns: list[int]) -> TurnedJoints | None:
    if len(set(order)) < 3:
        return None
    places = np.array(columns, dtype=np.int64).reshape(-1, 3)
    return TurnedJoints(order, np.array(joints, dtype=np.int64), places, rotation.MANY_DEGREES)


def _run(indices: list[int]) -> slice | IntArray:
    first = indices[0] if indices else 0
    if indices == list(range(first, first + len(indices))):
        return slice(first, first + len(indices))
    return np.array(indices, dtype=np.intp)


def write(motion: AnyMotion, path: Path, *, overwrite: bool) -> None:
    """Write a BVH file, all or nothing.

    A motion that was read from BVH is written as it was declared: names, hierarchy, offsets, channels and their order,
    frame time (where the rate is still the one it gave), and the angles that the file used where they still mean the
    same rotation. Any other motion gets six channels at the root, ``Zrotation Yrotation Xrotation`` elsewhere, and
    position channels at joints that leave their offset. Numbers have six decimals, offsets as many as they need.

    Parameters
    ----------
    motion : Motion
        What to write.
    path : Path
        Where.
    overwrite : bool
        Replace a file that is there.

    Raises
    ------
    OutputExistsError
        The file is there, and `overwrite` is not set.
    FormatError
        The declaration names channels that BVH does not have.

    Warns
    -----
    FormatWarning
        A name that BVH can't hold was changed (a line end to ``_``, white space at the ends cut, an empty name to
        ``joint_N``), or channels are missing for what the motion does and the nearest that they express is written.
    """
    if not isinstance(motion, Motion):
        raise FormatError("a BVH file holds a motion, not a signal", path=path)
    write_bytes(path, _parts(motion, path), overwrite=overwrite)


def _parts(motion: Motion, path: Path) -> Iterator[bytes]:
    """Yield the file's text piece by piece."""
    declaration = _declaration(motion, path)
    names = _names(motion.skeleton, declaration.encoding, path)
    yield _hierarchy_text(motion.skeleton, names, declaration.channels)
    yield f"MOTION\nFrames: {motion.n_frames}\n".encode()
    yield f"Frame Time: {_frame_time_text(motion.rate, declaration.frame_time, path)}\n".encode()
    rows = _Rows(motion, declaration)
    for start in range(0, motion.n_frames, _ROWS):
        yield format_table(rows.values(start, min(start + _ROWS, motion.n_frames)))
    rows.warn_of_misses(path)


def _declaration(motion: Motion, path: Path) -> BvhDeclaration:
    """Return what the motion's file declared, or what suits a motion from elsewhere."""
    skeleton = motion.skeleton
    declared = motion.declaration
    if declared is None or declared.format != "bvh" or len(declared.channels) != skeleton.n_joints:
        with np.errstate(over="ignore"):
            moves = np.abs(motion.local_translations - skeleton.offsets).max(axis=(0, 2)) > _UNSEEN
        moves[0] = True
        turns = ("Zrotation", "Yrotation", "Xrotation")
        return BvhDeclaration("bvh", tuple(CHANNELS[:3] + turns if moved else turns for moved in moves))
    for name, channels in zip(skeleton.names, declared.channels, strict=True):
        if len(set(channels)) < len(channels) or not set(channels) <= set(CHANNELS):
            raise FormatError(
                f"joint {name!r} declares the channels {', '.join(channels)}; BVH has {', '.join(CHANNELS)}, once each",
                path=path,
            )
    if isinstance(declared, BvhDeclaration):
        return declared
    return BvhDeclaration("bvh", declared.channels, declared.frame_time)


def _children(skeleton: Skeleton) -> list[list[int]]:
    children: list[list[int]] = [[] for _ in skeleton.names]
    for joint, parent in enumerate(skeleton.parents[1:], start=1):
        children[parent].append(joint)
    return children


def _depth_first(skeleton: Skeleton) -> list[int]:
    """List the joints in the order in which a hierarchy with braces must write them."""
    children = _children(skeleton)
    order, waiting = [], [0]
    while waiting:
        joint = waiting.pop()
        order.append(joint)
        waiting += reversed(children[joint])
    return order


def _names(skeleton: Skeleton, encoding: str, path: Path) -> list[bytes]:
    """Encode the joints' names; change those that would not be read back as they are."""
    try:
        "".join(skeleton.names).encode(encoding)
    except UnicodeEncodeError:
        encoding = "utf-8"
    names, changed = [], []
    for joint, name in enumerate(skeleton.names):
        text = name.replace("\r\n", "_").replace("\r", "_").replace("\n", "_")
        encoded = text.encode(encoding, "replace").strip() or f"joint_{joint}".encode()
        if encoded.decode(encoding) != name:
            changed.append(f"{name!r} is written as {encoded.decode(encoding)!r}")
        names.append(encoded)
    if changed:
        more = f" (and {len(changed) - 1} more)" if len(changed) > 1 else ""
        _warn(path, f"a joint's name that BVH can't hold was changed: {changed[0]}{more}")
    return names


def _hierarchy_text(skeleton: Skeleton, names: list[bytes], channels: tuple[tuple[str, ...], ...]) -> bytes:
    children = _children(skeleton)
    ends: list[list[tuple[float, float, float]]] = [[] for _ in names]
    for site in skeleton.end_sites:
        ends[site.parent].append(site.offset)
    text = [b"HIERARCHY\n"]
    # The stack: a joint and its depth, still to be written; None in place of the joint where a brace is to be closed.
    waiting: list[tuple[int | None, int]] = [(0, 0)]
    while waiting:
        joint, depth = waiting.pop()
        tabs = b"\t" * depth
        if joint is None:
            text.append(tabs + b"}\n")
            continue
        inside = tabs + b"\t"
        listed = " ".join([str(len(channels[joint])), *channels[joint]]).encode()
        text.append(tabs + (b"JOINT " if joint else b"ROOT ") + names[joint] + b"\n" + tabs + b"{\n")
        text.append(inside + _offset_text(skeleton.offsets[joint]) + inside + b"CHANNELS " + listed + b"\n")
        for offset in ends[joint]:
            text.append(inside + b"End Site\n" + inside + b"{\n")
            text.append(inside + b"\t" + _offset_text(offset) + inside + b"}\n")
        waiting.append((None, depth))
        waiting += [(child, depth + 1) for child in reversed(children[joint])]
    return b"".join(text)


def _offset_text(offset: Iterable[float]) -> bytes:
    numbers = [np.format_float_positional(value, unique=True, trim="0") for value in offset]
    return f"OFFSET {' '.join(numbers)}\n".encode()


def _frame_time_text(rate: Fraction, declared: str, path: Path) -> str:
    """Return the declared frame time if it still gives the rate, else one with enough digits to give it."""
    if declared and _gives(declared, rate):
        return declared
    seconds = Context(prec=60).divide(Decimal(rate.denominator), Decimal(rate.numerator))
    text = ""
    # Seven digits at least, for programs that take them as they are.
    for decimals in range(max(1, 6 - seconds.adjusted()), 30):
        text = f"{seconds:.{decimals}f}"
        plain = text.rstrip("0")
        for candidate in (plain + "0" if plain.endswith(".") else plain, text):
            if _gives(candidate, rate):
                return candidate
    _warn(path, f"no decimal frame time gives the rate {rate} exactly; written as {text}")
    return text


def _gives(frame_time: str, rate: Fraction) -> bool:
    try:
        return rate_from_frame_time(frame_time) == rate
    except ValueError:
        return False


class _Rows:
    """The numbers of a motion's frames, and how far they miss what its joints do where channels are lacking."""

    def __init__(self, motion: Motion, declaration: BvhDeclaration) -> None:
        self.motion = motion
        # In the order of writing, which is the motion's own where it was read from a BVH.
        self.joints = np.array(_depth_first(motion.skeleton), dtype=np.intp)
        self.layout = _Layout([declaration.channels[joint] for joint in self.joints])
        self.in_order = bool(np.all(self.joints == np.arange(len(self.joints))))
        self.rotations = motion.rotations if self.in_order else motion.rotations[:, self.joints]
        self.translations = motion.local_translations if self.in_order else motion.local_translations[:, self.joints]
        self.angles = self._angles_to_stay_near(declaration)
        offsets = motion.skeleton.offsets[self.joints].reshape(-1)
        self.held = np.setdiff1d(np.arange(len(offsets)), self.layout.position_places)
        self.held_at = offsets[self.held]
        # The largest errors so far, with their frame and their place among the joints or coordinates.
        self.turn_missed = (0.0, 0, 0)
        self.move_missed = (0.0, 0, 0)

    def _angles_to_stay_near(self, declaration: BvhDeclaration) -> FloatArray:
        declared = self.motion.declared_angles
        if declaration is self.motion.declaration and declared is not None:
            return declared if self.in_order else declared[:, self.joints]
        angles = np.zeros((*self.rotations.shape[:2], 3))
        for turns in self.layout.turns:
            angles[:, turns.joints, : len(turns.order)] = fit_angles(turns.order, self.rotations[:, turns.joints])
        return angles

    def values(self, start: int, stop: int) -> FloatArray:
        """Lay out the numbers of frames ``start`` to ``stop - 1``, shape (stop - start, n_columns)."""
        n_frames = stop - start
        values = np.empty((n_frames, self.layout.n_columns))
        coordinates = self.translations[start:stop].reshape(n_frames, -1)
        values[:, self.layout.position_columns] = coordinates[:, self.layout.position_places]
        with np.errstate(over="ignore"):
            moved = np.abs(coordinates[:, self.held] - self.held_at)
        self.move_missed = max(self.move_missed, _largest(moved, start), key=lambda found: found[0])
        for turns in self.layout.turns:
            order = turns.order
            rotations = self.rotations[start:stop, turns.joints]
            angles = fit_angles(order, rotations, near=self.angles[start:stop, turns.joints, : len(order)])
            values[:, turns.columns] = np.rad2deg(angles).reshape(n_frames, -1)
            if len(order) < 3:
                missed, frame, place = _largest(angle_between(rotation.from_euler(order, angles), rotations), start)
                place = int(np.arange(len(self.joints))[turns.joints][place])
                self.turn_missed = max(self.turn_missed, (missed, frame, place), key=lambda found: found[0])
        return values

    def warn_of_misses(self, path: Path) -> None:
        """Tell of the largest errors, once all frames are laid out."""
        names = self.motion.skeleton.names
        radians, frame, place = self.turn_missed
        if np.rad2deg(radians) > _MISSED:
            _warn(
                path,
                f"joint {names[self.joints[place]]!r} has too few rotation channels for its rotation at frame {frame}: "
                f"the nearest was written, {np.rad2deg(radians):.3g} degrees off (the largest error of the file)",
            )
        distance, frame, column = self.move_missed
        if distance > 2 * _UNSEEN:
            place, axis = divmod(int(self.held[column]), 3)
            _warn(
                path,
                f"joint {names[self.joints[place]]!r} has no channel {CHANNELS[axis]}: its offset was written at frame "
                f"{frame}, {distance:.3g} units off (the largest error of the file)",
            )


def _largest(errors: FloatArray, first_frame: int) -> tuple[float, int, int]:
    if errors.size == 0:
        return 0.0, first_frame, 0
    frame, place = divmod(int(errors.argmax()), errors.shape[1])
    return float(errors[frame, place]), first_frame + frame, place


def _warn(path: Path, problem: str) -> None:
    warnings.warn(FormatWarning(f"{fspath(path)}: {problem}"), stacklevel=2)
