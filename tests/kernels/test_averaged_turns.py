"""Turns averaged over windows: the same bits from both backends, and right where they are easily told."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from retime.kernels import BACKENDS, AveragedTurns, backend, compiled_available
from retime.motion import rotation

here = [name for name in BACKENDS if name == "numpy" or compiled_available()]


def some_turns(seed: int, n_frames: int, n_output: int) -> tuple[AveragedTurns, np.ndarray, np.ndarray]:
    """Joints in a random tree and in random groups, windows of every width; rotations, and what was sampled of them."""
    generator = np.random.default_rng(seed)
    n_joints, n_groups = int(generator.integers(1, 9)), int(generator.integers(1, 4))
    parents = np.array([-1, *(int(generator.integers(0, joint)) for joint in range(1, n_joints))], dtype=np.int64)
    groups = generator.integers(0, n_groups, n_joints)
    n_halves = n_groups + 1
    widths = np.full((n_groups, n_joints), -1, dtype=np.int64)
    for joint in range(n_joints):
        group, above = groups[joint], joint
        while above >= 0:
            # A group needs its joints and all above them; and so does a group whose parents are turned by another.
            for one in {group, groups[joint]}:
                widths[one, above] = one if generator.random() < 0.8 else n_groups
            above = int(parents[above])
    last = n_frames - 1
    centres = np.sort(generator.uniform(0, last, n_output))
    centres[generator.random(n_output) < 0.3] = float(generator.integers(0, n_frames))
    centres[0], centres[-1] = 0.0, last
    halves = generator.choice([0.0, 1e-7, 0.3, 1.0, 2.5, 40.0], size=(n_halves, n_output))
    halves = np.minimum(halves, np.minimum(centres, last - centres))
    rotations = rotation.normalize(np.cumsum(generator.normal(0, 0.4, (n_frames, n_joints, 4)), axis=0) + 1.0)
    # Some go over to the other side, some stay put, and some go all the way round.
    rotations[generator.random((n_frames, n_joints)) < 0.2] *= -1.0
    rotations[:, 0] = rotation.about_axis(1, np.arange(n_frames) * 2.2)
    rotations[n_frames // 2 :, n_joints - 1] = rotations[n_frames // 2, n_joints - 1]
    sampled = rotations[np.rint(centres).astype(np.int64)]
    turns = AveragedTurns(parents, groups, widths, np.arange(n_groups), halves, centres, 1e-6, 0.1)
    return turns, rotations, sampled


@pytest.mark.parametrize("seed", range(40))
@pytest.mark.parametrize(("n_frames", "n_output"), [(1, 1), (2, 3), (60, 41), (400, 1200)])
def test_both_backends_average_alike_to_the_last_bit(seed: int, n_frames: int, n_output: int) -> None:
    turns, rotations, sampled = some_turns(seed, n_frames, n_output)
    found = []
    for name in here:
        out = sampled.copy()
        backend(name).average_turns(turns, rotations, out)
        found.append(out.tobytes())
        np.testing.assert_allclose(np.linalg.norm(out, axis=2), 1.0, rtol=0, atol=1e-12)
    assert len(set(found)) == 1


@pytest.mark.parametrize("name", here)
def test_where_every_window_is_closed_nothing_changes(name: str) -> None:
    turns, rotations, sampled = some_turns(3, 60, 41)
    closed = replace(turns, halves=np.minimum(turns.halves, 1e-6))
    out = sampled.copy()
    backend(name).average_turns(closed, rotations, out)
    assert out.tobytes() == sampled.tobytes()


@pytest.mark.parametrize("name", here)
def test_an_even_turn_is_its_own_mean(name: str) -> None:
    n_frames = 50
    rotations = rotation.about_axis(2, 0.05 * np.arange(n_frames))[:, None]
    # Whichever side of the sphere each is on.
    rotations[::3] *= -1.0
    centres = np.linspace(5.0, 44.0, 79)
    one = np.array([0])
    turns = AveragedTurns(np.array([-1]), one, one[None], one, np.full((1, 79), 3.0), centres, 1e-6, 0.1)
    out = rotation.about_axis(2, 0.05 * centres + 0.01)[:, None]
    backend(name).average_turns(turns, rotations, out)
    expected = rotation.about_axis(2, 0.05 * centres)
    # Between frames the window's polyline cuts its corners, by far less than a frame's step.
    assert np.abs(np.sum(out[:, 0] * expected, axis=1)).min() > 1 - 1e-7


@pytest.mark.parametrize("name", here)
def test_where_turns_cancel_what_was_sampled_stays(name: str) -> None:
    rotations = rotation.about_axis(0, np.linspace(0, 4 * np.pi, 41))[:, None]
    one = np.array([0])
    turns = AveragedTurns(np.array([-1]), one, one[None], one, np.full((1, 1), 20.0), np.array([20.0]), 1e-6, 0.1)
    out = rotation.about_axis(1, np.array([[0.7]]))
    before = out.copy()
    backend(name).average_turns(turns, rotations, out)
    np.testing.assert_allclose(out, before, rtol=0, atol=1e-15)
