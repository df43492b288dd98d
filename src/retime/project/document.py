"""What the editor edits: one value that says everything, from which clips to which keytimes.

Times are in seconds from the first frame used of the clip (`input_time`) or of the output (`output_time`). Lengths,
rates and speeds are text as on the command line, so that a document and a command line say the same in the same words.
"""

from __future__ import annotations

import itertools
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, Literal, TypeAlias, TypedDict

from retime.errors import FormatError
from retime.search.options import OPTIONS, Option

# Letters of a name that a person gives, and of an id that the page makes.
MAX_NAME = 200


@dataclass(frozen=True)
class ClipFile:
    """A clip of the document.

    Attributes
    ----------
    path : str
        The file.
    role : {"search", "follow"}
        Whether the warp is found on it (with all others that are), or it only gets the warp. The first one is
        searched, and its clock is the document's.
    first_frame, last_frame : int, optional
        Frames used, as the file numbers them, both included.
    fps : str, optional
        Frames a second, in place of what the file declares.
    skeleton : str, optional
        The ASF of an AMC, where it can't be found beside it.
    up : {"y", "z"}, optional
        The axis that is up in the file; left out, what the format says.
    channels : str, optional
        What channels of a table hold, as ``pan=angle:deg, *_id=label``; left out, what is found.
    gaps : str, optional
        What to do about values that a table lacks: ``bridge``, ``bridge:SECONDS`` or ``keep``; left out, refuse them.
    root : str, optional
        The joint that carries the body; left out, it is found.
    offset : str, optional
        How long after the first clip it begins, as ``0.5s`` or ``-12f``; of the first clip nothing. Left out, times in
        both files say it, or their first frames are one moment.
    """

    path: str
    role: Literal["search", "follow"] = "search"
    first_frame: int | None = None
    last_frame: int | None = None
    fps: str | None = None
    skeleton: str | None = None
    up: Literal["y", "z"] | None = None
    channels: str | None = None
    gaps: str | None = None
    root: str | None = None
    offset: str | None = None


@dataclass(frozen=True)
class JointPair:
    """A joint (or channel) of the clip, and which of the reference's stands for it.

    Attributes
    ----------
    input, reference : str
        Their names.
    """

    input: str
    reference: str


@dataclass(frozen=True)
class CounterpartFile:
    """What another searched clip is to move like, while the first one moves like the reference's own file.

    Attributes
    ----------
    clip : int
        The clip's place in the document, counted from 0; the first one's counterpart is the reference's own file.
    path : str
        The file. Of it the same time is used as of the reference's own.
    fps, skeleton, up, root, channels, gaps : str, optional
        As of a clip.
    """

    clip: int
    path: str
    fps: str | None = None
    skeleton: str | None = None
    up: Literal["y", "z"] | None = None
    channels: str | None = None
    gaps: str | None = None
    root: str | None = None


@dataclass(frozen=True)
class ReferenceFile:
    """What the input is to move like.

    Attributes
    ----------
    path : str, optional
        The file; left out, it is the first clip itself, and for a group the group itself.
    first_frame, last_frame : int, optional
        Frames used, as the file numbers them, both included.
    weight : float
        How much nearer it looks than it is; above 0.
    mirror : bool
        Imitate its mirror image too.
    fps, skeleton, up, root, channels, gaps : str, optional
        As of a clip.
    joint_map : str, optional
        A file that says which of its joints is which of the clip's.
    joints : tuple of JointPair
        The same, said here; where both speak of a joint of the clip, this holds.
    counterparts : tuple of CounterpartFile
        For a group that is searched together: a file for each of its clips but the first.
    """

    path: str | None = None
    first_frame: int | None = None
    last_frame: int | None = None
    weight: float = 1.0
    mirror: bool = False
    fps: str | None = None
    skeleton: str | None = None
    up: Literal["y", "z"] | None = None
    channels: str | None = None
    gaps: str | None = None
    root: str | None = None
    joint_map: str | None = None
    joints: tuple[JointPair, ...] = ()
    counterparts: tuple[CounterpartFile, ...] = ()


