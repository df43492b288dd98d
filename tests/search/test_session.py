"""Session.solve: free lengths, loops and keytimes against every path there is; what it keeps between solves."""

from __future__ import annotations

import itertools
import math
import re
from collections.abc import Sequence
from dataclasses import replace
from fractions import Fraction
from functools import cache

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from retime.errors import InfeasibleWarpError, OptionError
from retime.motion.grammar import parse_time
from retime.motion.signal import Signal
from retime.search.guided import guided_warp
from retime.search.keytimes import as_keytimes
from retime.search.methods.heuristic import SLACK
from retime.search.poses.references import Reference
from retime.search.result import GuidedWarp
from retime.search.score import triple_scores
from retime.search.session import Session
from retime.search.wishes.locks import Lock
from retime.warp.apply import apply_warp
from retime.warp.keytime import Keytime
from retime.warp.spline import linear_warp
from tests.reference import wishes as literal
from tests.reference.wishes import Wishes


def curve(n_frames: int, rate: Fraction | int = 30, seed: int = 0) -> Signal:
    """Smooth, and nowhere the same twice."""
    rng = np.random.default_rng(seed)
    t = np.arange(n_frames)[:, None] / float(rate)
    values = np.sin(t * rng.uniform(1, 4, 3) + rng.uniform(0, 6, 3)) + 0.4 * t * rng.uniform(-1, 1, 3)
    return Signal(("x", "y", "z"), values, Fraction(rate), name="curve")


def cycle(n_frames: int, rate: int = 30, seed: int = 0) -> Signal:
    """A closed curve whose last frame is the first one again."""
    rng = np.random.default_rng(seed)
    phase = 2 * np.pi * np.arange(n_frames)[:, None] / (n_frames - 1)
    values = np.sin(phase + rng.uniform(0, 6, 3)) + 0.4 * np.sin(2 * phase + rng.uniform(0, 6, 3))
    return Signal(("x", "y", "z"), values, Fraction(rate), name="cycle")


def scores_of(result: GuidedWarp) -> np.ndarray:
    return triple_scores(
        result.input_poses,
        result.model,
        max_skip=result.max_skip,
        n_neighbors=result.n_neighbors,
        score=result.score,
    )


def least(
    result: GuidedWarp, lengths: Sequence[int], *, neutral: bool = False, loop: bool = False, **wishes: object
) -> float:
    """Try every path; the least total, inf where there is none."""
    scores, reduction = scores_of(result), result.reduction

    @cache
    def seam(step: int) -> float:
        poses = result.input_poses[[-1 - step, 0, step]]
        across = triple_scores(poses, result.model, max_skip=1, n_neighbors=result.n_neighbors, score=result.score)
        return float(across[1, 0, 0]) * (math.sqrt(step / reduction.upsample) if neutral else 1.0)

    best = math.inf
    for path in literal.paths(reduction, result.max_skip, Wishes(**wishes), lengths):  # type: ignore[arg-type]
        total = literal.cost(path, scores, reduction, neutral=neutral)
        if loop:
            step = path[1] - path[0]
            if path[-1] - path[-2] != step:
                continue
            total += seam(step)
        best = min(best, total)
    return best


@pytest.mark.parametrize("score", ["joint", "conditional"])
@pytest.mark.parametrize("weight", ["neutral", "sum"])
@pytest.mark.parametrize(
    "keys", [(), [("4f", "6f")], [("6f", "4f"), ("6f", "5f"), ("3f", "7f")]], ids=["none", "one", "mixed"]
)
def test_free_lengths_equal_enumeration(score: str, weight: str, keys: Sequence[tuple[str, str]]) -> None:
    for seed in range(2):
        session = Session(curve(8, seed=seed), reference=curve(20, seed=seed + 50), score=score)
        for bounds in ({}, {"min_length": 12}, {"max_length": 11}, {"min_length": 10, "max_length": 12}):
            texts = {name: f"{n}f" for name, n in bounds.items()}
            result = session.solve(length="free", free_weight=weight, keys=keys, upsample=2, max_skip=3, **texts)
            lengths = range(bounds.get("min_length", 2), bounds.get("max_length", result.n_input) + 1)
            wanted = least(result, lengths, neutral=weight == "neutral")
            assert result.total == pytest.approx(wanted, rel=1e-12)
            assert len(result.path.frames) in lengths
            assert round(result.warp.output_end * 30) + 1 in lengths
            for key in result.reduction.keytimes:
                assert float(result.warp(key.output_time)) == key.input_time


