"""What the analysis sees: pose spaces and what they ignore, the low-pass, sampling between frames, differences."""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import retime
from retime.errors import OptionError
from retime.motion import rotation
from retime.motion.motion import Motion
from retime.motion.signal import Signal
from retime.motion.skeleton import Skeleton
from retime.search.poses.spaces import (
    PoseOptions,
    Track,
    _added_up,
    _convolved,
    difference_scales,
    low_pass,
    sample,
    timing_features,
)
from retime.search.poses.vectors import pose_vectors
from tests.reference.scores import acceleration, exact, velocity
from tests.warp.motions import SKELETON, wandering_motion


def moved(motion: Motion, turn: np.ndarray, shift: np.ndarray) -> Motion:
    """Turn and shift each frame as a whole: (n_frames, 4) or (4,), (n_frames, 3) or (3,)."""
    rotations, translations = motion.rotations.copy(), motion.local_translations.copy()
    rotations[:, 0] = rotation.multiply(turn, rotations[:, 0])
    translations[:, 0] = rotation.rotate(turn, translations[:, 0]) + shift
    return replace(motion, rotations=rotations, translations=translations)


def any_turns(n_frames: int, seed: int) -> np.ndarray:
    return Rotation.random(n_frames, rng=np.random.default_rng(seed)).as_quat(scalar_first=True)


def test_torso_features_don_t_see_where_the_body_is_or_how_it_is_turned() -> None:
    motion = wandering_motion(30)
    shifts = np.random.default_rng(1).uniform(-9, 9, (30, 3))
    elsewhere = moved(motion, any_turns(30, 2), shifts)
    np.testing.assert_allclose(pose_vectors(elsewhere, "torso"), pose_vectors(motion, "torso"), rtol=0, atol=1e-12)
    assert pose_vectors(motion, "torso").shape == (30, 9)


def test_without_a_choice_a_figure_that_stands_up_has_its_heading_and_any_other_its_torso() -> None:
    upright = retime.sample().frames(0, 60)
    assert np.array_equal(pose_vectors(upright), pose_vectors(upright, "heading"))
    # A Z-up file, or a figure on the floor: nothing is known of what is up.
    for turn in (rotation.about_axis(0, np.pi / 2), rotation.about_axis(2, np.pi / 2)):
        lying = moved(upright, turn, np.zeros(3))
        assert np.array_equal(pose_vectors(lying), pose_vectors(lying, "torso"))
    point = Motion(Skeleton(("point",), (-1,), np.zeros((1, 3))), rotation.identity(9, 1))
    assert pose_vectors(point).shape == (9, 3)


def test_torso_features_are_joint_positions_seen_from_the_root() -> None:
    # Chest, arm and leg of a figure that stands 1 m up, turned a quarter to its left, tilted, and far away.
    root = rotation.multiply(rotation.about_axis(1, np.pi / 2), rotation.about_axis(2, 0.3))
    rotations = rotation.identity(1, 4)
    rotations[0, 0] = root
    translations = SKELETON.offsets.copy()[None]
    translations[0, 0] = [7.0, 1.0, -3.0]
    poses = pose_vectors(Motion(SKELETON, rotations, translations), "torso")
    np.testing.assert_allclose(poses, [[0, 0.5, 0, 0.3, 0.6, 0, 0.1, -0.2, 0]], atol=1e-15)


def test_heading_features_don_t_see_the_ground_position_or_the_turn() -> None:
    motion = wandering_motion(30)
    rng = np.random.default_rng(3)
    shifts = rng.uniform(-9, 9, (30, 3)) * [1, 0, 1]
    elsewhere = moved(motion, rotation.about_axis(1, rng.uniform(-3, 3, 30)), shifts)
    here = pose_vectors(motion, "heading")
    np.testing.assert_allclose(pose_vectors(elsewhere, "heading"), here, rtol=0, atol=1e-12)
    assert here.shape == (30, 12)


def test_heading_features_see_height_and_tilt() -> None:
    motion = wandering_motion(30)
    here = pose_vectors(motion, "heading").reshape(30, 4, 3)
    still = rotation.identity(1)
    higher = pose_vectors(moved(motion, still, np.array([0, 0.25, 0])), "heading").reshape(30, 4, 3)
    np.testing.assert_allclose(higher - here, np.broadcast_to([0, 0.25, 0], here.shape), atol=1e-12)
    tilted = pose_vectors(moved(motion, rotation.about_axis(0, np.array([0.2])), np.zeros(3)), "heading")
    assert np.abs(tilted.reshape(30, 4, 3) - here)[:, 1:].max() > 0.05


