"""JSON from strangers: `json.loads` alone takes NaN, and nesting until the interpreter gives up."""

from __future__ import annotations

import json
from typing import Any

from retime.errors import FormatError

MAX_DEPTH = 64


def parse_json(text: str | bytes, *, what: str = "a document", prefix: str = "") -> Any:
    """Parse JSON; refuse numbers that are none, and nesting deeper than `MAX_DEPTH`.

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

    if isinstance(text, bytes):
        try:
            text = text.decode("utf-8-sig")
        except UnicodeDecodeError as error:
            raise FormatError("expected JSON in UTF-8", byte=error.start) from None
    too_deep = f"{prefix}JSON nested more than {MAX_DEPTH} deep"
    try:
        document = json.loads(text, parse_constant=refuse)
    except json.JSONDecodeError as error:
        raise FormatError(f"not JSON: {error.msg}", line=error.lineno, column=error.colno) from None
    except RecursionError:
        raise FormatError(too_deep) from None
    except FormatError:
        raise
    except ValueError:
        # Python refuses to read whole numbers of thousands of digits.
        raise FormatError(f"{prefix}a whole number has too many digits") from None
    level = [document]
    for _ in range(MAX_DEPTH):
        inside = (node.values() if isinstance(node, dict) else node for node in level if isinstance(node, dict | list))
        level = [child for children in inside for child in children if isinstance(child, dict | list)]
        if not level:
            return document
    raise FormatError(too_deep)
