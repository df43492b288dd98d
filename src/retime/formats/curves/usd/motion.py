"""The motion that an answer of the process that runs pxr holds."""

from __future__ import annotations

from fractions import Fraction

import numpy as np

from retime.arrays import FloatArray
from retime.formats.curves.usd.exchange import Message
from retime.motion.motion import Motion, Up
from retime.motion.skeleton import EndSite, Skeleton


def motion_of(answer: Message) -> Motion:
    """Make a motion of an answer; raise InvalidMotionError, KeyError, TypeError or IndexError where it is none."""
    facts = answer.facts
    offsets = doubles(answer, "offsets", 2)
    translations, rotations = doubles(answer, "translations", 3), doubles(answer, "rotations", 3)
    names, parents, ends = [str(name) for name in facts["names"]], list(facts["parents"]), set(facts["ends"])
    kept = [joint for joint in range(len(names)) if joint not in ends]
    place = {joint: number for number, joint in enumerate(kept)}
    sites = [EndSite(place[parents[joint]], tuple(offsets[joint].tolist())) for joint in sorted(ends)]
    skeleton = Skeleton(
        tuple(names[joint] for joint in kept),
        tuple(-1 if parents[joint] < 0 else place[parents[joint]] for joint in kept),
        offsets[kept],
        tuple(sites),
    )
    unit = facts["unit"]
    up: Up = "z" if facts["up"] == "z" else "y"
    return Motion(
        skeleton,
        rotations[:, kept],
        translations[:, kept],
        Fraction(*facts["rate"]),
        name=str(facts["name"]),
        metres_per_unit=unit if isinstance(unit, float) and 0 < unit < 1e9 else None,
        up=up,
    )


def doubles(answer: Message, name: str, n_dimensions: int) -> FloatArray:
    """Return an array of an answer; raise KeyError where it is none of finite numbers."""
    array = answer.arrays[name]
    if array.ndim != n_dimensions or not np.isfinite(array).all():
        raise KeyError(name)
    return np.array(array, dtype=np.float64)
