"""The glTF 2.0 container: JSON, and the buffers that it names, inside a GLB, beside the file or in its own text.

Source: the Khronos glTF 2.0 specification, sections 3.6 (binary data) and 4.4 (GLB).
"""

from __future__ import annotations

import base64
import struct
import urllib.parse
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from retime.arrays import FloatArray, doubles
from retime.errors import FormatError
from retime.files import read_bytes
from retime.formats.file_signatures import foreign_kind
from retime.formats.read_options import Limits
from retime.strict_json import parse_json

_MAGIC, _JSON, _BIN = 0x46546C67, 0x4E4F534A, 0x004E4942
TYPES: dict[int, str] = {5120: "<i1", 5121: "<u1", 5122: "<i2", 5123: "<u2", 5125: "<u4", 5126: "<f4"}
WIDTHS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4, "MAT2": 4, "MAT3": 9, "MAT4": 16}
FLOAT = 5126


@dataclass(frozen=True)
class Buffer:
    """One buffer and where its bytes come from.

    Attributes
    ----------
    data : bytes
        At least as many as it declares.
    place : "glb", "data" or Path
        The GLB's own chunk, the JSON text itself, or a file beside it.
    head : str
        Of a data URI, what stands before its bytes.
    """

    data: bytes
    place: str | Path
    head: str = ""


@dataclass(frozen=True)
class GltfFile:
    """A glTF scene as its file holds it.

    Attributes
    ----------
    path : Path
        The file.
    text : str
        Its JSON, as written.
    json : dict
        The same, parsed.
    buffers : list of Buffer
        In the order of ``json["buffers"]``.
    is_binary : bool
        Whether it is a GLB.
    more : bytes
        Chunks of a GLB after its JSON and buffer, as they were.
    """

    path: Path
    text: str
    json: dict[str, Any]
    buffers: list[Buffer]
    is_binary: bool
    more: bytes = b""

    def error(self, problem: str) -> FormatError:
        """Make an error of this file."""
        return FormatError(problem, path=self.path)

    def beside(self, uri: str, where: str) -> Path:
        """Find the file of a relative URI; refuse what leaves the folder."""
        name = urllib.parse.unquote(uri)
        if urllib.parse.urlsplit(uri).scheme or name.startswith(("/", "\\")) or "\0" in name or ":" in name:
            raise self.error(f"{where} must name a file beside this one, found {uri[:100]!r}")
        folder = self.path.parent.resolve()
        place = (folder / name).resolve()
        if folder not in place.parents:
            raise self.error(f"{where} leaves the file's folder: {uri[:100]!r}")
        return place

    def items(self, kind: str) -> list[dict[str, Any]]:
        """Return a list of objects of the JSON, such as its accessors; refuse what is none."""
        found = self.json.get(kind, [])
        if not isinstance(found, list) or not all(isinstance(one, dict) for one in found):
            raise self.error(f"{kind} must be a list of objects")
        return found

    def item(self, kind: str, index: object) -> dict[str, Any]:
        """Return one of them; refuse an index that there is not."""
        items = self.items(kind)
        if not isinstance(index, int) or isinstance(index, bool) or not 0 <= index < len(items):
            raise self.error(f"expected the index of one of {len(items)} {kind}, found {index!r}")
        return items[index]

    def view(self, index: object) -> tuple[bytes, int]:
        """Return the bytes of a buffer view, and its stride (0 where its elements are packed)."""
        view = self.item("bufferViews", index)
        buffer = self.whole(view, "buffer", f"bufferViews[{index}]")
        if buffer >= len(self.buffers):
            raise self.error(f"bufferViews[{index}] lies in buffer {buffer}, of {len(self.buffers)}")
        data = self.buffers[buffer].data
        start = self.whole(view, "byteOffset", f"bufferViews[{index}]", 0)
        length = self.whole(view, "byteLength", f"bufferViews[{index}]")
        # A file, or a chunk, may have more bytes than its buffer: those are nobody's, and go when it is written anew.
        size = self.whole(self.item("buffers", buffer), "byteLength", f"buffers[{buffer}]")
        if start + length > size:
            raise self.error(f"bufferViews[{index}] ends at byte {start + length} of buffer {buffer}, which has {size}")
        return data[start : start + length], self.whole(view, "byteStride", f"bufferViews[{index}]", 0)

    def whole(self, item: dict[str, Any], name: str, where: str, missing: int | None = None) -> int:
        """Return a member that is a whole number from 0 up."""
        value = item.get(name, missing)
        if not isinstance(value, int) or isinstance(value, bool) or not 0 <= value < 1 << 48:
            raise self.error(f"{where}.{name} must be a whole number from 0 up, found {str(value)[:40]}")
        return value

    def accessor(self, index: object) -> FloatArray:
        """Read an accessor: packed, with a stride, normalised or sparse.

        Returns
        -------
        float array, shape (count, width)
            Whole numbers that are not normalised as they are.
        """
        item = self.item("accessors", index)
        where = f"accessors[{index}]"
        width = WIDTHS.get(str(item.get("type")))
        if width is None:
            raise self.error(f"{where}.type must be one of {', '.join(WIDTHS)}; found {item.get('type')!r}")
        count = self.whole(item, "count", where)
        if "bufferView" in item:
            offset = self.whole(item, "byteOffset", where, 0)
            values = self._elements(item["bufferView"], offset, item.get("componentType"), count, width, where)
        elif "sparse" in item:
            # Zeros on a claim: as many as the sparse values alone can't explain are refused.
            if count * width > 1 << 22:
                raise self.error(f"{where} claims {count} elements that its file does not hold")
            values = np.zeros((count, width), dtype=_type_of(self, item, where))
        else:
            raise self.error(f"{where} names no bufferView, so it has no numbers")
        if "sparse" in item:
            values = self._with_sparse(values, item, where)
        if item.get("normalized") and values.dtype.kind in "iu":
            largest = np.iinfo(values.dtype).max
            return np.asarray(np.maximum(values.astype(np.float64) / largest, -1.0))
        floats = doubles(values)
        if not np.isfinite(floats).all():
            raise self.error(f"{where} holds a number that is not finite")
        return floats

    def _elements(
        self, view_index: object, offset: int, component: object, count: int, width: int, where: str
    ) -> NDArray[Any]:
        dtype = _type_of(self, {"componentType": component}, where)
        view, stride = self.view(view_index)
        size = dtype.itemsize * width
        stride = stride or size
        if stride < size:
            raise self.error(f"{where}: the stride of {stride} bytes is shorter than an element of {size}")
        if count and offset + (count - 1) * stride + size > len(view):
            raise self.error(
                f"{where} needs {offset + (count - 1) * stride + size} bytes for {count} elements, its bufferView has "
                f"{len(view)}"
            )
        if not count:
            return np.zeros((0, width), dtype=dtype)
        stride = stride if count > 1 else size
        return np.ndarray((count, width), dtype, view, offset, (stride, dtype.itemsize)).copy()

    def _with_sparse(self, values: NDArray[Any], item: dict[str, Any], where: str) -> NDArray[Any]:
        sparse = item["sparse"]
        parts = [sparse[name] for name in ("indices", "values") if isinstance(sparse, dict) and name in sparse]
        if len(parts) < 2 or not all(isinstance(part, dict) for part in parts):
            raise self.error(f"{where}.sparse needs indices and values")
        count = self.whole(sparse, "count", f"{where}.sparse")
        places, others = (
            self._elements(
                part.get("bufferView"), self.whole(part, "byteOffset", where, 0), component, count, width, where
            )
            for part, component, width in (
                (parts[0], parts[0].get("componentType"), 1),
                (parts[1], item.get("componentType"), values.shape[1]),
            )
        )
        if places.dtype.kind != "u" or (places >= len(values)).any():
            raise self.error(f"{where}.sparse points beyond its {len(values)} elements")
        values = values.copy()
        values[places[:, 0]] = others
        return values


