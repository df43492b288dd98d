"""Change a few members of a JSON text, and leave every other byte as it was.

A program that reads JSON and writes it again changes spaces, escapes and the digits of numbers. What nobody asked to be
changed is copied here.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from typing import Any

_SPACE = " \t\r\n"


def spliced(text: str, members: Mapping[str, Any]) -> str:
    r"""Replace top-level members of a JSON object; those that it lacks are added at its end.

    Where old and new value are both lists, elements that are equal stay as they were written.

    Parameters
    ----------
    text : str
        A JSON object, already known to be valid.
    members : mapping of str to JSON values
        The new values.

    Returns
    -------
    str

    Examples
    --------
    >>> spliced('{ "a": [1.0,  2],\n"b" : {"c": 1e0} }', {"a": [1.0, 3], "d": True})
    '{ "a": [1.0,  3],\n"b" : {"c": 1e0} ,"d":true}'
    """
    spans, close = _members(text)
    parts, place = [], 0
    for name, (start, stop) in spans.items():
        if name in members:
            parts += [text[place:start], _new_value(text, start, stop, members[name])]
            place = stop
    parts.append(text[place:close])
    missing = [name for name in members if name not in spans]
    for name in missing:
        comma = "," if spans or name != missing[0] else ""
        parts.append(f"{comma}{json.dumps(name)}:{_written(members[name])}")
    parts.append(text[close:])
    return "".join(parts)


def _written(value: Any) -> str:
    return json.dumps(value, separators=(",", ":"), ensure_ascii=False, allow_nan=False)


def _new_value(text: str, start: int, stop: int, value: Any) -> str:
    old = json.loads(text[start:stop])
    if old == value:
        return text[start:stop]
    if not (isinstance(old, list) and isinstance(value, list)):
        return _written(value)
    spans = _elements(text, start)
    parts, place = [], start
    for (first, last), before, after in zip(spans, old, value, strict=False):
        parts += [text[place:first], text[first:last] if before == after else _written(after)]
        place = last
    more = value[len(old) :]
    if len(value) < len(old):
        # What lies between the last element that stays and the bracket goes with those that were dropped.
        return "".join(parts).rstrip() + "]" if value else "[]"
    added = ("," if old else "") + ",".join(_written(one) for one in more) if more else ""
    parts += [added, text[place:stop]] if old else ["[", added, "]"]
    return "".join(parts)


def _skip(text: str, place: int) -> int:
    while text[place] in _SPACE:
        place += 1
    return place


def _members(text: str) -> tuple[dict[str, tuple[int, int]], int]:
    """Find where each member's value stands in an object, and its closing brace. Of a repeated name the last counts."""
    decode = json.JSONDecoder().raw_decode
    place = _skip(text, 0) + 1
    spans: dict[str, tuple[int, int]] = {}
    while True:
        place = _skip(text, place)
        if text[place] == "}":
            return spans, place
        if text[place] == ",":
            place = _skip(text, place + 1)
        name, place = decode(text, place)
        start = _skip(text, _skip(text, place) + 1)
        _, place = decode(text, start)
        # A name said twice is put at its later place, as json.loads has it.
        spans.pop(name, None)
        spans[name] = (start, place)


def _elements(text: str, start: int) -> list[tuple[int, int]]:
    """Find where each element of a list stands."""
    decode = json.JSONDecoder().raw_decode
    place = start + 1
    spans: list[tuple[int, int]] = []
    while True:
        place = _skip(text, place)
        if text[place] == "]":
            return spans
        if text[place] == ",":
            place = _skip(text, place + 1)
        _, stop = decode(text, place)
        spans.append((place, stop))
        place = stop
