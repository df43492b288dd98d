"""Parquet tables: written as data sets of robots have them, and read from any program."""

from __future__ import annotations

import random
import subprocess
import sys
import warnings
from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import retime
from retime import FormatError, FormatWarning, Limits, MissingExtraError, Signal, joint_signal, read, write
from retime.formats import parquet, registry

try:
    import pyarrow as pa
    import pyarrow.parquet as pq
except ImportError:
    pa = None

needs_pyarrow = pytest.mark.skipif(pa is None, reason="pyarrow (the extra retime[parquet]) is not installed")


def table(path: Path, columns: dict[str, Any], **metadata: str) -> Path:
    made = pa.table(columns)
    pq.write_table(made.replace_schema_metadata(metadata or None), path)
    return path


def signal(path: Path, **options: Any) -> Signal:
    clip = read(path, **options)
    assert isinstance(clip, Signal)
    return clip


@needs_pyarrow
@pytest.mark.parametrize("rate", [30, "30000/1001", 120, "7/3"])
def test_a_signal_comes_back_as_it_was(tmp_path: Path, rate: Any) -> None:
    rng = np.random.default_rng(4)
    values = rng.normal(size=(50, 6))
    values[:, 2] = rng.integers(0, 2, 50)
    values[:, 3] = rng.integers(0, 3, 50)
    values[7, 0] = values[8, 3] = np.nan
    kinds = [
        "linear:m",
        "angle:rad",
        "label",
        retime.ChannelKind("label", words=("go", "wait", "")),
        "event",
        "time:ms",
    ]
    made = Signal(("Hips.x", "a", "b", "action", "=odd, name", "腰"), values, rate, "c", "", 7, kinds, "keep")
    write(made, tmp_path / "c.parquet")
    with pytest.warns(FormatWarning, match="kept gaps"):
        back = signal(tmp_path / "c.parquet", gaps="keep")
    assert (back.names, back.rate, back.first_frame, back.name) == (made.names, made.rate, 7, "c")
    assert [str(kind) for kind in back.kinds] == [str(kind) for kind in made.kinds]
    assert back.texts("action") == made.texts("action")
    others = [0, 1, 2, 4, 5]
    np.testing.assert_array_equal(back.values[:, others], made.values[:, others])
    with pytest.raises(FormatError, match="--gaps"):
        signal(tmp_path / "c.parquet")


@needs_pyarrow
def test_columns_are_those_of_a_robots_data_set(
    tmp_path: Path,
) -> None:
    clip = retime.sample()[100:160]
    write(joint_signal(clip), tmp_path / "walk.parquet")
    made = pq.read_table(tmp_path / "walk.parquet")
    assert made.column_names[:3] == ["timestamp", "frame_index", "Hips.x"]
    assert [str(field.type) for field in made.schema][:3] == ["float", "int64", "double"]
    assert made["frame_index"].to_pylist() == list(range(60))
    np.testing.assert_allclose(made["timestamp"].to_numpy(), np.arange(60) / 60, rtol=1e-7)
    np.testing.assert_array_equal(made["Hips.x"].to_numpy(), clip.positions[:, 0, 0])
    back = signal(tmp_path / "walk.parquet")
    assert (back.rate, back.first_frame) == (60, clip.first_frame)
    np.testing.assert_array_equal(back.values.reshape(60, -1, 3), clip.positions)


@needs_pyarrow
@pytest.mark.parametrize("fixed", [False, True])
def test_an_episode_of_a_robots_data_set(tmp_path: Path, fixed: bool) -> None:
    rng = np.random.default_rng(8)
    state, action = rng.normal(size=(40, 3)), rng.normal(size=(40, 2)).astype(np.float32)
    lists = pa.list_(pa.float64(), 3) if fixed else pa.list_(pa.float64())
    path = table(
        tmp_path / "episode_000003.parquet",
        {
            "observation.state": pa.array(state.tolist(), lists),
            "action": pa.array(action.tolist(), pa.list_(pa.float32())),
            "observation.image": pa.array([{"path": "a.png"}] * 40),
            "next.done": pa.array([False] * 39 + [True]),
            "timestamp": pa.array((np.arange(40) / 50).astype(np.float32)),
            "frame_index": pa.array(np.arange(40)),
            "episode_index": pa.array(np.full(40, 3)),
            "index": pa.array(np.arange(40) + 1234),
            "task_index": pa.array(np.zeros(40, dtype=np.int64)),
        },
    )
    with pytest.warns(FormatWarning, match=r"left out: observation\.image"):
        clip = signal(path)
    assert clip.rate == 50
    assert clip.names == (
        *(f"observation.state.{i}" for i in range(3)),
        *("action.0", "action.1", "next.done", "episode_index", "task_index"),
    )
    np.testing.assert_array_equal(clip.values[:, :3], state)
    np.testing.assert_array_equal(clip.values[:, 3:5], action)
    assert [str(kind) for kind in clip.kinds[5:]] == ["label"] * 3
    assert clip.values[:, 5].tolist() == [0] * 39 + [1]


