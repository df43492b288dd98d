"""Walks whose stances are known: feet that land on the heel, roll over the ball and leave from the tips of the toes."""

from __future__ import annotations

from fractions import Fraction

import numpy as np

from retime.motion import rotation
from retime.motion.motion import Motion
from retime.motion.skeleton import Skeleton

# Points of a foot that is flat on the ground: metres ahead of the ankle, and above the ground, of a person of 1.7 m.
_HEEL, _ANKLE, _BALL, _TIP = (-0.05, 0.0), (0.0, 0.08), (0.14, 0.02), (0.20, 0.0)
# Shares of a stance: the sole is down, the heel leaves the ground, the ball leaves it.
_FLAT, _HEEL_OFF, _BALL_OFF = 0.14, 0.5, 0.88
# How the foot meets the ground: metres a second ahead and up, in a stance of 0.56 s.
_LANDING = np.array([0.6, -0.4])
_CLEARANCE = 0.06


def _turned(points: np.ndarray, about: tuple[float, float], angles: np.ndarray) -> np.ndarray:
    away = points - np.array(about)
    cos, sin = np.cos(angles), np.sin(angles)
    turned = np.stack([away[:, 0] * cos - away[:, 1] * sin, away[:, 0] * sin + away[:, 1] * cos], axis=1)
    return turned + np.array(about)


def _stance(point: tuple[float, float], share: np.ndarray, runs: bool) -> np.ndarray:
    """A point of the foot (ahead, up) at shares of its stance."""
    there = np.broadcast_to(np.array(point), (len(share), 2))
    landing = np.radians(8 if runs else 20) * (1 - np.clip(share / _FLAT, 0, 1)) ** 1.5
    pushing = np.radians(65) * np.clip((share - _HEEL_OFF) / (1 - _HEEL_OFF), 0, 1) ** 2.2
    leaving = np.radians(35) * np.clip((share - _BALL_OFF) / (1 - _BALL_OFF), 0, 1) ** 1.5
    landed = _turned(there, _HEEL, landing)
    pushed = there if point == _BALL else _turned(there, (_BALL[0], 0.0), -pushing)
    return _turned(np.where((share < _FLAT)[:, None], landed, pushed), _TIP, -leaving)


def _track(point: tuple[float, float], cycles: np.ndarray, duty: float, stance: float, step: float) -> np.ndarray:
    """A point of the foot (ahead, up); time in cycles, of which each begins with a stance."""
    whole = np.floor(cycles)
    share = (cycles - whole) / duty
    runs = duty < 0.5
    stands = share < 1
    places = _stance(point, np.minimum(share, 1.0), runs)
    # A swing is a polynomial of the fifth degree from the end of one stance to the beginning of the next.
    begin, end = (_stance(point, np.array([at, at - 1e-4]), runs) for at in (1.0, 0.0))
    velocity = (begin[0] - begin[1]) / (1e-4 * stance)
    seconds = stance / duty * (1 - duty)
    h = ((cycles - whole - duty) / (1 - duty))[:, None]
    there = 10 * h**3 - 15 * h**4 + 6 * h**5
    swing = begin[0] + there * (end[0] + [step, 0] - begin[0])
    swing = swing + (h - 6 * h**3 + 8 * h**4 - 3 * h**5) * seconds * velocity
    swing = swing + (-4 * h**3 + 7 * h**4 - 3 * h**5) * seconds * _LANDING * (0.56 / stance)
    swing[:, 1] += _CLEARANCE * np.sin(np.pi * h[:, 0]) ** 2
    return np.where(stands[:, None], places, swing) + np.stack([whole * step, 0 * whole], axis=1)


def strides(
    stance: float, *, rate: int = 120, size: float = 1.0, unit: float = 1.0, toes: bool = True, noise: float = 0.001
) -> tuple[Motion, np.ndarray]:
    """Make a walk, or with stances under 0.36 s a run.

    Parameters
    ----------
    stance : float
        Seconds that a foot bears the body.
    rate : int
        Frames a second.
    size : float
        1 is a person of 1.7 m.
    unit : float
        Metres.
    toes : bool
        Whether feet have a joint at the ball.
    noise : float
        Standard deviation of each coordinate of a joint, metres.

    Returns
    -------
    Motion
        Six cycles or more.
    bool array, shape (n_frames, 2)
        Whether the left and the right foot touch the ground.
    """
    rng = np.random.default_rng(0)
    runs = stance < 0.36
    duty = 0.35 if runs else 0.6 + 0.03 * min(1.0, stance - 0.4)
    cycle = stance / duty
    # The slower, the shorter the steps too.
    step = (3.0 if runs else 1.5 * (0.6 / stance) ** 1.1) * cycle * np.sqrt(size)
    times = np.arange(int(max(6 * cycle, 4) * rate)) / rate
    hips = np.stack([0 * times, 0 * times + 0.9 * size, step * times / cycle], axis=1)
    rows = [("Hips", -1, hips)]
    touches = []
    for side, phase in ((1, 0.0), (-1, 0.5)):
        cycles = times / cycle - phase
        touches.append(cycles - np.floor(cycles) < duty)
        for part, point, parent in (("Foot", _ANKLE, 0), ("Toe", _BALL, len(rows)))[: 1 + toes]:
            ahead, up = (_track(point, cycles, duty, stance, step / size) * size).T
            rows.append(
                (("Left" if side > 0 else "Right") + part, parent, np.stack([0 * up + 0.1 * side, up, ahead], 1))
            )
    rows.append(("Head", 0, hips + np.array([0, 0.8 * size, 0])))
    places = np.stack([place for _, _, place in rows], axis=1)
    places = (places + rng.normal(0, noise, places.shape)) / unit
    parents = tuple(parent for _, parent, _ in rows)
    local = places - np.where(np.array(parents)[:, None] < 0, 0, places[:, parents])
    skeleton = Skeleton(tuple(name for name, _, _ in rows), parents, local.mean(axis=0))
    motion = Motion(skeleton, rotation.identity(len(times), len(rows)), local, Fraction(rate), metres_per_unit=unit)
    return motion, np.stack(touches, axis=1)
