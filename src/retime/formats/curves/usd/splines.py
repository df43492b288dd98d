"""Splines of USD (TsSpline) cut by a warp. Runs in the child process (`usd.child`).

A Bézier knot's tangent is a width in time and a slope: its end is the handle that `retime.warp.cutting` knows.
"""

from __future__ import annotations

from itertools import pairwise
from typing import Any

import numpy as np
from pxr import Gf, Ts

from retime.errors import FormatError, OptionError
from retime.formats.curves.usd.animation import Span
from retime.warp.curve import Warp
from retime.warp.cutting import CurveSegments, SegmentKind, cut_curve

_KINDS = {Ts.InterpHeld: SegmentKind.STEP, Ts.InterpLinear: SegmentKind.LINEAR, Ts.InterpCurve: SegmentKind.CUBIC}
# Loops may be short and the scene long.
_MOST_KNOTS = 100_000
_INTERPOLATIONS = {int(kind): interpolation for interpolation, kind in _KINDS.items()}


def cut_spline(spline: Any, warp: Warp, span: Span, where: str) -> Any:
    """Give a spline new timing.

    Parameters
    ----------
    spline : Ts.Spline
        In time codes.
    warp : Warp
        Seconds from the scene's start.
    span : Span
        The scene's clock.
    where : str
        The attribute, for messages.

    Raises
    ------
    FormatError
        It has a form that can't be cut, or loops too often.
    """
    refused = {
        "is a Hermite curve": spline.GetCurveType() != Ts.CurveTypeBezier,
        "holds times": spline.IsTimeValued(),
        "is blocked in parts": spline.HasValueBlocks(),
        "has tangents longer than what they span": spline.HasRegressiveTangents(),
        "shows nothing beyond its first or last knot": any(
            one.mode == Ts.ExtrapValueBlock for one in (spline.GetPreExtrapolation(), spline.GetPostExtrapolation())
        ),
    }
    for what, is_so in refused.items():
        if is_so:
            raise FormatError(f"the spline {where} {what}: make time samples of it first, or give it a plain end")
    shown = span.start + np.array([warp.input_times.min(), warp.input_times.max()]) * span.per_second
    knots = _unrolled(spline, float(shown[0]), float(shown[1]), where)
    if len(knots) < 2:
        return spline
    try:
        cut = cut_curve(_curve(knots, span), warp)[0]
    except OptionError as error:
        raise FormatError(f"the spline {where} can't be cut: {error}") from None
    result = Ts.Spline(spline.GetValueTypeName())
    for knot in _knots(cut, spline.GetValueTypeName(), span):
        result.SetKnot(knot)
    return result


def _unrolled(spline: Any, low: float, high: float, where: str) -> list[Any]:
    """Write out what a spline shows from one time code to another: its knots, its loops, and lines beyond its ends."""
    knots = list(spline.GetKnots().values())
    if spline.HasLoops():
        period = min(_periods(spline, knots), default=0.0)
        if not period > 0 or (high - low) / period * len(knots) > _MOST_KNOTS:
            raise FormatError(f"the spline {where} loops so often that it would have more than {_MOST_KNOTS} knots")
        knots = list(spline.GetKnotsWithLoopsBaked(Gf.Interval(low, high)).values())
    if not knots:
        return knots
    lines = (Ts.ExtrapLinear, Ts.ExtrapSloped)
    if spline.GetPreExtrapolation().mode in lines and low < knots[0].GetTime():
        knots.insert(0, _knot_of_line(spline, low))
    if spline.GetPostExtrapolation().mode in lines and high > knots[-1].GetTime():
        knots[-1].SetNextInterpolation(Ts.InterpLinear)
        knots.append(_knot_of_line(spline, high))
    return knots


def _periods(spline: Any, knots: list[Any]) -> list[float]:
    """Say how long the loops are, in time codes: that of the knots inside, and that beyond the ends."""
    if not knots:
        return []
    found = [knots[-1].GetTime() - knots[0].GetTime()] if spline.HasExtrapolatingLoops() else []
    inner = spline.GetInnerLoopParams()
    if inner.numPreLoops > 0 or inner.numPostLoops > 0:
        found.append(inner.protoEnd - inner.protoStart)
    return found


def _knot_of_line(spline: Any, code: float) -> Any:
    knot = Ts.Knot(spline.GetValueTypeName(), time=code, value=spline.Eval(code))
    knot.SetNextInterpolation(Ts.InterpLinear)
    return knot


def _curve(knots: list[Any], span: Span) -> CurveSegments:
    codes = np.array([knot.GetTime() for knot in knots], dtype=np.float64)
    values = np.array([knot.GetValue() for knot in knots], dtype=np.float64)
    if (
        not np.isfinite(values).all()
        or not np.isfinite(codes).all()
        or np.abs(codes - span.start).max() / span.per_second > 1e7
    ):
        raise FormatError("a spline has a knot that is no number, or no time")
    curve = CurveSegments.through((codes - span.start) / span.per_second, values[:, None], SegmentKind.LINEAR)
    for i, (a, b) in enumerate(pairwise(knots)):
        kind = _KINDS[a.GetNextInterpolation()]
        curve.kinds[i] = kind
        arrives = float(b.GetPreValue() if b.IsDualValued() else b.GetValue())
        curve.values[i, :, 0] = np.linspace(float(curve.values[i, 0, 0]), arrives, 4)
        if kind is SegmentKind.STEP:
            curve.values[i] = curve.values[i, 0]
        if kind is SegmentKind.CUBIC:
            first, last = a.GetPostTanWidth(), b.GetPreTanWidth()
            curve.times[i, 1] = curve.times[i, 0] + first / span.per_second
            curve.times[i, 2] = curve.times[i, 3] - last / span.per_second
            curve.values[i, 1] = curve.values[i, 0] + first * a.GetPostTanSlope()
            curve.values[i, 2] = arrives - last * b.GetPreTanSlope()
    return curve


def _knots(cut: CurveSegments, kind: str, span: Span) -> list[Any]:
    count = len(cut)
    codes = span.start + np.append(cut.times[:, 0], cut.end_time) * span.per_second
    values = np.append(cut.values[:, 0, 0], cut.end_value)
    jumps = set(cut.jumps.tolist())
    found = []
    for i in range(count + 1):
        knot = Ts.Knot(kind, time=round(float(codes[i]), 9), value=float(values[i]))
        if i < count:
            knot.SetNextInterpolation(_INTERPOLATIONS[int(cut.kinds[i])])
            if cut.kinds[i] == SegmentKind.CUBIC:
                width = (cut.times[i, 1] - cut.times[i, 0]) * span.per_second
                knot.SetPostTanWidth(float(width))
                knot.SetPostTanSlope(_slope(cut.values[i, 1, 0] - cut.values[i, 0, 0], width))
        if i and cut.kinds[i - 1] == SegmentKind.CUBIC:
            width = (cut.times[i - 1, 3] - cut.times[i - 1, 2]) * span.per_second
            knot.SetPreTanWidth(float(width))
            knot.SetPreTanSlope(_slope(cut.values[i - 1, 3, 0] - cut.values[i - 1, 2, 0], width))
        if i and i - 1 in jumps:
            knot.SetPreValue(float(cut.values[i - 1, 3, 0]))
        found.append(knot)
    return found


def _slope(rise: float, width: float) -> float:
    return float(rise / width) if width > 0 else 0.0
