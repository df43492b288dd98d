"""Why a warp is as it is: the table, the matches, the costs, and what was binding, each against its meaning."""

from __future__ import annotations

import csv
import io
import itertools
import math
import sys
from collections.abc import Sequence
from fractions import Fraction

import numpy as np
import pytest

from retime.errors import MissingExtraError
from retime.motion.signal import Signal
from retime.search.explain import Explanation
from retime.search.guided import guided_warp
from retime.search.poses.references import Reference
from retime.search.poses.spaces import PoseOptions
from retime.search.score import triple_scores
from retime.search.session import GuidedWarp
from retime.search.wishes.locks import Lock
from tests.reference import scores as literal
from tests.reference import wishes

# Poses are then the values of the signal, at its own frames: nothing stands between them and the literal scores.
PLAIN = {"features": PoseOptions(scale_signals=False), "low_pass": 0.0}
# Sums of squares round otherwise than exact fractions; times are written with six decimals.
SAME = {"rel": 1e-9, "abs": 1e-12}


def curve(n_frames: int, seed: int = 0, name: str = "curve") -> Signal:
    """Smooth, and nowhere the same twice."""
    rng = np.random.default_rng(seed)
    t = np.arange(n_frames)[:, None] / 30
    values = np.sin(t * rng.uniform(1, 4, 3) + rng.uniform(0, 6, 3)) + 0.4 * t * rng.uniform(-1, 1, 3)
    return Signal(("x", "y", "z"), values, Fraction(30), name=name)


def cycle(n_frames: int, seed: int = 0) -> Signal:
    rng = np.random.default_rng(seed)
    phase = 2 * np.pi * np.arange(n_frames)[:, None] / (n_frames - 1)
    return Signal(("x", "y"), np.sin(phase + rng.uniform(0, 6, 2)), Fraction(30), name="cycle")


def table(explained: Explanation) -> list[dict[str, str]]:
    return list(csv.DictReader(io.StringIO(explained.to_csv())))


def test_the_table_says_what_the_result_says() -> None:
    rivals = [Reference(curve(40, 7, "slow, by hand")), Reference(curve(40, 8, "fast"), weight=2.0)]
    result = guided_warp(
        curve(120),
        reference=rivals,
        length="5s",
        keys=[(1.0, 1.0), (1.0, 1.5), (2.0, 2.5, 0.5)],
        locks=[Lock(2.5, 3.0)],
    )
    rows = table(result.explain())
    path, reduction = result.path.frames, result.reduction
    assert len(rows) == result.n_output
    assert list(rows[0]) == [
        "output_time", "input_time", "speed", "score", "cost",
        "tempo_cost", "reference_1", "reference_time_1", "reference_2", "reference_time_2", "reference_3",
        "reference_time_3", "binding",
    ]  # fmt: skip
    shown = reduction.input_times[path]
    for i, row in enumerate(rows):
        assert float(row["output_time"]) == pytest.approx(i / 30, abs=1e-6)
        assert float(row["input_time"]) == pytest.approx(shown[i], abs=1e-6)
        after = min(i, len(path) - 2)
        assert float(row["speed"]) == pytest.approx((shown[after + 1] - shown[after]) * 30, abs=1e-5)
    # A keytime's pose is in the row of its output time.
    for into, out in ((1.0, 1.0), (1.0, 1.5), (2.0, 2.5)):
        assert float(rows[round(out * 30)]["input_time"]) == pytest.approx(into, abs=1e-6)
    every = triple_scores(result.input_poses, result.model, max_skip=result.max_skip)
    for i, (a, j, b) in enumerate(zip(path, path[1:], path[2:], strict=False), start=1):
        assert float(rows[i]["score"]) == pytest.approx(every[j, j - a - 1, b - j - 1], rel=1e-5)
        assert float(rows[i]["cost"]) == pytest.approx(result.path.scores[i - 1], rel=1e-5)
        assert {rows[i][f"reference_{k}"] for k in (1, 2, 3)} <= {"slow, by hand", "fast"}
        assert all(0 < float(rows[i][f"reference_time_{k}"]) < 39 / 30 for k in (1, 2, 3))
    for end in (rows[0], rows[-1]):
        assert {end[name] for name in end if name.startswith(("score", "cost", "reference"))} == {""}
    assert {word for row in rows for word in row["binding"].split("+")} >= {"key", "tangent", "hold", "lock"}


