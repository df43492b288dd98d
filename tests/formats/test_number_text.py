"""Numbers in text: nothing but plain decimals gets in, each to the last bit, and what is written reads back."""

from __future__ import annotations

import math
import re
from decimal import Decimal

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from retime.formats.number_text import (
    NumberTextError,
    count_of,
    format_table,
    parse_count,
    parse_number,
    parse_numbers,
    show,
)
from retime.kernels import backend, compiled_available

# What a number is, said a second time and by other means: sign, digits around a point, exponent.
numbers = st.builds(
    lambda sign, whole, point, decimals, exponent: f"{sign}{whole}{point}{decimals if point else ''}{exponent}",
    st.sampled_from(["", "-", "+"]),
    st.text("0123456789", min_size=1, max_size=20),
    st.sampled_from(["", "."]),
    st.text("0123456789", max_size=20),
    st.sampled_from(["", "e5", "E-7", "e+0", "e-300", "E12"]),
) | st.sampled_from([".5", "-.5e1", "+.25", "5.", "-0", "0.0000000000000000000001", "1e-400", "9007199254740993"])
blanks = st.text(" \t\r\n", min_size=1, max_size=3)

NOT_NUMBERS = [
    *("", ".", "+", "-", "e5", ".e5", "+.e5", "1e", "1e+", "--1", "+-1", "1.2.3", "1..2", "1e2.5", "1e2e3"),
    *("nan", "NaN", "-nan", "inf", "-Infinity", "1.#QNAN", "1e999", "-1e999", "9" * 400),
    *(
        "1_0",
        "0x10",
        "0x1p3",
        "1d5",
        "1f",
        "1L",
        "1,000",
        "1'000",
        "١٢",
        "１２",
        "½",
        "−5",
        "1\x00",
        "\x001",
        "#1",
        "1#",
    ),
    *("0.0-7.5", "1+2", "1e5-3", "-1-2-3", "1-", "__import__('os')", "None", "True", "1;2", "(1)"),
]


@given(number=numbers)
def test_a_number_is_read_to_the_last_bit(number: str) -> None:
    # Decimal knows the exact value, and its conversion to float rounds correctly.
    expected = float(Decimal(number))
    token = number.encode()
    assert parse_number(token) == expected
    assert math.copysign(1, parse_number(token)) == math.copysign(1, expected)
    assert parse_numbers(token) == [expected]
    assert parse_number(token.replace(b".", b","), decimal_comma=True) == expected


@pytest.mark.parametrize("text", NOT_NUMBERS)
def test_anything_else_is_refused(text: str) -> None:
    token = text.encode()
    with pytest.raises(NumberTextError):
        parse_number(token)
    if text:
        with pytest.raises(NumberTextError) as caught:
            parse_numbers(b"1 \t2\n" + token + b" nan")
        assert (caught.value.offset, caught.value.index) == (5, 2)


def test_white_space_of_other_kinds_parts_numbers_too() -> None:
    assert parse_numbers(b"1\x0b2\x0c3") == [1, 2, 3]


def test_a_decimal_comma_is_taken_only_where_it_was_said() -> None:
    assert parse_numbers(b"0,5 1.5 -,25e1", decimal_comma=True) == [0.5, 1.5, -2.5]
    with pytest.raises(NumberTextError):
        parse_numbers(b"1,000,000", decimal_comma=True)


@pytest.mark.parametrize(
    ("token", "message"),
    [
        (b"0,5", "expected a number, found '0,5'; if this file writes decimals with a comma, say so (--decimal-comma"),
        (b"0.0-7.5", "numbers run together in '0.0-7.5': expected white space before '-7.5'"),
        (b"NaN", "expected a finite number, found 'NaN'"),
        (b"1e999", "expected a finite number, found '1e999', which is too large for one"),
        ("١٢".encode(), "expected a number in the digits 0-9, found '١٢'"),
        (b"x" * 100, f"expected a number, found '{'x' * 37}...'"),
    ],
)
def test_messages(token: bytes, message: str) -> None:
    with pytest.raises(NumberTextError, match="^" + re.escape(message)):
        parse_number(token)


def test_run_together_with_a_decimal_comma() -> None:
    with pytest.raises(NumberTextError, match="numbers run together in '0,0-7,5': expected white space before '-7,5'"):
        parse_number(b"0,0-7,5", decimal_comma=True)


