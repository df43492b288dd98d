"""Pictures of warps: playback speed, time map, and a strip of poses (the paper's Figures 1 and 5)."""

from __future__ import annotations

import io
import warnings
from collections.abc import Mapping, Sequence
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal, cast, get_args

from retime.brief import kind_of
from retime.checks import path_of, whole
from retime.errors import FormatError, MissingExtraError, OptionError
from retime.evaluate.metrics.flights import flight_spans
from retime.evaluate.naming import name_warps
from retime.evaluate.plot.panels import draw_keys, draw_map, draw_speed, draw_strip
from retime.evaluate.plot.reasons import draw_reasons, most_score, reasons_height
from retime.evaluate.plot.strip import DEFAULT_N_POSES, Strip, plan_strip
from retime.evaluate.plot.style import GREY, PLOT_SUFFIXES, STYLE, pens_for, shown
from retime.files import write_bytes
from retime.motion.any_motion import AnyMotion
from retime.motion.signal import Signal
from retime.search.explain import Explanation
from retime.warp.curve import Warp, WarpLike
from retime.warp.keytime import Keytime, KeytimeLike, keytimes_of
from retime.warp.spline import linear_warp, spline_warp

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

# Inches.
_WIDTH = 12.8
_LEFT, _RIGHT = 1.3, 0.35
_TOP = 1.3
_CURVES_HEIGHT = 3.0
_MAP_WIDTH = 3.5
_BETWEEN = 0.45
_ROW_HEIGHT, _ROW_GAP = 1.15, 0.1
_BELOW = 0.62
# Between the speeds and the reasons below them, for the heading of the latter.
_REASONS_GAP = 0.36
# Above the speeds, for the keytimes.
_KEYS_HEIGHT, _KEYS_GAP = 0.17, 0.08
_PNG_DPI = 200

Panel = Literal["speed", "map"]
"""A panel that can be drawn alone."""


