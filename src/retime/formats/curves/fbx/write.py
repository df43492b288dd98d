"""A motion as a binary FBX: its joints as limbs of a plain skeleton, one animation, a key on every frame."""

from __future__ import annotations

import struct
from collections import Counter
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from fractions import Fraction

import numpy as np

from retime.arrays import FloatArray, IntArray
from retime.errors import FormatError
from retime.formats.curves.fbx.binary import LAST, MAGIC, encoded
from retime.formats.curves.fbx.curve import LINEAR, THIRDS, USER
from retime.formats.curves.fbx.file import Value
from retime.formats.curves.fbx.scene import TICKS
from retime.formats.curves.fbx.values import ORDERS
from retime.motion.euler import fit_angles
from retime.motion.motion import Motion

_VERSION = 7400
_HEAD = struct.Struct("<IIIB")
# Programs check that the three of these belong together; so the file claims to be from 1970, as Blender's do.
_CREATED = "1970-01-01 10:00:00:000"
_FILE_ID = bytes.fromhex("28b32aebb624ccc2bfc8b02aa92bfcf1")
_FOOT_ID = bytes.fromhex("fabcab09d0c8d466b176fb831cf7267e")
_TIME_MODES = {
    Fraction(120): 1,
    Fraction(100): 2,
    Fraction(60): 3,
    Fraction(50): 4,
    Fraction(48): 5,
    Fraction(30): 6,
    Fraction(30000, 1001): 9,
    Fraction(25): 10,
    Fraction(24): 11,
    Fraction(24000, 1001): 13,
}
_OWN_RATE = 14
# From here on numbers are beyond single precision, or all use.
_LARGEST = 1e30
# Kinds of objects, in the order in which a file counts them.
_KINDS = ("AnimationStack", "AnimationLayer", "NodeAttribute", "Model", "AnimationCurveNode", "AnimationCurve")


@dataclass
class _Node:
    """A record to be written."""

    name: str
    values: Sequence[Value] = ()
    children: Iterable[_Node] = ()

    def bytes_at(self, place: int) -> bytes:
        """Return the record's bytes, for where it will stand: heads say where records end."""
        values = b"".join(encoded(value, packed=True) for value in self.values)
        head = _HEAD.size + len(self.name)
        inner: list[bytes] = []
        end = place + head + len(values)
        for child in self.children:
            inner.append(child.bytes_at(end))
            end += len(inner[-1])
        if inner or not self.values:
            inner.append(b"\0" * _HEAD.size)
            end += _HEAD.size
        if end >= 2**32:
            raise FormatError("the motion is too long for one FBX file (4 GiB)")
        first = _HEAD.pack(end, len(self.values), len(values), len(self.name))
        return b"".join([first, self.name.encode(), values, *inner])


def _text(text: str) -> Value:
    return Value("S", text)


def _int(number: int) -> Value:
    return Value("I", number)


def _long(number: int) -> Value:
    return Value("L", number)


def _real(number: float) -> Value:
    return Value("D", float(number))


def _leaf(name: str, *values: Value) -> _Node:
    return _Node(name, values)


def _object(kind: str, number: int, name: str, class_: str, subtype: str, children: Sequence[_Node]) -> _Node:
    return _Node(kind, [_long(number), _text(f"{name}\0\1{class_}"), _text(subtype)], children)


def _property(name: str, type_: str, label: str, flags: str, *values: Value) -> _Node:
    return _Node("P", [_text(name), _text(type_), _text(label), _text(flags), *values])


def _time(name: str, ticks: int) -> _Node:
    return _property(name, "KTime", "Time", "", _long(ticks))


def _whole(name: str, number: int) -> _Node:
    return _property(name, "int", "Integer", "", _int(number))


