"""The file that a report holds: no name is in it, and it is read, or refused, as the one that it stands for."""

from __future__ import annotations

import base64
import io
import json
import random
import re
import warnings
import zipfile
from dataclasses import replace
from pathlib import Path
from urllib.parse import unquote

import numpy as np
import pytest

from retime import Motion, read, write
from retime.errors import FormatError
from retime.formats.read_options import Limits, ReadOptions
from retime.issue_report import report as reports
from retime.issue_report.report import STRIPPINGS, Reading, Report, make_report
from retime.motion.joint_signal import joint_signal
from tests.cli.figures import figure
from tests.formats.c3d_files import Capture

DATA = Path(__file__).resolve().parents[1] / "data"
ARM = DATA / "amc" / "arm.asf"
BROKEN = sorted([*DATA.glob("bvh/broken_*.bvh"), *DATA.glob("amc/broken/*.amc"), *DATA.glob("csv/broken/*.csv")])
WHOLE = sorted(path for path in DATA.rglob("*") if path.suffix in STRIPPINGS and path not in BROKEN)
SECRET = ("Annabel", "Backflip", "Wagner")


def reported(path: Path, **options: object) -> Report:
    return make_report(path, Reading(ReadOptions(**options)), build=[("retime", "1")])


def unpacked(report: Report, folder: Path) -> Path:
    """Unpack a report, and return the clip that is in it."""
    folder.mkdir()
    with zipfile.ZipFile(io.BytesIO(report.archive())) as archive:
        archive.extractall(folder)
    (clip,) = (path for path in folder.iterdir() if path.stem == "clip" and path.suffix not in (".asf", ".bin"))
    return clip


def ending(path: Path, **options: object) -> tuple[str, str, list[str]]:
    """Return the error's class, its message, and the warnings of reading a file, all that is quoted left out."""

    def plain(message: str) -> str:
        without_path = re.sub(r"\S*/[^\s:]*", "FILE", message).replace(path.name, "FILE")
        return re.sub(r"'[^']*'|\"[^\"]*\"|(?<=it has ).*", "Q", without_path)

    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        try:
            read(path, **options)
        except Exception as error:
            return type(error).__name__, plain(str(error)), [plain(str(one.message)) for one in caught]
    return "", "", [plain(str(one.message)) for one in caught]


@pytest.mark.parametrize("path", BROKEN, ids=lambda path: path.name)
def test_a_broken_file_still_fails_in_the_same_way(path, tmp_path) -> None:
    options = {"skeleton": ARM} if path.suffix == ".amc" else {}
    report = reported(path, **options)
    assert report.same, report.text
    clip = unpacked(report, tmp_path / "out")
    if options:
        options = {"skeleton": clip.with_name("clip.asf")} if clip.with_name("clip.asf").exists() else options
    ours = ending(path, **({"skeleton": ARM} if path.suffix == ".amc" else {}))
    assert ours[0] == "FormatError"
    theirs = ending(clip, **options)
    # Lines may have been left out.
    numbers = re.compile(r"[0-9]+")
    assert [numbers.sub("#", text) for text in (*ours[:2], *ours[2])] == [
        numbers.sub("#", text) for text in (*theirs[:2], *theirs[2])
    ]


@pytest.mark.parametrize("path", WHOLE, ids=lambda path: path.name)
def test_what_is_odd_but_whole_is_read_in_the_same_way(path, tmp_path) -> None:
    options = {"skeleton": ARM} if path.suffix == ".amc" else {}
    report = reported(path, **options)
    assert report.same, report.text


def secret_motion() -> Motion:
    motion = figure("Annabel_Wagner", seconds=3)
    skeleton = motion.skeleton
    names = tuple(f"{SECRET[index % 3]}{chr(65 + index)}" for index in range(len(skeleton.names)))
    return replace(motion, skeleton=replace(skeleton, names=names))


