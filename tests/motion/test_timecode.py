from __future__ import annotations

from fractions import Fraction

import pytest
from hypothesis import given
from hypothesis import strategies as st

from retime.errors import OptionError
from retime.motion.timecode import parse_frame_range, parse_length, parse_time

FILM = Fraction(24000, 1001)


class TestTimes:
    @pytest.mark.parametrize(
        ("text", "seconds"),
        [
            ("2.5", 2.5),
            ("2.5s", 2.5),
            (" 2.5 s ", 2.5),
            (".5", 0.5),
            ("-1.5", -1.5),
            ("120f", 1.0),
            ("0f", 0.0),
            ("-12 f", -0.1),
            ("1:02.5", 62.5),
            ("0:00.040", 0.04),
            ("90:00", 5400.0),
            ("1:01:01.25", 3661.25),
            (3, 3.0),
            (1e-7, 1e-7),
        ],
    )
    def test_seconds_frames_and_clocks(self, text, seconds: float) -> None:
        assert parse_time(text, Fraction(120)) == seconds

    @given(st.integers(0, 10**7))
    def test_a_frame_is_as_exact_as_a_float_can_be(self, frame: int) -> None:
        assert parse_time(f"{frame}f", FILM) == float(frame / FILM)

    @pytest.mark.parametrize(
        "text",
        [
            "",
            "s",
            "f",
            "1.5f",
            "1h",
            "1e3",
            "nan",
            "inf",
            float("nan"),
            float("inf"),
            "1:60",
            "1:99:00",
            "1:2:3:4",
            "-1:00",
            "2,5",
            "1_0",
            "١",
            "5 frames",
            "9" * 400,
            "9" * 5000 + "f",
            "1:" + "0" * 5000,
        ],
    )
    def test_what_is_no_time_is_refused(self, text) -> None:
        with pytest.raises(OptionError, match=r"expected a time such as 2\.5s, 120f or 1:02\.500"):
            parse_time(text, Fraction(120))


class TestLengths:
    @pytest.mark.parametrize(
        ("text", "frames"),
        [
            ("65%", 1287),
            ("100%", 1980),
            ("12.5 %", 248),
            ("150%", 2970),
            ("9.3s", 1116),
            ("280f", 280),
            (280, 280),
            (2, 2),
        ],
    )
    def test_shares_seconds_and_frames(self, text, frames: int) -> None:
        assert parse_length(text, 1980, Fraction(120)) == frames

    def test_seconds_are_counted_at_the_exact_rate(self) -> None:
        assert parse_length("1001s", 10, FILM) == 24000

    @pytest.mark.parametrize(
        "text", ["65", "", "%", "9.3", "1:02", "280 frames", "nan%", True, "9" * 5000 + "%", "1.5f"]
    )
    def test_what_is_no_length_is_refused(self, text) -> None:
        with pytest.raises(OptionError, match=r"expected a length such as 65%, 9\.3s or 280f"):
            parse_length(text, 1980, Fraction(120))

    @pytest.mark.parametrize("text", ["0%", "0.01%", "-65%", "1f", "-5f", "0s", "0.01s", 1, 0, -3])
    def test_fewer_than_two_frames_are_refused(self, text) -> None:
        with pytest.raises(OptionError, match="the output needs at least 2"):
            parse_length(text, 1980, Fraction(120))


class TestRanges:
    @pytest.mark.parametrize(
        ("text", "first_frame", "expected"),
        [
            ("1:10", 1, (0, 10)),
            ("0:9", 0, (0, 10)),
            ("2:2", 1, (1, 2)),
            (":5", 1, (0, 5)),
            ("4:", 0, (4, 10)),
            (":", 1, (0, 10)),
            (" 3:4 ", 0, (3, 5)),
            ("-5:-3", -5, (0, 3)),
        ],
    )
    def test_both_ends_count_by_the_files_own_numbers(self, text, first_frame, expected) -> None:
        assert parse_frame_range(text, 10, first_frame) == expected

    @pytest.mark.parametrize("text", ["", "5", "1-5", "a:b", "1:2:3", "-:5", "1.0:2", "٠:٣", "9" * 5000 + ":"])
    def test_what_is_no_range_is_refused(self, text: str) -> None:
        with pytest.raises(OptionError, match="expected a range of frames such as 1:1980"):
            parse_frame_range(text, 10)

    @pytest.mark.parametrize("text", ["0:5", "1:11", "5:4", "12:", ":0", "-1:3"])
    def test_a_range_outside_the_clip_is_refused_with_what_there_is(self, text: str) -> None:
        with pytest.raises(OptionError, match=r"are not inside the clip, whose frames are 1:10$"):
            parse_frame_range(text, 10, first_frame=1)
