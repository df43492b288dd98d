"""NPY and NPZ: shapes and kinds of numbers, and archives that claim what they don't hold."""

from __future__ import annotations

import io
import random
import struct
import tracemalloc
import zipfile
from fractions import Fraction
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

from retime.errors import FormatError, FormatWarning, OutputExistsError
from retime.formats import Limits, read, write
from retime.motion.channels import text_label
from retime.motion.clock import Clock
from retime.motion.motion import Motion
from retime.motion.signal import Signal
from retime.motion.skeleton import Skeleton

VALUES = np.array([[1.0, -2.5], [1.5, -2.0], [2.25, 0.001]])


def read_signal(path: Path, **options: object) -> Signal:
    signal = read(path, **options)
    assert isinstance(signal, Signal)
    return signal


def npy(array: object, *, allow_pickle: bool = False) -> bytes:
    file = io.BytesIO()
    np.save(file, np.asarray(array), allow_pickle=allow_pickle)
    return file.getvalue()


def raw_npy(header: str, body: bytes = b"", *, version: tuple[int, int] = (1, 0), length: int | None = None) -> bytes:
    text = header.encode()
    size = struct.pack("<H" if version == (1, 0) else "<I", len(text) if length is None else length)
    return b"\x93NUMPY" + bytes(version) + size + text + body


def described(descr: str, shape: str, order: str = "False") -> str:
    return f"{{'descr': '{descr}', 'fortran_order': {order}, 'shape': {shape}, }}\n"


def npz(**members: bytes) -> bytes:
    file = io.BytesIO()
    with zipfile.ZipFile(file, "w") as archive:
        for name, data in members.items():
            archive.writestr(f"{name}.npy", data)
    return file.getvalue()


def put(folder: Path, data: bytes, name: str = "a.npy") -> Path:
    path = folder / name
    path.write_bytes(data)
    return path


# Odd but legal


@pytest.mark.parametrize(
    "array",
    [
        VALUES,
        VALUES.astype(">f8"),
        np.asfortranarray(VALUES),
        VALUES[::-1][::-1],
    ],
    ids=["little", "big", "fortran", "view"],
)
def test_layouts(tmp_path: Path, array: np.ndarray) -> None:
    signal = read_signal(put(tmp_path, npy(array)), rate=25)
    assert signal.values.tolist() == VALUES.tolist()
    assert (signal.names, signal.rate, signal.name, signal.time_column) == (("c0", "c1"), 25, "a", "")


@pytest.mark.parametrize("kind", ["<f2", "<f4", ">f4", "|i1", "|u1", "<i2", ">i2", "<u2", ">i4", "<i4", "<i8", ">u8"])
def test_kinds_of_numbers(tmp_path: Path, kind: str) -> None:
    array = np.array([[1, 2], [3, 100]], dtype=kind)
    assert read_signal(put(tmp_path, npy(array)), rate=25).values.tolist() == [[1, 2], [3, 100]]


def test_truths_are_0_and_1(tmp_path: Path) -> None:
    assert read_signal(put(tmp_path, npy([True, False])), rate=25).values.tolist() == [[1], [0]]


def test_one_column_and_markers(tmp_path: Path) -> None:
    signal = read_signal(put(tmp_path, npy([1.0, 2.0])), rate=25)
    assert (signal.names, signal.values.tolist()) == (("c0",), [[1], [2]])
    markers = np.arange(12.0).reshape(2, 2, 3)
    for array in (markers, np.asfortranarray(markers)):
        signal = read_signal(put(tmp_path, npy(array)), rate=25)
        assert signal.names == ("m0.x", "m0.y", "m0.z", "m1.x", "m1.y", "m1.z")
        assert signal.values.tolist() == [list(range(6)), list(range(6, 12))]


@pytest.mark.parametrize("version", [(1, 0), (2, 0), (3, 0)])
def test_versions_and_headers_of_other_writers(tmp_path: Path, version: tuple[int, int]) -> None:
    body = np.array([1.0, 2.0]).tobytes()
    for header in (
        "{'descr': '<f8', 'fortran_order': False, 'shape': (2,), }          \n",
        '{"shape": (2L,), "fortran_order": False, "descr": "<f8"}',
        "{'fortran_order':False,'shape':( 2 , 1 ),'descr':'<f8'}",
    ):
        path = put(tmp_path, raw_npy(header, body, version=version))
        assert read_signal(path, rate=25).values.tolist() == [[1], [2]]


