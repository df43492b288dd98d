"""guided_warp from end to end, on made-up clips whose right answer is known."""

from __future__ import annotations

import warnings
from fractions import Fraction

import numpy as np
import pytest

from retime.data import sample
from retime.errors import InfeasibleWarpError, OptionError, RetimeWarning
from retime.motion.signal import Signal
from retime.search.guided import guided_warp
from retime.search.result import GuidedWarp
from retime.search.wishes.locks import Lock
from retime.warp.apply import apply_warp
from tests.warp.motions import wandering_motion, wandering_signal

SCORES = ["joint", "conditional"]


def check(result: GuidedWarp) -> None:
    """What holds of every guided warp."""
    frames, steps = result.path.frames, np.diff(result.path.frames)
    assert len(frames) == result.n_output
    assert [int(frames[position]) for position in result.reduction.positions] == list(result.reduction.frames)
    assert ((steps >= 1) & (steps <= result.max_skip)).all()
    assert result.plan.allowed[frames[:-1], steps - 1].all()
    assert result.path.lower_bound <= result.total
    for warp in (result.warp, result.staircase):
        assert warp.keytimes == result.reduction.keytimes
        for key in warp.keytimes:
            assert float(warp(key.output_time)) == key.input_time
    assert len(result.staircase.output_times) == result.n_output


def place(times: np.ndarray) -> np.ndarray:
    """Where a point is on a curve that is nowhere near itself twice."""
    return np.column_stack([times, np.sin(2 * times), np.cos(1.3 * times)])


def clip_at(times: np.ndarray, rate: int = 30) -> Signal:
    return Signal(("x", "y", "z"), place(times), Fraction(rate))


# Known answers


@pytest.mark.parametrize("score", SCORES)
@pytest.mark.parametrize("rates", [(30, 30), (120, 24)])
def test_a_warped_copy_of_the_reference_is_warped_back(score: str, rates: tuple[int, int]) -> None:
    # The reference moves along a curve; the input does so too, but at a speed that swings between 0.5 and 2.
    def reference_time(input_time: np.ndarray) -> np.ndarray:
        return input_time + 0.35 * np.sin(1.4 * input_time)

    input_rate, reference_rate = rates
    input_times = np.arange(3 * input_rate + 1) / input_rate
    moving = clip_at(reference_time(input_times), input_rate)
    end = float(reference_time(np.array([3.0]))[0])
    reference = clip_at(np.arange(0, end + 1e-9, 1 / reference_rate), reference_rate)
    # Speeds come in twelfths here: with the usual quarters the search keeps one of them as long as it can, to save
    # changes of speed, and lags up to three frames behind.
    result = guided_warp(
        moving,
        reference=reference,
        length=f"{round(end * input_rate) + 1}f",
        score=score,
        # Its swings are short.
        time_scale=0.1,
        low_pass=0,
        upsample=12,
        max_skip=26,
    )
    check(result)
    times = np.linspace(0, result.warp.output_end, 200)
    error = reference_time(result.warp(times)) - times * end / result.warp.output_end
    assert np.abs(error).max() < 0.5 / 30
    assert np.abs(error).mean() < 0.15 / 30


@pytest.mark.parametrize("score", SCORES)
def test_a_free_length_finds_the_reference_s(score: str) -> None:
    # All of these speeds are eighths.
    reference = clip_at(np.arange(0, 6.001, 1 / 30))
    for pace in (0.5, 0.8, 1.0, 1.6):
        moving = clip_at(np.arange(0, 3.001, 1 / 30) * pace)
        result = guided_warp(
            moving, reference=reference, length="free", score=score, low_pass=0, upsample=8, max_skip=20
        )
        check(result)
        assert result.warp.output_end == pytest.approx(3 * pace, rel=0.02)


@pytest.mark.parametrize("score", SCORES)
def test_stretches_take_the_speed_that_the_reference_has_there(score: str) -> None:
    # Two stretches of two seconds; the reference plays the first at half speed, the second at double speed.
    moving = clip_at(np.arange(0, 4.001, 1 / 30))
    reference_times = np.concatenate([np.arange(0, 2, 1 / 60), np.arange(2, 4.001, 1 / 15)])
    reference = clip_at(reference_times)
    result = guided_warp(
        moving, reference=reference, length=f"{len(reference_times)}f", score=score, low_pass=0, smoothing=0
    )
    check(result)
    inside = (result.staircase.input_times[:-1] > 0.2) & (result.staircase.input_times[1:] < 1.8)
    assert result.staircase.slopes[inside].mean() == pytest.approx(0.5, rel=0.05)
    inside = (result.staircase.input_times[:-1] > 2.2) & (result.staircase.input_times[1:] < 3.8)
    assert result.staircase.slopes[inside].mean() == pytest.approx(2.0, rel=0.1)


