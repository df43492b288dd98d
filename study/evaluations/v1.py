"""V1: silence removal on a dance with leaps."""

from __future__ import annotations

from study.clips.library import Library
from study.evaluations.evaluation import Evaluation, PaperRow
from study.evaluations.preserve import preserve

KEY = "V1"
PAPER = PaperRow(493, 280, 493, 8, 1.3, 2.7, 0.17)


def evaluate(clips: Library, repeats: int) -> Evaluation:
    """Shorten the dance to the paper's share of it."""
    return preserve(
        KEY,
        "Silence removal",
        "Idle stretches are hurried through, leaps keep their time. The paper's 493 frames became 280.",
        "CMU 05_18: dance, attitude/arabesque, jeté en tourant, bending back; the whole clip.",
        clips["05_18"],
        "56.8%",
        max_skip=8,
        silence=True,
        repeats=repeats,
    )