def _type_of(file: GltfFile, item: dict[str, Any], where: str) -> np.dtype[Any]:
    component = item.get("componentType")
    if not isinstance(component, int) or component not in TYPES:
        raise file.error(f"{where}.componentType must be one of {', '.join(map(str, TYPES))}; found {component!r}")
    return np.dtype(TYPES[component])


def parse_gltf(path: Path, data: bytes, limits: Limits) -> GltfFile:
    """Read a GLB or a .gltf with its buffers; raise FormatError with the place.

    Buffers in other files must lie in the folder of `path` or below it; no address of a network is opened.
    """
    chunk: bytes | None = None
    is_binary = data[:4] == b"glTF"
    more = b""
    text_bytes = data
    if is_binary:
        text_bytes, chunk, more = _chunks(path, data)
    elif path.suffix.lower() == ".glb" or not data.lstrip(b"\xef\xbb\xbf \t\r\n").startswith(b"{"):
        kind = foreign_kind(data)
        found = f"this is {kind}" if kind else "empty" if not data else "its first bytes are none"
        raise FormatError(f"expected a glTF scene; {found}", path=path, byte=0)
    try:
        json = parse_json(text_bytes, what="a glTF scene")
    except FormatError as error:
        raise FormatError(error.problem, path=path, line=error.line, column=error.column, byte=error.byte) from None
    if not isinstance(json, dict) or not isinstance(json.get("asset"), dict):
        raise FormatError("expected a glTF scene, found JSON without an asset", path=path)
    version = str(json["asset"].get("minVersion", json["asset"].get("version")))
    if not version.startswith("2."):
        raise FormatError(f"expected glTF 2.x, found version {version!r}; convert it to glTF 2.0 first", path=path)
    file = GltfFile(path, text_bytes.decode("utf-8-sig"), json, [], is_binary, more)
    total = 0
    for index, item in enumerate(file.items("buffers")):
        length = file.whole(item, "byteLength", f"buffers[{index}]")
        buffer = _buffer(file, item, index, chunk, limits)
        if len(buffer.data) < length:
            raise file.error(f"buffers[{index}] declares {length} bytes, there are {len(buffer.data)}")
        total += len(buffer.data)
        if total > limits.file_bytes:
            raise file.error(f"its buffers have more than {limits.file_bytes} bytes (Limits.file_bytes)")
        file.buffers.append(buffer)
    _check_lists(file)
    return file