def jumps(rate: int, drift: float = 0.2) -> tuple[Signal, list[tuple[float, float]]]:
    """Height and forward place of something that drifts slowly, and twice is thrown up; when it flies."""
    gravity, flights = 9.8, [(2.0, 2.6), (4.5, 5.0)]
    times = np.arange(7 * rate + 1) / rate
    height = 0.05 * np.sin(2 * times)
    for start, end in flights:
        inside = (times > start) & (times < end)
        height[inside] += gravity / 2 * (times[inside] - start) * (end - times[inside])
    return Signal(("height", "forward"), np.column_stack([height, drift * times]), Fraction(rate)), flights


def speeds_within(result: GuidedWarp, start: float, end: float) -> np.ndarray:
    """Speeds of the path's steps between two input times."""
    times = result.reduction.input_times[result.path.frames]
    inside = (times[:-1] >= start - 1e-9) & (times[1:] <= end + 1e-9)
    return result.path_speeds[inside]


@pytest.mark.parametrize("rate", [30, 120])
@pytest.mark.parametrize(("length", "slowest", "fastest"), [("70%", 1.3, 2.0), ("85%", 1.1, 1.5), ("150%", 0.5, 0.7)])
def test_flights_keep_unit_speed_and_the_drift_takes_the_change(
    rate: int, length: str, slowest: float, fastest: float
) -> None:
    # Only the joint score: where the body is low it is so on its way up and down, and the pose alone can't say which.
    clip, flights = jumps(rate)
    result = guided_warp(clip, length=length, low_pass=0)
    check(result)
    for start, end in flights:
        speeds = speeds_within(result, start, end)
        assert len(speeds) >= (end - start) * 30 - 3
        assert (speeds == 1.0).all()
    drifting = np.concatenate(
        [speeds_within(result, 0, 2), speeds_within(result, 2.6, 4.5), speeds_within(result, 5, 7)]
    )
    assert slowest < drifting.mean() < fastest


@pytest.mark.parametrize("score", SCORES)
@pytest.mark.parametrize("rate", [24, "23.976", 30, 60])
@pytest.mark.parametrize("make", [wandering_motion, wandering_signal])
def test_no_change_asked_for_gives_none(make: type, rate: int | str, score: str) -> None:
    clip = make(121, 120)
    result = guided_warp(clip, rate=rate, score=score)
    check(result)
    assert (result.path_speeds == 1.0).all()
    np.testing.assert_allclose(result.warp.input_times, result.warp.output_times, rtol=0, atol=1e-12)
    same = apply_warp(clip, result.warp)
    for name in ("rotations", "local_translations") if make is wandering_motion else ("values",):
        assert np.array_equal(getattr(same, name), getattr(clip, name))


def test_the_output_shows_keyed_poses_at_keyed_times() -> None:
    clip = wandering_signal(241, 120)
    keys = [("48f", "60f"), ("48f", "90f"), ("12f", "126f"), ("180f", "240f")]
    result = guided_warp(clip, keys=keys)
    check(result)
    shown = apply_warp(clip, result.warp)
    assert shown.n_frames == 301
    for i, o in ((0, 0), (48, 60), (48, 90), (12, 126), (180, 240), (240, 300)):
        # Beside a key that is passed fast, the average over a period of output reaches beyond it.
        np.testing.assert_allclose(shown.values[o], clip.values[i], atol=0.05)
        np.testing.assert_array_equal(apply_warp(clip, result.warp, average=False).values[o], clip.values[i])
    assert (shown.values[61:90] == clip.values[48]).all()
    speeds = result.warp.speed(np.arange(91, 126) / 120)
    assert (speeds < 0).all()


def test_speeds_of_a_path_tell_holds_and_backward_spans() -> None:
    clip = wandering_signal(61, 30)
    result = guided_warp(clip, keys=[(1.0, 1.0), (1.0, 1.5), (0.5, 2.0)])
    assert (result.path_speeds[30:45] == 0).all()
    assert (result.path_speeds[45:60] < 0).all()
    assert (result.path_speeds[60:] > 0).all()


