"""Decimal numbers in text: read strictly, and written fast.

A number is ``[+-]digits[.digits][e[+-]digits]`` in ASCII digits; ``.5`` and ``5.`` count too. Python's
parsers take more (``1_0``, ``nan``, the digits of other scripts), and some of NumPy's take two numbers run
together for two. Here every token is one finite number, or an error says where it stands.

`retime.formats.number_rows` reads many rows at once, and answers None where anything is unusual. `parse_numbers`
takes the same text, a line at a time, and names the first token at fault.
"""

from __future__ import annotations

import math
import re

import numpy as np

from retime.arrays import FloatArray
from retime.kernels import backend
from retime.motion.size import LARGEST

_UNSIGNED = rb"(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eE][+-]?[0-9]+)?"
_NUMBER = re.compile(rb"[+-]?" + _UNSIGNED)
_RUN_TOGETHER = re.compile(rb"[+-]?" + _UNSIGNED + rb"(?:[+-]" + _UNSIGNED + rb")+")
# A sign that stands after a digit or a point; after an e it would be the exponent's.
_NEXT_NUMBER = re.compile(rb"(?<=[0-9.,])[+-]")
_WITH_COMMA = re.compile(rb"[+-]?[0-9]*,[0-9]+(?:[eE][+-]?[0-9]+)?")
_NOT_FINITE = re.compile(rb"[+-]?(?:nan|inf|infinity|[0-9]\.#\w+)", re.IGNORECASE)
_COUNT = re.compile(rb"\+?[0-9]+")
_TOKEN = re.compile(rb"[^ \t\r\n\v\f]+")
_NUMBER_BYTES = b"0123456789+-.eE \t\r\n"


class NumberTextError(ValueError):
    """A token is not a number.

    Attributes
    ----------
    problem : str
        What was expected and what was found.
    offset : int
        The token's first byte in the text that was parsed.
    index : int
        How many tokens stand before it in that text.
    """

    def __init__(self, problem: str, *, offset: int = 0, index: int = 0) -> None:
        self.problem = problem
        self.offset = offset
        self.index = index
        super().__init__(problem)


def show(token: bytes) -> str:
    """Quote a piece of a file for a message: readable, on one line, no longer than 40 characters.

    Examples
    --------
    >>> show(b"Hips")
    "'Hips'"
    """
    text = token[:200].decode("utf-8", "backslashreplace")
    return repr(text if len(text) <= 40 else text[:37] + "...")


def parse_number(token: bytes, *, decimal_comma: bool = False) -> float:
    """Parse one number.

    Parameters
    ----------
    token : bytes
        Text without white space.
    decimal_comma : bool
        Take ``0,5`` for 0.5.

    Raises
    ------
    NumberTextError
        Not a finite decimal number, or one beyond 1e100.

    Examples
    --------
    >>> parse_number(b"-.5e1"), parse_number(b"0,5", decimal_comma=True)
    (-5.0, 0.5)
    """
    plain = token.replace(b",", b".") if decimal_comma else token
    if not _NUMBER.fullmatch(plain):
        raise NumberTextError(_explain(token, decimal_comma))
    value = float(plain)
    if not math.isfinite(value):
        raise NumberTextError(f"expected a finite number, found {show(token)}, which is too large for one")
    if abs(value) > LARGEST:
        raise NumberTextError(f"expected a number of {LARGEST:g} at most, found {show(token)}")
    return value


def _explain(token: bytes, decimal_comma: bool) -> str:
    if _NOT_FINITE.fullmatch(token):
        return f"expected a finite number, found {show(token)}"
    plain = token.replace(b",", b".") if decimal_comma else token
    if _RUN_TOGETHER.fullmatch(plain):
        first = _NUMBER.match(plain)
        assert first is not None
        rest = token[first.end() :]
        return f"numbers run together in {show(token)}: expected white space before {show(rest)}"
    if not decimal_comma and _WITH_COMMA.fullmatch(token):
        return (
            f"expected a number, found {show(token)}; if this file writes decimals with a comma, "
            "say so (--decimal-comma, decimal_comma=True)"
        )
    digits = "" if token.isascii() else " in the digits 0-9"
    return f"expected a number{digits}, found {show(token)}"


