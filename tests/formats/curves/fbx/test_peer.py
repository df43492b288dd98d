"""FBX by ufbx (package pufbx, which wants a C compiler): it finds keys and handles that make the same curves."""

from __future__ import annotations

import itertools
from pathlib import Path

import numpy as np
import pytest

from retime.formats.curves.fbx import format as fbx
from retime.formats.read_options import ReadOptions
from retime.warp.curve import Warp
from tests.formats.curves.fbx.files import drawn_fbx
from tests.reference.fbx import Scene as Literal
from tests.reference.segments import CUBIC, LINEAR, STEP, value_at

pytestmark = pytest.mark.extras


class Peer:
    """The curves of a file, as ufbx has them."""

    def __init__(self, path: Path, data: bytes) -> None:
        pufbx = pytest.importorskip("pufbx", reason="pufbx is not installed (pip install pufbx, with a C compiler)")
        path.write_bytes(data)
        self.scene = pufbx.load_fbx(str(path))
        self.curves = list(self.scene.anim_curves)

    def value(self, index: int, time: float) -> float:
        """What a curve has at a time."""
        keys = self.curves[index].keyframes
        times, values, kinds = [], [], []
        for key, after in itertools.pairwise(keys):
            name = key.interpolation.name
            times.append([key.time, key.time + key.right[0], after.time - after.left[0], after.time])
            line = [key.value, key.value + key.right[1], after.value - after.left[1], after.value]
            line = [after.value] * 4 if name.endswith("CONSTANT_NEXT") else line
            values.append([[one] for one in line])
            kinds.append(STEP if "CONSTANT" in name else LINEAR if name.endswith("LINEAR") else CUBIC)
        return (
            float(keys[0].value) if time < keys[0].time else value_at(times, values, kinds, [keys[-1].value], time)[0]
        )


@pytest.mark.parametrize("text", [False, True])
@pytest.mark.parametrize("seed", range(4))
def test_another_program_finds_the_same_values_at_the_warps_times(seed: int, text: bool, tmp_path: Path) -> None:
    made = drawn_fbx(seed, 0.25)
    data = made.ascii() if text else made.binary(7500, packed=True)
    warp = Warp([0.0, 0.75, 1.0, 1.5, 2.25], [0.0, 1.5, 1.5, 0.5, 2.5])
    new = fbx.retime(Path("a.fbx"), data, warp, ReadOptions())[""]
    before, after = Peer(tmp_path / "a.fbx", data), Peer(tmp_path / "b.fbx", new)
    assert len(before.curves) == len(after.curves) == len(Literal(data).curves)
    for index, (curve, new_curve) in enumerate(zip(before.curves, after.curves, strict=True)):
        keys, new_keys = ([key.time for key in one.keyframes] for one in (curve, new_curve))
        shown = [(time, float(warp(time)) + 0.25) for time in np.random.default_rng(seed).uniform(0, 2.25, 15)]
        found = [
            (before.value(index, there), after.value(index, time + 0.25))
            for time, there in shown
            if np.abs(np.subtract(keys, there)).min() > 1e-6 and np.abs(np.subtract(new_keys, time + 0.25)).min() > 1e-6
        ]
        wanted, values = np.array(found).T
        largest = max(abs(key.value) for one in (curve, new_curve) for key in one.keyframes)
        np.testing.assert_allclose(values, wanted, rtol=0, atol=1e-5 * max(largest, np.abs(wanted).max()))