def test_the_total_is_the_sum_of_the_path_s_scores() -> None:
    clip = wandering_motion(200, 60)
    for options in ({"length": "70%"}, {"length": "130%"}, {"keys": [(1.0, 0.7)]}):
        result = guided_warp(clip, **options)
        check(result)
        explained = result.explain()
        assert result.total == pytest.approx(np.nansum(explained.costs), rel=1e-12)
        np.testing.assert_allclose(explained.costs[1:-1], result.path.scores, rtol=1e-12)
        np.testing.assert_allclose((explained.scores + explained.tempo_costs)[1:-1], result.path.scores, rtol=1e-9)
        assert np.isnan(explained.scores[[0, -1]]).all()


@pytest.mark.parametrize("search", ["layered", "heuristic"])
def test_the_other_searches(search: str) -> None:
    clip = wandering_motion(300, 60)
    best = guided_warp(clip, length="60%")
    other = guided_warp(clip, length="60%", search=search)
    check(other)
    if search == "layered":
        assert np.array_equal(other.path.frames, best.path.frames)
        assert other.total == best.total
    else:
        assert other.excess is not None
        assert other.total >= best.total
        assert other.excess == pytest.approx((other.total - best.total) / best.total, rel=1e-9)
        assert other.path.lower_bound <= best.total


# Options


@pytest.mark.parametrize("upsample", [2, 3, 7])
@pytest.mark.parametrize("max_skip", [7, 9, 20])
def test_speeds_stay_within_what_upsample_and_max_skip_allow(upsample: int, max_skip: int) -> None:
    clip = wandering_signal(150, 30)
    result = guided_warp(clip, length="110%", upsample=upsample, max_skip=max_skip)
    check(result)
    assert (result.upsample, result.max_skip) == (upsample, max_skip)
    assert result.path_speeds.min() >= 1 / upsample
    assert result.path_speeds.max() <= max_skip / upsample
    assert result.n_input == 149 * upsample + 1


@pytest.mark.parametrize("rate", [10, "23.976", 30, 100, 240])
@pytest.mark.parametrize("length", ["60%", "140%"])
def test_any_analysis_rate_gives_the_wanted_length(rate: int | str, length: str) -> None:
    clip = wandering_signal(200, 100)
    result = guided_warp(clip, rate=rate, length=length)
    check(result)
    assert apply_warp(clip, result.warp).n_frames == round(200 * int(length[:-1]) / 100)
    assert result.warp.output_end == (round(200 * int(length[:-1]) / 100) - 1) / 100
    assert float(result.warp(result.warp.output_end)) == clip.end_time


@pytest.mark.parametrize("n_frames", [2, 3, 5, 6])
@pytest.mark.parametrize("rate", [30, 120])
def test_the_shortest_clips(n_frames: int, rate: int) -> None:
    clip, reference = wandering_signal(n_frames, rate), wandering_signal(60, 30, seed=1)
    result = guided_warp(clip, reference=reference, rate=rate)
    check(result)
    assert np.array_equal(apply_warp(clip, result.warp).values[[0, -1]], clip.values[[0, -1]])


def test_an_array_and_its_rate_will_do() -> None:
    t = np.arange(0, 4, 1 / 24)
    one = guided_warp(np.sin(t**2), rate=24, length="80%")
    other = guided_warp(Signal(("c0",), np.sin(t**2)[:, None], Fraction(24)), rate=24, length="80%")
    assert np.array_equal(one.path.frames, other.path.frames)
    with pytest.raises(OptionError, match="rate"):
        guided_warp(np.sin(t**2), length="80%")


def test_without_smoothing_the_warp_is_the_path() -> None:
    clip = wandering_signal(150, 30)
    result = guided_warp(clip, length="70%", smoothing=0)
    np.testing.assert_allclose(
        result.warp(result.staircase.output_times), result.staircase.input_times, rtol=0, atol=1e-12
    )
    smooth = guided_warp(clip, length="70%", smoothing=5)
    assert np.array_equal(smooth.path.frames, result.path.frames)
    assert np.abs(np.diff(smooth.warp.slopes)).max() < np.abs(np.diff(result.warp.slopes)).max()


def test_influence_mixes_with_the_spline() -> None:
    clip = wandering_signal(150, 30)
    keys = [(2.0, 1.0)]
    whole, none, half = (guided_warp(clip, keys=keys, influence=share).warp for share in (1.0, 0.0, 0.5))
    times = np.linspace(0, whole.output_end, 200)
    np.testing.assert_allclose(half(times), (whole(times) + none(times)) / 2, rtol=0, atol=1e-9)
    assert float(half(1.0)) == float(none(1.0)) == 2.0


