"""A document's warp, written to files: exactly what `retime warp` writes for the same settings."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

from retime.errors import FormatError, OptionError
from retime.files import resolved
from retime.formats.registry import animation_names, retime_file, stays_in_place, write
from retime.formats.warp_file import write_warp
from retime.motion.channels import parse_channels
from retime.motion.signal import Signal
from retime.project.document import Document
from retime.project.file import files_of
from retime.project.solve import Solution
from retime.warp.apply import apply_warp


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
