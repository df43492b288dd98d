"""The editor in a notebook: the same view as `retime edit`, as a widget (extra ``notebook``).

Its messages are the page's (`retime.server.messages`), and travel over the widget's own channel to this process.
"""

from __future__ import annotations

import asyncio
import json
from collections.abc import Sequence
from os import PathLike
from pathlib import Path
from typing import Any

from retime.errors import FormatError, MissingExtraError, MissingPageError, OptionError
from retime.project.document import Document
from retime.project.places import Places
from retime.project.work import new_document, open_document, open_project, state_folder
from retime.server import PAGE, messages, no_page
from retime.server.messages import read_message, write_message
from retime.server.session import EditorSession, Outbox, welcome
from retime.warp.curve import Warp

try:
    import anywidget
    import traitlets
except ImportError as error:
    raise MissingExtraError("the editor in a notebook", package=error.name or "anywidget", extra="notebook") from error

AnyPath = str | PathLike[str]

# A cell that is run again shows what it showed before: a document is open once in this process.
_sessions: dict[tuple[asyncio.AbstractEventLoop, Document | Path], EditorSession] = {}


class EditorWidget(anywidget.AnyWidget):  # type: ignore[misc, unused-ignore]
    """The editor as a widget.

    Made by `edit`.

    Attributes
    ----------
    height : int
        Of the view, in CSS pixels.
    """

    height = traitlets.Int(720).tag(sync=True)

    def __init__(self, session: EditorSession, *, height: int = 720) -> None:
        self._session = session
        self._page = Outbox()
        self._sender: asyncio.Task[None] | None = None
        super().__init__(height=height)
        self.on_msg(self._heard)

    @property
    def _esm(self) -> str:
        return (PAGE / "widget.js").read_text(encoding="utf-8")

    @property
    def _css(self) -> str:
        return (PAGE / "widget.css").read_text(encoding="utf-8")

    @property
    def document(self) -> Document:
        """The document as it is now."""
        return self._session.document

    @property
    def warp(self) -> Warp | None:
        """The warp of the last document that could be solved; None before there is one."""
        return self._session.warp

    def close(self) -> None:
        """Close the view; the document stays open for the next."""
        self._session.leave(self._page)
        if self._sender is not None:
            self._sender.cancel()
        super().close()

    def _heard(self, widget: object, content: Any, buffers: object) -> None:
        """Hear a message of the page's."""
        try:
            message = read_message(json.dumps(content))
        except FormatError as error:
            self._session.refuse(self._page, error)
            return
        if not isinstance(message, messages.Hello):
            self._session.handle(self._page, message)
            return
        self.send(json.loads(write_message(welcome())))
        if message.version == messages.VERSION:
            # A second view of the same widget says hello too.
            self._session.leave(self._page)
            self._session.join(self._page)
            if self._sender is None:
                self._sender = asyncio.get_running_loop().create_task(self._send_all())

    async def _send_all(self) -> None:
        while True:
            payload = await self._page.get()
            if isinstance(payload, str):
                self.send(json.loads(payload))
            else:
                self.send({}, buffers=[payload])


def edit(
    *clips: AnyPath, reference: AnyPath | Sequence[AnyPath] = (), project: AnyPath | None = None, height: int = 720
) -> EditorWidget:
    """Edit the timing of a clip in the notebook.

    Parameters
    ----------
    *clips : path-like
        The clip, and others that get its warp.
    reference : path-like, or sequence of them
        Clips whose timing is imitated.
    project : path-like, optional
        A project file: opened, or begun with the clips where there is none.
    height : int
        Of the view, in CSS pixels.

    Returns
    -------
    EditorWidget
        Its ``warp`` is the warp as it is now.

    Raises
    ------
    OptionError
        Neither a clip nor a project, a project that has clips of its own, no event loop (outside of a notebook), or
        another editor has it open.
    MissingPageError
        This installation has no page.
    FormatError, OSError
        A file can't be read.
    """
    if not (PAGE / "widget.js").is_file():
        raise MissingPageError(no_page())
    try:
        loop = asyncio.get_running_loop()
    except RuntimeError:
        raise OptionError("the editor's widget needs a notebook; elsewhere use retime edit") from None
    references = [reference] if isinstance(reference, str | PathLike) else list(reference)
    if not clips and project is None:
        raise OptionError("name a clip to edit, or a project")
    document = new_document([str(clip) for clip in clips], [str(path) for path in references]) if clips else None
    place = None if project is None else Path(project).resolve()
    key = loop, place or document
    assert key[1] is not None
    session = _sessions.get((loop, key[1]))
    if session is None:
        if place is not None and place.exists() and document is not None:
            raise OptionError(f"{place} is there already, with clips of its own: open it without naming others")
        named = [Path(path) for path in (*clips, *references, *([] if place is None else [place]))]
        places = Places([Path.cwd(), *(path.resolve().parent for path in named)], named)
        if place is not None:
            work = open_project(place, document)
        else:
            assert document is not None
            work = open_document(document)
        session = _sessions[loop, key[1]] = EditorSession(work, places, state_folder())
    return EditorWidget(session, height=height)


async def close_all() -> None:
    """Close all documents; what was not saved is there again when they are opened next."""
    while _sessions:
        _, session = _sessions.popitem()
        await session.close()
