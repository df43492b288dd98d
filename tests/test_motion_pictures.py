"""The pictures that move: each is drawn, shown, small, and has the poses at the times that the warp says."""

from __future__ import annotations

import re
import xml.etree.ElementTree as ElementTree
from pathlib import Path

import numpy as np
import pytest

import retime
from tests.tool_modules import tool

ROOT = Path(__file__).resolve().parents[1]
PLACE = ROOT / "docs" / "images" / "gallery"
SVG = "{http://www.w3.org/2000/svg}"
pictures = tool("make_motion_pictures")


@pytest.mark.parametrize("name", pictures.PICTURES)
def test_a_picture_shows_what_it_says(name) -> None:
    rows = pictures.PICTURES[name]()
    drawn = ElementTree.fromstring(pictures.drawn(rows))
    committed = ElementTree.parse(PLACE / f"{name}.svg").getroot()
    assert [text.text for text in committed.iter(f"{SVG}text")] == [text.text for text in drawn.iter(f"{SVG}text")]
    for picture in (drawn, committed):
        paths = list(picture.iter(f"{SVG}path"))
        assert len(paths) == 3 * len(rows)
        for path, row in zip(paths, np.repeat(rows, 3), strict=True):
            (animation,) = (one for one in path if one.get("attributeName") == "d")
            poses, times = animation.get("values").split(";"), animation.get("keyTimes").split(";")
            assert len(poses) == len(times) == round(row.warp.output_end * pictures.PICTURES_A_SECOND) + 1
            assert float(times[0]) == 0
            assert float(times[-1]) < 1
            assert path.get("d") == poses[0]


def test_the_committed_pictures_are_those_of_the_gallery_and_small() -> None:
    text = (ROOT / "docs" / "gallery.md").read_text(encoding="utf-8")
    assert set(re.findall(r"images/gallery/(\w+)\.svg", text)) == set(pictures.PICTURES)
    assert {path.stem for path in PLACE.iterdir()} == set(pictures.PICTURES)
    assert all(path.stat().st_size < 500_000 for path in PLACE.iterdir())


def test_a_flight_is_orange_while_it_is_seen() -> None:
    (up, down), *_ = pictures.FLIGHTS
    twice = retime.Warp([0.0, up, 2 * down - up, 2 * down - up + 1.0], [0.0, up, down, down + 1.0])
    assert pictures.shown_flights(twice) == [
        (pytest.approx(up, abs=0.05), pytest.approx(2 * down - up, abs=0.05)),
    ]
