"""The options that say what a table or an array holds, and those that make other frames of it."""

from __future__ import annotations

import json

import numpy as np
import pytest

from retime import Signal, read, sample, write

TABLE = "time,pan,where,cue\n" + "".join(
    f"{frame / 30:.6f},{(170 + frame) % 360 - (360 if (170 + frame) % 360 > 180 else 0)},"
    f"{'left' if frame < 10 else 'right'},{int(frame == 7)}\n"
    for frame in range(30)
)


@pytest.fixture
def table(tmp_path):
    (tmp_path / "table.csv").write_text(TABLE)
    return "table.csv"


def test_info_says_what_was_found(run, table) -> None:
    says = run("info", table).stdout
    assert "kinds     angle:deg: pan; label: where; linear: cue" in says
    assert "words     where: left, right" in says
    assert "weigh     all but where" in says
    told = json.loads(run("info", table, "--json", "--channel", "c*=event").stdout)
    assert told["kinds"] == ["angle:deg", "label", "event"]
    assert told["words"] == {"where": ["left", "right"]}
    assert told["weigh"] == [True, False, False]


def test_what_is_told_is_followed(run, table, tmp_path) -> None:
    run("warp", table, "--length", "50%", "--method", "linear", "--channel", "cue=event", "-o", "o.csv")
    shown = read(tmp_path / "o.csv", kinds={"cue": "event"})
    assert isinstance(shown, Signal)
    assert shown.values[:, 2].sum() == 1
    assert np.abs((np.diff(shown.values[:, 0]) + 180) % 360 - 180).max() < 3
    run("warp", table, "--length", "150%", "--method", "linear", "--channel", "pan=linear", "-o", "l.csv")
    blended = read(tmp_path / "l.csv")
    assert isinstance(blended, Signal)
    # As a length it goes from one side to the other through 0.
    assert np.abs(blended.values[:, 0]).min() < 150


@pytest.mark.parametrize(
    ("args", "says"),
    [
        (("--channel", "tilt=angle"), "table has no channel 'tilt'; there are pan, where, cue"),
        (("--channel", "pan=turn"), "Invalid value for '--channel': the kind of a channel is one of linear"),
        (("--gaps", "fill"), "Invalid value for '--gaps': gaps are 'bridge', 'bridge:SECONDS' or 'keep'"),
        (("--channel", "where=linear"), "channel 'where' holds text, which can only be a label"),
    ],
)
def test_what_can_not_be_is_refused(run, table, args, says) -> None:
    assert says in run("info", table, *args, code=2).stderr.replace("\n", " ").replace("  ", " ")


def test_a_pattern_may_be_for_a_clip_beside(run, table, clips) -> None:
    run("warp", clips.csv, "--length", "80%", "--channel", "pan=angle:deg", "--also", f"{table}=o.csv")
    assert "has no channel 'zzz'" in run("warp", clips.csv, "--length", "80%", "--channel", "zzz=label", code=2).stderr


def test_an_array_is_chosen(run, tmp_path) -> None:
    np.savez(tmp_path / "a.npz", one=np.zeros((9, 2)), two=np.ones((9, 3, 2)), fps=25)
    assert "say which is meant (--array): one, two" in run("info", "a.npz", code=1).stderr
    run("convert", "a.npz", "two.npy", "--array", "two")
    assert np.load(tmp_path / "two.npy").shape == (9, 3, 2)


def test_another_rate_ends_at_the_same_time(run, tmp_path) -> None:
    write(sample(), tmp_path / "sample.bvh")
    says = run("convert", "sample.bvh", "film.bvh", "--rate", "24").stdout
    assert says == "film.bvh: 327 frames, 13.62 s at 24 Hz\n"
    assert read(tmp_path / "film.bvh").end_time == pytest.approx(sample().end_time, abs=1e-6)


def test_poses_are_held(run, tmp_path, clips) -> None:
    run("convert", clips.csv, "twos.csv", "--on-twos")
    run("convert", clips.csv, "threes.csv", "--on", "3")
    run("warp", clips.csv, "--length", "80%", "--on", "2", "-o", "warped.csv", "--save", "w.json")
    run("apply", "w.json", clips.csv, "-o", "applied.csv", "--on-twos")
    for name, on in (("twos", 2), ("threes", 3), ("warped", 2), ("applied", 2)):
        held = read(tmp_path / f"{name}.csv")
        assert isinstance(held, Signal)
        steps = np.flatnonzero(np.any(np.diff(held.values, axis=0) != 0, axis=1)) + 1
        assert len(steps) > 5
        assert not np.any(steps % on), name
    assert "give one of them" in run("convert", clips.csv, "x.csv", "--on-twos", "--on", "2", code=2).stderr
    assert "give -o OUT" in run("warp", clips.csv, "--length", "80%", "--on-twos", code=2).stderr
