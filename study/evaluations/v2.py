"""V2: silence removal on a short dance."""

from __future__ import annotations

from study.clips.library import Library
from study.evaluations.evaluation import Evaluation, PaperRow
from study.evaluations.preserve import preserve

KEY = "V2"
PAPER = PaperRow(316, 180, 316, 10, 1.7, 1.4, 0.11)


def evaluate(clips: Library, repeats: int) -> Evaluation:
    """Shorten the dance to the paper's share of it."""
    return preserve(
        KEY,
        "Silence removal, a shorter clip",
        "As V1; there is less silence to remove.",
        "CMU 05_08: dance, rond de jambe, jeté, turn; the whole clip.",
        clips["05_08"],
        "57%",
        max_skip=10,
        silence=True,
        repeats=repeats,
    )
