"""Warp: evaluation, inverse, composition, smoothing and mixing against their definitions; JSON bit for bit."""

from __future__ import annotations

import itertools
import json
import warnings
from dataclasses import replace
from fractions import Fraction

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from retime.errors import FormatError, InfeasibleWarpError, OptionError, OutputExistsError, RetimeWarning
from retime.warp.blend import blend
from retime.warp.curve import Warp
from retime.warp.keytime import Keytime
from retime.warp.knots import add_times
from tests.reference import curve as literal

NTSC = Fraction(24000, 1001)


def drawn_warp(rng: np.random.Generator, n_knots: int, *, forward: bool, keys: int = 0) -> Warp:
    """Knots at uneven times, from slow to fast; a few of them keytimes."""
    output_times = np.cumsum(rng.uniform(0.01, 1.0, n_knots)) - rng.uniform(0, 2)
    steps = 10.0 ** rng.uniform(-2, 1, n_knots) * np.where(rng.random(n_knots) < 0.8 if not forward else True, 1, -1)
    if not forward:
        steps[rng.random(n_knots) < 0.2] = 0.0
    input_times = np.cumsum(steps)
    chosen = np.sort(rng.choice(n_knots, min(keys, n_knots), replace=False))
    keytimes = tuple(Keytime(input_time=float(input_times[k]), output_time=float(output_times[k])) for k in chosen)
    return Warp(output_times, input_times, keytimes)


@st.composite
def warps(draw: st.DrawFn, forward: bool = True, keys: int = 0) -> Warp:
    rng = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    return drawn_warp(rng, draw(st.integers(2, 12)), forward=forward, keys=draw(st.integers(0, keys)))


def some_times(warp: Warp, seed: int = 0) -> np.ndarray:
    """Knots, times between them, and times outside."""
    rng = np.random.default_rng(seed)
    between = rng.uniform(warp.output_start - 1, warp.output_end + 1, 9)
    return np.concatenate([warp.output_times, between])


@settings(max_examples=40)
@given(warps(forward=False))
def test_evaluate_and_speed(warp: Warp) -> None:
    o, i = warp.output_times.tolist(), warp.input_times.tolist()
    for time in some_times(warp):
        assert float(warp(time)) == pytest.approx(literal.evaluate(o, i, time), rel=1e-12, abs=1e-12)
        assert float(warp.speed(time)) == pytest.approx(literal.speed(o, i, min(max(time, o[0]), o[-1])), rel=1e-12)
    assert warp(warp.output_times).tolist() == i
    assert warp(warp.output_times.reshape(-1, 1)).shape == (len(o), 1)


@settings(max_examples=40)
@given(warps())
def test_inverse_undoes_the_warp(warp: Warp) -> None:
    inverse = warp.inverse()
    o, i = warp.output_times.tolist(), warp.input_times.tolist()
    for time in np.linspace(i[0], i[-1], 5):
        assert float(inverse(time)) == pytest.approx(literal.inverse_at(o, i, time), abs=1e-9)
    assert inverse(warp.input_times).tolist() == o
    again = inverse.inverse()
    assert np.array_equal(again.output_times, warp.output_times)
    assert np.array_equal(again.input_times, warp.input_times)
    assert again.keytimes == warp.keytimes


@pytest.mark.parametrize("input_times", [[0.0, 1.0, 1.0], [0.0, 1.0, 0.5], [1.0, 0.0, -1.0]])
def test_a_warp_that_holds_or_turns_back_has_no_inverse(input_times: list[float]) -> None:
    warp = Warp([0.0, 1.0, 2.0], input_times)
    assert not warp.monotone
    with pytest.raises(InfeasibleWarpError, match="no inverse"):
        warp.inverse()


@settings(max_examples=40)
@given(warps(forward=False), warps(forward=False))
def test_compose_applies_the_first_then_the_other(warp: Warp, first: Warp) -> None:
    both = warp.compose(first)
    assert both.output_start == first.output_start
    assert both.output_end == first.output_end
    for time in [*some_times(both), *first.output_times]:
        inner = literal.evaluate(first.output_times.tolist(), first.input_times.tolist(), time)
        wanted = literal.evaluate(warp.output_times.tolist(), warp.input_times.tolist(), inner)
        assert float(both(time)) == pytest.approx(wanted, rel=1e-9, abs=1e-9)
    assert both(first.output_times).tolist() == warp(first(first.output_times)).tolist()


