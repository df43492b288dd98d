"""Long BVH files: frames that go from the text right to the joints are those that a table of numbers gives."""

from __future__ import annotations

import warnings
from pathlib import Path

import numpy as np
import pytest

from retime.errors import FormatError
from retime.formats import Limits, bvh, bvh_frames, read
from retime.kernels import compiled_available
from retime.motion.motion import Motion

pytestmark = pytest.mark.skipif(not compiled_available(), reason="the compiled kernels were not built")

HIERARCHY = """HIERARCHY
ROOT a
{
OFFSET 1 2 3
CHANNELS 6 Xposition Zposition Yposition Zrotation Xrotation Yrotation
JOINT b
{
OFFSET 0 5 0
CHANNELS 3 %s
End Site
{
OFFSET 0 1 0
}
}
}
MOTION
"""
N_FRAMES = 400


def some_lines(generator: np.random.Generator) -> list[str]:
    rows = generator.normal(scale=60, size=(N_FRAMES, 9)).round(int(generator.integers(1, 9)))
    # A pose at rest in front: its lines are much shorter.
    rows[: int(generator.integers(0, 60))] = 0
    return [" ".join(map(repr, row)) for row in rows.tolist()]


def text_of(lines: list[str], *, order: str = "ZYX", ending: str = "\n", claimed: int = N_FRAMES) -> bytes:
    turns = " ".join(f"{axis}rotation" for axis in order)
    head = HIERARCHY % turns + f"Frames: {claimed}\nFrame Time: 0.01\n"
    return (head.replace("\n", ending) + ending.join(lines) + ending).encode()


def outcome(path: Path, **options: object) -> object:
    """What reading gives, to the bit, with all that it says."""
    with warnings.catch_warnings(record=True) as said:
        warnings.simplefilter("always")
        try:
            motion = read(path, **options)
        except FormatError as error:
            return str(error), error.line, error.column
    assert isinstance(motion, Motion)
    assert motion.declared_angles is not None
    arrays = motion.rotations, motion.local_translations, motion.declared_angles
    return [len(array) for array in arrays], [array.tobytes() for array in arrays], [str(each.message) for each in said]


def both_ways(monkeypatch: pytest.MonkeyPatch, path: Path, **options: object) -> tuple[object, int]:
    """Read a file and see that it comes out as without the short way; how many frames took that."""
    taken = 0
    short_way = bvh._Joints.take_text

    def counted(self: bvh._Joints, *told: object) -> tuple[int, int]:
        nonlocal taken
        found = short_way(self, *told)
        taken += found[0]
        return found

    with monkeypatch.context() as change:
        change.setattr(bvh_frames, "_BLOCK", 1000)
        change.setattr(bvh._Joints, "take_text", counted)
        found = outcome(path, **options)
        change.setattr(bvh._Joints, "take_text", lambda *_: (0, 0))
        assert outcome(path, **options) == found
    return found, taken


@pytest.mark.parametrize("ending", ["\n", "\r\n"])
@pytest.mark.parametrize("seed", range(4))
def test_plain_frames_go_the_short_way(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, seed: int, ending: str) -> None:
    path = tmp_path / "long.bvh"
    path.write_bytes(text_of(some_lines(np.random.default_rng(seed)), ending=ending))
    found, taken = both_ways(monkeypatch, path)
    assert found[0] == [N_FRAMES] * 3
    # All but the first piece, which tells how much room there must be.
    assert taken > N_FRAMES * 0.8


@pytest.mark.parametrize("order", ["", "X", "ZX"])
def test_joints_with_fewer_turns_go_the_long_way(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, order: str) -> None:
    lines = [" ".join(line.split()[: 6 + len(order)]) for line in some_lines(np.random.default_rng(1))]
    path = tmp_path / "long.bvh"
    path.write_bytes(text_of(lines, order=order).replace(b"CHANNELS 3", b"CHANNELS %d" % len(order)))
    found, taken = both_ways(monkeypatch, path)
    assert found[0] == [N_FRAMES] * 3
    assert taken == 0


@pytest.mark.parametrize("repair", [False, True])
@pytest.mark.parametrize(
    "oddity", ["", " ", "1 2", "nan " * 9, "1 2 3 4 5 6 7 8 9 10", "1 2 3 4 5 6 7 8 x", "\r1 2", "1e-400 " * 9]
)
@pytest.mark.parametrize("seed", range(3))
def test_oddities_anywhere_change_nothing(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, seed: int, oddity: str, repair: bool
) -> None:
    generator = np.random.default_rng(seed)
    lines = some_lines(generator)
    lines.insert(int(generator.integers(20, N_FRAMES)), oddity)
    path = tmp_path / "odd.bvh"
    path.write_bytes(text_of(lines))
    both_ways(monkeypatch, path, repair=repair)


def test_damage_is_named_by_its_line(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    lines = some_lines(np.random.default_rng(3))
    lines[300] = lines[300].replace(" ", " 4.5.6 ", 1)
    path = tmp_path / "damaged.bvh"
    path.write_bytes(text_of(lines))
    (message, line, column), taken = both_ways(monkeypatch, path)
    assert line == HIERARCHY.count("\n") + 2 + 301
    assert column == lines[300].index("4.5.6") + 1
    assert "frame 300, " in message
    assert taken > 200


@pytest.mark.parametrize("claimed", [1, N_FRAMES // 2, N_FRAMES - 1, N_FRAMES + 1, 2 * N_FRAMES])
@pytest.mark.parametrize("repair", [False, True])
def test_a_wrong_count_of_frames_changes_nothing(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, claimed: int, repair: bool
) -> None:
    path = tmp_path / "claims.bvh"
    path.write_bytes(text_of(some_lines(np.random.default_rng(4)), claimed=claimed))
    both_ways(monkeypatch, path, repair=repair)


@pytest.mark.parametrize(
    "limits", [Limits(frames=200), Limits(joint_poses=500), Limits(line_bytes=60), Limits(frames=399)]
)
@pytest.mark.parametrize("claimed", [100, N_FRAMES])
def test_limits_hold(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, limits: Limits, claimed: int) -> None:
    path = tmp_path / "limited.bvh"
    path.write_bytes(text_of(some_lines(np.random.default_rng(5)), claimed=claimed))
    found, _ = both_ways(monkeypatch, path, limits=limits)
    assert "Limits." in found[0]


def test_a_real_piece_is_long_enough_for_threads(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Without smaller pieces than users have: a file of a megabyte, by one thread and by several."""
    generator = np.random.default_rng(6)
    lines = [line for _ in range(30) for line in some_lines(generator)]
    path = tmp_path / "longer.bvh"
    path.write_bytes(text_of(lines, claimed=len(lines)))
    assert path.stat().st_size > 3 * bvh_frames._BLOCK
    found = []
    for threads in ("1", "2", "5"):
        monkeypatch.setenv("RETIME_THREADS", threads)
        found.append(outcome(path))
    assert found[0] == found[1] == found[2]
    assert found[0][0] == [len(lines)] * 3
