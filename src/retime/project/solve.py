"""From a document to its warp: read the files, analyse them, solve. What `retime warp` does with its options."""

from __future__ import annotations

import warnings
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from retime.errors import InfeasibleWarpError, OptionError, RetimeWarning
from retime.formats.joint_map import read_joint_map
from retime.formats.registry import read
from retime.motion.kinematics import seems_z_up
from retime.motion.motion import Motion
from retime.motion.signal import Signal
from retime.motion.timecode import parse_frame_range
from retime.project.document import ClipFile, Document, Key, ReferenceFile
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
    """

    clips: tuple[AnyClip, ...]
    references: tuple[Reference, ...]


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


def as_paths(text: str) -> Path:
    """Take any path; see `retime.project.places` for something stricter."""
    return Path(text)


def read_clip(file: ClipFile | ReferenceFile, path: Path, find: Find) -> AnyClip:
    """Read one clip and cut out the frames used."""
    skeleton = None if file.skeleton is None else find(file.skeleton)
    clip = read(path, rate=file.fps, skeleton=skeleton, up=file.up)
    if not clip.name:
        clip = replace(clip, name=path.stem)
    if file.up is None and isinstance(clip, Motion) and seems_z_up(clip):
        warnings.warn(f"{clip.name}: the figure stands along Z; say so if Z is up in this file", RetimeWarning, 2)
    return _cut(clip, file)


def _cut(clip: AnyClip, file: ClipFile | ReferenceFile) -> AnyClip:
    if file.first_frame is None and file.last_frame is None:
        return clip
    ends = ["" if frame is None else str(frame) for frame in (file.first_frame, file.last_frame)]
    return clip.frames(*parse_frame_range(":".join(ends), clip.n_frames, clip.first_frame))


class Reader:
    """Reads a document's files; keeps what it read for the next document.

    Parameters
    ----------
    find : function of str
        Returns the path of a file, or refuses it.
    """

    def __init__(self, find: Find = as_paths) -> None:
        self._find = find
        self._clips: dict[ClipFile, AnyClip] = {}
        self._references: dict[tuple[ClipFile, ReferenceFile], Reference] = {}
        self._sources: Sources | None = None

    def read(self, document: Document) -> Sources:
        """Return what a document's files hold; the same value as before, where they are the same files.

        Raises
        ------
        FormatError, OSError
            A file can't be read.
        OptionError
            Frames that are not there, a path that may not be read, or references of a group.
        """
        # Which clips follow changes nothing about what is in them.
        files = [replace(file, role="search") for file in document.clips]
        clips = {file: self._clips.get(file) or read_clip(file, self._find(file.path), self._find) for file in files}
        first = files[0]
        references = {
            (first, file): self._references.get((first, file)) or self._reference(file, clips[first])
            for file in document.references
        }
        self._clips, self._references = clips, references
        found = Sources(
            tuple(clips[file] for file in files), tuple(references[first, file] for file in document.references)
        )
        if self._sources is None or not _same(self._sources, found):
            self._sources = found
        return self._sources

    def _reference(self, file: ReferenceFile, clip: AnyClip) -> Reference:
        motion = _cut(clip, file) if file.path is None else read_clip(file, self._find(file.path), self._find)
        joint_map = {} if file.joint_map is None else read_joint_map(self._find(file.joint_map))
        return Reference(motion, weight=file.weight, mirror=file.mirror, joint_map=joint_map)


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
        FormatError, OSError
            A file can't be read.
        """
        sources = self.read(document)
        clip, options = sources.clips[0], document.options
        keys = [key_of(key) for key in document.keys]
        if options.method != "guided":
            if document.length == "free":
                raise OptionError(f"a free length needs a search; the method {options.method} has none")
            keytimes = check_keytimes(as_keytimes(clip, document.length, keys), clip.duration)
            warp = linear_warp(keytimes) if options.method == "linear" else spline_warp(keytimes, rate=float(clip.rate))
            return Solution(document, sources, replace(warp, name=clip.name), None)
        search = self._session(document, sources).solve(
            length=document.length,
            keys=keys,
            min_length=document.min_length,
            max_length=document.max_length,
            free_weight=document.free_weight,
            locks=[Lock(lock.start, lock.end, lock.slowest, lock.fastest) for lock in document.locks],
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
        if len(searched) > 1 and document.references:
            raise OptionError("a group moves like itself: search on one clip only, or leave out the references")
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


@dataclass(frozen=True)
class Fault:
    """What an error speaks of; ids of a document's key or lock."""

    key: str | None = None
    lock: str | None = None


def fault_of(error: Exception, document: Document, clip: AnyClip | None, last: Document | None) -> Fault:
    """Say which key or lock is at fault, if it is one.

    Parameters
    ----------
    error : Exception
        From `DocumentSolver.solve`.
    document : Document
        What was to be solved.
    clip : Motion or Signal, optional
        Its first clip.
    last : Document, optional
        The last one that could be solved: of the two ends of a span the one that was changed since is at fault.
    """
    for lock in document.locks:
        try:
            text = f"the lock {Lock(lock.start, lock.end, lock.slowest, lock.fastest)} "
        except OptionError:
            return Fault(lock=lock.id)
        if text in str(error):
            return Fault(lock=lock.id)
    for key in document.keys:
        if key.speed is not None and not key.speed > 0:
            return Fault(key=key.id)
    times = {key.output_time for key in document.keys if f"output time {key.output_time:g} s" in str(error)}
    if isinstance(error, InfeasibleWarpError) and error.span is not None and clip is not None:
        try:
            keytimes = as_keytimes(clip, document.length, [key_of(key) for key in document.keys])
        except OptionError:
            keytimes = ()
        times = {keytime.output_time for keytime in sorted(keytimes)[error.span : error.span + 2]}
    suspects = [key for key in document.keys if key.output_time in times]
    before = () if last is None else last.keys
    changed = [key for key in suspects if key not in before]
    return Fault(key=(changed or suspects)[-1].id) if suspects else Fault()
