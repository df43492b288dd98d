"""Reading whole files within limits, and writing them so that a crash leaves the old file or the new one."""

from __future__ import annotations

import contextlib
import errno
import os
import re
import secrets
import stat
import time
from collections.abc import Callable, Iterable, Iterator
from contextvars import ContextVar
from os import PathLike
from pathlib import Path
from typing import IO, Any, BinaryIO

from retime.errors import FormatError, OptionError, OutputExistsError

MOST_BYTES = 1 << 30
"""Of a file that is read, where nobody says otherwise."""

_BESIDE = re.compile(r"\.retime-[0-9a-f]{16}\.tmp")
# Seconds since the last byte was written, before a file that nobody holds is taken for a dead writer's.
_LEFT_ALONE = 600.0
_read_here: ContextVar[list[Path] | None] = ContextVar("_read_here", default=None)
_written_here: ContextVar[list[Path] | None] = ContextVar("_written_here", default=None)
# Folders that were looked at in this run.
_tidied: set[Path] = set()


def _contents(file: BinaryIO, most: int) -> bytes:
    return file.read(most)


def read_bytes(
    path: str | PathLike[str], most: int = MOST_BYTES, *, contents: Callable[[BinaryIO, int], bytes] = _contents
) -> bytes:
    """Read a file of at most `most` bytes.

    Parameters
    ----------
    path : path-like
        The file.
    most : int
        The limit.
    contents : callable
        Reads a file from its begin: so many bytes, or as many as it has.

    Raises
    ------
    FormatError
        The file is larger, or is not a regular file (a pipe would wait for ever, a device never ends).
    OSError
        The file can't be opened.
    """
    path = Path(path)
    note_read(path)
    status = path.stat()
    if stat.S_ISDIR(status.st_mode):
        raise FormatError("this is a folder, not a file", path=path)
    if not stat.S_ISREG(status.st_mode):
        raise FormatError("this is not a regular file", path=path)
    with path.open("rb") as file:
        # One byte more than it had a moment ago: the buffer is made before the reading, and the file may grow.
        data = contents(file, min(status.st_size, most) + 1)
    if len(data) > most:
        raise FormatError(
            f"the file has {max(status.st_size, len(data))} bytes, the limit is {most} (Limits.file_bytes)",
            path=path,
        )
    return data


def note_read(path: Path) -> None:
    """Note that a file is read, where somebody wants to know (`noting_reads`): by another process, or a library."""
    noted = _read_here.get()
    if noted is not None and path not in noted:
        noted.append(path)


@contextlib.contextmanager
def noting_reads() -> Iterator[list[Path]]:
    """Note which files are read inside, each once: a clip's own, and those that belong to it (a skeleton, a buffer)."""
    noted: list[Path] = []
    token = _read_here.set(noted)
    try:
        yield noted
    finally:
        _read_here.reset(token)


def note_written(path: Path) -> None:
    """Note that a file is written, or is there as it would be, where somebody wants to know (`noting_writes`)."""
    noted = _written_here.get()
    if noted is not None and path not in noted:
        noted.append(path)


@contextlib.contextmanager
def noting_writes() -> Iterator[list[Path]]:
    """Note which files are written inside, each once: a scene's own, its layers and its buffer, a clip's skeleton."""
    noted: list[Path] = []
    token = _written_here.set(noted)
    try:
        yield noted
    finally:
        _written_here.reset(token)


def write_bytes(path: str | PathLike[str], parts: bytes | Iterable[bytes], *, overwrite: bool) -> None:
    """Write a file beside its place, sync it, and rename it over; nothing is left behind where that fails.

    Parameters
    ----------
    path : path-like
        The place. A symbolic link is followed.
    parts : bytes or iterable of bytes
        What to write. An iterable is not begun where the file may not be written.
    overwrite : bool
        Replace a file that is there.

    Raises
    ------
    OutputExistsError
        The file is there, and `overwrite` is not set.
    FormatError
        What is there is a device, a pipe or a socket: a rename would put a file in its stead.
    OSError
        The folder is missing, links lead round in a circle, it can't be written, or the disk is full.
    """
    with beside(path, overwrite=overwrite) as file:
        for part in (parts,) if isinstance(parts, bytes) else parts:
            file.write(part)


