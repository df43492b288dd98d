"""Captures in place, by the command line: all of the file is kept, and only its frames are others."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from retime.formats.c3d import facts, parse_c3d
from retime.formats.read_options import ReadOptions
from retime.warp.curve import Warp
from tests.cli.conftest import Run
from tests.formats.c3d_files import Capture


@pytest.fixture
def capture(tmp_path: Path) -> Path:
    """Two seconds of two markers at 60 Hz, one of them lost for a while, a force at 240 Hz, and an event."""
    times = np.arange(120) / 60
    points = np.zeros((120, 2, 4))
    points[:, 0, 0], points[:, 1, 1] = 300 * np.sin(3 * times), 200 * np.cos(4 * times)
    points[40:46, 1] = (0, 0, 0, -1)
    path = tmp_path / "take.c3d"
    path.write_bytes(
        Capture(
            real=False,
            rate=60.0,
            points=np.round(points),
            labels=["LANK", "RANK"],
            analog=np.round(500 * np.sin(np.arange(480) / 30))[:, None],
            analog_labels=["Fz"],
            events=[(1.0, "Foot Strike", "Left")],
        ).build()
    )
    return path


def test_warp_and_apply_keep_a_capture(run: Run, capture: Path) -> None:
    says = run("warp", capture, "--length", "70%", "-o", "short.c3d", "--save", "w.json").output
    assert "kept gaps: RANK.x, RANK.y, RANK.z frames 41:46" in says
    run("apply", "w.json", capture, "-o", "again.c3d")
    assert Path("short.c3d").read_bytes() == Path("again.c3d").read_bytes()
    file = parse_c3d(Path("short.c3d"), Path("short.c3d").read_bytes(), ReadOptions())
    assert (file.n_frames, file.layout.samples, file.form) == (84, 4, "Intel, 16-bit numbers")
    warp = Warp.load("w.json")
    ((time, label),) = file.events()
    assert label == "Left Foot Strike"
    assert float(warp(time)) == pytest.approx(1.0, abs=1e-5)
    says = run("apply", "w.json", capture, "--out-dir", ".", "--suffix", "_x", "--no-average", "--on-twos").output
    assert "take_x.c3d: its frames resampled, 1.383 s from" in says
    assert Path("take_x.c3d").read_bytes() != Path("short.c3d").read_bytes()


def test_part_of_a_capture(run: Run, capture: Path) -> None:
    run("warp", capture, "--frames", "61:120", "--length", "50%", "-o", "part.c3d")
    file = parse_c3d(Path("part.c3d"), Path("part.c3d").read_bytes(), ReadOptions())
    assert (file.first, file.n_frames) == (61, 30)
    says = run(
        "warp", capture, "--drop-first", "2", "--array", "analog", "--length", "50%", "-o", "x.c3d", code=2
    ).output
    assert "--array counts other frames" in says
    # The whole take, by what the forces tell: their last sample is later than the last frame.
    run("warp", capture, "--array", "analog", "--length", "50%", "-o", "forces.c3d")
    assert parse_c3d(Path("forces.c3d"), Path("forces.c3d").read_bytes(), ReadOptions()).n_frames == 61


def test_a_capture_cut_short(run: Run, capture: Path) -> None:
    capture.write_bytes(capture.read_bytes()[:-1000])
    for command in (("info", capture), ("warp", capture, "--length", "70%", "-o", "x.c3d")):
        assert "120 frames are claimed, and" in run(*command, code=1).output
    says = run("warp", capture, "--repair", "--length", "70%", "-o", "x.c3d").output
    assert "of 120 frames are there and were kept" in says


def test_captures_and_tables(run: Run, capture: Path) -> None:
    run("convert", capture, "take.csv", "--gaps", "keep")
    head, first, *_ = Path("take.csv").read_text().splitlines()
    assert head == "time,LANK.x,LANK.y,LANK.z,RANK.x,RANK.y,RANK.z"
    assert first.startswith("0,") or first.startswith("0.0")
    run("convert", "take.csv", "back.c3d", "--gaps", "keep", "--channel", "*=linear:mm")
    again = json.loads(run("info", "back.c3d", "--json").stdout)
    assert again["facts"]["points"] == "2, in mm"
    assert (again["rate"], again["frames"], again["format"]) == (60.0, 120, "c3d")
    run("convert", capture, "force.csv", "--array", "analog")
    assert Path("force.csv").read_text().count("\n") == 481
    run("convert", capture, "half.c3d", "--rate", "30")
    assert facts(Path("half.c3d"), Path("half.c3d").read_bytes(), ReadOptions())["stored"] == "Intel, real numbers"


def test_joints_become_markers(run: Run, clips: object) -> None:
    run("convert", clips.bvh, "joints.c3d")  # type: ignore[attr-defined]
    says = run("info", "joints.c3d").output
    assert "Hips.x, Hips.y, Hips.z" in says


def test_what_a_capture_tells(run: Run, capture: Path) -> None:
    says = run("info", capture).output
    for line in (
        "stored    Intel, 16-bit numbers",
        "points    2, in mm",
        "analog    1 channels at 240 Hz: Fz (--array analog)",
        "events    1: Left Foot Strike 1.000 s",
    ):
        assert line in says


def test_a_motion_is_no_capture(run: Run, capture: Path) -> None:
    says = run("convert", capture, "x.bvh", code=1).output
    assert "a .bvh file holds a motion, not a signal" in says
