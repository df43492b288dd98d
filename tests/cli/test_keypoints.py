"""Keypoints of footage on the command line."""

from __future__ import annotations

import json

import numpy as np
import pytest

from retime import read, read_warp
from tests.formats.keypoint_files import landmarks, moving, openpose_people, write_openpose


def test_a_folder_of_openpose_is_looked_at_and_retimed(run, tmp_path) -> None:
    poses = moving(90, 25, n_axes=2)
    sure = np.full((90, 25), 0.9)
    sure[30:33, 4] = 0.25
    write_openpose(
        tmp_path / "poses", [openpose_people([p], [s]) for p, s in zip(poses, sure, strict=True)], take="take"
    )
    result = run("info", "poses", "--fps", "30")
    assert "OpenPose, BODY_25" in result.stdout
    assert "right_wrist.y frames 30:32" in result.stderr
    assert "gaps" not in run("info", "poses", "--fps", "30", "--confidence", "0.2").stderr
    assert "--confidence" in run("info", "poses", "--fps", "30", "--confidence", "2", code=2).stderr
    assert "--fps" in run("info", "poses", code=1).stderr
    run("warp", "poses", "--fps", "30", "--length", "65%", "--save", "w.json", "-o", "short.csv")
    assert read_warp(tmp_path / "w.json").output_span == pytest.approx(0.65 * 89 / 30, abs=0.05)
    # The table shows the places where the warp has them.
    short = read(tmp_path / "short.csv")
    assert short.n_frames == pytest.approx(0.65 * 90, abs=1)
    assert short.names[:2] == ("nose.x", "nose.y")


def test_landmarks_of_mediapipe_as_a_reference(run, tmp_path) -> None:
    poses = moving(60, 33)
    (tmp_path / "a.json").write_text(json.dumps({"fps": 30, "frames": landmarks(poses)}))
    (tmp_path / "b.json").write_text(json.dumps({"fps": 30, "frames": landmarks(poses[::2])}))
    document = json.loads(run("info", "a.json", "--json").stdout)
    assert (document["format"], document["table"], document["frames"]) == ("keypoints", "MediaPipe, pose", 60)
    run("warp", "a.json", "--reference", "b.json", "--method", "align", "--save", "w.json")
    # The reference plays the same twice as fast.
    assert read_warp(tmp_path / "w.json")(0.5) == pytest.approx(1.0, abs=0.1)


def test_a_warp_is_no_clip(run, clips, tmp_path) -> None:
    run("warp", clips.bvh, "--length", "65%", "--save", "w.json", "-q")
    assert "no keypoints of OpenPose or MediaPipe" in run("info", "w.json", code=1).stderr
    assert "can be read, but not written" in run("convert", clips.csv, "o.json", code=1).stderr


def test_points_that_tremble_count_no_more_than_they_move(run, tmp_path) -> None:
    """Arms fly three times for 0.6 s, and rest between; the other points only tremble."""
    chance = np.random.default_rng(0)
    times = np.arange(163) / 30
    poses = chance.uniform(0.2, 0.8, (33, 3)) + chance.normal(0, 0.002, (163, 33, 3))
    spans = [(start, start + 0.6) for start in (0.9, 2.4, 3.9)]
    for start, _ in spans:
        aloft = np.clip(times - start, 0, 0.6)[:, None]
        poses[:, 15:23, 1] -= 0.6 * 4.9 * aloft * (0.6 - aloft)
        poses[:, 15:23, 0] += 0.1 * aloft
    (tmp_path / "arms.json").write_text(json.dumps({"fps": 30, "frames": landmarks(poses)}))
    for length in ("65%", "150%"):
        run("warp", "arms.json", "--length", length, "--save", "w.json", "--force", "-q")
        warp = read_warp(tmp_path / "w.json")
        inner = np.concatenate([np.linspace(start + 0.1, stop - 0.1, 20) for start, stop in spans])
        np.testing.assert_allclose(warp.speed(warp.inverse()(inner)), 1, atol=0.05)