@pytest.mark.parametrize("score", ["joint", "conditional"])
@pytest.mark.parametrize("n_neighbors", [1, 3])
def test_matched_frames_are_the_nearest_of_a_literal_search(score: str, n_neighbors: int) -> None:
    weights = [1.0, 2.5]
    for seed in range(3):
        clip, references = curve(14, seed), [curve(9, seed + 20, "first"), curve(7, seed + 40, "second")]
        result = guided_warp(
            clip,
            reference=[Reference(one, weight=w) for one, w in zip(references, weights, strict=True)],
            length="10f",
            upsample=1,
            max_skip=4,
            n_neighbors=n_neighbors,
            score=score,
            **PLAIN,
        )
        explained = result.explain()
        tau, rate = Fraction(result.time_scale), Fraction(30)
        # Every inner frame of every reference: whose it is, its time there, its pose, its movement, its weight.
        frames = []
        for which, (one, weight) in enumerate(zip(references, weights, strict=True)):
            z = literal.exact(one.values)
            for t in range(1, len(z) - 1):
                move = literal.velocity(z[t - 1], z[t + 1], rate, tau) + literal.acceleration(
                    *z[t - 1 : t + 2], rate, tau
                )
                frames.append((which, t / 30, z[t], move, weight))
        y = literal.exact(clip.values)
        for place in range(1, result.n_output - 1):
            i, j, k = (int(f) for f in result.path.frames[place - 1 : place + 2])
            move = literal.velocity(y[i], y[k], rate, tau) + literal.acceleration(y[i], y[j], y[k], rate, tau)
            if score == "joint":
                near = sorted((literal.distance(y[j] + move, f[2] + f[3]) / f[4], n) for n, f in enumerate(frames))
            else:
                poses = literal.nearest_in_pose(
                    y[j], [f[2] for f in frames], [Fraction(f[4]) for f in frames], n_neighbors
                )
                near = sorted((literal.distance(move, frames[n][3]), n) for n in poses)
            wanted = near[:n_neighbors]
            assert explained.references[place].tolist() == [frames[n][0] for _, n in wanted]
            np.testing.assert_allclose(explained.reference_times[place], [frames[n][1] for _, n in wanted], atol=1e-12)
            assert explained.scores[place] == pytest.approx(sum(d for d, _ in wanted) / n_neighbors, **SAME)


def words_at(explained: Explanation) -> list[set[str]]:
    return [set(words.split("+")) - {""} for words in explained.binding]


def beside(n_output: int, steps: Sequence[int]) -> set[int]:
    """Frames at either end of these steps."""
    return {frame for step in steps for frame in (step, step + 1) if frame < n_output}


def where(explained: Explanation, word: str) -> set[int]:
    return {i for i, words in enumerate(words_at(explained)) if word in words}


def test_nothing_binds_but_the_keytimes_where_all_is_at_ease() -> None:
    explained = guided_warp(curve(91), keys=[(1.0, 1.0)]).explain()
    assert where(explained, "key") == {0, 30, 90}
    assert set(explained.binding) == {"key", ""}


def test_a_key_is_named_at_its_frame_alone() -> None:
    result = guided_warp(curve(150), length="70%", keys=[(1.0, 0.8), (3.0, 2.5)])
    assert where(result.explain(), "key") == set(result.reduction.positions) == {0, 24, 75, result.n_output - 1}


def test_a_tangent_is_named_at_the_steps_beside_its_key() -> None:
    explained = guided_warp(curve(150), length="80%", keys=[(2.0, 1.5, 2.0)]).explain()
    assert where(explained, "tangent") == {44, 45, 46}
    assert explained.binding[45] == "key+tangent"
    assert explained.speeds[[44, 45]].tolist() == pytest.approx([2.0, 2.0])


def test_a_hold_is_named_from_its_first_frame_to_its_last() -> None:
    explained = guided_warp(curve(91), keys=[(1.0, 1.0), (1.0, 1.5)]).explain()
    assert where(explained, "hold") == set(range(30, 46))
    assert (explained.speeds[30:45] == 0).all()


