"""Clocks of tables: what their names and numbers say, and that they come back as they were."""

from __future__ import annotations

import csv
import random
import re
import warnings
from datetime import UTC, datetime, timedelta
from fractions import Fraction
from pathlib import Path

import numpy as np
import pytest

from retime import apply_warp, resample
from retime.errors import FormatError, FormatWarning
from retime.formats import Limits, read, write
from retime.formats.tables.time_column import numeric_times
from retime.motion.clock import Clock
from retime.motion.signal import Signal
from retime.warp.curve import Warp


def table(folder: Path, name: str, times: list[str], **options: object) -> Signal:
    rows = [f'"{at}",{i}\n' for i, at in enumerate(times)]
    (folder / "a.csv").write_text(f'"{name}",x\n' + "".join(rows))
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", FormatWarning)
        signal = read(folder / "a.csv", **options)
    assert isinstance(signal, Signal)
    return signal


def written(folder: Path, signal: Signal) -> tuple[str, list[str]]:
    write(signal, folder / "b.csv", overwrite=True)
    with (folder / "b.csv").open(newline="") as file:
        rows = list(csv.reader(file))
    return rows[0][0], [row[0] for row in rows[1:]]


@pytest.mark.parametrize("sample", ["0.00 1", "", "1/0", "1e999", "0.5", "nan"])
def test_a_first_cell_that_is_not_what_was_read_is_written_anew(sample: str) -> None:
    # As of a damaged row, which was left out.
    column = numeric_times("time", np.array([0.25, 0.5, 0.75]), sample, None)
    assert (column.clock.start, column.clock.sample) == (Fraction(1, 4), "0.25")


@pytest.mark.parametrize(
    "name",
    [
        "time",
        "t",
        "Time (Seconds)",
        "Time [s]",
        "time_s",
        "# time",
        "timestamp",
        "Elapsed Time",
        "unix_time",
        "seconds",
    ],
)
def test_seconds_by_many_names(tmp_path: Path, name: str) -> None:
    signal = table(tmp_path, name, ["1.25", "1.27", "1.29", "1.31"])
    assert (signal.names, signal.rate, signal.start_time, signal.clock.form) == (("x",), 50, 1.25, "s")
    assert written(tmp_path, signal) == (name, ["1.250000", "1.270000", "1.290000", "1.310000"])


@pytest.mark.parametrize("name", ["reaction_time", "frame_time", "timeout", "temperature", "ms", "time_to_contact"])
def test_other_names_are_channels(tmp_path: Path, name: str) -> None:
    assert table(tmp_path, name, ["0", "1", "2"], rate=25).names == (name, "x")


@pytest.mark.parametrize(
    ("name", "ticks", "form"),
    [
        ("time_ms", 10**3, "ms"),
        ("Time (milliseconds)", 10**3, "ms"),
        ("timeUs", 10**6, "us"),
        ("timestamp_ns", 10**9, "ns"),
        # By their numbers alone.
        ("timestamp", 10**3, "ms"),
        ("t", 10**6, "us"),
        ("time", 10**9, "ns"),
    ],
)
@pytest.mark.parametrize("start", [0, 7, 1_700_000_000])
def test_parts_of_seconds(tmp_path: Path, name: str, ticks: int, form: str, start: int) -> None:
    times = [str(round((start + Fraction(i, 60)) * ticks)) for i in range(40)]
    signal = table(tmp_path, name, times)
    assert (signal.rate, signal.clock.form, signal.clock.start) == (60, form, start)
    assert signal.first_frame == (60 * start if start < 10**7 else 0)
    again_name, again = written(tmp_path, signal)
    assert (again_name, again) == (name, times)
    # A part begins when it begins; played at half its speed it begins as before, and so it does at another rate.
    assert written(tmp_path, signal[6:])[1] == times[6:]
    slow = apply_warp(signal, Warp([0.0, 2 * signal.end_time], [0.0, signal.end_time]))
    assert written(tmp_path, slow)[1][:40] == times
    assert written(tmp_path, resample(signal, 30))[1] == times[::2]


