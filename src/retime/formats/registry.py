"""Which module reads and writes which file, and the one way in and out.

A format is a small module with ``read(path, data, options)`` and ``write(motion, path, overwrite=...)``; see `FORMATS`.
Modules are imported when a file of theirs is met.
"""

from __future__ import annotations

import importlib
import importlib.util
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from os import PathLike
from pathlib import Path
from typing import Protocol, cast
from urllib.parse import quote

from retime.brief import kind_of
from retime.checks import path_of
from retime.errors import FormatError, MissingExtraError, OptionError, OutputExistsError
from retime.files import write_bytes
from retime.formats.compressed import COMPRESSED, is_compressed, plain_path, read_plain, refuse_compressed
from retime.formats.read_options import Limits, ReadOptions
from retime.motion.any_motion import AnyMotion
from retime.motion.body import body_joint
from retime.motion.channels import ChannelKind, KindLike, as_kind, matching
from retime.motion.gaps import GapPolicy
from retime.motion.motion import UPS, Motion, Up
from retime.motion.rate import parse_rate
from retime.warp.curve import Warp


@dataclass(frozen=True)
class Format:
    """One row of the registry.

    Attributes
    ----------
    name : str
        The format's name and its module in `retime.formats`.
    suffixes : tuple of str
        File name endings, lower case, with the dot.
    holds : str
        "motion" or "signal".
    title : str
        What people call it.
    writes : bool
        Whether it can be written.
    curves : bool
        Whether its animation is curves with keys, which are retimed in place (`retime_file`); its module then is in
        `retime.formats.curves`.
    package, extra : str
        A package that it needs beyond retime's own, and the extra that installs it.
    """

    name: str
    suffixes: tuple[str, ...]
    holds: str
    title: str
    writes: bool = True
    curves: bool = False
    package: str = ""
    extra: str = ""


FORMATS = (
    Format("bvh", (".bvh",), "motion", "BVH"),
    Format("amc", (".amc",), "motion", "AMC, with its ASF"),
    Format("csv_table", (".csv", ".tsv"), "signal", "tables of text"),
    # Tables of other programs are read by the same reader, which looks at what they hold, and are written as CSV.
    Format("csv_table", (".mot", ".sto", ".trc"), "signal", "tables of OpenSim", writes=False),
    Format("npy", (".npy", ".npz"), "signal", "arrays of NumPy"),
    Format("gltf", (".glb", ".gltf"), "motion", "glTF 2.0 scenes", curves=True),
    Format("parquet", (".parquet",), "signal", "Parquet tables", package="pyarrow", extra="parquet"),
)


class FormatModule(Protocol):
    """What a format's module offers."""

    def read(self, path: Path, data: bytes, options: ReadOptions) -> AnyMotion:
        """Read the bytes of a file; `path` is for messages and for files that belong to it."""

    def write(self, motion: AnyMotion, path: Path, *, overwrite: bool) -> None:
        """Write a file, all or nothing."""


class CurveModule(FormatModule, Protocol):
    """What the module of a format offers whose animation is curves."""

    def animation_names(self, path: Path, data: bytes, options: ReadOptions) -> list[str]:
        """Name the animations that are meant."""

    def retime(
        self, path: Path, data: bytes, warps: Warp | Mapping[str, Warp], options: ReadOptions
    ) -> dict[str, bytes]:
        """Cut the curves of animations by warps; "" is the new file, other names are of files beside it."""

    def bake(
        self, path: Path, data: bytes, warps: Warp | Mapping[str, Warp], options: ReadOptions, *, average: bool
    ) -> dict[str, bytes]:
        """Put a key on every frame instead."""


def format_of(path: str | PathLike[str]) -> Format:
    """Find a file's format by its name's ending (that before .gz, if any); raise FormatError where none is known."""
    suffix = plain_path(path).suffix.lower()
    for known in FORMATS:
        if suffix in known.suffixes:
            return known
    endings = ", ".join(suffix for known in FORMATS for suffix in known.suffixes)
    problem = f"no format ends in {suffix!r}" if suffix else "the name has no ending, which would say the format"
    raise FormatError(
        f"{problem}; known endings are {endings}; each may be followed by {' or '.join(COMPRESSED)}", path=path
    )


def check_holds(path: str | PathLike[str], holds: str, *, like: str = "") -> None:
    """Refuse a place whose format holds signals for a motion, and the reverse, or a compressed file; raise FormatError.

    MissingExtraError is raised where its format needs a package that is not installed.

    Parameters
    ----------
    path : path-like
        Where something is to be written.
    holds : str
        "motion" or "signal": what.
    like : str
        The file that it comes from, for the message.
    """
    known = format_of(path)
    refuse_compressed(path)
    if known.holds != holds:
        endings = " or ".join(suffix for one in FORMATS if one.holds == holds and one.writes for suffix in one.suffixes)
        remedy = "; convert (joint_signal(motion)) makes a table of its joints" if holds == "motion" else ""
        what = {"motion": "a skeleton that moves", "signal": "columns of numbers"}
        raise FormatError(
            f"a {Path(path).suffix.lower()} file holds a {known.holds}, not a {holds}{like and f' as {like}'} (a "
            f"{known.holds} is {what[known.holds]}); a {holds} is written as {endings}{remedy}",
            path=path,
        )
    if known.package and importlib.util.find_spec(known.package) is None:
        raise MissingExtraError(f"a {known.suffixes[0]} file", package=known.package, extra=known.extra)


