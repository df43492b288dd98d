"""OpenSim's motions and storages (.mot, .sto): settings, one a line, up to ``endheader``, then the names."""

from __future__ import annotations

from retime.formats.number_text import count_of
from retime.formats.tables.layout import Head, Layout


def find(head: Head) -> Layout | None:
    """Read a head that ends in ``endheader``.

    Raises
    ------
    FormatError
        Nothing follows, or the columns are not as many as the head says.
    """
    places = [place for place, row in enumerate(head.rows) if "".join(row.fields).lower() == "endheader"]
    if not places:
        return None
    if places[0] + 1 >= len(head.rows):
        raise head.error(head.rows[places[0]].line, "nothing follows 'endheader'; expected the names of columns")
    settings = {}
    for row in head.rows[: places[0]]:
        key, sign, value = head.delimiter.join(row.fields).partition("=")
        if sign:
            settings[key.strip().lower()] = value.strip()
    if settings.get("datatype", "double").lower() != "double":
        raise head.error(
            head.rows[0].line, f"an OpenSim table of {settings['datatype']}; only those of plain numbers are read"
        )
    names = head.rows[places[0] + 1]
    fields, delimiter = names.fields, head.delimiter
    if len(fields) == 1:
        # Parted by blanks.
        fields, delimiter = tuple(names.fields[0].split()), " "
    claimed = settings.get("ncolumns", "")
    if count_of(claimed) not in (None, len(fields)):
        raise head.error(names.line, f"nColumns={claimed[:40]}, but {len(fields)} columns have names")
    return Layout(
        "OpenSim table",
        fields,
        names.line,
        names.stop,
        delimiter,
        n_frames=count_of(settings.get("nrows", "")),
        extra=True,
    )
