"""Mutants of scenes (glTF; FBX, binary and in text): each is read, retimed and baked, or refused as FormatError."""

from __future__ import annotations

import functools
import pickle
import random
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from retime.errors import FormatError
from retime.formats.curves.fbx import format as fbx
from retime.formats.curves.fbx.scene import parse_fbx
from retime.formats.curves.gltf import format as gltf
from retime.formats.read_options import Limits, ReadOptions
from retime.warp.curve import Warp
from tests.formats.curves.fbx.files import ARRAYS, Builder, ascii_, binary, drawn_fbx, drawn_track
from tests.formats.curves.gltf.scenes import Scene, drawn_scene
from tests.fuzz.text_files import check, written_again
from tests.fuzz.trials import Trial, mutated_bytes, mutated_text

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


@functools.cache
def _gltf_scenes() -> tuple[tuple[bytes, bytes, bytes], ...]:
    """Return small scenes: their JSON, pickled, which is copied fast; their binary chunk; and their text."""
    scenes = [drawn_scene(seed) for seed in range(8)]
    return tuple((pickle.dumps(scene.json), bytes(scene.chunk), scene.gltf()) for scene in scenes)


def gltf_mutant(draw: random.Random, *, text: bool) -> bytes:
    """Make one: numbers and texts of its JSON exchanged, parts taken away, bytes turned, the end cut off."""
    pickled, chunk, written = draw.choice(_gltf_scenes())
    if text and draw.random() < 0.4:
        return mutated_text(draw, written, _GLTF_WORDS, [one for _, _, one in _gltf_scenes()])
    changed = Scene()
    changed.json, changed.chunk = pickle.loads(pickled), bytearray(chunk)
    for _ in range(draw.choice([0, 1, 1, 1, 2, 3])):
        places = _places(changed.json)
        if not places:
            break
        holder, key = draw.choice(places)
        kind = draw.randrange(4)
        if kind == 0:
            del holder[key]
        elif kind == 1:
            other, there = draw.choice(places)
            holder[key] = pickle.loads(pickle.dumps(other[there]))
        elif isinstance(holder[key], int | float) and kind == 2:
            holder[key] = type(holder[key])(holder[key] + draw.randint(-3, 3))
        else:
            holder[key] = pickle.loads(pickle.dumps(draw.choice(_ODD)))
    if text:
        return changed.gltf()
    data = changed.glb()
    for _ in range(draw.choice([0, 0, 0, 0, 0, 1, 1, 2])):
        data = mutated_bytes(draw, data)
    return data


_GLTF_WORDS = tuple(
    b'"accessors"|"bufferViews"|"animations"|"samplers"|"channels"|"target"|"path"|"rotation"|"weights"|"CUBICSPLINE"|"STEP"|'
    b'"sparse"|"normalized"|5126|5123|5121|"VEC4"|"SCALAR"|"MAT4"|"data:application/octet-stream;base64,AAAA"|'
    b'"../x.bin"|"http://a/b"|"nodes"|"children"|[0]|{}|[]|null|-1|1e400|99999999999|"byteOffset"|"skins"'.split(b"|")
)


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
    """Make a limb that every kind of key moves, in two layers, beside a shape: small, so that many can be tried.

    Of each three one is whole, and two have some of it.
    """
    rng = np.random.default_rng(seed)
    has_top, has_weight, has_shape = (seed % 3 == 0 or rng.random() < 0.5 for _ in range(3))
    made = Builder()
    made.settings = [("UpAxis", ("I", int(rng.integers(3)))), ("TimeMode", ("I", 6)), ("TimeSpanStop", ("L", 10**11))]
    limb = made.model("limb", RotationActive=1, RotationOrder=seed % 6, PreRotation=rng.normal(size=3) * 30)
    stack = made.stack("take", 0.0, 1.0)
    base = made.layer(stack)
    beyond = replace(
        drawn_track(rng, 2, start=0.2), pre="RAMK"[seed % 4], post="KRAM"[seed % 4], repetition=seed % 3 - 1
    )
    made.animate(base, limb, "Lcl Rotation", {"X": drawn_track(rng, 5), "Y": beyond}, Z=3.0)
    if has_top:
        top = made.layer(stack, "top", Weight=60.0, BlendMode=seed % 3)
        made.animate(top, limb, "Lcl Rotation", {"Z": drawn_track(rng, 3)})
        if has_weight:
            made.animate(top, top, "Weight", {"Weight": drawn_track(rng, 2)})
    if has_shape:
        shape = made.add("Deformer", "smile", "SubDeformer", "BlendShapeChannel", [])
        made.animate(base, shape, "DeformPercent", {"DeformPercent": drawn_track(rng, 3)})
    return made


@functools.cache
def _fbx_scenes() -> Mapping[int, tuple[bytes, ...]]:
    """Return scenes of each version: their records, pickled, which are copied fast."""
    builders = [*map(small_fbx, range(36)), *map(drawn_fbx, range(2))]
    return {version: tuple(pickle.dumps(one.records(version)) for one in builders) for version in _VERSIONS}