def _check_lists(file: GltfFile) -> None:
    """Refuse lists that are none, and what writing would trip over: views and accessors that nothing reads, too."""
    for kind in ("animations", "images", "meshes", "nodes", "skins"):
        file.items(kind)
    for index in range(len(file.items("bufferViews"))):
        file.view(index)
    for index, item in enumerate(file.items("accessors")):
        sparse = item.get("sparse", {})
        parts = (
            [item, *(sparse.get(name, {}) for name in ("indices", "values"))] if isinstance(sparse, dict) else [None]
        )
        for part in parts:
            if not isinstance(part, dict):
                raise file.error(f"accessors[{index}].sparse must be an object with indices and values")
            if "bufferView" in part:
                file.item("bufferViews", part["bufferView"])
    for index, item in enumerate(file.items("animations")):
        samplers = item.get("samplers", [])
        if not isinstance(samplers, list) or not all(isinstance(one, dict) for one in samplers):
            raise file.error(f"animations[{index}].samplers must be a list of objects")


def _chunks(path: Path, data: bytes) -> tuple[bytes, bytes | None, bytes]:
    if len(data) < 20:
        raise FormatError(f"a GLB has at least 20 bytes, this has {len(data)}", path=path, byte=len(data))
    _, version, length = struct.unpack_from("<III", data)
    if version != 2:
        raise FormatError(f"expected a GLB of version 2, found {version}", path=path, byte=4)
    if length > len(data):
        raise FormatError(f"the GLB declares {length} bytes, there are {len(data)}: it was cut", path=path, byte=8)
    chunks = []
    place = 12
    while place < length:
        if place + 8 > length:
            raise FormatError("the GLB ends within the head of a chunk", path=path, byte=place)
        size, kind = struct.unpack_from("<II", data, place)
        if place + 8 + size > length:
            raise FormatError(
                f"a chunk claims {size} bytes, {length - place - 8} are left: the file was cut", path=path, byte=place
            )
        chunks.append((kind, place, place + 8, place + 8 + size))
        place += 8 + size + (-size % 4 if place + 8 + size < length else 0)
    if not chunks or chunks[0][0] != _JSON:
        raise FormatError("the GLB does not begin with its JSON chunk", path=path, byte=12)
    text = data[chunks[0][2] : chunks[0][3]]
    binary = len(chunks) > 1 and chunks[1][0] == _BIN
    rest = chunks[2 if binary else 1 :]
    return text, data[chunks[1][2] : chunks[1][3]] if binary else None, data[rest[0][1] :] if rest else b""


def _buffer(file: GltfFile, item: dict[str, Any], index: int, chunk: bytes | None, limits: Limits) -> Buffer:
    uri = item.get("uri")
    if uri is None:
        if index or chunk is None:
            raise file.error(f"buffers[{index}] names no uri, and there is no GLB chunk for it")
        return Buffer(chunk, "glb")
    if not isinstance(uri, str):
        raise file.error(f"buffers[{index}].uri must be text")
    if uri.startswith("data:"):
        head, comma, body = uri.partition(",")
        if not comma or not head.endswith(";base64"):
            raise file.error(f"buffers[{index}].uri is a data URI that is not base64")
        try:
            return Buffer(base64.b64decode(body, validate=True), "data", f"{head},")
        except ValueError as error:
            # binascii's own is one; letters beyond ASCII come to a plain one.
            raise file.error(f"buffers[{index}].uri: {error}") from None
    place = file.beside(uri, f"buffers[{index}].uri")
    try:
        return Buffer(read_bytes(place, limits.file_bytes), place)
    except OSError as error:
        raise file.error(f"its buffer {uri!r} can't be opened: {error.strerror}") from None


def build_glb(text: str, chunk: bytes, more: bytes) -> bytes:
    """Put a GLB together: JSON padded with spaces, the buffer with zeros, other chunks as they were."""
    json_bytes = text.encode()
    json_bytes += b" " * (-len(json_bytes) % 4)
    parts = [struct.pack("<II", len(json_bytes), _JSON), json_bytes]
    if chunk:
        padded = chunk + b"\0" * (-len(chunk) % 4)
        parts += [struct.pack("<II", len(padded), _BIN), padded]
    parts.append(more)
    return b"".join([struct.pack("<III", _MAGIC, 2, 12 + sum(map(len, parts))), *parts])
