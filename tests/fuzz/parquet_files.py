"""Mutants of Parquet files: each is read as a valid signal, or refused as retime refuses.

A process of its own tries each of them first, so that this takes half a second a file.
"""

from __future__ import annotations

import functools
import random
import tempfile
from fractions import Fraction
from pathlib import Path

import numpy as np

from retime.formats import read, write
from retime.motion.signal import Signal
from tests.fuzz.text_files import check, write_and_read
from tests.fuzz.trials import Trial, mutated_bytes


@functools.cache
def whole_file(several: bool) -> bytes:
    """Return a table: of a column, or of several."""
    names = ("x", "y", "label") if several else ("x",)
    values = np.linspace(-1.0, 1.0, 8 * len(names)).reshape(8, -1)
    with tempfile.TemporaryDirectory(prefix="retime-fuzz-") as name:
        path = Path(name) / "clip.parquet"
        write(Signal(names, values, Fraction(30)), path)
        return path.read_bytes()


def parquet_file(draw: random.Random) -> str:
    """Make a mutant, and read it."""
    data = mutated_bytes(draw, whole_file(draw.random() < 0.7))
    with tempfile.TemporaryDirectory(prefix="retime-fuzz-") as name:
        path = Path(name) / "clip.parquet"
        path.write_bytes(data)
        clip = read(path, rate=None if draw.random() < 0.5 else 30)
        check(clip)
        if draw.random() < 0.3:
            write_and_read(clip, path.with_name("again.parquet"))
    return ".parquet is read"


KINDS: dict[str, Trial] = {"parquet": parquet_file}
