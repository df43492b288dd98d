"""CSV tables: exact rates from times, quirks and damage from files, names that no spreadsheet may run."""

from __future__ import annotations

import random
import re
import warnings
from fractions import Fraction
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from retime.errors import FormatError, FormatWarning, OptionError, OutputExistsError
from retime.formats import Limits, read, write
from retime.formats.tables import table_rows
from retime.motion.motion import Motion
from retime.motion.rate import parse_rate
from retime.motion.signal import Signal
from retime.motion.skeleton import Skeleton

CSV = Path(__file__).resolve().parents[1] / "data/csv"


def read_csv(path: Path, **options: object) -> Signal:
    signal = read(path, **options)
    assert isinstance(signal, Signal)
    return signal


def table(folder: Path, text: str, **options: object) -> Signal:
    (folder / "table.csv").write_text(text)
    return read_csv(folder / "table.csv", **options)


# Odd but legal


@pytest.mark.parametrize(
    ("name", "time_column"),
    [
        ("plain", "time"),
        ("crlf", "time"),
        ("cr_only_no_final_newline", "time"),
        ("byte_order_mark", "time"),
        ("utf_16", "time"),
        ("semicolons", "time"),
        ("tabs", "time"),
        ("blanks_around_fields", "time"),
        ("quoted", "time"),
        ("blank_lines", "time"),
        ("time_in_the_middle", "Seconds"),
        ("frame_counts_from_0", "t"),
        ("decimal_comma", "time"),
    ],
)
def test_odd_tables(name: str, time_column: str) -> None:
    signal = read_csv(CSV / f"{name}.csv", decimal_comma=name == "decimal_comma")
    assert signal.names == ("x", "y speed")
    assert signal.values.tolist() == [[1.0, -2.5], [1.5, -2.0], [2.25, 0.001]]
    assert (signal.rate, signal.time_column, signal.first_frame, signal.name) == (25, time_column, 0, name)


def test_names_in_quotes() -> None:
    signal = read_csv(CSV / "names_in_quotes.csv")
    assert signal.names == ("a, b", 'say "hi"', "two\nlines", "=SUM(A1)", "=x", "'quoted'")
    assert signal.values.tolist() == [[1, 2, 3, 4, 5, 6]] * 2


def test_names_in_latin_1() -> None:
    assert read_csv(CSV / "latin_1_name.csv").names == ("größe",)


def test_no_names_and_no_times() -> None:
    signal = read_csv(CSV / "no_names.csv", rate="29.97")
    assert signal.names == ("c0", "c1", "c2")
    assert signal.values.tolist() == [[0.5, 1, 2], [0.25, 3, 4]]
    assert (signal.rate, signal.time_column) == (Fraction(30000, 1001), "")
    assert read_csv(CSV / "one_column.csv", rate=10).values.tolist() == [[1], [2]]


# Times


@pytest.mark.parametrize(
    ("times", "rate"),
    [
        (["0", "0.033", "0.067", "0.1", "0.133"], 30),
        ([f"{i / 30:.2f}" for i in range(300)], 30),
        ([f"{int(i / 30 * 1000) / 1000}" for i in range(300)], 30),
        ([repr(i / 30) for i in range(300)], 30),
        ([repr(17.25 + i / 120) for i in range(300)], 120),
        ([repr(1.7e9 + i / 120) for i in range(300)], 120),
        ([f"{i * 1001 / 24000:.4f}" for i in range(100)], Fraction(24000, 1001)),
        ([f"{i / 24:.4f}" for i in range(100)], 24),
        (["0.50", "1.00", "1.50"], 2),
        (["0.0300", "0.0600", "0.0900"], Fraction(100, 3)),
        (["1e-3", "2e-3", "3E-3"], 1000),
        (["0", "1", "2", "3"], 1),
    ],
)
def test_the_rate_behind_times(tmp_path: Path, times: list[str], rate: Fraction) -> None:
    signal = table(tmp_path, "t,x\n" + "".join(f"{at},1\n" for at in times))
    assert signal.rate == rate