def secret_file(suffix: str, folder: Path) -> Path:
    path = folder / f"Annabel_Backflip{suffix}"
    motion = secret_motion()
    if suffix == ".c3d":
        labels = ("AnnabelHead", "WagnerFoot")
        points = np.random.default_rng(5).normal(size=(60, 2, 4)) * [1, 1, 1, 0]
        path.write_bytes(Capture(points=points, labels=labels).build())
    elif suffix in (".csv", ".tsv", ".npz"):
        write(joint_signal(motion), path)
    elif suffix == ".npy":
        np.save(path, np.random.default_rng(1).normal(size=(90, 6)))
    else:
        write(motion, path)
    return path


WRITTEN = (".bvh", ".amc", ".csv", ".tsv", ".npz", ".npy", ".c3d", ".glb", ".gltf", ".fbx")


@pytest.mark.parametrize("suffix", WRITTEN)
def test_no_name_is_in_the_report_and_it_is_small(suffix, tmp_path) -> None:
    path = secret_file(suffix, tmp_path)
    options = {"rate": 60} if suffix == ".npy" else {}
    report = reported(path, **options)
    assert report.same, report.text
    everything = b"\n".join([report.text.encode(), *report.files.values(), *(name.encode() for name in report.files)])
    if suffix == ".npz":
        with zipfile.ZipFile(io.BytesIO(report.files["clip.npz"])) as archive:
            everything += b"".join(archive.read(name) + name.encode() for name in archive.namelist())
    # Text of NumPy takes four bytes a letter.
    plain = everything.replace(b"\0", b"").lower()
    assert not [name for name in SECRET if name.lower().encode() in plain]
    assert str(tmp_path).encode() not in everything
    assert len(report.archive()) < 100_000
    clip = unpacked(report, tmp_path / "out")
    ours, theirs = read(path, **options), read(clip, **options)
    assert type(theirs) is type(ours)
    assert theirs.rate == ours.rate
    if isinstance(ours, Motion):
        assert theirs.skeleton.parents == ours.skeleton.parents
        np.testing.assert_allclose(theirs.skeleton.offsets, ours.skeleton.offsets)
        np.testing.assert_allclose(theirs.rotations[:5], ours.rotations[:5], atol=1e-12)


def damaged(data: bytes, seed: int) -> bytes:
    """Change some bytes of a file, cut it, leave some out, or put some in again elsewhere."""
    rng = random.Random(seed)
    changed = bytearray(data)
    kind = rng.choice(["flip", "cut", "leave out", "say twice"])
    if kind == "flip":
        for _ in range(rng.choice([1, 3, 20])):
            changed[rng.randrange(len(changed))] = rng.randrange(256)
    elif kind == "cut":
        del changed[rng.randrange(len(changed)) :]
    elif kind == "say twice":
        start, place = rng.randrange(len(changed)), rng.randrange(len(changed))
        changed[place:place] = changed[start : start + rng.randrange(200)]
    else:
        start = rng.randrange(len(changed))
        del changed[start : start + rng.randrange(100)]
    return bytes(changed)


@pytest.mark.parametrize("suffix", WRITTEN)
def test_a_damaged_file_gives_a_report_without_names(suffix, tmp_path) -> None:
    path = secret_file(suffix, tmp_path)
    whole = path.read_bytes()
    n_same = 0
    for seed in range(25):
        path.write_bytes(damaged(whole, seed))
        report = reported(path, **({"rate": 60} if suffix == ".npy" else {}))
        plain = b"".join([report.text.encode(), *report.files.values()]).replace(b"\0", b"").lower()
        assert not [name for name in SECRET if name.lower().encode() in plain], seed
        n_same += report.same
    # An archive that can't be opened can't be stripped either, and of one with a wrong checksum little is left.
    assert n_same >= (5 if suffix == ".npz" else 12)


