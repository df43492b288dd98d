"""The panel that says why a warp is as it is: how each output frame scored, and what was binding."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from retime.evaluate.plot import style
from retime.search.explain import Explanation

if TYPE_CHECKING:
    from matplotlib.axes import Axes

# From top to bottom, where they occur.
LANES = ("key", "tangent", "lock", "hold", "flight", "even", "fastest", "slowest")
# Inches.
_HEAT_HEIGHT, _LANE_HEIGHT = 0.24, 0.17
_HEAT_COLORS = ("#f8fafc", "#fca5a5", "#991b1b")
_HEAT = _HEAT_HEIGHT / _LANE_HEIGHT


def lanes_of(explanation: Explanation) -> list[str]:
    """Return what was binding anywhere."""
    found = {word for words in explanation.binding for word in words.split("+")}
    return [word for word in LANES if word in found]


def reasons_height(explanation: Explanation) -> float:
    """Return the height that the panel needs, inches."""
    return _HEAT_HEIGHT + _LANE_HEIGHT * len(lanes_of(explanation))


def binding_intervals(explanation: Explanation, word: str) -> list[tuple[float, float]]:
    """Output times of the stretches of frames that something bound: from half a frame before to half a frame after.

    Examples
    --------
    >>> times = np.arange(4.0)
    >>> blank = np.zeros((4, 1))
    >>> bound = ("key", "hold", "lock+hold", "key")
    >>> held = Explanation(times, times, times, times, times, times, blank.astype(int), blank, bound, ("x",))
    >>> binding_intervals(held, "hold")
    [(0.5, 2.5)]
    """
    times = explanation.output_times
    half = _half_a_frame(explanation)
    bound = np.array([word in words.split("+") for words in explanation.binding])
    edges = np.flatnonzero(np.diff(np.concatenate([[0], bound, [0]]).astype(np.int8))).reshape(-1, 2)
    return [
        (float(max(times[first] - half, times[0])), float(min(times[stop - 1] + half, times[-1])))
        for first, stop in edges
    ]


def most_score(explanation: Explanation) -> float:
    """Return the worst score; 0 where no frame has one."""
    scores = explanation.scores[np.isfinite(explanation.scores)]
    return float(scores.max()) if len(scores) else 0.0


def draw_reasons(axes: Axes, explanation: Explanation, limits: tuple[float, float]) -> None:
    """Scores as a strip of heat over output time, and below it a lane for each thing that was binding."""
    from matplotlib.colors import LinearSegmentedColormap

    times, half = explanation.output_times, _half_a_frame(explanation)
    lanes = lanes_of(explanation)
    # One unit of height is a lane; the strip lies above zero, the lanes below.
    colors = LinearSegmentedColormap.from_list("score", _HEAT_COLORS).with_extremes(bad="white")
    axes.imshow(
        explanation.scores[None],
        extent=(float(times[0]) - half, float(times[-1]) + half, 0.0, _HEAT),
        aspect="auto",
        cmap=colors,
        vmin=0.0,
        # A scale needs a length, whatever the scores are.
        vmax=most_score(explanation) or 1.0,
        interpolation="nearest",
        label="_scores",
    )
    for number, word in enumerate(lanes):
        middle = -number - 0.5
        if word == "key":
            keys = [time for time, words in zip(times, explanation.binding, strict=True) if "key" in words.split("+")]
            # The analysis grid may end half a frame beyond the output.
            axes.plot(
                np.clip(keys, *limits), [middle] * len(keys), label="key", **{**style.KEY_MARKS, "markersize": 3.5}
            )
            continue
        bars = [(start, stop - start) for start, stop in binding_intervals(explanation, word)]
        axes.broken_barh(bars, (middle - 0.3, 0.6), facecolors=style.TRUNK, linewidth=0, label=word)
    axes.set(xlim=limits, ylim=(-len(lanes), _HEAT), xlabel="output time (s)")
    axes.set_yticks([_HEAT / 2, *(-number - 0.5 for number in range(len(lanes)))], ["score", *lanes])
    axes.tick_params(axis="y", length=0, pad=7, labelsize=8.5)
    axes.spines["left"].set_visible(False)


def _half_a_frame(explanation: Explanation) -> float:
    times = explanation.output_times
    return float(times[-1] - times[0]) / (len(times) - 1) / 2
