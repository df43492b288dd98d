"""Opening a USD scene from a file that nobody vouches for. Runs in the child process (`usd.child`).

A scene is composed of layers that name each other, and a name may lead anywhere. So each layer is first read by itself,
without composing; what it names is looked at; and only files within the folder (or the package) are copied to a folder
of this process's own, where the scene is then opened.
"""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path, PurePosixPath
from typing import Any

from pxr import Ar, Sdf, Tf, Usd

from retime.errors import FormatError
from retime.files import note_read, read_bytes
from retime.formats.curves.usd.clip_template import unroll_templates
from retime.formats.curves.usd.package import unpacked
from retime.formats.read_options import Limits

LAYERS = (".usda", ".usdc", ".usd", ".usdz")
_TEXT, _CRATE = b"#usda", b"PXR-USDC"
_MOST_LAYERS = 1000
# Fields that name no file, or none that is opened, or whose names are asked for otherwise.
_NO_FILES = (
    "subLayerOffsets",
    "subLayers",
    "references",
    "payload",
    "spline",
    "assetInfo",
    "customData",
    "customLayerData",
)


@dataclass
class Scene:
    """An opened scene.

    Attributes
    ----------
    stage : Usd.Stage
        Composed.
    layer : Sdf.Layer
        Its root layer.
    folder : Path
        A folder of this process's own, where the copy lies.
    base : Path
        The folder of what was opened: of the copy, or, where the scene is composed of files elsewhere, its own.
    text : bytes
        The root layer as it was.
    package : dict of str to bytes
        Of a usdz, its files, the root layer first; else empty.
    used : list of str
        Layers beside the root, by their places relative to it.
    missing : list of str
        Layers that are named and not there.
    """

    stage: Any
    layer: Any
    folder: Path
    base: Path
    text: bytes
    package: dict[str, bytes] = field(default_factory=dict)
    used: list[str] = field(default_factory=list)
    missing: list[str] = field(default_factory=list)

    @property
    def codes_per_second(self) -> float:
        """Time codes a second."""
        return float(self.stage.GetTimeCodesPerSecond())


def open_scene(name: str, data: bytes, folder: Path | None, work: Path, outside: bool, limits: Limits) -> Scene:
    """Open a scene.

    Parameters
    ----------
    name : str
        The file's name.
    data : bytes
        Its contents.
    folder : Path or None
        Where it lies; files beside it are found there.
    work : Path
        An empty folder of this process's own.
    outside : bool
        Whether it may be composed of files elsewhere. It is then opened where it is.
    limits : Limits
        Of sizes.

    Raises
    ------
    FormatError
        It is damaged, or names files elsewhere.
    """
    suffix = Path(name).suffix.lower()
    package: dict[str, bytes] = {}
    root = work / name
    if suffix == ".usdz":
        package = unpacked(data, limits)
        for member, content in package.items():
            place = work / member
            place.parent.mkdir(parents=True, exist_ok=True)
            place.write_bytes(content)
        root = work / next(iter(package))
        data = package[next(iter(package))]
        folder = None
    else:
        root.write_bytes(data)
    if not data.startswith((_TEXT, _CRATE)):
        raise FormatError("expected a USD layer (text that begins with #usda, or a crate file)")
    gathered = _Gathered(work, folder, limits, outside)
    gathered.look_at(root, PurePosixPath(root.relative_to(work).as_posix()))
    place = root
    if gathered.unrolled:
        if gathered.elsewhere:
            raise FormatError("value clips named by a template can't be followed where files lie outside the folder")
        data = root.read_bytes()
    if folder is not None and gathered.elsewhere:
        place = folder / name
        if not place.is_file() or place.read_bytes() != data:
            raise FormatError("a compressed scene can't be composed of files elsewhere: unpack it first")
    try:
        layer = Sdf.Layer.FindOrOpen(str(place))
        stage = Usd.Stage.Open(layer, Ar.DefaultResolverContext([]), Usd.Stage.LoadAll)
    except Tf.ErrorException as error:
        raise FormatError(words_of(error)) from None
    base = Path(os.path.realpath(place.parent))
    if gathered.elsewhere:
        for used in stage.GetUsedLayers():
            if used.realPath:
                note_read(Path(used.realPath))
    return Scene(stage, layer, Path(os.path.realpath(work)), base, data, package, gathered.used, gathered.missing)


