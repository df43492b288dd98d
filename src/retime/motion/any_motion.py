"""What can be retimed: a motion, which has a skeleton, or a signal, which has none."""

from __future__ import annotations

from retime.motion.motion import Motion
from retime.motion.signal import Signal

AnyMotion = Motion | Signal
"""A motion or a signal."""
