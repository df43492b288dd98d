"""Which module reads and writes which file, and the one way in and out.

A format is a small module with ``read(path, data, options)`` and ``write(motion, path, overwrite=...)``; see `FORMATS`.
A file that holds more than a clip is retimed in place: `in_place`.
Modules are imported when a file of theirs is met.
"""

from __future__ import annotations

import importlib
import importlib.util
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from io import BytesIO
from os import PathLike
from pathlib import Path
from typing import Any, cast

from retime.brief import kind_of
from retime.checks import path_of
from retime.errors import FormatError, MissingExtraError, OptionError
from retime.formats.compressed import COMPRESSED, is_compressed, plain_path, read_plain, refuse_compressed
from retime.formats.format_modules import (
    CurveModule,
    FormatModule,
    FramesModule,
    ManyFilesModule,
    SkinModule,
    TellingModule,
)
from retime.formats.read_options import Limits, ReadOptions
from retime.motion.any_motion import AnyMotion
from retime.motion.body import body_joint
from retime.motion.channels import ChannelKind, KindLike, as_kind, matching
from retime.motion.gaps import GapPolicy
from retime.motion.motion import UPS, Motion, Up
from retime.motion.rate import parse_rate
from retime.motion.skin import Skin
from retime.warp.curve import Warp


@dataclass(frozen=True)
class Format:
    """One row of the registry.

    Attributes
    ----------
    name : str
        The format's name and that of its module in `retime.formats` (of its room, where it has ``curves``).
    suffixes : tuple of str
        File name endings, lower case, with the dot.
    holds : str
        "motion" or "signal".
    title : str
        What people call it.
    writes : bool
        Whether it can be written.
    curves : bool
        Whether its animation is curves with keys, which are retimed in place (`in_place`); its module then is
        ``format`` in its room of `retime.formats.curves`.
    frames : bool
        Whether its files hold more than a clip's frames, so that retiming gives them other frames in place and keeps
        the rest (`in_place`).
    among : str
        The name of a format whose ending it shares; its module then tells by what a file holds that it is one.
    facts : bool
        Whether its module has more to tell of a file than what is read (`facts_of`).
    skins : bool
        Whether its files may hold the character's own mesh, which its module reads (`skin_of`).
    package, extra : str
        A package that it needs beyond retime's own, and the extra that installs it.
    imports : str
        What that package is imported as, where that is another name.
    composed : bool
        Whether its files are composed of others, that a new one must name from where it will lie: `retime` and `bake`
        of its module then take that ``place`` too.
    layers : tuple of str
        Kinds of new files that show one of this format, itself untouched, with new timing (`in_place`).
    shared_ending : bool
        Whether most files with its ending are something else, so that folders are not searched for it.
    many_files : bool
        Whether a folder, or a pattern of names, may stand for a clip; its module, which then
        is ``format`` in a room of its own, tells which (`is_many_files`) and reads them.
    alike : bool
        Whether all channels are places in one picture or room, so that a search compares them as they are, without
        dividing each by its own spread.
    """

    name: str
    suffixes: tuple[str, ...]
    holds: str
    title: str
    writes: bool = True
    curves: bool = False
    frames: bool = False
    among: str = ""
    facts: bool = False
    skins: bool = False
    package: str = ""
    extra: str = ""
    imports: str = ""
    composed: bool = False
    layers: tuple[str, ...] = ()
    shared_ending: bool = False
    many_files: bool = False
    alike: bool = False


FORMATS = (
    Format("bvh", (".bvh",), "motion", "BVH"),
    Format("amc", (".amc",), "motion", "AMC, with its ASF"),
    Format("csv_table", (".csv", ".tsv"), "signal", "tables of text"),
    # Tables of other programs are read by the same reader, which looks at what they hold, and are written as CSV.
    Format("csv_table", (".mot", ".sto", ".trc"), "signal", "tables of OpenSim", writes=False),
    Format("npy", (".npy", ".npz"), "signal", "arrays of NumPy"),
    Format("c3d", (".c3d",), "signal", "C3D captures", frames=True, facts=True),
    Format("amass", (".npz",), "motion", "AMASS, SMPL bodies", writes=False, frames=True, among="npy", facts=True),
    Format("humanml3d", (".npy",), "signal", "HumanML3D features", writes=False, frames=True, among="npy"),
    Format("gltf", (".glb", ".gltf"), "motion", "glTF 2.0 scenes", curves=True, facts=True, skins=True),
    Format("fbx", (".fbx",), "motion", "FBX 7 scenes", curves=True, facts=True, skins=True),
    Format(
        "usd",
        (".usda", ".usdc", ".usd", ".usdz"),
        "motion",
        "USD scenes",
        curves=True,
        package="usd-core",
        extra="usd",
        facts=True,
        imports="pxr",
        composed=True,
        layers=("clips", "over"),
    ),
    Format("parquet", (".parquet",), "signal", "Parquet tables", package="pyarrow", extra="parquet"),
    Format(
        "keypoints",
        (".json",),
        "signal",
        "keypoints of OpenPose and MediaPipe",
        writes=False,
        shared_ending=True,
        many_files=True,
        alike=True,
    ),
)


