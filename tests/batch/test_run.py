"""A library from start to end, without Dask: trees, resuming, what changed, cuts, labels, variants."""

from __future__ import annotations

import json
import os
import shutil
from pathlib import Path

import numpy as np
import pytest

import retime
from retime.batch import BatchResult, ClipTask, Recipe, Rule, Treatment, retime_clip, run
from retime.batch.manifest import Journal, Manifest, read_manifest
from retime.batch.treatment import settings
from retime.errors import OptionError
from retime.formats.c3d_file import parse_c3d
from retime.formats.read_options import ReadOptions
from tests.formats.body_files import body, npz
from tests.formats.c3d_files import Capture


def made_clip(place: Path, start: int = 0, n: int = 40) -> Path:
    place.parent.mkdir(parents=True, exist_ok=True)
    retime.write(retime.sample().frames(start, start + n), place)
    return place


@pytest.fixture
def library(tmp_path: Path) -> Path:
    root = tmp_path / "in"
    for i, name in enumerate(("walks/a.bvh", "walks/slow/b.bvh", "c.bvh")):
        made_clip(root / name, 60 * i)
    (root / "walks" / "broken.bvh").write_text("HIERARCHY\nnothing")
    (root / ".hidden").mkdir()
    made_clip(root / ".hidden" / "d.bvh")
    (root / "notes.txt").write_text("no clip")
    rows = "\n".join(f"{np.sin(i * i / 90)},{i % 3}" for i in range(50))
    (root / "arm.csv").write_text(f"x,y\n{rows}\n")
    return root


def done(library: Path, out: Path, given: object, **more: object) -> BatchResult:
    return run(library, out, given, workers=0, **more)  # type: ignore[arg-type]


def test_captures_are_retimed_in_place(tmp_path: Path) -> None:
    root, out = tmp_path / "in", tmp_path / "out"
    root.mkdir()
    points = np.zeros((60, 1, 4))
    points[:, 0, 0] = np.sin(np.arange(60) / 5) * 100
    members = body(n_frames=60)
    (root / "take.c3d").write_bytes(Capture(rate=30.0, points=points, analog=np.arange(120.0)[:, None]).build())
    (root / "walk.npz").write_bytes(npz(members))
    result = done(root, out, {"length": "80%", "frames": "10:49"})
    assert result.counts == {"done": 2, "kept": 0, "failed": 0}, [record.message for record in result.records]
    capture = parse_c3d(out / "take.c3d", (out / "take.c3d").read_bytes(), ReadOptions())
    assert (capture.first, capture.n_frames, capture.layout.samples) == (10, 32, 2)
    with np.load(out / "walk.npz") as archive:
        assert np.array_equal(archive["betas"], members["betas"])
        assert archive["poses"].shape == (32, 156)
        np.testing.assert_allclose(archive["trans"][[0, -1]], members["trans"][[10, 49]])


def test_the_tree_is_mirrored_and_each_output_is_that_of_the_single_command(library: Path, tmp_path: Path) -> None:
    result = done(library, tmp_path / "out", {"length": "80%", "fps": 30})
    assert result.counts == {"done": 4, "kept": 0, "failed": 1}
    assert [record.output for record in result.records] == [
        "arm.csv",
        "c.bvh",
        "walks/a.bvh",
        "",
        "walks/slow/b.bvh",
    ]
    for record in result.records:
        if record.status == "failed":
            assert (record.name, record.code) == ("walks/broken.bvh", "format")
            assert "broken.bvh:2" in record.message
            continue
        clip = retime.read(library / record.name, rate=30)
        found = retime.guided_warp(clip, length="80%")
        expected = tmp_path / f"single{Path(record.name).suffix}"
        retime.write(found.apply(clip), expected, overwrite=True)
        assert (tmp_path / "out" / record.output).read_bytes() == expected.read_bytes()
        assert (record.frames_in, record.frames_out) == (clip.n_frames, found.warp.count_frames(30))
        assert record.total == found.total
    lines = list(read_manifest(tmp_path / "out"))
    assert [line.name for line in lines] == [record.name for record in result.records]
    assert not list((tmp_path / "out").rglob("*.tmp"))
    assert [path.name for path in (tmp_path / "out" / ".retime").iterdir()] == ["lock"]