def test_a_name_says_more_than_numbers(tmp_path: Path) -> None:
    assert table(tmp_path, "time_s", ["0", "7", "14", "21"]).rate == Fraction(1, 7)
    assert table(tmp_path, "time_ms", ["0", "1", "2", "3"]).rate == 1000
    assert table(tmp_path, "time", ["0", "7", "14", "21"], kinds={"time": "time:s"}).rate == Fraction(1, 7)
    assert table(tmp_path, "stamp", ["0", "40", "80"], kinds={"stamp": "time:ms"}).rate == 25


def test_it_is_said_where_only_numbers_told_the_unit(tmp_path: Path) -> None:
    (tmp_path / "a.csv").write_text("time,x\n0,1\n33,2\n67,3\n100,4\n")
    with pytest.warns(FormatWarning, match="'time' is taken for milliseconds, by the size of its numbers"):
        read(tmp_path / "a.csv")


@pytest.mark.parametrize(
    ("times", "rate", "base"),
    [
        ([f"01:00:{s:02d}:{f:02d}" for s in (58, 59) for f in range(24)], 24, 24),
        ([f"23:59:59:{f:02d}" for f in range(25)] + [f"00:00:00:{f:02d}" for f in range(25)], 25, 25),
        ([f"10:00:0{s}:{f:02d}.652" for s in (4, 5) for f in range(0, 60, 2)], 30, 60),
        (
            [f"00:00:59;{f:02d}" for f in range(30)] + [f"00:01:00;{f:02d}" for f in range(2, 30)],
            Fraction(30000, 1001),
            30,
        ),
        (
            [f"00:09:59;{f:02d}" for f in range(30)] + [f"00:10:00;{f:02d}" for f in range(30)],
            Fraction(30000, 1001),
            30,
        ),
    ],
)
def test_timecodes(tmp_path: Path, times: list[str], rate: Fraction, base: int) -> None:
    signal = table(tmp_path, "Timecode", times)
    assert (signal.rate, signal.clock.base, signal.clock.form) == (rate, base, "timecode")
    assert written(tmp_path, signal) == ("Timecode", times)
    assert written(tmp_path, signal[20:])[1] == times[20:]
    again = read(tmp_path / "b.csv")
    assert (again.rate, again.n_frames) == (rate, len(times) - 20)


def test_a_timecode_of_another_rate_counts_parts_of_frames(tmp_path: Path) -> None:
    signal = table(tmp_path, "Timecode", [f"00:00:0{s}:{f:02d}" for s in (4, 5) for f in range(30)])
    _, times = written(tmp_path, resample(signal, 24))
    assert times[:3] == ["00:00:04:00.000", "00:00:04:01.250", "00:00:04:02.500"]
    assert read(tmp_path / "b.csv").rate == 24
    assert written(tmp_path, resample(signal, 15))[1][:3] == ["00:00:04:00", "00:00:04:02", "00:00:04:04"]


def test_what_a_timecode_counts_is_told_by_what_stands_beside_it(tmp_path: Path) -> None:
    rows = "".join(f"01:00:00:{i:02d},{i / 25:.2f},{i}\n" for i in range(12))
    (tmp_path / "a.csv").write_text("Timecode,time,x\n" + rows)
    signal = read(tmp_path / "a.csv")
    assert isinstance(signal, Signal)
    assert (signal.names, signal.rate, signal.clock.base) == (("x",), 25, 25)
    alone = "Timecode,x\n" + re.sub(r",\d\.\d\d,", ",", rows)
    (tmp_path / "a.csv").write_text(alone)
    with pytest.warns(FormatWarning, match="24 frames to a second are a guess"):
        assert read(tmp_path / "a.csv").rate == 24
    told = read(tmp_path / "a.csv", rate=25)
    assert isinstance(told, Signal)
    assert (told.rate, told.clock.base) == (25, 25)