@settings(max_examples=40)
@given(warps())
def test_compose_with_the_inverse_is_the_identity(warp: Warp) -> None:
    same = warp.inverse().compose(warp)
    np.testing.assert_allclose(same(warp.output_times), warp.output_times, rtol=0, atol=1e-12)
    # Every corner of one is a corner of the other: the result has no knots a rounding error apart.
    assert len(same.output_times) == len(warp.output_times)
    assert np.diff(same.output_times).min() > 1e-9


@settings(max_examples=40)
@given(warps(forward=False, keys=3), st.floats(0, 3), st.booleans())
def test_smooth_is_the_mean_over_its_window(warp: Warp, window: float, elsewhere: bool) -> None:
    at = np.linspace(warp.output_start, warp.output_end, 9) if elsewhere else None
    smooth = warp.smooth(window, at=at)
    o, i = warp.output_times.tolist(), warp.input_times.tolist()
    keys = [key.output_time for key in warp.keytimes]
    size = np.abs(warp.input_times).max()
    for time, value in zip(smooth.output_times, smooth.input_times, strict=True):
        assert value == pytest.approx(literal.moving_average(o, i, keys, window, time), rel=1e-9, abs=1e-9 * size)
    wanted = set(warp.output_times.tolist() if at is None else at.tolist()) | {o[0], o[-1], *keys}
    np.testing.assert_allclose(smooth.output_times, sorted(wanted), rtol=0, atol=1e-9)


@settings(max_examples=40)
@given(warps(forward=False, keys=4), st.floats(0, 50))
def test_smooth_keeps_ends_and_keytimes_exactly(warp: Warp, window: float) -> None:
    smooth = warp.smooth(window)
    assert (smooth.output_start, smooth.output_end) == (warp.output_start, warp.output_end)
    assert smooth.keytimes == warp.keytimes
    ends = [Keytime(input_time=float(warp.input_times[k]), output_time=float(warp.output_times[k])) for k in (0, -1)]
    for key in (*warp.keytimes, *ends):
        assert float(smooth(key.output_time)) == key.input_time
        assert key.output_time in smooth.output_times


@settings(max_examples=40)
@given(warps(keys=4), st.floats(0, 50), st.integers(2, 200))
def test_a_monotone_warp_stays_monotone_when_smoothed(warp: Warp, window: float, n_knots: int) -> None:
    assert warp.monotone
    assert warp.smooth(window).monotone
    assert warp.smooth(window, at=np.linspace(warp.output_start, warp.output_end, n_knots)).monotone


@pytest.mark.parametrize("speed", [1.0, 0.25, -1.0, 0.0])
def test_a_straight_warp_stays_straight_when_smoothed(speed: float) -> None:
    times = np.arange(40) / 30
    warp = Warp(times, 3 + speed * times)
    np.testing.assert_allclose(warp.smooth(0.5).input_times, 3 + speed * times, rtol=0, atol=1e-14)


def test_smooth_leaves_holds_between_keytimes_at_rest() -> None:
    keys = [(0, 0), (1, 1), (2, 1), (3, 0), (4, 4)]
    warp = Warp(
        *np.array(keys, dtype=float).T, tuple(Keytime(input_time=float(i), output_time=float(o)) for o, i in keys)
    )
    smooth = warp.smooth(0.4, at=np.arange(0, 4.01, 0.01))
    inside = (smooth.output_times >= 1) & (smooth.output_times <= 2)
    assert (smooth.input_times[inside] == 1.0).all()
    backward = (smooth.output_times >= 2) & (smooth.output_times <= 3)
    assert (np.diff(smooth.input_times[backward]) < 0).all()


