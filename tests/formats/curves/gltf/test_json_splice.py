"""Changing a JSON text in place: the new values are read back, and nothing else moves."""

from __future__ import annotations

import json

from hypothesis import given
from hypothesis import strategies as st

from retime.formats.curves.gltf.json_splice import spliced

LEAVES = st.none() | st.booleans() | st.integers(-99, 99) | st.floats(allow_nan=False, allow_infinity=False) | st.text()
VALUES = st.recursive(LEAVES, lambda inner: st.lists(inner, max_size=4) | st.dictionaries(st.text(), inner, max_size=3))


@given(
    st.dictionaries(st.text(), VALUES, max_size=5),
    st.dictionaries(st.text(), VALUES | st.lists(VALUES), max_size=4),
    st.sampled_from([None, 0, 2]),
    st.booleans(),
)
def test_the_text_is_read_back_with_the_new_values(old, new, indent, ascii_only) -> None:
    text = json.dumps(old, indent=indent, ensure_ascii=ascii_only)
    assert json.loads(spliced(text, new)) == {**old, **new}


@given(st.dictionaries(st.text(), VALUES, max_size=5), st.sampled_from([None, 0, 2]))
def test_what_is_the_same_stays_to_the_letter(document, indent) -> None:
    text = json.dumps(document, indent=indent)
    assert spliced(text, document) == text


def test_elements_of_a_list_that_did_not_change_stay() -> None:
    text = '{"a": [ {"x": 1.50}, {"x":2e0} , 3 ], "b":\t0.10}'
    assert spliced(text, {"a": [{"x": 1.5}, {"x": 3}, 3, 4]}) == '{"a": [ {"x": 1.50}, {"x":3} , 3,4 ], "b":\t0.10}'
    assert spliced(text, {"a": [{"x": 1.5}]}) == '{"a": [ {"x": 1.50}], "b":\t0.10}'
    assert json.loads(spliced('{"a": []}', {"a": [1]})) == {"a": [1]}
