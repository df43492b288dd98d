"""What stands beside the stage: the video or sound that the document names, and its beats.

The page names no file here. It is given what the document as it is now names, if that is a media file by its name and
its first bytes, and lies where the editor may read.
"""

from __future__ import annotations

import asyncio
from collections.abc import Callable
from pathlib import Path

from starlette.requests import Request
from starlette.responses import FileResponse, JSONResponse, PlainTextResponse, Response
from starlette.routing import BaseRoute, Route

from retime.errors import FormatError, MissingExtraError, OptionError, RetimeError
from retime.media.beats import Found, read_beats
from retime.media.process import check_media
from retime.progress import watching
from retime.project.allowed_places import AllowedPlaces
from retime.project.document import BeatsFile, Document
from retime.server.unexpected import words_for_page

# What a browser is told that a file is, by its ending; others are called what most programs call them.
_TYPES = {
    ".mp4": "video/mp4", ".m4v": "video/mp4", ".mov": "video/quicktime", ".webm": "video/webm", ".ogv": "video/ogg",
    ".mkv": "video/x-matroska", ".avi": "video/x-msvideo", ".wav": "audio/wav", ".flac": "audio/flac",
    ".ogg": "audio/ogg", ".opus": "audio/ogg", ".mp3": "audio/mpeg", ".m4a": "audio/mp4", ".aac": "audio/aac",
}  # fmt: skip


class _EndedError(Exception):
    """Nobody waits for these beats any more."""


class BesideStage:
    """Gives the page what stands beside the stage.

    Parameters
    ----------
    document : function
        Returns the document as it is now.
    places : AllowedPlaces
        Where the editor may read.
    """

    def __init__(self, document: Callable[[], Document], places: AllowedPlaces) -> None:
        self._document, self._places = document, places
        self._one_at_a_time = asyncio.Lock()
        self._closed = False
        # The beats found last, and of what: a file that was changed is listened to again.
        self._known: tuple[tuple[object, ...], Found] | None = None

    @property
    def routes(self) -> list[BaseRoute]:
        """What the server answers to."""
        return [Route("/media", self._media), Route("/beats", self._beats)]

    def close(self) -> None:
        """End what is at work."""
        self._closed = True

    async def _media(self, request: Request) -> Response:
        media = self._document().media
        if media is None:
            return PlainTextResponse("the document has no video or sound beside the stage", 404)
        try:
            place = await asyncio.to_thread(self._checked, media.path)
        except (RetimeError, OSError) as error:
            return _refusal(error)
        return FileResponse(place, media_type=_TYPES.get(place.suffix.lower(), "application/octet-stream"))

    def _checked(self, path: str) -> Path:
        place = self._places.find(path, reading=True)
        check_media(place)
        return place

    async def _beats(self, request: Request) -> Response:
        document = self._document()
        beats = document.beats
        if beats is None:
            return PlainTextResponse("the document has no beats", 404)
        path = beats.path
        if path is None:
            # A document with beats of no file has media, or it would be none.
            assert document.media is not None
            path = document.media.path
        async with self._one_at_a_time:
            try:
                found = await asyncio.to_thread(self._found, path, beats)
            except _EndedError:
                return PlainTextResponse("the editor is ending", 503)
            except (RetimeError, OSError) as error:
                return _refusal(error)
            except Exception as error:
                return PlainTextResponse(words_for_page(error), 500)
        times, strengths, names = (list(column) for column in zip(*found, strict=True))
        return JSONResponse({"times": times, "strengths": strengths, "names": names})

    def _found(self, path: str, beats: BeatsFile) -> Found:
        place = self._places.find(path, reading=True)
        state = place.stat()
        of = (place, beats.on, state.st_mtime_ns, state.st_size)
        if self._known is None or self._known[0] != of:
            with watching(self._go_on):
                self._known = of, read_beats(place, on=beats.on)
        return self._known[1]

    def _go_on(self, _: float) -> None:
        if self._closed:
            raise _EndedError


def _refusal(error: RetimeError | OSError) -> Response:
    """Say why something is not given."""
    status = 500
    for kind, number in ((OptionError, 403), (MissingExtraError, 501), (FormatError, 415), (OSError, 404)):
        if isinstance(error, kind):
            status = number
            break
    return PlainTextResponse(words_for_page(error), status)
