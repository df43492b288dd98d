"""align(): the best path there is under every wish, and known answers: a doubled take, walks, signals, a cycle."""

from __future__ import annotations

import inspect
import itertools
import warnings
from dataclasses import replace
from fractions import Fraction
from pathlib import Path

import numpy as np
import pytest

import retime
from retime import InfeasibleWarpError, Lock, Motion, OptionError, Reference, RetimeWarning, Signal, Warp, align
from retime.search.align import ANALYSIS, SOLVE, AlignSession
from retime.search.options import OPTIONS, default_of
from retime.search.result import GuidedWarp
from study.clips.walks import Step, steps
from tests.reference import wishes as literal
from tests.reference.scores import acceleration, distance, exact, velocity
from tests.reference.wishes import Wishes


def curve(n_frames: int, seed: int, rate: int = 30) -> Signal:
    """Smooth, and nowhere the same twice."""
    rng = np.random.default_rng(seed)
    t = np.arange(n_frames)[:, None] / rate
    values = np.sin(t * rng.uniform(1, 4, 3) + rng.uniform(0, 6, 3)) + 0.4 * t * rng.uniform(-1, 1, 3)
    return Signal(("x", "y", "z"), values, Fraction(rate), name="curve")


def totals(result: GuidedWarp, reference: np.ndarray, wishes: Wishes, time_scale: float = 0.2) -> dict:
    """Measure every path that obeys the wishes, by exact fractions; the reference's poses are those of its clock."""
    y, z = exact(result.input_poses), exact(reference)
    rate, tau = Fraction(30), Fraction(time_scale)
    n_output = result.n_output

    def feature(rows: list, i: int, j: int, k: int) -> list[Fraction]:
        return rows[j] + velocity(rows[i], rows[k], rate, tau) + acceleration(rows[i], rows[j], rows[k], rate, tau)

    wanted = [feature(z, p - 1, p, p + 1) for p in range(1, n_output - 1)]
    known: dict[tuple[int, ...], float] = {}

    def cost(p: int, i: int, j: int, k: int) -> float:
        if (p, i, j, k) not in known:
            known[p, i, j, k] = distance(feature(y, i, j, k), wanted[p - 1])
        return known[p, i, j, k]

    return {
        path: sum(cost(p, *path[p - 1 : p + 2]) for p in range(1, n_output - 1))
        for path in literal.paths(result.reduction, result.max_skip, wishes, [n_output])
    }


@pytest.mark.parametrize(
    ("given", "wishes"),
    [
        ({}, Wishes()),
        ({"keys": [(0.2, 0.1)]}, Wishes()),
        ({"keys": [(0.2, 0.1), (0.1, 0.17)], "max_skip": 8}, Wishes()),
        ({"keys": [(0.1, 0.1, 0.5)], "max_skip": 5}, Wishes()),
        ({"locks": [Lock(0.1, 0.2, 1.0)]}, Wishes(locks=[Lock(0.1, 0.2, 1.0)])),
        ({"locks": [Lock(0.1, 0.2, 0.5, 1.0)]}, Wishes(locks=[Lock(0.1, 0.2, 0.5, 1.0)])),
        ({"speed": (0.5, 1.5), "upsample": 2}, Wishes(slowest=0.5, fastest=1.5)),
    ],
)
@pytest.mark.parametrize("seed", range(2))
def test_no_path_that_obeys_is_nearer_to_the_reference(given: dict, wishes: Wishes, seed: int) -> None:
    clip, reference = curve(10, seed), curve(8, 100 + seed)
    session = AlignSession(clip, reference, low_pass=0)
    limits = {} if "speed" in given else {"upsample": 2, "max_skip": 4}
    result = session.solve(**(limits | given))
    every = totals(result, session._reference_tracks[0].at(np.arange(8) / 30, 0), wishes)
    assert tuple(result.path.frames) in every
    assert every[tuple(result.path.frames)] == pytest.approx(min(every.values()), rel=1e-9)
    assert result.total == pytest.approx(min(every.values()), rel=1e-9)
    assert result.path.optimal
    for key in given.get("keys", ()):
        assert float(result.warp(key[1])) == pytest.approx(key[0], abs=1e-9)


