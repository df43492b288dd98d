"""What is not interpolated is written as the table had it; what is, has decimals."""

from __future__ import annotations

import csv
from pathlib import Path

import numpy as np
import pytest

from retime.formats.registry import read, write
from retime.motion.signal import Signal
from retime.warp.apply import apply_warp
from retime.warp.curve import Warp

# What a column of names of things may hold, by what is odd about it.
SPELLED = {
    "plain": ["0", "1"],
    "with a point": ["0.0", "1.0"],
    "two decimals": ["2.00", "11.00"],
    "padded": ["007", "012"],
    "padded and not": ["7", "007", "07"],
    "beyond doubles": ["9007199254740993", "9007199254740992"],
    "twenty digits": ["12345678901234567890", "12345678901234567891", "-3"],
    "zeros with signs": ["-0", "0"],
    "signs": ["+1", "-1", "0"],
    "exponents": ["1e3", "2E3"],
    "dates": ["2026-01-02", "2026-02-01"],
    "days and slashes": ["1/2/2026", "12/11/2026"],
    "booleans": ["TRUE", "FALSE"],
    "booleans, small": ["false", "true"],
    "words": ["walk", "=run", "a,b", 'say "so"'],
}


def write_rows(path: Path, rows: list[list[str]]) -> None:
    with path.open("w", newline="") as file:
        csv.writer(file, lineterminator="\n").writerows(rows)


def rows_of(path: Path) -> list[list[str]]:
    with path.open(newline="") as file:
        return list(csv.reader(file))


def table(rng: np.random.Generator, n_rows: int) -> tuple[list[str], list[list[str]]]:
    """Make held columns, in random order, each text of which is there several times, beside one that moves."""
    picked = [list(SPELLED)[i] for i in rng.permutation(len(SPELLED))]
    names = [f"{name.replace(',', '').replace(' ', '_')}_id" for name in picked]
    columns = [[SPELLED[name][i] for i in rng.permutation(n_rows) % len(SPELLED[name])] for name in picked]
    # A formula is written with an apostrophe, and this is how it is read too.
    columns = [[f"'{cell}" if cell.startswith("=") else cell for cell in column] for column in columns]
    x = [repr(float(value)) for value in rng.normal(size=n_rows)]
    body = [[f"{i / 30:.6f}", *cells, x[i]] for i, cells in enumerate(zip(*columns, strict=True))]
    return ["time", *names, "x"], body


@pytest.mark.parametrize("seed", range(6))
def test_held_columns_come_back_letter_by_letter(tmp_path: Path, seed: int) -> None:
    rng = np.random.default_rng(seed)
    head, body = table(rng, int(rng.integers(12, 60)))
    write_rows(tmp_path / "a.csv", [head, *body])
    signal = read(tmp_path / "a.csv")
    assert isinstance(signal, Signal)
    write(signal, tmp_path / "b.csv")
    assert rows_of(tmp_path / "b.csv") == [head, *body]
    # Retimed, each row has the cells of the frame that it shows.
    places = np.sort(rng.uniform(0, len(body) - 1, 40))
    write(signal.at(places / 30), tmp_path / "c.csv")
    shown = [body[int(np.floor(place + 0.5))] for place in places]
    assert [row[1:-1] for row in rows_of(tmp_path / "c.csv")[1:]] == [row[1:-1] for row in shown]


def test_gaps_stay_empty_beside_what_is_held(tmp_path: Path) -> None:
    write_rows(
        tmp_path / "a.csv",
        [["time", "take_id", "event", "n"], *[[f"{i / 10:.6f}", "" if i == 3 else "007", "0", "5"] for i in range(8)]],
    )
    with pytest.warns(match="kept gaps"):
        signal = read(tmp_path / "a.csv", gaps="keep")
    write(signal, tmp_path / "b.csv")
    assert (tmp_path / "b.csv").read_bytes() == (tmp_path / "a.csv").read_bytes()


def test_a_linear_column_is_whole_until_something_lies_between(tmp_path: Path) -> None:
    rows = [[f"{i / 10:.6f}", str(2 * i), f"{2 * i}.0", "-0", str(i % 2)] for i in range(11)]
    write_rows(tmp_path / "a.csv", [["time", "steps", "meters", "zero", "left"], *rows])
    signal = read(tmp_path / "a.csv")
    assert isinstance(signal, Signal)
    assert {str(kind) for kind in signal.kinds} == {"linear"}
    twice = apply_warp(signal, Warp([0.0, 2.0], [0.0, 1.0]), average=False)
    write(twice, tmp_path / "b.csv")
    half = apply_warp(signal, Warp([0.0, 0.5], [0.0, 1.0]), average=False)
    write(half, tmp_path / "c.csv")
    steps, meters, zero, left = zip(*[row[1:] for row in rows_of(tmp_path / "b.csv")[1:]], strict=True)
    # At every second frame of the half speed lies a whole number, and still a column is written one way.
    assert steps == tuple(map(str, range(21)))
    assert meters == tuple(f"{i}.0" for i in range(21))
    assert zero[0] == "-0"
    assert left[:4] == ("0.0", "0.5", "1.0", "0.5")
    assert [row[1:] for row in rows_of(tmp_path / "c.csv")[1:]] == [row[1:] for row in rows[::2]]


