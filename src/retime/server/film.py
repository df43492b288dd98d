"""Films of the stage: pictures that the page sends one after the other, encoded as a video at the end.

The page draws every frame, not when it is due but when it can: a film has exactly the frames that it should have. The
pictures are PNG; the media room decodes and encodes them in its process that may die.

A film may have the sound of what stands beside the stage. The page says when what of it is heard, as it plays it, and
names no file: it is that of the document.
"""

from __future__ import annotations

import asyncio
import secrets
import shutil
import tempfile
from collections.abc import Callable
from dataclasses import dataclass
from fractions import Fraction
from pathlib import Path

import numpy as np
from starlette.requests import Request
from starlette.responses import JSONResponse, PlainTextResponse, Response
from starlette.routing import BaseRoute, Route

from retime.errors import FormatError, OptionError, OutputExistsError, RetimeError
from retime.media.apply import retime_media
from retime.media.description import describe_media
from retime.media.extras import needed
from retime.media.job import OtherSound
from retime.media.kinds import ANIMATION_SUFFIXES
from retime.media.options import MediaOptions
from retime.media.process import check_media
from retime.motion.rate import parse_rate
from retime.progress import watching
from retime.project.allowed_places import AllowedPlaces
from retime.project.document import Document
from retime.project.export import check_no_input
from retime.server.unexpected import words_for_page
from retime.strict_json import parse_json
from retime.warp.curve import Warp
from retime.warp.keytime import Keytime

# Of one picture, and of one film: an hour at 30 frames a second.
_MOST_BYTES, _MOST_FRAMES = 64 << 20, 108_000
# Of when what is heard: some hundred thousand times.
_MOST_HEARD_BYTES = 16 << 20
# Seconds between moments that are not one.
_APART = 1e-6
# Films that are begun at a time: pages that were closed meanwhile leave theirs behind.
_MOST_FILMS = 4
# What holds all that there is of a picture, at every size.
_SUFFIXES = (".mp4", ".m4v", ".mov", ".webm", ".mkv", *ANIMATION_SUFFIXES)
_PNG = b"\x89PNG\r\n\x1a\n"
_PATTERN = "%06d.png"


class _StoppedError(Exception):
    """The film is not wanted any more."""


@dataclass
class _Film:
    place: Path
    rate: Fraction
    n_frames: int
    overwrite: bool
    folder: Path
    sound: OtherSound | None = None
    n_got: int = 0
    stopped: bool = False


