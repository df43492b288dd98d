"""Applying a warp: what must come back bit for bit, and the averages against their definition (§3.4)."""

from __future__ import annotations

import time
from dataclasses import replace
from fractions import Fraction
from importlib import resources

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from retime.errors import OptionError, RetimeWarning
from retime.formats.registry import read
from retime.motion import rotation
from retime.motion.any_motion import AnyMotion
from retime.motion.contacts import Contacts, Foot, contacts, slip
from retime.motion.kinematics import global_poses
from retime.motion.motion import Motion
from retime.motion.signal import Signal
from retime.motion.skeleton import Skeleton
from retime.warp.apply import apply_warp
from retime.warp.curve import Warp, output_frame_times
from retime.warp.slip import retimed_slip
from tests.reference.averaging import half_width, turn_in_space
from tests.reference.curve import window_mean
from tests.warp.motions import SKELETON, wandering_motion, wandering_signal

RATES = [Fraction(30), Fraction(120), Fraction(24000, 1001), Fraction(1), Fraction(100, 3)]


def same_frames(result: AnyMotion, motion: AnyMotion, frames: slice | np.ndarray | list[int]) -> bool:
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
    whole = Warp([0.0, motion.end_time], [0.0, motion.end_time])
    frame_times = np.array([float(frame / rate) for frame in range(n_frames)])
    for warp in (whole, Warp(frame_times, frame_times), whole.smooth(0.2, at=frame_times)):
        result = apply_warp(motion, warp)
        assert result.n_frames == n_frames
        assert same_frames(result, motion, slice(None))


@pytest.mark.parametrize("make", [wandering_motion, wandering_signal])
def test_what_is_not_timing_stays(make: type) -> None:
    motion = make(40, 30)
    result = apply_warp(motion, Warp([0.0, 0.8], [0.0, motion.end_time]))
    assert result.n_frames == 25
    assert (result.rate, result.name, result.first_frame) == (motion.rate, motion.name, motion.first_frame)


def test_the_declared_channels_stay() -> None:
    motion = wandering_motion(40, 30)
    angles = np.random.default_rng(0).random((40, 4, 3))
    declared = Motion(SKELETON, motion.rotations, motion.local_translations, motion.rate, declared_angles=angles)
    result = apply_warp(declared, Warp([0.0, 0.8], [0.0, motion.end_time]))
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
    warp = Warp([0.0, motion.end_time / speed], [0.0, motion.end_time])
    result, plain = apply_warp(motion, warp), apply_warp(motion, warp, average=False)
    assert same_frames(result, plain, slice(None))


@pytest.mark.parametrize("speed", [1.05, 1.5, 2.0, 3.7, 8.0, 40.0])
def test_the_average_is_the_mean_over_as_many_frames_as_the_speed(speed: float) -> None:
    signal = wandering_signal(241, 30)
    warp = Warp([0.0, signal.end_time / speed], [0.0, signal.end_time])
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
    warp = Warp([0.0, 0.5, 1.2], [0.0, 2.0, motion.end_time])
    moved, plain = apply_warp(motion, warp), apply_warp(signal, warp)
    np.testing.assert_allclose(moved.local_translations[:, arm], plain.values, rtol=0, atol=1e-13)
    for still in ("chest", "leg"):
        joint = SKELETON.index(still)
        assert (moved.local_translations[:, joint] == SKELETON.offsets[joint]).all()


def test_rotations_are_averaged_as_rotations() -> None:
    speed, n_frames = 5.0, 121
    motion = wandering_motion(n_frames, 60)
    warp = Warp([0.0, motion.end_time / speed], [0.0, motion.end_time])
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
    warp = Warp([0.0, 0.7, 1.4], [0.0, 2.3, motion.end_time])
    one, other = apply_warp(motion, warp).rotations, apply_warp(flipped, warp).rotations
    np.testing.assert_allclose(np.abs(np.sum(one * other, axis=-1)), 1.0, rtol=0, atol=1e-12)


