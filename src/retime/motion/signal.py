"""Plain named channels: a motion with no skeleton (a camera path, a curve, markers)."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from os import PathLike
from typing import TYPE_CHECKING, get_args

import numpy as np
from numpy.typing import ArrayLike

from retime.arrays import BoolArray, FloatArray, as_real
from retime.brief import brief, kind_of
from retime.errors import InvalidMotionError, OptionError
from retime.frames import frame_positions, frame_range, slice_range
from retime.motion.blending import blended
from retime.motion.channels import ChannelKind, KindsLike, as_kinds, quaternion_groups
from retime.motion.clock import Clock
from retime.motion.gaps import Gaps, holes_of
from retime.motion.picture import channels_html
from retime.motion.rate import RateField, RateLike, parse_rate
from retime.motion.size import size_problem, within_size


def numbered_names(n_channels: int) -> tuple[str, ...]:
    """Name channels that have no names: c0, c1 ..."""
    return tuple(f"c{i}" for i in range(n_channels))


@dataclass(frozen=True, eq=False)
class Signal:
    """Named columns of numbers at an exact rate.

    Parameters
    ----------
    names : tuple of str
        One for each channel.
    values : float array, shape (n_frames, n_channels)
        The numbers, in whatever unit they have.
    rate : Fraction, number or str
        Frames a second: 120, 29.97, ``"30000/1001"``. Kept as an exact fraction (`retime.motion.rate.parse_rate`).
    name : str
        What to call it in messages and plots.
    time_column : str
        The column that held time in its file, "" if there was none; written again on export.
    first_frame : int
        The number of the first frame.
    kinds : sequence of ChannelKind or str, or mapping of str to them
        What each channel holds: ``"linear"``, ``"angle:deg"``, ``"quaternion"``, ``"label"`` ... (`ChannelKind`). A
        mapping tells it of some, by their names or patterns of them. What is left out is found by names and values
        (`retime.motion.channels.find_kinds`).
    gaps : {"refuse", "keep"}
        What to do about values that are not a number: refuse them, or keep them as holes, which stay holes when the
        signal is retimed, and which the search doesn't look at. `retime.motion.gaps.bridged` fills them.
    clock : Clock
        How its file writes times, and when the first frame is. It stays when the signal is retimed: what is written
        begins when the file began.
    dialect : str
        What kind of table it was read from, for people ("Motive export"); "" for others.

    Raises
    ------
    InvalidMotionError
        No frame, no channel, shapes that disagree, or a number that is not finite or beyond 1e100 (named by channel and
        frame); a rotation of length 0, a label that has no word.
    OptionError
        The rate is none, or the kinds are none.

    Examples
    --------
    >>> pan = Signal(("yaw",), np.linspace(0, 90, 46)[:, None], rate=29.97, name="pan")
    >>> pan, len(pan[10:20])
    (Signal('pan', 46 frames at 30000/1001 Hz, 1 channel: yaw), 10)
    >>> turn = Signal(("yaw",), [[179.0], [-179.0]], kinds=["angle:deg"])
    >>> turn.at([0.25 / 30]).values.tolist()
    [[179.5]]
    """

    names: tuple[str, ...]
    values: FloatArray
    rate: RateField = RateField(30)  # noqa: RUF009
    name: str = ""
    time_column: str = ""
    first_frame: int = 0
    kinds: tuple[ChannelKind, ...] = ()
    gaps: Gaps = "refuse"
    clock: Clock = Clock()  # noqa: RUF009
    dialect: str = ""

    # What the constructor takes. A dataclass alone could declare only what its fields hold afterwards.
    if TYPE_CHECKING:

        def __init__(
            self,
            names: Sequence[str],
            values: ArrayLike,
            rate: RateLike = 30,
            name: str = "",
            time_column: str = "",
            first_frame: int = 0,
            kinds: KindsLike = (),
            gaps: Gaps = "refuse",
            clock: Clock = Clock(),  # noqa: B008
            dialect: str = "",
        ) -> None: ...

    def __post_init__(self) -> None:
        if isinstance(self.names, str) or not isinstance(self.names, Iterable):
            raise InvalidMotionError(f"a signal's names are a text for each channel, found {kind_of(self.names)}")
        object.__setattr__(self, "names", tuple(self.names))
        values = as_real(self.values, "the values of a signal")
        if values.ndim != 2 or 0 in values.shape or values.shape[1] != len(self.names):
            raise InvalidMotionError(
                f"expected values of shape (n_frames >= 1, {len(self.names)} named channels), found {values.shape}"
            )
        if self.gaps not in get_args(Gaps):
            raise OptionError(f"the gaps of a signal are one of {', '.join(get_args(Gaps))}; found {self.gaps!r}")
        if not within_size([values.min(), values.max()]).all():
            wrong = ~within_size(values)
            if self.gaps == "keep":
                wrong &= ~np.isnan(values)
            if wrong.any():
                frame, channel = (int(i) for i in np.argwhere(wrong)[0])
                problem = size_problem(values[frame, channel])
                raise InvalidMotionError(f"channel {self.names[channel]!r} at frame {frame} {problem}")
        object.__setattr__(self, "kinds", as_kinds(self.kinds, self.names, values))
        _refuse_misfits(self.names, self.kinds, values)
        view = values.view()
        view.setflags(write=False)
        object.__setattr__(self, "values", view)

    def __repr__(self) -> str:
        n_channels = len(self.names)
        channels = f"{n_channels} channel{'s' * (n_channels != 1)}"
        if n_channels <= 4:
            channels += f": {', '.join(self.names)}"
        named = f"{brief(self.name)}, " if self.name else ""
        return f"Signal({named}{self.n_frames} frames at {self.rate} Hz, {channels})"

    def _repr_html_(self) -> str:
        named = {"signal": self.name} if self.name else {}
        facts = {**named, "frames": self.n_frames, "rate": f"{self.rate} Hz"}
        return channels_html(self.values, self.names, float(self.rate), facts)

    @property
    def numbered(self) -> bool:
        """Whether its channels have no names but their numbers (`numbered_names`), as those of an array."""
        return self.names == numbered_names(len(self.names))

    @property
    def holes(self) -> BoolArray:
        """Where values are missing, shape (n_frames, n_channels); nowhere, unless gaps are kept."""
        return holes_of(self.values)

    def texts(self, name: str) -> list[str]:
        """Return the word of each frame of a channel that holds text ("" in a hole); raise OptionError for others."""
        if name not in self.names:
            raise OptionError(f"{self.name or 'the signal'} has no channel {name!r}")
        place = self.names.index(name)
        words = self.kinds[place].words
        if not words:
            raise OptionError(f"channel {name!r} holds no text: it is {self.kinds[place]}")
        return ["" if np.isnan(code) else words[int(code)] for code in self.values[:, place]]

    @property
    def n_frames(self) -> int:
        """Number of frames."""
        return len(self.values)

    @property
    def duration(self) -> float:
        """Length in seconds, ``n_frames / rate``: every frame is shown for a frame period, the last one too."""
        return float(self.n_frames / self.rate)

    @property
    def end_time(self) -> float:
        """Time of the last frame, seconds, ``(n_frames - 1) / rate``: where the signal's own time ends."""
        return float((self.n_frames - 1) / self.rate)

    @property
    def start_time(self) -> float:
        """Time of the first frame by the clock of its file, seconds; where that is not known, by its number."""
        return float(self.first_frame / self.rate if self.clock.start is None else self.clock.start)

    def __len__(self) -> int:
        return self.n_frames

    def __getitem__(self, index: slice) -> Signal:
        """Cut out frames, as `frames` does, by ``clip[start:stop]``."""
        return self.frames(*slice_range(index, self.n_frames, self.name or "the signal"))

    # Without this a loop over a clip, or np.array(clip), would ask for single frames; a clip gives ranges only.
    __iter__ = None

    def frames(self, start: int, stop: int) -> Signal:
        """Cut out frames ``start`` to ``stop - 1``, counted from 0; raise OptionError where they leave it."""
        start, stop = frame_range(start, stop, self.n_frames, self.name or "the signal")
        return replace(
            self,
            values=self.values[start:stop],
            first_frame=self.first_frame + start,
            clock=self.clock.later(start / self.rate),
        )

    def with_rate(self, rate: RateLike) -> Signal:
        """Play the same frames at another rate."""
        return replace(self, rate=rate)

    def at(self, input_times: ArrayLike) -> Signal:
        """Show any times (seconds from the first frame; held at the ends outside), each channel as its kind has it."""
        places = frame_positions(input_times, self.rate, self.n_frames)
        values = blended(self.values, self.names, self.kinds, places)
        return replace(self, values=values, first_frame=0)


