"""A warp as a JSON document: the same bits back, and whatever is wrong refused."""

from __future__ import annotations

import itertools
import json

import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from retime.errors import FormatError
from retime.warp.curve import Warp
from retime.warp.keytime import Keytime


def same(a: Warp, b: Warp) -> bool:
    """Bit for bit, the sign of zero included."""
    return (
        a.output_times.tobytes() == b.output_times.tobytes()
        and a.input_times.tobytes() == b.input_times.tobytes()
        and repr(a.keytimes) == repr(b.keytimes)
        and (a.method, a.name) == (b.method, b.name)
    )


ANY_TIME = st.floats(-1e7, 1e7)


@settings(max_examples=40)
@given(
    st.lists(ANY_TIME, min_size=2, max_size=9, unique=True),
    st.data(),
    st.text(max_size=8),
    st.lists(st.builds(Keytime, input_time=ANY_TIME, output_time=ANY_TIME), max_size=3),
)
def test_json_gives_the_same_bits_back(
    output_times: list[float], data: st.DataObject, name: str, keytimes: list[Keytime]
) -> None:
    output_times = sorted(output_times)
    assume(all(b - a >= 1e-9 for a, b in itertools.pairwise(output_times)))
    n = len(output_times)
    input_times = data.draw(st.lists(ANY_TIME, min_size=n, max_size=n))
    warp = Warp(output_times, input_times, tuple(keytimes), method="gui\u00e9", name=name)
    text = warp.to_json()
    assert same(Warp.from_json(text), warp)
    assert same(Warp.from_json(text.encode()), warp)
    assert same(Warp.from_json(b"\xef\xbb\xbf" + text.encode()), warp)


def document(**changes: object) -> str:
    whole = {
        "format": "retime-warp",
        "version": 1,
        "method": "guided",
        "name": "walk",
        "keytimes": [[0, 0], [1, 2.5]],
        "output_times": [0, 0.5, 1],
        "input_times": [0, 0.25, 2.5],
    }
    whole.update(changes)
    return json.dumps({key: value for key, value in whole.items() if value is not ...})


def test_what_may_be_left_out_of_a_document() -> None:
    assert Warp.from_json(document(keytimes=..., method=..., name=...)).keytimes == ()
    assert Warp.from_json(document(note={"who": ["knows"]})).name == "walk"


def nested(depth: int) -> str:
    return "[" * depth + "]" * depth


BROKEN = {
    "empty": "",
    "spaces": "  \n",
    "not_json": "format: retime-warp",
    "another_format": document(format="otio"),
    "a_list": "[1, 2]",
    "a_number": "17",
    "null": "null",
    "no_version": document(version=...),
    "from_the_future": document(version=2),
    "version_as_text": document(version="1"),
    "version_true": document(version=True),
    "no_output_times": document(output_times=...),
    "times_null": document(input_times=None),
    "times_as_text": document(input_times="0 1 2"),
    "a_time_as_text": document(input_times=[0, "1", 2]),
    "a_time_true": document(input_times=[0, True, 2]),
    "a_time_null": document(input_times=[0, None, 2]),
    "times_nested": document(input_times=[[0, 1, 2]]),
    "an_object_for_times": document(input_times={"0": 1}),
    "lengths_differ": document(input_times=[0, 1]),
    "one_knot": document(input_times=[0], output_times=[0]),
    "no_knot": document(input_times=[], output_times=[]),
    "times_decrease": document(output_times=[0, 2, 1]),
    "nan": document(input_times=[0, float("nan"), 2]),
    "infinity": document(input_times=[0, float("inf"), 2]),
    "minus_infinity": document(output_times=[float("-inf"), 0, 2]),
    "beyond_doubles": document().replace("0.25", "1e999"),
    "a_whole_number_beyond_doubles": document().replace("0.25", "1" + "0" * 400),
    "thousands_of_digits": document().replace("0.25", "1" * 5000),
    "underscore": document().replace("0.25", "1_0"),
    "another_script": document().replace("0.25", "\u0661"),
    "hexadecimal": document().replace("0.25", "0x10"),
    "keytimes_as_object": document(keytimes={"0": 0}),
    "keytimes_null": document(keytimes=None),
    "a_keytime_of_one": document(keytimes=[[0]]),
    "a_keytime_of_four": document(keytimes=[[0, 1, 2, 3]]),
    "a_keytime_as_number": document(keytimes=[0, 1]),
    "a_keytime_as_text": document(keytimes=[["0", "1"]]),
    "a_keytime_true": document(keytimes=[[True, False]]),
    "a_keytime_nan": document(keytimes=[[0, float("nan")]]),
    "a_keytime_beyond_doubles": document().replace("2.5]]", "1e999]]"),
    "a_whole_keytime_beyond_doubles": document().replace("2.5]]", "1" + "0" * 400 + "]]"),
    "method_as_number": document(method=3),
    "name_null": document(name=None),
    "two_documents": document() * 2,
    "deep": nested(100_000),
    "deep_inside": document(note=...)[:-1] + f', "note": {nested(500)}}}',
    "deep_in_objects": document(note=...)[:-1] + ', "note": ' + '{"a":' * 500 + "1" + "}" * 500 + "}",
    "not_utf8": b"\xff\xfe{\x00}\x00",
    "utf8_cut": document(name="\u5de6").encode()[:60] + b"\xe5",
    "nul": b"\x00",
}


