"""Tables of other programs, and clocks as people have them, each with its right answer."""

from __future__ import annotations

import csv
from fractions import Fraction
from pathlib import Path

import numpy as np
import pytest

from retime import Signal, read
from retime.errors import FormatWarning

CASES = Path(__file__).resolve().parents[3] / "shared" / "cases"

pytestmark = pytest.mark.skipif(not CASES.is_dir(), reason="the folder of cases, ../shared/cases, is not here")


def signal(path: Path, **options) -> Signal:
    clip = read(path, **options)
    assert isinstance(clip, Signal)
    return clip


def column(path: Path, name: str) -> list[str]:
    with path.open(newline="") as file:
        return [row[name] for row in csv.DictReader(file)]


def plain_numbers(path: Path, *, skip: int, columns: slice, delimiter: str = ",") -> np.ndarray:
    """Read the numbers of a file with nothing but Python's own reader of CSV."""
    with path.open(newline="") as file:
        rows = list(csv.reader(file, delimiter=delimiter))[skip:]
    return np.array([[float(cell) for cell in row[columns]] for row in rows if row])


@pytest.mark.parametrize(("case", "frames"), [("ms_timestamps", 90), ("ms_timestamps_10s", 300)])
def test_milliseconds(run, tmp_path, case, frames) -> None:
    path = CASES / f"{case}.csv"
    told = run("info", path)
    assert "30 Hz" in told.stdout
    assert f"{frames / 30:.3f} s" in told.stdout
    assert "clock     timestamp: milliseconds, from 0 s" in told.stdout
    assert "'timestamp' is taken for milliseconds" in told.stderr
    run("warp", path, "--length", "70%", "-o", "o.csv")
    times = column(tmp_path / "o.csv", "timestamp")
    assert times == [str(round(i * 1000 / 30)) for i in range(len(times))]
    assert len(times) == pytest.approx(0.7 * frames, abs=1)


def test_a_column_of_seconds_by_a_longer_name(run, tmp_path) -> None:
    run("warp", CASES / "time_seconds_column.csv", "--length", "70%", "-o", "o.csv")
    with (tmp_path / "o.csv").open(newline="") as file:
        names = next(csv.reader(file))
    assert names == ["Time (Seconds)", "qx", "qy", "qz", "qw", "px", "py", "pz"]
    times = [float(time) for time in column(tmp_path / "o.csv", "Time (Seconds)")]
    np.testing.assert_allclose(times, np.arange(len(times)) / 120, atol=1e-6)
    assert signal(tmp_path / "o.csv").rate == 120


def test_a_start_between_frames_is_kept(run, tmp_path) -> None:
    path = CASES / "start_time_lost.csv"
    run("convert", path, "o.csv")
    times = [float(time) for time in column(tmp_path / "o.csv", "time")]
    np.testing.assert_allclose(times, [float(time) for time in column(path, "time")], atol=1e-9)
    assert times[0] == 2.235
    run("convert", path, "--drop-first", "10", "p.csv")
    assert float(column(tmp_path / "p.csv", "time")[0]) == 2.335
    # Whatever is done to the timing, the clip begins when it began.
    run("warp", path, "--method", "linear", "--length", "150%", "-o", "w.csv")
    assert float(column(tmp_path / "w.csv", "time")[0]) == 2.235
    assert signal(path).start_time == 2.235


def test_timecodes(run, tmp_path) -> None:
    path = CASES / "livelink_timecode.csv"
    told = run("info", path).stdout
    assert "30 Hz" in told
    assert "Live Link Face" in told
    run("convert", path, "o.csv")
    assert column(tmp_path / "o.csv", "Timecode") == column(path, "Timecode")
    run("warp", path, "--method", "linear", "--length", "150%", "-o", "w.csv")
    longer = column(tmp_path / "w.csv", "Timecode")
    assert longer[: len(column(path, "Timecode"))] == column(path, "Timecode")
    assert signal(tmp_path / "w.csv").rate == 30


