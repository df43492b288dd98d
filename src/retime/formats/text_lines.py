"""Text files from anywhere: byte order marks, line ends of every kind, and a reader of lines and tokens."""

from __future__ import annotations

import codecs
import re
from os import PathLike
from typing import NoReturn

from retime.errors import FormatError
from retime.formats.read_options import Limits

LINE_END = re.compile(rb"\r\n?|\n")
_TOKEN = re.compile(rb"[^ \t\v\f]+")
_NOT_BLANK = re.compile(rb"[^ \t\r\n\v\f]")
_BLANKS = b" \t\r\n\v\f"
_PADDING = b"\0\x1a"
_UTF16 = ((codecs.BOM_UTF16_LE, "utf-16-le"), (codecs.BOM_UTF16_BE, "utf-16-be"))


def count_line_ends(text: bytes) -> int:
    r"""Count the line ends of a text, each a LF, CR or CRLF.

    Examples
    --------
    >>> count_line_ends(b"a\r\nb\rc\n")
    3
    """
    ends = text.count(b"\n")
    # The search for two bytes is the slow one, and most files have no CR.
    return ends + text.count(b"\r") - text.count(b"\r\n") if b"\r" in text else ends


def without_byte_order_mark(path: str | PathLike[str], data: bytes) -> bytes:
    """Return a text file's bytes as UTF-8 (or whatever has no mark), its byte order mark taken off.

    Raises
    ------
    FormatError
        The mark says UTF-16, and the rest is not.
    """
    if data.startswith(codecs.BOM_UTF8):
        return data[len(codecs.BOM_UTF8) :]
    for mark, encoding in _UTF16:
        if data.startswith(mark):
            try:
                return data[len(mark) :].decode(encoding).encode("utf-8")
            except UnicodeError:
                raise FormatError("begins like UTF-16 text, but can't be decoded as such", path=path) from None
    return data


def utf8_text(path: str | PathLike[str], data: bytes) -> str:
    r"""Return a text file's letters, where they are UTF-8, or UTF-16 with its mark.

    Raises
    ------
    FormatError
        They are neither; says in which line.

    Examples
    --------
    >>> utf8_text("a.csv", b"\xef\xbb\xbfa,b\n")
    'a,b\n'
    """
    data = without_byte_order_mark(path, data)
    try:
        return data.decode("utf-8")
    except UnicodeDecodeError as error:
        line = count_line_ends(data[: error.start]) + 1
        raise FormatError("expected UTF-8 text, found other bytes", path=path, line=line) from None


def without_end_padding(data: bytes) -> bytes:
    r"""Return a text file's bytes without what some writers fill up its end with: zeros, DOS's sign of an end (^Z).

    What stands before is left as it is, and so is a file of nothing else, or one where a value is missing there.

    Examples
    --------
    >>> without_end_padding(b"1 2\n\x1a\0\0\n")
    b'1 2\n'
    """
    # The end of a long file is enough to look at, unless it is all padding.
    for end in (data[-4096:], data):
        text = end.rstrip(_PADDING + _BLANKS)
        if text:
            break
    else:
        return data
    padding = end[len(text) :]
    left_out = len(padding.lstrip(_BLANKS))
    # Right after a comma a value was to come.
    return data[: len(data) - left_out] if text[-1:] not in b",;" else data


class Lines:
    """A text file's lines and tokens, from the front; lines end in LF, CR or CRLF.

    Attributes
    ----------
    number : int
        The line at hand, counted from 1.
    next_start : int
        Offset of the line after it.
    """

    def __init__(self, data: bytes, path: str | PathLike[str], limits: Limits) -> None:
        self.data = data
        self.path = path
        self.limits = limits
        self.number = 0
        self.next_start = 0
        self._start = self._at = self._end = 0
        self._go_on()

    def _go_on(self) -> bool:
        """Move to the next line; False at the end of the file."""
        if self.number and self.next_start >= len(self.data):
            return False
        self.number += 1
        self._start = self._at = self.next_start
        longest = self.limits.line_bytes
        # The longest allowed line and its CRLF end two bytes past the limit; looking further is no use.
        match = LINE_END.search(self.data, self._start, self._start + longest + 2)
        if match is None:
            self._end = self.next_start = len(self.data)
        else:
            self._end, self.next_start = match.span()
        if self._end - self._start > longest:
            self.fail(f"the line is longer than {longest} bytes (Limits.line_bytes)")
        return True

    def fail(self, problem: str, *, line: int | None = None, column: int | None = None) -> NoReturn:
        """Raise a FormatError at the line at hand, or at another."""
        raise FormatError(problem, path=self.path, line=line or self.number, column=column)

    def token_on_line(self) -> bytes | None:
        """Take the next token of this line; None where it has no more."""
        match = _TOKEN.search(self.data, self._at, self._end)
        if match is None:
            self._at = self._end
            return None
        self._at = match.end()
        return match[0]

    def token(self) -> bytes | None:
        """Take the next token of this line or a later one; None at the end of the file."""
        while (token := self.token_on_line()) is None:
            if not self._go_on():
                return None
        return token

    def put_back(self, token: bytes) -> None:
        """Put back the token that was taken last."""
        self._at -= len(token)

    def column_of(self, token: bytes) -> int:
        """Return the column, from 1, of the token that was taken last."""
        return len(self.data[self._start : self._at - len(token)].decode("utf-8", "replace")) + 1

    def rest(self) -> bytes:
        """Take the rest of this line, without white space around it."""
        rest = self.data[self._at : self._end].strip()
        self._at = self._end
        return rest

    def at_end(self) -> bool:
        """Say whether nothing but white space is left."""
        return _NOT_BLANK.search(self.data, self._at) is None

    def put_back_line(self) -> None:
        """Make the line at hand the next one again."""
        self.next_start = self._start
        self._at = self._end = self._start
        self.number -= 1
