"""What a person asks for in the panel, and the search that answers it. bpy is not needed.

The panel speaks in frames of the scene; the search in seconds from the first frame of the range.
"""

from __future__ import annotations

import re
import warnings
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, Literal

from retime.brief import brief_repr
from retime.errors import InfeasibleWarpError, OptionError, RetimeWarning
from retime.motion.any_motion import AnyMotion
from retime.motion.grammar import parse_length, parse_speed, parse_speeds
from retime.motion.rate import parse_rate
from retime.progress import watching
from retime.search import options
from retime.search.align import align
from retime.search.guided import guided_warp
from retime.search.imitate import imitate
from retime.search.poses.references import Reference
from retime.search.result import GuidedWarp
from retime.search.wishes.locks import Lock

from .hand import HandTiming
from .timing import Timing

_NUMBER = r"(-?\d+(?:\.\d+)?(?:e[-+]?\d+)?)"
# Words after which a search names a moment, and then one or two of them.
_MOMENT = re.compile(
    rf"((?:input|output)(?: times?)?|of the input;|last frame at|runs from|the lock) {_NUMBER}(?: s)?"
    rf"(?:(–| to | and ){_NUMBER})? s\b"
)
_TIME = re.compile(r" times?$")

Way = Literal["RETIME", "PROPAGATE", "SYNCHRONISE"]


@dataclass(frozen=True, eq=False)
class Asked:
    """What a search is to answer.

    Attributes
    ----------
    way : {"RETIME", "PROPAGATE", "SYNCHRONISE"}
        Find timing; carry over what a hand did to a stretch; keep in step with the reference.
    start, rate : float
        First frame of the range, and frames a second.
    clips : sequence of Motion or Signal
        What moves, from that frame.
    keys : sequence of (float, float, str)
        Input frame, output frame, and the speed there ("" for any).
    locks : sequence of (float, float, str)
        First and last frame, and the speeds between them ("" for its own).
    given : mapping
        Options of the search that were changed, by their names.
    reference : sequence of Motion or Signal
        Whose timing is wanted; empty: the clips' own.
    hand : HandTiming, optional
        With "PROPAGATE".
    repeat : float
        With "SYNCHRONISE": how often the reference is played.
    mirror : bool
        Look at the reference's mirror image too.
    """

    way: Way
    start: float
    rate: float
    clips: Sequence[AnyMotion]
    keys: Sequence[tuple[float, float, str]] = ()
    locks: Sequence[tuple[float, float, str]] = ()
    given: Mapping[str, Any] = field(default_factory=dict)
    reference: Sequence[AnyMotion] = ()
    hand: HandTiming | None = None
    repeat: float = 1.0
    mirror: bool = False

    __repr__ = brief_repr

    def seconds(self, frame: float) -> float:
        """Return a frame's time, seconds from the first."""
        return (frame - self.start) / self.rate


@dataclass(frozen=True, eq=False)
class Answer:
    """What a search found.

    Attributes
    ----------
    timing : Timing
        In the scene's frames.
    found : GuidedWarp
        How it came about.
    warnings : list of str
        What was assumed.
    """

    timing: Timing
    found: GuidedWarp
    warnings: list[str]

    __repr__ = brief_repr


@dataclass(frozen=True)
class Fault:
    """An error beside the field that it is about.

    Attributes
    ----------
    text : str
        For people.
    field : str
        The option, ``keys`` or ``locks``; "" where no field is at fault.
    item : int
        Which of several keytimes or locks; -1 for none.
    """

    text: str
    field: str = ""
    item: int = -1


def answer(asked: Asked, tell: Callable[[float], None] | None = None) -> Answer:
    """Search; may run in any thread.

    Parameters
    ----------
    asked : Asked
    tell : function of a share, optional
        Hears how far the search is; whatever it raises ends it.

    Raises
    ------
    RetimeError
        As the search itself has it, and where a speed of a keytime or a lock is none.
    """
    with warnings.catch_warnings(record=True) as heard, watching(tell or (lambda share: None)):
        warnings.simplefilter("always", RetimeWarning)
        found = _search(asked)
    said = [str(one.message) for one in heard if issubclass(one.category, RetimeWarning)]
    return Answer(Timing.of_seconds(found.warp, asked.start, asked.rate), found, said)


