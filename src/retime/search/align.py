"""align(): in step with a reference that does the same things in the same order."""

from __future__ import annotations

import math
import warnings
from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from retime.arrays import FloatArray
from retime.checks import real
from retime.errors import OptionError, RetimeWarning
from retime.kernels import StepPairs, n_threads
from retime.limits import MAX_STEP
from retime.motion.any_motion import AnyMotion
from retime.motion.contacts import runs
from retime.search import options
from retime.search.estimate import align_seconds, check_fits
from retime.search.finished_curve import finish_curve
from retime.search.keytimes import asking_for_a_share
from retime.search.methods.align import aligned_path
from retime.search.path import FramePath
from retime.search.plan import SHORTER, SearchPlan, make_plan
from retime.search.poses.references import PoseTracks, Reference
from retime.search.poses.spaces import PoseOptions, PoseSpace, Track
from retime.search.result import GuidedWarp
from retime.search.score import Model, build_model, check_table, distances_to
from retime.search.session import Session
from retime.search.stage_clock import StageClock
from retime.search.wishes.allowed import end_costs, forbid
from retime.search.wishes.locks import Lock
from retime.search.wishes.prices import add_smoothness

# Options of guided_warp that say something here too; the others are about the length, which is the reference's, and
# about looking for the reference frames that are like a frame, which here are given.
ANALYSIS = options.names("analysis", "align")
SOLVE = options.names("solve", "align")
# The reference says what is hurried, and what is not.
_NO_TEMPO = {"evenness": 0.0, "keep_flights": 0.0}
# A cycle meets where its ends are nearer than this share of the median distance between its frames.
_MEETS = 0.55
# Seconds: across a longer gap what is bridged may be far from what was there.
_LONGEST_BRIDGE = 0.2


def align(
    motion: AnyMotion | ArrayLike | Sequence[AnyMotion],
    reference: AnyMotion | ArrayLike | Reference | Sequence[AnyMotion],
    *,
    repeat: float = 1.0,
    keys: Sequence[str | Sequence[float | str | None]] = (),
    locks: Sequence[Lock | str] = (),
    speed: str | Sequence[float | str] | None = None,
    smoothness: float = 0.0,
    influence: ArrayLike = 1.0,
    rate: float | str | None = None,
    max_skip: int | None = None,
    upsample: int | None = None,
    time_scale: float = 0.2,
    low_pass: float = 4.0,
    features: PoseSpace | PoseOptions | Sequence[PoseOptions] | None = None,
    smoothing: int = 5,
) -> GuidedWarp:
    """Find the warp that keeps a motion in step with a reference.

    Both do the same things in the same order: two walks that shall go in stride, a double of an actor, a take that
    shall fit a recorded one. Output frame p is compared with reference frame p (in pose, velocity and acceleration),
    so the output takes as long as the reference, and both begin and end together. The path that is nearest in all is
    found, exactly.

    `guided_warp` asks that a motion move *like* the reference wherever that may be; this asks *when*.

    Parameters
    ----------
    motion : Motion, Signal, array of shape (n_frames, n_channels), or sequence of clips
        The input.
    reference : Motion, Signal, array, Reference, or sequence of clips
        Whose clock the output keeps; a sequence is one group, where the input is one. Its skeleton may be another. A
        `Reference` with a mirror image is followed as it is or in the mirror, whichever is nearer as a whole.
    repeat : float
        How often the reference is played, 1 or more: 6 for a cycle of a walk and six strides, 2.5 for two and a half.
        Its end is taken for its beginning, as a loop has it.
    keys, locks, speed, smoothness, influence, rate, max_skip, upsample, time_scale, low_pass, features, smoothing
        As `guided_warp` has them; a key's output time is a time of the reference.

    Returns
    -------
    GuidedWarp
        ``.warp`` is the result; in ``.explain()`` each output frame is matched with the reference frame of its time,
        and its score says how far from that it is.

    Raises
    ------
    InfeasibleWarpError
        The reference is too short or too long for the steps that are allowed, or for the keytimes; says what would do.
    OptionError
        Options that contradict each other or the data; more than one reference; a repetition below 1.

    Warns
    -----
    RetimeWarning
        A reference that is repeated does not end as it begins; or values are missing of either for a fifth of a second
        or more: there both are compared by what is bridged.

    Examples
    --------
    The same wave, in another rhythm: shown in step, the two are next to equal.

    >>> import numpy as np
    >>> t = np.arange(121) / 30
    >>> wave, late = np.sin(3 * t), np.sin(3 * (t - 0.2 * np.sin(np.pi * t / 2)))
    >>> result = align(late, wave, rate=30)
    >>> [round(float(np.abs(shown - wave).mean()), 2) for shown in (late, result.apply().values[:, 0])]
    [0.23, 0.01]
    """
    given = locals()
    session = AlignSession(motion, reference, repeat=repeat, **{name: given[name] for name in ANALYSIS})
    return session.solve(keys=keys, locks=locks, **{name: given[name] for name in SOLVE})


