"""The editor in a notebook: the same view as `retime edit`, as a widget (extra ``notebook``).

Its messages are the page's (`retime.server.messages`), and travel over the widget's own channel to this process.
"""

from __future__ import annotations

import asyncio
import json
from collections.abc import Sequence
from dataclasses import replace
from os import PathLike
from pathlib import Path
from typing import Any, TypeVar

from retime.brief import kind_of
from retime.errors import MissingExtraError, MissingPageError, OptionError
from retime.motion.any_motion import AnyMotion
from retime.motion.motion import Motion
from retime.motion.signal import Signal
from retime.project.allowed_places import AllowedPlaces
from retime.project.document import ClipFile, Document, ReferenceFile
from retime.project.from_memory import file_of
from retime.project.workspace import new_document, open_document, open_project, state_folder
from retime.server import PAGE, messages, no_page
from retime.server.message_coding import read_message, write_message
from retime.server.outbox import Outbox
from retime.server.shared_document import SharedDocument, welcome
from retime.warp.curve import Warp

try:
    import anywidget
    import traitlets
except ImportError as error:
    raise MissingExtraError("the editor in a notebook", package=error.name or "anywidget", extra="notebook") from error

AnyPath = str | PathLike[str]
AnyFile = TypeVar("AnyFile", ClipFile, ReferenceFile)

# A cell that is run again shows what it showed before: a document is open once in this process.
_open_documents: dict[tuple[asyncio.AbstractEventLoop, Document | Path], SharedDocument] = {}


class EditorWidget(anywidget.AnyWidget):  # type: ignore[misc, unused-ignore]
    """The editor as a widget.

    Made by `edit`.

    Attributes
    ----------
    height : int
        Of the view, in CSS pixels.
    """

    height = traitlets.Int(720).tag(sync=True)

    def __init__(self, shared: SharedDocument, *, height: int = 720) -> None:
        self._shared = shared
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
        return self._shared.document

    @property
    def warp(self) -> Warp | None:
        """The warp of the last document that could be solved; None before there is one."""
        return self._shared.warp

    async def ready(self) -> Warp:
        """Wait for the warp of the document as it is now: ``warp = await widget.ready()``.

        With "Run all" the next cell runs before the search has ended; this waits, whether a view is shown or not.

        Returns
        -------
        Warp
            Also in `warp` from then on.

        Raises
        ------
        RetimeError, OSError
            The document can't be solved; says why.
        """
        return await self._shared.solved()

    def __repr__(self) -> str:
        names = ", ".join(Path(clip.path).name for clip in self.document.clips)
        return f"EditorWidget({names}, warp={self.warp!r})"

    def close(self) -> None:
        """Close the view; the document stays open for the next."""
        self._shared.leave(self._page)
        if self._sender is not None:
            self._sender.cancel()
        super().close()

    def _heard(self, widget: object, content: Any, buffers: object) -> None:
        """Hear a message of the page's."""
        try:
            message = read_message(json.dumps(content))
        except Exception as error:
            self._shared.refuse(self._page, error)
            return
        if not isinstance(message, messages.Hello):
            self._shared.handle(self._page, message)
            return
        self.send(json.loads(write_message(welcome())))
        if message.version == messages.VERSION:
            # A second view of the same widget says hello too.
            self._shared.leave(self._page)
            self._shared.join(self._page)
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
    *clips: AnyPath | AnyMotion,
    reference: AnyPath | AnyMotion | Sequence[AnyPath | AnyMotion] = (),
    project: AnyPath | None = None,
    height: int = 720,
) -> EditorWidget:
    """Edit the timing of a clip in the notebook.

    Parameters
    ----------
    *clips : path-like, Motion or Signal
        The clip, and others that get its warp. What is no file yet is written to one (`retime.project.from_memory`),
        so that the same clip, passed again, is found as it was left.
    reference : path-like, Motion or Signal, or sequence of them
        Clips whose timing is imitated.
    project : path-like, optional
        A project file: opened, or begun with the clips where there is none.
    height : int
        Of the view, in CSS pixels.

    Returns
    -------
    EditorWidget
        Its ``warp`` is the warp as it is now; ``await widget.ready()`` waits for it.

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
    several = [reference] if isinstance(reference, str | PathLike | AnyMotion) else list(reference)
    if not clips and project is None:
        raise OptionError("name a clip to edit, or a project")
    files, references = [_path_of(clip) for clip in clips], [_path_of(clip) for clip in several]
    document = new_document(list(map(str, files)), list(map(str, references))) if clips else None
    if document is not None:
        # Of a clip that is held, what its file does not say.
        document = replace(
            document,
            clips=tuple(_as_held(file, clip) for file, clip in zip(document.clips, clips, strict=True)),
            references=tuple(_as_held(file, clip) for file, clip in zip(document.references, several, strict=True)),
        )
    place = None if project is None else Path(project).resolve()
    key = loop, place or document
    assert key[1] is not None
    shared = _open_documents.get((loop, key[1]))
    if shared is None:
        if place is not None and place.exists() and document is not None:
            raise OptionError(f"{place} is there already, with clips of its own: open it without naming others")
        named = [*files, *references, *([] if place is None else [place])]
        places = AllowedPlaces([Path.cwd(), *(path.resolve().parent for path in named)], named)
        if place is not None:
            workspace = open_project(place, document)
        else:
            assert document is not None
            workspace = open_document(document)
        shared = _open_documents[loop, key[1]] = SharedDocument(workspace, places, state_folder())
    return EditorWidget(shared, height=height)


def _path_of(clip: AnyPath | AnyMotion) -> Path:
    if isinstance(clip, AnyMotion):
        return file_of(clip, state_folder() / "notebook")
    if isinstance(clip, str | PathLike):
        return Path(clip)
    raise OptionError(f"expected edit(clip) with a path, a motion or a signal; found {kind_of(clip)}")


def _as_held(file: AnyFile, clip: object) -> AnyFile:
    if isinstance(clip, Signal) and clip.gaps == "keep":
        return replace(file, gaps="keep")
    if not isinstance(clip, Motion):
        return file
    return replace(file, up=None if clip.up == "y" else clip.up, root=clip.root)


async def close_all() -> None:
    """Close all documents; what was not saved is there again when they are opened next."""
    while _open_documents:
        _, shared = _open_documents.popitem()
        await shared.close()