def test_times_may_tremble_by_a_hundredth_of_a_step(tmp_path: Path) -> None:
    rng = np.random.default_rng(3)
    times = np.arange(200) / 60 + rng.uniform(-0.004, 0.004, 200) / 60
    # Known so exactly, the trembling ends give the mean step of these rows and no rounder rate.
    rate = table(tmp_path, "t,x\n" + "".join(f"{at!r},1\n" for at in times.tolist())).rate
    assert float(rate) == pytest.approx(199 / (times[-1] - times[0]), rel=1e-12)
    times[100:] += 0.02 / 60
    with pytest.warns(FormatWarning, match=r"'t' are uneven, .* ends at line 102\); 200 frames were made of 200 rows"):
        assert table(tmp_path, "t,x\n" + "".join(f"{at!r},1\n" for at in times.tolist())).rate == 60


def test_a_given_rate_takes_the_rows_as_even() -> None:
    for name in ("time_stands_still", "time_goes_back", "time_of_ages"):
        signal = read_csv(CSV / f"broken/{name}.csv", rate=50)
        assert (signal.names, signal.rate, signal.first_frame) == (("x",), 50, 0)


def test_the_first_time_tells_the_first_frame(tmp_path: Path) -> None:
    assert table(tmp_path, "t,x\n2.5,1\n2.6,2\n2.7,3\n").first_frame == 25
    assert table(tmp_path, "t,x\n2.55,1\n2.65,2\n2.75,3\n").first_frame == 0
    # Where both say something the times have it: they are written again, the frames are not.
    assert table(tmp_path, "frame,t,x\n1,0.0,1\n2,0.1,2\n3,0.2,3\n").first_frame == 0


def test_a_column_called_frame(tmp_path: Path) -> None:
    signal = table(tmp_path, "Frame,x\n7,1\n8,2\n", rate=30)
    assert (signal.names, signal.first_frame) == (("x",), 7)
    # One that doesn't count up is a channel like any other, and so is one that stands alone.
    for text, names in (("frame,x\n7,1\n9,2\n", ("frame", "x")), ("frame,x\n0.5,1\n1.5,2\n", ("frame", "x"))):
        assert table(tmp_path, text, rate=30).names == names
    assert table(tmp_path, "t,frame\n0,1\n1,2\n").names == ("frame",)


def test_one_number_that_is_wrong_makes_no_channel_of_a_count_without_a_word(tmp_path: Path) -> None:
    """The search would look at it: one number that is far off outweighs all else."""
    numbers = ["7", "8", "9", "1000000", "11", "12", "13"]
    rows = "".join(f"{number},{i * i}\n" for i, number in enumerate(numbers))
    words = r"'frame' doesn't count up by one: it goes from 9 to 1000000 at line 5\. .* looks at, and its rows as even"
    with pytest.warns(FormatWarning, match=words):
        assert table(tmp_path, f"frame,x\n{rows}", rate=30).names == ("frame", "x")
    timed = "".join(f"{i / 25},{row}" for i, row in enumerate(rows.splitlines(keepends=True)))
    with pytest.warns(FormatWarning, match=r"to 1000000 at line 5\. .* looks at \(--channel 'frame=time:frames'"):
        table(tmp_path, f"t,frame,x\n{timed}")
    # Rows that are missing are told too; a count by twos is a channel that somebody meant.
    with pytest.warns(FormatWarning, match="from 3 to 7 at line 5"):
        table(tmp_path, "frame,x\n1,1\n2,4\n3,2\n7,1\n8,1\n", rate=30)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        table(tmp_path, "frame,x\n2,1\n4,1\n6,3\n8,1\n", rate=30)
        said = table(tmp_path, "frame,x\n1,1\n2,4\n3,2\n7,1\n8,1\n", rate=30, kinds={"frame": "time:frames"})
    assert [str(kind) for kind in said.kinds] == ["time:frames", "linear"]