@contextlib.contextmanager
def beside(path: str | PathLike[str], *, overwrite: bool) -> Iterator[BinaryIO]:
    """Open a file beside a place for writing, under a name of its own; in the end sync it, and rename it over.

    Where the block is left by an error nothing is left behind. Another process may write to the file by its name.

    Parameters
    ----------
    path : path-like
        The place. A symbolic link is followed.
    overwrite : bool
        Replace a file that is there.

    Raises
    ------
    OutputExistsError, FormatError, OSError
        As of `write_bytes`.
    """
    path = Path(path)
    if not overwrite and path.exists():
        raise OutputExistsError(path)
    # Follow a symbolic link, so that the rename replaces the file it means and not the link.
    place = resolved(path)
    _check_regular(place, path)
    name = name_beside(place)
    try:
        with name.open("xb") as file:
            _mark_as_alive(file)
            yield file
            file.flush()
            sync_file(file.fileno())
        if overwrite:
            # On Windows a file has no rights but to be read only, and one that is so is not replaced.
            if os.name != "nt" and place.exists():
                name.chmod(stat.S_IMODE(place.stat().st_mode))
            name.replace(place)
        else:
            _rename_to_free_name(name, place, path)
    except BaseException as error:
        name.unlink(missing_ok=True)
        if isinstance(error, OSError):
            _name_place(error, name, path)
        raise
    note_written(path)
    sync_folder(place.parent)


def _name_place(error: OSError, name: Path, path: Path) -> None:
    """Have an error about a file beside its place tell of the place: nobody knows the other name."""
    if not isinstance(error.filename, str | bytes | PathLike) or Path(os.fsdecode(error.filename)) != name:
        return
    error.filename, error.filename2 = str(path), None
    if os.name == "nt" and isinstance(error, PermissionError):
        error.strerror = f"{error.strerror} (the file is open in another program, or read only)"


def name_beside(place: Path) -> Path:
    """Return a name in a file's folder, free but for chance, to write under before the file is replaced.

    What writers who died have left in the folder under such names is removed, once in a run for each folder.
    """
    if place.parent not in _tidied:
        _tidied.add(place.parent)
        with contextlib.suppress(OSError):
            remove_left_overs(place.parent, _LEFT_ALONE)
    return place.with_name(f".retime-{secrets.token_hex(8)}.tmp")


@contextlib.contextmanager
def scratch(folder: str | PathLike[str]) -> Iterator[BinaryIO]:
    """Open a new file in a folder that another process may open by its name (``file.name``); it goes in the end.

    On Windows a `tempfile.NamedTemporaryFile` is opened by nobody else.

    Raises
    ------
    OSError
        The folder can't be written.
    """
    place = name_beside(Path(folder) / "scratch")
    try:
        # For nobody else's eyes.
        with open(place, "x+b", opener=lambda name, flags: os.open(name, flags, 0o600)) as file:
            _mark_as_alive(file)
            yield file
    finally:
        place.unlink(missing_ok=True)