@pytest.mark.parametrize("degrees", [30, 45, 60, 90, 175])
def test_a_wheel_that_turns_all_the_way_round_keeps_its_angle(degrees: float) -> None:
    # Its mean over the window is no rotation, or is the one in the middle.
    angle = np.radians(degrees) * np.arange(97.0)
    wheel = Motion(SKELETON, np.broadcast_to(rotation.about_axis(1, angle)[:, None], (97, 4, 4)), rate=Fraction(30))
    warp = Warp([0.0, wheel.end_time / 8], [0.0, wheel.end_time])
    result = apply_warp(wheel, warp)
    turn = np.abs(np.sum(result.rotations[:, 0] * rotation.about_axis(1, angle[::8]), axis=-1))
    np.testing.assert_allclose(turn, 1.0, rtol=0, atol=1e-9)


@pytest.mark.parametrize("make", [wandering_motion, wandering_signal])
@pytest.mark.parametrize("length", [0.4, 1.0, 1.51, 7.0])
def test_the_first_and_last_pose_are_kept(make: type, length: float) -> None:
    motion = make(77, 30)
    warp = Warp([0.0, length / 3, length], [0.0, 2.0, motion.end_time])
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
    assert apply_warp(signal, Warp([0.0, 0.01], [0.0, signal.end_time])).values.tolist() == [signal.values[0].tolist()]


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
    warp = Warp([0.0, signal.end_time / 3], [0.0, signal.end_time])
    result = apply_warp(signal, warp)
    assert np.array_equal(result.values[:, 0], np.full(len(result.values), 1e6))
    for frame in (1, 1000, 30_000, 35_999):
        wanted = window_mean(values[3 * frame - 1 : 3 * frame + 2, 1:], 0.0, 2.0)
        np.testing.assert_allclose(result.values[frame, 1], wanted[0], rtol=0, atol=1e-8)