def test_wishes_bind_and_hold_in_the_curve() -> None:
    clip, reference = curve(150, 1), curve(120, 2)
    free = align(clip, reference)
    locked = align(clip, reference, locks=[Lock(1.0, 2.0)])
    inside = (locked.warp.input_times[:-1] >= 1.0 + 1e-9) & (locked.warp.input_times[1:] <= 2.0 - 1e-9)
    assert np.allclose(locked.warp.slopes[inside], 1.0)
    assert not np.allclose(free.warp.slopes[1:-1], 1.0)
    assert locked.total > free.total
    limited = align(clip, reference, speed="4/5..3/2")
    assert limited.warp.slopes.min() >= 0.8 - 1e-9
    assert limited.warp.slopes.max() <= 1.5 + 1e-9
    keyed = align(clip, reference, keys=[(2.0, 2.5, 0.5)])
    assert float(keyed.warp(2.5)) == pytest.approx(2.0, abs=1e-9)
    beside = np.flatnonzero(np.abs(keyed.warp.output_times - 2.5) < 1 / 30)
    assert np.allclose(keyed.warp.slopes[beside[:-1]], 0.5)


def test_smoothness_is_charged_on_changes_of_speed() -> None:
    clip, reference = curve(150, 2), curve(130, 3)
    rough = []
    for weight in (0.0, 1.0, 30.0):
        result = align(clip, reference, smoothness=weight)
        taken = np.log(np.diff(result.path.frames))
        rough.append(float(np.square(np.diff(taken)).sum()))
        # What is charged beside the distances.
        charged = result.total - float(np.nansum(result.explain().scores))
        assert charged == pytest.approx(0.0, abs=1e-6) if weight == 0 else charged > 0
    assert rough[0] > rough[1] > rough[2]


def known_warp(end: float, seed: int) -> Warp:
    """Speeds between about a half and one and a half."""
    rng = np.random.default_rng(seed)
    s = np.linspace(0, 1, 300)
    n = rng.uniform(1.5, 3.5)
    return Warp(
        s * end * rng.uniform(0.8, 1.2),
        end * (s + 0.4 / (2 * np.pi * n) * (np.sin(2 * np.pi * s * n) - s * np.sin(2 * np.pi * n))),
    )


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("what", ["signal", "figure"])
def test_a_doubled_take_gives_back_the_warp_it_was_made_with(what: str, seed: int) -> None:
    clip: Motion | Signal = curve(200, seed, rate=60) if what == "signal" else retime.sample()
    warp = known_warp(clip.end_time, seed)
    double: Motion | Signal
    if isinstance(clip, Signal):
        double = retime.apply_warp(clip, warp, average=False)
    else:
        double = retime.apply_warp(clip, warp, average=False, contacts=None)
    result = align(clip, double)
    times = np.linspace(0.1, warp.output_end - 0.1, 400)
    off = np.abs(result.warp(times) - warp(times))
    linear = np.abs(times * clip.end_time / warp.output_end - warp(times))
    # The search looks 30 times a second; where a figure stands still, one moment is as good as another.
    assert np.median(off) < 0.5 / 30
    assert np.mean(off) < 0.35 * np.mean(linear)


def test_the_output_takes_as_long_as_the_reference_at_the_clips_own_rate() -> None:
    clip = curve(200, 5, rate=60)
    for n_frames, rate in ((100, 24), (91, 50), (120, 30)):
        reference = curve(n_frames, 6, rate=rate)
        shown = align(clip, reference).apply()
        assert shown.rate == clip.rate
        assert abs(shown.end_time - reference.end_time) <= 0.5 / 60 + 1e-9


def test_two_series_of_keypoints_are_put_in_step() -> None:
    """A hand's path in pixels, drawn twice in different rhythms, by two people of different size."""
    s = np.linspace(0, 1, 240)
    first, second = s + 0.08 * np.sin(2 * np.pi * 2 * s) / 2, s + 0.1 * np.sin(2 * np.pi * 1.5 * s) / 2
    second = (second - second[0]) / (second[-1] - second[0])

    def drawn(phase: np.ndarray, size: float, rate: int) -> Signal:
        x, y = 320 + size * np.sin(9 * phase), 240 + size * 0.6 * np.sin(14 * phase + 1)
        return Signal(("wrist.x", "wrist.y"), np.stack([x, y], axis=1), Fraction(rate))

    one, other = drawn(first, 100, 30), drawn(second, 110, 25)
    result = align(one, other)
    times = np.linspace(0.3, other.end_time - 0.3, 200)
    # The phase that is shown, and the phase of the other at that time.
    shown = np.interp(result.warp(times), np.arange(240) / 30, first)
    wanted = np.interp(times, np.arange(240) / 25, second)
    evenly = np.interp(times * one.end_time / other.end_time, np.arange(240) / 30, first)
    assert np.abs(shown - wanted).max() < 0.02
    assert np.abs(evenly - wanted).max() > 0.05