def test_what_is_there_is_kept_and_what_changed_is_done_again(library: Path, tmp_path: Path) -> None:
    out = tmp_path / "out"
    reference = made_clip(tmp_path / "limp.bvh", 200)
    given = {"length": "80%", "reference": str(reference), "channel": []}
    shutil.rmtree(library / "walks" / "slow")
    (library / "arm.csv").unlink()
    assert done(library, out, given).counts == {"done": 2, "kept": 0, "failed": 1}
    times = {path: path.stat().st_mtime_ns for path in out.rglob("*.bvh")}
    again = done(library, out, given)
    assert again.counts == {"done": 0, "kept": 2, "failed": 1}
    assert {path: path.stat().st_mtime_ns for path in out.rglob("*.bvh")} == times
    # The clip's bytes, the settings, the reference's bytes: each counts, whatever the time of the file says.
    before = (library / "c.bvh").stat()
    data = (library / "c.bvh").read_bytes()
    digit = data.rindex(b"1")
    (library / "c.bvh").write_bytes(data[:digit] + b"2" + data[digit + 1 :])
    os.utime(library / "c.bvh", ns=(before.st_atime_ns, before.st_mtime_ns + 1))
    assert done(library, out, given).counts == {"done": 1, "kept": 1, "failed": 1}
    assert done(library, out, given | {"length": "90%"}).counts == {"done": 2, "kept": 0, "failed": 1}
    made_clip(tmp_path / "other.bvh", 240)
    reference.write_bytes((tmp_path / "other.bvh").read_bytes())
    assert done(library, out, given | {"length": "90%"}).counts == {"done": 2, "kept": 0, "failed": 1}
    # A mended clip is no failure any more; one that was taken away is made again.
    made_clip(tmp_path / "mended.bvh", 20)
    (library / "walks" / "broken.bvh").write_bytes((tmp_path / "mended.bvh").read_bytes())
    (out / "c.bvh").unlink()
    result = done(library, out, given | {"length": "90%"})
    assert result.counts == {"done": 2, "kept": 1, "failed": 0}
    assert done(library, out, given | {"length": "90%"}, restart=True).counts == {"done": 3, "kept": 0, "failed": 0}


def test_a_run_that_died_is_gone_on_with(library: Path, tmp_path: Path) -> None:
    out = tmp_path / "out"
    (out / "walks").mkdir(parents=True)
    task = ClipTask(
        str(library / "c.bvh"), "c.bvh", str(out), ("c.bvh",), Treatment().with_(settings({"length": "80%"}))
    )
    # One process wrote an output and said so; another was about to, and had got as far as a file; a line is torn.
    journal = Journal(out)
    journal.intend(task)
    journal.written(retime_clip(task))
    other = Journal(out)
    other.intend(ClipTask("", "walks/a.bvh", str(out), ("walks/a.bvh",), Treatment()))
    (out / "walks" / "a.bvh").write_text("half")
    journals = list((out / ".retime").glob("journal-*"))
    with max(journals, key=lambda path: path.stat().st_size).open("ab") as file:
        file.write(b'{"name": "walks/a.bvh", "outp')
    journal.close()
    other.close()
    result = done(library, out, {"length": "80%"})
    assert {record.name: record.status for record in result.records} == {
        "arm.csv": "failed",
        "c.bvh": "kept",
        "walks/a.bvh": "done",
        "walks/broken.bvh": "failed",
        "walks/slow/b.bvh": "done",
    }


def test_a_stranger_s_file_is_not_replaced(library: Path, tmp_path: Path) -> None:
    out = tmp_path / "out"
    out.mkdir()
    (out / "c.bvh").write_text("mine")
    result = done(library, out, {"length": "80%", "fps": 30})
    (failure,) = [record for record in result.failures if record.name == "c.bvh"]
    assert failure.code == "exists"
    assert (out / "c.bvh").read_text() == "mine"
    assert done(library, out, {"length": "80%", "fps": 30}, force=True, retry=True).counts["failed"] == 1
    assert (out / "c.bvh").read_text() != "mine"


def test_two_runs_in_one_folder_are_refused(tmp_path: Path) -> None:
    manifest = Manifest(tmp_path)
    with pytest.raises(OptionError, match="another run is at work"):
        Manifest(tmp_path)
    manifest.close()
    Manifest(tmp_path).close()


def test_folders_in_one_another_are_refused(library: Path) -> None:
    for out in (library, library / "out", library.parent):
        with pytest.raises(OptionError, match="lie in one another"):
            done(library, out, {})


def test_two_clips_of_one_output_are_refused(library: Path, tmp_path: Path) -> None:
    shutil.copy(library / "c.bvh", library / "c.csv")
    with pytest.raises(OptionError, match=r"c\.bvh and c\.csv would both be written as c\.npz"):
        done(library, tmp_path / "out", {"format": ".npz"})


def test_recipes_reach_their_clips(library: Path, tmp_path: Path) -> None:
    recipe = Recipe(
        Treatment().with_(settings({"length": "80%", "fps": 30})),
        (Rule("walks/*", settings({"length": "120%"})), Rule("arm*", {}, skip=True)),
        {"c.bvh": settings({"frames": "0:19", "method": "linear"})},
    )
    result = done(library, tmp_path / "out", recipe)
    lengths = {record.name: (record.frames_in, record.frames_out) for record in result.records if not record.code}
    assert lengths == {"c.bvh": (20, 16), "walks/a.bvh": (40, 48), "walks/slow/b.bvh": (40, 48)}


