"""What is no number, or too large to be squared, is refused where it comes in; numbers at the limit do no harm."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import retime
from retime.errors import FormatError, InvalidMotionError, OptionError
from retime.motion.size import LARGEST


def test_a_motion_and_a_skeleton_say_where() -> None:
    clip = retime.sample().frames(0, 10)
    translations = clip.local_translations.copy()
    translations[4, 2, 1] = -1e101
    name = clip.skeleton.names[2]
    with pytest.raises(InvalidMotionError, match=rf"translation of joint '{name}' at frame 4 is larger than 1e\+100"):
        replace(clip, translations=translations)
    offsets = clip.skeleton.offsets.copy()
    offsets[2, 0] = 1e300
    with pytest.raises(InvalidMotionError, match=f"offset of joint '{name}' is larger than"):
        replace(clip.skeleton, offsets=offsets)
    ends = (retime.EndSite(2, (0.0, 1e300, 0.0)),)
    with pytest.raises(InvalidMotionError, match=f"end site of '{name}' is larger than"):
        replace(clip.skeleton, end_sites=ends)


def test_a_signal_says_where() -> None:
    with pytest.raises(InvalidMotionError, match=r"channel 'c1' at frame 3 is larger than 1e\+100, the limit: 1e\+200"):
        retime.guided_warp(np.array([[0.0, 0], [1, 2], [2, 1], [3, 1e200]]), rate=30)


@pytest.mark.parametrize("number", ["1e101", "-1e300"])
def test_a_file_is_refused_by_line(tmp_path: Path, number: str) -> None:
    (tmp_path / "huge.csv").write_text(f"x,y\n0,1\n1,{number}\n")
    with pytest.raises(FormatError, match=r"huge.csv:3: .*expected a number of 1e\+100 at most, found "):
        retime.read(tmp_path / "huge.csv", rate=30)
    text = Path("tests/data/bvh/plain.bvh")
    rows = (Path(__file__).parents[2] / text).read_text().splitlines()
    rows[-1] = f"{number} " + rows[-1].split(maxsplit=1)[1]
    (tmp_path / "huge.bvh").write_text("\n".join(rows) + "\n")
    with pytest.raises(FormatError, match=rf"huge.bvh:{len(rows)}:1: .*1e\+100 at most, found '{number}'"):
        retime.read(tmp_path / "huge.bvh")


def test_the_largest_numbers_are_searched_and_applied() -> None:
    wave = np.sin(np.arange(60) / 5)[:, None] * [1.0, 2.0]
    spiked = wave.copy()
    spiked[25, 0] = LARGEST
    # Compared with a small reference they are scaled by its spread, and stay huge.
    for reference in (None, wave):
        result = retime.guided_warp(spiked, reference=reference, rate=30, length="80%")
        assert np.isfinite(result.total)
        assert result.warp.monotone
    clip = retime.sample().frames(100, 200)
    translations = clip.local_translations.copy()
    translations[50, 0, 1] = LARGEST
    result = retime.guided_warp(replace(clip, translations=translations), length="80%")
    assert np.isfinite(result.total)
    assert np.isfinite(retime.apply_warp(clip, result.warp).local_translations).all()


NO_NUMBERS = {
    "complex numbers: pass the real parts": np.array([0.0, 1.0]) + 0j,
    "some are masked: fill them first": np.ma.masked_greater([0.0, 1.0], 0.5),
    "found dates: pass seconds": np.array([0, 1]).astype("datetime64[s]"),
    "found time spans: pass seconds": np.array([0, 1]).astype("timedelta64[ms]"),
    "found text": np.array(["0", "1"]),
    "an array of real numbers: .*argument must be a string or a real number": np.array([0, {}], dtype=object),
}


@pytest.mark.parametrize("message", NO_NUMBERS)
def test_what_is_no_array_of_numbers_is_refused_where_it_comes_in(message: str) -> None:
    values = NO_NUMBERS[message]
    clip = retime.sample().frames(0, 2)
    with pytest.raises(InvalidMotionError, match=f"the values of a signal must be .*{message}"):
        retime.Signal(("a",), values[:, None])
    for name, of in (("rotations", "rotations"), ("translations", "translations"), ("declared_angles", "translations")):
        array = values[np.ones(getattr(clip, of).shape, dtype=int)]
        with pytest.raises(InvalidMotionError, match=f"{name.replace('_', ' ')} must be .*{message}"):
            replace(clip, **{name: array})
    with pytest.raises(OptionError, match=f"the input_times of a warp, in seconds, must be .*{message}"):
        retime.Warp([0.0, 1.0], values)
    with pytest.raises(OptionError, match=f"times must be .*{message}"):
        clip.at(values)


@pytest.mark.parametrize("message", list(NO_NUMBERS)[:-1])
def test_such_an_array_is_neither_input_nor_reference(message: str) -> None:
    values, numbers = NO_NUMBERS[message], np.arange(20.0)
    with pytest.raises(OptionError, match=f"the array must be real numbers; .*{message}"):
        retime.guided_warp(values, rate=30)
    with pytest.raises(OptionError, match=f"the reference must be real numbers; .*{message}"):
        retime.guided_warp(numbers, reference=values, rate=30)


def test_a_mask_that_hides_nothing_is_no_matter() -> None:
    assert retime.Signal(("a",), np.ma.masked_greater([[0.0], [1.0]], 5)).values.tolist() == [[0.0], [1.0]]
