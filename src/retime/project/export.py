"""A document's warp, written to files: exactly what `retime warp` writes for the same settings."""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path

from retime.errors import FormatError, OptionError
from retime.files import resolved
from retime.formats.in_place import retime_file
from retime.formats.registry import animation_names, stays_in_place, write
from retime.formats.warp_file import write_warp
from retime.hosts.exporting import export_curve
from retime.motion.channels import parse_channels
from retime.motion.grammar import parse_number
from retime.motion.rate import parse_rate
from retime.motion.signal import Signal
from retime.project.document import Document
from retime.project.file import files_of
from retime.project.solve import Solution
from retime.warp.apply import apply_warp

_WHOLE = re.compile(r"[+-]?\d{1,9}", re.ASCII)


def check_no_input(place: Path, document: Document) -> None:
    """Refuse a place that is an input: one is never overwritten; raise OptionError."""
    for path in files_of(document):
        try:
            same = place.samefile(path)
        except OSError:
            same = resolved(place) == resolved(path)
        if same:
            raise OptionError(f"{place} is an input; choose another place, an input is never overwritten")


def export_motion(solution: Solution, clip: int, place: Path, *, overwrite: bool) -> None:
    """Write a clip with its new timing.

    Raises
    ------
    OptionError
        The document has no such clip, or the place is an input.
    OutputExistsError, FormatError, OSError
        It can't be written.
    """
    check_no_input(place, solution.document)
    if not 0 <= clip < len(solution.sources.clips):
        raise OptionError(f"the document has {len(solution.sources.clips)} clips; there is no number {clip}")
    motion = solution.sources.clips[clip]
    average = solution.document.average
    source = Path(solution.document.clips[clip].path)
    # What the page left out at the start stays out.
    known = stays_in_place(source, place)
    if known is not None and any(solution.sources.moved[clip : clip + 1]):
        raise OptionError(
            f"{source.name} begins at another moment than the first clip, and {place.name} would be that file retimed "
            "in place, which begins where it does; write another format"
        )
    if known is not None and known.frames:
        retime_file(
            source,
            place,
            solution.warp,
            rate=solution.document.clips[clip].fps,
            average=average,
            frames=(motion.first_frame, motion.first_frame + motion.n_frames - 1),
            kinds=parse_channels(solution.document.clips[clip].channels or ""),
            overwrite=overwrite,
        )
        return
    if known is not None:
        # As `retime warp` does: the curves are cut.
        offset = motion.first_frame / float(motion.rate)
        warp = replace(solution.warp, input_times=solution.warp.input_times + offset, keytimes=())
        name = animation_names(source)[0]
        retime_file(source, place, {name: warp}, overwrite=overwrite)
        return
    if isinstance(motion, Signal):
        write(apply_warp(motion, solution.warp, average=average), place, overwrite=overwrite)
    else:
        write(apply_warp(motion, solution.warp, average=average), place, overwrite=overwrite)


def export_warp(solution: Solution, place: Path, *, overwrite: bool) -> None:
    """Write the warp, for `retime apply` and `retime plot`; errors are those of `export_motion`."""
    check_no_input(place, solution.document)
    if place.suffix.lower() != ".json":
        raise FormatError("a warp's name ends in .json", path=place)
    write_warp(solution.warp, place, overwrite=overwrite)


def export_for_host(
    solution: Solution,
    place: Path,
    host: str,
    *,
    rate: str,
    start: str,
    tolerance: str,
    item: str,
    overwrite: bool,
) -> str:
    """Write the warp as the retime curve of another program, as `retime export` does.

    Parameters
    ----------
    solution : Solution
        Whose warp it is.
    place : Path
        The file.
    host : str
        The program.
    rate, start : str
        Frames a second and the first frame's number, as a person wrote them; empty: those of the first clip, and the
        program's custom.
    tolerance : str
        Seconds that the curve may be off to do with fewer keys, as a person wrote them; empty: 0.001.
    item : str
        What it is for.
    overwrite : bool
        Replace a file that is there.

    Returns
    -------
    str
        How far the curve is off, in words.

    Raises
    ------
    OptionError
        The place is an input, or the program can't play this; says what would do.
    OutputExistsError, FormatError, OSError
        It can't be written.
    """
    check_no_input(place, solution.document)
    frames = parse_rate(rate) if rate.strip() else solution.sources.clips[0].rate
    first = int(start.strip()) if _WHOLE.fullmatch(start.strip()) else None
    if start.strip() and first is None:
        raise OptionError(f"expected the first frame's number, such as 1001, found {start[:40]!r}")
    try:
        allowed = parse_number(tolerance, unit="s") if tolerance.strip() else None
    except OptionError as error:
        raise OptionError(f"the tolerance: {error}") from None
    done = export_curve(
        solution.warp,
        place,
        host,
        rate=frames,
        start=first,
        tolerance=allowed,
        item=item.strip(),
        overwrite=overwrite,
    )
    return done.error_text
