"""A warp from what a video shows, where the answer is known."""

from __future__ import annotations

from fractions import Fraction

import numpy as np
import pytest

from retime import guided_warp, read_warp, write
from retime.errors import FormatError
from retime.evaluate.metrics.flights import flight_timing
from retime.media.features import video_signal
from retime.motion.signal import Signal
from retime.search.poses.spaces import PoseOptions
from retime.warp.spline import linear_warp
from study.footage import ball as footage
from tests.media import clips

av = pytest.importorskip("av", reason="needs the extra 'video'")
for package in ("cv2", "python_stretch"):
    pytest.importorskip(package, reason="needs the extra 'video'")

pytestmark = pytest.mark.extras


@pytest.fixture(scope="module")
def ball(tmp_path_factory):
    return footage.write_ball(tmp_path_factory.mktemp("ball") / "ball.mp4")


def test_flow_says_how_far_things_move(tmp_path) -> None:
    # All of the picture passes by, three pixels of 96 a frame.
    def change(number, frame):
        y, x = np.mgrid[0:96, 0:128].astype(float)
        grey = 120 + 50 * np.sin((x - 3 * number) / 4) * np.cos(y / 5)
        made = av.VideoFrame.from_ndarray(grey.astype(np.uint8), format="gray").reformat(format="yuv420p")
        made.pts, made.time_base = frame.pts, frame.time_base
        return made

    clip = clips.write_clip(tmp_path / "a.mkv", 120, size=(128, 96), change=change)
    signal = video_signal(clip)
    assert (signal.n_frames, signal.rate) == (120, 30)
    across = signal.values[:, [name.startswith("flow x") for name in signal.names]]
    down = signal.values[:, [name.startswith("flow y") for name in signal.names]]
    # Summed and forgotten within a second it stays at its height.
    assert across[-30:].mean(axis=0).min() > 10 * np.abs(down[-30:].mean(axis=0)).max()
    assert across[-1] == pytest.approx(across[-20], rel=0.1)


def test_a_ball_keeps_its_flights(ball) -> None:
    signal = video_signal(ball)
    found = guided_warp(signal, length="60%", features=PoseOptions(scale_signals=False))
    timing = flight_timing(found.staircase, footage.spans())
    linear = flight_timing(linear_warp(found.warp.keytimes), footage.spans())
    assert timing.n_kept >= 0.95 * timing.n_frames
    assert linear.n_kept == 0


def test_the_command_finds_and_applies_it(run, ball, tmp_path) -> None:
    run("warp", ball, "--length", "60%", "-o", "short.mp4", "--save", "w.json", "-q")
    warp = read_warp(tmp_path / "w.json")
    assert warp.count_frames(30) == round(0.6 * 163)
    assert len(clips.read_frames(tmp_path / "short.mp4")[0]) == round(0.6 * 163)
    speeds = [float(np.mean(warp.speed(warp.inverse()(np.linspace(a + 0.1, b - 0.1, 20))))) for a, b in footage.spans()]
    assert speeds == pytest.approx([1, 1, 1], abs=0.1)


def test_a_part_of_a_video_is_cut_where_it_was_looked_at(run, ball, tmp_path) -> None:
    run("warp", ball, "--frames", "30:90", "--length", "100%", "-o", "part.mkv", "--save", "w.json", "-q")
    frames = clips.read_frames(tmp_path / "part.mkv")[2]
    given = clips.read_frames(ball)[2]
    assert len(frames) == 61
    for k in (0, 30, 60):
        a, b = (one.to_ndarray(format="gray").astype(float) for one in (frames[k], given[30 + k]))
        assert np.abs(a - b).mean() < 4


def test_footage_beside_a_motion_gets_its_warp(run, tmp_path) -> None:
    times = np.arange(61) / 30
    values = np.stack([np.where(times > 1, (times - 1) ** 2, 0.0), np.sin(times)], axis=1)
    write(Signal(("a", "b"), values, 30), tmp_path / "curve.csv")
    clips.write_clip(tmp_path / "take.mkv", 91)
    run(
        "warp",
        "curve.csv",
        "--length",
        "70%",
        "--save",
        "w.json",
        "--also",
        "take.mkv-1s=out.mkv",
        "--no-average",
        "-q",
    )
    warp = read_warp(tmp_path / "w.json")
    numbers, _, _ = clips.read_frames(tmp_path / "out.mkv")
    wanted = (warp(np.arange(len(numbers)) / 30) + 1) * 30
    assert np.abs(np.array(numbers) - wanted).max() < 1.01
    refused = run("warp", "curve.csv", "--group", "--also", "take.mkv=o.mkv", code=2)
    assert "is video or sound" in refused.stderr


def test_a_variable_rate_becomes_even(tmp_path) -> None:
    stamps = np.cumsum(np.random.default_rng(1).integers(20, 50, 60)).tolist()
    clip = clips.write_clip(
        tmp_path / "a.mkv", 60, codec="libx264", stamps=stamps, base=Fraction(1, 1000), options={"bf": "0"}
    )
    signal = video_signal(clip)
    assert signal.end_time == pytest.approx((stamps[-1] - stamps[0]) / 1000, abs=1 / float(signal.rate))


def test_sound_and_a_single_frame_move_nothing(tmp_path) -> None:
    with pytest.raises(FormatError, match="sound alone"):
        video_signal(clips.write_sound(tmp_path / "a.wav", clips.sound(0.5)))
    with pytest.raises(FormatError, match="single frame"):
        video_signal(clips.write_clip(tmp_path / "b.mkv", 1))
