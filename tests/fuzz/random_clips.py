"""Random clips for requests: signals, and motions of any skeleton."""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction

import numpy as np

from retime.motion import rotation
from retime.motion.clock import Clock
from retime.motion.motion import Motion
from retime.motion.signal import Signal
from retime.motion.skeleton import EndSite, Skeleton
from tests.cli.figures import figure
from tests.motion.walkers import permuted, scaled, walker

RATES = [Fraction(24), Fraction(25), Fraction(30), Fraction(60), Fraction(120), Fraction(30000, 1001)]
# A person's joints and none; names repeat.
_NAMES = ("Hips", "Spine", "Head", "LeftHand", "LeftFoot", "RightFoot", "LeftToeBase", "foot.R", "prop", "Bone", "左足")
# Metres, feet, inches, centimetres, millimetres and nothing in particular.
_UNITS = (1.0, 3.28, 39.4, 100.0, 1000.0, 0.05)


def n_frames_of(rng: np.random.Generator) -> int:
    """Return a number of frames: a few, some, many."""
    return int(rng.choice([rng.integers(2, 8), rng.integers(8, 60), rng.integers(60, 400)], p=[0.06, 0.34, 0.6]))


def signal(rng: np.random.Generator, name: str) -> Signal:
    """Return a short signal: smooth, random, standing still for a while, or all the time."""
    rate = RATES[rng.integers(len(RATES))]
    n_frames = n_frames_of(rng)
    n_channels = int(rng.integers(1, 4))
    t = np.arange(n_frames) / float(rate)
    kind = rng.choice(["smooth", "walk", "paused", "still"], p=[0.5, 0.2, 0.2, 0.1])
    values = np.stack([np.sin(t ** rng.uniform(1, 1.6) * rng.uniform(1, 5)) for _ in range(n_channels)], axis=1)
    if kind == "walk":
        values = rng.standard_normal(values.shape).cumsum(axis=0)
    elif kind == "paused":
        first, last = np.sort(rng.integers(0, n_frames, 2))
        values[first:last] = values[first]
    elif kind == "still":
        values[:] = values[0]
    return Signal(tuple(f"{name}{i}" for i in range(n_channels)), values, rate, name=name)


def motion(rng: np.random.Generator, name: str) -> Motion:
    """Return a motion: a figure that jumps, a walk, or any tree of joints; in any order, unit and place."""
    kind = rng.choice(["jump", "walk", "tree"], p=[0.25, 0.25, 0.5])
    if kind == "jump":
        found = figure(seconds=float(rng.uniform(2.2, 4.0)))
    elif kind == "walk":
        found = walker(int(rng.integers(8, 200)), float(rng.uniform(-3, 3)))
    else:
        found = _tree(rng)
    if kind != "tree" and rng.random() < 0.4:
        found = _in_another_order(rng, found)
    if kind != "tree" and rng.random() < 0.3:
        names = rng.permutation(found.skeleton.n_joints).tolist()
        found = replace(found, skeleton=replace(found.skeleton, names=tuple(f"bone {n}" for n in names)))
    for _ in range(int(rng.choice([0, 1, 2], p=[0.6, 0.3, 0.1]))):
        found = below_a_node(rng, found)
    if rng.random() < 0.5:
        found = scaled(found, float(rng.choice(_UNITS)))
    if rng.random() < 0.4:
        found = replace(found, metres_per_unit=None)
    return replace(
        found,
        rate=RATES[rng.integers(len(RATES))],
        name=name,
        up="z" if rng.random() < 0.2 else "y",
        first_frame=int(rng.choice([0, 0, 1, 250])),
    )


def group(rng: np.random.Generator) -> list[Motion | Signal]:
    """Return clips that move together: of other kinds, lengths, rates, and clocks that begin elsewhere."""
    clips: list[Motion | Signal] = []
    for place in range(int(rng.choice([2, 3], p=[0.7, 0.3]))):
        name = f"clip{place}"
        one = motion(rng, name) if rng.random() < 0.5 else signal(rng, name)
        if isinstance(one, Signal) and rng.random() < 0.3:
            one = replace(one, clock=Clock(start=Fraction(int(rng.integers(-500, 5000)), 100)))
        clips.append(one)
    if rng.random() < 0.9:
        # As long as the first, or they would be refused.
        first = clips[0]
        clips = [first, *(_as_long_as(one, first) for one in clips[1:])]
    return clips


