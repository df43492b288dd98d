"""What one editor has open: a document, its history, its journal, and the project file if there is one."""

from __future__ import annotations

import hashlib
import os
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Literal

from retime.errors import FormatError, OptionError
from retime.files import read_bytes, resolved
from retime.project.document import ClipFile, Document, ReferenceFile
from retime.project.file import SUFFIX, Project, digest_of, files_of, project_bytes, read_project, save_project
from retime.project.history import History
from retime.project.journal import Journal, Recovered, find_recovery
from retime.warp.curve import Warp


def state_folder() -> Path:
    """Return the folder for what has no place of its own: journals of documents never saved, files dropped."""
    given = os.environ.get("RETIME_STATE")
    if given:
        return Path(given)
    if os.name == "nt":
        return Path(os.environ.get("LOCALAPPDATA") or Path.home() / "AppData" / "Local") / "retime"
    return Path(os.environ.get("XDG_STATE_HOME") or Path.home() / ".local" / "state") / "retime"


@dataclass
class Workspace:
    """What one editor has open: a document and all that is kept of it.

    Attributes
    ----------
    history : History
        The document and its steps.
    warps : mapping of str to Warp
        Those that its documents keep.
    journal : Journal
        Where everything is written down.
    path : Path, optional
        The project file.
    saved : Document, optional
        What the project file holds; the document as it was opened, where there is none.
    digest : str
        Of the project file as it was read or written last; "" where there is none.
    recovered : bool
        Whether it was recovered from a journal.
    notes : list of str
        What is to be said about that.
    """

    history: History
    warps: Mapping[str, Warp]
    journal: Journal
    path: Path | None
    saved: Document | None
    digest: str = ""
    recovered: bool = False
    notes: list[str] = field(default_factory=list)

    @property
    def is_saved(self) -> bool:
        """Whether nothing would be lost without the journal."""
        return self.history.present == self.saved

    def save(self, path: Path, history: History, warps: Mapping[str, Warp], *, overwrite: bool) -> None:
        """Write the project file; at every moment either the file or the journal holds everything.

        Parameters
        ----------
        path : Path
            The project's own, or another: then the work goes on there.
        history : History
            Whose present is saved.
        warps : mapping of str to Warp
            Those that its documents keep.
        overwrite : bool
            Replace another project that is there, or the own one where another program changed it.

        Raises
        ------
        FormatError, OutputExistsError, OptionError, OSError
            It is not saved, and the file is as it was.
        """
        path = resolved(path)
        data = project_bytes(history.present, warps, path.parent)
        digest = digest_of(data)
        if path != self.path:
            self._move(path, data, overwrite=overwrite)
        else:
            if not overwrite and path.exists() and digest_of(read_bytes(path)) != self.digest:
                raise OptionError(
                    f"{path}: another program changed this project; save under another name, or allow overwriting"
                )
            # Should the program die just after saving, the digest tells that the file on disk belongs to this journal.
            self.journal.save(digest, history, warps)
            save_project(path, data, overwrite=True)
        self.saved, self.digest, self.recovered = history.present, digest, False
        self.journal.begin(history, warps, digest)

    def _move(self, path: Path, data: bytes, *, overwrite: bool) -> None:
        """Save to another place, and go on there."""
        if path.suffix.lower() != SUFFIX:
            raise FormatError(f"a project's name ends in {SUFFIX}", path=path)
        journal = Journal(journal_of_project(path))
        try:
            save_project(path, data, overwrite=overwrite)
            if journal.path.exists():
                journal.set_aside()
        except BaseException:
            journal.close()
            raise
        # The new file holds all that the old journal held.
        self.journal.close(remove=True)
        self.journal, self.path = journal, path

    def close(self) -> None:
        """Let go of the journal; where nothing in it is worth recovering, it goes."""
        self.journal.close(remove=self.is_saved)


def new_document(
    clips: list[str], references: list[str] | None = None, *, up: Literal["y", "z"] | None = None
) -> Document:
    """Make a document of files: the first is retimed, the others get its warp; `up` is as in `ClipFile`.

    Raises
    ------
    OptionError
        A name that is no text.
    """
    files = [str(resolved(path)) for path in clips]
    others = [str(resolved(path)) for path in references or []]
    for path in (*files, *others):
        try:
            path.encode()
        except UnicodeEncodeError:
            raise OptionError(f"{path!r}: the editor needs a name that is text") from None
    first, *rest = files
    return Document(
        (ClipFile(first, up=up), *(ClipFile(path, role="follow", up=up) for path in rest)),
        references=tuple(ReferenceFile(path, up=up) for path in others),
    )


def journal_of_project(path: Path) -> Path:
    """Return the place of a project's journal: beside it."""
    return path.with_name(f".{path.name}-journal")


def journal_of_clips(document: Document, folder: Path) -> Path:
    """Return the place of the journal of a document that has no project: the same for the same files."""
    name = hashlib.sha256("\0".join(files_of(document)).encode()).hexdigest()[:16]
    return folder / "journals" / f"{name}.journal"


def open_document(document: Document, *, folder: Path | None = None) -> Workspace:
    """Begin with a document that has no project, or go on with what was not saved of it.

    Parameters
    ----------
    document : Document
        The clips and references, with nothing done to them.
    folder : Path, optional
        Where the journal is; left out, `state_folder`.

    Raises
    ------
    OptionError
        Another editor has it open.
    OSError
        The journal can't be written.
    """
    journal = Journal(journal_of_clips(document, folder or state_folder()))
    return _open(journal, None, Project(document))


def open_project(path: Path, new: Document | None = None) -> Workspace:
    """Open a project, and recover what was not saved of it.

    Parameters
    ----------
    path : Path
        The project file.
    new : Document, optional
        What to begin with where there is no file yet.

    Raises
    ------
    FormatError
        The file is no project.
    OptionError
        Another editor has it open.
    OSError
        It can't be read, or its journal can't be written.
    """
    path = resolved(path)
    if path.suffix.lower() != SUFFIX:
        raise FormatError(f"a project's name ends in {SUFFIX}", path=path)
    journal = Journal(journal_of_project(path))
    try:
        project = Project(new) if new is not None and not path.exists() else read_project(path)
    except BaseException:
        journal.close()
        raise
    return _open(journal, path, project)


def _open(journal: Journal, path: Path | None, project: Project) -> Workspace:
    """Begin with a project, or with what its journal adds to it."""
    saved = project.document if project.digest or path is None else None
    workspace = Workspace(History(project.document), project.warps, journal, path, saved, project.digest)
    try:
        _recover(workspace, project)
        journal.begin(workspace.history, workspace.warps, project.digest)
    except BaseException:
        journal.close()
        raise
    return workspace


def _recover(workspace: Workspace, project: Project) -> None:
    found: Recovered | None = None
    try:
        found = workspace.journal.recover()
    except FormatError as error:
        workspace.notes.append(
            f"the autosave could not be read ({error}); it is kept as {workspace.journal.set_aside()}"
        )
    if found is None:
        return
    base = find_recovery(found, project.digest)
    if base is None:
        workspace.notes.append(
            "the project was changed since, by another program or from a copy; what was not saved then is kept as "
            f"{workspace.journal.set_aside()}"
        )
        return
    workspace.history, workspace.warps = found.history.sealed(), {**found.warps, **project.warps}
    workspace.recovered = found.history.present != project.document
