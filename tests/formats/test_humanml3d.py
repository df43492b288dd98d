"""Frames of HumanML3D, carried along as a signal."""

from __future__ import annotations

import io
import warnings
from fractions import Fraction
from pathlib import Path

import numpy as np
import pytest

from retime.errors import FormatError, FormatWarning, OptionError, RetimeWarning
from retime.formats import humanml3d
from retime.formats.in_place import retime_file
from retime.formats.read_options import ReadOptions
from retime.formats.registry import format_in, read
from retime.motion.signal import Signal
from retime.warp.curve import Warp

PATH = Path("M000000.npy")
AT_20 = ReadOptions(rate=Fraction(20))
# The walk goes on by the first numbers: a turn, and steps along x and z.
TURN, STEPS, HEIGHT, CONTACTS = 0, slice(1, 3), 3, slice(259, 263)


def frames(n_frames: int = 41, dtype: str = "f4") -> np.ndarray:
    rng = np.random.default_rng(7)
    values = np.cumsum(rng.normal(size=(n_frames, 263)), axis=0) * 0.01
    values[:, CONTACTS] = np.arange(n_frames)[:, None] // 7 % 2
    return values.astype(dtype)


def stored(values: np.ndarray) -> bytes:
    file = io.BytesIO()
    np.save(file, values)
    return file.getvalue()


def retimed(values: np.ndarray, warp: Warp, **more: object) -> np.ndarray:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", RetimeWarning)
        return np.load(io.BytesIO(humanml3d.retime_frames(PATH, stored(values), warp, AT_20, **more)))  # type: ignore[arg-type]


def test_frames_have_names_and_kinds() -> None:
    signal = humanml3d.read(PATH, stored(frames()), AT_20)
    assert signal.dialect == "HumanML3D features"
    assert (len(signal.names), len(set(signal.names))) == (263, 263)
    assert signal.names[:5] == ("root.turn", "root.step_x", "root.step_z", "root.y", "left_hip.x")
    assert [str(kind) for kind in signal.kinds[CONTACTS]] == ["label"] * 4
    with pytest.warns(FormatWarning, match="are taken for HumanML3D, at 20 Hz"):
        assert humanml3d.read(PATH, stored(frames()), ReadOptions()).rate == 20


@pytest.mark.parametrize("dtype", ["f4", ">f8"])
@pytest.mark.parametrize("average", [True, False])
def test_the_way_is_as_long_and_the_feet_stand_or_not(dtype: str, average: bool) -> None:
    values = frames(dtype=dtype)
    for warp in (Warp([0.0, 1.4], [0.0, 2.0]), Warp([0.0, 3.0], [0.0, 2.0]), Warp([0, 0.7, 1.0, 2.0], [0, 1, 1, 2.0])):
        new = retimed(values, warp, average=average)
        assert new.dtype == values.dtype
        assert len(new) == warp.count_frames(20)
        np.testing.assert_allclose(new[:-1, TURN].sum(), values[:-1, TURN].sum(), atol=1e-4)
        np.testing.assert_allclose(new[:-1, STEPS].sum(axis=0), values[:-1, STEPS].sum(axis=0), atol=1e-4)
        assert set(np.unique(new[:, CONTACTS])) == {0, 1}
    # A hold goes nowhere; there and back ends where it began.
    hold = retimed(values, Warp([0, 1, 2, 3], [0, 1, 1, 2.0]), average=average)
    assert np.array_equal(hold[20:40, STEPS], np.zeros((20, 2)))
    back = retimed(values, Warp([0, 1.0, 2.0], [0, 1.0, 0]), average=average)
    np.testing.assert_allclose(back[:-1, STEPS].sum(axis=0), 0, atol=1e-5)


def test_nothing_changes_by_a_warp_that_changes_nothing() -> None:
    values = frames()
    new = retimed(values, Warp([0.0, 2.0], [0.0, 2.0]))
    np.testing.assert_allclose(new, values, atol=1e-6)
    part = retimed(values, Warp([0.0, 1.0], [0.0, 1.0]), frames=(10, 30))
    np.testing.assert_allclose(part, values[10:31], atol=1e-6)


def test_what_is_refused(tmp_path: Path) -> None:
    with pytest.raises(OptionError, match="can't be held"):
        retimed(frames(), Warp([0.0, 1.0], [0.0, 1.0]), held=2)
    with pytest.raises(FormatError, match="expected a NumPy array"):
        humanml3d.read(PATH, b"PK", AT_20)
    for other in (frames()[:, :262], frames()[0], frames()[None]):
        with pytest.raises(FormatError, match="expected frames of 263 numbers, found shape"):
            humanml3d.read(PATH, stored(other), AT_20)
    with pytest.raises(FormatError, match="real numbers, these are of type int64; --array values"):
        humanml3d.read(PATH, stored(frames().astype(np.int64)), AT_20)
    holes = frames()
    holes[3, 4] = np.nan
    with pytest.raises(FormatError, match=r"left_hip\.x"):
        humanml3d.read(PATH, stored(holes), AT_20)


def test_by_the_registry(tmp_path: Path) -> None:
    np.save(tmp_path / "a.npy", frames())
    np.save(tmp_path / "b.npy", frames()[:, :262])
    assert [format_in(tmp_path / name).name for name in ("a.npy", "b.npy")] == ["humanml3d", "npy"]
    assert format_in(tmp_path / "a.npy", arrays=["values"]).name == "npy"
    with pytest.warns(FormatWarning, match="HumanML3D"):
        retime_file(tmp_path / "a.npy", tmp_path / "c.npy", Warp([0.0, 1.0], [0.0, 2.0]))
    with pytest.warns(FormatWarning, match="HumanML3D"):
        again = read(tmp_path / "c.npy")
    assert isinstance(again, Signal)
    assert again.n_frames == 21
