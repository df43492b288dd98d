"""What a release says of itself agrees: tag, version, changelog and citation."""

from __future__ import annotations

import importlib.util
import re
import tomllib
from pathlib import Path
from types import ModuleType

import pytest

ROOT = Path(__file__).resolve().parents[1]


@pytest.fixture(scope="module")
def release_notes() -> ModuleType:
    spec = importlib.util.spec_from_file_location("release_notes", ROOT / "tools" / "release_notes.py")
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


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


def test_notes_are_what_the_changelog_says_of_the_version(release_notes: ModuleType) -> None:
    assert release_notes.notes_of("v1.2.0", CHANGELOG, "1.2.0") == "* New.\n\n### Part\n\n* More.\n"
    assert release_notes.notes_of("v1.1.0", CHANGELOG, "1.1.0") == "* Old.\n"


@pytest.mark.parametrize(
    ("tag", "version"), [("v1.2.0", "1.1.0"), ("1.2.0", "1.2.0"), ("v1.3.0", "1.3.0"), ("v1.2", "1.2")]
)
def test_a_tag_that_nothing_agrees_with_is_refused(release_notes: ModuleType, tag: str, version: str) -> None:
    with pytest.raises(ValueError, match=r"pyproject\.toml says|says nothing of version"):
        release_notes.notes_of(tag, CHANGELOG, version)


def test_the_citation_names_this_version() -> None:
    version = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]["version"]
    found = re.search(r"^version: (.+)$", (ROOT / "CITATION.cff").read_text(encoding="utf-8"), re.MULTILINE)
    assert found is not None
    assert found[1] == version
