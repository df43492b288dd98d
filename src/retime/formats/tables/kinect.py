"""Recordings of a Kinect: no names; a time in ms, then x, y, z and how it was tracked of each joint, and a comma."""

from __future__ import annotations

from itertools import pairwise

from retime.formats.number_text import count_of
from retime.formats.tables.layout import Head, Layout
from retime.motion.channels import ChannelKind
from retime.motion.signal import numbered_names

# How a joint was tracked: not, inferred, tracked.
_STATES = {"0", "1", "2"}


def find(head: Head) -> Layout | None:
    """Know such rows by what they hold: the count of columns, whole times that rise, and states of 0, 1 or 2."""
    rows = head.rows
    fields = [row.fields[:-1] for row in rows]
    n_columns = len(fields[0])
    if n_columns < 5 or n_columns % 4 != 1 or any(row.fields[-1] for row in rows):
        return None
    if any(len(row) != n_columns or not all(map(head.numeric, row)) for row in fields):
        return None
    times = [time for row in fields if (time := count_of(row[0])) is not None]
    if len(times) < len(fields) or any(b <= a for a, b in pairwise(times)):
        return None
    states = range(4, n_columns, 4)
    if any(row[column] not in _STATES for row in fields for column in states):
        return None
    return Layout(
        "Kinect recording",
        numbered_names(n_columns),
        1,
        0,
        head.delimiter,
        extra=True,
        clock=0,
        clock_form="ms",
        clock_name="time_ms",
        kinds={column: ChannelKind("label") for column in states},
    )
