"""V4: walk, jump, walk, shortened."""

from __future__ import annotations

from study.clips.library import Library
from study.evaluations.evaluation import Evaluation, PaperRow
from study.evaluations.preserve import preserve

KEY = "V4"
PAPER = PaperRow(486, 320, 486, 8, 1.0, 2.6, 0.20)


def evaluate(clips: Library, repeats: int) -> Evaluation:
    """Shorten the clip; and once more, with its first take-off on a beat."""
    return preserve(
        KEY,
        "Walking and jumping, shortened",
        "There is no silence: the walk must give way, and the jumps should not.",
        "CMU 86_01, frames 1 to 1980: walk, jump, walk.",
        clips["86_01"],
        "65%",
        max_skip=8,
        beat=4.0,
        repeats=repeats,
    )
