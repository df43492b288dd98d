"""The site's pages: all of docs/ and what stands beside it, each in the menu, with links that lead to pages of it."""

from __future__ import annotations

import posixpath
import re
from fnmatch import fnmatch
from pathlib import Path

import pytest

import retime
from tests.tool_modules import tool

ROOT = Path(__file__).resolve().parents[1]
build_site = tool("build_site")
PAGES = build_site.pages()


def test_every_page_is_in_the_menu_once() -> None:
    listed = [f"{name}.md" for names in build_site.MENU.values() for name in names]
    of_reference = {name for name in PAGES if name.startswith("reference/") and name != "reference/index.md"}
    assert len(listed) == len(set(listed))
    assert set(listed) | of_reference | {"index.md"} == set(PAGES)
    below = re.findall(r"^[a-z-]+$", PAGES["reference/index.md"].partition("toctree")[2], re.M)
    assert {f"reference/{name}.md" for name in below} == of_reference


@pytest.mark.parametrize("place", PAGES)
def test_links_lead_to_pages_of_the_site(place) -> None:
    text = re.sub(r"^```.*?^```|`[^`\n]+`", "", PAGES[place], flags=re.M | re.S)
    lost = []
    for _, target, _, _ in build_site._LINK.findall(text):
        if re.match(r"[a-z]+:", target):
            continue
        there = posixpath.normpath(posixpath.join(posixpath.dirname(place), target))
        if there not in PAGES and not (ROOT / "docs" / there).is_file():
            lost.append(target)
    assert lost == []


def test_the_site_is_built_for_a_change_of_any_of_its_pages() -> None:
    workflow = (ROOT / ".github" / "workflows" / "docs.yml").read_text(encoding="utf-8")
    (listed,) = re.findall(r"paths: \[(.*)\]", workflow)
    patterns = [word.strip().strip('"') for word in listed.split(",")]
    sources = [*build_site.OUTSIDE, *(path.relative_to(ROOT).as_posix() for path in (ROOT / "docs").rglob("*.md"))]
    assert [name for name in sources if not any(fnmatch(name, pattern) for pattern in patterns)] == []


def test_the_reference_has_every_public_name() -> None:
    described = set(re.findall(r"auto(?:class|function):: ([\w.]+)", "".join(PAGES.values())))
    assert {path.rpartition(".")[2] for path in described} >= set(retime.__all__)
    for path in described:
        home, _, name = path.rpartition(".")
        module = __import__(home, fromlist=[name])
        assert getattr(module, name).__doc__, path


def test_the_page_of_options_is_up_to_date() -> None:
    made = tool("make_option_docs")
    assert made.PAGE.read_text(encoding="utf-8") == made.page(), "run python tools/make_option_docs.py"


def test_links_are_turned_and_code_is_not() -> None:
    text = "[a](../CHANGELOG.md#x) [b](b.md) `[c](../CHANGELOG.md)` [d](../docs/d.md)\n```\n[e](../README.md)\n```\n"
    assert build_site.moved(text, "docs/page.md", "page.md") == (
        "[a](changes.md#x) [b](b.md) `[c](../CHANGELOG.md)` [d](d.md)\n```\n[e](../README.md)\n```\n"
    )
    assert build_site.moved("[a](docs/a.md) [b](https://c)", "CHANGELOG.md", "changes.md") == "[a](a.md) [b](https://c)"
    assert build_site.moved("[a](../../SECURITY.md)", "docs/howto/x.md", "howto/x.md") == "[a](../security.md)"


SITE = ROOT / "build" / "site"


@pytest.mark.skipif(not (SITE / "index.html").is_file(), reason="the site is not built: make site")
def test_the_site_that_is_built_fetches_nothing() -> None:
    loading = re.compile(
        r"<(?:script|link|img|iframe)\b[^>]*?\b(?:src|href)=\"(?:https?:)?//[^\"]*\"|url\(['\"]?https?:"
    )
    found = [
        f"{path.relative_to(SITE)}: {match}"
        for path in [*SITE.rglob("*.html"), *SITE.rglob("*.css")]
        for match in loading.findall(path.read_text(encoding="utf-8"))
        if 'rel="canonical"' not in match
    ]
    assert found == []
    assert (SITE / "searchindex.js").is_file()
    assert 'type="search"' in (SITE / "index.html").read_text(encoding="utf-8") or 'name="q"' in (
        SITE / "index.html"
    ).read_text(encoding="utf-8")
