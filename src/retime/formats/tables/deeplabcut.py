"""DeepLabCut's tables: rows of scorers, animals, body parts and coordinates above the numbers."""

from __future__ import annotations

from retime.formats.tables.layout import Head, Layout, joined_names


def find(head: Head) -> Layout | None:
    """Read a head whose rows begin with scorer, individuals (of several animals), bodyparts and coords.

    The channels are called ``snout.x``; of several animals ``mouse1.snout.x``.

    Raises
    ------
    FormatError
        The rows differ in length.
    """
    rows = {}
    for row in head.rows[:4]:
        key = row.fields[0].lower()
        if key not in ("scorer", "individuals", "bodyparts", "coords"):
            break
        rows[key] = row
    if "bodyparts" not in rows or "coords" not in rows:
        return None
    last = rows["coords"]
    above = [rows[key] for key in ("individuals", "bodyparts", "coords") if key in rows]
    for row in above:
        if len(row.fields) != len(last.fields):
            raise head.error(row.line, f"the row has {len(row.fields)} fields, that of coords has {len(last.fields)}")
    names = joined_names(list(zip(*(row.fields for row in above), strict=True)))
    # The first column numbers the frames, or names their pictures.
    return Layout(
        "DeepLabCut" + (", several animals" if "individuals" in rows else ""),
        ("frame", *names[1:]),
        last.line,
        last.stop,
        head.delimiter,
        left_out=frozenset([0]),
    )