def test_a_lock_holds() -> None:
    clip = wandering_signal(300, 30)
    result = guided_warp(clip, length="75%", locks=[Lock(3.0, 5.0), Lock(6.0, 8.0, 0.5, 1.0)])
    check(result)
    assert (speeds_within(result, 3.0, 5.0) == 1.0).all()
    assert len(speeds_within(result, 3.0, 5.0)) == 60
    other = speeds_within(result, 6.0, 8.0)
    assert len(other) >= 60
    assert (other <= 1.0).all()


def test_a_tangent_is_met_on_both_sides_of_its_key() -> None:
    clip = wandering_signal(300, 30)
    result = guided_warp(clip, keys=[(4.0, 5.0, 0.5)])
    check(result)
    position = result.reduction.positions[1]
    assert result.path_speeds[position - 1 : position + 1].tolist() == [0.5, 0.5]


@pytest.mark.parametrize("bounds", [{}, {"min_length": "20%"}, {"max_length": "90%"}, {"min_length": "150%"}], ids=str)
def test_a_free_length_still_meets_its_keytimes(bounds: dict[str, str]) -> None:
    clip = wandering_signal(150, 30)
    result = guided_warp(clip, length="free", keys=[(2.0, 3.0), (2.0, 3.2), (1.0, 3.5)], **bounds)
    check(result)
    assert [float(result.warp(time)) for time in (3.0, 3.2, 3.5)] == [2.0, 2.0, 1.0]
    least, most = bounds.get("min_length", "0%")[:-1], bounds.get("max_length", "1000%")[:-1]
    assert int(least) / 100 * 5 - 0.05 <= result.warp.output_end <= int(most) / 100 * 5 + 0.05


@pytest.mark.parametrize("length", ["400%", "1300%"])
def test_very_long_results(length: str) -> None:
    clip = wandering_signal(20, 30)
    result = guided_warp(clip, length=length)
    check(result)
    assert result.n_output == 20 * int(length[:-1]) / 100


@pytest.mark.parametrize("seed", range(40))
def test_keytimes_at_about_unit_speed_always_find_a_way(seed: int) -> None:
    # Rounded to analysis frames apart from each other, input and output times may differ by a frame more or less.
    rng = np.random.default_rng(seed)
    clip = wandering_signal(150, 30)
    input_times = (np.arange(1, 5) + rng.uniform(-0.3, 0.3, 4)) * 0.9
    keys = [(i, i + rng.uniform(-0.02, 0.02)) for i in input_times.tolist()]
    close = (keys[1][0] + 0.04, keys[1][1] + 0.035)
    check(guided_warp(clip, keys=[*keys, close]))


def test_speed_limits_hold() -> None:
    clip = wandering_signal(300, 30)
    result = guided_warp(clip, length="90%", speed=(0.5, 1.5))
    check(result)
    assert result.path_speeds.min() >= 0.5
    assert result.path_speeds.max() <= 1.5
    assert result.path_speeds.max() > 1.0


def test_smoothness_takes_changes_of_speed_away() -> None:
    clip, _ = jumps(30)

    def changes(weight: float) -> float:
        speeds = guided_warp(clip, length="70%", smoothness=weight).path_speeds
        return float(np.abs(np.diff(np.log(speeds))).sum())

    assert changes(10.0) < 0.5 * changes(0.0)


def test_a_loop_begins_and_ends_at_one_speed() -> None:
    t = np.arange(61) / 30
    cycle = Signal(("x", "y"), np.column_stack([np.sin(np.pi * t), np.cos(np.pi * t) + 0.3 * np.sin(2 * np.pi * t)]))
    result = guided_warp(cycle, length="70%", loop=True)
    check(result)
    assert result.path_speeds[0] == result.path_speeds[-1]


def test_a_session_gives_what_a_single_call_gives() -> None:
    from retime.search.session import Session

    clip = wandering_motion(200, 60)
    session = Session(clip)
    for options in ({"length": "70%"}, {"keys": [(1.0, 1.5)]}, {"length": "70%"}, {"length": "free"}):
        one, other = session.solve(**options), guided_warp(clip, **options)
        assert np.array_equal(one.path.frames, other.path.frames)
        assert one.total == other.total
        assert np.array_equal(one.warp.input_times, other.warp.input_times)


# Errors


