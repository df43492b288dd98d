"""The solver's thread: reads a document's files, solves it, explains the curve, and exports."""

from __future__ import annotations

import contextlib
import dataclasses
import math
import time
import warnings
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

from retime.errors import OptionError, RetimeError, RetimeWarning
from retime.motion.body import body_of
from retime.motion.kinematics import forget_poses
from retime.motion.motion import Motion
from retime.progress import watching
from retime.project.document import Document
from retime.project.export import check_no_input, export_for_host, export_motion, export_warp
from retime.project.faults import Fault, fault_of
from retime.project.reader import Find, Sources
from retime.project.solve import DocumentSolver, Solution
from retime.server import messages
from retime.server.drawn_messages import clip_messages, curve_message, why_message
from retime.server.freed_memory import give_back_freed_memory
from retime.server.latest_only_thread import LatestOnlyThread
from retime.server.messages import ServerMessage
from retime.server.page_words import page_words
from retime.server.unexpected import words_for_page

# Seconds in which nothing is asked for, before a curve is explained: explaining takes some times as long as solving.
_REST = 0.2
# The same while a hand holds something: it rests for a moment here and there.
_REST_IN_HAND = 1.0
# Seconds that a search may go on once a newer document waits, where that is not of the same drag: all positions of a
# drag need the same scores, so a search that is ended for the next of them would be begun anew, and never be done.
_PATIENCE = 2.0
# Seconds after which the pages are told how far a search is, and between two of those.
_LONG, _TOLD_EVERY = 0.3, 0.1


class SearchEndedError(Exception):
    """Nobody wants the answer of a search any more."""


@dataclass(frozen=True)
class Job:
    """A document to be solved.

    Attributes
    ----------
    revision : int
        Of the document.
    first : int
        The first revision of the document that is open: others with the same one are edits of the same.
    document : Document
        What to solve.
    gesture : str
        Of the edit that made it; "" where none did. Those of one drag have the same.
    in_hand : bool
        Whether that gesture goes on.
    """

    revision: int
    first: int
    document: Document
    gesture: str = ""
    in_hand: bool = False


@dataclass(frozen=True)
class Findings:
    """What was found of a job.

    Attributes
    ----------
    job : Job
        Of which.
    messages : dict of str
        To the pages, by what they are: ``curve``, ``problem``, ``clip 0``.
    counts : dict of str, optional
        How many clips and references there are, where that was found.
    """

    job: Job
    messages: dict[str, ServerMessage]
    counts: dict[str, int] | None = None


