"""`--also CLIP+OFFSET=OUT`: another clip that begins at another moment."""

from __future__ import annotations

from fractions import Fraction
from pathlib import Path

import numpy as np
import pytest

import retime
from retime.motion.clock import Clock
from retime.motion.signal import Signal


@pytest.fixture
def clips(tmp_path: Path) -> tuple[Path, Path]:
    times = np.arange(150)[:, None] / 30
    figure = Signal(("x",), np.sin(times), Fraction(30))
    # It begins a second and a half before the figure and shows the figure's time.
    camera = Signal(("shown",), np.arange(240)[:, None] / 30 - 1.5, Fraction(30))
    retime.write(figure, tmp_path / "figure.csv")
    retime.write(camera, tmp_path / "camera.csv")
    return tmp_path / "figure.csv", tmp_path / "camera.csv"


@pytest.mark.parametrize("offset", ["-1.5s", "-45f", "-1.5"])
def test_it_shows_the_moments_that_the_figure_shows(run, clips: tuple[Path, Path], offset: str) -> None:
    figure, camera = clips
    run("warp", figure, "--method", "linear", "--length", "80%", "-o", "f.csv", "--also", f"{camera}{offset}=c.csv")
    wanted, shown = retime.read("f.csv"), retime.read("c.csv")
    assert isinstance(wanted, Signal)
    assert isinstance(shown, Signal)
    assert shown.n_frames == wanted.n_frames
    output = np.arange(shown.n_frames) / 30
    # Averaged over windows that close at the ends.
    linear = output * (149 / 30) / ((wanted.n_frames - 1) / 30)
    np.testing.assert_allclose(shown.values[:, 0], linear, atol=2e-3)


def test_a_later_one_is_held_and_that_is_said(run, clips: tuple[Path, Path]) -> None:
    figure, camera = clips
    said = run("warp", figure, "--method", "linear", "--length", "80%", "--also", f"{camera}+0.5s=c.csv").stderr
    assert "camera does not show all of figure: its nearest frame is held for 0.5 s at the start" in said


def test_a_file_of_that_very_name_is_meant_itself(run, clips: tuple[Path, Path]) -> None:
    figure, camera = clips
    odd = camera.with_name("camera.csv+0.5s")
    camera.rename(odd)
    assert "no format ends in" in run("warp", figure, "--length", "80%", "--also", f"{odd}=c.csv", code=1).stderr


def test_a_clock_that_begins_elsewhere_is_said_with_its_offset(run, clips: tuple[Path, Path]) -> None:
    figure, _ = clips
    late = Signal(("pan",), np.arange(150)[:, None] / 7, Fraction(30), first_frame=300)
    retime.write(late, "late.csv")
    arguments = ("warp", figure, "--method", "linear", "--length", "80%", "--also")
    assert "--also CLIP+10s=OUT" in run(*arguments, "late.csv=l.csv").stderr
    # Said by a person, nothing is left to say of it.
    assert "by its own times" not in run(*arguments, "late.csv+0s=m.csv").stderr


@pytest.mark.parametrize("beside", ["figure.csv", "10 s"])
def test_times_in_both_files_say_when_it_begins(run, clips: tuple[Path, Path], beside: str) -> None:
    """The figure begins at 12.5 s of a day's clock, the camera at 11 s: by their times it shows the figure's time."""
    del clips
    times = np.arange(150)[:, None] / 30
    at = Fraction(25, 2) if beside == "10 s" else Fraction(0)
    retime.write(Signal(("x",), np.sin(times), Fraction(30), clock=Clock(start=at)), "timed.csv")
    camera = Signal(
        ("shown",), np.arange(240)[:, None] / 30 - 1.5, Fraction(30), clock=Clock(start=at - Fraction(3, 2))
    )
    retime.write(camera, "cam.csv")
    arguments = ("warp", "timed.csv", "--method", "linear", "--length", "100%", "--force", "-o", "f.csv", "--also")
    said = run(*arguments, "cam.csv=c.csv").stderr
    assert "cam begins 1.5 s before timed by the times in both files, and is put there" in said
    assert "by its own times" not in said
    shown = retime.read("c.csv")
    assert isinstance(shown, Signal)
    np.testing.assert_allclose(shown.values[:, 0], np.arange(150) / 30, atol=1e-6)
    assert shown.start_time == at
    # Said by a person, the times count for nothing.
    said = run(*arguments, "cam.csv+0s=c.csv").stderr
    assert "by the times in both files" not in said
    assert retime.read("c.csv").values[0, 0] == pytest.approx(-1.5)
