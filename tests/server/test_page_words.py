"""What the page is told speaks of its fields: it has neither options nor arguments."""

from __future__ import annotations

import ast
import re
from collections.abc import Iterator
from pathlib import Path

import click
import pytest

import retime
from retime.cli.main import main
from retime.errors import OutputExistsError
from retime.hosts.exporting import export_curve
from retime.search.options import OPTIONS
from retime.server.page_words import page_words
from retime.server.unexpected import words_for_page

ROOT = Path(retime.__file__).parent
# Rooms whose words no page hears.
UNHEARD = {"cli", "batch", "blender", "issue_report"}
WEB = Path(__file__).parents[2] / "web" / "src"

OPTION = re.compile(r"(?<![\w-])--[a-z][a-z-]*")


def said() -> Iterator[tuple[str, str]]:
    """All texts of the source that say an option, with letters for what is put in."""
    for path in sorted(ROOT.rglob("*.py")):
        if path.relative_to(ROOT).parts[0] in UNHEARD or path.name == "page_words.py":
            continue
        tree = ast.parse(path.read_text(encoding="utf-8"))
        described = {id(node.value) for node in ast.walk(tree) if isinstance(node, ast.Expr)}
        parts = {id(part) for node in ast.walk(tree) if isinstance(node, ast.JoinedStr) for part in node.values}
        for node in ast.walk(tree):
            if id(node) in described or id(node) in parts:
                continue
            if isinstance(node, ast.JoinedStr):
                text = "".join(part.value if isinstance(part, ast.Constant) else "7" for part in node.values)
            elif isinstance(node, ast.Constant) and isinstance(node.value, str):
                text = node.value
            else:
                continue
            if OPTION.search(text) and not text.startswith("--neighbors"):
                yield f"{path.relative_to(ROOT)}:{node.lineno}", text


def commands() -> dict[str, set[str]]:
    """The options of the commands that the page names."""
    found = {name: main.get_command(click.Context(main), name) for name in ("convert", "apply")}
    return {
        name: {word for param in command.params for word in (*param.opts, *param.secondary_opts)}
        for name, command in found.items()
    }


def test_no_message_tells_the_page_to_set_an_option() -> None:
    there = commands()
    texts = list(said())
    assert len(texts) > 60
    for place, text in texts:
        if text == "--folder" or place.startswith("motion/first_frames.py"):
            # A part of a command that is typed; a part of a message that stands below.
            continue
        words = page_words(text)
        for found in OPTION.finditer(words):
            before = words[: found.start()]
            command = re.search(r"retime (convert|apply) with $", before)
            if command:
                assert found[0] in there[command[1]], (place, words)
            else:
                assert re.search(r"(?:type|start): |pip install |usdcat $", before), (place, words)
        assert not re.search(r"\b[a-z_]+=(?:True|'|[,)])|in Python|Limits\.", words), (place, words)


def test_fields_that_are_named_are_the_pages() -> None:
    script = "\n".join(path.read_text(encoding="utf-8") for path in sorted(WEB.rglob("*.ts")))
    titles = {option.label for option in OPTIONS}
    named = {name for _, text in said() for name in re.findall("“([^”]+)”", page_words(text))}
    assert {"Rate, Hz", "Rate", "For", "Tolerance", "Search rate", "Speed limits"} <= named
    for name in named - titles:
        assert f'"{name}"' in script, name
    assert '"How it is read"' in script


@pytest.mark.parametrize(
    ("message", "words"),
    [
        ("give the rate (--fps, rate=)", "give the rate (“Rate, Hz” under How it is read)"),
        (
            "line 3; --repair (repair=True) keeps what is there",
            "line 3; retime convert with --repair keeps what is there",
        ),
        ("bridge them (--gaps bridge:SECONDS)", "bridge them (“Gaps” under How it is read: Bridge)"),
        (
            "(--channel 'Time (s)=time:s' takes it for seconds)",
            "(“Channels” under How it is read: Time (s)=time:s takes it for seconds)",
        ),
        (
            "say that it is linear (--channel pan=linear)",
            "say that it is linear (“Channels” under How it is read: pan=linear)",
        ),
        ("find a slower warp (--speed 1/4..2.5)", "find a slower warp (“Speed limits”: 1/4..2.5)"),
        ("allow speeds down to 1/8 (speed='1/8..')", "allow speeds down to 1/8 (“Speed limits”: 1/8..)"),
        ("take search='priced' (--search priced)", "take “Exactness”: Exact"),
        ("--item is blank: leave it out", "“For” is blank: leave it out"),
        ("use a lower rate (rate=, --rate)", "use a lower rate (“Search rate”)"),
        (
            "away: say so (--also CLIP+2s=OUT; in Python on_clock_of)",
            "away: say so (“Begins” under How it is read: +2s)",
        ),
        (
            "Leave it out: --drop-first 2 (in Python clip[2:]; in the editor use frames from 3)",
            "Leave it out: use frames from 3",
        ),
        (
            "Leave it out: --reference-frames 3: (in Python clip[2:]; in the editor use frames from 3)",
            "Leave it out: use frames from 3",
        ),
        # Commands, and names that only look so.
        (
            "To allow it, end the editor and type: retime edit a.bvh --rate --folder /etc",
            "To allow it, end the editor and type: retime edit a.bvh --rate --folder /etc",
        ),
        ("walk--fps.bvh: there is no such file", "walk--fps.bvh: there is no such file"),
        ("--rates", "--rates"),
    ],
)
def test_words_of_the_page(message, words) -> None:
    assert page_words(message) == words


def test_errors_are_told_in_the_pages_words(tmp_path) -> None:
    warp = retime.linear_warp(keytimes=[(0, 0), (1.0, 0.8)])
    with pytest.raises(retime.OptionError) as refused:
        export_curve(warp, tmp_path / "a.jsx", "after-effects", rate=30, start=1)
    assert "--start" in str(refused.value)
    assert words_for_page(refused.value).startswith("“First frame” would have no effect")
    words = words_for_page(OutputExistsError("a.bvh"))
    assert (
        words == "a.bvh: exists already; choose another place or allow overwriting (“Replace the file if it is there”)"
    )