def test_an_archive(tmp_path: Path) -> None:
    np.savez(tmp_path / "a.npz", values=VALUES, rate="24000/1001", names=["x", "größe"], comment="kept out")
    signal = read_signal(tmp_path / "a.npz")
    assert signal.names == ("x", "größe")
    assert signal.rate == Fraction(24000, 1001)
    assert signal.values.tolist() == VALUES.tolist()
    assert read_signal(tmp_path / "a.npz", rate=30).rate == 30
    np.savez_compressed(tmp_path / "b.npz", values=VALUES.astype("f4"), rate=29.97, names=np.array([b"x", b"y"]))
    signal = read_signal(tmp_path / "b.npz")
    assert (signal.names, signal.rate) == (("x", "y"), Fraction(30000, 1001))
    np.savez(tmp_path / "c.npz", values=VALUES, rate=np.array([60]), names=np.array(["x", "y"], dtype=">U3"))
    assert read_signal(tmp_path / "c.npz").rate == 60
    # The bytes say what a file is, not its ending.
    assert read_signal(put(tmp_path, (tmp_path / "c.npz").read_bytes())).rate == 60


def test_a_small_archive_of_zeros_is_no_bomb(tmp_path: Path) -> None:
    np.savez_compressed(tmp_path / "a.npz", values=np.zeros((2000, 8)), rate=30)
    assert not read_signal(tmp_path / "a.npz").values.any()


# Broken


@pytest.mark.parametrize(
    ("data", "says"),
    [
        pytest.param(b"", "the file is empty", id="empty"),
        pytest.param(b"\x89PNG\r\n\x1a\n", "a PNG picture", id="a_png_picture"),
        pytest.param(b"time,x\n", "found the bytes 74 69", id="a_csv"),
        pytest.param(b"\x93NUMPY", "version", id="magic_alone"),
        pytest.param(raw_npy(described("<f8", "(2,)"), version=(9, 1)), "version 09.01", id="version_9"),
        pytest.param(raw_npy(described("<f8", "(2,)"))[:30], "claims a header of", id="cut_in_the_header"),
        pytest.param(raw_npy("{}", version=(2, 0), length=2**32 - 1), "a header of 4294967295 bytes", id="huge_header"),
        pytest.param(raw_npy(" " * 5000), "the limit is 4096", id="long_header"),
        pytest.param(raw_npy("hello"), "describes no plain array", id="no_dictionary"),
        pytest.param(raw_npy("{'descr': '<f8', 'shape': (2,)}"), "describes no plain array", id="key_missing"),
        pytest.param(raw_npy(described("<f8", "(-2,)")), "describes no plain array", id="shape_negative"),
        pytest.param(raw_npy(described("<f8", "(1e3,)")), "describes no plain array", id="shape_float"),
        pytest.param(raw_npy(described("<f8", "__import__('os')")), "describes no plain array", id="shape_of_code"),
        pytest.param(raw_npy("(" * 3000), "describes no plain array", id="nested"),
        pytest.param(
            npy(np.zeros(2, dtype=[("a", "f8"), ("b", "i4")])), "records and objects are not read", id="records"
        ),
        pytest.param(npy([{}, {}], allow_pickle=True), "Python objects, which are never loaded", id="objects"),
        pytest.param(npy([1j, 2]), "complex numbers", id="complex"),
        pytest.param(npy(np.array(["2020-01-01"], "M8[D]")), "describes no plain array", id="dates"),
        pytest.param(raw_npy(described("<M8", "(1,)"), bytes(8)), "dates", id="dates_without_unit"),
        pytest.param(raw_npy(described("<f3", "(1,)"), bytes(3)), "the type '<f3'", id="three_byte_floats"),
        pytest.param(npy(["a", "b"]), "values holds text", id="text"),
        pytest.param(
            raw_npy(described("<f8", "(1000000000, 1000000000)"), bytes(16)), "8000000000000000000 bytes; 16", id="huge"
        ),
        pytest.param(
            raw_npy(described("<f8", "(999999999999999999, 999999999999999999, 3)")), "0 bytes follow", id="overflow"
        ),
        pytest.param(npy(VALUES)[:-8], "48 bytes; 40 bytes follow", id="cut_in_the_data"),
        pytest.param(npy(VALUES) + b"\0", "48 bytes; 49 bytes follow", id="a_byte_too_many"),
        pytest.param(npy(3.0), "shape ()", id="no_dimension"),
        pytest.param(npy(np.zeros((0, 3))), "shape (0, 3)", id="no_frame"),
        pytest.param(npy(np.zeros((3, 0))), "shape (3, 0)", id="no_channel"),
        pytest.param(npy(np.zeros((2, 1, 1, 3))), "shape (2, 1, 1, 3); expected (n_frames,)", id="four_dimensions"),
        pytest.param(npy(np.zeros((1, 1, 2, 1, 3))), "shape (1, 1, 2, 1, 3)", id="five_dimensions"),
        pytest.param(npy([[1, np.nan]]), "channel 'c1' at frame 0 is not finite", id="nan"),
        pytest.param(npy(np.array([1, np.inf], "f4")), "channel 'c0' at frame 1 is not finite", id="infinite"),
        pytest.param(npy([2**53 + 1]), "9007199254740993, more than 2**53", id="large_whole_number"),
        pytest.param(npy([-(2**60)]), "more than 2**53", id="large_negative_number"),
        pytest.param(npy(np.zeros((1, 20_000), "i1")), "Limits.channels", id="channels"),
    ],
)
def test_broken_arrays(tmp_path: Path, data: bytes, says: str) -> None:
    path = put(tmp_path, data)
    with pytest.raises(FormatError) as caught:
        read(path, rate=25)
    assert caught.value.path == str(path)
    assert says in str(caught.value)


