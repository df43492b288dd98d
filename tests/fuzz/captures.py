"""Mutants of captures that are retimed in place: each is read and retimed, or refused as FormatError.

    python -m tests.fuzz.captures --count 200000
    python -m tests.fuzz.captures --count 200000 --only-kind npz

C3D files of every machine, archives of SMPL bodies, and frames of HumanML3D. What was written is read again.
"""

from __future__ import annotations

import functools
import io
import random
import sys
import warnings
import zipfile
from collections.abc import Callable
from pathlib import Path
from types import ModuleType

import numpy as np

from retime.errors import FormatError
from retime.formats import amass, c3d, humanml3d
from retime.formats.read_options import Limits, ReadOptions
from retime.motion.gaps import GapPolicy
from retime.motion.motion import Motion
from retime.warp.curve import Warp
from tests.formats.body_files import body, npz, smplx
from tests.formats.c3d_files import drawn
from tests.fuzz.trials import command, mutated_bytes

_LIMITS = Limits(file_bytes=1 << 20, frames=20_000, joint_poses=100_000, inflated_bytes=4 << 20)
_WARP = Warp([0.0, 0.05, 0.1, 0.2, 0.3], [0.0, 0.15, 0.15, 0.02, 0.3])
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
        "npz": (*(npz(one) for one in small), npz(extended), npz(small[0] | more, compressed=True)),
        "npy": (frames.getvalue(),),
    }


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


def mutant_npz(draw: random.Random, data: bytes) -> bytes:
    """Change an archive: the bytes of its members, under sums that are right, or any bytes."""
    if draw.random() < 0.3:
        return mutated_bytes(draw, data)
    with zipfile.ZipFile(io.BytesIO(data)) as archive:
        members = {member.filename: archive.read(member) for member in archive.infolist()}
    for _ in range(draw.choice([0, 1, 1, 2])):
        name = draw.choice(list(members))
        kind = draw.randrange(4)
        if kind == 0:
            members.pop(name)
            if not members:
                break
        elif kind == 1:
            members[draw.choice([*members, "fps.npy", "../x.npy", "trans.npy", "dmpls", "poses.npy"])] = members[name]
        elif kind == 2:
            members[name] = mutated_bytes(draw, members[name])
        else:
            # In its header, which is shorter than the numbers.
            head = mutated_bytes(draw, members[name][:128])
            members[name] = head + members[name][128:]
    file = io.BytesIO()
    with zipfile.ZipFile(file, "w", draw.choice([zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED])) as out:
        for name, content in members.items():
            out.writestr(name, content)
    return file.getvalue()


_KINDS: dict[str, tuple[ModuleType, Callable[[random.Random, bytes], bytes]]] = {
    "c3d": (c3d, mutant_c3d),
    "npz": (amass, mutant_npz),
    "npy": (humanml3d, mutated_bytes),
}


def trial(draw: random.Random, kinds: tuple[str, ...] = ("c3d", "c3d", "npz", "npz", "npy")) -> str:
    """Make a mutant, read it, retime it, and read what came out."""
    kind = draw.choice(kinds)
    module, change = _KINDS[kind]
    data = change(draw, draw.choice(whole_files()[kind]))
    options = ReadOptions(
        rate=30 if draw.random() < 0.3 else None,  # type: ignore[arg-type]
        repair=draw.random() < 0.3,
        gaps=draw.choice([None, GapPolicy(), GapPolicy(1.0)]),
        arrays=draw.choice([(), (), ("points",), ("analog",)]) if kind == "c3d" else (),
        limits=_LIMITS,
    )
    path = Path(f"mutant.{kind}")
    claimed = kind == "c3d" or module.claims(io.BytesIO(data))
    try:
        clip = module.read(path, data, options)
        values = clip.rotations if isinstance(clip, Motion) else clip.values[~clip.holes]
        assert np.isfinite(values).all()
        assert clip.n_frames >= 1
        assert clip.rate > 0
        assert claimed, "what is no body of its own was read as one"
        if kind != "npy":
            module.facts(path, data, options)
    except FormatError:
        # A part that can't be looked at may still be retimed: the markers of a file whose forces are broken.
        clip = None
    new = module.retime_frames(path, data, _WARP, options, average=draw.random() < 0.5, held=1)
    again = ReadOptions(rate=options.rate, gaps=GapPolicy(), limits=Limits())
    if clip is not None:
        module.read(path, new, again)
    assert len(module.retime_frames(path, new, Warp([0.0, 0.1], [0.0, 0.1]), again)) > 0
    return f"{kind} is retimed"


if __name__ == "__main__":
    warnings.simplefilter("ignore")
    chosen = trial
    if "--only-kind" in sys.argv:
        at = sys.argv.index("--only-kind")
        chosen = functools.partial(trial, kinds=(sys.argv[at + 1],))
        del sys.argv[at : at + 2]
    sys.exit(command(chosen, __doc__))
