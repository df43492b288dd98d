"""What a figure of merit is: how it is measured, and how it is shown."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

from study.figures.shown import Shown, Warped
from study.text import number

Figures = Mapping[str, Any]
"""All figures of one version, by name; None where one does not apply."""


@dataclass(frozen=True)
class Column:
    """How a figure is shown.

    Attributes
    ----------
    heading : str
        Above it.
    write : function
        Writes the figure, which is not None; all others of the version are at hand.
    """

    heading: str
    write: Callable[[Any, Figures], str]


@dataclass(frozen=True)
class Figure:
    """A figure of merit.

    Attributes
    ----------
    name : str
        In the JSON.
    measure : function
        Returns its value, or None where it does not apply.
    columns : tuple of Column
        How it is shown; a column that no version of an evaluation has is left out.
    """

    name: str
    measure: Callable[[Shown], Any]
    columns: tuple[Column, ...] = ()


def of_warps(measure: Callable[[Warped], Any]) -> Callable[[Shown], Any]:
    """Measure only what a warp made of the input."""
    return lambda shown: measure(shown) if isinstance(shown, Warped) else None


def of_flights(measure: Callable[[Warped], Any]) -> Callable[[Shown], Any]:
    """Measure only where the input flies."""
    return of_warps(lambda shown: measure(shown) if shown.subject.flights else None)


def as_number(digits: int = 2, *, scale: float = 1.0) -> Callable[[Any, Figures], str]:
    """Write a figure as a number, so many times as large."""
    return lambda value, _: number(value * scale, digits)
