"""From a document to its warp: read the files, analyse them, solve. What `retime warp` does with its options."""

from __future__ import annotations

import contextlib
import functools
import warnings
from collections.abc import Callable, Iterator
from dataclasses import dataclass, fields, replace
from pathlib import Path
from typing import Any

import numpy as np

from retime.brief import brief_repr
from retime.errors import InfeasibleWarpError, OptionError, RetimeError, RetimeWarning
from retime.formats.joint_map import read_joint_map
from retime.formats.registry import read
from retime.motion.kinematics import seems_z_up
from retime.motion.motion import Motion
from retime.motion.rate import parse_rate
from retime.motion.signal import Signal
from retime.motion.timecode import parse_frame_range, parse_length, parse_speed
from retime.project.document import ClipFile, CounterpartFile, Document, Key, ReferenceFile
from retime.warp.control import Lock
from retime.warp.curve import Warp
from retime.warp.keytimes import as_keytimes, check_keytimes
from retime.warp.reference import Reference
from retime.warp.result import GuidedWarp
from retime.warp.session import Session
from retime.warp.spline import linear_warp, spline_warp

AnyClip = Motion | Signal
Find = Callable[[str], Path]


@dataclass(frozen=True, eq=False)
class Sources:
    """What a document's files hold.

    Attributes
    ----------
    clips : tuple of Motion or Signal
        In the document's order.
    references : tuple of Reference
        In the document's order.
    wholes : tuple of Motion or Signal
        For each reference what its first motion is cut out of.
    """

    clips: tuple[AnyClip, ...]
    references: tuple[Reference, ...]
    wholes: tuple[AnyClip, ...]

    __repr__ = brief_repr


@dataclass(frozen=True, eq=False)
class Solution:
    """A document's warp.

    Attributes
    ----------
    document : Document
        What it answers.
    sources : Sources
        What it was found on.
    warp : Warp
        The result.
    search : GuidedWarp, optional
        How it came about, where there was a search.
    """

    document: Document
    sources: Sources
    warp: Warp
    search: GuidedWarp | None

    __repr__ = brief_repr


def as_paths(text: str) -> Path:
    """Take any path; see `retime.project.places` for something stricter."""
    return Path(text)


@dataclass(frozen=True)
class Fault:
    """What of a document is at fault.

    Attributes
    ----------
    key, lock : str, optional
        The id of a keytime, of a lock.
    clip, reference : int, optional
        The place of a clip, of a reference, counted from 0.
    field : str, optional
        The name of a value: ``length``, ``options.rate``.
    """

    key: str | None = None
    lock: str | None = None
    clip: int | None = None
    reference: int | None = None
    field: str | None = None


class FaultyError(RetimeError):
    """Something in a document can't be used.

    Parameters
    ----------
    error : Exception
        Why; its words are this one's.
    fault : Fault
        What.
    """

    def __init__(self, error: Exception, fault: Fault) -> None:
        self.fault = fault
        super().__init__(words_of(error))


def words_of(error: Exception) -> str:
    """Say what went wrong, as the command line does."""
    if isinstance(error, OSError) and error.strerror:
        return f"{error.filename}: {error.strerror}" if error.filename else error.strerror
    return str(error) or type(error).__name__


@contextlib.contextmanager
def _blaming(fault: Fault) -> Iterator[None]:
    """Say of whatever fails inside that this was at fault."""
    try:
        yield
    except FaultyError:
        raise
    except (RetimeError, OSError) as error:
        raise FaultyError(error, fault) from error


AnyFile = ClipFile | ReferenceFile | CounterpartFile
# A file, how it is read, and the frames used of it.
_Key = tuple[str, str | None, str | None, str | None, int | None, int | None]


