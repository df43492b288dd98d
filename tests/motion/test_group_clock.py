"""One clock for the clips of a group: offsets, and what is said where their own clocks differ."""

from __future__ import annotations

import warnings
from dataclasses import replace
from fractions import Fraction
from pathlib import Path

import numpy as np
import pytest

import retime
from retime.errors import RetimeWarning
from retime.motion.clock import Clock
from retime.motion.group_clock import hint_at_clocks, on_clock_of
from retime.motion.motion import Motion
from retime.motion.signal import Signal
from retime.project.document import ClipFile, Document
from retime.project.faults import FaultyError
from retime.project.solve import DocumentSolver

FIGURE = Signal(("x",), np.arange(90.0)[:, None] / 30, Fraction(30), name="figure")


def camera(n_frames: int, rate: int = 30, start: float = 0.0, first_frame: int = 0) -> Signal:
    """A clip that shows, at every moment, the time of the figure's clock."""
    values = start + np.arange(n_frames)[:, None] / rate
    return Signal(("shown",), values, Fraction(rate), name="camera", first_frame=first_frame, kinds=("linear",))


@pytest.mark.parametrize("rate", [24, 30, 60, 120])
@pytest.mark.parametrize("offset", [-1.0, -0.317, 0.0])
def test_what_is_shown_is_of_the_same_moment(rate: int, offset: float) -> None:
    found = on_clock_of(camera(6 * rate, rate, offset), FIGURE, offset)
    assert found.rate == rate
    assert abs(found.end_time - FIGURE.end_time) <= 0.5 / rate
    np.testing.assert_allclose(found.values[:, 0], np.arange(found.n_frames) / rate, atol=1e-12)


def test_where_it_has_no_frames_its_nearest_is_held_and_that_is_said() -> None:
    with pytest.warns(RetimeWarning, match=r"camera does not show all of figure: .* 0.5 s at the start and 1.5 s at"):
        found = on_clock_of(camera(30, 30, 0.5), FIGURE, 0.5)
    wanted = np.clip(np.arange(90) / 30, 0.5, 0.5 + 29 / 30)
    np.testing.assert_allclose(found.values[:, 0], wanted, atol=1e-12)


def test_frames_of_a_motion_stay_as_they_are() -> None:
    clip = retime.sample()
    found = on_clock_of(clip, clip.frames(30, 200), -0.5)
    assert isinstance(found, Motion)
    np.testing.assert_array_equal(found.rotations, clip.rotations[30:200])
    assert found.first_frame == 30


class TestHints:
    def told(self, *clips: Signal, lengths: bool = True) -> list[str]:
        with warnings.catch_warnings(record=True) as caught:
            warnings.simplefilter("always")
            hint_at_clocks([FIGURE, *clips], lengths=lengths)
        return [str(one.message) for one in caught]

    def test_nothing_is_said_of_one_clock(self) -> None:
        # As long to half a frame of the slower one; counted from 1.
        assert self.told(camera(90), camera(360, 120), camera(90, first_frame=1)) == []

    def test_a_clock_that_begins_elsewhere(self) -> None:
        told = self.told(camera(90), replace(camera(90, first_frame=300), name="late"))
        assert len(told) == 1
        assert told[0].startswith("late begins at 10 s by its own times, figure at 0 s")
        assert "--also CLIP+10s=OUT" in told[0]

    def test_times_since_1970_say_nothing_beside_those_of_a_clip(self) -> None:
        since_1970 = [replace(camera(90), clock=Clock("ms", 1_700_000_000 + Fraction(late))) for late in (0, 2)]
        assert self.told(*since_1970) == []
        with pytest.warns(RetimeWarning, match=r"CLIP\+2s=OUT"):
            hint_at_clocks(since_1970)

    @pytest.mark.parametrize(
        ("n_frames", "what"), [(80, "its last frame is held"), (100, "the rest of it is not shown")]
    )
    def test_lengths(self, n_frames: int, what: str) -> None:
        assert self.told(camera(n_frames)) == [f"camera lasts {n_frames / 30:.3f} s and figure 3.000 s: {what}"]

    def test_a_group_is_told_in_python(self) -> None:
        with pytest.warns(RetimeWarning, match="camera begins at 10 s by its own times"):
            retime.guided_warp([FIGURE, camera(90, first_frame=300)], length="90%")

    def test_the_page_is_told(self, tmp_path: Path) -> None:
        for name, signal in (("a", FIGURE), ("b", camera(60, first_frame=60))):
            retime.write(signal, tmp_path / f"{name}.csv")
        document = Document((ClipFile(str(tmp_path / "a.csv")), ClipFile(str(tmp_path / "b.csv"), role="follow")))
        solver = DocumentSolver()
        with warnings.catch_warnings(record=True) as caught:
            warnings.simplefilter("always")
            solver.read(document)
        told = [str(one.message) for one in caught if issubclass(one.category, RetimeWarning)]
        assert any(one.startswith("b begins 2 s after a by the times in both files, and is put there") for one in told)
        assert any(one.startswith("b does not show all of a") for one in told)
        # Once, not at every change of the document.
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            solver.read(replace(document, options={"length": "90%"}))

    @pytest.mark.parametrize(("offset", "first"), [("-1s", 30), ("+0s", 0), ("-12f", 12), ("0:00.5", 0)])
    def test_a_document_says_when_a_clip_begins(self, tmp_path: Path, offset: str, first: int) -> None:
        late = Signal(("frame",), np.arange(120.0)[:, None], 30, first_frame=60)
        for name, signal in (("a", FIGURE), ("b", late)):
            retime.write(signal, tmp_path / f"{name}.csv")
        other = ClipFile(str(tmp_path / "b.csv"), role="follow", offset=offset)
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            solver = DocumentSolver()
            sources = solver.read(Document((ClipFile(str(tmp_path / "a.csv")), other)))
            # The same value while nothing changes.
            again = solver.read(Document((ClipFile(str(tmp_path / "a.csv")), other), options={"length": "90%"}))
        assert again.clips[1] is sources.clips[1]
        assert sources.clips[1].n_frames == FIGURE.n_frames
        assert sources.clips[1].values[0, 0] == first

    def test_an_offset_that_is_none_is_the_fault_of_its_clip(self, tmp_path: Path) -> None:
        retime.write(FIGURE, tmp_path / "a.csv")
        clip = ClipFile(str(tmp_path / "a.csv"))
        with pytest.raises(FaultyError) as caught:
            DocumentSolver().read(Document((clip, replace(clip, role="follow", offset="soon"))))
        assert caught.value.fault.clip == 1
