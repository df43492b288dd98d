"""The pictures of the method are drawn, with their own checks, and the page shows them."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest

ROOT = Path(__file__).resolve().parents[1]
PLACE = ROOT / "docs" / "images" / "method"

pytest.importorskip("matplotlib", reason="needs the extra plot")


@pytest.fixture(scope="module")
def pictures():
    from tests.tool_modules import tool

    return tool("make_method_pictures")


def test_the_page_shows_what_there_is(pictures) -> None:
    shown = set(re.findall(r"images/method/(\w+)\.svg", (ROOT / "docs" / "method.md").read_text(encoding="utf-8")))
    assert shown == set(pictures.PICTURES) == {path.stem for path in PLACE.iterdir()}


@pytest.mark.parametrize("name", ["path", "bound", "hurry"])
def test_a_picture_is_drawn_and_holds_what_it_says(pictures, name) -> None:
    figure = pictures.PICTURES[name]()
    assert all(axes.get_xlabel() and axes.get_ylabel() for axes in figure.axes)
    pictures.plt.close(figure)


def test_the_small_search_has_paths_above_the_hull_too(pictures) -> None:
    steps, totals = pictures.toy()
    # Else the picture would hide the gap that it tells of.
    bends = np.diff(totals, 2)
    assert (bends < -1e-9).any()
    assert len(steps) == len(totals) > 10
