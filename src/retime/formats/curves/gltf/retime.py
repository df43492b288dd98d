"""New keys for the animations of a glTF scene; every other byte stays as it was, where the format allows.

New numbers take the place of the old ones: accessors and buffer views that served these animations alone keep their
indices, and their old bytes are cut out of a GLB's buffer. What anything else uses is left, and new entries are added.
"""

from __future__ import annotations

import base64
import json
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any
from urllib.parse import unquote, urlsplit

import numpy as np
from numpy.typing import NDArray

from retime.arrays import BoolArray
from retime.brief import brief_repr
from retime.files import read_bytes
from retime.formats.curves.gltf.animation import Animation, Sampler
from retime.formats.curves.gltf.file import FLOAT, TYPES, WIDTHS, GltfFile, build_glb
from retime.formats.curves.gltf.json_splice import spliced

# Bytes of a GLB's buffer are cut out by multiples of this, so that what follows stays aligned.
_ALIGN = 16


@dataclass(frozen=True)
class NewKeys:
    """What a sampler is to hold.

    Attributes
    ----------
    animation : int
    sampler : Sampler
        As it was.
    times : float32 array, shape (n_keys,)
    values : float32 array, shape (n_rows, k)
    interpolation : str
    """

    animation: int
    sampler: Sampler
    times: NDArray[np.float32]
    values: NDArray[np.float32]
    interpolation: str

    __repr__ = brief_repr


def with_keys(file: GltfFile, keys: list[NewKeys], animations: list[Animation]) -> dict[str, bytes]:
    """Write a scene with new keys.

    Parameters
    ----------
    file : GltfFile
        The scene.
    keys : list of NewKeys
        For every sampler of `animations`.
    animations : list of Animation
        Those that are retimed.

    Returns
    -------
    dict of str to bytes
        "" is the scene itself; other names are of files beside it that are new or changed. ``{stem}`` in a name, and
        in the scene's own text, stands for the name that the scene will have.
    """
    files = _Writer(file, keys, animations).written()
    for item in (*file.items("buffers"), *file.items("images")):
        uri = item.get("uri")
        if isinstance(uri, str) and not urlsplit(uri).scheme and uri not in files:
            # What the scene names beside itself goes with it to another folder.
            place = file.beside(uri, "uri")
            if place.is_file():
                files[unquote(uri)] = read_bytes(place)
    return files


