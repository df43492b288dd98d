"""The lines that the project promises, on real motion capture: jumps keep their timing."""

from __future__ import annotations

import itertools
import json
import warnings

import numpy as np
import pytest
from scipy.ndimage import gaussian_filter1d

from retime import FormatWarning, read
from retime.motion.flights import flights
from retime.motion.kinematics import global_poses
from retime.motion.motion import Motion


def speeds_in_flight(document: dict, spans: list[tuple[float, float]]) -> list[np.ndarray]:
    """Take the playback speed of every step of a path that lies within a flight (input seconds)."""
    frames = np.array(document["path"])
    times = frames / (document["rate"] * document["upsample"])
    speeds = np.diff(frames) / document["upsample"]
    return [speeds[(times[:-1] >= start) & (times[1:] <= end)] for start, end in spans]


def test_86_01_shortened_to_65_percent_keeps_both_jumps(run, mocap, tmp_path) -> None:
    clip = mocap / "cmu-asfamc" / "86_01.amc"
    line = ("warp", clip, "--frames", "1:1980", "--length", "65%")
    result = run(*line, "-o", "shorter.bvh", "--plot", "warp.svg")
    assert "flights  2 of 2 kept at unit speed\n" in result.stdout
    # An AMC says no rate, and that is said.
    assert result.stderr.startswith(f"warning: {clip}: ")
    assert result.stderr.count("\n") == 1
    assert "<svg" in (tmp_path / "warp.svg").read_text()[:1000]
    document = json.loads(run(*line, "--json").stdout)
    assert (document["input_frames"], document["output_frames"], document["input_rate"]) == (1980, 1287, 120.0)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", FormatWarning)
        motion = read(clip).frames(0, 1980)
    jumps = flights(motion)
    assert len(jumps) == 2
    speeds = speeds_in_flight(document, [(first / 120, last / 120) for first, last in jumps])
    assert [len(steps) for steps in speeds] == [11, 13]
    assert all(np.all(steps == 1.0) for steps in speeds)

    # What is written jumps as long as what was captured, and walks in less time.
    shorter = read(tmp_path / "shorter.bvh")
    assert (shorter.n_frames, shorter.rate) == (1287, 120)
    # (A step that is hurried over may fall as fast as gravity for a moment.)
    kept = flights(shorter, minimum=0.2)
    assert [last - first for first, last in kept] == pytest.approx([last - first for first, last in jumps], abs=2)

    linear = run(*line, "--method", "linear").stdout
    assert "flights  0 of 2 kept at unit speed; input 5.88-6.28 s at 1.54, 8.10-8.53 s at 1.54\n" in linear


def falling_frames(motion: Motion) -> list[int]:
    """Frames at 30 Hz at which the root falls freely and both feet are 5 cm or more off the ground."""
    assert motion.metres_per_unit is not None
    places = global_poses(motion).positions * motion.metres_per_unit
    dt = 1 / float(motion.rate)
    fall = np.gradient(np.gradient(gaussian_filter1d(places[:, 0, 1], 3), dt), dt)
    feet = [i for i, name in enumerate(motion.skeleton.names) if "foot" in name or "toes" in name]
    lowest = places[:, feet, 1].min(axis=1)
    every = np.arange(0, motion.n_frames, round(1 / dt / 30))
    return np.flatnonzero((fall < -8)[every] & (lowest > np.percentile(lowest, 5) + 0.05)[every]).tolist()


@pytest.mark.parametrize(
    "how",
    [
        ("--features", "heading"),
        ("--features", "heading", "--evenness", "0", "--keep-flights", "0"),
        ("--features", "torso", "--evenness", "0", "--keep-flights", "0"),
    ],
)
def test_all_24_falling_frames_of_86_01_keep_unit_speed(run, mocap, how) -> None:
    clip = mocap / "cmu-asfamc" / "86_01.amc"
    options = ("--frames", "1:1980", "--length", "65%", *how, "--json")
    document = json.loads(run("warp", clip, *options).stdout)
    # Of the frames offered some lie between those at 30 Hz.
    path = [frame / document["upsample"] for frame in document["path"]]
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", FormatWarning)
        falling = falling_frames(read(clip).frames(0, 1980))
    assert len(falling) == 24
    # Two jumps, of which every frame is shown, as long after the one before as it was.
    assert set(falling) <= set(path)
    within = [(a, b) for a, b in itertools.pairwise(falling) if b - a < 10]
    assert len(within) == 22
    assert all(path.index(b) - path.index(a) == b - a for a, b in within)


def test_02_04_lengthened_by_half_keeps_its_jump(run, mocap) -> None:
    clip = mocap / "cmu-bvh" / "02_04.bvh"
    document = json.loads(run("warp", clip, "--drop-first", "1", "--length", "150%", "--json").stdout)
    motion = read(clip)
    (jump,) = flights(motion.frames(1, motion.n_frames))
    (speeds,) = speeds_in_flight(document, [(jump[0] / 120, jump[1] / 120)])
    assert len(speeds) >= 14
    assert np.all(speeds == 1.0)