_VERSIONS = (7100, 7400, 7500, 7700)


def _lists(records: list[Any]) -> list[list[Any]]:
    """List all lists of records that hold some."""
    lists, waiting = [], [records]
    while waiting:
        one = waiting.pop()
        if one:
            lists.append(one)
        waiting += [inner for _, _, inner in one if inner]
    return lists


def fbx_mutant(draw: random.Random, *, text: bool) -> bytes:
    """Make one: values of its records exchanged, records taken away or doubled, bytes turned, the end cut off."""
    rng = np.random.default_rng(draw.randrange(2**63))
    version = draw.choice(_VERSIONS)
    # The last two are long.
    which = draw.randrange(38) if draw.random() < 0.2 else draw.randrange(36)
    records = pickle.loads(_fbx_scenes()[version][which])
    for _ in range(draw.choice([0, 1, 1, 1, 2, 3])):
        lists = _lists(records)
        if not lists:
            break
        chosen = draw.choice(lists)
        place = draw.randrange(len(chosen))
        kind = draw.randrange(6)
        if kind == 0:
            del chosen[place]
        elif kind == 1:
            chosen.insert(place, pickle.loads(pickle.dumps(draw.choice(draw.choice(lists)))))
        elif chosen[place][1]:
            name, values, inner = chosen[place]
            values = list(values)
            spot = draw.randrange(len(values))
            values[spot] = _odd_value(rng, values[spot])
            chosen[place] = (name, values, inner)
    if text:
        data = ascii_(records, version, "\n" if draw.random() < 0.8 else "\r\n")
        return mutated_text(draw, data, _FBX_WORDS) if draw.random() < 0.3 else data
    data = binary(records, version, draw.random() < 0.5)
    for _ in range(draw.choice([0, 0, 0, 0, 0, 1, 1, 2])):
        data = mutated_bytes(draw, data)
    return data


_FBX_WORDS = tuple(
    b'Objects:|Connections:|C: "OO",1,2|AnimationCurve:|KeyTime: *3 {|a: 1,2,3|KeyAttrFlags:|Properties70:|'
    b'P: "Lcl Rotation"|{|}|*99999999|"|;|,|: |Takes:|Version: 7500|*0 {|FBXHeaderExtension:  {'.split(b"|")
)


def gltf_file(draw: random.Random, *, text: bool) -> str:
    """Read and retime a mutant of glTF, in text or as GLB; what was written is read again."""
    data = gltf_mutant(draw, text=text)
    path = Path("mutant.gltf" if text else "mutant.glb")
    names = gltf.animation_names(path, data, _OPTIONS)
    clip = gltf.read(path, data, _OPTIONS)
    check(clip)
    if draw.random() < 0.05:
        written_again(clip)
        return "a scene is converted"
    if draw.random() < 0.5:
        return "a scene is read"
    new = gltf.retime(path, data, dict.fromkeys(names, _WARP), _OPTIONS)
    if text and len(new) > 1:
        return "a scene is retimed, with a file beside it"
    gltf.read(path, new[""], _OPTIONS)
    return "a scene is retimed"


def fbx_file(draw: random.Random, *, text: bool) -> str:
    """Read and retime a mutant of FBX, in text or binary; now and then it is baked.

    What lies behind the parser is the same for both: of those in text, three of four are parsed alone.
    """
    data = fbx_mutant(draw, text=text)
    path = Path("mutant.fbx")
    if text and draw.random() < 0.75:
        scene = parse_fbx(path, data, _OPTIONS.limits)
        return "a scene is parsed, with animations" if scene.stacks else "a scene is parsed"
    if draw.random() < 0.1:
        assert fbx.animation_names(path, data, _OPTIONS)
    clip = fbx.read(path, data, _OPTIONS)
    check(clip)
    if draw.random() < 0.05:
        written_again(clip)
        return "a scene is converted"
    # Cutting and baking take as long as five readings.
    how = draw.randrange(60)
    if how < 48:
        return "a scene is read"
    names = fbx.animation_names(path, data, _OPTIONS)
    if how < 58:
        new = fbx.retime(path, data, dict.fromkeys(names, _WARP), _OPTIONS)
    else:
        new = fbx.bake(path, data, {names[0]: Warp([0.0, 0.5], [0.0, 1.0])}, _OPTIONS, average=clip.n_frames % 2 == 0)
    if how % 2:
        try:
            fbx.read(path, new[""], _OPTIONS)
        except FormatError as error:
            raise AssertionError(f"what was written is refused: {error}") from error
    return "a scene is retimed" if how < 58 else "a scene is baked"


_WARP = Warp([0.0, 0.5, 0.7, 1.5], [0.0, 1.0, 1.0, 0.2])
KINDS: dict[str, Trial] = {
    "glb": functools.partial(gltf_file, text=False),
    "gltf": functools.partial(gltf_file, text=True),
    "fbx": functools.partial(fbx_file, text=False),
    "fbx-text": functools.partial(fbx_file, text=True),
}
