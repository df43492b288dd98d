"""Mutants of scenes (glTF; FBX, binary and in text): each is read, retimed and baked, or refused as FormatError.

python -m tests.fuzz.scenes --kind fbx --count 200000
"""

from __future__ import annotations

import argparse
import copy
import json
import random
import struct
import time
import warnings
from collections import Counter
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from retime.errors import FormatError, RetimeWarning
from retime.formats.curves import fbx, gltf
from retime.formats.read_options import Limits, ReadOptions
from retime.warp.curve import Warp
from tests.formats.curves.fbx_files import ARRAYS, Builder, ascii_, binary, drawn_fbx, drawn_track
from tests.formats.curves.scenes import Scene, drawn_scene
from tests.fuzz.trials import mutated_text

_ODD: list[Any] = [-1, 0, 1, 2, 3, 7, 99, 2**31, 2**63, 1e308, 0.5, True, None, "", "x", [], {}, [0], {"a": 1}, "VEC4"]
_OPTIONS = ReadOptions(limits=Limits(frames=20_000, joint_poses=100_000))


def _places(node: Any) -> list[tuple[Any, Any]]:
    """Every (container, key) of a JSON value."""
    found = []
    waiting = [node]
    while waiting:
        one = waiting.pop()
        keys = list(one) if isinstance(one, dict) else range(len(one)) if isinstance(one, list) else ()
        for key in keys:
            found.append((one, key))
            waiting.append(one[key])
    return found


def mutant(rng: np.random.Generator, seeds: list[Scene]) -> bytes:
    """Make one: numbers and texts of its JSON exchanged, parts taken away, bytes turned, the end cut off."""
    scene = seeds[rng.integers(len(seeds))]
    changed = Scene()
    changed.json, changed.chunk = copy.deepcopy(scene.json), bytearray(scene.chunk)
    for _ in range(int(rng.choice([0, 1, 1, 1, 2, 3]))):
        places = _places(changed.json)
        holder, key = places[rng.integers(len(places))]
        kind = rng.integers(4)
        if kind == 0:
            del holder[key]
        elif kind == 1:
            other, there = places[rng.integers(len(places))]
            if there in other if isinstance(other, dict) else there < len(other):
                holder[key] = copy.deepcopy(other[there])
        elif isinstance(holder[key], int | float) and kind == 2:
            holder[key] = type(holder[key])(holder[key] + int(rng.integers(-3, 4)))
        else:
            holder[key] = copy.deepcopy(_ODD[rng.integers(len(_ODD))])
    data = bytearray(changed.glb())
    for _ in range(int(rng.integers(1, 3)) if rng.random() < 0.3 else 0):
        data[rng.integers(len(data))] = rng.integers(256)
    if rng.random() < 0.1:
        del data[rng.integers(len(data)) :]
    return bytes(data)


_ODD_LONGS = [-1, 0, 1, 7, 2**31, -(2**31), 2**62, -(2**62), 46_186_158_000, 2**63 - 1, -(2**63)]
_ODD_REALS = [0.0, -1.0, 1e-300, 1e300, np.nan, np.inf, -np.inf, 3.4e38, 1e30, 0.5]
_ODD_FLAGS = [0, 2, 4, 8, 0x102, 0x108, 0x208, 0x408, 0xC08, 0x6108, 0x3000C08, 0x3000108, -1, 0x1108, 0x3000208]


def _odd_value(rng: np.random.Generator, value: tuple[str, Any]) -> tuple[str, Any]:
    """Exchange a value of an FBX record for one that no program would write, or hardly."""
    letter, content = value
    if letter in ARRAYS:
        numbers = np.array(content, dtype=ARRAYS[letter])
        kind = rng.integers(5)
        if kind == 0 or not numbers.size:
            return letter, numbers[: rng.integers(numbers.size + 1)]
        place = rng.integers(numbers.size)
        if kind == 1:
            return letter, np.append(numbers, numbers[place])
        odd: list[Any] = _ODD_REALS if letter in "fd" else _ODD_LONGS if letter == "l" else _ODD_FLAGS
        with np.errstate(over="ignore"):
            numbers[place] = numbers[0] if kind == 2 else odd[rng.integers(len(odd))]
        if kind == 4:
            letter = str(rng.choice(list(ARRAYS)))
            with np.errstate(all="ignore"):
                return letter, np.nan_to_num(numbers, posinf=1e9, neginf=-1e9).clip(-1e9, 1e9).astype(ARRAYS[letter])
        return letter, numbers
    if letter in "IL":
        odd_number = _ODD_LONGS[rng.integers(len(_ODD_LONGS))]
        return (letter, odd_number) if letter == "L" else ("I", int(np.int32(odd_number & 0x7FFFFFFF)))
    if letter == "D":
        return "D", _ODD_REALS[rng.integers(len(_ODD_REALS))]
    if letter == "C":
        return "C", int(rng.integers(256))
    words = [
        "",
        "OO",
        "OP",
        "d|X",
        "Lcl Rotation",
        "Lcl Translation",
        "Weight",
        "x" * 3000,
        "LocalStop",
        "P",
        "\0\1",
        "ü",
    ]
    return "S", words[rng.integers(len(words))]