class SolverThread:
    """Solves in a thread of its own; of the documents that wait for it, only the latest.

    Parameters
    ----------
    find : function of str
        Returns the path of a file, or refuses it. Called in the thread, as the others are.
    found : function of Findings
        Called with all that is found.
    """

    def __init__(self, find: Find, found: Callable[[Findings], None]) -> None:
        self._solver = DocumentSolver(find)
        self._found = found
        # The document whose files the pages were shown last, and what those files held.
        self._shown: tuple[int, Sources] | None = None
        self._good: tuple[int, Solution] | None = None
        # The error of the revision that could not be solved.
        self._bad: tuple[int, BaseException] | None = None
        # The newest revision whose search nobody waits for any more, and the last one that is to be exported.
        self._cancelled = 0
        self._exported = 0
        self._worker = LatestOnlyThread(self._solve, name="retime-solver", failed=self._fail)

    @property
    def good(self) -> tuple[int, Solution] | None:
        """The last document that could be solved: its revision, and its solution."""
        return self._good

    def answer(self, revision: int) -> Solution | None:
        """Return a revision's solution, None while there is no answer; raise what it could not be solved for."""
        if self._good is not None and self._good[0] == revision:
            return self._good[1]
        if self._bad is not None and self._bad[0] == revision:
            raise self._bad[1]
        return None

    def ask(self, job: Job) -> None:
        """Have a document solved; forget one that still waits."""
        self._worker.submit(job)

    def cancel(self, revision: int) -> None:
        """End the search for a revision, and for those before it; the pages are told that it was ended."""
        self._cancelled = revision

    def forget(self) -> None:
        """Another document is open: a solution of the old one is no use."""
        self._good = None

    def check(
        self,
        path: str,
        say: Callable[[Exception | None, list[messages.Notice]], None],
        *,
        may_be_told: bool = False,
    ) -> None:
        """Have a file read; `say` is called, in the thread, with what is wrong, and what is to be told.

        A search that is at work does not hold this up: it goes on once the file is read. For `may_be_told` see
        `Reader.try_file`.
        """

        def read() -> None:
            notices: list[messages.Notice] = []
            error: Exception | None = None
            try:
                with _warnings_told(notices.append), watching(self._end_if_closed):
                    self._solver.try_file(path, may_be_told=may_be_told)
            except Exception as problem:
                error = problem
            say(error, notices)

        self._worker.add_aside(read)

    def export(
        self,
        message: messages.Export | messages.ExportCurve,
        job: Job,
        place: Path,
        say: Callable[[ServerMessage], None],
    ) -> None:
        """Have a document solved, unless it is, and exported; `say` is called with what came of it, in the thread."""
        self._exported = job.revision

        def export() -> None:
            try:
                with _warnings_told(say):
                    check_no_input(place, job.document)
                    solution = self.answer(job.revision) or self._search(job)
                    error = _write_export(message, solution, place)
            except Exception as problem:
                say(messages.Refused("export", message.path, words_for_page(problem)))
            else:
                what = message.what if isinstance(message, messages.Export) else "curve"
                say(messages.Exported(what, str(place), error))

        self._worker.add(export)

    def close(self) -> None:
        """End the thread; a search that is at work is ended, what is being written is not."""
        self._worker.close()

    def _end_if_closed(self, _: float = 0.0) -> None:
        if self._worker.stopped:
            raise SearchEndedError

    def _search(self, job: Job) -> Solution:
        """Find the warp of a document that is exported and was changed before it was found; a page can end this."""
        watch = _Watch(job, time.perf_counter(), lambda progress: self._tell(job, {"progress": progress}))
        watch.doing = "searching"

        def look(share: float) -> None:
            self._end_if_closed()
            if job.revision <= self._cancelled:
                raise SearchEndedError
            self._worker.do_asides()
            watch.look(share)

        try:
            with watching(look):
                return self._solver.solve(job.document)
        except SearchEndedError:
            raise OptionError("the search was stopped, so there is nothing to write") from None

    def _solve(self, job: Job) -> None:
        begin = time.perf_counter()
        solution = None
        watch = _Watch(job, begin, lambda progress: self._tell(job, {"progress": progress}))

        def look(share: float) -> None:
            if self._worker.stopped or job.revision <= self._cancelled:
                raise SearchEndedError
            newer = self._worker.newer
            if newer is not None and newer.first != job.first:
                # Another document is open.
                raise SearchEndedError
            another = newer is not None and not (job.gesture and newer.gesture == job.gesture)
            wanted = job.revision == self._exported
            if another and not wanted and time.perf_counter() - begin > _PATIENCE:
                raise SearchEndedError
            self._worker.do_asides()
            watch.look(share)

        try:
            with (
                _warnings_told(lambda notice: self._tell(job, {f"notice {notice.text}": notice})),
                watching(look),
            ):
                self._read(job)
                watch.doing = "searching"
                solution = self._solver.solve(job.document)
        except SearchEndedError:
            error = OptionError("the search was stopped, and the last curve stays: undo (Ctrl+Z), or change something")
            self._bad = job.revision, error
            if job.revision <= self._cancelled:
                self._tell(job, {"problem": messages.Problem(job.revision, str(error), None, None, None, None, None)})
            return
        except (RetimeError, OSError, MemoryError) as error:
            last = self._good
            self._refuse(job, error, fault_of(error, job.document, None if last is None else last[1].document))
            return
        self._good = job.revision, solution
        _forget_poses(solution.sources)
        self._tell(job, {"curve": curve_message(job.revision, solution, 1000 * (time.perf_counter() - begin))})
        if self._worker.idle(_REST_IN_HAND if job.in_hand else _REST):
            self._explain(job, solution)
            if not job.in_hand and self._worker.newer is None:
                # The hand rests, and all that it waited for is there.
                give_back_freed_memory()

    def _explain(self, job: Job, solution: Solution) -> None:
        def look(_: float) -> None:
            # Of a long take it takes a second or two, and the hand goes on.
            if self._worker.stopped or self._worker.newer is not None:
                raise SearchEndedError
            self._worker.do_asides()

        try:
            with watching(look):
                why = why_message(job.revision, solution)
        except SearchEndedError:
            pass
        except Exception as error:
            # The curve stands, whatever can be said of it.
            text = f"this curve can't be explained: {words_for_page(error)}"
            self._tell(job, {f"notice {text}": messages.Notice("error", text)})
        else:
            if why is not None:
                self._tell(job, {"why": why})

    def _fail(self, job: Job | None, error: BaseException) -> None:
        """Tell of what nobody expected."""
        # An errand tells by itself what it raises.
        if job is not None:
            self._refuse(job, error, Fault())

    def _refuse(self, job: Job, error: BaseException, fault: Fault) -> None:
        """Tell why a document can't be solved, or its curve not be shown, and what of it is at fault."""
        self._bad = job.revision, error
        problem = messages.Problem(job.revision, words_for_page(error), **dataclasses.asdict(fault))
        self._tell(job, {"problem": problem})

    def _read(self, job: Job) -> None:
        """Read a document's files, and tell the pages those that they have not been told."""
        sources = self._solver.read(job.document)
        if self._shown is not None and self._shown == (job.first, sources):
            return
        before = None if self._shown is None or self._shown[0] != job.first else self._shown[1]
        clips = clip_messages(sources, before)
        self._shown = job.first, sources
        counts = {"clip": len(sources.clips), "reference": len(sources.references)}
        self._found(Findings(job, {f"{clip.what} {clip.index}": clip for clip in clips}, counts))

    def _tell(self, job: Job, found: dict[str, ServerMessage]) -> None:
        self._found(Findings(job, found))


