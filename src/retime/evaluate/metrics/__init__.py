"""Figures of merit: numbers that say how a retimed motion turned out.

Each looks at a warp, at a motion, or at both; none knows how the warp was found. Times are seconds, lengths metres,
by the motion's own scale (`retime.motion.kinematics.metres_per_unit`). docs/study says in words what each one means
and what it is good for.
"""

from __future__ import annotations

from collections.abc import Sequence

Spans = Sequence[tuple[float, float]]
"""Stretches of a clip: start and end, seconds."""

ANALYSIS_RATE = 30.0
"""Hz: the paper's."""
