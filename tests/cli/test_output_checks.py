"""Nothing is lost: outputs are refused before the work where they would replace a file, or could not be written."""

from __future__ import annotations

import os
import shutil
from pathlib import Path

import pytest

from retime.formats import registry


@pytest.fixture
def never_read(monkeypatch: pytest.MonkeyPatch) -> None:
    """Fail where a clip is read: what is refused here must be refused before."""

    def read(*args: object, **options: object) -> None:
        raise AssertionError("the clip was read")

    monkeypatch.setattr(registry, "read", read)


PLACES = [("-o", "x.bvh"), ("--save", "x.json"), ("--plot", "x.svg")]


@pytest.mark.parametrize(("option", "name"), PLACES)
def test_a_file_that_is_there_is_kept(run, clips, tmp_path, never_read, option, name) -> None:
    (tmp_path / name).write_text("mine")
    result = run("warp", clips.bvh, "--length", "65%", option, name, code=1)
    assert result.stderr == f"error: {name}: exists already; choose another place or allow overwriting (--force)\n"
    assert (tmp_path / name).read_text() == "mine"


def test_one_output_that_is_there_keeps_all_from_being_written(run, clips, tmp_path, never_read) -> None:
    (tmp_path / "warp.svg").write_text("mine")
    run("warp", clips.bvh, "--length", "65%", "-o", "x.bvh", "--save", "x.json", "--plot", "warp.svg", code=1)
    assert [path.name for path in tmp_path.iterdir()] == ["warp.svg"]


def test_force_replaces(run, clips, tmp_path) -> None:
    for _, name in PLACES:
        (tmp_path / name).write_text("mine")
    run("warp", clips.bvh, "--length", "65%", *sum(map(list, PLACES), []), "--force")  # noqa: RUF017
    assert all((tmp_path / name).stat().st_size > 100 for _, name in PLACES)


@pytest.mark.parametrize(("option", "name"), PLACES)
def test_a_missing_folder_is_named(run, clips, never_read, option, name) -> None:
    result = run("warp", clips.bvh, "--length", "65%", option, f"new/{name}", code=1)
    assert f"new/{name}" in result.stderr
    assert "there is no folder new; make it first" in result.stderr


def test_a_folder_is_no_place_for_a_file_nor_a_file_for_a_folder(run, clips, tmp_path, never_read) -> None:
    (tmp_path / "x.bvh").mkdir()
    assert "this is a folder" in run("warp", clips.bvh, "--length", "65%", "-o", "x.bvh", code=1).stderr
    (tmp_path / "file").write_text("")
    assert "is not a folder" in run("warp", clips.bvh, "--length", "65%", "-o", "file/x.bvh", code=1).stderr


@pytest.mark.skipif(os.name == "nt" or os.geteuid() == 0, reason="root may write anywhere")
def test_a_folder_that_can_not_be_written(run, clips, tmp_path, never_read) -> None:
    (tmp_path / "locked").mkdir(mode=0o500)
    assert "can't be written" in run("warp", clips.bvh, "--length", "65%", "-o", "locked/x.bvh", code=1).stderr


@pytest.mark.parametrize("way", ["same name", "symbolic link", "hard link", "through ..", "reference"])
def test_the_input_is_never_an_output(run, clips, tmp_path, never_read, way) -> None:
    clip = Path(shutil.copy(clips.bvh, tmp_path / "clip.bvh"))
    output, extra = "clip.bvh", []
    if way == "symbolic link":
        output = "link.bvh"
        (tmp_path / output).symlink_to(clip)
    elif way == "hard link":
        output = "hard.bvh"
        (tmp_path / output).hardlink_to(clip)
    elif way == "through ..":
        output = f"../{tmp_path.name}/clip.bvh"
    elif way == "reference":
        extra = ["--reference", "clip.bvh"]
        clip = clips.bvh
    result = run("warp", clip, "--length", "65%", "-o", output, *extra, "--force", code=2)
    assert "is the input" in result.stderr
    assert (tmp_path / "clip.bvh").read_bytes() == clips.bvh.read_bytes()


def test_two_outputs_need_two_places(run, clips, never_read) -> None:
    result = run("warp", clips.bvh, "--length", "65%", "--save", "x.svg", "--plot", "./x.svg", code=2)
    assert "--plot and --save name the same file" in result.stderr


@pytest.mark.parametrize(
    ("output", "says"),
    [
        ("x.csv", "holds a signal, not a motion"),
        ("x.blend", "no format ends in '.blend'"),
        ("x", "the name has no ending"),
    ],
)
def test_a_format_that_can_not_hold_it_is_refused_first(run, clips, never_read, output, says) -> None:
    assert says in run("warp", clips.bvh, "--length", "65%", "-o", output, code=1).stderr


def test_a_link_that_leads_nowhere_is_followed(run, clips, tmp_path) -> None:
    (tmp_path / "link.bvh").symlink_to(tmp_path / "new.bvh")
    run("warp", clips.bvh, "--length", "65%", "-o", "link.bvh")
    assert (tmp_path / "new.bvh").exists()
    assert (tmp_path / "link.bvh").is_symlink()