def test_a_lock_is_named_where_it_decides_and_nowhere_else() -> None:
    result = guided_warp(curve(150), length="120%", locks=[Lock(2.0, 3.0, 1.5, 1.5)], upsample=2)
    explained = result.explain()
    (span,) = result.plan.locked
    inside = [
        i for i, (a, b) in enumerate(itertools.pairwise(result.path.frames)) if span.first <= a and b <= span.last
    ]
    assert len(inside) == 20
    assert beside(result.n_output, inside) <= where(explained, "lock")
    assert explained.speeds[inside] == pytest.approx(np.full(20, 1.5))
    # The step that ends at a lock may be cut short by it; any other has nothing to do with it.
    assert where(explained, "lock") <= beside(result.n_output, [inside[0] - 1, *inside])


def test_a_range_of_speeds_is_named_where_its_ends_are_reached() -> None:
    # Kept from being cut, the stretch would be played faster: the rest is.
    result = guided_warp(curve(150), length="70%", locks=[Lock(1.0, 4.0, 0.0, 1.0)])
    explained = result.explain()
    (span,) = result.plan.locked
    inside = [
        i for i, (a, b) in enumerate(itertools.pairwise(result.path.frames)) if span.first <= a and b <= span.last
    ]
    at_the_end = [i for i in inside if explained.speeds[i] == pytest.approx(1.0)]
    assert len(at_the_end) >= 80
    assert beside(result.n_output, at_the_end) <= where(explained, "lock")
    assert not where(explained, "slowest")


@pytest.mark.parametrize(
    ("options", "fastest"),
    [({"length": "55%", "max_skip": 2}, 2.0), ({"length": "55%", "speed": (0.5, 2)}, 2.0), ({"length": "30%"}, 8.0)],
    ids=["max_skip", "speed", "default"],
)
def test_fastest_is_named_at_the_longest_steps_and_nowhere_else(options: dict[str, object], fastest: float) -> None:
    result = guided_warp(curve(150), **options)  # type: ignore[arg-type]
    explained = result.explain()
    steps = np.flatnonzero(np.isclose(explained.speeds[:-1], fastest)).tolist()
    assert steps
    assert where(explained, "fastest") == beside(result.n_output, steps)


@pytest.mark.parametrize(
    ("options", "slowest"),
    [
        ({"length": "190%", "upsample": 2}, 0.5),
        ({"length": "190%", "speed": (0.5, 2)}, 0.5),
        ({"length": "95%", "speed": (0.75, 4), "upsample": 4}, 0.75),
    ],
    ids=["upsample", "speed", "between"],
)
def test_slowest_is_named_at_the_shortest_steps_and_nowhere_else(options: dict[str, object], slowest: float) -> None:
    result = guided_warp(curve(150), reference=curve(100, 3), **options)  # type: ignore[arg-type]
    explained = result.explain()
    steps = np.flatnonzero(np.isclose(explained.speeds[:-1], slowest)).tolist()
    assert steps
    assert where(explained, "slowest") == beside(result.n_output, steps)


def test_without_upsampling_unit_speed_is_no_limit() -> None:
    result = guided_warp(curve(150), length="70%")
    assert result.upsample == 1
    assert not where(result.explain(), "slowest")


def test_spans_of_different_upsampling_have_limits_of_their_own() -> None:
    result = guided_warp(
        curve(150, 1), reference=curve(90, 9), keys=[(1.0, 2.0), (3.0, 3.0)], speed=(0, 3), smoothing=0
    )
    fine, coarse, last = result.reduction.upsamples
    assert fine > coarse
    assert fine == last
    explained, path = result.explain(), result.path.frames
    # The table's times are those of the finer or coarser grid; its speeds are what they show.
    np.testing.assert_allclose(explained.input_times, result.reduction.input_times[path])
    np.testing.assert_allclose(explained.speeds[:-1], np.diff(explained.input_times) * 30)
    step, span = np.diff(path), np.searchsorted(result.reduction.positions, np.arange(len(path) - 1), side="right") - 1
    upsample = np.array(result.reduction.upsamples)[span]
    most = np.minimum(result.max_skip, np.floor(3 * upsample + 1e-9))
    held_by_key = {p + side for p in result.reduction.positions for side in (-1, 0)}
    free = [i for i in range(len(step)) if i not in held_by_key]
    words = words_at(explained)
    for i in free:
        for word, here in (("slowest", 1), ("fastest", most[i])):
            if step[i] == here:
                assert word in words[i]
                assert word in words[i + 1]
        if i + 1 in free and 1 < step[i] < most[i] and 1 < step[i + 1] < most[i + 1]:
            assert not words[i + 1] & {"slowest", "fastest"}


