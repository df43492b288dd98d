"""The page's message types are what the server declares now, and what is written can be read."""

from __future__ import annotations

import importlib.util
import json
import struct
from pathlib import Path

import numpy as np
import pytest

from retime.errors import FormatError
from retime.project.dataclass_json import to_value
from retime.project.document import ClipFile, Document, Key
from retime.server import messages
from retime.server.message_coding import read_message, write_message

TOOLS = Path(__file__).resolve().parents[2] / "tools"


@pytest.mark.parametrize("name", ["make_messages", "make_options", "make_hosts"])
def test_the_page_speaks_the_language_of_the_server_and_shows_its_options(name) -> None:
    spec = importlib.util.spec_from_file_location(name, TOOLS / f"{name}.py")
    tool = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(tool)
    assert tool.PAGE.read_text(encoding="utf-8") == tool.page(), f"run python tools/{name}.py"


def test_a_message_with_arrays_is_one_aligned_frame() -> None:
    kept = messages.Kept("日本", np.array([0.0, 0.1, 1 / 3]), np.array([1e-300, np.nan, 2.0]))
    frame = write_message(kept)
    (length,) = struct.unpack_from("<I", frame)
    header = json.loads(frame[4 : 4 + length])
    assert (4 + length) % 8 == 0
    assert (header["type"], header["id"]) == ("kept", "日本")
    for place in header["arrays"]:
        assert place["offset"] % 8 == 0
        begin = 4 + length + place["offset"]
        array = np.frombuffer(frame, place["dtype"], int(np.prod(place["shape"])), begin)
        np.testing.assert_array_equal(array, getattr(kept, place["name"]))


def test_a_document_comes_back_as_it_was() -> None:
    document = Document(
        (ClipFile("a.bvh", first_frame=3),), keys=(Key("k", 1 / 3, 0.1, 2.0),), options={"length": "65%"}
    )
    text = json.dumps(
        {"type": "edit", "revision": 2, "gesture": "g", "done": True, "label": "move", "document": to_value(document)}
    )
    assert read_message(text) == messages.Edit(2, "g", True, "move", document)


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("[]", "expected a message"),
        ('{"type": 3}', "expected a message"),
        ('{"type": "fly"}', 'no message is called "fly"'),
        ('{"type": "undo"}', "undo: revision is missing"),
        ('{"type": "undo", "revision": 1.5}', "undo.revision: expected a whole number, found 1.5"),
        ('{"type": "undo", "revision": true}', "undo.revision: expected a number, found true"),
        ('{"type": "undo", "revision": 1, "sudo": 1}', 'undo: unknown field "sudo"'),
        ('{"type": "hello", "version": NaN}', "NaN is not a number"),
        ('{"type": "hello", "version": 1e999}', "the number 1e999 is too large"),
        ("{", "not JSON"),
        ("[" * 100_000, "deep"),
        ('{"type": "hello", "version": ' + "9" * 5000 + "}", "digits"),
    ],
)
def test_what_is_no_message_is_refused_with_its_place(text, says) -> None:
    with pytest.raises(FormatError, match="(?s)" + says.replace("[", r"\[").replace(".", r"\.")):
        read_message(text)