def test_smooth_takes_keytimes_in_any_order() -> None:
    times = np.arange(11.0)
    steps = np.cumsum([0.0, 1, 3, 1, 3, 1, 3, 1, 3, 1, 3])
    keys = [Keytime(input_time=float(np.interp(time, times, steps)), output_time=time) for time in (8.0, 2.0, 5.0)]
    shuffled = Warp(times, steps, tuple(keys)).smooth(4)
    ordered = Warp(times, steps, tuple(sorted(keys))).smooth(4)
    assert np.array_equal(shuffled.input_times, ordered.input_times)


@pytest.mark.parametrize("window", [-1.0, float("nan"), float("inf")])
def test_a_window_that_is_no_time_is_refused(window: float) -> None:
    with pytest.raises(OptionError, match="window"):
        Warp([0, 1], [0, 1]).smooth(window)


def test_times_that_differ_by_rounding_make_no_knots() -> None:
    # At 23.976 Hz a frame's time and the same keytime differ in the last bit half of the time.
    frames = np.arange(300)
    as_frames = frames / float(NTSC)
    as_keys = np.array([float(frame / NTSC) for frame in frames.tolist()])
    assert (as_frames != as_keys).any()
    warp = Warp(
        as_keys,
        np.cumsum(1 + np.sin(frames / 9) / 2),
        tuple(Keytime(input_time=t, output_time=t) for t in as_keys[1:-1:7].tolist()),
    )
    for result in (
        warp.smooth(0.3, at=as_frames),
        warp.compose(Warp(as_frames[[0, 150, -1]], as_frames[[0, 150, -1]])),
        blend(warp, Warp(as_frames, warp.input_times), 0.5),
    ):
        assert np.diff(result.output_times).min() > 0.9 / float(NTSC)
        assert result.monotone


def test_add_times_keeps_the_old_ones() -> None:
    times = np.array([0.0, 1.0, 2.0])
    more = np.array([1 + 1e-12, 0.5, 0.5 + 1e-13, -1.0, 3.0, 2 - 1e-12])
    assert add_times(times, more).tolist() == [-1.0, 0.0, 0.5, 1.0, 2.0, 3.0]
    assert add_times(times, np.empty(0)).tolist() == times.tolist()


@settings(max_examples=40)
@given(st.integers(0, 2**32 - 1), st.floats(0, 1))
def test_blend_mixes_at_every_time(seed: int, weight: float) -> None:
    rng = np.random.default_rng(seed)
    one, other = drawn_warp(rng, 6, forward=True), drawn_warp(rng, 9, forward=True)
    start, length = one.output_start, one.output_span
    stretched = start + (other.output_times - other.output_start) * (length / other.output_span)
    stretched[-1] = one.output_end
    other = Warp(stretched, other.input_times)
    mixed = blend(one, other, weight)
    assert mixed.monotone
    assert (mixed.output_start, mixed.output_end) == (one.output_start, one.output_end)
    for time in some_times(one, seed):
        wanted = (1 - weight) * float(one(time)) + weight * float(other(time))
        assert float(mixed(time)) == pytest.approx(wanted, rel=1e-12, abs=1e-9)


@pytest.mark.parametrize("weight", [0.0, 0.1, 0.3, 1 / 3, 0.7, 1.0])
def test_blend_keeps_what_both_agree_on_bit_for_bit(weight: float) -> None:
    rng = np.random.default_rng(1)
    shared = np.cumsum(rng.random(40))
    one, other = shared + 0, shared + 0
    other[1::2] += 0.01
    mixed = blend(Warp(np.arange(40.0), one), Warp(np.arange(40.0), other), weight)
    assert np.array_equal(mixed.input_times[::2], shared[::2])
    if weight in (0.0, 1.0):
        assert np.array_equal(mixed.input_times, other if weight else one)


def test_blend_of_ends_a_rounding_error_apart_keeps_the_first_ends() -> None:
    one = Warp([0.0, 1.0, 2.0], [0.0, 0.5, 2.0])
    other = Warp([1e-12, 1.0, 2.0 - 1e-12], [0.0, 1.5, 2.0])
    for a, b in ((one, other), (other, one)):
        mixed = blend(a, b, 0.25)
        assert np.array_equal(mixed.output_times, a.output_times)
        assert mixed.input_times[[0, -1]].tolist() == [0.0, 2.0]


