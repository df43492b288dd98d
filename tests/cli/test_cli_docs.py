"""docs/cli.md is what the help says now."""

from __future__ import annotations

import importlib.util
import json
import re
from pathlib import Path

TOOL = Path(__file__).resolve().parents[2] / "tools" / "make_cli_docs.py"


def _tool():
    spec = importlib.util.spec_from_file_location("make_cli_docs", TOOL)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def test_the_page_is_up_to_date() -> None:
    tool = _tool()
    assert tool.PAGE.read_text(encoding="utf-8") == tool.page(), "run python tools/make_cli_docs.py"


def test_the_page_does_not_depend_on_the_terminal(monkeypatch) -> None:
    page = _tool().page()
    monkeypatch.setenv("COLUMNS", "43")
    monkeypatch.setenv("TERM", "dumb")
    assert _tool().page() == page


def test_the_page_names_every_key_of_the_json(run, clips, tmp_path) -> None:
    page = _tool().JSON
    named = {
        key for row in re.findall(r"^\| (`.*?) \|", page, flags=re.MULTILINE) for key in re.findall(r"`(\w+)`", row)
    }
    warp = set(json.loads(run("warp", clips.csv, "--length", "80%", "--json", "--save", "hand.json").stdout))
    hand = ("--example", "0:59", "--warp", "hand.json")
    own = {"example", "example_clip", "coverage"}
    assert set(json.loads(run("imitate", clips.csv, *hand, "--json").stdout)) == warp | own <= named
    variant = set(json.loads(run("warp", clips.csv, "--variants", "1", "--json").stdout))
    (tmp_path / "beats.csv").write_text("0.5\n1\n1.5\n2\n")
    beats = set(json.loads(run("warp", clips.csv, "--keys-from", "beats.csv", "--json").stdout))
    named -= {"accent"}
    assert warp | own | variant | beats == named
