"""How the study writes numbers for a reader."""

from __future__ import annotations

import math

NOTHING = "–"


def number(value: float | None, digits: int = 2, unit: str = "") -> str:
    """Write a number, or a dash where there is none; "lost" where it is beyond measure."""
    if value is None or math.isnan(value):
        return NOTHING
    if math.isinf(value):
        return "lost"
    return f"{value:.{digits}f}{unit}"


def milliseconds(seconds: float | None) -> str:
    """Write a time in milliseconds, with two significant digits or more."""
    if seconds is None:
        return NOTHING
    value = seconds * 1000
    return f"{value:.1f}" if value < 10 else f"{value:.0f}"
