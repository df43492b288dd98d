"""Use retime where there is NumPy and nothing else, as inside Blender; `make core` runs this in such an environment."""

from __future__ import annotations

import importlib
import importlib.util
import json
import pkgutil
import runpy
import sys
import tempfile
from pathlib import Path

import numpy as np

import retime

TESTS = Path(__file__).parent
# What needs no other package: everything but the command line, plots, and the editor's server.
CORE = ("motion", "warp", "search", "kernels", "formats", "data", "project", "evaluate.metrics")


def main() -> None:
    """Import the core, find warps and compare their bits, retime a motion through a file."""
    for absent in ("scipy", "click", "matplotlib"):
        assert importlib.util.find_spec(absent) is None, f"{absent} is installed: this proves nothing"
    for part in CORE:
        package = importlib.import_module(f"retime.{part}")
        for module in pkgutil.walk_packages(getattr(package, "__path__", []), f"retime.{part}."):
            try:
                importlib.import_module(module.name)
            except ModuleNotFoundError as error:
                # What runs USD's own libraries is loaded by a process of its own, and by nothing else.
                if (error.name, module.name.startswith("retime.formats.curves.usd.")) != ("pxr", True):
                    raise
    found = runpy.run_path(str(TESTS / "search" / "sample_warps.py"))["digests"]()
    expected = json.loads((TESTS / "search" / "sample_digests.json").read_text(encoding="utf-8"))
    different = [name for name in expected if found.get(name) != expected[name]]
    assert not different, f"other bits than committed: {different}"
    with tempfile.TemporaryDirectory() as folder:
        clip = retime.sample()
        shorter = retime.apply_warp(clip, retime.guided_warp(clip, length="65%").warp)
        retime.write(shorter, Path(folder) / "shorter.bvh")
        again = retime.read(Path(folder) / "shorter.bvh")
        assert again.n_frames == round(0.65 * clip.n_frames)
        np.testing.assert_allclose(again.local_translations, shorter.local_translations, atol=1e-4)
    for form, numbers in (("matrix", np.eye(3)), ("rotvec", np.zeros(3))):
        rotations = np.tile(numbers, (30, 1) + (1,) * numbers.ndim)
        made = retime.Motion.from_arrays(rotations, form=form, parents=[-1], offsets=np.zeros((1, 3)), rate=30)
        assert made.rotations[:, 0].tolist() == [[1.0, 0.0, 0.0, 0.0]] * 30
    print(f"The core works with NumPy {np.__version__} alone, on Python {sys.version.split()[0]}")


if __name__ == "__main__":
    main()
