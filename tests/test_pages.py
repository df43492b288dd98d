"""The tutorial and the how-to pages, followed as they are read; the links of all pages; and the site's plan."""

from __future__ import annotations

import re
from pathlib import Path

import pytest
from click.testing import CliRunner

from retime.cli.main import main
from tests.pages import Command, commands_of, follow

ROOT = Path(__file__).resolve().parents[1]
DOCS = ROOT / "docs"
FOLLOWED = [DOCS / "tutorial.md", DOCS / "reporting.md", *sorted((DOCS / "howto").glob("*.md"))]
PAGES = sorted([*ROOT.glob("*.md"), *DOCS.rglob("*.md")])
LINK = re.compile(r"(?<!`)\[(?:[^\[\]]|\[[^\]]*\])*\]\(\s*<?([^)\s>]+)>?(?:\s+\"[^\"]*\")?\s*\)")


def call(arguments: list[str]) -> tuple[int, str]:
    """Call retime in this process."""
    done = CliRunner().invoke(main, arguments)
    return done.exit_code, done.output


@pytest.mark.parametrize("path", FOLLOWED, ids=lambda path: path.stem)
def test_what_a_page_tells_to_type_does_what_it_shows(path, tmp_path, monkeypatch) -> None:
    monkeypatch.chdir(tmp_path)
    if path.stem == "reporting":
        (tmp_path / "broken.bvh").write_text("HIERARCHY\nROOT Hips\n{\nOFFSET 0 0", encoding="utf-8")
    n_commands = follow(path, call, tmp_path)
    assert n_commands or path.stem in ("notebook", "video")


def test_a_command_that_does_otherwise_than_shown_is_found(tmp_path) -> None:
    page = tmp_path / "page.md"
    text = "```console\n$ retime --version\nretime, version ...\n$ printf 'a\\nb' > c.txt\n```\n$ no\n"
    page.write_text(text, encoding="utf-8")
    assert [(one.line, one.shown) for one in commands_of(text)] == [(2, "retime, version ...\n"), (4, "")]
    assert follow(page, lambda _: (0, "retime, version 1\n"), tmp_path) == 2
    assert (tmp_path / "c.txt").read_text(encoding="utf-8") == "a\nb"
    with pytest.raises(AssertionError, match="the page shows"):
        follow(page, lambda _: (0, "retime 1\n"), tmp_path)
    with pytest.raises(AssertionError, match="ended with 1"):
        follow(page, lambda _: (1, "retime, version 1\n"), tmp_path)
    assert commands_of("```text\n$ no\n```") == []
    assert commands_of("```console\n$ a\n```") == [Command(2, "a", "")]


def anchors_of(page: str) -> set[str]:
    """Return the anchors of a page's headings, as GitHub and the site make them."""
    anchors = set()
    for heading in re.findall(r"^#+ (.+?)\s*$", re.sub(r"^```.*?^```", "", page, flags=re.M | re.S), re.M):
        plain = re.sub(r"\[([^\]]*)\]\([^)]*\)", r"\1", heading).replace("`", "")
        anchors.add(re.sub(r"[^\w\- ]", "", plain.lower()).strip().replace(" ", "-"))
    return anchors


@pytest.mark.parametrize("path", PAGES, ids=lambda path: path.relative_to(ROOT).as_posix())
def test_links_lead_somewhere(path) -> None:
    page = re.sub(r"^```.*?^```", "", path.read_text(encoding="utf-8"), flags=re.M | re.S)
    broken = []
    for target in LINK.findall(page):
        if re.match(r"[a-z]+:", target):
            continue
        name, _, anchor = target.partition("#")
        place = (path.parent / name).resolve() if name else path
        if not place.exists() or (anchor and anchor not in anchors_of(place.read_text(encoding="utf-8"))):
            broken.append(target)
    assert broken == []


def test_links_of_every_form_are_found() -> None:
    text = '[a](b.md) ![c](d.svg "e") [f `g`](h.md#i) [![j](k.png)](l.md) `[m](n.md)`'
    assert LINK.findall(text) == ["b.md", "d.svg", "h.md#i", "l.md"]
    assert anchors_of("# A `b` - c\n## [D e](f.md): g!\n```\n# no\n```\n") == {"a-b---c", "d-e-g"}
