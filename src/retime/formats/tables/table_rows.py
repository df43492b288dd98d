"""The rows of a table as numbers: read fast where they are plain, and carefully where they are not."""

from __future__ import annotations

import math
import re
from array import array
from collections.abc import Iterator, Mapping
from itertools import islice

import numpy as np

from retime.arrays import FloatArray
from retime.errors import FormatError
from retime.formats.channel_meaning import GAPS_HINT
from retime.formats.number_rows import parse_rows
from retime.formats.number_text import NumberTextError, parse_number, part_glued
from retime.formats.tables.table_text import PIECE_BYTES, TableText
from retime.formats.tables.time_text import form_of_text
from retime.motion.clock import ClockForm

ESCAPED = re.compile(r"'[\s]*[=+\-@]")
"""What a text begins with that was quoted, for a spreadsheet would take it for a formula."""
# How a value that is missing is written.
_GAPS = {"", "nan", "-nan", "na", "n/a", "#n/a", "null", "none"}
# A word of a text begins otherwise: what begins like this is a number, or one that is written wrongly.
_LIKE_A_NUMBER = re.compile(r"[+-]?[.,]?\d|[+-]?(nan|inf|infinity)$", re.IGNORECASE)
_DAY = re.compile(r"\d{4}([-/])\d\d\1\d\d|\d\d?([./])\d\d?\2\d{4}", re.ASCII)
# By so many rows it is told which columns are text.
_ROWS_TO_TELL = 1000


