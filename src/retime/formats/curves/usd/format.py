"""USD (.usda, .usdc, .usd, .usdz): read as a motion, retimed in place, baked, or shown by a layer over it.

Needs the extra ``usd`` (usd-core). It is a native decoder, which a damaged file may bring down: all of it runs in
another process (`usd.child`), whose end is an error here and no more.
"""

from __future__ import annotations

import os
import warnings
from collections.abc import Mapping
from dataclasses import replace
from fractions import Fraction
from pathlib import Path
from typing import Any

from retime.errors import FormatError, FormatWarning, InvalidMotionError
from retime.files import write_bytes
from retime.formats.channel_meaning import make_signal
from retime.formats.curves.usd.decoder import Decoder
from retime.formats.curves.usd.exchange import Message
from retime.formats.curves.usd.motion import doubles, motion_of
from retime.formats.curves.usd.package import packed
from retime.formats.file_signatures import foreign_kind
from retime.formats.read_options import Limits, ReadOptions
from retime.motion.any_motion import AnyMotion
from retime.motion.channels import ChannelKind
from retime.motion.motion import Motion
from retime.warp.curve import Warp

_SIGNATURES = {
    ".usda": (b"#usda",),
    ".usdc": (b"PXR-USDC",),
    ".usd": (b"#usda", b"PXR-USDC"),
    ".usdz": (b"PK\x03\x04",),
}


def _request(do: str, path: Path, data: bytes, options: ReadOptions, **more: Any) -> Message:
    facts = {
        "do": do,
        # Of a compressed file, the name without that.
        "file": f"{path.stem}{_suffix(path)}" if path.suffix.lower() in _SIGNATURES else Path(path.stem).name,
        "folder": str(path.parent.resolve()),
        "outside": options.outside,
        "animation": options.animation,
        "rate": None if options.rate is None else [options.rate.numerator, options.rate.denominator],
        **more,
    }
    return Message(facts, files={"": data})


def _suffix(path: Path) -> str:
    """Return the ending that says the kind of file, under that of a compressed one."""
    return path.suffix if path.suffix.lower() in _SIGNATURES else Path(path.stem).suffix


def _check_signature(path: Path, data: bytes) -> None:
    if not data.startswith(_SIGNATURES[_suffix(path).lower()]):
        found = foreign_kind(data) or ("something else" if data else "an empty file")
        raise FormatError(f"expected a USD scene, found {found}", path=path)


def animation_names(path: Path, data: bytes, options: ReadOptions) -> list[str]:
    """Return what is retimed: a scene has one clock, so it is one, and named by the animation that is looked at."""
    _check_signature(path, data)
    with Decoder(options.limits) as decoder:
        names = decoder.ask(_request("names", path, data, options), path).facts.get("names")
    if options.animation is not None:
        return [options.animation]
    return [str(names[0])] if isinstance(names, list) and names else [path.stem]


def read(path: Path, data: bytes, options: ReadOptions) -> AnyMotion:
    """Sample a scene from its start to its end: the joints of a skeletal animation, else the prims that move.

    A scene in which nothing but numbers changes gives a signal of them; so does an attribute whose path is chosen.

    Warns
    -----
    FormatWarning
        There are several animations, and none was chosen; a layer is missing; something could not be made numbers; most
        of the frames lie where no sample does.
    """
    with Decoder(options.limits) as decoder:
        return read_by(decoder, path, data, options)


def read_by(decoder: Decoder, path: Path, data: bytes, options: ReadOptions) -> AnyMotion:
    """Do what `read` says by a process that is there."""
    _check_signature(path, data)
    answer = decoder.ask(_request("read", path, data, options), path)
    facts = answer.facts
    _warn_of_missing(path, facts)
    for doubt in _texts(facts, "doubts", path):
        warnings.warn(f"{path}: {doubt}", FormatWarning, stacklevel=2)
    others = _texts(facts, "others", path)
    if len(others) > 1 and options.animation is None:
        some = ", ".join(others[:12]) + (" ..." if len(others) > 12 else "")
        warnings.warn(
            f"{path}: {len(others)} animations ({some}); {facts.get('chosen')} is read, --animation chooses another",
            FormatWarning,
            stacklevel=2,
        )
    try:
        if facts.get("kind") == "motion":
            motion = motion_of(answer)
            return motion if motion.name else replace(motion, name=path.stem)
        return _signal(path, answer, options)
    except InvalidMotionError as error:
        raise FormatError(str(error), path=path) from None
    except (KeyError, TypeError, IndexError, AttributeError, ZeroDivisionError):
        raise FormatError("a damaged USD file: its reader gave no answer that makes sense", path=path) from None


