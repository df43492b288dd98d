"""Rows of text under headings, written for both kinds of page."""

from __future__ import annotations

import html
from collections.abc import Sequence
from dataclasses import dataclass


@dataclass(frozen=True)
class Table:
    """Rows of text under headings.

    Attributes
    ----------
    headings : tuple of str
        One a column.
    rows : tuple of tuple of str
        As many texts each.
    numbers_from : int
        The first column of numbers: from there on they are set to the right.
    marked : frozenset of int
        Rows to set in bold.
    """

    headings: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]
    numbers_from: int = 1
    marked: frozenset[int] = frozenset()

    def markdown(self) -> str:
        """Write it for a Markdown page."""
        rule = [":--" if i < self.numbers_from else "--:" for i in range(len(self.headings))]
        lines = [self.headings, tuple(rule)]
        for i, row in enumerate(self.rows):
            lines.append(tuple(f"**{text}**" if i in self.marked and text else text for text in row))
        return "".join(f"| {' | '.join(line)} |\n" for line in lines)

    def html(self) -> str:
        """Write it for a page of HTML."""

        def cells(texts: Sequence[str], tag: str) -> str:
            return "".join(
                f"<{tag}{' class=number' if i >= self.numbers_from else ''}>{html.escape(text)}</{tag}>"
                for i, text in enumerate(texts)
            )

        rows = "".join(
            f"<tr{' class=marked' if i in self.marked else ''}>{cells(row, 'td')}</tr>"
            for i, row in enumerate(self.rows)
        )
        head = cells(self.headings, "th")
        return f'<div class="wide"><table><thead><tr>{head}</tr></thead><tbody>{rows}</tbody></table></div>'
