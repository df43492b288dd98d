"""Rows of numbers at once: what the careful reader takes, the same bits, and nothing else; by every backend."""

from __future__ import annotations

import math
from decimal import Decimal

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from retime.formats.number_rows import parse_rows
from retime.kernels import BACKENDS, RowFormat, backend, compiled_available
from retime.motion.size import LARGEST
from tests.formats.test_number_text import NOT_NUMBERS, numbers
from tests.reference.number_rows import read_rows

here = [name for name in BACKENDS if name == "numpy" or compiled_available()]
# What most files hold, and what is just too long for that.
short_numbers = st.builds(
    lambda sign, whole, decimals: f"{sign}{whole}{decimals}",
    st.sampled_from(["", "-", "+"]),
    st.text("0123456789", min_size=1, max_size=10),
    st.just("") | st.text("0123456789", max_size=10).map(lambda digits: f".{digits}"),
)


def plain(delimiter: str = "", n_columns: int = 0, *, decimal_comma: bool = False, line_bytes: int = 1000) -> RowFormat:
    return RowFormat(n_columns, delimiter, decimal_comma, LARGEST, line_bytes)


def exact(value: float) -> tuple[float, float]:
    """A number with the sign of its zero."""
    return value, math.copysign(1, value)


@pytest.mark.parametrize("name", here)
@given(number=numbers | short_numbers, delimiter=st.sampled_from(["", ",", ";", "\t"]), after=st.integers(0, 40))
def test_a_number_is_read_to_the_last_bit(name: str, number: str, delimiter: str, after: int) -> None:
    # Decimal knows the exact value, and its conversion to float rounds correctly.
    expected = float(Decimal(number))
    # What follows tells whether many bytes may be looked at together, or only one at a time.
    text = f"7{delimiter or ' '}{number}\n".encode() + b"\n" * after
    table = backend(name).read_rows(text, plain(delimiter, 2))
    if name == "compiled" and expected == 0 and Decimal(number) != 0:
        # Below the smallest double: left to the careful reader.
        assert table is None
    else:
        assert table is not None
        assert table.shape == (1, 2)
        assert exact(table[0, 1]) == exact(expected)


@pytest.mark.parametrize("name", here)
@given(value=st.floats(-LARGEST, LARGEST), digits=st.integers(0, 25))
def test_every_double_comes_back(name: str, value: float, digits: int) -> None:
    text = " ".join([repr(value), f"{value:.17g}", f"{value:.{digits}e}", f"{value:+.{digits}E}"])
    table = backend(name).read_rows(text.encode(), plain())
    assert table is not None
    assert list(map(exact, table[0])) == [exact(float(word)) for word in text.split()]
    assert list(map(exact, table[0, :2])) == [exact(value)] * 2


@pytest.mark.parametrize("name", here)
@pytest.mark.parametrize("delimiter", ["", ",", ";", "\t"])
@pytest.mark.parametrize("token", NOT_NUMBERS)
def test_anything_else_is_refused(name: str, delimiter: str, token: str) -> None:
    if delimiter not in token or not delimiter:
        text = (delimiter or " ").join(["1", token, "3"]) + "\n" + (delimiter or " ").join("123")
        for after in ("", "\n" * 40):
            assert backend(name).read_rows((text + after).encode(), plain(delimiter, 3)) is None


@pytest.mark.parametrize("name", here)
@given(rows=st.lists(st.lists(numbers, min_size=3, max_size=3), min_size=1, max_size=4), data=st.data())
def test_a_table_with_any_white_space(name: str, rows: list[list[str]], data: st.DataObject) -> None:
    text = ""
    for row in rows:
        text += data.draw(st.sampled_from(["", " ", "\t "])) + data.draw(st.sampled_from([" ", "\t", "  "])).join(row)
        text += data.draw(st.sampled_from(["\n", "\r", "\r\n", " \n\n", "\r\r"]))
    table = backend(name).read_rows(text.encode(), plain())
    expected = [[float(number) for number in row] for row in rows]
    if "1e-400" not in text:
        assert table is not None
        assert table.tolist() == expected


