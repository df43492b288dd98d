"""Figures of merit: numbers that say how a retimed motion turned out.

Each looks at a warp, at a motion, or at both; none knows how the warp was found. Times are seconds, lengths metres,
by the motion's own scale (`retime.motion.kinematics.metres_per_unit`). docs/study says in words what each one means
and what it is good for.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from retime.errors import OptionError
from retime.evaluate.strip import output_intervals
from retime.motion.contacts import Contacts, contacts
from retime.motion.contacts import slip as contact_slip
from retime.motion.kinematics import flights, global_poses, metres_per_unit, torso_positions
from retime.motion.motion import Motion
from retime.motion.rotation import FloatArray
from retime.motion.signal import Signal
from retime.warp.curve import Keytime, Warp, output_frame_times
from retime.warp.features import PoseOptions, PoseSpace, timing_features
from retime.warp.reference import Reference, model_poses
from retime.warp.result import GuidedWarp
from retime.warp.session import DEFAULT_TIME_SCALE

Spans = Sequence[tuple[float, float]]
"""Stretches of a clip: start and end, seconds."""

ANALYSIS_RATE = 30.0
"""Hz: the paper's."""

# A step of the search at unit speed is exact in floating point; what smoothing leaves of it differs by rounding alone.
_UNIT = 1e-6
# Seconds to either side: over one frame of 120 Hz, capture noise alone makes a tenth of a metre a second.
_SPEED_WINDOW = 1 / 30
# Speeds beyond these are holds and cuts: their logarithms would drown all others.
_LOG_LIMITS = (1 / 20, 20.0)


def flight_spans(motion: Motion, *, clearance: float = 0.05) -> tuple[tuple[float, float], ...]:
    """Input times between which a figure flies, seconds, for every flight (see `retime.motion.kinematics.flights`).

    Parameters
    ----------
    motion : Motion
        Y up.
    clearance : float
        Metres that everything is off the ground, at least.
    """
    rate = float(motion.rate)
    return tuple((first / rate, last / rate) for first, last in flights(motion, clearance=clearance))


def idle_spans(
    motion: Motion, *, root_speed: float = 0.2, joint_speed: float = 0.1, minimum: float = 0.25
) -> tuple[tuple[float, float], ...]:
    """Find stretches in which a figure stands still.

    Parameters
    ----------
    motion : Motion
        The input.
    root_speed : float
        Metres a second that the root stays below.
    joint_speed : float
        Metres a second that the other joints stay below, against the root, on average.
    minimum : float
        Shortest stretch, seconds.

    Returns
    -------
    tuple of (float, float)
        Input times, seconds.
    """
    rate = float(motion.rate)
    root, joints = _speeds(motion)
    still = (root < root_speed) & (joints < joint_speed)
    edges = np.flatnonzero(np.diff(np.concatenate([[0], still.astype(np.int8), [0]])))
    spans = [(first / rate, (stop - 1) / rate) for first, stop in edges.reshape(-1, 2).tolist()]
    return tuple(span for span in spans if span[1] - span[0] >= minimum)


def activity(motion: Motion) -> FloatArray:
    """How fast a figure moves in each frame: root, and mean joint against the root, together; metres a second."""
    root, joints = _speeds(motion)
    return root + joints


def _speeds(motion: Motion) -> tuple[FloatArray, FloatArray]:
    """Speed of the root, and mean speed of the other joints in its space, metres a second; shape (n_frames,) each."""
    scale, rate = metres_per_unit(motion), float(motion.rate)
    poses = global_poses(motion)
    frames = np.arange(motion.n_frames)
    lag = max(1, round(_SPEED_WINDOW * rate))
    before, after = np.maximum(frames - lag, 0), np.minimum(frames + lag, motion.n_frames - 1)
    seconds = np.maximum(after - before, 1) / rate
    inner = torso_positions(poses)
    root = np.linalg.norm(poses.positions[after, 0] - poses.positions[before, 0], axis=-1)
    joints = np.linalg.norm(inner[after] - inner[before], axis=-1).mean(axis=-1)
    return root * scale / seconds, joints * scale / seconds


