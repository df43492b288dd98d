"""A warp from footage alone, measured."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest

from study.footage.ball import FLIGHT, RATE, SIZE, place, spans, write_ball

PAGE = Path(__file__).resolve().parents[2] / "docs" / "study" / "video.md"
pytestmark = pytest.mark.extras
for package in ("av", "cv2"):
    pytest.importorskip(package, reason="needs the extra 'video'")


@pytest.fixture(scope="module")
def ball(tmp_path_factory):
    return write_ball(tmp_path_factory.mktemp("ball") / "ball.mp4")


def test_the_ball_is_drawn_where_it_is_known_to_be(ball) -> None:
    import av

    with av.open(str(ball)) as container:
        frames = [frame.to_ndarray(format="gray").astype(float) for frame in container.decode(video=0)]
    wall = np.median(frames, axis=0)
    x, y = place(np.arange(len(frames)) / RATE)
    for number in range(0, len(frames), 7):
        rows, columns = np.nonzero(frames[number] - wall > 60)
        assert (columns.mean(), rows.mean()) == pytest.approx((x[number], y[number]), abs=4)
    assert frames[0].shape == SIZE[::-1]
    # In the middle of a flight it is highest.
    assert y.min() == pytest.approx(100 - 120 * 9.81 / 8 * FLIGHT**2, abs=1)


def test_flights_are_kept_and_the_tables_say_so(ball, tmp_path) -> None:
    pytest.importorskip("matplotlib", reason="needs the extra 'plot'")
    from study.footage.measure import measure_ball, measure_take, tables
    from study.footage.picture import draw

    (row,) = measure_ball(ball, ["65%"])
    (take,) = measure_take(ball, ["65%"])
    assert row.guided.n_frames == row.played.n_frames == 54
    assert row.guided.n_kept >= 52
    assert 35 <= row.played.n_kept <= row.guided.n_kept
    assert row.linear.n_kept == 0
    assert 0.5 < take.at_own_speed < 1
    assert take.extreme > 2
    lines = tables([row], [take]).splitlines()
    assert re.fullmatch(r"\| 65 % \| \d\d of 54 \| \d\d of 54 \| 0 \| \d+ \|", lines[2])
    assert re.fullmatch(r"\| 65 % \| \d\d % \| [\d.]+x \|", lines[6])
    # The page has the same tables.
    page = PAGE.read_text(encoding="utf-8")
    assert lines[0] in page
    assert lines[4] in page
    draw(tmp_path / "a.png", ball, row.warp, spans(), "A ball")
    assert (tmp_path / "a.png").read_bytes()[:4] == b"\x89PNG"
