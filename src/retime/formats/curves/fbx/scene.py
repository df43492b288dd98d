"""What an FBX file holds: objects, what is connected to what, properties, and animation by stack, layer and curve."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from retime.arrays import FloatArray
from retime.brief import brief_repr
from retime.errors import FormatError
from retime.formats.curves.fbx.binary import MAGIC, BinaryFbx
from retime.formats.curves.fbx.file import FbxFile, Record, Value
from retime.formats.curves.fbx.text import TextFbx
from retime.formats.file_signatures import foreign_kind
from retime.formats.number_text import count_of
from retime.formats.read_options import Limits

TICKS = 46_186_158_000
"""Units of FBX time in a second."""
_NEW_TICKS, _OLD_TICKS_SAID = 141_120_000, 127
# Beyond this a time stands for "endless", or is damaged.
_LONGEST_SECONDS = 1e7


@dataclass(eq=False)
class Item:
    """An object of the scene.

    Attributes
    ----------
    id : int
        The file's own number for it.
    kind : str
        Model, AnimationCurve and so on.
    name : str
    subtype : str
        LimbNode, Mesh and so on.
    record : Record
    own : dict of str to (Record, list of Value)
        Its properties; values from the fifth on are the property's own.
    """

    id: int
    kind: str
    name: str
    subtype: str
    record: Record
    own: dict[str, tuple[Record, list[Value]]] | None = None

    __repr__ = brief_repr


@dataclass(eq=False)
class CurveNode:
    """Curves for the parts of one property.

    Attributes
    ----------
    item : Item
    curves : dict of str to Item
        AnimationCurve of each part ("d|X").
    targets : list of (Item, str)
        The objects and properties that it moves.
    """

    item: Item
    curves: dict[str, Item]
    targets: list[tuple[Item, str]]

    __repr__ = brief_repr


@dataclass(eq=False)
class Layer:
    """A layer of an animation."""

    item: Item
    nodes: list[CurveNode] = field(default_factory=list)

    __repr__ = brief_repr


@dataclass(eq=False)
class Stack:
    """One animation: its layers, the lowest first."""

    item: Item
    name: str
    layers: list[Layer] = field(default_factory=list)

    __repr__ = brief_repr

    @property
    def curves(self) -> list[Item]:
        """Every curve of the stack, once, those of weights of layers included."""
        found = {curve.id: curve for layer in self.layers for node in layer.nodes for curve in node.curves.values()}
        return list(found.values())


class FbxScene:
    """A file and what it holds."""

    def __init__(self, file: FbxFile) -> None:
        self.file = file
        self.ticks = self._ticks()
        self.items: dict[int, Item] = {}
        self.below: dict[int, list[tuple[int, str]]] = {}
        self.above: dict[int, list[tuple[int, str]]] = {}
        self._templates = self._read_templates()
        self._read_objects()
        self._read_connections()
        self.settings = self._properties(file.section("GlobalSettings"))
        self.stacks = [self._stack(item) for item in self.items.values() if item.kind == "AnimationStack"]

    def _ticks(self) -> int:
        head = self.file.section("FBXHeaderExtension")
        if head is None:
            return TICKS
        locked = head.child("EncryptionType")
        if locked is not None and self._first_whole(locked) != 0:
            raise self.file.error("the file is encrypted: export it without a password", locked)
        version, flags = head.child("FBXHeaderVersion"), head.child("OtherFlags")
        said = flags.child("TCDefinition") if flags is not None else None
        if version is None or said is None or self._first_whole(version) < 1004:
            return TICKS
        return TICKS if self._first_whole(said) == _OLD_TICKS_SAID else _NEW_TICKS

    def _first_whole(self, record: Record) -> int:
        values = self.file.values(record)
        return self.file.whole(record, values[0]) if values else 0

    def _read_templates(self) -> dict[str, dict[str, tuple[Record, list[Value]]]]:
        """Read what properties are where objects don't say them, by kind of object."""
        found: dict[str, dict[str, tuple[Record, list[Value]]]] = {}
        section = self.file.section("Definitions")
        for one in section.children if section else []:
            if one.name != "ObjectType":
                continue
            values = self.file.values(one)
            template = one.child("PropertyTemplate")
            if values and template is not None:
                found.setdefault(str(values[0].content), {}).update(self._properties(template))
        return found

    def _properties(self, record: Record | None) -> dict[str, tuple[Record, list[Value]]]:
        table = record.child("Properties70") if record is not None else None
        found: dict[str, tuple[Record, list[Value]]] = {}
        for one in table.children if table is not None else []:
            if one.name == "P":
                values = self.file.values(one)
                if values:
                    found[str(values[0].content)] = (one, values)
        return found

    def _read_objects(self) -> None:
        section = self.file.section("Objects")
        for record in section.children if section else []:
            spans = self.file.spans(record)
            if not spans:
                continue
            values = [self.file.value(record, span) for span in spans[:3]]
            if not isinstance(values[0].content, int):
                # What has no number can't be connected to anything.
                continue
            id_ = self.file.whole(record, values[0])
            if id_ in self.items:
                raise self.file.error(f"two objects have the number {id_}", record)
            name = str(values[1].content) if len(values) > 1 else ""
            # Binary files write "name, 0, 1, class", text "class::name".
            name = name.split("\0\1")[0] if "\0\1" in name else name.split("::", 1)[-1]
            subtype = str(values[2].content) if len(values) > 2 else ""
            self.items[id_] = Item(id_, record.name, name, subtype, record)

    def _read_connections(self) -> None:
        section = self.file.section("Connections")
        for record in section.children if section else []:
            if record.name not in ("C", "Connect"):
                continue
            values = [one.content for one in self.file.values(record)]
            if len(values) < 3 or values[0] not in ("OO", "OP"):
                continue
            child, parent = values[1], values[2]
            if not isinstance(child, int) or not isinstance(parent, int):
                raise self.file.error("a connection must join two numbers of objects", record)
            prop = str(values[3]) if values[0] == "OP" and len(values) > 3 else ""
            self.below.setdefault(parent, []).append((child, prop))
            self.above.setdefault(child, []).append((parent, prop))

    def within(self, item: Item, kind: str) -> list[tuple[Item, str]]:
        """Return the objects of a kind that are connected to one, with the property that each is connected to."""
        found = [(self.items[child], prop) for child, prop in self.below.get(item.id, ()) if child in self.items]
        return [(child, prop) for child, prop in found if child.kind == kind]

    def _stack(self, item: Item) -> Stack:
        stack = Stack(item, item.name)
        for layer, _ in self.within(item, "AnimationLayer"):
            stack.layers.append(Layer(layer))
            for node, prop in self.within(layer, "AnimationCurveNode"):
                if not prop:
                    stack.layers[-1].nodes.append(self._curve_node(node))
        return stack

    def _curve_node(self, item: Item) -> CurveNode:
        curves: dict[str, Item] = {}
        for curve, prop in self.within(item, "AnimationCurve"):
            if prop in curves and curves[prop] is not curve:
                raise self.file.error(f"two curves move {prop} of the curve node {item.name!r}", item.record)
            curves[prop] = curve
        targets = [
            (self.items[parent], prop) for parent, prop in self.above.get(item.id, ()) if prop and parent in self.items
        ]
        return CurveNode(item, curves, targets)

    def properties(self, item: Item) -> dict[str, tuple[Record, list[Value]]]:
        """Return an object's own properties, read once."""
        if item.own is None:
            item.own = self._properties(item.record)
        return item.own

    def numbers(self, item: Item, name: str, missing: tuple[float, ...]) -> FloatArray:
        """Return a property's numbers: the object's own, its kind's, or `missing`, shape (len(missing),)."""
        found = self.properties(item).get(name) or self._templates.get(item.kind, {}).get(name)
        if found is None:
            return np.array(missing)
        return self.file.numbers(found[0], found[1][4:], len(missing))

    def whole(self, item: Item, name: str, missing: int) -> int:
        """Return a property that is a whole number, as `numbers` finds it."""
        return _as_whole(self.file, self.numbers(item, name, (float(missing),))[0])

    def setting(self, name: str, missing: float) -> float:
        """Return a number of the scene's settings."""
        found = self.settings.get(name)
        return missing if found is None else float(self.file.numbers(found[0], found[1][4:], 1)[0])

    def seconds(self, ticks: int) -> float | None:
        """Return a time in seconds; None where it is beyond any clip's, as "endless" is."""
        seconds = ticks / self.ticks
        return seconds if abs(seconds) <= _LONGEST_SECONDS else None

    def time(self, stack: Stack, name: str) -> int | None:
        """Return one of a stack's four times in ticks; None where it has none of its own."""
        found = self.properties(stack.item).get(name)
        if found is None or len(found[1]) < 5:
            return None
        return self.file.whole(found[0], found[1][4])


