"""The report of a run: one page of HTML that needs nothing else."""

from __future__ import annotations

import html
import math
from collections import Counter
from collections.abc import Iterable, Sequence
from pathlib import Path

import numpy as np

from retime.batch.task import Record
from retime.errors import OptionError, OutputExistsError
from retime.svg import Panel

# Clips that are shown as pictures, and failures of a kind that are listed.
_WORST, _LISTED = 12, 200
_BINS = 24
# By this a report is known for one.
_MARK = '<meta name="generator" content="retime batch">'

_STYLE = """\
:root { color-scheme: light dark; --line: #d5dae1; --quiet: #64748b; }
body { font: 15px/1.5 system-ui, sans-serif; margin: 0 auto; max-width: 75rem; padding: 1rem 1.5rem 3rem; }
h1 { font-size: 1.5rem; } h2 { font-size: 1.15rem; margin-top: 2rem; }
table { border-collapse: collapse; } td, th { padding: .25rem .8rem .25rem 0; text-align: left; vertical-align: top; }
th { color: var(--quiet); font-weight: 500; } tr + tr > * { border-top: 1px solid var(--line); }
.row { display: flex; flex-wrap: wrap; gap: 1rem; } figure { margin: 0; max-width: 392px; }
figcaption { overflow-wrap: anywhere; } .quiet { color: var(--quiet); } svg { max-width: 100%; height: auto; }
table { width: 100%; } td:first-child, th { width: 16rem; } td { overflow-wrap: anywhere; }
"""


def report_html(records: Sequence[Record], *, title: str, seconds: float) -> str:
    """Return the page.

    Parameters
    ----------
    records : sequence of Record
        Of all outputs and failures.
    title : str
        What was done to what, for its heading.
    seconds : float
        That the run took.
    """
    made = [record for record in records if record.status != "failed"]
    failures = [record for record in records if record.status == "failed"]
    return (
        '<!doctype html>\n<html lang="en"><head><meta charset="utf-8">'
        f'<meta name="viewport" content="width=device-width">{_MARK}'
        f"<title>{html.escape(title)}</title><style>{_STYLE}</style></head><body>\n"
        f"<h1>{html.escape(title)}</h1>\n{_counts(records, seconds)}\n{_distributions(made)}\n{_worst(made)}\n"
        f"{_failures(failures)}\n{_warnings(made)}\n</body></html>\n"
    )


def _counts(records: Sequence[Record], seconds: float) -> str:
    counted = Counter(record.status for record in records)
    made = [record for record in records if record.status != "failed"]
    flights, kept = sum(record.flights for record in made), sum(record.flights_kept for record in made)
    facts = {
        "Clips": f"{len({record.name for record in records}):,}",
        "Outputs made": f"{counted['done']:,}",
        "Outputs that were there": f"{counted['kept']:,}",
        "Clips that failed": f"{counted['failed']:,}",
        "Seconds of motion": f"{sum(record.frames_out / record.rate for record in made if record.rate):,.0f}",
        "Flights that keep every frame": f"{kept:,} of {flights:,}",
        "Time": f"{seconds:,.1f} s",
    }
    rows = "".join(f"<tr><th>{name}</th><td>{value}</td></tr>" for name, value in facts.items())
    return f"<table>{rows}</table>"


def _distributions(made: Sequence[Record]) -> str:
    if not made:
        return ""
    pictures = [
        _histogram("length, % of the input", [100 * r.frames_out / r.frames_in for r in made if r.frames_in], "%"),
        _histogram("input, seconds", [r.frames_in / r.rate for r in made if r.rate], "s"),
        _histogram("highest speed", [r.fastest for r in made if r.fastest], "x"),
        _histogram("time for an output, ms", [1000 * r.seconds for r in made], "ms"),
    ]
    return f'<h2>Distributions</h2><div class="row">{"".join(pictures)}</div>'