def scores_of(result: GuidedWarp) -> np.ndarray:
    return triple_scores(
        result.input_poses, result.model, max_skip=result.max_skip, n_neighbors=result.n_neighbors, score=result.score
    )


@pytest.mark.parametrize("score", ["joint", "conditional"])
@pytest.mark.parametrize(
    "options",
    [
        {"length": "70%"},
        {"length": "70%", "smoothness": 0.7},
        {"length": "free", "free_weight": "sum"},
        {"length": "free"},
        {"length": "free", "smoothness": 0.7, "keys": [(1.0, 1.2), (1.0, 1.5), (0.5, 2.0)]},
        {"length": "80%", "search": "heuristic"},
    ],
    ids=str,
)
def test_costs_add_up_to_the_total_and_say_what_was_paid_beyond_the_score(
    options: dict[str, object], score: str
) -> None:
    result = guided_warp(curve(61, 2), reference=curve(50, 5), score=score, **options)  # type: ignore[arg-type]
    explained = result.explain()
    assert explained.seam_cost == 0
    assert math.fsum(explained.costs[1:-1]) == pytest.approx(result.total, **SAME)
    assert np.isnan(explained.costs[[0, -1]]).all()
    neutral = options["length"] == "free" and "free_weight" not in options
    smoothness = float(options.get("smoothness", 0.0))  # type: ignore[arg-type]
    path, table = result.path.frames.tolist(), scores_of(result)
    for place in range(1, len(path) - 1):
        i, j, k = path[place - 1 : place + 2]
        assert explained.scores[place] == pytest.approx(table[j, j - i - 1, k - j - 1], **SAME)
        paid = wishes.cost((i, j, k), table, result.reduction, smoothness=smoothness, neutral=neutral)
        assert explained.costs[place] == pytest.approx(paid, **SAME)


@pytest.mark.parametrize("length", ["80%", "free"])
def test_the_seam_of_a_loop_costs_what_its_three_frames_score(length: str) -> None:
    clip, reference = cycle(31), curve(40, 4)
    reference = Signal(("x", "y"), reference.values[:, :2], Fraction(30), name="other")
    result = guided_warp(clip, reference=reference, length=length, loop=True, upsample=1, max_skip=3, **PLAIN)
    explained = result.explain()
    step = int(result.path.frames[1])
    assert step == int(np.diff(result.path.frames)[-1])
    # The last frame is the first one again: before it comes the one a step earlier, after it the one a step on.
    around = clip.values[[-1 - step, 0, step]]
    found = literal.scores(
        "joint", around, reference.values, max_skip=1, rate=30, time_scale=result.time_scale, n_neighbors=3
    )[1, 0, 0]
    weight = math.sqrt(step) if length == "free" else 1.0
    assert explained.seam_cost == pytest.approx(found * weight, rel=1e-9)
    assert explained.seam_cost + math.fsum(explained.costs[1:-1]) == pytest.approx(result.total, rel=1e-12)


def test_two_frames_have_nothing_to_explain_but_their_keytimes() -> None:
    explained = guided_warp(curve(8), length="2f", reference=curve(20, 3)).explain()
    assert explained.binding[0].startswith("key")
    assert explained.binding[1].startswith("key")
    assert np.isnan(explained.scores).all()
    assert len(table(explained)) == 2


def test_a_pandas_table_says_what_the_csv_says() -> None:
    pd = pytest.importorskip("pandas", reason="needs the extra pandas")
    clip = Signal(("x",), np.sin(np.arange(90) ** 1.5 / 40)[:, None], Fraction(30))
    why = guided_warp(clip, length="70%", keys=[(1.0, 0.8)]).explain()
    table = why.to_frame()
    written = pd.read_csv(io.StringIO(why.to_csv()), keep_default_na=True)
    assert list(table.columns) == list(written.columns)
    for name in table.columns:
        if name == "binding" or (name.startswith("reference_") and "time" not in name):
            assert table[name].tolist() == written[name].fillna("").tolist()
        else:
            np.testing.assert_allclose(table[name].to_numpy(float), written[name].to_numpy(float), rtol=1e-4, atol=1e-6)


def test_a_table_without_pandas_names_the_extra(monkeypatch) -> None:
    why = guided_warp(np.sin(np.arange(60) / 9), rate=30, length="80%").explain()
    monkeypatch.setitem(sys.modules, "pandas", None)
    with pytest.raises(MissingExtraError, match=r"pip install 'retime\[pandas\]'"):
        why.to_frame()
