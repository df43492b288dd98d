"""Binary files without their names; their bytes stay where they were.

What is no name stays: the numbers of C3D captures and of arrays, but for those of the frames in the middle, which
repeat the first one; the keys of scenes. What no reader here looks at (meshes, pictures) is made zero.
"""

from __future__ import annotations

import base64
import binascii
import json
import math
import re
import struct
import zipfile
from collections.abc import Iterator
from io import BytesIO
from pathlib import Path
from typing import Any, Literal
from urllib.parse import unquote

from retime.errors import RetimeError
from retime.formats.c3d_file import parse_c3d
from retime.formats.c3d_numbers import MACHINES
from retime.formats.npy_arrays import parse_array
from retime.formats.read_options import ReadOptions
from retime.issue_report.stand_ins import StandIns
from retime.issue_report.text_files import FBX_MODULES, UNITS_AND_AXES
from retime.issue_report.vocabulary import words_of_modules

_RUN = re.compile(rb"[\x20-\x7e\x80-\xff]{3,}")
_C3D = tuple(f"retime.formats.{one}" for one in ("c3d", "c3d_file", "c3d_frames", "c3d_numbers"))
_C3D_BLOCK = 512
_BYTE_ORDERS: tuple[Literal["little", "big"], ...] = ("little", "big")
# Where the header has the labels of its events.
_C3D_LABELS = (396, 468)
_ARRAYS = (
    "retime.formats.npy",
    "retime.formats.npy_arrays",
    "retime.formats.amass",
    "retime.formats.smpl_body",
    "retime.motion.channels",
)
_GLTF = tuple(
    f"retime.formats.curves.gltf.{one}" for one in ("format", "animation", "file", "retime", "scene", "write")
)
_KEYPOINTS = tuple(
    f"retime.formats.keypoints.{one}" for one in ("format", "frames", "layouts", "mediapipe", "openpose")
)
Spans = list[tuple[int, int]]
"""Begins and ends of bytes."""

# Text of a JSON document: what a backslash begins is no word, nor is a byte that an address writes as a number.
_JSON_PIECE = re.compile(rb"\\u[0-9a-fA-F]{4}|\\.|%[0-9a-fA-F]{2}|(?:[^\\%]|%(?![0-9a-fA-F]{2}))+", re.DOTALL)
_ADDRESS_BYTE, _WORD_BYTE = re.compile(rb"%[0-9a-fA-F]{2}"), re.compile(rb"[A-Za-z0-9_\x80-\xff]")
_DATA_URI = re.compile(rb'("data:)([^,"\\]*)(,)([A-Za-z0-9+/=]*)')
_FBX_START = 27
# Arrays of an FBX that its animation is made of begin so.
_FBX_KEYS = (b"Key", b"Matrix", b"Transform")


def mask_c3d(data: bytes, names: StandIns) -> bytes:
    """Replace the texts of a C3D's header and parameters that the format has not."""
    known = words_of_modules(*_C3D) | UNITS_AND_AXES
    out = bytearray(data)
    begin, end = _C3D_LABELS
    _mask_runs(out, begin, min(end, len(out)), names, known)
    place = (data[0] - 1) * _C3D_BLOCK + 3 if data else 0
    if data[1:2] != b"\x50" or place < 0 or place >= len(data) or data[place] not in MACHINES:
        # No C3D, or one whose bytes have moved: its text may be anywhere.
        _mask_runs(out, 0, len(out), names, known)
    else:
        # The parameters end where the frames begin; how the machine writes numbers is not needed to see that.
        # Header and section both say where that is, and damage may have changed one of them.
        section = max(data[0] - 1, 0) * _C3D_BLOCK
        said = [section + _C3D_BLOCK * data[section + 2] if section + 2 < len(data) else 0]
        said += [_C3D_BLOCK * (int.from_bytes(data[16:18], order) - 1) for order in _BYTE_ORDERS]
        ends = [end for end in said if section < end <= len(data)]
        _mask_parameters(out, section + 4, max(ends, default=len(out)), names, known)
    return bytes(out)


