"""THIRD_PARTY.md lists what is needed and what is inside the wheels, and goes into them."""

from __future__ import annotations

import re
import tomllib
from pathlib import Path

import pytest

from tests.tool_modules import tool

ROOT = Path(__file__).resolve().parents[1]
licences = tool("list_licences")
TEXT = (ROOT / "THIRD_PARTY.md").read_text(encoding="utf-8")
LISTED = dict(re.findall(r"^\| ([\w.-]+) \| (`\w+`|everything) \| \S", TEXT, re.M))


def test_all_that_is_asked_for_is_listed_where_it_is_needed_first() -> None:
    seen: set[str] = set()
    for extra, names in licences.needed().items():
        for name in names:
            if name not in seen and LISTED[name] != "everything":
                order = list(licences.needed())
                assert order.index(LISTED[name].strip("`")) <= order.index(extra)
            seen.add(name)
    assert seen <= set(LISTED)


def test_the_page_is_made_of_what_is_listed() -> None:
    assert licences.locked_of_page() == ["three"]
    for name in ("three.js", "nanobind", "robin-map"):
        text = TEXT.partition(f"### {name}\n")[2].partition("###")[0]
        assert "Copyright" in text
        assert re.search(r"SOFTWARE\s+IS\s+PROVIDED\s+(?:BY.*)?\"AS\s+IS\"", text, re.S)


def test_it_is_in_every_wheel() -> None:
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    assert project["license-files"] == ["LICENSE", "THIRD_PARTY.md"]


PACKAGES = {
    "Alpha_One": ["MIT", "", [], ["beta>=1", "gamma; extra == 'more'"]],
    "beta": ["", "BSD 3-Clause\nlong text", [], ["alpha-one"]],
    "gamma": ["", "x" * 100, ["ISC License"], []],
    "delta": ["", "", [], []],
}


def test_what_is_needed_in_turn_is_found_once_and_extras_of_others_are_not() -> None:
    assert licences.closure({"": ["alpha-one"], "plot": ["gamma", "beta"]}, PACKAGES) == {
        "Alpha_One": "",
        "beta": "",
        "gamma": "plot",
    }


def test_a_licence_is_taken_from_where_it_is_said() -> None:
    found = [licences.licence_of(name, PACKAGES) for name in ("Alpha_One", "beta", "gamma")]
    assert found == ["MIT", "BSD 3-Clause", "ISC License"]
    with pytest.raises(ValueError, match="delta does not say"):
        licences.licence_of("delta", PACKAGES)
