"""USD (.usda, .usdc, .usd, .usdz): read as a motion, retimed in place, baked, or shown by a layer over it.

Needs the extra ``usd`` (usd-core). It is a native decoder, which a damaged file may bring down: all of it runs in
another process (`usd.child`), whose end is an error here and no more.
"""

from __future__ import annotations

import contextlib
import importlib.util
import json
import os
import re
import subprocess
import sys
import tempfile
import threading
import warnings
from collections.abc import Mapping
from dataclasses import asdict, replace
from fractions import Fraction
from pathlib import Path
from types import TracebackType
from typing import Any

import numpy as np

from retime.arrays import FloatArray
from retime.child_process import child_environment
from retime.errors import FormatError, FormatWarning, InvalidMotionError, MissingExtraError
from retime.files import note_read, write_bytes
from retime.formats.channel_meaning import make_signal
from retime.formats.curves.usd.exchange import Message, receive, send
from retime.formats.curves.usd.package import packed
from retime.formats.file_signatures import foreign_kind
from retime.formats.read_options import Limits, ReadOptions
from retime.motion.any_motion import AnyMotion
from retime.motion.channels import ChannelKind
from retime.motion.motion import Motion, Up
from retime.motion.skeleton import EndSite, Skeleton
from retime.warp.curve import Warp

NO_MEMORY = "no memory"
_BYTES_A_SECOND = 1e6
_SIGNATURES = {
    ".usda": (b"#usda",),
    ".usdc": (b"PXR-USDC",),
    ".usd": (b"#usda", b"PXR-USDC"),
    ".usdz": (b"PK\x03\x04",),
}
# Where pxr would look for more of itself, and what would have it print.
_LEFT_OUT = ("PXR_", "USD_", "TF_", "SDF_", "AR_")