def fbx_of(motion: Motion) -> bytes:
    """Make a binary FBX 7.4 of a motion.

    Lengths stay in the motion's own unit, and the file says how long that is, where it is known; so it does for the
    vertical axis. Turns are written in the order that the motion's file had.

    Raises
    ------
    FormatError
        A number is beyond single precision, or the file would be larger than FBX 7.4 allows.
    """
    skeleton = motion.skeleton
    translations = motion.local_translations
    if max(float(np.abs(translations).max()), float(np.abs(skeleton.offsets).max())) > _LARGEST:
        raise FormatError("a length is beyond what single precision, which FBX has, can hold")
    ticks = np.rint(np.arange(motion.n_frames) * float(TICKS / motion.rate)).astype(np.int64)
    objects = _Objects()
    orders = [_order_of(motion, joint) for joint in range(skeleton.n_joints)]
    limbs: list[int] = []
    for joint, (name, parent) in enumerate(zip(skeleton.names, skeleton.parents, strict=True)):
        above = limbs[parent] if parent >= 0 else 0
        limbs.append(objects.add_limb(name, above, skeleton.offsets[joint], orders[joint]))
    for site in skeleton.end_sites:
        name = f"{skeleton.names[site.parent]}_end"
        objects.add_limb(name, limbs[site.parent], np.array(site.offset), ORDERS[0])
    name, end = motion.name or "motion", int(ticks[-1])
    layer = objects.add_stack(name, end)
    for joint, limb in enumerate(limbs):
        objects.add_curves(layer, limb, "R", "Lcl Rotation", ticks, _angles(motion, joint, orders[joint]))
        if (translations[:, joint] != skeleton.offsets[joint]).any():
            objects.add_curves(layer, limb, "T", "Lcl Translation", ticks, translations[:, joint])
    take = [
        _leaf("FileName", _text(f"{name}.tak")),
        _leaf("LocalTime", _long(0), _long(end)),
        _leaf("ReferenceTime", _long(0), _long(end)),
    ]
    return _file(
        [
            *_header(),
            _settings(motion, end),
            _document(objects.new_id()),
            _Node("References"),
            _Node("Definitions", (), objects.definitions()),
            _Node("Objects", (), objects.nodes),
            _Node("Connections", (), objects.links),
            _Node("Takes", (), [_leaf("Current", _text(name)), _Node("Take", [_text(name)], take)]),
        ]
    )


class _Objects:
    """The objects of a file, and what ties them: each is known by its number."""

    def __init__(self) -> None:
        self._number = iter(range(1_000_000, 2**40))
        self.nodes: list[_Node] = []
        self.links: list[_Node] = []

    def new_id(self) -> int:
        """Return a number that no object has."""
        return next(self._number)

    def link(self, child: int, parent: int, prop: str = "") -> None:
        """Tie an object to another one, or to a property of it; 0 is the scene."""
        more = [_text(prop)] if prop else []
        self.links.append(_Node("C", [_text("OP" if prop else "OO"), _long(child), _long(parent), *more]))

    def add_limb(self, name: str, parent: int, offset: FloatArray, order: str) -> int:
        """Add a joint, and the attribute that says that it is one; return its number."""
        limb, attribute = self.new_id(), self.new_id()
        properties = [
            _property("RotationActive", "bool", "", "", _int(1)),
            _property("InheritType", "enum", "", "", _int(1)),
            _property("RotationOrder", "enum", "", "", _int(ORDERS.index(order))),
            _property("Lcl Translation", "Lcl Translation", "", "A", *map(_real, offset)),
            _property("Lcl Rotation", "Lcl Rotation", "", "A", *map(_real, (0, 0, 0))),
            _property("Lcl Scaling", "Lcl Scaling", "", "A", *map(_real, (1, 1, 1))),
        ]
        inner = [_leaf("Version", _int(232)), _Node("Properties70", (), properties)]
        self.nodes.append(_object("NodeAttribute", attribute, name, "NodeAttribute", "LimbNode", [_skeleton()]))
        self.nodes.append(_object("Model", limb, name, "Model", "LimbNode", inner))
        self.link(limb, parent)
        self.link(attribute, limb)
        return limb

    def add_stack(self, name: str, end: int) -> int:
        """Add an animation that ends at a tick; return the number of its one layer."""
        stack, layer = self.new_id(), self.new_id()
        times = [
            _time("LocalStart", 0),
            _time("LocalStop", end),
            _time("ReferenceStart", 0),
            _time("ReferenceStop", end),
        ]
        self.nodes.append(_object("AnimationStack", stack, name, "AnimStack", "", [_Node("Properties70", (), times)]))
        self.nodes.append(_object("AnimationLayer", layer, "BaseLayer", "AnimLayer", "", []))
        self.link(stack, 0)
        self.link(layer, stack)
        return layer

    def add_curves(self, layer: int, limb: int, name: str, prop: str, ticks: IntArray, columns: FloatArray) -> None:
        """Add the curves of a joint's property: a key at each of the ticks, of `columns`, shape (n_ticks, 3)."""
        node = self.new_id()
        first = [_property(f"d|{axis}", "Number", "", "A", _real(columns[0, i])) for i, axis in enumerate("XYZ")]
        inner = [_Node("Properties70", (), first)]
        self.nodes.append(_object("AnimationCurveNode", node, name, "AnimCurveNode", "", inner))
        self.link(node, layer)
        self.link(node, limb, prop)
        for i, axis in enumerate("XYZ"):
            curve = self.new_id()
            self.nodes.append(_object("AnimationCurve", curve, "", "AnimCurve", "", _curve(ticks, columns[:, i])))
            self.link(curve, node, f"d|{axis}")

    def definitions(self) -> list[_Node]:
        """Say how many objects of each kind there are."""
        found = Counter(node.name for node in self.nodes)
        counts = {"GlobalSettings": 1} | {kind: found[kind] for kind in _KINDS}
        types = [_Node("ObjectType", [_text(kind)], [_leaf("Count", _int(count))]) for kind, count in counts.items()]
        return [_leaf("Version", _int(100)), _leaf("Count", _int(sum(counts.values()))), *types]


