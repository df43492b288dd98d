"""How the messages of `retime.server.messages` are written.

A message is JSON text with its name as ``type``. Those that carry arrays travel from the server as one binary frame::

    uint32, little endian   length of the header in bytes
    header                  JSON: the message's plain fields, and ``arrays``: name, dtype, shape and offset of each
    arrays                  raw, little endian, C order, each beginning at a multiple of 8 bytes

Offsets count from the end of the header, which is padded with spaces so that this too lies at a multiple of 8.
"""

from __future__ import annotations

import dataclasses
import json
import re
import struct
from typing import Annotated, Any, get_args, get_origin, get_type_hints

import numpy as np

from retime.errors import FormatError
from retime.project.dataclass_json import from_value, to_value
from retime.server.messages import FROM_PAGE, FROM_SERVER, FROM_SERVER_WITH_ARRAYS, PageMessage, ServerMessage
from retime.strict_json import parse_json


def type_name(kind: type) -> str:
    """Return the ``type`` of a message: its class's name in snake case."""
    return re.sub(r"(?<!^)(?=[A-Z])", "_", kind.__name__).lower()


_PAGE_KINDS: dict[str, type] = {type_name(kind): kind for kind in FROM_PAGE}


def read_message(text: str | bytes) -> PageMessage:
    """Read a message of the page's.

    Raises
    ------
    FormatError
        Not a message; says where and why.

    Examples
    --------
    >>> read_message('{"type": "undo", "revision": 4}')
    Undo(revision=4)
    """
    value = parse_json(text)
    if not isinstance(value, dict) or not isinstance(value.get("type"), str):
        raise FormatError('expected a message: a JSON object with a "type"')
    name = value.pop("type")
    if name not in _PAGE_KINDS:
        raise FormatError(f"no message is called {json.dumps(name)[:60]}; there are {', '.join(_PAGE_KINDS)}")
    message: PageMessage = from_value(_PAGE_KINDS[name], value, name)
    return message


def array_fields(kind: type) -> dict[str, str]:
    """Return the fields of a message that are arrays, each with its dtype."""
    hints = get_type_hints(kind, include_extras=True)
    return {name: get_args(hint)[1] for name, hint in hints.items() if get_origin(hint) is Annotated}


_ARRAYS: dict[type, dict[str, str]] = {kind: array_fields(kind) for kind in (*FROM_SERVER, *FROM_SERVER_WITH_ARRAYS)}


def write_message(message: ServerMessage) -> str | bytes:
    """Write a message of the server's: text, or bytes where it carries arrays."""
    dtypes = _ARRAYS[type(message)]
    plain: dict[str, Any] = {"type": type_name(type(message))}
    plain |= {
        field.name: to_value(getattr(message, field.name))
        for field in dataclasses.fields(message)
        if field.name not in dtypes
    }
    if not dtypes:
        return json.dumps(plain, allow_nan=False, ensure_ascii=False)
    arrays = {
        name: np.ascontiguousarray(getattr(message, name), dtype=np.dtype(dtype)) for name, dtype in dtypes.items()
    }
    places, size = [], 0
    for name, array in arrays.items():
        places.append({"name": name, "dtype": dtypes[name], "shape": list(array.shape), "offset": size})
        size += -(-array.nbytes // 8) * 8
    header = json.dumps({**plain, "arrays": places}, allow_nan=False, ensure_ascii=False).encode()
    header += b" " * (-(4 + len(header)) % 8)
    parts = [struct.pack("<I", len(header)), header]
    for array in arrays.values():
        parts += [array.tobytes(), bytes(-array.nbytes % 8)]
    return b"".join(parts)