def _module(known: Format) -> FormatModule:
    room = "retime.formats.curves" if known.curves else "retime.formats"
    return cast(FormatModule, importlib.import_module(f"{room}.{known.name}"))


def read(
    path: str | PathLike[str],
    *,
    rate: str | float | Fraction | None = None,
    skeleton: str | PathLike[str] | None = None,
    repair: bool = False,
    decimal_comma: bool = False,
    up: Up | None = None,
    kinds: Mapping[str, KindLike] | None = None,
    gaps: str | None = None,
    array: str | Sequence[str] = (),
    root: str | None = None,
    animation: str | None = None,
    limits: Limits | None = None,
) -> AnyMotion:
    """Read a motion, or a signal, from a file.

    Parameters
    ----------
    path : path-like
        The file; its name's ending says what it is. It may be compressed: ``walk.bvh.gz``, ``walk.bvh.bz2``.
    rate : str, float or Fraction, optional
        Frames a second, in place of what the file declares.
    skeleton : path-like, optional
        The ASF of an AMC, where it can't be found beside it.
    repair : bool
        Keep what is whole of a damaged file, and part numbers that run together (``0.0-7.5``) where their count is
        right then, with a warning.
    decimal_comma : bool
        Numbers are written with a comma.
    up : {"y", "z"}, optional
        Which axis of a motion's coordinates is vertical, where it isn't Y. No format here declares it; it is written
        as it was read. A signal has none.
    root : str, optional
        The joint that carries a motion's body, where it isn't found rightly (`retime.motion.body.body_joint`). A signal
        has none.
    animation : str, optional
        Which animation of a file that has several (a scene); left out, the first.
    limits : Limits, optional
        Sizes not to go past.

    Returns
    -------
    Motion or Signal
        What the file holds.

    Raises
    ------
    FormatError
        The file is not what it claims to be.
    OSError
        The file can't be opened.
    OptionError
        No such axis, joint, kind, or way with gaps; or no channel that a kind was given for.

    Warns
    -----
    FormatWarning
        Something was assumed or repaired.
    """
    if up not in (None, *UPS):
        raise OptionError(f"up must be one of {', '.join(UPS)}; found {up!r}")
    path = path_of(path, "read(path)")
    options = ReadOptions(
        rate=None if rate is None else parse_rate(rate),
        skeleton=None if skeleton is None else Path(skeleton),
        repair=repair,
        decimal_comma=decimal_comma,
        channels={name: as_kind(kind) for name, kind in (kinds or {}).items()},
        gaps=None if gaps is None else GapPolicy.parse(gaps),
        arrays=(array,) if isinstance(array, str) else tuple(array),
        animation=animation,
        limits=limits or Limits(),
    )
    clip = read_with(path, options, up=up, root=root)
    refuse_unfit(clip, options.channels, root)
    return clip


def read_with(path: Path, options: ReadOptions, *, up: Up | None = None, root: str | None = None) -> AnyMotion:
    """Do what `read` says; channels, or a root, that are not there are passed over, as they may be another clip's.

    Raises
    ------
    FormatError, OSError, OptionError
        As of `read`.
    """
    known = format_of(path)
    try:
        clip = _module(known).read(path, read_plain(path, options.limits, repair=options.repair), options)
    except MemoryError:
        raise FormatError("this machine has too little memory for what the file holds", path=path) from None
    if is_compressed(path):
        clip = replace(clip, name=plain_path(path).stem)
    if not isinstance(clip, Motion):
        return clip
    return replace(clip, up=up or clip.up, root=root if root in clip.skeleton.names else None)


def refuse_unfit(clip: AnyMotion, channels: Mapping[str, ChannelKind], root: str | None) -> None:
    """Raise OptionError where a kind was chosen for a channel, or a root, that a clip hasn't."""
    if isinstance(clip, Motion) and root is not None:
        body_joint(replace(clip, root=root))
    for pattern in channels:
        if isinstance(clip, Motion):
            raise OptionError(f"{clip.name or 'the motion'} has joints, whose kinds are known: {pattern!r} is none")
        if not matching(pattern, (*clip.names, clip.time_column)):
            some = ", ".join(clip.names[:12]) + (" ..." if len(clip.names) > 12 else "")
            raise OptionError(f"{clip.name or 'the signal'} has no channel {pattern!r}; there are {some}")


