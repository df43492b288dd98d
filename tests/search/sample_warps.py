"""Warps of the clip that ships with retime, and digests of them; needs NumPy and retime alone.

Run as a script it prints what it finds, as `sample_digests.json` holds it. Change that file only where a change of the
results is meant, and say so in the changelog.
"""

from __future__ import annotations

import hashlib
import json
import sys
from typing import Any

import numpy as np

import retime
from retime.search.keytimes import as_keytimes
from retime.warp.spline import spline_warp

REQUESTS: dict[str, dict[str, Any]] = {
    "shorter": {"length": "65%"},
    "longer, with a jump uncut": {"length": "130%", "locks": ["6.1..6.6=uncut"], "upsample": 2},
    "keys, one with a tangent": {"length": "8s", "keys": ["5=3.5", "00:00:11:11=7@1"]},
    "a hold and a reversal": {"length": "14s", "keys": ["3=2.5", "3=3.5", "2=5"]},
    "smooth, within limits": {"length": "80%", "speed": "1/2..2", "smoothness": 0.5},
    "the other score": {"length": "75%", "score": "conditional"},
    "the other search": {"length": "75%", "search": "layered"},
    "half the influence": {"length": "75%", "keys": ["6=4.4"], "influence": 0.5},
    "a free length": {"length": "free", "keys": ["6=4"], "max_length": "90%", "features": "torso"},
}


def digest(*arrays: np.ndarray) -> str:
    """Hash the bits of some arrays, the same on every machine."""
    found = hashlib.sha256()
    for array in arrays:
        found.update(array.astype(array.dtype.newbyteorder("<")).tobytes())
    return found.hexdigest()[:32]


def digests() -> dict[str, dict[str, str]]:
    """Find every warp; hash its frame path, and its knots."""
    clip = retime.sample()
    found = {}
    for name, options in REQUESTS.items():
        result = retime.guided_warp(clip, **options)
        path = digest(np.asarray(result.path.frames, dtype=np.int64))
        found[name] = {"path": path, "warp": digest(result.warp.output_times, result.warp.input_times)}
    spline = spline_warp(as_keytimes(clip, "75%", ["6=4", "9=6@1/2"]), rate=float(clip.rate))
    found["a spline"] = {"warp": digest(spline.output_times, spline.input_times)}
    return found


if __name__ == "__main__":
    json.dump(digests(), sys.stdout, indent=2)
    print()
