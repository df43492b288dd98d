"""Frames are not made on the word of one time: how many may be, and what is said of those that are."""

from __future__ import annotations

import numpy as np
import pytest

from retime.formats.made_frames import Sampling, too_many_made


@pytest.mark.parametrize("frames", [1, 2**18, 2**18 + 1, 10**7])
@pytest.mark.parametrize("rows", [2, 2_622, 99_999, 10**7])
@pytest.mark.parametrize("channels", [1, 16, 300])
@pytest.mark.parametrize("filled", [0.01, 1.0])
def test_so_many_frames_and_numbers_are_made_of_so_many(frames: int, rows: int, channels: int, filled: float) -> None:
    numbers = round(rows * channels * filled)
    few = frames <= 262_144 or frames <= 100 * rows
    small = frames * channels <= 4_194_304 or frames * channels <= 100 * numbers
    fits = frames * channels <= 268_435_456 or frames * channels <= numbers
    assert too_many_made(frames, channels, n_rows=rows, n_numbers=numbers) != (few and small and fits)


def sampling(keys, rate: float, channels: int = 7, start: float | None = None, end: float | None = None) -> Sampling:
    keys = np.asarray(keys, dtype=np.float64)
    start = float(keys.min()) if start is None else start
    end = float(keys.max()) if end is None else end
    return Sampling(start, end, rate, round((end - start) * rate) + 1, channels, channels * len(keys), keys)


def test_one_key_that_is_far_off_makes_no_millions_of_frames() -> None:
    keys = np.append(np.arange(10) / 10, 1e5)
    # In whatever order curves give them, and however many of them have a key there.
    keys = np.random.default_rng(0).permutation(np.append(keys, keys))
    problem = sampling(keys, 30).problem()
    assert problem == (
        "lasts 100000 s, and no key lies between 0.9 and 100000 s: 3000001 frames would be made of keys at 11 times; "
        "is that time right? A lower rate makes fewer (--fps)"
    )
    assert sampling(keys, 1).problem() is None
    # Where the scene says its end, or its start, no key need be there.
    assert "no key lies between 0.9 and 100000 s" in str(sampling(np.arange(10) / 10, 30, end=1e5).problem())
    assert "no key lies between -100000 and 0 s" in str(sampling(np.arange(10) / 10, 30, start=-1e5).problem())


def test_a_long_scene_with_keys_all_along_is_read() -> None:
    # Three hours at 120 Hz, a key a second; a crowd of whose nodes few move.
    assert sampling(np.arange(10_800.0), 120).problem() is None
    assert sampling(np.arange(10_800.0), 120).doubt() is None
    assert sampling([0.0, 60.0], 60, channels=7 * 1000).problem() is None
    # As many frames of a crowd as would take gigabytes are not made of two keys.
    assert "216001 frames" in str(sampling([0.0, 3600.0], 60, channels=7 * 1000).problem())


def test_frames_that_lie_where_no_key_does_are_said() -> None:
    assert sampling([0.0, 0.1, 3600.0], 30).doubt() == (
        "lasts 3600 s, 108001 frames, and no key lies between 0.1 and 3600 s: is that time right?"
    )
    # A minute's pause is none, nor one that is half of the scene.
    assert sampling([0.0, 0.1, 60.0], 30).doubt() is None
    assert sampling([0.0, 1800.0, 3600.0], 30).doubt() is None


def test_keys_of_which_hardly_one_is_shown_are_said() -> None:
    keys = np.arange(40) * 1e-6
    assert sampling(keys, 60).doubt() == (
        "lasts 3.9e-05 s, and has keys at 40 times, of which 1 frames at 60 Hz are made: is its clock right? A higher "
        "rate makes more (--fps)"
    )
    # Keys at 240 Hz of a scene at 60 Hz are none too many.
    assert sampling(np.arange(240) / 240, 60).doubt() is None
