"""Propagation: a limp that was made by hand on one stride of a made walk, and is known for all of them."""

from __future__ import annotations

import itertools
import math
import warnings
from dataclasses import replace
from fractions import Fraction

import numpy as np
import pytest

from retime import imitate
from retime.errors import OptionError, RetimeWarning
from retime.motion import rotation
from retime.motion.motion import Motion
from retime.motion.signal import Signal
from retime.search.guided import guided_warp
from retime.search.poses.references import Reference
from retime.search.wishes.locks import Lock
from retime.warp.apply import apply_warp
from retime.warp.curve import Warp
from tests.motion import walkers

CYCLES = 7
HALF = walkers.N_CYCLE // 2
# Boundaries of the halves of each cycle, frames.
HALVES = list(itertools.pairwise(range(0, CYCLES * walkers.N_CYCLE + 1, HALF)))


@pytest.fixture(scope="module")
def walk() -> Motion:
    """An even walk; its halves begin at multiples of HALF."""
    return walkers.walker(CYCLES * walkers.N_CYCLE + 1)


def limp(first: float, second: float, halves: list[tuple[int, int]] = HALVES) -> Warp:
    """Play the first half of each cycle at one speed, the second one at another; both of one shape."""
    rate, slowness, frames = 30.0, [], []
    for (start, stop), speed in zip(halves, itertools.cycle([first, second]), strict=False):
        t = (np.arange(start, stop) + 0.5 - start) / (stop - start)
        slowness.append(np.exp(-math.log(speed) * np.sin(np.pi * t)))
        frames.append(np.arange(start, stop))
    shown = np.concatenate([[0.0], np.cumsum(np.concatenate(slowness))]) / rate
    return Warp(shown, np.concatenate([*frames, [halves[-1][1]]]) / rate)


def of_frames(warp: Warp, start: int, stop: int) -> Warp:
    """What a warp with a knot at every frame does with some of them; input time 0 is the first."""
    part = slice(start, stop)
    return Warp(warp.output_times[part] - warp.output_times[start], warp.input_times[part] - warp.input_times[start])


def sides(warp: Warp, halves: list[tuple[int, int]], apart_from: tuple[int, int] = (0, 0)) -> float:
    """Mean log speed of first halves less that of second ones, outside of an example."""
    means: list[list[float]] = [[], []]
    for place, (start, stop) in enumerate(halves):
        if stop <= apart_from[0] or start >= apart_from[1] - 1:
            shown = np.interp([start / 30, stop / 30], warp.input_times, warp.output_times)
            means[place % 2].append(math.log((stop - start) / 30 / (shown[1] - shown[0])))
    return float(np.mean(means[0]) - np.mean(means[1]))


@pytest.mark.parametrize(("first", "second"), [(1.6, 1 / 1.6), (1.25, 0.9), (0.5, 1.0)])
@pytest.mark.parametrize("length", ["free", "given"])
def test_a_limp_comes_back_in_every_stride(walk: Motion, first: float, second: float, length: str) -> None:
    truth = limp(first, second)
    example = (2 * walkers.N_CYCLE, 3 * walkers.N_CYCLE + 1)
    wanted = "free" if length == "free" else truth.output_span + 1 / 30
    found = imitate(walk, example, of_frames(truth, *example), length=wanted)
    assert sides(found.warp, HALVES, example) / sides(truth, HALVES, example) == pytest.approx(1.0, abs=0.1)
    assert found.warp.output_span == pytest.approx(truth.output_span, rel=0.03 if length == "free" else 0.002)
    assert found.path.optimal
    assert found.example is not None
    assert (found.example.share, found.example.closed) == (1.0, True)


def test_the_papers_way_copies_how_fast_the_example_is_seen_to_move(walk: Motion) -> None:
    # The clip slows down by itself; the hand touched a stride of its first, brisk part, and only its left half.
    pace = Warp([0.0, 4.0, 4.0 + (walk.end_time - 4.0) * 1.6], [0.0, 4.0, walk.end_time])
    slowing = apply_warp(walk, pace, average=False)
    halves = [(round(30 * float(pace.inverse()(a / 30))), round(30 * float(pace.inverse()(b / 30)))) for a, b in HALVES]
    truth = limp(1.6, 1.0, halves)
    example = (walkers.N_CYCLE, 2 * walkers.N_CYCLE + 1)
    hand = of_frames(truth, *example)
    found = imitate(slowing, example, hand)
    assert found.warp.output_span == pytest.approx(truth.output_span, rel=0.03)
    assert sides(found.warp, halves, example) / sides(truth, halves, example) == pytest.approx(1.0, abs=0.12)
    # It hurries the slow part until it moves as the example does.
    paper = imitate(slowing, example, hand, paper=True)
    assert paper.warp.output_span < 0.9 * truth.output_span
    assert paper.example is None