def read_clip(file: AnyFile, path: Path, find: Find) -> AnyClip:
    """Read one clip, all of its frames."""
    skeleton = None if file.skeleton is None else find(file.skeleton)
    clip = read(path, rate=file.fps, skeleton=skeleton, up=file.up)
    if not clip.name:
        clip = replace(clip, name=path.stem)
    if file.up is None and isinstance(clip, Motion) and seems_z_up(clip):
        warnings.warn(
            f"{clip.name}: the figure stands along Z. If Z is up in this file, say so under How it is read: Up",
            RetimeWarning,
            2,
        )
    return clip


def _cut(clip: AnyClip, first_frame: int | None, last_frame: int | None) -> AnyClip:
    if first_frame is None and last_frame is None:
        return clip
    ends = ["" if frame is None else str(frame) for frame in (first_frame, last_frame)]
    return clip.frames(*parse_frame_range(":".join(ends), clip.n_frames, clip.first_frame))


def _same_stretch(part: AnyClip, whole: AnyClip, other: AnyClip) -> AnyClip:
    """Cut the stretch out of another clip that a part is of its whole, in time."""
    if part is whole:
        return other
    start = float((part.first_frame - whole.first_frame) / whole.rate)
    n_frames = min(round(part.end_time * float(other.rate)) + 1, other.n_frames)
    begin = min(round(start * float(other.rate)), other.n_frames - n_frames)
    return other.frames(begin, begin + n_frames)


class Reader:
    """Reads a document's files; keeps what it read for the next document.

    Parameters
    ----------
    find : function of str
        Returns the path of a file, or refuses it.
    """

    def __init__(self, find: Find = as_paths) -> None:
        self._find = find
        # Whole files, and what is cut out of them.
        self._clips: dict[_Key, AnyClip] = {}
        self._used: dict[_Key, AnyClip] = {}
        self._references: dict[tuple[ReferenceFile, tuple[int, ...]], tuple[tuple[AnyClip, ...], Reference]] = {}
        self._sources: Sources | None = None

    def read(self, document: Document) -> Sources:
        """Return what a document's files hold; the same value as before, where they are the same files.

        Raises
        ------
        FaultyError
            A file can't be read, or may not be; frames that are not there; a weight that is none. Says of which.
        """
        self._used = {}
        clips = []
        for i, file in enumerate(document.clips):
            with _blaming(Fault(clip=i)):
                clips.append(self._stretch(file, file.first_frame, file.last_frame))
        searched = tuple(i for i, file in enumerate(document.clips) if file.role == "search")
        references = {}
        for i, reference in enumerate(document.references):
            with _blaming(Fault(reference=i)):
                references[reference, searched] = self._reference(reference, searched, clips)
        self._clips, self._references = self._used, references
        found = Sources(
            tuple(clips),
            tuple(references[file, searched][1] for file in document.references),
            tuple(clips[0] if file.path is None else self._stretch(file, None, None) for file in document.references),
        )
        if self._sources is None or not _same(self._sources, found):
            self._sources = found
        return self._sources

    def _stretch(self, file: AnyFile, first_frame: int | None, last_frame: int | None) -> AnyClip:
        """Read a file, or remember it, and cut out the frames used."""
        whole = (file.path or "", file.fps, file.skeleton, file.up, None, None)
        part = (*whole[:4], first_frame, last_frame)
        for key in (whole, part):
            if key not in self._used:
                clip = self._clips.get(key)
                if clip is None:
                    clip = (
                        read_clip(file, self._find(file.path or ""), self._find)
                        if key == whole
                        else _cut(self._used[whole], first_frame, last_frame)
                    )
                self._used[key] = clip
        return self._used[part]

    def _reference(
        self, file: ReferenceFile, searched: tuple[int, ...], clips: list[AnyClip]
    ) -> tuple[tuple[AnyClip, ...], Reference]:
        """Make a reference; beside it stand the clips that it was made for."""
        motions: list[AnyClip] = []
        if file.path is None:
            first = _cut(clips[0], file.first_frame, file.last_frame)
            motions = [first, *(_same_stretch(first, clips[0], clips[i]) for i in searched[1:])]
        else:
            first = self._stretch(file, file.first_frame, file.last_frame)
            whole = self._stretch(file, None, None)
            beside = {counterpart.clip: counterpart for counterpart in file.counterparts}
            others = [self._stretch(beside[i], None, None) for i in searched[1:] if i in beside]
            motions = [first, *(_same_stretch(first, whole, other) for other in others)]
        own = tuple(clips[i] for i in searched)
        known = self._references.get((file, searched))
        if known is not None and all(one is other for one, other in zip(known[0], own, strict=True)):
            return known
        joint_map = {} if file.joint_map is None else read_joint_map(self._find(file.joint_map))
        joint_map |= {pair.input: pair.reference for pair in file.joints}
        motion = motions if len(searched) > 1 else first
        return own, Reference(motion, weight=file.weight, mirror=file.mirror, joint_map=joint_map)


