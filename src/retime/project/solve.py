"""From a document to its warp: what `retime warp` does with its options."""

from __future__ import annotations

import math
import warnings
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from retime.arrays import FloatArray
from retime.brief import brief_repr
from retime.errors import OptionError, RetimeWarning
from retime.motion.any_motion import AnyMotion
from retime.motion.flights import corrected_flights
from retime.motion.grammar import parse_length, parse_speed, parse_speeds
from retime.motion.rate import parse_rate
from retime.project.document import Document, Key
from retime.project.faults import Fault, FaultyError, blaming, option_fault
from retime.project.reader import Find, Reader, Sources, as_paths
from retime.search import options
from retime.search.align import AlignSession
from retime.search.imitate import imitate
from retime.search.joined import joined_warp
from retime.search.result import GuidedWarp
from retime.search.session import Session
from retime.search.wishes.locks import Lock
from retime.search.wishes.tempo import flights_of
from retime.warp.curve import Warp
from retime.warp.spline import linear_warp, span_slopes

# Seconds: closer than this, two input times are one.
_NEAR = 1e-9


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
    hand : Warp, optional
        Where an example is carried over: the example as the method plays it, at its own output times.
    """

    document: Document
    sources: Sources
    warp: Warp
    search: GuidedWarp | None
    hand: Warp | None = None

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
        self._last: Solution | None = None

    def read(self, document: Document) -> Sources:
        """Read a document's files, or return what was read before; see `Reader.read`."""
        return self._reader.read(document)

    def try_file(self, path: str, *, may_be_told: bool = False) -> None:
        """Read a file that no document names yet; see `Reader.try_file`."""
        self._reader.try_file(path, may_be_told=may_be_told)

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
        last, self._last = self._last, None
        if last is not None and last.sources is sources and _asks_for(last.document) == _asks_for(document):
            self._last = replace(last, document=document)
            return self._last
        # Let go of the old solution before the new one takes its memory.
        del last
        _check_values(document, sources.clips[0])
        found = self._by_method(document, sources)
        self._last = found if document.example is None else _carried_over(found)
        return self._last

    def _by_method(self, document: Document, sources: Sources) -> Solution:
        """Find the warp of a document's method, with no example carried over."""
        clip = sources.clips[0]
        keys = [key_of(key) for key in document.keys]
        if document.method in ("linear", "spline"):
            warp = joined_warp(clip, document.options.get("length"), keys, document.method)
            return Solution(document, sources, replace(warp, name=clip.name), None)
        search = self._session(document, sources).solve(
            keys=keys, locks=_locks(document), **_given(document, "solve", document.method)
        )
        return Solution(document, sources, replace(search.warp, name=clip.name), search)

    def _session(self, document: Document, sources: Sources) -> Session:
        aligns = document.method == "align"
        settings = _given(document, "analysis", document.method)
        flights = () if aligns else document.flights
        repeat = document.repeat if aligns else 1.0
        # Sources are equal where they are the same: held here, no others can take their place in memory.
        key = (sources, _searched(document), aligns, repeat, flights, *sorted(settings.items()))
        if self._analysed is None or self._analysed[0] != key:
            # Let go of the old analysis before the new one takes its memory.
            self._analysed = None
            clips = [sources.clips[i] for i in _searched(document)]
            motion = clips if len(clips) > 1 else clips[0]
            if aligns:
                session: Session = _align_session(motion, sources, repeat, settings)
            else:
                session = Session(
                    motion,
                    reference=list(sources.references) or None,
                    flights=_corrected(document, clips),
                    **settings,
                )
            self._analysed = key, session
        return self._analysed[1]


def _asks_for(document: Document) -> Document:
    """Leave out of a document what says nothing of its warp: markers, the work area, media, what is compared with."""
    return replace(document, markers=(), work_area=None, kept=(), media=None, beats=None)


def _searched(document: Document) -> tuple[int, ...]:
    """Name the clips that are searched, by their places."""
    return tuple(i for i, file in enumerate(document.clips) if file.role == "search")


def _given(document: Document, stage: options.Stage, method: options.Method) -> dict[str, Any]:
    """Return those options of a stage that a document gives; what says nothing for a method waits for another."""
    names = options.names(stage, method)
    found: dict[str, Any] = {name: document.options[name] for name in names if name in document.options}
    if document.influence and "influence" in names:
        found["influence"] = [(point.time, point.share) for point in document.influence]
    return found


def _align_session(
    motion: AnyMotion | list[AnyMotion], sources: Sources, repeat: float, settings: dict[str, Any]
) -> AlignSession:
    with blaming(Fault(field="method")):
        if not sources.references:
            raise OptionError(
                "there is nothing to keep step with: add under References the clip that does the same things in the "
                "same order"
            )
        if len(sources.references) > 1:
            raise OptionError(
                f"only one reference can be kept step with, and there are {len(sources.references)}: take the others "
                "out of References"
            )
    try:
        return AlignSession(motion, sources.references[0], repeat=repeat, **settings)
    except OptionError as error:
        if error.option != "repeat":
            raise
        raise FaultyError(error, Fault(field="repeat")) from error