def test_a_signal_s_channels_are_told_in_standard_deviations() -> None:
    rng = np.random.default_rng(0)
    values = rng.standard_normal((200, 3)) * [1, 1e-9, 1e6] + [0, 5, 0]
    signal = Signal(("a", "b", "c"), values, Fraction(30))
    np.testing.assert_allclose(pose_vectors(signal).std(axis=0), 1.0, rtol=1e-6)
    constant = Signal(("k",), np.full((50, 1), 0.1), Fraction(30))
    assert pose_vectors(constant).tolist() == constant.values.tolist()


@pytest.mark.parametrize(
    ("clip", "options"),
    [
        pytest.param("motion", "signal", id="a_motion_is_no_signal"),
        pytest.param("signal", "torso", id="a_signal_has_no_torso"),
        pytest.param("signal", "heading", id="a_signal_has_no_heading"),
        pytest.param("motion", "hip", id="no_such_space"),
        pytest.param("one_joint", "torso", id="one_joint_has_no_torso"),
        pytest.param("motion", PoseOptions(joints=["tail"]), id="no_such_joint"),
    ],
)
def test_a_pose_space_that_does_not_fit_is_refused(clip: str, options: str | PoseOptions) -> None:
    point = Skeleton(("point",), (-1,), np.zeros((1, 3)))
    clips = {
        "motion": wandering_motion(9),
        "signal": Signal(("x",), np.arange(9.0)[:, None]),
        "one_joint": Motion(point, rotation.identity(9, 1)),
    }
    with pytest.raises(OptionError):
        pose_vectors(clips[clip], options)
    assert pose_vectors(clips["one_joint"], "heading").shape == (9, 3)


# The low-pass


@pytest.mark.parametrize("rate", [Fraction(30), Fraction(120), Fraction(24000, 1001)])
@pytest.mark.parametrize("share", [0.02, 0.1, 0.25, 0.4, 0.49])
def test_the_low_pass_halves_the_power_at_its_cutoff(rate: Fraction, share: float) -> None:
    cutoff = share * float(rate)
    frames = np.arange(2001) - 1000

    def gain(frequency: float) -> float:
        wave = np.cos(2 * np.pi * frequency / float(rate) * frames)[:, None]
        return float(low_pass(wave, rate, cutoff)[1000, 0])

    assert gain(cutoff) ** 2 == pytest.approx(0.5, abs=3e-4)
    assert gain(0.0) == pytest.approx(1.0, abs=1e-12)
    # Ever less of ever faster waves, and never a negative share: no ringing.
    gains = [gain(f) for f in np.linspace(0, float(rate) / 2, 20)]
    assert (np.diff(gains) < 1e-4).all()
    assert gains[-1] > -1e-4


def test_the_low_pass_moves_nothing_in_time() -> None:
    impulse = np.zeros((401, 1))
    impulse[200] = 1.0
    response = low_pass(impulse, Fraction(120), 4.0)[:, 0]
    np.testing.assert_allclose(response, response[::-1], rtol=0, atol=1e-15)
    assert response.argmax() == 200
    assert response.sum() == pytest.approx(1.0, abs=1e-12)
    assert (response >= -1e-12).all()
    for place in (100, 300):
        other = low_pass(np.roll(impulse, place - 200, axis=0), Fraction(120), 4.0)[:, 0]
        np.testing.assert_allclose(np.roll(other, 200 - place), response, rtol=0, atol=1e-15)


@pytest.mark.parametrize("n_frames", [2, 3, 7, 500])
@pytest.mark.parametrize("cutoff", [0.01, 1.0, 4.0, 14.9])
def test_the_low_pass_keeps_straight_lines_and_ends(n_frames: int, cutoff: float) -> None:
    line = np.outer(np.arange(n_frames), [1.0, -3.0, 0.0]) + np.array([5.0, 0.0, 0.1])
    np.testing.assert_allclose(low_pass(line, Fraction(30), cutoff), line, rtol=0, atol=1e-10)
    noise = np.random.default_rng(0).standard_normal((n_frames, 2))
    smooth = low_pass(noise, Fraction(30), cutoff)
    np.testing.assert_allclose(smooth[[0, -1]], noise[[0, -1]], rtol=0, atol=1e-12)
    assert smooth.shape == noise.shape


