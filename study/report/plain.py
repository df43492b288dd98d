"""Results as plain data, for JSON."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Mapping
from typing import Any

import numpy as np

from retime.motion.any_motion import AnyMotion
from retime.search.result import GuidedWarp
from retime.warp.curve import Warp


def plain(value: Any) -> Any:
    """Turn results into what JSON can hold: no motions, no warps, no infinities.

    Motions and signals become their names and sizes, warps their knots' counts and ends; numbers that are not finite
    become null.
    """
    if isinstance(value, AnyMotion):
        return {"name": value.name, "n_frames": value.n_frames, "rate": str(value.rate)}
    if isinstance(value, Warp):
        return {"method": value.method, "seconds": value.output_span, "n_knots": len(value.output_times)}
    if isinstance(value, GuidedWarp):
        stated = (
            "n_input",
            "n_output",
            "n_reference",
            "max_skip",
            "upsample",
            "total",
            "score",
            "time_scale",
            "low_pass",
        )
        return {name: plain(getattr(value, name)) for name in stated} | {"warp": plain(value.warp)}
    if dataclasses.is_dataclass(value) and not isinstance(value, type):
        return {field.name: plain(getattr(value, field.name)) for field in dataclasses.fields(value)}
    if isinstance(value, Mapping):
        return {str(key): plain(one) for key, one in value.items()}
    if isinstance(value, str | bool | int) or value is None:
        return value
    if isinstance(value, float | np.floating):
        # Four digits are as many as any of these means.
        return float(f"{value:.4g}") if math.isfinite(value) else None
    if isinstance(value, np.integer):
        return int(value)
    if callable(value):
        return getattr(value, "__name__", "function").strip("_")
    return [plain(one) for one in value]