@pytest.mark.parametrize("weight", [-0.1, 1.1, float("nan")])
def test_a_weight_beyond_0_to_1_is_refused(weight: float) -> None:
    warp = Warp([0, 1], [0, 1])
    with pytest.raises(OptionError, match="from 0 to 1"):
        blend(warp, warp, weight)


def test_warps_of_different_ranges_are_not_mixed() -> None:
    with pytest.raises(OptionError, match="same output range"):
        blend(Warp([0, 1], [0, 1]), Warp([0, 1.1], [0, 1]), 0.5)


@pytest.mark.parametrize(
    ("output_times", "input_times", "says"),
    [
        pytest.param([0.0], [0.0], "two or more", id="one_knot"),
        pytest.param([0.0, 1.0], [0.0], "two or more", id="lengths_differ"),
        pytest.param([[0.0, 1.0]], [[0.0, 1.0]], "two or more", id="two_dimensions"),
        pytest.param([0.0, 0.0], [0.0, 1.0], "knot 1", id="same_time_twice"),
        pytest.param([0.0, 2.0, 1.0], [0.0, 1.0, 2.0], "knot 2", id="times_decrease"),
        pytest.param([0.0, np.nan], [0.0, 1.0], "knot 1 .* not finite", id="nan_output"),
        pytest.param([0.0, 1.0], [0.0, np.inf], "knot 1 .* not finite", id="inf_input"),
        pytest.param([-1e308, 1.5e308, 1.4e308], [0.0, 1.0, 2.0], "knot 2", id="differences_overflow"),
    ],
)
def test_numbers_that_make_no_warp_are_refused(output_times: object, input_times: object, says: str) -> None:
    with pytest.raises(OptionError, match=says):
        Warp(output_times, input_times)  # type: ignore[arg-type]


@pytest.mark.parametrize(
    "key", [Keytime(input_time=0.0, output_time=float("nan")), Keytime(input_time=float("inf"), output_time=0.0)]
)
def test_keytimes_that_are_not_finite_are_refused(key: Keytime) -> None:
    with pytest.raises(OptionError, match="keytime"):
        Warp([0, 1], [0, 1], (key,))


def test_a_warp_can_not_be_changed_from_outside() -> None:
    output_times = np.array([0.0, 1.0])
    warp = Warp(output_times, [0.0, 1.0])
    output_times[0] = 5.0
    assert warp.output_start == 0.0
    with pytest.raises(ValueError, match="read-only"):
        warp.input_times[0] = 1.0


# Equal warps


@settings(max_examples=40)
@given(warps(forward=False, keys=3))
def test_equal_warps_are_equal_and_hash_alike(warp: Warp) -> None:
    again = Warp.from_json(warp.to_json())
    assert again == warp
    assert hash(again) == hash(warp)
    assert {warp: "found"}[again] == "found"


def test_zeros_of_either_sign_are_equal() -> None:
    a, b = Warp([0.0, 1.0], [0.0, 1.0]), Warp([-0.0, 1.0], [-0.0, 1.0])
    assert a == b
    assert hash(a) == hash(b)


def test_whatever_differs_makes_warps_different() -> None:
    key = Keytime(input_time=2.0, output_time=1.0)
    warp = Warp([0.0, 1.0, 2.0], [0.0, 2.0, 3.0], (key,), "guided", "walk")
    others = [
        replace(warp, output_times=[0.0, 1.0, 2.5]),
        replace(warp, input_times=[0.0, 2.0, 3.5]),
        replace(warp, output_times=[0.0, 2.0], input_times=[0.0, 3.0]),
        replace(warp, keytimes=()),
        replace(warp, keytimes=(replace(key, speed=1.0),)),
        replace(warp, method="linear"),
        replace(warp, name="run"),
    ]
    assert [other == warp for other in others] == [False] * len(others)
    assert len({warp, *others}) == len(others) + 1
    assert warp != "a warp"


# Arrays


