"""ASF, the skeleton that belongs to AMC motions: what it says, and where it is found.

An ASF bone points from the end of its parent in a direction, for a length, and its degrees of freedom turn it in
axes of its own. Here each bone is a joint at the bone's base, and the rest pose has identity rotations: with C the
rotation of the bone's axes and M the rotation that the AMC gives, the joint's local rotation is C M C⁻¹. Angles turn
about fixed axes in the order in which the file lists them, so ``rx ry rz`` is the product Rz Ry Rx.

The root is the joint 0. Its preset ``orientation`` O comes first and its AMC rotation M turns about the global axes
after it, M O; its preset ``position`` is added. Programs disagree here, and say so by writing zeros; a file with
another preset gets a warning.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from retime.arrays import FloatArray
from retime.brief import brief_repr
from retime.errors import FormatError
from retime.formats.compressed import plain_path
from retime.formats.file_signatures import foreign_kind
from retime.formats.number_text import count_of
from retime.motion import rotation
from retime.motion.skeleton import Skeleton

ROOT = "root"


@dataclass(frozen=True, eq=False)
class Asf:
    """An ASF skeleton.

    Attributes
    ----------
    skeleton : Skeleton
        The root and a joint for each bone, parents first, in the order of the hierarchy.
    channels : tuple of tuple of str
        For each joint what an AMC gives it, in order: of "tx", "ty", "tz", "rx", "ry" and "rz".
    before, after : float array, shape (n_joints, 4)
        A joint's local rotation is ``before · M · after``, M being the product of the AMC's rotations.
    degrees : bool
        Angles are in degrees.
    length_unit : float
        The ``length`` of ``:units``, 1 where it is missing.
    encoding : str
        How the names are encoded in the file, "utf-8" or "latin-1".
    notes : tuple of str
        What was passed over, for a warning.
    """

    skeleton: Skeleton
    channels: tuple[tuple[str, ...], ...]
    before: FloatArray
    after: FloatArray
    degrees: bool
    length_unit: float
    encoding: str
    notes: tuple[str, ...]

    __repr__ = brief_repr

    @property
    def metres_per_unit(self) -> float | None:
        """Metres in a unit: the file's numbers are inches times ``length`` (CMU's 0.45); None where that is 1."""
        return None if self.length_unit == 1.0 else (1.0 / self.length_unit) * 2.54 / 100.0

    def same_as(self, other: Asf) -> bool:
        """Whether an AMC of the one means the same motion with the other."""
        return (
            self.skeleton.names == other.skeleton.names
            and self.skeleton.parents == other.skeleton.parents
            and self.channels == other.channels
            and self.degrees == other.degrees
            and self.length_unit == other.length_unit
            and np.array_equal(self.skeleton.offsets, other.skeleton.offsets)
            and self.skeleton.end_sites == other.skeleton.end_sites
            and np.array_equal(self.before, other.before)
            and np.array_equal(self.after, other.after)
        )


def turn_order(channels: Sequence[str]) -> str:
    """Give the order of multiplication of a joint's rotations: the last one listed stands first ("ZYX")."""
    return "".join(channel[1].upper() for channel in reversed(channels) if channel[0] == "r")


def split_channels(channels: tuple[str, ...]) -> tuple[list[int], list[int]]:
    """Say at which places of a joint's channels its translations stand, and at which its rotations."""
    moves = [i for i, channel in enumerate(channels) if channel[0] == "t"]
    turns = [i for i, channel in enumerate(channels) if channel[0] == "r"]
    return moves, turns


def axis_of(channel: str) -> int:
    """Give the axis that a channel moves along or turns about: 0 for x, 1 for y, 2 for z."""
    return "xyz".index(channel[1])


def compose_turns(asf: Asf, joint: int, angles: FloatArray) -> FloatArray:
    """Give a joint's local rotations (n_frames, 4) for its angles (n_frames, number of turns), radians."""
    turns = [channel for channel in asf.channels[joint] if channel[0] == "r"]
    turned = rotation.from_euler(turn_order(turns), angles[:, ::-1])
    return rotation.multiply(rotation.multiply(asf.before[joint], turned), asf.after[joint])


def refuse_other_kinds(path: Path, data: bytes, expected: str) -> None:
    """Raise FormatError for an empty file and for one that is plainly something else than `expected`."""
    if not data.strip():
        raise FormatError(f"the file is empty; expected {expected}", path=path)
    kind = foreign_kind(data)
    if kind is not None and kind != expected:
        raise FormatError(f"this is {kind}; expected {expected}", path=path)
    zero = data.find(b"\0")
    if zero >= 0:
        raise FormatError(f"binary data, not text; expected {expected}", path=path, byte=zero)


def subject_problem(amc: Path, asf: Path) -> str:
    """Say where names give an AMC (02_04.amc) and its ASF (07.asf) different subjects; "" where they don't.

    An AMC has angles alone: that bones are of another length shows in none of its numbers, so names are all there is.
    """
    theirs, own = plain_path(asf).stem, plain_path(amc).stem.partition("_")[0]
    if None in (numbers := (count_of(theirs), count_of(own))) or numbers[0] == numbers[1]:
        return ""
    return (
        f"by the names the skeleton {asf.name} is of subject {theirs}, and the motion of subject {own}: bone lengths, "
        "and so heights and standing feet, may be another person's (an AMC says nothing of them); --skeleton names "
        "another"
    )


def find_asf(amc: Path) -> tuple[Path | None, str]:
    """Find the ASF beside an AMC: the same stem, the same subject (02 of 02_04), or the only one in the folder.

    Returns
    -------
    path : Path or None
        The ASF.
    searched : str
        What was looked for, for a message.
    """
    stem = amc.stem
    folder = amc.parent
    there = sorted(
        entry for entry in folder.iterdir() if plain_path(entry).suffix.lower() == ".asf" and entry.is_file()
    )
    subject = stem.partition("_")[0]
    for wanted in dict.fromkeys((stem, subject)):
        for entry in there:
            if plain_path(entry).stem.casefold() == wanted.casefold():
                return entry, ""
    number = count_of(subject)
    if number is not None:
        for entry in there:
            if count_of(plain_path(entry).stem) == number:
                return entry, ""
    if len(there) == 1:
        return there[0], ""
    names = " and ".join(dict.fromkeys((f"{stem}.asf", f"{subject}.asf")))
    shown = ", ".join(entry.name for entry in there[:5]) + (", ..." if len(there) > 5 else "")
    found = f"which has {len(there)} .asf files ({shown})" if there else "which has no .asf file"
    return None, f"looked for {names}, or a single .asf file, in {folder}, {found}"