def _corrected(document: Document, clips: list[AnyMotion]) -> list[tuple[float, float]] | None:
    """Return the flights of a document that corrects some; None where those that are found are right."""
    if not document.flights:
        return None
    end = clips[0].duration
    for mark in document.flights:
        if not 0 <= mark.start < mark.end <= end:
            with blaming(Fault(field="flights")):
                raise OptionError(
                    f"a flight from {mark.start:g} to {mark.end:g} s is no stretch of the clip, which lasts {end:g} s"
                )
    spans = {
        flies: [(mark.start, mark.end) for mark in document.flights if mark.flies is flies] for flies in (True, False)
    }
    return corrected_flights(flights_of(clips), flown=spans[True], grounded=spans[False])


def _carried_over(by_method: Solution) -> Solution:
    """Carry over to the whole clip what a document's method made of its example."""
    document, sources, example = by_method.document, by_method.sources, by_method.document.example
    assert example is not None
    clips = [sources.clips[i] for i in _searched(document)]
    rate = float(clips[0].rate)
    with blaming(Fault(field="example")):
        if not 0 <= example.start < example.end <= clips[0].duration:
            raise OptionError(
                f"an example from {example.start:g} to {example.end:g} s is no stretch of the clip, which lasts "
                f"{clips[0].duration:g} s"
            )
        first, last = (min(round(time * rate), clips[0].n_frames - 1) for time in (example.start, example.end))
        shown = _stretch_of(by_method.warp, first / rate, last / rate)
        hand = Warp(shown.output_times - shown.output_start, shown.input_times - first / rate)
    given = {
        name: value
        for stage in ("analysis", "solve")
        for name, value in _given(document, stage, "guided" if document.options.get("paper") else "hand").items()
        # The paper's way of searching weighs scores, and a hand's speeds have none.
        if document.options.get("paper") or (name, value) != ("search", "heuristic")
    }
    # The keytimes in the example are met by its own curve, where it stood before what lies before it followed.
    keys = [
        key_of(key)
        for key in document.keys
        if not example.start - 0.5 / rate < key.input_time < example.end + 0.5 / rate
    ]
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always", RetimeWarning)
        search = imitate(
            clips if len(clips) > 1 else clips[0],
            (first, last + 1),
            hand,
            keys=keys,
            locks=_locks(document),
            **{"length": "free", **given},
        )
    # What is to be said of the example stands in the result, for as long as that is looked at.
    said = () if search.example is None else search.example.warnings
    for warning in caught:
        if str(warning.message) not in said:
            warnings.warn(warning.message, stacklevel=2)
    return replace(by_method, warp=replace(search.warp, name=clips[0].name), search=search, hand=shown)


def _stretch_of(warp: Warp, start: float, end: float) -> Warp:
    """Cut a stretch of the input out of a warp."""
    outputs, inputs = warp.output_times, warp.input_times
    first = _crossing(outputs, inputs, start)
    # Backward from the end: the last moment that shows the end of the stretch.
    last = -_crossing(-outputs[::-1], inputs[::-1], end)
    if not first < last:
        raise OptionError(
            f"the curve does not play the example (input {start:.2f} to {end:.2f} s) from its beginning to its end: "
            "choose a stretch that it shows as a whole"
        )
    inside = outputs[(outputs > first) & (outputs < last)]
    times = np.concatenate([[first], inside, [last]])
    shown = warp(times)
    if shown.min() < start - _NEAR or shown.max() > end + _NEAR:
        raise OptionError(
            f"between the beginning and the end of the example (input {start:.2f} to {end:.2f} s) the curve shows "
            f"input {shown.min():.2f} to {shown.max():.2f} s: choose a stretch that holds all of that"
        )
    return Warp(times, shown)


def _crossing(outputs: FloatArray, inputs: FloatArray, wanted: float) -> float:
    """Return the first output time at which a polyline comes to an input time; inf where it never does."""
    away = inputs - wanted
    met = np.abs(away) <= _NEAR
    passed = np.concatenate([away[:-1] * away[1:] < 0, [False]]) & ~met
    places = np.flatnonzero(met | passed)
    if len(places) == 0:
        return math.inf
    i = int(places[0])
    if met[i]:
        return float(outputs[i])
    return float(outputs[i] - away[i] / (inputs[i + 1] - inputs[i]) * (outputs[i + 1] - outputs[i]))


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


def ghosts(solution: Solution) -> tuple[Warp, tuple[FloatArray, FloatArray]]:
    """Return what an animator has today through the same keytimes: straight lines, and the spline's slopes."""
    keytimes = solution.warp.keytimes
    with warnings.catch_warnings():
        # A tangent may be too steep for a spline; that says nothing about the guided warp, so nobody is warned.
        warnings.simplefilter("ignore", RetimeWarning)
        return linear_warp(keytimes), span_slopes(keytimes)