@pytest.mark.filterwarnings("ignore::retime.errors.FormatWarning")
def test_a_column_called_frame_may_have_empty_cells(tmp_path: Path) -> None:
    """Filled, such a column would be a channel that is taken for the frames' numbers when it is read again."""
    signal = table(tmp_path, "frame,x,y\n,1,1\n5,2,\n,3,1\n7,4,1\n", rate=30, gaps="bridge")
    assert (signal.names, signal.first_frame, signal.values[:, 0].tolist()) == (("x", "y"), 4, [1, 2, 3, 4])
    # One number says nothing of how it goes on, and neither do numbers that leave some out.
    for cells in (("1", "", ""), ("1", "", "4"), ("0.5", "", "2.5")):
        rows = "".join(f"{i / 25},{cell},{i}\n" for i, cell in enumerate(cells))
        assert table(tmp_path, f"t,frame,x\n{rows}", gaps="keep").names == ("frame", "x")


@pytest.mark.filterwarnings("ignore::retime.errors.FormatWarning")
@pytest.mark.parametrize("seed", range(3))
def test_filled_frame_numbers_read_back_as_they_were_read(tmp_path: Path, seed: int) -> None:
    rng = np.random.default_rng(seed)
    read_again = set()
    for _ in range(60):
        n, step = int(rng.integers(2, 7)), int(rng.integers(1, 3))
        numbers = [str(int(rng.integers(0, 9)) + step * i) for i in range(n)]
        if rng.random() < 0.7:
            numbers = [str(3 + step * i) for i in range(n)]
        cells = ["" if rng.random() < 0.4 else one for one in numbers]
        cells[int(rng.integers(n))] = "3"
        rows = "".join(f"{i / 25:.2f},{cell},{i * i}\n" for i, cell in enumerate(cells))
        signal = table(tmp_path, f"t,frame,x\n{rows}", gaps="bridge")
        write(signal, tmp_path / "again.csv", overwrite=True)
        again = read_csv(tmp_path / "again.csv", gaps="bridge")
        read_again.add(signal.names)
        assert (again.names, again.values.tolist()) == (signal.names, signal.values.tolist()), cells
    assert read_again == {("x",), ("frame", "x")}


def test_a_channel_that_would_be_read_as_frame_numbers_is_told(tmp_path: Path) -> None:
    counted = Signal(("frame", "x"), np.array([[3.0, 1], [4, 2], [5, 4]]), rate=25)
    with pytest.warns(
        FormatWarning, match="channel 'frame' goes up by one a row, so a reader takes it for the frames'"
    ):
        write(counted, tmp_path / "a.csv")
    assert read_csv(tmp_path / "a.csv").names == ("x",)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        write(Signal(("frame", "x"), np.array([[3.0, 1], [5, 2]]), rate=25), tmp_path / "b.csv")
        write(Signal(("frame",), counted.values[:, :1], rate=25), tmp_path / "c.csv")
    assert read_csv(tmp_path / "b.csv").names == ("frame", "x")
    # Alone, it is what the table is about.
    assert read_csv(tmp_path / "c.csv").names == ("frame",)


# Broken