def test_the_papers_way_is_to_be_guided_by_the_stretch_as_it_is_now(walk: Motion) -> None:
    hand = Warp([0.0, 2.0], [0.0, 40 / 30])
    found = imitate(walk, (40, 81), hand, paper=True, length="120%")
    retimed = apply_warp(walk.frames(40, 81), hand, average=False)
    same = guided_warp(walk, reference=Reference(retimed), paper=True, length="120%")
    assert np.array_equal(found.path.frames, same.path.frames)


@pytest.mark.parametrize("length", ["free", "given"])
def test_one_step_as_the_example_leaves_the_other_steps_alone(walk: Motion, length: str) -> None:
    truth = limp(1.6, 1.0)
    example = (2 * walkers.N_CYCLE, 2 * walkers.N_CYCLE + HALF + 1)
    wanted = "free" if length == "free" else truth.output_span + 1 / 30
    found = imitate(walk, example, of_frames(truth, *example), length=wanted)
    assert sides(found.warp, HALVES, example) / sides(truth, HALVES, example) == pytest.approx(1.0, abs=0.12)
    assert found.warp.output_span == pytest.approx(truth.output_span, rel=0.03)
    assert found.example is not None
    assert found.example.period == pytest.approx(walkers.N_CYCLE / 30)


def test_a_slow_example_makes_all_slow(walk: Motion) -> None:
    found = imitate(walk, (40, 81), Warp([0.0, 4.0], [0.0, 40 / 30]))
    assert found.warp.slopes == pytest.approx(1 / 3, rel=0.01)


def test_a_very_slow_hand_is_followed_as_far_as_steps_go(walk: Motion) -> None:
    found = imitate(walk, (40, 81), Warp([0.0, 20 * 4 / 3], [0.0, 4 / 3]))
    assert found.upsample == 20
    assert np.median(found.warp.slopes) == pytest.approx(1 / 20, rel=0.05)


def test_what_is_unlike_the_example_keeps_its_speed(walk: Motion) -> None:
    # In the middle it stands for two seconds, bowed and with its arms up.
    pose = rotation.identity(walk.n_frames, walk.skeleton.n_joints)
    for side, sign in (("Left", 1), ("Right", -1)):
        pose[:, walk.skeleton.index(f"{side}Arm")] = rotation.about_axis(2, np.full(walk.n_frames, sign * 1.5))
    pose[:, walk.skeleton.index("Spine")] = rotation.about_axis(0, np.full(walk.n_frames, 1.5))
    stands = (np.arange(walk.n_frames) >= 120) & (np.arange(walk.n_frames) < 180)
    stops = replace(walk, rotations=np.where(stands[:, None, None], pose, walk.rotations))
    with pytest.warns(RetimeWarning, match="says little"):
        found = imitate(stops, (40, 81), Warp([0.0, 8 / 3], [0.0, 4 / 3]))
    assert found.example is not None
    ((start, end),) = found.example.unspoken
    assert (start, end) == pytest.approx((4.0, 6.0), abs=0.15)
    shown = np.interp([4.4, 5.6], found.warp.input_times, found.warp.output_times)
    assert shown[1] - shown[0] == pytest.approx(1.2, rel=0.1)
    walked = np.interp([1.0, 3.5], found.warp.input_times, found.warp.output_times)
    assert walked[1] - walked[0] == pytest.approx(5.0, rel=0.1)


def test_a_pause_in_the_middle_of_a_step_is_no_step(walk: Motion) -> None:
    pauses = apply_warp(
        walk, Warp([0.0, 4.0, 6.0, 6.0 + walk.end_time - 4.05], [0.0, 4.0, 4.05, walk.end_time]), average=False
    )
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", RetimeWarning)
        found = imitate(pauses, (40, 81), Warp([0.0, 8 / 3], [0.0, 4 / 3]))
    shown = np.interp([4.3, 5.7], found.warp.input_times, found.warp.output_times)
    assert shown[1] - shown[0] == pytest.approx(1.4, rel=0.1)


def test_the_order_and_the_unit_of_joints_do_not_matter(walk: Motion) -> None:
    example, hand = (80, 121), of_frames(limp(1.6, 1 / 1.6), 80, 121)
    found = imitate(walk, example, hand)
    joints = walk.skeleton.n_joints
    order = [0, *np.random.default_rng(0).permutation(np.arange(1, joints)).tolist()]
    # A joint stands after its parent.
    order.sort(key=lambda joint: _depth(walk, joint))
    again = imitate(walkers.permuted(walk, order), example, hand)
    assert np.array_equal(found.path.frames, again.path.frames)
    in_inches = imitate(walkers.scaled(walk, 39.37), example, hand)
    assert np.array_equal(found.path.frames, in_inches.path.frames)