def test_ids_that_count_on_are_no_names(tmp_path: Path) -> None:
    rows = [[f"{i / 10:.6f}", f"{100 + 3 * i:06d}", str(2**53 + 4 * i)] for i in range(20)]
    write_rows(tmp_path / "a.csv", [["time", "height", "stamp"], *rows])
    signal = read(tmp_path / "a.csv")
    assert isinstance(signal, Signal)
    assert [str(kind) for kind in signal.kinds] == ["linear", "linear"]
    assert signal.at([0.05]).values[0, 0] == 101.5


def test_what_is_told_holds(tmp_path: Path) -> None:
    write_rows(
        tmp_path / "a.csv",
        [
            ["time", "level", "mark"],
            *[[f"{i / 10:.6f}", ["001", "005"][i // 5], ["1.0", "2.0"][i // 5]] for i in range(10)],
        ],
    )
    found = read(tmp_path / "a.csv")
    told = read(tmp_path / "a.csv", kinds={"level": "linear", "mark": "label"})
    assert isinstance(found, Signal)
    assert isinstance(told, Signal)
    assert [str(kind) for kind in found.kinds] == ["label", "linear"]
    assert [str(kind) for kind in told.kinds] == ["linear", "label"]
    assert told.at([0.45]).values[0, 0] == pytest.approx(3.0)
    write(told.at([0.0, 0.41, 0.46]), tmp_path / "b.csv")
    assert [row[2] for row in rows_of(tmp_path / "b.csv")[1:]] == ["1.0", "1.0", "2.0"]


def test_decimal_commas_become_points(tmp_path: Path) -> None:
    (tmp_path / "a.csv").write_text(
        "time;state;x\n" + "".join(f"0,{i};{'1,0' if i < 5 else '2,0'};{i},5\n" for i in range(10))
    )
    signal = read(tmp_path / "a.csv", decimal_comma=True)
    write(signal, tmp_path / "b.csv")
    assert [row[1] for row in rows_of(tmp_path / "b.csv")[1:]] == ["1.0"] * 5 + ["2.0"] * 5


def test_rows_behind_the_damage_are_not_looked_at(tmp_path: Path) -> None:
    rows = "".join(f"{i / 10},{'01' if i % 2 else '02'},{i}\n" for i in range(8))
    (tmp_path / "a.csv").write_text(f"time,state,x\n{rows}0.8,03,what\n0.9,04\n")
    with pytest.warns(match="8 whole rows were kept"):
        signal = read(tmp_path / "a.csv", repair=True)
    write(signal, tmp_path / "b.csv")
    assert [row[1] for row in rows_of(tmp_path / "b.csv")[1:]] == ["02", "01"] * 4


def test_columns_without_a_number_in_the_first_rows(tmp_path: Path) -> None:
    """What tells whole numbers from decimals are the first thousand rows; a label is looked at in all."""
    rows = [[f"{i / 100:.6f}", "1" if i < 1500 else "01", repr(i / 8)] for i in range(3000)]
    write_rows(tmp_path / "a.csv", [["time", "phase", "x"], *rows])
    write(read(tmp_path / "a.csv"), tmp_path / "b.csv")
    assert [row[1] for row in rows_of(tmp_path / "b.csv")[1:]] == [row[1] for row in rows]


def test_lines_of_delimiters_alone_are_no_rows(tmp_path: Path) -> None:
    """A .trc ends its rows with a tab, and programs leave lines of tabs between them."""
    head = (
        "PathFileType\t4\t(X/Y/Z)\ta.trc\nDataRate\tCameraRate\tNumFrames\tNumMarkers\tUnits\n100\t100\t3\t1\tmm\n"
        "Frame#\tTime\tA\t\t\t\n\t\tX1\tY1\tZ1\t\n\n"
    )
    rows = ["1\t0.00\t007\t2\t3\t\n", "\t\t\n", "2\t0.01\t008\t2\t3\t\n", "\t\t\t\t\t\t\n", "3\t0.02\t008\t4\t3\t\n"]
    (tmp_path / "a.trc").write_text(head + "".join(rows))
    clip = read(tmp_path / "a.trc")
    assert clip.values.tolist() == [[7, 2, 3], [8, 2, 3], [8, 4, 3]]
    write(clip, tmp_path / "a.csv")
    assert [line.split(",")[1:] for line in (tmp_path / "a.csv").read_text().splitlines()[1:]] == [
        ["7", "2", "3"], ["8", "2", "3"], ["8", "4", "3"],
    ]  # fmt: skip
