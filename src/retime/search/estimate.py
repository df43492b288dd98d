"""What a search will take, before it is begun: memory and time, and what to change where that is too much.

Estimates are of the kernels' main arrays and loops, measured on one machine: right to a factor of three or so. They
tell a search of seconds from one of days, which is what they are for.
"""

from __future__ import annotations

import itertools
import math
import os
from collections.abc import Sequence

import numpy as np

from retime.errors import OptionError

# Gigabytes and seconds that one search may take, where nobody says.
MOST_MEMORY, MOST_SECONDS = 4.0, 120.0
_MEMORY, _SECONDS = "RETIME_MOST_MEMORY", "RETIME_MOST_SECONDS"
# Seconds on one thread: for a triple against a row of the reference, against one beyond the first some thousand (which
# bounds mostly rule out), for a triple in one position of the layered recurrence, and for one in a whole search.
_PER_ROW, _PER_FAR_ROW, _LONG, _PER_LAYER = 4e-10, 1e-10, 4096, 4e-10
# Where there are keytimes inside, sweeps look for a price of each span, and some of a loop's first steps lead nowhere.
_PER_SEARCH, _PER_SEARCH_OF_SPANS = 1.5e-8, 1e-7
# Sets of first steps that a loop's search looks at: of 600 random loops half took 5, nine of ten 11, the worst 33.
_SETS_OF_A_LOOP = 12
# For a triple in one position of a search in step with a reference, and for each number of its pose vectors.
_PER_COMPARED, _PER_NUMBER = 3e-9, 3e-10
# For each number of two frames that are compared, and the seconds over which an example is compared with itself.
_PER_LOOKED_UP, _LAGS_SECONDS = 5e-9, 2.1
# For a frame between the ends of a step of which the content is priced.
_PER_LEFT_OUT = 2e-8


def most(name: str, usual: float) -> float:
    """Read a limit that the environment may set."""
    try:
        value = float(os.environ.get(name, ""))
    except ValueError:
        return usual
    return value if value > 0 else usual


def check_fits(
    *, what: str, remedy: str, n_bytes: float = 0.0, seconds: float = 0.0, option: str | None = None
) -> None:
    """Refuse work that its estimate says won't fit.

    Parameters
    ----------
    what : str
        The work, in words, with its sizes.
    remedy : str
        What to change.
    n_bytes, seconds : float
        Estimates.
    option : str, optional
        The argument at fault.

    Raises
    ------
    OptionError
        Names the estimate, the remedy, and the variable that moves the limit.
    """
    gigabytes = n_bytes / 2**30
    if gigabytes > (limit := most(_MEMORY, MOST_MEMORY)):
        raise OptionError(
            f"{what} would take about {gigabytes:.2g} GB of memory; the limit is {limit:g} GB ({_MEMORY}=GB sets "
            f"another). {remedy}",
            option=option,
        )
    if seconds > (limit := most(_SECONDS, MOST_SECONDS)):
        raise OptionError(
            f"{what} would take about {_time_words(seconds)}; the limit is {_time_words(limit)} ({_SECONDS}=SECONDS "
            f"sets another). {remedy}",
            option=option,
        )


def score_seconds(n_input: int, n_pairs: int, n_rows: int, n_threads: int) -> float:
    """Estimate how long triples take to be scored, (n_input, n_pairs) of them against rows of the reference."""
    near, far = min(n_rows, _LONG), max(0, n_rows - _LONG)
    return n_input * n_pairs * (near * _PER_ROW + far * _PER_FAR_ROW) / max(1, n_threads)


def layered_seconds(n_input: int, n_pairs: int, n_output: int) -> float:
    """Estimate how long the layered recurrence takes."""
    return _PER_LAYER * n_output * n_input * n_pairs


def loop_seconds(n_input: int, n_pairs: int, n_steps: int, n_spans: int) -> float:
    """Estimate how long a loop's search takes: for each set of first steps some sweeps over all scores."""
    return min(n_steps, _SETS_OF_A_LOOP) * (_PER_SEARCH if n_spans == 1 else _PER_SEARCH_OF_SPANS) * n_input * n_pairs


def align_seconds(
    anchors: Sequence[tuple[int, int]], longest: int, n_pairs: int, n_numbers: int, n_threads: int
) -> float:
    """Estimate how long a search in step with a reference takes, between anchors (position, input frame)."""
    n_frames = 0
    for (p0, j0), (p1, j1) in itertools.pairwise(anchors):
        # Frames from which the next anchor can be reached, among those that the last one leads to.
        after, before = np.arange(p1 - p0), p1 - p0 - np.arange(p1 - p0)
        low, high = np.maximum(j0 + after, j1 - before * longest), np.minimum(j0 + after * longest, j1 - before)
        n_frames += int(np.maximum(high - low + 1, 0).sum())
    return n_frames * n_pairs * (_PER_COMPARED + _PER_NUMBER * n_numbers / max(1, n_threads))


def example_seconds(n_points: int, n_example: int, n_numbers: int, rate: float) -> float:
    """Estimate how long points take to be looked up in an example, and the example in its surroundings."""
    n_lags = 2 * _LAGS_SECONDS * rate
    return _PER_LOOKED_UP * n_numbers * n_example * (n_points + n_lags)


def content_seconds(n_input: int, step_lengths: list[int]) -> float:
    """Estimate how long the price on what steps leave out takes."""
    return _PER_LEFT_OUT * n_input * math.fsum(step_lengths)


def _time_words(seconds: float) -> str:
    for size, name in ((86400.0, "days"), (3600.0, "hours"), (60.0, "minutes")):
        if seconds >= 2 * size:
            return f"{seconds / size:.2g} {name}"
    return f"{seconds:.2g} seconds" if seconds < 100 else f"{seconds:.0f} seconds"
