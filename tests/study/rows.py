"""A row of the table of settings, made by hand."""

from __future__ import annotations

from study.choices.questions import Imitated, Preserved, Row
from study.choices.settings import Setting


def row_of_one(label: str, kept: int, ratio: float) -> Row:
    """One clip and one case."""
    return Row(
        Setting(label, label),
        (Preserved("clip", "65%", 10, kept, 4, min(kept, 4)),),
        (Imitated("case", "limp", "neutral", 0.9, 0.1, 1.0, ratio),),
    )
