"""One document that is edited, by one page or several.

Three threads share the work. The event loop holds the document and its history, and never waits. The solver's thread
(`retime.server.solver_thread`) reads files, solves and exports; of the documents that wait for it, only the latest is
solved. The writer (`retime.server.disk_writer`) puts each change on the disk before the pages are told that it is safe;
of a drag whose positions wait for it, only the latest is written.
"""

from __future__ import annotations

import asyncio
import contextlib
import itertools
import secrets
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from importlib.metadata import version
from pathlib import Path
from typing import Literal

from retime.errors import OptionError
from retime.formats.compressed import plain_path
from retime.project.allowed_places import AllowedPlaces
from retime.project.document import MAX_NAME, Document, KeptWarp
from retime.project.export import check_no_input, export_motion
from retime.project.file import SUFFIX, files_of, warp_id
from retime.project.history import History
from retime.project.journal import Edit, Journal
from retime.project.recent import note_recent
from retime.project.workspace import Workspace, new_document, open_document, open_project
from retime.server import files, messages
from retime.server.audience import Audience
from retime.server.disk_writer import Change, DiskWriter
from retime.server.drawn_messages import kept_message
from retime.server.message_coding import write_message
from retime.server.messages import ServerMessage
from retime.server.outbox import Outbox
from retime.server.page_words import of_unopened
from retime.server.solver_thread import Findings, Job, SolverThread
from retime.server.unexpected import words_for_page
from retime.warp.curve import Warp

# Which run of the server this is.
_RUN = secrets.token_hex(8)


def welcome(command: str = "", key: str = "") -> messages.Welcome:
    """Return the answer to a page's first message; `command` and `key` are as `messages.Welcome` has them."""
    return messages.Welcome(messages.VERSION, version("retime"), files.OPENS, _RUN, command, key)


class ElsewhereError(OptionError):
    """Another page has changed the document since a page last heard of it."""