class AlignSession(Session):
    """A motion and the reference that it is to keep step with, analysed; `solve` finds warps.

    Parameters
    ----------
    motion, reference, repeat
        As `align` has them.
    **given
        Its options that don't depend on keytimes: `ANALYSIS`.

    Examples
    --------
    >>> t = np.arange(121) / 30
    >>> session = AlignSession(np.sin(3 * t**2 / 4), np.sin(3 * t), rate=30)
    >>> [round(float(session.solve(keys=[(2.0, to)]).warp(to)), 6) for to in (0.9, 1.0, 1.1)]
    [2.0, 2.0, 2.0]
    """

    def __init__(
        self,
        motion: AnyMotion | ArrayLike | Sequence[AnyMotion],
        reference: AnyMotion | ArrayLike | Reference | Sequence[AnyMotion],
        *,
        repeat: float = 1.0,
        **given: Any,
    ) -> None:
        options.refuse_unknown(given, ANALYSIS)
        if reference is None:
            raise OptionError("there is nothing to keep step with: give a reference", option="reference")
        super().__init__(motion, reference=reference, n_neighbors=1, **given)
        # One that is the input itself is a reference like any other here.
        self.itself = False
        self.repeat = real(repeat, "repeat", option="repeat")
        if not 1 <= self.repeat < math.inf:
            raise OptionError(
                f"the reference is played once or more often: repeat is at least 1, found {repeat}", option="repeat"
            )
        named = sorted({track.name for track in self._reference_tracks if not track.mirrored})
        if sum(not track.mirrored for track in self._reference_tracks) != 1:
            raise OptionError(
                f"only one reference can be kept step with; found {len(named)}: {', '.join(named)}", option="reference"
            )
        seconds = self.repeat * self._reference_tracks[0].end_time
        if seconds > MAX_STEP * self.motion.duration:
            # Said before as many frames of the reference are made, which may be more than memory holds.
            raise OptionError(
                f"played {self.repeat:g} times the reference lasts {seconds:g} s, and the clip "
                f"{self.motion.duration:g} s: nothing is played at less than 1/{MAX_STEP} of its speed",
                option="repeat",
            )
        for track in (self._tracks, self._reference_tracks[0]):
            _warn_of_gaps(track, self.rate)
        if self.repeat > 1:
            self._reference_tracks = tuple(_repeated(track, self.repeat) for track in self._reference_tracks)
        self.length = 1 + round(self._reference_tracks[0].end_time * float(self.motion.rate))

    def solve(
        self, *, keys: Sequence[str | Sequence[float | str | None]] = (), locks: Sequence[Lock | str] = (), **given: Any
    ) -> GuidedWarp:
        """Find the warp.

        Parameters
        ----------
        keys, locks
            As `align` has them.
        **given
            Its other options: `SOLVE`.

        Raises
        ------
        InfeasibleWarpError, OptionError
            As `align`.
        """
        clock = StageClock()
        options.refuse_unknown(given, SOLVE)
        chosen = options.completed("solve", given | {"length": f"{self.length}f", **_NO_TEMPO})
        request = self._request(keys, locks, chosen)
        with asking_for_a_share(self.motion, chosen["length"]):
            plan = make_plan(request, rate=self.rate, itself=False)
        seconds = dict(self._analysis_seconds)
        poses = self._tracks.at(plan.reduction.input_times, self.low_pass)
        models = [self._clocked(track, plan) for track in self._reference_tracks]
        seconds["scores"] = clock.lap()
        paths = [self._in_step(plan, poses, model, chosen["smoothness"]) for model in models]
        best = min(range(len(paths)), key=lambda which: paths[which].total)
        path = paths[best]
        reduction = plan.finished(path.frames)
        seconds["path"] = clock.lap()
        curve = finish_curve(plan, reduction, path, chosen, analysis_rate=self.rate, tempo=None)
        seconds["curve"] = clock.lap()
        return GuidedWarp(
            warp=replace(curve.warp, method="align"),
            staircase=replace(curve.staircase, method="align"),
            given_up=curve.given_up,
            path=path,
            plan=plan,
            tempo=None,
            tempo_prices=None,
            reduction=reduction,
            model=models[best],
            references=(self.references[best],),
            input_poses=poses,
            n_reference=plan.reduction.n_output,
            n_neighbors=1,
            time_scale=self.time_scale,
            low_pass=self.low_pass,
            score=self.score,
            clips=self.clips,
            matched=np.arange(len(path.frames) - 2),
            seconds=seconds,
        )

    def _clocked(self, track: PoseTracks, plan: SearchPlan) -> Model:
        """Read a reference at the times of the output's frames."""
        times = np.arange(plan.reduction.n_output) / self.rate
        return build_model([track.at(times, self.low_pass)], rate=self.rate, time_scale=self.time_scale, n_neighbors=1)

    def _in_step(self, plan: SearchPlan, poses: FloatArray, model: Model, smoothness: float) -> FramePath:
        """Find the best path in step with one reference."""
        # Any step may follow any: the reference says how its speed changes.
        steps = StepPairs.of(plan.steps.steps)
        check_table(len(poses), steps)
        # Each position has costs of its own.
        check_fits(
            what=f"keeping {len(poses):,} frames in {steps.n_pairs} pairs of steps in step with "
            f"{len(model.features):,} frames of reference",
            remedy=SHORTER,
            # Prices, and the costs of one position at least.
            n_bytes=8.0 * 2 * len(poses) * steps.n_pairs,
            seconds=len(self._reference_tracks)
            * align_seconds(plan.anchors, steps.longest, steps.n_pairs, model.n_numbers, n_threads()),
        )
        prices = np.zeros((len(poses), steps.n_pairs))
        add_smoothness(prices, smoothness, plan.reduction, steps, unit=_even_score(plan, poses, model))
        forbid(prices, plan.allowed, steps)
        start, end = end_costs(plan.allowed, steps)
        return aligned_path(poses, model, prices, steps=steps, anchors=plan.anchors, start_cost=start, end_cost=end)


