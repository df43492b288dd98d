"""The study's numbers as tables, for a page of Markdown or HTML, and as plain data for JSON."""

from __future__ import annotations

import dataclasses
import html
import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from retime.evaluate.metrics import FlightTiming
from retime.evaluate.sensitivity import LENGTHS, Row, default_row, row_of
from retime.evaluate.study import PAPER, Evaluation, Figures
from retime.evaluate.study_answers import METHODS, Answered
from retime.evaluate.study_prototype import Comparison
from retime.evaluate.study_signals import CameraResult, CurveResult, SignalResult
from retime.motion.motion import Motion
from retime.motion.signal import Signal
from retime.warp.curve import Warp
from retime.warp.result import GuidedWarp

NOTHING = "–"


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


def sizes_table(evaluations: Sequence[Evaluation]) -> Table:
    """Table 1: sizes and times, ours above the paper's own."""
    headings = (
        *("trial", "", "n", "m", "r", "s", "objective (ms)", "search (ms)"),
        *("recurrence (ms)", "heuristic (ms)", "heuristic's excess"),
    )
    rows = []
    for one in evaluations:
        row = one.row
        excess = NOTHING if row.excess is None else f"{row.excess:.0%}"
        rows.append(
            (
                one.key,
                "here",
                *(str(size) for size in (row.n_input, row.n_output, row.n_reference, row.max_skip)),
                milliseconds(row.objective),
                milliseconds(row.search),
                milliseconds(row.layered),
                milliseconds(row.heuristic),
                excess,
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
                )
            )
    return Table(headings, tuple(rows), numbers_from=2)


# What is shown of each figure: heading, and how to write it. A column that no version has is left out.
_COLUMNS: tuple[tuple[str, Callable[[Figures], str]], ...] = (
    ("length (s)", lambda f: number(f.seconds)),
    ("keytimes missed by (ms)", lambda f: number(None if f.keytimes_missed is None else f.keytimes_missed * 1000, 1)),
    ("fastest (×)", lambda f: number(f.fastest, 1)),
    (
        "flight frames kept",
        lambda f: NOTHING if f.flight_frames is None else f"{f.flight_frames_kept} of {f.flight_frames}",
    ),
    (
        "flights play at (×)",
        lambda f: NOTHING if f.flight_slowest is None else _range(f.flight_slowest, f.flight_fastest or math.inf),
    ),
    ("gravity (× input's)", lambda f: number(f.gravity)),
    ("standing still (s)", lambda f: number(f.idle)),
    ("jerk (m/s³)", lambda f: number(f.jerk, 0)),
    ("foot slip (mm)", lambda f: number(f.slip, 1)),
    ("distance to reference (cm)", lambda f: number(f.distance, 1)),
    (
        "wrists: 50, 90, 99 % below (m/s)",
        lambda f: NOTHING if f.speeds is None else " / ".join(number(speed) for speed in f.speeds),
    ),
    ("wrists: off by (m/s)", lambda f: number(f.speeds_distance)),
    ("correlation with the answer", lambda f: NOTHING if f.closeness is None else number(f.closeness.correlation)),
    ("off in time (frames)", lambda f: NOTHING if f.closeness is None else number(f.closeness.mean_error, 1)),
)


def _range(low: float, high: float) -> str:
    a, b = number(low), number(high)
    return a if a == b else f"{a} to {b}"


def figures_table(evaluation: Evaluation) -> Table:
    """Figures of merit, one row a version; the method's own is marked."""
    written = [(heading, [write(version.figures) for version in evaluation.versions]) for heading, write in _COLUMNS]
    shown = [(heading, texts) for heading, texts in written if any(text != NOTHING for text in texts)]
    rows = tuple((version.label, *(texts[i] for _, texts in shown)) for i, version in enumerate(evaluation.versions))
    marked = frozenset(i for i, version in enumerate(evaluation.versions) if version.label == "guided")
    return Table(("version", *(heading for heading, _ in shown)), rows, marked=marked)


def answers_table(answered: Sequence[Answered]) -> Table:
    """How alike playback speeds are: correlation of log-speed, where the answer has something to say."""
    rows = []
    for one in answered:
        found = [one.attempt(method) for method in METHODS[1:]]
        cells = [NOTHING if attempt is None else number(attempt.inside.correlation) for attempt in found]
        rows.append((one.answer.name, one.answer.kind, *cells))
    return Table(("case", "kind", *METHODS[1:]), tuple(rows), numbers_from=2)


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


def sensitivity_table(rows: Sequence[Row]) -> Table:
    """One row a setting: flights kept at each length, and closeness to known answers."""
    lengths = [length for length in LENGTHS if any(one.length == length for one in rows[0].preserved)]
    headings = (
        *("choice", "setting"),
        *(f"kept at {length}" for length in lengths),
        *("kept in all", "of high flights", "limps", "jumps", "boxing", "log-speed off by", "… neutral", "… sum"),
        *("length off by, neutral", "… sum"),
    )
    written = []
    group = ""
    for row in rows:
        kept, frames = row.kept()
        high, high_frames = row.kept_high()
        first = row.setting.group if row.setting.group != group else ""
        group = row.setting.group
        written.append(
            (
                first,
                row.setting.label,
                *(str(row.kept(length)[0]) for length in lengths),
                f"{kept} of {frames}",
                f"{high} of {high_frames}",
                *(number(row.mean("correlation", kind=kind)) for kind in ("limp", "jump", "boxing")),
                number(row.mean("log_speed_error", length="given")),
                number(row.mean("log_speed_error", length="neutral")),
                number(row.mean("log_speed_error", length="sum")),
                number(row.mean("length_ratio", length="neutral"), 0, " %"),
                number(row.mean("length_ratio", length="sum"), 0, " %"),
            )
        )
    marked = frozenset(i for i, row in enumerate(rows) if row is default_row(rows))
    return Table(headings, tuple(written), numbers_from=2, marked=marked)