def plot_warps(
    warps: WarpLike | Mapping[str, WarpLike] | Sequence[WarpLike],
    *,
    motion: AnyMotion | None = None,
    path: str | PathLike[str] | None = None,
    keytimes: Sequence[KeytimeLike] | None = None,
    title: str = "",
    n_poses: int = DEFAULT_N_POSES,
    explanation: Explanation | None = None,
    ax: Axes | None = None,
    panel: Panel = "speed",
    overwrite: bool = False,
) -> Figure:
    """Draw warps: playback speed, time map, and a strip of the motion at even output times.

    *Speed* is drawn over output time on a log axis from 1/10 to 10, as steps: the slope of each piece of the warp. Pass
    `GuidedWarp.staircase` beside `GuidedWarp.warp` to see the path's own speeds with the smoothed ones. Holds and
    backward pieces have no place on such an axis: a hold is a bar at the foot of the panel, a backward piece is dotted
    with arrowheads at its absolute speed, and both say so. Speeds beyond the axis run along its edge, with the farthest
    one in numbers.

    Above the speeds a lane of diamonds says when keytimes stand: they have a time, and no speed.

    The *reasons* stand below the speeds where an `explanation` is given: the score of each output frame, dark where it
    is unlike the reference, and in a lane of its own each thing that was binding (keytimes, tangents, locks, holds, the
    fastest and the slowest speed allowed).

    The *time map* shows input time over output time, with the keytimes as diamonds.

    The *strip* needs `motion`. It has a row for the input and one for each warp, with the same seconds a centimetre and
    the same seconds between poses in each, so that what takes longer is longer and has more poses. Each figure is seen
    from its right side whichever way it turns, its ground position removed and its height kept; right limbs are dark,
    left limbs pale. Where a whole row would have no room for the poses of a flight, all rows show an excerpt around the
    take-off of the longest one. Of a `Signal` the rows show the first three channels, each scaled to its own range.

    Flights (`retime.motion.flights.flights`) are shaded in every panel: among the speeds along each curve, since
    each warp shows them at its own times.

    Parameters
    ----------
    warps : Warp or GuidedWarp, sequence of them, or mapping of str to them
        What to compare, at least one. The names of a mapping are the labels; else each warp's name, or method.
    motion : Motion or Signal, optional
        The input of the warps.
    path : path-like, optional
        Where to write the picture; the ending says what: ``.svg``, ``.pdf`` or ``.png``. The same warps give the same
        bytes.
    keytimes : sequence of Keytime, or of (input time, output time), optional
        What to mark. Left out: the keytimes that the warps carry.
    title : str
        Stands above; left out, the motion's name.
    n_poses : int
        About how many poses the longest row of the strip gets; samples, for a signal.
    explanation : Explanation, optional
        Of one of the warps (`GuidedWarp.explain`).
    ax : matplotlib.axes.Axes, optional
        Draw one panel, on these axes of your own figure. Of the `motion` only the flights are then shown.
    panel : {"speed", "map"}
        Which one that is.
    overwrite : bool
        Replace a file that is there.

    Returns
    -------
    matplotlib.figure.Figure
        The picture, with no window and no part in pyplot. Its axes are labelled ``speed``,
        ``keys`` (where there are keytimes), ``reasons``, ``map``, and ``strip`` with the name of the row. Where `ax` is
        given, its figure.

    Raises
    ------
    MissingExtraError
        matplotlib is not installed.
    OptionError
        No warp, fewer than 2 poses, no such panel, or more than one panel is asked for on one of axes.
    FormatError
        The path ends in none of .svg, .pdf and .png.
    OutputExistsError
        The file is there, and `overwrite` is not set.

    Examples
    --------
    >>> figure = plot_warps([Warp([0.0, 2.0], [0.0, 3.0], method="linear")])
    >>> [axes.get_label() for axes in figure.axes]
    ['speed', 'map']

    In a figure of your own:

    >>> from matplotlib.figure import Figure
    >>> mine = Figure()
    >>> plot_warps({"linear": Warp([0.0, 2.0], [0.0, 3.0])}, ax=mine.add_subplot()) is mine
    True
    """
    named = name_warps(warps, "plot_warps({name: warp})")
    if whole(n_poses, "n_poses") < 2:
        raise OptionError(f"a strip needs 2 poses or more, found n_poses={n_poses}")
    if not (motion is None or isinstance(motion, AnyMotion)):
        raise OptionError(f"expected plot_warps(warps, motion=...) with a motion or a signal, found {kind_of(motion)}")
    if not (explanation is None or isinstance(explanation, Explanation)):
        raise OptionError(f"an explanation is what result.explain() returns, found {kind_of(explanation)}")
    kind = None if path is None else _kind(path_of(path, "plot_warps(warps, path=...)"))
    if panel not in get_args(Panel):
        raise OptionError(f"the panel must be one of {', '.join(get_args(Panel))}; found {panel!r}")
    if ax is not None and (title or explanation is not None):
        raise OptionError(
            "on axes of your own there is one panel, with no title and no explanation: leave out these, or ax"
        )
    marked = None if keytimes is None else keytimes_of(keytimes)
    try:
        import matplotlib
        from matplotlib.figure import Figure
    except ImportError as error:
        raise MissingExtraError("drawing a plot", package="matplotlib", extra="plot") from error

    with matplotlib.rc_context(STYLE), warnings.catch_warnings():
        # A name may have letters that the plot's font lacks: boxes in a PNG; in an SVG the reader's own font has them.
        warnings.filterwarnings("ignore", message="Glyph .* missing from font")
        if ax is None:
            figure = _draw(Figure, named, motion, marked, title, n_poses, explanation)
        else:
            figure = _draw_panel(ax, panel, named, motion, marked)
        if path is not None and kind is not None:
            write_bytes(path, _rendered(figure, kind), overwrite=overwrite)
    return figure


