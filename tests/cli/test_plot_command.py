"""`retime plot`: saved warps in one picture."""

from __future__ import annotations

import pytest

from retime import Keytime, Warp, write_warp


@pytest.fixture
def warps(tmp_path):
    """Save two warps, and one of the same name in another folder."""
    write_warp(
        Warp(
            [0.0, 2.0],
            [0.0, 4.0],
            (Keytime(input_time=0.0, output_time=0.0), Keytime(input_time=4.0, output_time=2.0)),
            "linear",
        ),
        tmp_path / "even.json",
    )
    write_warp(Warp([0.0, 1.0, 2.0], [0.0, 1.0, 4.0], method="guided"), tmp_path / "late.json")
    (tmp_path / "b").mkdir()
    write_warp(Warp([0.0, 3.0], [0.0, 4.0]), tmp_path / "b" / "even.json")


def test_several_warps_and_the_strip(run, clips, tmp_path, warps) -> None:
    result = run("plot", "even.json", "late.json", "--motion", clips.bvh, "-o", "both.svg", "--title", "Compared")
    picture = (tmp_path / "both.svg").read_text()
    for text in ("even", "late", "Compared"):
        assert text in picture
    assert result.stdout == "both.svg: even, late\n"


def test_png_without_a_motion(run, tmp_path, warps) -> None:
    assert run("plot", "even.json", "b/even.json", "-o", "two.png", "-q").output == ""
    assert (tmp_path / "two.png").read_bytes().startswith(b"\x89PNG")


def test_warps_of_one_name_are_told_apart(run, warps) -> None:
    assert run("plot", "even.json", "b/even.json", "-o", "two.svg").stdout == "two.svg: even.json, b/even.json\n"


def test_the_options_say_how_to_read_the_motion(run, clips, warps) -> None:
    result = run("plot", "even.json", "--motion", clips.bvh, "--frames", "0:999", "-o", "x.svg", code=2)
    assert "0:240" in result.stderr


def test_a_picture_is_not_overwritten(run, tmp_path, warps) -> None:
    (tmp_path / "old.svg").write_text("old")
    assert "--force" in run("plot", "even.json", "-o", "old.svg", code=1).stderr
    assert (tmp_path / "old.svg").read_text() == "old"
    run("plot", "even.json", "-o", "old.svg", "--force")
    assert "<svg" in (tmp_path / "old.svg").read_text()


def test_without_matplotlib_it_says_what_to_install_before_anything_is_read(run, clips, monkeypatch, warps) -> None:
    import importlib.util

    find_spec = importlib.util.find_spec
    monkeypatch.setattr(importlib.util, "find_spec", lambda name: None if name == "matplotlib" else find_spec(name))
    for arguments in (["plot", "none.json", "-o", "x.svg"], ["warp", "none.bvh", "--length", "65%", "--plot", "x.svg"]):
        assert "pip install 'retime[plot]'" in run(*arguments, code=1).stderr