def _refuse_misfits(names: Sequence[str], kinds: Sequence[ChannelKind], values: FloatArray) -> None:
    """Raise InvalidMotionError where values can't be what their kinds say."""
    for four in quaternion_groups(names, kinds):
        nothing = np.flatnonzero(np.abs(values[:, four]).max(axis=1) < 1e-12)
        if len(nothing):
            raise InvalidMotionError(
                f"channels {', '.join(names[place] for place in four)} at frame {int(nothing[0])} are all 0, which "
                "is no rotation"
            )
    for place, kind in enumerate(kinds):
        if kind.words:
            codes = values[:, place]
            wrong = np.flatnonzero(~(np.isnan(codes) | np.isin(codes, np.arange(len(kind.words)))))
            if len(wrong):
                raise InvalidMotionError(
                    f"channel {names[place]!r} at frame {int(wrong[0])} is {codes[wrong[0]]:g}, but it has "
                    f"{len(kind.words)} words, from 0"
                )


def signal_of(array: ArrayLike, rate: RateLike | None, *, call: str) -> Signal:
    """Take an array of numbers, a row a frame, for a signal; what a row holds becomes so many channels.

    Parameters
    ----------
    array : float array, shape (n_frames, ...)
        The numbers.
    rate : number or str
        Frames a second.
    call : str
        How the call is written, for messages.

    Raises
    ------
    OptionError
        No array of numbers, no frame, or no rate.
    """
    if array is None or isinstance(array, str | PathLike):
        raise OptionError(f"expected {call} with a motion, a signal, or an array of numbers; found {kind_of(array)}")
    values = as_real(array, f"the array of {call}", error=OptionError)
    if values.ndim == 0 or values.size == 0:
        raise OptionError(f"expected {call} with a row of numbers a frame; found {kind_of(array)}")
    if rate is None:
        raise OptionError(f"an array of numbers needs its rate: {call}")
    columns = values.reshape(len(values), -1)
    return Signal(numbered_names(columns.shape[1]), columns, parse_rate(rate), name="array")
