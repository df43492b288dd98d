"""What is to be done with one clip, and what became of it: plain data that goes to another machine and into a file."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass, field
from functools import cache
from importlib.metadata import version
from typing import Any, Literal

from retime.batch.treatment import Treatment, settings
from retime.brief import brief_repr

Status = Literal["done", "kept", "failed", "old"]


@cache
def own_version() -> str:
    """Return the version of retime that is installed; asked when something is done, for docs are made without."""
    return version("retime")


@dataclass(frozen=True)
class ClipTask:
    """A clip, and what is to become of it.

    Attributes
    ----------
    clip : str
        Its file.
    name : str
        What it is called: its place below the folder of all of them, with ``/``. What is drawn depends on it.
    out : str
        The folder of all outputs.
    places : tuple of str
        Where in it its output goes; of variants, one for each.
    treatment : Treatment
        What it gets.
    beside : tuple of (str, tuple of str)
        Files that go through the same warp, each with its places in `out`.
    before : mapping, optional
        What an earlier run recorded of each place (`Record.to_json`): where nothing changed since, nothing is done.
    failed_before : mapping, optional
        What an earlier run recorded of the clip where it failed; unchanged, it is not tried again.
    overwrite : bool
        Replace what is there: it was asked for, or an earlier run says that it is its own.
    run : str
        Which run of the folder asks; where another has begun since, or none is at work, nothing is written. "" where
        no run asks.
    """

    clip: str
    name: str
    out: str
    places: tuple[str, ...]
    treatment: Treatment
    beside: tuple[tuple[str, tuple[str, ...]], ...] = ()
    before: Mapping[str, Mapping[str, Any]] = field(default_factory=dict)
    failed_before: Mapping[str, Any] | None = None
    overwrite: bool = False
    run: str = ""

    __repr__ = brief_repr

    def to_json(self) -> dict[str, Any]:
        """Return it as JSON has it."""
        return asdict(self) | {"treatment": self.treatment.to_json()}

    @classmethod
    def from_json(cls, given: Mapping[str, Any]) -> ClipTask:
        """Make it of what `to_json` returned."""
        return cls(
            clip=given["clip"],
            name=given["name"],
            out=given["out"],
            places=tuple(given["places"]),
            treatment=Treatment().with_(settings(given["treatment"])),
            beside=tuple((path, tuple(places)) for path, places in given["beside"]),
            before=given["before"],
            failed_before=given["failed_before"],
            overwrite=given["overwrite"],
            run=given.get("run", ""),
        )


@dataclass(frozen=True)
class Record:
    """What became of one output; a line of the manifest.

    Attributes
    ----------
    name : str
        The clip.
    output : str
        The file, as it stands in the folder of all outputs; "" where the clip failed.
    status : {"done", "kept", "failed", "old"}
        "kept": it was there, made of the same by the same. "old", in a manifest only: an earlier run made it, and the
        last one had no such output (a clip that is left out, or fails by now; fewer variants).
    hash : str
        Of all that it is made of: the bytes that were read, the treatment, the version of retime.
    files : tuple of str
        The files that were read.
    bytes_out : int
        Size of the output.
    variant : int
        Its number, from 1; 0 where there is but one output.
    reference : str
        The reference that a variant imitates, where one was drawn.
    rate : float
        Frames a second.
    frames_in, frames_out : int
        Lengths.
    total : float, optional
        Of the search (Eq. 1); None where there was none.
    optimal : bool, optional
        Whether it was proved to be the best possible.
    flights, flights_kept : int
        Of the clip, and those that play at unit speed from end to end.
    knots : tuple of (float, float)
        The warp for a picture: output and input times, seconds, thinned.
    seconds : float
        That it took.
    code, message : str
        Of a failure: what kind, and what was said.
    warnings : tuple of str
        What was assumed or repaired.
    others : tuple of str
        Files that were written with the output, as they stand in the folder of all outputs: labels, a skeleton, a
        buffer.
    fastest : float
        The highest speed at which the output shows the clip; 0 where several animations have several.
    limit : float
        Of a failure the bound that it met: seconds, or bytes of memory; 0 where it met none.
    """

    name: str
    output: str
    status: Status
    hash: str = ""
    files: tuple[str, ...] = ()
    bytes_out: int = 0
    variant: int = 0
    reference: str = ""
    rate: float = 0.0
    frames_in: int = 0
    frames_out: int = 0
    total: float | None = None
    optimal: bool | None = None
    flights: int = 0
    flights_kept: int = 0
    knots: tuple[tuple[float, float], ...] = ()
    seconds: float = 0.0
    code: str = ""
    message: str = ""
    warnings: tuple[str, ...] = ()
    others: tuple[str, ...] = ()
    fastest: float = 0.0
    limit: float = 0.0

    __repr__ = brief_repr

    def to_json(self) -> dict[str, Any]:
        """Return it as JSON has it."""
        return asdict(self)

    @classmethod
    def from_json(cls, given: Mapping[str, Any]) -> Record:
        """Make it of what `to_json` returned, or what JSON made of that."""
        return cls(
            **{
                **given,
                "files": tuple(given["files"]),
                "others": tuple(given.get("others", ())),
                "warnings": tuple(given["warnings"]),
                "knots": tuple((a, b) for a, b in given["knots"]),
            }
        )


def places_with(task: ClipTask, number: int) -> list[str]:
    """Return the places of one output of a task and of the files beside it."""
    return [task.places[number], *(places[number] for _, places in task.beside)]