def small_fbx(seed: int) -> Builder:
    """Make a limb that every kind of key moves, in two layers, beside a shape: small, so that many can be tried."""
    rng = np.random.default_rng(seed)
    made = Builder()
    made.settings = [("UpAxis", ("I", int(rng.integers(3)))), ("TimeMode", ("I", 6)), ("TimeSpanStop", ("L", 10**11))]
    limb = made.model("limb", RotationActive=1, RotationOrder=seed % 6, PreRotation=rng.normal(size=3) * 30)
    stack = made.stack("take", 0.0, 1.0)
    base = made.layer(stack)
    top = made.layer(stack, "top", Weight=60.0, BlendMode=seed % 3)
    beyond = replace(
        drawn_track(rng, 2, start=0.2), pre="RAMK"[seed % 4], post="KRAM"[seed % 4], repetition=seed % 3 - 1
    )
    made.animate(base, limb, "Lcl Rotation", {"X": drawn_track(rng, 5), "Y": beyond}, Z=3.0)
    made.animate(top, limb, "Lcl Rotation", {"Z": drawn_track(rng, 3)})
    made.animate(top, top, "Weight", {"Weight": drawn_track(rng, 2)})
    shape = made.add("Deformer", "smile", "SubDeformer", "BlendShapeChannel", [])
    made.animate(base, shape, "DeformPercent", {"DeformPercent": drawn_track(rng, 3)})
    return made


def _copied(records: list[Any]) -> list[Any]:
    return [(name, list(values), None if inner is None else _copied(inner)) for name, values, inner in records]


def fbx_mutant(rng: np.random.Generator, seeds: list[Builder], text: bool) -> bytes:
    """Make one: values of its records exchanged, records taken away or doubled, bytes turned, the end cut off."""
    version = int(rng.choice([7100, 7400, 7500, 7700]))
    records = _copied(seeds[rng.integers(len(seeds))].records(version))
    for _ in range(int(rng.choice([0, 1, 1, 1, 2, 3]))):
        lists, waiting = [], [records]
        while waiting:
            one = waiting.pop()
            if one:
                lists.append(one)
            waiting += [inner for _, _, inner in one if inner]
        chosen = lists[rng.integers(len(lists))]
        place = int(rng.integers(len(chosen)))
        kind = rng.integers(6)
        if kind == 0:
            del chosen[place]
        elif kind == 1:
            other = lists[rng.integers(len(lists))]
            chosen.insert(place, _copied([other[rng.integers(len(other))]])[0])
        elif chosen[place][1]:
            values = chosen[place][1]
            spot = int(rng.integers(len(values)))
            values[spot] = _odd_value(rng, values[spot])
    if text:
        data = ascii_(records, version, "\n" if rng.random() < 0.8 else "\r\n")
        if rng.random() < 0.3:
            data = mutated_text(random.Random(int(rng.integers(2**31))), data)
        return data
    changed = bytearray(binary(records, version, bool(rng.random() < 0.5)))
    for _ in range(int(rng.integers(1, 3)) if rng.random() < 0.3 else 0):
        changed[rng.integers(len(changed))] = rng.integers(256)
    if rng.random() < 0.1:
        del changed[rng.integers(len(changed)) :]
    return bytes(changed)


def _try_gltf(path: Path, data: bytes, warp: Warp, outcomes: Counter[str]) -> None:
    names = gltf.animation_names(path, data, _OPTIONS)
    gltf.read(path, data, _OPTIONS)
    outcomes["read"] += 1
    new = gltf.retime(path, data, dict.fromkeys(names, warp), _OPTIONS)[""]
    # What was written is read again.
    gltf.read(path, new, _OPTIONS)
    json.loads(new[20 : 20 + struct.unpack_from("<I", new, 12)[0]])


def _try_fbx(path: Path, data: bytes, warp: Warp, outcomes: Counter[str]) -> None:
    names = fbx.animation_names(path, data, _OPTIONS)
    clip = fbx.read(path, data, _OPTIONS)
    outcomes["read"] += 1
    new = fbx.retime(path, data, dict.fromkeys(names, warp), _OPTIONS)[""]
    if outcomes["read"] % 4:
        return
    # What was written is read again; and now and then it is baked.
    baked = fbx.bake(path, data, {names[0]: Warp([0.0, 0.5], [0.0, 1.0])}, _OPTIONS, average=clip.n_frames % 2 == 0)
    for written in (new, baked[""]):
        try:
            fbx.read(path, written, _OPTIONS)
        except FormatError as error:
            raise AssertionError(f"what was written is refused: {error}") from error


def run(count: int, seed: int = 0, kind: str = "gltf") -> Counter[str]:
    """Try mutants; return how many were read, retimed and refused. What else happens is raised with its seed."""
    rng = np.random.default_rng(seed)
    scenes = [drawn_scene(i) for i in range(8)] if kind == "gltf" else []
    builders = [*map(small_fbx, range(36)), *map(drawn_fbx, range(2))] if kind != "gltf" else []
    path = Path("mutant.glb" if kind == "gltf" else "mutant.fbx")
    outcomes: Counter[str] = Counter()
    warp = Warp([0.0, 0.5, 0.7, 1.5], [0.0, 1.0, 1.0, 0.2])
    for number in range(count):
        data = mutant(rng, scenes) if kind == "gltf" else fbx_mutant(rng, builders, kind == "fbx-text")
        begun = time.monotonic()
        try:
            with warnings.catch_warnings():
                warnings.simplefilter("error")
                warnings.simplefilter("ignore", RetimeWarning)
                (_try_gltf if kind == "gltf" else _try_fbx)(path, data, warp, outcomes)
                outcomes["retimed"] += 1
        except FormatError:
            outcomes["refused"] += 1
        except Exception as error:
            raise AssertionError(f"mutant {number} of seed {seed}: {type(error).__name__}: {error}") from error
        if time.monotonic() - begun > 5:
            raise AssertionError(f"mutant {number} of seed {seed} took more than 5 s")
    return outcomes


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--count", type=int, default=1000)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--kind", choices=["gltf", "fbx", "fbx-text"], default="gltf")
    given = parser.parse_args()
    print(dict(run(given.count, given.seed, given.kind)))