def seconds_shown(warp: Warp, spans: Spans) -> float:
    """Return for how many seconds of output a warp shows some stretches of the input.

    Examples
    --------
    >>> seconds_shown(Warp([0.0, 2.0], [0.0, 4.0]), [(1.0, 2.0)])
    0.5
    """
    return sum(stop - start for span in spans for start, stop in output_intervals(warp, *span))


def fastest_speed(warp: Warp, *, rate: float = ANALYSIS_RATE) -> float:
    """Return the most input that a warp shows in one analysis period, as a speed: how much of the content is rushed.

    The paper forbids to go past `max_skip` (§3.1): a cut has no such bound.

    Examples
    --------
    >>> round(fastest_speed(Warp([0.0, 1.0, 1.1, 2.0], [0.0, 1.0, 4.0, 5.0])), 2)
    30.0
    """
    starts = np.unique(np.concatenate([warp.output_times, warp.output_times - 1 / rate]))
    starts = starts[(starts >= warp.output_start) & (starts <= warp.output_end - 1 / rate)]
    if not len(starts):
        return float(abs(warp.input_times[-1] - warp.input_times[0]) / warp.output_span)
    return float(np.max(np.abs(warp(starts + 1 / rate) - warp(starts)))) * rate


@dataclass(frozen=True)
class FlightTiming:
    """How flights are played.

    Attributes
    ----------
    n_frames : int
        Analysis periods that lie wholly in a flight of the input: what there was to keep.
    n_kept : int
        Those of them that are played at exactly unit speed from end to end.
    n_flights : int
        Flights of the input.
    n_flights_kept : int
        Flights of which every such period was kept.
    slowest, fastest : float
        Mean speeds of the slowest and of the fastest flight; 1 where there is none.
    """

    n_frames: int
    n_kept: int
    n_flights: int
    n_flights_kept: int
    slowest: float
    fastest: float


def path_warp(found: GuidedWarp) -> Warp:
    """Return the path that a search found as a warp, on the analysis grid: what it decided, before all that follows.

    (`GuidedWarp.steps` meets ends and keytimes that lie between frames of the grid, so its speeds may be a little off.)
    """
    times = np.arange(found.n_output) / found.rate
    return Warp(times, found.reduction.input_times[found.path.frames], method="guided")


def flight_timing(warp: Warp, spans: Spans, *, rate: float = ANALYSIS_RATE) -> FlightTiming:
    """Count in-flight frames at exactly unit speed.

    What is counted is frames of the *input*: a flight that the warp rushes through in one step loses all of its frames.
    (Counted among the output's frames it would lose one.)

    Parameters
    ----------
    warp : Warp
        Plays every flight at most once.
    spans : sequence of (float, float)
        Flights of the input, seconds.
    rate : float
        Analysis rate, Hz.

    Examples
    --------
    A flight of a third of a second; its last third is played at twice the speed.

    >>> warp = Warp([0.0, 11 / 90, 20 / 90], [0.0, 11 / 90, 29 / 90])
    >>> flight_timing(warp, [(0.0, 1 / 3)]).n_kept, flight_timing(warp, [(0.0, 1 / 3)]).n_frames
    (3, 10)
    """
    low = np.minimum(warp.input_times[:-1], warp.input_times[1:])
    high = np.maximum(warp.input_times[:-1], warp.input_times[1:])
    off = np.abs(warp.slopes - 1.0) > _UNIT
    n_frames = n_kept = n_flights_kept = 0
    speeds = []
    for start, end in spans:
        first, last = math.ceil(start * rate - 1e-6), math.floor(end * rate + 1e-6)
        kept = 0
        for period in range(first, last):
            a, b = period / rate, (period + 1) / rate
            # A hold belongs to the period that begins where it stands.
            touching = (high > a + 1e-7 * (high > low) - 1e-7 * (high == low)) & (low < b - 1e-7)
            kept += bool(touching.any() and not (touching & off).any())
        n_frames += max(0, last - first)
        n_kept += kept
        n_flights_kept += kept == max(0, last - first)
        shown = seconds_shown(warp, [(start, end)])
        speeds.append((end - start) / shown if shown > 0 else math.inf)
    return FlightTiming(
        n_frames, n_kept, len(spans), n_flights_kept, min(speeds, default=1.0), max(speeds, default=1.0)
    )


