"""Make the values that the page's evaluation of a warp is tested with: ``python tools/make_warp_golden.py``."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np

from retime.warp.curve import Warp
from retime.warp.spline import span_slopes, spline_warp

GOLDEN = Path(__file__).resolve().parents[1] / "web" / "test" / "warp_golden.json"

WARPS = {
    "two knots": ([0.0, 2.0], [0.0, 3.0]),
    "begins late": ([0.5, 1.25, 2.0], [1.0, 1.5, 4.0]),
    "hold, then backward": ([0.0, 1.0, 1.5, 2.5, 3.0], [0.0, 1.0, 1.0, 0.25, 2.0]),
    "eighths": (np.linspace(0, 3, 25).tolist(), (np.linspace(0, 3, 25) ** 2 / 3).tolist()),
}

# Keytimes: input time, output time, and perhaps a speed. On frames and off them, a hold, backward, a corner.
SPLINES = {
    "two keytimes": (30, [(0.0, 0.5), (3.0, 2.0)]),
    "tangents off the frames": (24, [(0.0, 0.0), (1.0, 0.71, 2.0), (1.25, 1.0), (4.0, 2.0, 0.5)]),
    "hold, then backward": (60, [(0.0, 0.0), (1.0, 0.5), (1.0, 0.9), (0.5, 1.3, 1.0), (2.0, 1.75)]),
}


def golden() -> str:
    """Return the values as JSON."""
    cases = []
    for name, (output_times, input_times) in WARPS.items():
        warp = Warp(np.array(output_times), np.array(input_times))
        # Before, at and between knots, and after the end.
        inner = np.linspace(warp.output_start - 0.25, warp.output_end + 0.25, 23)
        times = np.unique(np.concatenate([inner, warp.output_times]))
        cases.append(
            {
                "name": name,
                "output_times": warp.output_times.tolist(),
                "input_times": warp.input_times.tolist(),
                "at": times.tolist(),
                "shows": warp(times).tolist(),
                "speeds": warp.speed(times).tolist(),
            }
        )
    splines = []
    for name, (rate, keys) in SPLINES.items():
        spline, (begins, ends) = spline_warp(keys, rate=rate), span_slopes(keys)
        splines.append(
            {
                "name": name,
                "rate": rate,
                "key_output_times": [key.output_time for key in spline.keytimes],
                "key_input_times": [key.input_time for key in spline.keytimes],
                "spline_begins": begins.tolist(),
                "spline_ends": ends.tolist(),
                "output_times": spline.output_times.tolist(),
                "input_times": spline.input_times.tolist(),
            }
        )
    return json.dumps({"cases": cases, "splines": splines}, indent=1) + "\n"


if __name__ == "__main__":
    GOLDEN.write_text(golden(), encoding="utf-8")