class Films:
    """Takes films of the stage.

    Parameters
    ----------
    document : function
        Returns the document as it is now: none of its files is overwritten.
    project : function
        Returns the project file, if there is one.
    places : AllowedPlaces
        Where the editor may write.
    """

    def __init__(
        self, document: Callable[[], Document], project: Callable[[], Path | None], places: AllowedPlaces
    ) -> None:
        self._document, self._project, self._places = document, project, places
        self._films: dict[str, _Film] = {}

    @property
    def routes(self) -> list[BaseRoute]:
        """What the server answers to."""
        return [
            Route("/film", self._begin, methods=["POST"]),
            Route("/film/{name}/{number:int}", self._take, methods=["POST"]),
            Route("/film/{name}/end", self._end, methods=["POST"]),
            Route("/film/{name}/stop", self._stop, methods=["POST"]),
        ]

    def close(self) -> None:
        """Forget all films that are not done."""
        for name in list(self._films):
            self._forget(name)

    async def _begin(self, request: Request) -> Response:
        try:
            heard = await request.body()
            if len(heard) > _MOST_HEARD_BYTES:
                raise OptionError(f"what is heard takes more than {_MOST_HEARD_BYTES} bytes to say")
            film = await asyncio.to_thread(self._begun, dict(request.query_params), heard)
        except OutputExistsError as error:
            return PlainTextResponse(words_for_page(error), 409)
        except (RetimeError, OSError) as error:
            return PlainTextResponse(words_for_page(error), 400)
        while len(self._films) >= _MOST_FILMS:
            self._forget(next(iter(self._films)))
        name = secrets.token_hex(16)
        self._films[name] = film
        return JSONResponse({"film": name, "heard": film.sound is not None})

    def _begun(self, given: dict[str, str], heard: bytes) -> _Film:
        """Check all that can be checked before the first picture is drawn."""
        for module in ("av", "cv2"):
            needed(module)
        place = self._places.find(given.get("path", ""))
        if place.suffix.lower() not in _SUFFIXES:
            raise FormatError(f"a film's name ends in one of {', '.join(_SUFFIXES)}", path=place)
        check_no_input(place, self._document())
        if place == self._project():
            raise OptionError(f"{place} is the project; choose another place")
        overwrite = given.get("overwrite") == "true"
        if place.exists() and not overwrite:
            raise OutputExistsError(place)
        frames = given.get("frames", "")
        if not (frames.isascii() and frames.isdigit() and len(frames) < 10 and 2 <= int(frames) <= _MOST_FRAMES):
            raise OptionError(f"a film has 2 to {_MOST_FRAMES} frames, found {frames[:20]!r}")
        rate = parse_rate(given.get("rate", ""))
        sound = self._sound(heard, place, (int(frames) - 1) / float(rate)) if heard else None
        return _Film(place, rate, int(frames), overwrite, Path(tempfile.mkdtemp(prefix="retime-film-")), sound)

    def _sound(self, heard: bytes, place: Path, seconds: float) -> OtherSound | None:
        """Return what is heard in a film of so many seconds; None where the file beside the stage has no sound."""
        media = self._document().media
        if media is None:
            raise OptionError("there is no video and no sound beside the stage whose sound the film could have")
        if place.suffix.lower() in ANIMATION_SUFFIXES:
            raise OptionError(f"a {place.suffix} has no sound: choose .mp4 or .webm, or leave its sound out")
        needed("python_stretch")
        path = self._places.find(media.path, reading=True)
        check_media(path)
        warp = _heard_warp(heard, seconds)
        kinds = [stream["type"] for stream in describe_media(path)["streams"]]
        return OtherSound(path, warp) if "audio" in kinds else None

    async def _take(self, request: Request) -> Response:
        film = self._films.get(request.path_params["name"])
        number = request.path_params["number"]
        if film is None or film.stopped:
            return PlainTextResponse("there is no such film: it was stopped, or the editor was started anew", 404)
        if number != film.n_got or number >= film.n_frames:
            return PlainTextResponse(f"expected picture {film.n_got} of {film.n_frames}, found {number}", 409)
        data = await request.body()
        if len(data) > _MOST_BYTES or not data.startswith(_PNG):
            return PlainTextResponse("expected a picture as PNG", 415)
        if film.n_got != number or film.stopped:
            return PlainTextResponse("this picture came twice, or too late", 409)
        film.n_got += 1
        try:
            await asyncio.to_thread((film.folder / (_PATTERN % number)).write_bytes, data)
        except OSError as error:
            return PlainTextResponse(f"the picture can't be kept: {words_for_page(error)}", 507)
        return Response(status_code=204)

    async def _end(self, request: Request) -> Response:
        name = request.path_params["name"]
        film = self._films.get(name)
        if film is None:
            return PlainTextResponse("there is no such film: it was stopped, or the editor was started anew", 404)
        if film.n_got != film.n_frames:
            return PlainTextResponse(f"expected {film.n_frames} pictures, found {film.n_got}", 409)
        try:
            await asyncio.to_thread(_encode, film)
        except _StoppedError:
            return PlainTextResponse("the film was stopped", 410)
        except (RetimeError, OSError) as error:
            return PlainTextResponse(words_for_page(error), 400)
        except Exception as error:
            return PlainTextResponse(words_for_page(error), 500)
        finally:
            self._forget(name)
        return JSONResponse({"path": str(film.place)})

    async def _stop(self, request: Request) -> Response:
        self._forget(request.path_params["name"])
        return Response(status_code=204)

    def _forget(self, name: str) -> None:
        film = self._films.pop(name, None)
        if film is not None:
            film.stopped = True
            shutil.rmtree(film.folder, ignore_errors=True)


def _heard_warp(heard: bytes, seconds: float) -> Warp:
    """Read when what is heard: seconds of the film and of the file, and which of the former are keytimes.

    Raises
    ------
    OptionError, FormatError
        It says something else.
    """
    said = parse_json(heard, what="what is heard")
    problem = OptionError("what is heard is said by times of the film and of the file, as many of each")
    try:
        times, values, keys = (np.array(said[name], dtype=np.float64) for name in ("times", "values", "keys"))
    except (ValueError, TypeError, KeyError):
        raise problem from None
    if not (times.ndim == values.ndim == keys.ndim == 1 and len(times) == len(values) >= 2):
        raise problem
    if not all(np.isfinite(one).all() for one in (times, values, keys)) or (np.diff(times) <= 0).any():
        raise problem
    # As long as the film, whose last frame is the last that fits. What is as good as at a keytime is that keytime.
    keys = np.unique(keys[(keys > _APART) & (keys < seconds - _APART)])
    others = times[(times > _APART) & (times < seconds - _APART)]
    others = others[[not len(keys) or np.abs(keys - time).min() > _APART for time in others.tolist()]]
    moments = np.unique(np.concatenate([[0.0], keys, others, [seconds]]))
    places = np.interp(moments, times, values)
    pairs = zip(keys.tolist(), np.interp(keys, times, values).tolist(), strict=True)
    return Warp(moments, places, tuple(Keytime(input_time=place, output_time=key) for key, place in pairs))


def _encode(film: _Film) -> None:
    """Write the film: every picture once, for a frame."""

    def go_on(_: float) -> None:
        if film.stopped:
            raise _StoppedError

    last = (film.n_frames - 1) / float(film.rate)
    times = np.array([0.0, last])
    # What every player shows; left out, the colours of the pictures would be kept, which many do not.
    form = None if film.place.suffix.lower() in ANIMATION_SUFFIXES else "yuv420p"
    options = MediaOptions(frames="nearest", fps=film.rate, rate=film.rate, pixel_format=form)
    pictures = film.folder / _PATTERN
    with watching(go_on):
        retime_media(pictures, film.place, Warp(times, times), options, sound=film.sound, overwrite=film.overwrite)
