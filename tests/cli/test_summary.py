"""The numbers of a summary, on warps where they are known."""

from __future__ import annotations

from fractions import Fraction

import numpy as np
import pytest

from retime import Signal, Warp
from retime.cli import summary
from retime.evaluate.metrics.flights import flight_spans
from tests.cli.figures import FLIGHT, curve, figure

# Two seconds of input at speed 2, one at 1, three at 3.
WARP = Warp([0.0, 1.0, 2.0, 3.0], [0.0, 2.0, 3.0, 6.0])


def test_unit_share_counts_output_time() -> None:
    assert summary.unit_share(WARP) == pytest.approx(1 / 3)
    assert summary.unit_share(Warp([0.0, 4.0], [0.0, 4.0])) == 1.0


def test_output_seconds_follow_the_pieces_that_a_span_crosses() -> None:
    clip = Signal(("pan",), np.zeros((181, 1)), Fraction(30))
    assert clip.end_time == WARP.input_times[-1]
    assert summary.output_seconds(WARP, 1.0, 4.5, clip) == pytest.approx(0.5 + 1.0 + 0.5)
    # The last frame is shown for a frame period in the output as in the input, however fast the way to it was.
    assert summary.output_seconds(WARP, 1.0, clip.duration, clip) == pytest.approx(2.5 + 1 / 30)


def test_speeds_are_those_of_the_pieces_inside_or_of_the_one_around() -> None:
    assert summary.speeds_in(WARP, 1.5, 3.5).tolist() == [1.0]
    assert summary.speeds_in(WARP, 4.0, 5.0).tolist() == [3.0]
    backward = Warp([0.0, 1.0, 3.0], [6.0, 4.0, 0.0])
    assert summary.speeds_in(backward, 3.9, 6.0).tolist() == [-2.0]


def test_flights_that_are_played_at_another_speed_are_named() -> None:
    kept, fast, cut = (2.0, 3.0), (3.0, 6.0), (7.0, 8.0)
    assert summary.flights_text(WARP, [kept]) == "1 of 1 kept at unit speed"
    assert summary.flights_text(WARP, [kept, fast]) == "1 of 2 kept at unit speed; input 3.00-6.00 s at 3.00"
    # A flight that the warp never shows is neither kept nor played.
    assert summary.flights_text(WARP, [kept, cut]) == "1 of 2 kept at unit speed"


def test_flights_and_idle_times_of_the_figure() -> None:
    (flight,) = flight_spans(figure())
    assert flight == pytest.approx(FLIGHT, abs=0.1)
    idle = summary.idle_spans(figure())
    assert idle[-1][0] == pytest.approx(FLIGHT[1], abs=0.1)
    assert idle[-1][1] == 4.0
    assert all(end < FLIGHT[0] or start > FLIGHT[1] - 0.1 for start, end in idle)
    assert flight_spans(curve()) == ()
    assert summary.idle_spans(figure().frames(0, 1)) == []


def test_lengths_count_every_frame_for_a_period() -> None:
    assert summary.length_text(1, Fraction(30)) == "1 frame, 0.03 s"
    assert summary.length_text(48, Fraction(24000, 1001)) == "48 frames, 2.00 s"
    assert summary.rate_text(Fraction(24000, 1001)) == "23.976 Hz"


def test_a_warp_that_holds_and_runs_backward_has_a_summary(run, clips) -> None:
    held = run("warp", clips.bvh, "--key", "1=1", "--key", "1=2", "--key", "3=4").stdout
    assert "speed    0.00 to " in held
    back = run("warp", clips.bvh, "--key", "2=2", "--key", "1=3.5").stdout
    assert "speed    -" in back
    assert np.isfinite(float(back.split("speed")[1].split()[0]))
