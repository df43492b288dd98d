"""docs/study shows what its study.json says, all of it, and nothing else."""

from __future__ import annotations

import copy
import json
import re
from pathlib import Path
from typing import Any

import pytest

from study.defaults import DEFAULTS
from study.evaluations.registry import EVALUATIONS
from study.report.docs import IncompleteStudyError, fill, main

ROOT = Path(__file__).resolve().parents[2]
DOCS = ROOT / "docs" / "study"


@pytest.fixture(scope="module")
def document() -> dict[str, Any]:
    return json.loads((DOCS / "study.json").read_text(encoding="utf-8"))


@pytest.fixture(scope="module")
def page() -> str:
    return (DOCS / "README.md").read_text(encoding="utf-8")


def test_the_page_is_filled_with_the_numbers_beside_it(page: str, document: dict[str, Any]) -> None:
    assert fill(page, document) == page


def test_no_table_of_the_page_is_empty(page: str) -> None:
    tables = re.findall(r"<!-- table ([\w-]+) -->\n(.*?)<!-- end -->", page, flags=re.DOTALL)
    assert {name for name, _ in tables} >= {*EVALUATIONS, "sizes", "answers", "sensitivity", "losses", "signals"}
    for name, text in tables:
        lines = [line for line in text.splitlines() if line]
        assert len(lines) >= 4, name
        assert len({line.count("|") for line in lines}) == 1, name


def test_every_part_of_the_study_was_run_with_the_defaults_of_today(document: dict[str, Any]) -> None:
    assert [one["key"] for one in document["evaluations"]] == list(EVALUATIONS)
    assert document["settings"] == DEFAULTS
    assert all(document[part] for part in ("answers", "sensitivity", "camera", "curve", "ball"))


def test_every_picture_of_the_page_is_there_and_small(page: str) -> None:
    names = re.findall(r"!\[[^\]]*\]\(([\w.-]+)\)", page)
    assert {f"{key.lower()}.png" for key in EVALUATIONS} <= set(names)
    sizes = [(DOCS / name).stat().st_size for name in names]
    assert min(sizes) > 1000
    assert sum(sizes) < 4_000_000
    beside = re.findall(r"\]\((\w+\.md)\)", page)
    assert {place.name for place in DOCS.iterdir()} == {*names, *beside, "README.md", "study.json"}


SMALL = {
    "tables": {"a": {"headings": ["x", "y"], "rows": [["1", "2"]], "numbers_from": 1, "marked": []}},
    "values": {"v": "3 of 4"},
}
PAGE = "# Page\n\n<!-- table a -->\n\nold\n\n<!-- end -->\n\nIt keeps <!-- value v -->0<!-- end --> of them.\n"


def test_a_page_is_filled_and_filled_again_alike() -> None:
    filled = fill(PAGE, SMALL)
    assert "| 1 | 2 |" in filled
    assert "keeps <!-- value v -->3 of 4<!-- end --> of them" in filled
    assert "old" not in filled
    assert fill(filled, SMALL) == filled


def changed(**parts: Any) -> dict[str, Any]:
    return copy.deepcopy(SMALL) | parts


@pytest.mark.parametrize(
    ("page", "document", "says"),
    [
        pytest.param(PAGE, changed(tables={}), "no table a", id="no_such_table"),
        pytest.param(PAGE, changed(values={}), "no value v", id="no_such_value"),
        pytest.param(
            PAGE, changed(tables={"a": {**SMALL["tables"]["a"], "rows": []}}), "table a has 0 rows", id="empty_table"
        ),
        pytest.param(
            PAGE, changed(tables={"a": {**SMALL["tables"]["a"], "rows": [["1"]]}}), "not all of 2 cells", id="ragged"
        ),
        pytest.param(PAGE.replace("<!-- end -->", ""), SMALL, "not closed", id="not_closed"),
        pytest.param("# Page\n", SMALL, "no place for the tables a", id="no_marker"),
        pytest.param(
            PAGE,
            changed(tables={**SMALL["tables"], "b": SMALL["tables"]["a"]}),
            "no place for the tables b",
            id="hidden",
        ),
    ],
)
def test_a_page_is_not_filled_by_halves(page: str, document: dict[str, Any], says: str) -> None:
    with pytest.raises(IncompleteStudyError, match=says):
        fill(page, document)


def test_nothing_is_written_where_a_picture_is_missing(tmp_path: Path) -> None:
    source, docs = tmp_path / "out", tmp_path / "docs"
    source.mkdir()
    docs.mkdir()
    before = PAGE + "\n![A](a.png)\n"
    (docs / "README.md").write_text(before, encoding="utf-8")
    (source / "study.json").write_text(json.dumps(SMALL), encoding="utf-8")
    with pytest.raises(IncompleteStudyError, match=r"no picture a\.png"):
        main(source, docs)
    assert (docs / "README.md").read_text(encoding="utf-8") == before
    (source / "a.png").write_bytes(b"picture")
    main(source, docs)
    assert "| 1 | 2 |" in (docs / "README.md").read_text(encoding="utf-8")
    assert (docs / "a.png").read_bytes() == b"picture"
