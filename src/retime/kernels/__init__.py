"""Scoring and path search: the compiled kernels, and NumPy's where none could be built. Both give the same bits."""

from __future__ import annotations

import importlib
import importlib.util
import os
from functools import cache
from typing import Protocol, cast

import numpy as np
from numpy.typing import NDArray

from retime.errors import OptionError

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]

BACKENDS = ("compiled", "numpy")


class Backend(Protocol):
    """What a backend computes; arrays are contiguous, checked by the caller."""

    def joint_scores(
        self,
        inputs: FloatArray,
        reference: FloatArray,
        max_skip: int,
        velocity: float,
        acceleration: float,
        n_neighbors: int,
    ) -> FloatArray:
        """Score triples of poses (n_input, d) against features (n_reference, 3 d): (n_input, max_skip, max_skip)."""

    def conditional_scores(
        self,
        inputs: FloatArray,
        reference: FloatArray,
        max_skip: int,
        velocity: float,
        acceleration: float,
        n_neighbors: int,
    ) -> FloatArray:
        """Score triples by the motion of the reference frames nearest in pose: (n_input, max_skip, max_skip)."""

    def layered_path(
        self, scores: FloatArray, positions: IntArray, frames: IntArray, memory_limit: int
    ) -> tuple[IntArray, float] | None:
        """Find the best path through anchors (position, frame): frames and total, or None where there is none."""


def compiled_available() -> bool:
    """Whether the compiled kernels were built."""
    return importlib.util.find_spec("retime.kernels._kernels") is not None


@cache
def backend(name: str | None = None) -> Backend:
    """Return the kernels to use.

    Parameters
    ----------
    name : {"compiled", "numpy"}, optional
        Left out: the environment variable RETIME_BACKEND, else the compiled ones where they were built.

    Raises
    ------
    OptionError
        No such backend, or the compiled one was not built.
    """
    name = name or os.environ.get("RETIME_BACKEND") or ("compiled" if compiled_available() else "numpy")
    if name not in BACKENDS:
        raise OptionError(f"the backend must be one of {', '.join(BACKENDS)}; found {name!r}")
    if name == "compiled" and not compiled_available():
        raise OptionError("the compiled kernels were not built: install retime where there is a C++ compiler")
    module = "retime.kernels.compiled" if name == "compiled" else "retime.kernels.numpy_backend"
    return cast(Backend, importlib.import_module(module))