@pytest.mark.parametrize("zone", ["", "Z", "+02:00"])
@pytest.mark.parametrize("between", ["T", " "])
def test_dates(tmp_path: Path, zone: str, between: str) -> None:
    start = datetime(2023, 12, 31, 23, 59, 59, 500_000, tzinfo=UTC)
    times = [
        (start + timedelta(milliseconds=40 * i)).strftime(f"%Y-%m-%d{between}%H:%M:%S.%f")[:-3] + zone
        for i in range(30)
    ]
    signal = table(tmp_path, "timestamp", times)
    assert (signal.rate, signal.clock.form, signal.start_time) == (25, "date", start.timestamp())
    assert written(tmp_path, signal) == ("timestamp", times)


def test_times_of_day(tmp_path: Path) -> None:
    times = ["23:59:59.90", "23:59:59.95", "00:00:00.00", "00:00:00.05"]
    signal = table(tmp_path, "Time", times)
    assert signal.rate == 20
    assert written(tmp_path, signal) == ("Time", times)


def test_text_that_is_no_time_is_named(tmp_path: Path) -> None:
    for times, says in (
        (
            ["10:00:00:00", "10:00:00:01", "soon"],
            "a.csv:4: column 'Timecode': expected a timecode, as in the first row",
        ),
        (["10:00:00:00", "10:00:00:00"], "a.csv:3: row 2: 'Timecode' goes from '10:00:00:00' to '10:00:00:00'"),
        (["soon", "later"], "a.csv:2: column 'Timecode': expected a number, found 'soon'"),
    ):
        with pytest.raises(FormatError) as caught:
            table(tmp_path, "Timecode", times)
        assert says in str(caught.value)


def test_one_clock_out(tmp_path: Path) -> None:
    rows = [f"{i},{i / 50},{1000 + 20 * i},{i * i},{i}\n" for i in range(20)]
    (tmp_path / "a.csv").write_text("Frame,time,time_ms,timestamp,x\n" + "".join(rows))
    signal = read(tmp_path / "a.csv")
    assert isinstance(signal, Signal)
    # A clock that goes otherwise is a channel: what it showed at that frame.
    assert (signal.names, signal.time_column, signal.rate) == (("timestamp", "x"), "time", 50)
    assert str(signal.kinds[0]) == "time:s"


def test_numbers_of_frames_come_back(tmp_path: Path) -> None:
    signal = table(tmp_path, "Frame", ["240", "241", "242", "243"], rate=120)
    assert (signal.first_frame, signal.clock.form) == (240, "frames")
    assert written(tmp_path, signal) == ("Frame", ["240", "241", "242", "243"])
    assert written(tmp_path, signal[1:])[1] == ["241", "242", "243"]


