"""Several warps of one clip, side by side in numbers."""

from __future__ import annotations

import html
import itertools
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields
from typing import TYPE_CHECKING

import numpy as np

from retime.errors import MissingExtraError, OptionError
from retime.evaluate.metrics.flights import flight_spans, flight_timing
from retime.evaluate.naming import name_warps
from retime.motion.motion import Motion
from retime.svg import INKS, Panel, stacked, thinned
from retime.warp.curve import Warp, WarpLike
from retime.warp.knots import add_times

if TYPE_CHECKING:
    import pandas as pd

# Speeds that differ by less are the same, but for rounding.
_SAME_SPEED = 1e-6


@dataclass(frozen=True)
class ComparedWarp:
    """One warp in numbers.

    Attributes
    ----------
    name : str
        What it is called.
    output_span : float
        Seconds of output between its ends.
    slowest, fastest : float
        Playback speeds, of either direction, where it moves; nan where it never does.
    at_unit_speed : float
        Share of the output that plays at the input's own speed.
    held, backward : float
        Seconds of output that hold a pose, that run backward.
    mean_apart, most_apart : float
        Seconds of input between what this warp shows and what the first one shows at the same output time; nan where
        their domains have nothing in common.
    flights_kept, flights : int, optional
        Flights of the motion that play at unit speed from end to end, and all of them.
    flight_slowest, flight_fastest : float, optional
        Mean speeds of the slowest and the fastest flight.
    """

    name: str
    output_span: float
    slowest: float
    fastest: float
    at_unit_speed: float
    held: float
    backward: float
    mean_apart: float
    most_apart: float
    flights_kept: int | None = None
    flights: int | None = None
    flight_slowest: float | None = None
    flight_fastest: float | None = None


@dataclass(frozen=True)
class WarpComparison:
    """Several warps side by side.

    Attributes
    ----------
    rows : tuple of ComparedWarp
        In the order in which they were passed; the first one is what the others are held against.
    warps : mapping of str to Warp
        The warps, by name.
    """

    rows: tuple[ComparedWarp, ...]
    warps: Mapping[str, Warp]

    def _table(self) -> list[list[str]]:
        """Return heads and rows as text, with the columns that say something."""
        names = [field.name for field in fields(ComparedWarp)]
        shown = [name for name in names if any(getattr(row, name) is not None for row in self.rows)]
        return [[name.replace("_", " ") for name in shown]] + [
            [_written(getattr(row, name)) for name in shown] for row in self.rows
        ]

    def __repr__(self) -> str:
        table = self._table()
        widths = [max(len(row[i]) for row in table) for i in range(len(table[0]))]
        lines = []
        for name, *cells in table:
            numbers = [cell.rjust(width) for cell, width in zip(cells, widths[1:], strict=True)]
            lines.append("  ".join([name.ljust(widths[0]), *numbers]))
        return "\n".join(lines)

    def _repr_html_(self) -> str:
        table = self._table()
        start = min(warp.output_start for warp in self.warps.values())
        end = max(warp.output_end for warp in self.warps.values())
        low = min(float(warp.input_times.min()) for warp in self.warps.values())
        high = max(float(warp.input_times.max()) for warp in self.warps.values())
        panel = Panel("input time (s)", start, end, low, high)
        for value in (low, high):
            panel.rule(value, f"{value:.3g}")
        for warp, ink in zip(self.warps.values(), itertools.cycle(INKS), strict=False):
            kept = thinned(len(warp.output_times))
            panel.line(warp.output_times[kept], warp.input_times[kept], ink=ink)
        panel.legend(list(self.warps)[: len(INKS)])
        rows = "".join(
            "<tr>" + "".join(f"<{tag}>{html.escape(cell)}</{tag}>" for cell in row) + "</tr>"
            for tag, row in zip(["th", *["td"] * (len(table) - 1)], table, strict=True)
        )
        return stacked(panel.svg(), f"<table>{rows}</table>")

    def to_frame(self) -> pd.DataFrame:
        """Return a pandas table: one row a warp, named by it.

        Raises
        ------
        MissingExtraError
            pandas is not installed.
        """
        try:
            import pandas as pd
        except ImportError as error:
            raise MissingExtraError("a table of warps", package="pandas", extra="pandas") from error
        return pd.DataFrame([vars(row) for row in self.rows]).set_index("name").dropna(axis="columns", how="all")