def standing_now_and_then(motion: Motion, seed: int, feet: tuple[Foot, ...] = (Foot(3), Foot(2))) -> Contacts:
    """Made-up contacts of the leg and the arm, in stretches of a few frames."""
    rng = np.random.default_rng(seed)
    columns = [np.repeat(rng.random(motion.n_frames // 7 + 1) < 0.4, 7)[: motion.n_frames] for _ in feet]
    return Contacts(feet, np.stack(columns, axis=1), motion.rate)


def carries(joint: int, foot: Foot) -> bool:
    at = foot.joint
    while at > joint:
        at = SKELETON.parents[at]
    return at == joint


@pytest.mark.parametrize("speed", [1.4, 3.0, 6.5])
@pytest.mark.parametrize("seed", [0, 1])
def test_each_joint_is_turned_in_space_as_its_own_window_says(speed: float, seed: int) -> None:
    motion = wandering_motion(80, 30, seed)
    standing = standing_now_and_then(motion, seed)
    warp = Warp([0.0, motion.end_time / speed], [0.0, motion.end_time])
    result = apply_warp(motion, warp, contacts=standing)
    found = global_poses(result).rotations
    places = warp(output_frame_times(warp, 30)) * 30
    for frame in range(0, len(places), 2):
        for joint in range(4):
            feet = [standing.at_rest[:, i].tolist() for i, foot in enumerate(standing.feet) if carries(joint, foot)]
            half = half_width(speed, places[frame], 80, feet)
            wanted = turn_in_space(motion, joint, places[frame], half)
            assert (Rotation.from_quat(found[frame, joint], scalar_first=True).inv() * wanted).magnitude() < 1e-7


@pytest.mark.parametrize("speed", [1.3, 2.0, 5.0])
@pytest.mark.parametrize("seed", [3, 4])
def test_what_carries_a_standing_foot_is_not_averaged(speed: float, seed: int) -> None:
    motion = wandering_motion(200, 60, seed)
    standing = standing_now_and_then(motion, seed)
    warp = Warp([0.0, 1.0, 1.0 + 2.0 / speed], [0.0, motion.end_time - 2.0, motion.end_time])
    result = apply_warp(motion, warp, contacts=standing)
    plain = apply_warp(motion, warp, average=False)
    shown = standing.at(warp(output_frame_times(warp, 60)))
    assert shown.at_rest.any(axis=0).all()
    for i, foot in enumerate(shown.feet):
        frames = np.flatnonzero(shown.at_rest[:, i])
        chain = [joint for joint in range(4) if carries(joint, foot)]
        kept = np.ix_(frames, chain)
        assert np.array_equal(result.rotations[kept], plain.rotations[kept])
        here, there = (global_poses(each).positions[frames, foot.joint] for each in (result, plain))
        assert np.array_equal(here, there)
    # The others are averaged all the same.
    assert not np.array_equal(result.rotations[:, 1], plain.rotations[:, 1])


def test_the_rest_of_the_body_faces_where_averaging_all_of_it_would_have_it() -> None:
    motion = wandering_motion(120, 30)
    standing = Contacts((Foot(3),), np.ones((120, 1), dtype=bool), motion.rate)
    warp = Warp([0.0, motion.end_time / 4], [0.0, motion.end_time])
    aware = global_poses(apply_warp(motion, warp, contacts=standing)).rotations
    everything = global_poses(apply_warp(motion, warp, contacts=None)).rotations
    still = global_poses(apply_warp(motion, warp, average=False)).rotations
    same = np.abs(np.sum(aware * everything, axis=-1)), np.abs(np.sum(aware * still, axis=-1))
    np.testing.assert_allclose(same[0][:, [1, 2]], 1.0, rtol=0, atol=1e-12)
    np.testing.assert_allclose(same[1][:, [0, 3]], 1.0, rtol=0, atol=1e-12)


@pytest.mark.parametrize("speed", [1.7, 4.0, 9.0])
@pytest.mark.parametrize("seed", range(6))
def test_windows_never_move_against_time(speed: float, seed: int) -> None:
    # What only ever rises still does, averaged over windows that open and close.
    rng = np.random.default_rng(seed)
    motion = wandering_motion(150, 30, seed)
    translations = motion.local_translations.copy()
    translations[:, 3] = np.cumsum(rng.random((150, 3)) ** 8, axis=0)
    motion = replace(motion, translations=translations)
    warp = Warp([0.0, motion.end_time / speed], [0.0, motion.end_time])
    result = apply_warp(motion, warp, contacts=standing_now_and_then(motion, seed))
    assert np.all(np.diff(result.local_translations[:, 3], axis=0) >= -1e-12)


def test_feet_are_found_unless_told() -> None:
    motion = sample()
    warp = Warp([0.0, motion.end_time / 3], [0.0, motion.end_time])
    default, found = apply_warp(motion, warp), apply_warp(motion, warp, contacts=contacts(motion))
    assert np.array_equal(default.rotations, found.rotations)
    without = apply_warp(motion, warp, contacts=None)
    assert not np.array_equal(default.rotations, without.rotations)
    nobody = Contacts((), np.zeros((motion.n_frames, 0), dtype=bool), motion.rate)
    assert np.array_equal(apply_warp(motion, warp, contacts=nobody).rotations, without.rotations)


def test_contacts_of_another_clip_are_refused() -> None:
    motion = wandering_motion(50, 30)
    warp = Warp([0.0, 1.0], [0.0, motion.end_time])
    other = standing_now_and_then(wandering_motion(49, 30), 0)
    with pytest.raises(OptionError, match="contacts are those of 49 frames, but wanderer has 50"):
        apply_warp(motion, warp, contacts=other)
    with pytest.raises(OptionError, match="contacts are those of 49 frames"):
        retimed_slip(motion, warp, contacts=other)


def away_from_polyline(points: np.ndarray, corners: np.ndarray) -> np.ndarray:
    """Distance of each point from the nearest piece of a polyline."""
    a, b = corners[:-1], corners[1:]
    along = np.sum((points[:, None] - a) * (b - a), axis=-1) / np.maximum(np.sum((b - a) ** 2, axis=-1), 1e-300)
    nearest = a + np.clip(along, 0, 1)[..., None] * (b - a)
    return np.min(np.linalg.norm(points[:, None] - nearest, axis=-1), axis=1)


@pytest.mark.parametrize(
    ("output_times", "input_times"),
    [
        pytest.param([0.0, 1.0], [0.0, 5.0], id="fast"),
        pytest.param([0.0, 1.0, 2.0, 5.0], [0.0, 3.0, 3.2, 5.0], id="uneven"),
        pytest.param([0.0, 1.0, 2.0, 2.5], [0.0, 4.0, 1.0, 5.0], id="back_and_forth"),
        pytest.param([0.0, 9.0], [0.0, 5.0], id="slow"),
    ],
)
def test_the_root_stays_on_its_path(output_times: list[float], input_times: list[float]) -> None:
    motion = wandering_motion(151, 30)
    warp = Warp(output_times, input_times)
    for keep in ({}, {"contacts": None}, {"average": False}):
        root = apply_warp(motion, warp, **keep).local_translations[:, 0]
        assert away_from_polyline(root, motion.local_translations[:, 0]).max() < 1e-12
        # And where on it the warp says.
        assert np.array_equal(root, motion.at(warp(output_frame_times(warp, 30))).local_translations[:, 0])


def test_the_paper_averages_the_roots_path_too() -> None:
    motion = wandering_motion(151, 30)
    warp = Warp([0.0, 1.0, 2.0, 5.0], [0.0, 3.0, 3.2, 5.0])
    root = apply_warp(motion, warp, contacts=None, keep_root_path=False).local_translations[:, 0]
    signal = Signal(("x", "y", "z"), motion.local_translations[:, 0], motion.rate)
    np.testing.assert_allclose(root, apply_warp(signal, warp).values, rtol=0, atol=1e-13)
    assert away_from_polyline(root, motion.local_translations[:, 0]).max() > 1e-4


def closed(motion: Motion, times: int = 1) -> Motion:
    """A cycle, its last frame the first one again, played some times; the root walks and turns on."""
    cycle = motion.n_frames - 1
    frames = np.arange(times * cycle + 1)
    q, p = motion.rotations[frames % cycle].copy(), motion.local_translations[frames % cycle].copy()
    travel = motion.local_translations[-1, 0] - motion.local_translations[0, 0]
    p[:, 0] += (frames // cycle)[:, None] * travel
    return replace(motion, rotations=q, translations=p)


def cycle_of(n_frames: int, seed: int = 0) -> Motion:
    """A wanderer that comes back to its first pose, by smooth waves."""
    rng = np.random.default_rng(seed)
    phase = 2 * np.pi * np.arange(n_frames)[:, None, None] / (n_frames - 1)
    waves = sum(rng.uniform(-0.4, 0.4, (4, 3)) * np.sin(k * phase + rng.uniform(0, 6, (4, 3))) for k in (1, 2, 3))
    translations = np.broadcast_to(SKELETON.offsets, (n_frames, 4, 3)).copy()
    translations[:, 0] += 0.2 * waves[:, 0] + np.arange(n_frames)[:, None] * np.array([0.01, 0.0, 0.04])
    translations[:, 2] += 0.1 * waves[:, 2]
    return Motion(SKELETON, rotation.from_euler("ZYX", waves), translations, Fraction(30), name="cycle")


def again_and_again(warp: Warp, times: int) -> Warp:
    """A warp of one cycle, played some times."""
    length, travel = warp.output_span, warp.input_times[-1] - warp.input_times[0]
    output_times = [warp.output_times + k * length for k in range(times)]
    input_times = [warp.input_times + k * travel for k in range(times)]
    joined = [slice(0, None), *[slice(1, None)] * (times - 1)]
    return Warp(
        np.concatenate([each[piece] for each, piece in zip(output_times, joined, strict=True)]),
        np.concatenate([each[piece] for each, piece in zip(input_times, joined, strict=True)]),
    )


LOOPS = [
    pytest.param([0.0, 0.8], [0.0, 2.0], id="fast_all_over"),
    pytest.param([0.0, 0.2, 1.8, 2.0], [0.0, 0.6, 1.4, 2.0], id="fast_at_the_seam"),
    pytest.param([0.0, 0.5, 1.0], [0.0, 0.4, 2.0], id="fast_on_one_side"),
    pytest.param([0.0, 0.1, 0.3], [0.0, 0.5, 2.0], id="longer_than_half_the_cycle"),
]


@pytest.mark.parametrize(("output_times", "input_times"), LOOPS)
def test_a_loop_is_averaged_as_if_it_went_on_for_ever(output_times: list[float], input_times: list[float]) -> None:
    motion, warp = cycle_of(61), Warp(output_times, input_times)
    feet = standing_now_and_then(motion, 5)
    at_rest = feet.at_rest[:-1]
    standing = Contacts(feet.feet, np.concatenate([at_rest, at_rest[:1]]), motion.rate)
    thrice = Contacts(feet.feet, np.concatenate([at_rest] * 3 + [at_rest[:1]]), motion.rate)
    cycle = round(warp.output_span * 30)
    middle = slice(cycle, 2 * cycle + 1)
    for one, three in ((None, None), (standing, thrice)):
        looped = apply_warp(motion, warp, contacts=one, loop=True)
        long = apply_warp(closed(motion, 3), again_and_again(warp, 3), contacts=three)
        assert looped.n_frames == cycle + 1
        if three is None:
            same = np.abs(np.sum(looped.rotations * long.rotations[middle], axis=-1))[:, 1:]
            np.testing.assert_allclose(same, 1.0, rtol=0, atol=1e-12)
        else:
            # Where the root is the input's own, nothing tells the two from each other.
            both = global_poses(looped).rotations, global_poses(long).rotations[middle]
            resting = standing.at(warp(output_frame_times(warp, 30))).at_rest.any(axis=1)
            same = np.abs(np.sum(both[0] * both[1], axis=-1))[resting]
            np.testing.assert_allclose(same[:, 0], 1.0, rtol=0, atol=1e-12)
        np.testing.assert_allclose(
            looped.local_translations[:, 1:], long.local_translations[middle][:, 1:], rtol=0, atol=1e-12
        )


def test_a_window_wider_than_the_cycle_counts_each_frame_once() -> None:
    motion = cycle_of(10)
    signal = Signal(("x", "y", "z"), motion.local_translations[:, 2], motion.rate)
    result = apply_warp(signal, Warp([0.0, 0.02], [0.0, signal.end_time]), loop=True)
    assert result.n_frames == 2
    np.testing.assert_allclose(result.values - signal.values[:9].mean(axis=0), 0.0, rtol=0, atol=1e-12)


@pytest.mark.parametrize(("output_times", "input_times"), LOOPS)
def test_a_loop_ends_in_the_pose_that_it_begins_with(output_times: list[float], input_times: list[float]) -> None:
    motion, warp = cycle_of(61), Warp(output_times, input_times)
    result = apply_warp(motion, warp, loop=True)
    seam = np.abs(np.sum(result.rotations[0] * result.rotations[-1], axis=-1))[1:]
    np.testing.assert_allclose(seam, 1.0, rtol=0, atol=1e-12)
    # Which is an average too: the window is open there, unless the warp is slow on both sides.
    assert not np.array_equal(result.rotations[0, 1], motion.rotations[0, 1])
    # The root's own window closes, so its first and last pose stay.
    assert np.array_equal(result.rotations[[0, -1], 0], motion.rotations[[0, -1], 0])
    assert np.array_equal(result.local_translations[[0, -1], 0], motion.local_translations[[0, -1], 0])


def test_a_looped_signal_goes_on_from_its_last_value() -> None:
    motion = cycle_of(61)
    signal = Signal(("x", "y", "z"), motion.local_translations[:, 0], motion.rate)
    long = Signal(("x", "y", "z"), closed(motion, 3).local_translations[:, 0], motion.rate)
    warp = Warp([0.0, 0.2, 1.8, 2.0], [0.0, 0.6, 1.4, 2.0])
    looped = apply_warp(signal, warp, loop=True).values
    travel = signal.values[-1] - signal.values[0]
    wanted = apply_warp(long, again_and_again(warp, 3)).values[60:121] - travel
    np.testing.assert_allclose(looped, wanted, rtol=0, atol=1e-12)


def test_a_clip_that_is_no_cycle_is_named() -> None:
    motion, warp = cycle_of(61), Warp([0.0, 1.0], [0.0, 2.0])
    apply_warp(motion, warp, loop=True)
    # A cycle without its last frame ends one step too early.
    open_cycle = motion.frames(0, 60)
    with pytest.warns(RetimeWarning, match=r"the last pose of cycle is not its first one again.*degrees away"):
        apply_warp(open_cycle, Warp([0.0, 1.0], [0.0, open_cycle.end_time]), loop=True)
    wanderer = wandering_motion(50, 30)
    with pytest.warns(RetimeWarning, match="the last pose of wanderer"):
        apply_warp(wanderer, Warp([0.0, 1.0], [0.0, wanderer.end_time]), loop=True)


def test_a_root_alone_and_a_single_frame_make_no_seam() -> None:
    ball = Motion(Skeleton(("ball",), (-1,), np.zeros((1, 3))), rotation.about_axis(0, np.arange(9.0)[:, None]))
    assert apply_warp(ball, Warp([0.0, 0.1], [0.0, ball.end_time]), loop=True).n_frames == 4
    one = wandering_motion(1, 30)
    assert apply_warp(one, Warp([0.0, 0.1], [0.0, 0.001]), loop=True).n_frames == 4


def sample() -> Motion:
    with resources.as_file(resources.files("retime") / "data" / "sample.bvh") as place:
        motion = read(place)
    assert isinstance(motion, Motion)
    return motion


class TestSlip:
    @pytest.mark.parametrize("speed", [2, 4, 8])
    def test_averaging_makes_the_figures_feet_slide_and_exempting_them_does_not(self, speed: float) -> None:
        motion = sample()
        report = retimed_slip(motion, Warp([0.0, motion.end_time / speed], [0.0, motion.end_time]))
        assert report.contact_aware.total == pytest.approx(report.unaveraged.total, abs=1e-6)
        assert report.plain.total > (1.05, 1.3, 3.0)[(2, 4, 8).index(speed)] * report.contact_aware.total
        assert report.contact_aware.total < report.input.total

    def test_the_identity_changes_nothing(self) -> None:
        motion = sample()
        report = retimed_slip(motion, Warp([0.0, motion.end_time], [0.0, motion.end_time]))
        for after in (report.unaveraged, report.plain, report.contact_aware):
            assert after.contacts == report.input.contacts
            assert np.array_equal(after.millimetres, report.input.millimetres)

    def test_each_is_the_slip_of_an_output(self) -> None:
        motion = sample().frames(0, 400)
        warp = Warp([0.0, 1.0, 2.0], [0.0, 2.5, motion.end_time])
        standing = contacts(motion)
        report = retimed_slip(motion, warp)
        shown = standing.at(warp(output_frame_times(warp, 60)))
        outputs = (
            (report.unaveraged, apply_warp(motion, warp, average=False)),
            (report.plain, apply_warp(motion, warp, contacts=None, keep_root_path=False)),
            (report.contact_aware, apply_warp(motion, warp, contacts=standing)),
        )
        assert report.input.total == slip(motion, standing).total
        for found, output in outputs:
            assert found.contacts == shown.where_held().spans()
            np.testing.assert_allclose(found.millimetres, slip(output, shown).millimetres, rtol=0, atol=1e-9)

    def test_a_warp_that_leaves_something_out_says_so_once(self) -> None:
        motion = sample().frames(0, 100)
        with pytest.warns(RetimeWarning, match="left out") as caught:
            retimed_slip(motion, Warp([0.0, 0.5], [0.0, 1.0]))
        assert len(caught) == 1
        assert caught[0].filename == __file__


@pytest.mark.parametrize(
    ("end", "says"),
    [
        (1e7, "output of 1e+07 s has 3e+08 frames at 30 frames a second; 10000000 is the most"),
        (1e300, "3e+301 frames"),
        (3.2e5, "the output would have 9600001 frames, and take 2.15 GB, where the input has 20 frames; 2.1 GB are"),
        (
            8739.0,
            "the output would have 262171 frames, and take 0.0587 GB, where the input has 20 frames; 262144 frames",
        ),
    ],
)
def test_an_output_that_no_file_could_hold_is_refused_before_it_is_made(end: float, says: str) -> None:
    motion = wandering_motion(20, Fraction(30))
    for warp in (Warp([0.0, end], [0.0, 19 / 30]), Warp([-end / 2, end / 2], [0.0, 19 / 30])):
        begun = time.process_time()
        with pytest.raises(OptionError) as refused:
            apply_warp(motion, warp)
        assert says in str(refused.value)
        assert time.process_time() - begun < 1


def test_an_output_whose_length_overflows_is_refused() -> None:
    with pytest.raises(OptionError, match="frames at 30 frames a second"):
        Warp([-1e308, 1e308], [0.0, 1.0]).count_frames(30)
