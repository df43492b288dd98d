"""What people type: the table that the page's tests run too, and what only Python can be given."""

from __future__ import annotations

import json
import math
from collections.abc import Callable
from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from retime.errors import OptionError
from retime.motion import grammar
from retime.motion.rate import parse_rate
from retime.motion.timecode import Timecode, counted_rate

TABLE = json.loads((Path(__file__).parent / "table.json").read_text(encoding="utf-8"))
FILM, NTSC = Fraction(24000, 1001), Fraction(30000, 1001)


def span_with_open_end(text: str) -> list[float | None]:
    return [None if end == math.inf else end for end in grammar.parse_speeds(text)]


READERS: dict[str, Callable[..., Any]] = {
    "time": lambda text, rate: grammar.parse_time(text, Fraction(rate)),
    "length": lambda text, n_frames, rate: grammar.parse_length(text, n_frames, Fraction(rate)),
    "speed": grammar.parse_speed,
    "speeds": span_with_open_end,
    "span": lambda text, rate: list(grammar.read_span(text).at(Fraction(rate))),
    "lock": lambda text, rate: list(grammar.read_lock(text).at(Fraction(rate))),
    "key": lambda text, rate: list(grammar.read_key(text).at(Fraction(rate))),
    "frames": lambda text, n_frames, first_frame: list(grammar.parse_frame_range(text, n_frames, first_frame)),
    "rate": lambda text: str(parse_rate(text)),
    "share": grammar.parse_share,
    "number": grammar.parse_number,
}


def test_the_table_speaks_of_every_kind_both_ways() -> None:
    for kind in READERS:
        rows = [row for row in TABLE if row["kind"] == kind]
        assert any("value" in row for row in rows), kind
        assert any("error" in row for row in rows), kind
    assert {row["kind"] for row in TABLE} == set(READERS)


@pytest.mark.parametrize("row", TABLE, ids=lambda row: f"{row['kind']} {row['text']!r}")
def test_the_table(row: dict[str, Any]) -> None:
    given = {name: value for name, value in row.items() if name not in ("kind", "value", "error")}
    read = READERS[row["kind"]]
    if "error" in row:
        with pytest.raises(OptionError) as caught:
            read(**given)
        assert str(caught.value) == row["error"]
    else:
        assert read(**given) == row["value"]


class TestNumbers:
    @pytest.mark.parametrize("number", [3, 3.0, np.float64(3), np.int64(3), np.float32(3), Fraction(3)])
    def test_a_number_is_seconds(self, number) -> None:
        assert grammar.parse_time(number, Fraction(120)) == 3.0

    @pytest.mark.parametrize("number", [1e-7, 123456.789, 5e-324])
    def test_seconds_keep_their_bits(self, number: float) -> None:
        assert grammar.parse_time(number, FILM) == number

    @pytest.mark.parametrize("value", [float("nan"), float("inf"), True, None, 1j, "9" * 400, "9" * 5000 + "f", "١"])
    def test_what_is_no_time_is_refused(self, value) -> None:
        with pytest.raises(OptionError, match=r"expected a time such as 2\.5"):
            grammar.parse_time(value, Fraction(120))

    @pytest.mark.parametrize("length", [9.3, np.float64(9.3)])
    def test_a_float_length_is_seconds(self, length: float) -> None:
        assert grammar.parse_length(length, 1980, Fraction(120)) == 1116

    @pytest.mark.parametrize("length", [280, 0, -3, np.int64(280)])
    def test_a_whole_number_as_length_is_refused_with_what_to_write(self, length: int) -> None:
        with pytest.raises(OptionError, match=rf'write "{length}f" for frames, or "{length}s" for seconds'):
            grammar.parse_length(length, 1980, Fraction(120))

    @pytest.mark.parametrize("length", [True, float("nan"), None, "9" * 5000 + "%"])
    def test_what_is_no_length_is_refused(self, length) -> None:
        with pytest.raises(OptionError, match="expected a length such as 65%"):
            grammar.parse_length(length, 1980, Fraction(120))

    def test_a_small_number_is_a_speed_however_python_writes_it(self) -> None:
        assert grammar.parse_speed(1e-7) == 1e-7
        assert grammar.parse_speed(np.float32(0.5)) == 0.5

    @pytest.mark.parametrize("speed", [0, -1.0, float("nan"), float("inf"), True])
    def test_what_is_no_speed_is_refused(self, speed) -> None:
        with pytest.raises(OptionError, match="expected a playback speed"):
            grammar.parse_speed(speed)

    def test_lengths_are_checked_before_the_clip_is_known(self) -> None:
        for text in ("free", "65%", "8", "0.65", "00:08", "280f", "00:00:08;29"):
            assert grammar.check_length(text) == text
        for text in ("1:75", "280.5f", "65 percent", "", "1f", "0%", "0.001", "-5%"):
            with pytest.raises(OptionError):
                grammar.check_length(text)


class TestFrames:
    @given(st.integers(0, 10**7))
    def test_a_frame_is_as_exact_as_a_float_can_be(self, frame: int) -> None:
        assert grammar.parse_time(f"{frame}f", FILM) == float(frame / FILM)


class TestTimecode:
    @pytest.mark.parametrize("rate", [NTSC, 2 * NTSC])
    def test_drop_frame_numbers_frames_without_gap_or_repeat(self, rate: Fraction) -> None:
        # The literal twin: count the numbers one by one, and leave out those that the standard leaves out.
        counted = counted_rate(rate)
        frame = 0
        for minute in range(21):
            for second in range(60):
                for number in range(counted):
                    if second == 0 and number < counted // 15 and minute % 10:
                        continue
                    if second in (0, 1, 59):
                        written = Timecode(0, minute, second, number, True, "")
                        assert written.frame(rate) == frame
                    frame += 1

    def test_drop_frame_keeps_to_the_clock(self) -> None:
        # An hour of it is 3.6 ms short; without dropping it is 3.6 s long.
        assert abs(grammar.parse_time("01:00:00;00", NTSC) - 3600) < 0.004
        assert grammar.parse_time("01:00:00:00", NTSC) == pytest.approx(3603.6)

    def test_the_rate_matters_only_when_it_is_known(self) -> None:
        written = grammar.read_time("00:00:01:45")
        assert written.at(Fraction(60)) == Fraction(7, 4)
        with pytest.raises(OptionError, match="frames of a timecode go from 0 to 29 at 30 Hz"):
            written.at(Fraction(30))


NUMBERS_THAT_NOTHING_HOLDS = [10**400, -(10**400), 10**5000, Fraction(10**400), 1e308, "9" * 5000, "1e999999999", "²"]


@pytest.mark.parametrize("number", NUMBERS_THAT_NOTHING_HOLDS, ids=lambda number: type(number).__name__)
@pytest.mark.parametrize("kind", ["time", "length", "speed", "share", "number", "rate"])
def test_numbers_that_nothing_holds_are_refused(kind: str, number: Any) -> None:
    """Python writes out no number of thousands of digits, and makes no float of one of hundreds."""
    more: dict[str, Any] = {"time": {"rate": 30}, "length": {"rate": 30, "n_frames": 300}}.get(kind, {})
    with pytest.raises(OptionError) as caught:
        READERS[kind](number, **more)
    assert len(str(caught.value)) < 300
