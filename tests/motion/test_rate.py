"""Rates behind rounded decimals."""

from __future__ import annotations

from collections.abc import Callable
from decimal import ROUND_DOWN, ROUND_HALF_EVEN, Context
from fractions import Fraction

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from retime.errors import OptionError
from retime.motion.rate import parse_rate, rate_from_frame_time, rate_meant_by

FILM = Fraction(24000, 1001)
NTSC = Fraction(30000, 1001)
RATES = [Fraction(n) for n in (12, 15, 24, 25, 30, 48, 50, 60, 90, 100, 120, 144, 240)]
NTSC_RATES = [Fraction(n * 1000, 1001) for n in (24, 30, 48, 60, 120, 240)]
WHOLE = [12, 15, 24, 25, 30, 48, 50, 60, 72, 75, 90, 100, 120, 144, 150, 180, 200, 240, 250, 300, 360, 480, 500, 1000]
RARE_NTSC_RATES = [rate for n in WHOLE[:-1] if (rate := Fraction(n * 1000, 1001)) not in NTSC_RATES]
ROUNDINGS = [ROUND_HALF_EVEN, ROUND_DOWN]


def written(value: Fraction, digits: int, rounding: str) -> str:
    return f"{Context(prec=digits, rounding=rounding).divide(value.numerator, value.denominator):f}"


def meant(text: str, digits: int, value_of: Callable[[Fraction], Fraction]) -> Fraction:
    """The rate behind some digits, looked up: the plainest of which they are the digits."""
    value = Fraction(text)
    about = round(value_of(value))
    plain = [Fraction(n) for n in (*range(max(1, about - 3), about + 4), *WHOLE)]
    for rate in (*sorted(plain, key=lambda rate: rate not in WHOLE), *NTSC_RATES, *RARE_NTSC_RATES):
        same = value in {Fraction(written(value_of(rate), digits, rounding)) for rounding in ROUNDINGS}
        # A rare one is not made of digits that are farther from it than it is from its whole rate, by half.
        if same and (rate not in RARE_NTSC_RATES or abs(1 - value_of(value) / rate) < Fraction(1, 2002)):
            return rate
    return value_of(value)


class TestStandardRates:
    """Whole rates and those of television, from as few or as many digits as anybody writes."""

    @pytest.mark.parametrize("rounding", ROUNDINGS)
    @pytest.mark.parametrize("rate", [*map(Fraction, WHOLE), *NTSC_RATES, *RARE_NTSC_RATES], ids=str)
    def test_a_rate_comes_back_from_its_decimals(self, rate: Fraction, rounding: str) -> None:
        for digits in range(3, 18):
            text = written(rate, digits, rounding)
            assert parse_rate(text) == meant(text, digits, lambda rate: rate), text
            if digits > (5 if rate > 100 else 4):
                assert parse_rate(text) == rate, text

    @pytest.mark.parametrize("rounding", ROUNDINGS)
    @pytest.mark.parametrize("rate", [*map(Fraction, WHOLE), *NTSC_RATES, *RARE_NTSC_RATES], ids=str)
    def test_and_from_its_frame_time(self, rate: Fraction, rounding: str) -> None:
        for digits in range(3, 18):
            text = written(1 / rate, digits, rounding)
            if digits > 4 or rate in RATES:
                assert rate_from_frame_time(text) == rate, text

    @pytest.mark.parametrize("rounding", ROUNDINGS)
    @pytest.mark.parametrize("rate", [*NTSC_RATES, *RARE_NTSC_RATES], ids=str)
    def test_and_from_a_decimal_padded_or_turned_over(self, rate: Fraction, rounding: str) -> None:
        # 29.970000, and the frame time of a program that keeps the rate as 29.97.
        for places in (2, 3, 4):
            decimal = Fraction(written(rate, places + len(str(int(rate))), rounding))
            if decimal.denominator == 1 or abs(1 - decimal / rate) > Fraction(1, 2002):
                continue  # 11.98, cut from 11.988, is nearer to itself
            for digits in range(9, 18):
                assert parse_rate(written(decimal, digits, rounding).ljust(digits, "0")) == rate
                assert rate_from_frame_time(written(1 / decimal, digits, rounding)) == rate, (decimal, digits)
            assert rate_from_frame_time(repr(float(1 / decimal))) == rate
            assert parse_rate(float(decimal)) == rate

    @pytest.mark.parametrize(
        ("text", "rate"),
        [("89.91", Fraction(90000, 1001)), ("14.985", Fraction(15000, 1001)), ("29.97000", NTSC), ("23.976", FILM)],
    )
    def test_decimals_of_public_files(self, text: str, rate: Fraction) -> None:
        assert parse_rate(text) == rate

    @given(st.integers(1, 6), st.integers(1_000_000, 300_000_000))
    def test_what_is_none_of_them_stays_itself(self, places: int, millionths: int) -> None:
        value = round(Fraction(millionths, 10**6) * 10**places) / Fraction(10**places)
        text = f"{float(value):.{places}f}"
        near = [abs(1 - value / rate) for rate in (*NTSC_RATES, *RARE_NTSC_RATES)]
        # Common rates are known by one digit after the point; those two digits apart are none of them.
        assume(min(near) > (Fraction(1, 100) if places == 1 else Fraction(1, 2002)))
        assert parse_rate(text).denominator != 1001
        assert rate_from_frame_time(written(1 / value, 17, ROUND_HALF_EVEN)).denominator != 1001

    @pytest.mark.parametrize(
        "text", ["24.9", "14.9", "29.5", "29.99", "23.99", "59.99", "89.5", "25.97", "12.5", "37.5"]
    )
    def test_near_a_standard_rate_is_not_on_it(self, text: str) -> None:
        assert parse_rate(text) == Fraction(text)
        assert rate_from_frame_time(repr(1 / float(text))) == Fraction(text)


