"""Random and degenerate rotations, skeletons and motions for hypothesis."""

from __future__ import annotations

from fractions import Fraction

import numpy as np
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from retime.motion import rotation
from retime.motion.motion import Motion
from retime.motion.skeleton import EndSite, Skeleton

RATES = [
    *map(Fraction, (1, 12, 24, 25, 30, 60, 100, 120, 240, 1000)),
    *(Fraction(n * 1000, 1001) for n in (24, 30, 60, 120)),
    Fraction(100, 3),
]

# Every turn of a cube onto itself, in both signs: right angles, gimbal locks, half turns, opposite quaternions, ties.
_CUBE = Rotation.create_group("O").as_quat(scalar_first=True)
_SPECIAL = np.concatenate([_CUBE, -_CUBE, rotation.about_axis(1, np.array([1e-12, 1e-9, 1e-6, np.pi - 1e-9]))])


# A seed and a share: drawing every number by itself would take hypothesis most of the tests' time.
_seeds = st.integers(0, 2**32 - 1)
_shares = st.sampled_from([0.0, 0.5, 1.0])


def quaternions(*shape: int) -> st.SearchStrategy[np.ndarray]:
    """Unit quaternions, wxyz, random, special or both."""

    def make(seed: int, share: float) -> np.ndarray:
        rng = np.random.default_rng(seed)
        q = rotation.normalize(rng.normal(size=(*shape, 4)))
        special = _SPECIAL[rng.integers(len(_SPECIAL), size=shape)]
        return np.where(rng.random((*shape, 1)) < share, special, q)

    return st.builds(make, _seeds, _shares)


def vectors(*shape: int) -> st.SearchStrategy[np.ndarray]:
    """Vectors in a space of a hundred units, random, small whole numbers or both; many zeros."""

    def make(seed: int, share: float) -> np.ndarray:
        rng = np.random.default_rng(seed)
        whole = rng.integers(-1, 2, size=(*shape, 3))
        return np.where(rng.random((*shape, 3)) < share, whole, rng.uniform(-100, 100, (*shape, 3)))

    return st.builds(make, _seeds, _shares)


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
