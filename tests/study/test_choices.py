"""What each choice is worth: the settings, and their means over clips and cases."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

from retime.search.session import Session
from study.choices.questions import Imitated, Row, measure, row_of
from study.choices.settings import CHOSEN, Setting, settings
from study.clips.library import Library, read_sample
from study.defaults import AS_PRINTED, DEFAULTS
from tests.study.rows import row_of_one

SAMPLE = read_sample()


def test_means_over_cases_count_what_could_not_be_had_as_nothing() -> None:
    one = row_of_one(CHOSEN, 4, 1.1)
    assert one.kept() == (4, 10)
    assert row_of_one(CHOSEN, 9, 1.0).kept_high("65%") == (4, 4)
    assert row_of_one(CHOSEN, 9, 1.0).kept_high("80%") == (0, 0)
    assert one.mean("length_ratio") == pytest.approx(100 * math.log(1.1))
    assert math.isnan(one.mean("correlation", kind="boxing"))
    lost = Row(one.setting, (), (Imitated("case", "limp", "given", math.nan, 0.1, 1.0, 1.0),))
    assert lost.mean("correlation") == 0.0


def test_a_length_and_its_inverse_are_equally_far_off() -> None:
    assert row_of_one("a", 1, 2.0).mean("length_ratio") == pytest.approx(row_of_one("a", 1, 0.5).mean("length_ratio"))


def test_settings_hold_the_papers_own_and_each_row_once() -> None:
    rows = settings(DEFAULTS)
    assert rows[0].options == AS_PRINTED
    assert row_of([Row(one, (), ()) for one in rows], {**DEFAULTS, "time_scale": 0.1}).setting.label.endswith("0.1 s")
    assert row_of([], {"time_scale": 999}) is None
    assert len({(one.group, one.label) for one in rows}) == len(rows)


def test_the_study_runs_with_the_packages_own_choices() -> None:
    by_itself, said = Session(SAMPLE).solve(length="65%"), Session(SAMPLE, **DEFAULTS).solve(length="65%")
    assert np.array_equal(by_itself.path.frames, said.path.frames)
    assert by_itself.total == said.total


def test_the_samples_flights_are_kept_at_every_length() -> None:
    chosen = [Setting(CHOSEN, "", DEFAULTS)]
    (found,) = measure(Library(Path("unused")), chosen, jumps=["sample"], answers=[])
    assert found.kept()[0] == found.kept()[1] > 0
