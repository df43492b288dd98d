"""Applying a warp: what must come back bit for bit, and the averages against their definition (§3.4)."""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from retime.errors import RetimeWarning
from retime.motion import rotation
from retime.motion.motion import Motion
from retime.motion.signal import Signal
from retime.warp.apply import apply_warp, output_frame_times
from retime.warp.curve import Warp
from tests.reference.curve import window_mean
from tests.warp.motions import SKELETON, wandering_motion, wandering_signal

RATES = [Fraction(30), Fraction(120), Fraction(24000, 1001), Fraction(1), Fraction(100, 3)]


def same_frames(result: Motion | Signal, motion: Motion | Signal, frames: slice | np.ndarray | list[int]) -> bool:
    if isinstance(result, Signal):
        assert isinstance(motion, Signal)
        return np.array_equal(result.values, motion.values[frames])
    assert isinstance(motion, Motion)
    return np.array_equal(result.rotations, motion.rotations[frames]) and np.array_equal(
        result.local_translations, motion.local_translations[frames]
    )


@pytest.mark.parametrize("make", [wandering_motion, wandering_signal])
@pytest.mark.parametrize("rate", RATES)
@pytest.mark.parametrize("n_frames", [2, 3, 250])
def test_the_identity_gives_every_frame_back_bit_for_bit(make: type, rate: Fraction, n_frames: int) -> None:
    motion = make(n_frames, rate)
    whole = Warp([0.0, motion.duration], [0.0, motion.duration])
    frame_times = np.array([float(frame / rate) for frame in range(n_frames)])
    for warp in (whole, Warp(frame_times, frame_times), whole.smooth(0.2, at=frame_times)):
        result = apply_warp(motion, warp)
        assert result.n_frames == n_frames
        assert same_frames(result, motion, slice(None))


@pytest.mark.parametrize("make", [wandering_motion, wandering_signal])
def test_what_is_not_timing_stays(make: type) -> None:
    motion = make(40, 30)
    result = apply_warp(motion, Warp([0.0, 0.8], [0.0, motion.duration]))
    assert result.n_frames == 25
    assert (result.rate, result.name, result.first_frame) == (motion.rate, motion.name, motion.first_frame)


def test_the_declared_channels_stay() -> None:
    motion = wandering_motion(40, 30)
    angles = np.random.default_rng(0).random((40, 4, 3))
    declared = Motion(SKELETON, motion.rotations, motion.local_translations, motion.rate, declared_angles=angles)
    result = apply_warp(declared, Warp([0.0, 0.8], [0.0, motion.duration]))
    assert result.declared_angles is not None
    assert result.declared_angles.shape == (25, 4, 3)


@pytest.mark.parametrize("make", [wandering_motion, wandering_signal])
@pytest.mark.parametrize("rate", RATES)
def test_stretches_at_unit_speed_come_back_bit_for_bit(make: type, rate: Fraction) -> None:
    # Twice as fast for 20 output frames, then unit speed, then three times as fast.
    motion = make(161, rate)
    frames = np.concatenate([np.arange(0, 40, 2), np.arange(40, 101), np.arange(103, 161, 3)])
    warp = Warp(np.arange(len(frames)) / float(rate), frames / float(rate))
    result = apply_warp(motion, warp)
    # The first and last frame of the stretch border on a fast one: theirs are averaged.
    inside = slice(21, 80)
    assert frames[inside].tolist() == list(range(41, 100))
    kept = result.frames(inside.start, inside.stop)
    assert same_frames(kept, motion, frames[inside])


@pytest.mark.parametrize("make", [wandering_motion, wandering_signal])
@pytest.mark.parametrize("speed", [1.0, 0.73, 0.25])
def test_where_not_sped_up_nothing_is_averaged(make: type, speed: float) -> None:
    motion = make(60, 24)
    warp = Warp([0.0, motion.duration / speed], [0.0, motion.duration])
    result, plain = apply_warp(motion, warp), apply_warp(motion, warp, average=False)
    assert same_frames(result, plain, slice(None))


