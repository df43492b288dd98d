"""Tables with one row of names, or none: and a row of units below it, or an index before it."""

from __future__ import annotations

import re

from retime.formats.tables.layout import Head, Layout, Row
from retime.formats.tables.time_names import FORM_OF_UNIT, is_time_name
from retime.motion.channels import ChannelKind
from retime.motion.clock import ClockForm
from retime.motion.signal import numbered_names

_ANGLES = {"deg": "deg", "degs": "deg", "degree": "deg", "degrees": "deg", "°": "deg"} | {
    "rad": "rad",
    "radian": "rad",
    "radians": "rad",
}
# Of lengths, speeds, forces and so on, as programs write them below a name.
_UNIT = re.compile(
    r"(?:[kcmµu]?(?:m|g|N|V|A|Hz|Pa|J|W)|in|ft|inch(?:es)?|px|pixels?|met(?:er|re)s?|N[.*·]?m+|deg|degs|degrees?|°"
    r"|rad|radians?|%|BW|G|count|counts|frames?|n|bool|none|s|sec|secs|seconds?|ms|us|µs|ns|-|1)"
    r"(?:/(?:s|ms|s\^?2|s²|kg|m|min))?",
    re.IGNORECASE,
)
_NO_UNIT = {"", "-", "1", "none", "bool", "n", "count", "counts"}
_FORMULA = re.compile(r"'[\s']*[=+\-@]")


def find(head: Head) -> Layout:
    """Read the names, if there are any, and units, if they stand below.

    Raises
    ------
    FormatError
        There are no names but of some columns.
    """
    first = head.rows[0]
    fields = first.fields
    extra = len(fields) > 1 and not fields[-1] and _ends_empty(head, len(fields))
    if extra:
        fields = fields[:-1]
    if all(map(head.numeric, fields)):
        return Layout("", numbered_names(len(fields)), first.line, 0, head.delimiter, extra=extra)
    names = tuple(name[1:] if _FORMULA.match(name) else name for name in fields)
    left_out: frozenset[int] = frozenset()
    dialect = ""
    below = head.rows[1] if len(head.rows) > 1 else None
    if below is not None and _are_units(head, names, below):
        kinds: dict[int, ChannelKind] = {}
        form: ClockForm | None = None
        for column, cell in enumerate(below.fields[: len(names)]):
            unit = cell.strip("()[] ")
            if is_time_name(names[column]):
                form = form or FORM_OF_UNIT.get(unit.lower())
            elif unit.lower() in _ANGLES:
                kinds[column] = ChannelKind("angle", _ANGLES[unit.lower()])
            elif unit.lower() not in _NO_UNIT:
                kinds[column] = ChannelKind("linear", unit)
        return Layout(
            "a row of units below the names",
            names,
            first.line,
            below.stop,
            head.delimiter,
            extra=extra,
            clock_form=form,
            kinds=kinds,
        )
    if len(names) > 1 and (not names[0] or names[0] == "Unnamed: 0"):
        # What pandas writes before the columns: a number for each row.
        left_out, dialect = frozenset([0]), "an index before the columns"
    return Layout(dialect, names, first.line, first.stop, head.delimiter, extra=extra, left_out=left_out)


def _ends_empty(head: Head, n_fields: int) -> bool:
    """Whether every row that is as long as the first ends in an empty cell, so that it is only a delimiter too many."""
    return all(not row.fields[-1] for row in head.rows if len(row.fields) == n_fields)


def _are_units(head: Head, names: tuple[str, ...], row: Row) -> bool:
    """Tell units from words and numbers: every cell is a unit or nothing, some are no number, and numbers follow."""
    cells = [cell.strip("()[] ") for cell in row.fields[: len(names)]]
    numbers = [cell for cell in cells if head.numeric(cell)]
    if len(row.fields) < len(names) or not set(numbers) <= {"1"} or not any(cell and cell != "1" for cell in cells):
        return False
    return all(not cell or _UNIT.fullmatch(cell) for cell in cells) and any(
        head.numeric(cell) for after in head.rows[2:3] for cell in after.fields
    )
