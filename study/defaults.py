"""The main choices of the analysis: what the study runs with, and what the paper has, read literally."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from retime.search.options import default_of, names

DEFAULTS: dict[str, Any] = {"features": "heading", "score": "joint", "time_scale": default_of("time_scale")}
"""What `retime.guided_warp` chooses by itself, said aloud."""

AS_PRINTED: dict[str, Any] = {"features": "torso", "score": "joint", "time_scale": 1 / 30, "paper": True}
"""The paper read literally: the torso's own space, velocity and acceleration counted in frames, its sum and no more."""

WITHOUT_HURRY: dict[str, Any] = {"evenness": 0.0, "keep_flights": 0.0}
"""No price on tempo: what `retime.guided_warp` chose by itself before there was natural hurry."""


def parted(options: Mapping[str, Any]) -> tuple[dict[str, Any], dict[str, Any]]:
    """Part the options of `retime.guided_warp` into those of the analysis (`Session`) and those of `Session.solve`.

    Examples
    --------
    >>> parted({"length": "65%", "score": "joint"})
    ({'score': 'joint'}, {'length': '65%'})
    """
    known = names("analysis")
    analysis = {name: value for name, value in options.items() if name in known}
    return analysis, {name: value for name, value in options.items() if name not in known}
