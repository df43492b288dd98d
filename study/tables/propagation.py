"""How much of a hand's change comes back outside of its example: a row a kind of case and way."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from study.propagation.measure import LENGTHS, WAYS, Propagated
from study.tables.table import Table
from study.text import NOTHING, number


def propagation_table(found: Sequence[Propagated]) -> Table:
    """One row a kind and way: recovery at both kinds of length, and the length where it was free."""
    rows: list[tuple[str, ...]] = []
    marked: list[int] = []
    for kind in dict.fromkeys(one.kind for one in found):
        for place, way in enumerate(WAYS):
            some = [one for one in found if (one.kind, one.way) == (kind, way)]
            free = [one for one in some if one.length == "free"]
            lengths = [one.length_ratio for one in free]
            shares = [one.share for one in free if one.share is not None]
            cells = [_recovered(some, length) for length in LENGTHS]
            if way == "the hand's speed":
                marked.append(len(rows))
            rows.append(
                (
                    kind if place == 0 else "",
                    str(len(free)) if place == 0 else "",
                    way,
                    *cells,
                    f"{min(lengths):.2f}–{max(lengths):.2f}",
                    number(100 * float(np.mean(shares)), 0, " %") if shares else NOTHING,
                )
            )
    headings = (
        "case",
        "examples",
        "way",
        *(f"recovery, {length} length" for length in LENGTHS),
        "length",
        "spoken for",
    )
    return Table(headings, tuple(rows), numbers_from=3, marked=frozenset(marked))


def _recovered(some: Sequence[Propagated], length: str) -> str:
    """Write the mean and the worst recovery."""
    values = [one.recovery for one in some if one.length == length and np.isfinite(one.recovery)]
    return f"{number(float(np.mean(values)))} ({number(min(values))})" if values else NOTHING
