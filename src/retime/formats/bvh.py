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
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from decimal import Context, Decimal
from fractions import Fraction
from os import fspath
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from retime.errors import FormatError, FormatWarning
from retime.formats.bvh_frames import Frames, parse_frames
from retime.formats.bvh_hierarchy import CHANNELS, Hierarchy, parse_hierarchy
from retime.formats.files import write_bytes
from retime.formats.options import ReadOptions
from retime.formats.text_lines import Lines, without_byte_order_mark
from retime.motion import rotation
from retime.motion.euler import angle_between, fit_angles
from retime.motion.motion import Declaration, Motion
from retime.motion.rate import rate_from_frame_time
from retime.motion.rotation import FloatArray
from retime.motion.signal import Signal
from retime.motion.skeleton import Skeleton

IntArray = NDArray[np.intp]

_AXIS = {"X": 0, "Y": 1, "Z": 2}
# Numbers are written with six decimals; what is nearer than half of the last one comes out the same.
_DECIMALS = 6
_UNSEEN = 0.5 * 10.0**-_DECIMALS
# Degrees by which a rotation may miss what its joint's channels can express before that is worth a warning.
_MISSED = 1e-3
_ROWS = 256


@dataclass(frozen=True)
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
    lines = Lines(without_byte_order_mark(path, data), path, options.limits)
    hierarchy = parse_hierarchy(lines, options)
    if hierarchy.encoding != "utf-8":
        _warn(path, "the joint names are not UTF-8; read as Latin-1")
    return _motion(hierarchy, parse_frames(lines, hierarchy, options), path.stem)


def _motion(hierarchy: Hierarchy, frames: Frames, name: str) -> Motion:
    skeleton = Skeleton(hierarchy.names, hierarchy.parents, np.array(hierarchy.offsets), hierarchy.end_sites)
    layout = _Layout(hierarchy.channels)
    shape = (len(frames.values), skeleton.n_joints)
    translations = np.empty((*shape, 3))
    translations[:] = skeleton.offsets
    translations.reshape(len(translations), -1)[:, layout.position_places] = frames.values[:, layout.position_columns]
    angles = np.zeros((*shape, 3))
    rotations = rotation.identity(*shape)
    for order, (joints, columns) in layout.turns.items():
        turns = np.deg2rad(frames.values[:, columns])
        angles[:, joints, : len(order)] = turns
        rotations[:, joints] = rotation.from_euler(order, turns)
    return Motion(
        skeleton,
        rotations,
        translations,
        frames.rate,
        name=name,
        declaration=BvhDeclaration("bvh", hierarchy.channels, frames.frame_time, encoding=hierarchy.encoding),
        declared_angles=angles,
    )


class _Layout:
    """Where the channels of a frame lie.

    Attributes
    ----------
    position_columns, position_places : list of int
        Columns of position channels, and where each belongs in a frame's (n_joints * 3) translations.
    turns : dict
        For each rotation order the joints that have it, shape (n,), and their columns, shape (n, len(order)).
    n_columns : int
        Channels in all.
    """

    def __init__(self, channels: tuple[tuple[str, ...], ...]) -> None:
        self.position_columns: list[int] = []
        self.position_places: list[int] = []
        turns: dict[str, tuple[list[int], list[list[int]]]] = {}
        column = 0
        for joint, names in enumerate(channels):
            order, columns = "", []
            for name in names:
                if name.endswith("rotation"):
                    order += name[0]
                    columns.append(column)
                else:
                    self.position_columns.append(column)
                    self.position_places.append(3 * joint + _AXIS[name[0]])
                column += 1
            joints, rows = turns.setdefault(order, ([], []))
            joints.append(joint)
            rows.append(columns)
        self.n_columns = column
        self.turns: dict[str, tuple[IntArray, IntArray]] = {
            order: (np.array(joints, dtype=np.intp), np.array(rows, dtype=np.intp).reshape(len(joints), len(order)))
            for order, (joints, rows) in turns.items()
        }