class TestRateFromFrameTime:
    @pytest.mark.parametrize("rounding", [ROUND_HALF_EVEN, ROUND_DOWN])
    @pytest.mark.parametrize("rate", RATES)
    def test_a_whole_rate_comes_back_from_its_rounded_or_cut_time(self, rate, rounding) -> None:
        texts = [written(1 / rate, digits, rounding) for digits in range(3, 18)]
        assert {text: rate_from_frame_time(text) for text in texts} == dict.fromkeys(texts, rate)

    @pytest.mark.parametrize("rounding", [ROUND_HALF_EVEN, ROUND_DOWN])
    @pytest.mark.parametrize("rate", NTSC_RATES)
    def test_so_does_a_rate_of_television(self, rate, rounding) -> None:
        texts = [written(1 / rate, digits, rounding) for digits in range(5, 18)]
        assert {text: rate_from_frame_time(text) for text in texts} == dict.fromkeys(texts, rate)

    @pytest.mark.parametrize(
        ("text", "rate"),
        [
            (".0083333", 120),  # the BVH conversions of the CMU library
            ("0.010000", 100),
            ("0.033333", 30),
            ("0.041667", 24),
            ("0.04170833", FILM),
            # 1 / 23.976, to as many digits as a program wrote.
            ("0.04170837504170837", FILM),
            ("0.041708375", FILM),
            ("0.0417084", FILM),
            ("3.33333e-2", 30),
            ("8.3333E-03", 120),
            ("+0.04", 25),
            (" 0.05\t", 20),
            ("1", 1),
            ("1.", 1),
            ("10", Fraction(1, 10)),
            ("0.0357", 28),
            # Few digits hold several whole rates: the usual one is meant.
            (".0083", 120),
            ("0.033", 30),
            ("0.017", 60),
            ("0.011", 90),
            # Half a unit decides between 30 (.0333) and 29.97 (.0334).
            ("0.0333", 30),
            ("0.0334", NTSC),
            # Neither a whole nor a usual rate is near: exactly what is written.
            ("0.03", Fraction(100, 3)),
            ("0.016", Fraction(125, 2)),
            ("0.032", Fraction(125, 4)),
        ],
    )
    def test_times_as_files_write_them(self, text: str, rate: int | Fraction) -> None:
        assert rate_from_frame_time(text) == rate

    @given(st.fractions(1, 1000, max_denominator=999))
    def test_a_simple_fraction_comes_back_from_many_digits(self, rate: Fraction) -> None:
        # Unless it is a decimal by which a rate of television is known, such as 23.976.
        near = min(abs(1 - rate / known) for known in (*NTSC_RATES, *RARE_NTSC_RATES))
        assume(near > Fraction(1, 2002) or 10**4 % rate.denominator)
        text = written(1 / rate, 18, ROUND_HALF_EVEN)
        assert rate_from_frame_time(text.ljust(18, "0") if "." in text else text) == rate

    @given(st.decimals(min_value="0.0001", max_value="10", places=6))
    def test_no_rate_is_further_from_the_written_one_than_its_digits_allow(self, time) -> None:
        rate = rate_from_frame_time(str(time))
        assert Fraction(time) - Fraction(1, 2 * 10**6) <= 1 / rate < Fraction(time) + Fraction(1, 10**6)

    @pytest.mark.parametrize(
        "text",
        [
            "",
            "0",
            "0.0",
            "-0.0333",
            "nan",
            "inf",
            "1e999",
            "1e-9",
            "1_0",
            "١",
            "0,0333",
            "1/30",
            "0x1",
            "30 fps",
            "1e",
            ".",
        ],
    )
    def test_what_is_no_frame_time_is_refused(self, text: str) -> None:
        with pytest.raises(ValueError, match=r"^expected a (positive decimal number|frame time from .*), found"):
            rate_from_frame_time(text)

    def test_digits_without_end_are_refused_and_not_repeated(self) -> None:
        with pytest.raises(ValueError, match="expected") as refusal:
            rate_from_frame_time("0." + "3" * 100_000)
        assert len(str(refusal.value)) < 200