def _texts(facts: Mapping[str, Any], name: str, path: Path) -> list[str]:
    found = facts.get(name, [])
    if not isinstance(found, list) or not all(isinstance(one, str) for one in found):
        raise FormatError("a damaged USD file: its reader gave no answer that makes sense", path=path)
    return found


def _warn_of_missing(path: Path, facts: Mapping[str, Any]) -> None:
    missing = _texts(facts, "missing", path)
    if missing:
        warnings.warn(
            f"{path}: layers that it is composed of are not there: {', '.join(missing[:8])}",
            FormatWarning,
            stacklevel=3,
        )


def _signal(path: Path, answer: Message, options: ReadOptions) -> AnyMotion:
    facts = answer.facts
    left_out = _texts(facts, "left_out", path)
    if left_out:
        some = ", ".join(left_out[:8]) + (" ..." if len(left_out) > 8 else "")
        warnings.warn(f"{path}: what is no table of numbers was left out: {some}", FormatWarning, stacklevel=3)
    kinds = {int(place): ChannelKind.parse(str(kind)) for place, kind in facts["kinds"]}
    values = doubles(answer, "values", 2)
    rate = options.rate or Fraction(*facts["rate"])
    return make_signal(path, _texts(facts, "names", path), values, rate, options, kinds)


def facts(path: Path, data: bytes, options: ReadOptions) -> dict[str, str]:
    """Say of which layers a scene is composed, on which clock, and what moves in it."""
    _check_signature(path, data)
    with Decoder(options.limits) as decoder:
        found = decoder.ask(_request("facts", path, data, options), path).facts.get("facts")
    if not isinstance(found, dict) or not all(isinstance(one, str) for one in found.values()):
        raise FormatError("a damaged USD file: its reader gave no answer that makes sense", path=path)
    return found


def write(motion: AnyMotion, path: Path, *, overwrite: bool) -> None:
    """Write a motion as a new scene: a skeleton and its animation; raise FormatError for a signal."""
    if not isinstance(motion, Motion):
        raise FormatError("a USD scene holds a skeleton that moves, not a signal", path=path)
    skeleton = motion.skeleton
    facts = {
        "do": "write",
        "text": path.suffix.lower() == ".usda",
        "names": list(skeleton.names),
        "parents": list(skeleton.parents),
        "ends": [[site.parent, [float(part) for part in site.offset]] for site in skeleton.end_sites],
        "rate": [motion.rate.numerator, motion.rate.denominator],
        "up": motion.up,
        "unit": motion.metres_per_unit,
        "name": motion.name,
    }
    arrays = {
        "rotations": motion.rotations,
        "translations": motion.local_translations,
        "offsets": skeleton.offsets,
    }
    with Decoder(Limits()) as decoder:
        made = decoder.ask(Message(facts, arrays), path).files[""]
    if path.suffix.lower() == ".usdz":
        made = packed({"motion.usdc": made})
    write_bytes(path, made, overwrite=overwrite)


def retime(
    path: Path,
    data: bytes,
    warps: Warp | Mapping[str, Warp],
    options: ReadOptions,
    *,
    place: Path | None = None,
) -> dict[str, bytes]:
    """Give a scene new timing by cutting the time samples of all its layers; nothing is sampled.

    Parameters
    ----------
    path : Path
        The file that `data` was read from.
    data : bytes
        Its contents.
    warps : Warp, or mapping of str to Warp
        One, under any name: all that a scene holds is on one clock. Time 0 of its input is the scene's start.
    options : ReadOptions
        As it was read.
    place : Path, optional
        Where the new file will lie; left out, over the old one. From there it names what the scene is composed of.

    Returns
    -------
    dict of str to bytes
        "" is the new file; other names are of layers for its folder, that the new scene is composed of.

    Warns
    -----
    FormatWarning
        A layer is missing; or there are time samples that nothing in the scene shows, and they stay as they were.
    """
    return _changed("retime", path, data, warps, options, bake=False, average=False, **_whereto(path, place))