def test_a_cycle_is_repeated_for_a_long_signal() -> None:
    t = np.arange(31) / 30
    cycle = Signal(("x", "y"), np.stack([np.sin(2 * np.pi * t), np.cos(2 * np.pi * t)], axis=1), Fraction(30))
    # Four turns and a half, ever faster.
    s = np.arange(151) / 150
    phase = 2 * np.pi * 4.5 * (0.6 * s + 0.4 * s**2)
    clip = Signal(("x", "y"), np.stack([np.sin(phase), np.cos(phase)], axis=1), Fraction(30))
    result = align(clip, cycle, repeat=4.5)
    assert result.warp.output_end == pytest.approx(4.5)
    shown = result.apply()
    at = np.arange(shown.n_frames) / 30
    assert np.abs(shown.values[5:-5, 0] - np.sin(2 * np.pi * at)[5:-5]).max() < 0.12


def test_a_repeated_reference_that_does_not_meet_is_named() -> None:
    clip = curve(100, 1)
    with pytest.warns(RetimeWarning, match="does not end as it begins"):
        align(clip, curve(40, 2), repeat=2)
    t = 2 * np.pi * np.arange(41) / 40
    ring = Signal(("x", "y", "z"), np.stack([np.sin(t), np.cos(t), np.sin(2 * t)], axis=1), Fraction(30))
    align(clip, ring, repeat=2)


def test_of_a_reference_and_its_mirror_image_the_nearer_is_followed() -> None:
    clip = retime.sample()
    clip = clip.frames(0, clip.n_frames // 2)
    plain = align(clip, clip)
    both = align(clip, Reference(clip, mirror=True))
    assert plain.total == both.total == 0.0
    assert both.references == (clip.name,)
    other_way = mirror_image(clip)
    assert align(clip, Reference(other_way)).total > 0
    mirrored = align(clip, Reference(other_way, mirror=True))
    assert mirrored.references == (f"{clip.name}, mirrored",)
    assert mirrored.total == pytest.approx(0.0, abs=1e-6)


def mirror_image(clip: Motion) -> Motion:
    """Move each joint as the other side's does, seen in a mirror across X."""
    names = clip.skeleton.names
    swapped = [name.replace("Left", "#").replace("Right", "Left").replace("#", "Right") for name in names]
    others = [names.index(name) for name in swapped]
    translations = np.asarray(clip.translations)[:, others] * [-1, 1, 1]
    return replace(clip, rotations=clip.rotations[:, others] * [1, 1, -1, -1], translations=translations)


def test_a_group_keeps_step_with_a_group() -> None:
    one, other = curve(120, 1), curve(120, 2)
    warp = known_warp(one.end_time, 3)
    doubles = [retime.apply_warp(clip, warp, average=False) for clip in (one, other)]
    result = align([one, other], doubles)
    times = np.linspace(0.2, warp.output_end - 0.2, 100)
    assert np.abs(result.warp(times) - warp(times)).max() < 1 / 30


def test_each_output_frame_is_matched_with_the_reference_at_its_own_time() -> None:
    result = align(curve(120, 1), curve(90, 2))
    why = result.explain()
    assert np.allclose(why.reference_times[1:-1, 0], why.output_times[1:-1])
    assert np.isnan(why.reference_times[[0, -1]]).all()
    assert why.references[1:-1].max() == 0
    assert np.allclose(why.scores[1:-1], why.costs[1:-1])
    assert why.seam_cost == 0.0
    assert (result.warp.method, result.staircase.method) == ("align", "align")


def test_influence_mixes_with_the_spline() -> None:
    clip, reference = curve(120, 1), curve(90, 2)
    spline, half, full = (align(clip, reference, influence=share).warp for share in (0.0, 0.5, 1.0))
    times = np.linspace(0, full.output_end, 50)
    assert np.allclose(spline(times), times * clip.end_time / full.output_end)
    assert np.allclose(half(times), (spline(times) + full(times)) / 2)


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({"repeat": 0.5}, "repeat is at least 1"),
        ({"repeat": np.inf}, "repeat is at least 1"),
        ({"repeat": 1e12}, "nothing is played at less than 1/255 of its speed"),
        ({"reference": None}, "nothing to keep step with"),
        ({"reference": [Reference(curve(50, 1)), Reference(curve(50, 2))]}, "only one reference"),
        ({"reference": curve(2, 1)}, "needs at least 3"),
    ],
)
def test_what_can_not_be_kept_step_with_is_refused(given: dict, message: str) -> None:
    with pytest.raises(OptionError, match=message):
        align(curve(60, 3), **{"reference": curve(50, 4), **given})


