"""Where the editor may read and write."""

from __future__ import annotations

import os
from collections.abc import Iterable
from os import PathLike
from pathlib import Path

from retime.errors import OptionError


class Places:
    """Folders that the editor may use, and single files that its user named.

    Parameters
    ----------
    folders : iterable of path-like
        With all that is in them. The first one is where relative paths begin.
    files : iterable of path-like
        To be read, wherever they are.

    Examples
    --------
    >>> places = Places(["/home/ana/clips"])
    >>> places.find("/home/ana/clips/../keys")
    Traceback (most recent call last):
    ...
    retime.errors.OptionError: ...
    """

    def __init__(self, folders: Iterable[str | PathLike[str]], files: Iterable[str | PathLike[str]] = ()) -> None:
        self.folders = [Path(os.path.realpath(folder)) for folder in folders]
        self._files = {Path(os.path.realpath(file)) for file in files}

    def add_folder(self, folder: str | PathLike[str]) -> None:
        """Allow another folder."""
        place = Path(os.path.realpath(folder))
        if place not in self.folders:
            self.folders.append(place)

    def contains(self, path: str | PathLike[str]) -> bool:
        """Whether a path, all its links followed, lies in one of the folders."""
        # Component by component: /clips2 begins with the letters of /clips, but is not in it.
        place = Path(os.path.realpath(self._from_first(path)))
        return any(place.is_relative_to(folder) for folder in self.folders)

    def find(self, path: str | PathLike[str], *, reading: bool = False) -> Path:
        """Return the file that a path means, all links followed.

        Parameters
        ----------
        path : path-like
            Relative ones begin at the first folder.
        reading : bool
            The single files are allowed too.

        Raises
        ------
        OptionError
            It lies outside.
        """
        try:
            place = Path(os.path.realpath(self._from_first(path)))
        except ValueError:
            raise OptionError(f"{str(path)!r} is no path") from None
        if self.contains(place) or (reading and place in self._files):
            return place
        raise OptionError(
            f"{path}: outside the folders that the editor may use ({', '.join(map(str, self.folders))}); start retime "
            "edit with --folder to allow another"
        )

    def _from_first(self, path: str | PathLike[str]) -> Path:
        return self.folders[0] / Path(path).expanduser()
