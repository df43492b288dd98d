"""Which clips a folder holds, and where their outputs go: the same tree again."""

from __future__ import annotations

import csv
import os
import re
from collections.abc import Iterator, Mapping, Sequence
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
# What AMASS has beside its clips: the shape of a body, and what its markers told of it.
_OF_BODIES = re.compile(r"shape\.npz|(?:neutral|female|male)_stagei\.npz")
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
class Cuts:
    """A table `FRAME_CUTS`: for the clips of its folder and of those below.

    Attributes
    ----------
    name : str
        Its place below the tree's folder, with ``/``.
    rows : tuple of dict
        As they are written.
    frames : dict of str to (int, int)
        Frames that are meant of a clip, both included, by its name without folder and ending.
    """

    name: str
    rows: tuple[dict[str, str], ...]
    frames: dict[str, tuple[int, int]]


@dataclass(frozen=True, eq=False)
class Tree:
    """A folder of clips.

    Attributes
    ----------
    root : Path
        The folder.
    clips : tuple of FoundClip
        Its clips, by name.
    cuts : tuple of Cuts
        Its tables `FRAME_CUTS`.
    """

    root: Path
    clips: tuple[FoundClip, ...]
    cuts: tuple[Cuts, ...] = field(default=())


def find_clips(root: Path, *, beside: tuple[str, ...] = (), only: Sequence[Path] | None = None) -> Tree:
    """Look through a folder, and the folders in it, for files of known formats.

    Parameters
    ----------
    root : Path
        The folder. Links to folders are not followed; names that begin with a dot are passed over.
    beside : tuple of str
        Names of files that belong to clips (``{stem}_labels.csv``), and are none.
    only : sequence of Path, optional
        The files below it that are meant; left out, all.

    Raises
    ------
    OptionError
        It is no folder; one of `only` is not there, or of no format that is known.
    FormatError
        A `FRAME_CUTS` in it is none.
    """
    if not root.is_dir():
        raise OptionError(f"{root} is not a folder")
    endings = {suffix for known in FORMATS if not known.shared_ending for suffix in known.suffixes}
    if only is None:
        files = {path.relative_to(root).as_posix(): path for path in _files(root)}
    else:
        for path in only:
            if not path.is_file():
                raise OptionError(f"the clip {path} is not there")
            if plain_path(path).suffix.lower() not in endings:
                raise OptionError(f"{path} is of no format that holds clips (retime info {path.name} says more)")
        tables = {above / FRAME_CUTS for path in only for above in path.parents if above.is_relative_to(root)}
        files = {path.relative_to(root).as_posix(): path for path in (*only, *filter(Path.is_file, tables))}
    cuts = [_frame_cuts(files[name], name) for name in sorted(files) if PurePosixPath(name).name == FRAME_CUTS]
    # The nearest table above a clip holds for it.
    by_folder = {PurePosixPath(one.name).parent: one for one in cuts}
    belonging = set[str]()
    for name in files:
        plain = plain_path(PurePosixPath(name))
        for pattern in beside:
            belonging.add(str(PurePosixPath(name).with_name(pattern.replace("{stem}", plain.stem))))
    clips = []
    for name, path in sorted(files.items()):
        place = PurePosixPath(name)
        if plain_path(path).suffix.lower() not in endings or name in belonging:
            continue
        if name in _OWN or place.name == FRAME_CUTS or _OF_BODIES.fullmatch(place.name):
            continue
        table = next((by_folder[above] for above in place.parents if above in by_folder), None)
        cut = None if table is None else table.frames.get(plain_path(place).stem)
        clips.append(FoundClip(path, name, path.stat().st_size, cut))
    return Tree(root, tuple(clips), tuple(cuts))


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


def _frame_cuts(path: Path, name: str) -> Cuts:
    """Read a table of cuts: for the clip ``STYLE_XX`` the frames from ``XX_START`` to ``XX_STOP``."""
    rows = tuple(csv.DictReader(StringIO(read_bytes(path).decode("utf-8-sig", errors="replace"))))
    if not rows or "STYLE_NAME" not in rows[0]:
        raise FormatError("expected a table of cuts with a column STYLE_NAME", path=path, line=1)
    found = {}
    for line, row in enumerate(rows, start=2):
        for kind in _kinds(row):
            start, stop = ((row.get(f"{kind}_{end}") or "").strip() for end in ("START", "STOP"))
            if start.lower() in _NO_CUT:
                continue
            first, last = count_of(start), count_of(stop)
            if first is None or last is None:
                raise FormatError(f"expected frames {kind}_START and {kind}_STOP", path=path, line=line)
            if not first < last:
                raise FormatError(f"{kind}: frames {start[:20]} to {stop:.20} are no range", path=path, line=line)
            found[f"{row['STYLE_NAME']}_{kind}"] = first, last
    return Cuts(name, rows, found)


def _kinds(row: Mapping[str, str]) -> list[str]:
    """Return the kinds of clips of which a table of cuts speaks: those of the columns ``XX_START``."""
    return [column.removesuffix("_START") for column in row if column is not None and column.endswith("_START")]


def remapped_cuts(rows: Sequence[Mapping[str, str]], outputs: Mapping[str, Sequence[tuple[int, int]]]) -> str:
    """Return the table of cuts of the outputs: what was cut is all of them, from frame 0 on.

    Parameters
    ----------
    rows : sequence of mapping
        Of the input's table.
    outputs : mapping of str to sequence of (int, int)
        Of each clip, by its name without folder and ending: the number (0 for the only one) and the frames of each
        output. Variants get columns of their own, for they are clips of the new tree: ``FW_1_START`` of ``FW_1``. A
        clip that has no such output is not there, ``N/A``.
    """
    new_rows = []
    columns = [column for column in rows[0] if column is not None]
    for row in rows:
        new = {name: value for name, value in row.items() if name is not None}
        for kind in _kinds(row):
            made = outputs.get(f"{row['STYLE_NAME']}_{kind}")
            if made is None:
                continue
            new[f"{kind}_START"] = new[f"{kind}_STOP"] = "N/A"
            width = len(str(max((number for number, _ in made), default=0)))
            for number, frames in made:
                named = f"{kind}_{number:0{width}d}" if number else kind
                new |= {f"{named}_START": "0", f"{named}_STOP": str(frames - 1)}
        columns += [name for name in new if name not in columns]
        new_rows.append(new)
    out = StringIO()
    writer = csv.DictWriter(out, columns, restval="N/A", lineterminator="\n")
    writer.writeheader()
    writer.writerows(new_rows)
    return out.getvalue()