def test_the_low_pass_treats_columns_alike_and_time_s_directions_too() -> None:
    noise = np.random.default_rng(0).standard_normal((300, 4))
    smooth = low_pass(noise, Fraction(30), 3.0)
    for column in range(4):
        np.testing.assert_allclose(low_pass(noise[:, [column]], Fraction(30), 3.0)[:, 0], smooth[:, column], atol=1e-14)
    np.testing.assert_allclose(low_pass(noise[::-1], Fraction(30), 3.0)[::-1], smooth, atol=1e-14)


@pytest.mark.parametrize("n_frames", [50, 128, 129, 260, 1000])
@pytest.mark.parametrize("cutoff", [0.5, 2.0, 5.0, 11.0])
def test_the_low_pass_adds_up_neighbours_and_goes_on_beyond_the_ends(n_frames: int, cutoff: float) -> None:
    values = np.random.default_rng(n_frames).standard_normal((n_frames, 3))
    impulse = np.zeros((2 * n_frames - 1, 1))
    impulse[n_frames - 1] = 1.0
    weights = low_pass(impulse, Fraction(30), cutoff)[:, 0]
    assert weights.sum() == pytest.approx(1.0, abs=1e-12)
    # The clip goes on as it came, reflected in its end points.
    wide = np.concatenate([2 * values[0] - values[:0:-1], values, 2 * values[-1] - values[-2::-1]])
    expected = [weights @ wide[frame : frame + 2 * n_frames - 1] for frame in range(n_frames)]
    np.testing.assert_allclose(low_pass(values, Fraction(30), cutoff), expected, rtol=0, atol=1e-12)


@pytest.mark.parametrize("seed", range(40))
def test_both_ways_to_low_pass_agree(seed: int) -> None:
    generator = np.random.default_rng(seed)
    reach = int(generator.integers(1, 25))
    n_frames = reach + int(generator.integers(1, 300))
    half = generator.random(reach + 1)
    values = generator.standard_normal((n_frames, int(generator.integers(1, 20))))
    values[generator.random(n_frames) < 0.1] = values[0]
    np.testing.assert_allclose(_added_up(values, half), _convolved(values, half), rtol=0, atol=1e-12)


@pytest.mark.parametrize("cutoff", [0.0, 2.0, 11.0])
def test_a_track_that_is_read_twice_is_the_same(cutoff: float) -> None:
    track = Track(np.random.default_rng(0).standard_normal((200, 3)), Fraction(60))
    for rate in (30.0, 24.0, 30.0):
        n_frames = int(track.end_time * rate) + 1
        wanted = sample(low_pass(track.vectors, track.rate, cutoff), track.rate, np.arange(n_frames) / rate)
        for _ in range(2):
            assert np.array_equal(track.at_rate(n_frames, rate, cutoff), wanted)


@pytest.mark.parametrize("cutoff", [0.0, 15.0, 1e9])
def test_a_cutoff_of_zero_or_beyond_the_rate_changes_nothing(cutoff: float) -> None:
    noise = np.random.default_rng(0).standard_normal((30, 2))
    assert np.array_equal(low_pass(noise, Fraction(30), cutoff), noise)


@pytest.mark.parametrize("cutoff", [1e-300, 1e-9, 1e-3])
def test_a_cutoff_of_next_to_nothing_stays_finite(cutoff: float) -> None:
    noise = np.random.default_rng(0).standard_normal((300, 2))
    assert np.isfinite(low_pass(noise, Fraction(30), cutoff)).all()


@pytest.mark.parametrize("cutoff", [-1.0, float("nan"), float("inf")])
def test_a_cutoff_that_is_no_frequency_is_refused(cutoff: float) -> None:
    with pytest.raises(OptionError, match="cutoff"):
        low_pass(np.zeros((9, 1)), Fraction(30), cutoff)


# Between frames


