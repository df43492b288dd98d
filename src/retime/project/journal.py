"""Autosave: a file that grows by a line for everything that is done.

A line is on the disk before the page is told that the edit is safe. A line that was cut off when the machine or the
program died fails its checksum and counts as not written; all before it counts. What can't be written (the disk is
full) leaves the lines before it as they were, and the next write begins the file anew. A line counts as written only
if the file still stands where the next editor will look for it: a folder may be removed or renamed under an open file.
"""

from __future__ import annotations

import contextlib
import errno
import itertools
import json
import os
import stat
import zlib
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from typing import Any, BinaryIO

from retime.errors import FormatError, OptionError
from retime.files import hold, name_beside, read_bytes, sync_file, sync_folder
from retime.project.dataclass_json import from_value, to_value
from retime.project.document import Document
from retime.project.file import read_warps
from retime.project.history import History
from retime.project.versions import read_old_document
from retime.strict_json import parse_json
from retime.warp.curve import Warp

VERSION = 2
# Its documents are of version 2 of the project file, or older.
_OLD = 1
# A journal larger than this, and than twice what its history needs, is written anew.
_LARGE = 4 << 20
# Bytes that are put together before they are written.
_PIECE = 1 << 16


@dataclass(frozen=True)
class Edit:
    """An edit as it is written down; see `History.edit`."""

    document: Document
    label: str
    gesture: str
    done: bool


@dataclass(frozen=True)
class Recovered:
    """What a journal holds.

    Attributes
    ----------
    history : History
        The document and its steps.
    warps : dict of str to Warp
        Those that its documents keep.
    base : str
        Digest of the project file that the journal began with; "" where there was none.
    saves : tuple of (str, Document)
        For each save begun the digest of the file to be, and what it holds; the latest last.
    """

    history: History
    warps: dict[str, Warp] = field(default_factory=dict)
    base: str = ""
    saves: tuple[tuple[str, Document], ...] = ()


def read_journal(path: Path) -> Recovered:
    """Read a journal up to the first line that is not whole.

    Raises
    ------
    FormatError
        Not one whole line of a journal.
    OSError
        It can't be opened.
    """
    lines = list(_whole_lines(read_bytes(path)))
    head = lines[0] if lines else None
    if (
        not isinstance(head, dict)
        or head.get("format") != "retime-journal"
        or head.get("version") not in (_OLD, VERSION)
    ):
        raise FormatError("not a journal that this program reads", path=path)
    try:
        return _replayed(head, lines[1:])
    except (FormatError, KeyError) as error:
        raise FormatError(f"not a journal that this program wrote: {error}", path=path) from None


def _replayed(head: dict[str, Any], lines: list[dict[str, Any]]) -> Recovered:
    read = read_old_document if head["version"] == _OLD else partial(from_value, Document)
    history = History(read(head["start"], "start"))
    warps: dict[str, Warp] = {}
    saves = []
    for line in lines:
        match line["did"]:
            case "edit":
                document = read(line["document"], "document")
                history = history.edit(
                    document, label=str(line["label"]), gesture=str(line["gesture"]), done=line["done"] is True
                )
            case "undo":
                history = history.undo()
            case "redo":
                history = history.redo()
            case "keep":
                if not isinstance(line["id"], str):
                    raise FormatError("a warp is kept by no name")
                warps |= read_warps({line["id"]: line["warp"]})
            case "save":
                saves.append((str(line["digest"]), history.present))
            case other:
                raise FormatError(f"{other!r} is nothing that is done")
    return Recovered(history, warps, str(head["base"]), tuple(saves))


def _whole_lines(data: bytes) -> Iterable[dict[str, Any]]:
    for line in data.split(b"\n")[:-1]:
        checksum, _, text = line.partition(b" ")
        if checksum != _checksum(text):
            return
        value = parse_json(text)
        if not isinstance(value, dict):
            return
        yield value


def _checksum(text: bytes) -> bytes:
    return b"%08x" % zlib.crc32(text)


