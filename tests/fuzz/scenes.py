"""Mutants of glTF scenes: each is read and retimed, or refused as FormatError.

python -m tests.fuzz.scenes --count 200000
"""

from __future__ import annotations

import argparse
import copy
import json
import struct
import time
import warnings
from collections import Counter
from pathlib import Path
from typing import Any

import numpy as np

from retime.errors import FormatError, RetimeWarning
from retime.formats.curves import gltf
from retime.formats.read_options import Limits, ReadOptions
from retime.warp.curve import Warp
from tests.formats.curves.scenes import Scene, drawn_scene

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


def run(count: int, seed: int = 0) -> Counter[str]:
    """Try mutants; return how many were read, retimed and refused. What else happens is raised with its seed."""
    rng = np.random.default_rng(seed)
    seeds = [drawn_scene(i) for i in range(8)]
    path = Path("mutant.glb")
    outcomes: Counter[str] = Counter()
    warp = Warp([0.0, 0.5, 0.7, 1.5], [0.0, 1.0, 1.0, 0.2])
    for number in range(count):
        data = mutant(rng, seeds)
        begun = time.monotonic()
        try:
            with warnings.catch_warnings():
                warnings.simplefilter("error")
                warnings.simplefilter("ignore", RetimeWarning)
                names = gltf.animation_names(path, data, _OPTIONS)
                gltf.read(path, data, _OPTIONS)
                outcomes["read"] += 1
                new = gltf.retime(path, data, dict.fromkeys(names, warp), _OPTIONS)[""]
                # What was written is read again.
                gltf.read(path, new, _OPTIONS)
                json.loads(new[20 : 20 + struct.unpack_from("<I", new, 12)[0]])
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
    given = parser.parse_args()
    print(dict(run(given.count, given.seed)))
