"""USD scenes evaluated by USD itself, at any time; and how far two of them are apart. Nothing of retime is used."""

from __future__ import annotations

from pathlib import Path

import numpy as np


def opened(path: Path):
    from pxr import Usd

    stage = Usd.Stage.Open(str(path))
    assert stage is not None
    return stage


def sampled(stage) -> dict[str, list[float]]:
    """The attributes that change, and their times."""
    found = {}
    for prim in stage.Traverse():
        for attribute in prim.GetAttributes():
            times = attribute.GetTimeSamples()
            if attribute.HasSpline():
                knots = attribute.GetSpline().GetKnots()
                times = [knots.GetTimeSpan().GetMin(), knots.GetTimeSpan().GetMax()]
            if len(times) > 1:
                found[attribute.GetPath().pathString] = list(times)
    return found


def as_numbers(value):
    """Numbers of a value, and whether they are quaternions (real part last); None where it has none."""
    if hasattr(value, "GetImaginary"):
        return np.array([*value.GetImaginary(), value.GetReal()]), True
    if isinstance(value, str) or value is None:
        return None, False
    numbers = np.array(value, dtype=np.float64)
    return numbers, "Quat" in type(value).__name__


def degrees_apart(a: np.ndarray, b: np.ndarray) -> float:
    a, b = a.reshape(-1, 4), b.reshape(-1, 4)
    a, b = (x / np.linalg.norm(x, axis=1)[:, None] for x in (a, b))
    # By the chord, which is exact for small angles.
    chord = np.minimum(np.linalg.norm(a - b, axis=1), np.linalg.norm(a + b, axis=1))
    return float(np.degrees(4 * np.arcsin(np.minimum(chord / 2, 1))).max())


def worst(before, after, pairs: list[tuple[float, float]]) -> tuple[float, float, list[str]]:
    """Compare two stages at pairs of (output code, input code).

    Returns the largest relative error of numbers, the largest angle of rotations (degrees), and what differs in kind.
    """
    relative, degrees, other = 0.0, 0.0, []
    for path, times in sampled(before).items():
        old, new = before.GetAttributeAtPath(path), after.GetAttributeAtPath(path)
        size = 1e-30
        for time in times:
            numbers, _ = as_numbers(old.Get(time))
            if numbers is not None and numbers.size:
                size = max(size, float(np.abs(numbers).max()))
        for out, into in pairs:
            a, b = old.Get(into), new.Get(out)
            (x, turned), (y, _) = as_numbers(a), as_numbers(b)
            if x is None or y is None or x.dtype.kind == "b":
                if a != b:
                    other.append(f"{path} at {out}: {b!r} for {a!r}")
            elif x.shape != y.shape:
                other.append(f"{path} at {out}: {y.shape} for {x.shape}")
            elif turned:
                degrees = max(degrees, degrees_apart(x, y))
            elif x.size:
                relative = max(relative, float(np.abs(x - y).max()) / size)
    return relative, degrees, other