def test_variants_depend_on_the_clip_s_name_alone(library: Path, tmp_path: Path) -> None:
    (library / "arm.csv").unlink()
    given = {"variants": 3, "speeds": "0.8..1.25", "seed": 1}
    result = done(library, tmp_path / "out", given)
    made = [record for record in result.records if record.status == "done"]
    assert [record.output for record in made[:3]] == ["c_1.bvh", "c_2.bvh", "c_3.bvh"]
    assert [record.variant for record in made[:3]] == [1, 2, 3]
    assert all(0.79 < record.frames_out / record.frames_in < 1.26 for record in made)
    assert len({(tmp_path / "out" / record.output).read_bytes() for record in made}) == len(made)
    # Alone, elsewhere, in another order: the same draws.
    shutil.rmtree(library / "walks")
    alone = done(library, tmp_path / "alone", given)
    for record in alone.records:
        assert (tmp_path / "alone" / record.output).read_bytes() == (tmp_path / "out" / record.output).read_bytes()
    other = done(library, tmp_path / "seed", given | {"seed": 2})
    assert (tmp_path / "seed" / "c_1.bvh").read_bytes() != (tmp_path / "out" / "c_1.bvh").read_bytes()
    assert other.counts["done"] == 3


def test_files_beside_go_along(library: Path, tmp_path: Path) -> None:
    (library / "walks" / "a_labels.json").write_text(json.dumps([{"start_frame": 0, "end_frame": 39, "act": "walk"}]))
    (library / "c_labels.csv").write_text("start_t,end_t,act\n0,0.3,step\n")
    result = done(
        library, tmp_path / "out", {"length": "50%", "beside": ["{stem}_labels.json", "{stem}_labels.csv"], "fps": 60}
    )
    assert not (tmp_path / "out" / "notes.txt").exists()
    frames = {record.name: record.frames_out for record in result.records}
    assert json.loads((tmp_path / "out" / "walks" / "a_labels.json").read_text()) == [
        {"start_frame": 0, "end_frame": frames["walks/a.bvh"] - 1, "act": "walk"}
    ]
    assert (tmp_path / "out" / "c_labels.csv").read_text().startswith("start_t,end_t,act\n0,0.1")
    assert "c_labels.csv" not in frames
    # Each variant has labels of its own, under its name: the new library is one whose labels are found again.
    given = {"variants": 2, "seed": 1, "beside": ["{stem}_labels.csv"]}
    done(library, tmp_path / "varied", given)
    assert {path.name for path in (tmp_path / "varied").glob("*.csv")} == {"c_1_labels.csv", "c_2_labels.csv"}
    again = done(tmp_path / "varied", tmp_path / "again", {"length": "50%", "beside": ["{stem}_labels.csv"]})
    assert again.counts["failed"] == 0
    assert {path.name for path in (tmp_path / "again").glob("*.csv")} == {"c_1_labels.csv", "c_2_labels.csv"}


def test_cuts_of_100style_are_honoured_and_remapped(tmp_path: Path) -> None:
    root = tmp_path / "in"
    made_clip(root / "Aeroplane" / "Aeroplane_FW.bvh", 0, 60)
    made_clip(root / "Aeroplane" / "Aeroplane_ID.bvh", 60, 50)
    (root / "Frame_Cuts.csv").write_text(
        "STYLE_NAME,BR_START,BR_STOP,FW_START,FW_STOP,ID_START,ID_STOP\nAeroplane,N/A,N/A,10,49,5,44\n"
    )
    result = done(root, tmp_path / "out", {"length": "50%"})
    assert {record.name: (record.frames_in, record.frames_out) for record in result.records} == {
        "Aeroplane/Aeroplane_FW.bvh": (40, 20),
        "Aeroplane/Aeroplane_ID.bvh": (40, 20),
    }
    assert (tmp_path / "out" / "Frame_Cuts.csv").read_text() == (
        "STYLE_NAME,BR_START,BR_STOP,FW_START,FW_STOP,ID_START,ID_STOP\nAeroplane,N/A,N/A,0,19,0,19\n"
    )


def test_a_task_and_its_records_come_back_from_json(library: Path, tmp_path: Path) -> None:
    task = ClipTask(
        str(library / "c.bvh"),
        "c.bvh",
        str(tmp_path),
        ("c_1.bvh", "c_2.bvh"),
        Treatment().with_(settings({"variants": 2, "seed": 3})),
        ((str(library / "c.csv"), ("c_1.csv", "c_2.csv")),),
        overwrite=True,
    )
    assert ClipTask.from_json(json.loads(json.dumps(task.to_json()))) == task


def test_an_unexpected_error_is_one_clip_s(library: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def breaks(*given: object, **more: object) -> None:
        raise ZeroDivisionError("of no kind that is known")

    monkeypatch.setattr("retime.batch.clip.guided_warp", breaks)
    task = ClipTask(str(library / "c.bvh"), "c.bvh", str(tmp_path), ("c.bvh",), Treatment())
    (record,) = retime_clip(task)
    assert (record.status, record.code) == ("failed", "unexpected")
    assert "ZeroDivisionError: of no kind that is known (test_run.py:" in record.message


def test_a_free_length_needs_a_search(library: Path, tmp_path: Path) -> None:
    task = ClipTask(
        str(library / "c.bvh"),
        "c.bvh",
        str(tmp_path),
        ("c.bvh",),
        Treatment(method="linear", search={"length": "free"}),
    )
    (record,) = retime_clip(task)
    assert (record.code, record.output) == ("option", "")
    assert "a free length needs a search; the method linear has none" in record.message
