"""Propagation: a stretch of a clip is retimed by hand, and the rest of the clip follows (§4.2)."""

from __future__ import annotations

import math
import warnings
from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from retime.brief import kind_of
from retime.errors import OptionError, RetimeWarning
from retime.motion.any_motion import AnyMotion
from retime.motion.rate import parse_rate
from retime.motion.signal import Signal
from retime.search import options as declared
from retime.search.example.reading import read_example
from retime.search.example.session import HandSession
from retime.search.grid import DEFAULT_MAX_SKIP, usual_upsample
from retime.search.guided import guided_warp
from retime.search.inputs import as_clips, as_references, check_rates
from retime.search.poses.references import Reference, model_poses
from retime.search.result import GuidedWarp
from retime.search.session import DEFAULT_RATE
from retime.warp.apply import apply_warp
from retime.warp.curve import Warp, WarpLike, as_warp

# A hand's speeds are looked up, not searched for: there is less to smooth than in a path of scores.
SMOOTHING = 3
# Options of guided_warp that say how its scores are made or weighed: there are none here.
_OF_SCORES = tuple(option.name for option in declared.OPTIONS if "hand" not in option.methods)
# Options of guided_warp that need speeds of their own, or say which.
_BOUND_SPEEDS = ("speed", "upsample", "max_skip", "keys", "locks", "min_length", "max_length")
# The table of scores grows with the square of max_skip.
_MOST_UPSAMPLE, _MOST_SKIP = 16, 48


def imitate(
    motion: AnyMotion | ArrayLike | Sequence[AnyMotion],
    example: tuple[int, int],
    hand: WarpLike,
    *,
    example_clip: AnyMotion | Reference | Sequence[AnyMotion] | None = None,
    paper: bool = False,
    length: str | float | None = "free",
    **options: Any,
) -> GuidedWarp:
    """Find the warp that gives a whole clip the timing that a stretch of it was given by hand.

    The *hand's speed* is carried over: each moment of the clip is looked up in the example as it was before it was
    retimed, and plays as fast as the hand played what it found. So a slow walk that is made to limp limps, and gets no
    slower; the left step is told from the right one, also where only one of them is in the example; and what nothing
    in the example is like keeps its own speed. The result says how much of the clip the example speaks for
    (`GuidedWarp.example`).

    The search stays exact, and keytimes, locks, tangents and limits hold: it finds the path whose speeds are nearest
    to the hand's.

    Parameters
    ----------
    motion : Motion, Signal, array, or sequence of clips
        The input. Several clips that move together get one warp, as with `retime.guided_warp`.
    example : (int, int)
        The stretch: first frame and the one after its last, counted from 0, as in ``motion.frames(start, stop)``; of
        several clips in the first one.
    hand : Warp or GuidedWarp
        Its timing, found by whatever means. Input time 0 is the stretch's first frame.
    example_clip : Motion, Signal, Reference, or sequence of clips, optional
        Where the example lies in another clip: that clip, whole. A `Reference` may ask for its mirror image, and say
        which joint is which. Left out: the input.
    paper : bool
        The paper's way: the stretch, retimed, is the reference, and the clip moves like it, with its *absolute*
        speeds. Its frames are not averaged where the hand's warp is fast: the reference is looked at, not shown.
        Where nothing else bounds them, the search is offered the hand's speeds.
    length : str, float or None
        As `guided_warp` has it; "free" where left out, for the hand's warp says how fast, not how long.
    **options
        The other options of `guided_warp`, but for `reference`. Those that weigh its scores (`score`, `free_weight`,
        `evenness`, `keep_flights`, `content`, `ends`, `own_timing`, `match_tempo`, the heuristic search) need `paper`.

    Returns
    -------
    GuidedWarp
        For the whole of `motion`.

    Warns
    -----
    RetimeWarning
        Much of the clip is unlike the example, the example is no cycle and none was found around it, or it lies
        elsewhere.

    Raises
    ------
    OptionError
        The stretch leaves the clip, the hand's warp leaves the stretch, or an option is wrong.
    InfeasibleWarpError
        No warp meets the keytimes within the limits.

    Examples
    --------
    A swing of one second, played by hand at half its speed; the other seven follow.

    >>> import numpy as np
    >>> from fractions import Fraction
    >>> t = np.arange(8 * 30 + 1) / 30
    >>> swing = Signal(("x", "y"), np.stack([np.sin(2 * np.pi * t), np.cos(2 * np.pi * t)], axis=1), Fraction(30))
    >>> slow = imitate(swing, (0, 31), Warp([0.0, 2.0], [0.0, 1.0]))
    >>> round(float(np.median(slow.warp.slopes)), 2)
    0.5
    >>> slow.example.share
    1.0
    """
    if isinstance(motion, Warp | GuidedWarp):
        raise OptionError(
            f"expected imitate(motion, (start, stop), warp) with a motion or a signal, found {kind_of(motion)}"
        )
    if not isinstance(example, Sequence) or isinstance(example, str) or len(example) != 2:
        raise OptionError(f"the example is (first frame, the one after its last), found {kind_of(example)}")
    hand = as_warp(hand, "imitate(motion, (start, stop), warp)")
    clips = as_clips(motion, options.get("rate"))
    reference = _whole_reference(clips, example_clip, options.get("rate"))
    elsewhere = any(one is not other for one, other in zip(reference.clips, clips, strict=False))
    stretch, span = _stretch(reference.clips, example)
    _check_hand(hand, stretch[0], span, example)
    if paper:
        retimed = [_by_hand(clip, hand) for clip in stretch]
        if length == "free" and all(options.get(name) in (None, (), []) for name in _BOUND_SPEEDS):
            options |= _room_for(hand, clips[0].end_time)
        given = replace(reference, motion=retimed if len(retimed) > 1 else retimed[0])
        return guided_warp(clips, reference=given, length=length, paper=True, **options)
    _refuse_score_options(options)
    analysis = {name: options.pop(name) for name in declared.names("analysis") if name in options}
    flights = options.pop("flights", None)
    chosen = declared.completed("analysis", {name: value for name, value in analysis.items() if name != "features"})
    rate = float(parse_rate(DEFAULT_RATE if chosen["rate"] is None else chosen["rate"]))
    with warnings.catch_warnings():
        # The session says again what there is to say.
        warnings.simplefilter("ignore")
        check_rates((*clips, *reference.clips), rate)
    reading = read_example(
        model_poses(clips, [reference], analysis.get("features")).in_own_order(),
        span,
        hand,
        rate=rate,
        low_pass=chosen["low_pass"],
        time_scale=chosen["time_scale"],
        n_neighbors=chosen["n_neighbors"],
        elsewhere=elsewhere,
    )
    named = replace(
        reference, motion=stretch if len(stretch) > 1 else stretch[0], name=f"{reference.label}, the example"
    )
    session = HandSession(clips, example=named, reading=reading, flights=flights, **analysis)
    result = session.solve(length=length, **{"smoothing": SMOOTHING} | options)
    for said in reading.warnings:
        warnings.warn(said, RetimeWarning, stacklevel=2)
    return result


