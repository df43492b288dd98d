"""Files given new timing in place: a scene other keys, a capture other frames, and the rest of each kept."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from fractions import Fraction
from os import PathLike
from pathlib import Path
from typing import Any, cast
from urllib.parse import quote

from retime.checks import path_of
from retime.errors import FormatError, OptionError, OutputExistsError
from retime.files import note_written, write_bytes
from retime.formats.compressed import plain_path, read_plain, refuse_compressed
from retime.formats.format_modules import CurveModule, FramesModule
from retime.formats.read_options import ReadOptions
from retime.formats.registry import format_in, module_of
from retime.motion.channels import KindLike, as_kind
from retime.motion.rate import parse_rate
from retime.warp.curve import Warp


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
        by_frames = cast(FramesModule, module_of(known))
        new = by_frames.retime_frames(path, data, warps, options, frames=frames, average=average, held=held)
        write_bytes(place, new, overwrite=overwrite)
        return
    module = cast(CurveModule, module_of(known))
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
