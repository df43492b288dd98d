"""The warp: a continuous map from output time to input time.

Its slope is the playback speed: 2 plays the input twice as fast, 0 holds a pose, below 0 runs backward. It is stored
as a polyline, which is closed under everything done to it here (inverse, composition, blending), so a saved
warp means the same numbers in every program that draws straight lines between knots.
"""

from __future__ import annotations

import itertools
import json
import math
import warnings
from dataclasses import dataclass, field, replace
from fractions import Fraction

import numpy as np
from numpy.typing import ArrayLike, NDArray

from retime.errors import FormatError, InfeasibleWarpError, OptionError
from retime.warp.strict_json import parse_json

FloatArray = NDArray[np.float64]

_VERSION = 1
_MAX_KNOTS = 20_000_000
# Seconds. Two knots closer than this are one: the slope between them would be made of rounding errors.
_SAME_TIME = 1e-9


@dataclass(frozen=True, order=True)
class Keytime:
    """At `output_time` the output shows the pose that the input has at `input_time`; both in seconds.

    Attributes
    ----------
    output_time, input_time : float
        Seconds from the first frame of the output, of the input.
    speed : float, optional
        Playback speed there (a tangent), above 0; a backward span has it backward. Left out, whatever comes.
    """

    output_time: float
    input_time: float
    speed: float | None = field(default=None, compare=False)


