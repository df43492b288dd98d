"""Reads an ASF, section after section, with the line of every fault."""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from retime.arrays import FloatArray
from retime.errors import FormatError
from retime.formats.asf import ROOT, Asf, refuse_other_kinds
from retime.formats.number_text import NumberTextError, parse_number, show
from retime.formats.read_options import Limits
from retime.formats.text_lines import without_byte_order_mark, without_end_padding
from retime.motion import rotation
from retime.motion.size import within_size
from retime.motion.skeleton import EndSite, Skeleton

_BLANKS = bytes.maketrans(b"(),", b"   ")
_CHANNELS = (b"tx", b"ty", b"tz", b"rx", b"ry", b"rz")
_BONE_WORDS = (b"id", b"name", b"direction", b"length", b"axis", b"dof", b"limits", b"bodymass", b"cofmass")


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
    data = without_end_padding(without_byte_order_mark(path, data))
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
        # The root's axes are its preset orientation: see `retime.formats.asf`.
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
        angles = rotation.radians(bone.axis[::-1], degrees=self.degrees)
        return rotation.from_euler(bone.axis_order[::-1], angles)
