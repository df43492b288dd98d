"""Rates behind rounded decimals."""

from __future__ import annotations

from decimal import ROUND_DOWN, ROUND_HALF_EVEN, Context
from fractions import Fraction

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from retime.errors import OptionError
from retime.motion.rate import parse_rate, rate_from_frame_time

FILM = Fraction(24000, 1001)
NTSC = Fraction(30000, 1001)
RATES = [Fraction(n) for n in (12, 15, 24, 25, 30, 48, 50, 60, 90, 100, 120, 144, 240)]
NTSC_RATES = [Fraction(n * 1000, 1001) for n in (24, 30, 48, 60, 120, 240)]


def written(value: Fraction, digits: int, rounding: str) -> str:
    return f"{Context(prec=digits, rounding=rounding).divide(value.numerator, value.denominator):f}"


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
        ],
    )
    def test_times_as_files_write_them(self, text: str, rate: int | Fraction) -> None:
        assert rate_from_frame_time(text) == rate

    @given(st.fractions(1, 1000, max_denominator=999))
    def test_a_simple_fraction_comes_back_from_many_digits(self, rate: Fraction) -> None:
        # Unless a rate of television lies within those digits, which none with so small a denominator does.
        assert rate_from_frame_time(written(1 / rate, 18, ROUND_HALF_EVEN)) == rate

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
            "30 fps",
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