@pytest.mark.parametrize(
    "options",
    [
        pytest.param({"max_skip": 0}, id="max_skip_0"),
        pytest.param({"max_skip": 256}, id="max_skip_256"),
        pytest.param({"upsample": 0}, id="upsample_0"),
        pytest.param({"n_neighbors": 0}, id="no_neighbors"),
        pytest.param({"rate": 0}, id="rate_0"),
        pytest.param({"rate": "fast"}, id="rate_text"),
        pytest.param({"time_scale": -1.0}, id="time_scale_negative"),
        pytest.param({"low_pass": -1.0}, id="low_pass_negative"),
        pytest.param({"low_pass": float("nan")}, id="low_pass_nan"),
        pytest.param({"smoothing": -1}, id="smoothing_negative"),
        pytest.param({"smoothness": -1.0}, id="smoothness_negative"),
        pytest.param({"features": "hips"}, id="features"),
        pytest.param({"score": "mean"}, id="score"),
        pytest.param({"search": "greedy"}, id="search"),
        pytest.param({"speed": (2.0, 1.0)}, id="speed_reversed"),
        pytest.param({"speed": (0.0, 0.0)}, id="speed_zero"),
        pytest.param({"influence": 1.5}, id="influence"),
        pytest.param({"min_length": "50%"}, id="bounds_on_a_given_length"),
        pytest.param({"length": 1}, id="one_frame"),
        pytest.param({"length": 80}, id="length_in_frames_or_seconds"),
        pytest.param({"keys": ["1:75=2"]}, id="key_beyond_the_minute"),
        pytest.param({"locks": ["1..2=1/2.."]}, id="lock_without_a_fastest_speed"),
        pytest.param({"speed": "2..1"}, id="speed_text_reversed"),
    ],
)
def test_options_without_meaning_are_refused(options: dict[str, object]) -> None:
    clip = wandering_signal(100, 30)
    with pytest.raises(OptionError):
        guided_warp(clip, **{"length": "80%", **options})  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("options", "says"),
    [
        pytest.param({"keys": [(1.0, 1.0), (2.0, 1.0)], "length": "80%"}, "two keytimes stand at", id="one_time_twice"),
        pytest.param({"keys": [(9.0, 1.0)]}, "input runs from 0 to 3.3", id="beyond_the_input"),
        pytest.param({"keys": [(1.0, 1.0), (1.02, 1.01)]}, "raise the rate", id="closer_than_a_frame"),
        pytest.param({"length": "10%", "max_skip": 4}, "Use a length of at least", id="too_short"),
        pytest.param({"length": "150%", "upsample": 1}, "Use a length of at most", id="too_long"),
    ],
)
def test_what_can_not_be_met_is_said_with_a_remedy(options: dict[str, object], says: str) -> None:
    clip = wandering_signal(100, 30)
    with pytest.raises(InfeasibleWarpError, match=says):
        guided_warp(clip, **options)  # type: ignore[arg-type]


@pytest.mark.parametrize("length", ["10%", "250%"])
@pytest.mark.parametrize(("upsample", "max_skip"), [(1, 4), (2, 5)])
def test_the_bounds_that_an_error_names_are_true(length: str, upsample: int, max_skip: int) -> None:
    clip = wandering_signal(100, 30)

    def solve(length: str) -> int:
        return guided_warp(clip, length=length, upsample=upsample, max_skip=max_skip).n_output

    with pytest.raises(InfeasibleWarpError) as caught:
        solve(length)
    low, high = caught.value.min_output, caught.value.max_output
    assert low is not None
    assert high is not None
    assert (solve(f"{low}f"), solve(f"{high}f")) == (low, high)
    for beyond in (low - 1, high + 1):
        with pytest.raises(InfeasibleWarpError):
            solve(f"{beyond}f")


def test_a_reference_of_another_kind_is_refused() -> None:
    with pytest.raises(OptionError):
        guided_warp(wandering_motion(60), reference=wandering_signal(60))
    with pytest.raises(OptionError):
        guided_warp(wandering_signal(60), reference=Signal(("a", "b"), np.zeros((60, 2))))


def test_a_reference_too_short_is_refused() -> None:
    with pytest.raises(OptionError, match="n_neighbors=3 needs at least 5"):
        guided_warp(wandering_signal(60), reference=wandering_signal(4))
    with pytest.raises(OptionError, match="4 frames"):
        guided_warp(wandering_signal(4), length="3f")


