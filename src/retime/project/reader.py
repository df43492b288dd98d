"""A document's files: read once, and kept for the next document, which mostly names the same ones."""

from __future__ import annotations

import warnings
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from weakref import WeakKeyDictionary

from retime.brief import brief_repr
from retime.errors import FormatError, RetimeError, RetimeWarning
from retime.formats.asf import find_asf
from retime.formats.compressed import plain_path
from retime.formats.joint_map import read_joint_map
from retime.formats.read_options import ReadOptions
from retime.formats.registry import read, skin_of
from retime.motion.any_motion import AnyMotion
from retime.motion.channels import parse_channels
from retime.motion.grammar import parse_frame_range, parse_time
from retime.motion.group_clock import hint_at_clocks, on_clock_by_times, on_clock_of
from retime.motion.kinematics import seems_z_up
from retime.motion.motion import Motion
from retime.motion.skin import Skin
from retime.project.document import ClipFile, CounterpartFile, Document, ReferenceFile
from retime.project.faults import Fault, blaming
from retime.search.poses.references import Reference

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
    moved : tuple of bool
        For each clip whether it was put elsewhere on the first one's clock; left out, none was.
    stretches : tuple of (int, int)
        For each clip how many frames of its file come before those used, and how many the file has; left out, all of
        each file is used.
    skins : tuple of Skin or None
        For each clip the character's own mesh, where its file has one; left out, none has.
    """

    clips: tuple[AnyMotion, ...]
    references: tuple[Reference, ...]
    wholes: tuple[AnyMotion, ...]
    moved: tuple[bool, ...] = ()
    stretches: tuple[tuple[int, int], ...] = ()
    skins: tuple[Skin | None, ...] = ()

    __repr__ = brief_repr


def as_paths(text: str) -> Path:
    """Take any path; see `retime.project.allowed_places` for something stricter."""
    return Path(text)


AnyFile = ClipFile | ReferenceFile | CounterpartFile
# A file, how it is read, and the frames used of it.
_Key = tuple[str, str | None, str | None, str | None, str | None, str | None, str | None, int | None, int | None]


def read_clip(file: AnyFile, path: Path, find: Find) -> AnyMotion:
    """Read one clip, all of its frames."""
    skeleton = None if file.skeleton is None else find(file.skeleton)
    kinds = None if file.channels is None else parse_channels(file.channels)
    clip = read(path, rate=file.fps, skeleton=skeleton, up=file.up, root=file.root, kinds=kinds, gaps=file.gaps)
    if not clip.name:
        clip = replace(clip, name=path.stem)
    if file.up is None and isinstance(clip, Motion) and seems_z_up(clip):
        warnings.warn(
            f"{clip.name}: the figure stands along Z. If Z is up in this file, say so under How it is read: Up",
            RetimeWarning,
            2,
        )
    return clip


def _cut(clip: AnyMotion, first_frame: int | None, last_frame: int | None) -> AnyMotion:
    if first_frame is None and last_frame is None:
        return clip
    ends = ["" if frame is None else str(frame) for frame in (first_frame, last_frame)]
    return clip.frames(*parse_frame_range(":".join(ends), clip.n_frames, clip.first_frame))


def _same_stretch(part: AnyMotion, whole: AnyMotion, other: AnyMotion) -> AnyMotion:
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
        # The files as they were read, and the stretches that were cut out of them.
        self._clips: dict[_Key, AnyMotion] = {}
        self._used: dict[_Key, AnyMotion] = {}
        # What was tried, for the document that is read next.
        self._tried: dict[_Key, AnyMotion] = {}
        self._references: dict[tuple[ReferenceFile, tuple[int, ...]], tuple[tuple[AnyMotion, ...], Reference]] = {}
        # Of each further clip: the clip, the first one, the offset, and what came of them.
        self._placed: dict[int, tuple[AnyMotion, AnyMotion, str | None, AnyMotion]] = {}
        # Of each clip as it was read, for as long as that is kept.
        self._skins: WeakKeyDictionary[AnyMotion, Skin | None] = WeakKeyDictionary()
        self._sources: Sources | None = None

    def try_file(self, path: str, *, may_be_told: bool = False) -> None:
        """Read a file that no document names yet; the document that is read next need not read it again.

        Parameters
        ----------
        path : str
            The file.
        may_be_told : bool
            A file passes that only lacks what its reader can be told once a document names it: a rate, how gaps are
            filled, the skeleton of an AMC.

        Raises
        ------
        FormatError, OptionError, InvalidMotionError, OSError
            It can't be read, or may not be.
        """
        file = ClipFile(path=path)
        place = self._find(path)
        try:
            self._tried[_whole(file)] = read_clip(file, place, self._find)
        except FormatError:
            if not (may_be_told and _lacks_words_alone(file, place, self._find)):
                raise

    def read(self, document: Document) -> Sources:
        """Return what a document's files hold; the same value as before, where they are the same files.

        Raises
        ------
        FaultyError
            A file can't be read, or may not be; frames that are not there; a weight that is none. Says of which.
        """
        self._used = {}
        tried, self._tried = self._tried, {}
        self._clips = {**self._clips, **tried}
        clips = []
        for i, file in enumerate(document.clips):
            with blaming(Fault(clip=i)):
                clips.append(self._stretch(file, file.first_frame, file.last_frame))
        cut = clips
        clips = [
            clips[0],
            *(self._on_clock(i, document.clips[i], clip, clips[0]) for i, clip in enumerate(clips[1:], 1)),
        ]
        searched = tuple(i for i, file in enumerate(document.clips) if file.role == "search")
        references = {}
        for i, reference in enumerate(document.references):
            with blaming(Fault(reference=i)):
                references[reference, searched] = self._reference(reference, searched, clips)
        self._clips, self._references = self._used, references
        found = Sources(
            tuple(clips),
            tuple(references[file, searched][1] for file in document.references),
            tuple(clips[0] if file.path is None else self._stretch(file, None, None) for file in document.references),
            tuple(placed is not clip for placed, clip in zip(clips, cut, strict=True)),
            tuple(self._place(file, clip) for file, clip in zip(document.clips, cut, strict=True)),
            tuple(self._skin(file, clip) for file, clip in zip(document.clips, cut, strict=True)),
        )
        if self._sources is None or not _same(self._sources, found):
            self._sources = found
            hint_at_clocks(clips, lengths=True)
        return self._sources

    def _on_clock(self, index: int, file: ClipFile, clip: AnyMotion, first: AnyMotion) -> AnyMotion:
        """Put a clip on the first one's clock, as the document or the times in both files say; remember it."""
        known = self._placed.get(index)
        if known is None or not (known[0] is clip and known[1] is first and known[2] == file.offset):
            with blaming(Fault(clip=index)):
                placed = (
                    on_clock_by_times(clip, first)
                    if file.offset is None
                    else on_clock_of(clip, first, parse_time(file.offset.removeprefix("+"), first.rate))
                )
            known = self._placed[index] = clip, first, file.offset, placed
        return known[3]

    def _place(self, file: ClipFile, part: AnyMotion) -> tuple[int, int]:
        """Say how many frames of a clip's file come before those used, and how many there are."""
        whole = self._stretch(file, None, None)
        return part.first_frame - whole.first_frame, whole.n_frames

    def _skin(self, file: ClipFile, clip: AnyMotion) -> Skin | None:
        """Read a clip's own mesh, or remember it; where it can't be read say so, once, and show the bare joints."""
        whole = self._stretch(file, None, None)
        if whole not in self._skins:
            found = None
            if isinstance(clip, Motion):
                try:
                    found = skin_of(self._find(file.path), ReadOptions())
                except FormatError as error:
                    warnings.warn(f"{clip.name}: its mesh is not shown: {error}", RetimeWarning, 2)
                if found is not None and found.joints.max(initial=0) >= clip.skeleton.n_joints:
                    found = None
            self._skins[whole] = found
        return self._skins[whole]

    def _stretch(self, file: AnyFile, first_frame: int | None, last_frame: int | None) -> AnyMotion:
        """Read a file, or remember it, and cut out the frames used."""
        whole = _whole(file)
        part = (*whole[:7], first_frame, last_frame)
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
        self, file: ReferenceFile, searched: tuple[int, ...], clips: list[AnyMotion]
    ) -> tuple[tuple[AnyMotion, ...], Reference]:
        """Make a reference; beside it stand the clips that it was made for."""
        motions: list[AnyMotion] = []
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


def _whole(file: AnyFile) -> _Key:
    return (file.path or "", file.fps, file.skeleton, file.up, file.root, file.channels, file.gaps, None, None)


def _lacks_words_alone(file: ClipFile, place: Path, find: Find) -> bool:
    """Whether a file that can't be read could be, were its reader told what the file does not say."""
    if plain_path(place).suffix.lower() == ".amc":
        return find_asf(plain_path(place))[0] is None
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            read_clip(replace(file, fps="30", gaps="keep"), place, find)
    except (RetimeError, OSError):
        return False
    return True


def _same(a: Sources, b: Sources) -> bool:
    """Whether both hold the very same clips."""
    one, other = (*a.clips, *a.references), (*b.clips, *b.references)
    return (
        len(a.clips) == len(b.clips) and len(one) == len(other) and all(x is y for x, y in zip(one, other, strict=True))
    )
