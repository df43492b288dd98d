"""The sample clip: made by its generator, and true to the ground, to gravity and to a body.

Everything is measured on the shipped file through forward kinematics. Nothing is taken over from the generator: the
masses are of another table than its own, and heels and soles are declared here.
"""

from __future__ import annotations

import itertools
import json
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from retime import read
from retime.data import SAMPLE
from retime.motion import rotation
from retime.motion.flights import flights
from retime.motion.kinematics import global_poses

ROOT = Path(__file__).resolve().parents[1]
PHASES = SAMPLE.with_name("sample_phases.json")
SIDES = ("Left", "Right")
# Where the heel touches the ground, from the ankle, in the foot's space; heights of the other ends of a flat sole.
HEEL = (0.0, -8.0, -5.5)
BALL_HEIGHT, TOE_HEIGHT = 2.0, 1.0
# Winter's table (after Dempster): percent of the body's mass, and the centre's share of the way between two ends.
TRUNK = (49.7, "Hips", "Neck", 0.5)
HEAD = (8.1, "Neck", "Head end", 0.5)
LIMBS = (
    (2.8, "Arm", "ForeArm", 0.436),
    (1.6, "ForeArm", "Hand", 0.430),
    (0.6, "Hand", "Hand end", 0.506),
    (10.0, "UpLeg", "Leg", 0.433),
    (4.65, "Leg", "Foot", 0.433),
    (1.45, "Foot", "ToeBase end", 0.5),
)


@pytest.fixture(scope="module")
def clip():
    return read(SAMPLE)


@pytest.fixture(scope="module")
def places(clip):
    """Global positions, cm, of joints by name, of end sites ("Head end") and heels ("LeftHeel")."""
    poses = global_poses(clip)
    skeleton = clip.skeleton
    found = {name: poses.positions[:, joint] for joint, name in enumerate(skeleton.names)}
    for i, site in enumerate(skeleton.end_sites):
        found[f"{skeleton.names[site.parent]} end"] = poses.end_positions[:, i]
    for side in SIDES:
        foot = skeleton.index(f"{side}Foot")
        found[f"{side}Heel"] = poses.positions[:, foot] + rotation.rotate(poses.rotations[:, foot], HEEL)
    return found


@pytest.fixture(scope="module")
def phases():
    return json.loads(PHASES.read_text(encoding="utf-8"))


@pytest.fixture(scope="module")
def jumps(phases):
    """First and last frame of each flight."""
    return [(phase["first_frame"], phase["last_frame"]) for phase in phases if phase["name"] == "flight"]


def mass_centre(places) -> np.ndarray:
    """Return the centre of mass by Winter's table, shape (n, 3)."""
    segments = [TRUNK, HEAD]
    for side in SIDES:
        segments += [(mass, f"{side}{near}", f"{side}{far}", share) for mass, near, far, share in LIMBS]
    masses = np.array([mass for mass, *_ in segments])
    centres = [(1 - share) * places[near] + share * places[far] for _, near, far, share in segments]
    assert masses.sum() == pytest.approx(100.0)
    return np.tensordot(masses / 100, np.array(centres), axes=1)


def accelerations(values: np.ndarray, first: int, last: int) -> np.ndarray:
    """Fit a parabola to frames first to last of values in cm at 60 Hz; return its acceleration in m/s²."""
    times = np.arange(first, last + 1) / 60
    return 2 * np.polyfit(times, values[first : last + 1], 2)[0] / 100


def test_it_is_what_its_generator_writes(tmp_path, clip) -> None:
    subprocess.run([sys.executable, ROOT / "tools" / "make_sample.py", tmp_path / "made.bvh"], check=True)
    made = read(tmp_path / "made.bvh")
    assert made.skeleton.names == clip.skeleton.names
    assert made.rate == clip.rate
    np.testing.assert_allclose(made.local_translations, clip.local_translations, atol=1e-3)
    np.testing.assert_allclose(np.degrees(made.declared_angles), np.degrees(clip.declared_angles), atol=1e-3)
    assert (tmp_path / "made_phases.json").read_text(encoding="utf-8") == PHASES.read_text(encoding="utf-8")


def test_it_is_a_grown_body_and_a_small_file(clip, places) -> None:
    assert clip.rate == 60
    assert 20 <= clip.skeleton.n_joints <= 24
    assert 12 <= clip.end_time <= 14
    assert SAMPLE.stat().st_size < 700_000
    assert places["Head end"][0, 1] == pytest.approx(174, abs=2)


def test_its_phases_cover_it_in_order(clip, phases) -> None:
    once = ["walk", "pause", "crouch", "push", "flight", "land", "pause"]
    again = ["walk", "crouch", "push", "flight", "land", "stand"]
    assert [phase["name"] for phase in phases] == ["stand", *once, *again]
    assert phases[0]["first_frame"] == 0
    assert phases[-1]["last_frame"] == clip.n_frames - 1
    for before, after in itertools.pairwise(phases):
        assert after["first_frame"] == before["last_frame"] + 1