def gravity(motion: Motion, spans: Spans) -> FloatArray:
    """Acceleration of fall that a motion's flights imply: a parabola fitted to the mean height of the joints.

    The joints' mean is not the body's centre of mass, so even a capture does not say 9.81. What a warp did shows in the
    ratio of the output's value to the input's: played c times faster, a flight falls c² times harder.

    Parameters
    ----------
    motion : Motion
        Y up.
    spans : sequence of (float, float)
        Its flights, in its own time, seconds.

    Returns
    -------
    float array, shape (n_spans,)
        Metres per second squared, downward; NaN where a flight has fewer than 4 frames.
    """
    rate = float(motion.rate)
    height = global_poses(motion).positions[:, :, 1].mean(axis=1) * metres_per_unit(motion)
    found = np.full(len(spans), np.nan)
    for i, (start, end) in enumerate(spans):
        first, last = math.ceil(start * rate - 1e-6), min(math.floor(end * rate + 1e-6), motion.n_frames - 1)
        if last - first >= 3:
            times = np.arange(first, last + 1) / rate
            found[i] = -2 * np.polynomial.polynomial.polyfit(times - times.mean(), height[first : last + 1], 2)[2]
    return found


def gravity_ratios(motion: Motion, output: Motion, warp: Warp, spans: Spans) -> FloatArray:
    """Gravity in the output's flights over gravity in the input's, shape (n_spans,); 1 is as captured.

    NaN where the output has too few frames of a flight to tell.
    """
    shown = [next(iter(output_intervals(warp, *span)), (0.0, 0.0)) for span in spans]
    return np.asarray(gravity(output, shown) / gravity(motion, spans))


@dataclass(frozen=True)
class FootSlip:
    """How far feet slide while they stand, millimetres.

    Attributes
    ----------
    mean, largest : float
        Of all contacts.
    n_contacts : int
        How many contacts there are.
    """

    mean: float
    largest: float
    n_contacts: int


def foot_slip(motion: Motion, output: Motion, warp: Warp, *, standing: Contacts | None = None) -> FootSlip:
    """Measure how far the output's feet slide while the input's stand (see `retime.motion.contacts`).

    The contacts are the input's, carried over by the warp: a foot that stood there should stand in the output.

    Parameters
    ----------
    motion, output : Motion
        Before and after.
    warp : Warp
        What made one the other.
    standing : Contacts, optional
        The input's, where they are known already.
    """
    standing = contacts(motion) if standing is None else standing
    standing = standing.at(warp(output_frame_times(warp, float(output.rate))))
    found = contact_slip(output, standing)
    return FootSlip(found.mean, found.largest, len(found.contacts))


def rms_jerk(motion: Motion, *, rate: float = ANALYSIS_RATE) -> float:
    """Root mean square of the joints' jerk, metres per second cubed: third differences at the analysis rate.

    Over shorter times the noise of a capture would be all that it measures. 0 where the motion is shorter than four
    analysis frames.
    """
    times = np.arange(math.floor(motion.end_time * rate + 1e-6) + 1) / rate
    if len(times) < 4:
        return 0.0
    positions = global_poses(motion.at(times)).positions * metres_per_unit(motion)
    third = np.diff(positions, n=3, axis=0) * rate**3
    return float(np.sqrt(np.mean(np.sum(third * third, axis=-1))))