def compare_warps(
    warps: WarpLike | Mapping[str, WarpLike] | Sequence[WarpLike], *, motion: Motion | None = None
) -> WarpComparison:
    """Compare warps of one clip: how long, how fast, and how far from the first one.

    Parameters
    ----------
    warps : sequence of Warp or GuidedWarp, or mapping of str to them
        At least one. The names of a mapping are the rows'; else each warp's name, or method.
    motion : Motion, optional
        The input: then how its flights are played is compared too.

    Returns
    -------
    WarpComparison
        Its ``rows`` hold the numbers; it prints, and shows in a notebook, as a table, and `WarpComparison.to_frame`
        makes it one of pandas'.

    Raises
    ------
    OptionError
        No warp, something that is none, or a `motion` that is none.

    Examples
    --------
    >>> fast, slow = Warp([0.0, 1.0], [0.0, 2.0], method="fast"), Warp([0.0, 4.0], [0.0, 2.0], method="slow")
    >>> [(row.name, row.output_span, row.fastest, row.most_apart) for row in compare_warps([fast, slow]).rows]
    [('fast', 1.0, 2.0, 0.0), ('slow', 4.0, 0.5, 1.5)]
    """
    named = name_warps(warps, "compare_warps({name: warp})")
    if motion is not None and not isinstance(motion, Motion):
        raise OptionError(f"only a motion has flights; found a {type(motion).__name__}: leave motion out")
    spans = None if motion is None else flight_spans(motion)
    first = next(iter(named.values()))
    rows = []
    for name, warp in named.items():
        seconds, slopes = np.diff(warp.output_times), warp.slopes
        moving = np.abs(slopes[slopes != 0])
        mean_apart, most_apart = _apart(warp, first)
        timing = None if spans is None else flight_timing(warp, spans)
        rows.append(
            ComparedWarp(
                name=name,
                output_span=warp.output_span,
                slowest=float(moving.min()) if len(moving) else float("nan"),
                fastest=float(moving.max()) if len(moving) else float("nan"),
                at_unit_speed=float(seconds[np.abs(slopes - 1) < _SAME_SPEED].sum() / warp.output_span),
                held=float(seconds[slopes == 0].sum()),
                backward=float(seconds[slopes < 0].sum()),
                mean_apart=mean_apart,
                most_apart=most_apart,
                flights_kept=None if timing is None else timing.n_flights_kept,
                flights=None if timing is None else timing.n_flights,
                flight_slowest=None if timing is None else timing.slowest,
                flight_fastest=None if timing is None else timing.fastest,
            )
        )
    return WarpComparison(tuple(rows), named)


def _apart(warp: Warp, first: Warp) -> tuple[float, float]:
    """Mean and greatest distance between two warps where both are, exactly: they are straight between their knots."""
    start, end = max(warp.output_start, first.output_start), min(warp.output_end, first.output_end)
    if not start < end:
        return float("nan"), float("nan")
    knots = np.concatenate([warp.output_times, first.output_times])
    times = add_times(np.array([start, end]), knots[(knots > start) & (knots < end)])
    gap = warp(times) - first(times)
    before, after = gap[:-1], gap[1:]
    size = np.abs(before) + np.abs(after)
    # Where the gap changes its sign there are two triangles, else a trapezium.
    crossed = (before**2 + after**2) / np.where(size > 0, 2 * size, 1.0)
    heights = np.where(before * after < 0, crossed, size / 2)
    return float(np.sum(heights * np.diff(times)) / (end - start)), float(np.abs(gap).max())


def _written(value: object) -> str:
    if value is None:
        return ""
    return f"{value:.4g}" if isinstance(value, float) else str(value)
