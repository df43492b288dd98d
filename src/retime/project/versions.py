"""Documents as older programs wrote them: project files of versions 1 and 2, and journals of version 1."""

from __future__ import annotations

from dataclasses import dataclass, field
from decimal import Decimal
from typing import Any, Literal

from retime.project.dataclass_json import from_value
from retime.project.document import ClipFile, Document, KeptWarp, Key, LockedTime, Options, ReferenceFile


@dataclass(frozen=True)
class _OldOptions:
    """What version 2 called options, with every field that it could have."""

    method: Literal["guided", "linear", "spline"] = "guided"
    rate: str | None = None
    max_skip: int | None = None
    upsample: int | None = None
    slowest: float | None = None
    fastest: float | None = None
    smoothness: float = 0.0
    smoothing: int | None = None
    n_neighbors: int | None = None
    time_scale: float | None = None
    low_pass: float | None = None
    features: Literal["torso", "heading", "signal"] | None = None
    score: Literal["joint", "conditional"] = "joint"
    loop: bool = False
    average: bool = True


@dataclass(frozen=True)
class _OldDocument:
    """A document of version 2. Version 1 knew less of references; what it leaves out has its default."""

    clips: tuple[ClipFile, ...]
    references: tuple[ReferenceFile, ...] = ()
    keys: tuple[Key, ...] = ()
    locks: tuple[LockedTime, ...] = ()
    length: str | None = None
    min_length: str | None = None
    max_length: str | None = None
    free_weight: Literal["neutral", "sum"] = "neutral"
    influence: float = 1.0
    options: _OldOptions = field(default_factory=_OldOptions)
    kept: tuple[KeptWarp, ...] = ()


# Of version 2 every option that may be left out was null; these were written whether they were given or not.
_ALWAYS_WRITTEN = {"free_weight": "neutral", "influence": 1.0, "smoothness": 0.0, "score": "joint", "loop": False}


def read_old_document(value: Any, where: str) -> Document:
    """Make a document of what version 1 or 2 wrote, from parsed JSON.

    Raises
    ------
    FormatError
        No such document; names the field, what was expected and what was found.
    """
    old = from_value(_OldDocument, value, where)
    apart = ("method", "average", "slowest", "fastest")
    found: dict[str, Any] = {name: value for name, value in vars(old.options).items() if name not in apart}
    for name in ("length", "min_length", "max_length", "free_weight", "influence"):
        found[name] = getattr(old, name)
    found["speed"] = _speeds_text(old.options.slowest, old.options.fastest)
    given = {name: value for name, value in found.items() if value != _ALWAYS_WRITTEN.get(name)}
    return Document(
        clips=old.clips,
        references=old.references,
        keys=old.keys,
        locks=old.locks,
        method=old.options.method,
        average=old.options.average,
        # This version's reader checks it: an option that it no longer knows is named in its message.
        options=from_value(Options, given, f"{where}.options"),
        kept=old.kept,
    )


def _speeds_text(slowest: float | None, fastest: float | None) -> str | None:
    """Write limits as people type them, digit for digit."""
    if slowest is None and fastest is None:
        return None
    low, high = (None if speed is None else f"{Decimal(repr(speed)).normalize():f}" for speed in (slowest, fastest))
    return f"{low or ''}..{high or ''}"