def _histogram(title: str, values: Iterable[float], unit: str) -> str:
    numbers = np.array([value for value in values if math.isfinite(value)])
    if not len(numbers):
        return ""
    low, high = float(numbers.min()), float(numbers.max())
    # Of values that are all one, or differ by rounding, no parts can be made.
    room = max(0.0, 1e-6 * max(abs(low), abs(high), 1.0) - (high - low))
    counts, edges = np.histogram(numbers, bins=_BINS, range=(low - room, high + room))
    panel = Panel(title, float(edges[0]), float(edges[-1]), 0.0, float(counts.max()), of=unit)
    panel.rule(0.0, "0", strong=True)
    panel.rule(float(counts.max()), f"{counts.max():,}")
    panel.line(np.repeat(edges, 2)[1:-1], np.repeat(counts, 2))
    return f"<figure>{panel.svg()}<figcaption class=quiet>median {np.median(numbers):.4g} {unit}</figcaption></figure>"


def _lost(record: Record) -> tuple[float, float]:
    """Order outputs by what a person would look at first: flights lost, then the highest speed."""
    return record.flights - record.flights_kept, record.fastest


def _worst(made: Sequence[Record]) -> str:
    worst = sorted((record for record in made if record.knots), key=_lost, reverse=True)[:_WORST]
    if not worst:
        return ""
    pictures = []
    for record in worst:
        knots = np.array(record.knots)
        panel = Panel("input time (s)", knots[0, 0], knots[-1, 0], knots[:, 1].min(), knots[:, 1].max())
        for value in (knots[:, 1].min(), knots[:, 1].max()):
            panel.rule(float(value), f"{value:.3g}")
        panel.line(knots[:, 0], knots[:, 1])
        flights = f"{record.flights_kept} of {record.flights} flights kept" if record.flights else "no flights"
        words = f"{flights}, up to {record.fastest:.1f}x"
        pictures.append(
            f"<figure>{panel.svg()}<figcaption>{html.escape(record.output)}<br><span class=quiet>{words}</span>"
            "</figcaption></figure>"
        )
    return (
        "<h2>To look at first</h2><p class=quiet>Where most flights lost frames, then where the speed is highest."
        f'</p><div class="row">{"".join(pictures)}</div>'
    )


def _failures(failures: Sequence[Record]) -> str:
    if not failures:
        return "<h2>Failures</h2><p>None.</p>"
    parts = [f"<h2>Failures</h2><p>{len(failures):,}, by kind:</p>"]
    for code, count in Counter(record.code for record in failures).most_common():
        listed = [record for record in failures if record.code == code][:_LISTED]
        rows = "".join(
            f"<tr><td>{html.escape(record.name)}</td><td>{html.escape(record.message)}</td></tr>" for record in listed
        )
        more = f"<p class=quiet>{count - len(listed):,} more stand in the manifest.</p>" if count > len(listed) else ""
        parts.append(f"<h3>{html.escape(code)}: {count:,}</h3><table>{rows}</table>{more}")
    return "".join(parts)


def _warnings(made: Sequence[Record]) -> str:
    said = [record for record in made if record.warnings]
    if not said:
        return ""
    rows = "".join(
        f"<tr><td>{html.escape(record.output)}</td><td>{'<br>'.join(map(html.escape, record.warnings))}</td></tr>"
        for record in said[:_LISTED]
    )
    more = f"<p class=quiet>{len(said) - _LISTED:,} more stand in the manifest.</p>" if len(said) > _LISTED else ""
    return f"<h2>Warnings</h2><p>Of {len(said):,} outputs.</p><table>{rows}</table>{more}"


def refuse_bad_place(place: Path, out: Path, *, force: bool) -> None:
    """Refuse a place for a report while it is early: a page that can't be written after a long night helps nobody.

    Parameters
    ----------
    place : Path
        Of the report.
    out : Path
        The folder of outputs, which may still have to be made.
    force : bool
        Replace a file that is no report.

    Raises
    ------
    OptionError
        What opens pages would not open it, or its folder is not there.
    OutputExistsError
        A file is there that no run has written.
    """
    if not place.name.lower().endswith((".html", ".htm")):
        raise OptionError(f"a report is a page, .html; found {place}")
    folder = place.absolute().parent
    if not folder.is_dir() and folder != out.absolute():
        raise OptionError(f"the report's folder {folder} is not there")
    if place.exists() and not force:
        with place.open("rb") as file:
            if _MARK.encode() not in file.read(1000):
                raise OutputExistsError(place)