@dataclass(frozen=True, eq=False)
class Warp:
    """A continuous map from output time to input time, linear between knots.

    Parameters
    ----------
    output_times : float array, shape (n_knots,)
        Seconds, strictly increasing; at least two.
    input_times : float array, shape (n_knots,)
        Seconds. Increasing where the warp plays forward, equal where it holds, decreasing where it runs backward.
    keytimes : tuple of Keytime
        The keytimes that it was made to meet, for plots and for smoothing.
    method : str
        How it was found: "guided", "linear", "spline", ... or "".
    name : str
        What to call it in messages and plots.

    Raises
    ------
    OptionError
        Fewer than two knots, times (of knots or keytimes) that are not finite, or output times that don't increase.

    Examples
    --------
    >>> warp = Warp([0.0, 1.0, 2.0], [0.0, 2.0, 3.0])
    >>> float(warp(0.5)), warp.speed([0.5, 1.5]).tolist()
    (1.0, [2.0, 1.0])
    >>> float(warp.inverse()(1.0))
    0.5
    """

    output_times: FloatArray
    input_times: FloatArray
    keytimes: tuple[Keytime, ...] = ()
    method: str = ""
    name: str = ""

    def __post_init__(self) -> None:
        output_times = np.array(self.output_times, dtype=np.float64)
        input_times = np.array(self.input_times, dtype=np.float64)
        if output_times.ndim != 1 or output_times.shape != input_times.shape or len(output_times) < 2:
            raise OptionError(
                "a warp needs two or more knots, one input time for each output time; found shapes "
                f"{output_times.shape} and {input_times.shape}"
            )
        if not (np.isfinite(output_times).all() and np.isfinite(input_times).all()):
            knot = int(np.flatnonzero(~(np.isfinite(output_times) & np.isfinite(input_times)))[0])
            raise OptionError(f"knot {knot} of the warp is not finite: {output_times[knot]}, {input_times[knot]}")
        for key in self.keytimes:
            if not (math.isfinite(key.output_time) and math.isfinite(key.input_time)):
                raise OptionError(f"a keytime of the warp is not finite: {key.output_time}, {key.input_time}")
            check_speed(key)
        stuck = np.flatnonzero(output_times[1:] <= output_times[:-1])
        if len(stuck):
            knot = int(stuck[0])
            raise OptionError(
                f"output times must increase: knot {knot + 1} is at {output_times[knot + 1]:g} s, after one at "
                f"{output_times[knot]:g} s"
            )
        for name, array in (("output_times", output_times), ("input_times", input_times)):
            array.setflags(write=False)
            object.__setattr__(self, name, array)

    @property
    def output_start(self) -> float:
        """Output time of the first knot, seconds."""
        return float(self.output_times[0])

    @property
    def output_end(self) -> float:
        """Output time of the last knot, seconds."""
        return float(self.output_times[-1])

    @property
    def output_span(self) -> float:
        """Seconds of output between the first knot and the last.

        Not the length of a clip: that counts the last frame too, which is shown for a frame period (`count_frames`).
        """
        return self.output_end - self.output_start

    @property
    def output_duration(self) -> float:
        """Deprecated: `output_span` under a name that was taken for the length of a clip."""
        warnings.warn("Warp.output_duration is now Warp.output_span", DeprecationWarning, stacklevel=2)
        return self.output_span

    def count_frames(self, rate: float | Fraction) -> int:
        """Count the frames that a clip gets by this warp; its length is so many periods of `rate`.

        Parameters
        ----------
        rate : float or Fraction
            Of the clip, Hz.

        Examples
        --------
        >>> Warp([0.0, 479 / 60], [0.0, 12.0]).count_frames(60) / 60
        8.0
        """
        return max(1, round(self.output_span * float(rate)) + 1)

    @property
    def slopes(self) -> FloatArray:
        """Playback speed of each piece between knots, shape (n_knots - 1,)."""
        return np.diff(self.input_times) / np.diff(self.output_times)

    @property
    def monotone(self) -> bool:
        """Whether the warp plays forward everywhere, without a hold."""
        return bool(np.all(self.input_times[1:] > self.input_times[:-1]))

    def __call__(self, output_times: ArrayLike) -> FloatArray:
        """Return the input time (seconds) shown at each output time (seconds); held at the ends outside."""
        return np.asarray(np.interp(np.asarray(output_times, dtype=np.float64), self.output_times, self.input_times))

    def speed(self, output_times: ArrayLike) -> FloatArray:
        """Return the playback speed at each output time; at a knot, that of the piece after it."""
        slopes = self.slopes
        piece = np.searchsorted(self.output_times, np.asarray(output_times, dtype=np.float64), side="right") - 1
        return slopes[np.clip(piece, 0, len(slopes) - 1)]

    def inverse(self) -> Warp:
        """Return the map from input time to output time.

        Raises
        ------
        InfeasibleWarpError
            The warp holds or runs backward somewhere: one input time then has several output times, or none.
        """
        if not self.monotone:
            piece = int(np.flatnonzero(self.input_times[1:] <= self.input_times[:-1])[0])
            raise InfeasibleWarpError(
                f"the warp holds or runs backward from output time {self.output_times[piece]:g} s, so it has no inverse"
            )
        keytimes = tuple(Keytime(key.input_time, key.output_time) for key in self.keytimes)
        return replace(self, output_times=self.input_times, input_times=self.output_times, keytimes=keytimes)

    def compose(self, first: Warp) -> Warp:
        """Return the warp that applies `first`, then this one: ``result(t) == self(first(t))``.

        `first` maps the new output time to what this warp calls output time. Its keytimes and this one's are dropped:
        they speak of a time in between.
        """
        # Where `first` passes a knot of this warp on its way, the result has a corner.
        corners = [np.empty(0)]
        for before, after, a, b in zip(
            first.output_times[:-1],
            first.output_times[1:],
            first.input_times[:-1],
            first.input_times[1:],
            strict=True,
        ):
            if a != b:
                low = np.searchsorted(self.output_times, min(a, b), side="right")
                high = np.searchsorted(self.output_times, max(a, b), side="left")
                inner = self.output_times[low:high]
                corners.append(before + (inner - a) / (b - a) * (after - before))
        times = add_times(first.output_times, np.concatenate(corners))
        return Warp(times, self(first(times)), method=self.method, name=self.name)

    def smooth(self, window: float, *, at: ArrayLike | None = None, keep: ArrayLike = (), loop: bool = False) -> Warp:
        """Average the warp over a moving window, and keep its ends and keytimes exactly (§3.4).

        The mean of the warp over `window` seconds of output around each time. Beyond its ends the warp is continued
        by point reflection, so the ends stay; near a keytime inside the window shrinks, so the keytime stays. A
        window that grows or shrinks no faster than time passes keeps a monotone warp monotone: between neighbouring
        times it gains only later values, or loses only earlier ones.

        Parameters
        ----------
        window : float
            Full width in seconds of output time; 0 changes nothing.
        at : float array, optional
            Output times of the new knots, to which ends and keytimes are added. Left out: the knots of this warp.
        keep : float array, optional
            More output times at which the warp stays as it is, as at a keytime: what is straight between two of them
            stays straight.
        loop : bool
            Keep the first and the last piece too: where their slopes agree, a loop has no corner at its seam.

        Returns
        -------
        Warp
            With the same ends and keytimes.
        """
        if not (np.isfinite(window) and window >= 0):
            raise OptionError(f"the smoothing window must be 0 or more seconds, found {window}")
        start, end = self.output_start, self.output_end
        ends = self.output_times[[0, 1, -2, -1]] if loop else np.empty(0)
        kept = np.concatenate([[key.output_time for key in self.keytimes], np.asarray(keep, dtype=np.float64), ends])
        inner = np.unique(kept[(kept > start) & (kept < end)])
        wanted = self.output_times if at is None else np.asarray(at, dtype=np.float64)
        times = add_times(np.concatenate([[start], inner, [end]]), wanted[(wanted > start) & (wanted < end)])
        half = np.full(len(times), min(window, self.output_span) / 2)
        fixed = np.concatenate([[start], inner, [end]]) if loop else inner
        if len(fixed):
            later = np.clip(np.searchsorted(fixed, times), 0, len(fixed) - 1)
            earlier = np.maximum(later - 1, 0)
            half = np.minimum(half, np.minimum(np.abs(times - fixed[later]), np.abs(times - fixed[earlier])))
        input_times = self(times)
        wide = (half > 0) & (times > start) & (times < end)
        input_times[wide] = self._mean_around(times[wide], half[wide])
        input_times[np.isin(times, inner)] = self(times[np.isin(times, inner)])
        return replace(self, output_times=times, input_times=input_times)

    def _mean_around(self, times: FloatArray, half: FloatArray) -> FloatArray:
        """Average over [t - half, t + half], piece by piece: sums stay local, so hours of warp lose no digits."""
        t, w = self.output_times, self.input_times
        t = np.concatenate([2 * t[0] - t[:0:-1], t, 2 * t[-1] - t[-2::-1]])
        w = np.concatenate([2 * w[0] - w[:0:-1], w, 2 * w[-1] - w[-2::-1]])
        low, high = times - half, times + half
        piece = np.searchsorted(t, low, side="right") - 1
        last = np.searchsorted(t, high, side="left") - 1
        centre = np.interp(times, t, w)
        area = np.zeros(len(times))
        while True:
            live = piece <= last
            if not live.any():
                break
            here = np.where(live, piece, last)
            a, b = np.maximum(low, t[here]), np.minimum(high, t[here + 1])
            # Reflected about an end, the shortest pieces may round to none.
            width = t[here + 1] - t[here]
            slope = (w[here + 1] - w[here]) / np.where(width > 0, width, np.inf)
            middle = w[here] + slope * ((a + b) / 2 - t[here]) - centre
            area += np.where(live, (b - a) * middle, 0.0)
            piece = piece + 1
        return np.asarray(centre + area / (2 * half))

    def _repr_html_(self) -> str:
        from retime.warp.picture import warp_html

        return warp_html(self)

    def to_json(self) -> str:
        """Return the warp as a JSON document (format ``retime-warp``, version 1); numbers come back bit for bit."""
        document = {
            "format": "retime-warp",
            "version": _VERSION,
            "method": self.method,
            "name": self.name,
            "keytimes": [
                [key.output_time, key.input_time] + ([] if key.speed is None else [key.speed]) for key in self.keytimes
            ],
            "output_times": self.output_times.tolist(),
            "input_times": self.input_times.tolist(),
        }
        return json.dumps(document, allow_nan=False) + "\n"

    @classmethod
    def from_json(cls, text: str | bytes) -> Warp:
        """Read a warp from a JSON document.

        Raises
        ------
        FormatError
            Not JSON, not a warp, a version from the future, or numbers that make no warp.
        """
        document = parse_json(text, what="a warp", prefix="not a warp: ")
        if not isinstance(document, dict) or document.get("format") != "retime-warp":
            raise FormatError('expected a warp: a JSON object with "format": "retime-warp"')
        version = document.get("version")
        if version != _VERSION or not _is_number(version):
            raise FormatError(f"warp version {version!r} is not one that this program reads (it reads {_VERSION})")
        output_times = _numbers("output_times", document.get("output_times"))
        input_times = _numbers("input_times", document.get("input_times"))
        pairs = document.get("keytimes", [])
        if not isinstance(pairs, list) or not all(isinstance(pair, list) and len(pair) in (2, 3) for pair in pairs):
            raise FormatError(
                "keytimes: expected [output time, input time] in seconds, and a speed where it has a tangent"
            )
        keytimes = [Keytime(*_numbers("keytimes", pair).tolist()) for pair in pairs]
        texts = {key: document.get(key, "") for key in ("method", "name")}
        for key, value in texts.items():
            if not isinstance(value, str):
                raise FormatError(f"{key}: expected text, found {value!r}")
        try:
            return cls(
                output_times,
                input_times,
                tuple(keytimes),
                method=texts["method"],
                name=texts["name"],
            )
        except OptionError as error:
            raise FormatError(str(error)) from None


