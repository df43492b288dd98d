"""FBX files made by the tests, binary and in text: every kind of key, layers, stacks, and bytes that must stay."""

from __future__ import annotations

import struct
import zlib
from dataclasses import dataclass, field

import numpy as np

TICKS = 46_186_158_000
ARRAYS = {"f": "<f4", "d": "<f8", "l": "<i8", "i": "<i4"}
THIRDS = 3333 | 3333 << 16
CONSTANT, LINEAR, CUBIC = 0x2, 0x4, 0x8
NEXT, AUTO, TCB, USER, BROKEN = 0x100, 0x100, 0x200, 0x400, 0x800
CLAMP, INDEPENDENT, PROGRESSIVE = 0x1000, 0x2000, 0x4000
RIGHT, NEXT_LEFT = 0x1000000, 0x2000000


def node(name: str, *values, inner=None) -> tuple:
    """A record: its values with a letter each, and the records within (None: it has no list of them)."""
    return name, list(values), inner


def text(value: str) -> tuple:
    return "S", value


def prop(name: str, *values, kind: str = "Number") -> tuple:
    return node("P", text(name), text(kind), text(""), text("A"), *values)


def binary(records: list, version: int = 7400, packed: bool = False) -> bytes:
    """Lay records out as a binary file."""
    head = "<QQQB" if version >= 7500 else "<IIIB"
    size = struct.calcsize(head)

    def value(letter, content) -> bytes:
        if letter in ARRAYS:
            raw = np.asarray(content, ARRAYS[letter]).tobytes()
            body = zlib.compress(raw) if packed else raw
            return letter.encode() + struct.pack("<III", len(raw) // int(ARRAYS[letter][2]), packed, len(body)) + body
        if letter in "SR":
            raw = content if isinstance(content, bytes) else content.encode()
            return letter.encode() + struct.pack("<I", len(raw)) + raw
        return letter.encode() + struct.pack({"I": "<i", "L": "<q", "D": "<d", "C": "<B"}[letter], content)

    def lay(record, place) -> bytes:
        name, values, inner = record
        body = b"".join(value(*one) for one in values)
        out = name.encode() + body
        for child in inner or []:
            out += lay(child, place + size + len(out))
        if inner is not None:
            out += b"\0" * size
        return struct.pack(head, place + size + len(out), len(values), len(body), len(name)) + out

    data = b"Kaydara FBX Binary  \0\x1a\0" + struct.pack("<I", version)
    for record in records:
        data += lay(record, len(data))
    data += b"\0" * size + b"\xfa\xbc\xab" * 5 + b"!" + b"\0" * 4
    data += b"\0" * (16 - len(data) % 16) + struct.pack("<I", version) + b"\0" * 120
    return data + bytes.fromhex("f85a8c6adef5d97eece90ce3758f290b")


def ascii_(records: list, version: int = 7500, newline: str = "\n") -> bytes:
    """Write records as text, with a comment before each array, as Maya does."""
    lines = [f"; FBX {version // 1000}.{version % 1000 // 100}.0 project file", "; ---"]

    def value(letter, content) -> str:
        if letter == "S":
            if "\0\1" in content:
                content = "::".join(content.split("\0\1")[::-1])
            return '"' + content.replace('"', "&quot;") + '"'
        return chr(content) if letter == "C" else str(content)

    def lay(record, indent) -> None:
        name, values, inner = record
        if values and values[0][0] in ARRAYS:
            letter, content = values[0]
            if name == "KeyAttrDataFloat" and version >= 7200:
                content = np.asarray(content, "<f4").view("<i4")
            numbers = ",".join(
                str(one) for one in np.asarray(content, content.dtype if letter == "f" else ARRAYS[letter])
            )
            lines.append(f"{indent};{name}: told in a comment")
            lines.append(f"{indent}{name}: *{len(content)} {{")
            lines.extend([f"{indent}\ta: {numbers}", f"{indent}}} "])
            return
        shown = ",".join(value(*one) for one in values)
        lines.append(f"{indent}{name}: {shown}" + (" {" if inner is not None else ""))
        for child in inner or []:
            lay(child, indent + "\t")
        if inner is not None:
            lines.append(indent + "}")

    for record in records:
        lay(record, "")
    return (newline.join(lines) + newline).encode()


@dataclass
class Track:
    """A curve to be written: ticks, values, flags and attributes of each key."""

    ticks: np.ndarray
    values: np.ndarray
    flags: np.ndarray
    data: np.ndarray
    pre: str = "C"
    post: str = "C"
    repetition: int = -1

    def record(self, number: int) -> tuple:
        new = np.ones(len(self.ticks), dtype=bool)
        new[1:] = (self.flags[1:] != self.flags[:-1]) | (self.data[1:] != self.data[:-1]).any(axis=1)
        runs = np.flatnonzero(new)
        inner = [
            node("Default", ("D", 0.0)),
            node("KeyVer", ("I", 4009)),
            node("KeyTime", ("l", self.ticks)),
            node("KeyValueFloat", ("f", self.values.astype("<f4"))),
            node("KeyAttrFlags", ("i", self.flags[runs])),
            node("KeyAttrDataFloat", ("f", self.data[runs].ravel().view("<f4"))),
            node("KeyAttrRefCount", ("i", np.diff(np.append(runs, len(self.ticks))))),
        ]
        for name, kind in (("Pre-Extrapolation", self.pre), ("Post-Extrapolation", self.post)):
            if kind != "C":
                more = [node("Type", ("C", ord(kind))), node("Repetition", ("I", self.repetition))]
                inner.append(node(name, inner=more))
        return node("AnimationCurve", ("L", number), text("\0\1AnimCurve"), text(""), inner=inner)


def track(times, values, flags, slopes=None, weights=None) -> Track:
    """A curve of one kind of key; times in seconds, slopes as right and next left, weights in shares."""
    n = len(times)
    data = np.zeros((n, 4), dtype=np.uint32)
    data[:, 2] = THIRDS
    if slopes is not None:
        data[:, :2] = np.asarray(slopes, "<f4").reshape(n, 2).view(np.uint32)
    if weights is not None:
        right, left = np.rint(np.asarray(weights).reshape(n, 2) * 1e4).astype(np.uint32).T
        data[:, 2] = right | left << 16
    ticks = np.rint(np.asarray(times) * TICKS).astype(np.int64)
    return Track(ticks, np.asarray(values, float), np.broadcast_to(flags, n).astype(np.int64), data)


def drawn_track(rng: np.random.Generator, n: int, kinds: list[int] | None = None, start: float = 0.0) -> Track:
    """Keys at uneven times, of every interpolation and tangent."""
    times = start + np.concatenate([[0.0], np.cumsum(rng.uniform(0.03, 0.6, n - 1))])
    choice = [
        CONSTANT,
        CONSTANT | NEXT,
        LINEAR,
        LINEAR | USER,
        CUBIC | USER,
        CUBIC | USER | BROKEN,
        CUBIC | USER | BROKEN | RIGHT | NEXT_LEFT,
        CUBIC | USER | RIGHT,
        CUBIC | AUTO,
        CUBIC | AUTO | INDEPENDENT | PROGRESSIVE,
        CUBIC | AUTO | INDEPENDENT | NEXT_LEFT | RIGHT,
        CUBIC | AUTO | CLAMP | INDEPENDENT,
        CUBIC | TCB,
    ]
    flags = rng.choice(kinds or choice, n)
    out = track(times, rng.normal(size=n) * 10, flags, rng.normal(size=(n, 2)) * 20, rng.uniform(0.02, 0.9, (n, 2)))
    # An automatic key has a bias in place of a slope, one with tension three numbers of its own.
    automatic = (flags & CUBIC != 0) & (flags & (USER | TCB) == 0)
    bias = rng.choice([0.0, 0.0, 40.0, -30.0], (n, 2)).astype("<f4")
    out.data[automatic, :2] = bias[automatic].view(np.uint32)
    tcb = flags & TCB != 0
    out.data[tcb, :3] = rng.uniform(-0.8, 0.8, (n, 3)).astype("<f4")[tcb].view(np.uint32)
    return out


@dataclass
class Builder:
    """A scene under construction."""

    objects: list = field(default_factory=list)
    links: list = field(default_factory=list)
    takes: list = field(default_factory=list)
    settings: list = field(default_factory=list)
    number: int = 100
    header: list = field(default_factory=list)

    def add(self, kind: str, name: str, class_: str, subtype: str = "", props: list | None = None, inner=()) -> int:
        self.number += 1
        table = [node("Properties70", inner=props)] if props is not None else []
        values = (("L", self.number), text(f"{name}\0\1{class_}"), text(subtype))
        self.objects.append(node(kind, *values, inner=[*table, *inner]))
        return self.number

    def link(self, child: int, parent: int, at: str = "") -> None:
        more = [text(at)] if at else []
        self.links.append(node("C", text("OP" if at else "OO"), ("L", child), ("L", parent), *more))

    def model(self, name: str, parent: int = 0, subtype: str = "LimbNode", **props) -> int:
        table = []
        for key, value in props.items():
            values = np.atleast_1d(value)
            letter = "I" if values.dtype.kind == "i" and len(values) == 1 else "D"
            table.append(prop(key.replace("_", " "), *((letter, one.item()) for one in values)))
        number = self.add("Model", name, "Model", subtype, table)
        self.link(number, parent)
        return number

    def stack(self, name: str, start: float | None = None, stop: float | None = None) -> int:
        table = []
        for key, time in (
            ("LocalStart", start),
            ("LocalStop", stop),
            ("ReferenceStart", start),
            ("ReferenceStop", stop),
        ):
            if time is not None:
                table.append(node("P", text(key), text("KTime"), text("Time"), text(""), ("L", round(time * TICKS))))
        if start is not None and stop is not None:
            span = (("L", round(start * TICKS)), ("L", round(stop * TICKS)))
            inner = [node("LocalTime", *span), node("ReferenceTime", *span)]
            self.takes.append(node("Take", text(name), inner=inner))
        return self.add("AnimationStack", name, "AnimStack", props=table)

    def layer(self, stack: int, name: str = "BaseLayer", **props) -> int:
        table = [prop(key, ("D" if isinstance(value, float) else "I", value)) for key, value in props.items()]
        number = self.add("AnimationLayer", name, "AnimLayer", props=table)
        self.link(number, stack)
        return number

    def animate(self, layer: int, target: int, at: str, tracks: dict[str, Track], **defaults: float) -> list[int]:
        """Connect curves to a property; return their numbers."""
        table = [prop(f"d|{part}", ("D", defaults.get(part, 0.0))) for part in dict.fromkeys([*tracks, *defaults])]
        held = self.add("AnimationCurveNode", at.split()[-1][0], "AnimCurveNode", props=table)
        self.link(held, layer)
        self.link(held, target, at)
        numbers = []
        for part, one in tracks.items():
            self.number += 1
            self.objects.append(one.record(self.number))
            self.link(self.number, held, f"d|{part}")
            numbers.append(self.number)
        return numbers

    def records(self, version: int) -> list:
        settings = [prop(name, value) for name, value in self.settings]
        current = self.takes[0][1][0] if self.takes else text("")
        return [
            node(
                "FBXHeaderExtension",
                inner=[node("FBXHeaderVersion", ("I", 1003)), node("FBXVersion", ("I", version)), *self.header],
            ),
            node("GlobalSettings", inner=[node("Version", ("I", 1000)), node("Properties70", inner=settings)]),
            node("Definitions", inner=[node("Version", ("I", 100))]),
            node("Objects", inner=self.objects),
            node("Connections", inner=self.links),
            node("Takes", inner=[node("Current", current), *self.takes]),
        ]

    def binary(self, version: int = 7400, packed: bool = False) -> bytes:
        return binary(self.records(version), version, packed)

    def ascii(self, version: int = 7500, newline: str = "\n") -> bytes:
        return ascii_(self.records(version), version, newline)


def drawn_fbx(seed: int, start: float = 0.0) -> Builder:
    """Three limbs in a chain and a camera, moved by every kind of key in two layers, beside a mesh that must stay."""
    rng = np.random.default_rng(seed)
    made = Builder()
    made.settings = [("UpAxis", ("I", 1)), ("TimeMode", ("I", 6)), ("UnitScaleFactor", ("D", 1.0))]
    made.settings += [("TimeSpanStart", ("L", 0)), ("TimeSpanStop", ("L", 2 * TICKS))]
    mesh = made.add("Geometry", "mesh", "Geometry", "Mesh", inner=[node("Vertices", ("d", rng.normal(size=9)))])
    parent = 0
    limbs = []
    for index in range(3):
        turned = {"RotationActive": 1, "RotationOrder": int(rng.integers(0, 6)), "PreRotation": rng.normal(size=3) * 30}
        pivots = {"RotationPivot": rng.normal(size=3), "ScalingOffset": rng.normal(size=3)}
        post = {"PostRotation": rng.normal(size=3) * 20, "Lcl_Translation": rng.normal(size=3)}
        parent = made.model(f'limb {index} "ü"', parent, **turned, **pivots, **post)
        limbs.append(parent)
    made.link(mesh, limbs[0])
    camera = made.add("NodeAttribute", "lens", "NodeAttribute", "Camera", [prop("FocalLength", ("D", 35.0))])
    stack = made.stack("take", start, start + 2.5)
    base = made.layer(stack)
    top = made.layer(stack, "top", Weight=60.0, RotationAccumulationMode=int(rng.integers(0, 2)))
    for limb in limbs:
        for at in ("Lcl Translation", "Lcl Rotation", "Lcl Scaling"):
            axes = "XYZ" if at != "Lcl Scaling" else "Y"
            made.animate(
                base, limb, at, {axis: drawn_track(rng, int(rng.integers(1, 7)), start=start) for axis in axes}
            )
    made.animate(top, limbs[1], "Lcl Rotation", {"X": drawn_track(rng, 4, start=start)}, Y=5.0, Z=0.0)
    made.animate(top, top, "Weight", {"Weight": track([start, start + 1], [0.0, 100.0], LINEAR)})
    made.animate(base, camera, "FocalLength", {"FocalLength": drawn_track(rng, 3, start=start)})
    return made
