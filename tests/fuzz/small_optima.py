"""Small searches against every path that there is: what is found costs as little as any, and is refused where none is.

    python -m tests.fuzz.small_optima --count 100000

In turn: wishes of every kind on scores that are drawn, each solved by both exact searches; and clips of a few frames
whose length is free, or given, with natural hurry, that are loops, or are aligned with another clip. What a path
costs is added up by the literal twins in `tests/reference`.
"""

from __future__ import annotations

import itertools
import math
import random
import sys
import warnings
from typing import Any

import numpy as np

from retime.errors import InfeasibleWarpError, OptionError
from retime.kernels import BACKENDS, StepPairs, backend, compiled_available
from retime.motion.signal import Signal
from retime.search.align import AlignSession
from retime.search.path import SEARCHES
from retime.search.result import GuidedWarp
from retime.search.session import Session
from retime.search.wishes.locks import Lock
from tests.fuzz.trials import command_apart
from tests.reference import wishes as literal
from tests.reference.wishes import Wishes
from tests.search.test_align import totals
from tests.search.test_session import curve, cycle, least
from tests.search.wishes.test_control import KINDS, random_problem, solved

_CLOSE = 1e-9
# Each frame doubles the number of paths. Where the search takes a finer grid than was asked for, there may be too many.
_MOST_FRAMES = 11
_TOO_MANY = "too many paths to try"


def _is_least(found: float, wanted: float, what: str) -> None:
    assert math.isfinite(wanted), f"{what}: a path was found, and there is none"
    assert abs(found - wanted) <= _CLOSE * max(1.0, abs(wanted)), f"{what}: {found} was found, the least is {wanted}"


def control(rng: np.random.Generator) -> str:
    """Locks, tangents, limits, smoothness and lists of steps, on random scores."""
    what = KINDS[rng.integers(len(KINDS))]
    problem = random_problem(rng, what=what, most=9)
    kernels = backend(str(rng.choice(BACKENDS if compiled_available() else ["numpy"])))
    every = list(literal.paths(problem.reduction, problem.steps, problem.wishes, [problem.reduction.n_output]))
    ends = set()
    for search in SEARCHES:
        try:
            path, _ = solved(problem, kernels, search)
        except OptionError:
            ends.add("wishes are refused")
            continue
        except InfeasibleWarpError:
            assert not every, f"{search} found no path, and there are {len(every)}"
            ends.add("wishes that no path obeys")
            continue
        costs = {
            one: literal.cost(one, problem.scores, problem.reduction, smoothness=problem.smoothness) for one in every
        }
        assert tuple(path.frames.tolist()) in costs, "the path breaks a wish"
        _is_least(path.total, min(costs.values()), search)
        _is_least(costs[tuple(path.frames.tolist())], path.total, f"{search}, added up again")
        ends.add(f"wishes are obeyed: {'+'.join(what) or 'none'}")
    assert len(ends) == 1, ends
    return ends.pop()


def _clips(rng: np.random.Generator, *, loop: bool = False) -> tuple[Signal, Signal]:
    clip = (cycle if loop else curve)(int(rng.integers(4 if loop else 3, 7)), seed=int(rng.integers(1 << 30)))
    if rng.random() < 0.2:
        # Frames that repeat: ties.
        clip = clip.at(np.sort(rng.choice(clip.n_frames, clip.n_frames)) / 30)
    return clip, curve(int(rng.integers(5, 9)), seed=int(rng.integers(1 << 30)))


def _key(rng: np.random.Generator, clip: Signal) -> list[tuple[float, float]]:
    return [
        (int(rng.integers(1, clip.n_frames)) / 30, int(rng.integers(1, clip.n_frames + 2)) / 30)
        for _ in range(rng.choice([0, 0, 1]))
    ]


def lengths(rng: np.random.Generator, *, loop: bool) -> str:
    """Lengths that are free, with bounds or none, or given; of a loop or not."""
    clip, reference = _clips(rng, loop=loop)
    score = str(rng.choice(["joint", "conditional"]))
    asked: dict[str, Any] = {"loop": True} if loop else {}
    upsample, max_skip = int(rng.integers(1, 3)), int(rng.integers(2, 5))
    n_input = (clip.n_frames - 1) * upsample + 1
    free = rng.random() < 0.6
    neutral = free and rng.random() < 0.5
    wanted = range(2, 2 * n_input)
    if free:
        low, high = np.sort(rng.integers(2, n_input + 2, 2)).tolist()
        asked |= {"length": "free", "free_weight": "neutral" if neutral else "sum"}
        if rng.random() < 0.4:
            asked |= {"min_length": f"{low}f", "max_length": f"{high}f"}
            wanted = range(low, high + 1)
    else:
        n_output = int(rng.integers(2, n_input + 1))
        asked["length"] = f"{n_output}f"
        wanted = range(n_output, n_output + 1)
    session = Session(clip, reference=reference, score=score, n_neighbors=int(rng.integers(1, 4)))
    keys = _key(rng, clip)
    try:
        result = session.solve(keys=keys, upsample=upsample, max_skip=max_skip, **asked)
    except (OptionError, InfeasibleWarpError) as error:
        return f"a {'loop' if loop else 'length'} is refused: {type(error).__name__}"
    if result.n_input > _MOST_FRAMES:
        return _TOO_MANY
    _is_least(result.total, least(result, wanted, neutral=neutral, loop=loop), str(asked))
    assert result.path.optimal
    return f"{'a loop' if loop else 'a length'} is {'free' if free else 'given'}"


