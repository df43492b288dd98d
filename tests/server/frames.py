"""Reads a message of the server's, as the page does."""

from __future__ import annotations

import json
import struct
from typing import Any

import numpy as np


def read(message: str | bytes) -> dict[str, Any]:
    """Return a message as plain values and arrays."""
    if isinstance(message, str):
        value: dict[str, Any] = json.loads(message)
        return value
    (length,) = struct.unpack_from("<I", message)
    value = json.loads(message[4 : 4 + length])
    for place in value.pop("arrays"):
        count = int(np.prod(place["shape"]))
        array = np.frombuffer(message, place["dtype"], count, 4 + length + place["offset"])
        value[place["name"]] = array.reshape(place["shape"])
    return value