def _mask_parameters(out: bytearray, at: int, end: int, names: StandIns, known: frozenset[bytes]) -> None:
    """Walk through the parameters as far as they lead; what comes behind is looked through for text."""
    while at + 2 < end:
        size = abs(out[at] - 256 if out[at] > 127 else out[at])
        is_group = out[at + 1] > 127
        link = at + 2 + size
        if size == 0 or link + 2 > end:
            break
        out[at + 2 : link] = names.in_words(bytes(out[at + 2 : link]), known)
        step = int.from_bytes(out[link : link + 2], "little")
        stop = min(link + step, end) if step >= 2 else end
        text_at = link + 2
        if not is_group and link + 4 <= end:
            is_text, n_dimensions = out[link + 2] == 255, out[link + 3]
            dimensions = out[link + 4 : link + 4 + n_dimensions]
            values = link + 4 + n_dimensions
            text_at = min(values + math.prod(dimensions) * (1 if is_text else max(out[link + 2], 1)), stop)
            if not is_text:
                # Numbers, unless damage has moved words in among them: few numbers look like long ones.
                _mask_runs(out, values, text_at, names, known, least=6)
            if is_text and text_at > values:
                # Texts of one length follow one another, with nothing between them.
                size = (dimensions[0] if dimensions else 1) or 1
                for begin in range(values, text_at, size):
                    _mask_runs(out, begin, min(begin + size, text_at), names, known, least=1)
        _mask_runs(out, text_at, stop, names, known, least=1)
        at = stop
        if step < 2:
            break
    _mask_runs(out, at, end, names, known)


def shorter_c3d(data: bytes, options: ReadOptions) -> Iterator[bytes]:
    """Let the frames in the middle of a C3D repeat its first one; none, where it can't be taken apart."""
    try:
        file = parse_c3d(Path("clip.c3d"), data, options)
    except RetimeError:
        return
    row = file.layout.numbers * (4 if file.scale < 0 else 2)
    yield _middle_repeated(data, file.data_start, row, file.n_frames)


def mask_npy(data: bytes, names: StandIns) -> bytes:
    """Replace what a NumPy array holds of text."""
    out = bytearray(data)
    start = _npy_start(data)
    head = data[:start]
    # Names of fields stand in the header; arrays of text in what follows.
    known = words_of_modules(*_ARRAYS) | UNITS_AND_AXES | {b"descr", b"fortran_order", b"shape", b"numpy"}
    codes = {match[0].strip(b"'<>|=").lower() for match in re.finditer(rb"'[<>|=]?[a-zA-Z][0-9]*'", head)}
    out[10:start] = names.in_words(bytes(out[10:start]), known | codes)
    texts = re.search(rb"'descr'\s*:\s*'([<>|=]?)([SU])([0-9]+)'", head)
    if texts is not None:
        out[start:] = _mask_texts(data[start:], texts[2] == b"U", texts[1] == b">", max(int(texts[3]), 1), names, known)
    elif b"'O'" in head or b"|O" in head:
        # A pickle: nobody here reads it, whatever is in it.
        out[start:] = bytes(len(out) - start)
    return bytes(out)


def _mask_texts(
    content: bytes, is_wide: bool, is_big: bool, letters: int, names: StandIns, known: frozenset[bytes]
) -> bytes:
    """Mask an array of texts of one length; a letter takes four bytes, or one."""
    step = 4 if is_wide else 1
    low = content[(3 if is_big else 0) :: 4] if is_wide else content
    high = content[(2 if is_big else 1) :: 4] if is_wide else bytes(len(content))
    # Letters beyond ASCII are made one of it.
    plain = bytes(letter if letter < 128 and not more else ord("n") for letter, more in zip(low, high, strict=False))
    masked = b"".join(names.in_words(plain[at : at + letters], known) for at in range(0, len(plain), letters))
    out = bytearray(len(content))
    out[(3 if is_wide and is_big else 0) :: step] = masked + bytes(len(low) - len(masked))
    return bytes(out)


def _npy_start(data: bytes) -> int:
    wide = data[6:7] not in (b"\x01",)
    begin = 12 if wide else 10
    return min(begin + int.from_bytes(data[8:begin], "little"), len(data))


def shorter_npy(data: bytes, options: ReadOptions) -> Iterator[bytes]:
    """Let the frames in the middle of an array repeat its first one."""
    try:
        array = parse_array(Path("clip.npy"), data, "the array", options)
    except RetimeError:
        return
    if array.fortran or not array.shape or array.kind not in "fiu":
        return
    lengths = [size for size in array.shape if size != 1] or [1]
    row = math.prod(lengths[1:]) * array.item_bytes
    yield _middle_repeated(data, _npy_start(data), row, lengths[0])


def mask_npz(data: bytes, names: StandIns) -> bytes:
    """Replace the names of an archive's members, and what they hold of text; packed anew."""
    return _repacked(data, lambda name, content: (_member_name(name, names), mask_npy(content, names)))


def _member_name(name: str, names: StandIns) -> str:
    stem, dot, ending = name.rpartition(".")
    known = words_of_modules(*_ARRAYS)
    masked = names.in_words((stem if dot else name).encode(), known).decode("utf-8", "replace")
    return f"{masked}{dot}{ending}" if dot else masked