def hurry(rng: np.random.Generator) -> str:
    """Natural hurry: scores and prices together."""
    n_frames = int(rng.integers(3, 7))
    moving = rng.random(n_frames) < 0.7
    clip = Signal(("x", "y"), np.cumsum(rng.normal(size=(n_frames, 2)) * moving[:, None], axis=0), 30)  # type: ignore[arg-type]
    flights = [(1 / 30, 2 / 30)] if rng.random() < 0.5 else []
    session = Session(clip, flights=flights, low_pass=0, n_neighbors=int(rng.integers(1, 3)))
    asked, wishes = _wishes(rng, clip)
    try:
        found = session.solve(
            length=f"{rng.integers(2, 2 * n_frames)}f",
            evenness=float(rng.choice([0.5, 4.0])),
            keep_flights=float(rng.choice([0.0, 24.0])),
            upsample=int(rng.integers(1, 3)),
            **asked,
        )
    except (OptionError, InfeasibleWarpError) as error:
        return f"natural hurry is refused: {type(error).__name__}"
    if found.n_input > _MOST_FRAMES:
        return _TOO_MANY
    prices, plan = found.tempo_prices, found.plan
    every = StepPairs.of(plan.steps.steps)
    scores = session._triples(found.input_poses, every, session._model)
    places = {int(step): place for place, step in enumerate(every.steps)}
    costs = {}
    for path in literal.paths(found.reduction, every, wishes, [found.reduction.n_output]):
        cost = 0.0 if prices is None else float(prices[0, places[path[1]]])
        for (i, j), (_, k) in itertools.pairwise(itertools.pairwise(path)):
            near = literal.follows(plan.steps, j - i, k - j) or j in plan.loose
            pair = int(every.pair_of(np.array(j - i), np.array(k - j)))
            cost += float(scores[j, pair]) + (0.0 if prices is None else prices[j, places[k - j]]) if near else math.inf
        costs[path] = cost
    assert tuple(found.path.frames.tolist()) in costs, "the path breaks a wish"
    _is_least(found.total, min(costs.values()), "natural hurry")
    return "natural hurry"


def _wishes(rng: np.random.Generator, clip: Signal) -> tuple[dict[str, Any], Wishes]:
    """Ask for a lock, limits, a key or nothing."""
    what = rng.integers(4)
    start, end = np.sort(rng.choice(clip.n_frames, 2, replace=False)) / 30
    if what == 0:
        lock = Lock(float(start), float(end), *[(1.0, 1.0), (0.5, 1.0), (2.0, 2.0)][rng.integers(3)])
        return {"locks": [lock]}, Wishes(locks=[lock])
    if what == 1:
        return {"speed": (0.5, 2.0)}, Wishes(slowest=0.5, fastest=2.0)
    return ({"keys": _key(rng, clip)} if what == 2 else {}), Wishes()


def aligned(rng: np.random.Generator) -> str:
    """Keeping step with another clip."""
    clip, reference = _clips(rng)
    session = AlignSession(clip, reference, low_pass=0)
    asked, wishes = _wishes(rng, clip)
    limits = {} if "speed" in asked else {"upsample": int(rng.integers(1, 3)), "max_skip": int(rng.integers(2, 5))}
    try:
        result: GuidedWarp = session.solve(**(limits | asked))
    except (OptionError, InfeasibleWarpError) as error:
        return f"an alignment is refused: {type(error).__name__}"
    if result.n_input > _MOST_FRAMES:
        return _TOO_MANY
    costs = totals(result, session._reference_tracks[0].at(np.arange(reference.n_frames) / 30, 0), wishes)
    assert tuple(result.path.frames.tolist()) in costs, "the path breaks a wish"
    _is_least(result.total, min(costs.values()), "aligned")
    return "aligned"


def trial(draw: random.Random) -> str:
    """Make a problem of one kind, solve it, and try every path."""
    rng = np.random.default_rng(draw.randrange(2**63))
    kind = draw.randrange(10)
    if kind < 4:
        return control(rng)
    if kind < 8:
        return lengths(rng, loop=kind >= 6)
    return hurry(rng) if kind == 8 else aligned(rng)


if __name__ == "__main__":
    warnings.simplefilter("ignore")
    sys.exit(command_apart(trial, __doc__, name="small optima"))
