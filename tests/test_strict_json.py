"""JSON from strangers: what `json.loads` takes and no file may hold."""

from __future__ import annotations

import random

import pytest

from retime.errors import FormatError
from retime.strict_json import MAX_DEPTH, parse_json


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("[NaN]", "NaN is not a number that a document may hold"),
        ("[-Infinity]", "-Infinity is not a number"),
        ('{"a": 1e400}', "1e400 is too large"),
        ("[-1E+0400]", "-1E+0400 is too large"),
        (f"[{'9' * 400}.5]", "is too large"),
        ('["\\ud800"]', "half a letter"),
        ('{"a": [{"\\uDFFF": 1}]}', "half a letter"),
        ('"\\udc00\\ud83d"', "half a letter"),
        ("[" * 70 + "]" * 70, f"more than {MAX_DEPTH} deep"),
        (b"[1, \xff]", "UTF-8"),
    ],
)
def test_what_no_file_may_hold_is_refused(text: str | bytes, said: str) -> None:
    with pytest.raises(FormatError) as caught:
        parse_json(text)
    assert said in str(caught.value)


def test_what_looks_like_it_is_taken() -> None:
    assert parse_json('["\\ud83d\\ude00", "\\\\ud800", 1e300, 1e-400, "1e999"]') == [
        "😀",
        "\\ud800",
        1e300,
        0.0,
        "1e999",
    ]


def test_numbers_are_the_same_whether_large_ones_are_looked_for_or_not() -> None:
    draw = random.Random(3)
    numbers = [draw.uniform(-1, 1) * 10 ** draw.randint(-300, 300) for _ in range(200)]
    assert parse_json(str(numbers)) == numbers
    assert parse_json(str(numbers[:3])) == numbers[:3]
