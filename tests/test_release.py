"""What a release says of itself agrees: tag, version, changelog and citation."""

from __future__ import annotations

import tomllib
from pathlib import Path

import pytest

import retime
from tests.tool_modules import tool

ROOT = Path(__file__).resolve().parents[1]
release_notes, make_version = tool("release_notes"), tool("make_version")


CHANGELOG = """\
# Changelog

## Unreleased

* Later.

## 1.2.0 (2027-01-02)

* New.

### Part

* More.

## 1.1.0

* Old.
"""


def test_notes_are_what_the_changelog_says_of_the_version() -> None:
    assert release_notes.notes_of("v1.2.0", CHANGELOG, "1.2.0") == "* New.\n\n### Part\n\n* More.\n"
    assert release_notes.notes_of("v1.1.0", CHANGELOG, "1.1.0") == "* Old.\n"


@pytest.mark.parametrize(
    ("tag", "version"), [("v1.2.0", "1.1.0"), ("1.2.0", "1.2.0"), ("v1.3.0", "1.3.0"), ("v1.2", "1.2")]
)
def test_a_tag_that_nothing_agrees_with_is_refused(tag: str, version: str) -> None:
    with pytest.raises(ValueError, match=r"pyproject\.toml says|says nothing of version"):
        release_notes.notes_of(tag, CHANGELOG, version)


def test_every_file_that_names_the_version_has_this_one() -> None:
    version = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]["version"]
    assert retime.__version__ == version
    for place in make_version.PLACES:
        text = (ROOT / place).read_text(encoding="utf-8")
        assert make_version.with_version(place, text, version) == text, "run python tools/make_version.py"


def test_a_new_version_goes_to_all_of_its_places() -> None:
    for place, (_, times) in make_version.PLACES.items():
        text = (ROOT / place).read_text(encoding="utf-8")
        new = make_version.with_version(place, text, "77.8.9rc1")
        assert new.count("77.8.9rc1") == times
        assert make_version.with_version(place, new, retime.__version__) == text
    with pytest.raises(ValueError, match="0 times, expected 1"):
        make_version.with_version("CITATION.cff", "title: none", "1.0.0")


def test_the_changelog_has_a_heading_for_every_version_the_newest_first() -> None:
    text = (ROOT / "CHANGELOG.md").read_text(encoding="utf-8")
    headings = [line.removeprefix("## ") for line in text.splitlines() if line.startswith("## ")]
    versions = [tuple(map(int, one.split()[0].split("."))) for one in headings if one != "Unreleased"]
    assert versions == sorted(versions, reverse=True)
    assert "Unreleased" not in headings[1:]
    assert release_notes.notes_of(f"v{retime.__version__}", text, retime.__version__)