def plot_with_baselines(
    warp: Warp,
    motion: AnyMotion,
    *,
    method: str,
    explanation: Explanation | None,
    path: str | PathLike[str],
    overwrite: bool = False,
) -> None:
    """Draw a warp beside what an animator has today: straight lines through its keytimes, and a spline where they bend.

    Parameters
    ----------
    warp : Warp
        With its keytimes.
    motion : Motion or Signal
        The input.
    method : str
        How the warp was found, for its label.
    explanation, path, overwrite
        As of `plot_warps`, whose errors are raised.
    """
    warps = {"linear": linear_warp(warp.keytimes)}
    if len(warp.keytimes) > 2:
        warps["spline"] = spline_warp(warp.keytimes, rate=float(motion.rate))
    warps[method] = warp
    plot_warps(warps, motion=motion, path=path, title=motion.name, explanation=explanation, overwrite=overwrite)


def _kind(path: str | PathLike[str]) -> str:
    suffix = Path(path).suffix.lower()
    if suffix not in PLOT_SUFFIXES:
        raise FormatError(
            f"a plot is written as {', '.join(PLOT_SUFFIXES)}, not as {suffix or 'a file with no ending'!r}", path=path
        )
    return suffix[1:]


def _rendered(figure: Figure, kind: str) -> bytes:
    buffer = io.BytesIO()
    if kind == "svg":
        # No date, and text stays text: the same warps give the same bytes, and a page can search the labels.
        figure.savefig(buffer, format="svg", metadata={"Date": None})
        return buffer.getvalue()
    if kind == "pdf":
        figure.savefig(buffer, format="pdf", metadata={"CreationDate": None, "Creator": None, "Producer": None})
        return buffer.getvalue()
    # Flat colours and the greys between them: a palette holds them in a third of the bytes.
    from PIL import Image

    figure.savefig(buffer, format="png", dpi=_PNG_DPI, metadata={"Software": None})
    palette = Image.open(buffer).convert("RGB").quantize(256, Image.Quantize.MEDIANCUT, dither=Image.Dither.NONE)
    buffer = io.BytesIO()
    palette.save(buffer, format="png", optimize=True, dpi=(_PNG_DPI, _PNG_DPI))
    return buffer.getvalue()


def _draw_panel(
    ax: Axes, panel: Panel, warps: dict[str, Warp], motion: AnyMotion | None, keytimes: Sequence[Keytime] | None
) -> Figure:
    """Draw one panel on axes that somebody has; return their figure."""
    if keytimes is None:
        keytimes = _keytimes_of(warps)
    if panel == "speed":
        draw_speed(ax, warps, pens_for(warps), flight_spans(motion), keytimes, above=0.0)
    else:
        draw_map(ax, warps, pens_for(warps), flight_spans(motion), keytimes)
    figure = ax.get_figure()
    while figure is not None and not hasattr(figure, "savefig"):
        # A subfigure: the picture is the figure around it.
        figure = figure.figure
    assert figure is not None
    return cast("Figure", figure)


def _keytimes_of(warps: Mapping[str, Warp]) -> list[Keytime]:
    return sorted({key for warp in warps.values() for key in warp.keytimes})


