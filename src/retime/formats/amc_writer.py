"""Writes an AMC, and an ASF beside it where none that fits is there."""

from __future__ import annotations

import warnings
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from retime.arrays import FloatArray
from retime.errors import FormatError, FormatWarning, OutputExistsError
from retime.files import read_bytes, write_bytes
from retime.formats.amc_declaration import ASSUMED_RATE, RATE_COMMENT, AsfDeclaration
from retime.formats.asf import Asf, axis_of, compose_turns, find_asf, split_channels, turn_order
from retime.formats.asf_reader import parse_asf
from retime.formats.asf_writer import make_asf
from retime.formats.read_options import Limits
from retime.motion import rotation
from retime.motion.any_motion import AnyMotion
from retime.motion.euler import angle_between, fit_angles
from retime.motion.motion import Motion

# For an ASF that is already in memory: one that was read within its reader's limits, or one made here, whose helper
# bones may lead past those that the motion keeps.
_UNBOUNDED = Limits(joints=1 << 40, depth=1 << 40, line_bytes=1 << 40, name_bytes=1 << 40)
# Of the longest offset: what a program that works in 32-bit numbers leaves of a translation that doesn't move.
_STILL = 1e-5
# Radians. Near gimbal lock angles can wind up turn after turn, and would lose their decimals.
_MOST_WOUND = 8 * np.pi


def write(motion: AnyMotion, path: Path, *, overwrite: bool) -> None:
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
        # An ASF without its AMC is of no use, so it goes; but one that was replaced can't be brought back.
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
        moves, turns = split_channels(channels)
        columns = np.zeros((motion.n_frames, len(channels)))
        if source >= 0:
            shift = motion.local_translations[:, source]
            # In an ASF made here, helper bones lead to where the joint stands in the first frame.
            shift = shift - (
                motion.local_translations[0, source] if not output.declared and joint else asf.skeleton.offsets[joint]
            )
            shift = rotation.rotate(rotation.conjugate(asf.before[joint]), shift)
            columns[:, moves] = shift[:, [axis_of(channels[i]) for i in moves]]
            _refuse_moving(shift, {axis_of(channels[i]) for i in moves}, scale, motion, source, path)
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
    # The file lists angles about fixed axes, which are the intrinsic angles in reverse order.
    angles = fit_angles(turn_order(turns), m, near=None if near is None else near[:, ::-1])[:, ::-1]
    if near is None and np.abs(angles).max(initial=0.0) > _MOST_WOUND:
        angles = angles - 2.0 * np.pi * np.round(angles / (2.0 * np.pi))
    return angles, np.rad2deg(angle_between(q, compose_turns(asf, joint, angles)))


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
        header.insert(0, b"%b %b" % (RATE_COMMENT, str(motion.rate).encode()) + end)
    yield b"".join(header)
    layout = "%d\n"
    columns = []
    for joint in declaration.joint_order:
        layout += asf.skeleton.names[joint].replace("%", "%%") + " %.10g" * len(asf.channels[joint]) + "\n"
        columns.append(values[joint])
    layout = layout.replace("\n", end.decode())
    table = np.concatenate([np.empty((motion.n_frames, 0)), *columns], axis=1)
    # A resampled motion counts from 0; most AMC files count from 1.
    first = motion.first_frame or min(declaration.counts_from, 1)
    for start in range(0, motion.n_frames, 256):
        rows = table[start : start + 256].tolist()
        text = "".join([layout % (first + start + i, *row) for i, row in enumerate(rows)])
        yield text.encode(asf.encoding)
