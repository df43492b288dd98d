"""`retime report`: what it writes, prints and refuses."""

from __future__ import annotations

import zipfile
from pathlib import Path

from retime import write
from tests.cli.figures import figure


def test_a_report_is_written_and_shown_and_reads_like_the_file(run, clips, tmp_path) -> None:
    broken = tmp_path / "walk.bvh"
    broken.write_text(clips.bvh.read_text().replace("JOINT LeftLeg", "JOINT LeftLeg\n{ OFFSET 1 2 three"))
    refused = run("info", broken, code=1)
    shown = run("report", broken)
    assert "it ended in FormatError: clip.bvh:" in shown.stdout
    assert "read again it behaves in the same way: retime info clip.bvh" in shown.stdout
    assert "Words of the file that stay: CHANNELS, End," in shown.stdout
    assert "LeftLeg" not in shown.stdout
    with zipfile.ZipFile(tmp_path / "retime-report.zip") as archive:
        assert archive.namelist() == ["report.txt", "clip.bvh"]
        assert archive.read("report.txt").decode() in shown.stdout
        archive.extractall(tmp_path / "out")
    again = run("info", tmp_path / "out" / "clip.bvh", code=1)
    place = refused.stderr.partition(".bvh:")[2].partition(":")[0]
    assert again.stderr.partition(".bvh:")[2].partition(":")[0] == place


def test_no_file_is_replaced(run, clips, tmp_path) -> None:
    run("report", clips.bvh)
    before = (tmp_path / "retime-report.zip").read_bytes()
    again = run("report", clips.csv, code=1)
    assert "exists already, and a report replaces nothing: name another place with -o" in again.stderr
    # The words of other commands, whose option this one lacks.
    assert "--force" not in again.stderr
    assert (tmp_path / "retime-report.zip").read_bytes() == before
    run("report", clips.csv, "-o", "other.zip")
    run("report", clips.csv, "--output", "other.zip", code=1)


def test_a_word_is_kept_on_demand(run, tmp_path) -> None:
    write(figure(), tmp_path / "walk.bvh")
    run("report", "walk.bvh", "--keep", "LeftFoot", "--keep", "RightFoot")
    with zipfile.ZipFile(tmp_path / "retime-report.zip") as archive:
        text = archive.read("clip.bvh").decode()
    assert "JOINT LeftFoot\n" in text
    assert "LeftLeg" not in text


def test_what_has_no_place_in_it_is_refused(run, clips, tmp_path) -> None:
    assert "chooses frames itself" in run("report", clips.bvh, "--frames", "1:3", code=2).stderr
    (tmp_path / "film.mp4").write_bytes(b"\0\0\0\x18ftypmp42")
    assert "video" in run("report", "film.mp4", code=2).stderr
    (tmp_path / "take").mkdir()
    assert "make a report of one of them" in run("report", "take", code=2).stderr
    (tmp_path / "take").rmdir()
    assert "No such file" in run("report", "none.bvh", code=1).stderr
    assert [path.name for path in Path().iterdir()] == ["film.mp4"]
