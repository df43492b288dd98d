"""What a release says of itself agrees: tag, version, changelog and citation."""

from __future__ import annotations

import fnmatch
import re
import tomllib
from pathlib import Path

import pytest

import retime
from tests.tool_modules import tool

ROOT = Path(__file__).resolve().parents[1]
release_notes, make_version, name_repository = tool("release_notes"), tool("make_version"), tool("name_repository")
REPOSITORY = "https://example.org/somebody/retime"


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


def test_on_the_index_all_links_lead_to_the_repository() -> None:
    text = (ROOT / "README.md").read_text(encoding="utf-8")
    published = name_repository.published_readme(text, REPOSITORY, "v1.2.0")
    targets = re.findall(r"\]\(([^)\s]+)\)", published)
    ours = [target for target in targets if target.startswith(REPOSITORY)]
    assert len(ours) == len(re.findall(r"\]\((?!https:)", text)) > 20
    assert {target for target in targets if target not in ours} == set(re.findall(r"\]\((https:[^)]+)\)", text))
    for target in ours:
        kind, path = re.fullmatch(rf"{REPOSITORY}/(raw|blob)/v1\.2\.0/([^#]+)(?:#.*)?", target).groups()
        assert (ROOT / path).is_file(), path
        assert (kind == "raw") == path.endswith((".svg", ".png")), path
    # Nothing but links is changed: without them the texts are one.
    bare = [re.sub(r"\]\([^)]+\)", "]", one) for one in (text, published)]
    assert bare[0] == bare[1]


def test_links_in_code_and_in_pages_stay() -> None:
    text = (
        "[a](b.md#c) `[a](b.md)` [![p](p.svg)](q.md) [d](#d) <m@x.y> [w](https://w.org)\n```console\n$ [a](b.md)\n```\n"
    )
    assert name_repository.published_readme(text, "https://x.org/r", "v1") == (
        "[a](https://x.org/r/blob/v1/b.md#c) `[a](b.md)` [![p](https://x.org/r/raw/v1/p.svg)]"
        "(https://x.org/r/blob/v1/q.md) "
        "[d](#d) <m@x.y> [w](https://w.org)\n```console\n$ [a](b.md)\n```\n"
    )


def test_the_index_lists_the_repository_and_the_paper() -> None:
    text = (ROOT / "pyproject.toml").read_text(encoding="utf-8")
    before = tomllib.loads(text)
    after = tomllib.loads(name_repository.published_project(text, REPOSITORY, "v1.2.0"))
    urls = after["project"].pop("urls")
    assert urls == {
        "Homepage": REPOSITORY,
        "Documentation": f"{REPOSITORY}/blob/v1.2.0/docs/index.md",
        "Changelog": f"{REPOSITORY}/blob/v1.2.0/CHANGELOG.md",
        "Issues": f"{REPOSITORY}/issues",
        **before["project"].pop("urls"),
    }
    assert after == before
    with pytest.raises(ValueError, match="expected one line of urls"):
        name_repository.published_project("[project]\n", REPOSITORY, "v1.2.0")


def test_the_wheels_are_of_the_pythons_that_the_package_says() -> None:
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
    said = {one.rpartition(" ")[2] for one in project["project"]["classifiers"] if re.search(r":: 3\.\d+$", one)}
    chosen = project["tool"]["cibuildwheel"]["build"].split()
    assert {re.sub(r"cp(\d)(\d+)-\*", r"\1.\2", one) for one in chosen} == said
    # A build without the global lock ("cp314t-") is none of them: nobody has tried the kernels there.
    assert not any(fnmatch.fnmatch("cp314t-manylinux_x86_64", one) for one in chosen)


@pytest.mark.parametrize("path", sorted((ROOT / ".github" / "workflows").glob("*.yml")), ids=lambda path: path.stem)
def test_no_workflow_chooses_other_pythons(path: Path) -> None:
    # It takes the place of the choice in pyproject.toml, and adds nothing to it.
    assert "CIBW_BUILD:" not in path.read_text(encoding="utf-8")
