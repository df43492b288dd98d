"""What each choice is worth: a row a setting, and where flights are lost."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from study.choices.questions import LENGTHS, Row, default_row, printed_row
from study.tables.table import Table
from study.text import number


def _of(kept: tuple[int, int]) -> str:
    return f"{kept[0]} of {kept[1]}"


# One entry a column: heading, and how to write it. The flights kept at each length stand before these.
_COLUMNS: tuple[tuple[str, Callable[[Row], str]], ...] = (
    ("kept in all", lambda row: _of(row.kept())),
    ("of high flights", lambda row: _of(row.kept_high())),
    ("limps", lambda row: number(row.mean("correlation", kind="limp"))),
    ("jumps", lambda row: number(row.mean("correlation", kind="jump"))),
    ("boxing", lambda row: number(row.mean("correlation", kind="boxing"))),
    ("log-speed off by", lambda row: number(row.mean("log_speed_error", length="given"))),
    ("… neutral", lambda row: number(row.mean("log_speed_error", length="neutral"))),
    ("… sum", lambda row: number(row.mean("log_speed_error", length="sum"))),
    ("length off by, neutral", lambda row: number(row.mean("length_ratio", length="neutral"), 0, " %")),
    ("… sum", lambda row: number(row.mean("length_ratio", length="sum"), 0, " %")),
)


def choices_table(rows: Sequence[Row]) -> Table:
    """One row a setting: flights kept at each length, and closeness to known answers."""
    lengths = [length for length in LENGTHS if any(one.length == length for one in rows[0].preserved)]
    written = []
    group = ""
    for row in rows:
        first = row.setting.group if row.setting.group != group else ""
        group = row.setting.group
        kept = [str(row.kept(length)[0]) for length in lengths]
        written.append((first, row.setting.label, *kept, *(write(row) for _, write in _COLUMNS)))
    headings = ("choice", "setting", *(f"kept at {length}" for length in lengths), *(text for text, _ in _COLUMNS))
    marked = frozenset(i for i, row in enumerate(rows) if row is default_row(rows))
    return Table(headings, tuple(written), numbers_from=2, marked=marked)


def losses_table(rows: Sequence[Row]) -> Table:
    """Clip by clip and length by length: in-flight frames kept, by each way of the analysis that is compared."""
    # The default stands without a name.
    columns = {"": default_row(rows), ", as printed": printed_row(rows)}
    lengths = list(dict.fromkeys(one.length for one in rows[0].preserved))
    clips = list(dict.fromkeys(one.clip for one in rows[0].preserved))
    kept = {
        name: {(one.clip, one.length): _of((one.n_kept, one.n_frames)) for one in row.preserved}
        for name, row in columns.items()
    }
    headings = ("clip", *(f"{length}{name}" for name in columns for length in lengths))
    written = [(clip, *(kept[name][clip, length] for name in columns for length in lengths)) for clip in clips]
    return Table(headings, tuple(written))
