"""Tables, and the numbers of the text around them."""

from __future__ import annotations

import math

from study.baselines.steady import at_one_speed
from study.choices.questions import Row
from study.choices.settings import CHOSEN, PRINTED, Setting
from study.defaults import AS_PRINTED, DEFAULTS
from study.evaluations.evaluation import Evaluation
from study.evaluations.versions import VersionMaker
from study.figures.shown import Subject
from study.tables.choices import choices_table, losses_table
from study.tables.figures import figures_table
from study.tables.table import Table
from study.tables.values import text_values
from study.text import number
from tests.evaluate.figures import jumper
from tests.study.rows import row_of_one

STILL = jumper(lead=1.0, rest=0.5, jump=False)


def test_tables_of_settings_name_every_clip_and_mark_the_recommended() -> None:
    rows = [row_of_one(PRINTED, 1, 1.0), row_of_one(CHOSEN, 9, 1.0)]
    assert choices_table(rows).marked == frozenset({1})
    losses = losses_table(rows)
    assert losses.headings == ("clip", "65%", "65%, as printed")
    assert losses.rows == (("clip", "9 of 10", "1 of 10"),)


def test_tables_are_written_for_both_kinds_of_page() -> None:
    table = Table(("a", "b"), (("x<y", "1"), ("z", "2")), marked=frozenset({1}))
    assert table.markdown() == "| a | b |\n| :-- | --: |\n| x<y | 1 |\n| **z** | **2** |\n"
    assert "x&lt;y" in table.html()
    assert table.html().count("class=marked") == 1


def test_numbers_that_do_not_exist_are_said_so() -> None:
    assert [number(value) for value in (None, math.nan, math.inf, 1.005)] == ["–", "–", "lost", "1.00"]


def test_numbers_of_the_text_are_those_of_the_rows() -> None:
    torso = Row(Setting("", "", {**DEFAULTS, "features": "torso"}), row_of_one("", 2, 1.0).preserved, ())
    chosen = Row(Setting(CHOSEN, "", DEFAULTS), row_of_one("", 9, 1.0).preserved, row_of_one("", 9, 1.0).imitated)
    printed = Row(Setting(PRINTED, "", AS_PRINTED), row_of_one("", 3, 1.0).preserved, ())
    values = text_values([printed, torso, chosen], ())
    assert values["kept-printed"] == "3 of 10"
    assert (values["kept-default"], values["share-torso"], values["kept-high"]) == ("9 of 10", "20 %", "4 of 4")
    assert values["limps-default"] == "0.90"
    assert values["jumps-default"] == "–"
    # A quick run has no row for the torso, and says nothing of it.
    assert "share-torso" not in text_values([printed, chosen], ())


def test_a_column_that_no_version_has_is_left_out() -> None:
    subject = Subject(STILL, STILL)
    show = VersionMaker(subject)
    versions = (show.input(), show.other("reference", "", STILL), show.version("guided", "", at_one_speed(STILL, 1.0)))
    table = figures_table(Evaluation("V0", "", "", "", STILL, versions, None, None, (), {}))
    assert table.headings[:3] == ("version", "length (s)", "keytimes missed by (ms)")
    assert not {"flight frames kept", "wrists: off by (m/s)", "off in time (frames)"} & set(table.headings)
    assert [row[:4] for row in table.rows] == [
        ("input", "2.02", "–", "1.0"),
        ("reference", "2.02", "–", "–"),
        ("guided", "1.02", "0.0", "2.0"),
    ]
    assert table.marked == frozenset({2})
