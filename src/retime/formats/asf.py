"""ASF, the skeleton that belongs to AMC motions: reading one, finding one, and making one up.

An ASF bone points from the end of its parent in a direction, for a length, and its degrees of freedom turn it in
axes of its own. Here each bone is a joint at the bone's base, and the rest pose has identity rotations: with C the
rotation of the bone's axes and M the rotation that the AMC gives, the joint's local rotation is C M C⁻¹. Angles turn
about fixed axes in the order in which the file lists them, so ``rx ry rz`` is the product Rz Ry Rx.

The root is the joint 0. Its preset ``orientation`` O comes first and its AMC rotation M turns about the global axes
after it, M O; its preset ``position`` is added. Programs disagree here, and say so by writing zeros; a file with
another preset gets a warning.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from retime.arrays import FloatArray
from retime.brief import brief_repr
from retime.errors import FormatError
from retime.formats.file_signatures import foreign_kind
from retime.formats.number_text import NumberTextError, parse_number, show
from retime.formats.read_options import Limits
from retime.formats.text_lines import without_byte_order_mark
from retime.motion import rotation
from retime.motion.size import within_size
from retime.motion.skeleton import EndSite, Skeleton

ROOT = "root"
_BLANKS = bytes.maketrans(b"(),", b"   ")
_LETTERS = {b"rx": "X", b"ry": "Y", b"rz": "Z"}
_CHANNELS = (b"tx", b"ty", b"tz", b"rx", b"ry", b"rz")
_BONE_WORDS = (b"id", b"name", b"direction", b"length", b"axis", b"dof", b"limits", b"bodymass", b"cofmass")


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
    there = sorted(entry for entry in folder.iterdir() if entry.suffix.lower() == ".asf" and entry.is_file())
    subject = stem.partition("_")[0]
    for wanted in dict.fromkeys((stem, subject)):
        for entry in there:
            if entry.stem.casefold() == wanted.casefold():
                return entry, ""
    if subject.isascii() and subject.isdigit():
        for entry in there:
            if entry.stem.isascii() and entry.stem.isdigit() and int(entry.stem) == int(subject):
                return entry, ""
    if len(there) == 1:
        return there[0], ""
    names = " and ".join(dict.fromkeys((f"{stem}.asf", f"{subject}.asf")))
    shown = ", ".join(entry.name for entry in there[:5]) + (", ..." if len(there) > 5 else "")
    found = f"which has {len(there)} .asf files ({shown})" if there else "which has no .asf file"
    return None, f"looked for {names}, or a single .asf file, in {folder}, {found}"


@dataclass
class _Bone:
    """A bone while it is read."""

    line: int
    name: bytes = b""
    direction: list[float] = field(default_factory=list)
    length: float | None = None
    axis: list[float] = field(default_factory=lambda: [0.0, 0.0, 0.0])
    axis_order: str = "XYZ"
    channels: tuple[str, ...] = ()

    def end(self) -> FloatArray:
        """Place of the bone's end, seen from its base."""
        length = self.length or 0.0
        return np.array([part * length for part in self.direction])


def parse_asf(path: Path, data: bytes, limits: Limits) -> Asf:
    """Read the bytes of an ASF.

    Parameters
    ----------
    path : Path
        The file, for messages.
    data : bytes
        What it holds.
    limits : Limits
        Sizes not to go past.

    Raises
    ------
    FormatError
        Anything that is not an ASF, with its line.
    """
    data = without_byte_order_mark(path, data)
    refuse_other_kinds(path, data, "an ASF skeleton")
    return _Parser(path, data, limits).asf()


