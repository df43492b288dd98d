"""Rows of numbers in text, read at once: the fast way of every reader.

It answers None where anything is unusual: the reader then goes through the same text with
`retime.formats.number_text`, which says what is wrong, and where. Both take the same grammar.
"""

from __future__ import annotations

from retime.arrays import FloatArray
from retime.kernels import RowFormat, backend
from retime.motion.size import LARGEST

_ANY_LENGTH = 1 << 62


def parse_rows(
    text: bytes,
    n_columns: int = 0,
    *,
    delimiter: str = "",
    decimal_comma: bool = False,
    line_bytes: int = _ANY_LENGTH,
) -> FloatArray | None:
    r"""Parse lines that hold the same count of numbers each, fast; blank lines don't count.

    The memory used is at most six times the text's (ten times, without compiled kernels), so a large file is best
    parsed in pieces cut at line ends.

    Parameters
    ----------
    text : bytes
        Whole lines, which end in LF, CR or CRLF.
    n_columns : int
        Numbers in each line; 0: as many as the first one has.
    delimiter : str
        What parts two numbers, with blanks around it or none: a comma, say. Left out: blanks.
    decimal_comma : bool
        Take ``0,5`` for 0.5; the delimiter is no comma then.
    line_bytes : int
        The longest line that is taken.

    Returns
    -------
    float array, shape (n_lines, n_columns), or None
        None where the counts differ, where there is no line, or where a field is empty or not a finite number of
        1e100 at most.

    Examples
    --------
    >>> parse_rows(b"1 2.5\n-3 4\n")
    array([[ 1. ,  2.5],
           [-3. ,  4. ]])
    >>> parse_rows(b"1, 2.5\n-3,4e1\n", delimiter=",")
    array([[ 1. ,  2.5],
           [-3. , 40. ]])
    >>> parse_rows(b"1 2.5-3 4\n") is None
    True
    """
    rows = RowFormat(n_columns, delimiter, decimal_comma and delimiter != ",", LARGEST, line_bytes)
    return backend(warn=False).read_rows(text, rows)