def _write_export(message: messages.Export | messages.ExportCurve, solution: Solution, place: Path) -> str:
    """Write what is asked for; return how far a curve is off, in words."""
    if isinstance(message, messages.ExportCurve):
        return export_for_host(
            solution,
            place,
            message.host,
            rate=message.rate,
            start=message.start,
            tolerance=message.tolerance,
            item=message.item,
            overwrite=message.overwrite,
        )
    if message.what == "motion":
        export_motion(solution, message.clip, place, overwrite=message.overwrite)
    elif message.what == "warp":
        export_warp(solution, place, overwrite=message.overwrite)
    else:
        from retime.evaluate.plot.warps import plot_with_baselines

        plot_with_baselines(
            solution.warp,
            solution.sources.clips[0],
            # An example that is carried over is found by a search, whatever made the example.
            method=solution.document.method if solution.hand is None else "guided",
            explanation=None if solution.search is None else solution.search.explain(),
            path=place,
            overwrite=message.overwrite,
        )
    return ""


def _forget_poses(sources: Sources) -> None:
    """Let go of the poses in space, of which the analysis and the messages have what they need."""
    for clip in (*sources.clips, *(clip for reference in sources.references for clip in reference.clips)):
        if isinstance(clip, Motion):
            for motion in (clip, body_of(clip)):
                forget_poses(motion)


class _Watch:
    """Tells how far a search is, once it has gone on for a while."""

    def __init__(self, job: Job, begin: float, tell: Callable[[messages.Progress], None]) -> None:
        self.doing: Literal["reading", "searching"] = "reading"
        self._job, self._tell = job, tell
        self._next = begin + _LONG

    def look(self, share: float) -> None:
        now = time.perf_counter()
        if now < self._next:
            return
        self._next = now + _TOLD_EVERY
        self._tell(messages.Progress(self._job.revision, self.doing, None if math.isnan(share) else share))


@contextlib.contextmanager
def _warnings_told(say: Callable[[messages.Notice], None]) -> Iterator[None]:
    """Show retime's own warnings on the page."""
    # Python has one list of warning filters for all threads. Only the solver's thread changes it.
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always", RetimeWarning)
        try:
            yield
        finally:
            for text in dict.fromkeys(str(warning.message) for warning in caught):
                say(messages.Notice("warning", page_words(text)))
