"""What docs/hosts.md tells to type, typed; and every host has its words there."""

from __future__ import annotations

import shlex
from pathlib import Path

from retime.hosts.registry import HOST_NAMES, IMPORTED
from tests.test_readme import commands_of

PAGE = (Path(__file__).resolve().parents[2] / "docs" / "hosts.md").read_text(encoding="utf-8")


def test_the_commands_of_the_page_run(run) -> None:
    commands = [text for _, text in commands_of(PAGE)]
    assert {shlex.split(text)[1] for text in commands} >= {"export", "import"}
    for text in commands:
        run(*shlex.split(text)[1:])


def test_every_host_has_its_words() -> None:
    verified = PAGE.split("## What was verified")[1].split("\n## ")[0]
    for name in HOST_NAMES:
        assert f"`{name}`" in verified or f"`{name} --item`" in verified, name
    assert PAGE.count("Read back:") + PAGE.count("Read back (") >= len(set(IMPORTED) - {"csv", "framecurve"})
