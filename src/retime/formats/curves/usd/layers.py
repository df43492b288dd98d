"""The layers that a USD scene is composed of: what in them moves, on which clock, and what they name.

Runs in the child process (`usd.child`).
"""

from __future__ import annotations

import os
import posixpath
import zipfile
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any

from pxr import Ar, Sdf, Usd, UsdUtils

from retime.errors import FormatError
from retime.formats.curves.usd.stage import Scene, sampled_specs, spec_paths

Clock = tuple[float, float]
"""An offset and a scale: what a layer has at a time code t, the scene shows at offset + scale * t."""


def told(layer: Any, scene: Scene) -> str:
    """Name a layer as a message should: by its place beside the scene."""
    package, inner = package_of(layer)
    name = Path(os.path.relpath(package, top_of(scene))).as_posix()
    return f"{name}[{inner}]" if inner else name


def top_of(scene: Scene) -> Path:
    """Return the folder from which a scene's layers are named: its root's own, or a package's."""
    return scene.folder if scene.package else scene.base


def package_of(layer: Any) -> tuple[str, str]:
    """Return the real file that a layer is in, and, where that is a package, its place in there."""
    file = layer.realPath or layer.identifier
    outer, inner = Ar.SplitPackageRelativePathOuter(file)
    if not inner and outer.lower().endswith(".usdz"):
        # USD opens a package as what its first file is.
        with zipfile.ZipFile(outer) as archive:
            inner = archive.namelist()[0]
    return os.path.realpath(outer), inner


ASSETS = (Sdf.ValueTypeNames.Asset, Sdf.ValueTypeNames.AssetArray)
TIMECODES = (Sdf.ValueTypeNames.TimeCode, Sdf.ValueTypeNames.TimeCodeArray)


class Clocks:
    """On which clocks a scene shows what stands in its layers.

    Parameters
    ----------
    stage : Usd.Stage
        Composed.
    """

    def __init__(self, stage: Any) -> None:
        # By layer and place in it; those of prims that nobody sees (classes, overs over nothing) count where no other
        # shows the same.
        self._shown: dict[str, dict[Any, set[Clock]]] = {}
        self._hidden: dict[str, dict[Any, set[Clock]]] = {}
        self._prims: dict[tuple[str, Any], Any] = {}
        for prim in Usd.PrimRange.Stage(stage, Usd.TraverseInstanceProxies(Usd.PrimAllPrimsPredicate)):
            found = self._shown if prim.IsDefined() and not prim.IsAbstract() else self._hidden
            for spec, offset in prim.GetPrimStackWithLayerOffsets():
                clock = (round(offset.offset, 9), round(offset.scale, 12))
                found.setdefault(spec.layer.identifier, {}).setdefault(spec.path, set()).add(clock)
                self._prims.setdefault((spec.layer.identifier, spec.path), prim.GetPath())

    def shows(self, layer: Any, path: Any) -> bool:
        """Tell whether a prim of the scene shows what stands at a place of a layer."""
        return any(path in found.get(layer.identifier, {}) for found in (self._shown, self._hidden))

    def prim_of(self, layer: Any, path: Any) -> Any:
        """Return the path of a prim of the scene that shows it; None where there is none."""
        return self._prims.get((layer.identifier, path))

    def of(self, layer: Any, path: Any) -> Clock | None:
        """Find the clock of what stands at a place of a layer: its own, or of what it is part of.

        None, where the scene shows nothing of it and the layer has no one clock.

        Raises
        ------
        FormatError
            It is shown on several clocks, or backward.
        """
        clocks: set[Clock] = set()
        place = path
        while not clocks and place and not place.isEmpty and place != Sdf.Path.absoluteRootPath:
            for found in (self._shown, self._hidden):
                clocks = clocks or found.get(layer.identifier, {}).get(place, set())
            place = place.GetParentPath()
        if not clocks:
            clocks = {clock for one in self._shown.get(layer.identifier, {}).values() for clock in one}
            if len(clocks) != 1:
                return None
        if len(clocks) > 1:
            some = ", ".join(_words(clock) for clock in sorted(clocks)[:4])
            raise FormatError(
                f"{path} of {Path(layer.identifier).name} is shown at {len(clocks)} times ({some}), and no one change "
                "of it is right for all of them: write a layer over the scene (--layer over), which gives each "
                "its own samples"
            )
        clock = next(iter(clocks))
        if not clock[1] > 0:
            raise FormatError(
                f"{path} of {Path(layer.identifier).name} is played backward by the scene (a scale of {clock[1]:g}): "
                "write a layer over it (--layer over)"
            )
        return clock


def _words(clock: Clock) -> str:
    return f"offset {clock[0]:g}" if clock[1] == 1 else f"offset {clock[0]:g} and scale {clock[1]:g}"