def test_uneven_times_are_sampled_where_they_stand(run, tmp_path) -> None:
    path = CASES / "uneven_times.csv"
    assert "at 30 Hz" in run("convert", path, "o.csv").stderr
    times = np.array([float(time) for time in column(tmp_path / "o.csv", "time")])
    before = np.array([float(time) for time in column(path, "time")])
    assert times[0] == before[0]
    np.testing.assert_allclose(np.diff(times), 1 / 30, atol=2e-6)
    for name in "xy":
        expected = np.interp(times, before, [float(value) for value in column(path, name)])
        np.testing.assert_allclose([float(value) for value in column(tmp_path / "o.csv", name)], expected, atol=1e-3)
    with pytest.warns(FormatWarning, match="at 60 Hz"):
        assert signal(path, rate=60).rate == 60


def test_a_motive_export(run) -> None:
    path = CASES / "motive_export.csv"
    told = run("info", path).stdout
    assert "Motive export" in told
    found = signal(path)
    assert found.names == (
        *(f"Prop1.rotation.{axis}" for axis in "xyzw"),
        *(f"Prop1.position.{axis}" for axis in "xyz"),
    )
    assert (found.rate, found.n_frames) == (120, 90)
    assert [kind.kind for kind in found.kinds] == ["quaternion"] * 4 + ["linear"] * 3
    expected = plain_numbers(path, skip=7, columns=slice(2, None))
    assert found.values.tolist() == expected.tolist()


def test_deeplabcut(run) -> None:
    path = CASES / "dlc_three_headers.csv"
    assert "DeepLabCut" in run("info", path, "--fps", "30").stdout
    found = signal(path, rate=30)
    assert found.names == ("snout.x", "snout.y", "snout.likelihood", "tail.x", "tail.y", "tail.likelihood")
    assert found.values.tolist() == plain_numbers(path, skip=3, columns=slice(1, None)).tolist()
    assert [kind.weighs for kind in found.kinds] == [True, True, False] * 2


def test_a_kinect_recording(run, tmp_path) -> None:
    path = CASES / "kinect_no_header_trailing_comma.csv"
    assert "Kinect" in run("info", path, "--fps", "30").stdout
    found = signal(path, rate=30)
    assert found.names == tuple(f"c{i}" for i in range(1, 17))
    assert found.values.tolist() == plain_numbers(path, skip=0, columns=slice(1, -1)).tolist()
    assert (found.n_frames, found.clock.form, found.start_time) == (60, "ms", 0.69)
    # Its own times say 33 ms a frame.
    assert signal(path).rate == Fraction(1000, 33)
    run("convert", path, "o.csv")
    assert column(tmp_path / "o.csv", "time_ms")[:3] == ["690", "723", "756"]


def test_a_spreadsheets_first_line() -> None:
    path = CASES / "excel_sep_line.csv"
    found = signal(path)
    assert (found.names, found.rate) == (("x", "y"), 30)
    assert found.values.tolist() == plain_numbers(path, skip=2, columns=slice(1, None), delimiter=";").tolist()


def test_a_row_of_units(run) -> None:
    path = CASES / "units_row.csv"
    assert "units" in run("info", path).stdout
    found = signal(path)
    assert (found.names, found.rate, [kind.unit for kind in found.kinds]) == (("x", "y"), 30, ["mm", "mm"])
    assert found.values.tolist() == plain_numbers(path, skip=2, columns=slice(1, None)).tolist()


def test_an_index_without_a_name(run) -> None:
    path = CASES / "pandas_index.csv"
    assert "an index" in run("info", path, "--fps", "30").stdout
    found = signal(path, rate=30)
    assert found.names == ("snout_x", "snout_y", "tail_x", "tail_y")
    assert found.values.tolist() == plain_numbers(path, skip=1, columns=slice(1, None)).tolist()
