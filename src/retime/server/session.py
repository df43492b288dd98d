"""One document that is edited, by one page or several.

Three threads share the work. The event loop holds the document and its history, and never waits. The solver's thread
reads files, solves and exports; of the documents that wait for it, only the latest is solved. The writer puts each
change on the disk before the pages are told that it is safe; of a drag whose positions wait for it, only the latest is
written.
"""

from __future__ import annotations

import asyncio
import contextlib
import dataclasses
import time
import warnings
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace
from functools import partial
from importlib.metadata import version
from pathlib import Path

from retime.errors import FormatError, OptionError, RetimeError, RetimeWarning
from retime.formats.registry import FORMATS
from retime.project.document import MAX_NAME, Document, KeptWarp
from retime.project.export import check_no_input, export_motion, export_warp
from retime.project.file import SUFFIX, files_of, warp_id
from retime.project.history import History
from retime.project.journal import Edit
from retime.project.places import Places
from retime.project.solve import DocumentSolver, Solution, Sources, fault_of, words_of
from retime.project.work import Work, new_document, open_document, open_project
from retime.server import messages
from retime.server.messages import ServerMessage, type_name, write_message
from retime.server.pictures import clip_messages, curve_message, kept_message, why_message
from retime.server.solver import LatestOnly
from retime.warp.curve import Warp

# Seconds in which nothing is asked for, before a curve is explained: explaining takes some times as long as solving.
_REST = 0.2
_OPENS = tuple(suffix for known in FORMATS for suffix in known.suffixes)
_HOLDS = {"clip": (*_OPENS, SUFFIX), "skeleton": (".asf",), "joint map": (".json", ".csv")}


class Outbox:
    """What is to be sent to one page. A slow page gets the latest curve, not all of them."""

    def __init__(self) -> None:
        self._parts: dict[str, str | bytes] = {}
        self._count = 0
        self._filled = asyncio.Event()

    def put(self, message: ServerMessage, payload: str | bytes | None = None) -> None:
        """Send a message after those that wait; one that tells the same of a newer revision takes its place."""
        self._count += 1
        slot = str(self._count)
        if isinstance(message, messages.Curve | messages.Why | messages.Ack | messages.Problem):
            slot = type_name(type(message))
        self._parts.pop(slot, None)
        self._parts[slot] = write_message(message) if payload is None else payload
        self._filled.set()

    async def get(self) -> str | bytes:
        """Wait for the next."""
        while not self._parts:
            self._filled.clear()
            await self._filled.wait()
        return self._parts.pop(next(iter(self._parts)))


def welcome() -> messages.Welcome:
    """Return the answer to a page's first message."""
    return messages.Welcome(messages.VERSION, version("retime"), _OPENS)


@dataclass(frozen=True)
class _Job:
    revision: int
    # The first revision of the document that is open.
    first: int
    document: Document


@dataclass(frozen=True)
class _Change:
    """What the writer is to put on the disk, and what is said then."""

    write: Callable[[], None]
    done: Callable[[], None]
    failed: Callable[[Exception], None]
    # An edit of a gesture that goes on; a later edit of it may take its place.
    gesture: str = ""
    last: bool = False