def _depth(motion: Motion, joint: int) -> int:
    parent = motion.skeleton.parents[joint]
    return 0 if parent < 0 else 1 + _depth(motion, parent)


def test_a_limp_goes_from_one_clip_to_another(walk: Motion) -> None:
    truth = limp(1.6, 1 / 1.6)
    # Another body, another clock, another pace: 1.25 times as fast, at 60 Hz.
    other = walkers.built(walk, np.full(walk.skeleton.n_joints, 0.7), 0.7)
    brisk = apply_warp(other, Warp([0.0, walk.end_time / 1.25], [0.0, walk.end_time]), average=False)
    example = (80, 121)
    with pytest.warns(RetimeWarning, match="another clip"):
        found = imitate(brisk, example, of_frames(truth, *example), example_clip=walk)
    halves = [(round(a / 1.25), round(b / 1.25)) for a, b in HALVES]
    assert sides(found.warp, halves) / sides(truth, HALVES) == pytest.approx(1.0, abs=0.12)
    assert found.warp.output_span == pytest.approx(truth.output_span / 1.25, rel=0.04)
    assert found.example is not None
    assert found.example.elsewhere
    assert found.example.tempo == pytest.approx(1.25, rel=0.1)


def test_a_mirror_image_gives_both_sides_the_timing_of_one(walk: Motion) -> None:
    truth = limp(1.6, 1.0)
    example = (80, 80 + HALF + 1)
    with pytest.warns(RetimeWarning, match="mirror image"):
        found = imitate(
            walk, example, of_frames(truth, *example), example_clip=Reference(walk, mirror=True), length="free"
        )
    assert found.example is not None
    assert (found.example.mirrored, found.example.elsewhere) == (True, False)
    # Half a cycle in the mirror is the other half: both are hurried.
    assert abs(sides(found.warp, HALVES, example)) < 0.3 * abs(sides(truth, HALVES, example))


def swing(seconds: float = 8.0, rate: int = 30) -> Signal:
    t = np.arange(round(seconds * rate) + 1) / rate
    return Signal(("x", "y"), np.stack([np.sin(np.pi * t), np.cos(np.pi * t)], axis=1), Fraction(rate), "swing")


def test_signals_and_arrays_follow_a_hand() -> None:
    hand = Warp([0.0, 0.5, 2.5], [0.0, 1.0, 2.0])
    found = imitate(swing(), (60, 121), hand)
    assert found.warp.output_span == pytest.approx(10.0, rel=0.02)
    again = imitate(swing().values, (60, 121), hand, rate=30)
    assert np.array_equal(found.path.frames, again.path.frames)
    # The speeds of the hand come back at the same phase.
    shown = np.interp([6.2, 6.8, 7.2, 7.8], found.warp.input_times, found.warp.output_times)
    assert [0.6 / (shown[1] - shown[0]), 0.6 / (shown[3] - shown[2])] == pytest.approx([2.0, 0.5], rel=0.1)


def test_a_group_gets_one_warp(walk: Motion) -> None:
    # It sways with the walker, at another rate.
    phase = np.pi * np.arange(2 * walk.n_frames - 1) / walkers.N_CYCLE
    camera = Signal(("pan",), np.sin(phase)[:, None], Fraction(60), "camera")
    truth = limp(1.6, 1 / 1.6)
    example = (80, 121)
    found = imitate([walk, camera], example, of_frames(truth, *example))
    assert sides(found.warp, HALVES, example) / sides(truth, HALVES, example) == pytest.approx(1.0, abs=0.15)
    assert found.clips == (walk, camera)
    paper = imitate([walk, camera], example, of_frames(truth, *example), paper=True)
    assert paper.clips == (walk, camera)


def test_keys_tangents_locks_and_limits_hold(walk: Motion) -> None:
    example = (80, 121)
    found = imitate(
        walk,
        example,
        of_frames(limp(1.6, 1 / 1.6), *example),
        keys=[(4.5, 4.0, 0.5)],
        locks=[Lock(6.0, 7.0, 1.0, 1.0)],
        speed=(0.4, 2.0),
        length=9.0,
    )
    warp = found.warp
    assert float(warp(4.0)) == pytest.approx(4.5, abs=1e-9)
    assert warp.speed([3.99, 4.01]) == pytest.approx([0.5, 0.5])
    inside = np.interp([6.05, 6.95], warp.input_times, warp.output_times)
    assert inside[1] - inside[0] == pytest.approx(0.9, rel=1e-6)
    assert (warp.slopes.min() >= 0.4 - 1e-9, warp.slopes.max() <= 2.0 + 1e-9) == (True, True)
    assert warp.count_frames(30) == 270


