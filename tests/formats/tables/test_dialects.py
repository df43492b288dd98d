"""The heads of tables, each in the shape in which its program writes it, and what is wrong with broken ones."""

from __future__ import annotations

import random
import re
import warnings
from pathlib import Path

import numpy as np
import pytest

from retime.errors import FormatError, FormatWarning
from retime.formats import read
from retime.motion.signal import Signal

STO = (
    "Coordinates\nversion=1\nnRows=3\nnColumns=3\ninDegrees=yes\n\nUnits are S.I. units (second, meters)\n\nendheader\n"
    "time\tknee_angle_r\tpelvis_tx\n0.5\t10\t1\n0.51\t11\t2\n0.52\t12\t3\n"
)
TRC = (
    "PathFileType\t4\t(X/Y/Z)\ttrial.trc\n"
    "DataRate\tCameraRate\tNumFrames\tNumMarkers\tUnits\tOrigDataRate\tOrigDataStartFrame\tOrigNumFrames\n"
    "100\t100\t3\t2\tmm\t100\t1\t3\n"
    "Frame#\tTime\tR.ASIS\t\t\tL.ASIS\t\t\t\n\t\tX1\tY1\tZ1\tX2\tY2\tZ2\t\n\t\t\n"
    "1\t0.00\t1\t2\t3\t4\t5\t6\t\n2\t0.01\t2\t3\t4\t5\t6\t7\n3\t0.02\t3\t4\t5\t6\t7\t8\t\n"
)
MOTIVE = (
    "Format Version,1.23,Take Name,take,Capture Frame Rate,240.000000,Export Frame Rate,120.000000,"
    "Rotation Type,XYZ,Length Units,Meters\n\n"
    ",,Bone,Bone,Bone,Bone,Bone,Bone,Marker,Marker,Marker\n,,Hip,Hip,Hip,Hip,Hip,Hip,Hip,Hip,Hip\n"
    ",,1,1,1,1,1,1,2,2,2\n,,Rotation,Rotation,Rotation,Position,Position,Position,Position,Position,Position\n"
    "Frame,Time (Seconds),X,Y,Z,X,Y,Z,X,Y,Z\n"
    "0,0.000000,170,0,0,1,2,3,4,5,6\n1,0.008333,-170,0,0,1,2,3,4,5,6\n2,0.016667,-160,0,0,1,2,3,4,5,6\n"
)
DLC = (
    "scorer,net,net,net,net\nindividuals,one,one,two,two\nbodyparts,nose,nose,nose,nose\ncoords,x,y,x,y\n"
    "0,1,2,3,4\n1,2,3,4,5\n2,3,4,5,6\n"
)


def table(folder: Path, text: str, name: str = "a.csv", **options: object) -> Signal:
    (folder / name).write_text(text)
    signal = read(folder / name, **options)
    assert isinstance(signal, Signal)
    return signal


@pytest.mark.parametrize("name", ["a.sto", "a.mot", "a.csv"])
@pytest.mark.parametrize("blanks", [False, True])
def test_opensim(tmp_path: Path, name: str, *, blanks: bool) -> None:
    found = table(tmp_path, STO.replace("\t", "   ") if blanks else STO, name)
    assert (found.names, found.rate, found.start_time) == (("knee_angle_r", "pelvis_tx"), 100, 0.5)
    assert found.values.tolist() == [[10, 1], [11, 2], [12, 3]]
    assert (found.dialect, found.first_frame) == ("OpenSim table", 50)
    with pytest.warns(FormatWarning, match="4 rows claimed, 3 there; kept all 3"):
        table(tmp_path, STO.replace("nRows=3", "nRows=4"), name)


def test_trc(tmp_path: Path) -> None:
    found = table(tmp_path, TRC, "a.trc")
    assert found.names == tuple(f"{marker}.{axis}" for marker in ("R.ASIS", "L.ASIS") for axis in "xyz")
    assert (found.rate, found.dialect, found.kinds[0].unit) == (100, "TRC markers", "mm")
    assert found.values.tolist() == [[1, 2, 3, 4, 5, 6], [2, 3, 4, 5, 6, 7], [3, 4, 5, 6, 7, 8]]
    # A marker that was not seen.
    gone = TRC.replace("2\t0.01\t2\t3\t4\t", "2\t0.01\t\t\t\t")
    with pytest.raises(FormatError, match=r"a\.trc:8: column 'R\.ASIS\.x': .*--gaps"):
        table(tmp_path, gone, "a.trc")
    with pytest.warns(FormatWarning, match="bridged gaps"):
        bridged = table(tmp_path, gone, "a.trc", gaps="bridge")
    np.testing.assert_allclose(bridged.values, found.values)


def test_motive(tmp_path: Path) -> None:
    found = table(tmp_path, MOTIVE)
    axes = [*(f"Hip.rotation.{axis}" for axis in "xyz"), *(f"Hip.position.{axis}" for axis in "xyz")]
    # The marker has the name of its bone.
    assert found.names == (*axes, *(f"Hip.position.{axis}.2" for axis in "xyz"))
    assert (found.rate, found.dialect) == (120, "Motive export")
    assert [str(kind) for kind in found.kinds[:4]] == ["angle:deg"] * 3 + ["linear"]
    assert found.values[:, 0].tolist() == [170, -170, -160]