def shorter_npz(data: bytes, options: ReadOptions) -> Iterator[bytes]:
    """Let the frames in the middle of an archive's arrays repeat their first one."""
    yield _repacked(data, lambda name, content: (name, next(shorter_npy(content, options), content)))


def _repacked(data: bytes, change: Any) -> bytes:
    """Pack an archive anew with members changed; one that can't be opened is left as its first bytes."""
    packed = BytesIO()
    try:
        with zipfile.ZipFile(BytesIO(data)) as old, zipfile.ZipFile(packed, "w", zipfile.ZIP_DEFLATED) as new:
            for member in old.infolist():
                name, content = change(member.filename, old.read(member))
                new.writestr(zipfile.ZipInfo(name), content, member.compress_type)
    except (zipfile.BadZipFile, RuntimeError, NotImplementedError, ValueError, OSError, EOFError):
        return data[:4]
    return packed.getvalue()


def mask_gltf(data: bytes, names: StandIns) -> bytes:
    """Replace the texts of a glTF's JSON; meshes and pictures in it are made zero."""
    known = words_of_modules(*_GLTF)
    spans = _animation_spans(data)
    parts, place, buffer = [], 0, 0
    for match in _DATA_URI.finditer(data):
        parts.append(_mask_json(data[place : match.start()], names, known))
        # The buffers come in the order of their list in all files but strange ones; pictures are none.
        is_buffer = not match[2].startswith(b"image")
        parts.append(
            match[1] + match[2] + match[3] + _blank_base64(match[4], spans.get(buffer, ()) if is_buffer else ())
        )
        buffer += is_buffer
        place = match.end()
    return b"".join([*parts, _mask_json(data[place:], names, known)])


def mask_keypoints(data: bytes, names: StandIns) -> bytes:
    """Replace the texts of keypoints in JSON that their reader does not know."""
    known = words_of_modules(*_KEYPOINTS) | UNITS_AND_AXES
    return _mask_json(data, names, known)


def _mask_json(text: bytes, names: StandIns, known: frozenset[bytes]) -> bytes:
    def piece(match: re.Match[bytes]) -> bytes:
        found = match[0]
        if found.startswith(b"\\"):
            return b"\\u0101" if found.startswith(b"\\u") else found
        if _ADDRESS_BYTE.fullmatch(found):
            return b"%6e" if _WORD_BYTE.fullmatch(bytes((int(found[1:], 16),))) else found
        return names.in_words(found, known)

    return _JSON_PIECE.sub(piece, text)


def mask_glb(data: bytes, names: StandIns) -> bytes:
    """Replace the texts of a GLB; meshes and pictures in it are made zero."""
    out = bytearray(data)
    at = 12
    spans: dict[int, list[tuple[int, int]]] = {}
    while at + 8 <= len(out):
        size, kind = struct.unpack_from("<II", out, at)
        begin, end = at + 8, min(at + 8 + size, len(out))
        if kind == 0x4E4F534A:
            spans = _animation_spans(bytes(out[begin:end]))
            out[begin:end] = mask_gltf(bytes(out[begin:end]), names)
        else:
            keep = spans.get(0, []) if kind == 0x004E4942 else []
            out[begin:end] = blank_but(bytes(out[begin:end]), keep)
        at = end
    return bytes(out)


def _animation_spans(text: bytes) -> dict[int, list[tuple[int, int]]]:
    """Find what of each buffer animations and skins are made of; nothing, where the JSON can't be read."""
    spans: dict[int, list[tuple[int, int]]] = {}
    try:
        document = json.loads(text)
        accessors, views = document.get("accessors", []), document.get("bufferViews", [])
        wanted = {skin.get("inverseBindMatrices") for skin in document.get("skins", [])}
        for animation in document.get("animations", []):
            wanted |= {sampler.get(end) for sampler in animation.get("samplers", []) for end in ("input", "output")}
        for index in wanted - {None}:
            accessor = accessors[index]
            sparse = accessor.get("sparse", {})
            for view in (accessor, sparse.get("indices", {}), sparse.get("values", {})):
                if "bufferView" in view:
                    place = views[view["bufferView"]]
                    begin = place.get("byteOffset", 0)
                    spans.setdefault(place.get("buffer", 0), []).append((begin, begin + place["byteLength"]))
    except (ValueError, TypeError, KeyError, IndexError, AttributeError, RecursionError):
        # A document that is broken here is refused for that, before its buffers count.
        return {}
    return spans


