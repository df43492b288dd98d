"""glTF animations, literally by the specification: `struct` and plain numbers, one value at a time."""

from __future__ import annotations

import base64
import json
import struct
from pathlib import Path

from tests.reference.segments import slerp

FORMATS = {5120: ("b", 127), 5121: ("B", 255), 5122: ("h", 32767), 5123: ("H", 65535), 5125: ("I", 1), 5126: ("f", 1)}
WIDTHS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4}


class Scene:
    """A scene, its JSON and its buffers."""

    def __init__(self, path: Path) -> None:
        data = path.read_bytes()
        chunk = b""
        if data[:4] == b"glTF":
            size = struct.unpack_from("<I", data, 12)[0]
            text, rest = data[20 : 20 + size], data[20 + size :]
            if rest:
                chunk = rest[8 : 8 + struct.unpack_from("<I", rest)[0]]
        else:
            text = data
        self.json = json.loads(text)
        self.buffers = []
        for one in self.json.get("buffers", []):
            uri = one.get("uri")
            if uri is None:
                self.buffers.append(chunk)
            elif uri.startswith("data:"):
                self.buffers.append(base64.b64decode(uri.split(",", 1)[1]))
            else:
                self.buffers.append((path.parent / uri).read_bytes())

    def accessor(self, index: int) -> list[list[float]]:
        item = self.json["accessors"][index]
        letter, largest = FORMATS[item["componentType"]]
        width = WIDTHS[item["type"]]
        view = self.json["bufferViews"][item["bufferView"]]
        size = struct.calcsize(letter) * width
        base = view.get("byteOffset", 0) + item.get("byteOffset", 0)
        assert (
            item.get("byteOffset", 0) + (item["count"] - 1) * (view.get("byteStride") or size) + size
            <= (view["byteLength"])
        )
        buffer = self.buffers[view["buffer"]]
        rows = []
        for index_of_row in range(item["count"]):
            place = base + index_of_row * (view.get("byteStride") or size)
            row = struct.unpack_from(f"<{width}{letter}", buffer, place)
            rows.append([max(x / largest, -1.0) for x in row] if item.get("normalized") else list(row))
        return rows

    def value(self, animation: int, channel: int, time: float) -> list[float]:
        """What a channel has at a time."""
        track = self.json["animations"][animation]
        sampler = track["samplers"][track["channels"][channel]["sampler"]]
        path = track["channels"][channel]["target"]["path"]
        times = [row[0] for row in self.accessor(sampler["input"])]
        flat = [x for row in self.accessor(sampler["output"]) for x in row]
        kind = sampler.get("interpolation", "LINEAR")
        parts = 3 if kind == "CUBICSPLINE" else 1
        width = len(flat) // (parts * len(times))
        keys = [
            [flat[(k * parts + p) * width : (k * parts + p + 1) * width] for p in range(parts)]
            for k in range(len(times))
        ]
        middle = 1 if parts == 3 else 0
        if time < times[0]:
            return keys[0][middle]
        for k in range(len(times) - 1):
            if times[k] <= time < times[k + 1]:
                return _between(keys[k], keys[k + 1], times[k], times[k + 1], time, kind, path)
        return keys[-1][middle]


def _between(a, b, start, end, time, kind, path):
    width = end - start
    t = (time - start) / width
    if kind == "STEP":
        return a[0]
    if kind == "LINEAR" and path != "rotation":
        return [(1 - t) * x + t * y for x, y in zip(a[0], b[0], strict=True)]
    if kind == "LINEAR":
        return slerp(a[0], b[0], t)
    return [
        (2 * t**3 - 3 * t**2 + 1) * va
        + width * (t**3 - 2 * t**2 + t) * out
        + (-2 * t**3 + 3 * t**2) * vb
        + width * (t**3 - t**2) * into
        for va, out, vb, into in zip(a[1], a[2], b[1], b[0], strict=True)
    ]
