"""Motive's export: a row of settings, then rows of types, names, ids and measures above the axes."""

from __future__ import annotations

from collections import Counter
from fractions import Fraction
from itertools import islice, zip_longest

from retime.errors import OptionError
from retime.formats.tables.layout import Head, Layout, joined_names
from retime.motion.channels import ChannelKind
from retime.motion.rate import parse_rate


def find(head: Head) -> Layout | None:
    """Read the head of a table that begins with ``Format Version``.

    The channels are called ``Prop.rotation.x``, ``Prop.position.x``.

    Raises
    ------
    FormatError
        No row begins with ``Frame``, or its rate is none.
    """
    first = head.rows[0]
    if first.fields[0].lower() != "format version":
        return None
    places = [place for place, row in enumerate(head.rows) if row.fields[0].lower() in ("frame", "frame#")]
    if not places:
        raise head.error(first.line, "a Motive export, but none of its rows begins with 'Frame', as its names do")
    axes = head.rows[places[0]]
    settings = dict(zip(map(str.lower, first.fields[::2]), first.fields[1::2], strict=False))
    above = head.rows[1 : places[0]]
    # Which row is which is told by what it holds: older files have no row of types, newer ones one of parents.
    measures = next(
        (row for row in reversed(above) if {"rotation", "position"} & {cell.lower() for cell in row.fields}), None
    )
    named = [row for row in above if row is not measures]
    types = named[0] if named and {"rigid body", "bone", "marker"} & set(map(str.lower, named[0].fields)) else None
    named = [row for row in named if row is not types]
    owners = named[0].fields if named else ()
    names = []
    turns: dict[tuple[str, int], list[int]] = {}
    met: Counter[tuple[str, str]] = Counter()
    columns = zip_longest(axes.fields, owners, measures.fields if measures else (), fillvalue="")
    for column, (axis, owner, measure) in enumerate(islice(columns, len(axes.fields))):
        if not measure and owner.lower() in ("", "name"):
            # Frames and times; newer files say above them what each row holds.
            names.append([axis])
            continue
        names.append([owner, measure.lower() if axis and owner else measure, axis])
        if measure.lower() == "rotation" and axis:
            # Two things may have one name: what a column's rotation belongs to is told by how often its axis was met.
            turns.setdefault((owner, met[owner, axis]), []).append(column)
            met[owner, axis] += 1
    euler = settings.get("rotation type", "quaternion").lower() != "quaternion"
    kinds = {
        column: ChannelKind("angle", "deg") if euler else ChannelKind("quaternion")
        for of in turns.values()
        for column in of
        if euler or len(of) == 4
    }
    return Layout(
        "Motive export",
        joined_names(names),
        axes.line,
        axes.stop,
        head.delimiter,
        rate=_rate(head, settings),
        extra=True,
        kinds=kinds,
    )


def _rate(head: Head, settings: dict[str, str]) -> Fraction | None:
    text = settings.get("export frame rate") or settings.get("capture frame rate")
    try:
        return parse_rate(text) if text else None
    except OptionError as error:
        raise head.error(head.rows[0].line, f"Export Frame Rate: {error}") from None