@given(
    text=st.text(st.sampled_from("0123456789+-.eE,;\t \n\r_ni\u0661"), max_size=20),
    n_columns=st.integers(0, 3),
    delimiter=st.sampled_from(["", ",", ";", "\t"]),
    decimal_comma=st.booleans(),
    line_bytes=st.sampled_from([3, 1000]),
    after=st.sampled_from(["", "\n" * 40]),
)
def test_it_takes_no_more_and_no_less_than_the_careful_way(
    text: str, n_columns: int, delimiter: str, decimal_comma: bool, line_bytes: int, after: str
) -> None:
    text += after
    careful = read_rows(
        text.encode(), n_columns, delimiter=delimiter, decimal_comma=decimal_comma, line_bytes=line_bytes
    )
    decimal_comma = decimal_comma and delimiter != ","
    for name in here:
        rows = plain(delimiter, n_columns, decimal_comma=decimal_comma, line_bytes=line_bytes)
        table = backend(name).read_rows(text.encode(), rows)
        if table is not None:
            assert table.tolist() == careful
        elif name == "compiled" and careful is not None:
            # Numbers below the smallest double are all that it leaves to the careful way.
            assert any(0.0 in row for row in careful)
            assert "e" in text.lower()


@pytest.mark.parametrize("name", here)
@pytest.mark.parametrize("text", [b"", b" \n", b"1 2\n3\n", b"1\n2 3", b"1\x0b2\n", b"1\x0c2\n", b"1\xa02"])
def test_what_is_no_table(name: str, text: bytes) -> None:
    assert backend(name).read_rows(text, plain()) is None


@pytest.mark.parametrize("name", here)
@pytest.mark.parametrize("text", [b"1,2,\n", b",1,2\n", b"1,,2\n", b"1,2 3\n", b"1,2\n3\n", b",\n", b"1,2\n,\n"])
def test_an_empty_field_is_not_passed_over(name: str, text: bytes) -> None:
    assert backend(name).read_rows(text, plain(",")) is None


@pytest.mark.parametrize("name", here)
def test_a_line_that_is_too_long_is_left_to_the_careful_way(name: str) -> None:
    text = b"1 2\n" + b"3" * 50 + b" 4\n"
    assert backend(name).read_rows(text, plain(line_bytes=51)) is None
    assert backend(name).read_rows(text, plain(line_bytes=52)) is not None


@pytest.mark.parametrize("largest", [0.5, 1e10])
@pytest.mark.parametrize("name", here)
def test_numbers_are_no_larger_than_said(name: str, largest: float) -> None:
    text = f"{-largest!r}\n".encode()
    table = backend(name).read_rows(text, RowFormat(0, "", False, largest, 100))
    assert table is not None
    assert table.tolist() == [[-largest]]
    more = f"{float(np.nextafter(largest, np.inf))!r}\n".encode()
    assert backend(name).read_rows(more, RowFormat(0, "", False, largest, 100)) is None


def test_a_decimal_comma_is_taken_only_where_it_was_said() -> None:
    table = parse_rows(b"0,5 1.5 -,25e1 0,12345678901234567\n", decimal_comma=True)
    assert table is not None
    assert table.tolist() == [[0.5, 1.5, -2.5, 0.12345678901234567]]
    assert parse_rows(b"0,5\n") is None
    assert parse_rows(b"0,5,1\n", decimal_comma=True) is None
    # Where commas part the numbers they are no decimals.
    table = parse_rows(b"0,5\n", delimiter=",", decimal_comma=True)
    assert table is not None
    assert table.tolist() == [[0.0, 5.0]]


def test_blank_lines_may_follow_one_long_row() -> None:
    """The memory for what a text could hold is no more than its length says."""
    text = b"1 " * 2000 + b"\n" * 100_000
    table = parse_rows(text)
    assert table is not None
    assert table.shape == (1, 2000)


@pytest.mark.skipif(not compiled_available(), reason="the compiled kernels were not built")
@pytest.mark.parametrize("seed", range(12))
def test_several_threads_read_what_one_reads(monkeypatch: pytest.MonkeyPatch, seed: int) -> None:
    generator = np.random.default_rng(seed)
    ending = ["\n", "\r\n", "\r"][seed % 3]
    rows = generator.normal(scale=50, size=(8000, 9)).round(6).tolist()
    lines = [" ".join(map(repr, row)) for row in rows]
    # Blank lines, in long runs too; then, in one of two texts, a line that is no row.
    for place in generator.integers(0, len(lines), size=3).tolist():
        lines.insert(place, "\n" * int(generator.integers(1, 5000)))
    whole = seed % 2 == 0
    if not whole:
        lines.insert(int(generator.integers(0, len(lines))), "1 2 3")
    text = ending.join(lines).encode()
    for threads in (1, 2, 3, 7):
        monkeypatch.setenv("RETIME_THREADS", str(threads))
        table = backend("compiled").read_rows(text, plain("", 9, line_bytes=1 << 20))
        assert (table is not None and table.tolist() == rows) if whole else table is None