@pytest.mark.parametrize("seed", range(5))
def test_uneven_times_show_what_was_there_then(tmp_path: Path, seed: int) -> None:
    rng = np.random.default_rng(seed)
    times = np.cumsum(rng.uniform(0.01, 0.05, 60)) + 3
    turns = np.cumsum(rng.uniform(0, 40, 60)) % 360
    rows = [
        f"{at!r},{at * 2!r},{turn!r},{i // 20}\n"
        for i, (at, turn) in enumerate(zip(times.tolist(), turns.tolist(), strict=True))
    ]
    (tmp_path / "a.csv").write_text(
        "time,x,yaw_deg,state_id\n" + "".join(rows).replace("np.float64(", "").replace(")", "")
    )
    with pytest.warns(FormatWarning, match="uneven"):
        signal = read(tmp_path / "a.csv", rate=90)
    assert isinstance(signal, Signal)
    at = signal.start_time + np.arange(signal.n_frames) / 90
    assert (signal.start_time, signal.rate) == (times[0], 90)
    assert times[-1] - 1 / 90 < at[-1] <= times[-1]
    np.testing.assert_allclose(signal.values[:, 0], 2 * at, atol=1e-9)
    expected = np.interp(at, times, np.unwrap(turns, period=360))
    np.testing.assert_allclose((signal.values[:, 1] - expected + 180) % 360, 180, atol=1e-6)
    nearest = np.abs(at[:, None] - times).argmin(axis=1)
    assert np.mean(signal.values[:, 2] == nearest // 20) > 0.97


def test_dropped_frames_are_filled_in(tmp_path: Path) -> None:
    kept = [i for i in range(100) if i not in (20, 21, 50)]
    (tmp_path / "a.csv").write_text("time,x\n" + "".join(f"{i / 50:.2f},{i}\n" for i in kept))
    with pytest.warns(FormatWarning, match=r"0\.02 to 0\.06 s apart .*100 frames were made of 97 rows.* at 50 Hz"):
        signal = read(tmp_path / "a.csv")
    assert isinstance(signal, Signal)
    np.testing.assert_allclose(signal.values[:, 0], np.arange(100), atol=1e-9)


def test_a_signal_made_here_begins_at_its_first_frame() -> None:
    signal = Signal(("x",), np.zeros((4, 1)), 20, first_frame=10)
    assert (signal.start_time, signal[2:].start_time, signal.clock) == (0.5, 0.6, Clock())


@pytest.mark.parametrize("seed", range(4))
def test_damaged_times_end_in_a_signal_or_a_format_error(tmp_path: Path, seed: int) -> None:
    chance = random.Random(seed)
    whole = [
        "Timecode,time,x\n" + "".join(f"01:00:0{i // 4};{i % 4:02d}.5,{i / 4},{i}\n" for i in range(12)),
        "time,t,x\n" + "".join(f"2024-12-31T23:59:{50 + i}.25Z,{i},{i}\n" for i in range(9)),
        "timestamp,time_us,x\n" + "".join(f"{i * 33},{i * 33000},{i}\n" for i in range(9)),
    ]
    pieces = [b"9", b"-", b":", b";", b".", b"Z", b"e9", b"0" * 20, b"00", b"\n", b",", b"e-9", b"99:59:59:239"]
    outcomes = set()
    for _ in range(200):
        data = bytearray(chance.choice(whole).encode())
        for _ in range(chance.randint(1, 3)):
            at = chance.randrange(len(data) + 1)
            data[at : at + chance.choice([0, 0, 1, 4])] = chance.choice([b"", *pieces])
        (tmp_path / "a.csv").write_bytes(data)
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", FormatWarning)
            try:
                found = read(tmp_path / "a.csv", rate=chance.choice([None, 30]), limits=Limits(frames=10_000))
                assert np.isfinite(found.values).all()
                # What is read can be written, and read.
                write(found, tmp_path / "b.csv", overwrite=True)
                again = read(tmp_path / "b.csv", rate=found.rate)
                assert again.values.tolist() == found.values.tolist()
                outcomes.add("signal")
            except FormatError:
                outcomes.add("error")
    assert outcomes == {"signal", "error"}


def test_frames_are_not_made_on_the_word_of_one_time(tmp_path: Path) -> None:
    """A time that is wrong by two days would make five million frames of four rows."""
    rows = [f"2026-03-0{day}T12:00:00.{tenth}Z,{tenth}\n" for day, tenth in ((1, 0), (1, 1), (3, 2), (3, 3))]
    (tmp_path / "a.csv").write_text("timestamp,x\n" + "".join(rows))
    with pytest.raises(FormatError, match=r"a\.csv:4: .*172800 s here.* made of 4 rows"):
        read(tmp_path / "a.csv", rate=30)
    # Nine hours off is as wrong, and a million frames of one column are hundreds of megabytes of text when written.
    (tmp_path / "c.csv").write_text("time,x\n00:00:01.5,1\n00:00:02.0,2\n09:00:02.5,3\n")
    with pytest.raises(
        FormatError, match=r"c\.csv:4: .*972031 frames of 2 columns \(0\.016 GB\) would be made of 3 rows"
    ):
        read(tmp_path / "c.csv", rate=30)
    # Long pauses between many rows are no such thing, and a rate as low as the times are makes few frames.
    with pytest.warns(FormatWarning, match="uneven"):
        assert read(tmp_path / "a.csv", rate=Fraction(1, 60)).n_frames == 2881
    times = [*range(200), *range(10_000, 10_200)]
    (tmp_path / "b.csv").write_text("time,x\n" + "".join(f"{at / 10},{at}\n" for at in times))
    with pytest.warns(FormatWarning, match="uneven"):
        assert read(tmp_path / "b.csv").n_frames == 10_200