def _warn_of_gaps(track: PoseTracks, rate: float) -> None:
    """Warn where values are missing for longer than they can be bridged without a doubt."""
    missing = track.missing_at(np.arange(track.count_at(rate)) / rate) if track.has_gaps else np.zeros(0, dtype=bool)
    spans = [(first / rate, stop / rate) for first, stop in runs(missing) if stop - first > _LONGEST_BRIDGE * rate]
    if spans:
        where = ", ".join(f"{start:.2f}..{end:.2f}" for start, end in spans[:4])
        more = f" and {len(spans) - 4} more" if len(spans) > 4 else ""
        warnings.warn(
            f"{track.name} misses values for {sum(end - start for start, end in spans):.1f} s (seconds {where}{more}). "
            "Each moment is kept in step with one, so there it goes by what is bridged over the gap: look at the "
            "result, or put keytimes beside it",
            RetimeWarning,
            stacklevel=4,
        )


def _even_score(plan: SearchPlan, poses: FloatArray, model: Model) -> float:
    """Return the median score of playing evenly between the keytimes: what a change of speed is charged in."""
    positions, frames = zip(*plan.anchors, strict=True)
    evenly = np.round(np.interp(np.arange(positions[-1] + 1), positions, frames)).astype(np.int64)
    return float(np.median(distances_to(poses, evenly, model, np.arange(len(evenly) - 2))))


def _repeated(poses: PoseTracks, repeat: float) -> PoseTracks:
    """Play a reference again and again, as a loop: its last frame is its first."""
    for track in poses.tracks:
        first, last = track.vectors[0], track.vectors[-1]
        usual = np.linalg.norm(track.vectors - np.median(track.vectors, axis=0), axis=1)
        # Frames about a middle are as far from one another as from it, times the root of two.
        apart = float(np.linalg.norm(last - first)) / max(math.sqrt(2) * float(np.median(usual)), 1e-300)
        if apart > _MEETS:
            warnings.warn(
                f"{poses.name} is repeated, but does not end as it begins (its ends are {apart:.2f} times as far apart "
                "as its frames usually are): cut it to whole cycles, from one moment of the movement to the same one",
                RetimeWarning,
                stacklevel=4,
            )
    return replace(poses, tracks=tuple(_again(track, repeat) for track in poses.tracks))


def _again(track: Track, repeat: float) -> Track:
    n_steps = len(track.vectors) - 1
    places = np.arange(round(n_steps * repeat) + 1)
    # The seam is seen once: as the first frame, of which the last is another take.
    return Track(np.ascontiguousarray(track.vectors[places % n_steps]), track.rate)
