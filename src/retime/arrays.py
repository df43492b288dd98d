"""The kinds of arrays that retime is written with, and arrays as people hand them over."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from retime.errors import InvalidMotionError, RetimeError

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]
BoolArray = NDArray[np.bool_]

_LOST = {
    "c": "complex numbers: pass the real parts (x.real), or both parts as columns of their own",
    "M": "dates: pass seconds, as numbers",
    "m": "time spans: pass seconds, as numbers (x / numpy.timedelta64(1, 's'))",
    "U": "text",
    "S": "bytes",
    "V": "records: pass one array of numbers (numpy.lib.recfunctions.structured_to_unstructured)",
}


def doubles(values: NDArray[Any]) -> FloatArray:
    """Make doubles of numbers as a file holds them; what is no number stays none, and is the caller's to refuse.

    NumPy warns of a signalling NaN, which a damaged file may hold, as it makes it a double or reckons with it.

    Examples
    --------
    >>> doubles(np.array([1.5, np.nan], dtype=np.float32)).tolist()
    [1.5, nan]
    """
    with np.errstate(invalid="ignore"):
        # Doubles too: a product with 1 is the same number, and a NaN that is quiet.
        return np.multiply(values, 1.0, dtype=np.float64) if values.dtype.kind == "f" else values.astype(np.float64)


def as_real(values: ArrayLike, what: str, *, error: type[RetimeError] = InvalidMotionError) -> FloatArray:
    """Take real numbers; refuse what NumPy would turn into them silently, losing an imaginary part, a mask or a unit.

    Parameters
    ----------
    values : array-like
        What was handed over.
    what : str
        What it is, for messages.
    error : type
        What to raise.

    Raises
    ------
    InvalidMotionError
        (Or `error`.) Not an array of real numbers; says what to pass.

    Examples
    --------
    >>> as_real([1, 2.5], "the speeds").tolist()
    [1.0, 2.5]
    """
    if np.ma.is_masked(values):
        raise error(f"{what} must be real numbers; some are masked: fill them first (numpy.ma.filled)")
    try:
        array = np.asarray(values)
        if array.dtype == object and any(value is None for value in array.ravel()):
            # NumPy would make a NaN of it.
            raise TypeError("None is not a number")
        if (lost := _LOST.get(array.dtype.kind)) is None:
            return array if array.dtype == np.float64 else doubles(array)
    except (TypeError, ValueError) as problem:
        raise error(f"{what} must be an array of real numbers: {problem}") from None
    raise error(f"{what} must be real numbers; found {lost}")