def _draw(
    new_figure: type[Figure],
    warps: dict[str, Warp],
    motion: AnyMotion | None,
    keytimes: Sequence[Keytime] | None,
    title: str,
    n_poses: int,
    explanation: Explanation | None,
) -> Figure:
    pens = pens_for(warps)
    found = flight_spans(motion)
    if keytimes is None:
        keytimes = _keytimes_of(warps)
    strip = None if motion is None else plan_strip(motion, warps, found, n_poses)
    n_rows = 0 if strip is None else len(strip.rows)
    strip_height = _BETWEEN + n_rows * (_ROW_HEIGHT + _ROW_GAP) + _BELOW if n_rows else 0.0
    reasons_tall = 0.0 if explanation is None else reasons_height(explanation)
    curves_height = _CURVES_HEIGHT + (0.0 if explanation is None else _REASONS_GAP + reasons_tall)
    height = _TOP + curves_height + _BELOW + strip_height
    figure = new_figure(figsize=(_WIDTH, height))

    def place(left: float, top: float, width: float, tall: float, label: str) -> Axes:
        """Add axes, in inches from the top left corner."""
        return figure.add_axes((left / _WIDTH, 1 - (top + tall) / height, width / _WIDTH, tall / height), label=label)

    def write(text: str, left: float, top: float, **how: Any) -> None:
        figure.text(left / _WIDTH, 1 - top / height, text, va="baseline", parse_math=False, **how)

    heading = {"fontsize": 10.5, "fontweight": "bold"}
    title = title or ("" if motion is None else motion.name) or "Time warps"
    write(shown(title, 80), 0.3, 0.45, fontsize=15, fontweight="bold")
    write(_summary(warps, motion, bool(found)), 0.3, 0.72, color=GREY)

    speed_width = _WIDTH - _LEFT - _RIGHT - _MAP_WIDTH - 0.85
    write("Playback speed", _LEFT, _TOP - 0.12, **heading)
    keys_height = _KEYS_HEIGHT + _KEYS_GAP if keytimes else 0.0
    speed = place(_LEFT, _TOP + keys_height, speed_width, _CURVES_HEIGHT - keys_height, "speed")
    draw_speed(speed, warps, pens, found, keytimes, above=keys_height / (_CURVES_HEIGHT - keys_height))
    if keytimes:
        draw_keys(place(_LEFT, _TOP, speed_width, _KEYS_HEIGHT, "keys"), keytimes, speed.get_xlim())
    if explanation is not None:
        # One axis of time serves both.
        speed.set_xlabel("")
        speed.tick_params(axis="x", labelbottom=False)
        top = _TOP + _CURVES_HEIGHT + _REASONS_GAP
        write("Why", _LEFT, top - 0.1, **heading)
        write(
            f"dark: unlike the reference, score up to {most_score(explanation):.3g}; below, what was binding",
            _LEFT + 0.45,
            top - 0.1,
            color=GREY,
        )
        draw_reasons(place(_LEFT, top, speed_width, reasons_tall, "reasons"), explanation, speed.get_xlim())
    map_left = _WIDTH - _RIGHT - _MAP_WIDTH
    write("Time map", map_left, _TOP - 0.12, **heading)
    draw_map(place(map_left, _TOP, _MAP_WIDTH, curves_height, "map"), warps, pens, found, keytimes)
    if strip is not None and motion is not None:
        top, width = _TOP + curves_height + _BELOW + _BETWEEN, _WIDTH - _LEFT - _RIGHT
        what, how = _strip_heading(strip, motion, bool(found))
        write(what, _LEFT, top - 0.14, **heading)
        write(how, _LEFT + 0.085 * len(what) + 0.1, top - 0.14, color=GREY)
        axes = [
            place(_LEFT, top + i * (_ROW_HEIGHT + _ROW_GAP), width, _ROW_HEIGHT, f"strip {row.label}")
            for i, row in enumerate(strip.rows)
        ]
        draw_strip(axes, strip, motion, size=(width, _ROW_HEIGHT))
    return figure


def _strip_heading(strip: Strip, motion: AnyMotion, flights: bool) -> tuple[str, str]:
    every = f"every {_brief(strip.step)} s of output"
    if isinstance(motion, Signal):
        return f"Values {every}", "each channel scaled to its own range"
    where = ""
    if strip.aligned and flights:
        where = f"around the longest flight, aligned at take-off (input time {strip.anchor:.2f} s); "
    elif strip.aligned:
        where = f"around input time {strip.anchor:.2f} s; "
    return f"Poses {every}", where + "right limbs dark, left limbs pale"


def _brief(seconds: float) -> str:
    return f"{seconds:.2f}" if seconds >= 0.05 else f"{seconds:.2g}"


def _summary(warps: Mapping[str, Warp], motion: AnyMotion | None, flights: bool) -> str:
    parts = [] if motion is None else [f"input {_brief(motion.duration)} s"]
    for label, warp in warps.items():
        # A warp has no frames: how long its output is shown, the last frame included, is known with a clip only.
        if motion is None:
            parts.append(f"{shown(label, 24)} ends at {_brief(warp.output_end)} s")
        else:
            parts.append(f"{shown(label, 24)} {_brief(warp.count_frames(motion.rate) / float(motion.rate))} s")
    text = ", ".join(parts[:6]) + (", …" if len(parts) > 6 else "")
    return text + (".  Shaded: in flight, where the body falls freely and touches nothing." if flights else ".")
