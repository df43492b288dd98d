"""Several warps in numbers, each against its definition."""

from __future__ import annotations

import sys
import xml.etree.ElementTree as ElementTree

import numpy as np
import pytest
from hypothesis import given, settings

from retime import MissingExtraError, OptionError, Warp, compare_warps, guided_warp, linear_warp, sample
from tests.warp.drawn import warps

CLIP = sample()


def test_numbers_of_one_warp() -> None:
    # Twice the speed for 1 s, a hold of 2 s, backward at half speed for 2 s, at unit speed for 3 s.
    warp = Warp([0.0, 1.0, 3.0, 5.0, 8.0], [0.0, 2.0, 2.0, 1.0, 4.0], name="mixed")
    (row,) = compare_warps(warp).rows
    assert (row.name, row.output_span, row.slowest, row.fastest) == ("mixed", 8.0, 0.5, 2.0)
    assert (row.at_unit_speed, row.held, row.backward) == (3 / 8, 2.0, 2.0)
    assert (row.mean_apart, row.most_apart) == (0.0, 0.0)
    assert (row.flights, row.flights_kept) == (None, None)


@settings(max_examples=40)
@given(warps(forward=False), warps(forward=False))
def test_distances_are_those_of_many_samples(a: Warp, b: Warp) -> None:
    first, second = compare_warps([a, b]).rows
    assert (first.mean_apart, first.most_apart) == (0.0, 0.0)
    start, end = max(a.output_start, b.output_start), min(a.output_end, b.output_end)
    if not start < end:
        assert np.isnan([second.mean_apart, second.most_apart]).all()
        return
    # The middles of many equal parts: their mean is the integral, but for the corners.
    times = start + (np.arange(20_000) + 0.5) / 20_000 * (end - start)
    gap = np.abs(a(times) - b(times))
    assert second.mean_apart == pytest.approx(gap.mean(), rel=1e-3, abs=1e-9)
    assert gap.max() <= second.most_apart * (1 + 1e-12)
    assert second.most_apart <= gap.max() + 1e-3 * (1 + second.most_apart) + 1e-4 * np.abs(a.slopes).max() * 10


def test_a_guided_warp_keeps_flights_that_an_even_one_rushes() -> None:
    result = guided_warp(CLIP, length="65%")
    found = compare_warps({"linear": linear_warp(result.warp.keytimes), "guided": result}, motion=CLIP)
    linear, guided = found.rows
    assert linear.flights == guided.flights == len(CLIP.flights()) == 2
    assert (linear.flights_kept, guided.flights_kept) == (0, 2)
    assert linear.flight_slowest == pytest.approx(linear.slowest)
    assert guided.flight_fastest == pytest.approx(1.0)
    assert found.warps["guided"] == result.warp


def test_it_prints_and_shows_as_a_table() -> None:
    found = compare_warps({"even": Warp([0, 1], [0, 2]), "<slow>": Warp([0, 4], [0, 2])})
    heads, even, slow = repr(found).splitlines()
    assert heads.split()[:3] == ["name", "output", "span"]
    assert "flights" not in heads
    assert even.split() == ["even", "1", "2", "2", "0", "0", "0", "0", "0"]
    assert slow.split()[:3] == ["<slow>", "4", "0.5"]
    page = ElementTree.fromstring(found._repr_html_())
    assert next(cell.text for cell in page.iter("td")) == "even"
    assert len(list(page.iter("tr"))) == 3
    assert len(list(page.iter("{http://www.w3.org/2000/svg}polyline"))) == 2


def test_as_a_pandas_table() -> None:
    pytest.importorskip("pandas", reason="needs the extra pandas")
    table = compare_warps({"even": Warp([0, 1], [0, 2]), "slow": Warp([0, 4], [0, 2])}).to_frame()
    assert table.loc["slow", "output_span"] == 4.0
    assert "flights" not in table.columns


def test_without_pandas_the_extra_is_named(monkeypatch) -> None:
    monkeypatch.setitem(sys.modules, "pandas", None)
    with pytest.raises(MissingExtraError, match=r"retime\[pandas\]"):
        compare_warps(Warp([0, 1], [0, 2])).to_frame()


@pytest.mark.parametrize("wrong", [CLIP, "warp.json", [CLIP], {}, [], None])
def test_what_is_no_warp_is_refused(wrong) -> None:
    with pytest.raises(OptionError, match="warp"):
        compare_warps(wrong)
    with pytest.raises(OptionError, match="flights"):
        compare_warps(Warp([0, 1], [0, 2]), motion=np.zeros(3))  # type: ignore[arg-type]
