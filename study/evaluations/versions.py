"""Makes the versions of one input, and measures each."""

from __future__ import annotations

from retime.evaluate.metrics.flights import path_warp
from retime.motion.motion import Motion
from retime.search.result import GuidedWarp
from retime.warp.apply import apply_warp
from retime.warp.curve import Warp
from study.baselines.steady import untouched
from study.evaluations.evaluation import Version
from study.figures.registry import measured
from study.figures.shown import Shown, Subject, Warped


class VersionMaker:
    """Makes versions of one input.

    Parameters
    ----------
    subject : Subject
        The input, and what its versions are measured against.
    """

    def __init__(self, subject: Subject) -> None:
        self.subject = subject

    def input(self, note: str = "as captured") -> Version:
        """Show the input as it is."""
        motion = self.subject.motion
        return Version("input", note, motion, None, measured(Warped(self.subject, motion, untouched(motion))))

    def version(self, label: str, note: str, warp: Warp, *, average: bool = True, path: Warp | None = None) -> Version:
        """Show the input by a warp; `path` is what a search decided, where there was one."""
        shown = apply_warp(self.subject.motion, warp, average=average)
        return Version(label, note, shown, warp, measured(Warped(self.subject, shown, warp, path, warp.keytimes)))

    def guided(self, found: GuidedWarp, note: str, label: str = "guided") -> Version:
        """Show the input by a guided warp."""
        return self.version(label, note, found.warp, path=path_warp(found))

    def other(self, label: str, note: str, motion: Motion) -> Version:
        """Show another motion beside it."""
        return Version(label, note, motion, None, measured(Shown(self.subject, motion)))
