"""Brings what a run wrote into docs/study: ``python -m study.report.docs out/study docs/study``.

Copies the pictures and the numbers, and writes into README.md the tables between their markers and the numbers within
its text. The rest of the text is written by hand. Nothing is changed where the run lacks a table, a row or a picture
that the page shows.
"""

from __future__ import annotations

import json
import re
import shutil
import sys
from pathlib import Path
from typing import Any

from study.tables.table import Table

_PICTURES = (".png", ".svg")
_TABLE = re.compile(r"(<!-- table ([\w-]+) -->\n)(.*?)(<!-- end -->)", re.DOTALL)
_VALUE = re.compile(r"(<!-- value ([\w-]+) -->)(.*?)(<!-- end -->)")
_PICTURE = re.compile(r"!\[[^\]]*\]\(([\w.-]+)\)")


class IncompleteStudyError(ValueError):
    """A run lacks what the page shows."""


def fill(page: str, document: dict[str, Any]) -> str:
    """Write tables and numbers between their markers.

    Raises
    ------
    IncompleteStudyError
        A marker names what is not in the document, a table has no rows, a marker is not closed, or a table of the
        document is nowhere on the page.
    """
    tables, values = document["tables"], document["values"]
    shown = {match[2] for match in _TABLE.finditer(page)}
    for what, pattern, there in (("table", _TABLE, tables), ("value", _VALUE, values)):
        found = [match[2] for match in pattern.finditer(page)]
        opened = re.findall(rf"<!-- {what} ([\w-]+) -->", page)
        if found != opened:
            raise IncompleteStudyError(f"a marker is not closed: the page opens {opened}, and closes {found}")
        missing = [name for name in found if name not in there]
        if missing:
            raise IncompleteStudyError(f"the run has no {what} {', '.join(missing)}: run the whole study")
    hidden = sorted(set(tables) - shown)
    if hidden or not shown:
        raise IncompleteStudyError(f"the page has no place for the tables {', '.join(hidden) or 'of a study'}")

    def table(match: re.Match[str]) -> str:
        return f"{match[1]}\n{read_table(match[2], tables[match[2]]).markdown()}\n{match[4]}"

    def value(match: re.Match[str]) -> str:
        return f"{match[1]}{values[match[2]]}{match[4]}"

    return _VALUE.sub(value, _TABLE.sub(table, page))


def read_table(name: str, table: dict[str, Any]) -> Table:
    """Make a table of a study's JSON again; raise IncompleteStudyError where it is empty or ragged."""
    headings, rows = tuple(table["headings"]), tuple(tuple(row) for row in table["rows"])
    if not rows or any(len(row) != len(headings) for row in rows):
        raise IncompleteStudyError(f"table {name} has {len(rows)} rows, not all of {len(headings)} cells")
    return Table(headings, rows, table["numbers_from"], frozenset(table["marked"]))


def main(source: Path, docs: Path) -> None:
    """Fill the folder of the docs from the folder of a run."""
    document = json.loads((source / "study.json").read_text(encoding="utf-8"))
    place = docs / "README.md"
    page = fill(place.read_text(encoding="utf-8"), document)
    pictures = [name for name in _PICTURE.findall(page) if Path(name).suffix in _PICTURES]
    missing = [name for name in pictures if not (source / name).is_file()]
    if missing:
        raise IncompleteStudyError(f"the run has no picture {', '.join(missing)}")
    place.write_text(page, encoding="utf-8")
    for name in (*pictures, "study.json"):
        shutil.copyfile(source / name, docs / name)


if __name__ == "__main__":
    try:
        main(Path(sys.argv[1]), Path(sys.argv[2]))
    except IncompleteStudyError as error:
        sys.exit(f"error: {error}")