def test_a_free_length_keeps_its_bounds(walk: Motion) -> None:
    slow = Warp([0.0, 8 / 3], [0.0, 4 / 3])
    bounded = imitate(walk, (40, 81), slow, max_length="120%")
    assert bounded.warp.count_frames(30) <= 1.2 * walk.n_frames
    # All share in what is too much.
    assert bounded.warp.slopes == pytest.approx(1 / 1.2, rel=0.06)


def test_a_loop_stays_one(walk: Motion) -> None:
    one = walk.frames(0, 2 * walkers.N_CYCLE + 1)
    found = imitate(one, (0, 41), of_frames(limp(1.4, 0.8), 0, 41), loop=True)
    assert found.warp.slopes[0] == pytest.approx(found.warp.slopes[-1])
    assert found.loop


def test_smoothness_evens_out_what_the_hand_did(walk: Motion) -> None:
    example, hand = (80, 121), of_frames(limp(1.6, 1 / 1.6), 80, 121)
    plain, smooth = (imitate(walk, example, hand, smoothness=weight).warp for weight in (0.0, 50.0))
    assert np.ptp(np.log(smooth.slopes)) < 0.8 * np.ptp(np.log(plain.slopes))


def test_a_still_clip_gets_the_hands_speed_in_the_example_and_some_speed_elsewhere() -> None:
    still = Signal(("x",), np.zeros((90, 1)), Fraction(30), "still")
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", RetimeWarning)
        found = imitate(still, (10, 41), Warp([0.0, 2.0], [0.0, 1.0]))
    assert found.warp.slopes[20:60] == pytest.approx(0.5, rel=0.05)


def test_the_result_says_what_it_was_matched_with(walk: Motion) -> None:
    found = imitate(walk, (80, 121), of_frames(limp(1.6, 1 / 1.6), 80, 121))
    explained = found.explain()
    assert found.references == ("walker, the example",)
    assert found.n_reference == 41
    assert "walker, the example" in explained.to_csv()


@pytest.mark.parametrize(
    ("options", "says"),
    [
        ({"score": "conditional"}, "score would have no effect"),
        ({"free_weight": "sum"}, "free_weight would have no effect"),
        ({"evenness": 2.0}, "evenness would have no effect"),
        ({"content": 2.0}, "content would have no effect"),
        ({"ends": 0.2, "evenness": 1.0}, "evenness, ends would have no effect"),
        ({"keep_flights": 2.0}, "keep_flights would have no effect"),
        ({"search": "heuristic", "length": "80%"}, "heuristic"),
        ({"example_clip": [Reference(swing()), Reference(swing())]}, "lies in one clip"),
    ],
)
def test_what_would_have_no_effect_is_refused(options: dict, says: str) -> None:
    with pytest.raises(OptionError, match=says):
        imitate(swing(), (60, 121), Warp([0.0, 2.5], [0.0, 2.0]), **options)


def test_a_hand_that_holds_one_moment_is_refused() -> None:
    with pytest.raises(OptionError, match="holds one moment"):
        imitate(swing(), (60, 121), Warp([0.0, 2.5], [1.0, 1.0]))


def test_a_part_of_an_example_that_a_hand_did_not_touch_plays_as_at_its_edge() -> None:
    found = imitate(swing(), (60, 121), Warp([0.0, 3.0], [0.2, 1.8]))
    assert np.median(found.warp.slopes) == pytest.approx(1.6 / 3.0, rel=0.02)


def test_a_name_tells_no_difference(walk: Motion) -> None:
    example, hand = (80, 121), of_frames(limp(1.6, 1 / 1.6), 80, 121)
    found = imitate(walk, example, hand)
    again = imitate(replace(walk, name=""), example, hand)
    assert np.array_equal(found.path.frames, again.path.frames)


def test_what_would_take_for_ever_is_refused_before_anything_is_looked_up(monkeypatch: pytest.MonkeyPatch) -> None:
    """A random request: the example was compared with its surroundings for 14 s, and then the rate was refused."""
    t = 2 * np.pi * np.arange(200) / 25
    clip = Signal(("x", "y"), np.stack([np.sin(t), np.cos(t)], axis=1), Fraction(25))
    hand = Warp([0.0, 2.0], [0.0, 1.0])
    with pytest.raises(OptionError, match="an analysis at 1000 Hz sees no more"):
        imitate(clip, (50, 80), hand, rate=1000)
    assert imitate(clip, (50, 76), hand).n_output > 2
    monkeypatch.setenv("RETIME_MOST_SECONDS", "0.00001")
    with pytest.raises(OptionError, match=r"looking 239 frames up in an example of \d+ would take about .* lower rate"):
        imitate(clip, (50, 80), hand)
