"""What the editor edits: one value that says everything, from which clips to which keytimes.

Times are in seconds from the first frame used of the clip (`input_time`) or of the output (`output_time`). Lengths and
rates are text as on the command line, so that a document and a command line say the same in the same words.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Literal

from retime.errors import FormatError

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
    """

    path: str
    role: Literal["search", "follow"] = "search"
    first_frame: int | None = None
    last_frame: int | None = None
    fps: str | None = None
    skeleton: str | None = None
    up: Literal["y", "z"] | None = None


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
    fps, skeleton, up : str, optional
        As of a clip.
    """

    clip: int
    path: str
    fps: str | None = None
    skeleton: str | None = None
    up: Literal["y", "z"] | None = None


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
    fps, skeleton, up : str, optional
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
class Options:
    """How the warp is found, and used; the names and defaults of `retime.guided_warp` and `retime warp`.

    Attributes
    ----------
    method : {"guided", "linear", "spline"}
        Search for a warp, or only join the keytimes.
    rate : str, optional
        Analysis rate, Hz.
    max_skip, upsample : int, optional
        Limits of the search; left out, what the keytimes need.
    slowest, fastest : float, optional
        Speed limits for the whole clip; both or none.
    smoothness : float
        Weight on changes of speed.
    smoothing : int, optional
        Output frames averaged to smooth the path's steps.
    n_neighbors : int, optional
        Reference frames averaged in a score.
    time_scale : float, optional
        How much velocity weighs against pose, seconds.
    low_pass : float, optional
        Cutoff of the filter that the analysis looks through, Hz.
    features : {"torso", "heading", "signal"}, optional
        What a pose is.
    score : {"joint", "conditional"}
        The local score.
    loop : bool
        The clip is a cycle and stays one.
    average : bool
        Average the input where it is sped up.
    """

    method: Literal["guided", "linear", "spline"] = "guided"
    rate: str | None = None
    max_skip: int | None = None
    upsample: int | None = None
    slowest: float | None = None
    fastest: float | None = None
    smoothness: float = 0.0
    smoothing: int | None = None
    n_neighbors: int | None = None
    time_scale: float | None = None
    low_pass: float | None = None
    features: Literal["torso", "heading", "signal"] | None = None
    score: Literal["joint", "conditional"] = "joint"
    loop: bool = False
    average: bool = True


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
    length : str, optional
        Of the output: ``65%``, ``9.3s`` (a bare number too is seconds), ``280f`` (frames at the clip's rate) or
        ``free``. Left out, the input plays on at its own speed after the last key.
    min_length, max_length : str, optional
        Bounds on a free length.
    free_weight : {"neutral", "sum"}
        How a free length weighs frames.
    influence : float
        From 0, the spline through the keytimes, to 1, the guided warp.
    options : Options
        How the warp is found and used.
    kept : tuple of KeptWarp
        Warps to compare with.
    """

    clips: tuple[ClipFile, ...]
    references: tuple[ReferenceFile, ...] = ()
    keys: tuple[Key, ...] = ()
    locks: tuple[LockedTime, ...] = ()
    length: str | None = None
    min_length: str | None = None
    max_length: str | None = None
    free_weight: Literal["neutral", "sum"] = "neutral"
    influence: float = 1.0
    options: Options = field(default_factory=Options)
    kept: tuple[KeptWarp, ...] = ()

    def __post_init__(self) -> None:
        if not self.clips:
            raise FormatError("a document needs a clip")
        if self.clips[0].role != "search":
            raise FormatError("the first clip of a document is one that is searched")
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
            ("kept warps", [warp.id for warp in self.kept]),
        ):
            if len(set(ids)) < len(ids):
                raise FormatError(f"two {what} have the same id")
            if any(not one or len(one) > MAX_NAME for one in ids):
                raise FormatError(f"an id of the {what} is empty, or longer than {MAX_NAME} letters")