class SharedDocument:
    """A document, its history, its solver, and the pages that look at it.

    Parameters
    ----------
    workspace : Workspace
        What is open.
    places : AllowedPlaces
        Where it may read and write.
    state : Path
        Folder for what has no place of its own.
    """

    def __init__(self, workspace: Workspace, places: AllowedPlaces, state: Path) -> None:
        self._workspace = workspace
        self._places = places
        self._state_folder = state
        self._loop = asyncio.get_running_loop()
        self._audience = Audience()
        # Set when something was found, and when nothing ever will be: whoever waits looks again.
        self._answered = asyncio.Event()
        self._revision = 1
        # The first revision of the document that is open; what is found for an older one belongs to another document.
        self._first = 1
        self._opened = 0
        self._opening = False
        # What is on the disk; and after a change that could not be written, what should be, and why it is not.
        self._safe = self._state()
        self._unsafe: messages.Notice | None = None
        self._writer = DiskWriter(fault=self._writer_failed)
        self._solver = SolverThread(self._find, found=self._found)
        self._ask()

    async def close(self) -> None:
        """Put on the disk what waits for it, and end the threads."""
        await self._writer.close()
        await asyncio.to_thread(self._solver.close)
        self._workspace.close()

    @property
    def _history(self) -> History:
        return self._workspace.history

    @property
    def document(self) -> Document:
        """The document as it is now."""
        return self._history.present

    @property
    def path(self) -> Path | None:
        """The project file, if there is one."""
        return self._workspace.path

    @property
    def warp(self) -> Warp | None:
        """The warp of the last document that could be solved."""
        good = self._solver.good
        return None if good is None else good[1].warp

    async def solved(self) -> Warp:
        """Wait until the document as it is now is solved, and return its warp; raise what it can't be solved for."""
        while True:
            self._answered.clear()
            solution = self._solver.answer(self._revision)
            if solution is not None:
                return solution.warp
            await self._answered.wait()

    # Pages.

    def join(self, page: Outbox) -> None:
        """Tell a new page all there is."""
        self._audience.join(page, [*self._kept(), self._safe])
        for note in self._notes():
            page.put(note)
        if self._unsafe is not None:
            page.put(self._unsafe)

    def leave(self, page: Outbox) -> None:
        """Forget a page."""
        self._audience.leave(page)

    def _kept(self) -> list[ServerMessage]:
        return [kept_message(name, warp) for name, warp in self._workspace.warps.items()]

    def _notes(self) -> list[ServerMessage]:
        return [messages.Notice("warning", note) for note in self._workspace.notes]

    def _state(self) -> messages.State:
        workspace = self._workspace
        return messages.State(
            revision=self._revision,
            document=workspace.history.present,
            undo_label=workspace.history.undo_label,
            redo_label=workspace.history.redo_label,
            saved=workspace.is_saved,
            recovered=workspace.recovered,
            resumed=workspace.resumed,
            path=None if workspace.path is None else str(workspace.path),
            opened=self._opened,
        )

    # What pages ask for.

    def handle(self, page: Outbox, message: messages.PageMessage) -> None:
        """Do what a page asks for, or tell it why not."""
        try:
            self._handle(page, message)
        except ElsewhereError:
            page.put(messages.Elsewhere(self._revision))
            page.put(self._safe)
        except Exception as error:
            self.refuse(page, error)

    def refuse(self, page: Outbox, error: Exception) -> None:
        """Tell a page why what it asked for is not done, and how the document stands."""
        page.put(messages.Notice("error", words_for_page(error)))
        page.put(self._safe)

    def _handle(self, page: Outbox, message: messages.PageMessage) -> None:
        match message:
            case messages.Edit():
                self._check_next(message.revision)
                self._edit(page, message)
            case messages.Undo():
                self._check_next(message.revision)
                self._change(page, self._history.undo(), Journal.undo)
            case messages.Redo():
                self._check_next(message.revision)
                self._change(page, self._history.redo(), Journal.redo)
            case messages.Keep():
                self._check_next(message.revision)
                self._keep(page, message.name)
            case messages.Save():
                self._try(page, "save", message.path or "", lambda: self._save(page, message))
            case messages.Open():
                self._try(page, "open", message.path, lambda: self._open(page, message.path))
            case messages.Anew():
                self._try(page, "open", "", lambda: self._begin_anew(page))
            case messages.Export() | messages.ExportCurve():
                self._try(page, "export", message.path, lambda: self._export(page, message))
            case messages.Stop():
                self._solver.cancel(min(message.revision, self._revision))
            case messages.Browse():
                page.put(files.listing(self._places, message.folder, message.holds))
            case messages.Find():
                self._find_for(page, message)
            case messages.Hello():
                pass

    def _try(self, page: Outbox, what: Literal["open", "save", "export"], path: str, do: Callable[[], None]) -> None:
        """Open or write a file, or tell the page that asked why not: it has the path still."""
        try:
            do()
        except Exception as error:
            page.put(messages.Refused(what, path, words_for_page(error)))

    def _check_next(self, revision: int) -> None:
        if self._opening:
            raise OptionError("another document is being opened")
        if revision != self._revision + 1:
            raise ElsewhereError("the document was changed in another window meanwhile: look at it, and try again")

    def _edit(self, page: Outbox, message: messages.Edit) -> None:
        if len(message.label) > MAX_NAME or len(message.gesture) > MAX_NAME:
            raise OptionError(f"a label or a gesture is longer than {MAX_NAME} letters")
        for kept in message.document.kept:
            if kept.id not in self._workspace.warps:
                raise OptionError(f"there is no kept warp {kept.id!r}")
        edit = Edit(message.document, message.label, message.gesture, message.done)
        history = self._history.edit(edit.document, label=edit.label, gesture=edit.gesture, done=edit.done)
        self._writer.drop_last_of(edit.gesture)

        def write(journal: Journal, history: History, warps: Mapping[str, Warp]) -> None:
            journal.edit(edit, history, warps)

        self._change(page, history, write, gesture=edit.gesture, done=edit.done)

    def _keep(self, page: Outbox, name: str) -> None:
        if not name or len(name) > MAX_NAME:
            raise OptionError(f"a kept warp needs a name of 1 to {MAX_NAME} letters")
        document = self._history.present
        good = self._solver.good
        if good is None or good[0] != self._revision:
            raise OptionError("there is no warp to keep: wait for the curve, or solve its problem first")
        warp = good[1].warp
        kept = KeptWarp(warp_id(warp), name)
        if any(kept.id == other.id for other in document.kept):
            raise OptionError("this warp is kept already")
        edit = Edit(replace(document, kept=(*document.kept, kept)), f"keep {name}", "", True)
        history = self._history.edit(edit.document, label=edit.label)
        self._workspace.warps = {**self._workspace.warps, kept.id: warp}
        self._audience.tell(kept_message(kept.id, warp))

        def write(journal: Journal, history: History, warps: Mapping[str, Warp]) -> None:
            journal.keep(kept.id, warp, history, warps)
            journal.edit(edit, history, warps)

        self._change(page, history, write)

    def _change(
        self,
        page: Outbox,
        history: History,
        write: Callable[[Journal, History, Mapping[str, Warp]], None],
        *,
        gesture: str = "",
        done: bool = True,
    ) -> None:
        """Take a new history, have it solved, and tell the pages once it is on the disk.

        While a gesture is not `done`, a later change of it may take this one's place.
        """
        workspace, warps = self._workspace, self._workspace.warps
        workspace.history = history
        self._revision += 1
        self._audience.tell_others(page, messages.Elsewhere(self._revision))
        self._ask(gesture, in_hand=not done)
        state = self._state()

        def state_now() -> messages.State:
            # It may have been saved, under another name, since the edit was made.
            return replace(
                state,
                path=None if workspace.path is None else str(workspace.path),
                saved=history.present == workspace.saved,
                recovered=workspace.recovered,
            )

        def written() -> None:
            self._safe, self._unsafe = state_now(), None
            self._audience.tell(self._safe if done else messages.Ack(state.revision))

        def failed(error: Exception) -> None:
            words = f"the autosave can't be written, so this edit is not safe: {words_for_page(error)}"
            # Who is told the state from now on must know the revision, or no edit of theirs would be taken.
            self._safe, self._unsafe = state_now(), messages.Notice("error", words)
            self._audience.tell(self._unsafe)

        # Which journal is told when it is written: a save under another name, which waits still, changes that.
        goes_on = "" if done else gesture
        self._writer.put(Change(lambda: write(workspace.journal, history, warps), written, failed, goes_on))

    # Files.

    def _save(self, page: Outbox, message: messages.Save) -> None:
        if self._opening:
            # It would wait behind that, and this document's journal is closed by then.
            raise OptionError("another document is being opened")
        workspace, history, warps = self._workspace, self._history, self._workspace.warps
        path = workspace.path if message.path is None else self._places.find(message.path)
        if path is None:
            raise OptionError("the project has no name yet: say where to save it")
        check_no_input(path, history.present)
        place, revision = path, self._revision

        def done() -> None:
            self._places.add_folder(place.parent)
            # Edits that came meanwhile still wait to be written; the pages are told of them then.
            self._safe = replace(self._state(), revision=revision, document=history.present, saved=True)
            self._unsafe = None
            self._audience.tell(messages.Saved(str(place)), self._safe)

        def failed(error: Exception) -> None:
            page.put(messages.Refused("save", message.path or "", words_for_page(error)))

        def save() -> None:
            workspace.save(place, history, warps, overwrite=message.overwrite)
            note_recent(place, self._state_folder)

        self._writer.put(Change(save, done, failed))

    def _open(self, page: Outbox, text: str) -> None:
        place = self._places.find(text, reading=True)
        if self._opening:
            # Once the first is open, edits of it are taken; they would wait behind the second.
            raise OptionError("another document is being opened")
        if place == self._workspace.path:
            raise OptionError(f"{place} is open already")
        if place.suffix.lower() == SUFFIX:
            self._replace(page, text, lambda: self._noted(place, open_project(place)))
            return
        new = new_document([str(place)])

        def read(error: Exception | None, notices: list[messages.Notice]) -> None:
            if error is not None:
                self._opening = False
                page.put(messages.Refused("open", text, of_unopened(words_for_page(error))))
                return
            self._replace(
                page, text, lambda: self._noted(place, open_document(new, folder=self._state_folder)), notices
            )

        # What can't be read is refused while what is open stays.
        self._opening = True
        self._check(str(place), read)

    def _check(
        self,
        path: str,
        say: Callable[[Exception | None, list[messages.Notice]], None],
        *,
        may_be_told: bool = False,
    ) -> None:
        """Have a file read, and say in the event loop what is wrong with it, and what is to be told."""

        def checked(error: Exception | None, notices: list[messages.Notice]) -> None:
            with contextlib.suppress(RuntimeError):
                # The loop is closed already: the program is ending.
                self._loop.call_soon_threadsafe(say, error, notices)

        self._solver.check(path, checked, may_be_told=may_be_told)

    def _find_for(self, page: Outbox, message: messages.Find) -> None:
        """Say whether a file may be used, and where it is to be a clip or a reference, whether it can be read."""
        found = files.found(self._places, message)
        if not message.as_clip or found.refused is not None:
            page.put(found)
            return

        def read(error: Exception | None, notices: list[messages.Notice]) -> None:
            page.put(found if error is None else replace(found, place="", refused=words_for_page(error)))
            for notice in notices if error is None else ():
                page.put(notice)

        self._check(found.place, read, may_be_told=True)

    def _noted(self, place: Path, opened: Workspace) -> Workspace:
        """Note that a file was opened, for the list of those."""
        note_recent(place, self._state_folder)
        return opened

    def _begin_anew(self, page: Outbox) -> None:
        if self._opening:
            raise OptionError("another document is being opened")
        workspace = self._workspace
        self._replace(page, str(workspace.path or ""), lambda: workspace.begin_anew(self._state_folder), closes=True)

    def _replace(
        self,
        page: Outbox,
        text: str,
        open_it: Callable[[], Workspace],
        notices: Sequence[messages.Notice] = (),
        *,
        closes: bool = False,
    ) -> None:
        """Open something else in the document's place; where it can't be opened, what is open stays.

        `notices` are told with it; `open_it` opens it, in a thread, and where it `closes` what is open, that is done.
        """
        found: list[Workspace] = []
        self._opening = True

        def opened() -> None:
            found.append(open_it())
            if not closes:
                self._workspace.close()

        def done() -> None:
            self._opening = False
            self._workspace = found[0]
            self._revision += 1
            self._first = self._revision
            self._opened += 1
            self._solver.forget()
            self._audience.forget()
            self._ask()
            self._safe, self._unsafe = self._state(), None
            self._audience.tell(*self._kept(), self._safe, *self._notes(), *notices)

        def failed(error: Exception) -> None:
            self._opening = False
            page.put(messages.Refused("open", text, words_for_page(error)))

        self._writer.put(Change(opened, done, failed))

    def _export(self, page: Outbox, message: messages.Export | messages.ExportCurve) -> None:
        place = self._places.find(message.path)
        if place == self._workspace.path:
            raise OptionError(f"{place} is the project; choose another place")

        def say(answer: ServerMessage) -> None:
            self._loop.call_soon_threadsafe(page.put, answer)

        self._solver.export(message, self._job(), place, say)

    def drop(self, name: str, data: bytes, folder: Path) -> Path:
        """Keep a file that was dropped on the page, where pages may read from then on. Called in a thread.

        A project stays where it lies.
        """
        if name.lower().endswith(SUFFIX):
            return files.find_dropped(name, data, self._places)
        place = files.keep_dropped(name, data, folder)
        self._places.add_folder(folder)
        return place

    async def keep_output(self, folder: Path) -> Path:
        """Write the first clip as the warp of this very document shows it, where pages may read; return its place.

        Raises
        ------
        OptionError
            There is no warp yet, or the document asks for what can't be done.
        """
        solution = self._solver.answer(self._revision)
        if solution is None:
            raise OptionError("there is no output to keep: wait for the curve")

        def write() -> Path:
            source = plain_path(solution.document.clips[0].path)
            folder.mkdir(parents=True, exist_ok=True, mode=0o700)
            for number in itertools.count(1):
                place = folder / f"{source.stem}_output{'' if number == 1 else f'-{number}'}{source.suffix.lower()}"
                if not place.exists():
                    break
            export_motion(solution, 0, place, overwrite=False)
            return place

        place = await asyncio.to_thread(write)
        self._places.add_folder(folder)
        return place

    def files(self) -> set[str]:
        """List the files that the document needs, or would after undo."""
        history = self._history
        steps = [history.start, *(step.document for step in (*history.done, *history.undone))]
        return {path for document in steps for path in files_of(document)}

    def _find(self, path: str) -> Path:
        return self._places.find(path, reading=True, beside=files_of(self.document))

    # The other threads.

    def _ask(self, gesture: str = "", *, in_hand: bool = False) -> None:
        self._solver.ask(self._job(gesture, in_hand=in_hand))

    def _job(self, gesture: str = "", *, in_hand: bool = False) -> Job:
        return Job(self._revision, self._first, self._history.present, gesture, in_hand)

    def _found(self, findings: Findings) -> None:
        """Tell all pages what was found. Called in the solver's thread, which writes the messages."""
        ready = {name: (message, write_message(message)) for name, message in findings.messages.items()}

        def publish() -> None:
            self._answered.set()
            if findings.job.first != self._first:
                # Of a document that is not open any more.
                return
            if findings.counts is not None:
                self._audience.keep_clips(findings.counts)
            self._audience.publish(ready)

        with contextlib.suppress(RuntimeError):
            # The loop is closed already: the program is ending.
            self._loop.call_soon_threadsafe(publish)

    def _writer_failed(self, error: Exception) -> None:
        self._audience.tell(messages.Notice("error", words_for_page(error)))