def test_the_binary_frames_in_the_middle_are_left_out(tmp_path) -> None:
    path = secret_file(".npy", tmp_path)
    kept = np.load(unpacked(reported(path, rate=60), tmp_path / "out"))
    ours = np.load(path)
    np.testing.assert_array_equal(kept[:5], ours[:5])
    np.testing.assert_array_equal(kept[-2:], ours[-2:])
    np.testing.assert_array_equal(kept[5:-2], np.broadcast_to(ours[0], kept[5:-2].shape))


def test_a_fault_in_the_middle_of_a_long_file_is_in_the_report(tmp_path) -> None:
    path = tmp_path / "long.bvh"
    write(figure(seconds=20), path)
    lines = path.read_text().splitlines(keepends=True)
    lines[700] = "0.5 what 1.5\n"
    path.write_text("".join(lines))
    report = reported(path)
    assert report.same
    clip = unpacked(report, tmp_path / "out")
    kept = clip.read_text().splitlines()
    assert len(kept) < 70
    (at_fault,) = (index for index, line in enumerate(kept) if re.fullmatch(r"0\.5 [a-z]{4} 1\.5", line))
    assert "what" not in kept[at_fault]
    with pytest.raises(FormatError, match=r"values|number") as caught:
        read(clip)
    assert caught.value.line == at_fault + 1


def test_a_word_that_matters_can_be_kept_and_its_loss_is_said(tmp_path) -> None:
    # What names tell, the report can't keep: two columns of one name are told apart by it alone.
    path = tmp_path / "t.csv"
    path.write_text("time,who\n0,Ann\n0.1,nan\n0.2,Ann\n")
    masked = make_report(path, Reading(ReadOptions()), build=[])
    kept = make_report(path, Reading(ReadOptions()), build=[], keep=["Ann"])
    assert b"Ann" not in masked.files["clip.csv"]
    assert b"Ann" in kept.files["clip.csv"]
    assert "Ann" in kept.stayed


def test_what_nobody_expected_is_reported_with_its_place_in_retime(tmp_path, monkeypatch) -> None:
    path = tmp_path / "Annabel.bvh"
    write(secret_motion(), path)
    from retime.formats import bvh

    def broken(path: Path, data: bytes, options: ReadOptions) -> Motion:
        raise IndexError(f"no joint AnnabelA in {path}")

    monkeypatch.setattr(bvh, "read", broken)
    report = reported(path)
    assert report.same
    assert "it ended in IndexError: no joint" in report.text
    assert re.search(r"^  in retime/formats/registry.py:\d+ read_with$", report.text, re.M)
    assert "Annabel" not in report.text
    assert str(tmp_path) not in report.text


def test_keypoints_lose_the_names_that_nobody_knows(tmp_path) -> None:
    path = tmp_path / "Annabel.json"
    points = [{"x": 0.3, "y": 0.01 * n, "z": 0, "visibility": 0.9} for n in range(33)]
    frames = [{"time": n / 30, "by": "Annabel", "landmarks": points} for n in range(9)]
    path.write_text(json.dumps({"of": "Wagner", "frames": frames}), encoding="utf-8")
    report = reported(path, confidence=0.5)
    assert report.same, report.text
    assert "--confidence 0.5" in report.text
    content = report.files["clip.json"]
    assert not [name for name in SECRET if name.encode() in content]
    assert len(json.loads(content)["frames"]) == 9


def test_a_report_that_would_be_too_large_says_so(tmp_path, monkeypatch) -> None:
    path = secret_file(".glb", tmp_path)
    monkeypatch.setattr(reports, "MOST_BYTES", 100)
    report = reported(path)
    assert not report.files
    assert not report.same
    assert "nothing of it fits" in report.text


def test_of_a_file_that_can_not_be_stripped_only_what_happened_is_told(tmp_path) -> None:
    path = tmp_path / "Annabel.parquet"
    path.write_bytes(b"PAR1 Annabel")
    report = reported(path)
    assert not report.files
    assert "it ended in" in report.text
    assert "Annabel" not in report.text


