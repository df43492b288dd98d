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
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field, replace
from fractions import Fraction
from numbers import Integral, Real
from os import PathLike
from typing import TYPE_CHECKING, Any, Literal, Protocol, cast, get_args

import numpy as np
from numpy.typing import ArrayLike, NDArray

from retime.arrays import FloatArray, as_real
from retime.brief import brief, kind_of
from retime.checks import path_of, real
from retime.errors import FormatError, InfeasibleWarpError, OptionError, RetimeWarning
from retime.files import MOST_BYTES, read_bytes, write_bytes
from retime.frames import frame_positions
from retime.strict_json import parse_json
from retime.warp.picture import warp_html

IntArray = NDArray[np.intp]
ResampleMethod = Literal["linear", "nearest"]

_VERSION = 1
_MAX_KNOTS = 20_000_000
# Seconds. Two knots closer than this are one: the slope between them would be made of rounding errors.
_SAME_TIME = 1e-9


@dataclass(frozen=True, order=True, init=False, repr=False, match_args=False)
class Keytime:
    """At `output_time` the output shows the pose that the input has at `input_time`; both in seconds.

    Made by names. Where a keytime is written without them, as ``(input_time, output_time)`` or ``(input_time,
    output_time, speed)``, the input comes first, as in ``--key IN=OUT``; every call that takes keytimes takes such
    tuples too. Keytimes sort by output time.

    Parameters
    ----------
    input_time, output_time : float
        Seconds from the first frame of the input, of the output.
    speed : float, optional
        Playback speed there (a tangent), above 0; a backward span has it backward. Left out, whatever comes.

    Raises
    ------
    OptionError
        A time or a speed is no number.

    Warns
    -----
    DeprecationWarning
        Arguments without names are taken as retime 0.1 took them, the output time first. A later release will refuse
        them; none will take them the other way round.

    Examples
    --------
    >>> Keytime(input_time=2.0, output_time=1.5)
    Keytime(input_time=2.0, output_time=1.5)
    """

    # Keytimes are compared, and so sorted, by their fields in this order.
    output_time: float
    input_time: float
    speed: float | None = field(default=None, compare=False)

    if TYPE_CHECKING:

        def __init__(self, *, input_time: float, output_time: float, speed: float | None = None) -> None: ...

    else:

        def __init__(self, *output_first: float, **named: float | None) -> None:
            if output_first:
                warnings.warn(
                    "Keytime(output_time, input_time) without names is deprecated, for key tuples have the input "
                    "first: write Keytime(input_time=..., output_time=...), or a tuple (input_time, output_time)",
                    DeprecationWarning,
                    stacklevel=2,
                )
            order = ("output_time", "input_time", "speed")
            times = dict(zip(order, output_first, strict=False))
            wrong = [name for name in named if name not in order or name in times]
            missing = [name for name in ("input_time", "output_time") if name not in times and name not in named]
            if len(output_first) > len(order) or wrong or missing:
                raise TypeError(
                    "expected Keytime(input_time=..., output_time=...), and speed=... where it has a tangent"
                )
            times.update(named)
            for name in order:
                value = times.get(name)
                if value is not None or name != "speed":
                    value = real(value, f"the {name.replace('_', ' ')} of a keytime")
                object.__setattr__(self, name, value)

    def __repr__(self) -> str:
        speed = "" if self.speed is None else f", speed={self.speed!r}"
        return f"Keytime(input_time={self.input_time!r}, output_time={self.output_time!r}{speed})"


KeytimeLike = Keytime | Sequence[float]
"""A keytime, or a tuple (input time, output time) or (input time, output time, speed)."""


def keytime_of(key: KeytimeLike) -> Keytime:
    """Take a keytime, or the numbers of one with the input time first.

    Raises
    ------
    OptionError
        Neither of them.

    Examples
    --------
    >>> keytime_of((2.0, 1.5))
    Keytime(input_time=2.0, output_time=1.5)
    """
    if isinstance(key, Keytime):
        return key
    if isinstance(key, str | bytes) or not isinstance(key, Sequence | np.ndarray) or len(key) not in (2, 3):
        raise OptionError(
            "expected a keytime: a tuple (input time, output time) in seconds, with a speed where it has a tangent; "
            f"found {kind_of(key)}",
            option="keys",
        )
    speed = key[2] if len(key) == 3 else None
    return Keytime(input_time=key[0], output_time=key[1], speed=speed)


