"""The page, its players and pictures, and the numbers as JSON."""

from __future__ import annotations

import base64
import json
import math
import re
from fractions import Fraction

import numpy as np
import pytest

from retime.motion.signal import Signal
from retime.warp.curve import Warp
from study.clips.library import Library, read_sample
from study.defaults import DEFAULTS
from study.report.numbers import numbers
from study.report.pictures import simplified
from study.report.plain import plain
from study.report.player import camera_player_html, player_data, player_html, player_script
from study.report.write import write_study
from study.run import Results, run
from study.signals.camera import warp_camera

SAMPLE = read_sample()


def test_a_simplified_curve_is_near_the_curve_and_keeps_its_ends_and_gaps() -> None:
    x = np.linspace(0.0, 10.0, 4001)
    y = np.exp(np.sin(3 * x))
    y[2000:2010] = np.nan
    few_x, few_y = simplified(x, y, reach=10.0)
    assert len(few_x) < 400
    assert (few_x[0], few_x[-1]) == (0.0, 10.0)
    assert np.isnan(few_y).any()
    for part in (slice(0, 2000), slice(2010, 4001)):
        there = (few_x >= x[part][0]) & (few_x <= x[part][-1]) & ~np.isnan(few_y)
        again = np.interp(x[part], few_x[there], np.log10(few_y[there]))
        assert np.abs(again - np.log10(y[part])).max() < 0.06


def test_a_player_looks_through_the_camera() -> None:
    result = warp_camera(SAMPLE, Warp([0.0, SAMPLE.end_time * 0.7], [0.0, SAMPLE.end_time]))
    (text,) = re.findall(r'<script type="application/json">(.*?)</script>', camera_player_html(result), flags=re.DOTALL)
    data = json.loads(text)
    along, left = (np.array(one["camera"]) for one in data["versions"])
    assert along.shape == left.shape == (data["versions"][0]["count"], 6)
    assert np.linalg.norm(along[:, :3] - along[:, 3:], axis=1) == pytest.approx(np.full(len(along), 4.12), abs=0.01)
    assert np.abs(along[-1] - left[-1]).max() > 0.2


def test_a_player_holds_the_poses_that_are_written(lengthened) -> None:
    data = player_data(lengthened)
    version = data["versions"][-1]
    poses = np.frombuffer(base64.b64decode(version["poses"]), "<i2").reshape(version["count"], data["nodes"], 3)
    assert [one["label"] for one in data["versions"]] == [one.label for one in lengthened.versions]
    assert len(version["speeds"]) == len(version["aloft"]) == version["count"]
    # A man: no taller than two metres and a half on his jump, no shorter than one.
    heights = np.ptp(poses[:, :, 1] * data["grain"], axis=1)
    assert 1.0 < np.median(heights) < 2.0
    assert all(0 <= node < data["nodes"] for _, line in data["chains"] for node in line)
    assert sum(version["aloft"]) / data["rate"] == pytest.approx(0.5, abs=0.1)


def test_a_player_can_stand_in_a_page(lengthened) -> None:
    text = player_html(lengthened)
    (data,) = re.findall(r'<script type="application/json">(.*?)</script>', text, flags=re.DOTALL)
    assert json.loads(data)["key"] == "V5"
    assert text.count("</script>") == 1


def test_results_are_plain_data_without_infinities() -> None:
    assert plain({"a": math.inf, "b": [np.float64(1.5), np.int64(2)]}) == {"a": None, "b": [1.5, 2]}
    assert plain(Signal(("x",), np.zeros((3, 1)), Fraction(30), name="s")) == {"name": "s", "n_frames": 3, "rate": "30"}


@pytest.fixture(scope="module")
def written(captures: Library, tmp_path_factory: pytest.TempPathFactory):
    results = run(captures, ("V5",), quick=True)
    return results, write_study(results, tmp_path_factory.mktemp("study"))


def test_the_page_asks_no_other_place_for_anything(written) -> None:
    _, found = written
    page = found.page.read_text(encoding="utf-8")
    assert "<canvas" not in page
    assert player_script() in page
    assert not re.findall(r"""(?:src|href)=["'](?!data:|#)""", page)
    assert not re.findall(r"https?://|@import|url\(", page)


def test_the_numbers_are_json_without_nan(written) -> None:
    results, found = written
    document = json.loads(found.numbers.read_text(encoding="utf-8"), parse_constant=pytest.fail)
    assert document["evaluations"][0]["key"] == "V5"
    assert document["machine"].keys() == {"python", "processor", "cores", "processor time"}
    assert document["values"].keys() == {"excess", "excess-keytimes"}
    assert document["tables"].keys() == {"V5", "sizes"}
    assert numbers(results)["settings"] == DEFAULTS


def test_pictures_are_written_for_what_was_run(written) -> None:
    _, found = written
    assert [place.name for place in found.figures] == ["v5.png", "speeds.svg"]
    assert all(place.stat().st_size > 1000 for place in found.figures)


def test_a_study_of_nothing_has_no_tables() -> None:
    empty = Results((), (), (), (), (), None, None, None, 0.0, {})
    assert numbers(empty)["tables"] == numbers(empty)["values"] == {}