def layers_of(scene: Scene) -> list[Any]:
    """List the layers that a scene is composed of, its root first; none of this process's own making."""
    own = (scene.layer, scene.stage.GetSessionLayer())
    others = [layer for layer in scene.stage.GetUsedLayers(False) if layer not in own]
    # USD lists them in no order of its own.
    return [scene.layer, *sorted(others, key=lambda layer: told(layer, scene))]


def unshown(scene: Scene, clocks: Clocks, rewritten: Iterable[Any]) -> list[str]:
    """Name what has time samples that no prim shows, such as a variant that is not chosen, beyond layers rewritten."""
    done = {layer.identifier for layer in rewritten}
    found: list[str] = []
    layers = layers_of(scene)
    for layer in layers:
        if layer.identifier in done:
            continue
        for spec in sampled_specs(layer):
            if not clocks.shows(layer, spec.path.GetPrimOrPrimVariantSelectionPath()):
                found.append(f"{spec.path} in {told(layer, scene)}")
    known = {package_of(layer)[0] for layer in layers}
    played = {os.path.realpath(name) for layer in layers for name in clip_files(layer)}
    for name in scene.used:
        place = os.path.realpath(top_of(scene) / name)
        if place in known or place in played or not Path(place).is_file():
            continue
        layer = Sdf.Layer.FindOrOpen(place)
        if layer and any(True for _ in sampled_specs(layer)):
            found.append(name)
    return found


def clip_files(layer: Any) -> list[str]:
    """List the files of a layer's value clips, by their real places."""
    home = Path(package_of(layer)[0]).parent
    found: list[str] = []
    for path in prims_with_clips(layer):
        for one in layer.GetPrimAtPath(path).GetInfo("clips").values():
            assets = one.get("assetPaths") if isinstance(one, dict) else None
            if isinstance(assets, Sdf.AssetPathArray):
                found += [str(home / asset.path) for asset in assets]
    return found


def prims_with_clips(layer: Any) -> list[Any]:
    """Find the prims of a layer, in variants too, that are played by value clips."""
    found = []
    for path in spec_paths(layer):
        prim = layer.GetPrimAtPath(path)
        if prim is not None and prim.path == path and prim.HasInfo("clips"):
            found.append(path)
    return found


def anchored(scene: Scene, home: str, layer: Any, asset: str) -> str:
    """Name, from the folder that a scene's is found from by `home`, what one of its layers calls `asset`."""
    name, bracket, inner = asset.partition("[")
    if not name or name.startswith("/") or "`" in name or ":" in name:
        return asset
    folder = Path(os.path.relpath(Path(package_of(layer)[0]).parent, scene.base)).as_posix()
    place = posixpath.normpath(posixpath.join(home, folder, name))
    if place == posixpath.normpath(name):
        return asset
    return f"{place if place.startswith('../') else f'./{place}'}{bracket}{inner}"


def named_over(scene: Scene, root: str, layer: Any, value: Any) -> Any:
    """Return a value as a layer over a scene has it, that calls the scene `root`: files are named from there."""
    if not scene.package:
        return _each(value, lambda asset: anchored(scene, posixpath.dirname(root), layer, asset))
    folder = Path(os.path.relpath(layer.realPath, scene.folder)).parent.as_posix()
    return _each(value, lambda asset: f"{root}[{posixpath.normpath(posixpath.join(folder, asset))}]")