def words_of(error: BaseException) -> str:
    """Say what pxr found wrong, in one line and without its source's places."""
    try:
        told = str(error)
    except UnicodeDecodeError:
        # It quotes the file, whose text is none.
        return "USD can't read it: it holds text that is not UTF-8"
    lines = [line.strip() for line in told.splitlines() if line.strip()]
    text = lines[0] if lines else type(error).__name__
    _, colon, said = text.partition(".cpp : ")
    if not colon:
        _, colon, said = text.partition(".h : ")
    return f"USD can't read it: {(said if colon else text).strip(chr(39))[:300]}"


class _Gathered:
    """The layers of a scene, copied to where they can be opened; what leaves its folder is refused."""

    def __init__(self, work: Path, folder: Path | None, limits: Limits, outside: bool) -> None:
        self.work, self.limits, self.outside = work, limits, outside
        self.folder = None if folder is None else Path(os.path.realpath(folder))
        self.used: list[str] = []
        self.missing: list[str] = []
        self.elsewhere = False
        self.unrolled = False
        self.seen: set[PurePosixPath] = set()
        self.bytes = 0

    def look_at(self, place: Path, name: PurePosixPath) -> None:
        """Look at a layer, and at those that it names."""
        waiting = [(place, name)]
        self.seen.add(name)
        while waiting:
            place, name = waiting.pop()
            if place.suffix.lower() == ".usdz":
                # A package may not name what is outside of it, and USD looks for nothing there.
                unpacked(place.read_bytes(), self.limits)
                continue
            layer = open_layer(place, name.name)
            if unroll_templates(layer, lambda asset, by=name: self.is_there(asset, by)):  # type: ignore[misc]
                layer.Export(str(place))
                self.unrolled = True
            for asset in asset_paths(layer):
                found = self.file_of(asset, name)
                if found is None or found in self.seen:
                    continue
                self.seen.add(found)
                if len(self.seen) > _MOST_LAYERS:
                    raise FormatError(f"the scene is composed of more than {_MOST_LAYERS} layers")
                copy = self.copied(found)
                if copy is not None:
                    self.used.append(str(found))
                    waiting.append((copy, found))

    def file_of(self, asset: str, by: PurePosixPath) -> PurePosixPath | None:
        """Find where, from the root's folder, a file lies that a layer names; None for what is not opened."""
        name, _, _ = asset.partition("[")
        if "://" in name or "`" in name or "\0" in name:
            raise FormatError(f"it names {asset[:200]!r}, and only files can be read")
        if name.startswith("/") or "\\" in name or ":" in name:
            self.leaves(f"it names {asset[:200]!r}, which is no file beside it")
            return None
        clean: list[str] = []
        for part in PurePosixPath(by.parent, name).parts:
            if part == ".." and not clean:
                self.leaves(f"it names {asset[:200]!r}, which leaves its folder")
                return None
            if part == "..":
                clean.pop()
            elif part != ".":
                clean.append(part)
        found = PurePosixPath(*clean)
        # Pictures and sounds are not opened, but a link among them would leave as well.
        if found.suffix.lower() in LAYERS:
            return found
        if self.folder is not None:
            self.inside(found)
        return None

    def is_there(self, asset: str, by: PurePosixPath) -> bool:
        """Tell whether a file that a layer may name is there."""
        name = self.file_of(asset, by)
        if name is None:
            return False
        if self.folder is None:
            return (self.work / name).is_file()
        real = self.inside(name)
        return real is not None and real.is_file()

    def leaves(self, problem: str) -> None:
        """Note that a file lies elsewhere; raise FormatError where it may not."""
        if not self.outside or self.folder is None:
            hint = "" if self.folder is None else "; --allow-outside lets files elsewhere be read"
            raise FormatError(problem + hint)
        self.elsewhere = True

    def inside(self, name: PurePosixPath) -> Path | None:
        """Find a file in the folder, links followed; None where they lead elsewhere, and may."""
        assert self.folder is not None
        real = Path(os.path.realpath(self.folder / name))
        if self.folder in real.parents:
            return real
        self.leaves(f"it names {str(name)[:200]!r}, which is a link that leaves its folder")
        return None

    def copied(self, name: PurePosixPath) -> Path | None:
        """Copy a layer from the scene's folder; None where it is not there, as USD goes on without it."""
        place = self.work / name
        if self.folder is None:
            return place if place.is_file() else None
        real = self.inside(name)
        if real is None:
            return None
        if not real.is_file():
            self.missing.append(str(name))
            return None
        content = read_bytes(real, self.limits.file_bytes)
        self.bytes += len(content)
        if self.bytes > self.limits.inflated_bytes:
            raise FormatError("the layers of the scene are larger together than Limits.inflated_bytes")
        place.parent.mkdir(parents=True, exist_ok=True)
        place.write_bytes(content)
        return place