def test_motive_of_today(tmp_path: Path) -> None:
    """Its rows say at their beginning what they hold."""
    text = MOTIVE.replace(",,Bone", ",Type,Bone").replace(",,Hip", ",Name,Hip").replace(",,1", ",ID,1")
    found = table(tmp_path, text)
    old = table(tmp_path, MOTIVE)
    assert (found.names, found.rate, found.time_column) == (old.names, 120, "Time (Seconds)")
    assert found.values.tolist() == old.values.tolist()


def test_deeplabcut_of_several_animals(tmp_path: Path) -> None:
    found = table(tmp_path, DLC, rate=30)
    assert found.names == ("one.nose.x", "one.nose.y", "two.nose.x", "two.nose.y")
    assert found.values.tolist() == [[1, 2, 3, 4], [2, 3, 4, 5], [3, 4, 5, 6]]
    # Tables of pictures that people marked name the pictures.
    marked = re.sub(r"(?m)^(\d)", r"img\1.png", DLC)
    assert table(tmp_path, marked, rate=30).values.tolist() == found.values.tolist()


def test_kinect_rows_are_known_by_what_they_hold(tmp_path: Path) -> None:
    rows = [[100 + 33 * i, 0.5 * i, 1, 2, 2, i, 3, 4, i % 3] for i in range(6)]
    text = "".join(",".join(map(str, row)) + ",\n" for row in rows)
    found = table(tmp_path, text)
    assert (found.dialect, found.names) == ("Kinect recording", tuple(f"c{i}" for i in range(1, 9)))
    assert [kind.kind for kind in found.kinds] == (["linear"] * 3 + ["label"]) * 2
    # Without the comma, or with numbers that are no states, it is a table like any other, whose first column stays.
    for other in (text.replace(",\n", "\n"), text.replace("1,2,2", "1,2,9")):
        plain = table(tmp_path, other, rate=30)
        assert (plain.dialect, plain.names) == ("", tuple(f"c{i}" for i in range(9)))
        assert plain.values[:, 0].tolist() == [row[0] for row in rows]


@pytest.mark.parametrize("units", ["s,deg,[mm],-", "s,°,mm,1", "(s),degrees,(mm),"])
def test_units_say_what_channels_hold(tmp_path: Path, units: str) -> None:
    found = table(tmp_path, f"time,turn,x,n\n{units}\n0,1,2,5\n0.1,3,4,6\n")
    assert [str(kind) for kind in found.kinds] == ["angle:deg", "linear:mm", "linear"]
    assert found.values.tolist() == [[1, 2, 5], [3, 4, 6]]
    assert found.rate == 10


def test_the_unit_of_time_stands_below_its_name(tmp_path: Path) -> None:
    assert table(tmp_path, "time,x\nms,mm\n0,1\n1,2\n2,3\n").rate == 1000
    assert table(tmp_path, "time,x\ns,mm\n0,1\n40,2\n80,3\n").rate == pytest.approx(1 / 40)


@pytest.mark.parametrize("delimiter", [";", ",", "\t", "|"])
def test_the_line_that_says_what_parts_cells(tmp_path: Path, delimiter: str) -> None:
    text = "time,x,y\n0,1,2\n0.5,3,4\n".replace(",", delimiter)
    for ends in ("\n", delimiter + "\n"):
        found = table(
            tmp_path, f"sep={delimiter}\n{text}".replace("\n", ends).replace(f"={delimiter}{ends}", f"={delimiter}\n")
        )
        assert (found.names, found.values.tolist()) == (("x", "y"), [[1, 2], [3, 4]])
    with pytest.raises(FormatError, match=r"a\.csv:4: column 'y': expected a number, found 'b'"):
        table(tmp_path, f"sep={delimiter}\n" + text.replace("4", "b"))


@pytest.mark.parametrize("delimiter", [b"\xdc", b"1", b"e", b"-", b"."])
def test_a_line_that_names_what_can_part_no_numbers_is_refused(tmp_path: Path, delimiter: bytes) -> None:
    place = tmp_path / "a.csv"
    place.write_bytes(b"sep=" + delimiter + b"\ntime;x\n0;1\n0.5;2\n")
    with pytest.raises(FormatError, match=r"a\.csv:1: sep= names what parts the cells: one of , ; \| or a tab, found"):
        read(place)


def test_a_first_time_with_an_exponent_of_billions_is_read_at_once(tmp_path: Path) -> None:
    found = table(tmp_path, "time,x\n0.00e-5999999999999999,1\n0.04,2\n0.08,3\n")
    assert (found.rate, found.values.tolist(), found.clock.start) == (25, [[1], [2], [3]], 0)