def _is_number(value: object) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool)


def _numbers(key: str, values: object) -> FloatArray:
    if not isinstance(values, list) or not all(_is_number(value) for value in values):
        raise FormatError(f"{key}: expected a list of numbers")
    if len(values) > _MAX_KNOTS:
        raise FormatError(f"{key}: {len(values)} knots, the limit is {_MAX_KNOTS}")
    try:
        return np.array(values, dtype=np.float64)
    except OverflowError:
        raise FormatError(f"{key}: a number is too large") from None


def check_speed(key: Keytime) -> None:
    """Refuse a tangent that is no speed; raise OptionError."""
    if key.speed is not None and not (math.isfinite(key.speed) and key.speed > 0):
        raise OptionError(
            f"the speed of a keytime must be above 0, found {key.speed:g} at output time {key.output_time:g} s",
            option="keys",
            output_times=(key.output_time,),
        )


def add_times(times: FloatArray, more: FloatArray) -> FloatArray:
    """Add times to increasing ones, except where one within a billionth of a second is there already."""
    more = np.unique(more)
    place = np.searchsorted(times, more)
    earlier, later = times[np.maximum(place - 1, 0)], times[np.minimum(place, len(times) - 1)]
    more = more[np.minimum(np.abs(more - earlier), np.abs(later - more)) > _SAME_TIME]
    return np.union1d(times, more[np.diff(more, prepend=-np.inf) > _SAME_TIME])