def _same(a: Sources, b: Sources) -> bool:
    """Whether both hold the very same clips."""
    one, other = (*a.clips, *a.references), (*b.clips, *b.references)
    return (
        len(a.clips) == len(b.clips) and len(one) == len(other) and all(x is y for x, y in zip(one, other, strict=True))
    )


class DocumentSolver:
    """Solves documents one after the other; analyses anew only what changed.

    Parameters
    ----------
    find : function of str
        Returns the path of a file, or refuses it.
    """

    def __init__(self, find: Find = as_paths) -> None:
        self._reader = Reader(find)
        self._analysed: tuple[tuple[Any, ...], Session] | None = None

    def read(self, document: Document) -> Sources:
        """Read a document's files, or return what was read before; see `Reader.read`."""
        return self._reader.read(document)

    def solve(self, document: Document) -> Solution:
        """Find a document's warp.

        Raises
        ------
        InfeasibleWarpError, OptionError
            The document asks for what can't be done.
        FaultyError
            A file can't be read, or a value says nothing.
        """
        sources = self.read(document)
        clip, options = sources.clips[0], document.options
        keys = [key_of(key) for key in document.keys]
        _check_values(document, clip)
        if options.method != "guided":
            if document.length == "free":
                raise OptionError(
                    f"a free length needs a search; the method {options.method} has none", option="length"
                )
            keytimes = check_keytimes(as_keytimes(clip, document.length, keys), clip.end_time)
            warp = linear_warp(keytimes) if options.method == "linear" else spline_warp(keytimes, rate=float(clip.rate))
            return Solution(document, sources, replace(warp, name=clip.name), None)
        search = self._session(document, sources).solve(
            length=document.length,
            keys=keys,
            min_length=document.min_length,
            max_length=document.max_length,
            free_weight=document.free_weight,
            locks=_locks(document),
            speed=_speed_limits(document),
            smoothness=options.smoothness,
            influence=document.influence,
            loop=options.loop,
            **_given(max_skip=options.max_skip, upsample=options.upsample, smoothing=options.smoothing),
        )
        return Solution(document, sources, replace(search.warp, name=clip.name), search)

    def _session(self, document: Document, sources: Sources) -> Session:
        options = document.options
        searched = tuple(i for i, file in enumerate(document.clips) if file.role == "search")
        settings = _given(
            rate=options.rate,
            n_neighbors=options.n_neighbors,
            time_scale=options.time_scale,
            low_pass=options.low_pass,
            features=options.features,
        )
        key = (id(sources), searched, options.score, *sorted(settings.items()))
        if self._analysed is None or self._analysed[0] != key:
            # Let go of the old analysis before the new one takes its memory.
            self._analysed = None
            clips = [sources.clips[i] for i in searched]
            session = Session(
                clips if len(clips) > 1 else clips[0],
                reference=list(sources.references) or None,
                score=options.score,
                **settings,
            )
            self._analysed = key, session
        return self._analysed[1]


def _given(**options: Any) -> dict[str, Any]:
    return {name: value for name, value in options.items() if value is not None}


