"""Which module reads and writes which file, and the one way in and out.

A format is a small module with ``read(path, data, options)`` and ``write(motion, path, overwrite=...)``; see `FORMATS`.
A file that holds more than a clip is retimed in place: `retime_file`.
Modules are imported when a file of theirs is met.
"""

from __future__ import annotations

import importlib
import importlib.util
import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from io import BytesIO
from os import PathLike
from pathlib import Path
from typing import Any, BinaryIO, Protocol, cast
from urllib.parse import quote

from retime.brief import kind_of
from retime.checks import path_of
from retime.errors import FormatError, MissingExtraError, OptionError, OutputExistsError
from retime.files import note_written, write_bytes
from retime.formats.compressed import COMPRESSED, is_compressed, plain_path, read_plain, refuse_compressed
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
        Whether its animation is curves with keys, which are retimed in place (`retime_file`); its module then is
        ``format`` in its room of `retime.formats.curves`.
    frames : bool
        Whether its files hold more than a clip's frames, so that retiming gives them other frames in place and keeps
        the rest (`retime_file`).
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
        Kinds of new files that show one of this format, itself untouched, with new timing (`retime_file`).
    shared_ending : bool
        Whether most files with its ending are something else, so that folders are not searched for it.
    many_files : bool
        Whether a folder, or a pattern of names, may stand for a clip; its module then tells which (`is_many_files`) and
        reads them.
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

    def layer(
        self,
        path: Path,
        data: bytes,
        warps: Warp | Mapping[str, Warp],
        options: ReadOptions,
        *,
        kind: str,
        place: Path,
    ) -> dict[str, bytes]:
        """Make a file for `place` that shows this one with new timing, where the format has such (`Format.layers`)."""


class TellingModule(FormatModule, Protocol):
    """What the module of a format offers that has more to tell of a file than what is read."""

    def facts(self, path: Path, data: bytes, options: ReadOptions) -> dict[str, str]:
        """Say what a file holds beside the clip that is read."""


class ManyFilesModule(FormatModule, Protocol):
    """What the module of a format offers whose clips may be many files."""

    def is_many_files(self, path: Path) -> bool:
        """Tell whether a path stands for several files: a folder, or a pattern of names."""


class SkinModule(FormatModule, Protocol):
    """What the module of a format offers whose files may hold meshes that follow the joints."""

    def skin(self, path: Path, data: bytes, options: ReadOptions) -> Skin | None:
        """Read what follows the joints of the motion that is read."""


class FramesModule(FormatModule, Protocol):
    """What the module of a format offers whose files are given other frames in place."""

    def retime_frames(
        self,
        path: Path,
        data: bytes,
        warp: Warp,
        options: ReadOptions,
        *,
        frames: tuple[int, int] | None,
        average: bool,
        held: int,
    ) -> bytes:
        """Make the file anew with the frames that a warp shows; see `retime_file`."""

    def claims(self, file: BinaryIO) -> bool:
        """Tell whether a file with the ending of the format that it is `among` is one of its own."""


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
        return next((one for one in others if cast(FramesModule, _module(one)).claims(file)), known)


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
    return cast(TellingModule, _module(known)).facts(path, data, options)


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
    return cast(SkinModule, _module(known)).skin(path, data, options)


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


def _module(known: Format) -> FormatModule:
    module = f"curves.{known.name}.format" if known.curves else known.name
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
        Which axis of a motion's coordinates is vertical, where it isn't Y. No format here declares it; it is written
        as it was read. A signal has none.
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
        clip = _module(known).read(path, _content(known, path, options), options)
    except MemoryError as error:
        raise FormatError("this machine has too little memory for what the file holds", path=path) from error
    changed: dict[str, Any] = {"name": plain_path(path).stem} if is_compressed(path) else {}
    if isinstance(clip, Motion):
        changed |= {"up": up or clip.up, "root": root if root in clip.skeleton.names else None}
    # A motion looks at all its numbers as it is made: not once more for nothing.
    return replace(clip, **changed) if any(getattr(clip, name) != value for name, value in changed.items()) else clip