def parse_count(token: bytes) -> int:
    """Parse a count: a whole number in plain digits, not negative.

    More than 18 digits come back as 10**18: nothing holds as many, and the caller's limit refuses it.

    Raises
    ------
    NumberTextError
        Anything else.

    Examples
    --------
    >>> parse_count(b"120")
    120
    """
    if not _COUNT.fullmatch(token):
        raise NumberTextError(f"expected a whole number of 0 or more, found {show(token)}")
    digits = token.lstrip(b"+0") or b"0"
    return 10**18 if len(digits) > 18 else int(digits)


def count_of(text: str) -> int | None:
    """Return the count that a text is, a whole number in plain digits; None where it is anything else.

    ``str.isdigit`` is no guard for ``int``: it takes ``²``, and Python refuses thousands of digits. More than 300 come
    back as 10**300, which no count equals.

    Examples
    --------
    >>> count_of("0120"), count_of("²"), count_of("-1"), count_of("9" * 5000) == 10**300
    (120, None, None, True)
    """
    if not (text.isascii() and text.isdigit()):
        return None
    digits = text.lstrip("0") or "0"
    return 10**300 if len(digits) > 300 else int(digits)


def parse_numbers(text: bytes, *, decimal_comma: bool = False) -> list[float]:
    """Parse numbers with white space between them: a line, or several.

    Raises
    ------
    NumberTextError
        For the first token that is not a number, with its `offset` in the text and its `index`.

    Examples
    --------
    >>> parse_numbers(b"1 -.5 2e3")
    [1.0, -0.5, 2000.0]
    """
    plain = text.replace(b",", b".") if decimal_comma else text
    if not plain.translate(None, _NUMBER_BYTES):
        # With these characters alone float() takes exactly the grammar above, and it rounds correctly.
        try:
            values = list(map(float, plain.split()))
        except ValueError:
            values = [math.nan]
        if min(values, default=0.0) >= -LARGEST and max(values, default=0.0) <= LARGEST:
            return values
    values = []
    for match in _TOKEN.finditer(text):
        try:
            values.append(parse_number(match[0], decimal_comma=decimal_comma))
        except NumberTextError as error:
            raise NumberTextError(error.problem, offset=match.start(), index=len(values)) from None
    return values


def part_glued(text: bytes, *, decimal_comma: bool = False) -> bytes:
    """Put white space between numbers that run together, where a sign begins the next one; leave all else alone.

    Whether they were two numbers is the caller's to tell, by how many it expects.

    Examples
    --------
    >>> part_glued(b"1 0.0-7.5 2e-3-4 x-1")
    b'1 0.0 -7.5 2e-3 -4 x-1'
    """

    def parted(match: re.Match[bytes]) -> bytes:
        token = match[0]
        plain = token.replace(b",", b".") if decimal_comma else token
        return _NEXT_NUMBER.sub(rb" \g<0>", token) if _RUN_TOGETHER.fullmatch(plain) else token

    return _TOKEN.sub(parted, text)


def format_table(values: FloatArray) -> bytes:
    r"""Write rows of numbers with six decimals, a space between two and a line feed after each row.

    The text is that of ``"%.6f"``, but for a zero, which never has a sign, and for a number halfway between two last
    digits, which may go either way. It takes a third of the time; the memory used is some thirty bytes a number, so a
    long table is best written in pieces.

    Parameters
    ----------
    values : float array, shape (n_rows, n_columns)
        Finite numbers.

    Examples
    --------
    >>> format_table(np.array([[1.5, -20.0], [-1e-9, 0.1]]))
    b'1.500000 -20.000000\n0.000000 0.100000\n'
    """
    if not values.shape[1]:
        return b"\n" * len(values)
    if values.size and not max(values.max(), -values.min()) < 1e9:
        row_text = " ".join(["%.6f"] * values.shape[1]) + "\n"
        return "".join([row_text % tuple(row) for row in values.tolist()]).encode()
    return backend(warn=False).write_rows(np.ascontiguousarray(values))
