"""V3: silence removal on a clip that is idle for more than half of its time."""

from __future__ import annotations

from dataclasses import replace

from study.clips.library import Library
from study.evaluations.evaluation import Evaluation, PaperRow
from study.evaluations.preserve import preserve

KEY = "V3"
PAPER = PaperRow(378, 180, 378, 8, 1.9, 1.4, 0.14)


def evaluate(clips: Library, repeats: int) -> Evaluation:
    """Shorten the clip to less than its half."""
    return preserve(
        KEY,
        "Silence removal, mostly silence",
        "Waiting, kneeling down, waiting, getting up: more than half of this clip is standing or kneeling still.",
        "test_mocapbank: the first 378 frames, at 30 Hz as captured.",
        replace(clips["mocapbank"].frames(0, 378), name="mocapbank"),
        "47.6%",
        max_skip=8,
        silence=True,
        repeats=repeats,
    )
