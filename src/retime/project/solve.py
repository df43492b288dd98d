"""From a document to its warp: what `retime warp` does with its options."""

from __future__ import annotations

import warnings
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

from retime.brief import brief_repr
from retime.errors import OptionError, RetimeWarning
from retime.motion.any_motion import AnyMotion
from retime.motion.grammar import parse_length, parse_speed, parse_speeds
from retime.motion.rate import parse_rate
from retime.project.document import Document, Key
from retime.project.faults import Fault, blaming, option_fault
from retime.project.reader import Find, Reader, Sources, as_paths
from retime.search import options
from retime.search.keytimes import as_keytimes, asking_for_a_share, check_keytimes
from retime.search.result import GuidedWarp
from retime.search.session import Session
from retime.search.wishes.locks import Lock
from retime.warp.curve import Warp
from retime.warp.spline import linear_warp, spline_warp


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
        clip, given = sources.clips[0], document.options
        keys = [key_of(key) for key in document.keys]
        _check_values(document, clip)
        if document.method != "guided":
            length = given.get("length")
            if length == "free":
                raise OptionError(
                    f"a free length needs a search; the method {document.method} has none", option="length"
                )
            with asking_for_a_share(clip, length):
                keytimes = check_keytimes(as_keytimes(clip, length, keys), clip.end_time)
            join = linear_warp if document.method == "linear" else partial(spline_warp, rate=float(clip.rate))
            warp = join(keytimes)
            return Solution(document, sources, replace(warp, name=clip.name), None)
        search = self._session(document, sources).solve(keys=keys, locks=_locks(document), **_given(document, "solve"))
        return Solution(document, sources, replace(search.warp, name=clip.name), search)

    def _session(self, document: Document, sources: Sources) -> Session:
        searched = tuple(i for i, file in enumerate(document.clips) if file.role == "search")
        settings = _given(document, "analysis")
        key = (id(sources), searched, *sorted(settings.items()))
        if self._analysed is None or self._analysed[0] != key:
            # Let go of the old analysis before the new one takes its memory.
            self._analysed = None
            clips = [sources.clips[i] for i in searched]
            session = Session(
                clips if len(clips) > 1 else clips[0],
                reference=list(sources.references) or None,
                **settings,
            )
            self._analysed = key, session
        return self._analysed[1]


def _given(document: Document, stage: options.Stage) -> dict[str, Any]:
    """Return those options of a stage that a document gives."""
    return {name: document.options[name] for name in options.names(stage) if name in document.options}


def _check_values(document: Document, clip: AnyMotion) -> None:
    """Refuse a value that says no length, rate or speed; say which it is."""
    readers: dict[str, Callable[[Any], object]] = {
        "length": lambda text: parse_length(text, clip.n_frames, clip.rate),
        "rate": parse_rate,
        "speeds": parse_speeds,
    }
    for name, value in document.options.items():
        read = readers.get(options.BY_NAME[name].kind)
        if read is not None and (name, value) != ("length", "free"):
            with blaming(option_fault(name)):
                read(value)
    for key in document.keys:
        if key.speed is not None:
            with blaming(Fault(key=key.id)):
                parse_speed(key.speed)


def _locks(document: Document) -> list[Lock]:
    found = []
    for lock in document.locks:
        with blaming(Fault(lock=lock.id)):
            found.append(Lock(lock.start, lock.end, lock.slowest, lock.fastest))
    return found


def key_of(key: Key) -> tuple[float, float] | tuple[float, float, float]:
    """Return a key as `retime.guided_warp` takes it."""
    pair = key.input_time, key.output_time
    return pair if key.speed is None else (*pair, key.speed)


def ghosts(solution: Solution) -> tuple[Warp, Warp]:
    """Return what an animator has today through the same keytimes: straight lines, and the spline."""
    keytimes = solution.warp.keytimes
    with warnings.catch_warnings():
        # A tangent may be too steep for a spline; that says nothing about the guided warp, so nobody is warned.
        warnings.simplefilter("ignore", RetimeWarning)
        return linear_warp(keytimes), spline_warp(keytimes, rate=float(solution.sources.clips[0].rate))
