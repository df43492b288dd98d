"""The folders and files that the editor may read and write, and no others."""

from __future__ import annotations

import contextlib
import os
import shlex
import subprocess
from collections.abc import Iterable, Sequence
from os import PathLike
from pathlib import Path

from retime.errors import OptionError


class AllowedPlaces:
    """Folders that the editor may use, and single files that its user named.

    Parameters
    ----------
    folders : iterable of path-like
        With all that is in them. The first one is where relative paths begin.
    files : iterable of path-like
        To be read, wherever they are.
    command : sequence of str
        How the editor was started; a refusal says what to add to it. None: it was not started by a command.

    Examples
    --------
    >>> places = AllowedPlaces(["/home/ana/clips"])
    >>> places.find("/home/ana/clips/../keys")
    Traceback (most recent call last):
    ...
    retime.errors.OptionError: ...
    """

    def __init__(
        self,
        folders: Iterable[str | PathLike[str]],
        files: Iterable[str | PathLike[str]] = (),
        *,
        command: Sequence[str] = (),
    ) -> None:
        self.folders = list(dict.fromkeys(Path(os.path.realpath(folder)) for folder in folders))
        self._files = {Path(os.path.realpath(file)) for file in files}
        self._command = tuple(command)

    def add_folder(self, folder: str | PathLike[str]) -> None:
        """Allow another folder."""
        place = Path(os.path.realpath(folder))
        if place not in self.folders:
            self.folders.append(place)

    def contains(self, path: str | PathLike[str]) -> bool:
        """Whether a path, all its links followed, lies in one of the folders."""
        # Component by component: /clips2 begins with the letters of /clips, but is not in it.
        return self._inside(self._place(path))

    def allows(self, path: str | PathLike[str]) -> bool:
        """Whether a file may be read; raise OptionError where it is no path."""
        place = self._place(path)
        return self._inside(place) or place in self._files

    def _inside(self, place: Path) -> bool:
        return any(place.is_relative_to(folder) for folder in self.folders)

    def find(
        self, path: str | PathLike[str], *, reading: bool = False, beside: Iterable[str | PathLike[str]] = ()
    ) -> Path:
        """Return the file that a path means, all links followed.

        Parameters
        ----------
        path : path-like
            Relative ones begin at the first folder.
        reading : bool
            The single files are allowed too.
        beside : iterable of path-like
            What is to be read with it: a refusal says how to allow all of them at once.

        Raises
        ------
        OptionError
            It lies outside.
        """
        place = self._place(path)
        if self._inside(place) or (reading and place in self._files):
            return place
        refused = [place]
        for other in beside:
            # A text that is no path at all is refused when it is asked for, not here.
            with contextlib.suppress(OptionError):
                if not self.allows(other):
                    refused.append(self._place(other))
        # A name without an ending is taken for a folder. What is really there must not be told, so nobody looks.
        folders = [one.parent if one.suffix else one for one in refused]
        raise OptionError(
            f"{path} lies outside the folders that the editor may use ({', '.join(map(str, self.folders))}). "
            f"{self._remedy(folders)}"
        )

    def _remedy(self, folders: Iterable[Path]) -> str:
        """Say how to allow some folders."""
        needed = list(dict.fromkeys(folders))
        if not self._command:
            return f"Copy it there, or start in another folder (os.chdir({str(needed[0])!r}) in a notebook)"
        options = [word for folder in needed for word in ("--folder", str(folder))]
        return f"To allow it, end the editor (Ctrl+C in its terminal) and type: {_typed((*self._command, *options))}"

    def _place(self, path: str | PathLike[str]) -> Path:
        """Follow all links of a path; raise OptionError where it is none."""
        try:
            return Path(os.path.realpath(self.folders[0] / Path(path).expanduser()))
        except (ValueError, RuntimeError):
            # The name holds a NUL, or begins with the ~ of a user who doesn't exist.
            raise OptionError(f"{str(path)!r} is no path") from None


def _typed(words: Sequence[str]) -> str:
    """Write a command as it is typed in this system's shell."""
    return subprocess.list2cmdline(words) if os.name == "nt" else shlex.join(words)
