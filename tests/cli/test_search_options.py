"""Options of the search on the command line, as they are made from a declaration."""

from __future__ import annotations

from dataclasses import replace

import click
import pytest
from click.testing import CliRunner

from retime.cli import search_options as made
from retime.search.options import BY_NAME

ON = replace(BY_NAME["loop"], name="keep_on", default=True)
OFF = replace(BY_NAME["loop"], name="turn_on", default=False)


@pytest.mark.parametrize(
    ("arguments", "given"),
    [
        ([], {}),
        (["--turn-on"], {"turn_on": True}),
        (["--no-keep-on"], {"keep_on": False}),
        (["--no-keep-on", "--turn-on"], {"keep_on": False, "turn_on": True}),
    ],
)
def test_a_flag_turns_from_its_default_and_is_passed_on_only_where_it_was_given(monkeypatch, arguments, given) -> None:
    monkeypatch.setattr(made, "OPTIONS", (ON, OFF))
    found = {}

    @click.command()
    @made.search_options(usual={})
    def command(*, search) -> None:
        found.update(search)

    done = CliRunner().invoke(command, arguments)
    assert done.exit_code == 0, done.output
    assert found == given