@dataclass(frozen=True)
class Key:
    """A keytime. The clip's own ends need none.

    Attributes
    ----------
    id : str
        Stays with it while it is moved.
    input_time, output_time : float
        Seconds.
    speed : float, optional
        A tangent: the playback speed there.
    """

    id: str
    input_time: float
    output_time: float
    speed: float | None = None


@dataclass(frozen=True)
class LockedTime:
    """A span of the input that plays at given speeds; from 0 to 1 it may be slowed down, but is not cut.

    Attributes
    ----------
    id : str
        Stays with it while it is moved.
    start, end : float
        Input time, seconds.
    slowest, fastest : float
        Playback speeds; equal ones fix the speed.
    """

    id: str
    start: float
    end: float
    slowest: float = 1.0
    fastest: float = 1.0


@dataclass(frozen=True)
class FlightMark:
    """What a person says of a stretch of the input: it is a flight, or none.

    Attributes
    ----------
    id : str
        Stays with it while it is moved.
    start, end : float
        Input time, seconds.
    flies : bool
        A flight, in the place of every one that was found and that it touches; or none, whatever was found there.
    """

    id: str
    start: float
    end: float
    flies: bool = True


@dataclass(frozen=True)
class Example:
    """A stretch that was retimed by hand, whose timing is carried over to the rest of the clip.

    Attributes
    ----------
    start, end : float
        Input time, seconds. The keytimes in it shape the example; those outside hold in the result.
    """

    start: float
    end: float


@dataclass(frozen=True)
class Marker:
    """A moment that a person has marked. It changes nothing of the warp: hands and keytimes snap to it.

    Attributes
    ----------
    id : str
        Stays with it while it is moved.
    time : float
        Seconds.
    name : str
        What it is; may be empty.
    on : {"output", "input"}
        Which time it is of: a beat that something is to happen on, or the moment of the clip at which it does.
    """

    id: str
    time: float
    name: str = ""
    on: Literal["output", "input"] = "output"


@dataclass(frozen=True)
class WorkArea:
    """The stretch of the output that is worked on: what is played is this. It changes nothing of the warp.

    Attributes
    ----------
    start, end : float
        Output time, seconds.
    """

    start: float
    end: float


def _held_by(option: Option) -> Any:
    """Return the type that holds an option in a document."""
    if option.kind == "choice":
        return Literal[tuple(choice.value for choice in option.choices)]
    # A curve of influence stands in the document itself: see `InfluencePoint`.
    held = {"influence": float, "number": float, "whole": int, "flag": bool}
    return held.get(option.kind, str)


# The options of the search that were given, by their names: see `retime.search.options`, which declares them.
if TYPE_CHECKING:
    Options: TypeAlias = dict[str, str | float | bool]
else:
    Options = TypedDict("Options", {option.name: _held_by(option) for option in OPTIONS}, total=False)


@dataclass(frozen=True)
class KeptWarp:
    """A warp kept for comparison.

    Attributes
    ----------
    id : str
        Of its content: the project holds the warp itself under this id.
    name : str
        A person's name for it.
    """

    id: str
    name: str


@dataclass(frozen=True)
class InfluencePoint:
    """How much the search has to say at a moment; between two of them it changes evenly.

    Attributes
    ----------
    time : float
        Output time, seconds.
    share : float
        From 0 (the spline through the keytimes) to 1 (guided).
    """

    time: float
    share: float


@dataclass(frozen=True)
class MediaFile:
    """A video or a sound, shown and heard beside the stage; it has no part in the search.

    Attributes
    ----------
    path : str
        The file.
    offset : str, optional
        How long after the clock's 0 it begins, as ``0.5s`` or ``-12f`` (frames of the first clip); left out, not at
        all.
    clock : {"input", "output"}
        Whether it was taken with the first clip, and follows the warp; or keeps the output's time, as a song does
        that is danced to.
    """

    path: str
    offset: str | None = None
    clock: Literal["input", "output"] = "input"


@dataclass(frozen=True)
class BeatsFile:
    """Moments to put keytimes on.

    Attributes
    ----------
    path : str, optional
        A table of times, or sound, in the output's time, as ``--keys-from`` reads it. Left out, the sound of the
        document's media, at the times where that is heard.
    on : {"beats", "onsets"}
        Of sound: its regular beats, or whenever something begins.
    """

    path: str | None = None
    on: Literal["beats", "onsets"] = "beats"


