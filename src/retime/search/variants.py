"""variants(): different natural timings of one clip, for whoever needs many takes where there is one."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from retime.brief import kind_of
from retime.checks import real, whole
from retime.errors import InfeasibleWarpError, OptionError
from retime.motion.any_motion import AnyMotion
from retime.motion.motion import Motion
from retime.motion.signal import Signal
from retime.search import options
from retime.search.guided import guided_warp
from retime.search.inputs import as_clips, as_references
from retime.search.poses.references import Reference
from retime.search.poses.spaces import PoseOptions
from retime.search.result import GuidedWarp
from retime.search.wishes.locks import Lock
from retime.warp.curve import Warp

# Of any two variants some moment of the input is shown at times that differ by this share of its duration.
APART = 0.02
# A moment in the middle is shown so much earlier or later than evenly, as a share of the output.
_SHIFT = 0.08
# A stretch that keeps its own speed is so long, as a share of the input.
_KEPT = 0.12
# Draws for each variant that is asked for.
_DRAWS = 20
# What variants draw themselves, or what fixes how long they are.
_DRAWN = ("length", "min_length", "max_length", "free_weight")


def variants(
    motion: AnyMotion | ArrayLike,
    n: int = 8,
    *,
    lengths: Sequence[float] = (0.8, 1.2),
    seed: int = 0,
    locks: Sequence[Lock | str] = (),
    draw_references: bool = False,
    **given: Any,
) -> tuple[GuidedWarp, ...]:
    """Find different natural timings of one clip.

    Each is a guided warp with a length of its own, spread evenly over `lengths`, one moment shown earlier or later, in
    half of them a stretch that keeps its own speed, and other weights: of joints (or channels) where `features` is left
    out, of smoothness, of evenness for a figure. All poses are the input's.

    The same clip, `n`, `seed` and options give the same variants, bit by bit. No two are alike: of any two, some moment
    of the input is shown at output times that differ by at least 2 % of the input's duration (`APART`).

    Parameters
    ----------
    motion : Motion, Signal, or array of shape (n_frames, n_channels)
        The input.
    n : int
        How many.
    lengths : (float, float)
        The shortest and the longest, as shares of the input's length.
    seed : int
        Another seed, other variants; 0 or more.
    locks : sequence of Lock or str
        Hold in all of them.
    draw_references : bool
        Of several references each variant imitates one, in place of all (`drawn_references`).
    **given
        Other options of `guided_warp`, but for keys and what is about the length.

    Returns
    -------
    tuple of GuidedWarp

    Raises
    ------
    OptionError
        An option is wrong, or so many that differ are not to be found: ask for fewer, or more room in the lengths.

    Examples
    --------
    >>> import numpy as np
    >>> takes = variants(np.sin(np.arange(150) ** 2 / 900), 4, rate=30, seed=1)
    >>> [take.apply().n_frames for take in takes]
    [125, 144, 155, 173]
    """
    n, seed = whole(n, "n"), whole(seed, "the seed")
    if n < 1 or seed < 0:
        raise OptionError(f"at least one variant, and a seed of 0 or more; found n={n}, seed={seed}")
    shortest, longest = _lengths(lengths)
    options.refuse_unknown(given, ("reference", *(name for name in (*options.BY_NAME,) if name not in _DRAWN)))
    (clip,) = as_clips(motion, given.get("rate"))
    references: list[Reference] = []
    if draw_references:
        if given.get("reference") is None:
            raise OptionError("to draw references some must be there: reference=[...]", option="draw_references")
        references = as_references(given["reference"], 1, given.get("rate"))
    order = drawn_references(n, len(references), seed)
    rng = np.random.default_rng(seed)
    # One length from each of n parts of the range: they are spread, whatever is drawn.
    parts = rng.permutation(n)
    found: list[GuidedWarp] = []
    shown: list[np.ndarray] = []
    moments = np.linspace(0.0, clip.end_time, 101)
    for _ in range(_DRAWS * n):
        share = shortest + (longest - shortest) * (parts[len(found)] + rng.uniform(0.25, 0.75)) / n
        drawn = _drawn(rng, clip, share, tuple(locks), given)
        if references:
            drawn["reference"] = references[order[len(found)]]
        try:
            take = guided_warp(motion, **given | drawn)
        except InfeasibleWarpError:
            # A lock and a key too near each other, say.
            continue
        times = np.asarray(take.warp.inverse()(moments))
        if any(float(np.abs(times - other).max()) < APART * clip.duration for other in shown):
            continue
        found.append(take)
        shown.append(times)
        if len(found) == n:
            return tuple(found)
    raise OptionError(
        f"found {len(found)} variants that differ, not {n}: ask for fewer, for lengths farther apart than "
        f"{shortest:g} and {longest:g}, or loosen locks and limits",
        option="lengths",
    )


def drawn_references(n: int, n_references: int, seed: int) -> tuple[int, ...]:
    """Return which reference each of `n` variants imitates: drawn, and each as often as the others, one aside.

    Examples
    --------
    >>> sorted(drawn_references(5, 2, seed=1)) in ([0, 0, 0, 1, 1], [0, 0, 1, 1, 1])
    True
    """
    if not n_references:
        return ()
    # A stream of its own: what else is drawn does not depend on it.
    rng = np.random.default_rng([seed, 1])
    rounds = [rng.permutation(n_references).tolist() for _ in range(-(-n // n_references))]
    return tuple(place for one in rounds for place in one)[:n]


def how_far_apart(one: Warp, other: Warp) -> float:
    """Return by how much the times differ at most at which two warps of a clip show a moment of it, seconds."""
    end = min(float(one.input_times.max()), float(other.input_times.max()))
    moments = np.linspace(0.0, end, 1001)
    return float(np.abs(np.asarray(one.inverse()(moments)) - np.asarray(other.inverse()(moments))).max())


def _lengths(lengths: Sequence[float]) -> tuple[float, float]:
    if isinstance(lengths, str) or not isinstance(lengths, Sequence | np.ndarray) or len(lengths) != 2:
        raise OptionError(
            f"lengths are the shortest and the longest, as shares: (0.8, 1.2); found {kind_of(lengths)}",
            option="lengths",
        )
    low, high = (real(one, "a length", option="lengths") for one in lengths)
    if not 0 < low <= high < math.inf:
        raise OptionError(f"lengths are above 0, the shortest first; found {low:g} and {high:g}", option="lengths")
    return low, high


def _drawn(
    rng: np.random.Generator, clip: AnyMotion, share: float, locks: tuple[Lock | str, ...], given: dict[str, Any]
) -> dict[str, Any]:
    """Draw what makes a variant; as many numbers each time, whatever is used of them."""
    n_frames = max(3, round(share * clip.n_frames))
    output_end = (n_frames - 1) / float(clip.rate)
    at, shift, locked, where, smooth, even = rng.uniform(size=6)
    weights = 2.0 ** rng.uniform(-1, 1, size=len(_names(clip)))
    moment = 0.3 + 0.4 * at
    place = moment + _SHIFT * (2 * shift - 1)
    drawn: dict[str, Any] = {
        "length": f"{n_frames}f",
        "keys": [(moment * clip.end_time, place * output_end)],
        "locks": list(locks),
    }
    # Within the longer of the parts beside the key, so that the rest can give.
    begin, room = (0.0, moment) if moment > 0.5 else (moment, 1 - moment)
    if locked < 0.5 and not locks:
        start = (begin + (room - _KEPT) * where) * clip.end_time
        drawn["locks"] = [Lock(start, start + _KEPT * clip.end_time)]
    if "smoothness" not in given:
        drawn["smoothness"] = 0.3 * smooth
    figure = isinstance(clip, Motion) and given.get("reference") is None and not given.get("paper")
    if figure and given.get("evenness") is None:
        drawn["evenness"] = 4.0 * 2.0 ** (2 * even - 1)
    if given.get("features") is None:
        drawn["features"] = PoseOptions(weights=dict(zip(_names(clip), weights.tolist(), strict=True)))
    return drawn


def _names(clip: AnyMotion) -> list[str]:
    """Joints that have coordinates in any pose space, or channels; each name once."""
    names = clip.names if isinstance(clip, Signal) else clip.skeleton.names[1:] or clip.skeleton.names
    return list(dict.fromkeys(names))
