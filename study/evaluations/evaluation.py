"""What an evaluation is: an input, and the ways to play it, each with its figures."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from retime.brief import brief_repr
from retime.motion.motion import Motion
from retime.search.result import GuidedWarp
from retime.warp.curve import Warp
from study.evaluations.timing import TableRow


@dataclass(frozen=True)
class PaperRow:
    """A row of the paper's Table 1; seconds on a 2.4 GHz Pentium 4.

    Attributes
    ----------
    n_input, n_output, n_reference, max_skip : int
        Its n, m, r, s.
    objective, search : float
        Seconds for evaluating the objective and for the full optimization.
    heuristic : float, optional
        Seconds for the optimization with the heuristic.
    """

    n_input: int
    n_output: int
    n_reference: int
    max_skip: int
    objective: float
    search: float
    heuristic: float | None


@dataclass(frozen=True, eq=False)
class Version:
    """One way to play a clip.

    Attributes
    ----------
    label : str
        What stands above it.
    note : str
        What it is.
    motion : Motion
        What is seen.
    warp : Warp, optional
        How the input became that; None for the input and for a reference.
    figures : mapping of str to object
        How it turned out: `study.figures.registry.FIGURES`, by name; None where one does not apply.
    """

    label: str
    note: str
    motion: Motion
    warp: Warp | None
    figures: Mapping[str, Any]

    __repr__ = brief_repr


@dataclass(frozen=True, eq=False)
class Evaluation:
    """One of the paper's evaluations, run.

    Attributes
    ----------
    key : str
        "V1" to "V8"; "V6b", "V6c" and "V7b" are further ones.
    title, about, clip : str
        What it shows, in words, and on which capture.
    motion : Motion
        The input.
    versions : tuple of Version
        The input's first; the one called "guided" is the method's.
    guided : GuidedWarp
        The method's result.
    row : TableRow
        Sizes and times.
    flights : tuple of (float, float)
        Of the input, seconds.
    options : mapping of str to object
        What `retime.guided_warp` was asked for, beyond `study.defaults.DEFAULTS`.
    """

    key: str
    title: str
    about: str
    clip: str
    motion: Motion
    versions: tuple[Version, ...]
    guided: GuidedWarp
    row: TableRow
    flights: tuple[tuple[float, float], ...]
    options: Mapping[str, Any]

    __repr__ = brief_repr

    def version(self, label: str) -> Version:
        """Return a version by its label; raise KeyError where there is none."""
        for version in self.versions:
            if version.label == label:
                return version
        raise KeyError(label)
