"""Footage with a known answer: a ball that flies, rests and flies again before a wall, drawn as a camera sees it."""

from __future__ import annotations

from fractions import Fraction
from pathlib import Path

import numpy as np

from retime.arrays import FloatArray
from retime.media.extras import needed

FLIGHT, REST, N_FLIGHTS, RATE = 0.6, 0.9, 3, 30
SIZE = (160, 120)


def spans() -> list[tuple[float, float]]:
    """Return when the ball flies, seconds."""
    return [(start, start + FLIGHT) for start in REST + np.arange(N_FLIGHTS) * (FLIGHT + REST)]


def place(times: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return where the ball is, pixels from the left and from the top."""
    along, height = np.full_like(times, 20.0), np.zeros_like(times)
    for start, _ in spans():
        aloft = np.clip(times - start, 0, FLIGHT)
        along += 60 * aloft
        height += 9.81 / 2 * aloft * (FLIGHT - aloft)
    # It rolls a little while it rests.
    return along + 2.0 * times, 100 - 120 * height


def write_ball(path: Path) -> Path:
    """Draw and write the footage: a textured wall, grain, and the ball."""
    av = needed("av")
    chance = np.random.default_rng(4)
    y, x = np.mgrid[0 : SIZE[1], 0 : SIZE[0]].astype(float)
    wall = 90 + 25 * np.sin(x / 6) * np.cos(y / 5)
    n = round((N_FLIGHTS * (FLIGHT + REST) + REST) * RATE) + 1
    with av.open(str(path), "w") as output:
        stream = output.add_stream("libx264", rate=Fraction(RATE), options={"crf": "14"})
        # As many threads everywhere: how many there are shows in what x264 writes.
        stream.codec_context.thread_count = 1
        stream.width, stream.height, stream.pix_fmt = *SIZE, "yuv420p"
        for number, (px, py) in enumerate(zip(*place(np.arange(n) / RATE), strict=True)):
            distance = np.hypot(x - px, y - py)
            ball = 180 + 50 * np.sin((x - px) / 2) * np.sin((y - py) / 2)
            share = np.clip(12.5 - distance, 0, 1)
            grey = wall * (1 - share) + ball * share + chance.normal(0, 1.5, wall.shape)
            frame = av.VideoFrame.from_ndarray(np.clip(grey, 0, 255).astype(np.uint8), format="gray")
            frame = frame.reformat(format="yuv420p")
            frame.pts = number
            output.mux(stream.encode(frame))
        output.mux(stream.encode(None))
    return path
