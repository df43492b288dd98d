"""Figures of merit of one evaluation: a row a version, a column a figure."""

from __future__ import annotations

from study.evaluations.evaluation import Evaluation
from study.figures.figure import Column, Figure, Figures
from study.figures.registry import FIGURES
from study.tables.table import Table
from study.text import NOTHING


def figures_table(evaluation: Evaluation) -> Table:
    """Lay out the figures; the method's own row is marked, and what no version has is left out."""
    columns = [(figure, column) for figure in FIGURES for column in figure.columns]
    written = [
        (column.heading, [_cell(figure, column, version.figures) for version in evaluation.versions])
        for figure, column in columns
    ]
    shown = [(heading, texts) for heading, texts in written if any(text != NOTHING for text in texts)]
    rows = tuple((version.label, *(texts[i] for _, texts in shown)) for i, version in enumerate(evaluation.versions))
    marked = frozenset(i for i, version in enumerate(evaluation.versions) if version.label == "guided")
    return Table(("version", *(heading for heading, _ in shown)), rows, marked=marked)


def _cell(figure: Figure, column: Column, figures: Figures) -> str:
    value = figures[figure.name]
    return NOTHING if value is None else column.write(value, figures)