def _content(known: Format, path: Path, options: ReadOptions) -> bytes:
    """Return what a file holds; nothing where its module reads many files itself."""
    if known.many_files and cast(ManyFilesModule, _module(known)).is_many_files(path):
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
    frames: tuple[int, int] | None = None,
    held: int = 1,
    kinds: Mapping[str, KindLike] | None = None,
    repair: bool = False,
    layer: str | None = None,
    outside: bool = False,
    overwrite: bool = False,
) -> None:
    """Give a file new timing in place: a scene (glTF, FBX, USD) other keys, a capture (C3D, AMASS) other frames.

    Of a scene each curve is cut at the warp's knots, and each piece is laid where the warp shows it: nothing is
    sampled, and keys stay keys. Of a capture frames are resampled as `retime.apply_warp` does. Meshes, materials,
    parameters and whatever else the file holds stay as they are.

    Parameters
    ----------
    path, place : path-like
        The file, and where the new one goes; both of one format, and with one ending but for a `layer`.
    warps : Warp, or mapping of str to Warp
        For all animations that are meant, or by name; a capture has one. Time 0 of the input is an animation's first
        key, or the first frame; of an FBX, where its stack begins, if that is earlier.
    animation : str, optional
        Only the animation of this name.
    rate : str, float or Fraction, optional
        Of a scene, frames a second of baked keys; left out, that on which the file's own keys lie. Of a capture, its
        rate in place of what it declares, which is written too.
    bake : bool
        Put a key on every frame in place of cutting; where the warp speeds up, frames are averaged (§3.4).
    average : bool
        Average, where baked, and the frames of a capture.
    tolerance : float
        Seconds: of a scene the warp is simplified within this error first (`Warp.simplify`), for each of its knots
        makes a key.
    frames : (int, int), optional
        Of a capture, the first frame and the last one that are meant, as the file numbers them.
    held : int
        Of a capture, for how many frames each pose is held.
    kinds : mapping of str to ChannelKind or str, optional
        Of a capture, what channels beside the poses hold (a switch among analog channels is a ``"label"``).
    repair : bool
        Keep what is whole of a damaged capture.
    layer : {"clips", "over"}, optional
        Of a USD scene: leave the file as it is, and write a small layer that shows it with new timing, by value clips
        or by time samples over its own.
    outside : bool
        As of `read`.
    overwrite : bool
        Replace a file that is there.

    Raises
    ------
    FormatError
        The file is not what it claims to be, its format is not retimed in place, or `place` is of another.
    OptionError
        Several warps for a capture.
    OutputExistsError
        A file is there, and `overwrite` is not set.
    """
    path, place = path_of(path, "retime_file(path, place, warps)"), path_of(place, "retime_file(path, place, warps)")
    known = format_in(path)
    suffix = plain_path(path).suffix.lower()
    if not (known.curves or known.frames):
        raise FormatError(
            f"a {suffix} file holds nothing but its frames, which retiming replaces: read it, and use apply_warp",
            path=path,
        )
    refuse_compressed(place)
    if layer is not None and layer not in known.layers:
        raise OptionError(
            f"a {suffix} file has no layers over it (--layer {layer})"
            if not known.layers
            else f"a layer over a {suffix} file is one of {', '.join(known.layers)}; found {layer!r}"
        )
    if layer is not None and bake:
        raise OptionError("a layer shows the file's own samples, cut: it can't be baked")
    if layer is None and place.suffix.lower() != suffix:
        raise FormatError(f"retimed in place, a {suffix} file stays one; found {place.name}", path=place)
    options = ReadOptions(
        rate=None if rate is None else parse_rate(rate),
        animation=animation,
        channels={name: as_kind(kind) for name, kind in (kinds or {}).items()},
        repair=repair,
        outside=outside,
    )
    data = read_plain(path, options.limits, repair=repair)
    if known.frames:
        if not isinstance(warps, Warp):
            raise OptionError(f"{path} is one capture, and gets one warp; found {len(warps)} by name")
        by_frames = cast(FramesModule, _module(known))
        new = by_frames.retime_frames(path, data, warps, options, frames=frames, average=average, held=held)
        write_bytes(place, new, overwrite=overwrite)
        return
    module = cast(CurveModule, _module(known))
    whereto: dict[str, Any] = {"place": place} if known.composed else {}
    if layer is not None:
        even = _each(warps, lambda warp: warp.simplify(tolerance))
        files = module.layer(path, data, even, options, kind=layer, place=place)
    elif bake:
        files = module.bake(path, data, warps, options, average=average, **whereto)
    else:
        even = _each(warps, lambda warp: warp.simplify(tolerance))
        files = module.retime(path, data, even, options, **whereto)
    _write_beside(files, place, overwrite=overwrite)


def _each(warps: Warp | Mapping[str, Warp], change: Callable[[Warp], Warp]) -> Warp | dict[str, Warp]:
    """Change each warp."""
    return change(warps) if isinstance(warps, Warp) else {name: change(warp) for name, warp in warps.items()}


def _write_beside(files: dict[str, bytes], place: Path, *, overwrite: bool) -> None:
    """Write a scene after the files beside it that it names; refuse all of them where one may not be replaced."""
    main = files[""]
    if any("{stem}" in name for name in files):
        main = main.replace(b"{stem}", quote(place.stem).encode())
    beside = {place.parent / name.replace("{stem}", place.stem): content for name, content in files.items() if name}
    # What is there already, to the byte, needs no writing.
    known = [path for path, content in beside.items() if path.is_file() and path.read_bytes() == content]
    beside = {path: content for path, content in beside.items() if path not in known}
    if not overwrite:
        for path in (*beside, place):
            if path.exists():
                raise OutputExistsError(path)
    for path in known:
        note_written(path)
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
