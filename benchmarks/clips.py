"""Features of real motion at given sizes: from ../shared/mocap where it is, else from the sample clip.

The pose vectors are those that `retime warp` would search with: joints in the root's space, low-passed, read at 30 Hz.
"""

from __future__ import annotations

import warnings
from fractions import Fraction
from functools import cache
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

import retime
from retime.motion import rotation
from retime.motion.motion import Motion
from retime.search.poses.spaces import Track
from retime.search.poses.vectors import pose_vectors

Poses = NDArray[np.float64]
MOCAP = Path(__file__).resolve().parents[1] / "../shared/mocap"
RATE = 30.0
CUTOFF = 4.0
TIME_SCALE = 0.1


class Size(NamedTuple):
    """A row of the paper's Table 1, with a clip like the paper's: (file, first second, last second)."""

    n_input: int
    n_output: int
    n_reference: int
    max_skip: int
    input: tuple[str, float, float]
    reference: tuple[str, float, float]


def _whole(file: str) -> tuple[str, float, float]:
    return file, 0.0, np.inf


SIZES = {
    "V1": Size(493, 280, 493, 8, _whole("cmu-bvh/05_18.bvh"), _whole("cmu-bvh/05_18.bvh")),
    "V2": Size(316, 180, 316, 10, _whole("cmu-bvh/05_08.bvh"), _whole("cmu-bvh/05_08.bvh")),
    "V3": Size(378, 180, 378, 8, _whole("cmu-bvh/49_20.bvh"), _whole("cmu-bvh/49_20.bvh")),
    "V4": Size(486, 320, 486, 8, ("cmu-asfamc/86_01.amc", 0.0, 16.5), ("cmu-asfamc/86_01.amc", 0.0, 16.5)),
    "V5": Size(401, 150, 101, 4, _whole("cmu-bvh/02_04.bvh"), _whole("cmu-bvh/02_04.bvh")),
    "V6": Size(601, 301, 301, 8, ("bvh-other/Boxing_Toes.bvh", 0.0, 5.0), ("bvh-other/Boxing_Toes.bvh", 5.0, 15.0)),
    "V7": Size(573, 143, 45, 8, ("cmu-bvh/29_01.bvh", 0.0, 4.8), _whole("cmu-bvh/35_17.bvh")),
    "V8": Size(1524, 590, 91, 8, ("cmu-bvh/49_02.bvh", 0.0, 12.7), ("cmu-bvh/49_02.bvh", 13.0, 16.0)),
}


def source() -> str:
    """Say where the motion comes from."""
    return "the captures in ../shared/mocap" if MOCAP.is_dir() else "the sample clip that ships with retime, with noise"


@cache
def _track(file: str) -> Track:
    """One clip's pose vectors; without the T-pose that many CMU files begin with."""
    with warnings.catch_warnings():
        # What is odd in these files is known.
        warnings.simplefilter("ignore", retime.RetimeWarning)
        motion = retime.read(MOCAP / file)
    assert isinstance(motion, Motion)
    return Track(pose_vectors(motion)[1:], motion.rate)


@cache
def _sample_track() -> Track:
    motion = retime.sample()
    return Track(pose_vectors(motion), motion.rate)


def clip(n_frames: int, file: str, first: float, last: float, *, seed: int = 0) -> Poses:
    """Read a part of a clip at so many frames."""
    if not MOCAP.is_dir():
        return long_take(n_frames, seed=seed)
    track = _track(file)
    return track.at(np.linspace(first, min(last, track.end_time), n_frames), CUTOFF)


def table_size(name: str) -> tuple[Size, Poses, Poses]:
    """Return a row of Table 1, its input and its reference."""
    size = SIZES[name]
    inputs = clip(size.n_input, *size.input)
    if size.n_reference == size.n_input and size.input == size.reference:
        return size, inputs, inputs
    return size, inputs, clip(size.n_reference, *size.reference, seed=1)


def long_take(n_frames: int, *, seed: int = 0) -> Poses:
    """Join clips into a take of any length.

    Each pass goes through all clips in another order and plays each at another speed. Joins are blended over eight
    frames, and a thousandth of each number's spread is added as noise, so that no two frames are alike.
    """
    generator = np.random.default_rng(seed)
    files = sorted((MOCAP / "cmu-bvh").glob("*.bvh")) if MOCAP.is_dir() else []
    tracks = [_track(str(file.relative_to(MOCAP))) for file in files] or [_sample_track()]
    parts: list[Poses] = []
    total = 0
    while total < n_frames:
        for which in generator.permutation(len(tracks)):
            step = generator.uniform(0.8, 1.25) / RATE
            part = tracks[which].at(np.arange(0, tracks[which].end_time, step), CUTOFF)
            if parts:
                share = np.linspace(0, 1, min(9, len(part)))[:-1, None]
                part[: len(share)] = (1 - share) * parts[-1][-1] + share * part[: len(share)]
            parts.append(part)
            total += len(part)
            if total >= n_frames:
                break
    take = np.concatenate(parts)[:n_frames]
    return np.ascontiguousarray(take + generator.normal(scale=1e-3, size=take.shape) * take.std(axis=0))