def _check_typed(asked: Asked) -> None:
    """Refuse what is no length, rate or speed, and say in which field it was typed."""
    first = asked.clips[0]
    readers: dict[str, Callable[[str], object]] = {
        "length": lambda text: parse_length(text, first.n_frames, first.rate),
        "rate": parse_rate,
        "speeds": parse_speeds,
    }
    for name, value in asked.given.items():
        reader = readers.get(options.BY_NAME[name].kind)
        if reader is None or (name, value) == ("length", "free"):
            continue
        try:
            reader(value)
        except OptionError as error:
            raise OptionError(str(error), option=name) from None


def _search(asked: Asked) -> GuidedWarp:
    _check_typed(asked)
    clips = asked.clips[0] if len(asked.clips) == 1 else list(asked.clips)
    keys = [_key(asked, i) for i in range(len(asked.keys))]
    locks = [_lock(asked, i) for i in range(len(asked.locks))]
    if asked.way == "SYNCHRONISE":
        if not asked.reference:
            raise OptionError("to keep in step, choose with what: an action, an object or a file", option="reference")
        given = {name: value for name, value in asked.given.items() if "align" in options.BY_NAME[name].methods}
        given.pop("length", None)
        return align(clips, _reference(asked), repeat=asked.repeat, keys=keys, locks=locks, **given)
    if asked.way == "PROPAGATE":
        hand = asked.hand
        assert hand is not None
        first, last = round(hand.start - asked.start), round(hand.end - asked.start)
        rate = asked.rate
        warp = type(hand.warp)(
            (hand.warp.output_times - hand.warp.output_start) / rate,
            (hand.warp.input_times - hand.warp.input_times[0]) / rate,
        )
        given = {name: value for name, value in asked.given.items() if "hand" in options.BY_NAME[name].methods}
        return imitate(clips, (first, last + 1), warp, locks=locks, **{"length": "free", **given})
    reference = _reference(asked) if asked.reference else None
    return guided_warp(clips, reference=reference, keys=keys, locks=locks, **asked.given)


def _reference(asked: Asked) -> Reference:
    motions = tuple(asked.reference)
    return Reference(motions[0] if len(motions) == 1 else motions, mirror=asked.mirror)


def _key(asked: Asked, place: int) -> tuple[float, ...]:
    frame, to, speed = asked.keys[place]
    times = asked.seconds(frame), asked.seconds(to)
    if not speed.strip():
        return times
    try:
        return *times, parse_speed(speed)
    except OptionError as error:
        raise OptionError(str(error), option="keys", item=place) from None


def _lock(asked: Asked, place: int) -> Lock:
    first, last, speeds = asked.locks[place]
    try:
        slowest, fastest = parse_speeds(speeds) if speeds.strip() else (1.0, 1.0)
        return Lock(asked.seconds(first), asked.seconds(last), slowest, fastest)
    except OptionError as error:
        raise OptionError(str(error), option="locks", item=place) from None


def fault_of(error: Exception, asked: Asked | None = None) -> Fault:
    """Say which field an error is about.

    Parameters
    ----------
    error : RetimeError or OSError
        What was raised.
    asked : Asked, optional
        What it was raised for: a keytime is found by its output time.
    """
    text = str(error) if asked is None else in_frames(str(error), asked)
    name = getattr(error, "option", None) or ""
    item = getattr(error, "item", None)
    times = getattr(error, "output_times", None) or ()
    if asked is not None and item is None:
        at = [asked.seconds(key[1]) for key in asked.keys]
        near = [i for i, time in enumerate(at) if any(abs(time - other) < 0.5 / asked.rate for other in times)]
        if near:
            return Fault(text, "keys", near[0])
    if isinstance(error, InfeasibleWarpError) and not name:
        # What does not fit has too long or too short a time.
        name = "length"
    return Fault(text, str(name), -1 if item is None else int(item))


def in_frames(text: str, asked: Asked) -> str:
    """Say a search's moments, which are seconds from the first frame, as the frames that the panel speaks of.

    How long something lasts stays in seconds.
    """

    def frame(seconds: str) -> str:
        return f"{round(asked.start + float(seconds) * asked.rate, 1):g}"

    def said(found: re.Match[str]) -> str:
        words, first, between, second = found.groups()
        words = _TIME.sub("", words)
        place = "frame" if between is None or words == "runs from" else "frames"
        rest = "" if between is None else f"{between}{frame(second)}"
        return f"{words} {place} {frame(first)}{rest}".replace("last frame at frame", "last frame,")

    text = _MOMENT.sub(said, text)
    return text.replace("begins at time 0", f"begins at frame {asked.start:g}")