class TableRows:
    """The rows of one file.

    Parameters
    ----------
    text : TableText
        Its text.
    clocks : mapping of int to str
        Columns that may hold times, the likeliest first, each with the form of its text ("" of numbers).

    Attributes
    ----------
    values : float array, shape (n_rows, n_columns)
        Numbers; 0 where a text is.
    time_texts : dict of int to list of str
        Of each column of times that is text, its cells.
    texts : dict of int to list of str, optional
        Columns of text, found where a row is first met that is not all numbers.
    """

    def __init__(self, text: TableText, clocks: Mapping[int, ClockForm | str]) -> None:
        self.text = text
        self.clocks = clocks
        self.time_texts: dict[int, list[str]] = {column: [] for column, form in clocks.items() if form}
        self.values = np.empty((0, len(text.names)))
        # Lines of rows whose numbers ran together and were parted.
        self.glued: list[int] = []
        self.texts: dict[int, list[str]] | None = None

    def read(self) -> list[str]:
        """Read all rows; the notes say what was cut off of a damaged file."""
        pieces: list[FloatArray] = []
        notes = []
        n_rows = 0
        start, line = self.text.body, self.text.body_line
        limit = self.text.options.limits.frames
        while start < len(self.text.data):
            stop = self.text.data.find(b"\n", start + PIECE_BYTES) + 1 or len(self.text.data)
            piece = self.text.data[start:stop]
            # A delimiter at the end of a row begins no cell where the layout says so.
            ends = rb"%b+(?= *(?:\n|$))" % re.escape(self.text.delimiter.encode())
            rows = parse_rows(
                re.sub(ends, b"", piece) if self.text.layout.extra else piece,
                len(self.text.names),
                delimiter=self.text.delimiter.strip(" "),
                decimal_comma=self.text.options.decimal_comma,
                # The limit counts the line's end too.
                line_bytes=self.text.options.limits.line_bytes - 1,
            )
            failure = None
            if rows is None:
                rows, failure = self._careful_rows(piece, line)
            n_rows += len(rows)
            pieces.append(rows)
            if n_rows > limit:
                raise self.text.error(None, f"more than {limit} rows (Limits.frames)")
            if failure is not None:
                if not self.text.options.repair or not n_rows:
                    raise failure
                notes.append(f"{n_rows} whole rows were kept; then {failure}")
                break
            start, line = stop, line + piece.count(b"\n")
        if not n_rows:
            raise self.text.error(line, "the table ends after its names; expected rows of numbers")
        self.values = np.concatenate(pieces)
        claimed = self.text.layout.n_frames
        if claimed is not None and claimed != n_rows and not notes:
            shown = claimed if claimed < 10**12 else f"{claimed:.3g}"
            notes.append(f"{shown} rows claimed, {n_rows} there; kept all {n_rows}")
        if self.glued:
            where = f"{len(self.glued)} row{'s' * (len(self.glued) != 1)}"
            notes.append(f"numbers that ran together were parted in {where}; the first is line {self.glued[0]}")
        return notes

    def _careful_rows(self, piece: bytes, first_line: int) -> tuple[FloatArray, FormatError | None]:
        """Parse rows one at a time, up to the first that can't be."""
        values = array("d")
        failure = None
        n_columns = len(self.text.names)
        if self.texts is None:
            self.texts = {column: [] for column in self._text_columns(piece, first_line)}
        try:
            for line, was_glued, fields in self._fields(piece, first_line):
                if was_glued:
                    self.glued.append(line)
                if len(fields) != n_columns:
                    raise self.text.error(
                        line,
                        f"the row has {len(fields)} field{'s' * (len(fields) != 1)}, the first row has {n_columns}"
                        + (f" (separated by {self.text.delimiter!r})" if 1 in (len(fields), n_columns) else ""),
                    )
                values.extend([self._number(line, i, field) for i, field in enumerate(fields)])
        except FormatError as error:
            failure = error
        return np.array(values).reshape(-1, n_columns), failure

    def _fields(self, piece: bytes, first_line: int) -> Iterator[tuple[int, bool, list[str]]]:
        """Yield each row's line, whether its numbers ran together, and its fields."""
        for line, _, fields in self.text.rows(piece, first_line):
            # Delimiters alone are an empty line, where the layout ends rows with some.
            if self.text.layout.extra and not any(fields):
                continue
            while self.text.layout.extra and len(fields) > len(self.text.names) and not fields[-1]:
                fields.pop()
            parted = self._parted(fields)
            yield line, parted is not fields, parted

    def cells(self, columns: list[int], n_rows: int) -> list[list[str]]:
        """Return some columns of the first rows, which have been read, as they are written."""
        if not columns:
            return []
        rows = islice(self._fields(self.text.data[self.text.body :], self.text.body_line), n_rows)
        return [list(column) for column in zip(*([fields[i] for i in columns] for _, _, fields in rows), strict=True)]

    def first_cell(self, column: int) -> str:
        """Return a cell of the first row as it is written, or nothing where the row has not so many."""
        fields = self._parted(self.text.first_row())
        return fields[column] if column < len(fields) else ""

    def _parted(self, fields: list[str]) -> list[str]:
        """Part numbers that run together, where the row then has as many as it must have; in tables of numbers."""
        if len(fields) >= len(self.text.names) or not self.text.options.repair:
            return fields
        # Dates and words may hold a minus.
        if self.texts or self.time_texts:
            return fields
        comma = self.text.options.decimal_comma
        parted = [
            one for field in fields for one in part_glued(field.encode(), decimal_comma=comma).decode().split(" ")
        ]
        return parted if len(parted) == len(self.text.names) else fields

    def _number(self, line: int, column: int, field: str) -> float:
        if column in self.time_texts:
            if form_of_text(field) != self.clocks[column]:
                raise self.text.error(
                    line,
                    f"column {self.text.names[column]!r}: expected a {self.clocks[column]}, as in the first row; found "
                    f"{field[:40]!r}",
                )
            self.time_texts[column].append(field)
            return 0.0
        if self.texts and column in self.texts:
            self.texts[column].append(field[1:] if ESCAPED.match(field) else field)
            return 0.0
        try:
            return parse_number(field.encode(), decimal_comma=self.text.options.decimal_comma)
        except NumberTextError as error:
            if field.lower() in _GAPS:
                if self.text.options.gaps is not None and column not in self.clocks:
                    return math.nan
                problem = error.problem if field else "expected a number, found nothing"
                raise self.text.error(line, f"column {self.text.names[column]!r}: {problem}; {GAPS_HINT}") from None
            raise self.text.error(line, f"column {self.text.names[column]!r}: {error.problem}") from None

    def _text_columns(self, piece: bytes, first_line: int) -> list[int]:
        """Find columns that hold text: words in two rows at least, and no number, as far as the first rows tell."""
        rows = [fields for _, _, fields in islice(self.text.rows(piece, first_line), _ROWS_TO_TELL)]
        found = []
        for column in range(len(self.text.names)):
            cells = [fields[column] for fields in rows if len(fields) >= len(self.text.names)]
            words = [cell for cell in cells if cell.lower() not in _GAPS]
            # A date that is no clock says something of its frame, as a word does.
            worded = all(_DAY.fullmatch(cell) or form_of_text(cell) or not _LIKE_A_NUMBER.match(cell) for cell in words)
            if len(words) > 1 and column not in self.clocks and worded:
                found.append(column)
        # A table of text alone is none of what is read here.
        return found if len(found) < len(self.text.names) else []