def write(motion: Motion | Signal, path: Path, *, overwrite: bool) -> None:
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
    joints = _depth_first(motion.skeleton)
    channels = tuple(declaration.channels[joint] for joint in joints)
    names = _names(motion.skeleton, declaration.encoding, path)
    yield _hierarchy_text(motion.skeleton, names, declaration.channels)
    yield f"MOTION\nFrames: {motion.n_frames}\n".encode()
    yield f"Frame Time: {_frame_time_text(motion.rate, declaration.frame_time, path)}\n".encode()
    angles = motion.declared_angles if declaration is motion.declaration else None
    values = _values(motion, angles, np.array(joints), _Layout(channels), path)
    row = " ".join([f"%.{_DECIMALS}f"] * values.shape[1]) + "\n"
    for start in range(0, len(values), _ROWS):
        yield "".join([row % tuple(numbers) for numbers in values[start : start + _ROWS].tolist()]).encode()


def _declaration(motion: Motion, path: Path) -> BvhDeclaration:
    """Return what the motion's file declared, or what suits a motion from elsewhere."""
    skeleton = motion.skeleton
    declared = motion.declaration
    if declared is None or declared.format != "bvh" or len(declared.channels) != skeleton.n_joints:
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
    # A joint waits to be opened with its depth; None in its place waits to be closed.
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
    text = ""
    for digits in range(7, 41):
        exact = Context(prec=digits).divide(Decimal(rate.denominator), Decimal(rate.numerator))
        text = f"{exact:f}"
        if _gives(text, rate):
            return text
    _warn(path, f"no decimal frame time gives the rate {rate} exactly; written as {text}")
    return text


def _gives(frame_time: str, rate: Fraction) -> bool:
    try:
        return rate_from_frame_time(frame_time) == rate
    except ValueError:
        return False


def _values(
    motion: Motion, declared_angles: FloatArray | None, joints: IntArray, layout: _Layout, path: Path
) -> FloatArray:
    """Lay out the numbers of all frames, shape (n_frames, n_columns); `joints` in the order of writing."""
    values = np.empty((motion.n_frames, layout.n_columns))
    translations = motion.local_translations[:, joints].reshape(motion.n_frames, -1)
    values[:, layout.position_columns] = translations[:, layout.position_places]
    _warn_of_lost_positions(motion, joints, translations, layout, path)
    missed = np.zeros((motion.n_frames, len(joints)))
    for order, (places, columns) in layout.turns.items():
        turned = motion.rotations[:, joints[places]]
        near = None if declared_angles is None else declared_angles[:, joints[places], : len(order)]
        angles = fit_angles(order, turned, near=near)
        if len(order) < 3:
            missed[:, places] = angle_between(rotation.from_euler(order, angles), turned)
        values[:, columns] = np.rad2deg(angles)
    frame, place = np.unravel_index(int(missed.argmax()), missed.shape)
    if np.rad2deg(missed[frame, place]) > _MISSED:
        name = motion.skeleton.names[joints[place]]
        _warn(
            path,
            f"the rotation channels of joint {name!r} can't express its rotation at frame {frame}: the nearest was "
            f"written, {np.rad2deg(missed[frame, place]):.3g} degrees off (the largest error of the file)",
        )
    values[np.abs(values) < _UNSEEN] = 0.0
    return values


def _warn_of_lost_positions(
    motion: Motion, joints: IntArray, translations: FloatArray, layout: _Layout, path: Path
) -> None:
    held = np.ones(translations.shape[1], dtype=bool)
    held[layout.position_places] = False
    lost = np.abs(translations[:, held] - motion.skeleton.offsets[joints].reshape(-1)[held])
    if lost.size == 0 or lost.max() <= 2 * _UNSEEN:
        return
    frame, column = np.unravel_index(int(lost.argmax()), lost.shape)
    place = int(np.flatnonzero(held)[column])
    _warn(
        path,
        f"joint {motion.skeleton.names[joints[place // 3]]!r} has no channel {CHANNELS[place % 3]}: its offset was "
        f"written at frame {frame}, {lost.max():.3g} units off (the largest error of the file)",
    )


def _warn(path: Path, problem: str) -> None:
    warnings.warn(FormatWarning(f"{fspath(path)}: {problem}"), stacklevel=2)
