"""Both sets of clips: what is measured, and how it is summed up."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from study.clips.library import Library
from study.sets.measure import LINEAR, MEASURED, SETS, VERSIONS, Played, play_sets
from study.tables.sets import sets_table


def played(clip: str, version: str, **figures: Any) -> Played:
    return Played("first", clip, "80%", version, dict.fromkeys(MEASURED) | figures)


def test_every_version_plays_every_clip_at_every_length() -> None:
    found = list(play_sets(Library(Path("unused")), sets={"first": ["sample"]}, lengths=["80%", "120%"]))
    assert [(one.length, one.version) for one in found] == [
        (length, version) for length in ("80%", "120%") for version in (*VERSIONS, LINEAR)
    ]
    assert all(set(one.figures) == set(MEASURED) and one.optimal for one in found)
    by_version = {one.version: one.figures for one in found if one.length == "80%"}
    assert by_version["the default"]["flight_frames_kept"] == by_version["the default"]["flight_frames"] > 20
    assert by_version[LINEAR]["flight_frames_kept"] == 0
    assert (by_version[LINEAR]["walk_low"], by_version[LINEAR]["walk_high"]) == pytest.approx((1.25, 1.25), abs=0.01)


def test_what_has_no_warp_is_left_out() -> None:
    slow = {"the default": {"max_skip": 1}}
    clips = Library(Path("unused"))
    assert list(play_sets(clips, sets={"first": ["sample"]}, lengths=["50%"], versions=slow)) == []


def test_sums_means_and_the_worst_of_a_set() -> None:
    default = list(VERSIONS)[-1]
    some = [
        played("a", default, flight_frames=10, flight_frames_kept=9, walk_high=1.2, walk_low=1.0, flights_leapt=1),
        played("b", default, flight_frames=5, flight_frames_kept=5, walk_high=1.6, walk_low=0.8, skipped=2.0),
        played("c", default, idle=1.5),
        played("c", LINEAR, idle=3.0),
    ]
    table = sets_table(some, "first")
    assert table.headings == ("figure", "version", "80%")
    heading = ""
    cells = {}
    for row in table.rows:
        heading = row[0] or heading
        cells[heading.split(",")[0], row[1]] = row[2]
    assert cells["walks: 95th percentile of speed", default] == "1.40 (1.60)"
    assert cells["walks: 5th percentile of speed", default] == "0.90 (0.80)"
    assert cells["flight frames kept", default] == "14 of 15"
    assert cells["flights leapt over", default] == "1"
    assert (cells["standing still", default], cells["standing still", LINEAR]) == ("1.5", "3.0")
    assert cells["walks: spread of steps", LINEAR] == "–"
    assert {table.rows[i][1] for i in table.marked} == {default}
    assert len(table.marked) == len(table.rows) / (len(VERSIONS) + 1)


def test_the_sets_are_the_studys_own() -> None:
    assert list(SETS) == ["first", "second"]
    assert "sample" in SETS["first"]
