"""The settings that are compared: one a row of the table."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from retime.motion.joint_names import body_parts
from retime.motion.motion import Motion
from retime.search.poses.spaces import PoseOptions
from study.defaults import AS_PRINTED

PRINTED = "the paper, read literally"
"""Group of the row that stands for what the paper has."""

CHOSEN = "the default"
"""Group of the row that stands for what the package does by itself."""


@dataclass(frozen=True)
class Setting:
    """One row of the table.

    Attributes
    ----------
    group : str
        The choice that is looked at.
    label : str
        What was chosen.
    options : mapping of str to object
        Of `retime.guided_warp`. ``features`` may be a function from a motion to its options.
    """

    group: str
    label: str
    options: Mapping[str, Any] = field(default_factory=dict)


def _without_hands(motion: Motion) -> PoseOptions:
    """Leave out palms, fingers and thumbs: small, and in captures mostly noise."""
    names = motion.skeleton.names
    parts = body_parts(names)
    small = {
        name
        for name, part in zip(names, parts, strict=True)
        if (part is not None and part.base in ("palm", "fingers")) or "thumb" in name.lower()
    }
    return PoseOptions("heading", weights=dict.fromkeys(small, 0.0))


def _few(motion: Motion) -> PoseOptions:
    """Hips, feet, hands, head."""
    names = motion.skeleton.names
    wanted = ("hips", "foot", "hand", "head")
    chosen = [
        name for name, part in zip(names, body_parts(names), strict=True) if part is not None and part.base in wanted
    ]
    return PoseOptions("heading", joints=(names[0], *(name for name in chosen if name != names[0])))


def _root_weighs(factor: float) -> Callable[[Motion], PoseOptions]:
    return lambda motion: PoseOptions("heading", weights={motion.skeleton.names[0]: factor})


def settings(base: Mapping[str, Any]) -> list[Setting]:
    """List the rows: the main choices with each other, then one at a time around `base`."""
    rows = [
        Setting(PRINTED, describe(AS_PRINTED), AS_PRINTED),
        Setting(CHOSEN, describe(base), base),
    ]
    for features in ("torso", "heading"):
        for score in ("joint", "conditional"):
            for time_scale in (1 / 30, 0.1, 0.15, 0.2, 0.3):
                options = {"features": features, "score": score, "time_scale": time_scale}
                rows.append(Setting("pose space, score, time scale", describe(options), options))
    single: list[tuple[str, str, Sequence[Any]]] = [
        ("time scale τ (s)", "time_scale", (0.05, 0.25, 0.5)),
        ("low-pass (Hz)", "low_pass", (0.0, 2.0, 3.0, 6.0, 8.0)),
        ("neighbours k", "n_neighbors", (1, 2, 5, 10)),
        ("weight on changes of speed", "smoothness", (0.02, 0.05, 0.1, 0.3)),
        ("averaging window (frames)", "smoothing", (0, 3, 9)),
        ("longest step", "max_skip", (3, 4, 12)),
    ]
    for group, option, values in single:
        rows += [Setting(group, f"{value:g}", {**base, option: value}) for value in values]
    rows += [
        Setting(
            "frames a period, where slowed", f"{n}, longest step {2 * n}", {**base, "upsample": n, "max_skip": 2 * n}
        )
        for n in (2, 4, 6, 12)
    ]
    rows += [
        Setting(
            "evenness, keeping flights",
            f"{evenness:g}, {keep:g}" if evenness or keep else "0, 0 (no natural hurry)",
            {**base, "evenness": evenness, "keep_flights": keep},
        )
        for evenness, keep in (
            (0.0, 0.0),
            (0.1, 0.0),
            (1.0, 6.0),
            (2.0, 12.0),
            (4.0, 0.0),
            (4.0, 12.0),
            (4.0, 48.0),
            (8.0, 48.0),
        )
    ]
    rows += [
        Setting("joints", "hips, feet, hands, head", {**base, "features": _few}),
        Setting("joints", "no fingers", {**base, "features": _without_hands}),
        Setting("joints", "root counts 4 times", {**base, "features": _root_weighs(4.0)}),
        Setting("joints", "root counts not", {**base, "features": _root_weighs(0.0)}),
    ]
    return rows


def describe(options: Mapping[str, Any]) -> str:
    """Write the main choices in one line."""
    time_scale = options["time_scale"]
    shown = "1/30" if abs(time_scale - 1 / 30) < 1e-9 else f"{time_scale:g}"
    return f"{options['features']}, {options['score']}, τ = {shown} s"