@pytest.mark.parametrize("rate", [30, 120, Fraction(24000, 1001)])
@pytest.mark.parametrize("n_frames", [40, 97])
def test_bounds_on_a_free_length_are_kept_at_any_rate(rate: Fraction | int, n_frames: int) -> None:
    clip = curve(n_frames, rate)
    session = Session(clip, reference=curve(60, seed=3))
    for low, high in ((n_frames, n_frames), (n_frames + 3, n_frames + 5), (None, n_frames // 2), (2 * n_frames, None)):
        low_text, high_text = (None if n is None else f"{n}f" for n in (low, high))
        result = session.solve(length="free", min_length=low_text, max_length=high_text)
        n_output = round(result.warp.output_span * float(rate)) + 1
        assert (low or 2) <= n_output <= (high or 10**6)
        assert result.warp.output_end == pytest.approx(float((n_output - 1) / Fraction(rate)), abs=1e-12)


@pytest.mark.parametrize("score", ["joint", "conditional"])
@pytest.mark.parametrize(
    "options",
    [{"length": "8f"}, {"length": "7f"}, {"length": "free"}, {"length": "free", "free_weight": "sum"}],
    ids=str,
)
@pytest.mark.parametrize("keys", [(), [("5f", "4f")]], ids=["none", "one"])
def test_loops_equal_enumeration(score: str, options: dict[str, object], keys: Sequence[tuple[str, str]]) -> None:
    for seed in range(2):
        session = Session(cycle(8, seed=seed), reference=curve(20, seed=seed + 50), score=score)
        result = session.solve(loop=True, upsample=2, max_skip=3, keys=keys, **options)
        free = options["length"] == "free"
        lengths = range(2, result.n_input + 1) if free else [int(str(options["length"])[:-1])]
        wanted = least(result, lengths, neutral=free and "free_weight" not in options, loop=True)
        assert result.total == pytest.approx(wanted, rel=1e-12)
        assert result.path.lower_bound <= result.total
        steps = np.diff(result.path.frames)
        assert steps[0] == steps[-1]
        assert result.warp.slopes[0] == pytest.approx(result.warp.slopes[-1], rel=1e-9)
        seam = result.explain().seam_cost
        assert seam + np.nansum(result.explain().costs) == pytest.approx(result.total, rel=1e-12)


def test_a_loop_that_can_not_close_is_refused_only_where_no_path_closes() -> None:
    session = Session(cycle(9), reference=curve(20, seed=1))
    lock = [Lock(0.0, 0.1, 2.0, 2.0)]
    refused = 0
    for length in range(3, 14):
        options = {"length": f"{length}f", "upsample": 2, "max_skip": 4, "locks": lock}
        try:
            session.solve(loop=True, **options)
        except InfeasibleWarpError:
            refused += 1
            try:
                open_path = session.solve(**options)
            except InfeasibleWarpError:
                continue
            assert least(open_path, [length], loop=True, locks=lock) == math.inf
    assert 0 < refused < 11


@pytest.mark.parametrize("keys", [(), [(1.0, 0.7)], [(0.8, 0.9), (1.3, 1.1)]], ids=len)
@pytest.mark.parametrize("influence", [1.0, 0.4, [(0.0, 1.0), (1.0, 0.2), (1.5, 0.9)]], ids=str)
@pytest.mark.parametrize("rate", [30, 120])
def test_first_and_last_slopes_of_a_loop_agree(keys: list[tuple[float, float]], influence: object, rate: int) -> None:
    for length in ("75%", "101%", "free"):
        warp = guided_warp(cycle(2 * rate + 1, rate), length=length, keys=keys, loop=True, influence=influence).warp
        assert warp.monotone
        # A mix that changes over time has its own slopes; where it is the same at both ends, they agree.
        if not isinstance(influence, list):
            assert warp.slopes[0] == pytest.approx(warp.slopes[-1], rel=0.1 if keys and influence != 1.0 else 1e-9)


# Keytimes


@st.composite
def clip_and_keys(draw: st.DrawFn) -> tuple[Signal, list[tuple[str | float, str | float]]]:
    """Keys in all units, some of them holds or backward, not too close to each other."""
    rate = draw(st.sampled_from([Fraction(30), Fraction(120), Fraction(24000, 1001), Fraction(50)]))
    clip = curve(round(2 * rate), rate, seed=draw(st.integers(0, 5)))

    def written(seconds: float) -> str | float:
        unit = draw(st.sampled_from(["number", "seconds", "frames", "clock"]))
        if unit == "frames":
            return f"{round(seconds * rate)}f"
        return {"number": seconds, "seconds": f"{seconds:.6f}s", "clock": f"0:{seconds:06.3f}"}[unit]

    n_keys = draw(st.integers(0, 4))
    output, keys = 0.0, []
    for _ in range(n_keys):
        output += draw(st.floats(0.1, 1.0))
        if keys and draw(st.integers(0, 3)) == 0:
            keys.append((keys[-1][0], written(output)))
        else:
            keys.append((written(draw(st.floats(0.05, 1.9))), written(output)))
    return clip, keys


@settings(max_examples=60)
@given(
    clip_and_keys(), st.sampled_from([0, 5, 9]), st.sampled_from([1.0, 0.5, "curve"]), st.sampled_from(["30", "17.5"])
)
def test_keytimes_are_met_exactly(
    drawn: tuple[Signal, list[tuple[str | float, str | float]]], smoothing: int, influence: object, rate: str
) -> None:
    clip, keys = drawn
    share = [(0.1, 0.9), (0.8, 0.1), (1.6, 1.0)] if influence == "curve" else influence
    try:
        result = guided_warp(clip, keys=keys, smoothing=smoothing, influence=share, rate=rate)
    except InfeasibleWarpError as error:
        # Two of the drawn keys are nearer to each other than the analysis can tell; anything else must be met.
        if re.search("closer than one frame|two keytimes", str(error)):
            return
        raise
    pairs = [(parse_time(out, clip.rate), parse_time(into, clip.rate)) for into, out in keys]
    for output_time, input_time in [(0.0, 0.0), *pairs, (result.warp.output_end, None)]:
        if input_time is not None and output_time > 0:
            assert float(result.warp(output_time)) == input_time
            assert float(result.staircase(output_time)) == input_time
    assert result.warp.keytimes == result.reduction.keytimes
    # Between two keys it goes one way, at rest in a hold.
    warp = result.warp
    for before, after in itertools.pairwise(warp.keytimes):
        inside = (warp.output_times >= before.output_time) & (warp.output_times <= after.output_time)
        moves = np.diff(warp.input_times[inside])
        direction = np.sign(after.input_time - before.input_time)
        assert (moves * direction >= 0).all() if direction else (moves == 0).all()


@pytest.mark.parametrize("rate", [30, 100, 120, Fraction(24000, 1001)])
@pytest.mark.parametrize("n_frames", [2, 3, 50, 101])
@pytest.mark.parametrize(
    "options", [{}, {"length": "100%"}, {"loop": True}, {"smoothness": 1.0}, {"influence": 0.5}], ids=str
)
def test_nothing_asked_is_the_identity(rate: Fraction | int, n_frames: int, options: dict[str, object]) -> None:
    clip = curve(n_frames, rate)
    if n_frames < 10:
        options = {**options, "rate": str(rate)}
    if n_frames < 5:
        with pytest.raises(OptionError, match="needs at least 5"):
            guided_warp(clip, **options)
        return
    result = guided_warp(clip, **options)
    np.testing.assert_allclose(result.warp.input_times, result.warp.output_times, rtol=0, atol=1e-12)
    assert result.warp.output_end == clip.end_time


@pytest.mark.parametrize("length", ["55%", "80%", "100%", "130%", "300%"])
def test_a_warp_without_holds_or_reversals_is_strictly_monotone(length: str) -> None:
    for reference in (None, curve(50, seed=4)):
        result = guided_warp(curve(97, 48), reference=reference, length=length, keys=[(0.31, 0.29)])
        assert result.warp.monotone


def test_keys_are_read_in_any_unit_and_order() -> None:
    clip = curve(241, 120)
    wanted = (
        Keytime(input_time=0.0, output_time=0.0),
        Keytime(input_time=1.0, output_time=0.5, speed=0.25),
        Keytime(input_time=1.5, output_time=1.25),
        Keytime(input_time=2.0, output_time=1.75),
    )
    for keys in (
        [(1.0, 0.5, 0.25), (1.5, 1.25)],
        [("180f", "0:01.25"), ("1s", "60f", "1/4")],
        [("0:01.5", 1.25), ("120f", "0.5", 0.25)],
        [
            Keytime(input_time=1.5, output_time=1.25),
            Keytime(input_time=1.0, output_time=0.5, speed=0.25),
            Keytime(input_time=0.0, output_time=0.0),
        ],
        [(1.0, 0.5), (1.0, 0.5, 0.25), (1.5, 1.25), (1.5, 1.25), (0, 0)],
    ):
        found = as_keytimes(clip, None, keys)
        assert found == wanted
        assert [key.speed for key in found] == [None, 0.25, None, None]
    assert as_keytimes(clip, "50%", [])[-1] == Keytime(input_time=2.0, output_time=119 / 120)
    assert as_keytimes(clip, "1.5s", [(0.5, 1.0)])[-1] == Keytime(input_time=2.0, output_time=179 / 120)
    # The last key may end the output elsewhere than at the clip's end.
    assert as_keytimes(clip, "121f", [(0.5, 1.0)])[-1] == Keytime(input_time=0.5, output_time=1.0)
    assert as_keytimes(clip, None, [(2.0, 3.0)])[-1] == Keytime(input_time=2.0, output_time=3.0)
    # The output may begin elsewhere than at the clip's beginning.
    assert as_keytimes(clip, None, [(0.5, 0)])[0] == Keytime(input_time=0.5, output_time=0.0)
    assert math.isinf(as_keytimes(clip, "free", [])[-1].output_time)


# Heuristic, references, what a session keeps


@pytest.mark.parametrize(
    "options",
    [
        {},
        {"keys": [(3.0, 2.0)]},
        {"locks": [Lock(2.0, 3.0)]},
        {"smoothness": 1.0},
        {"keys": [(3.0, 2.0, 0.5)], "speed": (0.5, 4)},
    ],
    ids=str,
)
def test_the_heuristic_reports_its_excess(options: dict[str, object]) -> None:
    excesses = []
    for seed, slack in itertools.product(range(3), (SLACK, 0, None)):
        session = Session(curve(200, seed=seed))
        session.slack = slack
        best = session.solve(length="65%", **options)
        found = session.solve(length="65%", search="heuristic", **options)
        assert found.total >= best.total
        assert found.path.lower_bound <= best.total
        assert found.excess == pytest.approx(found.total / best.total - 1, rel=1e-9)
        assert found.path.optimal == (found.total == best.total)
        assert best.excess is None
        assert found.total == pytest.approx(sum(found.path.scores), rel=1e-12)
        excesses.append(found.excess)
    assert max(excesses) > 0


def test_five_reference_frames_suffice_and_four_do_not() -> None:
    clip = curve(60)
    for n in (3, 4):
        with pytest.raises(OptionError, match=rf"has {n} frames .* needs at least 5"):
            Session(clip, reference=clip.frames(10, 10 + n))
    result = guided_warp(clip, reference=clip.frames(10, 15), length="80%")
    assert result.n_reference == 5
    assert set(result.explain().references[1:-1].ravel()) == {0}
    # Several short ones do together what one can't.
    pieces = [clip.frames(10, 13), clip.frames(20, 23), clip.frames(30, 33)]
    assert guided_warp(clip, reference=pieces, length="80%").n_reference == 9


@pytest.mark.parametrize("n_frames", [2, 3, 4])
@pytest.mark.parametrize("options", [{}, {"search": "heuristic"}, {"loop": True}, {"n_neighbors": 4}], ids=str)
def test_a_clip_too_short_to_search_is_called_so_not_a_reference(n_frames: int, options: dict[str, object]) -> None:
    clip = replace(curve(60).frames(0, n_frames), name="short")
    needed = int(options.get("n_neighbors", 3)) + 2
    with pytest.raises(
        OptionError, match=rf"^short is too short to search: it has {n_frames} frames .*30 Hz, .* at least {needed}\."
    ) as refusal:
        guided_warp(clip, length="150%", **options)
    assert "--method linear" in str(refusal.value)
    assert "the reference" not in str(refusal.value)
    assert refusal.value.option == "motion"
    # It can be played evenly, and it can imitate something longer.
    even = linear_warp(as_keytimes(clip, "150%", ()))
    assert apply_warp(clip, even).n_frames == round(1.5 * n_frames)
    longer = guided_warp(clip, reference=curve(60), length="150%")
    assert apply_warp(clip, longer.warp).n_frames == round(1.5 * n_frames)


def test_a_single_frame_has_no_timing() -> None:
    for reference in (None, curve(60)):
        with pytest.raises(OptionError, match="has one frame: there is no timing to change"):
            guided_warp(curve(60).frames(0, 1), reference=reference)


def test_a_clip_too_short_for_the_coarse_search_alone_is_pointed_to_the_exact_one() -> None:
    clip = curve(60).frames(0, 12)
    with pytest.raises(OptionError, match=r"too few frames for the heuristic search, .* take search='priced'"):
        guided_warp(clip, length="150%", search="heuristic")
    assert guided_warp(clip, length="150%").n_output == 18


@pytest.mark.parametrize("score", ["joint", "conditional"])
def test_a_heavy_reference_is_matched_more(score: str) -> None:
    clip = curve(80)
    rivals = [curve(60, seed=7), curve(60, seed=8)]
    shares = []
    for weight in (0.1, 1.0, 10.0):
        references = [Reference(rivals[0]), Reference(rivals[1], weight=weight)]
        matched = guided_warp(clip, reference=references, length="80%", score=score).explain().references[1:-1]
        shares.append(float(np.mean(matched == 1)))
    assert shares[0] < shares[1] < shares[2]


@pytest.mark.parametrize("score", ["joint", "conditional"])
def test_dragging_a_key_gives_what_a_fresh_session_gives(score: str) -> None:
    rng = np.random.default_rng(1)
    clip, reference = curve(150, 60), curve(60, seed=9)
    session = Session(clip, reference=reference, score=score)
    wishes: list[dict[str, object]] = [
        {},
        {"length": "free"},
        {"length": "free", "free_weight": "sum"},
        {"smoothness": 0.5},
        {"locks": [Lock(1.2, 1.5)]},
        {"speed": (0.25, 3)},
        {"max_skip": 9},
        {"upsample": 5},
        {"loop": True},
        {"search": "heuristic"},
        {"influence": 0.5},
    ]
    for turn in range(24):
        key = (float(rng.uniform(0.5, 1.0)), float(rng.uniform(0.5, 1.0)))
        more = wishes[int(rng.integers(len(wishes)))] if turn % 2 else {}
        options = {"length": "90%", "keys": [key], **more}
        kept = session._tables.latest
        before = None if kept is None else kept.scores.copy()
        again, fresh = session.solve(**options), Session(clip, reference=reference, score=score).solve(**options)
        if kept is not None:
            assert np.array_equal(kept.scores, before), "cached scores were changed"
        assert np.array_equal(again.path.frames, fresh.path.frames)
        assert again.total == fresh.total
        assert np.array_equal(again.warp.input_times, fresh.warp.input_times)
        assert (again.max_skip, again.upsample) == (fresh.max_skip, fresh.upsample)
        assert session._tables.latest is not None
        assert len(session._tables.latest.scores) == again.n_input
        assert session._tables.latest.steps.longest >= again.max_skip


def test_scores_are_kept_while_only_the_timing_changes() -> None:
    session = Session(curve(150))
    session.solve(length="80%")
    kept = session._tables.latest
    session.solve(length="70%", keys=[(2.0, 1.5)], smoothness=1.0, locks=[Lock(1.0, 2.0)])
    assert session._tables.latest is kept
    session.solve(length="70%", max_skip=12)
    assert session._tables.latest is not kept


# What contradicts itself is refused, and says why

CONTRADICTIONS: dict[str, tuple[dict[str, object], str]] = {
    "bounds_without_a_free_length": ({"length": "80%", "max_length": "90%"}, "need a free length"),
    "bounds_without_any_length": ({"min_length": "90%"}, "need a free length"),
    "least_above_most": ({"length": "free", "min_length": "90%", "max_length": "50%"}, "more than the most"),
    "free_after_the_end": ({"length": "free", "keys": [(2.0, 1.0)]}, "nothing is left"),
    "key_before_the_output": ({"keys": [(1.0, -0.5)]}, "begins at time 0"),
    "key_beyond_the_output": ({"keys": [(1.0, 3.0)], "length": "80%"}, "beyond the output's last frame"),
    "key_nan": ({"keys": [(float("nan"), 1.0)]}, "expected a time"),
    "key_inf": ({"keys": [(1.0, float("inf"))]}, "expected a time"),
    "keytime_nan": ({"keys": [Keytime(input_time=1.0, output_time=float("nan"))]}, "output time"),
    "key_of_one": ({"keys": [(1.0,)]}, "a key is"),
    "key_as_text": ({"keys": ["12"]}, "expected input time = output time"),
    "tangent_zero": ({"keys": [(1.0, 1.0, 0)]}, "playback speed"),
    "tangent_negative": ({"keys": [(1.0, 1.0, -1)]}, "playback speed"),
    "tangent_of_a_keytime_negative": ({"keys": [Keytime(input_time=1.0, output_time=1.0, speed=-1.0)]}, "above 0"),
    "tangent_nan": ({"keys": [(1.0, 1.0, float("nan"))]}, "playback speed"),
    "two_tangents": ({"keys": [(1.0, 1.0, 1), (1.0, 1.0, 2)]}, "two speeds"),
    "tangent_beyond_the_limits": ({"keys": [(1.0, 1.0, 3)], "speed": (0.5, 2)}, "speed limits"),
    "tangent_between_holds": (
        {"keys": [(1.0, 1.0), (1.0, 1.2, 1), (1.0, 1.4)]},
        "held before and after",
    ),
    "tangent_too_slow": ({"keys": [(1.0, 1.0, 0.001)]}, "beyond what can be played"),
    "lock_outside": ({"locks": [Lock(5.0, 6.0)]}, "leaves the clip"),
    "lock_before": ({"locks": [Lock(-1.0, 1.0)]}, "leaves the clip"),
    "lock_over_the_end": ({"locks": [Lock(1.0, 3.0)]}, "leaves the clip"),
    "lock_over_a_hold": ({"locks": [Lock(0.5, 1.5)], "keys": [(1.0, 1.0), (1.0, 1.5)]}, "where keytimes hold the pose"),
    "lock_never_shown": ({"locks": [Lock(1.5, 1.8)], "keys": [(1.0, 1.0)], "length": "31f"}, "nowhere shown"),
    "lock_too_short": ({"locks": [Lock(1.0, 1.02, 8.0, 8.0)]}, "one frame of the search, 33 ms, shows more"),
    "lock_too_fast_for_max_skip": (
        {"locks": [Lock(1.0, 1.5, 5.0, 5.0)], "max_skip": 3},
        "can't be played: with max_skip=3",
    ),
    "lock_between_the_steps": (
        {"locks": [Lock(1.0, 1.5, 0.6, 0.7)], "upsample": 2},
        "can't be played: with upsample=2",
    ),
    "limits_reversed": ({"speed": (2.0, 1.0)}, "slowest first"),
    "limits_zero": ({"speed": (0.0, 0.0)}, "above 0"),
    "limits_negative": ({"speed": (-1.0, 1.0)}, "above 0"),
    "limits_nan": ({"speed": (float("nan"), 1.0)}, "above 0"),
    "limits_between_the_steps": (
        {"speed": (0.6, 0.7), "upsample": 2},
        r"no speed from 0\.6 to 0\.7 can be played: with upsample=2 .* raise upsample$",
    ),
    "limits_beyond_bytes": ({"speed": (1 / 24, 16)}, r"from 1/24 to 16: .* Ask for speeds up to 10\.6, or"),
    "max_skip_0": ({"max_skip": 0}, "max_skip must be"),
    "max_skip_256": ({"max_skip": 256}, "max_skip must be"),
    "upsample_0": ({"upsample": 0}, "upsample must be"),
    "smoothness_negative": ({"smoothness": -1.0}, "smoothness"),
    "smoothness_nan": ({"smoothness": float("nan")}, "smoothness"),
    "smoothing_negative": ({"smoothing": -1}, "smoothing must be"),
    "influence_beyond_1": ({"influence": 1.5}, "from 0 to 1"),
    "influence_nan": ({"influence": float("nan")}, "from 0 to 1"),
    "influence_of_the_wrong_shape": ({"influence": [0.1, 0.2]}, "rows of"),
    "influence_out_of_order": ({"influence": [(1.0, 0.1), (0.5, 0.2)]}, "times that increase"),
    "influence_empty": ({"influence": np.empty((0, 2))}, "rows of"),
    "loop_with_a_backward_end": ({"loop": True, "keys": [(1.5, 1.0), (1.0, 1.5)], "length": "46f"}, "same direction"),
    "loop_with_a_held_end": ({"loop": True, "keys": [(1.0, 1.0), (1.0, 1.5)], "length": "46f"}, "same direction"),
    "loop_with_two_speeds": ({"loop": True, "keys": [(0, 0, 1), (2.0, 1.7, 2)]}, "one speed"),
    "loop_by_the_heuristic": ({"loop": True, "search": "heuristic", "length": "80%"}, "heuristic"),
    "heuristic_of_a_free_length": ({"length": "free", "search": "heuristic"}, "given length"),
    "unknown_search": ({"search": "fast"}, "priced, layered, heuristic"),
    "unknown_weight": ({"length": "free", "free_weight": "mean"}, "neutral, sum"),
    "unknown_length": ({"length": "long"}, "expected a length"),
    "unknown_bound": ({"length": "free", "max_length": "long"}, "expected a length"),
}


@pytest.mark.parametrize(("options", "says"), CONTRADICTIONS.values(), ids=CONTRADICTIONS)
def test_contradictions_are_refused(options: dict[str, object], says: str) -> None:
    session = Session(curve(61))
    with pytest.raises(OptionError, match=says):
        session.solve(**options)  # type: ignore[arg-type]


INFEASIBLE: dict[str, tuple[dict[str, object], str]] = {
    "two_keys_at_one_time": ({"keys": [(1.0, 1.0), (1.2, 1.0)]}, "two keytimes stand at"),
    "key_outside_the_clip": ({"keys": [(2.5, 1.0)]}, "runs from 0 to 2 s"),
    "keys_closer_than_a_frame": ({"keys": [(1.0, 1.0), (1.2, 1.001)]}, "closer than one frame"),
    "bounds_out_of_reach": ({"length": "free", "upsample": 1, "min_length": "200%"}, "no length lies within"),
    "bounds_before_the_last_key": (
        {"length": "free", "keys": [(1.0, 3.0)], "max_length": "2s"},
        "no length lies within",
    ),
}


@pytest.mark.parametrize(("options", "says"), INFEASIBLE.values(), ids=INFEASIBLE)
def test_keytimes_that_no_warp_meets_are_refused(options: dict[str, object], says: str) -> None:
    session = Session(curve(61))
    with pytest.raises(InfeasibleWarpError, match=says):
        session.solve(**options)  # type: ignore[arg-type]


@pytest.mark.parametrize("clip", [curve(1), np.zeros((1, 2))], ids=["signal", "array"])
def test_one_frame_has_no_timing(clip: object) -> None:
    with pytest.raises(OptionError, match="one frame"):
        guided_warp(clip, rate=30, reference=curve(20).values[:, :2] if isinstance(clip, np.ndarray) else curve(20))  # type: ignore[arg-type]


def test_uneven_keys_make_only_their_own_span_fine() -> None:
    keys = [(0.366, 3.187), (1.364, 3.3935), (3.924, 3.9697)]
    result = guided_warp(curve(150, seed=1), keys=keys)
    fine, *others = result.reduction.upsamples
    assert fine >= 9
    assert others == [1, 1, 1]
    assert result.max_skip <= 16
    assert result.n_input < 400
    assert [float(result.warp(output)) for _, output in keys] == [into for into, _ in keys]


def test_a_step_is_one_speed_whatever_its_spans_upsampling() -> None:
    """What each step shows is its speed, in spans that are offered in eighths and in quarters alike."""
    result = guided_warp(curve(150, seed=1), reference=curve(90, seed=9), keys=[(1.0, 2.0), (3.0, 3.0)])
    assert result.reduction.upsamples == (8, 4, 8)
    frames = result.path.frames
    shown = np.diff(result.reduction.input_times[frames]) * 30
    beside_keys = {p + near for p in result.reduction.positions for near in (-1, 0)}
    inner = [i for i in range(len(shown)) if i not in beside_keys]
    np.testing.assert_allclose(result.path_speeds[inner], shown[inner], atol=1e-9)


@pytest.mark.parametrize("smoothing", [0, 1])
def test_a_window_of_one_frame_changes_nothing(smoothing: int) -> None:
    result = guided_warp(curve(120), length="65%", smoothing=smoothing)
    times = np.linspace(0, result.warp.output_end, 500)
    np.testing.assert_allclose(result.warp(times), result.staircase(times), atol=1e-12)


def test_a_fiftieth_of_the_length_is_as_fast_as_steps_get() -> None:
    result = guided_warp(curve(300), length="2%")
    assert result.n_output == 6
    with pytest.raises(InfeasibleWarpError, match=r"Use a length of at least \d+f"):
        guided_warp(curve(2000), length="3f")


def test_no_speed_lies_beyond_what_max_skip_and_the_limits_allow() -> None:
    rng = np.random.default_rng(1)
    solved = 0
    for seed in range(60):
        clip = curve(int(rng.integers(60, 200)), int(rng.choice([24, 60, 120])), seed=seed)
        length = float(rng.uniform(0.2, 2.5))
        options: dict[str, object] = {"length": f"{100 * length:.2f}%"}
        if rng.random() < 0.4:
            options["speed"] = (float(rng.uniform(0.1, 0.6)) * min(1, 1 / length), float(rng.uniform(1.2, 3) / length))
        if rng.random() < 0.4:
            into = clip.end_time * float(rng.uniform(0.3, 0.7))
            options["keys"] = [(into, into * length * float(rng.uniform(0.8, 1.2)))]
        try:
            result = guided_warp(clip, **options)  # type: ignore[arg-type]
        except (InfeasibleWarpError, OptionError):
            continue
        solved += 1
        low, high = options.get("speed", (0.0, math.inf))  # type: ignore[misc]
        for warp in (result.staircase, result.warp):
            for span, (before, after) in enumerate(itertools.pairwise(warp.keytimes)):
                mean = (after.input_time - before.input_time) / (after.output_time - before.output_time)
                upsample = result.reduction.upsamples[span]
                inside = (warp.output_times[:-1] >= before.output_time) & (warp.output_times[1:] <= after.output_time)
                assert warp.slopes[inside].max() <= max(min(high, result.max_skip / upsample), mean) * (1 + 1e-9)
                assert warp.slopes[inside].min() >= min(max(low, 1 / upsample), mean) * (1 - 1e-9)
    assert solved > 40


def test_a_lock_is_kept_beside_keytimes_that_lie_between_frames() -> None:
    rng = np.random.default_rng(0)
    solved = 0
    for _ in range(280):
        clip = curve(240, 120, seed=int(rng.integers(5)))
        into = float(rng.uniform(0.5, 1.4))
        output = into * float(rng.uniform(0.7, 1.4))
        start = float(rng.uniform(0.2, into - 0.2))
        lock = Lock(start, float(rng.uniform(start + 0.1, min(start + 0.6, 1.9))))
        length = f"{int(rng.integers(70, 140))}%"
        try:
            result = guided_warp(clip, length=length, keys=[(into, output)], locks=[lock])
        except (InfeasibleWarpError, OptionError):
            continue
        solved += 1
        frames, times = result.path.frames, result.staircase.output_times
        for span in result.plan.locked:
            first, last = np.flatnonzero((frames == span.first) | (frames == span.last))
            # Halfway between knots, where a speed is one piece's.
            inside = (times[first:last] + times[first + 1 : last + 1]) / 2
            np.testing.assert_allclose(result.warp.speed(inside), 1.0, rtol=1e-9)
    assert solved > 250


def test_a_table_that_no_machine_should_make_is_refused_with_what_to_change() -> None:
    with pytest.raises(
        OptionError,
        match=r"about \d+ GB of memory; the limit is 4 GB .RETIME_MOST_MEMORY=GB sets another.*shorter output",
    ):
        guided_warp(curve(400), length="65%", upsample=120)