def test_a_rate_must_be_given(tmp_path: Path) -> None:
    for data in (npy(VALUES), npz(values=npy(VALUES))):
        with pytest.raises(FormatError, match=r"holds no rate, so it must be given \(--fps\)"):
            read(put(tmp_path, data))


@pytest.mark.parametrize(
    ("data", "says"),
    [
        pytest.param(
            npz(here=npy(VALUES), there=npy(VALUES)),
            "no array called values; say which is meant (--array): here, there",
            id="two_that_could_be_meant",
        ),
        pytest.param(npz(fps=npy(30), sex=npy("f")), "no array called values; it has 'fps', 'sex'", id="no_values"),
        pytest.param(
            npz(values=npy(VALUES), rate=npy(30), kinds=npy(["label"])),
            "kinds are 2 texts, one a channel",
            id="a_kind_less",
        ),
        pytest.param(
            npz(values=npy(VALUES), rate=npy(30), kinds=npy(["label", "turn"])),
            "kinds: the kind of a channel is one",
            id="no_kind",
        ),
        pytest.param(
            npz(values=npy(VALUES), rate=npy(30), kinds=npy(["label"] * 2), words=npy(["a"])),
            "words need word_counts",
            id="words",
        ),
        pytest.param(
            npz(values=npy(VALUES), rate=npy(30), kinds=npy(["label"] * 2), words=npy(["a"]), word_counts=npy([0, 2])),
            "word_counts say 2 words, and 1 are there",
            id="a_word_less",
        ),
        pytest.param(
            npz(poses=npy(VALUES), trans=npy(VALUES[:2])), "as many frames as one another; found poses 3", id="lengths"
        ),
        pytest.param(npz(), "no array called values; it has nothing", id="no_member"),
        pytest.param(npz(values=b"hello"), "values.npy is no NumPy array", id="member_of_text"),
        pytest.param(npz(values=npy([{}], allow_pickle=True)), "never loaded", id="objects"),
        pytest.param(npz(values=npy(VALUES), names=npy([{}, 1], allow_pickle=True)), "never loaded", id="object_names"),
        pytest.param(npz(values=npy(VALUES), names=npy(["x"])), "expected 2 texts", id="a_name_missing"),
        pytest.param(npz(values=npy(VALUES), names=npy([1, 2])), "expected 2 texts", id="names_of_numbers"),
        pytest.param(npz(values=npy(VALUES), names=npy(["x", "x"])), "both called 'x'", id="name_twice"),
        pytest.param(
            npz(values=npy(VALUES), names=raw_npy(described("<U1", "(2,)"), b"\xff" * 8)),
            "no text",
            id="names_of_noise",
        ),
        pytest.param(npz(values=npy(VALUES), names=npy(["x" * 2000, "y"])), "Limits.name_bytes", id="long_name"),
        pytest.param(npz(values=npy(VALUES), rate=npy("fast")), "rate: expected a frame rate", id="rate_of_words"),
        pytest.param(npz(values=npy(VALUES), rate=npy(0.0)), "rate: expected a frame rate", id="rate_0"),
        pytest.param(npz(values=npy(VALUES), rate=npy(np.nan)), "rate: expected a frame rate", id="rate_nan"),
        pytest.param(npz(values=npy(VALUES), rate=npy([1, 2])), "expected one number", id="two_rates"),
        pytest.param(npz(values=npy(VALUES), rate=npy(["1", "2"])), "expected one text", id="rate_texts"),
        pytest.param(
            npz(values=npy(VALUES), rate=npy(30), first_frame=npy(0.5)), "expected one number", id="half_a_first_frame"
        ),
        pytest.param(npz(values=npy(VALUES), rate=npy(30))[:-20], "zip archive", id="cut_in_the_directory"),
        pytest.param(npz(values=npy(VALUES), rate=npy(30))[100:], "expected a NumPy array", id="cut_in_front"),
    ],
)
def test_broken_archives(tmp_path: Path, data: bytes, says: str) -> None:
    with pytest.raises(FormatError) as caught:
        read(put(tmp_path, data, "a.npz"))
    assert says in str(caught.value)


