"""Mutants of files of every format: each is read as a valid clip, or refused as retime refuses.

    python -m tests.fuzz.files --count 100000 --seed 1

What is read has finite numbers, unit rotations and a rate; some of it is written again, and then read as the same.
"""

from __future__ import annotations

import bz2
import functools
import gzip
import io
import json
import random
import sys
import tempfile
import warnings
from dataclasses import replace
from pathlib import Path

import numpy as np

from retime.errors import FormatError
from retime.formats import read, write
from retime.formats.joint_map import read_joint_map
from retime.motion.motion import Motion
from retime.warp.apply import apply_warp
from retime.warp.curve import Warp
from tests.fuzz.trials import command, mutated_bytes, mutated_json, mutated_text

DATA = Path(__file__).resolve().parents[1] / "data"
PACKERS = {".gz": gzip.compress, ".bz2": bz2.compress}


@functools.cache
def whole_files() -> tuple[tuple[str, bytes], ...]:
    """Return files that mutants are made of: their endings and bytes."""
    found = [
        (path.suffix, path.read_bytes())
        for folder in ("bvh", "amc", "asf", "csv")
        for path in sorted((DATA / folder).glob(f"*.{folder}"))
        if not path.name.startswith("broken") and path.stat().st_size < 8000
    ]
    values = np.linspace(-1.0, 1.0, 24).reshape(8, 3)
    npy, npz, packed = io.BytesIO(), io.BytesIO(), io.BytesIO()
    np.save(npy, values)
    np.savez(npz, values=values, rate=30.0, names=np.array(["x", "y", "z"]))
    np.savez_compressed(packed, values=values, rate=30.0)
    warp = Warp([0.0, 0.1, 0.2], [0.0, 0.15, 0.2], [(0.15, 0.1, 1.0)], name="walk").to_json().encode()
    pairs = b'{"Hips": "hip", "Knee": "knee"}', b"Hips,hip\nKnee,knee\n"
    # As many of each as there are of a format that is text.
    for suffix, data in ((".npy", npy.getvalue()), (".npz", npz.getvalue()), (".npz", packed.getvalue())):
        found += [(suffix, data)] * 5
    found += [(".warp", warp)] * 10 + [(".map.json", pairs[0])] * 3 + [(".map.csv", pairs[1])] * 3
    return tuple(found)


def trial(draw: random.Random) -> str:
    """Make a mutant, and read it."""
    suffix, data = draw.choice(whole_files())
    if suffix == ".warp" and draw.random() < 0.8:
        # Whole as JSON, so that more of it comes through.
        return _warp(json.dumps(mutated_json(draw, json.loads(data))).encode())
    packer = draw.choice(list(PACKERS)) if draw.random() < 0.15 and suffix not in (".warp", ".asf") else ""
    # Damage to what is packed, or to the pack.
    inside = not packer or draw.random() < 0.7
    if inside:
        change = mutated_bytes if suffix.startswith(".np") else mutated_text
        data = change(draw, data)
    if packer:
        data = PACKERS[packer](data)
        if not inside:
            data = mutated_bytes(draw, data)
    if suffix == ".warp":
        return _warp(data)
    with tempfile.TemporaryDirectory(prefix="retime-fuzz-") as name:
        folder = Path(name)
        path = folder / f"clip{suffix}{packer}"
        path.write_bytes(data)
        if suffix.startswith(".map"):
            read_joint_map(path)
            return "a joint map is read"
        if suffix == ".asf":
            path = folder / "clip.amc"
            path.write_bytes(b":FULLY-SPECIFIED\n:DEGREES\n1\nroot 0 0 0 0 0 0\n")
        elif suffix == ".amc":
            (folder / "clip.asf").write_bytes((DATA / "amc" / "arm.asf").read_bytes())
        rate = None if draw.random() < 0.5 else 30
        clip = read(path, rate=rate, repair=draw.random() < 0.3)
        check(clip)
        if draw.random() < 0.3:
            write_and_read(clip, folder / f"again{suffix if suffix != '.asf' else '.amc'}")
    return f"{suffix}{packer} is read"


def check(clip: object) -> None:
    """Look whether a clip is one."""
    if isinstance(clip, Motion):
        assert np.isfinite(clip.local_translations).all()
        np.testing.assert_allclose(np.linalg.norm(clip.rotations, axis=-1), 1.0, atol=1e-9)
    else:
        assert np.isfinite(clip.values[~clip.holes]).all()
    assert clip.n_frames >= 1
    assert clip.rate > 0


def write_and_read(clip: object, path: Path) -> None:
    """Write a clip, and look whether it is read as the same."""
    try:
        write(clip, path)
    except FormatError:
        # Names that a format can't hold, numbers that its text can't.
        return
    skeleton = path.with_suffix(".asf")
    again = read(path, rate=clip.rate, skeleton=skeleton if skeleton.exists() else None)
    assert again.n_frames == clip.n_frames
    if isinstance(clip, Motion):
        turned = 1 - np.abs(np.einsum("fjc,fjc->fj", clip.rotations, again.rotations))
        assert turned.max(initial=0.0) < 1e-6, f"rotations differ: {turned.max()}"
    else:
        np.testing.assert_array_equal(clip.values, again.values)


@functools.cache
def _walk() -> Motion:
    motion = read(DATA / "bvh" / "angles_beyond_half_turns.bvh")
    assert isinstance(motion, Motion)
    return replace(motion, declaration=None, declared_angles=None)


def _warp(data: bytes) -> str:
    """Read a warp, and do with it what commands do."""
    warp = Warp.from_json(data)
    assert Warp.from_json(warp.to_json()) == warp
    _ = repr(warp), warp._repr_html_(), warp.slopes
    clip = apply_warp(_walk(), warp)
    check(clip)
    if warp.monotone:
        warp.inverse()
    return "a warp is applied"


if __name__ == "__main__":
    warnings.simplefilter("ignore")
    sys.exit(command(trial, __doc__))
