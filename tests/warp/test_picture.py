"""The pictures for notebooks are whole, and nothing is drawn outside its axes."""

from __future__ import annotations

import xml.etree.ElementTree as ElementTree
from fractions import Fraction

import numpy as np
import pytest

from retime import Keytime, Signal, Warp, guided_warp
from retime.svg import facts_html

KEYS = (
    Keytime(input_time=0.0, output_time=0.0),
    Keytime(input_time=2.0, output_time=1.0),
    Keytime(input_time=3.0, output_time=3.0),
)

WARPS = {
    "plain": Warp([0.0, 1.0, 3.0], [0.0, 2.0, 3.0], KEYS, method="linear"),
    "a hold": Warp([0.0, 1.0, 2.0], [0.0, 1.0, 1.0]),
    "nothing but a hold": Warp([0.0, 2.0], [1.0, 1.0]),
    "backward": Warp([0.0, 1.0, 2.0, 3.0], [0.0, 2.0, 0.5, 1.0]),
    "beyond the axis": Warp([0.0, 0.01, 1.0, 1000.0], [0.0, 5.0, 5.5, 5.6]),
    "tiny": Warp([0.0, 1e-6], [0.0, 1e-6]),
    "from elsewhere": Warp([100.0, 101.0], [-5.0, -4.0]),
    "many pieces": Warp(np.arange(20_001) / 120, np.cumsum(np.random.default_rng(0).uniform(0.2, 3, 20_001)) / 120),
}


def panels_of(page: str) -> list[ElementTree.Element]:
    """Parse the page as XML, and return its pictures."""
    return list(ElementTree.fromstring(page).iter("{http://www.w3.org/2000/svg}svg"))


def marks_of(panel: ElementTree.Element) -> np.ndarray:
    """Places of all points of lines and dots of a picture, shape (n, 2)."""
    svg = "{http://www.w3.org/2000/svg}"
    places = [point.split(",") for line in panel.iter(f"{svg}polyline") for point in line.attrib["points"].split()]
    places += [[dot.attrib["cx"], dot.attrib["cy"]] for dot in panel.iter(f"{svg}circle")]
    return np.array(places, dtype=float)


def frame_of(panel: ElementTree.Element) -> tuple[float, float, float, float]:
    """Return the left, right, top and bottom of the axes: the rules run across, the outermost at the ends."""
    rules = list(panel.iter("{http://www.w3.org/2000/svg}line"))
    heights = [float(rule.attrib["y1"]) for rule in rules]
    return float(rules[0].attrib["x1"]), float(rules[0].attrib["x2"]), min(heights), max(heights)


@pytest.mark.parametrize("kind", WARPS)
def test_every_mark_lies_within_the_axes(kind) -> None:
    panels = panels_of(WARPS[kind]._repr_html_())
    assert len(panels) == 2
    for panel in panels:
        places = marks_of(panel)
        assert np.isfinite(places).all()
        if kind == "nothing but a hold" and panel is panels[1]:
            # It has one level, at the foot.
            assert len(set(places[:, 1])) == 1
        left, right, top, bottom = frame_of(panel)
        assert left - 0.1 <= places[:, 0].min() <= places[:, 0].max() <= right + 0.1
        assert top - 0.1 <= places[:, 1].min() <= places[:, 1].max() <= bottom + 0.1


def test_the_lines_are_the_warp() -> None:
    speed, time_map = panels_of(WARPS["plain"]._repr_html_())
    left, right, top, bottom = frame_of(speed)
    # Speed 2 for a third of the output, then 1/2, on a log axis from 1/10 to 10.
    height = [bottom - (np.log10(value) + 1) / 2 * (bottom - top) for value in (2.0, 0.5)]
    third = left + (right - left) / 3
    wanted = [(left, height[0]), (third, height[0]), (third, height[1]), (right, height[1])]
    np.testing.assert_allclose(marks_of(speed), wanted, atol=0.11)
    left, right, top, bottom = frame_of(time_map)
    knots = [(left, bottom), (left + (right - left) / 3, bottom - (bottom - top) * 2 / 3), (right, top)]
    # The line, then the dots of the keytimes, which are its knots here.
    np.testing.assert_allclose(marks_of(time_map), knots + knots, atol=0.11)


def test_a_long_warp_makes_a_small_picture() -> None:
    assert len(marks_of(panels_of(WARPS["many pieces"]._repr_html_())[1])) <= 600


def test_a_guided_warp_adds_its_numbers() -> None:
    t = np.arange(60) / 30
    result = guided_warp(Signal(("x",), np.sin(t**2)[:, None], Fraction(30)), length="75%")
    page = f"<div>{result._repr_html_()}</div>"
    assert len(panels_of(page)) == 2
    text = " ".join("".join(ElementTree.fromstring(page).itertext()).split())
    for fact in ("n_input 60", "n_output 45", "max_skip 8", "rate 30 Hz", "optimal proved"):
        assert fact in text


def test_facts_are_text() -> None:
    page = facts_html({"name": "<script>&"})
    assert "".join(ElementTree.fromstring(page).itertext()) == "name <script>&"
