"""Motions and signals that a program holds in memory, written to files: the editor opens files only."""

from __future__ import annotations

import hashlib
import re
import tempfile
from pathlib import Path

import numpy as np

from retime.file_names import usable_name
from retime.formats.registry import write
from retime.motion.any_motion import AnyMotion
from retime.motion.motion import Motion


def file_of(clip: AnyMotion, folder: Path) -> Path:
    """Return the file of a clip, written where there is none yet: the same clip has the same file.

    A motion read from an AMC becomes one again, any other a BVH, which does not hold the length of its unit; a signal
    becomes NPZ.

    Parameters
    ----------
    clip : Motion or Signal
        What a program holds.
    folder : Path
        Where such files are kept, each in a folder of its own, so that it can have the clip's name.

    Raises
    ------
    FormatError
        No format holds it.
    OSError
        It can't be written.
    """
    suffix = ".npz"
    if isinstance(clip, Motion):
        suffix = ".amc" if clip.declaration is not None and clip.declaration.format == "amc" else ".bvh"
    stem = re.sub(r"[^\w.-]+", "_", clip.name).strip("._")[:60] or ("motion" if suffix != ".npz" else "signal")
    place = folder / _digest(clip) / usable_name(f"{stem}{suffix}")
    if place.exists():
        return place
    folder.mkdir(parents=True, exist_ok=True, mode=0o700)
    # Written beside its place, and moved there when whole: an AMC is two files, and both must be there or none.
    with tempfile.TemporaryDirectory(dir=folder) as beside:
        whole = Path(beside) / "whole"
        whole.mkdir(mode=0o700)
        write(clip, whole / place.name)
        try:
            whole.rename(place.parent)
        except OSError:
            # Another notebook wrote the same clip meanwhile.
            if not place.exists():
                raise
    return place


def _digest(clip: AnyMotion) -> str:
    """Return letters that tell a clip from any other."""
    facts: tuple[object, ...]
    if isinstance(clip, Motion):
        arrays = [clip.rotations, clip.local_translations, clip.skeleton.offsets]
        if clip.declared_angles is not None:
            arrays.append(clip.declared_angles)
        skeleton = clip.skeleton
        facts = (skeleton.names, skeleton.parents, skeleton.end_sites, clip.declaration, clip.metres_per_unit, clip.up)
    else:
        arrays, facts = [clip.values], (clip.names, clip.time_column, clip.kinds, clip.clock)
    digest = hashlib.sha256()
    for array in arrays:
        digest.update(np.ascontiguousarray(array).tobytes())
    # Every field is written out: the repr of a declaration leaves out long values.
    said = (type(clip).__name__, clip.name, str(clip.rate), clip.first_frame, *map(_written, facts))
    digest.update(repr(said).encode())
    return digest.hexdigest()[:16]


def _written(fact: object) -> str:
    return repr(vars(fact)) if hasattr(fact, "__dict__") else repr(fact)
