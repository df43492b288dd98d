"""The files that a page may see: listed, asked for, and dropped on it."""

from __future__ import annotations

import os
from pathlib import Path

from retime.errors import FormatError, OptionError
from retime.file_names import usable_name
from retime.formats.compressed import COMPRESSED, plain_path
from retime.formats.registry import FORMATS
from retime.media.kinds import SOUND_SUFFIXES, VIDEO_SUFFIXES
from retime.project.allowed_places import AllowedPlaces
from retime.project.file import SUFFIX
from retime.server import messages
from retime.server.unexpected import words_for_page

# The endings of the files that hold clips, but for one that most files with it don't.
OPENS = tuple(
    suffix + packed
    for known in FORMATS
    if not known.shared_ending
    for suffix in known.suffixes
    for packed in ("", *COMPRESSED)
)
# And those of what can stand beside the stage.
MEDIA = (*VIDEO_SUFFIXES, *SOUND_SUFFIXES)
# What the page may look for, and the endings of the files that hold it.
_HOLDS = {
    "clip": (*OPENS, SUFFIX),
    "skeleton": (".asf",),
    "joint map": (".json", ".csv"),
    "media": MEDIA,
    "beats": (".csv", ".txt", *MEDIA),
}


def listing(places: AllowedPlaces, folder: str | None, holds: str) -> messages.Listing:
    """List a folder, by default the first that may be used: its folders, and the files that hold what is looked for."""
    place = places.find(folder or ".")
    with_kind = [(entry.name, entry.is_dir()) for entry in place.iterdir() if not entry.name.startswith(".")]
    names = sorted(with_kind, key=lambda pair: pair[0].casefold())
    return messages.Listing(
        str(place),
        str(place.parent) if place.parent != place and places.contains(place.parent) else None,
        tuple(name for name, is_folder in names if is_folder and _is_text(name)),
        tuple(
            name
            for name, is_folder in names
            if not is_folder and _is_text(name) and name.lower().endswith(_HOLDS[holds])
        ),
    )


def found(places: AllowedPlaces, message: messages.Find) -> messages.Found:
    """Say whether a file may be used."""
    try:
        place = places.find(message.path, reading=not message.writing)
        if not message.writing and not place.is_file():
            raise OptionError(f"{place}: " + ("a folder, not a file" if place.is_dir() else "there is no such file"))
    except (OptionError, OSError) as error:
        # Of a file outside the allowed folders nothing is told, not even whether it exists.
        return messages.Found(message.path, "", words_for_page(error), False)
    return messages.Found(message.path, str(place), None, place.exists())


def keep_dropped(name: str, data: bytes, folder: Path) -> Path:
    """Keep a file that was dropped on the page; return its place."""
    name = usable_name(name)
    stem = plain_path(name).stem
    ending = Path(name).name[len(stem) :].lower()
    if ending not in (*OPENS, *MEDIA, ".asf", ".json", ".txt"):
        raise FormatError(f"no format ends in {ending or 'nothing'!r}", path=name)
    folder.mkdir(parents=True, exist_ok=True, mode=0o700)
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
    return place


# Of the folders that may be used: how deep a project is looked for that was dropped, and among how many files.
_MOST_DEEP, _MOST_FILES = 4, 20_000


def find_dropped(name: str, data: bytes, places: AllowedPlaces) -> Path:
    """Find the project that was dropped on the page: it names files beside it, so a copy elsewhere is no use.

    Raises
    ------
    FormatError
        None of that name and content lies in the folders that may be used.
    """
    seen = 0
    for folder in places.folders:
        for root, folders, names in os.walk(folder):
            if len(Path(root).relative_to(folder).parts) >= _MOST_DEEP:
                folders.clear()
            folders[:] = sorted(one for one in folders if not one.startswith("."))
            seen += len(names)
            place = Path(root) / name
            if name in names and place.stat().st_size == len(data) and place.read_bytes() == data:
                return place
            if seen > _MOST_FILES:
                break
    raise FormatError(
        "a browser does not say where a project lies, which names files beside it, and none like it is in the folders "
        "that the editor may use. Type its path under Open (Ctrl+O), or start: retime edit --project PATH",
        path=name,
    )


def _is_text(name: str) -> bool:
    try:
        name.encode()
    except UnicodeEncodeError:
        return False
    return True