@settings(max_examples=40)
@given(warps(forward=False), st.integers(1, 40), st.sampled_from([1, 7.5, Fraction(30000, 1001), 120]))
def test_frames_and_rows_are_those_of_the_literal_definition(warp: Warp, n_frames: int, rate: Fraction | float) -> None:
    rng = np.random.default_rng(n_frames)
    rows = rng.normal(size=(n_frames, 2, 3))
    labels = rng.integers(0, 5, n_frames)
    o, i = warp.output_times.tolist(), warp.input_times.tolist()
    n_output = max(1, round(warp.output_span * float(rate)) + 1)
    times = [min(o[0] + k / float(rate), o[-1]) for k in range(n_output)]
    times[-1] = o[-1] if n_output > 1 else o[0]
    places = [min(max(literal.evaluate(o, i, time) * float(rate), 0.0), n_frames - 1.0) for time in times]
    with warnings.catch_warnings():
        # The drawn warps care for no clip's ends.
        warnings.simplefilter("ignore", RetimeWarning)
        found = warp.to_frame_indices(rate, n_frames)
        shown = warp.resample(rows, rate)
        named = warp.resample(labels, rate, method="nearest")
    assert len(found) == len(shown) == len(named) == n_output
    for k, place in enumerate(places):
        assert abs(found[k] - place) <= 0.5 + 1e-6
        assert named[k] == labels[found[k]]
        low = min(int(place), n_frames - 1)
        high = min(low + 1, n_frames - 1)
        expected = rows[low] + (place - low) * (rows[high] - rows[low])
        np.testing.assert_allclose(shown[k], expected, atol=1e-6)


def test_the_identity_gives_back_the_same_rows_bit_for_bit() -> None:
    rows = np.random.default_rng(0).normal(size=(100, 3))
    whole = Warp([0.0, 99 / 30], [0.0, 99 / 30])
    assert np.array_equal(whole.resample(rows, 30), rows)
    assert whole.to_frame_indices(30, 100).tolist() == list(range(100))


def test_what_is_resampled_keeps_its_type_or_becomes_floats() -> None:
    half = Warp([0.0, 2.0], [0.0, 1.0])
    assert half.resample([0, 1], 1).tolist() == [0.0, 0.5, 1.0]
    assert half.resample([0, 1j], 1).tolist() == [0, 0.5j, 1j]
    assert half.resample(np.array([1, 2], np.uint8), 1, method="nearest").dtype == np.uint8
    assert half.resample(np.array([200, 0], np.uint8), 1).tolist() == [200.0, 100.0, 0.0]
    assert half.resample([True, False], 1, method="nearest").tolist() == [True, False, False]


@pytest.mark.parametrize(
    ("call", "says"),
    [
        (lambda w: w.resample(["a", "b"], 1), "method='nearest'"),
        (lambda w: w.resample([True, False], 1), "method='nearest'"),
        (lambda w: w.resample([1.0, 2.0], 1, method="cubic"), "one of linear, nearest; found 'cubic'"),
        (lambda w: w.resample(3.0, 1), "a row for each frame"),
        (lambda w: w.resample([], 1), "input frames must be 1 or more"),
        (lambda w: w.resample([1.0, 2.0], 0), "above 0"),
        (lambda w: w.resample([1.0, 2.0], "30"), "above 0, found the text '30'"),
        (lambda w: w.resample([1.0, 2.0], float("nan")), "above 0"),
        (lambda w: w.to_frame_indices(30, 2.5), "input frames must be 1 or more"),
        (lambda w: w.to_frame_indices(30, True), "input frames must be 1 or more"),
    ],
)
def test_arrays_that_can_not_be_shown_are_refused(call, says: str) -> None:
    with pytest.raises(OptionError, match=says):
        call(Warp([0.0, 1.0], [0.0, 1.0]))


def test_an_array_of_another_length_is_warned_of() -> None:
    warp = Warp([0.0, 1.0], [0.0, 1.0])
    with pytest.warns(RetimeWarning, match="reaches input times 0 to 1 s") as caught:
        assert warp.to_frame_indices(10, 6).tolist() == [0, 1, 2, 3, 4, 5, 5, 5, 5, 5, 5]
    assert caught[0].filename == __file__
    with pytest.warns(RetimeWarning, match="is left out"):
        warp.resample(np.zeros(30), 10)


# Files