def losses_table(rows: Sequence[Row]) -> Table:
    """Clip by clip and length by length: in-flight frames kept, as recommended and as the paper has it."""
    recommended, paper = default_row(rows), rows[0]
    lengths = list(dict.fromkeys(one.length for one in recommended.preserved))
    clips = list(dict.fromkeys(one.clip for one in recommended.preserved))

    def cell(row: Row, clip: str, length: str) -> str:
        one = next(one for one in row.preserved if (one.clip, one.length) == (clip, length))
        return f"{one.n_kept} of {one.n_frames}"

    headings = ("clip", *lengths, *(f"{length}, as printed" for length in lengths))
    written = [
        (
            clip,
            *(cell(recommended, clip, length) for length in lengths),
            *(cell(paper, clip, length) for length in lengths),
        )
        for clip in clips
    ]
    return Table(headings, tuple(written))


def prototype_table(compared: Sequence[Comparison]) -> Table:
    """Lay out the prototype's figures beside the package's."""
    return Table(("what", "prototype", "here"), tuple((one.what, one.prototype, one.here) for one in compared))


def signals_table(camera: CameraResult, curve: CurveResult, ball: SignalResult) -> Table:
    """One warp for a camera, and a guided warp of a signal."""
    rows = (
        ("camera aim off by, before", f"{camera.before:.2f}°", "camera and figure as made"),
        (
            "… both warped by one warp",
            f"{camera.together:.2f}°",
            f"{camera.n_input} to {camera.n_output} frames, 24 Hz",
        ),
        ("… the figure alone warped", f"{camera.motion_alone:.1f}°", "what goes wrong otherwise"),
        (
            "curve of the root's height off by, warped by the same warp",
            f"{curve.together * 1000:.1f} mm",
            f"{curve.n_input} to {curve.n_output} samples, 50 Hz",
        ),
        ("… the figure alone warped", f"{curve.motion_alone * 1000:.0f} mm", "what goes wrong otherwise"),
        ("ball, guided: flight frames kept", _kept(ball.timing), f"gravity {ball.gravity:.2f} × 9.81 m/s²"),
        (
            "ball, linear: flight frames kept",
            _kept(ball.linear_timing),
            f"gravity {ball.linear_gravity:.2f} × 9.81 m/s²",
        ),
    )
    return Table(("what", "value", "note"), rows, numbers_from=3)


def _kept(timing: FlightTiming) -> str:
    return f"{timing.n_kept} of {timing.n_frames}"


def text_values(rows: Sequence[Row], evaluations: Sequence[Evaluation]) -> dict[str, str]:
    """Write the numbers that the text around the tables mentions, by name."""
    found: dict[str, str] = {}
    if rows:
        default = default_row(rows)
        for name, row in (("default", default), ("printed", rows[0])):
            kept, frames = row.kept()
            found[f"kept-{name}"] = f"{kept:,} of {frames:,}"
            found[f"share-{name}"] = f"{kept / frames:.0%}".replace("%", " %")
        high, high_frames = default.kept_high()
        found["kept-high"] = f"{high} of {high_frames}"
        torso = row_of(rows, {**default.setting.options, "features": "torso"})
        found["share-torso"] = f"{torso.kept()[0] / torso.kept()[1]:.0%}".replace("%", " %")
        for name, row in (("default", default), ("torso", torso)):
            found[f"jumps-{name}"] = number(row.mean("correlation", kind="jump"))
            found[f"limps-{name}"] = number(row.mean("correlation", kind="limp"))
        for weight in ("neutral", "sum"):
            found[f"length-{weight}"] = number(default.mean("length_ratio", length=weight), 0, " %")
            found[f"log-speed-{weight}"] = number(default.mean("log_speed_error", length=weight))
    excesses = [one.row.excess for one in evaluations if one.row.excess is not None]
    if excesses:
        found["excess"] = f"{min(excesses) * 100:.0f} to {max(excesses) * 100:.0f} %"
    return found


def plain(value: Any) -> Any:
    """Turn results into what JSON can hold: no motions, no warps, no infinities.

    Motions and signals become their names and sizes, warps their knots' counts and ends; numbers that are not finite
    become null.
    """
    if isinstance(value, Motion | Signal):
        return {"name": value.name, "n_frames": value.n_frames, "rate": str(value.rate)}
    if isinstance(value, Warp):
        return {"method": value.method, "seconds": value.output_span, "n_knots": len(value.output_times)}
    if isinstance(value, GuidedWarp):
        stated = (
            "n_input",
            "n_output",
            "n_reference",
            "max_skip",
            "upsample",
            "total",
            "score",
            "time_scale",
            "low_pass",
        )
        return {name: plain(getattr(value, name)) for name in stated} | {"warp": plain(value.warp)}
    if dataclasses.is_dataclass(value) and not isinstance(value, type):
        return {field.name: plain(getattr(value, field.name)) for field in dataclasses.fields(value)}
    if isinstance(value, Mapping):
        return {str(key): plain(one) for key, one in value.items()}
    if isinstance(value, str | bool | int) or value is None:
        return value
    if isinstance(value, float | np.floating):
        # Four digits are as many as any of these means.
        return float(f"{value:.4g}") if math.isfinite(value) else None
    if isinstance(value, np.integer):
        return int(value)
    if callable(value):
        return getattr(value, "__name__", "function").strip("_")
    return [plain(one) for one in value]