def _order_of(motion: Motion, joint: int) -> str:
    """Return the order in which a joint's file multiplies its turns, where it has three of them."""
    channels = motion.declaration.channels[joint] if motion.declaration else ()
    order = "".join(channel[0] for channel in channels if channel.endswith("rotation"))
    return order if order in ORDERS else ORDERS[0]


def _angles(motion: Motion, joint: int, order: str) -> FloatArray:
    """Return a joint's turns about X, Y and Z in degrees, continuous in time, shape (n_frames, 3)."""
    found = np.degrees(fit_angles(order, motion.rotations[:, joint]))
    angles = np.empty_like(found)
    angles[:, ["XYZ".index(axis) for axis in order]] = found
    return angles


def _curve(ticks: IntArray, values: FloatArray) -> list[_Node]:
    data = np.array([0, 0, THIRDS, 0], dtype=np.uint32).view(np.float32)
    return [
        _leaf("Default", _real(values[0])),
        _leaf("KeyVer", _int(4008)),
        _leaf("KeyTime", Value("l", ticks)),
        _leaf("KeyValueFloat", Value("f", values)),
        _leaf("KeyAttrFlags", Value("i", [LINEAR | USER])),
        _leaf("KeyAttrDataFloat", Value("f", data)),
        _leaf("KeyAttrRefCount", Value("i", [len(ticks)])),
    ]


def _skeleton() -> _Node:
    return _leaf("TypeFlags", _text("Skeleton"))


def _header() -> list[_Node]:
    stamp = dict(
        zip(("Version", "Year", "Month", "Day", "Hour", "Minute", "Second"), (1000, 1970, 1, 1, 10, 0, 0), strict=True)
    )
    moments = [_leaf(name, _int(number)) for name, number in {**stamp, "Millisecond": 0}.items()]
    head = [
        _leaf("FBXHeaderVersion", _int(1003)),
        _leaf("FBXVersion", _int(_VERSION)),
        _leaf("EncryptionType", _int(0)),
        _Node("CreationTimeStamp", (), moments),
        _leaf("Creator", _text("retime")),
    ]
    return [
        _Node("FBXHeaderExtension", (), head),
        _leaf("FileId", Value("R", _FILE_ID)),
        _leaf("CreationTime", _text(_CREATED)),
        _leaf("Creator", _text("retime")),
    ]


def _settings(motion: Motion, end: int) -> _Node:
    # Y up: Z comes forward, X goes right. Z up: -Y comes forward.
    up, front, front_sign = (1, 2, 1) if motion.up == "y" else (2, 1, -1)
    unit = 100 * motion.metres_per_unit if motion.metres_per_unit else 1.0
    mode = _TIME_MODES.get(motion.rate, _OWN_RATE)
    properties = [
        _whole("UpAxis", up),
        _whole("UpAxisSign", 1),
        _whole("FrontAxis", front),
        _whole("FrontAxisSign", front_sign),
        _whole("CoordAxis", 0),
        _whole("CoordAxisSign", 1),
        _property("UnitScaleFactor", "double", "Number", "", _real(unit)),
        _property("OriginalUnitScaleFactor", "double", "Number", "", _real(unit)),
        _property("TimeMode", "enum", "", "", _int(mode)),
        _time("TimeSpanStart", 0),
        _time("TimeSpanStop", end),
        _property("CustomFrameRate", "double", "Number", "", _real(float(motion.rate) if mode == _OWN_RATE else -1)),
    ]
    return _Node("GlobalSettings", (), [_leaf("Version", _int(1000)), _Node("Properties70", (), properties)])


def _document(number: int) -> _Node:
    inner = [_Node("Properties70"), _leaf("RootNode", _long(0))]
    return _Node(
        "Documents", (), [_leaf("Count", _int(1)), _Node("Document", [_long(number), _text(""), _text("Scene")], inner)]
    )


def _file(records: list[_Node]) -> bytes:
    out = bytearray(MAGIC + struct.pack("<I", _VERSION))
    for record in records:
        out += record.bytes_at(len(out))
    out += b"\0" * _HEAD.size
    out += _FOOT_ID + b"\0" * 4
    out += b"\0" * (16 - len(out) % 16)
    return bytes(out + struct.pack("<I", _VERSION) + b"\0" * 120 + LAST)