class Decoder:
    """A process that runs pxr, for a while.

    Parameters
    ----------
    limits : Limits
        Of sizes; they bound its memory too.
    seconds : float
        How long it may take for anything, and a second more for each megabyte.

    Raises
    ------
    MissingExtraError
        There is no usd-core.
    """

    def __init__(self, limits: Limits, seconds: float = 60.0) -> None:
        if importlib.util.find_spec("pxr") is None:
            raise MissingExtraError("a USD file", package="usd-core", extra="usd")
        self.limits, self._seconds = limits, seconds
        self.is_dead = False
        self._folder = tempfile.TemporaryDirectory(prefix="retime-usd-", ignore_cleanup_errors=True)
        environment = {name: value for name, value in child_environment().items() if not name.startswith(_LEFT_OUT)}
        environment["PXR_WORK_THREAD_LIMIT"] = "1"
        command = [
            sys.executable,
            "-m",
            "retime.formats.curves.usd.child",
            json.dumps(asdict(limits)),
            self._folder.name,
        ]
        self._process = subprocess.Popen(
            command,
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
            env=environment,
            cwd=self._folder.name,
        )

    def __enter__(self) -> Decoder:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    def close(self) -> None:
        """End the process."""
        self._process.kill()
        self._process.wait()
        for pipe in (self._process.stdin, self._process.stdout):
            if pipe is not None:
                with contextlib.suppress(OSError):
                    pipe.close()
        self._folder.cleanup()

    def ask(self, request: Message, path: Path) -> Message:
        """Ask for something.

        Raises
        ------
        FormatError
            The file can't be read, or reading it ends the process, or takes for ever.
        """
        assert self._process.stdin is not None
        assert self._process.stdout is not None
        seconds = self._seconds + sum(map(len, request.files.values())) / _BYTES_A_SECOND
        late = threading.Event()

        def end() -> None:
            late.set()
            self._process.kill()

        clock = threading.Timer(seconds, end)
        clock.daemon = True
        clock.start()
        answer = None
        try:
            send(request, self._process.stdin)
            answer = receive(self._process.stdout, self.limits.file_bytes + self.limits.inflated_bytes)
        except (OSError, FormatError):
            # It ended while it was spoken to, or in the middle of a word.
            self._process.kill()
        finally:
            clock.cancel()
        self.is_dead = answer is None
        if late.is_set():
            raise FormatError(f"a USD file that is not read after {seconds:.0f} s", path=path)
        if answer is None:
            code = self._process.wait()
            raise FormatError(f"a damaged USD file: reading it ends the program that does ({code})", path=path)
        self._note(answer, path)
        fault = answer.facts.get("fault")
        if fault is not None:
            raise FormatError(
                f"retime can't do this with the file, by a fault of its own and not of the file: {str(fault)[:1000]}; "
                "please report it, with the file if you may",
                path=path,
            )
        said = answer.facts.get("error")
        if said == NO_MEMORY:
            raise FormatError("a USD file that needs too much memory", path=path)
        if said is not None:
            # A place in the copy that was read is one in the file.
            told = re.sub(rf"{re.escape(self._folder.name)}/\d+/", "", str(said)[:1000])
            raise FormatError(told.replace(f": {path.name}:", ": line "), path=path)
        return answer

    def _note(self, answer: Message, path: Path) -> None:
        """Note which layers were read for a scene, as `noting_reads` has it."""
        read = answer.facts.get("read")
        for one in read if isinstance(read, list) else ():
            if isinstance(one, str) and not one.startswith(self._folder.name):
                found = Path(one)
                folder = path.parent.resolve()
                note_read(path.parent / found.relative_to(folder) if folder in found.parents else found)


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
        There are several animations, and none was chosen; a layer is missing; something could not be made numbers.
    """
    with Decoder(options.limits) as decoder:
        return read_by(decoder, path, data, options)


def read_by(decoder: Decoder, path: Path, data: bytes, options: ReadOptions) -> AnyMotion:
    """Do what `read` says by a process that is there."""
    _check_signature(path, data)
    answer = decoder.ask(_request("read", path, data, options), path)
    facts = answer.facts
    _warn_of_missing(path, facts)
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


def _doubles(answer: Message, name: str, n_dimensions: int) -> FloatArray:
    array = answer.arrays[name]
    if array.ndim != n_dimensions or not np.isfinite(array).all():
        raise KeyError(name)
    return np.array(array, dtype=np.float64)


def motion_of(answer: Message) -> Motion:
    """Make a motion of an answer; raise InvalidMotionError, KeyError, TypeError or IndexError where it is none."""
    facts = answer.facts
    offsets = _doubles(answer, "offsets", 2)
    translations, rotations = _doubles(answer, "translations", 3), _doubles(answer, "rotations", 3)
    names, parents, ends = [str(name) for name in facts["names"]], list(facts["parents"]), set(facts["ends"])
    kept = [joint for joint in range(len(names)) if joint not in ends]
    place = {joint: number for number, joint in enumerate(kept)}
    sites = [EndSite(place[parents[joint]], tuple(offsets[joint].tolist())) for joint in sorted(ends)]
    skeleton = Skeleton(
        tuple(names[joint] for joint in kept),
        tuple(-1 if parents[joint] < 0 else place[parents[joint]] for joint in kept),
        offsets[kept],
        tuple(sites),
    )
    unit = facts["unit"]
    up: Up = "z" if facts["up"] == "z" else "y"
    return Motion(
        skeleton,
        rotations[:, kept],
        translations[:, kept],
        Fraction(*facts["rate"]),
        name=str(facts["name"]),
        metres_per_unit=unit if isinstance(unit, float) and 0 < unit < 1e9 else None,
        up=up,
    )


def _signal(path: Path, answer: Message, options: ReadOptions) -> AnyMotion:
    facts = answer.facts
    left_out = _texts(facts, "left_out", path)
    if left_out:
        some = ", ".join(left_out[:8]) + (" ..." if len(left_out) > 8 else "")
        warnings.warn(f"{path}: what is no table of numbers was left out: {some}", FormatWarning, stacklevel=3)
    kinds = {int(place): ChannelKind.parse(str(kind)) for place, kind in facts["kinds"]}
    values = _doubles(answer, "values", 2)
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
