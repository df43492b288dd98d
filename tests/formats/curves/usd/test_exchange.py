"""Messages with a process that may die, or say anything."""

from __future__ import annotations

import struct
from io import BytesIO

import numpy as np
import pytest

from retime.errors import FormatError
from retime.formats.curves.usd.exchange import Message, receive, send


def sent(message: Message) -> bytes:
    pipe = BytesIO()
    send(message, pipe)
    return pipe.getvalue()


def test_a_message_arrives_as_it_was_sent() -> None:
    arrays = {
        "a": np.arange(6.0).reshape(2, 3),
        "none": np.zeros((0, 3)),
        "b": np.arange(4, dtype=np.int64),
        "c": np.arange(12, dtype=np.float32).reshape(3, 4)[:, ::2],
    }
    facts = {"names": ["é", "\x00"], "rate": [30000, 1001], "deep": {"none": None}}
    data = sent(Message(facts, arrays, {"": b"\x00\xff" * 5, "b": b""}))
    pipe = BytesIO(data * 2)
    for _ in range(2):
        found = receive(pipe, 1000)
        assert found is not None
        assert found.facts == facts
        assert found.files == {"": b"\x00\xff" * 5, "b": b""}
        assert {name: array.tolist() for name, array in found.arrays.items()} == {
            name: array.tolist() for name, array in arrays.items()
        }
    assert receive(pipe, 1000) is None


def test_what_is_no_message_is_refused() -> None:
    data = sent(Message({"x": 1}, {"a": np.zeros(4)}, {"f": b"abc"}))
    for size in range(1, len(data)):
        with pytest.raises(FormatError):
            receive(BytesIO(data[:size]), 1000)
    with pytest.raises(FormatError, match="the limit is 34"):
        receive(BytesIO(data), 34)
    assert receive(BytesIO(data), 35) is not None
    with pytest.raises(FormatError):
        receive(BytesIO(b"x" + data[1:]), 1000)


@pytest.mark.parametrize(
    "header",
    [
        "[]",
        "{}",
        '{"facts": [], "arrays": [], "files": []}',
        '{"facts": {}, "arrays": [["a", "|O8", [1]]], "files": []}',
        '{"facts": {}, "arrays": [["a", "<f8", [-1]]], "files": []}',
        '{"facts": {}, "arrays": [["a", "<f8", [true]]], "files": []}',
        '{"facts": {}, "arrays": [["a", "<f8", [1099511627776]]], "files": []}',
        '{"facts": {}, "arrays": [["a", "<f8", [1, 1, 1, 1, 1]]], "files": []}',
        '{"facts": {}, "arrays": [], "files": [["f", 1.5]]}',
        '{"facts": {}, "arrays": [], "files": [["f", 4611686018427387904]]}',
        '{"facts": {}, "arrays": {}, "files": []}',
        '{"facts": {"a": NaN}, "arrays": [], "files": []}',
    ],
)
def test_a_header_that_makes_no_sense_is_refused(header: str) -> None:
    data = struct.pack("<8sQ", b"retimex1", len(header)) + header.encode()
    with pytest.raises(FormatError):
        receive(BytesIO(data + bytes(64)), 1 << 20)


def test_numbers_that_are_none_are_not_sent_as_facts() -> None:
    with pytest.raises(ValueError, match="JSON"):
        sent(Message({"x": float("nan")}))
