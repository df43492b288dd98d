"""Mutants of files of arrays, and of captures that are retimed in place: each is read, or refused as FormatError.

C3D files of every machine, archives of SMPL bodies, and frames of HumanML3D are retimed too, and what was written is
read again; plain arrays and archives of them are signals.
"""

from __future__ import annotations

import functools
import io
import random
import zipfile
from collections.abc import Callable
from fractions import Fraction
from pathlib import Path
from types import ModuleType

import numpy as np

from retime.errors import FormatError
from retime.formats import amass, c3d, humanml3d, npy
from retime.formats.read_options import Limits, ReadOptions
from retime.motion.gaps import GapPolicy
from retime.warp.curve import Warp
from tests.formats.body_files import body, smplx
from tests.formats.body_files import npz as archive
from tests.formats.c3d_files import drawn
from tests.fuzz.text_files import check, written_again
from tests.fuzz.trials import Trial, mutated_bytes, mutated_text

_LIMITS = Limits(file_bytes=1 << 20, frames=20_000, joint_poses=100_000, inflated_bytes=4 << 20)
_WARP = Warp([0.0, 0.05, 0.1, 0.2, 0.3], [0.0, 0.15, 0.15, 0.02, 0.3])
_HIGHEST_RATE = 60_000
_ODD_WORDS = [0, 1, 2, 127, 128, 255, 256, 12345, 32767, 32768, 65535]


@functools.cache
def whole_files() -> dict[str, tuple[bytes, ...]]:
    """Return files that mutants are made of."""
    frames = io.BytesIO()
    np.save(frames, np.linspace(-1, 1, 9 * 263).reshape(9, 263).astype("f4"))
    small = [body(seed, n_frames=7, joints=joints) for seed, joints in enumerate((22, 24, 52))]
    extended = smplx(4, n_frames=7)
    more = {"names": np.array(["a", "b"]), "seen": np.arange(7) > 3, "notes": np.array([None, {}], dtype=object)}
    return {
        "c3d": tuple(drawn(seed).build() for seed in range(60)),
        "amass": (*(archive(one) for one in small), archive(extended), archive(small[0] | more, compressed=True)),
        "humanml3d": (frames.getvalue(),),
        **_arrays(),
    }


def _arrays() -> dict[str, tuple[bytes, ...]]:
    """Return arrays of every kind of number and layout, and archives of them with all that is known by name."""
    values = np.linspace(-1.0, 1.0, 24).reshape(8, 3)
    plain = []
    for array in (
        *(values.astype(kind) for kind in ("<f8", ">f4", "<f2", "i2", "?")),
        np.asfortranarray(values),
        values[:, 0],
        values.reshape(4, 2, 3),
        np.array(["a", "b"]),
        np.array([{}], dtype=object),
        np.zeros(2, dtype=[("a", "f8"), ("b", "i4")]),
    ):
        file = io.BytesIO()
        np.save(file, array)
        plain.append(file.getvalue())
    label = {"kinds": np.array(["linear", "angle:deg", "label"]), "words": np.array(["a", "b"])}
    label |= {"word_counts": np.array([0, 0, 2])}
    archives = (
        archive({"values": values, "rate": 30.0, "names": np.array(["x", "y", "z"])}),
        archive({"values": values, "rate": 30.0, **label}, compressed=True),
        archive({"points": values.reshape(4, 2, 3), "fps": 25, "point_names": np.array(["a", "b"])}),
        archive({"values": values, "frame_rate": 24, "first_frame": 3, "start_time": 0.125}),
        archive({"a": values, "b": values[:, :1], "objects": np.array([{}], dtype=object)}),
    )
    return {"npy": tuple(plain), "npz": archives}


def mutant_c3d(draw: random.Random, data: bytes) -> bytes:
    """Change a C3D: numbers of its header and its parameters more often than its frames, or any bytes."""
    for _ in range(draw.choice([0, 1, 1, 2, 3])):
        if draw.random() < 0.3 or len(data) <= 512:
            data = mutated_bytes(draw, data)
            continue
        # Headers end at 400, and parameters follow them for a block or three.
        place = draw.choice([draw.randrange(0, 24, 2), draw.randrange(298, 402), draw.randrange(512, len(data))])
        word = draw.choice([*_ODD_WORDS, draw.randrange(65536)]).to_bytes(2, draw.choice(["little", "big"]))
        data = data[:place] + word[: draw.choice([1, 2])] + data[place + 2 :]
    return data[: draw.randrange(len(data))] if draw.random() < 0.05 and data else data


def mutated_array(draw: random.Random, data: bytes) -> bytes:
    """Change an array: mostly in its header, which is text and shorter than the numbers."""
    if draw.random() < 0.4:
        return mutated_bytes(draw, data)
    at = draw.choice([6, 8, 10, 10, 10])
    head = mutated_text(draw, data[at:128], _HEADER_WORDS)
    if draw.random() < 0.7:
        # Of the length that it says, or most would be refused for that alone.
        head = head.replace(b"\n", b"")[: 127 - at].ljust(127 - at) + b"\n"
    return data[:at] + head + data[128:]