def _line(value: Mapping[str, Any]) -> bytes:
    text = json.dumps(value, allow_nan=False, ensure_ascii=True).encode()
    return _checksum(text) + b" " + text + b"\n"


class Journal:
    """A journal that is written.

    As long as it is open, no other editor can open it. Every method takes the history as it is afterwards, and the
    warps that its documents keep: should the file have to be written anew, that is what it holds. Where it can't be
    written, or its folder is gone, they raise an OSError; where another editor took its place, an OptionError.

    Parameters
    ----------
    path : Path
        The file.

    Raises
    ------
    OptionError
        Another editor has it open.
    OSError
        Its folder can't be written.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        self._base = ""
        self._file: BinaryIO | None = None
        self._size = 0
        self._least = 0
        path.parent.mkdir(parents=True, exist_ok=True)
        self._lock_path = path.with_name(path.name + ".lock")
        self._lock = _locked(self._lock_path)

    def recover(self) -> Recovered | None:
        """Read what the file holds; None where there is none. See `read_journal`."""
        return read_journal(self.path) if self.path.exists() else None

    def set_aside(self) -> Path:
        """Rename a file that is no use now, but that nobody said may go."""
        for number in itertools.count(1):
            place = self.path.with_name(f"{self.path.name}.old-{number}")
            if not os.path.lexists(place):
                break
        self.path.rename(place)
        return place

    def begin(self, history: History, warps: Mapping[str, Warp], base: str) -> None:
        """Write the file, whole; `base` is the digest of the project file, "" where there is none."""
        self._base = base
        self._rewrite(history, warps)

    def edit(self, edit: Edit, history: History, warps: Mapping[str, Warp]) -> None:
        """Write down an edit."""
        value = {"did": "edit", **to_value(edit)}
        self._append(value, history, warps)

    def undo(self, history: History, warps: Mapping[str, Warp]) -> None:
        """Write down that a step was taken back; `history` is what that made."""
        self._append({"did": "undo"}, history, warps)

    def redo(self, history: History, warps: Mapping[str, Warp]) -> None:
        """Write down that a step was done again; `history` is what that made."""
        self._append({"did": "redo"}, history, warps)

    def keep(self, name: str, warp: Warp, history: History, warps: Mapping[str, Warp]) -> None:
        """Write down a warp that the next edit keeps."""
        self._append({"did": "keep", "id": name, "warp": json.loads(warp.to_json())}, history, warps)

    def save(self, digest: str, history: History, warps: Mapping[str, Warp]) -> None:
        """Write down that the project is about to be saved: whether it was, its digest will tell."""
        self._append({"did": "save", "digest": digest}, history, warps)

    def _rewrite(self, history: History, warps: Mapping[str, Warp]) -> None:
        """Write the file anew: beside its place, synced, renamed."""
        beside = name_beside(self.path)
        try:
            file = beside.open("xb", buffering=0)
            try:
                size = _write_lines(file, self._lines(history, warps))
                sync_file(file.fileno())
                if os.path.lexists(self.path) and not stat.S_ISREG(self.path.lstat().st_mode):
                    # A link, a pipe, a device, a folder: no journal of ours, and nothing to rename over.
                    self.set_aside()
                if os.name == "nt":
                    # There a file that is open is neither renamed nor replaced.
                    self._let_go()
                    file.close()
                beside.replace(self.path)
                if os.name == "nt":
                    file = self.path.open("ab", buffering=0)
            except BaseException:
                file.close()
                raise
        except BaseException:
            beside.unlink(missing_ok=True)
            self._abandon()
            raise
        sync_folder(self.path.parent)
        self._let_go()
        self._file, self._size, self._least = file, size, size

    def _lines(self, history: History, warps: Mapping[str, Warp]) -> Iterator[Mapping[str, Any]]:
        """Say all that a history is, a line at a time: of a thousand steps at once the program would stay large."""
        yield {"format": "retime-journal", "version": VERSION, "base": self._base, "start": to_value(history.start)}
        for name, warp in warps.items():
            yield {"did": "keep", "id": name, "warp": json.loads(warp.to_json())}
        for step in (*history.done, *reversed(history.undone)):
            yield {"did": "edit", **to_value(Edit(step.document, step.label, step.gesture, done=not step.gesture))}
        for _ in history.undone:
            yield {"did": "undo"}

    def _append(self, value: Mapping[str, Any], history: History, warps: Mapping[str, Warp]) -> None:
        self._hold()
        if self._file is None or self._size > max(_LARGE, 2 * self._least):
            # An earlier edit could not be written; or one long drag has written the same keytime a thousand times.
            self._rewrite(history, warps)
            if value["did"] == "save":
                self._append(value, history, warps)
            return
        line = _line(value)
        try:
            _write_all(self._file, line)
            sync_file(self._file.fileno())
        except BaseException:
            self._abandon()
            raise
        self._size += len(line)
        if not _is_at(self._file, self.path):
            # Somebody removed it; an open file takes what is written all the same.
            self._file.close()
            self._file = None
            self._append(value, history, warps)

    def _hold(self) -> None:
        """Make sure that the place is still ours to write."""
        if _is_at(self._lock, self._lock_path):
            return
        folder = self.path.parent
        if not folder.is_dir():
            raise FileNotFoundError(errno.ENOENT, "the folder is gone", str(folder))
        lock = _locked(self._lock_path)
        self._lock.close()
        self._lock = lock

    def _abandon(self) -> None:
        """Go back to what is whole; the next write begins anew, for what comes after may build on what is missing."""
        if self._file is None:
            return
        try:
            os.ftruncate(self._file.fileno(), self._size)
        finally:
            self._file.close()
            self._file = None

    def _let_go(self) -> None:
        if self._file is not None:
            self._file.close()
            self._file = None

    def close(self, *, remove: bool = False) -> None:
        """Let go of it; remove the file where nothing in it is worth recovering."""
        self._let_go()
        # A lock's file is removed only by who holds it, before letting go.
        if _is_at(self._lock, self._lock_path):
            if remove:
                self.path.unlink(missing_ok=True)
            if os.name == "nt":
                # There no file goes that is open; who opened it meanwhile holds it, and it stays.
                self._lock.close()
            with contextlib.suppress(PermissionError):
                self._lock_path.unlink(missing_ok=True)
        self._lock.close()


def _write_lines(file: BinaryIO, values: Iterable[Mapping[str, Any]]) -> int:
    """Write lines, some of them at a time; return how many bytes they are."""
    size = 0
    waiting = bytearray()
    for value in values:
        waiting += _line(value)
        if len(waiting) > _PIECE:
            _write_all(file, waiting)
            size += len(waiting)
            waiting = bytearray()
    _write_all(file, waiting)
    return size + len(waiting)


def _write_all(file: BinaryIO, data: bytes | bytearray) -> None:
    """Write all bytes: an unbuffered file may take fewer than it is given."""
    view = memoryview(data)
    while view:
        view = view[file.write(view) :]


def _locked(path: Path) -> BinaryIO:
    """Open and lock a file."""
    while True:
        file = path.open("ab")
        if not hold(file):
            file.close()
            raise OptionError(f"{path}: another editor has this open; close it first")
        if _is_at(file, path):
            return file
        # Its holder removed the file after we opened it and before we locked it: our lock guards nothing.
        file.close()


def _is_at(file: BinaryIO, path: Path) -> bool:
    try:
        return os.path.samestat(os.fstat(file.fileno()), path.stat())
    except OSError:
        return False


def find_recovery(recovered: Recovered, digest: str) -> Document | None:
    """Say which document the project file holds, as a journal knows it.

    Parameters
    ----------
    recovered : Recovered
        From `read_journal`.
    digest : str
        Of the project file as it is; "" where there is none.

    Returns
    -------
    Document or None
        None: the journal belongs to another version of the file.
    """
    for known, document in reversed(recovered.saves):
        if known == digest:
            return document
    return recovered.history.start if recovered.base == digest else None
