"""Table 1: sizes and times, ours above the paper's own."""

from __future__ import annotations

from collections.abc import Sequence

from study.evaluations.evaluation import Evaluation
from study.evaluations.registry import PAPER
from study.tables.table import Table
from study.text import NOTHING, milliseconds


def sizes_table(evaluations: Sequence[Evaluation]) -> Table:
    """Table 1: sizes and times, ours above the paper's own."""
    headings = (
        *("trial", "", "n", "m", "r", "s", "objective (ms)", "search (ms)"),
        *("recurrence (ms)", "heuristic (ms)", "heuristic's excess", "… as keytimes"),
    )
    rows = []
    for one in evaluations:
        row = one.row
        excesses = (NOTHING if one is None else f"{one:.1%}" for one in (row.excess, row.excess_as_keytimes))
        rows.append(
            (
                one.key,
                "here",
                *(str(size) for size in (row.n_input, row.n_output, row.n_reference, row.max_skip)),
                milliseconds(row.objective),
                milliseconds(row.search),
                milliseconds(row.layered),
                milliseconds(row.heuristic),
                *excesses,
            )
        )
        paper = PAPER.get(one.key)
        if paper is not None:
            sizes = (paper.n_input, paper.n_output, paper.n_reference, paper.max_skip)
            rows.append(
                (
                    *("", "paper, 2007"),
                    *(str(size) for size in sizes),
                    milliseconds(paper.objective),
                    NOTHING,
                    milliseconds(paper.search),
                    milliseconds(paper.heuristic),
                    "not given" if paper.heuristic is not None else NOTHING,
                    NOTHING,
                )
            )
    return Table(headings, tuple(rows), numbers_from=2)
