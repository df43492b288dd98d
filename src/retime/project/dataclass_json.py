"""Frozen dataclasses to JSON and back, strictly: what comes back has every field of the right kind, and no other.

`json.loads` alone takes NaN, text where a number should be, and any field; a document from a stranger must not.
"""

from __future__ import annotations

import dataclasses
import functools
import json
import math
import types
from collections.abc import Mapping
from typing import Any, Literal, TypeVar, Union, cast, get_args, get_origin, get_type_hints, is_typeddict

from retime.errors import FormatError

Value = TypeVar("Value")

# Of a list. No document that a person makes has as many keytimes.
MAX_ITEMS = 100_000
# Beyond this a double no longer tells neighbouring whole numbers apart, nor does a page.
MAX_INT = 2**53


def to_value(thing: Any) -> Any:
    """Turn dataclasses (and tuples of them) into what JSON can hold."""
    if dataclasses.is_dataclass(thing) and not isinstance(thing, type):
        return {field.name: to_value(getattr(thing, field.name)) for field in dataclasses.fields(thing)}
    if isinstance(thing, tuple | list):
        return [to_value(item) for item in thing]
    if isinstance(thing, dict):
        return {key: to_value(item) for key, item in thing.items()}
    return thing


def to_json(thing: Any, *, indent: int | None = None) -> str:
    """Write a value as JSON; numbers come back bit for bit."""
    return json.dumps(to_value(thing), allow_nan=False, ensure_ascii=False, indent=indent)


@functools.cache
def _hints(kind: type) -> Mapping[str, Any]:
    return get_type_hints(kind)


def from_value(kind: type[Value], value: Any, where: str) -> Value:
    """Make a value of a kind from parsed JSON.

    Parameters
    ----------
    kind : type
        A dataclass, or one of bool, int, float, str, None, a Literal, a union of these, ``tuple[kind, ...]``, a tuple
        of given kinds, ``dict[str, kind]``, or a TypedDict whose keys may all be left out; null is as good as that.
    value : object
        From `retime.strict_json.parse_json`.
    where : str
        What to call it in messages.

    Raises
    ------
    FormatError
        Names the field, what was expected and what was found.
    """
    return cast(Value, _convert(kind, value, where))


def _convert(kind: Any, value: Any, where: str) -> Any:
    origin = get_origin(kind)
    if origin in (Union, types.UnionType):
        return _convert_union(kind, value, where)
    if origin is Literal:
        if value not in get_args(kind) or isinstance(value, bool):
            raise FormatError(f"{where}: expected one of {', '.join(map(str, get_args(kind)))}; found {_shown(value)}")
        return value
    if origin is tuple:
        return _convert_tuple(kind, value, where)
    if origin is dict:
        _check_object(value, where)
        return {key: _convert(get_args(kind)[1], item, f"{where}.{_name(key)}") for key, item in value.items()}
    if is_typeddict(kind):
        return _convert_given(kind, value, where)
    if dataclasses.is_dataclass(kind):
        return _convert_dataclass(kind, value, where)
    return _convert_plain(kind, value, where)


def _convert_union(kind: Any, value: Any, where: str) -> Any:
    choices = [choice for choice in get_args(kind) if choice is not type(None)]
    if value is None and len(choices) < len(get_args(kind)):
        return None
    if len(choices) != 1:
        raise TypeError(f"{where}: only a kind or None can be told apart, not {kind}")
    return _convert(choices[0], value, where)


def _convert_tuple(kind: Any, value: Any, where: str) -> tuple[Any, ...]:
    if not isinstance(value, list):
        raise FormatError(f"{where}: expected a list, found {_shown(value)}")
    items = get_args(kind)
    if items[-1] is Ellipsis:
        if len(value) > MAX_ITEMS:
            raise FormatError(f"{where}: {len(value)} items, the limit is {MAX_ITEMS}")
        items = (items[0],) * len(value)
    elif len(value) != len(items):
        raise FormatError(f"{where}: expected {len(items)} items, found {len(value)}")
    return tuple(_convert(item, one, f"{where}[{i}]") for i, (item, one) in enumerate(zip(items, value, strict=True)))


def _convert_given(kind: Any, value: Any, where: str) -> dict[str, Any]:
    _check_object(value, where)
    hints = _hints(kind)
    _refuse_unknown(value, hints, where)
    # In the declaration's order, so that the same options are written as the same text, whoever gave them.
    return {
        name: _convert(hint, value[name], f"{where}.{name}")
        for name, hint in hints.items()
        if value.get(name) is not None
    }


def _convert_dataclass(kind: Any, value: Any, where: str) -> Any:
    _check_object(value, where)
    fields = {field.name: field for field in dataclasses.fields(kind)}
    _refuse_unknown(value, fields, where)
    hints, given = _hints(kind), {}
    for name, field in fields.items():
        if name in value:
            given[name] = _convert(hints[name], value[name], f"{where}.{name}")
        elif field.default is dataclasses.MISSING and field.default_factory is dataclasses.MISSING:
            raise FormatError(f"{where}: {name} is missing")
    return kind(**given)


def _convert_plain(kind: Any, value: Any, where: str) -> Any:
    if kind is bool:
        if not isinstance(value, bool):
            raise FormatError(f"{where}: expected true or false, found {_shown(value)}")
        return value
    if kind is str:
        if not isinstance(value, str):
            raise FormatError(f"{where}: expected text, found {_shown(value)}")
        if not value.isascii() and any("\ud800" <= letter <= "\udfff" for letter in value):
            raise FormatError(f"{where}: half a letter (a lone surrogate) in {_shown(value)}")
        return value
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise FormatError(f"{where}: expected a number, found {_shown(value)}")
    if kind is int:
        if isinstance(value, float) or abs(value) > MAX_INT:
            raise FormatError(f"{where}: expected a whole number, found {_shown(value)}")
        return value
    assert kind is float, kind
    try:
        number = float(value)
    except OverflowError:
        number = math.inf
    if not math.isfinite(number):
        raise FormatError(f"{where}: the number is too large")
    return number


def _check_object(value: Any, where: str) -> None:
    if not isinstance(value, dict):
        raise FormatError(f"{where}: expected an object, found {_shown(value)}")


def _refuse_unknown(value: Mapping[str, Any], known: Mapping[str, Any], where: str) -> None:
    for name in value:
        if name not in known:
            raise FormatError(f"{where}: unknown field {_shown(name)}; it has {', '.join(known)}")


def _name(key: str) -> str:
    return key if len(key) <= 40 else key[:40] + "…"


def _shown(value: Any) -> str:
    """Show a value in a message, shortly."""
    if isinstance(value, dict | list):
        return "an object" if isinstance(value, dict) else "a list"
    text = json.dumps(value, ensure_ascii=True)
    return text if len(text) <= 60 else text[:57] + "..."