def open_layer(place: Path, name: str) -> Any:
    """Read a layer by itself, without composing; raise FormatError where it is damaged."""
    with place.open("rb") as file:
        head = file.read(8)
    if not head.startswith((_TEXT, _CRATE)):
        raise FormatError(f"{name} is no USD layer (text that begins with #usda, or a crate file)")
    try:
        return Sdf.Layer.OpenAsAnonymous(str(place))
    except Tf.ErrorException as error:
        raise FormatError(words_of(error)) from None


def asset_paths(layer: Any) -> Iterator[str]:
    """List every file that a layer names, of whatever kind: layers, value clips, pictures; each once."""
    found: set[str] = {path for path in layer.GetExternalReferences() if path}
    found |= set(layer.subLayerPaths)
    for path in spec_paths(layer):
        spec = layer.GetObjectAtPath(path)
        if spec is None:
            continue
        type_name = str(spec.typeName) if isinstance(spec, Sdf.AttributeSpec) else ""
        for key in spec.ListInfoKeys():
            # These have no files in them, or came above.
            if key in _NO_FILES or (key in ("timeSamples", "default") and "asset" not in type_name):
                continue
            with naming(f"{path}: {key}", type_name or "none that is known"):
                value = spec.GetInfo(key)
            _collect(value, found)
    yield from sorted(path for path in found if path)


@contextmanager
def naming(path: Any, type_name: Any) -> Iterator[None]:
    """Raise FormatError, with the attribute and its type, where Python can't have a value of it."""
    try:
        yield
    except TypeError as error:
        raise FormatError(
            f"{path} is of the type {type_name}, whose values can't be read: {str(error).splitlines()[0][:200]}"
        ) from None


def spec_paths(layer: Any) -> list[Any]:
    """List all that a layer says, by its paths."""
    paths: list[Any] = []
    layer.Traverse(Sdf.Path.absoluteRootPath, paths.append)
    return paths


def _collect(value: Any, found: set[str]) -> None:
    if isinstance(value, Sdf.AssetPath):
        found.add(value.path)
    elif isinstance(value, Sdf.AssetPathArray):
        found |= {one.path for one in value}
    elif isinstance(value, dict):
        for one in value.values():
            _collect(one, found)
    elif isinstance(value, list | tuple):
        for one in value:
            _collect(one, found)


def sampled_specs(layer: Any) -> list[Any]:
    """Find the attribute specs of a layer that have two time samples or more, or a spline; in the layer's order."""
    found = []
    for path in spec_paths(layer):
        if path.IsPropertyPath():
            spec = layer.GetAttributeAtPath(path)
            if spec is not None and (layer.GetNumTimeSamplesForPath(path) > 1 or spec.HasSpline()):
                found.append(spec)
    return found
