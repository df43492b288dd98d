"""Options of the search as people write them: text, read by its declared kind before a clip's rate is known."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from fractions import Fraction
from typing import Any

from retime.motion.grammar import (
    WrittenTime,
    check_length,
    parse_number,
    parse_share,
    parse_speeds,
    read_time,
)
from retime.motion.rate import parse_rate
from retime.search.options import Option

WrittenInfluence = float | list[tuple[WrittenTime, float]]


def option_reader(option: Option) -> Callable[[str], Any]:
    """Return what reads an option's text, and raises OptionError; a flag is read by nobody."""
    readers: dict[str, Callable[[str], Any]] = {
        "length": check_length,
        "rate": parse_rate,
        "speeds": parse_speeds,
        "influence": _influence,
        "choice": option.checked,
    }
    if option.kind in readers:
        return readers[option.kind]
    return lambda text: option.checked(parse_number(text, whole=option.kind == "whole", unit=option.unit))


def _influence(text: str) -> WrittenInfluence:
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
