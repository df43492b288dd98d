"""What of an input is shown at the output's frames, and whether a warp and an input cover the same time."""

from __future__ import annotations

import math
from numbers import Integral, Real
from typing import Any, Literal, get_args

import numpy as np
from numpy.typing import ArrayLike, NDArray

from retime.arrays import FloatArray, IntArray
from retime.brief import kind_of
from retime.errors import OptionError

ResampleMethod = Literal["linear", "nearest"]


def refuse_no_clock(rate: float, n_frames: int) -> None:
    """Raise OptionError where a rate is none, or a number of frames."""
    if not isinstance(rate, Real) or isinstance(rate, bool) or not 0 < float(rate) < math.inf:
        raise OptionError(f"the rate must be a number of frames a second above 0, found {kind_of(rate)}")
    if not isinstance(n_frames, Integral) or isinstance(n_frames, bool) or n_frames < 1:
        raise OptionError(f"the number of input frames must be 1 or more, found {kind_of(n_frames)}")


def rows_of(array: ArrayLike, method: ResampleMethod) -> NDArray[Any]:
    """Take an array with a row for each frame; raise OptionError where a method can't show it."""
    if method not in get_args(ResampleMethod):
        raise OptionError(f"the method must be one of {', '.join(get_args(ResampleMethod))}; found {method!r}")
    values = np.asarray(array)
    if values.ndim == 0:
        raise OptionError(f"expected an array with a row for each frame, found {kind_of(array)}")
    if method == "linear" and values.dtype.kind not in "iufc":
        raise OptionError(
            f"values of type {values.dtype} can't be interpolated: method='nearest' takes them as they are"
        )
    return values


def shown_rows(
    values: NDArray[Any], places: tuple[IntArray, IntArray, FloatArray], method: ResampleMethod
) -> NDArray[Any]:
    """Show rows at places between them, as `retime.frames.frame_positions` gives these."""
    before, after, share = places
    if method == "nearest":
        return np.asarray(values[nearest(places)])
    share = share.reshape(-1, *[1] * (values.ndim - 1))
    start = values[before].astype(np.result_type(values.dtype, np.float64))
    return np.asarray(start + share * (values[after] - start))


def nearest(places: tuple[IntArray, IntArray, FloatArray]) -> IntArray:
    """Return the frame nearest to each place."""
    before, after, share = places
    return np.asarray(np.where(share < 0.5, before, after))


def range_problem(low: float, high: float, end_time: float, rate: float, name: str) -> str:
    """Say how the input times of a warp differ from those of a clip's frames, half a frame aside.

    Parameters
    ----------
    low, high : float
        The least and the greatest input time of the warp, seconds.
    end_time : float
        Of the clip's last frame, seconds.
    rate : float
        Of the clip, Hz.
    name : str
        What to call it.

    Returns
    -------
    str
        "" where they don't.
    """
    near = 0.5 / rate
    if low < -near or high > end_time + near:
        return (
            f"the warp reaches input times {low:g} to {high:g} s, but {name} runs from 0 to {end_time:g} s; "
            "it is held at its ends"
        )
    if low > near or high < end_time - near:
        return (
            f"the warp uses input times {low:g} to {high:g} s; {name} runs from 0 to {end_time:g} s, and the "
            "rest of it is left out"
        )
    return ""
