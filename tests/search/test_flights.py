"""Flights keep unit speed: the promise of the paper, on real jumps and on the sample clip.

In flight is decided here without the package's own finder: the root falls freely, and both feet are off the ground.
"""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

import retime
from retime.motion.kinematics import global_poses
from retime.motion.motion import Motion
from retime.search.guided import guided_warp
from retime.search.result import GuidedWarp

SAMPLE = Path(retime.__file__).parent / "data/sample.bvh"


def in_flight(motion: Motion, feet: tuple[str, ...], clearance: float = 0.05) -> np.ndarray:
    """Say for each frame whether the root's vertical acceleration is near -9.8 m/s² and both feet are up (metres)."""
    assert motion.metres_per_unit is not None
    positions = global_poses(motion).positions * motion.metres_per_unit
    rate = float(motion.rate)
    half = round(0.05 * rate)
    times = np.arange(-half, half + 1) / rate
    heights = positions[:, 0, 1]
    acceleration = np.zeros(motion.n_frames)
    for frame in range(half, motion.n_frames - half):
        acceleration[frame] = 2 * np.polyfit(times, heights[frame - half : frame + half + 1], 2)[0]
    lowest = positions[:, [motion.skeleton.index(name) for name in feet], 1]
    up = lowest - np.quantile(lowest, 0.1, axis=0) > clearance
    return (np.abs(acceleration + 9.8) < 3) & up.all(axis=1)


def stretches(flags: np.ndarray, at_least: int) -> list[tuple[int, int]]:
    """First and last frame of each run of true flags."""
    edges = np.flatnonzero(np.diff(np.concatenate([[0], flags.astype(int), [0]])))
    return [(int(a), int(b) - 1) for a, b in edges.reshape(-1, 2) if b - a >= at_least]


def speeds_in(result: GuidedWarp, rate: float, flights: list[tuple[int, int]]) -> list[np.ndarray]:
    """Speeds of the path's steps that begin and end inside each flight (frames of the motion)."""
    places = result.reduction.input_times[result.path.frames] * rate
    return [result.path_speeds[(places[:-1] >= first - 1e-6) & (places[1:] <= last + 1e-6)] for first, last in flights]


def check_kept(result: GuidedWarp, rate: float, flights: list[tuple[int, int]]) -> None:
    for (first, last), speeds in zip(flights, speeds_in(result, rate, flights), strict=True):
        # Every analysis frame of the flight is there: all steps that fit are, and none is longer than one.
        assert len(speeds) >= (last - first) / rate * result.rate - 2
        assert (speeds == 1.0).all()


FEET = ("lfoot", "ltoes", "rfoot", "rtoes")


@pytest.fixture(scope="module")
def walk_and_jumps(mocap: Path) -> Motion:
    with pytest.warns(retime.FormatWarning, match="120 Hz"):
        motion = retime.read(mocap / "cmu-asfamc/86_01.amc")
    assert isinstance(motion, Motion)
    return motion.frames(0, 1980)


@pytest.mark.parametrize("length", ["80%", "65%"])
@pytest.mark.parametrize("score", ["joint", "conditional"])
def test_both_jumps_of_a_walk_keep_every_frame(walk_and_jumps: Motion, length: str, score: str) -> None:
    flights = stretches(in_flight(walk_and_jumps, FEET), at_least=12)
    assert len(flights) == 2
    assert sum((last - first) // 4 + 1 for first, last in flights) >= 20
    result = guided_warp(walk_and_jumps, length=length, score=score)
    check_kept(result, 120.0, flights)
    # The rest is sped up instead: so much is what the shorter length asks for.
    assert result.path_speeds.mean() == pytest.approx(100 / int(length[:-1]), rel=0.01)


def test_a_jump_slowed_down_keeps_every_frame(mocap: Path) -> None:
    with pytest.warns(retime.FormatWarning, match="120 Hz"):
        motion = retime.read(mocap / "cmu-asfamc/02_04.amc")
    assert isinstance(motion, Motion)
    flights = stretches(in_flight(motion, FEET), at_least=8)
    assert sum(last - first for first, last in flights) >= 50
    result = guided_warp(motion, length="150%")
    check_kept(result, 120.0, [(flights[0][0], flights[-1][1])])
    assert result.path_speeds.mean() == pytest.approx(1 / 1.5, rel=0.01)


@pytest.fixture(scope="module")
def sample_flights() -> list[tuple[int, int]]:
    phases = json.loads(SAMPLE.with_name("sample_phases.json").read_text(encoding="utf-8"))
    return [(phase["first_frame"], phase["last_frame"]) for phase in phases if phase["name"] == "flight"]


@pytest.mark.parametrize("length", ["80%", "65%", "150%"])
@pytest.mark.parametrize("score", ["joint", "conditional"])
def test_the_sample_clip_s_jumps_keep_every_frame(
    sample_flights: list[tuple[int, int]], length: str, score: str
) -> None:
    motion = retime.read(SAMPLE)
    assert isinstance(motion, Motion)
    assert len(sample_flights) == 2
    result = guided_warp(motion, length=length, score=score)
    check_kept(result, float(motion.rate), sample_flights)
