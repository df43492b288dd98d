"""How close each method comes to the known answers."""

from __future__ import annotations

from collections.abc import Sequence

from study.answers.methods import METHODS, Answered
from study.tables.table import Table
from study.text import NOTHING, number

# Doing nothing has one speed: no correlation.
_FOUND = tuple(method for method in METHODS if method != "nothing")


def answers_table(answered: Sequence[Answered]) -> Table:
    """How alike playback speeds are: correlation of log-speed, where the answer has something to say."""
    rows = []
    for one in answered:
        found = [one.attempt(method) for method in _FOUND]
        cells = [NOTHING if attempt is None else number(attempt.inside.correlation) for attempt in found]
        rows.append((one.answer.name, one.answer.kind, *cells))
    return Table(("case", "kind", *_FOUND), tuple(rows), numbers_from=2)


def answer_times_table(answered: Sequence[Answered]) -> Table:
    """By how many frames poses come too early or late within each stretch, and the length of the whole."""
    rows = []
    for one in answered:
        cells = []
        for method in METHODS:
            attempt = one.attempt(method)
            if attempt is None:
                cells.append(NOTHING)
            elif method in ("nothing", "guided, given length"):
                cells.append(number(attempt.inside.mean_error, 1))
            else:
                cells.append(f"{number(attempt.inside.mean_error, 1)} ({attempt.inside.length_ratio:.0%})")
        rows.append((one.answer.name, one.answer.kind, *cells))
    return Table(("case", "kind", *METHODS), tuple(rows), numbers_from=2)
