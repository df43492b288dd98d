"""The page that compares with 0.1: made of what is committed, and right where there are two versions."""

from __future__ import annotations

import json
from pathlib import Path

from tests.tool_modules import tool

comparison = tool("make_comparison")


def results(version: str, seconds: float, text: str, *, more: str = "") -> dict[str, object]:
    machine = {"retime": version, "python": "3.13.1", "system": "Linux", "cores": 2, "load_before": 0.25}
    way = {"median": 2 * seconds, "min": seconds, "runs": 3}
    rows = [{"what": "path alone", "target": "", "met": None, "text": text}]
    rows += [{"what": more, "target": "", "met": None, "text": "1 GB"}] if more else []
    against = {"what": "a take, against version 0.1.0", "target": "<= 0.6x", "met": False, "text": "0.83x"}
    return {
        "sizes": {"machine": machine, "sizes": {"V1": {"contenders": {"retime, one thread": way, "other": way}}}},
        "targets": {"machine": machine, "rows": rows},
        "long_takes": {"machine": machine, "rows": [against, {**against, "what": "a take, against pybvh"}]},
    }


def test_the_page_is_up_to_date() -> None:
    found = {version: comparison.results_of(version) for version in comparison.versions()}
    assert comparison.PAGE.read_text(encoding="utf-8") == comparison.page(found), "run python tools/make_comparison.py"


def test_two_versions_are_put_side_by_side(tmp_path) -> None:
    both = {"0.1.0": results("0.1.0", 0.02, "10x", more="gone"), "1.0.0": results("1.0.0", 0.005, "12x", more="new")}
    page = comparison.page(both)
    assert "Version 1.0.0 beside 0.1.0." in page
    assert "| V1 | 20 ms | 5 ms | 0.25x |" in page
    assert "**other**" not in page
    assert "| path alone | 10x | 12x |" in page
    assert "| new | not measured | 1 GB |" in page
    assert "| gone | 1 GB | not measured any more |" in page
    assert "| a take, against version 0.1.0 | <= 0.6x | 0.83x | **not met** |" in page
    assert "pybvh" not in page
    for version, found in both.items():
        (tmp_path / version).mkdir()
        for name, content in found.items():
            (tmp_path / version / f"{name}.json").write_text(json.dumps(content), encoding="utf-8")
    (tmp_path / "0.10.0").mkdir()
    assert comparison.versions(tmp_path) == ["0.1.0", "1.0.0"]
    assert comparison.page({one: comparison.results_of(one, tmp_path) for one in ("0.1.0", "1.0.0")}) == page


def test_versions_are_ordered_by_number(tmp_path: Path) -> None:
    for name in ("0.10.0", "0.9.0", "1.0.0"):
        (tmp_path / name).mkdir()
        (tmp_path / name / "sizes.json").write_text("{}", encoding="utf-8")
    assert comparison.versions(tmp_path) == ["0.9.0", "0.10.0", "1.0.0"]


def test_with_one_version_nothing_is_claimed() -> None:
    page = comparison.page({"0.1.0": results("0.1.0", 0.02, "10x")})
    assert "There are no results of a version after 0.1.0 yet" in page
    assert "beside" not in page
    assert "| a take, against version 0.1.0 | <= 0.6x | 0.83x | **not met** |" in page
