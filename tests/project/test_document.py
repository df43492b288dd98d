"""What is no document."""

from __future__ import annotations

import pytest

from retime.errors import FormatError
from retime.project.dataclass_json import from_value
from retime.project.document import (
    Document,
)


@pytest.mark.parametrize(
    ("change", "says"),
    [
        ({"clips": []}, "needs a clip"),
        ({"clips": [{"path": "a", "role": "follow"}]}, "the first clip"),
        ({"keys": [{"id": "k", "input_time": 0, "output_time": 0}] * 2}, "two keys have the same id"),
        ({"keys": [{"id": "", "input_time": 0, "output_time": 0}]}, "empty"),
        ({"keys": {}}, r"document.keys: expected a list, found an object"),
        ({"keys": [{"id": "k", "input_time": "0", "output_time": 0}]}, r"keys\[0\].input_time: expected a number"),
        ({"influence": True}, "expected a number, found true"),
        ({"length": 65}, "expected text, found 65"),
        ({"free_weight": "heavy"}, "expected one of neutral, sum"),
        ({"options": {"loop": 1}}, "options.loop: expected true or false"),
        ({"options": {"max_skip": 2.0}}, "expected a whole number"),
        ({"length": "\ud800"}, "half a letter"),
        ({"tempo": 1}, 'unknown field "tempo"'),
        ({"references": [{"counterparts": [{"clip": 1, "path": "b"}]}]}, "counterpart for clip 1, of 1 clips"),
        ({"references": [{"joints": [{"input": "a", "reference": "b"}] * 2}]}, "two joints for one of the clip's"),
    ],
)
def test_what_is_no_document_is_refused_with_its_place(change, says) -> None:
    value = {"clips": [{"path": "a.bvh"}], **change}
    with pytest.raises(FormatError, match=says):
        from_value(Document, value, "document")
