"""The panel of reasons shows what the explanation says."""

from __future__ import annotations

import itertools
from pathlib import Path

import numpy as np
import pytest

from retime import Warp, guided_warp, plot_warps
from retime.evaluate.plot.reasons import binding_intervals, lanes_of
from retime.search.explain import Explanation
from retime.search.wishes.locks import Lock
from tests.evaluate.figures import ramp

pytest.importorskip("matplotlib")


def explanation_of(binding: list[str], scores: list[float]) -> Explanation:
    """Make an explanation at 10 Hz."""
    times = np.arange(len(binding)) / 10
    blank = np.zeros((len(binding), 1))
    return Explanation(
        times, times, np.ones(len(times)), np.array(scores), np.array(scores), np.zeros(len(times)),
        blank.astype(int), blank, tuple(binding), ("x",),
    )  # fmt: skip


BINDING = ["key", "fastest", "fastest", "", "key+hold", "hold", "lock", "", "fastest", "key+fastest"]
SCORES = [np.nan, 1.0, 4.0, 2.0, 0.0, 0.0, 1.0, 1.0, 3.0, np.nan]
EXPLANATION = explanation_of(BINDING, SCORES)
WARP = Warp([0.0, 0.9], [0.0, 1.8], method="guided")


def axes_of(figure, label: str):
    (found,) = [axes for axes in figure.axes if axes.get_label() == label]
    return found


def bars(axes, label: str) -> list[tuple[float, float]]:
    """Start and stop of each bar of a lane."""
    (lane,) = [drawn for drawn in axes.collections if drawn.get_label() == label]
    boxes = [path.get_extents() for path in lane.get_paths()]
    return [(box.x0, box.x1) for box in boxes]


def test_each_thing_that_bound_has_a_lane_with_its_frames() -> None:
    axes = axes_of(plot_warps([WARP], explanation=EXPLANATION), "reasons")
    assert [tick.get_text() for tick in axes.get_yticklabels()] == ["score", "key", "lock", "hold", "fastest"]
    np.testing.assert_allclose(bars(axes, "fastest"), [(0.05, 0.25), (0.75, 0.9)])
    np.testing.assert_allclose(bars(axes, "hold"), [(0.35, 0.55)])
    np.testing.assert_allclose(bars(axes, "lock"), [(0.55, 0.65)])
    (keys,) = [line for line in axes.lines if line.get_label() == "key"]
    np.testing.assert_allclose(keys.get_xdata(), [0.0, 0.4, 0.9])


def test_lanes_do_not_touch_and_scores_lie_above_them() -> None:
    axes = axes_of(plot_warps([WARP], explanation=EXPLANATION), "reasons")
    spans = [lane.get_paths()[0].get_extents() for lane in axes.collections]
    assert all(below.y1 < above.y0 for above, below in itertools.pairwise(spans))
    assert max(box.y1 for box in spans) < axes.images[0].get_extent()[2]


def test_heat_is_the_scores_from_zero_to_the_worst_at_their_times() -> None:
    axes = axes_of(plot_warps([WARP], explanation=EXPLANATION), "reasons")
    (heat,) = axes.images
    np.testing.assert_array_equal(np.ma.filled(heat.get_array()[0], np.nan), SCORES)
    assert heat.get_clim() == (0.0, 4.0)
    np.testing.assert_allclose(heat.get_extent()[:2], [-0.05, 0.95])


def test_reasons_stand_under_the_speeds_and_share_their_axis_of_time() -> None:
    plain, figure = plot_warps([WARP]), plot_warps([WARP], explanation=EXPLANATION)
    speed, reasons, time_map = (axes_of(figure, label) for label in ("speed", "reasons", "map"))
    assert reasons.get_xlim() == speed.get_xlim()
    upper, lower = speed.get_position(), reasons.get_position()
    assert (upper.x0, upper.x1) == pytest.approx((lower.x0, lower.x1))
    assert lower.y1 < upper.y0
    assert time_map.get_position().y0 == pytest.approx(lower.y0)
    assert (speed.get_xlabel(), reasons.get_xlabel()) == ("", "output time (s)")
    assert [axes.get_label() for axes in plain.axes] == ["speed", "map"]
    assert figure.get_figheight() > plain.get_figheight()


def test_nothing_binding_and_no_scores_draw_too() -> None:
    two = explanation_of(["", ""], [np.nan, np.nan])
    assert lanes_of(two) == []
    axes = axes_of(plot_warps([Warp([0.0, 0.1], [0.0, 0.2])], explanation=two), "reasons")
    assert [tick.get_text() for tick in axes.get_yticklabels()] == ["score"]
    assert axes.images[0].get_clim() == (0.0, 1.0)


def test_a_search_with_keys_a_hold_and_a_lock_shows_them_and_writes_the_same_bytes(tmp_path: Path) -> None:
    signal = ramp()
    result = guided_warp(signal, length="240f", keys=[(1.0, 0.8), (1.0, 1.1)], locks=[Lock(2.0, 2.5, 0.5, 0.5)])
    explanation = result.explain()
    assert {"key", "hold", "lock"} <= set(lanes_of(explanation))
    ((start, stop),) = binding_intervals(explanation, "hold")
    assert start < 0.8 < 1.1 < stop < 1.2
    for suffix in (".svg", ".png"):
        for name in ("one", "two"):
            plot_warps([result.warp], motion=signal, explanation=explanation, path=tmp_path / f"{name}{suffix}")
        assert (tmp_path / f"one{suffix}").read_bytes() == (tmp_path / f"two{suffix}").read_bytes()
