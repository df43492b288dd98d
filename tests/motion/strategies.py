"""Random and degenerate rotations, skeletons and motions for hypothesis."""

from __future__ import annotations

from fractions import Fraction

import numpy as np
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from retime.motion.motion import Motion
from retime.motion.skeleton import EndSite, Skeleton

RATES = [
    *map(Fraction, (1, 12, 24, 25, 30, 60, 100, 120, 240, 1000)),
    *(Fraction(n * 1000, 1001) for n in (24, 30, 60, 120)),
    Fraction(100, 3),
]

# Halves and zeros make right angles, gimbal locks, opposite quaternions and ties; shrinking leads to them.
_parts = st.one_of(st.sampled_from([0.0, 0.5, -0.5, 1.0, -1.0, 1e-9]), st.floats(-1, 1, width=32))


@st.composite
def quaternions(draw, *shape: int) -> np.ndarray:
    """Unit quaternions, wxyz; one that comes out too short becomes the identity."""
    q = draw(arrays(np.float64, (*shape, 4), elements=_parts))
    length = np.sqrt(np.sum(q * q, axis=-1, keepdims=True))
    return np.where(length > 1e-3, q / np.where(length > 1e-3, length, 1.0), [1.0, 0.0, 0.0, 0.0])


def vectors(*shape: int) -> st.SearchStrategy[np.ndarray]:
    return arrays(np.float64, (*shape, 3), elements=st.floats(-100, 100, width=32))


@st.composite
def skeletons(draw, max_joints: int = 6) -> Skeleton:
    """Any tree: chains, stars, repeated names, offsets of length zero."""
    n_joints = draw(st.integers(1, max_joints))
    parents = (-1, *(draw(st.integers(0, joint - 1)) for joint in range(1, n_joints)))
    names = tuple(draw(st.sampled_from(["hip", "knee", "左足", "a b:c.d"])) for _ in range(n_joints))
    offsets = draw(st.one_of(st.just(np.zeros((n_joints, 3))), vectors(n_joints)))
    sites = tuple(
        EndSite(draw(st.integers(0, n_joints - 1)), tuple(draw(vectors()).tolist()))
        for _ in range(draw(st.integers(0, 2)))
    )
    return Skeleton(names, parents, offsets, sites)


@st.composite
def motions(draw, max_frames: int = 5) -> Motion:
    skeleton = draw(skeletons())
    n_frames = draw(st.integers(1, max_frames))
    return Motion(
        skeleton,
        draw(quaternions(n_frames, skeleton.n_joints)),
        draw(st.one_of(st.none(), vectors(n_frames, skeleton.n_joints))),
        draw(st.sampled_from(RATES)),
    )