@pytest.mark.parametrize("rate", [Fraction(30), Fraction(24000, 1001), Fraction(1), Fraction(1000, 3)])
def test_sampling_at_frames_gives_their_bits(rate: Fraction) -> None:
    vectors = np.random.default_rng(0).standard_normal((400, 3))
    times = np.array([float(frame / rate) for frame in range(400)])
    assert np.array_equal(sample(vectors, rate, times), vectors)
    assert np.array_equal(sample(vectors, rate, np.arange(400) / float(rate)), vectors)


def test_sampling_reproduces_quadratics_inside_and_lines_everywhere() -> None:
    frames = np.arange(20.0)
    curve = np.column_stack([3 * frames**2 - frames + 1, 2 - 5 * frames])
    times = np.linspace(1, 18, 200)
    wanted = np.column_stack([3 * times**2 - times + 1, 2 - 5 * times])
    np.testing.assert_allclose(sample(curve, Fraction(1), times), wanted, rtol=1e-12)
    times = np.linspace(0, 19, 97)
    np.testing.assert_allclose(sample(curve, Fraction(1), times)[:, 1], 2 - 5 * times, rtol=0, atol=1e-12)


def test_sampling_has_no_corners_at_frames() -> None:
    vectors = np.random.default_rng(1).standard_normal((10, 1))
    for frame in range(1, 9):
        before, here, after = sample(vectors, Fraction(1), [frame - 1e-6, frame, frame + 1e-6])[:, 0]
        assert (here - before) / 1e-6 == pytest.approx((after - here) / 1e-6, abs=1e-4)


def test_sampling_is_held_at_the_ends() -> None:
    vectors = np.arange(4.0)[:, None] ** 2
    assert sample(vectors, Fraction(1), [-5.0, 0.0, 3.0, 99.0])[:, 0].tolist() == [0, 0, 9, 9]
    assert sample(vectors[:1], Fraction(1), [-1.0, 0.0, 1.0])[:, 0].tolist() == [0, 0, 0]
    np.testing.assert_allclose(sample(vectors[:2], Fraction(1), [0.25, 0.5]), [[0.25], [0.5]])


def test_a_track_reads_what_the_low_pass_leaves() -> None:
    vectors = np.random.default_rng(0).standard_normal((100, 2))
    track = Track(vectors, Fraction(60))
    times = np.linspace(0, track.end_time, 57)
    for cutoff in (0.0, 4.0, 0.0, 8.0):
        wanted = sample(low_pass(vectors, Fraction(60), cutoff), Fraction(60), times)
        assert np.array_equal(track.at(times, cutoff), wanted)


# Differences


@pytest.mark.parametrize("time_scale", [0.0, 1 / 30, 0.1, 2 / 3])
@pytest.mark.parametrize("rate", [24000 / 1001, 30.0, 120.0])
def test_timing_features_are_pose_velocity_and_acceleration(rate: float, time_scale: float) -> None:
    poses = np.random.default_rng(0).standard_normal((6, 2))
    features = timing_features(poses, rate=rate, time_scale=time_scale)
    y, hertz, tau = exact(poses), Fraction(rate), Fraction(time_scale)
    wanted = [
        [
            *y[t],
            *velocity(y[t - 1], y[t + 1], hertz, tau),
            *acceleration(y[t - 1], y[t], y[t + 1], hertz, tau),
        ]
        for t in range(1, 5)
    ]
    np.testing.assert_allclose(features, np.array(wanted, dtype=float), rtol=1e-12, atol=1e-12)


def test_timing_features_don_t_depend_on_the_rate_of_a_smooth_motion() -> None:
    # y = t² has velocity 2 t and acceleration 2, whatever the rate; in units of the time scale.
    for rate in (15.0, 30.0, 120.0):
        times = np.arange(40) / rate
        features = timing_features(times[:, None] ** 2, rate=rate, time_scale=0.1)
        np.testing.assert_allclose(features[:, 1], 0.1 * 2 * times[1:-1], rtol=1e-9)
        np.testing.assert_allclose(features[:, 2], 0.01 * 2, rtol=1e-9)


@pytest.mark.parametrize("time_scale", [-0.1, float("nan"), float("inf")])
def test_a_time_scale_that_is_no_time_is_refused(time_scale: float) -> None:
    with pytest.raises(OptionError, match="time scale"):
        difference_scales(30.0, time_scale)
