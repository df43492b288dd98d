"""What stands above the rows of a table, as a reader of one dialect finds it."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from fractions import Fraction

from retime.errors import FormatError
from retime.motion.channels import ChannelKind
from retime.motion.clock import ClockForm


@dataclass(frozen=True)
class Row:
    """One row above, or among the first of, a table's numbers.

    Attributes
    ----------
    line : int
        Its line, counted from 1.
    stop : int
        The offset of the row after it.
    fields : tuple of str
        Its cells, without the white space around them.
    """

    line: int
    stop: int
    fields: tuple[str, ...]


@dataclass(frozen=True)
class Head:
    """The first rows of a table, blank ones left out.

    Attributes
    ----------
    rows : tuple of Row
        Some of them.
    delimiter : str
        What parts their cells.
    numeric : callable
        Whether a cell is meant as a number.
    error : callable
        Makes a FormatError of a line and a problem.
    """

    rows: tuple[Row, ...]
    delimiter: str
    numeric: Callable[[str], bool]
    error: Callable[[int | None, str], FormatError]


@dataclass(frozen=True)
class Layout:
    """What the head of a table says of its rows.

    Attributes
    ----------
    dialect : str
        For people: "Motive export"; "" where it is a plain table.
    names : tuple of str
        Of its columns; "" for one that is an index, if it counts up.
    names_line : int
        The line where the names are.
    start : int
        The offset of the first row of numbers.
    delimiter : str
        What parts its cells; a blank stands for any white space.
    rate : Fraction, optional
        Frames a second, where the head says it.
    n_frames : int, optional
        How many rows the head says there are.
    extra : bool
        Whether rows may end in a delimiter, with nothing after it.
    left_out : frozenset of int
        Columns that are neither times nor channels.
    clock : int, optional
        The column of times, where the dialect has it at one place.
    clock_form : str, optional
        In what it counts, where the head says that.
    clock_name : str
        What to call the column of times where it has no name of its own.
    kinds : mapping of int to ChannelKind
        What columns hold, where the head says it.
    """

    dialect: str
    names: tuple[str, ...]
    names_line: int
    start: int
    delimiter: str
    rate: Fraction | None = None
    n_frames: int | None = None
    extra: bool = False
    left_out: frozenset[int] = frozenset()
    clock: int | None = None
    clock_form: ClockForm | None = None
    clock_name: str = ""
    kinds: Mapping[int, ChannelKind] = field(default_factory=dict)


def joined_names(parts: Sequence[Sequence[str]]) -> tuple[str, ...]:
    """Make names of what stands above each column, and number those that are there twice.

    Examples
    --------
    >>> joined_names([["Prop", "position", "X"], ["Prop", "", "X"], ["Prop", "", "X"]])
    ('Prop.position.x', 'Prop.x', 'Prop.x.2')
    """
    names: list[str] = []
    seen: set[str] = set()
    for own in parts:
        words = [part for part in own if part]
        if words and re.fullmatch("[WXYZ]", words[-1]):
            words[-1] = words[-1].lower()
        plain = name = ".".join(words)
        number = 1
        while name in seen:
            number += 1
            name = f"{plain}.{number}"
        seen.add(name)
        names.append(name)
    return tuple(names)
