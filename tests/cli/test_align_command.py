"""`retime warp --method align`: in step with a reference, and what that has no use for."""

from __future__ import annotations

import json

import numpy as np
import pytest

from retime import Signal, Warp, apply_warp, read, read_warp, write


def test_a_double_is_followed(run, clips, tmp_path) -> None:
    clip = read(clips.csv)
    assert isinstance(clip, Signal)
    end = clip.end_time
    warp = Warp([0.0, 0.4 * end, 0.9 * end], [0.0, 0.6 * end, end])
    write(apply_warp(clip, warp, average=False), tmp_path / "double.csv")
    options = ["--reference", "double.csv", "-o", "out.csv", "--save", "warp.json", "--plot", "warp.svg", "--json"]
    document = json.loads(run("warp", clips.csv, "--method", "align", *options).stdout)
    assert document["method"] == "align"
    assert document["optimal"] is True
    assert document["n_reference"] == document["n_output"]
    found = read_warp(tmp_path / "warp.json")
    assert found.method == "align"
    times = np.linspace(0, found.output_end, 30)
    assert np.abs(found(times) - warp(times)).max() < 0.05
    assert read(tmp_path / "out.csv").n_frames == read(tmp_path / "double.csv").n_frames
    # What it is drawn beside, and by what name.
    assert "align" in (tmp_path / "warp.svg").read_text(encoding="utf-8")


def test_a_cycle_is_repeated(run, tmp_path) -> None:
    turn = 2 * np.pi * np.arange(31) / 30
    write(Signal(("x", "y"), np.stack([np.sin(turn), np.cos(turn)], axis=1), 30), tmp_path / "cycle.csv")
    turns = 2 * np.pi * 3 * np.linspace(0, 1, 121) ** 1.2
    write(Signal(("x", "y"), np.stack([np.sin(turns), np.cos(turns)], axis=1), 30), tmp_path / "long.csv")
    options = ("--method", "align", "--reference", "cycle.csv", "--repeat", "3", "--save", "warp.json")
    lines = run("warp", "long.csv", *options).stdout.splitlines()
    assert "output  91 frames, 3.03 s (75.2% of the input)" in lines
    warp = read_warp(tmp_path / "warp.json")
    assert np.allclose(np.interp(warp([1.0, 2.0]), np.arange(121) / 30, turns) / (2 * np.pi), [1, 2], atol=0.03)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ((), "--method align needs --reference CLIP"),
        (("--reference", "{csv}", "--reference", "{csv}"), "keeps step with one reference; found 2"),
        (
            ("--reference", "{csv}", "--length", "50%", "--score", "joint", "--neighbors", "2", "--loop"),
            "--length, --loop, --score, --neighbors would have no effect",
        ),
        (("--reference", "{csv}", "--reference-weight", "2"), "--reference-weight would have no effect"),
        (("--reference", "{csv}", "--repeat", "0.5"), "--repeat"),
        (("--reference", "{csv}", "--group", "--also", "{csv}=other.csv"), "can't be combined with --reference"),
    ],
)
def test_what_keeping_step_has_no_use_for_is_refused(run, clips, options, message) -> None:
    given = [option.replace("{csv}", str(clips.csv)) for option in options]
    result = run("warp", clips.csv, "--method", "align", *given, code=2)
    # Long lines are broken.
    assert message in " ".join(result.stderr.split())


def test_repeat_needs_align(run, clips) -> None:
    assert "--repeat is for --method align" in run("warp", clips.csv, "--repeat", "2", code=2).stderr
