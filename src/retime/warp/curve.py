"""The warp: a continuous map from output time to input time.

Its slope is the playback speed: 2 plays the input twice as fast, 0 holds a pose, below 0 runs backward. It is stored
as a polyline, which is closed under everything done to it here (inverse, composition, blending), so a saved
warp means the same numbers in every program that draws straight lines between knots.
"""

from __future__ import annotations

import math
import warnings
from collections.abc import Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from os import PathLike
from typing import TYPE_CHECKING, Any, Protocol, cast

import numpy as np
from numpy.typing import ArrayLike, NDArray

from retime.arrays import FloatArray, IntArray, as_real
from retime.brief import brief, kind_of
from retime.checks import path_of, real
from retime.errors import FormatError, InfeasibleWarpError, OptionError, RetimeWarning
from retime.files import MOST_BYTES, read_bytes, write_bytes
from retime.frames import frame_positions
from retime.limits import MOST_FRAMES
from retime.warp import document
from retime.warp.keytime import Keytime, KeytimeLike, check_speed, keytimes_of
from retime.warp.knots import add_times
from retime.warp.picture import warp_html
from retime.warp.sampling import ResampleMethod, nearest, range_problem, refuse_no_clock, rows_of, shown_rows
from retime.warp.simplify import simplified
from retime.warp.smoothing import smoothed


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

    # What the constructor takes. A dataclass alone could declare only what its fields hold afterwards.
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

        Raises
        ------
        OptionError
            More than any clip can have (`retime.limits.MOST_FRAMES`).
        """
        frames = self.output_span * float(rate)
        if not frames < MOST_FRAMES:
            raise OptionError(
                f"the warp's output of {self.output_span:g} s has {frames + 1:.3g} frames at {float(rate):g} frames a "
                f"second; {MOST_FRAMES} is the most. Is it the warp of another clip?"
            )
        return max(1, round(frames) + 1)

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
        keys = np.array([key.output_time for key in self.keytimes], dtype=np.float64)
        times, values = smoothed(
            self.output_times,
            self.input_times,
            window,
            at=self.output_times if at is None else np.asarray(at, dtype=np.float64),
            keep=np.concatenate([keys, np.asarray(keep, dtype=np.float64)]),
            keep_ends=loop,
        )
        return replace(self, output_times=times, input_times=values)

    def simplify(self, tolerance: float = 0.001) -> Warp:
        """Return the warp with fewer knots, for programs in which each knot is a key.

        Parameters
        ----------
        tolerance : float
            The largest error in input time, seconds. At 0 only knots on a straight line go.

        Returns
        -------
        Warp
            Its knots are knots of this warp. The ends stay, and so do the knots at keytimes and where the warp begins
            or ends to hold, or turns.

        Raises
        ------
        OptionError
            The tolerance is not a number of seconds from 0 up.

        Examples
        --------
        >>> warp = Warp([0.0, 1.0, 2.0, 3.0], [0.0, 1.0, 2.0, 2.5])
        >>> warp.simplify(0).output_times.tolist()
        [0.0, 2.0, 3.0]
        """
        tolerance = real(tolerance, "the tolerance")
        if not (math.isfinite(tolerance) and tolerance >= 0):
            raise OptionError(f"the tolerance must be 0 or more seconds, found {tolerance}")
        keys = np.array([key.output_time for key in self.keytimes], dtype=np.float64)
        chosen = simplified(self.output_times, self.input_times, tolerance, keys)
        return replace(self, output_times=self.output_times[chosen], input_times=self.input_times[chosen])

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
        return nearest(self._places(rate, n_frames))

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
        values = rows_of(array, method)
        return shown_rows(values, self._places(rate, len(values)), method)

    def _places(self, rate: float, n_frames: int) -> tuple[IntArray, IntArray, FloatArray]:
        """Place the output frames among the frames of an input, as `frame_positions` does."""
        refuse_no_clock(rate, n_frames)
        problem = self.range_problem(float((n_frames - 1) / rate), float(rate), "the input")
        if problem:
            warnings.warn(problem, RetimeWarning, stacklevel=3)
        return frame_positions(self(output_frame_times(self, float(rate))), float(rate), n_frames)

    def range_problem(self, end_time: float, rate: float, name: str) -> str:
        """Say how the input times differ from those of a clip's frames; see `retime.warp.sampling.range_problem`."""
        return range_problem(float(self.input_times.min()), float(self.input_times.max()), end_time, rate, name)

    def _repr_html_(self) -> str:
        pairs = [(key.output_time, key.input_time) for key in self.keytimes]
        return warp_html(self.output_times, self.input_times, self.slopes, pairs)

    def to_json(self) -> str:
        """Return the warp as a JSON document (format ``retime-warp``, version 1); numbers come back bit for bit."""
        return document.written(self.output_times, self.input_times, self.keytimes, method=self.method, name=self.name)

    @classmethod
    def from_json(cls, text: str | bytes) -> Warp:
        """Read a warp from a JSON document.

        Raises
        ------
        FormatError
            Not JSON, not a warp, a version from the future, or numbers that make no warp.
        """
        found = document.parsed(text)
        try:
            return cls(found.output_times, found.input_times, found.keytimes, method=found.method, name=found.name)
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