@pytest.mark.parametrize("speed", [1.05, 1.5, 2.0, 3.7, 8.0, 40.0])
def test_the_average_is_the_mean_over_as_many_frames_as_the_speed(speed: float) -> None:
    signal = wandering_signal(241, 30)
    warp = Warp([0.0, signal.duration / speed], [0.0, signal.duration])
    result = apply_warp(signal, warp)
    places = warp(output_frame_times(warp, 30)) * 30
    for frame, place in enumerate(places):
        # The window of `speed` frames spans speed - 1 intervals; at the ends it closes.
        half = min((speed - 1) / 2, place, 240 - place)
        # Near the ends, half a period of the neighbourhood in which speed is measured lies outside: same speed.
        wanted = window_mean(signal.values, place - half, place + half) if half > 1e-6 else signal.values[round(place)]
        np.testing.assert_allclose(result.values[frame], wanted, rtol=0, atol=1e-12)


def test_translations_are_averaged_as_signals_are() -> None:
    motion = wandering_motion(100, 30)
    arm = SKELETON.index("arm")
    translations = motion.local_translations.copy()
    translations[:, arm] = wandering_signal(100, 30, seed=3).values
    motion = replace(motion, translations=translations)
    signal = Signal(("x", "y", "z"), translations[:, arm], motion.rate)
    warp = Warp([0.0, 0.5, 1.2], [0.0, 2.0, motion.duration])
    moved, plain = apply_warp(motion, warp), apply_warp(signal, warp)
    np.testing.assert_allclose(moved.local_translations[:, arm], plain.values, rtol=0, atol=1e-13)
    for still in ("chest", "leg"):
        joint = SKELETON.index(still)
        assert (moved.local_translations[:, joint] == SKELETON.offsets[joint]).all()


def test_rotations_are_averaged_as_rotations() -> None:
    speed, n_frames = 5.0, 121
    motion = wandering_motion(n_frames, 60)
    warp = Warp([0.0, motion.duration / speed], [0.0, motion.duration])
    result = apply_warp(motion, warp)
    places = warp(output_frame_times(warp, 60)) * 60
    for frame in range(1, result.n_frames - 1):
        half = min((speed - 1) / 2, places[frame], n_frames - 1 - places[frame])
        within = motion.at(np.linspace(places[frame] - half, places[frame] + half, 401) / 60)
        for joint in range(4):
            mean = Rotation.from_quat(within.rotations[:, joint], scalar_first=True).mean()
            found = Rotation.from_quat(result.rotations[frame, joint], scalar_first=True)
            spread = np.max(
                (mean.inv() * Rotation.from_quat(within.rotations[:, joint], scalar_first=True)).magnitude()
            )
            # The chordal mean and the mean of quaternions part company with the cube of the spread.
            assert (mean.inv() * found).magnitude() < 0.02 * spread**3 + 1e-4


def test_the_sign_of_a_quaternion_means_nothing() -> None:
    motion = wandering_motion(90, 30)
    signs = np.random.default_rng(3).choice([-1.0, 1.0], (90, 4, 1))
    flipped = Motion(SKELETON, motion.rotations * signs, motion.local_translations, motion.rate)
    warp = Warp([0.0, 0.7, 1.4], [0.0, 2.3, motion.duration])
    one, other = apply_warp(motion, warp).rotations, apply_warp(flipped, warp).rotations
    np.testing.assert_allclose(np.abs(np.sum(one * other, axis=-1)), 1.0, rtol=0, atol=1e-12)


@pytest.mark.parametrize("degrees", [30, 45, 60, 90, 175])
def test_a_wheel_that_turns_all_the_way_round_keeps_its_angle(degrees: float) -> None:
    # Its mean over the window is no rotation, or is the one in the middle.
    angle = np.radians(degrees) * np.arange(97.0)
    wheel = Motion(SKELETON, np.broadcast_to(rotation.about_axis(1, angle)[:, None], (97, 4, 4)), rate=Fraction(30))
    warp = Warp([0.0, wheel.duration / 8], [0.0, wheel.duration])
    result = apply_warp(wheel, warp)
    turn = np.abs(np.sum(result.rotations[:, 0] * rotation.about_axis(1, angle[::8]), axis=-1))
    np.testing.assert_allclose(turn, 1.0, rtol=0, atol=1e-9)


@pytest.mark.parametrize("make", [wandering_motion, wandering_signal])
@pytest.mark.parametrize("length", [0.4, 1.0, 1.51, 7.0])
def test_the_first_and_last_pose_are_kept(make: type, length: float) -> None:
    motion = make(77, 30)
    warp = Warp([0.0, length / 3, length], [0.0, 2.0, motion.duration])
    result = apply_warp(motion, warp)
    assert same_frames(result.frames(0, 1), motion, [0])
    assert same_frames(result.frames(result.n_frames - 1, result.n_frames), motion, [76])


