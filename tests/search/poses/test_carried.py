"""What moves as one, a camera or a prop: its own path and turn are its pose."""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction

import numpy as np
import pytest

import retime
from retime.errors import OptionError, RetimeWarning
from retime.motion import rotation
from retime.motion.body import is_rigid
from retime.motion.motion import Motion
from retime.motion.signal import Signal
from retime.motion.skeleton import Skeleton
from retime.search.poses.references import Reference
from tests.motion.walkers import walker

# Moves for two seconds, stands for one and a half, moves on.
T = np.arange(150) / 30
MOVED = np.interp(T, [0, 2, 3.5, 5], [0, 1, 1, 2])


def camera(path: np.ndarray, turn: np.ndarray, n_more: int = 0) -> Motion:
    """One joint, or several that are screwed together."""
    skeleton = Skeleton(
        ("Camera", *(f"part {i}" for i in range(n_more))), (-1, *range(n_more)), np.full((1 + n_more, 3), 0.3)
    )
    q = rotation.identity(len(turn), 1 + n_more)
    q[:, 0] = rotation.about_axis(1, turn)
    p = np.broadcast_to(skeleton.offsets, (len(turn), 1 + n_more, 3)).copy()
    p[:, 0] = path
    return Motion(skeleton, q, p, Fraction(30), name="camera")


def sliding(values: np.ndarray) -> np.ndarray:
    return np.stack([values * 40, np.full_like(values, 1.5), values * 10], axis=1)


def spans(warp: retime.Warp) -> np.ndarray:
    """Output seconds of the three parts."""
    return np.diff(np.interp([0, 2, 3.5, 5], warp.input_times, warp.output_times))


@pytest.mark.parametrize("n_more", [0, 3])
@pytest.mark.parametrize(
    "moves",
    [(sliding(MOVED), MOVED * 0), (sliding(MOVED * 0), MOVED), (sliding(MOVED), MOVED)],
    ids=["slides", "turns", "both"],
)
def test_the_pause_gives_way(moves: tuple[np.ndarray, np.ndarray], n_more: int) -> None:
    motion = camera(*moves, n_more)
    assert is_rigid(motion)
    # 1.5 seconds are to go, as many as the pause has; the moves keep nearly all of their time.
    before, pause, after = spans(retime.guided_warp(motion, length="70%").warp)
    assert before / 2 > 0.85
    assert pause / 1.5 < 0.5
    assert after / 1.5 > 0.75


def test_it_is_retimed_as_the_same_path_in_a_table() -> None:
    path = sliding(MOVED)
    table = Signal(("x", "y", "z"), path, Fraction(30))
    found = spans(retime.guided_warp(camera(path, MOVED * 0), length="70%").warp)
    np.testing.assert_allclose(found, spans(retime.guided_warp(table, length="70%").warp), atol=1 / 30)


def test_units_and_place_change_nothing() -> None:
    one = camera(sliding(MOVED), MOVED)
    other = camera(sliding(MOVED) * 1000 + [5e5, -3e4, 0], MOVED)
    np.testing.assert_allclose(
        spans(retime.guided_warp(one, length="70%").warp),
        spans(retime.guided_warp(other, length="70%").warp),
        atol=1e-6,
    )


def test_a_group_of_a_figure_and_a_camera() -> None:
    figure = walker(150)
    warp = retime.guided_warp([replace(figure, rate=Fraction(30)), camera(sliding(MOVED), MOVED)], length="90%").warp
    assert warp.output_times[-1] == pytest.approx(warp.input_times[-1] * 0.9, abs=0.05)


def test_one_camera_moves_like_another() -> None:
    slow = camera(sliding(MOVED), MOVED)
    fast = replace(camera(sliding(MOVED)[::2], MOVED[::2]), name="fast")
    warp = retime.guided_warp(slow, reference=fast, length="50%").warp
    assert warp.output_times[-1] == pytest.approx(2.5, abs=0.05)
    with pytest.raises(OptionError, match="has no left and right"):
        retime.guided_warp(slow, reference=Reference(fast, mirror=True), length="50%")


class TestNothingChanges:
    @pytest.mark.parametrize("kind", ["camera", "figure", "table"])
    def test_it_is_said(self, kind: str) -> None:
        clip = {
            "camera": camera(sliding(MOVED * 0), MOVED * 0),
            "figure": replace(walker(1).at(np.zeros(60)), rate=Fraction(30), name="figure"),
            "table": Signal(("a", "b"), np.full((60, 2), 0.1), Fraction(30), name="table"),
        }[kind]
        with pytest.warns(RetimeWarning, match=f"{kind}: nothing changes in what the search looks at"):
            retime.guided_warp(clip, length="80%")

    def test_a_space_in_which_a_camera_stands_still_is_said(self) -> None:
        with pytest.warns(RetimeWarning, match="camera: nothing changes"):
            retime.guided_warp(camera(sliding(MOVED), MOVED), features="heading", length="80%")

    def test_of_a_group_the_clip_is_named(self) -> None:
        still = replace(camera(sliding(MOVED * 0), MOVED * 0), name="tripod")
        with pytest.warns(RetimeWarning, match="tripod: nothing changes") as told:
            retime.guided_warp([camera(sliding(MOVED), MOVED), still], length="80%")
        assert len(told) == 1