_BY_PICKLE = (
    'python -c "import pickle, numpy; '
    "numpy.savez('{stem}.npz', **pickle.load(open('{name}', 'rb'), encoding='latin1'))\""
)
_BY_TORCH = (
    'python -c "import torch, numpy; '
    "numpy.savez('{stem}.npz', **{{k: numpy.asarray(v) for k, v in torch.load('{name}', 'cpu').items()}})\""
)
_PICKLED = {".pkl": _BY_PICKLE, ".pickle": _BY_PICKLE, ".pt": _BY_TORCH, ".pth": _BY_TORCH}
"""Endings of pickled Python objects, and the line that takes the arrays out of them."""


def format_of(path: str | PathLike[str]) -> Format:
    """Find a file's format by its name's ending (that before .gz, if any); raise FormatError where none is known.

    A folder whose name has no known ending is of the format whose clips are folders.
    """
    suffix = plain_path(path).suffix.lower()
    for known in FORMATS:
        if suffix in known.suffixes and not known.among:
            return known
    if Path(path).is_dir():
        return next(known for known in FORMATS if known.many_files)
    if suffix in _PICKLED:
        name = Path(path).name if re.fullmatch(r"[\w. -]+", Path(path).name) else f"FILE{suffix}"
        line = _PICKLED[suffix].format(name=name, stem=Path(name).stem)
        raise FormatError(
            f"a {suffix} file may run any program when it is read, so it is not read; where you trust it, this line "
            f"makes an archive of its arrays: {line}",
            path=path,
        )
    endings = ", ".join(suffix for known in FORMATS if not known.among for suffix in known.suffixes)
    problem = f"no format ends in {suffix!r}" if suffix else "the name has no ending, which would say the format"
    raise FormatError(
        f"{problem}; known endings are {endings}; each may be followed by {' or '.join(COMPRESSED)}", path=path
    )


def format_in(path: str | PathLike[str], *, arrays: Sequence[str] = ()) -> Format:
    """Find a file's format by its name's ending, and, where several share that, by what the file holds.

    Parameters
    ----------
    path : path-like
        The file; one that is not there, or is no file, is told by its name alone.
    arrays : sequence of str
        Arrays of it that were chosen: it is then no more than an archive of arrays.

    Raises
    ------
    FormatError
        No format is known by the ending, or a compressed file is damaged.
    """
    known, path = format_of(path), Path(path)
    others = [one for one in FORMATS if one.among == known.name and plain_path(path).suffix.lower() in one.suffixes]
    if not others or arrays or not path.is_file():
        return known
    with BytesIO(read_plain(path, Limits(), repair=True)) if is_compressed(path) else path.open("rb") as file:
        return next((one for one in others if cast(FramesModule, module_of(one)).claims(file)), known)


def stays_in_place(
    source: str | PathLike[str], place: str | PathLike[str], *, arrays: Sequence[str] = ()
) -> Format | None:
    """Return the format of a file that is retimed in place where it is written to a file of its kind; else None."""
    known = format_in(source, arrays=arrays)
    alike = plain_path(source).suffix.lower() == Path(place).suffix.lower()
    if (known.frames and alike) or (known.curves and format_of(place) == known):
        return known
    return None


def facts_of(path: str | PathLike[str], options: ReadOptions) -> dict[str, str]:
    """Say what a file holds beside the clip that is read: its events, its other arrays; nothing for most formats.

    Raises
    ------
    FormatError, OSError
        As `read`.
    """
    path = Path(path)
    known = format_in(path, arrays=() if format_of(path).facts else options.arrays)
    if not known.facts:
        return {}
    data = read_plain(path, options.limits, repair=options.repair)
    return cast(TellingModule, module_of(known)).facts(path, data, options)


def skin_of(path: str | PathLike[str], options: ReadOptions) -> Skin | None:
    """Read the mesh of the character that a file's motion moves; None where it has none that is known here.

    Raises
    ------
    FormatError, OSError
        As `read`; or the mesh is damaged or compressed.
    """
    path = Path(path)
    known = format_of(path)
    if not known.skins:
        return None
    data = read_plain(path, options.limits, repair=options.repair)
    return cast(SkinModule, module_of(known)).skin(path, data, options)