@pytest.mark.parametrize("make", [wandering_motion, wandering_signal])
def test_holds_repeat_one_pose_and_backward_spans_run_backward(make: type) -> None:
    motion = make(61, 30)
    warp = Warp([0.0, 1.0, 2.0, 3.0, 4.0], [0.0, 1.0, 1.0, 0.0, 1.0])
    with pytest.warns(RetimeWarning, match="left out"):
        result = apply_warp(motion, warp)
    frames = [*range(31), *[30] * 30, *range(29, -1, -1), *range(1, 31)]
    assert same_frames(result, motion, frames)


def test_backward_and_fast_is_averaged_too() -> None:
    signal = wandering_signal(121, 30)
    forward = Warp([0.0, 2.0], [0.0, 4.0])
    backward = Warp([0.0, 2.0], [4.0, 0.0])
    there, back = apply_warp(signal, forward).values, apply_warp(signal, backward).values
    np.testing.assert_allclose(back, there[::-1], rtol=0, atol=1e-12)


def test_a_clip_at_another_rate_is_shown_at_its_own() -> None:
    slow, fast = wandering_signal(31, 30), wandering_signal(121, 120)
    warp = Warp([0.0, 0.6, 1.5], [0.0, 0.5, 1.0])
    assert apply_warp(slow, warp).n_frames == 46
    result = apply_warp(fast, warp)
    assert result.n_frames == 181
    assert result.rate == 120


@pytest.mark.parametrize("rate", [24.0, 24000 / 1001, 30.0, 120.0])
@pytest.mark.parametrize("end", [0.3, 1.0, 1.0133, 1.049, 2.0 / 3, 7.30001])
@pytest.mark.parametrize("start", [0.0, 0.4, -1.0])
def test_output_frames_stand_a_period_apart_and_end_with_the_warp(rate: float, end: float, start: float) -> None:
    times = output_frame_times(Warp([start, start + end], [0.0, 1.0]), rate)
    assert len(times) == round(end * rate) + 1
    assert times[0] == start
    assert times[-1] == start + end
    steps = np.diff(times) * rate
    np.testing.assert_allclose(steps[:-1], 1.0, rtol=0, atol=1e-9)
    assert steps[-1] + 1e-9 >= 0.5
    assert steps[-1] <= 1.5 + 1e-9


def test_a_warp_shorter_than_half_a_frame_gives_one() -> None:
    signal = wandering_signal(10, 30)
    assert apply_warp(signal, Warp([0.0, 0.01], [0.0, signal.duration])).values.tolist() == [signal.values[0].tolist()]


@pytest.mark.parametrize(
    ("input_times", "says"),
    [
        pytest.param([0.0, 5.0], "held at its ends", id="beyond_the_end"),
        pytest.param([-1.0, 2.0], "held at its ends", id="before_the_start"),
        pytest.param([0.0, 1.0], "left out", id="the_end_left_out"),
        pytest.param([1.0, 2.0], "left out", id="the_start_left_out"),
    ],
)
def test_a_warp_that_does_not_cover_the_clip_says_so(input_times: list[float], says: str) -> None:
    signal = wandering_signal(61, 30)
    with pytest.warns(RetimeWarning, match=says):
        apply_warp(signal, Warp([0.0, 2.0], input_times))


def test_long_clips_lose_no_digits() -> None:
    # A camera a kilometre away, in millimetres, for an hour.
    values = np.column_stack([np.full(108_000, 1e6), 1e6 + 0.1 * np.sin(np.arange(108_000))])
    signal = Signal(("x", "y"), values, Fraction(30))
    warp = Warp([0.0, signal.duration / 3], [0.0, signal.duration])
    result = apply_warp(signal, warp)
    assert np.array_equal(result.values[:, 0], np.full(len(result.values), 1e6))
    for frame in (1, 1000, 30_000, 35_999):
        wanted = window_mean(values[3 * frame - 1 : 3 * frame + 2, 1:], 0.0, 2.0)
        np.testing.assert_allclose(result.values[frame, 1], wanted[0], rtol=0, atol=1e-8)
