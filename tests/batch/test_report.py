"""The page about a run: whatever the numbers are, it is written."""

from __future__ import annotations

import numpy as np
import pytest

from retime.batch.report import report_html
from retime.batch.task import Record


def made(fastest: float, seconds: float = 0.1, **more: object) -> Record:
    return Record(
        "a.bvh",
        "a.bvh",
        "done",
        rate=30.0,
        frames_in=40,
        frames_out=32,
        knots=((0.0, 0.0), (1.0, 1.3)),
        fastest=fastest,
        seconds=seconds,
        **more,  # type: ignore[arg-type]
    )


@pytest.mark.parametrize(
    "speeds",
    [[1.2], [1.2, 1.2], [1.2, float(np.nextafter(1.2, 2))], [1e-12, 2e-12], [1e12, float(np.nextafter(1e12, 2e12))]],
)
def test_numbers_that_are_all_but_one_have_a_distribution(speeds: list[float]) -> None:
    page = report_html([made(speed, seconds=speed) for speed in speeds], title="a to b", seconds=1.0)
    assert f"median {np.median(speeds):.4g} x" in page


def test_what_was_assumed_is_told_and_no_name_is_markup() -> None:
    page = report_html([made(1.5, warnings=("120 Hz <assumed>",))], title="<b> to c", seconds=1.0)
    assert "120 Hz &lt;assumed&gt;" in page
    assert "&lt;b&gt; to c" in page
    assert "<b>" not in page
    assert "Warnings" not in report_html([made(1.5)], title="a to b", seconds=1.0)