_HEADER_WORDS = tuple(
    b"'descr'|'<f8'|'>f4'|'|O'|'<U3'|'|b1'|'<i8'|'<c16'|[('a', '<f8')]|'fortran_order'|True|False|'shape'|(8, 3)|(8,)|"
    b"()|(-1, 3)|(2000000000, 3)|(0, 3)|(4, 2, 3)|{|}|__import__('os')|9**9**9".split(b"|")
)


def mutant_npz(draw: random.Random, data: bytes) -> bytes:
    """Change an archive: the bytes of its members, under sums that are right, or any bytes."""
    if draw.random() < 0.3:
        return mutated_bytes(draw, data)
    with zipfile.ZipFile(io.BytesIO(data)) as file:
        members = {member.filename: file.read(member) for member in file.infolist()}
    for _ in range(draw.choice([0, 1, 1, 2])):
        name = draw.choice(list(members))
        kind = draw.randrange(4)
        if kind == 0:
            members.pop(name)
            if not members:
                break
        elif kind == 1:
            members[draw.choice([*members, "fps.npy", "../x.npy", "trans.npy", "dmpls", "poses.npy"])] = members[name]
        else:
            members[name] = (mutated_bytes if kind == 2 else mutated_array)(draw, members[name])
    new = io.BytesIO()
    with zipfile.ZipFile(new, "w", draw.choice([zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED])) as out:
        for name, content in members.items():
            out.writestr(name, content)
    return new.getvalue()


def capture_file(draw: random.Random, kind: str) -> str:
    """Make a mutant, read it, retime one of three, and read what came out."""
    module, change = _CAPTURES[kind]
    data = change(draw, draw.choice(whole_files()[kind]))
    options = ReadOptions(
        rate=Fraction(30) if draw.random() < 0.3 else None,
        repair=draw.random() < 0.3,
        gaps=draw.choice([None, GapPolicy(), GapPolicy(1.0)]),
        arrays=draw.choice([(), (), ("points",), ("analog",)]) if kind == "c3d" else (),
        limits=_LIMITS,
    )
    path = Path("mutant" + _SUFFIXES[kind])
    claimed = kind == "c3d" or module.claims(io.BytesIO(data))
    retimed = draw.random() < 0.34
    try:
        clip = module.read(path, data, options)
        check(clip)
        if draw.random() < 0.02:
            written_again(clip)
        assert claimed, "what is no body of its own was read as one"
        if kind != "humanml3d" and retimed:
            module.facts(path, data, options)
    except FormatError:
        if not retimed:
            raise
        # A part that can't be looked at may still be retimed: the markers of a file whose forces are broken.
        clip = None
    # The warp takes three tenths of a second, of which a rate that is misread can make what no bound here holds.
    if not retimed or (clip is not None and clip.rate > _HIGHEST_RATE):
        return f"{kind} is read"
    new = module.retime_frames(path, data, _WARP, options, average=draw.random() < 0.5, held=1)
    again = ReadOptions(rate=options.rate, gaps=GapPolicy(), limits=Limits())
    if clip is not None:
        module.read(path, new, again)
    assert len(module.retime_frames(path, new, Warp([0.0, 0.1], [0.0, 0.1]), again)) > 0
    return f"{kind} is retimed"


_SUFFIXES = {"c3d": ".c3d", "amass": ".npz", "humanml3d": ".npy"}
_CAPTURES: dict[str, tuple[ModuleType, Callable[[random.Random, bytes], bytes]]] = {
    "c3d": (c3d, mutant_c3d),
    "amass": (amass, mutant_npz),
    "humanml3d": (humanml3d, mutated_array),
}


def array_file(draw: random.Random, kind: str) -> str:
    """Read a mutant of an array, or of an archive of them, as a signal."""
    data = (mutant_npz if kind == "npz" else mutated_array)(draw, draw.choice(whole_files()[kind]))
    options = ReadOptions(
        rate=Fraction(30) if draw.random() < 0.6 else None,
        repair=draw.random() < 0.3,
        gaps=draw.choice([None, GapPolicy(), GapPolicy(1.0)]),
        arrays=("values",) if draw.random() < 0.1 else (),
    )
    clip = npy.read(Path(f"mutant.{kind}"), data, options)
    check(clip)
    if draw.random() < 0.05:
        written_again(clip)
        return f"{kind} is converted"
    return f"{kind} is read"


KINDS: dict[str, Trial] = {
    **{kind: functools.partial(array_file, kind=kind) for kind in ("npy", "npz")},
    **{kind: functools.partial(capture_file, kind=kind) for kind in _CAPTURES},
}