class _Parser:
    """Reads the sections of one ASF, line after line."""

    def __init__(self, path: Path, data: bytes, limits: Limits) -> None:
        self.path = path
        self.limits = limits
        try:
            data.decode("utf-8")
            self.encoding = "utf-8"
        except UnicodeDecodeError:
            self.encoding = "latin-1"
        self.lines = data.splitlines()
        self.degrees = True
        self.length_unit = 1.0
        self.root = _Bone(0, b"root")
        self.bones: dict[bytes, _Bone] = {}
        self.parents: dict[bytes, bytes] = {}
        self.children: dict[bytes, list[bytes]] = {}
        self.sections: dict[bytes, int] = {}
        self.notes: dict[str, None] = {}

    def asf(self) -> Asf:
        readers: dict[bytes, Callable[[int, Iterator[tuple[int, list[bytes]]]], None]] = {
            b":units": self.units,
            b":root": self.read_root,
            b":bonedata": self.bonedata,
            b":hierarchy": self.hierarchy,
        }
        for word, first, stop in self.split_sections():
            reader = readers.get(word)
            if reader is not None:
                if word in self.sections:
                    raise self.error(first, f"a second {word.decode()}; the first is in line {self.sections[word]}")
                self.sections[word] = first
                reader(stop, self.records(first, stop))
        for word in (b":root", b":bonedata", b":hierarchy"):
            if word not in self.sections:
                raise self.error(len(self.lines), f"the file ends without a {word.decode()} section")
        return self.result()

    def error(self, line: int, problem: str) -> FormatError:
        return FormatError(problem, path=self.path, line=line)

    def text(self, name: bytes) -> str:
        return name.decode(self.encoding)

    def split_sections(self) -> list[tuple[bytes, int, int]]:
        """List keyword, its line, and the line before the next keyword."""
        starts = []
        for number, line in enumerate(self.lines, 1):
            if len(line) > self.limits.line_bytes:
                raise self.error(
                    number, f"the line has {len(line)} bytes, the limit is {self.limits.line_bytes} (Limits.line_bytes)"
                )
            words = line.split(None, 1)
            if words and words[0].startswith(b":"):
                starts.append((words[0].lower(), number))
            elif words and not starts and not words[0].startswith(b"#"):
                raise self.error(number, f"expected a keyword such as :version or :units, found {show(words[0])}")
        if not starts:
            raise self.error(len(self.lines), "the file ends without a keyword; expected an ASF skeleton")
        stops = [number - 1 for _, number in starts[1:]] + [len(self.lines)]
        return [(word, number, stop) for (word, number), stop in zip(starts, stops, strict=True)]

    def records(self, first: int, stop: int) -> Iterator[tuple[int, list[bytes]]]:
        """Yield the lines of a section as words, without comments; commas and parentheses are white space."""
        for number in range(first + 1, stop + 1):
            words = self.lines[number - 1].partition(b"#")[0].translate(_BLANKS).split()
            if words:
                yield number, words

    def numbers(self, line: int, words: list[bytes], count: int, what: str) -> list[float]:
        if len(words) != count:
            raise self.error(line, f"{what} needs {count} number{'s' * (count > 1)}, found {len(words)}")
        try:
            return [parse_number(word) for word in words]
        except NumberTextError as error:
            raise self.error(line, f"{what}: {error.problem}") from None

    def order(self, line: int, word: bytes, what: str) -> str:
        letters = word.decode("latin-1").upper()
        if sorted(letters) != ["X", "Y", "Z"]:
            raise self.error(line, f"{what} needs an order of the three axes such as XYZ, found {show(word)}")
        return letters

    def channel_words(self, line: int, words: list[bytes], what: str) -> tuple[str, ...]:
        found = [word.lower() for word in words]
        for word, written in zip(found, words, strict=True):
            if word == b"l":
                raise self.error(line, f"{what} changes its length (l), which retime can't hold")
            if word not in _CHANNELS:
                raise self.error(line, f"{what} knows tx, ty, tz, rx, ry and rz, found {show(written)}")
            if found.count(word) > 1:
                raise self.error(line, f"{what} lists {word.decode()} twice")
        return tuple(word.decode() for word in found)

    def units(self, stop: int, records: Iterator[tuple[int, list[bytes]]]) -> None:
        for line, words in records:
            what = words[0].lower()
            if what == b"angle":
                unit = words[1].lower() if len(words) == 2 else b""
                if unit not in (b"deg", b"degree", b"degrees", b"rad", b"radian", b"radians"):
                    raise self.error(line, f"angle is deg or rad, found {show(b' '.join(words[1:]))}")
                self.degrees = unit.startswith(b"deg")
            elif what == b"length":
                (self.length_unit,) = self.numbers(line, words[1:], 1, "length")
                if not self.length_unit > 0 or not math.isfinite(1.0 / self.length_unit):
                    raise self.error(line, f"length must be above 0, found {show(words[1])}")
            elif what == b"mass":
                self.numbers(line, words[1:], 1, "mass")
            else:
                self.notes[f"the unit {show(words[0])} in line {line} is unknown and was passed over"] = None

    def read_root(self, stop: int, records: Iterator[tuple[int, list[bytes]]]) -> None:
        self.root.line = self.sections[b":root"]
        self.root.direction = [0.0, 0.0, 0.0]
        self.root.length = 1.0
        ordered = False
        for line, words in records:
            what = words[0].lower()
            if what == b"order":
                self.root.channels = self.channel_words(line, words[1:], "the root's order")
                ordered = True
            elif what == b"axis":
                # Some write "axis XYZ", some "axis X Y Z".
                self.root.axis_order = self.order(line, b"".join(words[1:]), "the root's axis")
            elif what == b"position":
                self.root.direction = self.numbers(line, words[1:], 3, "the root's position")
            elif what == b"orientation":
                self.root.axis = self.numbers(line, words[1:], 3, "the root's orientation")
            else:
                self.notes[f"the root's {show(words[0])} in line {line} is unknown and was passed over"] = None
        if not ordered:
            raise self.error(stop, "the :root section ends without an order line (order TX TY TZ RX RY RZ)")

    def bonedata(self, stop: int, records: Iterator[tuple[int, list[bytes]]]) -> None:
        bone: _Bone | None = None
        word = b""
        for line, words in records:
            if bone is None:
                if words[0].lower() != b"begin":
                    raise self.error(line, f"expected begin, found {show(words[0])}")
                bone = _Bone(line)
                continue
            last, word = word, words[0].lower()
            if word == b"end":
                self.close_bone(line, bone)
                bone = None
            elif word == b"begin":
                raise self.error(line, f"expected end of the bone that begins in line {bone.line}, found begin")
            elif word in _BONE_WORDS:
                self.bone_word(line, bone, word, words)
            elif last == b"limits" and re.match(rb"[-+.0-9]|inf", word):
                word = last
            else:
                self.notes[f"the bone's word {show(words[0])} in line {line} is unknown and was passed over"] = None
        if bone is not None:
            raise self.error(stop, f"the file ends in the bone that begins in line {bone.line}; expected end")

    def bone_word(self, line: int, bone: _Bone, word: bytes, words: list[bytes]) -> None:
        what = f"bone {show(bone.name)}" if bone.name else f"the bone that begins in line {bone.line}"
        if word == b"name":
            if len(words) != 2:
                raise self.error(line, f"a bone's name is one word, found {len(words) - 1}")
            if len(words[1]) > self.limits.name_bytes:
                raise self.error(
                    line,
                    f"the name has {len(words[1])} bytes, the limit is {self.limits.name_bytes} (Limits.name_bytes)",
                )
            bone.name = words[1]
        elif word == b"direction":
            bone.direction = self.numbers(line, words[1:], 3, f"direction of {what}")
        elif word == b"length":
            (bone.length,) = self.numbers(line, words[1:], 1, f"length of {what}")
        elif word == b"axis":
            bone.axis = self.numbers(line, words[1:4], 3, f"axis of {what}")
            if len(words) > 4:
                bone.axis_order = self.order(line, b"".join(words[4:]), f"axis of {what}")
        elif word == b"dof":
            bone.channels = self.channel_words(line, words[1:], f"dof of {what}")

    def close_bone(self, line: int, bone: _Bone) -> None:
        if not bone.name:
            raise self.error(line, f"the bone that begins in line {bone.line} has no name")
        if not bone.direction or bone.length is None:
            missing = "length" if bone.direction else "direction"
            raise self.error(line, f"bone {show(bone.name)} has no {missing}")
        if not within_size(bone.end()).all():
            raise self.error(line, f"bone {show(bone.name)} is too long for a number")
        if bone.name.lower() == b"root":
            raise self.error(bone.line, "a bone is called root, which is the :root section's name")
        if bone.name in self.bones:
            first = self.bones[bone.name].line
            raise self.error(bone.line, f"a second bone is called {show(bone.name)}; the first begins in line {first}")
        if len(self.bones) + 1 >= self.limits.joints:
            raise self.error(
                bone.line, f"more than {self.limits.joints - 1} bones and a root; the limit is Limits.joints"
            )
        self.bones[bone.name] = bone

    def hierarchy(self, stop: int, records: Iterator[tuple[int, list[bytes]]]) -> None:
        state = "begin"
        for line, words in records:
            if state == "begin":
                if [word.lower() for word in words] != [b"begin"]:
                    raise self.error(line, f"expected begin, found {show(words[0])}")
                state = "end"
            elif state == "end" and [word.lower() for word in words] == [b"end"]:
                state = "closed"
            elif state == "closed":
                raise self.error(line, f"expected a keyword or the file's end, found {show(words[0])}")
            else:
                parent, *children = (self.known(line, word) for word in words)
                for child in children:
                    self.attach(line, parent, child)
        if state != "closed":
            raise self.error(stop, f"the file ends in its hierarchy; expected {state}")

    def known(self, line: int, word: bytes) -> bytes:
        if word in self.bones:
            return word
        if word.lower() == b"root":
            return b"root"
        raise self.error(line, f"the hierarchy names {show(word)}, which is no bone of :bonedata")

    def attach(self, line: int, parent: bytes, child: bytes) -> None:
        if child == b"root":
            raise self.error(line, f"the root can't be attached to {show(parent)}")
        if child in self.parents:
            raise self.error(
                line, f"{show(child)} is attached to {show(parent)}, and to {show(self.parents[child])} before"
            )
        self.parents[child] = parent
        self.children.setdefault(parent, []).append(child)

    def result(self) -> Asf:
        bones = [self.root]
        parents = [-1]
        depths = [1]
        # Depth first, without recursion: the deepest last child must not cost a stack.
        waiting = [(child, 0) for child in reversed(self.children.get(b"root", []))]
        while waiting:
            name, parent = waiting.pop()
            if depths[parent] >= self.limits.depth:
                raise self.error(
                    self.bones[name].line,
                    f"{show(name)} lies deeper than {self.limits.depth} joints (Limits.depth)",
                )
            joint = len(bones)
            bones.append(self.bones[name])
            parents.append(parent)
            depths.append(depths[parent] + 1)
            waiting.extend((child, joint) for child in reversed(self.children.get(name, [])))
        reached = {bone.name for bone in bones}
        for name, bone in self.bones.items():
            if name not in reached:
                above = self.parents.get(name)
                why = "has no parent in :hierarchy" if above is None else "hangs in a circle, not on the root"
                raise self.error(bone.line, f"bone {show(name)} {why}")
        ends = [np.zeros(3)] + [bone.end() for bone in bones[1:]]
        offsets = np.array([self.root.direction] + [ends[parent] for parent in parents[1:]])
        inner = set(parents)
        sites = tuple(
            EndSite(joint, (float(ends[joint][0]), float(ends[joint][1]), float(ends[joint][2])))
            for joint in range(1, len(bones))
            if joint not in inner
        )
        axes = np.array([self.axes(bone) for bone in bones])
        after = rotation.conjugate(axes)
        before = axes.copy()
        # The root's axes are its preset orientation: see the module's docstring.
        before[0], after[0] = rotation.identity(), axes[0]
        if any(self.root.axis) or any(self.root.direction):
            self.notes[
                "the root has a preset position or orientation, which programs apply in different ways; here the "
                "orientation comes first, the AMC's rotation turns about the global axes, and the position is added"
            ] = None
        names = (ROOT, *(self.text(bone.name) for bone in bones[1:]))
        return Asf(
            skeleton=Skeleton(names, tuple(parents), offsets, sites),
            channels=tuple(bone.channels for bone in bones),
            before=before,
            after=after,
            degrees=self.degrees,
            length_unit=self.length_unit,
            encoding=self.encoding,
            notes=tuple(self.notes),
        )

    def axes(self, bone: _Bone) -> FloatArray:
        angles = np.array(bone.axis[::-1])
        if self.degrees:
            angles = np.deg2rad(angles)
        return rotation.from_euler(bone.axis_order[::-1], angles)


