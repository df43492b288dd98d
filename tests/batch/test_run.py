"""A library from start to end, without Dask: trees, resuming, what changed, cuts, labels, variants."""

from __future__ import annotations

import csv
import errno
import gzip
import json
import os
import shutil
import sys
from dataclasses import replace
from io import StringIO
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import retime
from retime.batch import BatchResult, ClipTask, Recipe, Rule, Treatment, retime_clip, run
from retime.batch import clip as clip_module
from retime.batch.engine import Bounds
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


def test_clips_may_be_listed(library: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """They are named by their places below the folder that they share, and others beside them are let be."""
    whole = run(library, tmp_path / "whole", {"length": "80%"}, workers=0)
    chosen = [library / "walks" / "slow" / "b.bvh", library / "c.bvh"]
    monkeypatch.chdir(library)
    # One that is listed twice is done once.
    odd = [Path("walks", "slow", "b.bvh"), Path(library, "..", library.name, "c.bvh"), Path("c.bvh")]
    some = run(odd, tmp_path / "some", {"length": "80%"}, workers=0)
    names = [path.relative_to(library).as_posix() for path in sorted(chosen)]
    assert [record.name for record in some.records] == names
    for record in some.records:
        of_whole = next(one for one in whole.records if one.name == record.name)
        assert (record.status, record.code, record.output) == (of_whole.status, of_whole.code, of_whole.output)
        if record.output:
            assert (tmp_path / "some" / record.output).read_bytes() == (tmp_path / "whole" / record.output).read_bytes()
    # One alone lies in its own folder; the same list again does nothing twice.
    assert run([chosen[0]], tmp_path / "one", {"length": "80%"}, workers=0).records[0].name == "b.bvh"
    assert run(odd, tmp_path / "some", {"length": "80%"}, workers=0).counts["done"] == 0


def test_a_list_that_can_t_be_is_refused_and_nothing_is_written(library: Path, tmp_path: Path) -> None:
    clip = library / "c.bvh"
    note = tmp_path / "note.txt"
    note.write_text("no clip")
    for listed, said in (
        ([], "no clip was named"),
        ([clip, library / "gone.bvh"], "gone.bvh is not there"),
        ([clip, note], "note.txt is of no format that holds clips"),
    ):
        with pytest.raises(OptionError, match=said):
            run(listed, tmp_path / "out", {"length": "80%"}, workers=0)
    assert not (tmp_path / "out").exists()
    before = clip.read_bytes()
    with pytest.raises(OptionError, match="is read here, and never replaced"):
        run([clip], clip.parent, {"length": "80%"}, workers=0, force=True)
    assert clip.read_bytes() == before


def test_a_stranger_s_file_is_not_replaced(library: Path, tmp_path: Path) -> None:
    out = tmp_path / "out"
    out.mkdir()
    (out / "c.bvh").write_text("mine")
    result = done(library, out, {"length": "80%", "fps": 30})
    (failure,) = [record for record in result.failures if record.name == "c.bvh"]
    assert failure.code == "exists"
    assert (out / "c.bvh").read_text() == "mine"
    assert done(library, out, {"length": "80%", "fps": 30}, force=True).counts["failed"] == 1
    assert (out / "c.bvh").read_text() != "mine"


def test_a_stranger_s_labels_are_not_replaced(tmp_path: Path) -> None:
    root, out = tmp_path / "in", tmp_path / "out"
    made_clip(root / "a.bvh")
    (root / "a_labels.csv").write_text("start_frame,end_frame,act\n0,39,walk\n")
    out.mkdir()
    (out / "a_labels.csv").write_text("mine")
    given = {"length": "80%", "beside": "{stem}_labels.csv"}
    assert [record.code for record in done(root, out, given).failures] == ["exists"]
    # That a process meant to write there does not make it its own, should the run end before it says more.
    journal = Journal(out)
    journal.intend(ClipTask("", "a.bvh", str(out), ("a.bvh",), Treatment(), (("", ("a_labels.csv",)),)))
    journal.close()
    assert [record.code for record in done(root, out, given).failures] == ["exists"]
    assert (out / "a_labels.csv").read_text() == "mine"
    assert done(root, out, given, force=True).counts == {"done": 1, "kept": 0, "failed": 0}
    assert (out / "a_labels.csv").read_text() == "start_frame,end_frame,act\n0,31,walk\n"
    # They are the run's own by now, and part of what it made.
    assert done(root, out, given | {"length": "50%"}).counts["done"] == 1
    (out / "a_labels.csv").unlink()
    assert done(root, out, given | {"length": "50%"}).counts == {"done": 1, "kept": 0, "failed": 0}
    assert (out / "a_labels.csv").exists()


def test_a_clip_whose_labels_are_broken_leaves_nothing(tmp_path: Path) -> None:
    root, out = tmp_path / "in", tmp_path / "out"
    made_clip(root / "a.bvh")
    (root / "a_events.csv").write_text("frame,what\n3,step\n")
    (root / "a_labels.csv").write_text("start_frame,end_frame\nzero,39\n")
    result = done(root, out, {"length": "80%", "beside": ["{stem}_events.csv", "{stem}_labels.csv"]})
    assert [record.code for record in result.failures] == ["format"]
    assert {path.name for path in out.iterdir()} <= {"manifest.jsonl", "manifest.parquet", ".retime"}


@pytest.mark.parametrize(
    ("names", "given", "said"),
    [
        (("a.bvh", "a_1.bvh"), Recipe(rules=(Rule("a.bvh", {"variants": 2}),)), r"a\.bvh and a_1\.bvh would both"),
        (("a.bvh", "a.npz"), {"beside": "{stem}_labels.csv"}, r"both be written as a_labels\.csv"),
        (("b.npz",), {"beside": "{stem}.csv", "format": ".csv"}, r"both be written as b\.csv"),
        (("manifest.npz",), {"format": ".parquet"}, r"both be written as manifest\.parquet"),
    ],
)
def test_two_files_of_one_name_are_refused_before_one_is_lost(
    tmp_path: Path, names: tuple[str, ...], given: object, said: str
) -> None:
    root = tmp_path / "in"
    for i, name in enumerate(names):
        place = root / name
        place.parent.mkdir(exist_ok=True)
        if place.suffix == ".npz":
            retime.write(retime.Signal(("x",), np.arange(40.0)[:, None], 30), place)
        else:
            made_clip(place, 40 * i)
    for name in ("a_labels.csv", "b.csv"):
        (root / name).write_text("start_frame,end_frame\n0,9\n")
    with pytest.raises(OptionError, match=said):
        done(root, tmp_path / "out", given)
    assert not (tmp_path / "out").exists()


def test_another_reference_is_another_output(tmp_path: Path) -> None:
    root, out = tmp_path / "in", tmp_path / "out"
    made_clip(root / "a.bvh", n=80)
    references = [made_clip(tmp_path / name, start, 80) for name, start in (("one.bvh", 200), ("other.bvh", 400))]
    shutil.copy(references[1], tmp_path / "same.bvh")
    given = {"length": "80%"}
    found = []
    for more in ({"reference": str(references[0])}, {"reference": str(references[1])}, {}):
        assert done(root, out, given | more).counts == {"done": 1, "kept": 0, "failed": 0}
        found.append((out / "a.bvh").read_bytes())
        assert done(root, out, given | more).counts == {"done": 0, "kept": 1, "failed": 0}
    assert len(set(found)) == 3
    both = {"reference": [str(one) for one in references]}
    assert done(root, out, given | both).counts["done"] == 1
    assert done(root, out, given | {"reference": both["reference"][:1]}).counts["done"] == 1
    # What counts is what it holds, not what it is called.
    assert done(root, out, given | {"reference": str(references[1])}).counts["done"] == 1
    assert done(root, out, given | {"reference": str(tmp_path / "same.bvh")}).counts["kept"] == 1


def test_a_reference_that_is_not_there_is_said_once(library: Path, tmp_path: Path) -> None:
    with pytest.raises(OptionError, match=r"the reference .*none\.bvh is not there"):
        done(library, tmp_path / "out", {"reference": str(tmp_path / "none.bvh")})
    assert not (tmp_path / "out").exists()


def test_a_library_is_the_same_from_wherever_it_is_named(
    library: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    assert done(library, tmp_path / "out", {"length": "80%", "fps": 30}).counts["done"] == 4
    monkeypatch.chdir(tmp_path)
    assert done(Path("in"), Path("out"), {"length": "80%", "fps": 30}).counts == {"done": 0, "kept": 4, "failed": 1}


def test_outputs_that_are_not_asked_for_today_stay_known(library: Path, tmp_path: Path) -> None:
    out, given = tmp_path / "out", Treatment().with_(settings({"length": "80%", "fps": 30}))
    less = Recipe(given, (Rule("walks/*", skip=True),))
    assert done(library, out, Recipe(given)).counts == {"done": 4, "kept": 0, "failed": 1}
    assert done(library, out, less).counts == {"done": 0, "kept": 2, "failed": 0}
    statuses = {record.output: record.status for record in read_manifest(out)}
    assert statuses == {"arm.csv": "kept", "c.bvh": "kept", "walks/a.bvh": "old", "walks/slow/b.bvh": "old"}
    (out / "walks" / "a.bvh").unlink()
    assert done(library, out, less).counts["kept"] == 2
    assert {record.output for record in read_manifest(out)} == {"arm.csv", "c.bvh", "walks/slow/b.bvh"}
    assert done(library, out, Recipe(given)).counts == {"done": 1, "kept": 3, "failed": 1}
    # Fewer variants, and more again: those in between are a run's own.
    varied = tmp_path / "varied"
    for n in (3, 2, 3):
        result = done(library, varied, Recipe(Treatment(variants=n), (Rule("[!c]*", skip=True),)))
        assert result.counts == {"done": n, "kept": 0, "failed": 0}
    # A clip that fails by now has left an output that is not of this run.
    (library / "c.bvh").write_text("HIERARCHY")
    result = done(library, varied, Recipe(Treatment(variants=2), (Rule("[!c]*", skip=True),)))
    assert result.counts == {"done": 0, "kept": 0, "failed": 1}
    assert [record.status for record in read_manifest(varied)] == ["failed", "old", "old", "old"]


def test_what_a_process_was_about_to_write_is_known_after_a_second_death(library: Path, tmp_path: Path) -> None:
    out = tmp_path / "out"
    out.mkdir()
    journal = Journal(out)
    journal.intend(ClipTask("", "c.bvh", str(out), ("c.bvh",), Treatment()))
    journal.close()
    (out / "c.bvh").write_text("half")
    # A run that takes this in, and dies before it comes to the clip.
    Manifest(out).close()
    assert done(library, out, {"length": "80%", "fps": 30}).counts == {"done": 4, "kept": 0, "failed": 1}


def test_a_torn_last_line_takes_no_other_with_it(tmp_path: Path) -> None:
    made_clip(tmp_path / "in" / "c.bvh")
    done(tmp_path / "in", tmp_path / "out", {"length": "80%"})
    (record,) = read_manifest(tmp_path / "out")
    with (tmp_path / "out" / "manifest.jsonl").open("ab") as file:
        file.write(b'{"name": "x.bvh", "outp')
    manifest = Manifest(tmp_path / "out")
    manifest.add([replace(record, name="d.bvh", output="d.bvh", status="done")])
    manifest.close()
    assert [record.name for record in read_manifest(tmp_path / "out")] == ["c.bvh", "d.bvh"]


def test_a_journal_that_a_run_took_away_is_begun_anew(tmp_path: Path) -> None:
    journal = Journal(tmp_path)
    task = ClipTask("", "c.bvh", str(tmp_path), ("c.bvh",), Treatment())
    journal.intend(task)
    Manifest(tmp_path).close()
    assert not list((tmp_path / ".retime").glob("journal-*"))
    # The process lives on, a worker of a cluster, and works for the next run.
    journal.intend(task)
    journal.close()
    assert Manifest.look(tmp_path).intended == {"c.bvh"}


def test_failures_of_what_is_around_a_clip_are_tried_again(
    library: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def full(*given: object, **more: object) -> None:
        raise OSError(errno.ENOSPC, "No space left on device")

    task = ClipTask(str(library / "c.bvh"), "c.bvh", str(tmp_path / "out"), ("c.bvh",), Treatment())
    with monkeypatch.context() as patch:
        patch.setattr("retime.batch.clip.write", full)
        patch.setattr("retime.batch.clip.retime_file", full)
        (record,) = retime_clip(task)
    assert (record.code, record.message, record.hash) == ("system", "No space left on device", "")
    (again,) = retime_clip(replace(task, failed_before=record.to_json()))
    assert again.status == "done"


@pytest.mark.parametrize(
    ("failure", "bounds", "again"),
    [
        ({"code": "timeout", "limit": 5.0}, Bounds(seconds=5.0), False),
        ({"code": "timeout", "limit": 5.0}, Bounds(seconds=4.0), False),
        ({"code": "timeout", "limit": 5.0}, Bounds(seconds=6.0), True),
        ({"code": "memory", "limit": 2.0e9}, Bounds(memory=3_000_000_000), True),
        ({"code": "memory", "limit": 2.0e9}, Bounds(memory=2_000_000_000), False),
        ({"code": "memory", "limit": 2.0e9}, Bounds(), True),
        ({"code": "memory", "limit": 0.0}, Bounds(memory=3_000_000_000), False),
        ({"code": "killed", "limit": 0.0}, Bounds(), False),
        ({"code": "timeout"}, Bounds(), False),
    ],
)
def test_a_wider_bound_is_a_reason_to_try_again(failure: dict[str, object], bounds: Bounds, again: bool) -> None:
    assert bounds.wider_than(failure) is again


@pytest.mark.skipif(os.name == "nt" or sys.platform == "darwin", reason="names are Unicode there")
def test_a_name_that_is_no_unicode_is_one_of_many(tmp_path: Path) -> None:
    name = os.fsdecode(b"bad\xff.bvh")
    made_clip(tmp_path / "in" / name)
    made_clip(tmp_path / "in" / "new\nline.bvh")
    result = done(tmp_path / "in", tmp_path / "out", {"length": "80%"})
    assert result.counts == {"done": 2, "kept": 0, "failed": 0}
    assert {record.output for record in read_manifest(tmp_path / "out")} == {name, "new\nline.bvh"}
    assert done(tmp_path / "in", tmp_path / "out", {"length": "80%"}).counts["kept"] == 2


def test_a_clip_that_is_written_to_meanwhile_is_made_again(
    library: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    task = ClipTask(str(library / "c.bvh"), "c.bvh", str(tmp_path), ("c.bvh",), Treatment())
    search = clip_module.guided_warp

    def meanwhile(*given: Any, **more: Any) -> Any:
        made_clip(tmp_path / "other.bvh", 300)
        shutil.copy(tmp_path / "other.bvh", library / "c.bvh")
        return search(*given, **more)

    with monkeypatch.context() as patch:
        patch.setattr(clip_module, "guided_warp", meanwhile)
        (record,) = retime_clip(task)
    assert (record.status, record.hash) == ("done", "")
    (again,) = retime_clip(replace(task, before={"c.bvh": record.to_json()}, overwrite=True))
    assert again.status == "done"
    assert again.hash


def test_two_runs_in_one_folder_are_refused(tmp_path: Path) -> None:
    manifest = Manifest(tmp_path)
    with pytest.raises(OptionError, match="another run is at work"):
        Manifest(tmp_path)
    manifest.close()
    Manifest(tmp_path).close()


def test_what_a_run_that_is_over_asked_for_is_not_written(library: Path, tmp_path: Path) -> None:
    out = tmp_path / "out"
    first = Manifest(out)
    task = ClipTask(str(library / "c.bvh"), "c.bvh", str(out), ("c.bvh",), Treatment(), run=first.run)
    assert ClipTask.from_json(json.loads(json.dumps(task.to_json()))) == task
    first.close()
    # A worker that was at it when the client was killed; none is at work, and then another.
    assert retime_clip(task)[0].code == "superseded"
    second = Manifest(out)
    (late,) = retime_clip(task)
    assert (late.code, late.hash, late.output) == ("superseded", "", "")
    assert not (out / "c.bvh").exists()
    (done_now,) = retime_clip(replace(task, run=second.run))
    second.close()
    assert done_now.status == "done"


def test_folders_in_one_another_are_refused(library: Path) -> None:
    for out in (library, library / "out", library.parent):
        with pytest.raises(OptionError, match="lie in one another"):
            done(library, out, {})


def test_two_clips_of_one_output_are_refused(library: Path, tmp_path: Path) -> None:
    shutil.copy(library / "c.bvh", library / "c.csv")
    with pytest.raises(OptionError, match=r"c\.bvh and c\.csv would both be written as c\.npz"):
        done(library, tmp_path / "out", {"format": ".npz"})


def test_cuts_are_found_in_any_folder_and_of_every_output(tmp_path: Path) -> None:
    """Below the top; of a packed clip; of one that fails; and of variants, which are clips of the new tree."""
    root = tmp_path / "in"
    for name in ("Old_FW", "Old_BW", "Old_ID"):
        made_clip(root / "sets" / "style" / "Old" / f"{name}.bvh", 0, 60)
    packed = root / "sets" / "style" / "Old" / "Old_BW.bvh"
    packed.with_suffix(".bvh.gz").write_bytes(gzip.compress(packed.read_bytes()))
    packed.unlink()
    made_clip(root / "Old_FW.bvh", 0, 60)
    (root / "sets" / "style" / "Frame_Cuts.csv").write_text(
        "STYLE_NAME,BW_START,BW_STOP,FW_START,FW_STOP,ID_START,ID_STOP,TR_START,TR_STOP,note\n"
        "Old,20,59,10,49,10,99,5,8,slow\nYoung,1,2,N/A,N/A,N/A,N/A,N/A,N/A,\n"
    )
    result = done(root, tmp_path / "out", {"length": "50%"})
    assert {record.name: (record.frames_in, record.frames_out) for record in result.records} == {
        # No table above it speaks of this one.
        "Old_FW.bvh": (60, 30),
        "sets/style/Old/Old_BW.bvh.gz": (40, 20),
        "sets/style/Old/Old_FW.bvh": (40, 20),
        "sets/style/Old/Old_ID.bvh": (0, 0),
    }
    head = "STYLE_NAME,BW_START,BW_STOP,FW_START,FW_STOP,ID_START,ID_STOP,TR_START,TR_STOP,note"
    assert (tmp_path / "out" / "sets" / "style" / "Frame_Cuts.csv").read_text() == (
        f"{head}\nOld,0,19,0,19,N/A,N/A,5,8,slow\nYoung,1,2,N/A,N/A,N/A,N/A,N/A,N/A,\n"
    )
    varied = done(root, tmp_path / "varied", {"variants": 2, "seed": 1})
    table = (tmp_path / "varied" / "sets" / "style" / "Frame_Cuts.csv").read_text()
    row = next(csv.DictReader(StringIO(table)))
    frames = {record.output: record.frames_out for record in varied.records if record.output}
    for kind in ("BW", "FW"):
        assert row[f"{kind}_START"] == row[f"{kind}_STOP"] == "N/A"
        for number in (1, 2):
            assert row[f"{kind}_{number}_START"] == "0"
            assert int(row[f"{kind}_{number}_STOP"]) == frames[f"sets/style/Old/Old_{kind}_{number}.bvh"] - 1
    # The new tree is read by its table.
    again = done(tmp_path / "varied", tmp_path / "again", {"length": "100%"})
    assert again.counts == {"done": 6, "kept": 0, "failed": 0}
    assert all(record.frames_in == frames[record.name] for record in again.records)


def test_what_amass_has_beside_its_clips_is_no_clip(tmp_path: Path) -> None:
    root = tmp_path / "in"
    (root / "set" / "subject").mkdir(parents=True)
    (root / "set" / "subject" / "walk_poses.npz").write_bytes(npz(body(n_frames=40)))
    for name in ("shape.npz", "neutral_stagei.npz", "female_stagei.npz"):
        np.savez(root / "set" / "subject" / name, betas=np.zeros(16))
    result = done(root, tmp_path / "out", {"length": "50%"})
    assert [(record.name, record.status) for record in result.records] == [("set/subject/walk_poses.npz", "done")]


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


def test_references_are_drawn_by_the_clip_s_name(library: Path, tmp_path: Path) -> None:
    (library / "arm.csv").unlink()
    references = []
    for start in (0, 200, 400):
        references.append(str(tmp_path / f"reference_{start}.bvh"))
        retime.write(retime.sample()[start : start + 90], references[-1])
    given = {"variants": 3, "seed": 1, "reference": references, "draw_references": True}
    made = [record for record in done(library, tmp_path / "out", given).records if record.status == "done"]
    assert len(made) > 3
    by_clip: dict[str, list[str]] = {}
    for record in made:
        by_clip.setdefault(record.name, []).append(record.reference)
    assert all(sorted(found) == sorted(references) for found in by_clip.values())
    # Asked for alone, the drawn one gives the same file.
    first = made[0]
    done(library, tmp_path / "alone", given | {"reference": [first.reference]})
    assert (tmp_path / "alone" / first.output).read_bytes() == (tmp_path / "out" / first.output).read_bytes()
    again = done(library, tmp_path / "out", given)
    assert again.counts["kept"] == len(made)
    kept = [record for record in again.records if record.status == "kept"]
    assert [record.reference for record in kept] == [record.reference for record in made]
    together = done(library, tmp_path / "together", given | {"draw_references": False}).records
    assert {record.reference for record in together} == {""}
    assert (tmp_path / "together" / first.output).read_bytes() != (tmp_path / "out" / first.output).read_bytes()


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
