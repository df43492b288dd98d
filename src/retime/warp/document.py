"""A warp as a JSON document (format ``retime-warp``, version 1): what its files hold."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from retime.arrays import FloatArray
from retime.brief import brief_repr
from retime.errors import FormatError
from retime.limits import LEAST_GAP, MOST_SECONDS
from retime.strict_json import parse_json
from retime.warp.keytime import Keytime

_VERSION = 1
_MAX_KNOTS = 20_000_000


@dataclass(frozen=True, eq=False)
class WarpDocument:
    """What a document says; whether it makes a warp, `retime.warp.curve.Warp` tells, which has these fields.

    Attributes
    ----------
    output_times, input_times : float arrays, shape (n_knots,)
        Seconds.
    keytimes : tuple of Keytime
        Those that the warp was made to meet.
    method, name : str
        How it was found, and what it is called.
    """

    output_times: FloatArray
    input_times: FloatArray
    keytimes: tuple[Keytime, ...]
    method: str
    name: str

    __repr__ = brief_repr


def written(
    output_times: FloatArray, input_times: FloatArray, keytimes: Sequence[Keytime], *, method: str, name: str
) -> str:
    """Return the document; its numbers come back bit for bit.

    Raises
    ------
    FormatError
        It could not be read again: a time that no clip has, or knots that are too close.
    """
    _check(output_times, input_times, keytimes)
    # The output time first, as in the files of all versions.
    keys = [[key.output_time, key.input_time] + ([] if key.speed is None else [key.speed]) for key in keytimes]
    document = {
        "format": "retime-warp",
        "version": _VERSION,
        "method": method,
        "name": name,
        "keytimes": keys,
        "output_times": output_times.tolist(),
        "input_times": input_times.tolist(),
    }
    return json.dumps(document, allow_nan=False) + "\n"


def parsed(text: str | bytes) -> WarpDocument:
    """Read a document.

    Raises
    ------
    FormatError
        Not JSON, not a warp, a version from the future, a time that no clip has, or knots that are too close.
    """
    document = parse_json(text, what="a warp", prefix="not a warp: ")
    if not isinstance(document, dict) or document.get("format") != "retime-warp":
        raise FormatError('expected a warp: a JSON object with "format": "retime-warp"')
    version = document.get("version")
    if version != _VERSION or not _is_number(version):
        raise FormatError(f"warp version {version!r} is not one that this program reads (it reads {_VERSION})")
    output_times = _numbers("output_times", document.get("output_times"))
    input_times = _numbers("input_times", document.get("input_times"))
    pairs = document.get("keytimes", [])
    if not isinstance(pairs, list) or not all(isinstance(pair, list) and len(pair) in (2, 3) for pair in pairs):
        raise FormatError("keytimes: expected [output time, input time] in seconds, and a speed where it has a tangent")
    rows = [_numbers("keytimes", pair).tolist() for pair in pairs]
    keytimes = [Keytime(output_time=row[0], input_time=row[1], speed=row[2] if len(row) == 3 else None) for row in rows]
    _check(output_times, input_times, keytimes)
    texts = {key: document.get(key, "") for key in ("method", "name")}
    for key, value in texts.items():
        if not isinstance(value, str):
            raise FormatError(f"{key}: expected text, found {value!r}")
    return WarpDocument(output_times, input_times, tuple(keytimes), texts["method"], texts["name"])


def _check(output_times: FloatArray, input_times: FloatArray, keytimes: Sequence[Keytime]) -> None:
    """Refuse what would overflow, or be allocated on its claim, where it is used."""
    keyed = np.array([(key.output_time, key.input_time) for key in keytimes]).ravel()
    for key, times in (("output_times", output_times), ("input_times", input_times), ("keytimes", keyed)):
        # Written so that nan is refused too.
        far = np.flatnonzero(~(np.abs(times) <= MOST_SECONDS))
        if len(far):
            raise FormatError(f"{key}: no clip has a time of {times[far[0]]:g} s; the limit is {MOST_SECONDS:g} s")
    gaps = np.diff(output_times)
    close = np.flatnonzero((gaps > 0) & (gaps < LEAST_GAP))
    if len(close):
        knot = int(close[0])
        raise FormatError(
            f"output_times: knots {knot} and {knot + 1} are {gaps[knot]:.3g} s apart; the least is {LEAST_GAP:g} s"
        )


def _is_number(value: object) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool)


def _numbers(key: str, values: object) -> FloatArray:
    if not isinstance(values, list) or not all(_is_number(value) for value in values):
        raise FormatError(f"{key}: expected a list of numbers")
    if len(values) > _MAX_KNOTS:
        raise FormatError(f"{key}: {len(values)} knots, the limit is {_MAX_KNOTS}")
    try:
        return np.array(values, dtype=np.float64)
    except OverflowError:
        raise FormatError(f"{key}: a number is too large") from None