class TestParseRate:
    @pytest.mark.parametrize(
        ("value", "rate"),
        [
            ("30", 30),
            ("30.0", 30),
            (30, 30),
            (30.0, 30),
            (Fraction(30000, 1001), NTSC),
            ("30000/1001", NTSC),
            ("29.97", NTSC),
            ("29.9", NTSC),
            (29.97, NTSC),
            (30000 / 1001, NTSC),
            (24000 / 1001, FILM),
            ("23.976", FILM),
            ("23.98", FILM),
            ("23.97", FILM),
            ("119.88", Fraction(120000, 1001)),
            ("59.9", Fraction(60000, 1001)),
            # Nobody who means 24, 30 or 60 writes these.
            ("24.1", Fraction(241, 10)),
            ("30.1", Fraction(301, 10)),
            ("59.5", Fraction(119, 2)),
            ("12.5", Fraction(25, 2)),
            (".5", Fraction(1, 2)),
            (np.float64(33.333333), Fraction(100, 3)),
            (29.999999999999996, 30),  # 30 after some arithmetic
            (" 1e2 ", 100),
        ],
    )
    def test_rates_as_people_write_them(self, value, rate: int | Fraction) -> None:
        assert parse_rate(value) == rate
        assert isinstance(parse_rate(value), Fraction)

    @given(st.fractions("0.001", 100_000, max_denominator=10**9))
    def test_a_fraction_is_taken_as_it_is_and_so_is_its_text(self, rate: Fraction) -> None:
        assert parse_rate(rate) == rate
        assert parse_rate(f"{rate.numerator}/{rate.denominator}") == rate

    @given(st.sampled_from(RATES + NTSC_RATES))
    def test_a_float_means_the_exact_rate_next_to_it(self, rate: Fraction) -> None:
        assert parse_rate(float(rate)) == rate

    @given(st.decimals(min_value="0.01", max_value="5000", places=2))
    def test_no_rate_is_further_from_the_written_one_than_its_digits_allow(self, value) -> None:
        rate = parse_rate(str(value))
        assume(Fraction(value).denominator != 1)
        assert Fraction(value) - Fraction(1, 200) <= rate < Fraction(value) + Fraction(1, 100)

    @pytest.mark.parametrize(
        "value",
        [
            "",
            "0",
            0,
            -30,
            "-30",
            "nan",
            float("nan"),
            float("inf"),
            "1e999",
            1e9,
            1e-9,
            Fraction(-1),
            Fraction(0),
            "0/5",
            "30/0",
            "1_0",
            "٣٠",
            "30 frames",
            "29,97",
            "1/2/3",
            True,
            "9" * 5000,
            f"{'9' * 5000}/1",
        ],
    )
    def test_what_is_no_rate_is_refused(self, value) -> None:
        with pytest.raises(OptionError, match=r"^expected a frame rate .*, found") as refusal:
            parse_rate(value)
        assert len(str(refusal.value)) < 200


@pytest.mark.parametrize(
    ("frame_time", "what", "rate"),
    [
        ("33.333", "milliseconds", Fraction(30)),
        ("33.3667", "milliseconds", Fraction(30000, 1001)),
        ("40", "milliseconds", Fraction(25)),
        ("16.666667", "milliseconds", Fraction(60)),
        ("8.333333", "milliseconds", Fraction(120)),
        ("30", "a rate", Fraction(30)),
        ("60.000000", "a rate", Fraction(60)),
        ("24", "a rate", Fraction(24)),
        ("120", "a rate", Fraction(120)),
    ],
)
def test_frame_times_that_are_none(frame_time: str, what: str, rate: Fraction) -> None:
    assert rate_meant_by(frame_time) == (what, rate)


@pytest.mark.parametrize("frame_time", ["1.0", "2", "7", "1234.5", "0.0333"])
def test_frame_times_that_may_be_meant(frame_time: str) -> None:
    assert rate_meant_by(frame_time) is None