def _as_long_as(clip: Motion | Signal, first: Motion | Signal) -> Motion | Signal:
    n_frames = max(2, round(first.end_time * float(clip.rate)) + 1)
    return clip.at(np.minimum(np.arange(n_frames) / float(clip.rate), clip.end_time))


def _tree(rng: np.random.Generator) -> Motion:
    """Each joint hangs on any earlier one, and turns for a while, rests for a while; some slide in their parents."""
    n_frames, n_joints = n_frames_of(rng), int(rng.choice([1, 2, 4, 7, 15, 30]))
    deep = rng.choice([0.0, 0.5, 0.9])
    parents = (-1, *(joint - 1 if rng.random() < deep else int(rng.integers(joint)) for joint in range(1, n_joints)))
    offsets = rng.normal(0, 0.3, (n_joints, 3)) - [0.0, 0.2, 0.0]
    sites = tuple(
        EndSite(int(rng.integers(n_joints)), (0.0, -0.1, float(rng.random()))) for _ in range(rng.integers(4))
    )
    skeleton = Skeleton(tuple(rng.choice(_NAMES, n_joints).tolist()), parents, offsets, sites)
    share = float(rng.choice([0.0, 0.4, 0.8, 1.0], p=[0.05, 0.35, 0.3, 0.3]))
    moves = np.repeat(rng.random((n_frames // 8 + 1, n_joints)) < share, 8, axis=0)[:n_frames, :, None]
    angles = rng.uniform(-2, 2, (n_joints, 3)) + np.cumsum(moves * rng.normal(0, 0.1, (n_frames, n_joints, 3)), axis=0)
    slides = moves * (rng.random((n_joints, 1)) < 0.2) * rng.normal(0, 0.05, (n_frames, n_joints, 3))
    translations = offsets + np.cumsum(slides, axis=0)
    translations[:, 0] += np.cumsum(moves[:, 0] * rng.normal(0, 0.05, (n_frames, 3)), axis=0)
    if rng.random() < 0.3:
        # Far from the origin, as a camera on a map is.
        translations[:, 0] += rng.normal(0, 1e5, 3)
    return Motion(skeleton, rotation.from_euler("ZYX", angles), translations, 30)


def _in_another_order(rng: np.random.Generator, clip: Motion) -> Motion:
    order, open_joints = [0], list(clip.skeleton.children(0))
    while open_joints:
        joint = open_joints.pop(int(rng.integers(len(open_joints))))
        order.append(joint)
        open_joints += clip.skeleton.children(joint)
    return permuted(clip, order)


def below_a_node(rng: np.random.Generator, clip: Motion) -> Motion:
    """The same movement under a node that never moves, turned and away from the origin, as some programs write it."""
    skeleton = clip.skeleton
    turn, place = rotation.normalize(rng.normal(size=(1, 4)))[0], rng.normal(size=3)
    q, p = clip.rotations.copy(), clip.local_translations.copy()
    q[:, 0] = rotation.multiply(rotation.conjugate(turn), q[:, 0])
    p[:, 0] = rotation.rotate(rotation.conjugate(turn), p[:, 0] - place)
    below = Skeleton(
        ("node", *skeleton.names),
        (-1, *(parent + 1 for parent in skeleton.parents)),
        np.concatenate([place[None], skeleton.offsets]),
        tuple(replace(site, parent=site.parent + 1) for site in skeleton.end_sites),
    )
    n = clip.n_frames
    return Motion(
        below,
        np.concatenate([np.broadcast_to(turn, (n, 1, 4)), q], axis=1),
        np.concatenate([np.broadcast_to(place, (n, 1, 3)), p], axis=1),
        clip.rate,
        metres_per_unit=clip.metres_per_unit,
    )
