"""The study's pictures."""

from __future__ import annotations

import contextlib
import io
import itertools
import math
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from retime.arrays import FloatArray
from retime.errors import MissingExtraError
from retime.evaluate.plot.panels import SPEED_LIMITS, step_curve
from retime.evaluate.plot.style import FLIGHT, GREY, INK, STYLE
from retime.evaluate.plot.warps import plot_warps
from retime.files import write_bytes
from retime.warp.curve import Warp
from study.answers.methods import Answered
from study.evaluations.evaluation import Evaluation
from study.signals.ball import SignalResult

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

# Pixels: half as much again as the page's width.
_WIDTH = 1700
_TICKS = {0.1: "1/10", 1.0: "1", 10.0: "10"}
# Which methods the picture of the known answers shows, and how.
_SHOWN: dict[str, dict[str, Any]] = {
    "aligned, repeated": {"color": "#be185d", "linewidth": 1.2, "linestyle": (0, (1.5, 1.2))},
    "guided, given length": {"color": "#0f766e", "linewidth": 2.0},
}


def draw_evaluation(evaluation: Evaluation, path: Path) -> None:
    """Draw speeds, time map and strip of poses of every version (`retime.plot_warps`)."""
    warps = {version.label: version.warp for version in evaluation.versions if version.warp is not None}
    plot_warps(
        warps,
        motion=evaluation.motion,
        path=path,
        title=f"{evaluation.key}: {evaluation.title}",
        n_poses=26,
        overwrite=True,
    )
    _lighten(path)


def _lighten(path: Path) -> None:
    """Make a PNG as large as a page shows it, with as many colours as a drawing has: a third of the bytes."""
    from PIL import Image

    with Image.open(path) as picture:
        height = round(picture.height * _WIDTH / picture.width)
        small = picture.convert("RGB").resize((_WIDTH, height), Image.Resampling.LANCZOS)
    few = small.quantize(96, method=Image.Quantize.MEDIANCUT, dither=Image.Dither.NONE)
    buffer = io.BytesIO()
    few.save(buffer, format="png", optimize=True)
    write_bytes(path, buffer.getvalue(), overwrite=True)


def draw_signal(result: SignalResult, path: Path) -> None:
    """Draw the bouncing ball, shortened."""
    plot_warps(
        {"linear": result.linear, "guided": result.guided.warp},
        motion=result.signal,
        path=path,
        title="A bouncing ball, shortened to 60 %",
        overwrite=True,
    )
    _lighten(path)


def draw_speeds(evaluations: Sequence[Evaluation], path: Path) -> None:
    """Draw the speed of every guided warp as the paper's Figure 5 does: a log axis from 1/10 to 10, unit speed a line.

    Thin: the frame path, as it was found; thick: the warp, smoothed.
    """
    n_rows = math.ceil(len(evaluations) / 3)
    with _style() as new_figure:
        figure = new_figure(figsize=(12.8, 2.1 * n_rows + 0.4))
        for place, evaluation in enumerate(evaluations):
            axes = figure.add_subplot(n_rows, 3, place + 1, label=evaluation.key)
            warp = evaluation.guided.staircase
            _speed_axes(axes, warp.output_start, warp.output_end)
            flights = [
                (float(evaluation.guided.warp.inverse()(start)), float(evaluation.guided.warp.inverse()(end)))
                for start, end in evaluation.flights
            ]
            for start, end in flights:
                axes.axvspan(start, end, color=FLIGHT, linewidth=0, zorder=0)
            smooth = evaluation.guided.warp
            reach = warp.output_span
            for curve, color, width in ((warp, "#5eada5", 0.8), (smooth, "#0f766e", 1.5)):
                line = step_curve(curve, curve.slopes > 0, curve.slopes)
                axes.plot(*simplified(*line, reach=reach), color=color, linewidth=width)
            axes.set_title(f"{evaluation.key}  {evaluation.title}", loc="left", fontsize=9.5, fontweight="bold")
        for axes in figure.axes[-3:]:
            axes.set_xlabel("output time (s)")
        figure.tight_layout()
        _write(figure, path)


