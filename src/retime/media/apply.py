"""`retime_media`: a video, numbered pictures or sound with a warp's timing."""

from __future__ import annotations

from dataclasses import replace
from os import PathLike
from pathlib import Path
from typing import Any

from retime.checks import path_of
from retime.errors import FormatError, OptionError, OutputExistsError
from retime.files import beside, resolved, scratch, write_bytes
from retime.media.encoding import CONTAINERS
from retime.media.extras import refuse_without
from retime.media.job import OtherSound
from retime.media.kinds import is_sequence
from retime.media.options import MediaOptions
from retime.media.process import check_media, run
from retime.warp.curve import WarpLike, as_warp


def retime_media(
    path: str | PathLike[str],
    place: str | PathLike[str],
    warp: WarpLike,
    options: MediaOptions | None = None,
    *,
    sound: OtherSound | None = None,
    overwrite: bool = False,
) -> None:
    """Give a video, its sound, numbered pictures, or sound alone a warp's timing.

    Frames are shown where the warp has them, and averaged where it plays faster than life, as motions are (§3.4); sound
    is stretched with its pitch kept. The output appears whole or not at all. The work is done in a process of its own,
    which can open no other file and may die of a damaged one.

    Parameters
    ----------
    path : path-like
        The input. ``take.%04d.png`` stands for numbered pictures.
    place : path-like
        The output; its ending says what it is.
    warp : Warp or GuidedWarp
        From output time to input time. Its input time 0 is the moment of the first frame (or sample), `options.offset`
        aside.
    options : MediaOptions, optional
        How.
    sound : OtherSound, optional
        Of numbered pictures: what is heard beside them, by a warp of its own.
    overwrite : bool
        Replace what is there.

    Raises
    ------
    FormatError
        The file is not what it should be, is damaged, or names other files; or the output can't hold this.
    OutputExistsError
        The output is there, and `overwrite` is not set.
    OptionError
        Options that contradict each other or the file.
    MissingExtraError
        There is no PyAV, OpenCV or python-stretch.
    OSError
        A file can't be read or written.

    Warns
    -----
    RetimeWarning
        The warp and the file don't cover the same times, or something of the file can't be kept.
    """
    path, place = path_of(path, "retime_media(path, place, warp)"), path_of(place, "retime_media(path, place, warp)")
    warp = as_warp(warp, "retime_media(path, place, warp)")
    options = options or MediaOptions()
    refuse_without("av", "cv2")
    check_media(path)
    if sound is not None:
        if not is_sequence(path) or is_sequence(place):
            raise OptionError("sound of another file is for numbered pictures that become a video")
        check_media(sound.path)
    if not (is_sequence(place) or place.suffix.lower() in CONTAINERS):
        raise FormatError(
            f"nothing here writes {place.suffix or 'a file without an ending'}; known endings are "
            f"{', '.join(CONTAINERS)}, and numbered pictures (take.%04d.png)",
            path=place,
        )
    request = {
        "do": "retime",
        "path": str(resolved(path)),
        "place": str(place),
        "warp": replace(warp, name="").to_json(),
        "options": options.to_json(),
        "only_pictures": is_sequence(path) and sound is None,
    }
    if sound is not None:
        request["sound"] = {"path": str(resolved(sound.path)), "warp": replace(sound.warp, name="").to_json()}
    if is_sequence(place):
        _write_pictures(path, place, request, overwrite=overwrite)
        return
    with beside(place, overwrite=overwrite) as file:
        run({**request, "beside": file.name}, path)


def _write_pictures(path: Path, place: Path, request: dict[str, Any], *, overwrite: bool) -> None:
    """Have pictures written into one temporary file, then each put into its place."""
    found: list[tuple[str, int]] = []

    def take(fact: dict[str, Any]) -> None:
        if "picture" in fact:
            found.append((fact["picture"][0], fact["picture"][1]))

    with scratch(place.parent) as file:
        run({**request, "beside": file.name}, path, take)
        places = [place.with_name(name) for name, _ in found]
        if not overwrite:
            for one in places:
                if one.exists():
                    raise OutputExistsError(one)
        written: list[Path] = []
        try:
            for one, (_, size) in zip(places, found, strict=True):
                new = not one.exists()
                write_bytes(one, file.read(size), overwrite=overwrite)
                if new:
                    written.append(one)
        except BaseException:
            for one in written:
                one.unlink(missing_ok=True)
            raise