def bake(
    path: Path,
    data: bytes,
    warps: Warp | Mapping[str, Warp],
    options: ReadOptions,
    *,
    average: bool,
    place: Path | None = None,
) -> dict[str, bytes]:
    """Put a time sample on every frame, as `retime` does; sped up, frames are averaged (§3.4)."""
    return _changed("retime", path, data, warps, options, bake=True, average=average, **_whereto(path, place))


def _whereto(path: Path, place: Path | None) -> dict[str, str]:
    """Say what the new root layer is called, and how a scene's folder is found from where it lies."""
    if place is None:
        return {"home": ".", "name": path.name}
    home = Path(os.path.relpath(path.resolve().parent, place.parent.resolve())).as_posix()
    return {"home": home, "name": place.name}


def layer(
    path: Path, data: bytes, warps: Warp | Mapping[str, Warp], options: ReadOptions, *, kind: str, place: Path
) -> dict[str, bytes]:
    """Make a layer that shows the file, which stays as it is, with new timing.

    Parameters
    ----------
    path, data, warps, options
        As of `retime`.
    kind : {"clips", "over"}
        By value clips, or with new time samples over it.
    place : Path
        Where the layer will lie; it names the scene from there.
    """
    suffix = place.suffix.lower()
    if suffix not in (".usda", ".usdc", ".usd"):
        raise FormatError(f"a layer over a scene is a .usda, .usdc or .usd; found {place.name}", path=place)
    if path.suffix.lower() not in _SIGNATURES:
        raise FormatError("a layer can't show a compressed scene: unpack it first", path=path)
    asset = Path(os.path.relpath(path.resolve(), place.parent.resolve())).as_posix()
    asset = asset if asset.startswith("../") else f"./{asset}"
    if "@" in asset or not asset.isprintable():
        raise FormatError("a layer can't name a file with such letters in its path", path=path)
    return _changed("layer", path, data, warps, options, kind=kind, asset=asset, text=suffix != ".usdc")


def _changed(
    do: str, path: Path, data: bytes, warps: Warp | Mapping[str, Warp], options: ReadOptions, **more: Any
) -> dict[str, bytes]:
    if not isinstance(warps, Warp):
        if len(warps) != 1:
            raise FormatError(f"a USD scene has one clock, and gets one warp; found {len(warps)}", path=path)
        warps = next(iter(warps.values()))
    with Decoder(options.limits) as decoder:
        return changed_by(decoder, do, path, data, warps, options, **more)


def changed_by(
    decoder: Decoder, do: str, path: Path, data: bytes, warp: Warp, options: ReadOptions, **more: Any
) -> dict[str, bytes]:
    """Make new files by a process that is there: do is "retime" or "layer", with what `child` wants of it."""
    _check_signature(path, data)
    request = _request(do, path, data, options, **more)
    arrays = {"output_times": warp.output_times, "input_times": warp.input_times}
    answer = decoder.ask(Message(request.facts, arrays, request.files), path)
    _warn_of_missing(path, answer.facts)
    left = _texts(answer.facts, "left", path)
    if left:
        some = ", ".join(left[:8]) + (" ..." if len(left) > 8 else "")
        warnings.warn(
            f"{path}: time samples that nothing in the scene shows now (a variant that is not chosen, say) stay as "
            f"they were: {some}",
            FormatWarning,
            stacklevel=2,
        )
    # A name with a folder in it would lie elsewhere than beside the scene.
    if "" not in answer.files or any(Path(name).name != name for name in answer.files if name):
        raise FormatError("a damaged USD file: its reader gave no answer that makes sense", path=path)
    return dict(answer.files)
