"""The hosts that a warp can be written for, a row each; NumPy is not loaded, as the help must not wait for it."""

from __future__ import annotations

import importlib
import math
from dataclasses import dataclass
from pathlib import PurePath
from typing import TYPE_CHECKING, Protocol, cast

from retime.brief import brief
from retime.errors import OptionError

if TYPE_CHECKING:
    from retime.hosts.shot import Shot
    from retime.warp.curve import Warp


class HostModule(Protocol):
    """What the module of a host offers."""

    def write(self, warp: Warp, shot: Shot) -> str:
        """Return the text of the file.

        Raises
        ------
        OptionError
            This host can't hold it; says what would do.
        """

    def read(self, data: bytes, shot: Shot) -> Warp:
        """Return the warp of such a file.

        Raises
        ------
        FormatError
            It is no curve, or one that is no warp; says where.
        """


@dataclass(frozen=True)
class Host:
    """A program that plays a retime curve, or a way to write one down.

    Attributes
    ----------
    name : str
        What `retime export --host` calls it.
    title : str
        Its name and what of it is written.
    suffixes : tuple of str
        Endings of its files, the usual one first.
    first_frame : int, optional
        The number that it gives a shot's first frame, where nobody says another; None where it counts from the clip's
        own beginning.
    whole_frames : bool
        Its keys stand on whole frames: between two of them the curve is a straight line.
    every_frame : bool
        It gets a value for each frame, so there is nothing to simplify.
    holds, backward : bool
        Whether it can.
    picks : {"", "nearest", "last"}
        Which whole frame of the input is shown: the one nearest to what the curve says, or the last that has begun by
        then. Empty where that is the program's affair, or it mixes frames.
    fastest : float
        The largest speed that it has, forward or backward.
    before_clip : bool
        Whether it knows times before the first frame of the clip.
    begins_late : bool
        Whether it has a place for output that begins after time 0.
    takes_item : str
        What `item` names in it; empty where it names nothing.
    needs_item : bool
        Whether nothing can be written without.
    needs_rate : bool
        Whether it counts frames, or puts its keys on them.
    imports : bool
        Whether its files are read by `retime import`.
    says_rate : bool
        Whether its files say how many frames a second they count.
    may_count_frames : bool
        Whether a file that is read may count frames in place of seconds, though what is written doesn't.
    bends : bool
        Whether its files may hold rounded spans, which are read as lines.
    """

    name: str
    title: str
    suffixes: tuple[str, ...]
    first_frame: int | None = None
    whole_frames: bool = False
    every_frame: bool = False
    holds: bool = True
    backward: bool = True
    picks: str = ""
    fastest: float = math.inf
    before_clip: bool = True
    begins_late: bool = True
    takes_item: str = ""
    needs_item: bool = False
    needs_rate: bool = True
    imports: bool = False
    says_rate: bool = False
    may_count_frames: bool = False
    bends: bool = False

    @property
    def module(self) -> HostModule:
        """The module that writes and reads its files."""
        return cast(HostModule, importlib.import_module(f"retime.hosts.{self.name.replace('-', '_')}"))


HOSTS = (
    Host("nuke", "Nuke, a TimeWarp node", (".nk",), 1, every_frame=True, takes_item="the node", imports=True),
    Host(
        "maya",
        "Maya, the scene's time warp, or that of named curves",
        (".ma", ".py"),
        1,
        takes_item="animation curves, with commas between",
        imports=True,
        says_rate=True,
        bends=True,
    ),
    Host(
        "after-effects",
        "After Effects, Time Remap of a layer",
        (".jsx",),
        before_clip=False,
        takes_item="the layer",
        needs_rate=False,
    ),
    Host(
        "fcpxml",
        "Final Cut Pro and Resolve, a clip with a time map",
        (".fcpxml",),
        before_clip=False,
        takes_item="the clip's file",
        imports=True,
        says_rate=True,
    ),
    Host(
        "otio",
        "OpenTimelineIO, a clip cut in pieces of one speed each",
        (".otio",),
        0,
        whole_frames=True,
        before_clip=False,
        takes_item="the clip's file",
        imports=True,
        says_rate=True,
    ),
    Host(
        "premiere",
        "Premiere Pro, a clip with Time Remapping (Final Cut Pro 7 XML)",
        (".xml",),
        whole_frames=True,
        fastest=10.0,
        before_clip=False,
        takes_item="the clip's file",
    ),
    Host(
        "lottie",
        "Lottie, a precomposition with a time remap",
        (".json",),
        before_clip=False,
        takes_item="the precomposition",
        imports=True,
        says_rate=True,
        bends=True,
    ),
    Host("houdini", "Houdini, a channel for the Warp CHOP", (".chan",), every_frame=True, begins_late=False),
    Host("unreal", "Unreal Engine, the keys of a Time Warp track", (".py",), 0),
    Host(
        "framecurve",
        "framecurve, a table of frames that many programs read",
        (".txt", ".framecurve"),
        1,
        whole_frames=True,
        imports=True,
    ),
    Host(
        "usd-clips",
        "OpenUSD, a layer with value clips",
        (".usda",),
        0,
        takes_item="the layer and the prim, as walk.usd</Char>",
        needs_item=True,
    ),
    Host(
        "ffmpeg",
        "ffmpeg, a filter with setpts",
        (".txt",),
        holds=False,
        backward=False,
        picks="nearest",
        before_clip=False,
    ),
    Host(
        "mlt",
        "MLT (Shotcut, Kdenlive), a clip with the link timeremap",
        (".mlt",),
        whole_frames=True,
        picks="last",
        before_clip=False,
        takes_item="the clip's file",
    ),
    Host(
        "csv",
        "A table: output time, input time, in seconds",
        (".csv",),
        needs_rate=False,
        imports=True,
        may_count_frames=True,
    ),
    Host(
        "frames",
        "A list: the input frame of each output frame",
        (".txt",),
        0,
        every_frame=True,
        before_clip=False,
        begins_late=False,
    ),
)
HOST_NAMES = tuple(host.name for host in HOSTS)
IMPORTED = tuple(host.name for host in HOSTS if host.imports)


def host_named(name: str) -> Host:
    """Find a host; raise OptionError, which lists them, where there is none of that name."""
    for host in HOSTS:
        if host.name == name:
            return host
    raise OptionError(f"no host is called {brief(name)}; there are {', '.join(HOST_NAMES)}")


def host_by_ending(path: PurePath) -> Host | None:
    """Find the one host whose curves, that can be read, end in this way; None where none or several do."""
    found = [host for host in HOSTS if host.imports and path.suffix.lower() in host.suffixes]
    return found[0] if len(found) == 1 else None