def test_flights_are_found_where_its_phases_say(clip, jumps) -> None:
    # The detector asks for some height, so it may leave out a few frames at the ends.
    assert np.abs(np.array(flights(clip)) - np.array(jumps)).max() <= 3


def test_the_centre_of_mass_falls_freely_in_flight(places, jumps) -> None:
    centre = mass_centre(places)
    for first, last in jumps:
        sideways, up, forward = accelerations(centre, first, last)
        assert up == pytest.approx(-9.81, rel=0.02)
        assert abs(sideways) < 0.1
        assert abs(forward) < 0.5
        # No frame strays from the parabola: the limbs move, the whole does not.
        times = np.arange(last - first + 1)
        height = centre[first : last + 1, 1]
        assert np.abs(height - np.polyval(np.polyfit(times, height, 2), times)).max() < 0.5


def test_the_mean_joint_falls_about_freely_in_flight(clip, jumps) -> None:
    height = global_poses(clip).positions[:, :, 1].mean(axis=1)
    for first, last in jumps:
        assert accelerations(height, first, last) == pytest.approx(-9.81, rel=0.15)


def test_both_feet_are_well_off_the_ground_in_flight_and_one_stands_at_all_other_times(places, jumps) -> None:
    low = np.min(
        [places[f"{side}{part}"][:, 1] for side in SIDES for part in ("Heel", "ToeBase", "ToeBase end")], axis=0
    )
    flying = np.zeros(len(low), dtype=bool)
    for first, last in jumps:
        flying[first : last + 1] = True
        assert np.sum(low[first : last + 1] > 5.0) >= 0.3 * 60
    assert low[~flying].max() < TOE_HEIGHT + 0.01


def test_the_second_jump_is_higher_and_longer(places, jumps) -> None:
    (a, b), (c, d) = jumps
    centre = mass_centre(places)
    assert centre[c : d + 1, 1].max() > centre[a : b + 1, 1].max() + 5
    assert centre[d, 2] - centre[c, 2] > centre[b, 2] - centre[a, 2] + 10


def test_planted_feet_do_not_slide(places) -> None:
    for side in SIDES:
        for part, height in (("Heel", 0.0), ("ToeBase", BALL_HEIGHT)):
            point = places[f"{side}{part}"]
            planted = np.abs(point[:, 1] - height) < 0.01
            edges = np.flatnonzero(np.diff(np.concatenate([[False], planted, [False]])))
            stances = [point[a:b, ::2] for a, b in edges.reshape(-1, 2) if b - a >= 3]
            assert len(stances) >= 6
            for stance in stances:
                assert np.ptp(stance, axis=0).max() < 0.1


def test_nothing_sinks_into_the_ground(places) -> None:
    assert min(place[:, 1].min() for place in places.values()) > -0.05


def test_joints_stay_within_a_bodys_limits(clip) -> None:
    order = {letter: i for i, letter in enumerate("ZYX")}
    degrees = np.degrees(clip.declared_angles)
    # Flexion about X: legs bend back and arms forward, so hips and elbows are negative.
    limits = {
        "Leg": (0.0, 140.0),
        "UpLeg": (-120.0, 30.0),
        "Foot": (-50.0, 60.0),
        "ToeBase": (-75.0, 10.0),
        "Arm": (-170.0, 60.0),
        "ForeArm": (-145.0, 0.0),
    }
    for joint, (least, most) in limits.items():
        for side in SIDES:
            bend = degrees[:, clip.skeleton.index(f"{side}{joint}"), order["X"]]
            assert least < bend.min()
            assert bend.max() < most
    # Far from where the middle angle makes the others jump.
    assert np.abs(degrees[:, :, order["Y"]]).max() < 45


def test_no_joint_pops(clip) -> None:
    rates = np.diff(np.degrees(clip.declared_angles), axis=0) * 60
    assert np.abs(rates).max() < 1300
    # Away from pushing off and landing, where knees are fast, nothing is.
    changes = np.abs(np.diff(rates, axis=0)).max(axis=(1, 2))
    assert np.median(changes) < 60
    assert changes.max() < 800


def test_it_stands_alive_and_walks_at_a_walking_pace(clip, places, phases) -> None:
    root = clip.local_translations[:, 0]
    for phase in phases:
        part = slice(phase["first_frame"], phase["last_frame"] + 1)
        if phase["name"] in ("stand", "pause"):
            travelled = np.ptp(places["Head"][part], axis=0)
            assert travelled.max() > 0.2, "breath and sway"
            assert np.ptp(root[part], axis=0).max() < 8
        if phase["name"] == "walk":
            speed = np.gradient(root[part, 2]) * 60 / 100
            assert 1.0 < np.mean(np.sort(speed)[-45:]) < 1.5


def test_arms_swing_against_the_legs(places, phases) -> None:
    for phase in phases:
        if phase["name"] == "walk":
            part = slice(phase["first_frame"], phase["last_frame"] + 1)
            for side in SIDES:
                arm = places[f"{side}Hand"][part, 2] - places[f"{side}Arm"][part, 2]
                leg = places[f"{side}Foot"][part, 2] - places["Hips"][part, 2]
                assert np.corrcoef(arm, leg)[0, 1] < -0.5