@needs_pyarrow
def test_several_episodes_are_refused(tmp_path: Path) -> None:
    episodes = {"x": [1.0, 2, 3, 4], "timestamp": [0.0, 0.1, 0, 0.1], "episode_index": [4, 4, 5, 5]}
    with pytest.raises(FormatError, match=r"holds 2 episodes.*episode_index == 4"):
        read(table(tmp_path / "a.parquet", episodes))


@needs_pyarrow
@pytest.mark.parametrize("rate", [30, Fraction(30000, 1001), 50, 120, Fraction(24000, 1001)])
@pytest.mark.parametrize("kind", ["float32", "float64", "ms", "us", "ns"])
def test_the_rate_behind_times(tmp_path: Path, rate: Any, kind: str) -> None:
    times = np.arange(200) / float(rate)
    if kind.startswith("float"):
        column = pa.array((times + 2).astype(kind))
    else:
        start = 1_700_000_000
        ticks = {"ms": 10**3, "us": 10**6, "ns": 10**9}[kind]
        column = pa.array([start * ticks + round(at * ticks) for at in times], pa.timestamp(kind))
    clip = signal(table(tmp_path / "a.parquet", {"Time": column, "x": times}))
    assert clip.names == ("x",)
    assert float(clip.rate) == pytest.approx(float(rate), rel=1e-4 if kind == "ms" else 1e-6)
    if kind in ("float64", "us", "ns"):
        assert clip.rate == rate


@needs_pyarrow
def test_the_metadata_gives_way_to_times_that_disagree(tmp_path: Path) -> None:
    said = {"retime.rate": "30000/1001", "retime.first_frame": "5"}
    for step, rate in ((1001 / 30000, Fraction(30000, 1001)), (0.05, 20)):
        columns = {"timestamp": np.arange(3, 20) * step, "frame_index": np.arange(3, 20), "x": np.zeros(17)}
        clip = signal(table(tmp_path / "a.parquet", columns, **said))
        # Rows were cut off after it was written.
        assert (clip.rate, clip.first_frame) == (rate, 8)
    clip = signal(table(tmp_path / "b.parquet", {"x": [1.0, 2.0]}, **said))
    assert (clip.rate, clip.first_frame) == (Fraction(30000, 1001), 5)
    assert signal(tmp_path / "b.parquet", rate=12).rate == 12


@needs_pyarrow
@pytest.mark.parametrize(
    ("columns", "said", "message"),
    [
        ({"x": [1.0, 2]}, {}, "no rows of times .*--fps"),
        ({"t": [0.0], "x": [1.0]}, {}, "no rows of times .*--fps"),
        ({"t": [0.0, 0.1, 0.1], "x": [1.0, 2, 3]}, {}, "row 2: 't' goes from 0.1 to 0.1; times must increase.*--fps"),
        ({"t": [0.0, 0.1, 0.4], "x": [1.0, 2, 3]}, {}, "a step of .* where the mean is 0.2; times must be even.*--fps"),
        ({"t": [0.0, 33.0, 66.0], "x": [1.0, 2, 3]}, {}, "goes on by 33 a row, which can't be seconds.*--fps"),
        ({"t": [0.0, 0.1]}, {}, "no column beside those that count"),
        ({"x": [[1.0], [1.0, 2.0]]}, {}, "column 'x' holds lists of 1, 2 numbers"),
        ({"x": [[1.0], None]}, {}, "column 'x' holds lists of 1, nothing numbers"),
        ({"x": [2**53 + 1, 2]}, {}, "can't be read: Integer value 9007199254740993"),
        ({"x": [1.0, np.inf]}, {"retime.rate": "30"}, "channel 'x' at frame 1"),
        ({"x": [1.0, 2]}, {"retime.rate": "fast"}, "the metadata's rate: "),
        (
            {"x": [1.0, 2]},
            {"retime.rate": "30", "retime.first_frame": "one"},
            r"retime\.first_frame in the metadata is no number",
        ),
        ({"x": [b"a", b"b"]}, {}, "no row of numbers"),
        ({"x": np.zeros(0)}, {"retime.rate": "30"}, "no row of numbers"),
    ],
)
def test_what_is_no_motion_is_refused(tmp_path: Path, columns: Any, said: Any, message: str) -> None:
    path = table(tmp_path / "a.parquet", columns, **said)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", FormatWarning)
        with pytest.raises(FormatError, match=message) as caught:
            read(path)
    assert caught.value.path == str(path)


