"""JSON from strangers: `json.loads` alone takes NaN, 1e999, half a letter, and nesting until Python gives up."""

from __future__ import annotations

import json
import math
import re
from typing import Any

from retime.errors import FormatError

MAX_DEPTH = 64
# Only text with such escapes can hold half a letter, and only such numbers can be too large: few documents have them.
_HALF = re.compile(r"\\u[dD][89a-fA-F]")
_LONG = re.compile(r"[eE]\+?[0-9]{3}|[0-9]{300}")


def parse_json(text: str | bytes, *, what: str = "a document", prefix: str = "") -> Any:
    """Parse JSON; refuse numbers that are none or too large for one, half a letter, and nesting beyond `MAX_DEPTH`.

    Parameters
    ----------
    text : str or bytes
        Bytes are UTF-8, with or without a mark at the beginning.
    what : str
        What it is to be, for messages.
    prefix : str
        What messages about the whole begin with.

    Raises
    ------
    FormatError
        Says where and why.
    """

    def refuse(constant: str) -> None:
        raise FormatError(f"{constant} is not a number that {what} may hold")

    def finite(written: str) -> float:
        number = float(written)
        if not math.isfinite(number):
            raise FormatError(f"{prefix}the number {written[:40]} is too large")
        return number

    if isinstance(text, bytes):
        try:
            text = text.decode("utf-8-sig")
        except UnicodeDecodeError as error:
            raise FormatError("expected JSON in UTF-8", byte=error.start) from None
    too_deep = f"{prefix}JSON nested more than {MAX_DEPTH} deep"
    try:
        document = json.loads(text, parse_constant=refuse, parse_float=finite if _LONG.search(text) else None)
    except json.JSONDecodeError as error:
        raise FormatError(f"not JSON: {error.msg}", line=error.lineno, column=error.colno) from None
    except RecursionError:
        raise FormatError(too_deep) from None
    except FormatError:
        raise
    except ValueError:
        # Python refuses to read whole numbers of thousands of digits.
        raise FormatError(f"{prefix}a whole number has too many digits") from None
    may_be_half = _HALF.search(text) is not None
    level = [document]
    for _ in range(MAX_DEPTH):
        if may_be_half:
            _refuse_halves(level, prefix)
        inside = (node.values() if isinstance(node, dict) else node for node in level if isinstance(node, dict | list))
        level = [child for children in inside for child in children if isinstance(child, dict | list)]
        if not level:
            return document
    raise FormatError(too_deep)


def _refuse_halves(level: list[Any], prefix: str) -> None:
    """Refuse texts with half of a letter that is written as two: such text can't be written to any file, or shown."""
    for node in level:
        for one in (*node, *node.values()) if isinstance(node, dict) else node if isinstance(node, list) else (node,):
            if isinstance(one, str) and not one.isascii() and any("\ud800" <= letter <= "\udfff" for letter in one):
                shown = json.dumps(one)
                shown = shown if len(shown) <= 60 else f"{shown[:57]}..."
                raise FormatError(f"{prefix}half a letter (a lone surrogate) in {shown}")