def test_a_reference_that_is_too_short_for_the_limits_says_so() -> None:
    with pytest.raises(InfeasibleWarpError, match="the speed limits allow no less than 46f"):
        align(curve(90, 1), curve(30, 2), speed="1/2..2")


def test_options_about_the_length_are_none_of_its() -> None:
    with pytest.raises(OptionError, match="no option 'length'"):
        AlignSession(curve(60, 1), curve(50, 2)).solve(length="50%")


def test_the_signature_says_what_the_declaration_says() -> None:
    parameters = inspect.signature(align).parameters
    declared = {option.name for option in OPTIONS}
    assert set(ANALYSIS) | set(SOLVE) == declared & set(parameters)
    for name in (*ANALYSIS, *SOLVE):
        assert parameters[name].default == default_of(name)


def walk(mocap: Path, name: str) -> Motion:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", RetimeWarning)
        clip = retime.read(mocap / "cmu-bvh" / f"{name}.bvh")
    assert isinstance(clip, Motion)
    # The first frame is a T-pose.
    return clip.frames(1, clip.n_frames)


def out_of_step(clip: Motion, reference: list[Step], warp: Warp) -> np.ndarray:
    """How far each step of a clip, as shown, is from the nearest of the same foot in the reference, seconds."""
    back = warp.inverse()
    return np.array(
        [
            min(abs(float(back(one.time)) - other.time) for other in reference if other.side == one.side)
            for one in steps(clip)
        ]
    )


@pytest.mark.parametrize(
    ("one", "other"), [("07_09", "07_12"), ("07_10", "07_12"), ("07_01", "08_10"), ("08_10", "07_01")]
)
def test_two_walks_go_in_stride(mocap: Path, one: str, other: str) -> None:
    clip, reference = walk(mocap, one), walk(mocap, other)
    in_step = out_of_step(clip, steps(reference), align(clip, reference).warp)
    evenly = out_of_step(clip, steps(reference), Warp([0, reference.end_time], [0, clip.end_time]))
    assert in_step.max() < 0.05
    assert np.median(in_step) < 0.6 * np.median(evenly)


def test_one_stride_of_another_leads_a_walk(mocap: Path) -> None:
    clip, reference = walk(mocap, "07_09"), walk(mocap, "07_12")
    rate = float(clip.rate)

    def between(motion: Motion, first: Step, last: Step) -> Motion:
        return motion.frames(round(first.time * rate), round(last.time * rate) + 1)

    left = [[step for step in steps(motion) if step.side == "left"] for motion in (clip, reference)]
    whole, stride = between(clip, left[0][0], left[0][2]), between(reference, *left[1][:2])
    warp = align(whole, stride, repeat=2).warp
    assert warp.output_end == pytest.approx(2 * stride.end_time, abs=0.5 / rate + 1e-9)
    # The other foot of the stride, once in each repetition.
    right = next(step.time for step in steps(reference) if step.side == "right" and step.time > left[1][0].time)
    wanted = [right - left[1][0].time + turn * stride.end_time for turn in (0, 1)]
    shown = [float(warp.inverse()(step.time)) for step in steps(whole) if step.side == "right"]
    assert np.allclose(shown, wanted, atol=0.05)
    assert len(list(itertools.pairwise(wanted))) == 1