@needs_pyarrow
def test_two_columns_of_one_name_are_refused(tmp_path: Path) -> None:
    pq.write_table(pa.table([pa.array([1.0])] * 2, names=["x", "x"]), tmp_path / "a.parquet")
    with pytest.raises(FormatError, match="two columns are called 'x'"):
        read(tmp_path / "a.parquet", rate=30)


def test_what_is_no_parquet_is_refused_without_pyarrow(tmp_path: Path) -> None:
    for data, says in (
        (b"", "an empty file"),
        (b"time,x\n0,1\n", "something else"),
        (b"\x89PNG\r\n\x1a\n" + bytes(20), "a PNG picture"),
        (b"PAR1" + bytes(50), "ends too soon"),
    ):
        (tmp_path / "a.parquet").write_bytes(data)
        with pytest.raises(FormatError, match=f"expected a Parquet table, found .*{says}"):
            read(tmp_path / "a.parquet")


@needs_pyarrow
def test_limits(tmp_path: Path) -> None:
    path = table(tmp_path / "a.parquet", {"x": np.arange(1000.0), "y": np.zeros(1000)})
    for limits, says in (
        (Limits(frames=999), "Limits.frames"),
        (Limits(channels=1), "Limits.channels"),
        (Limits(inflated_bytes=15_000), "Limits.inflated_bytes"),
    ):
        with pytest.raises(FormatError, match=says):
            read(path, rate=30, limits=limits)
    # Two million zeros that are hardly a byte: what comes out counts too.
    small = table(tmp_path / "b.parquet", {"x": np.zeros(2_000_000)})
    assert small.stat().st_size < 100_000
    with pytest.raises(FormatError, match=r"Limits\.inflated_bytes"):
        read(small, rate=30, limits=Limits(inflated_bytes=10_000_000))


@needs_pyarrow
def test_damaged_files_are_refused_or_read_never_more(tmp_path: Path) -> None:
    write(joint_signal(retime.sample()[:30], rotations=True), tmp_path / "a.parquet")
    whole = (tmp_path / "a.parquet").read_bytes()
    chance = random.Random(9)
    refused = 0
    for _ in range(12):
        data = bytearray(whole)
        for _ in range(chance.randint(1, 8)):
            data[chance.randrange(4, len(data) - 4)] = chance.randrange(256)
        (tmp_path / "b.parquet").write_bytes(data)
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", FormatWarning)
            try:
                clip = read(tmp_path / "b.parquet")
            except FormatError:
                refused += 1
            else:
                assert isinstance(clip, Signal)
                assert np.isfinite(clip.values).all()
    assert refused > 2


@needs_pyarrow
def test_names_that_a_table_cant_hold_are_refused(tmp_path: Path) -> None:
    for names, says in (
        (("x", "timestamp"), "'timestamp' is the name of a column that counts"),
        (("x", "x"), "'x' is the name of two channels"),
        (("x", " "), "no name"),
    ):
        with pytest.raises(FormatError, match=says):
            write(Signal(names, np.zeros((4, 2))), tmp_path / "a.parquet")
    assert list(tmp_path.iterdir()) == []


