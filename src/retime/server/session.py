"""One document that is edited, by one page or several; everything but the solving runs on the event loop."""

from __future__ import annotations

import asyncio
import time
from collections.abc import Callable
from dataclasses import dataclass, replace

from retime.errors import RetimeError
from retime.project.document import ClipFile, Document
from retime.project.history import History
from retime.project.places import Places
from retime.project.solve import DocumentSolver, Solution, Sources, key_at_fault
from retime.server import messages
from retime.server.messages import ServerMessage, write_message
from retime.server.pictures import clip_messages, curve_message, why_message
from retime.server.solver import LatestOnly


class Outbox:
    """What is to be sent to one page. A slow page gets the latest curve, not all of them."""

    def __init__(self) -> None:
        self._parts: dict[str, str | bytes] = {}
        self._count = 0
        self._filled = asyncio.Event()

    def put(self, message: ServerMessage, payload: str | bytes) -> None:
        """Send a message after those that wait; one that tells the same of a newer revision takes its place."""
        self._count += 1
        slot = str(self._count)
        if isinstance(message, messages.Curve | messages.Why | messages.Ack | messages.Problem):
            slot = messages.type_name(type(message))
        self._parts.pop(slot, None)
        self._parts[slot] = payload
        self._filled.set()

    async def get(self) -> str | bytes:
        """Wait for the next."""
        while not self._parts:
            self._filled.clear()
            await self._filled.wait()
        slot = next(iter(self._parts))
        return self._parts.pop(slot)


@dataclass(frozen=True)
class _Job:
    revision: int
    document: Document


class EditorSession:
    """A document, its history, its solver, and the pages that look at it.

    Parameters
    ----------
    places : Places
        Where it may read and write.
    document : Document
        What to begin with.
    """

    def __init__(self, places: Places, document: Document) -> None:
        self._places = places
        self._loop = asyncio.get_running_loop()
        self._pages: set[Outbox] = set()
        self._history = History(document)
        self._revision = 1
        self._solver = DocumentSolver(lambda path: places.find(path, reading=True))
        self._shown: Sources | None = None
        self._good: Solution | None = None
        # What a page that comes later has to know, by what it is.
        self._latest: dict[str, tuple[ServerMessage, str | bytes]] = {}
        self._worker = LatestOnly(self._solve, name="retime-solver")
        self._ask()

    def close(self) -> None:
        """End the worker."""
        self._worker.close()

    def join(self, page: Outbox) -> None:
        """Tell a new page all there is."""
        for message, payload in [*self._latest.values()]:
            if isinstance(message, messages.Clip):
                page.put(message, payload)
        self._send(page, self._state())
        for message, payload in [*self._latest.values()]:
            if not isinstance(message, messages.Clip):
                page.put(message, payload)
        self._pages.add(page)

    def leave(self, page: Outbox) -> None:
        """Forget a page."""
        self._pages.discard(page)

    def handle(self, page: Outbox, message: messages.PageMessage) -> None:
        """Do what a page asks for."""
        match message:
            case messages.Edit():
                if self._is_next(page, message.revision):
                    self._change(
                        self._history.edit(message.document, label=message.label, gesture=message.gesture),
                        done=message.done,
                    )
            case messages.Undo():
                if self._is_next(page, message.revision):
                    self._change(self._history.undo(), done=True)
            case messages.Redo():
                if self._is_next(page, message.revision):
                    self._change(self._history.redo(), done=True)
            case _:
                self._send(page, messages.Notice("error", f"{messages.type_name(type(message))}: not yet"))

    def _is_next(self, page: Outbox, revision: int) -> bool:
        if revision == self._revision + 1:
            return True
        self._send(page, messages.Notice("warning", "the document was changed in another window: look again"))
        self._send(page, self._state())
        return False

    def _change(self, history: History, *, done: bool) -> None:
        self._history = history
        self._revision += 1
        self._ask()
        self._tell(self._state() if done else messages.Ack(self._revision))

    def _state(self) -> messages.State:
        history = self._history
        return messages.State(
            revision=self._revision,
            document=history.present,
            undo_label=history.undo_label,
            redo_label=history.redo_label,
            saved=False,
            recovered=False,
            path=None,
        )

    def _tell(self, message: ServerMessage) -> None:
        payload = write_message(message)
        for page in self._pages:
            page.put(message, payload)

    def _send(self, page: Outbox, message: ServerMessage) -> None:
        page.put(message, write_message(message))

    def _ask(self) -> None:
        self._worker.submit(_Job(self._revision, self._history.present))

    # In the worker's thread.

    def _solve(self, job: _Job) -> None:
        begin = time.perf_counter()
        try:
            sources = self._solver.read(job.document)
            if sources is not self._shown:
                clips = clip_messages(job.document, sources)
                self._shown = sources
                self._publish({f"{clip.what} {clip.index}": clip for clip in clips}, clear=("clip ", "reference "))
            solution = self._solver.solve(job.document)
        except (RetimeError, OSError, MemoryError) as error:
            self._publish({"curve problem": self._problem(job, error)})
            return
        self._good = solution
        curve = curve_message(job.revision, solution, 1000 * (time.perf_counter() - begin))
        self._publish({"curve": curve}, clear=("curve problem",))
        if not self._worker.waiting and (why := why_message(job.revision, solution)) is not None:
            self._publish({"curve why": why})

    def _problem(self, job: _Job, error: Exception) -> messages.Problem:
        last = self._good
        key = None
        if last is not None:
            key = key_at_fault(error, job.document, last.sources.clips[0], last.document)
        return messages.Problem(job.revision, str(error) or type(error).__name__, key, None)

    def _publish(self, found: dict[str, ServerMessage], clear: tuple[str, ...] = ()) -> None:
        """Send to all pages, and keep for those to come. Called in the worker's thread."""
        ready = {name: (message, write_message(message)) for name, message in found.items()}

        def publish() -> None:
            for name in [name for name in self._latest if name.startswith(clear)] if clear else []:
                del self._latest[name]
            self._latest |= ready
            for message, payload in ready.values():
                for page in self._pages:
                    page.put(message, payload)

        self._loop.call_soon_threadsafe(publish)


def new_document(clips: list[str], references: list[str]) -> Document:
    """Make a document of files, as a command line names them."""
    from retime.project.document import ReferenceFile

    first, *others = [ClipFile(path) for path in clips]
    return Document(
        (first, *(replace(other, role="follow") for other in others)),
        references=tuple(ReferenceFile(path) for path in references),
    )


Send = Callable[[str | bytes], None]
