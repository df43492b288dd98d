"""The panels of a plot: playback speed, time map, strip."""

from __future__ import annotations

import math
import textwrap
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from retime.arrays import FloatArray
from retime.evaluate.metrics.spans import output_intervals
from retime.evaluate.plot import style
from retime.evaluate.plot.stick_figure import HEAD_RADIUS, FigureView, view_of
from retime.evaluate.plot.strip import Row, Strip, in_flight
from retime.evaluate.plot.style import Pen, shown
from retime.motion.any_motion import AnyMotion
from retime.motion.motion import Motion
from retime.motion.signal import Signal
from retime.warp.curve import Warp
from retime.warp.keytime import Keytime

if TYPE_CHECKING:
    from matplotlib.axes import Axes

SPEED_LIMITS = (0.1, 10.0)
_SPEED_TICKS = {0.1: "1/10", 0.25: "1/4", 0.5: "1/2", 1.0: "1", 2.0: "2", 4.0: "4", 10.0: "10"}
# A slope smaller than this is a hold: it moves by less than a hundredth of a frame in an hour.
_HELD = 1e-7
# A warp with more pieces is drawn as the least and greatest of so many stretches; the paper has no room for more.
MOST_STEPS = 3000
# A flight's ribbon in the speed panel reaches from the speed divided by this to the speed times this.
_RIBBON = 1.2
_RIBBON_SAMPLES = 300
# Lanes at the foot of the speed panel, one for each warp that holds: shares of the panel's height.
_LANE, _LANE_STEP = 0.045, 0.055
# Seconds of output beyond which curves are drawn thin, lest they fill the panel.
_DENSE = 60.0
_MOST_CHANNELS = 3
# How many letters of a legend fit beside the title of the speed panel; a line's sample takes as much as some of them.
_LEGEND_LETTERS, _LETTERS_A_LINE = 70, 7
_CHANNEL_LINES: tuple[tuple[str, Any], ...] = (
    (style.NEAR, "solid"),
    ("#b45309", (0, (5, 1.5))),
    ("#0f766e", (0, (1.5, 1))),
)

Times = Sequence[tuple[float, float]]
Warps = Mapping[str, Warp]
Pens = Mapping[str, Pen]