@pytest.mark.parametrize(
    "name", ["../values.npy", "/values.npy", "x/../../values.npy", "..\\values.npy", "C:values.npy"]
)
def test_members_that_lead_out_of_the_archive(tmp_path: Path, name: str) -> None:
    with zipfile.ZipFile(tmp_path / "a.npz", "w") as archive:
        archive.writestr("values.npy", npy(VALUES))
        archive.writestr(name, npy(VALUES))
    with pytest.raises(FormatError, match="leads out of the archive"):
        read(tmp_path / "a.npz", rate=25)


def test_a_member_that_is_there_twice(tmp_path: Path) -> None:
    with zipfile.ZipFile(tmp_path / "a.npz", "w") as archive:
        archive.writestr("values.npy", npy(VALUES))
        with pytest.warns(UserWarning, match="Duplicate"):
            archive.writestr("values.npy", npy(VALUES + 1))
    with pytest.raises(FormatError, match=r"two members are called 'values\.npy'"):
        read(tmp_path / "a.npz", rate=25)


def test_encrypted_and_oddly_compressed_members(tmp_path: Path) -> None:
    data = bytearray(npz(values=npy(VALUES)))
    entry = data.index(b"PK\x01\x02")
    data[entry + 8] |= 1
    with pytest.raises(FormatError, match=r"'values\.npy' is encrypted"):
        read(put(tmp_path, bytes(data)), rate=25)
    with zipfile.ZipFile(tmp_path / "a.npz", "w", zipfile.ZIP_LZMA) as archive:
        archive.writestr("values.npy", npy(VALUES))
    with pytest.raises(FormatError, match="compressed by method 14"):
        read(tmp_path / "a.npz", rate=25)