@pytest.mark.parametrize(
    ("given", "found"),
    [
        pytest.param(
            [[wandering_signal(30), wandering_signal(30)], wandering_signal(30)], "'list', 'Signal'", id="groups"
        ),
        pytest.param([wandering_signal(30), np.zeros(30)], "'Signal', 'ndarray'", id="arrays"),
        pytest.param([wandering_signal(30), None], "'Signal', 'NoneType'", id="nothing"),
        pytest.param("walk.bvh", "'walk.bvh'", id="file"),
    ],
)
def test_what_is_no_group_is_refused_by_what_it_holds(given: object, found: str) -> None:
    with pytest.raises(OptionError, match="several motions and signals") as caught:
        guided_warp(given, rate=30, length="80%")  # type: ignore[arg-type]
    assert found in str(caught.value)


def test_a_result_applies_itself_to_its_input() -> None:
    clip = sample()[:300]
    result = guided_warp(clip, length="70%")
    expected = apply_warp(clip, result.warp)
    for shown in (result.apply(), result.apply(clip), apply_warp(clip, result)):
        assert np.array_equal(shown.rotations, expected.rotations)
        assert np.array_equal(shown.local_translations, expected.local_translations)
    plain = result.apply(average=False)
    assert np.array_equal(plain.rotations, apply_warp(clip, result.warp, average=False).rotations)


def test_a_loop_found_is_applied_as_one() -> None:
    clip = sample().frames(100, 200)
    result = guided_warp(clip, length="60%", loop=True)
    with warnings.catch_warnings():
        # The clip is nearly a cycle.
        warnings.simplefilter("ignore", RetimeWarning)
        expected = apply_warp(clip, result.warp, loop=True)
        assert np.array_equal(result.apply().rotations, expected.rotations)


def test_a_result_for_an_array_gives_its_rows_and_of_a_group_asks_which() -> None:
    t = np.arange(120) / 30
    array = np.stack([np.sin(t**2), t], axis=1)
    result = guided_warp(array, rate=30, length="75%")
    assert np.array_equal(result.apply().values, apply_warp(array, result, rate=30))
    pan, tilt = (Signal((name,), array[:, [i]], 30) for i, name in enumerate(("pan", "tilt")))
    both = guided_warp([pan, tilt], length="75%")
    with pytest.raises(OptionError, match="a group of 2 clips"):
        both.apply()
    assert [both.apply(clip).names for clip in both.clips] == [("pan",), ("tilt",)]


def test_what_people_type_and_what_programs_pass_are_one() -> None:
    clip = wandering_signal(100, 30)
    typed = guided_warp(
        clip,
        length="0:03",
        keys=["00:00:01:00=24f@1/2"],
        locks=["2..75f = 1/2 to 1"],
        speed="25%..8",
        features="signal",
    )
    passed = guided_warp(
        clip, length=3.0, keys=[(1, 0.8, 0.5)], locks=[Lock(2.0, 2.5, 0.5, 1.0)], speed=(0.25, 8.0), features="signal"
    )
    np.testing.assert_array_equal(typed.warp.output_times, passed.warp.output_times)
    np.testing.assert_array_equal(typed.warp.input_times, passed.warp.input_times)


def test_a_lock_that_says_nothing_is_named_by_its_place() -> None:
    with pytest.raises(OptionError, match="below 60") as caught:
        guided_warp(wandering_signal(100, 30), locks=[Lock(0.5, 1.0), "0:01..0:75"])
    assert (caught.value.option, caught.value.item) == ("locks", 1)


class TestAFactorThatIsTakenForSeconds:
    """A bare length is seconds: where hardly anything of the input would be left, the tool asks."""

    def test_it_is_asked_about_where_nothing_fits(self) -> None:
        with pytest.raises(InfeasibleWarpError, match=r"\(did you mean 65%\?\)\.$") as caught:
            guided_warp(wandering_signal(600, 30), length="0.65", max_skip=8)
        assert caught.value.min_output is not None

    def test_a_warning_asks_where_it_fits(self) -> None:
        with pytest.warns(RetimeWarning, match=r"0\.65 seconds, 3\.3% of the input \(did you mean 65%\?\)"):
            found = guided_warp(wandering_signal(600, 30), length=0.65)
        assert found.warp.output_span == pytest.approx(19 / 30)

    @pytest.mark.parametrize("length", ["0.65s", "65%", "4", "10"])
    def test_nobody_else_is_asked(self, length: str) -> None:
        guided_warp(wandering_signal(600, 30), length=length)