def make_asf(skeleton: Skeleton, offsets: FloatArray, metres_per_unit: float | None) -> tuple[bytes, tuple[str, ...]]:
    """Write an ASF for a skeleton that has none: axes along the global ones, all rotations free.

    A bone has one end, so a joint whose children stand in different places gets length 0 and a bone without
    freedom to each of those places. The root is a place without length as well.

    Parameters
    ----------
    skeleton : Skeleton
        The joints.
    offsets : float array, shape (n_joints, 3)
        Where each joint stands in its parent's space; the root's is not used.
    metres_per_unit : float, optional
        Becomes the ``length`` of ``:units``.

    Returns
    -------
    text : bytes
        The file.
    names : tuple of str
        What each joint is called in it: its own name where that is one word that stands for nothing else; the
        root is called root.
    """
    taken = {ROOT, "begin", "end"}
    names = [ROOT]
    for name in skeleton.names[1:]:
        names.append(_free_name(name, taken))
        taken.add(names[-1].lower())
    bones: list[tuple[str, FloatArray, bool]] = []
    lines: list[str] = []
    for joint, name in enumerate(names):
        children = skeleton.children(joint)
        ends = [tuple(offsets[child].tolist()) for child in children]
        ends += [site.offset for site in skeleton.end_sites if site.parent == joint]
        places = list(dict.fromkeys(ends))
        own = places[0] if joint > 0 and len(places) == 1 else (0.0, 0.0, 0.0)
        if joint > 0:
            bones.append((name, np.array(own), True))
        attached = [name]
        helpers: dict[tuple[float, ...], list[str]] = {}
        for child, end in zip(children, ends, strict=False):
            if end == own:
                attached.append(names[child])
            else:
                helpers.setdefault(end, []).append(names[child])
        for end in places:
            if end != own:
                below = helpers.get(end, [])
                helper = _free_name(f"{name}_to_{below[0] if below else 'end'}", taken)
                taken.add(helper.lower())
                bones.append((helper, np.array(end), False))
                attached.append(helper)
                if below:
                    lines.append(" ".join([helper, *below]))
        if len(attached) > 1:
            lines.append(" ".join(attached))
    return _asf_text(bones, lines, metres_per_unit), tuple(names)


