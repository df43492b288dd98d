"""V5: lengthen a jump."""

from __future__ import annotations

from dataclasses import replace

from study.clips.library import Library
from study.evaluations.evaluation import Evaluation, PaperRow
from study.evaluations.preserve import preserve

KEY = "V5"
PAPER = PaperRow(401, 150, 101, 4, 0.3, 0.7, 0.06)


def evaluate(clips: Library, repeats: int) -> Evaluation:
    """Make the clip half as long again, with four frames to choose from in each period."""
    motion = clips["02_04"]
    return preserve(
        KEY,
        "Walking and jumping, lengthened",
        "The reverse: 150 % of the length, by upsampling four times.",
        "CMU 02_04: jump, balance; the first 401 frames, which are the paper's 101 at 30 Hz.",
        replace(motion.frames(0, 401), name="02_04"),
        "150%",
        max_skip=4,
        upsample=4,
        repeats=repeats,
    )
