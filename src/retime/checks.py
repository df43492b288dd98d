"""What people pass, made into what is meant, or refused in words that say what to pass."""

from __future__ import annotations

import operator
from numbers import Integral, Real
from os import PathLike
from pathlib import Path

from retime.brief import kind_of
from retime.errors import OptionError


def real(value: object, what: str, *, option: str | None = None) -> float:
    """Take a number of whatever type; raise OptionError for anything else, a text too.

    Examples
    --------
    >>> import numpy as np
    >>> real(np.float32(0.5), "the weight")
    0.5
    """
    if isinstance(value, Real) and not isinstance(value, bool):
        return float(value)
    raise OptionError(f"{what} must be a number, found {kind_of(value)}", option=option)


def whole(value: object, what: str, *, option: str | None = None) -> int:
    """Take a whole number of whatever type (8, np.int64(8), 8.0); raise OptionError for anything else.

    Examples
    --------
    >>> import numpy as np
    >>> whole(np.int64(8), "max_skip"), whole(8.0, "max_skip")
    (8, 8)
    """
    if not isinstance(value, bool):
        if isinstance(value, Real) and not isinstance(value, Integral) and float(value).is_integer():
            return int(float(value))
        try:
            # NumPy's own truth values refuse to be an index.
            return operator.index(value)  # type: ignore[arg-type]
        except TypeError:
            pass
    raise OptionError(f"{what} must be a whole number, found {kind_of(value)}", option=option)


def path_of(value: object, call: str) -> Path:
    """Take a path; raise OptionError, which says how the call is written, for anything else."""
    if isinstance(value, str | PathLike):
        return Path(value)
    raise OptionError(f"expected {call} with a path, found {kind_of(value)}")