def blank_but(data: bytes, keep: list[tuple[int, int]] | tuple[()]) -> bytes:
    r"""Make all bytes zero but those in some spans.

    Examples
    --------
    >>> blank_but(b"abcdef", [(1, 3)])
    b'\x00bc\x00\x00\x00'
    """
    out = bytearray(len(data))
    for begin, end in keep:
        if 0 <= begin <= end <= len(data):
            out[begin:end] = data[begin:end]
    return bytes(out)


def buffers_beside(text: bytes) -> dict[int, tuple[str, Spans]]:
    """Name by their number the files beside a glTF that hold its buffers, and what of each animations are made of."""
    try:
        document = json.loads(text)
        spans = _animation_spans(text)
        named = {index: one.get("uri") for index, one in enumerate(document.get("buffers", []))}
    except (ValueError, TypeError, AttributeError, RecursionError):
        return {}
    return {
        index: (unquote(uri), spans.get(index, []))
        for index, uri in named.items()
        if isinstance(uri, str) and not uri.startswith("data:")
    }


def _blank_base64(text: bytes, keep: list[tuple[int, int]] | tuple[()]) -> bytes:
    try:
        return base64.b64encode(blank_but(base64.b64decode(text, validate=True), keep))
    except binascii.Error:
        # Where its padding stands may be what is wrong with it.
        return re.sub(rb"[^=]", b"A", text)


def mask_fbx(data: bytes, names: StandIns) -> bytes:
    """Replace the texts of a binary FBX; meshes and embedded files in it are made zero."""
    out = bytearray(data)
    known = words_of_modules(*FBX_MODULES)
    version = int.from_bytes(data[23:27], "little")
    head = struct.Struct("<QQQB" if version >= 7500 else "<IIIB")
    at = _FBX_START
    # Records follow one another, those inside a record after its values: one walk meets them all.
    while at + head.size <= len(out):
        end, n_values, values_size, name_size = head.unpack_from(out, at)
        if end == 0:
            at += head.size
            continue
        begin = at + head.size + name_size
        stop = begin + values_size
        if not at < end <= len(out) or stop > end:
            break
        name = bytes(out[at + head.size : begin])
        out[at + head.size : begin] = names.in_words(name, known)
        if not _mask_values(out, begin, stop, n_values, name, names, known):
            break
        at = stop
    else:
        return bytes(out)
    # The foot, or what damage has left: no structure is known there.
    _mask_runs(out, at, len(out), names, known)
    return bytes(out)


_FBX_SIZES = {b"C": 1, b"B": 1, b"Y": 2, b"I": 4, b"F": 4, b"D": 8, b"L": 8}


def _mask_values(
    out: bytearray, at: int, stop: int, n_values: int, name: bytes, names: StandIns, known: frozenset[bytes]
) -> bool:
    """Mask the values of a record; False where they are not what they claim."""
    for _ in range(n_values):
        letter = bytes(out[at : at + 1])
        if letter in _FBX_SIZES:
            at += 1 + _FBX_SIZES[letter]
        elif letter in (b"S", b"R") and at + 5 <= stop:
            size = int.from_bytes(out[at + 1 : at + 5], "little")
            begin, end = at + 5, at + 5 + size
            if end > stop:
                return False
            out[begin:end] = names.in_words(bytes(out[begin:end]), known) if letter == b"S" else bytes(size)
            at = end
        elif letter in (b"f", b"d", b"l", b"i", b"b", b"c") and at + 13 <= stop:
            size = int.from_bytes(out[at + 9 : at + 13], "little")
            if at + 13 + size > stop:
                return False
            if not name.startswith(_FBX_KEYS):
                out[at + 13 : at + 13 + size] = bytes(size)
            at += 13 + size
        else:
            return False
        if at > stop:
            return False
    return True


def _mask_runs(
    out: bytearray, begin: int, end: int, names: StandIns, known: frozenset[bytes], *, least: int = 3
) -> None:
    """Mask what looks like text between two places."""
    found = _RUN if least == 3 else re.compile(rb"[\x20-\x7e\x80-\xff]{%d,}" % least)
    out[begin:end] = found.sub(lambda match: names.in_words(match[0], known), bytes(out[begin:end]))


def _middle_repeated(data: bytes, start: int, row: int, n_rows: int, *, first: int = 5, last: int = 2) -> bytes:
    """Let all rows between the first and the last ones be the first."""
    if n_rows <= first + last or row <= 0:
        return data
    begin, end = start + first * row, start + (n_rows - last) * row
    if end > len(data):
        return data
    return data[:begin] + data[start : start + row] * (n_rows - first - last) + data[end:]