def motion(n_frames: int) -> Motion:
    """Return a motion at 120 Hz: hops and jumps of a capture, or the sample clip played forward and backward."""
    file = MOCAP / "cmu-bvh/49_02.bvh"
    if file.exists():
        found = retime.read(file)
        assert isinstance(found, Motion)
        return found.frames(1, 1 + n_frames)
    sample = retime.sample()
    span = float(sample.end_time)
    times = np.arange(n_frames) / 120.0
    return sample.at(span - np.abs(times % (2 * span) - span)).with_rate(Fraction(120))


def long_motion(n_frames: int) -> Motion:
    """Join a motion of any length at 120 Hz: forward and backward, at other speeds each time, with noise in its turns.

    No two frames are alike, as in a capture.
    """
    base, generator = motion(2000), np.random.default_rng(0)
    span, back = base.end_time, False
    parts: list[Poses] = []
    while sum(map(len, parts)) < n_frames:
        times = np.arange(0, span, generator.uniform(0.8, 1.25) / 120)
        parts.append(span - times if back else times)
        back = not back
    times = np.concatenate(parts)[:n_frames]
    rotations = np.empty((n_frames, *base.rotations.shape[1:]))
    translations = np.empty((n_frames, *base.local_translations.shape[1:]))
    # An hour of them needs no memory beside itself.
    for start in range(0, n_frames, 4096):
        some = slice(start, start + 4096)
        here = base.at(times[some])
        noise = generator.normal(scale=5e-4, size=(*here.rotations.shape[:2], 3))
        turns = np.concatenate([np.ones((*noise.shape[:2], 1)), noise], axis=-1)
        rotations[some] = rotation.multiply(here.rotations, turns)
        translations[some] = here.local_translations
    return Motion(base.skeleton, rotations, translations, base.rate, name="take", declaration=base.declaration)


def joined_motion(n_frames: int) -> Motion:
    """Join a motion of any length at 120 Hz out of different captures of one skeleton's joints, or of the sample clip.

    Each pass goes through all captures in another order and plays each at another speed, so that the take is as varied
    as a session on a stage. Joins are blended over an eighth of a second; noise in the turns makes no two frames alike.
    """
    generator = np.random.default_rng(0)
    files = sorted((MOCAP / "cmu-bvh").glob("*.bvh")) if MOCAP.is_dir() else []
    # The first row of these captures is a T-pose that was put in front.
    captures = [read.frames(1, read.n_frames) for read in map(_motion, files)] or [motion(2000)]
    base = captures[0]
    rotations, places, total = [], [], 0
    while total < n_frames:
        for which in generator.permutation(len(captures)):
            capture = captures[which]
            here = capture.at(np.arange(0, capture.end_time, generator.uniform(0.8, 1.25) / 120))
            turns, where = here.rotations.copy(), here.local_translations.copy()
            where[:, 1:] = base.local_translations[0, 1:]
            if rotations:
                # The figure goes on from where it stands, at its own height.
                where[:, 0, (0, 2)] += places[-1][-1, 0, (0, 2)] - where[0, 0, (0, 2)]
                n_blended = min(15, len(turns))
                share = np.linspace(0, 1, n_blended + 1)[:-1]
                before = np.repeat(rotations[-1][-1:], n_blended, axis=0)
                turns[:n_blended] = rotation.slerp(before, turns[:n_blended], share[:, None])
                where[:n_blended, 0, 1] = (1 - share) * places[-1][-1, 0, 1] + share * where[:n_blended, 0, 1]
            noise = generator.normal(scale=5e-4, size=(*turns.shape[:2], 3))
            ones = np.ones((*noise.shape[:2], 1))
            rotations.append(rotation.multiply(turns, np.concatenate([ones, noise], axis=-1)))
            places.append(where)
            total += len(turns)
            if total >= n_frames:
                break
    return Motion(
        base.skeleton,
        np.concatenate(rotations)[:n_frames],
        np.concatenate(places)[:n_frames],
        base.rate,
        name="take",
        declaration=base.declaration,
    )


def _motion(file: Path) -> Motion:
    found = retime.read(file)
    assert isinstance(found, Motion)
    return found
