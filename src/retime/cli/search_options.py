"""The options of the search on the command line, made from their declaration (`retime.search.options`)."""

from __future__ import annotations

import functools
from collections.abc import Callable, Iterable, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import click

from retime.cli.clip_options import parsed
from retime.cli.help_sections import Option as SectionedOption
from retime.search.options import BY_NAME, OPTIONS, Option
from retime.search.written import option_reader

Decorator = Callable[[Callable[..., None]], Callable[..., None]]


def search_options(
    *, usual: Mapping[str, str], beside: Mapping[str, tuple[Decorator, ...]] | None = None, as_text: bool = False
) -> Decorator:
    """Make a decorator that adds every option; the command gets those that were given as one dictionary ``search``.

    Parameters
    ----------
    usual : mapping of str to str
        What help says holds where an option is not given, by the option's name: the command's own defaults.
    beside : mapping of str to decorators
        Other options, by the name of the one that they follow in help.
    as_text : bool
        Hand on what was typed, once it was read without an error, and not its value.
    """

    def add(function: Callable[..., None]) -> Callable[..., None]:
        @functools.wraps(function)
        def packed(**given: Any) -> None:
            # An option that is not given is not passed on: guided_warp() has its own defaults.
            taken = {option.name: given.pop(option.name) for option in OPTIONS}
            search = {name: value for name, value in taken.items() if value is not None}
            function(search=search, **given)

        made: list[Decorator] = []
        for option in OPTIONS:
            made.append(_made(option, usual.get(option.name), as_text))
            made += (beside or {}).get(option.name, ())
        command: Callable[..., None] = packed
        for decorator in reversed(made):
            command = decorator(command)
        return command

    return add


def _made(option: Option, usual: str | None, as_text: bool) -> Decorator:
    """Make click's option of a declaration; `usual` is the command's own default in words."""
    if usual is None:
        # That a flag is off where nobody gives it needs no word.
        usual = "" if option.usual == "none" or option.kind == "flag" else option.default_words
    common: dict[str, Any] = {
        "cls": SectionedOption,
        "section": option.section,
        "help": option.help,
        "default_text": usual,
    }
    if option.kind == "flag":
        turned = not option.default
        return click.option(
            option.on_command_line, option.name, is_flag=True, flag_value=turned, default=None, **common
        )
    common |= {"metavar": option.metavar}
    if option.kind == "choice":
        choice = click.Choice([choice.value for choice in option.choices])
        return click.option(option.on_command_line, option.name, type=choice, **common)
    read = option_reader(option)
    return click.option(
        option.on_command_line, option.name, callback=parsed(text_of(read) if as_text else read), **common
    )


def text_of(read: Callable[[str], Any]) -> Callable[[str], str]:
    """Make a reader that only looks whether a text can be read, and hands it on."""

    def checked(text: str) -> str:
        read(text)
        return text

    return checked


def flags_of(names: Iterable[str]) -> list[str]:
    """Return what options are called on the command line, for messages."""
    return [BY_NAME[name].on_command_line for name in names]


def for_footage(path: Path, options: dict[str, Any]) -> dict[str, Any]:
    """Have the channels of a video, and of keypoints in one, compared as they are.

    How those of a video compare is settled when they are found; keypoints are all places in one picture. Each divided
    by its own spread, what only trembles would count as much as what moves.
    """
    from retime.formats.registry import format_of
    from retime.media.kinds import is_media

    if not (is_media(path) or format_of(path).alike):
        return options
    from retime.search.poses.spaces import PoseOptions

    features = options.get("features")
    if not isinstance(features, PoseOptions):
        features = PoseOptions(space=features)
    return options | {"features": replace(features, scale_signals=False)}
