"""Between any two formats where it makes sense: what is written shows what was read; what makes no sense is refused."""

from __future__ import annotations

import json
import warnings
from pathlib import Path

import numpy as np
import pytest

from retime import read, write
from retime.errors import RetimeWarning
from retime.formats.c3d import parse_c3d
from retime.formats.read_options import ReadOptions
from retime.motion.joint_signal import distinct_names, joint_signal
from retime.motion.motion import Motion
from retime.motion.signal import Signal
from tests.cli.conftest import Clips, Run
from tests.formats.body_files import body, npz
from tests.formats.c3d_files import Capture

MOTIONS = ["jump.bvh", "jump.amc", "body.npz", "jump.glb", "jump.fbx"]


def quiet_read(path: str | Path, **options: object):
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", RetimeWarning)
        return read(path, **options)


@pytest.fixture
def sources(run: Run, clips: Clips, tmp_path: Path) -> Path:
    """A motion of each format, a capture, and frames of a signal, in the folder that commands run in."""
    Path("jump.bvh").write_bytes(clips.bvh.read_bytes())
    Path("body.npz").write_bytes(npz(body()))
    for ending in (".amc", ".glb", ".fbx"):
        write(quiet_read("jump.bvh"), f"jump{ending}")
    Path("take.c3d").write_bytes(Capture(points=np.ones((9, 2, 4)), analog=np.arange(18.0)[:, None]).build())
    return tmp_path


@pytest.mark.parametrize("target", ["out.bvh", "out.glb", "out.gltf", "out.fbx"])
@pytest.mark.parametrize("source", MOTIONS)
def test_a_motion_in_another_format_goes_where_it_went(run: Run, sources: Path, source: str, target: str) -> None:
    run("convert", source, target)
    old, new = quiet_read(source), quiet_read(target)
    assert isinstance(old, Motion)
    assert isinstance(new, Motion)
    assert (new.n_frames, new.rate) == (old.n_frames, old.rate)
    # A scene may have a node on top that stands its axis up; numbers stay where their unit is not known.
    joints = [new.skeleton.index(name) for name in old.skeleton.names]
    known = target != "out.bvh" and old.metres_per_unit is not None
    scale = (old.metres_per_unit or 1.0) / (new.metres_per_unit or 1.0) if known else 1.0
    up = "z" if old.up == "z" and target == "out.bvh" else new.up
    shown = quiet_read(target, up=up).positions[:, joints]
    size = float(np.abs(old.positions).max())
    np.testing.assert_allclose(shown, old.positions * scale, atol=1e-5 * size * scale)


@pytest.mark.parametrize("target", ["out.csv", "out.npz", "out.c3d"])
@pytest.mark.parametrize("source", MOTIONS)
def test_joints_as_a_table(run: Run, sources: Path, source: str, target: str) -> None:
    run("convert", source, target)
    motion, table = quiet_read(source), quiet_read(target)
    assert isinstance(table, Signal)
    expected = joint_signal(motion)
    assert table.names == tuple(f"{name}.{axis}" for name in distinct_names(motion.skeleton.names) for axis in "xyz")
    np.testing.assert_allclose(table.values, expected.values, rtol=1e-6, atol=1e-6 * np.abs(expected.values).max())
    if source == "body.npz" and target == "out.c3d":
        assert {str(kind) for kind in table.kinds} == {"linear:m"}


def test_a_signal_goes_round(run: Run, sources: Path) -> None:
    run("convert", "take.c3d", "a.csv")
    run("convert", "a.csv", "b.npz")
    run("convert", "b.npz", "c.c3d")
    assert np.array_equal(quiet_read("c.c3d").values, quiet_read("take.c3d").values)


def test_part_of_a_capture_keeps_what_it_holds(run: Run, sources: Path) -> None:
    run("convert", "take.c3d", "part.c3d", "--frames", "3:6", "--fps", "50")
    file = parse_c3d(Path("part.c3d"), Path("part.c3d").read_bytes(), ReadOptions())
    assert (file.first, file.n_frames, file.rate, file.layout.channels) == (3, 4, 50, 1)
    forces = quiet_read("part.c3d", array="analog").values
    np.testing.assert_allclose(forces[:, 0] * 2, [4, 5, 6, 7, 8, 9, 10, 11])
    says = run("convert", "take.c3d", "slow.c3d", "--rate", "50").stderr
    assert "slow.c3d is written anew: it holds the signal of take.c3d, and nothing else of that file" in says
    says = run("convert", "jump.glb", "again.glb").stderr
    assert "again.glb is written anew: it holds the motion of jump.glb" in says


@pytest.mark.parametrize(
    ("source", "target", "says"),
    [
        ("take.c3d", "x.bvh", "a signal is written as .csv or .tsv or .npy or .npz or .c3d"),
        ("take.c3d", "x.glb", "a .glb file holds a motion, not a signal as take.c3d"),
        ("jump.bvh", "x.trc", ".trc files can be read, but not written; a signal is written as .csv"),
        ("take.c3d", "x.mot", ".mot files can be read, but not written; a signal is written as .csv"),
        ("jump.bvh", "x.pkl", "may run any program when it is read"),
        ("jump.bvh", "x.docx", "no format ends in '.docx'"),
    ],
)
def test_what_makes_no_sense_is_refused_with_what_would(
    run: Run, sources: Path, source: str, target: str, says: str
) -> None:
    assert says in run("convert", source, target, code=1).stderr
    assert not Path(target).exists()


@pytest.mark.parametrize("source", [*MOTIONS, "take.c3d"])
def test_what_each_holds_is_told(run: Run, sources: Path, source: str) -> None:
    told = json.loads(run("info", source, "--json").stdout)
    clip = quiet_read(source)
    assert (told["frames"], told["rate"]) == (clip.n_frames, float(clip.rate))
    assert told["holds"] == ("motion" if isinstance(clip, Motion) else "signal")
    assert run("info", source).stdout.startswith("clip")