class EditorSession:
    """A document, its history, its solver, and the pages that look at it.

    Parameters
    ----------
    work : Work
        What is open.
    places : Places
        Where it may read and write.
    state : Path
        Folder for what has no place of its own.
    """

    def __init__(self, work: Work, places: Places, state: Path) -> None:
        self._work = work
        self._places = places
        self._state_folder = state
        self._loop = asyncio.get_running_loop()
        self._pages: set[Outbox] = set()
        self._revision = 1
        # The first revision of the document that is open; what is found for an older one is of another document.
        self._first = 1
        self._opened = 0
        self._good: tuple[int, Solution] | None = None
        # Why a revision could not be solved; a search that has ended solves none any more.
        self._bad: tuple[int, Exception] | None = None
        self._dead: BaseException | None = None
        self._answered = asyncio.Event()
        self._shown: tuple[int, Sources] | None = None
        self._opening = False
        # What is on the disk.
        self._safe = self._state()
        # What a page that comes later has to be told, by what it is.
        self._latest: dict[str, tuple[ServerMessage, str | bytes]] = {}
        self._changes: list[_Change] = []
        self._changed = asyncio.Event()
        self._solver = DocumentSolver(lambda path: places.find(path, reading=True, beside=files_of(self.document)))
        self._worker = LatestOnly(self._solve, name="retime-solver", died=self._solver_died)
        self._writer = asyncio.create_task(self._write_all())
        self._writer.add_done_callback(self._writer_ended)
        self._ask()

    async def close(self) -> None:
        """Put on the disk what waits for it, and end the threads."""
        self._changed.set()
        self._changes.append(_Change(lambda: None, lambda: None, lambda error: None, last=True))
        await asyncio.wait([self._writer])
        await asyncio.to_thread(self._worker.close)
        self._work.close()

    @property
    def _history(self) -> History:
        return self._work.history

    @property
    def document(self) -> Document:
        """The document as it is now."""
        return self._history.present

    @property
    def warp(self) -> Warp | None:
        """The warp of the last document that could be solved."""
        return None if self._good is None else self._good[1].warp

    async def solved(self) -> Warp:
        """Wait until the document as it is now is solved, and return its warp; raise what it can't be solved for."""
        while True:
            self._answered.clear()
            if self._good is not None and self._good[0] == self._revision:
                return self._good[1].warp
            if self._bad is not None and self._bad[0] == self._revision:
                raise self._bad[1]
            if self._dead is not None:
                raise RuntimeError("a fault in retime ended the search") from self._dead
            await self._answered.wait()

    # Pages.

    def join(self, page: Outbox) -> None:
        """Tell a new page all there is."""
        clips = [found for found in self._latest.values() if isinstance(found[0], messages.Clip)]
        others = [found for found in self._latest.values() if not isinstance(found[0], messages.Clip)]
        for message, payload in clips:
            page.put(message, payload)
        for name, warp in self._work.warps.items():
            page.put(kept_message(name, warp))
        page.put(self._safe)
        for message, payload in others:
            page.put(message, payload)
        for note in self._work.notes:
            page.put(messages.Notice("warning", note))
        self._pages.add(page)

    def leave(self, page: Outbox) -> None:
        """Forget a page."""
        self._pages.discard(page)

    def _tell(self, *told: ServerMessage) -> None:
        for message in told:
            payload = write_message(message)
            for page in self._pages:
                page.put(message, payload)

    def _state(self) -> messages.State:
        work = self._work
        return messages.State(
            revision=self._revision,
            document=work.history.present,
            undo_label=work.history.undo_label,
            redo_label=work.history.redo_label,
            saved=work.is_saved,
            recovered=work.recovered,
            path=None if work.path is None else str(work.path),
            opened=self._opened,
        )

    # What pages ask for.

    def handle(self, page: Outbox, message: messages.PageMessage) -> None:
        """Do what a page asks for, or tell it why not."""
        try:
            self._handle(page, message)
        except (RetimeError, OSError) as error:
            page.put(messages.Notice("error", words_of(error)))
            page.put(self._safe)

    def refuse(self, page: Outbox, error: FormatError) -> None:
        """Answer something that is no message."""
        page.put(messages.Notice("error", str(error)))
        page.put(self._safe)

    def _handle(self, page: Outbox, message: messages.PageMessage) -> None:
        match message:
            case messages.Edit():
                self._check_next(message.revision)
                self._edit(message)
            case messages.Undo():
                self._check_next(message.revision)
                self._change(self._history.undo(), self._work.journal.undo)
            case messages.Redo():
                self._check_next(message.revision)
                self._change(self._history.redo(), self._work.journal.redo)
            case messages.Keep():
                self._check_next(message.revision)
                self._keep(message.name)
            case messages.Save():
                self._save(page, message)
            case messages.Open():
                self._open(page, message.path)
            case messages.Export():
                self._export(page, message)
            case messages.Browse():
                page.put(self._listing(message.folder, message.holds))
            case messages.Find():
                page.put(self._found(message))
            case messages.Hello():
                pass

    def _check_next(self, revision: int) -> None:
        if self._opening:
            raise OptionError("another document is being opened")
        if revision != self._revision + 1:
            raise OptionError("the document was changed in another window meanwhile: look at it, and try again")

    def _edit(self, message: messages.Edit) -> None:
        if len(message.label) > MAX_NAME or len(message.gesture) > MAX_NAME:
            raise OptionError(f"a label or a gesture is longer than {MAX_NAME} letters")
        for kept in message.document.kept:
            if kept.id not in self._work.warps:
                raise OptionError(f"there is no kept warp {kept.id!r}")
        edit = Edit(message.document, message.label, message.gesture, message.done)
        history = self._history.edit(edit.document, label=edit.label, gesture=edit.gesture, done=edit.done)
        waiting = self._changes[-1] if self._changes else None
        if edit.gesture and waiting is not None and waiting.gesture == edit.gesture:
            # The same key, dragged on before this was written.
            self._changes.pop()
        self._change(history, partial(self._work.journal.edit, edit), gesture="" if edit.done else edit.gesture)

    def _keep(self, name: str) -> None:
        if not name or len(name) > MAX_NAME:
            raise OptionError(f"a kept warp needs a name of 1 to {MAX_NAME} letters")
        document = self._history.present
        if self._good is None or self._good[0] != self._revision:
            raise OptionError("there is no warp to keep: wait for the curve, or solve its problem first")
        warp = self._good[1].warp
        kept = KeptWarp(warp_id(warp), name)
        if any(kept.id == other.id for other in document.kept):
            raise OptionError("this warp is kept already")
        journal = self._work.journal
        edit = Edit(replace(document, kept=(*document.kept, kept)), f"keep {name}", "", True)
        history = self._history.edit(edit.document, label=edit.label)
        self._work.warps = {**self._work.warps, kept.id: warp}
        self._tell(kept_message(kept.id, warp))

        def write(history: History, warps: Mapping[str, Warp]) -> None:
            journal.keep(kept.id, warp, history, warps)
            journal.edit(edit, history, warps)

        self._change(history, write)

    def _change(
        self, history: History, write: Callable[[History, Mapping[str, Warp]], None], *, gesture: str = ""
    ) -> None:
        """Take a new history, have it solved, and tell the pages once it is on the disk."""
        work, warps = self._work, self._work.warps
        work.history = history
        self._revision += 1
        self._ask()
        state = self._state()

        def done() -> None:
            self._safe = state
            self._tell(messages.Ack(state.revision) if gesture else state)

        def failed(error: Exception) -> None:
            words = f"the autosave can't be written, so this edit is not safe: {words_of(error)}"
            self._tell(messages.Notice("error", words))

        self._put(_Change(lambda: write(history, warps), done, failed, gesture))

    # Files.

    def _save(self, page: Outbox, message: messages.Save) -> None:
        work, history, warps = self._work, self._history, self._work.warps
        path = work.path if message.path is None else self._places.find(message.path)
        if path is None:
            raise OptionError("the project has no name yet: say where to save it")
        check_no_input(path, history.present)
        place, revision = path, self._revision

        def done() -> None:
            self._places.add_folder(place.parent)
            # What was edited meanwhile waits to be written; it is told then.
            self._safe = replace(self._state(), revision=revision, document=history.present, saved=True)
            self._tell(messages.Saved(str(place)), self._safe)

        def failed(error: Exception) -> None:
            page.put(messages.Notice("error", f"not saved: {words_of(error)}"))

        self._put(_Change(lambda: work.save(place, history, warps, overwrite=message.overwrite), done, failed))

    def _open(self, page: Outbox, text: str) -> None:
        place = self._places.find(text, reading=True)
        found: list[Work] = []
        self._opening = True

        def opened() -> None:
            if place == self._work.path:
                raise OptionError(f"{place} is open already")
            if place.suffix.lower() == SUFFIX:
                found.append(open_project(place))
            else:
                found.append(open_document(new_document([str(place)]), folder=self._state_folder))
            self._work.close()

        def done() -> None:
            self._opening = False
            self._work = found[0]
            self._revision += 1
            self._first = self._revision
            self._opened += 1
            self._good = None
            self._latest.clear()
            self._ask()
            self._safe = self._state()
            self._tell(
                *(kept_message(name, warp) for name, warp in self._work.warps.items()),
                self._safe,
                *(messages.Notice("warning", note) for note in self._work.notes),
            )

        def failed(error: Exception) -> None:
            self._opening = False
            page.put(messages.Notice("error", f"not opened: {words_of(error)}"))

        self._put(_Change(opened, done, failed))

    def _export(self, page: Outbox, message: messages.Export) -> None:
        place = self._places.find(message.path)
        document, project = self._history.present, self._work.path
        if place == project:
            raise OptionError(f"{place} is the project; choose another place")

        def say(answer: ServerMessage) -> None:
            self._loop.call_soon_threadsafe(page.put, answer)

        def export() -> None:
            try:
                with self._warnings_told(say):
                    self._write_export(message, document, place)
            except (RetimeError, OSError, MemoryError) as error:
                say(messages.Notice("error", f"not exported: {words_of(error)}"))
            else:
                say(messages.Exported(message.what, str(place)))

        self._worker.add(export)

    def _write_export(self, message: messages.Export, document: Document, place: Path) -> None:
        check_no_input(place, document)
        solution = self._solver.solve(document)
        if message.what == "motion":
            export_motion(solution, message.clip, place, overwrite=message.overwrite)
        elif message.what == "warp":
            export_warp(solution, place, overwrite=message.overwrite)
        else:
            from retime.evaluate.plot import plot_with_baselines

            plot_with_baselines(
                solution.warp,
                solution.sources.clips[0],
                method=document.options.method,
                explanation=None if solution.search is None else solution.search.explain(),
                path=place,
                overwrite=message.overwrite,
            )

    def _found(self, message: messages.Find) -> messages.Found:
        """Say whether a file may be used."""
        try:
            place = self._places.find(message.path, reading=not message.writing)
            if not message.writing and not place.is_file():
                raise OptionError(
                    f"{place}: " + ("a folder, not a file" if place.is_dir() else "there is no such file")
                )
        except (OptionError, OSError) as error:
            # What lies outside is not told, not even whether it is there.
            return messages.Found(message.path, "", words_of(error), False)
        return messages.Found(message.path, str(place), None, place.exists())

    def _listing(self, folder: str | None, holds: str) -> messages.Listing:
        place = self._places.find(folder or ".")
        with_kind = [(entry.name, entry.is_dir()) for entry in place.iterdir() if not entry.name.startswith(".")]
        names = sorted(with_kind, key=lambda pair: pair[0].casefold())
        return messages.Listing(
            str(place),
            str(place.parent) if place.parent != place and self._places.contains(place.parent) else None,
            tuple(name for name, is_folder in names if is_folder and _is_text(name)),
            tuple(
                name
                for name, is_folder in names
                if not is_folder and _is_text(name) and name.lower().endswith(_HOLDS[holds])
            ),
        )

    def drop(self, name: str, data: bytes, folder: Path) -> Path:
        """Keep a file that was dropped on the page; return its place. Called in a thread."""
        ending = Path(name).suffix.lower()
        if ending not in (*_OPENS, ".asf", ".json"):
            raise FormatError(f"no format ends in {ending or 'nothing'!r}", path=name)
        folder.mkdir(parents=True, exist_ok=True, mode=0o700)
        stem = Path(name).stem
        for number in range(1, 10_000):
            place = folder / (name if number == 1 else f"{stem}-{number}{ending}")
            try:
                with place.open("xb") as file:
                    file.write(data)
            except FileExistsError:
                if place.read_bytes() == data:
                    break
            else:
                break
        self._places.add_folder(folder)
        return place

    def files(self) -> set[str]:
        """List the files that the document needs, or would after undo."""
        history = self._history
        steps = [history.start, *(step.document for step in (*history.done, *history.undone))]
        return {path for document in steps for path in files_of(document)}

    # The writer.

    def _put(self, change: _Change) -> None:
        self._changes.append(change)
        self._changed.set()

    async def _write_all(self) -> None:
        while True:
            while not self._changes:
                self._changed.clear()
                await self._changed.wait()
            change = self._changes.pop(0)
            try:
                await asyncio.to_thread(change.write)
            except (RetimeError, OSError) as error:
                change.failed(error)
            else:
                change.done()
            if change.last:
                return

    # The solver's thread.

    def _ask(self) -> None:
        self._worker.submit(_Job(self._revision, self._first, self._history.present))

    def _solve(self, job: _Job) -> None:
        begin = time.perf_counter()
        solution = None
        try:
            with self._warnings_told(lambda notice: self._publish(job, {f"notice {notice.text}": notice})):
                sources = self._solver.read(job.document)
                if self._shown is None or self._shown != (job.first, sources):
                    before = None if self._shown is None or self._shown[0] != job.first else self._shown[1]
                    clips = clip_messages(sources, before)
                    self._shown = job.first, sources
                    counts = {"clip": len(sources.clips), "reference": len(sources.references)}
                    self._publish(job, {f"{clip.what} {clip.index}": clip for clip in clips}, counts)
                solution = self._solver.solve(job.document)
        except (RetimeError, OSError, MemoryError) as error:
            last = self._good
            fault = fault_of(error, job.document, None if last is None else last[1].document)
            self._bad = job.revision, error
            problem = messages.Problem(job.revision, words_of(error), **dataclasses.asdict(fault))
            self._publish(job, {"problem": problem})
            return
        self._good = job.revision, solution
        self._publish(job, {"curve": curve_message(job.revision, solution, 1000 * (time.perf_counter() - begin))})
        if self._worker.idle(_REST) and (why := why_message(job.revision, solution)) is not None:
            self._publish(job, {"why": why})

    def _solver_died(self, error: BaseException) -> None:
        words = f"a fault in retime ended the search ({error!r}): save, and start the editor again"
        self._dead = error
        with contextlib.suppress(RuntimeError):
            self._loop.call_soon_threadsafe(self._answered.set)
            self._loop.call_soon_threadsafe(self._tell, messages.Notice("error", words))

    def _writer_ended(self, writer: asyncio.Task[None]) -> None:
        error = None if writer.cancelled() else writer.exception()
        if error is not None:
            words = f"a fault in retime ended the autosave ({error!r}): what you do now is not safe"
            self._tell(messages.Notice("error", words))

    @contextlib.contextmanager
    def _warnings_told(self, say: Callable[[messages.Notice], None]) -> Iterator[None]:
        """Tell warnings of retime's to the page."""
        # What Python keeps of warnings is one for all threads; the solver's is the only one that changes it.
        with warnings.catch_warnings(record=True) as caught:
            warnings.simplefilter("always", RetimeWarning)
            try:
                yield
            finally:
                for text in dict.fromkeys(str(warning.message) for warning in caught):
                    say(messages.Notice("warning", text))

    def _publish(self, job: _Job, found: dict[str, ServerMessage], counts: Mapping[str, int] | None = None) -> None:
        """Send to all pages, and keep for those to come; of clips and references those that there are, by `counts`."""
        ready = {name: (message, write_message(message)) for name, message in found.items()}

        def publish() -> None:
            self._answered.set()
            if job.first != self._first:
                # Of a document that is not open any more.
                return
            for name, (message, _) in list(self._latest.items()):
                if counts is not None and isinstance(message, messages.Clip) and message.index >= counts[message.what]:
                    del self._latest[name]
            for name, (message, payload) in ready.items():
                if name == "curve":
                    self._latest.pop("problem", None)
                if isinstance(message, messages.Notice) and name in self._latest:
                    # Told before; each position of a drag would tell it again.
                    continue
                self._latest[name] = message, payload
                for page in self._pages:
                    page.put(message, payload)

        with contextlib.suppress(RuntimeError):
            # The loop is closed, where the program is ending.
            self._loop.call_soon_threadsafe(publish)


def _is_text(name: str) -> bool:
    try:
        name.encode()
    except UnicodeEncodeError:
        return False
    return True
