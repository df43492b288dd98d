"""Tables and arrays as people have them, each with its right answer."""

from __future__ import annotations

import csv
from pathlib import Path

import numpy as np
import pytest

from retime import Signal, read

CASES = Path(__file__).resolve().parents[3] / "shared" / "cases"

pytestmark = pytest.mark.skipif(not CASES.is_dir(), reason="the folder of cases, ../shared/cases, is not here")


def signal(path: Path, **options) -> Signal:
    clip = read(path, **options)
    assert isinstance(clip, Signal)
    return clip


@pytest.mark.parametrize("args", [("--method", "linear", "--length", "150%"), ("--length", "70%")])
def test_an_angle_turns_the_short_way(run, tmp_path, args) -> None:
    run("warp", CASES / "yaw_wrap.csv", *args, "-o", "o.csv")
    yaw = {path: signal(path).values[:, 0] for path in (CASES / "yaw_wrap.csv", tmp_path / "o.csv")}
    turns = [np.abs((np.diff(of) + 180) % 360 - 180).max() for of in yaw.values()]
    speed = 2 / 3 if "150%" in args else 4
    assert turns[0] == pytest.approx(2.39, abs=0.01)
    assert turns[1] <= turns[0] * speed + 1e-6


@pytest.mark.parametrize("args", [("--method", "linear", "--length", "150%"), ("--length", "70%")])
def test_rotations_keep_their_length(run, tmp_path, args) -> None:
    run("warp", CASES / "quat_signs.csv", *args, "-o", "o.csv")
    q = signal(tmp_path / "o.csv").values[:, :4]
    np.testing.assert_allclose(np.linalg.norm(q, axis=1), 1, atol=1e-3)
    assert np.all(np.einsum("fc,fc->f", q[1:], q[:-1]) > 0)


@pytest.mark.parametrize("args", [("--method", "linear", "--length", "150%"), ("--length", "70%")])
def test_labels_are_not_blended(run, tmp_path, args) -> None:
    run("warp", CASES / "labels_blended.csv", *args, "-o", "o.csv")
    shown = signal(tmp_path / "o.csv")
    assert set(shown.values[:, 1]) == {0, 1}
    assert set(shown.values[:, 2]) == {0, 7}


def test_text_is_carried_along(run, tmp_path) -> None:
    run("warp", CASES / "text_labels.csv", "--method", "linear", "--length", "150%", "-o", "o.csv")
    with (tmp_path / "o.csv").open(newline="") as file:
        rows = list(csv.DictReader(file))
    shown, before = signal(tmp_path / "o.csv"), signal(CASES / "text_labels.csv")
    nearest = np.round(np.linspace(0, before.n_frames - 1, len(rows))).astype(int)
    expected = np.array(before.texts("action"))[nearest]
    # Where two frames are as near, either word will do.
    assert np.mean([row["action"] for row in rows] == expected) > 0.97
    assert {row["action"] for row in rows} == {"walk", "run"}
    assert shown.texts("action") == [row["action"] for row in rows]


@pytest.mark.parametrize("case", ["gaps_nan", "gaps_empty"])
def test_gaps_are_refused_bridged_or_kept(run, tmp_path, case) -> None:
    path = CASES / f"{case}.csv"
    refused = run("info", path, code=1).stderr
    assert f"{path}:22: column 'snout_x'" in refused
    assert "--gaps bridge fills gaps, --gaps keep carries them through" in refused
    linear = ("--method", "linear", "--length", "150%")
    bridged = run("warp", path, *linear, "-o", "b.csv", "--gaps", "bridge").stderr
    assert "bridged gaps: snout_x, snout_y frames 20:25" in bridged
    assert np.isfinite(signal(tmp_path / "b.csv").values).all()
    kept = run("warp", path, *linear, "-o", "k.csv", "--gaps", "keep").stderr
    assert "kept gaps: snout_x, snout_y frames 20:25" in kept
    with (tmp_path / "k.csv").open(newline="") as file:
        rows = list(csv.DictReader(file))
    places = np.linspace(0, 89, len(rows))
    expected = [19 < place < 26 for place in places]
    # At a whole frame, or within rounding of one, either side of a hole's edge will do.
    sure = np.abs(places - np.round(places)) > 1e-6
    assert [not row["snout_x"] for row, one in zip(rows, sure, strict=True) if one] == np.array(expected)[sure].tolist()
    assert all(row["tail_x"] for row in rows)


def test_keypoints(run, tmp_path) -> None:
    run("warp", CASES / "keypoints_2d.npy", "--fps", "30", "--length", "70%", "-o", "o.npy")
    assert np.load(tmp_path / "o.npy").shape == (42, 17, 2)


def test_quaternions_of_joints(run, tmp_path) -> None:
    run("warp", CASES / "quaternions_TJ4.npy", "--fps", "30", "--length", "70%", "-o", "o.npy")
    shown = np.load(tmp_path / "o.npy")
    assert shown.shape == (42, 5, 4)
    np.testing.assert_allclose(np.linalg.norm(shown, axis=2), 1, atol=1e-6)


def test_parameters_of_a_body(run) -> None:
    says = run("info", CASES / "amass_like.npz").stdout
    assert "rate     120 Hz" in says
    assert "SMPL without hands, 22 joints" in says
    # As plain arrays, where that is wanted.
    says = run("info", CASES / "amass_like.npz", "--array", "poses", "--array", "trans").stdout
    assert "rate      120 Hz" in says
    assert "channels  69: poses.0" in says
    assert "trans.x, trans.y, trans.z" in says