@pytest.mark.parametrize(("token", "count"), [(b"0", 0), (b"+5", 5), (b"007", 7), (b"9" * 18, 10**18 - 1)])
def test_counts(token: bytes, count: int) -> None:
    assert parse_count(token) == count


def test_a_count_that_nothing_holds() -> None:
    assert parse_count(b"9" * 100_000) == 10**18


@pytest.mark.parametrize("token", [b"", b"-1", b"1.0", b"1e3", b"1_0", "٣".encode(), b" 1", b"0x1"])
def test_what_is_no_count(token: bytes) -> None:
    with pytest.raises(NumberTextError, match="expected a whole number of 0 or more"):
        parse_count(token)


@given(data=st.binary(max_size=300))
def test_showing_anything_is_one_short_line(data: bytes) -> None:
    shown = show(data)
    assert len(shown.splitlines()) == 1
    assert shown.isprintable()
    assert len(shown) < 400


@given(st.text("0123456789", min_size=1, max_size=400))
def test_a_count_in_text_is_read_exactly(digits: str) -> None:
    # Digit by digit, in another way than by int.
    value = 0
    for digit in digits:
        value = 10 * value + "0123456789".index(digit)
    assert count_of(digits) == min(value, 10**300)


@pytest.mark.parametrize("text", ["", "²", "٣", "1²", "-1", "+1", "1_0", "1.0", " 1", "1e3"])
def test_what_is_no_count_is_none(text: str) -> None:
    assert count_of(text) is None


def test_digits_without_end_are_a_count_that_nothing_has() -> None:
    assert count_of("9" * 5000) == count_of("1" + "0" * 10_000) == 10**300
    assert count_of("0" * 5000 + "7") == 7


finite = st.floats(allow_nan=False, allow_infinity=False)
usual = st.one_of(st.floats(-1e9, 1e9), st.floats(-1e-5, 1e-5), st.integers(-(10**9), 10**9).map(lambda n: n / 1e6))
below_a_billion = usual.filter(lambda number: abs(number) < 1e9) | st.sampled_from(
    [999999999.9999999, -0.0, 5e-7, 2.5e-6]
)


@given(values=arrays(np.float64, st.tuples(st.integers(0, 4), st.integers(1, 4)), elements=st.one_of(usual, finite)))
def test_what_is_written_reads_back(values: np.ndarray) -> None:
    text = format_table(values)
    rows = text.decode().split("\n")
    assert rows.pop() == ""
    assert [len(row.split(" ")) for row in rows] == [values.shape[1]] * len(values)
    for number, value in zip(text.split(), values.ravel().tolist(), strict=True):
        assert re.fullmatch(rb"-?(0|[1-9][0-9]*)\.[0-9]{6}", number)
        # Half a unit of the sixth decimal, and what a double of that size can't resolve.
        assert abs(Decimal(number.decode()) - Decimal(value)) <= Decimal("0.5e-6") + Decimal(abs(value)) / 2**52


@given(values=arrays(np.int64, (3, 5), elements=st.integers(-(10**14), 10**14)))
def test_six_decimals_come_back_as_they_were(values: np.ndarray) -> None:
    table = values / 1e6
    assert format_table(table).decode() == "".join(" ".join(f"{v + 0.0:.6f}" for v in row) + "\n" for row in table)


@pytest.mark.skipif(not compiled_available(), reason="the compiled kernels were not built")
@given(values=arrays(np.float64, st.tuples(st.integers(0, 4), st.integers(1, 4)), elements=below_a_billion))
def test_both_backends_write_the_same(values: np.ndarray) -> None:
    assert backend("compiled").write_rows(values) == backend("numpy").write_rows(values)


def test_rows_without_numbers_and_numbers_that_are_none_are_written_somehow() -> None:
    assert format_table(np.empty((2, 0))) == b"\n\n"
    assert format_table(np.array([[np.nan, 1.0], [np.inf, 1e300]])).startswith(b"nan 1.000000\ninf 1")


def test_zero_has_no_sign() -> None:
    assert format_table(np.array([[-0.0, -4e-7, -6e-7]])) == b"0.000000 0.000000 -0.000001\n"