@pytest.mark.parametrize(
    ("message", "told"),
    [
        ("the member 'Annabel' is too large", "the member '...' is too large"),
        # The apostrophe of a word is no quotation mark.
        (
            "it can't be read: 'Annabel' in </Wagner/Annabel.rotations>",
            "it can't be read: '...' in </.../....rotations>",
        ),
        ("column Annabel_2 holds 12 of 3.5", "column ... holds 12 of 3.5"),
    ],
)
def test_what_is_no_word_of_ours_is_left_out_where_no_name_is_known(tmp_path, monkeypatch, message, told) -> None:
    path = tmp_path / "walk.npz"
    path.write_bytes(b"PK\x03\x04 cut short")

    def refuse(path: Path, data: bytes, options: ReadOptions) -> Motion:
        raise FormatError(message, path=path)

    monkeypatch.setattr("retime.formats.npy.read", refuse)
    monkeypatch.setattr(reports, "MOST_BYTES", 0)
    report = reported(path)
    assert f"clip.npz: {told}" in report.text
    assert not [name for name in ("Annabel", "Wagner") if name in report.text]


@pytest.mark.parametrize("uri", ["Annabel buffer.bin", "Annabel%20buffer.bin", "%41nnabel%C3%A9.bin", "of/Annabel.bin"])
def test_buffers_beside_a_scene_go_with_it(tmp_path, uri) -> None:
    path = secret_file(".gltf", tmp_path)
    document = json.loads(path.read_text(encoding="utf-8"))
    place = tmp_path / unquote(uri)
    place.parent.mkdir(exist_ok=True)
    place.write_bytes(base64.b64decode(document["buffers"][0]["uri"].partition(",")[2]))
    document["buffers"][0]["uri"] = uri
    path.write_text(json.dumps(document), encoding="utf-8")
    report = reported(path)
    assert report.same, report.text
    assert len(report.files) == 2
    assert not [name for name in report.files if "nnabel" in name]
    assert b"nnabel" not in report.archive() + report.files["clip.gltf"]
    place.unlink()
    # That it is missing is what the report is about.
    report = reported(path)
    # Letters that an address writes as numbers are met nowhere else, so of a message that quotes them nobody can tell.
    assert report.same == (uri[0] != "%"), report.text
    assert "No such file" in report.text
    assert "nnabel" not in report.text


@pytest.mark.parametrize("folder", [".", "a", "Annabel"])
def test_folders_go_from_messages_and_nothing_else_does(tmp_path, monkeypatch, folder) -> None:
    (tmp_path / folder).mkdir(exist_ok=True)
    path = secret_file(".gltf", tmp_path / folder)
    document = json.loads(path.read_text(encoding="utf-8"))
    document["buffers"][0]["uri"] = "../data/Annabel.bin"
    path.write_text(json.dumps(document), encoding="utf-8")
    monkeypatch.chdir(tmp_path)
    report = reported(Path(folder) / path.name)
    assert report.same, report.text
    assert re.search(r"folder: '\.\./\w{4}/\w{7}\.bin'", report.text), report.text
    assert "Annabel" not in report.text


def test_a_file_past_the_limits_is_told_of_and_not_in_it(tmp_path) -> None:
    path = tmp_path / "walk.bvh"
    write(figure(), path)
    report = make_report(path, Reading(ReadOptions(limits=Limits(file_bytes=100))), build=[])
    assert "Limits.file_bytes" in report.text
    assert not report.files


def test_options_are_in_the_report_with_the_names_replaced(tmp_path) -> None:
    path = tmp_path / "walk.bvh"
    write(secret_motion(), path)
    report = make_report(path, Reading(ReadOptions(), root="AnnabelA"), build=[])
    assert report.same
    assert "--root Nnnnnnnn" in report.text
    assert "Annabel" not in report.text


def test_the_same_report_has_the_same_bytes(tmp_path) -> None:
    path = secret_file(".bvh", tmp_path)
    assert reported(path).archive() == reported(path).archive()
