"""What one editor has open: a document, its history, its journal, and the project file if there is one."""

from __future__ import annotations

import hashlib
import os
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Literal

from retime.errors import FormatError, OptionError, words_of
from retime.files import read_bytes, resolved, write_bytes
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
    origin : Path, optional
        Of work that began with clips alone: the file that says in which project they were saved.
    resumed : bool
        Whether that project was opened in the clips' place.
    began : Document, optional
        Those clips and references, with nothing done to them.
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
    origin: Path | None = None
    resumed: bool = False
    began: Document | None = None
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
            if self.origin is not None:
                # Whoever opens these clips next goes on here; from then on the old journal is not needed.
                write_bytes(self.origin, os.fsencode(path), overwrite=True)
        except BaseException:
            journal.close()
            raise
        # The new file holds all that the old journal held.
        self.journal.close(remove=True)
        self.journal, self.path = journal, path

    def begin_anew(self, folder: Path | None = None) -> Workspace:
        """Close this, and begin with the same clips and references, with nothing done to them.

        What was not saved is set aside; a project file stays as it is. Where that can't be done, this stays open.

        Parameters
        ----------
        folder : Path, optional
            As `open_document` has it.
        """
        start = self.history.start
        new = Document(start.clips, start.references) if self.began is None else self.began
        if self.path is not None:
            made = open_document(new, folder=folder, anew=True)
            self.close()
            return made
        self.journal.close()
        try:
            return open_document(new, folder=folder, anew=True)
        except BaseException:
            self.journal = Journal(self.journal.path)
            self.journal.begin(self.history, self.warps, self.digest)
            raise

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


def open_document(document: Document, *, folder: Path | None = None, anew: bool = False) -> Workspace:
    """Begin with a document that has no project, or go on with what was done to the same clips.

    That is what was not saved; else the project that they were saved in.

    Parameters
    ----------
    document : Document
        The clips and references, with nothing done to them.
    folder : Path, optional
        Where the journal is; left out, `state_folder`.
    anew : bool
        Go on with nothing: what was not saved is set aside, and the project is left alone.

    Raises
    ------
    OptionError
        Another editor has it open.
    OSError
        The journal can't be written.
    """
    journal = Journal(journal_of_clips(document, folder or state_folder()))
    origin = journal.path.with_suffix(".saved")
    notes: list[str] = []
    try:
        if anew:
            origin.unlink(missing_ok=True)
            if _holds_work(journal):
                notes.append(f"what was not saved of these clips is kept as {journal.set_aside()}")
            elif journal.path.exists():
                journal.path.unlink()
        elif origin.exists() and not _holds_work(journal):
            found = _project_of_clips(origin, notes)
            if found is not None:
                found.began = document
                journal.close(remove=True)
                return found
    except BaseException:
        journal.close()
        raise
    workspace = _open(journal, None, Project(document))
    workspace.origin, workspace.began = origin, document
    workspace.notes[:0] = notes
    return workspace


def _holds_work(journal: Journal) -> bool:
    """Whether a journal holds something that was done, or can't be read: then nobody knows."""
    try:
        found = journal.recover()
    except FormatError:
        return True
    return found is not None and bool(found.history.done or found.history.undone)


def _project_of_clips(origin: Path, notes: list[str]) -> Workspace | None:
    """Open the project that clips were saved in; None where it is gone, which is noted."""
    project = Path(os.fsdecode(origin.read_bytes()))
    try:
        workspace = open_project(project)
    except (FormatError, OSError) as error:
        notes.append(f"the project that these clips were saved in can't be opened ({words_of(error)})")
        return None
    workspace.origin, workspace.resumed = origin, True
    return workspace


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
