"""Reads the study's clips, each once."""

from __future__ import annotations

import warnings
from dataclasses import replace
from fractions import Fraction
from pathlib import Path

from retime.data import sample
from retime.errors import FormatWarning
from retime.formats.registry import read
from retime.motion.motion import Motion
from study.clips.sources import SOURCES, Source


class Library:
    """Clips of the data folder, each read once.

    Parameters
    ----------
    folder : Path
        Laid out as `SOURCES` says.
    """

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self._motions: dict[str, Motion] = {}

    def __getitem__(self, name: str) -> Motion:
        """Return a clip; "sample" is the shipped one. Raise the reader's errors."""
        if name not in self._motions:
            self._motions[name] = read_sample() if name == "sample" else read_source(self.folder, SOURCES[name], name)
        return self._motions[name]

    def stretch(self, name: str, start: float, end: float) -> Motion:
        """Cut a stretch out of a clip by input times, seconds, to the nearest frames; both included."""
        motion = self[name]
        first, last = round(start * float(motion.rate)), round(end * float(motion.rate))
        return replace(motion.frames(first, min(last + 1, motion.n_frames)), first_frame=0)


def read_source(folder: Path, source: Source, name: str) -> Motion:
    """Read a clip as the study uses it: its extra rows dropped, its rate and unit told.

    Raises
    ------
    FormatError
        The file is broken.
    FileNotFoundError
        It is not in the folder.
    """
    with warnings.catch_warnings():
        # What the readers warn of here (AMC says no rate, one header counts a row too few) is known.
        warnings.simplefilter("ignore", FormatWarning)
        motion = read(folder / source.path, rate=Fraction(source.rate))
    assert isinstance(motion, Motion)
    stop = motion.n_frames if source.frames is None else source.drop_first + source.frames
    motion = motion.frames(source.drop_first, stop)
    unit = source.metres_per_unit if motion.metres_per_unit is None else motion.metres_per_unit
    return replace(motion, name=name, first_frame=0, metres_per_unit=unit)


def read_sample() -> Motion:
    """Read the sample clip that is shipped."""
    return replace(sample(), name="sample")