def bomb(member: str = "values.npy", size: int = 16 << 20) -> bytes:
    file = io.BytesIO()
    with zipfile.ZipFile(file, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr(member, npy(np.zeros(size, "i1")))
    return file.getvalue()


def test_bombs_are_refused_before_they_are_made(tmp_path: Path) -> None:
    data = bomb()
    assert len(data) < 100_000
    # Directory that lies: less inflated than there is, or more compressed.
    entry = data.index(b"PK\x01\x02")
    small, large = bytearray(data), bytearray(data)
    small[entry + 24 : entry + 28] = struct.pack("<I", 1000)
    large[entry + 20 : entry + 24] = struct.pack("<I", 16 << 20)
    cases = [
        (data, Limits(), "more than 200:1 (Limits.zip_ratio)"),
        (bomb("other.npy"), Limits(), "Limits.zip_ratio"),
        (data, Limits(zip_ratio=10_000, inflated_bytes=1 << 20), "the limit is 1048576 (Limits.inflated_bytes)"),
        (bytes(small), Limits(), ""),
        (bytes(large), Limits(), "the file has"),
        (raw_npy(described("<f8", "(100000000000,)"), bytes(80)), Limits(), "800000000000 bytes; 80"),
    ]
    paths = [put(tmp_path, case, f"{i}.npz") for i, (case, _, _) in enumerate(cases)]
    tracemalloc.start()
    try:
        for path, (_, limits, says) in zip(paths, cases, strict=True):
            with pytest.raises(FormatError) as caught:
                read(path, rate=25, limits=limits)
            assert says in str(caught.value)
        assert tracemalloc.get_traced_memory()[1] < 5 << 20
    finally:
        tracemalloc.stop()


def test_repair_keeps_whole_frames(tmp_path: Path) -> None:
    with pytest.warns(FormatWarning, match="2 of 3 frames are there and were kept"):
        signal = read_signal(put(tmp_path, npy(VALUES)[:-9]), rate=25, repair=True)
    assert signal.values.tolist() == VALUES[:2].tolist()
    with pytest.raises(FormatError, match="bytes follow"):
        read(put(tmp_path, npy(np.asfortranarray(VALUES))[:-8]), rate=25, repair=True)
    with pytest.raises(FormatError, match="bytes follow"):
        read(put(tmp_path, npy(VALUES) + b"more"), rate=25, repair=True)


@pytest.mark.parametrize("seed", range(5))
def test_damage_ends_in_a_signal_or_a_format_error(tmp_path: Path, seed: int) -> None:
    chance = random.Random(seed)
    signal = Signal(("x", "y"), VALUES, rate=Fraction(25), first_frame=3)
    write(signal, tmp_path / "whole.npz")
    np.savez_compressed(tmp_path / "deflated.npz", values=VALUES, rate=30, names=["x", "y"])
    whole = [(tmp_path / "whole.npz").read_bytes(), (tmp_path / "deflated.npz").read_bytes(), npy(VALUES)]
    outcomes = set()
    for _ in range(150):
        data = bytearray(chance.choice(whole))
        for _ in range(chance.randint(1, 4)):
            at = chance.randrange(len(data))
            kind = chance.randrange(4)
            if kind == 0:
                data[at] = chance.randrange(256)
            elif kind == 1:
                data[at : at + 4] = chance.choice([b"\xff" * 4, b"\0" * 4, b"\x7f\xff\xff\xff"])
            elif kind == 2:
                del data[at : at + chance.randint(1, 6)]
            else:
                data[at:at] = bytes(chance.randrange(256) for _ in range(chance.randint(1, 6)))
        try:
            assert np.isfinite(read_signal(put(tmp_path, bytes(data)), rate=25).values).all()
            outcomes.add("signal")
        except FormatError:
            outcomes.add("error")
    assert outcomes == {"signal", "error"}


# Writing


@settings(deadline=None, max_examples=50)
@given(
    values=hnp.arrays(
        np.float64,
        hnp.array_shapes(min_dims=2, max_dims=2, max_side=5),
        elements=st.floats(-1e100, 1e100),
    ),
    rate=st.fractions(min_value=Fraction(1, 1000), max_value=2000),
    first_frame=st.integers(0, 2**40),
    data=st.data(),
)
def test_a_signal_comes_back(
    tmp_path_factory: pytest.TempPathFactory, values: np.ndarray, rate: Fraction, first_frame: int, data: st.DataObject
) -> None:
    text = st.text(st.characters(exclude_categories=("Cs",), exclude_characters="\0"), max_size=6)
    names = data.draw(st.lists(text, min_size=values.shape[1], max_size=values.shape[1], unique=True))
    signal = Signal(tuple(names), values, rate=rate, first_frame=first_frame)
    path = tmp_path_factory.mktemp("npz") / "a.npz"
    write(signal, path)
    again = read_signal(path)
    assert (again.names, again.rate, again.first_frame) == (signal.names, rate, first_frame)
    assert again.values.tobytes() == signal.values.tobytes()
    # Anybody's NumPy reads it.
    with np.load(path, allow_pickle=False) as archive:
        assert archive["values"].tobytes() == signal.values.tobytes()


def test_the_same_signal_gives_the_same_bytes(tmp_path: Path) -> None:
    signal = Signal(("x", "y"), VALUES)
    write(signal, tmp_path / "a.npz")
    write(signal, tmp_path / "b.npz")
    assert (tmp_path / "a.npz").read_bytes() == (tmp_path / "b.npz").read_bytes()


def test_a_npy_holds_the_values_alone(tmp_path: Path) -> None:
    write(Signal(("c0", "c1"), VALUES), tmp_path / "a.npy")
    assert np.load(tmp_path / "a.npy").tolist() == VALUES.tolist()
    with pytest.warns(FormatWarning, match="the names of 2 channels are not kept"):
        write(Signal(("x", "y"), VALUES), tmp_path / "b.npy")


def test_existing_files_and_motions(tmp_path: Path) -> None:
    signal = Signal(("c0", "c1"), VALUES)
    for name in ("a.npy", "a.npz"):
        put(tmp_path, b"mine", name)
        with pytest.raises(OutputExistsError):
            write(signal, tmp_path / name)
        assert (tmp_path / name).read_bytes() == b"mine"
        write(signal, tmp_path / name, overwrite=True)
        assert read_signal(tmp_path / name, rate=30).values.tolist() == VALUES.tolist()
    motion = Motion(Skeleton(("a",), (-1,), np.zeros((1, 3))), np.array([[[1.0, 0, 0, 0]]]))
    with pytest.raises(FormatError, match="holds a signal"):
        write(motion, tmp_path / "b.npz")


@pytest.mark.parametrize(
    ("shape", "names"),
    [
        ((4, 3, 2), ("m0.x", "m0.y", "m1.x", "m1.y", "m2.x", "m2.y")),
        ((4, 2, 3), ("m0.x", "m0.y", "m0.z", "m1.x", "m1.y", "m1.z")),
        ((4, 1, 6), tuple(f"m0.{i}" for i in range(6))),
        ((4, 2, 5), tuple(f"m{point}.{i}" for point in range(2) for i in range(5))),
        ((1, 4, 3, 2), ("m0.x", "m0.y", "m1.x", "m1.y", "m2.x", "m2.y")),
        # One frame of four points would be none to retime.
        ((1, 4, 3), ("c0", "c1", "c2")),
    ],
)
def test_points_are_read_as_they_come_and_written_so(tmp_path: Path, shape, names) -> None:
    values = np.random.default_rng(0).normal(size=shape)
    signal = read_signal(put(tmp_path, npy(values)), rate=30)
    assert (signal.names, signal.n_frames) == (names, 4)
    assert np.array_equal(signal.values, values.reshape(4, -1))
    if shape[-1] != 5:
        write(signal, tmp_path / "back.npy")
        assert np.load(tmp_path / "back.npy").shape == (shape[1:] if shape[0] == 1 else shape)


def test_fours_of_unit_length_are_rotations(tmp_path: Path) -> None:
    q = np.random.default_rng(1).normal(size=(5, 3, 4))
    unit = q / np.linalg.norm(q, axis=2, keepdims=True)
    turning, other = (read_signal(put(tmp_path, npy(values)), rate=30) for values in (unit, q))
    assert {str(kind) for kind in turning.kinds} == {"quaternion"}
    assert {str(kind) for kind in other.kinds} == {"linear"}
    between = turning.at([0.5 / 30]).values.reshape(3, 4)
    np.testing.assert_allclose(np.linalg.norm(between, axis=1), 1, atol=1e-12)
    # Each between its own two: as far from one as from the other.
    away = [np.abs(np.einsum("jc,jc->j", between, unit[frame])) for frame in (0, 1)]
    np.testing.assert_allclose(*away, atol=1e-9)


@pytest.mark.parametrize("key", ["rate", "fps", "framerate", "frame_rate", "mocap_framerate", "mocap_frame_rate"])
def test_the_rate_has_many_names(tmp_path: Path, key: str) -> None:
    path = put(tmp_path, npz(poses=npy(np.zeros((3, 6))), trans=npy(np.ones((3, 3))), **{key: npy(59.94)}), "a.npz")
    signal = read_signal(path)
    assert signal.rate == Fraction(60000, 1001)
    assert signal.names == (*(f"poses.{i}" for i in range(6)), "trans.x", "trans.y", "trans.z")
    assert np.array_equal(signal.values[:, 6:], np.ones((3, 3)))


def test_an_array_is_chosen_by_name(tmp_path: Path) -> None:
    points = np.random.default_rng(2).normal(size=(3, 2, 2))
    members = {
        "keypoints": npy(points),
        "other": npy(np.zeros((3, 1))),
        "joint_names": npy(["hip", "knee"]),
        "notes": npy([{}], allow_pickle=True),
    }
    path = put(tmp_path, npz(**members), "a.npz")
    signal = read_signal(path, rate=30, array="keypoints")
    assert signal.names == ("hip.x", "hip.y", "knee.x", "knee.y")
    both = read_signal(path, rate=30, array=["other", "keypoints"])
    assert both.names == ("other.0", *(f"keypoints.{name}" for name in signal.names))
    with pytest.raises(FormatError, match="no array called poses; it has 'keypoints', 'other', 'joint_names', 'notes'"):
        read(path, rate=30, array="poses")
    del members["other"]
    # The only one that could be meant needs no naming; an object is none.
    assert read_signal(put(tmp_path, npz(**members), "a.npz"), rate=30).names == signal.names


def test_an_archive_keeps_what_channels_hold(tmp_path: Path) -> None:
    codes, said = text_label(["walk", "run", "walk"])
    values = np.column_stack([codes, [1.0, np.nan, 3.0], [0, 1, 0], [0.5, 0.25, 0.125]])
    kinds = [said, "linear:cm", "label", "angle:rad"]
    before = Signal(("action", "x", "n", "a"), values, 25, kinds=kinds, gaps="keep")
    write(before, tmp_path / "kept.npz")
    with pytest.warns(FormatWarning, match="kept gaps: x frames 1:1"):
        after = read_signal(tmp_path / "kept.npz", gaps="keep")
    assert after.kinds == before.kinds
    assert after.texts("action") == ["walk", "run", "walk"]
    assert np.array_equal(after.values, before.values, equal_nan=True)
    with pytest.raises(FormatError, match="'x' at frame 1 is not finite: nan; --gaps bridge fills gaps"):
        read(tmp_path / "kept.npz")


def test_a_damaged_archive_is_not_quoted_at_length(tmp_path: Path) -> None:
    np.savez_compressed(tmp_path / "whole.npz", values=np.arange(6000.0).reshape(-1, 3), rate=30)
    data = bytearray((tmp_path / "whole.npz").read_bytes())
    # The first local header claims a name of 3,000 bytes, which zipfile quotes.
    data[26:28] = struct.pack("<H", 3000)
    (tmp_path / "broken.npz").write_bytes(data)
    with pytest.raises(FormatError, match=r"a damaged zip archive: File name in directory .*\.\.\.$") as refused:
        read(tmp_path / "broken.npz")
    assert len(refused.value.problem) < 200


@pytest.mark.parametrize("start", [Fraction("2.235"), Fraction(-1, 8), Fraction(1_700_000_000), Fraction(3, 10)])
def test_the_time_of_the_first_frame_comes_back(tmp_path: Path, start: Fraction) -> None:
    signal = Signal(("x",), np.arange(5.0)[:, None], 10, first_frame=3, clock=Clock("ms", start, "2235"))
    write(signal, tmp_path / "a.npz")
    again = read(tmp_path / "a.npz")
    assert isinstance(again, Signal)
    assert (again.clock.start, again.first_frame) == (start if start != Fraction(3, 10) else None, 3)
    assert again.start_time == float(start)
    np.savez(tmp_path / "b.npz", values=np.zeros((3, 1)), rate=10, start_time=np.inf)
    with pytest.raises(FormatError, match="start_time is inf; expected seconds"):
        read(tmp_path / "b.npz")
