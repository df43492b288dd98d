"""A picture of a warp from footage: where each is in the input, and what it shows."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from retime.errors import MissingExtraError
from retime.media.extras import needed
from retime.warp.curve import Warp

_WIDTH, _HEIGHT = 1500, 150
_FLIGHT, _INK, _LINE = "#fde68a", "#1f2937", "#0f766e"


def draw(path: Path, footage: Path, warp: Warp, flights: Sequence[tuple[float, float]], title: str) -> None:
    """Draw the frames of a clip and of the retimed one, at even times of each, over the speed of the warp.

    Parameters
    ----------
    path : Path
        The picture.
    footage : Path
        The clip.
    warp : Warp
        What gives it its timing.
    flights : sequence of (float, float)
        Known to be so, seconds of the input; they are shaded.
    title : str
        Above it.
    """
    try:
        from matplotlib import pyplot as plt
    except ImportError as error:
        raise MissingExtraError("the pictures of the study", package="matplotlib", extra="plot") from error
    frames, rate = _frames(footage)
    shares = np.linspace(0, 1, max(2, _WIDTH // frames[0].shape[1]))
    input_times = warp.input_times[0] + shares * (warp.input_times[-1] - warp.input_times[0])
    output_times = warp.output_times[0] + shares * warp.output_span
    figure, axes = plt.subplots(3, 1, figsize=(11, 4.6), height_ratios=(1, 1, 1.6), layout="constrained")
    for axis, times, label in zip(axes, (input_times, warp(output_times)), ("input", "output"), strict=False):
        shown = np.clip(np.round(times * rate).astype(int), 0, len(frames) - 1)
        axis.imshow(np.concatenate([frames[number] for number in shown.tolist()], axis=1))
        axis.set(xticks=[], yticks=[], ylabel=label)
    speeds = axes[2]
    back = warp.inverse()
    for number, span in enumerate(flights):
        low, high = (float(back(edge)) for edge in span)
        speeds.axvspan(low, high, color=_FLIGHT, lw=0, label="flight" if number == 0 else None)
    speeds.stairs(warp.slopes, warp.output_times, color=_LINE, lw=1.6, baseline=None, label="speed")
    speeds.axhline(1, color=_INK, lw=0.6)
    speeds.set(xlim=(warp.output_times[0], warp.output_times[-1]), xlabel="output, s", ylabel="speed", yscale="log")
    speeds.set_yticks([0.25, 0.5, 1, 2, 4, 8], ["1/4", "1/2", "1", "2", "4", "8"])
    speeds.minorticks_off()
    speeds.legend(loc="upper right", frameon=False, ncols=2)
    figure.suptitle(title)
    figure.savefig(path, dpi=110)
    plt.close(figure)


def _frames(footage: Path) -> tuple[list[Any], float]:
    """Return the frames of a clip, small, (height, width, 3) bytes each, and their rate."""
    av, cv2 = needed("av"), needed("cv2")
    with av.open(str(footage)) as container:
        frames = [
            cv2.resize(frame.to_ndarray(format="rgb24"), (round(_HEIGHT * frame.width / frame.height), _HEIGHT))
            for frame in container.decode(video=0)
        ]
        return frames, float(container.streams.video[0].average_rate)