def test_an_index_must_count_up(tmp_path: Path) -> None:
    found = table(tmp_path, ",time,x\n5,0,1\n6,0.1,2\n7,0.2,3\n")
    assert (found.names, found.dialect, found.rate) == (("x",), "an index before the columns", 10)
    with pytest.raises(FormatError, match=r"a\.csv:1: column 1 of 3 has no name"):
        table(tmp_path, ",time,x\n5,0,1\n7,0.1,2\n8,0.2,3\n")
    # An index of dates is a clock.
    dated = table(tmp_path, ",x\n2024-05-01 10:00:00.00,1\n2024-05-01 10:00:00.04,2\n2024-05-01 10:00:00.08,3\n")
    assert (dated.names, dated.rate, dated.clock.form) == (("x",), 25, "date")


def test_a_comma_too_many_after_every_row(tmp_path: Path) -> None:
    found = table(tmp_path, "time,x,y,\n0,1,2,\n0.1,2,3,\n")
    assert (found.names, found.values.tolist()) == (("x", "y"), [[1, 2], [2, 3]])
    with pytest.raises(FormatError, match=r"a\.csv:3: column 'y': expected a number, found nothing"):
        table(tmp_path, "time,x,y,\n0,1,2,\n0.1,2,,\n")


@pytest.mark.parametrize(
    ("text", "line", "says"),
    [
        (STO.replace("nColumns=3", "nColumns=4"), 10, "nColumns=4, but 3 columns have names"),
        (STO.replace("11\t", "11a\t"), 12, "column 'knee_angle_r': expected a number, found '11a'"),
        (STO.replace("\t2\n", "\n"), 12, "the row has 2 fields, the first row has 3"),
        (STO[: STO.index("time\t")], 9, "nothing follows 'endheader'"),
        (TRC.replace("\t2\tmm", "\t3\tmm"), 4, "NumMarkers is 3, and 2 markers have names"),
        (STO.replace("nColumns=3", "nColumns=" + "3" * 5000), 10, "nColumns=33"),
        (TRC.replace("\t2\tmm", "\t²\tmm"), 4, "NumMarkers is ², and 2 markers have names"),
        (TRC.replace("\t2\tmm", "\t" + "2" * 5000 + "\tmm"), 4, "NumMarkers is 22"),
        (TRC.replace("Z2", ""), 5, "5 axes, where 2 markers have 6"),
        (TRC.replace("100\t100\t3", "x\t100\t3"), 3, "DataRate: "),
        (TRC.replace("\t6\t7\n", "\t6\n"), 8, "the row has 7 fields, the first row has 8"),
        (MOTIVE.replace("Frame,Time", "Number,Time"), 1, "none of its rows begins with 'Frame'"),
        (MOTIVE.replace("-170", "x"), 9, "column 'Hip.rotation.x': expected a number, found 'x'"),
        (DLC.replace("nose,nose,nose,nose", "nose,nose"), 3, "the row has 3 fields, that of coords has 5"),
        (DLC.replace("2,3,4,5\n", "2,3,4\n"), 6, "the row has 4 fields, the first row has 5"),
    ],
)
def test_broken_tables_name_the_line(tmp_path: Path, text: str, line: int, says: str) -> None:
    with pytest.raises(FormatError) as caught:
        table(tmp_path, text, rate=100)
    assert caught.value.line == line
    assert says in str(caught.value)
    assert len(str(caught.value)) < 500


@pytest.mark.parametrize("claimed", ["²", "9" * 5000])
def test_a_count_of_rows_that_is_none_leaves_the_rows(tmp_path: Path, claimed: str) -> None:
    for whole in (TRC.replace("\t3\t2\tmm", f"\t{claimed}\t2\tmm"), STO.replace("nRows=3", f"nRows={claimed}")):
        assert claimed in whole
        with warnings.catch_warnings(record=True) as caught:
            warnings.simplefilter("always")
            assert table(tmp_path, whole).n_frames == 3
        said = [str(one.message) for one in caught if "rows claimed" in str(one.message)]
        assert len(said) == (claimed != "²")
        assert all("1e+300 rows claimed" in one and len(one) < 500 for one in said)


@pytest.mark.parametrize("seed", range(4))
def test_damage_ends_in_a_signal_or_a_format_error(tmp_path: Path, seed: int) -> None:
    chance = random.Random(seed)
    pieces = [b"nan", b"-", b'"', b"\n", b"\0", b",", b"\t", b";", b"\xff", b"=", b"ms", b"10:00:00:00", b"endheader"]
    outcomes = set()
    for _ in range(150):
        data = bytearray(chance.choice([STO, TRC, MOTIVE, DLC]).encode())
        for _ in range(chance.randint(1, 4)):
            at = chance.randrange(len(data) + 1)
            data[at : at + chance.choice([0, 0, 1, 9])] = chance.choice([b"", *pieces])
        (tmp_path / "a.csv").write_bytes(data[: chance.choice([len(data), chance.randrange(len(data) + 1)])])
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", FormatWarning)
            try:
                gaps = chance.choice([None, "keep", "bridge"])
                found = read(
                    tmp_path / "a.csv", rate=chance.choice([None, 30]), gaps=gaps, repair=chance.random() < 0.3
                )
                assert found.n_frames > 0
                outcomes.add("signal")
            except FormatError:
                outcomes.add("error")
    assert outcomes == {"signal", "error"}