def step_curve(warp: Warp, drawn: np.ndarray, values: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Vertices of a curve that has one value in each piece of a warp, with a gap (NaN) where a piece is not drawn.

    Examples
    --------
    >>> x, y = step_curve(Warp([0.0, 1.0, 3.0], [0.0, 2.0, 3.0]), np.array([True, True]), np.array([2.0, 0.5]))
    >>> x.tolist(), y.tolist()
    ([0.0, 1.0, 1.0, 3.0], [2.0, 2.0, 0.5, 0.5])
    """
    y = np.where(drawn, values, np.nan)
    starts, stops = warp.output_times[:-1], warp.output_times[1:]
    low = high = y
    if len(y) > MOST_STEPS:
        first = np.linspace(0, len(y), MOST_STEPS // 2 + 1).astype(np.intp)[:-1]
        starts, stops = starts[first], stops[np.append(first[1:], len(y)) - 1]
        low, high = np.fmin.reduceat(y, first), np.fmax.reduceat(y, first)
    return np.stack([starts, stops], axis=1).ravel(), np.stack([low, high], axis=1).ravel()


def stretches(warp: Warp, pieces: np.ndarray) -> list[tuple[float, float]]:
    """Output times between which some pieces of a warp follow one another without a gap."""
    edges = np.flatnonzero(np.diff(np.concatenate([[False], pieces, [False]]).astype(int)))
    return [(float(warp.output_times[a]), float(warp.output_times[b])) for a, b in edges.reshape(-1, 2)]


def draw_speed(
    axes: Axes, warps: Warps, pens: Pens, flights: Times, keytimes: Sequence[Keytime], *, above: float
) -> None:
    """Playback speed over output time, on a log axis; the legend leaves `above` free, a share of the panel's height."""
    start = min(warp.output_start for warp in warps.values())
    end = max(warp.output_end for warp in warps.values())
    axes.set_yscale("log")
    axes.set(xlim=(start, end), ylim=SPEED_LIMITS, xlabel="output time (s)", ylabel="playback speed (×)")
    axes.set_yticks(list(_SPEED_TICKS), list(_SPEED_TICKS.values()))
    axes.set_yticks([], minor=True)
    axes.grid(axis="y", color=style.PALE, linewidth=0.7)
    axes.axhline(1.0, color=style.INK, linewidth=0.9, zorder=1.5, label="_unit speed")
    lines = []
    for number, (label, warp) in enumerate(warps.items()):
        _draw_ribbon(axes, warp, flights)
        line = dict(pens[label].line)
        if end - start > _DENSE:
            line["linewidth"] *= 0.5
        # A plain curve lies on top of one that has many pieces, and would be hidden below it.
        line["zorder"] = 3 + 1 / len(warp.slopes)
        lines += axes.plot(*step_curve(warp, warp.slopes > _HELD, warp.slopes), label=label, **line)
        _draw_off_the_axis(axes, warp, pens[label], number)
    _draw_key_lines(axes, keytimes, start, end)
    names = [shown(label, 18, legend=True) for label in warps][:6]
    n_columns = len(names)
    # Beside the panel's title there is room for so many letters; more of them take a second row.
    if sum(len(name) + _LETTERS_A_LINE for name in names) > _LEGEND_LETTERS:
        n_columns = math.ceil(len(names) / 2)
        names = [shown(label, _LEGEND_LETTERS // n_columns - _LETTERS_A_LINE, legend=True) for label in warps][:6]
    legend = axes.legend(
        lines[:6],
        names,
        loc="lower right",
        bbox_to_anchor=(1.01, 1.005 + above),
        ncols=n_columns,
        frameon=False,
        handlelength=3.4,
        columnspacing=1.6 if n_columns == len(names) else 0.7,
        borderaxespad=0.2,
    )
    for text in legend.get_texts():
        text.set_parse_math(False)


def _draw_ribbon(axes: Axes, warp: Warp, flights: Times) -> None:
    """Shade flights around the speeds that they are played at: each warp shows them at times of its own."""
    from matplotlib.patches import PathPatch
    from matplotlib.path import Path

    left, right = axes.get_xlim()
    polygons = []
    for start, stop in (interval for times in flights for interval in output_intervals(warp, *times)):
        # As many samples as show on paper, and no more: a long clip has hundreds of flights.
        n_samples = 1 + round(_RIBBON_SAMPLES * (stop - start) / (right - left))
        bounds = np.linspace(start, stop, n_samples + 1)
        speeds = np.repeat(warp.speed((bounds[:-1] + bounds[1:]) / 2), 2)
        times = np.stack([bounds[:-1], bounds[1:]], axis=1).ravel()
        for part in np.split(np.arange(len(speeds)), np.flatnonzero(np.diff(speeds > _HELD)) + 1):
            if speeds[part[0]] > _HELD:
                x, y = times[part], speeds[part]
                upper, lower = np.column_stack([x, y * _RIBBON]), np.column_stack([x, y / _RIBBON])
                polygons.append(np.vstack([upper, lower[::-1], upper[:1]]))
    if polygons:
        codes = [code for p in polygons for code in [Path.MOVETO, *[Path.LINETO] * (len(p) - 2), Path.CLOSEPOLY]]
        path = Path(np.vstack(polygons), codes)
        axes.add_patch(PathPatch(path, facecolor=style.FLIGHT, linewidth=0, zorder=1.2, label="_flights"))


def _draw_off_the_axis(axes: Axes, warp: Warp, pen: Pen, number: int) -> None:
    """Show what a log axis from 1/10 to 10 can't: holds, backward pieces, and speeds beyond its ends."""
    low, high = SPEED_LIMITS
    slopes = warp.slopes
    held, backward = np.abs(slopes) <= _HELD, slopes < -_HELD
    if held.any():
        foot = _LANE_STEP * number
        for a, b in stretches(warp, held):
            axes.axvspan(a, b, ymin=foot, ymax=foot + _LANE, color=pen.color, alpha=0.3, linewidth=0, label="_hold")
        a, b = _longest(stretches(warp, held))
        height = low * (high / low) ** (foot + _LANE / 2)
        _note(axes, "hold", (a + b) / 2, height, (0, -3), pen, size=7.5)
    if backward.any():
        # Dots alone could be another warp's pen.
        dots = {**pen.line, "linestyle": (0, (1, 1)), "marker": "<", "markersize": 5, "markevery": 0.05}
        axes.plot(*step_curve(warp, backward, -slopes), zorder=3, label="_backward", **dots)
        a, b = _longest(stretches(warp, backward))
        top = float(np.clip(abs(warp.speed((a + b) / 2)), low, high))
        _note(axes, "backward", (a + b) / 2, top, (0, 5 if top < 6 else -14), pen)
    beyond = (np.abs(slopes) > high * (1 + 1e-9)) | ((np.abs(slopes) < low * (1 - 1e-9)) & ~held)
    if beyond.any():
        at_edge = step_curve(warp, beyond, np.clip(np.abs(slopes), low, high))
        axes.plot(*at_edge, zorder=3, label="_beyond", clip_on=False, **pen.line)
    middles = (warp.output_times[:-1] + warp.output_times[1:]) / 2
    fastest, slowest = int(np.abs(slopes).argmax()), int(np.abs(slopes).argmin())
    if (speed := abs(slopes[fastest])) > high * (1 + 1e-9):
        _note(axes, f"▲ up to {speed:.3g}×", middles[fastest], high, (0, -14 - 11 * number), pen)
    # Beside a hold or a turn every smooth warp passes through all small speeds; nothing to report there.
    if not held.any() and not backward.any() and (speed := slopes[slowest]) < low * (1 - 1e-9):
        _note(axes, f"▼ down to {speed:.2g}×", middles[slowest], low, (0, 5 + 11 * number), pen)


def _longest(intervals: Times) -> tuple[float, float]:
    return max(intervals, key=lambda times: times[1] - times[0])


def _note(
    axes: Axes, text: str, time: float, speed: float, offset: tuple[int, int], pen: Pen, size: float = 8.5
) -> None:
    left, right = axes.get_xlim()
    share = (time - left) / (right - left)
    side = "left" if share < 0.07 else "right" if share > 0.93 else "center"
    axes.annotate(
        text,
        (time, speed),
        xytext=offset,
        textcoords="offset points",
        ha=side,
        color=pen.color,
        fontsize=size,
        zorder=5,
    )


def _draw_key_lines(axes: Axes, keytimes: Sequence[Keytime], start: float, end: float) -> None:
    for key in keytimes:
        # Not on the panel's own edges.
        if start + 0.001 * (end - start) < key.output_time < end - 0.001 * (end - start):
            axes.axvline(
                key.output_time, color=style.GREY, linewidth=0.8, linestyle=(0, (1, 2)), zorder=1, label="_key line"
            )


def draw_keys(axes: Axes, keytimes: Sequence[Keytime], limits: tuple[float, float]) -> None:
    """Mark when keytimes stand, in a lane of their own: they have no speed, so no place among speeds."""
    times = [key.output_time for key in keytimes if limits[0] <= key.output_time <= limits[1]]
    axes.axhline(0.0, color=style.PALE, linewidth=0.7, zorder=1)
    axes.plot(times, [0.0] * len(times), label="_keytimes", **style.KEY_MARKS)
    axes.set(xlim=limits, ylim=(-1.0, 1.0))
    axes.set_axis_off()
    axes.text(-0.012, 0.5, "keys", transform=axes.transAxes, ha="right", va="center", color=style.GREY, fontsize=8.5)


def draw_map(axes: Axes, warps: Warps, pens: Pens, flights: Times, keytimes: Sequence[Keytime]) -> None:
    """Input time over output time."""
    for a, b in flights:
        axes.axhspan(a, b, color=style.FLIGHT, linewidth=0, zorder=0.5, label="_flight")
    for label, warp in warps.items():
        axes.plot(warp.output_times, warp.input_times, label=label, **pens[label].line)
    if keytimes:
        x, y = [key.output_time for key in keytimes], [key.input_time for key in keytimes]
        axes.plot(x, y, label="_keytimes", **style.KEY_MARKS)
    starts, stops = [w.output_start for w in warps.values()], [w.output_end for w in warps.values()]
    lows, highs = [w.input_times.min() for w in warps.values()], [w.input_times.max() for w in warps.values()]
    low, high = float(min(lows)), float(max(highs))
    # A warp that only holds spans no input time; an axis has to span something.
    margin = 0.5 if high == low else 0.0
    axes.set(xlim=(min(starts), max(stops)), ylim=(low - margin, high + margin))
    axes.set(xlabel="output time (s)", ylabel="input time (s)")


def draw_strip(rows: Sequence[Axes], strip: Strip, motion: AnyMotion, *, size: tuple[float, float]) -> None:
    """Poses, or a signal's values, at even output times: one of `rows` for each row of the strip.

    `size` is that of each of the axes, in inches.
    """
    figures = isinstance(motion, Motion)
    # Room at the ends for half a pose.
    seconds = (strip.right - strip.left) / (size[0] - (0.7 if figures else 0.0))
    pad = 0.35 * seconds if figures else 0.0
    for axes, row in zip(rows, strip.rows, strict=True):
        _prepare_row(axes, row, strip, float(motion.rate), labelled=axes is rows[-1])
        axes.set_xlim(strip.left - pad, strip.right + pad)
    if isinstance(motion, Motion):
        _draw_poses(rows, strip, motion, size[1], seconds)
    else:
        _draw_channels(rows, strip, motion)
    if not strip.aligned:
        rows[-1].set_xlabel("output time (s)")
    elif strip.rows[0].flights:
        rows[-1].set_xlabel("output time from take-off (s)")
    else:
        rows[-1].set_xlabel(f"output time from where the input is at {strip.anchor:.2f} s (s)")


def _prepare_row(axes: Axes, row: Row, strip: Strip, rate: float, *, labelled: bool) -> None:
    for spine in axes.spines.values():
        spine.set_visible(False)
    axes.patch.set_visible(False)
    axes.set_yticks([])
    axes.tick_params(axis="x", length=3 if labelled else 0, labelbottom=labelled)
    axes.grid(axis="x", color=style.PALE, linewidth=0.7)
    name: dict[str, Any] = {"transform": axes.transAxes, "ha": "right", "parse_math": False}
    words = "\n".join(textwrap.wrap(shown(row.label, 20), 11))
    axes.text(-0.01, 0.45, words, va="bottom", fontweight="bold", fontsize=10.5 if "\n" not in words else 9.5, **name)
    length = f"{row.warp.count_frames(rate) / rate:.2f} s"
    span = f"{row.start:.2f}–{row.stop:.2f}\nof {length}" if strip.aligned else length
    axes.text(-0.01, 0.42, span, va="top", color=style.GREY, fontsize=8.5, linespacing=1.3, **name)


def _draw_poses(rows: Sequence[Axes], strip: Strip, motion: Motion, height: float, seconds: float) -> None:
    view = view_of(motion)
    shapes = [view.project(motion, row.warp(row.pose_times)) for row in strip.rows]
    # In statures, as all heights here. The top of a row is kept for the labels of its flights.
    tallest = max(1.0, *(float(shape[..., 1].max()) for shape in shapes)) + 2 * HEAD_RADIUS
    deepest = min(0.0, *(float(shape[..., 1].min()) for shape in shapes)) - 0.03
    an_inch = (tallest - deepest) / (height - 0.17)
    for axes, row, shape in zip(rows, strip.rows, shapes, strict=True):
        axes.set_ylim(deepest, deepest + height * an_inch)
        axes.plot(
            [row.start - row.origin, row.stop - row.origin], [0, 0], color="#94a3b8", linewidth=1, label="_ground"
        )
        _draw_flights(axes, row, strip, seconds)
        flying = in_flight(row.pose_times, row.flights)
        for time, pose, up in zip(row.pose_times - row.origin, shape, flying, strict=True):
            _draw_figure(axes, view, np.column_stack([time + pose[:, 0] * seconds / an_inch, pose[:, 1]]), bool(up))
            if view.head >= 0:
                _draw_head(axes, time + pose[view.head, 0] * seconds / an_inch, pose[view.head, 1], an_inch, bool(up))


def _draw_flights(axes: Axes, row: Row, strip: Strip, seconds: float) -> None:
    free_from = -np.inf
    for a, b in row.flights:
        left, right = max(a - row.origin, strip.left), min(b - row.origin, strip.right)
        if left >= right:
            continue
        axes.axvspan(left, right, color=style.FLIGHT, linewidth=0, zorder=0.8, label="_flight")
        # A flight that the strip's end cuts off would be labelled with a time that is not seen.
        if left > a - row.origin or right < b - row.origin:
            continue
        n_poses = row.poses_in((a, b))
        for text in (f"{b - a:.2f} s · {n_poses} pose{'s' * (n_poses != 1)}", f"{b - a:.2f} s"):
            half = 0.036 * len(text) * seconds
            if (left + right) / 2 - half > free_from:
                free_from = (left + right) / 2 + half
                axes.text(
                    (left + right) / 2,
                    0.985,
                    text,
                    transform=axes.get_xaxis_transform(),
                    ha="center",
                    va="top",
                    fontsize=8.5,
                    fontweight="bold",
                    color=style.FLIGHT_INK,
                )
                break


def _draw_figure(axes: Axes, view: FigureView, nodes: FloatArray, up: bool) -> None:
    """One path for each side: far limbs, trunk, near limbs."""
    from matplotlib.patches import PathPatch
    from matplotlib.path import Path

    for side, color in (style.FLYING_SIDES if up else style.STANDING_SIDES).items():
        chains = [chain.nodes for chain in view.chains if chain.side == side]
        if chains:
            codes = [code for chain in chains for code in [Path.MOVETO, *[Path.LINETO] * (len(chain) - 1)]]
            path = Path(nodes[[node for chain in chains for node in chain]], codes)
            axes.add_patch(
                PathPatch(
                    path,
                    fill=False,
                    edgecolor=color,
                    linewidth=2.0,
                    capstyle="round",
                    joinstyle="round",
                    clip_on=False,
                    zorder=3,
                )
            )


def _draw_head(axes: Axes, time: float, height: float, an_inch: float, up: bool) -> None:
    # The joint is at the head's base.
    axes.plot(
        [time],
        [height + HEAD_RADIUS / 2],
        "o",
        color=style.FLYING_SIDES[""] if up else style.STANDING_SIDES[""],
        markersize=2 * HEAD_RADIUS / an_inch * 72,
        markeredgewidth=0,
        clip_on=False,
        zorder=3,
        label="_head",
    )


def _draw_channels(rows: Sequence[Axes], strip: Strip, signal: Signal) -> None:
    known = ~signal.holes
    low = signal.values.min(axis=0, where=known, initial=np.inf)
    high = signal.values.max(axis=0, where=known, initial=-np.inf)
    extent = np.where(high > low, high - low, 1.0)
    names = signal.names[:_MOST_CHANNELS]
    for axes, row in zip(rows, strip.rows, strict=True):
        axes.set_ylim(-0.15, 1.15)
        axes.plot(
            [row.start - row.origin, row.stop - row.origin],
            [-0.13, -0.13],
            color="#94a3b8",
            linewidth=1,
            label="_ground",
        )
        n_frames = round((row.stop - row.start) * float(signal.rate)) + 1
        smooth = np.linspace(row.start, row.stop, min(n_frames, MOST_STEPS))
        for times, marks in ((smooth, False), (row.pose_times, True)):
            values = (signal.at(row.warp(times)).values - low) / extent
            for channel, (name, (color, linestyle)) in enumerate(zip(names, _CHANNEL_LINES, strict=False)):
                how: dict[str, Any] = {"linestyle": linestyle, "linewidth": 1.2, "label": name}
                if marks:
                    how = {"linestyle": "none", "marker": "o", "markersize": 3.2, "label": f"_samples of {name}"}
                axes.plot(times - row.origin, values[:, channel], color=color, clip_on=False, **how)
    lines = [line for line in rows[0].lines if line.get_label() in names]
    legend = rows[0].legend(
        lines,
        [shown(name, 18, legend=True) for name in names],
        loc="lower right",
        bbox_to_anchor=(1.005, 1.01),
        ncols=_MOST_CHANNELS,
        frameon=False,
        handlelength=3.4,
        borderaxespad=0.2,
    )
    for text in legend.get_texts():
        text.set_parse_math(False)