@pytest.mark.parametrize(
    ("name", "line", "says"),
    [
        ("empty", None, "the file is empty"),
        ("blank", None, "the file is empty"),
        ("quotes_around_nothing", None, "the file is blank"),
        ("binary", None, "byte 6: binary data, not text"),
        ("a_png_picture", None, "this is a PNG picture; expected a table of numbers"),
        ("a_web_page", 2, "this is a web page"),
        ("names_alone", 2, "the table ends after its names"),
        ("row_too_short", 3, "the row has 2 fields, the first row has 3"),
        ("row_too_long", 3, "the row has 4 fields, the first row has 3"),
        ("other_delimiter_below", 2, "the row has 1 field, the first row has 2 (separated by ',')"),
        ("field_empty", 3, "column 'x': expected a number, found nothing"),
        ("two_in_a_field_and_one_empty", 3, "column 'time': expected a number, found '0.04 1.5'"),
        ("field_nan", 3, "column 'x': expected a finite number, found 'nan'"),
        ("first_row_nan", 1, "column 'c0': expected a finite number, found 'nan'"),
        ("field_infinite", 3, "column 'x': expected a finite number, found '-inf'"),
        ("field_too_large", 3, "column 'x': expected a finite number, found '1e999'"),
        ("field_underscore", 3, "column 'x': expected a number, found '1_5'"),
        ("field_other_digits", 3, "column 'x': expected a number in the digits 0-9"),
        ("field_words", 3, "column 'x': expected a number, found 'n/a'"),
        ("field_decimal_comma", 3, "--decimal-comma"),
        ("name_twice", 1, "columns 2 and 3 are both called 'x'"),
        ("name_missing", 1, "column 1 of 3 has no name"),
        ("quote_not_closed", 2, "not a row of a table"),
        ("text_after_a_quote", 2, "not a row of a table"),
        ("time_alone", None, "the table has no column beside 't'"),
        ("time_stands_still", 4, "row 3: 't' goes from 0.1 to 0.1; times must increase"),
        ("time_goes_back", 4, "row 3: 't' goes from 0.2 to 0.1; times must increase"),
        ("time_of_ages", 3, "row 2: 't' is 1e+99, too large for a time"),
        (
            "no_time",
            None,
            "the table has no column of times (time, t, seconds, timestamp), so its rate must be given (--fps)",
        ),
    ],
)
def test_broken_tables(name: str, line: int | None, says: str) -> None:
    path = CSV / "broken" / f"{name}.csv"
    with pytest.raises(FormatError) as caught:
        read(path)
    assert caught.value.path == str(path)
    assert caught.value.line == line
    assert says in str(caught.value)


@pytest.mark.parametrize("row", ["0.1,,1,2", ",0.1,1,2", "0.1,1,2,", "0.1, 1, , 2"])
def test_a_row_with_an_empty_field_too_many(tmp_path: Path, row: str) -> None:
    """Its numbers are as many as the names, and still nobody knows which belongs where."""
    with pytest.raises(FormatError, match=r"table\.csv:3: the row has 4 fields, the first row has 3"):
        table(tmp_path, f"t,a,b\n0,1,2\n{row}\n0.2,1,2\n")


def test_a_single_row_is_read_at_the_usual_rate_which_is_said(tmp_path: Path) -> None:
    with pytest.warns(FormatWarning, match=r"a single row's 't' gives no rate: 30 frames a second are taken \(--fps"):
        signal = table(tmp_path, "t,x\n2.5,1\n")
    assert (signal.rate, signal.n_frames, signal.clock.start) == (30, 1, Fraction(5, 2))
    assert table(tmp_path, "t,x\n2.5,1\n", rate=25).rate == 25
    with pytest.raises(FormatError, match="too large for a time"):
        table(tmp_path, "t,x\n1e99,1\n")


@pytest.mark.parametrize("rate", [30, 25])
def test_a_single_row_comes_back(tmp_path: Path, rate: int) -> None:
    one = Signal(("x",), np.array([[2.0]]), Fraction(rate), name="one")
    with warnings.catch_warnings(record=True) as told:
        warnings.simplefilter("always")
        write(one, tmp_path / "one.csv")
        again = read(tmp_path / "one.csv")
    assert again.values.tolist() == [[2.0]]
    # Where its rate does not come back, writing it says so, and reading it too.
    assert [str(one.message).count("--fps") for one in told] == [1] * (1 if rate == 30 else 2)
    assert read(tmp_path / "one.csv", rate=rate).rate == rate


def test_limits() -> None:
    for limits, says in (
        (Limits(channels=2), "3 columns, the limit is 2 (Limits.channels)"),
        (Limits(frames=2), "more than 2 rows (Limits.frames)"),
        (Limits(name_bytes=6), "Limits.name_bytes"),
        (Limits(line_bytes=11), "Limits.line_bytes"),
    ):
        with pytest.raises(FormatError, match=re.escape(says)):
            read(CSV / "plain.csv", limits=limits)