def timing_distance(
    motion: Motion | Signal,
    reference: Motion | Signal | Reference,
    *,
    features: PoseSpace | PoseOptions | None = None,
    rate: float = ANALYSIS_RATE,
    time_scale: float = DEFAULT_TIME_SCALE,
    low_pass: float = 4.0,
    n_neighbors: int = 3,
) -> float:
    """Distance of a motion's local timing to a reference's: Eq. 2 of its own consecutive frames, averaged.

    It is measured on a motion as it will be seen, whatever made it, after all smoothing and averaging; so it compares
    methods that never knew an objective.

    Returns
    -------
    float
        The mean over frames. For a motion in metres, root mean square over the joints; velocity and acceleration count
        as in Eq. 2, times τ and τ².

    Raises
    ------
    OptionError
        Either of them is too short.
    """
    tracks = model_poses(motion, [reference if isinstance(reference, Reference) else Reference(reference)], features)
    poses = tracks.input.at_rate(rate, low_pass)
    shortest = min(len(poses), *(len(track.at_rate(rate, low_pass)) for track in tracks.references))
    if shortest < 3:
        raise OptionError(f"a timing needs three analysis frames or more; found {shortest}")
    shape: dict[str, float] = {"rate": rate, "time_scale": time_scale}
    wanted = [timing_features(track.at_rate(rate, low_pass), **shape) for track in tracks.references]
    distances = _nearest_distances(timing_features(poses, **shape), np.concatenate(wanted), n_neighbors)
    scale = metres_per_unit(motion) if isinstance(motion, Motion) else 1.0
    coordinates = 3 if isinstance(motion, Motion) else 1
    return float(distances.mean()) * scale / math.sqrt(tracks.input.n_numbers / coordinates)


def _nearest_distances(here: FloatArray, there: FloatArray, n_neighbors: int) -> FloatArray:
    """Distances from each row to the nearest rows of another array; shape (n, n_neighbors)."""
    origin = there.mean(axis=0)
    here, there = here - origin, there - origin
    squares = np.sum(here**2, axis=1)[:, None] + np.sum(there**2, axis=1) - 2 * here @ there.T
    n_found = min(n_neighbors, len(there))
    nearest = np.partition(squares, n_found - 1, axis=1)[:, :n_found]
    return np.sqrt(np.maximum(nearest, 0.0))


def joint_speeds(motion: Motion, joints: Sequence[str], *, rate: float = ANALYSIS_RATE) -> FloatArray:
    """Speeds of some joints over the ground, between neighbouring analysis frames, all in one row; metres a second."""
    times = np.arange(math.floor(motion.end_time * rate + 1e-6) + 1) / rate
    places = [motion.skeleton.index(name) for name in joints]
    positions = global_poses(motion.at(times)).positions[:, places] * metres_per_unit(motion)
    return np.asarray(np.linalg.norm(np.diff(positions, axis=0), axis=-1).ravel() * rate)


SPEED_QUANTILES = (0.5, 0.9, 0.99)


@dataclass(frozen=True)
class SpeedMatch:
    """How one distribution of speeds lies to another.

    Attributes
    ----------
    quantiles : tuple of float
        The 50th, 90th and 99th percentile, metres a second.
    wanted : tuple of float
        The same of the distribution that is wanted.
    distance : float
        By how many metres a second a speed must change, on average, to make one distribution the other (Wasserstein).
    """

    quantiles: tuple[float, ...]
    wanted: tuple[float, ...]
    distance: float


def match_speeds(speeds: ArrayLike, wanted: ArrayLike) -> SpeedMatch:
    """Compare speeds with those that are wanted.

    Examples
    --------
    >>> match_speeds([1.0, 2.0, 3.0], [2.0, 3.0, 4.0]).distance
    1.0
    """
    a, b = np.sort(np.asarray(speeds, dtype=np.float64)), np.sort(np.asarray(wanted, dtype=np.float64))
    # The area between the two distribution functions.
    together = np.sort(np.concatenate([a, b]))
    shares = [np.searchsorted(one, together[:-1], side="right") / len(one) for one in (a, b)]
    distance = float(np.sum(np.abs(shares[0] - shares[1]) * np.diff(together)))
    found = [tuple(float(q) for q in np.quantile(one, SPEED_QUANTILES)) for one in (a, b)]
    return SpeedMatch(found[0], found[1], distance)