def _free_name(name: str, taken: set[str]) -> str:
    """Make one word of a name, that is no keyword, no number and not taken yet."""
    word = re.sub(r"[\s\x00-\x1f(),#]+", "_", name.encode("utf-8", "replace").decode())
    if not word or word[0] in ":+-." or word[0].isdigit():
        word = f"_{word}"
    number, free = 1, word
    while free.lower() in taken:
        number += 1
        free = f"{word}_{number}"
    return free


def _asf_text(bones: list[tuple[str, FloatArray, bool]], hierarchy: list[str], metres_per_unit: float | None) -> bytes:
    length_unit = 1.0 if metres_per_unit is None else 2.54 / 100.0 / metres_per_unit
    out = [
        "# made by retime",
        ":version 1.10",
        ":name retime",
        ":units",
        "  mass 1.0",
        f"  length {length_unit:.15g}",
        "  angle deg",
        ":documentation",
        "  One bone a joint, axes along the global ones.",
        ":root",
        "  order TX TY TZ RX RY RZ",
        "  axis XYZ",
        "  position 0 0 0",
        "  orientation 0 0 0",
        ":bonedata",
    ]
    for number, (name, end, free) in enumerate(bones, 1):
        length = math.hypot(*end.tolist())
        x, y, z = end / length if length > 0 else (0.0, 1.0, 0.0)
        out += [
            "  begin",
            f"    id {number}",
            f"    name {name}",
            f"    direction {x:.15g} {y:.15g} {z:.15g}",
            f"    length {length:.15g}",
            "    axis 0 0 0 XYZ",
        ]
        if free:
            out += ["    dof rx ry rz", *(f"    {word} (-180.0 180.0)" for word in ("limits", "      ", "      "))]
        out.append("  end")
    out += [":hierarchy", "  begin", *(f"    {line}" for line in hierarchy), "  end", ""]
    return "\n".join(out).encode()
