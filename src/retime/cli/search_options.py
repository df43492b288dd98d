"""The options of the search on the command line, made from their declaration (`retime.search.options`)."""

from __future__ import annotations

import functools
from collections.abc import Callable, Iterable, Mapping
from fractions import Fraction
from typing import Any

import click

from retime.cli.clip_options import parsed
from retime.cli.help_sections import Option as SectionedOption
from retime.motion.grammar import WrittenTime, check_length, parse_number, parse_share, parse_speeds, read_time
from retime.motion.rate import parse_rate
from retime.search.options import BY_NAME, OPTIONS, Option

Influence = float | list[tuple[WrittenTime, float]]
Decorator = Callable[[Callable[..., None]], Callable[..., None]]


def search_options(*, usual: Mapping[str, str], beside: Mapping[str, tuple[Decorator, ...]] | None = None) -> Decorator:
    """Make a decorator that adds every option; the command gets those that were given as one dictionary ``search``.

    Parameters
    ----------
    usual : mapping of str to str
        What help says holds where an option is not given, by the option's name: the command's own defaults.
    beside : mapping of str to decorators
        Other options, by the name of the one that they follow in help.
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
            made.append(_made(option, usual.get(option.name)))
            made += (beside or {}).get(option.name, ())
        command: Callable[..., None] = packed
        for decorator in reversed(made):
            command = decorator(command)
        return command

    return add


def _made(option: Option, usual: str | None) -> Decorator:
    """Make click's option of a declaration; `usual` is the command's own default in words."""
    if usual is None:
        usual = "" if option.usual == "none" else option.default_words
    common: dict[str, Any] = {"cls": SectionedOption, "section": option.section, "help": option.help}
    if option.kind == "flag":
        turned = not option.default
        return click.option(
            option.on_command_line, option.name, is_flag=True, flag_value=turned, default=None, **common
        )
    common |= {"metavar": option.metavar, "default_text": usual}
    if option.kind == "choice":
        choice = click.Choice([choice.value for choice in option.choices])
        return click.option(option.on_command_line, option.name, type=choice, **common)
    return click.option(option.on_command_line, option.name, callback=parsed(_reader(option)), **common)


def _reader(option: Option) -> Callable[[str], Any]:
    """Return what reads an option's text."""
    readers: dict[str, Callable[[str], Any]] = {
        "length": check_length,
        "rate": parse_rate,
        "speeds": parse_speeds,
        "influence": _influence,
    }
    if option.kind in readers:
        return readers[option.kind]
    return lambda text: option.checked(parse_number(text, whole=option.kind == "whole", unit=option.unit))


def _influence(text: str) -> Influence:
    """Read a share, or a curve ``T=V,T=V,...`` over output time."""
    if "=" not in text:
        return parse_share(text)
    curve = []
    for pair in text.split(","):
        time, _, value = pair.partition("=")
        curve.append((read_time(time), parse_share(value)))
    return curve


def search_arguments(search: Mapping[str, Any], rate: Fraction) -> dict[str, Any]:
    """Return options as `guided_warp` takes them, now that the clip's rate is known."""
    found = dict(search)
    if isinstance(curve := found.get("influence"), list):
        found["influence"] = [(float(time.at(rate)), value) for time, value in curve]
    return found


def flags_of(names: Iterable[str]) -> list[str]:
    """Return what options are called on the command line, for messages."""
    return [BY_NAME[name].on_command_line for name in names]
