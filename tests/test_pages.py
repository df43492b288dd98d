"""The tutorial and the how-to pages, followed as they are read; the links of all pages; and the site's plan."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner

import retime
from retime.cli.main import main
from tests.pages import Command, commands_of, follow

ROOT = Path(__file__).resolve().parents[1]
DOCS = ROOT / "docs"
# A page that needs more than retime itself has a test of its own below.
VIDEO = DOCS / "howto" / "video.md"
FOLLOWED = [
    *(DOCS / name for name in ("tutorial.md", "reporting.md", "coming-from.md")),
    *(path for path in sorted((DOCS / "howto").glob("*.md")) if path != VIDEO),
]
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
    assert n_commands or path.stem == "notebook"


@pytest.mark.extras
def test_the_page_of_video_does_what_it_shows(tmp_path, monkeypatch) -> None:
    av = pytest.importorskip("av", reason="needs the extra video")
    pytest.importorskip("cv2", reason="needs the extra video")
    monkeypatch.chdir(tmp_path)
    retime.write(retime.sample()[:120], tmp_path / "capture.bvh")
    with av.open("take.mp4", "w") as film:
        stream = film.add_stream("libx264", rate=30)
        stream.width, stream.height, stream.pix_fmt = 64, 48, "yuv420p"
        for number in range(60):
            # A disc that crosses the picture.
            y, x = np.mgrid[:48, :64]
            shown = (255 * ((x - number) ** 2 + (y - 24) ** 2 < 60)).astype(np.uint8)
            picture = av.VideoFrame.from_ndarray(np.repeat(shown[..., None], 3, axis=2), format="rgb24")
            film.mux(stream.encode(picture))
        film.mux(stream.encode(None))
    assert follow(VIDEO, call, tmp_path) == 4
    lengths = {}
    for name in ("take", "shorter", "both", "alone"):
        with av.open(f"{name}.mp4") as film:
            lengths[name] = sum(1 for _ in film.decode(video=0))
    assert abs(lengths["shorter"] - 0.65 * 60) <= 1
    assert lengths["both"] == lengths["shorter"]
    assert abs(lengths["alone"] - 0.8 * 60) <= 1


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