def test_a_saved_warp_is_loaded_equal_and_not_written_over(tmp_path) -> None:
    warp = Warp([0.0, 1.0], [0.0, 2.0], [(2.0, 1.0, 2.0)], "linear", "walk")
    warp.save(tmp_path / "walk.json")
    assert Warp.load(tmp_path / "walk.json") == warp
    assert Warp.load(str(tmp_path / "walk.json")) == warp
    with pytest.raises(OutputExistsError):
        warp.save(tmp_path / "walk.json")
    replace(warp, name="run").save(tmp_path / "walk.json", overwrite=True)
    assert Warp.load(tmp_path / "walk.json").name == "run"
    with pytest.raises(FormatError, match=r"walk\.json: the file has \d+ bytes, the limit is 5"):
        Warp.load(tmp_path / "walk.json", most_bytes=5)
    (tmp_path / "none.json").write_text("[\n1,")
    with pytest.raises(FormatError, match=r"none\.json:2:3: not JSON"):
        Warp.load(tmp_path / "none.json")


# JSON


def same(a: Warp, b: Warp) -> bool:
    """Bit for bit, the sign of zero included."""
    return (
        a.output_times.tobytes() == b.output_times.tobytes()
        and a.input_times.tobytes() == b.input_times.tobytes()
        and repr(a.keytimes) == repr(b.keytimes)
        and (a.method, a.name) == (b.method, b.name)
    )


ANY_FLOAT = st.floats(allow_nan=False, allow_infinity=False)


@settings(max_examples=40)
@given(
    st.lists(ANY_FLOAT, min_size=2, max_size=9, unique=True),
    st.data(),
    st.text(max_size=8),
    st.lists(st.builds(Keytime, input_time=ANY_FLOAT, output_time=ANY_FLOAT), max_size=3),
)
def test_json_gives_the_same_bits_back(
    output_times: list[float], data: st.DataObject, name: str, keytimes: list[Keytime]
) -> None:
    output_times = sorted(output_times)
    assume(all(a < b for a, b in itertools.pairwise(output_times)))
    n = len(output_times)
    input_times = data.draw(st.lists(ANY_FLOAT, min_size=n, max_size=n))
    warp = Warp(output_times, input_times, tuple(keytimes), method="gui\u00e9", name=name)
    text = warp.to_json()
    assert same(Warp.from_json(text), warp)
    assert same(Warp.from_json(text.encode()), warp)
    assert same(Warp.from_json(b"\xef\xbb\xbf" + text.encode()), warp)


def document(**changes: object) -> str:
    whole = {
        "format": "retime-warp",
        "version": 1,
        "method": "guided",
        "name": "walk",
        "keytimes": [[0, 0], [1, 2.5]],
        "output_times": [0, 0.5, 1],
        "input_times": [0, 0.25, 2.5],
    }
    whole.update(changes)
    return json.dumps({key: value for key, value in whole.items() if value is not ...})


def test_what_may_be_left_out_of_a_document() -> None:
    assert Warp.from_json(document(keytimes=..., method=..., name=...)).keytimes == ()
    assert Warp.from_json(document(note={"who": ["knows"]})).name == "walk"


def nested(depth: int) -> str:
    return "[" * depth + "]" * depth