def draw_answers(answered: Sequence[Answered], path: Path) -> None:
    """Draw speed over the input's time: the right one, the guided warp's, and an alignment's."""
    n_rows = math.ceil(len(answered) / 2)
    with _style() as new_figure:
        figure = new_figure(figsize=(12.8, 1.75 * n_rows + 0.7))
        lines = {}
        for place, one in enumerate(answered):
            axes = figure.add_subplot(n_rows, 2, place + 1, label=one.answer.name)
            truth = one.answer.truth
            _speed_axes(axes, float(truth.input_times[0]), float(truth.input_times[-1]), limits=(0.2, 5.0))
            for start, end in one.answer.spans:
                axes.axvspan(start, end, color="#f1f5f9", linewidth=0, zorder=0)
            for method, style in _SHOWN.items():
                attempt = one.attempt(method)
                if attempt is not None:
                    (lines[method],) = axes.plot(*_over_input(attempt.warp), **style)
            (lines["the answer"],) = axes.plot(*_over_input(truth), color=INK, linewidth=1.0)
            axes.set_title(f"{one.answer.name} ({one.answer.kind})", loc="left", fontsize=9.5, fontweight="bold")
        for axes in figure.axes[-2:]:
            axes.set_xlabel("input time (s)")
        figure.tight_layout(rect=(0, 0, 1, 1 - 0.35 / figure.get_figheight()))
        figure.legend(
            list(lines.values()), list(lines), loc="upper left", ncols=4, frameon=False, bbox_to_anchor=(0.02, 1.0)
        )
        _write(figure, path)


def _over_input(warp: Warp, *, window: float = 0.1) -> tuple[np.ndarray, np.ndarray]:
    """Speed over input time, taken over a short window."""
    times = np.arange(float(warp.input_times[0]), float(warp.input_times[-1]), 1 / 30)
    low = np.maximum(times - window / 2, warp.input_times[0])
    high = np.minimum(times + window / 2, warp.input_times[-1])
    ends = [np.interp(at, warp.input_times, warp.output_times) for at in (low, high)]
    shown = ends[1] - ends[0]
    return simplified(times, (high - low) / np.maximum(shown, 1e-3), reach=float(times[-1] - times[0]))


def simplified(x: FloatArray, y: FloatArray, *, reach: float, error: float = 0.004) -> tuple[FloatArray, FloatArray]:
    """Leave out the points of a curve that nobody would see missing (Douglas and Peucker).

    Parameters
    ----------
    x, y : float array, shape (n,)
        The curve; `y` is drawn on a log axis. Where `y` is NaN there is a gap.
    reach : float
        Width of the axis, in units of `x`.
    error : float
        What may be left out, as a share of the axis: two decades are as long as `reach`.

    Returns
    -------
    float array, float array
        The points that stay, ends included.

    Examples
    --------
    >>> simplified(np.arange(5.0), np.array([1.0, 1.0, 1.0, 3.0, 3.0]), reach=4.0)[0].tolist()
    [0.0, 2.0, 3.0, 4.0]
    """
    places = np.stack([x / reach, np.log10(np.clip(y, 1e-3, 1e3)) / 2], axis=1)
    keep = np.isnan(y)
    # The points beside a gap are ends.
    keep[1:] |= np.isnan(y[:-1])
    keep[:-1] |= np.isnan(y[1:])
    keep[[0, -1]] = True
    ends = np.flatnonzero(keep).tolist()
    pending = [(a, b) for a, b in itertools.pairwise(ends) if not np.isnan(y[a : b + 1]).any()]
    while pending:
        a, b = pending.pop()
        if b - a < 2:
            continue
        along = places[b] - places[a]
        off = places[a + 1 : b] - places[a]
        share = np.clip(off @ along / max(float(along @ along), 1e-18), 0.0, 1.0)
        distance = np.linalg.norm(off - share[:, None] * along, axis=1)
        worst = int(np.argmax(distance))
        if distance[worst] > error:
            keep[a + 1 + worst] = True
            pending += [(a, a + 1 + worst), (a + 1 + worst, b)]
    return x[keep], y[keep]


def _speed_axes(axes: Axes, start: float, end: float, *, limits: tuple[float, float] = SPEED_LIMITS) -> None:
    axes.set_yscale("log")
    axes.set(xlim=(start, end), ylim=limits)
    ticks: Mapping[float, str] = (
        _TICKS if limits == SPEED_LIMITS else {0.25: "1/4", 0.5: "1/2", 1.0: "1", 2.0: "2", 4.0: "4"}
    )
    axes.set_yticks(list(ticks), list(ticks.values()))
    axes.set_yticks([], minor=True)
    axes.axhline(1.0, color=GREY, linewidth=0.8, zorder=1)


@contextlib.contextmanager
def _style() -> Iterator[type[Figure]]:
    """Draw in the style of the other plots; raise MissingExtraError where matplotlib is missing."""
    try:
        import matplotlib
        from matplotlib.figure import Figure
    except ImportError as error:
        raise MissingExtraError("drawing a plot", package="matplotlib", extra="plot") from error
    with matplotlib.rc_context(STYLE):
        yield Figure


def _write(figure: Figure, path: Path) -> None:
    """Write an SVG without a date: the same numbers give the same bytes."""
    buffer = io.BytesIO()
    figure.savefig(buffer, format="svg", metadata={"Date": None})
    write_bytes(path, buffer.getvalue(), overwrite=True)