@needs_pyarrow
def test_a_warped_table_is_written_as_one(tmp_path: Path) -> None:
    write(joint_signal(retime.sample()[:120], space="torso"), tmp_path / "a.parquet")
    shorter = retime.guided_warp(read(tmp_path / "a.parquet"), length="60%").apply()
    write(shorter, tmp_path / "b.parquet")
    back = signal(tmp_path / "b.parquet")
    assert (back.n_frames, back.rate) == (shorter.n_frames, 60)
    np.testing.assert_array_equal(back.values, shorter.values)


@needs_pyarrow
def test_labels_stay_whole_numbers_or_truths(tmp_path: Path) -> None:
    n = 40
    columns = {
        "timestamp": pa.array((np.arange(n) / 50).astype(np.float32)),
        "done": pa.array([i > 30 for i in range(n)]),
        "task_index": pa.array([i // 10 for i in range(n)], pa.int16()),
        "contact": pa.array([i % 3 // 2 for i in range(n)]),
        "state": pa.array([float(i // 10) for i in range(n)]),
        "count": pa.array(np.arange(n) * 3),
        "gap_id": pa.array([None if i == 4 else 7 for i in range(n)]),
    }
    with pytest.warns(FormatWarning, match="kept gaps"):
        clip = signal(table(tmp_path / "a.parquet", columns), gaps="keep")
    write(clip.at(np.arange(20) / 25), tmp_path / "b.parquet")
    made = pq.read_table(tmp_path / "b.parquet")
    types = {field.name: str(field.type) for field in made.schema}
    # What is interpolated is a double whatever came out, so that all files of a data set have the same columns.
    wanted = {"done": "bool", "task_index": "int64", "contact": "int64", "state": "double", "count": "double"}
    assert types | wanted | {"gap_id": "int64"} == types
    for name in ("done", "task_index", "contact", "state", "gap_id"):
        assert made[name].to_pylist() == columns[name].to_pylist()[::2]


def test_without_pyarrow_the_extra_is_named(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    for name in ("pyarrow", "pyarrow.parquet", "pyarrow.compute"):
        monkeypatch.setitem(sys.modules, name, None)
    (tmp_path / "a.parquet").write_bytes(b"PAR1" + bytes(10) + b"PAR1")
    with pytest.raises(MissingExtraError, match=r"a Parquet file needs pyarrow.*pip install 'retime\[parquet\]'"):
        read(tmp_path / "a.parquet")
    monkeypatch.setattr(registry.importlib.util, "find_spec", lambda name: None)
    with pytest.raises(MissingExtraError, match=r"retime\[parquet\]"):
        write(Signal(("x",), np.zeros((4, 1))), tmp_path / "b.parquet")


def test_pyarrow_is_imported_when_it_is_used() -> None:
    code = "import sys, retime.formats.parquet, retime; retime.sample(); sys.exit('pyarrow' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0


@needs_pyarrow
def test_the_time_of_the_first_row_is_kept(tmp_path: Path) -> None:
    (tmp_path / "a.csv").write_text("time,x\n2.235,1\n2.335,2\n2.435,4\n")
    before = signal(tmp_path / "a.csv")
    write(before, tmp_path / "a.parquet")
    back = signal(tmp_path / "a.parquet")
    assert (back.start_time, back.rate) == (before.start_time, 10)
    assert back.start_time == pytest.approx(2.235)
    cut = pq.read_table(tmp_path / "a.parquet").slice(1)
    pq.write_table(cut, tmp_path / "b.parquet")
    assert signal(tmp_path / "b.parquet").start_time == pytest.approx(2.335)


@needs_pyarrow
def test_a_file_that_ends_its_decoder_is_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A process that dies, as pyarrow's does of some damaged footers, is an error and nothing more."""
    path = table(tmp_path / "a.parquet", {"x": np.arange(9.0)})
    for child, says in (("import os; os.abort()", "ends the program that does"), ("exit(3)", "too much memory")):
        monkeypatch.setattr(parquet, "_CHILD", child)
        with pytest.raises(FormatError, match=says):
            read(path, rate=30)
    monkeypatch.setattr(parquet, "_CHILD", "import time; time.sleep(60)")
    monkeypatch.setattr(parquet, "_LEAST_SECONDS", 0.1)
    with pytest.raises(FormatError, match="not read after 0 s"):
        read(path, rate=30)