class _Writer:
    def __init__(self, file: GltfFile, keys: list[NewKeys], animations: list[Animation]) -> None:
        self.file = file
        self.keys = keys
        self.accessors = [dict(one) for one in file.items("accessors")]
        self.views = [dict(one) for one in file.items("bufferViews")]
        self.animations = json.loads(json.dumps(file.items("animations")))
        replaced = {one.index for one in animations}
        self.old = {accessor for one in keys for accessor in (one.sampler.times, one.sampler.values)}
        others = _accessors_in_use(file, replaced)
        self.free = self.old - others
        used_views = _views_in_use(file, set(range(len(self.accessors))) - self.free)
        self.free_views = {view for index in self.free for view in _views_of(self.accessors[index])} - used_views
        # New bytes of each view that is laid anew.
        self.laid: dict[int, bytearray] = {}

    def written(self) -> dict[str, bytes]:
        chosen: dict[tuple[int, bytes], int] = {}
        for one in self.keys:
            item = self.animations[one.animation]["samplers"][one.sampler.index]
            item["input"] = self._accessor(chosen, one.sampler.times, one.times[:, None], limits=True)
            item["output"] = self._accessor(chosen, one.sampler.values, one.values, limits=False)
            if one.interpolation != one.sampler.interpolation:
                item["interpolation"] = one.interpolation
        buffers, files = self._buffers()
        members = {"accessors": self.accessors, "bufferViews": self.views, "animations": self.animations}
        text = spliced(self.file.text, {**members, "buffers": buffers})
        if self.file.is_binary:
            return {"": build_glb(text, files.pop("glb"), self.file.more), **files}
        return {"": text.encode(), **files}

    def _accessor(
        self, chosen: dict[tuple[int, bytes], int], old: int, values: NDArray[np.float32], *, limits: bool
    ) -> int:
        """Find or make the accessor that holds values in place of an old one."""
        item = dict(self.file.items("accessors")[old])
        if values.size % _width(item):
            # Numbers that were laid out in rows of another width than their keys have: one by one they always fit.
            item["type"] = "SCALAR"
        data = self._packed(item, values)
        key = (old, data)
        if key in chosen:
            return chosen[key]
        index = old if old in self.free and old not in chosen.values() else len(self.accessors)
        if index == len(self.accessors):
            self.accessors.append({})
        chosen[key] = index
        item["count"] = values.size // _width(item)
        view = item.get("bufferView")
        if view not in self.free_views:
            view = self._new_view()
        laid = self.laid.setdefault(view, bytearray())
        item["bufferView"] = view
        item.pop("byteOffset", None)
        if laid:
            item["byteOffset"] = len(laid)
        laid += data + b"\0" * (-len(data) % 4)
        item.pop("sparse", None)
        rows = np.frombuffer(data, dtype=_dtype(item)).reshape(-1, _width(item))
        for name, value in (("min", rows.min(axis=0)), ("max", rows.max(axis=0))):
            if limits or name in item:
                item[name] = value.tolist()
        self.accessors[index] = item
        return index

    def _packed(self, item: dict[str, Any], values: NDArray[np.float32]) -> bytes:
        """Return the bytes of values; whole numbers that are a quantity's own type stay whole, others become floats."""
        if item.get("componentType") != FLOAT:
            fits = (values == np.clip(np.rint(values), *_range(_dtype(item)))).all()
            if not item.get("normalized") and fits:
                return values.astype(_dtype(item)).tobytes()
            item["componentType"] = FLOAT
            item.pop("normalized", None)
        return values.astype("<f4").tobytes()

    def _new_view(self) -> int:
        """Make a view for what can't stand where it stood; one is enough."""
        for view in self.laid:
            if view >= len(self.file.items("bufferViews")):
                return view
        self.views.append({})
        self.free_views.add(len(self.views) - 1)
        return len(self.views) - 1

    def _buffers(self) -> tuple[list[dict[str, Any]], dict[str, bytes]]:
        """Lay the new bytes into buffers; return the JSON's list and the contents of files (the GLB's own as "glb")."""
        buffers = [dict(one) for one in self.file.items("buffers")]
        files: dict[str, bytes] = {}
        if self.file.is_binary and self.file.buffers and self.file.buffers[0].place == "glb":
            index, base = 0, self._compacted()
        elif self.file.is_binary and not self.file.buffers:
            buffers.append({})
            index, base = 0, b""
        else:
            index, base = self._buffer_alone(buffers), b""
        content = bytearray(base)
        for view in self.free_views | set(self.laid):
            if view not in self.laid:
                # Its accessors found another place: it must still lie within its buffer.
                self.laid[view] = bytearray()
        for view, laid in sorted(self.laid.items()):
            content += b"\0" * (-len(content) % 4)
            kept = {name: value for name, value in self.views[view].items() if name in ("name", "extras", "extensions")}
            self.views[view] = {"buffer": index, "byteOffset": len(content), "byteLength": max(4, len(laid)), **kept}
            content += laid or b"\0" * 4
        buffers[index] = {**buffers[index], "byteLength": len(content)}
        data = bytes(content)
        if self.file.is_binary and index == 0 and "uri" not in buffers[0]:
            files["glb"] = data
        elif str(buffers[index].get("uri", "data:")).startswith("data:"):
            head = self.file.buffers[index].head if index < len(self.file.buffers) else ""
            head = head or "data:application/octet-stream;base64,"
            buffers[index]["uri"] = head + base64.b64encode(data).decode()
        else:
            files[buffers[index]["uri"]] = data
        if self.file.is_binary and "glb" not in files:
            files["glb"] = self.file.buffers[0].data if self.file.buffers else b""
        return buffers, files

    def _buffer_alone(self, buffers: list[dict[str, Any]]) -> int:
        """Choose a buffer that holds nothing but what is laid anew; else add one, of the kind that the file has."""
        used = {view["buffer"] for index, view in enumerate(self.views) if index not in self.free_views and view}
        for index, one in enumerate(self.file.buffers):
            if index not in used and one.place != "glb":
                return index
        beside = any(isinstance(one.place, Path) for one in self.file.buffers)
        buffers.append({"uri": "{stem}_animation.bin"} if beside else {})
        return len(buffers) - 1

    def _compacted(self) -> bytes:
        """Cut out of a GLB's buffer what served the old keys alone, and move the views that follow."""
        data = self.file.buffers[0].data
        declared = self.file.whole(self.file.items("buffers")[0], "byteLength", "buffers[0]")
        data = data[:declared]
        live = _mark(self.views, set(range(len(self.views))) - self.free_views, len(data))
        dead = _mark(self.views, self.free_views, len(data)) & ~live
        if _has_offsets_elsewhere(self.file.json):
            return data
        # Whole blocks only: what stays keeps its place within a block.
        padded = np.append(dead, np.zeros(-len(data) % _ALIGN, dtype=bool))
        blocks: BoolArray = np.asarray(padded.reshape(-1, _ALIGN).all(axis=1))
        if len(data) % _ALIGN and len(blocks) and dead[len(data) // _ALIGN * _ALIGN :].all():
            blocks[-1] = True
        removed = np.concatenate([[0], np.cumsum(blocks)]) * _ALIGN
        for index, view in enumerate(self.views):
            if index not in self.free_views and view.get("buffer") == 0:
                start = view.get("byteOffset", 0)
                moved = int(removed[start // _ALIGN])
                if moved:
                    self.views[index] = {**view, "byteOffset": start - moved}
        return np.frombuffer(data, np.uint8)[~np.repeat(blocks, _ALIGN)[: len(data)]].tobytes()


def _mark(views: list[dict[str, Any]], chosen: Iterable[int], size: int) -> BoolArray:
    marked = np.zeros(size, dtype=bool)
    for index in chosen:
        view = views[index]
        if view.get("buffer") == 0:
            start = view.get("byteOffset", 0)
            marked[start : start + view["byteLength"]] = True
    return marked


def _width(item: dict[str, Any]) -> int:
    return WIDTHS[item["type"]]


def _range(dtype: np.dtype[Any]) -> tuple[float, float]:
    limits = np.iinfo(dtype)
    return float(limits.min), float(limits.max)


def _dtype(item: dict[str, Any]) -> np.dtype[Any]:
    return np.dtype(TYPES[item["componentType"]])


def _views_of(accessor: dict[str, Any]) -> Iterator[int]:
    sparse = accessor.get("sparse", {})
    for part in (accessor, sparse.get("indices", {}), sparse.get("values", {})):
        if isinstance(part.get("bufferView"), int):
            yield part["bufferView"]


def _accessors_in_use(file: GltfFile, replaced: set[int]) -> set[int]:
    """Find every accessor that something besides the replaced animations may use.

    Any whole number in a mesh, a skin or an extension is taken for one: too many stay, never too few.
    """
    used = set()
    for index, item in enumerate(file.items("animations")):
        if index not in replaced:
            used |= {one.get(name) for one in item.get("samplers", []) for name in ("input", "output")}
    for kind in ("meshes", "skins"):
        used |= set(_wholes(file.json.get(kind)))
    return {one for one in used | set(_extension_wholes(file.json)) if isinstance(one, int)}


def _views_in_use(file: GltfFile, live_accessors: set[int]) -> set[int]:
    """Find every buffer view that something besides the old keys may use."""
    accessors = file.items("accessors")
    used = {view for index in live_accessors for view in _views_of(accessors[index])}
    used |= {one["bufferView"] for one in file.json.get("images", []) if isinstance(one.get("bufferView"), int)}
    return used | set(_extension_wholes(file.json))


def _wholes(node: Any) -> Iterator[int]:
    """All whole numbers within a JSON value."""
    if isinstance(node, dict | list):
        for child in node.values() if isinstance(node, dict) else node:
            yield from _wholes(child)
    elif isinstance(node, int) and not isinstance(node, bool):
        yield node


def _extension_wholes(node: Any) -> Iterator[int]:
    """All whole numbers within any extension."""
    if isinstance(node, list):
        for child in node:
            yield from _extension_wholes(child)
    elif isinstance(node, dict):
        for name, child in node.items():
            yield from _wholes(child) if name == "extensions" else _extension_wholes(child)


def _has_offsets_elsewhere(json: Any) -> bool:
    """Whether an extension speaks of places in a buffer, which would have to move too."""
    if isinstance(json, list):
        return any(map(_has_offsets_elsewhere, json))
    if not isinstance(json, dict):
        return False
    for name, child in json.items():
        if name == "extensions" and "byteOffset" in repr(child):
            return True
        if _has_offsets_elsewhere(child):
            return True
    return False