BROKEN = {
    "empty": "",
    "spaces": "  \n",
    "not_json": "format: retime-warp",
    "another_format": document(format="otio"),
    "a_list": "[1, 2]",
    "a_number": "17",
    "null": "null",
    "no_version": document(version=...),
    "from_the_future": document(version=2),
    "version_as_text": document(version="1"),
    "version_true": document(version=True),
    "no_output_times": document(output_times=...),
    "times_null": document(input_times=None),
    "times_as_text": document(input_times="0 1 2"),
    "a_time_as_text": document(input_times=[0, "1", 2]),
    "a_time_true": document(input_times=[0, True, 2]),
    "a_time_null": document(input_times=[0, None, 2]),
    "times_nested": document(input_times=[[0, 1, 2]]),
    "an_object_for_times": document(input_times={"0": 1}),
    "lengths_differ": document(input_times=[0, 1]),
    "one_knot": document(input_times=[0], output_times=[0]),
    "no_knot": document(input_times=[], output_times=[]),
    "times_decrease": document(output_times=[0, 2, 1]),
    "nan": document(input_times=[0, float("nan"), 2]),
    "infinity": document(input_times=[0, float("inf"), 2]),
    "minus_infinity": document(output_times=[float("-inf"), 0, 2]),
    "beyond_doubles": document().replace("0.25", "1e999"),
    "a_whole_number_beyond_doubles": document().replace("0.25", "1" + "0" * 400),
    "thousands_of_digits": document().replace("0.25", "1" * 5000),
    "underscore": document().replace("0.25", "1_0"),
    "another_script": document().replace("0.25", "\u0661"),
    "hexadecimal": document().replace("0.25", "0x10"),
    "keytimes_as_object": document(keytimes={"0": 0}),
    "keytimes_null": document(keytimes=None),
    "a_keytime_of_one": document(keytimes=[[0]]),
    "a_keytime_of_four": document(keytimes=[[0, 1, 2, 3]]),
    "a_keytime_as_number": document(keytimes=[0, 1]),
    "a_keytime_as_text": document(keytimes=[["0", "1"]]),
    "a_keytime_true": document(keytimes=[[True, False]]),
    "a_keytime_nan": document(keytimes=[[0, float("nan")]]),
    "a_keytime_beyond_doubles": document().replace("2.5]]", "1e999]]"),
    "a_whole_keytime_beyond_doubles": document().replace("2.5]]", "1" + "0" * 400 + "]]"),
    "method_as_number": document(method=3),
    "name_null": document(name=None),
    "two_documents": document() * 2,
    "deep": nested(100_000),
    "deep_inside": document(note=...)[:-1] + f', "note": {nested(500)}}}',
    "deep_in_objects": document(note=...)[:-1] + ', "note": ' + '{"a":' * 500 + "1" + "}" * 500 + "}",
    "not_utf8": b"\xff\xfe{\x00}\x00",
    "utf8_cut": document(name="\u5de6").encode()[:60] + b"\xe5",
    "nul": b"\x00",
}


@pytest.mark.parametrize("text", BROKEN.values(), ids=BROKEN)
def test_broken_json_ends_in_a_format_error(text: str | bytes) -> None:
    with pytest.raises(FormatError):
        Warp.from_json(text)


def test_json_nested_to_the_limit_loads() -> None:
    assert Warp.from_json(document()[:-1] + f', "note": {nested(63)}}}').name == "walk"
    with pytest.raises(FormatError, match="64"):
        Warp.from_json(document()[:-1] + f', "note": {nested(64)}}}')


def test_every_truncation_ends_in_a_format_error() -> None:
    whole = document().encode()
    for length in range(len(whole)):
        with pytest.raises(FormatError):
            Warp.from_json(whole[:length])


@settings(max_examples=100)
@given(st.data())
def test_damaged_json_ends_in_a_warp_or_a_format_error(data: st.DataObject) -> None:
    damaged = bytearray(document().encode())
    for _ in range(data.draw(st.integers(1, 3))):
        place = data.draw(st.integers(0, len(damaged) - 1))
        damaged[place : place + data.draw(st.integers(0, 2))] = data.draw(st.binary(max_size=3))
    try:
        warp = Warp.from_json(bytes(damaged))
    except FormatError:
        return
    assert same(Warp.from_json(warp.to_json()), warp)


def test_a_place_in_the_file_is_named() -> None:
    with pytest.raises(FormatError, match="2:3: not JSON") as caught:
        Warp.from_json("{\n  oops")
    assert (caught.value.line, caught.value.column) == (2, 3)


def test_the_span_of_the_output_is_no_length_of_a_clip() -> None:
    warp = Warp([1.0, 1.0 + 479 / 60], [0.0, 4.0])
    assert warp.output_span == pytest.approx(479 / 60)
    assert (warp.count_frames(60), warp.count_frames(Fraction(30000, 1001))) == (480, 240)
    assert Warp([0.0, 1e-3], [0.0, 1.0]).count_frames(30) == 1
    with pytest.warns(DeprecationWarning, match=r"output_span"):
        assert warp.output_duration == warp.output_span
