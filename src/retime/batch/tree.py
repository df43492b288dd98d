"""Which clips a folder holds, and where their outputs go: the same tree again."""

from __future__ import annotations

import csv
import os
from collections.abc import Iterator
from dataclasses import dataclass, field
from io import StringIO
from pathlib import Path, PurePosixPath

from retime.errors import FormatError, OptionError
from retime.file_names import name_key
from retime.files import read_bytes
from retime.formats.compressed import plain_path
from retime.formats.number_text import count_of
from retime.formats.registry import FORMATS

FRAME_CUTS = "Frame_Cuts.csv"
"""100STYLE's table of which frames of its clips are more than standing and calibrating."""

# What a run leaves in its output folder, which may be the next one's input.
_OWN = ("manifest.jsonl", "manifest.parquet")
_NO_CUT = {"", "n/a", "na", "nan"}


@dataclass(frozen=True)
class FoundClip:
    """A clip of a tree.

    Attributes
    ----------
    path : Path
        Its file.
    name : str
        Its place below the tree's folder, with ``/``.
    size : int
        Bytes.
    cut : (int, int), optional
        Frames that the tree itself says are meant (`FRAME_CUTS`), both included.
    """

    path: Path
    name: str
    size: int
    cut: tuple[int, int] | None = None


@dataclass(frozen=True, eq=False)
class Tree:
    """A folder of clips.

    Attributes
    ----------
    root : Path
        The folder.
    clips : tuple of FoundClip
        Its clips, by name.
    cuts : tuple of dict, optional
        Rows of its `FRAME_CUTS`, where it has one.
    """

    root: Path
    clips: tuple[FoundClip, ...]
    cuts: tuple[dict[str, str], ...] = field(default=())


def find_clips(root: Path, *, beside: tuple[str, ...] = ()) -> Tree:
    """Look through a folder, and the folders in it, for files of known formats.

    Parameters
    ----------
    root : Path
        The folder. Links to folders are not followed; names that begin with a dot are passed over.
    beside : tuple of str
        Names of files that belong to clips (``{stem}_labels.csv``), and are none.

    Raises
    ------
    OptionError
        It is no folder.
    FormatError
        Its `FRAME_CUTS` is none.
    """
    if not root.is_dir():
        raise OptionError(f"{root} is not a folder")
    endings = {suffix for known in FORMATS if not known.shared_ending for suffix in known.suffixes}
    files = {path.relative_to(root).as_posix(): path for path in _files(root)}
    cuts, rows = _frame_cuts(root / FRAME_CUTS) if FRAME_CUTS in files else ({}, ())
    belonging = set[str]()
    for name in files:
        plain = plain_path(PurePosixPath(name))
        for pattern in beside:
            belonging.add(str(PurePosixPath(name).with_name(pattern.replace("{stem}", plain.stem))))
    clips = []
    for name, path in sorted(files.items()):
        if plain_path(path).suffix.lower() not in endings or name in (FRAME_CUTS, *_OWN) or name in belonging:
            continue
        clips.append(FoundClip(path, name, path.stat().st_size, cuts.get(plain_path(path).stem)))
    return Tree(root, tuple(clips), rows)


def _files(root: Path) -> Iterator[Path]:
    for folder, folders, names in os.walk(root):
        folders[:] = sorted(one for one in folders if not one.startswith("."))
        for name in names:
            path = Path(folder, name)
            if not name.startswith(".") and path.is_file():
                yield path


def output_names(tree: Tree, ending: str | None) -> dict[str, str]:
    """Name the output of each clip, by its name: the same, but for another ending and what compresses it.

    Raises
    ------
    OptionError
        Two clips would have one output.
    """
    found: dict[str, str] = {}
    taken: dict[str, str] = {}
    for clip in tree.clips:
        plain = plain_path(PurePosixPath(clip.name))
        name = str(plain.with_suffix(ending or plain.suffix))
        if name_key(name) in taken:
            raise OptionError(
                f"{taken[name_key(name)]} and {clip.name} would both be written as {name}; keep one, or their formats"
            )
        taken[name_key(name)] = clip.name
        found[clip.name] = name
    return found


def _frame_cuts(path: Path) -> tuple[dict[str, tuple[int, int]], tuple[dict[str, str], ...]]:
    """Read a table of cuts: for the clip ``STYLE_XX`` the frames from ``XX_START`` to ``XX_STOP``."""
    rows = tuple(csv.DictReader(StringIO(read_bytes(path).decode("utf-8-sig", errors="replace"))))
    if not rows or "STYLE_NAME" not in rows[0]:
        raise FormatError("expected a table of cuts with a column STYLE_NAME", path=path, line=1)
    found = {}
    for line, row in enumerate(rows, start=2):
        for column, start in row.items():
            kind, _, end = (column or "").rpartition("_")
            if end != "START" or start is None or start.strip().lower() in _NO_CUT:
                continue
            stop = row.get(f"{kind}_STOP")
            first, last = count_of(start.strip()), count_of((stop or "").strip())
            if first is None or last is None:
                raise FormatError(f"expected frames {kind}_START and {kind}_STOP", path=path, line=line)
            if not first < last:
                raise FormatError(f"{kind}: frames {start[:20]} to {stop!s:.20} are no range", path=path, line=line)
            found[f"{row['STYLE_NAME']}_{kind}"] = first, last
    return found, rows


def remapped_cuts(rows: tuple[dict[str, str], ...], lengths: dict[str, int]) -> str:
    """Return the table of cuts of the outputs: what was cut is all of them, from frame 0 on.

    Parameters
    ----------
    rows : tuple of dict
        Of the input's table.
    lengths : dict of str to int
        Frames of the outputs, by the clip's name without folder and ending.
    """
    out = StringIO()
    writer = csv.DictWriter(out, list(rows[0]), lineterminator="\n", extrasaction="ignore")
    writer.writeheader()
    for row in rows:
        new = dict(row)
        for column in row:
            kind, _, end = (column or "").rpartition("_")
            name = f"{row['STYLE_NAME']}_{kind}"
            if end in ("START", "STOP") and name in lengths:
                new[column] = "0" if end == "START" else str(lengths[name] - 1)
        writer.writerow(new)
    return out.getvalue()
