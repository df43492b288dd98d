"""What is no document."""

from __future__ import annotations

import pytest

from retime.errors import FormatError
from retime.project.dataclass_json import from_value
from retime.project.document import Document
from retime.search.options import OPTIONS


@pytest.mark.parametrize(
    ("change", "says"),
    [
        ({"clips": []}, "needs a clip"),
        ({"clips": [{"path": "a", "role": "follow"}]}, "the first clip"),
        ({"keys": [{"id": "k", "input_time": 0, "output_time": 0}] * 2}, "two keys have the same id"),
        ({"keys": [{"id": "", "input_time": 0, "output_time": 0}]}, "empty"),
        ({"keys": {}}, r"document.keys: expected a list, found an object"),
        ({"keys": [{"id": "k", "input_time": "0", "output_time": 0}]}, r"keys\[0\].input_time: expected a number"),
        ({"options": {"influence": True}}, "options.influence: expected a number, found true"),
        ({"options": {"length": 65}}, "options.length: expected text, found 65"),
        ({"options": {"free_weight": "heavy"}}, "options.free_weight: expected one of neutral, sum"),
        ({"options": {"loop": 1}}, "options.loop: expected true or false"),
        ({"options": {"max_skip": 2.0}}, "expected a whole number"),
        ({"options": {"length": "\ud800"}}, "half a letter"),
        ({"options": {"tempo": 1}}, 'options: unknown field "tempo"; it has length, '),
        ({"options": []}, "options: expected an object, found a list"),
        ({"method": "magic"}, "method: expected one of guided, align, linear, spline"),
        # Version 2 had it here.
        ({"length": "65%"}, 'unknown field "length"'),
        ({"tempo": 1}, 'unknown field "tempo"'),
        ({"flights": [{"id": "f", "start": 0, "end": 1}] * 2}, "two flights have the same id"),
        ({"flights": [{"id": "f", "start": 0}]}, r"flights\[0\]: end is missing"),
        ({"flights": [{"id": "f", "start": 0, "end": 1, "flies": 1}]}, "flies: expected true or false"),
        ({"markers": [{"id": "m", "time": 0}] * 2}, "two markers have the same id"),
        ({"markers": [{"id": "m", "time": 0, "on": "clip"}]}, "on: expected one of output, input"),
        ({"markers": [{"id": "m", "time": 0, "name": "n" * 201}]}, "the name of a marker is longer than 200 letters"),
        ({"work_area": {"start": 1, "end": 1}}, "a work area ends after it begins"),
        ({"work_area": {"start": 1}}, "work_area: end is missing"),
        ({"example": {"start": 1}}, "example: end is missing"),
        ({"repeat": "2"}, "repeat: expected a number"),
        ({"references": [{"counterparts": [{"clip": 1, "path": "b"}]}]}, "counterpart for clip 1, of 1 clips"),
        ({"references": [{"joints": [{"input": "a", "reference": "b"}] * 2}]}, "two joints for one of the clip's"),
    ],
)
def test_what_is_no_document_is_refused_with_its_place(change, says) -> None:
    value = {"clips": [{"path": "a.bvh"}], **change}
    with pytest.raises(FormatError, match=says):
        from_value(Document, value, "document")


def test_what_older_programs_did_not_know_is_not_asked_for() -> None:
    document = from_value(Document, {"clips": [{"path": "a.bvh"}]}, "document")
    assert (document.flights, document.example, document.repeat) == ((), None, 1.0)
    assert (document.markers, document.work_area) == ((), None)


def test_what_is_null_was_not_given() -> None:
    value = {"clips": [{"path": "a.bvh"}], "options": {"rate": None, "smoothness": 1, "length": "65%"}}
    document = from_value(Document, value, "document")
    assert document.options == {"length": "65%", "smoothness": 1.0}
    assert isinstance(document.options["smoothness"], float)


HELD = {
    "length": "65%",
    "rate": "29.97",
    "speeds": "1/2..2",
    "influence": 0.25,
    "number": 1.5,
    "whole": 2,
    "flag": True,
}


@pytest.mark.parametrize("option", OPTIONS, ids=lambda option: option.name)
def test_a_document_holds_every_option_and_refuses_another_kind(option) -> None:
    good = option.choices[-1].value if option.kind == "choice" else HELD[option.kind]
    value = {"clips": [{"path": "a.bvh"}], "options": {option.name: good}}
    assert from_value(Document, value, "document").options == {option.name: good}
    for wrong in ([], {}, 1 if isinstance(good, str) else "no such"):
        value["options"] = {option.name: wrong}
        with pytest.raises(FormatError, match=rf"^document\.options\.{option.name}: expected "):
            from_value(Document, value, "document")