def _check_values(document: Document, clip: AnyClip) -> None:
    """Refuse a value that says no length, rate or speed; say which it is."""
    for name in ("length", "min_length", "max_length"):
        text = getattr(document, name)
        if text is not None and (text != "free" or name != "length"):
            with _blaming(Fault(field=name)):
                parse_length(text, clip.n_frames, clip.rate)
    if document.options.rate is not None:
        with _blaming(Fault(field="options.rate")):
            parse_rate(document.options.rate)
    for key in document.keys:
        if key.speed is not None:
            with _blaming(Fault(key=key.id)):
                parse_speed(key.speed)


def _locks(document: Document) -> list[Lock]:
    found = []
    for lock in document.locks:
        with _blaming(Fault(lock=lock.id)):
            found.append(Lock(lock.start, lock.end, lock.slowest, lock.fastest))
    return found


def _speed_limits(document: Document) -> tuple[float, float] | None:
    slowest, fastest = document.options.slowest, document.options.fastest
    if slowest is None and fastest is None:
        return None
    return slowest or 0.0, np.inf if fastest is None else fastest


def key_of(key: Key) -> tuple[float, float] | tuple[float, float, float]:
    """Return a key as `retime.guided_warp` takes it."""
    pair = key.input_time, key.output_time
    return pair if key.speed is None else (*pair, key.speed)


def ghosts(solution: Solution) -> tuple[Warp, Warp]:
    """Return what an animator has today through the same keytimes: straight lines, and the spline."""
    keytimes = solution.warp.keytimes
    with warnings.catch_warnings():
        # That a tangent is too steep for a spline is no news about the guided warp.
        warnings.simplefilter("ignore", RetimeWarning)
        return linear_warp(keytimes), spline_warp(keytimes, rate=float(solution.sources.clips[0].rate))


def value_of(document: Document, name: str) -> Any:
    """Return a value of a document by its name, such as ``length`` or ``options.rate``."""
    return functools.reduce(getattr, name.split("."), document)


# What an argument of `retime.guided_warp` is called in a document, where it is called otherwise.
_FIELDS = {"speed": "options.fastest", "keys": None, "locks": None, "reference": None, "motion": None}


def fault_of(error: Exception, document: Document, last: Document | None) -> Fault:
    """Say what of a document is at fault.

    Parameters
    ----------
    error : Exception
        From `DocumentSolver.solve`.
    document : Document
        What was to be solved.
    last : Document, optional
        The last one that could be solved: of the two ends of a span the one that was changed since is at fault.
    """
    if isinstance(error, FaultyError):
        return error.fault
    if not isinstance(error, InfeasibleWarpError | OptionError):
        return Fault()
    if isinstance(error, OptionError) and error.item is not None:
        if error.option == "locks":
            return Fault(lock=document.locks[error.item].id)
        if error.option == "reference" and error.item < len(document.references):
            return Fault(reference=error.item)
    if error.option == "reference" and len(document.references) == 1:
        return Fault(reference=0)
    if error.option == "motion":
        # The clips of a group don't agree; the last that is searched came last.
        return Fault(clip=max(i for i, file in enumerate(document.clips) if file.role == "search"))
    suspects = [key for key in document.keys if key.output_time in error.output_times]
    before = () if last is None else last.keys
    changed = [key for key in suspects if key not in before]
    if not changed and last is not None and error.output_times:
        # The keys stand where they stood: what was changed beside them leaves no way through.
        if locks := [lock for lock in document.locks if lock not in last.locks]:
            return Fault(lock=locks[-1].id)
        for name in ("options.fastest", "options.slowest", "options.max_skip", "options.upsample"):
            if value_of(document, name) != value_of(last, name):
                return Fault(field=name)
        if document.length is not None and document.length != last.length:
            return Fault(field="length")
    if suspects:
        return Fault(key=(changed or suspects)[-1].id)
    if error.option is None:
        # A span between keytimes, of which the ends are two: the last one stands where the length puts it.
        return Fault(field="length") if error.output_times and document.length is not None else Fault()
    known = {field.name for field in fields(Document)}
    name = error.option if error.option in known else f"options.{error.option}"
    return Fault(field=_FIELDS.get(error.option, name))