@dataclass(frozen=True)
class Document:
    """All that undo brings back.

    Attributes
    ----------
    clips : tuple of ClipFile
        The first one sets the clock.
    references : tuple of ReferenceFile
        None: the clip itself.
    keys : tuple of Key
        In any order.
    locks : tuple of LockedTime
        In any order.
    method : {"guided", "align", "linear", "spline"}
        Search for a warp, keep step with the reference, or only join the keytimes.
    repeat : float
        With the method "align": how often the reference is played; 1 or more.
    flights : tuple of FlightMark
        Corrections of the flights that are found. In any order.
    example : Example, optional
        What the method makes of this stretch is carried over to the rest of the clip.
    average : bool
        Average the input where it is sped up.
    options : dict of str to value
        Options of the search, by the names that `retime.search.options` declares; only what was given. What people
        type (lengths, rates, speeds) is text.
    kept : tuple of KeptWarp
        Warps to compare with.
    media : MediaFile, optional
        A video or a sound beside the stage.
    beats : BeatsFile, optional
        Moments to put keytimes on.
    markers : tuple of Marker
        In any order.
    work_area : WorkArea, optional
        Left out, all of the output.
    influence : tuple of InfluencePoint
        Influence over time, in the order of time; where there is a point, the option of that name waits.
    """

    clips: tuple[ClipFile, ...]
    references: tuple[ReferenceFile, ...] = ()
    keys: tuple[Key, ...] = ()
    locks: tuple[LockedTime, ...] = ()
    method: Literal["guided", "align", "linear", "spline"] = "guided"
    repeat: float = 1.0
    flights: tuple[FlightMark, ...] = ()
    example: Example | None = None
    average: bool = True
    # Equal documents have equal options, but a dict has no hash.
    options: Options = field(default_factory=dict, hash=False)
    kept: tuple[KeptWarp, ...] = ()
    media: MediaFile | None = None
    beats: BeatsFile | None = None
    markers: tuple[Marker, ...] = ()
    work_area: WorkArea | None = None
    influence: tuple[InfluencePoint, ...] = ()

    def __post_init__(self) -> None:
        if not self.clips:
            raise FormatError("a document needs a clip")
        if self.clips[0].role != "search":
            raise FormatError("the first clip of a document is one that is searched")
        if self.beats is not None and self.beats.path is None and self.media is None:
            raise FormatError("the beats are those of the media, and the document has none")
        for reference in self.references:
            pairs = [pair.input for pair in reference.joints]
            if len(set(pairs)) < len(pairs):
                raise FormatError("a reference has two joints for one of the clip's")
            for counterpart in reference.counterparts:
                if not 0 < counterpart.clip < len(self.clips):
                    raise FormatError(
                        f"a reference has a counterpart for clip {counterpart.clip}, of {len(self.clips)} clips from 0"
                    )
        for what, ids in (
            ("keys", [key.id for key in self.keys]),
            ("locks", [lock.id for lock in self.locks]),
            ("flights", [flight.id for flight in self.flights]),
            ("kept warps", [warp.id for warp in self.kept]),
            ("markers", [marker.id for marker in self.markers]),
        ):
            if len(set(ids)) < len(ids):
                raise FormatError(f"two {what} have the same id")
            if any(not one or len(one) > MAX_NAME for one in ids):
                raise FormatError(f"an id of the {what} is empty, or longer than {MAX_NAME} letters")
        if any(len(marker.name) > MAX_NAME for marker in self.markers):
            raise FormatError(f"the name of a marker is longer than {MAX_NAME} letters")
        times = [point.time for point in self.influence]
        if any(after <= before for before, after in itertools.pairwise(times)):
            raise FormatError("the points of the influence are not in the order of their times")
        if not all(0 <= point.share <= 1 for point in self.influence):
            raise FormatError("an influence is from 0 to 1")
        if self.work_area is not None and not self.work_area.start < self.work_area.end:
            raise FormatError("a work area ends after it begins")
