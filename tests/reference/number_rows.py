"""Rows of numbers, read a field at a time."""

from __future__ import annotations

from retime.formats.number_text import NumberTextError, parse_number


def read_rows(
    text: bytes, n_columns: int = 0, *, delimiter: str = "", decimal_comma: bool = False, line_bytes: int = 1 << 62
) -> list[list[float]] | None:
    """Read each field of each line as a number of its own; None where one isn't, or where lines differ in length."""
    rows: list[list[float]] = []
    # Of bytes: they part at LF, CR and CRLF only.
    for line in text.splitlines():
        if len(line) > line_bytes:
            return None
        blanks = b" \t".replace(delimiter.encode(), b"") if delimiter else b" \t"
        if not line.strip(blanks):
            continue
        if delimiter:
            fields = [field.strip(blanks) for field in line.split(delimiter.encode())]
        else:
            fields = line.replace(b"\t", b" ").strip(b" ").split(b" ")
            fields = [field for field in fields if field]
        try:
            row = [parse_number(field, decimal_comma=decimal_comma and delimiter != ",") for field in fields]
        except NumberTextError:
            return None
        if len(row) != (n_columns or len(row)):
            return None
        n_columns = len(row)
        rows.append(row)
    return rows or None
