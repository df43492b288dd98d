"""What an example says of every moment of a clip: the hand's speed where the clip does the same."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from retime.arrays import BoolArray, FloatArray, IntArray
from retime.brief import brief_repr
from retime.errors import OptionError
from retime.search.estimate import check_fits, example_seconds
from retime.search.example.cover import Cover, cover_of
from retime.search.example.timing import extreme_speeds, hand_log_speeds
from retime.search.poses.references import ModelPoses, PoseTracks
from retime.warp.curve import Warp

# Medians of the distances between any two frames of the clip. Farther than this from the example a frame is not
# spoken for; from the first of the next two on its speed turns back to its own, and at the second it has it.
FAR = 0.6
_FADES, _FADED = 0.8, 1.2
# A moment that moves at less than the first share of the pace of what is nearest (or that much faster) is something
# else, however like it the pose is: a person who stands is not in the middle of a step. From the second share on it is
# the same. What moves at less than the last number's share of the clip's usual pace is idle.
_PACES, _IDLE = (0.3, 0.5), 0.1
# Share of frames that are not spoken for, from which on a person should know.
_MANY_FAR = 0.1
# All frames of another person or another take lie farther off: what counts is how much farther than the nearest tenth.
_NEAREST_SHARE = 0.1
# Gaps and stretches shorter than this, seconds, are not worth a mark.
_SHORT = 0.1
# How many times as fast as another clip a clip may be taken to move.
_MOST_TEMPO = 4.0
# Frames that a median of distances is taken over; numbers that are compared at once.
_SAMPLED, _AT_ONCE = 500, 4_000_000


@dataclass(frozen=True, eq=False)
class ExampleReading:
    """What an example says of every moment of a clip.

    Attributes
    ----------
    start, end : float
        The stretch that was retimed by hand, in seconds of the clip in which it lies.
    rate : float
        Samples a second of what follows; the first one stands at input time 0.
    log_speeds : float array, shape (n_samples,)
        Logarithm of the speed that each moment of the input should have; 0 is its own.
    distances : float array, shape (n_samples,)
        To what is nearest in the example, in medians of the distances between any two moments of the input; infinite
        where something is missing of the input.
    slowest, fastest : float
        Speeds that the hand gave; 1 lies between them.
    closed : bool
        The example's ends meet: it is a cycle by itself.
    period : float, optional
        Seconds of the cycle that was found around an example whose ends don't meet.
    tempo : float
        How many times as fast the input moves as the clip in which the example lies; 1 where it lies in the input.
    elsewhere : bool
        The example lies in another clip.
    mirrored : bool
        Its mirror image was looked at too.
    """

    start: float
    end: float
    rate: float
    log_speeds: FloatArray
    distances: FloatArray
    slowest: float
    fastest: float
    closed: bool
    period: float | None = None
    tempo: float = 1.0
    elsewhere: bool = False
    mirrored: bool = False

    __repr__ = brief_repr

    @property
    def share(self) -> float:
        """How much of the input the example speaks for, from 0 to 1."""
        return float(np.mean(self.distances <= FAR))

    @property
    def unspoken(self) -> tuple[tuple[float, float], ...]:
        """Stretches of the input (seconds) of which the example says little or nothing."""
        return tuple(
            (first / self.rate, last / self.rate) for first, last in _stretches(self.distances > FAR, self.rate)
        )

    def log_speeds_at(self, input_times: FloatArray) -> FloatArray:
        """Read `log_speeds` at input times (seconds), shape (n,)."""
        return np.interp(input_times * self.rate, np.arange(len(self.log_speeds)), self.log_speeds)

    @property
    def warnings(self) -> tuple[str, ...]:
        """What a person should know before trusting the result, in sentences."""
        said = []
        if self.elsewhere:
            pace = f", which moves {1 / self.tempo:.2g} times as fast" if abs(self.tempo - 1) > 0.05 else ""
            said.append(
                f"the example lies in another clip{pace}: what is alike in both is found by pose and pace alone, so "
                "look at the result"
            )
        if self.mirrored:
            said.append("the example's mirror image was looked at too: left and right get the same timing")
        if not self.closed and self.period is None:
            said.append(
                "the example's ends don't meet, and nothing like it was found before or after it: half a second on "
                "either side is taken to keep its speed. A whole cycle (of a walk, two steps) makes a better example"
            )
        missing = np.isinf(self.distances)
        far = (self.distances > FAR) & ~missing
        if np.mean(far) > _MANY_FAR:
            at = _where(_stretches(far, self.rate), self.rate)
            said.append(
                f"of {np.mean(far):.0%} of the clip the example says little{at}: it has nothing like that, and what "
                "is quite unlike keeps its own speed"
            )
        if gaps := _stretches(missing, self.rate):
            said.append(
                f"values of the clip are missing{_where(gaps, self.rate)}: nothing can be looked up there, so the "
                "speed goes on as beside the gap"
            )
        return tuple(said)


def read_example(
    poses: ModelPoses,
    span: tuple[float, float],
    hand: Warp,
    *,
    rate: float,
    low_pass: float,
    time_scale: float,
    n_neighbors: int,
    elsewhere: bool,
) -> ExampleReading:
    """Look up each moment of an input in the example, and take the speed that the hand gave there.

    Moments are compared at their *own* timing, by pose and velocity: the example as it was before it was retimed. So a
    hand's slowness is told from natural slowness, and the left step of a walk from the right one.

    Parameters
    ----------
    poses : ModelPoses
        Of the input; its references are the whole clip in which the example lies, and its mirror image or not.
    span : (float, float)
        First and last moment of the example, seconds.
    hand : Warp
        The example's timing; its input time 0 is the example's first moment.
    rate : float
        Analysis rate, Hz.
    low_pass : float
        Cutoff in Hz.
    time_scale : float
        τ, seconds: how much velocity weighs against pose.
    n_neighbors : int
        Frames of the example whose speeds are averaged.
    elsewhere : bool
        The example lies in another clip than the input.

    Raises
    ------
    OptionError
        Nothing of the input, or of the example, is without gaps.
    """
    pose, velocity = _motion(poses.input.at_rate(rate, low_pass), rate, time_scale)
    clips = [_motion(track.at_rate(rate, low_pass), rate, time_scale) for track in poses.references]
    # What is bridged over a gap was never there: nothing is looked up by it, or found in it.
    known = np.flatnonzero(~_lost(poses.input, len(pose), rate))
    if not len(known):
        raise OptionError(f"no moment of {poses.input.name} is without gaps: bridge them (--gaps bridge:SECONDS)")
    n_input, pose, velocity = len(pose), pose[known], velocity[known]
    own = np.concatenate([pose, velocity], axis=1)
    median = _median_distance(own)
    first, last = (round(time * rate) for time in span)
    check_fits(
        what=f"looking {len(own):,} frames up in an example of {last - first + 1:,}",
        remedy="Ask for a lower rate, or a shorter example",
        seconds=len(clips) * example_seconds(len(own), last - first + 1, own.shape[1], rate),
    )
    last = min(last, len(clips[0][0]) - 1)
    whole = np.concatenate(clips[0], axis=1)
    # A cycle is told by the clip's own measure.
    cover = cover_of(whole, first, last, rate=rate, median=_median_distance(whole) if elsewhere else median)
    there = cover.frames[~_lost(poses.references[0], len(whole), rate)[cover.frames]]
    if not len(there):
        raise OptionError("no frame of the example is without gaps: bridge them (--gaps bridge:SECONDS)")
    said = _said_by(cover, there, hand, span[0], rate)
    pool = [(shown[there], moving[there]) for shown, moving in clips]
    tempo = _tempo((pose, velocity), pool, n_neighbors) if elsewhere else 1.0
    features = np.concatenate([np.concatenate([shown, tempo * moving], axis=1) for shown, moving in pool])
    found, near = _looked_up(own, features, np.tile(said, len(pool)), n_neighbors)
    if median > 0:
        near = near / median
    faded = near - (np.quantile(near, _NEAREST_SHARE) if elsewhere else 0.0)
    found = found * np.clip((_FADED - faded) / (_FADED - _FADES), 0.0, 1.0)
    found = found * _alike_in_pace(own, velocity, features, n_neighbors)
    # Across a gap the speed goes on as beside it.
    log_speeds = np.interp(np.arange(n_input), known, found)
    distances = np.full(n_input, np.inf)
    distances[known] = near
    if not elsewhere:
        inside = np.arange(first, last + 1)
        log_speeds[inside] = hand_log_speeds(hand, inside / rate - span[0], 1 / rate)
        distances[inside] = 0.0
    slowest, fastest = extreme_speeds(said)
    return ExampleReading(
        span[0],
        span[1],
        rate,
        log_speeds,
        distances,
        slowest,
        fastest,
        cover.closed,
        None if cover.period is None else cover.period / rate,
        tempo,
        elsewhere,
        len(pool) > 1,
    )


def _lost(track: PoseTracks, n_frames: int, rate: float) -> BoolArray:
    """Tell where something is missing, or a velocity would be told by what is."""
    lost = np.zeros(n_frames, dtype=bool)
    if track.has_gaps:
        for beside in (-1, 0, 1):
            lost |= track.missing_at((np.arange(n_frames) + beside) / rate)
    return lost


def _motion(poses: FloatArray, rate: float, time_scale: float) -> tuple[FloatArray, FloatArray]:
    """Poses, and velocities times τ, of the same shape."""
    frames = np.arange(len(poses))
    before, after = np.maximum(frames - 1, 0), np.minimum(frames + 1, len(poses) - 1)
    seconds = np.maximum(after - before, 1) / rate
    return poses, time_scale * (poses[after] - poses[before]) / seconds[:, None]


def _alike_in_pace(own: FloatArray, velocity: FloatArray, features: FloatArray, n_neighbors: int) -> FloatArray:
    """Say from 0 to 1 how far the input moves at the pace of what is nearest in the example, shape (n,)."""
    speeds = np.sqrt(np.sum(velocity**2, axis=1))
    theirs = np.sqrt(np.sum(features[:, velocity.shape[1] :] ** 2, axis=1))
    near, _ = _looked_up(own, features, theirs, n_neighbors)
    # What hardly moves on either side is alike.
    least = _IDLE * math.sqrt(float(np.mean(speeds**2))) or 1.0
    pace = (speeds + least) / (near + least)
    low, high = _PACES
    return np.asarray(np.clip((np.minimum(pace, 1 / pace) - low) / (high - low), 0.0, 1.0))


def _said_by(cover: Cover, frames: IntArray, hand: Warp, start: float, rate: float) -> FloatArray:
    """Logarithms of speeds of some frames that an example is made of; 0 where nobody retimed them."""
    said = hand_log_speeds(hand, frames / rate - start, 1 / rate)
    return np.where((frames >= cover.first) & (frames <= cover.last), said, 0.0)


def _tempo(
    moves: tuple[FloatArray, FloatArray], pool: Sequence[tuple[FloatArray, FloatArray]], n_neighbors: int
) -> float:
    """Say how many times as fast a clip moves as what is nearest in pose; fast moments count more."""
    pose, velocity = moves
    speeds = np.sqrt(np.sum(velocity**2, axis=1))
    theirs = np.concatenate([np.sqrt(np.sum(moving**2, axis=1)) for _, moving in pool])
    tiny = 1e-9 * max(float(speeds.max()), float(theirs.max()), 1e-300)
    near, _ = _looked_up(pose, np.concatenate([there for there, _ in pool]), np.log(theirs + tiny), n_neighbors)
    total = float(speeds.sum())
    if total <= 0:
        return 1.0
    ratio = float(np.sum(speeds * (np.log(speeds + tiny) - near))) / total
    return math.exp(min(max(ratio, -math.log(_MOST_TEMPO)), math.log(_MOST_TEMPO)))


def _looked_up(
    points: FloatArray, others: FloatArray, values: FloatArray, n_neighbors: int
) -> tuple[FloatArray, FloatArray]:
    """Average the values at the nearest of some points, shape (n,); and the distance to the nearest one."""
    count = min(n_neighbors, len(others))
    means, nearest = np.empty(len(points)), np.empty(len(points))
    rows = max(1, _AT_ONCE // max(1, others.size))
    for begin in range(0, len(points), rows):
        some = slice(begin, begin + rows)
        apart = np.sqrt(np.sum((points[some, None, :] - others[None, :, :]) ** 2, axis=2))
        # Of two that are equally near the earlier one counts.
        order = np.argsort(apart, axis=1, kind="stable")[:, :count]
        means[some] = values[order].mean(axis=1)
        nearest[some] = apart.min(axis=1)
    return means, nearest


def _median_distance(points: FloatArray) -> float:
    """Median of the distances between any two of some points; of long clips evenly spaced ones are looked at."""
    chosen = points[np.unique(np.linspace(0, len(points) - 1, min(len(points), _SAMPLED)).round().astype(np.int64))]
    apart = [np.sqrt(np.sum((chosen - point) ** 2, axis=1)) for point in chosen]
    return float(np.median(np.concatenate(apart)))


def _where(spans: Sequence[tuple[int, int]], rate: float) -> str:
    """Name some stretches of frames in words, by their input times."""
    if not spans:
        return ""
    named = ", ".join(f"{first / rate:.2f}..{last / rate:.2f}" for first, last in spans[:4])
    more = f" and {len(spans) - 4} more" if len(spans) > 4 else ""
    return f" (input seconds {named}{more})"


def _stretches(marked: BoolArray, rate: float) -> list[tuple[int, int]]:
    """First and last frame of stretches that are marked; short gaps are bridged, short stretches left out."""
    edges = np.flatnonzero(np.diff(marked.astype(np.int8), prepend=0, append=0)).reshape(-1, 2).tolist()
    short = _SHORT * rate
    joined: list[list[int]] = []
    for first, stop in edges:
        if joined and first - joined[-1][1] < short:
            joined[-1][1] = stop
        else:
            joined.append([first, stop])
    return [(first, stop - 1) for first, stop in joined if stop - first >= short]
