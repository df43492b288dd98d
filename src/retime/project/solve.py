"""From a document to its warp: what `retime warp` does with its options."""

from __future__ import annotations

import warnings
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from retime.brief import brief_repr
from retime.errors import OptionError, RetimeWarning
from retime.motion.grammar import parse_length, parse_speed
from retime.motion.rate import parse_rate
from retime.project.document import Document, Key
from retime.project.faults import Fault, blaming
from retime.project.reader import AnyClip, Find, Reader, Sources, as_paths
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
        clip, options = sources.clips[0], document.options
        keys = [key_of(key) for key in document.keys]
        _check_values(document, clip)
        if options.method != "guided":
            if document.length == "free":
                raise OptionError(
                    f"a free length needs a search; the method {options.method} has none", option="length"
                )
            with asking_for_a_share(clip, document.length):
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
            with blaming(Fault(field=name)):
                parse_length(text, clip.n_frames, clip.rate)
    if document.options.rate is not None:
        with blaming(Fault(field="options.rate")):
            parse_rate(document.options.rate)
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