class Moves:
    """Where the changed layers of a scene are put, and how all that they name is then found.

    Parameters
    ----------
    scene : Scene
        The scene.
    home : str
        The way from the folder of what is written to that of the scene, with ``/``.
    name : str
        The name of the new root layer's file.
    """

    def __init__(self, scene: Scene, home: str, name: str) -> None:
        self._scene, self._home = scene, home
        self._old_stem, self._stem = Path(package_of(scene.layer)[0]).stem, Path(name).stem
        root = package_of(scene.layer)[0]
        self.new = {root: name}
        files = {package_of(layer)[0] for layer in layers_of(scene)} | {str(scene.base / one) for one in scene.used}
        files |= {file for layer in layers_of(scene) for file in clip_files(layer)}
        # What the scene is made of, by its places from the folder of what is written.
        self._taken = {
            posixpath.normpath(posixpath.join(home, os.path.relpath(file, scene.base).replace(os.sep, "/"))).casefold()
            for file in files
            if os.path.realpath(file) != root
        }
        if name.casefold() in self._taken:
            raise FormatError(f"{name} is a part of the scene, and would be written over: choose another name")
        self._taken.add(name.casefold())

    def put(self, layer: Any) -> str:
        """Give the file of a layer a name beside the new root; return it."""
        file, _ = package_of(layer)
        if file not in self.new:
            old = Path(file)
            # What was made of a layer of "a" for "b" is made for "c" of a layer of "b": no chain of names.
            plain = old.name.removeprefix(f"{self._old_stem}.")
            name, number = f"{self._stem}.{plain}", 1
            while name.casefold() in self._taken:
                number += 1
                name = f"{self._stem}.{Path(plain).stem}-{number}{old.suffix}"
            self.new[file] = name
            self._taken.add(name.casefold())
        return self.new[file]

    def needed(self, layers: list[Any]) -> list[Any]:
        """Put those layers too that name one that is put, and so must name another; return these."""
        found: list[Any] = []
        while True:
            more = [
                layer
                for layer in layers
                if package_of(layer)[0] not in self.new
                and not package_of(layer)[1]
                and any(self._target(layer, asset) in self.new for asset in _composed(layer))
            ]
            if not more:
                return found
            for layer in more:
                self.put(layer)
            found += more

    def _target(self, layer: Any, asset: str) -> str:
        """Find the real file that a layer means."""
        return os.path.realpath(Path(package_of(layer)[0]).parent / asset.partition("[")[0])

    def _anchored(self, layer: Any, asset: str) -> str:
        return anchored(self._scene, self._home, layer, asset)

    def apply(self, layer: Any, copy: Any) -> dict[str, str]:
        """Make a copy of a layer name what the layer does, from where it is put; return the names that are others.

        What is rewritten is named in its new place; value clips are not, for their times are in what names them.
        """
        changed: dict[str, str] = {}
        clips = {path: copy.GetPrimAtPath(path).GetInfo("clips") for path in prims_with_clips(copy)}

        def moved(asset: str) -> str:
            place = self.new.get(self._target(layer, asset)) if asset else None
            if place is None:
                new = self._anchored(layer, asset)
            else:
                _, bracket, inner = asset.partition("[")
                new = f"./{place}{bracket}{inner}"
            if new != asset:
                changed[asset] = new
            return new

        offsets, values = list(copy.subLayerOffsets), _asset_values(copy)
        UsdUtils.ModifyAssetPaths(copy, moved)
        # USD forgets these where a sublayer gets another name, and leaves empty names out of lists.
        for place, offset in enumerate(offsets):
            copy.subLayerOffsets[place] = offset
        for path, code, value in values:
            new = _each(value, moved)
            if code is None:
                copy.GetAttributeAtPath(path).default = new
            else:
                copy.SetTimeSample(path, code, new)
        for path, sets in clips.items():
            for name, one in sets.items():
                if isinstance(one, dict):
                    sets[name] = {key: self._clip(layer, value, changed) for key, value in one.items()}
            copy.GetPrimAtPath(path).SetInfo("clips", sets)
        return changed

    def _clip(self, layer: Any, value: Any, changed: dict[str, str]) -> Any:
        def named(asset: str) -> str:
            new = self._anchored(layer, asset)
            if new != asset:
                changed.setdefault(asset, new)
            return new

        return _each(value, named)


def _each(value: Any, named: Callable[[str], str]) -> Any:
    """Give each file that a value names another name; what names none stays as it is."""
    if isinstance(value, Sdf.AssetPathArray):
        return Sdf.AssetPathArray([_each(one, named) for one in value])
    return Sdf.AssetPath(named(value.path)) if isinstance(value, Sdf.AssetPath) and value.path else value


def _asset_values(layer: Any) -> list[tuple[Any, float | None, Any]]:
    """List the values of a layer's attributes that name files: where, when (None is at no time), and what."""
    found: list[tuple[Any, float | None, Any]] = []
    for path in spec_paths(layer):
        spec = layer.GetAttributeAtPath(path) if path.IsPropertyPath() else None
        if spec is None or spec.typeName not in ASSETS:
            continue
        found.append((path, None, spec.default))
        found += [(path, code, layer.QueryTimeSample(path, code)) for code in layer.ListTimeSamplesForPath(path)]
    return [one for one in found if isinstance(one[2], Sdf.AssetPath | Sdf.AssetPathArray)]


def timecode_specs(layer: Any) -> list[Any]:
    """Find the attribute specs of a layer whose one value is a time of the scene, or several."""
    found = []
    for path in spec_paths(layer):
        spec = layer.GetAttributeAtPath(path) if path.IsPropertyPath() else None
        if spec is not None and spec.typeName in TIMECODES and not isinstance(spec.default, None | Sdf.ValueBlock):
            found.append(spec)
    return found


def _composed(layer: Any) -> set[str]:
    """List the files that a layer is composed of by name."""
    return {asset for asset in (*layer.GetExternalReferences(), *layer.subLayerPaths) if asset}
