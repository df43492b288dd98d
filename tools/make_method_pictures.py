"""Draw the pictures of docs/method.md, each from the search itself, and check what they show.

Usage: python tools/make_method_pictures.py [FOLDER] (default: docs/images/method)
"""

from __future__ import annotations

import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np

import retime
from retime.motion.flights import flights
from retime.search.path import shortest_path

PLACE = Path(__file__).resolve().parents[1] / "docs" / "images" / "method"
INK, GREEN, ORANGE, GREY = "#1f2933", "#0f766e", "#b45309", "#94a3b8"
STYLE = {"svg.hashsalt": "retime", "font.size": 9, "axes.spines.top": False, "axes.spines.right": False}
# Of a figure that moves like itself.
EVENNESS, KEEP_FLIGHTS = 4.0, 24.0


def path() -> Any:
    """Draw the frame path around a jump, and the warp that it becomes: each dot is a frame that is shown."""
    clip = retime.sample()
    result = retime.guided_warp(clip, length="65%")
    first, last = (frame / 60 for frame in flights(clip)[0])
    frames = result.path.frames / (result.rate * result.upsample)
    shown = np.arange(len(frames)) / result.rate
    inside = (frames > first - 1.6) & (frames < last + 1.6)
    figure, axes = plt.subplots(figsize=(6.2, 3.6), layout="constrained")
    axes.axhspan(first, last, color="#fdebcb", lw=0)
    axes.text(shown[inside][0], last - 0.06, "flight", color=ORANGE, va="top")
    axes.step(shown[inside], frames[inside], where="mid", color=GREY, lw=0.8)
    axes.plot(shown[inside], frames[inside], ".", color=INK, ms=5, label="frame path: input frames that are shown")
    times = np.linspace(shown[inside][0], shown[inside][-1], 400)
    axes.plot(times, result.warp(times), color=GREEN, lw=1.6, label="warp: what it becomes")
    axes.set(xlabel="output time, s", ylabel="input time, s")
    axes.legend(frameon=False, loc="lower right")
    flying = (frames >= first) & (frames <= last)
    # In the air each step is unit speed.
    assert np.all(np.diff(result.path.frames[flying]) == result.upsample)
    return figure


def toy() -> tuple[np.ndarray, np.ndarray]:
    """Make the scores of a small search, and the least total of each number of steps that is possible."""
    rng = np.random.default_rng(7)
    n, most = 26, 4
    scores = np.full((n, most, most), np.inf)
    for middle in range(1, n - 1):
        for before in range(1, min(most, middle) + 1):
            for after in range(1, min(most, n - 1 - middle) + 1):
                scores[middle, before - 1, after - 1] = (
                    rng.gamma(1.2) * (0.4 + 0.5 * abs(before - after)) + 0.25 * before
                )
    steps = np.arange(-(-(n - 1) // most), n)
    totals = np.array([shortest_path(scores, n_output=int(count) + 1).total for count in steps])
    return steps, totals


def bound() -> Any:
    """Draw the best total of each number of steps, and the line that one price gives: nothing lies below it."""
    steps, totals = toy()
    wanted = int(steps[len(steps) // 3])
    prices = np.linspace(-2, 2, 4001)
    # One sweep without counting steps gives the least of total + price * steps; less the price of those wanted.
    bounds = (totals[:, None] + prices * steps[:, None]).min(axis=0) - prices * wanted
    best = float(prices[np.argmax(bounds)])
    intercept = (totals + best * steps).min()
    assert np.all(totals >= intercept - best * steps - 1e-9)
    assert bounds.max() <= totals[steps == wanted][0] + 1e-9
    figure, (left, right) = plt.subplots(1, 2, figsize=(7.4, 3.2), layout="constrained")
    left.plot(steps, totals, "o", color=INK, ms=4)
    left.plot(steps, intercept - best * steps, color=GREEN, lw=1.6)
    left.axvline(wanted, color=GREY, lw=0.8, ls=":")
    left.set(xlabel="steps of the path", ylabel="least total", title="the best path of each length")
    right.plot(prices, bounds, color=GREEN, lw=1.6)
    right.axhline(totals[steps == wanted][0], color=INK, lw=0.8, ls="--")
    right.plot([best], [bounds.max()], "o", color=ORANGE, ms=5)
    right.set(
        xlabel="price of a step, λ",
        ylabel="bound of the total",
        title=f"the bound for {wanted} steps",
        ylim=(bounds.max() - 12, bounds.max() + 3),
    )
    right.text(-1.95, totals[steps == wanted][0] + 0.25, "least total", color=INK)
    return figure


def hurry() -> Any:
    """Draw the price of tempo for an input frame: idle frames give way for nothing, those in flight only at last."""
    speeds = np.linspace(0.35, 4, 400)
    log = np.log(speeds)
    # For an output frame, and so for an input frame by 1 / speed.
    shared = np.maximum(1, speeds) / speeds
    kinds = {
        "in flight": (shared * (EVENNESS * log**2 + KEEP_FLIGHTS * np.abs(log)), ORANGE, "-"),
        "moving": (shared * EVENNESS * log**2, GREEN, "-"),
        "idle": (0 * log, GREY, "--"),
    }
    figure, axes = plt.subplots(figsize=(6.2, 3.2), layout="constrained")
    for name, (price, ink, line) in kinds.items():
        axes.plot(speeds, price, color=ink, ls=line, lw=1.8)
        axes.text(2.2, np.interp(2.2, speeds, price) + 0.9, name, color=ink, ha="right")
    axes.set(xlabel="playback speed", ylabel="price for an input frame, in r", ylim=(-0.5, 26))
    assert kinds["in flight"][0][np.argmin(np.abs(speeds - 1.1))] > kinds["moving"][0][np.argmin(np.abs(speeds - 1.7))]
    return figure


PICTURES: dict[str, Callable[[], Any]] = {"path": path, "bound": bound, "hurry": hurry}


def main() -> None:
    """Draw all of them."""
    folder = Path(sys.argv[1]) if len(sys.argv) > 1 else PLACE
    folder.mkdir(parents=True, exist_ok=True)
    with plt.rc_context(STYLE):
        for name, draw in PICTURES.items():
            figure = draw()
            figure.savefig(folder / f"{name}.svg", metadata={"Date": None})
            plt.close(figure)


if __name__ == "__main__":
    main()
