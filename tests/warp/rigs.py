"""Random rigs for hypothesis: any tree in any order that a skeleton allows, joints that stand and move, any warp."""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction

import numpy as np
from hypothesis import strategies as st

from retime.motion import rotation
from retime.motion.contacts import Contacts, Foot, contacts
from retime.motion.motion import Motion
from retime.motion.skeleton import EndSite, Skeleton
from retime.warp.curve import Warp

# Many joints and frames more often than few: hypothesis by itself would mostly draw what is too small to go wrong.
_JOINT_COUNTS = (1, 2, 4, 7, 7, 10, 10, 10, 10)
_FRAME_COUNTS = (1, 2, 5, 14, 14, 24, 24, 24, 24)

# None of a person's parts must be there; any joint, the root too, may be called a foot, and names repeat.
_NAMES = ("Hips", "Spine", "LeftHand", "LeftFoot", "RightFoot", "LeftToeBase", "foot.R", "prop", "Bone", "左足")

_seeds = st.integers(0, 2**32 - 1)


@st.composite
def rigs(draw: st.DrawFn) -> Skeleton:
    """Any tree, deep or wide: each joint hangs on any earlier one, so every order with parents first is drawn."""
    n_joints = draw(st.sampled_from(_JOINT_COUNTS))
    deep = draw(st.sampled_from([0.0, 0.5, 0.9]))
    rng = np.random.default_rng(draw(_seeds))
    parents = (-1, *(joint - 1 if rng.random() < deep else int(rng.integers(joint)) for joint in range(1, n_joints)))
    offsets = rng.normal(0, 0.3, (n_joints, 3)) - [0.0, 0.2, 0.0]
    # Joints without children and joints with some.
    sites = tuple(
        EndSite(int(rng.integers(n_joints)), (0.0, -0.1, float(rng.random()))) for _ in range(rng.integers(0, 4))
    )
    names = draw(st.lists(st.sampled_from(_NAMES), min_size=n_joints, max_size=n_joints))
    return Skeleton(tuple(names), parents, offsets, sites)


def orders(skeleton: Skeleton, seed: int) -> list[int]:
    """The joints in another order that a skeleton allows: each after its parent."""
    rng = np.random.default_rng(seed)
    order, open_joints = [0], list(skeleton.children(0))
    while open_joints:
        joint = open_joints.pop(int(rng.integers(len(open_joints))))
        order.append(joint)
        open_joints += skeleton.children(joint)
    return order


def stretches(rng: np.random.Generator, n_frames: int, n: int, share: float) -> np.ndarray:
    """True for a share of the time, a few frames at a stretch; shape (n_frames, n)."""
    return np.repeat(rng.random((n_frames // 4 + 1, n)) < share, 4, axis=0)[:n_frames]


@st.composite
def moving_rigs(draw: st.DrawFn, frame_counts: Sequence[int] = _FRAME_COUNTS) -> Motion:
    """A rig whose joints each turn for a while, and rest for a while; some slide in their parents as well."""
    skeleton = draw(rigs())
    n_frames = draw(st.sampled_from(frame_counts))
    rng = np.random.default_rng(draw(_seeds))
    n_joints = skeleton.n_joints
    moves = stretches(rng, n_frames, n_joints, draw(st.sampled_from([0.0, 0.4, 0.8])))[:, :, None]
    first = rng.uniform(-2, 2, (n_joints, 3))
    angles = first + np.cumsum(moves * rng.normal(0, 0.2, (n_frames, n_joints, 3)), axis=0)
    slides = moves * (rng.random((n_joints, 1)) < 0.3) * rng.normal(0, 0.05, (n_frames, n_joints, 3))
    translations = skeleton.offsets + np.cumsum(slides, axis=0)
    translations[:, 0] += np.cumsum(moves[:, 0] * rng.normal(0, 0.05, (n_frames, 3)), axis=0)
    rate = draw(st.sampled_from([Fraction(12), Fraction(30), Fraction(24000, 1001)]))
    return Motion(skeleton, rotation.from_euler("ZYX", angles), translations, rate, name="rig", metres_per_unit=1.0)


@st.composite
def contacts_of(draw: st.DrawFn, motion: Motion) -> Contacts:
    """Those that are found, or made-up ones of any joints and end sites."""
    if draw(st.booleans()):
        return contacts(motion)
    places = [Foot(joint) for joint in range(motion.skeleton.n_joints)]
    places += [Foot(site.parent, i) for i, site in enumerate(motion.skeleton.end_sites)]
    rng = np.random.default_rng(draw(_seeds))
    share = draw(st.sampled_from([0.0, 0.3, 0.7]))
    feet = [place for place in places if rng.random() < share]
    at_rest = stretches(rng, motion.n_frames, len(feet), 0.5)
    # Some of the time they roll.
    return Contacts(tuple(feet), at_rest, motion.rate, at_rest & stretches(rng, motion.n_frames, len(feet), 0.8))


@st.composite
def warps_of(draw: st.DrawFn, motion: Motion) -> Warp:
    """All of a motion's length: sped up, slowed down, held and run backward, at any of the spans between."""
    last = motion.n_frames - 1
    rng = np.random.default_rng(draw(_seeds))
    places = np.array([0, *rng.integers(0, 2 * last + 1, draw(st.integers(0, 4))), 2 * last]) / 2
    speeds = draw(st.sampled_from([(0.4, 1.0, 3.0), (1.5, 2.0, 6.0), (2.5,)]))
    # A hold takes time too.
    steps = np.maximum(np.abs(np.diff(places)), 1.0) / rng.choice(speeds, len(places) - 1)
    return Warp(np.concatenate([[0.0], np.cumsum(steps)]) / float(motion.rate), places / float(motion.rate))