def animation_names(path: str | PathLike[str], *, animation: str | None = None) -> list[str]:
    """Name the animations of a file whose animation is curves; none, where its format has but one clip a file.

    Parameters
    ----------
    path : path-like
        The file.
    animation : str, optional
        Only the one of this name.

    Raises
    ------
    FormatError, OSError
        As `read`; or no animation is called so.
    """
    path = path_of(path, "animation_names(path)")
    known = format_of(path)
    if not known.curves:
        return []
    options = ReadOptions(animation=animation)
    module = cast(CurveModule, _module(known))
    return module.animation_names(path, read_plain(path, options.limits), options)


def retime_file(
    path: str | PathLike[str],
    place: str | PathLike[str],
    warps: Warp | Mapping[str, Warp],
    *,
    animation: str | None = None,
    rate: str | float | Fraction | None = None,
    bake: bool = False,
    average: bool = True,
    tolerance: float = 0.001,
    overwrite: bool = False,
) -> None:
    """Give the animations of a scene (glTF, GLB) new timing in place: only their keys change.

    Each curve is cut at the warp's knots, and each piece is laid where the warp shows it: nothing is sampled, and keys
    stay keys. Meshes, materials and whatever else the file holds stay as they are.

    Parameters
    ----------
    path, place : path-like
        The file, and where the new one goes; both of one format.
    warps : Warp, or mapping of str to Warp
        For all animations that are meant, or by name. Time 0 of the input is an animation's first key.
    animation : str, optional
        Only the animation of this name.
    rate : str, float or Fraction, optional
        Frames a second of baked keys; left out, that on which the file's own keys lie.
    bake : bool
        Put a key on every frame in place of cutting; where the warp speeds up, frames are averaged (§3.4).
    average : bool
        Average, where baked.
    tolerance : float
        Seconds: the warp is simplified within this error first (`Warp.simplify`), for each of its knots makes a key.
    overwrite : bool
        Replace a file that is there.

    Raises
    ------
    FormatError
        The file is not what it claims to be, its format has no curves, or `place` is of another.
    OutputExistsError
        A file is there, and `overwrite` is not set.
    """
    path, place = path_of(path, "retime_file(path, place, warps)"), path_of(place, "retime_file(path, place, warps)")
    known = format_of(path)
    if not known.curves:
        raise FormatError(f"a {path.suffix.lower()} file has no curves to cut: read it, and use apply_warp", path=path)
    refuse_compressed(place)
    suffix = plain_path(path).suffix.lower()
    if place.suffix.lower() != suffix:
        raise FormatError(f"retimed in place, a {suffix} file stays one; found {place.name}", path=place)
    options = ReadOptions(rate=None if rate is None else parse_rate(rate), animation=animation)
    module = cast(CurveModule, _module(known))
    data = read_plain(path, options.limits)
    if bake:
        files = module.bake(path, data, warps, options, average=average)
    elif isinstance(warps, Warp):
        files = module.retime(path, data, warps.simplify(tolerance), options)
    else:
        files = module.retime(path, data, {name: warp.simplify(tolerance) for name, warp in warps.items()}, options)
    _write_beside(files, place, overwrite=overwrite)


def _write_beside(files: dict[str, bytes], place: Path, *, overwrite: bool) -> None:
    """Write a scene after the files beside it that it names; refuse all of them where one may not be replaced."""
    main = files[""]
    if any("{stem}" in name for name in files):
        main = main.replace(b"{stem}", quote(place.stem).encode())
    beside = {place.parent / name.replace("{stem}", place.stem): content for name, content in files.items() if name}
    # What is there already, to the byte, needs no writing.
    beside = {
        path: content for path, content in beside.items() if not (path.is_file() and path.read_bytes() == content)
    }
    if not overwrite:
        for path in (*beside, place):
            if path.exists():
                raise OutputExistsError(path)
    for path, content in beside.items():
        path.parent.mkdir(parents=True, exist_ok=True)
        write_bytes(path, content, overwrite=overwrite)
    write_bytes(place, main, overwrite=overwrite)


def write(motion: AnyMotion, path: str | PathLike[str], *, overwrite: bool = False) -> None:
    """Write a motion, or a signal, to a file: whole, or not at all.

    Parameters
    ----------
    motion : Motion or Signal
        What to write.
    path : path-like
        Where; the name's ending says in which format.
    overwrite : bool
        Replace a file that is there.

    Raises
    ------
    OutputExistsError
        The file is there, and `overwrite` is not set.
    FormatError
        The format can't hold this.
    OptionError
        Something else was passed for the motion, or the path.
    """
    if not isinstance(motion, AnyMotion):
        remedy = "; warp.save(path) writes a warp" if isinstance(motion, Warp) else ""
        raise OptionError(f"expected write(motion, path) with a motion or a signal, found {kind_of(motion)}{remedy}")
    path = path_of(path, "write(motion, path)")
    check_holds(path, "motion" if isinstance(motion, Motion) else "signal")
    _module(format_of(path)).write(motion, path, overwrite=overwrite)