def test_repair_keeps_the_rows_before_the_damage() -> None:
    for name in ("row_too_short", "field_nan"):
        with pytest.warns(FormatWarning, match=r"1 whole rows? were kept; then .*broken"):
            signal = read_csv(CSV / f"broken/{name}.csv", repair=True, rate=25)
        assert signal.values.tolist() == [[1, -2.5]]
    with pytest.raises(FormatError, match="first_row_nan"):
        read(CSV / "broken/first_row_nan.csv", repair=True)


def test_a_long_table_is_read_in_pieces(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(table_rows, "PIECE_BYTES", 500)
    rows = [f"{i / 100:.2f},{i},{'x' if i == 2500 else 1}.5\n" for i in range(3000)]
    text = "t,a,b\n" + "".join(rows)
    with pytest.raises(FormatError, match=r"table\.csv:2502: column 'b': expected a number, found 'x\.5'"):
        table(tmp_path, text)
    signal = table(tmp_path, text.replace("x", "2"))
    assert signal.rate == 100
    assert signal.values[:, 0].tolist() == list(range(3000))
    assert signal.values[2500, 1] == 2.5


@pytest.mark.parametrize("seed", range(6))
def test_damage_ends_in_a_signal_or_a_format_error(tmp_path: Path, seed: int) -> None:
    chance = random.Random(seed)
    whole = [
        (CSV / f"{name}.csv").read_bytes() for name in ("plain", "quoted", "names_in_quotes", "frame_counts_from_0")
    ]
    pieces = [b"nan", b"1e308", b"-", b'"', b"\n", b"\r", b"\0", b",", b";", b"\xff", b" ", b"e", b"9" * 30]
    outcomes = set()
    for _ in range(120):
        data = bytearray(chance.choice(whole))
        for _ in range(chance.randint(1, 4)):
            at = chance.randrange(len(data) + 1)
            data[at : at + chance.choice([0, 0, 1, 5])] = chance.choice([b"", *pieces])
        (tmp_path / "a.csv").write_bytes(data[: chance.choice([len(data), chance.randrange(len(data) + 1)])])
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", FormatWarning)
            try:
                signal = read_csv(tmp_path / "a.csv", rate=chance.choice([None, 30]), repair=chance.random() < 0.3)
                assert np.isfinite(signal.values).all()
                outcomes.add("signal")
            except FormatError:
                outcomes.add("error")
    assert outcomes == {"signal", "error"}


# Writing

names = st.text(st.characters(exclude_categories=("Cs",), exclude_characters="\r\0"), min_size=1, max_size=8).filter(
    lambda name: name == name.strip() and name.lower() != "frame"
)
finite = st.floats(-1e100, 1e100)
formulas = st.builds(str.__add__, st.sampled_from(["=", "+", "-", "@", "'=", "''-", "' ="]), names)
rates = st.one_of(
    st.sampled_from([Fraction(30), Fraction(24000, 1001), Fraction(120), Fraction(355, 113), Fraction(2993, 50)]),
    # But for decimals that mean rates of television: 59.94 is 60000/1001.
    st.fractions(min_value=Fraction(1, 50), max_value=2000, max_denominator=1001).filter(
        lambda rate: 10**4 % rate.denominator or parse_rate(float(rate)) == rate
    ),
)


@settings(deadline=None, max_examples=80)
@given(
    channels=st.dictionaries(names | formulas, finite, min_size=1, max_size=4),
    n_frames=st.integers(2, 5),
    rate=rates,
    first_frame=st.integers(0, 100_000),
    time_column=st.sampled_from(["", "time", "T", "Seconds"]),
)
def test_a_signal_comes_back(
    tmp_path_factory: pytest.TempPathFactory,
    channels: dict[str, float],
    n_frames: int,
    rate: Fraction,
    first_frame: int,
    time_column: str,
) -> None:
    values = np.array([list(channels.values())] * n_frames)
    signal = Signal(tuple(channels), values, rate=rate, first_frame=first_frame, time_column=time_column)
    path = tmp_path_factory.mktemp("csv") / "a.csv"
    write(signal, path)
    again = read_csv(path)
    assert again.names == signal.names
    assert again.values.tolist() == signal.values.tolist()
    assert (again.rate, again.first_frame) == (rate, first_frame)
    if time_column and time_column not in channels:
        # Frames so far apart would be taken for milliseconds, were the unit not said.
        unit = "_s" if rate <= Fraction(1, 2) and time_column != "Seconds" else ""
        assert again.time_column == time_column + unit
    # No field of the first row is taken for a formula.
    first = path.read_text(encoding="utf-8").splitlines()[0]
    assert not re.search(r'(^|,)"?\s*[=+\-@]', re.sub(r'"[^"]*"', lambda quoted: quoted[0].replace(",", ""), first))


def test_what_is_written(tmp_path: Path) -> None:
    signal = Signal(("x", "=1+2", "a;b"), np.array([[1, -0.5, 1e-7], [2, 3, 1e22]]), rate=Fraction(24000, 1001))
    write(signal, tmp_path / "a.csv")
    assert (tmp_path / "a.csv").read_text() == (
        '"time","x","\'=1+2","a;b"\n0.000000,1.0,-0.5,1e-07\n0.041708,2.0,3.0,1e+22\n'
    )


def test_a_channel_that_is_called_time_stays_one(tmp_path: Path) -> None:
    signal = Signal(("time", "x"), np.array([[5.0, 1], [5, 2], [4, 3]]), rate=Fraction(10))
    write(signal, tmp_path / "a.csv")
    again = read_csv(tmp_path / "a.csv")
    assert (again.names, again.time_column, again.rate) == (("time", "x"), "t", 10)
    with pytest.raises(FormatError, match="all names that a column of times can have"):
        write(Signal(("time", "t", "seconds", "timestamp"), np.zeros((2, 4))), tmp_path / "b.csv")


def test_names_that_a_table_cannot_hold(tmp_path: Path) -> None:
    for bad, says in ((("a", "a"), "two channels are called 'a'"), (("a", " "), "a channel has no name")):
        with pytest.raises(FormatError, match=says):
            write(Signal(bad, np.zeros((2, 2))), tmp_path / "a.csv")
    assert list(tmp_path.iterdir()) == []


def test_one_row_cannot_say_its_rate(tmp_path: Path) -> None:
    with pytest.warns(FormatWarning, match="can't say that the rate is 25; give it when the file is read"):
        write(Signal(("a",), np.ones((1, 1)), 25), tmp_path / "a.csv")
    assert read_csv(tmp_path / "a.csv", rate=25).values.tolist() == [[1]]


def test_times_at_a_decimal_of_television_mean_its_rate(tmp_path: Path) -> None:
    signal = Signal(("a",), np.ones((500, 1)), rate=Fraction(2997, 50))
    with pytest.warns(FormatWarning, match="can't say that the rate is 2997/50; give it when the file is read"):
        write(signal, tmp_path / "a.csv")
    assert read_csv(tmp_path / "a.csv").rate == Fraction(60000, 1001)
    assert read_csv(tmp_path / "a.csv", rate=Fraction(2997, 50)).rate == Fraction(2997, 50)


def test_existing_files_and_motions(tmp_path: Path) -> None:
    (tmp_path / "a.csv").write_text("mine")
    signal = Signal(("a",), np.ones((2, 1)))
    with pytest.raises(OutputExistsError):
        write(signal, tmp_path / "a.csv")
    write(signal, tmp_path / "a.csv", overwrite=True)
    assert read_csv(tmp_path / "a.csv").rate == 30
    motion = Motion(Skeleton(("a",), (-1,), np.zeros((1, 3))), np.array([[[1.0, 0, 0, 0]]]))
    with pytest.raises(FormatError, match="holds a signal"):
        write(motion, tmp_path / "b.csv")


def test_text_is_carried_along_and_written_as_it_came(tmp_path: Path) -> None:
    text = 'time,x,said,on\n0,1,"walk, slowly",TRUE\n0.1,2,=run,FALSE\n0.2,3,7,TRUE\n'.replace(",7,", ",stand,")
    path = tmp_path / "a.csv"
    path.write_text(text)
    signal = read(path)
    assert isinstance(signal, Signal)
    assert signal.texts("said") == ["walk, slowly", "=run", "stand"]
    assert signal.values[:, 2].tolist() == [1, 0, 1]
    write(signal, tmp_path / "b.csv")
    # A word that a spreadsheet would take for a formula is written with an apostrophe.
    assert "'=run" in (tmp_path / "b.csv").read_text()
    again = read(tmp_path / "b.csv")
    assert isinstance(again, Signal)
    assert again.texts("said") == signal.texts("said")
    assert again.texts("on") == ["TRUE", "FALSE", "TRUE"]


@pytest.mark.parametrize(
    ("text", "says"),
    [
        # One word among numbers is a mistake, be it the first.
        ("time,x\n0,walk\n0.1,2\n0.2,3\n", "a.csv:2: column 'x': expected a number, found 'walk'"),
        ("time,x\n0,1\n0.1,2\n0.2,walk\n", "a.csv:4: column 'x': expected a number, found 'walk'"),
        ("time,x,y\ns,mm,fast\n0,1,2\n0.1,2,3\n", "a.csv:2: column 'time': expected a number, found 's'"),
        ("a,b\nx,y\nz,w\n", "a.csv:2: column 'a': expected a number, found 'x'"),
        ("time,x\n0,1\n,2\n0.2,3\n", "a.csv:3: column 'time': expected a number, found nothing"),
    ],
)
@pytest.mark.parametrize("gaps", [None, "keep", "bridge"])
def test_what_is_neither_number_nor_text_nor_gap_is_refused(tmp_path: Path, text: str, says: str, gaps) -> None:
    (tmp_path / "a.csv").write_text(text)
    with pytest.raises(FormatError, match=re.escape(says)):
        read(tmp_path / "a.csv", gaps=gaps)


@pytest.mark.parametrize("cell", ["", "nan", "NaN", "NA", "N/A", "null", "None", "#N/A"])
def test_gaps_are_written_in_many_ways(tmp_path: Path, cell: str) -> None:
    path = tmp_path / "a.csv"
    path.write_text(f"time,x,y\n0,1,5\n0.1,{cell},5\n0.2,3,5\n0.3,{cell},5\n")
    with pytest.raises(FormatError, match=r"a.csv:3: column 'x'.*--gaps bridge fills gaps, --gaps keep carries them"):
        read(path)
    with pytest.warns(FormatWarning, match=r"bridged gaps: x frames 1:1, 3:3"):
        bridged = read(path, gaps="bridge")
    assert isinstance(bridged, Signal)
    assert bridged.values[:, 0].tolist() == [1, 2, 3, 3]
    with pytest.warns(FormatWarning, match=r"kept gaps: x frames 1:1, 3:3"):
        kept = read(path, gaps="keep")
    assert isinstance(kept, Signal)
    assert np.isnan(kept.values[:, 0]).tolist() == [False, True, False, True]
    write(kept, tmp_path / "b.csv")
    with pytest.warns(FormatWarning, match="kept gaps"):
        again = read(tmp_path / "b.csv", gaps="keep")
    assert isinstance(again, Signal)
    assert np.array_equal(again.values, kept.values, equal_nan=True)


def test_long_gaps_are_not_bridged(tmp_path: Path) -> None:
    x = [0.0, *[np.nan] * 2, 3.0, *[np.nan] * 3, 7.0]
    (tmp_path / "a.csv").write_text("time,x\n" + "".join(f"{i / 10},{value}\n" for i, value in enumerate(x)))
    with pytest.warns(FormatWarning) as said:
        found = read(tmp_path / "a.csv", gaps="bridge:0.2")
    assert isinstance(found, Signal)
    assert np.isnan(found.values[:, 0]).tolist() == [False] * 4 + [True] * 3 + [False]
    assert found.values[1:3, 0].tolist() == [1, 2]
    says = [str(one.message) for one in said]
    assert any("bridged gaps: x frames 1:2" in one for one in says)
    assert any("kept gaps longer than 0.2 s: x frames 4:6" in one for one in says)
    with pytest.raises(OptionError, match="gaps are 'bridge', 'bridge:SECONDS' or 'keep'; found 'fill'"):
        read(tmp_path / "a.csv", gaps="fill")


def test_channels_are_told_what_they_hold(tmp_path: Path) -> None:
    (tmp_path / "a.csv").write_text("time,a_x,b_x,said\n0,1,2,no\n0.1,2,3,yes\n0.2,3,4,no\n")
    found = read(tmp_path / "a.csv", kinds={"*_x": "label", "b_x": "angle:rad"})
    assert isinstance(found, Signal)
    assert [str(kind) for kind in found.kinds] == ["label", "angle:rad", "label"]
    with pytest.raises(OptionError, match="a has no channel 'c'; there are a_x, b_x, said"):
        read(tmp_path / "a.csv", kinds={"c": "label"})
    with pytest.raises(OptionError, match="channel 'said' holds text, which can only be a label"):
        read(tmp_path / "a.csv", kinds={"said": "linear"})


@pytest.mark.parametrize("end", ["\x1a", "\n\x1a", "\0" * 100, "\r\n\x1a\0\n"])
def test_padding_at_the_end_is_no_damage(tmp_path: Path, end: str) -> None:
    signal = table(tmp_path, f"t,x\n0.0,1\n0.1,2\n0.2,4{end}")
    assert (signal.rate, signal.values[:, 0].tolist()) == (10, [1, 2, 4])
    with pytest.raises(FormatError):
        table(tmp_path, f"t,x\n0.0,1\n0.1,2{end}\n0.2,4\n")


def test_repair_parts_numbers_that_run_together(tmp_path: Path) -> None:
    text = "t,x,y,z\n0.0,1,0.0-7.5\n0.1,2,3,4\n0.2,1e-2-3-4\n"
    with pytest.raises(FormatError, match="the row has 3 fields, the first row has 4"):
        table(tmp_path, text)
    with pytest.warns(FormatWarning, match="parted in 2 rows; the first is line 2"):
        signal = table(tmp_path, text, repair=True)
    assert signal.values.tolist() == [[1, 0, -7.5], [2, 3, 4], [0.01, -3, -4]]
    # Too many, or with words and dates, where a minus is none.
    for odd in ("t,x,y\n0.0,1,2\n0.1,3,4\n0.2,1-2-3\n", "t,x,y,w\n0.0,1,2,go\n0.1,3,4,go\n0.2,1-2,go\n"):
        with pytest.warns(FormatWarning, match="2 whole rows were kept; then .*:4: the row has"):
            assert table(tmp_path, odd, repair=True).n_frames == 2


@pytest.mark.parametrize("first", ["1-2,2.50", "1-2.5,2.50", "1e-2-2.5,2.50"])
def test_the_first_row_may_be_one_whose_numbers_ran_together(tmp_path: Path, first: str) -> None:
    """Times stand in the last column, and the row itself has no such column."""
    text = f"x,y,time\n{first}\n3,4,2.54\n5,6,2.58\n"
    with pytest.warns(FormatWarning, match="parted in 1 row; the first is line 2"):
        signal = table(tmp_path, text, repair=True)
    whole = table(tmp_path, text.replace(first, first[::-1].replace("-", "-,", 1)[::-1]))
    assert (signal.values == whole.values).all()
    assert (signal.rate, signal.clock) == (whole.rate, whole.clock)
    assert signal.rate == 25
