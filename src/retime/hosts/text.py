"""Reading the texts of other programs: bytes as text, numbers strictly, the place of what is wrong."""

from __future__ import annotations

import bisect
import json
import re
from typing import Any

from retime.brief import brief
from retime.errors import FormatError
from retime.formats.number_text import NumberTextError, parse_number
from retime.strict_json import parse_json


def decoded(data: bytes) -> str:
    """Return UTF-8 text without its mark; raise FormatError for anything else."""
    try:
        text = data.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        raise FormatError("expected text in UTF-8", byte=error.start) from None
    if "\0" in text:
        raise FormatError("expected text, found a NUL: a binary file?", byte=text.index("\0"))
    return text


class Lines:
    """The lines of a text, for messages.

    Parameters
    ----------
    text : str
        The whole text.
    """

    def __init__(self, text: str) -> None:
        self._ends = [match.start() for match in re.finditer("\n", text)]

    def at(self, offset: int) -> int:
        """Return the line, counted from 1, in which an offset lies."""
        return bisect.bisect_left(self._ends, offset) + 1


def number(token: str, line: int | None = None) -> float:
    """Read one number of a file.

    Raises
    ------
    FormatError
        Not a finite decimal number.
    """
    try:
        return parse_number(token.encode())
    except NumberTextError as error:
        raise FormatError(error.problem, line=line) from None


def json_number(value: Any, what: str) -> float:
    """Take a number of a JSON document; raise FormatError for anything else."""
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise FormatError(f"{what}: expected a number, found {brief(value)}")
    if not abs(value) <= 1e100:
        raise FormatError(f"{what}: expected a number that a time can be, found {str(value)[:40]}")
    return float(value)


def script_numbers(text: str, name: str) -> list[float]:
    """Read a list of numbers that a script of our own gives a name: ``name = [0, 1.5]`` on one line.

    Raises
    ------
    FormatError
        There is no such list.
    """
    match = re.search(rf"^\s*(?:var )?{re.escape(name)} = (\[[^\]\n]*\]);?$", text, re.MULTILINE)
    if match is None:
        raise FormatError(f"expected a script that retime wrote, with a list {name}")
    values = parse_json(match[1], what="a curve")
    return [json_number(value, name) for value in values]


def quoted(text: str) -> str:
    """Write text as JavaScript, Python and MEL quote it; what is not ASCII becomes an escape."""
    return json.dumps(text)