def blend(a: Warp, b: Warp, weight: ArrayLike) -> Warp:
    """Mix two warps of the same ends: ``(1 - weight) a + weight b`` (§5).

    A mix of monotone maps is monotone where the weight is constant. A weight that changes with time can turn it
    back; between two keytimes where that happens, the weight's changes are scaled down to the most that keep the
    mix monotone.

    Parameters
    ----------
    a, b : Warp
        With the same output range. The result has `a`'s keytimes.
    weight : float, or float array of shape (n, 2)
        0 gives `a`, 1 gives `b`. An array is a curve: output times (seconds, increasing) and weights, straight
        lines in between, constant outside.

    Raises
    ------
    OptionError
        Different ranges, or weights that are not from 0 to 1.

    Examples
    --------
    >>> slow, fast = Warp([0.0, 1.0, 2.0], [0.0, 0.5, 2.0]), Warp([0.0, 1.0, 2.0], [0.0, 1.5, 2.0])
    >>> float(blend(slow, fast, 0.5)(1.0))
    1.0
    """
    curve = np.asarray(weight, dtype=np.float64)
    if not np.all((curve if curve.ndim == 0 else curve[..., -1]) >= 0) or not np.all(
        (curve if curve.ndim == 0 else curve[..., -1]) <= 1
    ):
        raise OptionError(f"the weights of a blend must be from 0 to 1, found {weight!r}")
    if curve.ndim != 0 and (
        curve.ndim != 2 or curve.shape[1:] != (2,) or not np.all(np.diff(curve[:, 0], prepend=-np.inf) > 0)
    ):
        raise OptionError("a blend's curve needs rows of (output time, weight) with times that increase")
    if curve.size == 0:
        raise OptionError("a blend's curve needs one or more rows of (output time, weight)")
    if not np.allclose([a.output_start, a.output_end], [b.output_start, b.output_end], rtol=0, atol=1e-9):
        raise OptionError(
            f"only warps of the same output range can be mixed: {a.output_start:g}–{a.output_end:g} s and "
            f"{b.output_start:g}–{b.output_end:g} s"
        )
    inner = b.output_times if curve.ndim == 0 else np.concatenate([b.output_times, curve[:, 0]])
    times = add_times(a.output_times, inner[(inner > a.output_start) & (inner < a.output_end)])
    one, other = a(times), b(times)
    other[0], other[-1] = b.input_times[0], b.input_times[-1]
    if curve.ndim == 0:
        # Written so that times on which both agree stay as they are, bit for bit.
        mixed = one + float(curve) * (other - one) if curve < 1 else other
        return Warp(times, mixed, a.keytimes, method="blend", name=a.name)
    share = np.interp(times, curve[:, 0], curve[:, 1])
    inner_keys = [key.output_time for key in a.keytimes if a.output_start < key.output_time < a.output_end]
    ends = np.unique(np.searchsorted(times, [a.output_start, *inner_keys, a.output_end]))
    mixed = one.copy()
    for first, last in itertools.pairwise(ends.tolist()):
        piece = slice(first, last + 1)
        mixed[piece] = _mix_monotone(one[piece], other[piece], share[piece])
    return Warp(times, mixed, a.keytimes, method="blend", name=a.name)


def _mix_monotone(one: FloatArray, other: FloatArray, share: FloatArray) -> FloatArray:
    """Mix one span by a changing share; scale the share's changes down until the mix never turns back."""
    sign = np.sign(one[-1] - one[0])

    def mixed(scale: float) -> FloatArray:
        weight = middle + scale * (share - middle)
        # Where one of them is all there is, it comes bit for bit.
        return np.where(weight == 1.0, other, one + weight * (other - one))

    def turns(values: FloatArray) -> bool:
        return bool(np.any(np.diff(values) * sign < 0))

    middle = float(share.mean())
    if sign == 0 or not turns(mixed(1.0)) or turns(one) or turns(other):
        return mixed(1.0)
    low, high = 0.0, 1.0
    for _ in range(40):
        scale = (low + high) / 2
        low, high = (low, scale) if turns(mixed(scale)) else (scale, high)
    return mixed(low)
