"""The project file: a document and the warps that it keeps, as versioned JSON. See docs/project-file.md."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from os import PathLike
from pathlib import Path, PurePosixPath
from typing import Any

from retime.errors import FormatError
from retime.files import read_bytes, write_bytes
from retime.project.dataclass_json import from_value, to_value
from retime.project.document import ClipFile, Document, ReferenceFile
from retime.project.versions import read_old_document
from retime.strict_json import parse_json
from retime.warp.curve import Warp

VERSION = 3
_OLD = (1, 2)
SUFFIX = ".retime"
_MOST_BYTES = 256 << 20


@dataclass(frozen=True)
class Project:
    """What a project file holds.

    Attributes
    ----------
    document : Document
        Its paths are absolute.
    warps : mapping of str to Warp
        Those that the document keeps, by their id.
    digest : str
        Of the file's bytes.
    """

    document: Document
    warps: Mapping[str, Warp] = field(default_factory=dict)
    digest: str = ""


def warp_id(warp: Warp) -> str:
    """Name a warp by its content."""
    return hashlib.sha256(warp.to_json().encode()).hexdigest()[:16]


def digest_of(data: bytes) -> str:
    """Tell a file's content from any other."""
    return hashlib.sha256(data).hexdigest()


def project_bytes(document: Document, warps: Mapping[str, Warp], folder: Path) -> bytes:
    """Write a project as bytes; files in its folder are named from there, so that the folder may be moved.

    Parameters
    ----------
    document : Document
        With absolute paths.
    warps : mapping of str to Warp
        At least those that the document keeps.
    folder : Path
        Where the file will be.
    """
    value = {
        "format": "retime-project",
        "version": VERSION,
        "document": to_value(_with_paths(document, lambda path: _from_folder(path, folder))),
        "warps": {kept.id: json.loads(warps[kept.id].to_json()) for kept in document.kept},
    }
    return (json.dumps(value, allow_nan=False, ensure_ascii=False, indent=1) + "\n").encode()


def save_project(path: str | PathLike[str], data: bytes, *, overwrite: bool) -> None:
    """Write a project's bytes, all or nothing.

    Raises
    ------
    FormatError
        The name does not end as a project's does.
    OutputExistsError
        The file is there, and `overwrite` is not set.
    OSError
        It can't be written.
    """
    path = Path(path)
    if path.suffix.lower() != SUFFIX:
        raise FormatError(f"a project's name ends in {SUFFIX}", path=path)
    write_bytes(path, data, overwrite=overwrite)


def read_project(path: str | PathLike[str]) -> Project:
    """Read a project file.

    Raises
    ------
    FormatError
        Not a project, or one from the future; says where and why.
    OSError
        The file can't be opened.
    """
    path = Path(path)
    data = read_bytes(path, _MOST_BYTES)
    try:
        return _parse(data, path.absolute().parent)
    except FormatError as error:
        raise FormatError(error.problem, path=path, line=error.line, column=error.column, byte=error.byte) from None


def _parse(data: bytes, folder: Path) -> Project:
    value = parse_json(data)
    if not isinstance(value, dict) or value.get("format") != "retime-project":
        raise FormatError('expected a project: a JSON object with "format": "retime-project"')
    version = value.get("version")
    if version not in (*_OLD, VERSION) or isinstance(version, bool):
        reads = ", ".join(map(str, (*_OLD, VERSION)))
        raise FormatError(f"project version {version!r} is not one that this program reads (it reads {reads})")
    unknown = value.keys() - {"format", "version", "document", "warps"}
    if unknown:
        raise FormatError(f"unknown field {min(unknown)[:40]!r}")
    content = value.get("document")
    if version in _OLD:
        document = read_old_document(content, "document")
    else:
        document = from_value(Document, content, "document")
    warps = read_warps(value.get("warps", {}))
    for kept in document.kept:
        if kept.id not in warps:
            raise FormatError(f"the document keeps a warp {kept.id!r} that the file does not hold")
    return Project(_with_paths(document, lambda path: str(folder / path)), warps, digest_of(data))


def read_warps(value: Any) -> dict[str, Warp]:
    """Read warps by their ids from parsed JSON."""
    if not isinstance(value, dict):
        raise FormatError("warps: expected an object")
    warps = {}
    for name, one in value.items():
        try:
            warps[name] = Warp.from_json(json.dumps(one))
        except FormatError as error:
            raise FormatError(f"warps.{name[:40]}: {error.problem}") from None
    return warps


def _from_folder(path: str, folder: Path) -> str:
    """Name a file from a folder that it is in; elsewhere by its absolute path."""
    try:
        return str(PurePosixPath(*Path(path).relative_to(folder).parts))
    except ValueError:
        return str(Path(path).absolute())


def _with_paths(document: Document, change: Any) -> Document:
    """Change every path of a document."""

    def changed(file: Any) -> Any:
        names = ("path", "skeleton", "joint_map")
        paths = {name: getattr(file, name, None) for name in names}
        found = {name: change(path) for name, path in paths.items() if path is not None}
        if isinstance(file, ReferenceFile):
            found["counterparts"] = tuple(changed(one) for one in file.counterparts)
        return replace(file, **found)

    clips: tuple[ClipFile, ...] = tuple(changed(file) for file in document.clips)
    references: tuple[ReferenceFile, ...] = tuple(changed(file) for file in document.references)
    media = None if document.media is None else changed(document.media)
    beats = None if document.beats is None else changed(document.beats)
    return replace(document, clips=clips, references=references, media=media, beats=beats)


def files_of(document: Document) -> list[str]:
    """List the paths of all files that a document reads."""
    found: list[str] = []

    def note(path: str) -> str:
        found.append(path)
        return path

    _with_paths(document, note)
    return found
