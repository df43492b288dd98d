"""Random warps, and times to try them at."""

from __future__ import annotations

import numpy as np
from hypothesis import strategies as st

from retime.warp.curve import Warp
from retime.warp.keytime import Keytime


def drawn_warp(rng: np.random.Generator, n_knots: int, *, forward: bool, keys: int = 0) -> Warp:
    """Knots at uneven times, from slow to fast; a few of them keytimes."""
    output_times = np.cumsum(rng.uniform(0.01, 1.0, n_knots)) - rng.uniform(0, 2)
    steps = 10.0 ** rng.uniform(-2, 1, n_knots) * np.where(rng.random(n_knots) < 0.8 if not forward else True, 1, -1)
    if not forward:
        steps[rng.random(n_knots) < 0.2] = 0.0
    input_times = np.cumsum(steps)
    chosen = np.sort(rng.choice(n_knots, min(keys, n_knots), replace=False))
    keytimes = tuple(Keytime(input_time=float(input_times[k]), output_time=float(output_times[k])) for k in chosen)
    return Warp(output_times, input_times, keytimes)


@st.composite
def warps(draw: st.DrawFn, forward: bool = True, keys: int = 0) -> Warp:
    rng = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    return drawn_warp(rng, draw(st.integers(2, 12)), forward=forward, keys=draw(st.integers(0, keys)))


def some_times(warp: Warp, seed: int = 0) -> np.ndarray:
    """Knots, times between them, and times outside."""
    rng = np.random.default_rng(seed)
    between = rng.uniform(warp.output_start - 1, warp.output_end + 1, 9)
    return np.concatenate([warp.output_times, between])