@dataclass(frozen=True)
class WarpMatch:
    """How close a warp comes to the one that is known to be right.

    Attributes
    ----------
    mean_error, largest_error : float
        Analysis frames by which poses come too early or too late in the output.
    correlation : float
        Of the logarithms of playback speed, moment by moment of the input; NaN where one of them never changes.
    log_speed_error : float
        Root mean square difference of those logarithms: 0.1 is 10 % too fast or too slow.
    length_ratio : float
        Length of the output over the right one.
    """

    mean_error: float
    largest_error: float
    correlation: float
    log_speed_error: float
    length_ratio: float


def match_warps(
    warp: Warp, truth: Warp, *, rate: float = ANALYSIS_RATE, window: float = 0.1, spans: Spans | None = None
) -> WarpMatch:
    """Compare a warp with the one that is known to be right, at the same moments of the input.

    Parameters
    ----------
    warp, truth : Warp
        Forward warps of one clip; `warp` may hold and cut.
    rate : float
        Analysis rate: input times at which they are compared, and the unit of the errors.
    window : float
        Seconds of input over which a speed is taken.
    spans : sequence of (float, float), optional
        Input times to look at; left out, all. Errors in time are then counted from the start of each span.

    Examples
    --------
    >>> match_warps(Warp([0.0, 2.0], [0.0, 1.0]), Warp([0.0, 1.0], [0.0, 1.0])).largest_error
    30.0
    """
    start, end = float(truth.input_times[0]), float(truth.input_times[-1])
    errors, logs = [], []
    for low, high in [(start, end)] if spans is None else spans:
        times = np.linspace(low, high, max(2, round((high - low) * rate) + 1))
        apart = _times_shown(warp, times) - _times_shown(truth, times)
        errors.append(np.abs(apart - (0.0 if spans is None else apart[0])) * rate)
        a, b = np.maximum(times - window / 2, start), np.minimum(times + window / 2, end)
        logs.append([_log_speeds(one, a, b) for one in (warp, truth)])
    error = np.concatenate(errors)
    found, wanted = np.concatenate([pair[0] for pair in logs]), np.concatenate([pair[1] for pair in logs])
    varies = np.ptp(found) > 1e-9 and np.ptp(wanted) > 1e-9
    return WarpMatch(
        float(error.mean()),
        float(error.max()),
        float(np.corrcoef(found, wanted)[0, 1]) if varies else math.nan,
        float(np.sqrt(np.mean((found - wanted) ** 2))),
        warp.output_span / truth.output_span,
    )


def _times_shown(warp: Warp, input_times: FloatArray) -> FloatArray:
    """Output time of input times; in the middle of a hold."""
    first = np.searchsorted(warp.input_times, input_times, side="left")
    times = np.interp(input_times, warp.input_times, warp.output_times)
    there = first < len(warp.input_times)
    held = np.flatnonzero(there & (warp.input_times[np.minimum(first, len(warp.input_times) - 1)] == input_times))
    last = np.searchsorted(warp.input_times, input_times, side="right") - 1
    times[held] = (warp.output_times[first[held]] + warp.output_times[last[held]]) / 2
    return np.asarray(times)


def _log_speeds(warp: Warp, a: FloatArray, b: FloatArray) -> FloatArray:
    shown = _times_shown(warp, b) - _times_shown(warp, a)
    return np.log(np.clip((b - a) / np.maximum(shown, 1e-9), *_LOG_LIMITS))


@dataclass(frozen=True)
class KeytimeMatch:
    """Whether a warp does what its keytimes say.

    Attributes
    ----------
    n_keytimes : int
        How many there are, ends included.
    largest_error : float
        Seconds of input by which the worst one is missed.
    """

    n_keytimes: int
    largest_error: float


def match_keytimes(warp: Warp, keytimes: Sequence[Keytime]) -> KeytimeMatch:
    """Measure how far a warp misses keytimes; an output that is too short or too long misses its last."""
    errors = [abs(float(warp(key.output_time)) - key.input_time) for key in keytimes]
    errors += [abs(warp.output_end - max(key.output_time for key in keytimes))] if keytimes else []
    return KeytimeMatch(len(keytimes), max(errors, default=0.0))