def hold(file: IO[Any]) -> bool:
    """Take hold of an open, empty file until it is closed or the process ends; False where another has it.

    Where neither the system nor the file system has locks, nobody is kept out.
    """
    try:
        import fcntl
    except ImportError:
        return _hold_on_windows(file)
    try:
        fcntl.flock(file.fileno(), fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        return False
    except OSError:
        # A file system without locks.
        return True
    return True


def _hold_on_windows(file: IO[Any]) -> bool:
    try:
        import msvcrt
    except ImportError:
        return True
    file.seek(0)
    try:
        # Its first byte, which needs not be there.
        msvcrt.locking(file.fileno(), msvcrt.LK_NBLCK, 1)  # type: ignore[attr-defined, unused-ignore]
    except OSError:
        return False
    return True


def _mark_as_alive(file: BinaryIO) -> None:
    """Have the system say, for as long as this process lives, that a file is being written; not every one can."""
    with contextlib.suppress(ImportError, OSError):
        import fcntl

        fcntl.flock(file.fileno(), fcntl.LOCK_EX | fcntl.LOCK_NB)


def remove_left_overs(folder: Path, seconds: float = 0.0) -> None:
    """Remove what a writer has left who died, where nobody has written to it for so many seconds."""
    with os.scandir(folder) as entries:
        names = [entry.name for entry in entries if _BESIDE.fullmatch(entry.name)]
    for name in names:
        place = folder / name
        with contextlib.suppress(OSError):
            status = place.lstat()
            if not stat.S_ISREG(status.st_mode) or time.time() - status.st_mtime < seconds:
                continue
            _remove_unheld(place)


def _remove_unheld(place: Path) -> None:
    """Remove a file that no living writer holds; raise OSError where one does."""
    try:
        import fcntl
    except ImportError:
        # Windows removes no file that is open; elsewhere, without locks, nobody knows whether the writer lives.
        if os.name == "nt":
            place.unlink()
        return
    handle = os.open(place, os.O_RDONLY | os.O_NOFOLLOW)
    try:
        fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
        place.unlink()
    finally:
        os.close(handle)


def resolved(path: str | PathLike[str]) -> Path:
    """Return an absolute path without links; one of a circle of links is left as it is, for its opening to fail.

    `Path.resolve` raises errors that are no OSError, for such a circle and for a NUL.

    Raises
    ------
    OptionError
        The name holds a NUL, which no file's name can.
    """
    try:
        return Path(os.path.realpath(path))
    except ValueError:
        raise OptionError(f"{os.fspath(path)!r}: no file can have such a name") from None


def _check_regular(place: Path, path: Path) -> None:
    """Refuse to rename over what is no regular file."""
    try:
        mode = place.lstat().st_mode
    except FileNotFoundError:
        return
    if stat.S_ISLNK(mode):
        raise OSError(errno.ELOOP, os.strerror(errno.ELOOP), str(path))
    if stat.S_ISDIR(mode):
        raise IsADirectoryError(errno.EISDIR, os.strerror(errno.EISDIR), str(path))
    if not stat.S_ISREG(mode):
        raise FormatError("this is not a regular file (a device, a pipe or a socket); it is not replaced", path=path)


def _rename_to_free_name(beside: Path, place: Path, path: Path) -> None:
    """Rename, unless the name was taken meanwhile: a link fails then, where a rename would replace."""
    try:
        os.link(beside, place)
    except FileExistsError:
        raise OutputExistsError(path) from None
    except OSError:
        # A file system without links (FAT, some network drives): the moment between the two calls stays open.
        if place.exists():
            raise OutputExistsError(path) from None
        try:
            beside.rename(place)
        except FileExistsError:
            # Windows renames over nothing, so there the moment is none.
            raise OutputExistsError(path) from None
    else:
        beside.unlink()


def sync_file(handle: int) -> None:
    """Make sure that what was written to an open file is on the disk.

    macOS hands it to the drive, which may keep it in its own memory; there is another call that waits for the disk.
    """
    try:
        import fcntl

        fcntl.fcntl(handle, fcntl.F_FULLFSYNC)  # type: ignore[attr-defined, unused-ignore]
    except (ImportError, AttributeError, OSError):
        # Not macOS, or a file system that has no such call.
        os.fsync(handle)


def sync_folder(folder: Path) -> None:
    """Make sure that a folder's list of names is on the disk."""
    if os.name == "nt":
        return
    handle = os.open(folder, os.O_RDONLY)
    try:
        os.fsync(handle)
    except OSError as error:
        # Some network file systems can't sync a folder; the file itself is safe by now.
        if error.errno not in (errno.EINVAL, errno.ENOTSUP):
            raise
    finally:
        os.close(handle)
