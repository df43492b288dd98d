"""The text of a table, up to its rows of numbers: encoding, delimiter, what stands above, and how rows are parted."""

from __future__ import annotations

import csv
import re
from collections.abc import Iterator
from io import BytesIO
from itertools import islice
from pathlib import Path

from retime.errors import FormatError
from retime.formats.number_text import NumberTextError, parse_number
from retime.formats.read_options import ReadOptions
from retime.formats.tables import Head, Layout, find_layout
from retime.formats.tables.layout import Row

# Rows are parsed in pieces of this size: parsing takes several times the memory of its text.
PIECE_BYTES = 1 << 22
# So many rows, and bytes, may stand above the numbers.
_HEAD_ROWS = 40
_HEAD_BYTES = 1 << 22
_SEPARATOR = re.compile(rb"\s*\"?sep=([^\n])\"?[ \t]*\n", re.IGNORECASE)


class TableText:
    """The text of one file.

    Parameters
    ----------
    path : Path
        The file, for messages.
    data : bytes
        What it holds, without a mark at its beginning and without zeros.
    options : ReadOptions
        What the reader was told.

    Attributes
    ----------
    delimiter : str
        What parts cells.
    layout : Layout
        What the head says.
    names : tuple of str
        Of the columns.
    body, body_line : int
        Where the rows of numbers begin: the offset, and the line, counted from 1.
    """

    def __init__(self, path: Path, data: bytes, options: ReadOptions) -> None:
        self.path = path
        self.options = options
        if b"\r" in data:
            data = data.replace(b"\r\n", b"\n").replace(b"\r", b"\n")
        self.data = data
        try:
            data.decode("utf-8")
            self.encoding = "utf-8"
        except UnicodeDecodeError:
            self.encoding = "cp1252"
        # A spreadsheet's own first line, which says what parts the cells.
        said = _SEPARATOR.match(data)
        self.body = 0 if said is None else said.end()
        self.body_line = 1 + data.count(b"\n", 0, self.body)
        self.delimiter = self._find_delimiter() if said is None else said[1].decode("latin-1")
        if not self.delimiter.isascii() or self.delimiter.isalnum() or self.delimiter in "\"'+-.":
            raise self.error(1, f"sep= names what parts the cells: one of , ; | or a tab, found {self.delimiter!r}")
        self.layout = self._header()
        self.names = self.layout.names

    def error(self, line: int | None, problem: str) -> FormatError:
        """Make an error about this file, at a line."""
        return FormatError(problem, path=self.path, line=line)

    def _find_delimiter(self) -> str:
        """Take a tab or semicolon where the first line that isn't blank has one, outside of quotes; else the comma."""
        # A quoted name may hold line ends and delimiters, so quoted text is emptied first.
        plain = re.sub(rb'"[^"]*"', b'""', self.data[:PIECE_BYTES])
        first = next((line for line in BytesIO(plain) if line.strip()), b"")
        for delimiter in "\t;":
            # A single column may have white space around it; that is no delimiter.
            if delimiter.encode() in first.strip():
                return delimiter
        return "," if not self.options.decimal_comma else ";"

    def rows(self, data: bytes, first_line: int) -> Iterator[tuple[int, int, list[str]]]:
        """Yield each row's line, the offset after it, and its fields; blank rows are left out."""
        offset = 0
        limit = self.options.limits.line_bytes

        def lines() -> Iterator[str]:
            nonlocal offset
            for number, line in enumerate(BytesIO(data), first_line):
                if len(line) > limit:
                    raise self.error(
                        number, f"the line has {len(line)} bytes, the limit is {limit} (Limits.line_bytes)"
                    )
                offset += len(line)
                yield line.decode(self.encoding, "replace")

        if self.delimiter == " ":
            for number, text in enumerate(lines(), first_line):
                if fields := text.split():
                    yield number, offset, fields
            return
        reader = csv.reader(lines(), delimiter=self.delimiter, strict=True)
        before = 0
        while True:
            try:
                row = next(reader)
            except StopIteration:
                return
            except csv.Error as error:
                raise self.error(first_line + before, f"not a row of a table: {error}") from None
            fields = [field.strip() for field in row]
            if fields and fields != [""]:
                yield first_line + before, offset, fields
            before = reader.line_num

    def _header(self) -> Layout:
        """Read what stands above the rows of numbers; leave the body behind it."""
        begin, begin_line = self.body, self.body_line
        rows = []
        try:
            head = self.rows(self.data[begin : begin + _HEAD_BYTES], begin_line)
            for line, offset, fields in islice(head, _HEAD_ROWS):
                rows.append(Row(line, begin + offset, tuple(fields)))
        except FormatError:
            # What is wrong below the first row is said when it is reached, and what is above may be kept (--repair).
            if not rows:
                raise
        if not rows:
            raise self.error(None, "the file is blank; expected a table of numbers")
        layout = find_layout(Head(tuple(rows), self.delimiter, self.numeric, self.error))
        self.delimiter = layout.delimiter
        n_columns, limits = len(layout.names), self.options.limits
        if n_columns > limits.channels:
            raise self.error(
                layout.names_line, f"{n_columns} columns, the limit is {limits.channels} (Limits.channels)"
            )
        if layout.start:
            self.body = layout.start
            self.body_line = 1 + self.data.count(b"\n", 0, self.body)
        columns: dict[str, int] = {}
        for i, name in enumerate(layout.names, 1):
            if not name and i - 1 not in layout.left_out:
                raise self.unnamed(layout, i)
            if len(name.encode()) > limits.name_bytes:
                raise self.error(
                    layout.names_line,
                    f"the name of column {i} is longer than {limits.name_bytes} bytes (Limits.name_bytes)",
                )
            if name in columns:
                raise self.error(
                    layout.names_line,
                    f"columns {columns[name]} and {i} are both called {name!r}; each needs its own name",
                )
            columns[name] = i
        return layout

    def unnamed(self, layout: Layout, column: int) -> FormatError:
        """Make the error about a column, counted from 1, that has no name."""
        return self.error(layout.names_line, f"column {column} of {len(layout.names)} has no name")

    def first_row(self) -> list[str]:
        """Return the cells of the first row of numbers, if there is one."""
        for _, _, fields in self.rows(self.data[self.body : self.body + _HEAD_BYTES], self.body_line):
            return fields
        return []

    def numeric(self, field: str) -> bool:
        """Whether a field of the first row is meant as a number, be it one that is refused later."""
        try:
            parse_number(field.encode(), decimal_comma=self.options.decimal_comma)
        except NumberTextError:
            return re.fullmatch(r"[+-]?(nan|inf|infinity)", field, re.IGNORECASE) is not None
        return True

    def line_of_row(self, wanted: int) -> int:
        """Find the line of a row of numbers."""
        for row, (line, _, _) in enumerate(self.rows(self.data[self.body :], self.body_line)):
            if row == wanted:
                return line
        raise AssertionError("the row was read from this file")