def _as_whole(file: FbxFile, number: float) -> int:
    if abs(number) > 2**31:
        raise file.error(f"expected a small whole number, found {number:g}")
    return int(number)


def parse_fbx(path: Path, data: bytes, limits: Limits) -> FbxScene:
    """Take a file apart; raise FormatError where it is no FBX of version 7."""
    if not data:
        raise FormatError("empty; expected an FBX scene", path=path)
    if data.startswith(MAGIC):
        return FbxScene(BinaryFbx(path, data, limits))
    if data.startswith(MAGIC[:18]):
        raise FormatError("a binary FBX with another byte order, or a damaged head; export it anew", path=path)
    head = data[:4096].lstrip(b"\xef\xbb\xbf \t\r\n")
    if head.startswith(b";") or b"FBXHeaderExtension" in head:
        return FbxScene(TextFbx(path, data, limits))
    kind = foreign_kind(data)
    raise FormatError(f"this is {kind}, not an FBX scene" if kind else "this is no FBX scene", path=path)


def chosen_stacks(scene: FbxScene, name: str | None) -> list[Stack]:
    """Return the stacks of a name; all that have curves where none is given.

    A number counts from 0 where no stack is called so.

    Raises
    ------
    FormatError
        None is called so, or the file has none with curves.
    """
    stacks = [stack for stack in scene.stacks if stack.curves]
    path = scene.file.path
    if not stacks:
        raise FormatError("the scene has no animation: no stack of it has a curve", path=path)
    if name is None:
        return stacks
    found = [stack for stack in stacks if stack.name == name]
    number = count_of(name)
    if not found and number is not None and number < len(stacks):
        found = [stacks[number]]
    if not found:
        names = ", ".join(stack.name for stack in stacks)
        raise FormatError(f"no animation is called {name[:100]!r}; there are {names}", path=path)
    return found
