"""guided_warp(): the one call most people need."""

from __future__ import annotations

from collections.abc import Sequence

from numpy.typing import ArrayLike

from retime.motion.any_motion import AnyMotion
from retime.search import options
from retime.search.options import FreeWeight, SearchName
from retime.search.poses.references import Reference
from retime.search.poses.spaces import PoseOptions, PoseSpace
from retime.search.result import GuidedWarp
from retime.search.score import ScoreName
from retime.search.session import Session
from retime.search.wishes.locks import Lock


def guided_warp(
    motion: AnyMotion | ArrayLike | Sequence[AnyMotion],
    *,
    reference: AnyMotion | ArrayLike | Reference | Sequence[AnyMotion | Reference] | None = None,
    length: str | float | None = None,
    min_length: str | float | None = None,
    max_length: str | float | None = None,
    free_weight: FreeWeight = "neutral",
    keys: Sequence[str | Sequence[float | str | None]] = (),
    locks: Sequence[Lock | str] = (),
    speed: str | Sequence[float | str] | None = None,
    evenness: float | None = None,
    keep_flights: float | None = None,
    flights: Sequence[Sequence[float | str]] | None = None,
    content: float = 0.0,
    ends: float = 0.0,
    own_timing: float = 0.0,
    smoothness: float = 0.0,
    influence: ArrayLike = 1.0,
    loop: bool = False,
    paper: bool = False,
    rate: float | str | None = None,
    max_skip: int | None = None,
    upsample: int | None = None,
    n_neighbors: int = 3,
    time_scale: float = 0.2,
    low_pass: float = 4.0,
    features: PoseSpace | PoseOptions | Sequence[PoseOptions] | None = None,
    match_tempo: bool = False,
    score: ScoreName = "joint",
    smoothing: int = 5,
    search: SearchName = "priced",
) -> GuidedWarp:
    """Find the warp that meets the keytimes, keeps the input's content, and moves like the reference (§3).

    Parameters
    ----------
    motion : Motion, Signal, array of shape (n_frames, n_channels), or sequence of clips
        The input. Several clips that move together (characters, props, a camera) are one group: one warp is found
        on all of them.
    reference : Motion, Signal, array, Reference, or sequence of them, optional
        Moves with the timing that is wanted. Left out: the input itself. A `Reference` carries a weight, a mirror
        image, and a map of joints where the skeletons differ.
    length : str or float, optional
        Length of the output: ``"65%"``, seconds (9.3, ``"9.3"``, ``"0:09.300"``), frames at the input's rate
        (``"280f"``), a timecode, or ``"free"``: the search finds it (§4.2). An int is refused, for it once meant
        frames. Left out: after the last key the input plays on at its own speed.
    min_length, max_length : str or float, optional
        Bounds on a free length.
    free_weight : {"neutral", "sum"}
        How a free length weighs frames: ``sum`` is the paper's plain sum, which favours short results; ``neutral``
        weighs each by the square root of its speed.
    keys : sequence of (input time, output time), (input time, output time, speed) or str
        More keytimes, in seconds or as text (``"120f"``; a whole key is ``"120f=1.5@1/2"``), with a tangent where a
        speed is given; the clip's ends are added. Equal input times hold, decreasing ones run backward.
    locks : sequence of Lock or str
        Spans of the input that play at a given speed, or in a range of speeds; as text ``"2.1..3.4=1/2..1"``.
    speed : (slowest, fastest), optional
        Slowest and fastest playback speed, numbers or text (``"1/2"``); or both in a text,
        ``"1/2..4"``. Sets `upsample` and `max_skip` where those are left out.
    evenness : float, optional
        How evenly moving parts share the hurry: a weight on ln² of the speed wherever something moves. Pauses give way
        first; a walk is hurried as a whole. Left out: 4 where a figure moves like itself, 0.1 where it moves like
        another, 0 for signals. 0 leaves the choice to the scores alone.
    keep_flights : float, optional
        How strongly flights are played at their own speed. Left out: 24 where a figure moves like itself, else 0.
    flights : sequence of (start, end), optional
        Input times between which a figure flies, in place of what is found (`Motion.flights`).
    content : float
        How dear it is to leap over poses: a price on each step for what it does not show. 0 is off; 2 keeps nearly all
        actions of a signal, 4 all of them. With `evenness` it adds little.
    ends : float
        How near to its own speed the output begins and ends: a weight on ln² of the first and of the last speed, in
        median scores. 0 is off.
    own_timing : float
        How near the clip stays to its own timing where the reference says little: the weight of how far each triple
        moves unlike the clip at unit speed. 0 is off. For a free length after another motion, 0.1 brings lengths a
        little nearer, and makes the imitated timing a little milder.
    smoothness : float
        Weight on changes of log-speed, in median scores; 0 is off.
    influence : float, or array of shape (n, 2)
        How far the warp is guided: 0 is the spline through the keytimes, 1 the guided warp, between them a mix
        (§5). A curve is rows of (output time, influence).
    loop : bool
        The clip is a cycle and stays one: first and last speed agree, and the seam is scored.
    paper : bool
        The paper read literally: torso space, a time scale of one frame, its plain sum for a free length, no price on
        tempo. Options that are given beside it, and differ from their defaults, hold.
    rate : number or str, optional
        Analysis rate, Hz; 30 (the paper's) where left out. For an array it is the array's rate too. The output
        keeps the input's own rate.
    max_skip : int, optional
        Largest step between neighbouring selected frames of the upsampled input: no speed goes beyond ``max_skip /
        upsample``. Left out: with natural hurry 8 times `upsample`, without it 8, or 16 for another reference (8 beyond
        two minutes); or twice a span's mean step where that is more (a quarter more where twice is dear). Where it
        is given, a clip that moves like itself has the paper's steps: `upsample` is as without natural hurry.
    upsample : int, optional
        Frames offered per analysis period: no speed falls below ``1 / upsample``. Left out, each span between keytimes
        has its own. With natural hurry 4 where it gets shorter and 12 where it gets longer (4 where the input is
        longer than a minute, 2 beyond two); without it 1 and 4; 8 for another reference (4 beyond two minutes). More,
        twice the mean slow-down, where that asks for more (a quarter more where twice is dear); fewer where the span
        plays at twice its speed or faster.
    n_neighbors : int
        Reference frames averaged in a score (the paper's k).
    time_scale : float
        τ, seconds: how much velocity and acceleration weigh against pose.
    low_pass : float
        Cutoff in Hz of the filter that the analysis (never the output) looks through; 0 is off.
    features : {"torso", "heading", "signal"}, PoseOptions, or sequence of PoseOptions, optional
        Pose space, chosen joints and their weights; see `PoseOptions`. For a group one for all, or one a clip.
    match_tempo : bool
        Imitate the reference as if it moved as fast as the input does in the same poses: where it hurries and lingers
        is taken, not how quick it is as a whole. A slow-motion reference is no longer one then.
    score : {"joint", "conditional"}
        The paper's Eq. 2, or how the reference moves where its pose is like this.
    smoothing : int
        Output frames, at the analysis rate, averaged by the moving window that smooths the path's staircase; 0 or 1
        is off.
    search : {"priced", "layered", "heuristic"}
        ``priced`` and ``layered`` are exact and agree; ``heuristic`` is the paper's coarse-to-fine search, whose
        excess over the optimum the result reports.

    Returns
    -------
    GuidedWarp
        ``.warp`` is the result; the rest tells how it came about, ``.explain()`` why.

    Raises
    ------
    InfeasibleWarpError
        No warp meets the keytimes within the limits; says what would.
    OptionError
        Options that contradict each other or the data.

    Examples
    --------
    >>> import numpy as np
    >>> t = np.arange(120) / 30
    >>> result = guided_warp(np.sin(t**2), rate=30, length="75%")
    >>> result.n_input, result.n_output, round(float(result.warp(result.warp.output_end)), 3)
    (120, 90, 3.967)
    """
    # The signature above is written out for people; what it says is compared with `retime.search.options` by a test.
    given = locals()
    session = Session(
        motion, reference=reference, flights=flights, **{name: given[name] for name in options.names("analysis")}
    )
    return session.solve(keys=keys, locks=locks, **{name: given[name] for name in options.names("solve")})
