"""Sound by a warp, on samples: unsmeared, in tune, in time; holds, and what runs backward."""

from __future__ import annotations

import numpy as np
import pytest

from retime.media.sound import Samples, beginnings, retimed_sound, sound_length, without_sudden
from retime.warp.curve import Warp
from tests.media import clips

RATE = 48_000


def reader(samples: np.ndarray):
    """Read samples, with silence around them."""

    def read(first: int, count: int) -> Samples:
        made = np.zeros((len(samples), count), np.float32)
        low, high = max(first, 0), min(first + count, samples.shape[1])
        if high > low:
            made[:, low - first : high - first] = samples[:, low:high]
        return made

    return read


def retimed(samples: np.ndarray, warp: Warp, *, keep_pitch: bool = True) -> np.ndarray:
    """Give samples a warp."""
    blocks = retimed_sound(reader(samples), len(samples), RATE, warp, keep_pitch=keep_pitch)
    made = np.concatenate(list(blocks), axis=1)
    assert made.shape[1] == sound_length(warp, RATE)
    return made


def width_of(click: np.ndarray) -> float:
    """Return how long nine tenths of a click's energy take, seconds."""
    share = np.cumsum(click**2) / np.sum(click**2)
    return float(np.searchsorted(share, 0.95) - np.searchsorted(share, 0.05)) / RATE


@pytest.mark.extras
@pytest.mark.parametrize("speed", [1 / 3, 0.5, 0.8, 1.25, 2.0, 3.0, -0.6, -1.5])
def test_clicks_stay_clicks_and_a_tone_in_tune(speed) -> None:
    pytest.importorskip("python_stretch", reason="needs the extra 'video'")
    samples = clips.sound(6.0)
    ends = [0.0, 6.0] if speed > 0 else [6.0, 0.0]
    warp = Warp([0, 6 / abs(speed)], ends)
    made = retimed(samples, warp)
    given = np.arange(0.25, 5.9, 0.5) + 12 / RATE
    wanted = np.sort(given / speed if speed > 0 else (6 - given) / -speed)
    found = clips.clicks_in(made[0], RATE)
    assert len(found) == len(wanted)
    assert np.abs(found - wanted).max() < 1e-3
    first = round(0.25 * RATE)
    for moment in found[1:-1]:
        place = round(moment * RATE)
        assert width_of(made[0, place - 1200 : place + 1200]) < 2 * width_of(samples[0, first - 1200 : first + 1200])
    length = round(0.4 * RATE)
    for start in range(length, made.shape[1] - 2 * length, length):
        assert clips.pitch_of(made[1, start : start + length], RATE) == pytest.approx(440, rel=0.01)
        assert made[1, start : start + length].std() == pytest.approx(samples[1].std(), rel=0.25)


def test_the_input_s_own_speed_is_the_input() -> None:
    samples = clips.sound(3.0)
    made = retimed(samples, Warp([0, 1, 3], [0, 1, 3]))
    assert made[:, : 3 * RATE] == pytest.approx(samples, abs=1e-6)
    backward = retimed(samples, Warp([0, 3], [3, 0]))
    assert backward[:, 10:-10] == pytest.approx(np.roll(samples[:, ::-1], 1, axis=1)[:, 10:-10], abs=1e-6)


def test_a_hold_is_the_tone_of_the_room() -> None:
    chance = np.random.default_rng(2)
    room = chance.normal(0, 0.004, (1, 6 * RATE)).astype(np.float32)
    loud = room.copy()
    loud[0, : 3 * RATE] += 0.3 * np.sin(2 * np.pi * 300 * np.arange(3 * RATE) / RATE)
    made = retimed(loud, Warp([0, 2, 4, 6], [0, 2, 2, 4]), keep_pitch=False)
    held = made[0, round(2.1 * RATE) : round(3.9 * RATE)]
    assert held.std() == pytest.approx(0.004, rel=0.2)
    power = np.abs(np.fft.rfft(held)) ** 2
    assert power[: len(power) // 2].sum() == pytest.approx(power[len(power) // 2 :].sum(), rel=0.3)
    silent = loud - room
    made = retimed(silent, Warp([0, 2, 4, 6], [0, 2, 2, 4]), keep_pitch=False)
    assert np.abs(made[0, round(2.1 * RATE) : round(3.9 * RATE)]).max() == 0


def test_resampled_sound_is_that_of_the_formula() -> None:
    times = np.arange(4 * RATE) / RATE
    samples = np.sin(2 * np.pi * 300 * times)[None].astype(np.float32)
    made = retimed(samples, Warp([0, 2], [0.5, 3.5]), keep_pitch=False)
    wanted = np.sin(2 * np.pi * 300 * (0.5 + 1.5 * np.arange(2 * RATE) / RATE))
    assert made[0, 500:-500] == pytest.approx(wanted[500:-500], abs=2e-3)


@pytest.mark.parametrize("seed", range(4))
def test_what_is_taken_out_adds_up_again(seed) -> None:
    chance = np.random.default_rng(seed)
    samples = clips.sound(2.0) + chance.normal(0, 0.002, (2, 2 * RATE)).astype(np.float32)
    steady, sudden = without_sudden(samples.copy(), RATE)
    assert len(sudden) >= 3
    for _, start, sound in sudden:
        steady[:, start : start + sound.shape[1]] += sound
    assert steady == pytest.approx(samples, abs=1e-5)


def test_a_steady_tone_begins_nowhere() -> None:
    tone = 0.4 * np.sin(2 * np.pi * 440 * np.arange(2 * RATE) / RATE)[None].astype(np.float32)
    assert beginnings(tone, RATE) == []
    assert beginnings(np.zeros((1, RATE), np.float32), RATE) == []
    assert beginnings(np.zeros((1, 10), np.float32), RATE) == []
