"""Plain named channels: a motion with no skeleton (a camera path, a curve, markers)."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from fractions import Fraction

import numpy as np
from numpy.typing import ArrayLike

from retime.errors import InvalidMotionError, OptionError
from retime.motion.motion import frame_positions
from retime.motion.rotation import FloatArray
from retime.motion.size import size_problem, within_size


@dataclass(frozen=True, eq=False)
class Signal:
    """Named columns of numbers at an exact rate.

    Parameters
    ----------
    names : tuple of str
        One for each channel.
    values : float array, shape (n_frames, n_channels)
        The numbers, in whatever unit they have.
    rate : Fraction
        Frames a second, exact.
    name : str
        What to call it in messages and plots.
    time_column : str
        The column that held time in its file, "" if there was none; written again on export.
    first_frame : int
        The number of the first frame.

    Raises
    ------
    InvalidMotionError
        No frame, no channel, shapes that disagree, or a number that is not finite or beyond 1e100 (named by channel and
        frame).
    """

    names: tuple[str, ...]
    values: FloatArray
    rate: Fraction = field(default=Fraction(30))
    name: str = ""
    time_column: str = ""
    first_frame: int = 0

    def __post_init__(self) -> None:
        values = np.asarray(self.values, dtype=np.float64)
        if values.ndim != 2 or 0 in values.shape or values.shape[1] != len(self.names):
            raise InvalidMotionError(
                f"expected values of shape (n_frames >= 1, {len(self.names)} named channels), found {values.shape}"
            )
        if not within_size([values.min(), values.max()]).all():
            frame, channel = (int(i) for i in np.argwhere(~within_size(values))[0])
            problem = size_problem(values[frame, channel])
            raise InvalidMotionError(f"channel {self.names[channel]!r} at frame {frame} {problem}")
        if not (isinstance(self.rate, Fraction) and self.rate > 0):
            raise InvalidMotionError(f"expected an exact rate above 0 (a Fraction), found {self.rate!r}")
        view = values.view()
        view.setflags(write=False)
        object.__setattr__(self, "values", view)

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

    def frames(self, start: int, stop: int) -> Signal:
        """Cut out frames ``start`` to ``stop - 1``, counted from 0; raise OptionError where they leave it."""
        if not 0 <= start < stop <= self.n_frames:
            raise OptionError(
                f"frames {start} to {stop - 1} are not inside {self.name or 'the signal'}, which has frames 0 to "
                f"{self.n_frames - 1}"
            )
        return replace(self, values=self.values[start:stop], first_frame=self.first_frame + start)

    def with_rate(self, rate: Fraction) -> Signal:
        """Play the same frames at another rate."""
        return replace(self, rate=rate)

    def at(self, input_times: ArrayLike) -> Signal:
        """Sample linearly at any times (seconds from the first frame; held at the ends outside)."""
        before, after, fraction = frame_positions(input_times, self.rate, self.n_frames)
        values = self.values[before] + fraction[:, None] * (self.values[after] - self.values[before])
        return replace(self, values=values, first_frame=0)