def _whole_reference(
    clips: tuple[AnyMotion, ...],
    example_clip: AnyMotion | Reference | Sequence[AnyMotion] | None,
    rate: float | str | None,
) -> Reference:
    """Return the clip in which the example lies, as a reference; the input where no other is given."""
    if example_clip is None:
        return Reference(clips if len(clips) > 1 else clips[0])
    found = as_references(example_clip, len(clips), rate)
    if len(found) != 1:
        raise OptionError(f"an example lies in one clip (or in one for each of a group); found {len(found)}")
    return found[0]


def _stretch(
    clips: tuple[AnyMotion, ...], example: tuple[int, int]
) -> tuple[tuple[AnyMotion, ...], tuple[float, float]]:
    """Cut the example out of a clip, or out of each of a group; and its first and last moment, seconds."""
    start, stop = example
    first = clips[0].frames(start, stop)
    rate = float(clips[0].rate)
    span = start / rate, (start + first.n_frames - 1) / rate
    others = []
    for clip in clips[1:]:
        begin, end = (min(round(time * float(clip.rate)), clip.n_frames - 1) for time in span)
        others.append(clip.frames(begin, end + 1))
    return (first, *others), span


def _check_hand(hand: Warp, stretch: AnyMotion, span: tuple[float, float], example: tuple[int, int]) -> None:
    """Refuse a hand that leaves its example, or that shows one moment only."""
    near = 0.5 / float(stretch.rate)
    low, high = float(hand.input_times.min()), float(hand.input_times.max())
    if low < -near or high > stretch.end_time + near:
        raise OptionError(
            f"the warp made by hand shows input times {low:g} to {high:g} s, but its example (frames {example[0]} to "
            f"{example[1] - 1}) has its last one at {stretch.end_time:g} s: name the frames that it was made for, "
            "counted from their first"
        )
    if high <= low or span[1] <= span[0]:
        raise OptionError(
            f"the warp made by hand holds one moment of its example (input time {low:g} s): that is no speed to carry "
            "over"
        )


def _refuse_score_options(options: dict[str, Any]) -> None:
    """Refuse options that would have no effect where a hand's speeds are followed."""
    useless = [name for name in _OF_SCORES if options.get(name) not in (None, declared.default_of(name))]
    useless += ["search='heuristic'"] if options.get("search") == "heuristic" else []
    if useless:
        raise OptionError(
            f"{', '.join(useless)} would have no effect: the hand's speeds are carried over, and nothing is scored. "
            "The paper's way does (paper=True, --paper)",
            option="search" if useless[0].startswith("search") else useless[0],
        )


def _by_hand(clip: AnyMotion, hand: Warp) -> AnyMotion:
    """Retime a stretch; not averaged where it is fast."""
    shown = replace(clip, name=f"{clip.name or 'the clip'} by hand")
    # Two calls that look alike, so that types tell: apply_warp makes a motion of a motion, a signal of a signal.
    if isinstance(shown, Signal):
        return apply_warp(shown, hand, average=False)
    return apply_warp(shown, hand, average=False)


def _room_for(hand: Warp, input_end: float) -> dict[str, int]:
    """Choose upsample and max_skip so that the search can play as slow and as fast as the hand did, within reason."""
    speeds = np.abs(hand.slopes)
    moving = speeds[speeds > 1 / _MOST_UPSAMPLE]
    slowest, fastest = (float(moving.min()), float(moving.max())) if len(moving) else (1.0, 1.0)
    upsample = max(usual_upsample(input_end), math.ceil(1 / slowest - 1e-9))
    return {
        "upsample": upsample,
        "max_skip": min(_MOST_SKIP, max(DEFAULT_MAX_SKIP, upsample, math.ceil(fastest * upsample - 1e-9))),
    }