@pytest.mark.parametrize("text", BROKEN.values(), ids=BROKEN)
def test_broken_json_ends_in_a_format_error(text: str | bytes) -> None:
    with pytest.raises(FormatError):
        Warp.from_json(text)


@pytest.mark.parametrize(
    ("output_times", "input_times", "keytimes", "says"),
    [
        ([0.0, 1e300], [0.0, 2.0], [], "output_times: no clip has a time of 1e+300 s; the limit is 1e+07 s"),
        ([-1e308, 1e308], [-1e308, 1e308], [], "output_times: no clip has a time of -1e+308 s"),
        ([0.0, 1.0], [0.0, -1.1e7], [], "input_times: no clip has a time of -1.1e+07 s"),
        ([0.0, 1.0], [0.0, 1.0], [[0.5, 1e300]], "keytimes: no clip has a time of 1e+300 s"),
        ([0.0, 5e-324, 2.5], [0.0, 2.0, 2.0], [], "knots 0 and 1 are 4.94e-324 s apart; the least is 1e-09 s"),
        ([0.0, 1.0, 1.0 + 9e-10], [0.0, 2.0, 2.0], [], "knots 1 and 2 are 9e-10 s apart"),
    ],
)
def test_times_that_no_clip_can_have_are_refused_where_they_are_read_and_written(
    output_times: list[float], input_times: list[float], keytimes: list[list[float]], says: str
) -> None:
    with pytest.raises(FormatError) as refused:
        Warp.from_json(document(output_times=output_times, input_times=input_times, keytimes=keytimes))
    assert says in str(refused.value)
    # Python may make such a warp; it can't be saved as what nobody could read.
    keys = [Keytime(output_time=key[0], input_time=key[1]) for key in keytimes]
    with pytest.raises(FormatError) as refused:
        Warp(output_times, input_times, keys).to_json()
    assert says in str(refused.value)


def test_json_nested_to_the_limit_loads() -> None:
    assert Warp.from_json(document()[:-1] + f', "note": {nested(63)}}}').name == "walk"
    with pytest.raises(FormatError, match="64"):
        Warp.from_json(document()[:-1] + f', "note": {nested(64)}}}')


def test_every_truncation_ends_in_a_format_error() -> None:
    whole = document().encode()
    for length in range(len(whole)):
        with pytest.raises(FormatError):
            Warp.from_json(whole[:length])


@settings(max_examples=100)
@given(st.data())
def test_damaged_json_ends_in_a_warp_or_a_format_error(data: st.DataObject) -> None:
    damaged = bytearray(document().encode())
    for _ in range(data.draw(st.integers(1, 3))):
        place = data.draw(st.integers(0, len(damaged) - 1))
        damaged[place : place + data.draw(st.integers(0, 2))] = data.draw(st.binary(max_size=3))
    try:
        warp = Warp.from_json(bytes(damaged))
    except FormatError:
        return
    assert same(Warp.from_json(warp.to_json()), warp)


def test_a_place_in_the_file_is_named() -> None:
    with pytest.raises(FormatError, match="2:3: not JSON") as caught:
        Warp.from_json("{\n  oops")
    assert (caught.value.line, caught.value.column) == (2, 3)
