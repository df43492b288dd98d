"""Motions whose damage is none, or can be undone, each with its right answer."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from retime import FormatError, FormatWarning, Motion, read

CASES = Path(__file__).resolve().parents[3] / "shared" / "cases"

pytestmark = pytest.mark.skipif(not CASES.is_dir(), reason="the folder of cases, ../shared/cases, is not here")


@pytest.mark.parametrize("name", ["ctrl_z_at_end", "nul_padding"])
def test_padding_after_the_last_frame_is_no_damage(run, tmp_path, name) -> None:
    path = CASES / f"{name}.bvh"
    shown = run("info", path)
    assert "frames    40," in shown.output
    assert "warning" not in shown.output
    (tmp_path / "plain.bvh").write_bytes(path.read_bytes().rstrip(b"\0\x1a"))
    plain, padded = read(tmp_path / "plain.bvh"), read(path)
    assert isinstance(plain, Motion)
    assert isinstance(padded, Motion)
    np.testing.assert_array_equal(padded.rotations, plain.rotations)


def test_a_glued_minus_begins_a_number_in_a_repair(tmp_path) -> None:
    path = CASES / "glued_minus.bvh"
    with pytest.raises(FormatError, match="run together"):
        read(path)
    with pytest.warns(FormatWarning, match="parted, in 40 frames"):
        motion = read(path, repair=True)
    assert isinstance(motion, Motion)
    assert motion.n_frames == 40
    np.testing.assert_allclose(motion.local_translations[[0, 1], 0], [[0, 96.5, 0], [0, 96.3926, 3.6667]])
    assert motion.declared_angles is not None
    np.testing.assert_allclose(np.rad2deg(motion.declared_angles[[0, -1], 0, 0]), [-7.5, -7.89])
