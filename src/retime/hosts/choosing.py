"""Of the curves of a file, the one that is meant."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TypeVar

from retime.errors import FormatError, OptionError

T = TypeVar("T")
_MOST_NAMED = 10


def chosen(found: Mapping[str, T], item: str, what: str, where: str) -> T:
    """Return the curve that `item` names, or the only one.

    Raises
    ------
    FormatError
        There is no curve.
    OptionError
        There are several and nobody said which, or none of that name.
    """
    if not found:
        raise FormatError(f"expected {where} with a {what}, found none")
    names = ", ".join([*list(found)[:_MOST_NAMED], *["..."] * (len(found) > _MOST_NAMED)])
    if item:
        if item not in found:
            raise OptionError(f"no {what} is called {item}; there is {names} (--item)")
        return found[item]
    if len(found) > 1:
        raise OptionError(f"there are {len(found)} curves, {names}: name the one that is meant (--item)")
    return next(iter(found.values()))