def check_holds(path: str | PathLike[str], holds: str, *, like: str = "") -> None:
    """Refuse a place whose format holds signals for a motion, and the reverse, or is only read; raise FormatError.

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
    endings = " or ".join(suffix for one in FORMATS if one.holds == holds and one.writes for suffix in one.suffixes)
    if not known.writes:
        suffix = plain_path(path).suffix.lower()
        raise FormatError(f"{suffix} files can be read, but not written; a {holds} is written as {endings}", path=path)
    if known.holds != holds:
        remedy = "; convert (joint_signal(motion)) makes a table of its joints" if holds == "motion" else ""
        what = {"motion": "a skeleton that moves", "signal": "columns of numbers"}
        raise FormatError(
            f"a {Path(path).suffix.lower()} file holds a {known.holds}, not a {holds}{like and f' as {like}'} (a "
            f"{known.holds} is {what[known.holds]}); a {holds} is written as {endings}{remedy}",
            path=path,
        )
    if known.package and importlib.util.find_spec(known.imports or known.package) is None:
        raise MissingExtraError(f"a {known.suffixes[0]} file", package=known.package, extra=known.extra)


def module_of(known: Format) -> FormatModule:
    """Import the module of a format, which is done when a file of its is met."""
    if known.curves:
        module = f"curves.{known.name}.format"
    else:
        module = f"{known.name}.format" if known.many_files else known.name
    return cast(FormatModule, importlib.import_module(f"retime.formats.{module}"))


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
    outside: bool = False,
    confidence: float | None = None,
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
        Which axis of a motion's coordinates is vertical. Left out: what the file declares (FBX, USD, bodies of AMASS),
        else Y, for the other formats don't declare it. It is written as it was read. A signal has none.
    kinds : mapping of str to ChannelKind or str, optional
        What channels of a table hold, by their names or patterns of them (``{"*_contact": "event"}``); what is not
        named is found by names and values. As `Signal` has it.
    gaps : str, optional
        What to do about values that a table lacks: ``"bridge"`` fills gaps of up to a second, ``"bridge:0.2"`` up to
        0.2 s, ``"keep"`` keeps them all as holes. Left out, they are refused.
    array : str or sequence of str
        Which array of an NPZ is meant, or which side by side; of a C3D ``"points"`` or ``"analog"``.
    root : str, optional
        The joint that carries a motion's body, where it isn't found rightly (`retime.motion.body.body_joint`). A signal
        has none.
    animation : str, optional
        Which animation of a file that has several (a scene); left out, the first. Of a USD scene also the path of a
        prim or an attribute.
    outside : bool
        Let a USD scene be composed of files outside its folder; refused otherwise.
    confidence : float, optional
        Of keypoints, from 0 to 1: points that their detector is less sure of are missing; left out, 0.3.
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
        outside=outside,
        confidence=confidence,
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
    known = format_in(path, arrays=options.arrays)
    try:
        clip = module_of(known).read(path, _content(known, path, options), options)
    except MemoryError as error:
        raise FormatError("this machine has too little memory for what the file holds", path=path) from error
    changed: dict[str, Any] = {"name": plain_path(path).stem} if is_compressed(path) else {}
    if isinstance(clip, Motion):
        changed |= {"up": up or clip.up, "root": root if root in clip.skeleton.names else None}
    # A motion looks at all its numbers as it is made: not once more for nothing.
    return replace(clip, **changed) if any(getattr(clip, name) != value for name, value in changed.items()) else clip


def _content(known: Format, path: Path, options: ReadOptions) -> bytes:
    """Return what a file holds; nothing where its module reads many files itself."""
    if known.many_files and cast(ManyFilesModule, module_of(known)).is_many_files(path):
        return b""
    return read_plain(path, options.limits, repair=options.repair)


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


def animation_names(path: str | PathLike[str], *, animation: str | None = None, outside: bool = False) -> list[str]:
    """Name the animations of a file whose animation is curves; none, where its format has but one clip a file.

    Parameters
    ----------
    path : path-like
        The file.
    animation : str, optional
        Only the one of this name.
    outside : bool
        As of `read`.

    Raises
    ------
    FormatError, OSError
        As `read`; or no animation is called so.
    """
    path = path_of(path, "animation_names(path)")
    known = format_of(path)
    if not known.curves:
        return []
    options = ReadOptions(animation=animation, outside=outside)
    module = cast(CurveModule, module_of(known))
    return module.animation_names(path, read_plain(path, options.limits), options)


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
    module_of(format_of(path)).write(motion, path, overwrite=overwrite)
