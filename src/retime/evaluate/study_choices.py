"""The main choices of the analysis: what the study runs with, and what the paper has, read literally."""

from __future__ import annotations

from typing import Any

from retime.warp.session import DEFAULT_TIME_SCALE

SETTINGS: dict[str, Any] = {"features": "heading", "score": "joint", "time_scale": DEFAULT_TIME_SCALE}
"""What `retime.guided_warp` chooses by itself, said aloud."""

AS_PRINTED: dict[str, Any] = {"features": "torso", "score": "joint", "time_scale": 1 / 30}
"""The paper read literally: the torso's own space, velocity and acceleration counted in frames."""