def keytimes_of(keys: Sequence[KeytimeLike]) -> tuple[Keytime, ...]:
    """Take several of what `keytime_of` takes."""
    if isinstance(keys, str | bytes | Keytime) or not isinstance(keys, Iterable):
        raise OptionError(
            f"expected keytimes, as in [(0, 0), (2.0, 1.5)] with the input time first; found {kind_of(keys)}",
            option="keys",
        )
    return tuple(keytime_of(key) for key in keys)


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

    Notes
    -----
    Two warps are equal where all of this is: the same knots, keytimes, tangents, method and name. As a function of time
    a warp has its argument first, as ``np.interp`` has: output times, then input times.

    Examples
    --------
    >>> warp = Warp([0.0, 1.0, 2.0], [0.0, 2.0, 3.0])
    >>> float(warp(0.5)), warp.speed([0.5, 1.5]).tolist()
    (1.0, [2.0, 1.0])
    >>> float(warp.inverse()(1.0))
    0.5
    >>> warp.domain, float(warp(99.0))
    ((0.0, 2.0), 3.0)
    >>> warp
    Warp(output 0 to 2 s, input 0 to 3 s, 3 knots)
    """

    output_times: FloatArray
    input_times: FloatArray
    keytimes: tuple[Keytime, ...] = ()
    method: str = ""
    name: str = ""

    # What dataclass makes takes these types; it can declare only what the fields are then.
    if TYPE_CHECKING:

        def __init__(
            self,
            output_times: ArrayLike,
            input_times: ArrayLike,
            keytimes: Sequence[KeytimeLike] = (),
            method: str = "",
            name: str = "",
        ) -> None: ...

    def __post_init__(self) -> None:
        output_times = _times("output_times", self.output_times)
        input_times = _times("input_times", self.input_times)
        object.__setattr__(self, "keytimes", keytimes_of(self.keytimes))
        for what in ("method", "name"):
            if not isinstance(getattr(self, what), str):
                raise OptionError(f"the {what} of a warp is text, found {kind_of(getattr(self, what))}")
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

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, Warp):
            return NotImplemented
        return (
            np.array_equal(self.output_times, other.output_times)
            and np.array_equal(self.input_times, other.input_times)
            and self._marks == other._marks
        )

    def __hash__(self) -> int:
        # Adding 0 makes -0.0 the 0.0 that it equals.
        return hash(((self.output_times + 0.0).tobytes(), (self.input_times + 0.0).tobytes(), self._marks))

    @property
    def _marks(self) -> tuple[object, ...]:
        """What is not knots. Keytimes themselves are compared without their tangents."""
        keys = tuple((key.input_time, key.output_time, key.speed) for key in self.keytimes)
        return keys, self.method, self.name

    def __repr__(self) -> str:
        low, high = float(self.input_times.min()), float(self.input_times.max())
        said = [brief(text) for text in (self.name, self.method) if text]
        said += [f"output {self.output_start:.6g} to {self.output_end:.6g} s", f"input {low:.6g} to {high:.6g} s"]
        said.append(f"{len(self.output_times)} knots")
        if self.keytimes:
            said.append(f"{len(self.keytimes)} keytime{'s' * (len(self.keytimes) != 1)}")
        return f"Warp({', '.join(said)})"

    @property
    def domain(self) -> tuple[float, float]:
        """Output times of the first knot and the last, seconds; beyond them the warp holds its ends."""
        return self.output_start, self.output_end

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
        """Return the input time (seconds) shown at each output time (seconds).

        Outside of `domain` the warp holds its ends: before the first knot it shows the first input time, after the last
        knot the last one.
        """
        return np.asarray(
            np.interp(as_real(output_times, "output times", error=OptionError), self.output_times, self.input_times)
        )

    def speed(self, output_times: ArrayLike) -> FloatArray:
        """Return the playback speed at each output time; at a knot, that of the piece after it.

        Outside of `domain`, that of the first or the last piece.
        """
        slopes = self.slopes
        times = as_real(output_times, "output times", error=OptionError)
        piece = np.searchsorted(self.output_times, times, side="right") - 1
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
        keytimes = tuple(Keytime(input_time=key.output_time, output_time=key.input_time) for key in self.keytimes)
        return replace(self, output_times=self.input_times, input_times=self.output_times, keytimes=keytimes)

    def compose(self, first: WarpLike) -> Warp:
        """Return the warp that applies `first`, then this one: ``result(t) == self(first(t))``.

        `first` maps the new output time to what this warp calls output time. Its keytimes and this one's are dropped:
        they speak of a time in between.
        """
        first = as_warp(first, "warp.compose(first)")
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
        window = real(window, "the smoothing window")
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

    def to_frame_indices(self, rate: float, n_frames: int) -> IntArray:
        """Say which input frame each output frame shows, to the nearest.

        Parameters
        ----------
        rate : float
            Frames a second, of the input and of the output.
        n_frames : int
            Frames of the input.

        Returns
        -------
        int array, shape (n_output,)
            Counted from 0. There are as many as `retime.apply_warp` gives a motion of this rate.

        Raises
        ------
        OptionError
            The rate is not above 0, or there is no frame.

        Warns
        -----
        RetimeWarning
            The warp and the input don't cover the same input times.

        Examples
        --------
        >>> Warp([0.0, 2.0], [0.0, 4.0]).to_frame_indices(1, 5).tolist()
        [0, 2, 4]
        """
        before, after, share = self._places(rate, n_frames)
        return np.asarray(np.where(share < 0.5, before, after))

    def resample(self, array: ArrayLike, rate: float, *, method: ResampleMethod = "linear") -> NDArray[Any]:
        """Show numbers, or labels, with this timing: only what the input has at those times, nothing is averaged.

        `retime.apply_warp` averages where the warp is fast; for labels and for frames that a detector is to see again,
        that would be wrong.

        Parameters
        ----------
        array : array, shape (n_frames, ...)
            One row a frame.
        rate : float
            Its frames a second, which the output keeps.
        method : {"linear", "nearest"}
            ``linear`` interpolates between frames; ``nearest`` takes the nearest frame's own values, of whatever type.

        Returns
        -------
        array, shape (n_output, ...)
            Of floats, or complex numbers, where interpolated; else of the type of `array`.

        Raises
        ------
        OptionError
            The rate is not above 0, there is no frame, no such method, or what is no number would be interpolated.

        Warns
        -----
        RetimeWarning
            The warp and the array don't cover the same input times.

        Examples
        --------
        >>> half = Warp([0.0, 4.0], [0.0, 2.0])
        >>> half.resample([0.0, 10.0, 20.0], 1).tolist()
        [0.0, 5.0, 10.0, 15.0, 20.0]
        >>> half.resample(["walk", "walk", "jump"], 1, method="nearest").tolist()
        ['walk', 'walk', 'walk', 'jump', 'jump']
        """
        if method not in get_args(ResampleMethod):
            raise OptionError(f"the method must be one of {', '.join(get_args(ResampleMethod))}; found {method!r}")
        values = np.asarray(array)
        if values.ndim == 0:
            raise OptionError(f"expected an array with a row for each frame, found {kind_of(array)}")
        if method == "linear" and values.dtype.kind not in "iufc":
            raise OptionError(
                f"values of type {values.dtype} can't be interpolated: method='nearest' takes them as they are"
            )
        before, after, share = self._places(rate, len(values))
        if method == "nearest":
            return np.asarray(values[np.where(share < 0.5, before, after)])
        share = share.reshape(-1, *[1] * (values.ndim - 1))
        start = values[before].astype(np.result_type(values.dtype, np.float64))
        return np.asarray(start + share * (values[after] - start))

    def _places(self, rate: float, n_frames: int) -> tuple[IntArray, IntArray, FloatArray]:
        """Place the output frames among the frames of an input, as `frame_positions` does."""
        if not isinstance(rate, Real) or isinstance(rate, bool) or not 0 < float(rate) < math.inf:
            raise OptionError(f"the rate must be a number of frames a second above 0, found {kind_of(rate)}")
        if not isinstance(n_frames, Integral) or isinstance(n_frames, bool) or n_frames < 1:
            raise OptionError(f"the number of input frames must be 1 or more, found {kind_of(n_frames)}")
        problem = self.range_problem(float((n_frames - 1) / rate), float(rate), "the input")
        if problem:
            warnings.warn(problem, RetimeWarning, stacklevel=3)
        return frame_positions(self(output_frame_times(self, float(rate))), float(rate), n_frames)

    def range_problem(self, end_time: float, rate: float, name: str) -> str:
        """Say how the input times differ from those of a clip's frames, half a frame aside; "" where they don't."""
        near = 0.5 / rate
        low, high = float(self.input_times.min()), float(self.input_times.max())
        if low < -near or high > end_time + near:
            return (
                f"the warp reaches input times {low:g} to {high:g} s, but {name} runs from 0 to {end_time:g} s; "
                "it is held at its ends"
            )
        if low > near or high < end_time - near:
            return (
                f"the warp uses input times {low:g} to {high:g} s; {name} runs from 0 to {end_time:g} s, and the "
                "rest of it is left out"
            )
        return ""

    def _repr_html_(self) -> str:
        pairs = [(key.output_time, key.input_time) for key in self.keytimes]
        return warp_html(self.output_times, self.input_times, self.slopes, pairs)

    def to_json(self) -> str:
        """Return the warp as a JSON document (format ``retime-warp``, version 1); numbers come back bit for bit."""
        document = {
            "format": "retime-warp",
            "version": _VERSION,
            "method": self.method,
            "name": self.name,
            # The output time first, as in the files of all versions.
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
        rows = [_numbers("keytimes", pair).tolist() for pair in pairs]
        keytimes = [
            Keytime(output_time=row[0], input_time=row[1], speed=row[2] if len(row) == 3 else None) for row in rows
        ]
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

    def save(self, path: str | PathLike[str], *, overwrite: bool = False) -> None:
        """Write the warp to a JSON file, whole or not at all; `Warp.load` and every command read it.

        Raises
        ------
        OutputExistsError
            The file is there, and `overwrite` is not set.
        OSError
            It can't be written.
        """
        write_bytes(path_of(path, "warp.save(path)"), self.to_json().encode(), overwrite=overwrite)

    @classmethod
    def load(cls, path: str | PathLike[str], *, most_bytes: int = MOST_BYTES) -> Warp:
        """Read a warp from a JSON file that `save` (or ``retime warp --save``) made.

        Parameters
        ----------
        path : path-like
            The file.
        most_bytes : int
            A larger file is refused.

        Raises
        ------
        FormatError
            Not a warp; says where and why.
        OSError
            The file can't be opened.

        Examples
        --------
        >>> import pathlib, tempfile
        >>> warp = Warp([0.0, 2.0], [0.0, 3.0], name="walk")
        >>> with tempfile.TemporaryDirectory() as folder:
        ...     warp.save(pathlib.Path(folder, "walk.json"))
        ...     Warp.load(pathlib.Path(folder, "walk.json")) == warp
        True
        """
        path = path_of(path, "Warp.load(path)")
        try:
            return cls.from_json(read_bytes(path, most_bytes))
        except FormatError as error:
            raise FormatError(error.problem, path=path, line=error.line, column=error.column, byte=error.byte) from None


class CarriesWarp(Protocol):
    """What has a warp, as `retime.GuidedWarp` has."""

    @property
    def warp(self) -> Warp:
        """The warp."""


WarpLike = Warp | CarriesWarp
"""A warp, or a result that has one."""


def as_warp(value: WarpLike, call: str) -> Warp:
    """Take a warp, or the warp of a result.

    Parameters
    ----------
    value : Warp or GuidedWarp
        As it was passed.
    call : str
        How the call is written, for the message.

    Raises
    ------
    OptionError
        Neither of them.
    """
    if isinstance(value, Warp):
        return value
    carried = getattr(value, "warp", None)
    if isinstance(carried, Warp):
        return carried
    remedy = "; a file is read by Warp.load(path)" if isinstance(value, str | PathLike) else ""
    raise OptionError(f"expected {call} with a Warp or what guided_warp returns; found {kind_of(value)}{remedy}")


def output_frame_times(warp: Warp, rate: float) -> FloatArray:
    """Return the output time of each frame that a warp gives at `rate`, seconds; the last one is the warp's end."""
    n_output = warp.count_frames(rate)
    times = warp.output_start + np.arange(n_output) / rate
    if n_output > 1:
        times[-1] = warp.output_end
    return times


def _times(what: str, values: object) -> FloatArray:
    return as_real(cast(ArrayLike, values), f"the {what} of a warp, in seconds,", error=OptionError).copy()


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
    curve = as_real(weight, "the weights of a blend", error=OptionError)
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
