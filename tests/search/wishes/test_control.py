"""Locks, tangents, speed limits and smoothness: against every path there is, each looked at by what it means."""

from __future__ import annotations

import itertools
import math
import re
import warnings
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction

import numpy as np
import pytest

from retime.errors import InfeasibleWarpError, OptionError, RetimeWarning
from retime.kernels import Backend, StepPairs
from retime.motion.signal import Signal
from retime.search.path import SEARCHES, FramePath, shortest_path
from retime.search.reduction import Reduction, reduce_to_compression
from retime.search.session import Session
from retime.search.wishes.allowed import allowed_steps, end_costs, forbid
from retime.search.wishes.feasible import check_counts, steps_fit
from retime.search.wishes.locks import Lock, locked_spans
from retime.search.wishes.prices import add_smoothness
from retime.warp.keytime import Keytime
from tests.reference import wishes as literal
from tests.reference.paths import every_path
from tests.reference.wishes import Wishes

RATE = 30.0


@dataclass(frozen=True)
class Problem:
    reduction: Reduction
    steps: StepPairs
    input_end: float
    wishes: Wishes
    smoothness: float
    scores: np.ndarray


def random_problem(rng: np.random.Generator, *, what: Sequence[str], most: int = 16) -> Problem:
    """A few spans, forward, held or backward, with keytimes off the grid, and wishes of the given kinds.

    Most wishes are taken from a path that was drawn first, so that many problems have an answer.
    """
    max_skip = int(rng.integers(2, 5))
    finest = int(rng.integers(1, 4))
    spans, upsamples = [], []
    while not spans or rng.random() < 0.5:
        steps = rng.integers(1, max_skip + 1, rng.integers(1, 6))
        if rng.random() < 0.5:
            steps[:] = steps[0]
        spans.append(steps * rng.choice([1, 1, 1, 0, -1]))
        upsamples.append(finest if rng.random() < 0.7 else int(rng.integers(1, 4)))
    while len(spans) > 1 and sum(max(abs(steps.sum()), len(steps)) for steps in spans) > most:
        spans.pop()
    spans[0] = spans[0][: max(1, most // max_skip)]
    upsamples = upsamples[: len(spans)]
    # In sixths of an analysis period, so that every grid's places are whole.
    path = np.cumsum(np.concatenate([[0], *(6 // n * steps for n, steps in zip(upsamples, spans, strict=True))]))
    path -= path.min()
    grid = 6 * RATE
    positions = np.cumsum([0, *(len(steps) for steps in spans)])

    def near(place: float, hertz: float) -> float:
        return max(0.0, (place + rng.uniform(-0.4, 0.4)) / hertz)

    # Equal places are a hold only where the times are equal.
    times = {int(place): near(place, grid) for place in path[positions]}
    input_end = max([*times.values(), path.max() / grid])
    moves = np.abs(np.diff(path)) / 6

    def tangent(position: int) -> float | None:
        beside = {float(move) for move in moves[max(0, position - 1) : position + 1] if move}
        if "tangents" not in what or rng.random() < 0.4 or not beside:
            return None
        if rng.random() < 0.2:
            return float(rng.integers(1, max_skip + 1) / finest)
        return beside.pop() if len(beside) == 1 else None

    keytimes = [
        Keytime(
            input_time=times[int(path[position])],
            output_time=near(position, RATE) if position else 0.0,
            speed=tangent(int(position)),
        )
        for position in positions
    ]
    reduction = reduce_to_compression(keytimes, input_end, rate=RATE, upsample=upsamples)
    locks = []
    for _ in range(rng.integers(1, 3) if "locks" in what else 0):
        first, last = np.sort(rng.integers(0, len(path), 2))
        some = moves[first:last]
        if len(some) and some.all() and rng.random() < 0.6 and path[first] != path[last]:
            speeds = (some.min(), some.max())
        else:
            speeds = [(1.0, 1.0), (0.0, 1.0), (1 / finest, 2.0)][rng.integers(3)]
        start, end = sorted((near(path[first], grid), near(path[last] + 1e-3, grid)))
        locks.append(Lock(float(start), float(end) + 1e-3, float(speeds[0]), float(speeds[1])))
    limits = (0.0, math.inf)
    if "limits" in what:
        low, high = min(moves[moves > 0], default=1.0), max(moves.max(), 1 / finest)
        limits = [(low, high), (0.0, high), (low, math.inf), (0.0, 1.0)][rng.integers(4)]
    shape = (reduction.n_input, max_skip, max_skip)
    scores = rng.random(shape) if rng.random() < 0.7 else rng.integers(0, 4, shape) * 0.5
    steps = StepPairs.up_to(max_skip)
    if "lists" in what:
        some = [step for step in range(1, max_skip + 1) if step in (1, max_skip) or rng.random() < 0.6]
        steps = StepPairs.of(some, ratio=float(rng.choice([2.0, 2.05, 3.0, math.inf])))
        there = np.zeros((max_skip, max_skip), dtype=bool)
        there[steps.steps[steps.before] - 1, steps.steps[steps.after] - 1] = True
        scores = np.where(there, scores, np.inf)
    smoothness = float(rng.choice([0.3, 2.0])) if "smoothness" in what else 0.0
    wishes = Wishes(locks, float(limits[0]), float(limits[1]))
    return Problem(reduction, steps, float(input_end), wishes, smoothness, np.asarray(scores))


def solved(problem: Problem, kernels: Backend, search: str) -> tuple[FramePath, np.ndarray]:
    """The way of a session: from wishes to allowed steps, to forbidden triples, to the path."""
    reduction, wishes = problem.reduction, problem.wishes
    steps = problem.steps
    locked = locked_spans(reduction, steps, problem.input_end, wishes.locks)
    allowed = allowed_steps(
        reduction, steps.longest, steps=steps, locked=locked, slowest=wishes.slowest, fastest=wishes.fastest
    )
    check_counts(reduction, allowed)
    before, after = steps.steps[steps.before], steps.steps[steps.after]
    costs = problem.scores[:, before - 1, after - 1]
    add_smoothness(costs, problem.smoothness, reduction, steps)
    forbid(costs, allowed, steps)
    start, end = end_costs(allowed, steps)
    path = shortest_path(
        costs,
        steps=steps,
        n_output=reduction.n_output,
        anchors=reduction.anchors,
        start_cost=start,
        end_cost=end,
        search=search,
        use=kernels,
    )
    return path, allowed


KINDS = [
    (),
    ("locks",),
    ("tangents",),
    ("limits",),
    ("smoothness",),
    ("locks", "smoothness"),
    ("locks", "tangents"),
    ("locks", "tangents", "limits", "smoothness"),
    ("lists",),
    ("lists", "locks"),
    ("lists", "locks", "tangents", "limits", "smoothness"),
]


@pytest.mark.parametrize("search", SEARCHES)
@pytest.mark.parametrize("what", KINDS, ids="+".join)
def test_wishes_equal_enumeration(kernels: Backend, search: str, what: tuple[str, ...]) -> None:
    rng = np.random.default_rng(len(what) + 7)
    ends: Counter[str] = Counter()
    for _ in range(150 if "lists" in what else 50):
        problem = random_problem(rng, what=what)
        reduction = problem.reduction
        every = list(literal.paths(reduction, problem.steps, problem.wishes, [reduction.n_output]))
        try:
            path, allowed = solved(problem, kernels, search)
        except OptionError:
            ends["refused"] += 1
            continue
        except InfeasibleWarpError:
            assert not every
            ends["infeasible"] += 1
            continue
        assert every
        costs = {one: literal.cost(one, problem.scores, reduction, smoothness=problem.smoothness) for one in every}
        found = tuple(path.frames.tolist())
        assert found in costs
        assert path.total == pytest.approx(min(costs.values()), rel=1e-12)
        assert costs[found] == pytest.approx(path.total, rel=1e-12)
        assert all(allowed[a, b - a - 1] for a, b in itertools.pairwise(found))
        ends["solved"] += 1
    assert ends["solved"] >= 9
    assert ends["infeasible"] or what in [(), ("smoothness",)]


@pytest.mark.parametrize("what", [what for what in KINDS if "lists" not in what], ids="+".join)
def test_a_step_is_allowed_exactly_where_some_path_of_some_length_may_take_it(what: tuple[str, ...]) -> None:
    rng = np.random.default_rng(len(what))
    checked = 0
    for _ in range(40):
        problem = random_problem(rng, what=what, most=9)
        reduction, wishes = problem.reduction, problem.wishes
        try:
            steps = problem.steps
            locked = locked_spans(reduction, steps, problem.input_end, wishes.locks)
            allowed = allowed_steps(
                reduction, steps.longest, steps=steps, locked=locked, slowest=wishes.slowest, fastest=wishes.fastest
            )
        except OptionError:
            continue
        used = np.zeros_like(allowed)
        counts = set()
        for n_output in range(2, reduction.n_input + 1):
            for path in every_path(reduction.n_input, n_output, problem.steps.longest):
                if literal.obeys(path, reduction, problem.steps, wishes):
                    counts.add(n_output - 1)
                    for a, b in itertools.pairwise(path):
                        used[a, b - a - 1] = True
        assert not (used & ~allowed).any()
        # A step that is allowed and yet in no path leads to a dead end; from the start on, none is left out.
        assert (used == allowed & from_start(allowed) & to_end(allowed)).all()
        fits = {n for n in range(1, reduction.n_input) if steps_fit(allowed[:-1], n)}
        assert fits == counts
        checked += bool(counts)
    assert checked >= 8


def from_start(allowed: np.ndarray) -> np.ndarray:
    reached = np.zeros(len(allowed), dtype=bool)
    reached[0] = True
    for j, b in zip(*np.nonzero(allowed), strict=True):
        if reached[j] and j + b + 1 < len(allowed):
            reached[j + b + 1] = True
    return reached[:, None]


def to_end(allowed: np.ndarray) -> np.ndarray:
    leads = np.zeros_like(allowed)
    ends = np.zeros(len(allowed), dtype=bool)
    ends[-1] = True
    for j in range(len(allowed) - 2, -1, -1):
        for b in range(allowed.shape[1]):
            leads[j, b] = j + b + 1 < len(allowed) and ends[j + b + 1] and allowed[j, b]
        ends[j] = leads[j].any()
    return leads


# The finished curve


def curve(seconds: float, rate: int = 30) -> Signal:
    """A smooth path that is nowhere the same twice."""
    t = np.arange(round(seconds * rate) + 1) / rate
    return Signal(("x", "y"), np.stack([np.sin(t**1.4), 2 * np.cos(1.7 * t)], axis=1), Fraction(rate), name="curve")


SPEEDS = [1.0, 0.5, 0.25, 2.0, 1.5, 1 / 3, 0.37, 1.234, 3.0]


@pytest.mark.parametrize("speed", SPEEDS)
@pytest.mark.parametrize("rate", [30, 50, 120])
def test_a_lock_is_played_at_its_speed_to_the_last_digit(speed: float, rate: int) -> None:
    lock = Lock(1.01, 2.03, speed, speed)
    result = Session(curve(4.0, rate)).solve(length="130%", locks=[lock])
    # From its first moment to its last one, wherever the grid is.
    shown = result.warp.inverse()([lock.start, lock.end])
    assert shown[1] - shown[0] == pytest.approx((lock.end - lock.start) / speed, rel=1e-9)
    inside = np.linspace(*shown, 60)[1:-1]
    np.testing.assert_allclose(result.warp.speed(inside), speed, rtol=1e-9)
    assert result.warp.monotone


@pytest.mark.parametrize("bounds", [(0.0, 1.0), (0.5, 1.0), (0.8, 1.2), (1.0, 2.0)])
def test_a_lock_on_a_range_is_kept_after_smoothing(bounds: tuple[float, float]) -> None:
    lock = Lock(1.0, 2.5, *bounds)
    result = Session(curve(4.0)).solve(length="85%", locks=[lock])
    shown = result.warp.inverse()([lock.start, lock.end])
    speeds = result.warp.speed(np.linspace(*shown, 80)[1:-1])
    assert bounds[0] - 1e-9 <= speeds.min()
    assert speeds.max() <= bounds[1] + 1e-9


@pytest.mark.parametrize("speed", SPEEDS)
def test_a_tangent_is_the_slope_at_its_keytime(speed: float) -> None:
    result = Session(curve(4.0)).solve(keys=[(1.513, 1.797, speed), (4.0, 4.31)])
    beside = result.warp.speed(1.797 + np.array([-0.02, -1e-6, 1e-6, 0.02]))
    np.testing.assert_allclose(beside, speed, rtol=1e-6)
    assert float(result.warp(1.797)) == 1.513


def test_tangents_at_the_ends_in_holds_and_backward() -> None:
    keys = [(0, 0, 0.5), (2, 2.5, 1.5), (2, 3, 2), (1, 3.7, 0.75), (4, 6.1, 0.25)]
    warp = Session(curve(4.0)).solve(keys=keys).warp
    for time, slope in [(0.0, 0.5), (2.4999, 1.5), (2.7, 0), (3.001, -2), (3.6999, -0.75), (3.701, 0.75), (6.09, 0.25)]:
        assert float(warp.speed(time)) == pytest.approx(slope, rel=1e-6)


@pytest.mark.parametrize(
    "limits", [(0.25, 8), (0.5, 2), (0.8, 1.25), (0, 1.5), (0.9, 1.1), (0.9, math.inf), (1 / 3, 3)]
)
@pytest.mark.parametrize("length", ["94%", "100%", "106%"])
def test_speed_limits_in_plain_words(limits: tuple[float, float], length: str) -> None:
    result = Session(curve(6.0)).solve(length=length, speed=limits)
    assert result.warp.slopes.min() >= limits[0] * 0.99
    assert result.warp.slopes.max() <= limits[1] * 1.01
    # They can be used to the full, or nearly.
    assert result.max_skip / result.upsample >= 0.94 * min(limits[1], 1.5)


def test_limits_that_a_length_can_not_meet_are_named() -> None:
    session = Session(curve(4.0))
    with pytest.raises(
        InfeasibleWarpError, match=r"the speed limits allow .* at least .*loosen the speed limits"
    ) as caught:
        session.solve(length="40%", speed=(0.5, 2))
    assert caught.value.min_output is not None
    session.solve(length=f"{caught.value.min_output}f", speed=(0.5, 2))
    with pytest.raises(InfeasibleWarpError, match="at most"):
        session.solve(length="210%", speed=(0.5, 2))


def test_more_smoothness_changes_speed_less() -> None:
    session = Session(curve(6.0), reference=curve(3.0))

    def changes(smoothness: float) -> float:
        steps = np.diff(session.solve(length="70%", smoothness=smoothness).path.frames)
        return float(np.sum(np.diff(np.log(steps)) ** 2))

    found = [changes(weight) for weight in (0, 0.1, 1, 10, 1000)]
    assert found == sorted(found, reverse=True)
    assert found[-1] < 0.2 * found[0]


def test_smoothness_does_not_charge_for_keytimes_that_hold() -> None:
    keys = [
        Keytime(input_time=0, output_time=0),
        Keytime(input_time=1 / 30, output_time=1 / 30),
        Keytime(input_time=1 / 30, output_time=3 / 30),
        Keytime(input_time=2 / 30, output_time=4 / 30),
    ]
    reduction = reduce_to_compression(keys, 2 / 30, rate=30)
    steps = StepPairs.up_to(2)
    costs = np.ones((5, steps.n_pairs))
    add_smoothness(costs, 1.0, reduction, steps)
    scores = costs.reshape(5, 2, 2)
    charged = scores[:, 0, 1] > 1
    # Middle frames into, inside and out of the hold go free.
    assert charged.tolist() == [True, False, False, False, True]
    assert scores[0, 0, 1] == pytest.approx(1 + math.log(2) ** 2)
    assert scores[0, 1, 1] == 1.0


# Feasibility: what is named must be true, and its remedy must work


def refusal(session: Session, **options: object) -> InfeasibleWarpError | None:
    try:
        with warnings.catch_warnings():
            # Times rounded to frames may leave a little less room than locks ask for: that is said.
            warnings.simplefilter("ignore", RetimeWarning)
            session.solve(**options)  # type: ignore[arg-type]
    except InfeasibleWarpError as error:
        return error
    return None


# A length in frames of the clip, or how far apart two keytimes should stand.
REMEDY = re.compile(
    r"(?:Use a length of|Put these keytimes) (?:at least |at most |\S+ (?:\(\S+ s\)|s) or )?([\d.]+)(f| s)"
)


@pytest.mark.parametrize("seed", range(4))
def test_remedies_work(seed: int) -> None:
    rng = np.random.default_rng(seed)
    session = Session(curve(1.0))
    named = Counter()
    for _ in range(40):
        inner = np.sort(rng.uniform(0.2, 0.8, rng.integers(0, 3)))
        lengths = rng.integers(1, 24, len(inner) + 1)
        options = {"max_skip": int(rng.integers(1, 5)), "upsample": int(rng.integers(1, 4))}
        if rng.random() < 0.5:
            start = rng.uniform(0, 0.6)
            options["locks"] = [Lock(start, start + rng.uniform(0.2, 0.4), *np.sort(rng.choice([0.5, 1, 2], 2)))]
        if rng.random() < 0.3:
            options["speed"] = (0, float(rng.choice([1, 2, 3])))

        def keys(lengths: np.ndarray, inner: np.ndarray = inner) -> list[tuple[float, float]]:
            ends = np.cumsum(lengths) / 30
            return [*zip(inner.tolist(), ends.tolist(), strict=False), (1.0, float(ends[-1]))]

        try:
            error = refusal(session, keys=keys(lengths), **options)
        except OptionError:
            continue
        tried = 0
        while error is not None and (match := REMEDY.search(str(error))):
            assert error.span is not None
            assert tried < 5
            last = error.span
            lengths = lengths.copy()
            if skip := re.search(r"max_skip >= (\d+)", str(error)):
                assert refusal(session, keys=keys(lengths), **{**options, "max_skip": int(skip[1])}) is None
                assert refusal(session, keys=keys(lengths), **{**options, "max_skip": int(skip[1]) - 1}) is not None
                named["max_skip"] += 1
            if finer := re.search(r"upsample >= (\d+)(?: with max_skip=(\d+))?", str(error)):
                more = {"upsample": int(finer[1]), "max_skip": int(finer[2] or options["max_skip"])}
                assert refusal(session, keys=keys(lengths), **{**options, **more}) is None
                named["upsample"] += 1
            named["whole" if match[2] == "f" else "apart"] += 1
            lengths[last] = int(match[1]) - 1 if match[2] == "f" else round(float(match[1]) * 30)
            error = refusal(session, keys=keys(lengths), **options)
            # That span is mended; another one may be wrong too.
            assert error is None or error.span is None or error.span > last
            tried += 1
    assert named["whole"] > 2
    assert named["apart"] > 5
    assert named["max_skip"] + named["upsample"] > 5


def test_counts_between_those_that_fit_are_refused_with_both_neighbours() -> None:
    # Locked from end to end at speeds of 1/2 or 2 there is no way through in 30 frames of 31; in between only some.
    session = Session(curve(1.0))
    locks = [Lock(0.0, 0.5, 2.0, 2.0), Lock(0.5, 1.0, 0.5, 0.5)]
    with pytest.raises(InfeasibleWarpError, match="the locks allow"):
        session.solve(length="20f", locks=locks)
    counts = [n for n in range(5, 70) if refusal(session, length=f"{n}f", locks=locks) is None]
    assert counts
    for n in range(counts[0] + 1, counts[-1]):
        if n not in counts:
            error = refusal(session, length=f"{n}f", locks=locks)
            below, above = max(c for c in counts if c < n), min(c for c in counts if c > n)
            assert f"Use a length of {below}f ({below / 30:.3f} s) or {above}f ({above / 30:.3f} s)" in str(error)


def test_no_way_through_names_who_is_to_blame() -> None:
    session = Session(curve(2.0))
    with pytest.raises(InfeasibleWarpError, match=r"the locks and the tangents leave no way through"):
        session.solve(locks=[Lock(0.5, 1.5)], keys=[(1.0, 1.0, 2.0)])
    with pytest.raises(InfeasibleWarpError, match=r"the locks leave no way through"):
        session.solve(locks=[Lock(0.5, 1.5), Lock(0.7, 1.0, 2.0, 2.0)])
