"""Bring what `retime study` wrote into docs/study: ``python tools/fill_study.py out/study docs/study``.

Copies the pictures and the numbers, and writes the tables of README.md between their markers. The text around them is
written by hand.
"""

from __future__ import annotations

import json
import re
import shutil
import sys
from pathlib import Path

from retime.evaluate.study_tables import Table

_PICTURES = (".png", ".svg")


def fill(page: str, tables: dict[str, Table]) -> str:
    """Write each table between ``<!-- table NAME -->`` and ``<!-- end -->``; raise KeyError where one is missing."""

    def write(match: re.Match[str]) -> str:
        return f"{match[1]}\n\n{tables[match[2]].markdown()}\n{match[3]}"

    return re.sub(r"(<!-- table ([\w-]+) -->).*?(<!-- end -->)", write, page, flags=re.DOTALL)


def read_tables(document: dict[str, dict]) -> dict[str, Table]:
    """Make the tables of a study's JSON again."""
    return {
        name: Table(
            tuple(table["headings"]),
            tuple(tuple(row) for row in table["rows"]),
            table["numbers_from"],
            frozenset(table["marked"]),
        )
        for name, table in document["tables"].items()
    }


def main(source: Path, docs: Path) -> None:
    """Fill the folder of the docs from the folder of a run."""
    document = json.loads((source / "study.json").read_text(encoding="utf-8"))
    page = docs / "README.md"
    page.write_text(fill(page.read_text(encoding="utf-8"), read_tables(document)), encoding="utf-8")
    for place in sorted(source.iterdir()):
        if place.suffix in _PICTURES or place.name == "study.json":
            shutil.copyfile(place, docs / place.name)


if __name__ == "__main__":
    main(Path(sys.argv[1]), Path(sys.argv[2]))
