"""What the panel asks in frames, and the search answers in seconds."""

from __future__ import annotations

import re

import numpy as np
import pytest

from blender.asked import Asked, Fault, answer, fault_of
from blender.editor import write_project
from blender.hand import keyed_timing
from blender.wording import summary
from retime.errors import InfeasibleWarpError, OptionError
from retime.motion.signal import Signal
from retime.project.file import read_project
from retime.project.solve import DocumentSolver

START, RATE = 101.0, 25.0


def wave(n=200, seed=0):
    t = np.arange(n) / RATE
    rows = np.stack([np.sin(t**1.5), np.cos(1.3 * t), 0.2 * np.sin(5 * t + seed)], axis=1)
    return Signal(("x", "y", "z"), rows, 25, f"wave {seed}")


def asked(**given):
    return Asked(**{"way": "RETIME", "start": START, "rate": RATE, "clips": [wave()]} | given)


def test_frames_of_keytimes_are_met():
    found = answer(asked(keys=[(151, 141, ""), (201, 181, "")], given={"length": "75%"}))
    assert (found.timing.start, found.timing.end, found.timing.input_end) == (101, 250, 300)
    assert found.timing.warp([141, 181]).tolist() == pytest.approx([151, 201])


def test_a_speed_at_a_keytime_is_met():
    found = answer(asked(clips=[wave(50)], keys=[(126, 126, "1/2")]))
    assert float(found.timing.warp.speed([126.0])[0]) == pytest.approx(0.5, abs=0.1)


def test_a_locked_stretch_keeps_its_speed():
    found = answer(asked(locks=[(151, 181, "")], given={"length": "70%"}))
    shown = np.interp(np.arange(151, 182), found.timing.warp.input_times, found.timing.warp.output_times)
    np.testing.assert_allclose(np.diff(shown), 1.0, atol=0.02)


def test_a_hands_timing_is_carried_over():
    t = np.arange(8 * 25 + 1) / RATE
    swing = Signal(("x", "y"), np.stack([np.sin(2 * np.pi * t), np.cos(2 * np.pi * t)], axis=1), 25)
    found = answer(asked(way="PROPAGATE", clips=[swing], hand=keyed_timing([(126, 126), (151, 176)], 101, 160)))
    assert float(np.median(found.timing.warp.slopes)) == pytest.approx(0.5, abs=0.03)


def test_in_step_the_output_lasts_as_long_as_the_reference():
    found = answer(
        asked(way="SYNCHRONISE", clips=[wave(60)], reference=[wave(50)], given={"length": "10%", "smoothness": 0.1})
    )
    assert found.timing.end == 150
    with pytest.raises(OptionError) as caught:
        answer(asked(way="SYNCHRONISE"))
    assert caught.value.option == "reference"


def test_a_group_has_one_timing():
    pair, others = [wave(60), wave(60, seed=1)], [wave(60, seed=2), wave(60, seed=3)]
    assert answer(asked(clips=pair, reference=others, given={"length": "80%"})).timing.end == 148


@pytest.mark.parametrize(
    ("given", "fault"),
    [
        ({"given": {"length": "soon"}}, ("length", -1)),
        ({"given": {"min_length": "soon", "length": "free"}}, ("min_length", -1)),
        ({"given": {"speed": "2..1"}}, ("speed", -1)),
        ({"given": {"rate": "often"}}, ("rate", -1)),
        ({"keys": [(150, 140, ""), (170, 150, "slow")]}, ("keys", 1)),
        ({"keys": [(150, 140, ""), (170, 140, "")]}, ("keys", 0)),
        ({"locks": [(150, 160, ""), (180, 170, "")]}, ("locks", 1)),
        ({"locks": [(150, 160, "sometimes")]}, ("locks", 0)),
        ({"given": {"length": "10%", "speed": "..2"}}, ("length", -1)),
        ({"given": {"length": "10%"}, "locks": [(110, 280, "")]}, ("length", -1)),
    ],
)
def test_errors_name_the_field(given, fault):
    one = asked(**given)
    with pytest.raises((OptionError, InfeasibleWarpError)) as caught:
        answer(one)
    found = fault_of(caught.value, one)
    assert (found.field, found.item) == fault
    assert fault_of(caught.value).text == str(caught.value)


@pytest.mark.parametrize(
    ("given", "said"),
    [
        (
            {"keys": [(400, 140, "")]},
            "the keytime at output frame 140 asks for input frame 400, but the input runs from frame 101 to 300",
        ),
        ({"keys": [(90, 80, "")]}, "a keytime stands at output frame 80; the output begins at frame 101"),
        (
            {"keys": [(150, 250, "")], "given": {"length": "50%"}},
            "a keytime stands at output frame 250, beyond the output's last frame, 200",
        ),
        ({"locks": [(180, 170, "")]}, "a lock needs a span of the input; frames 180 to 170 is none"),
        ({"locks": [(250, 400, "")]}, "the lock frames 250–400 at 1 leaves the clip, which runs from frame 101 to 300"),
        (
            {"given": {"length": "10%", "speed": "..2"}},
            "cannot fit input frames 101–300 into 20f (0.800 s): the speed limits allow no less than 101f (4.040 s). "
            "Use a length of at least 101f (4.040 s), or loosen the speed limits.",
        ),
    ],
)
def test_errors_speak_of_frames(given, said):
    one = asked(**given)
    with pytest.raises((OptionError, InfeasibleWarpError)) as caught:
        answer(one)
    assert fault_of(caught.value, one).text == said


def test_an_error_of_no_field_stands_alone():
    assert fault_of(ValueError("odd")) == Fault("odd", "", -1)


def test_a_search_tells_how_far_it_is_and_ends_where_nobody_listens():
    class EnoughError(Exception):
        pass

    def stop(share):
        raise EnoughError

    with pytest.raises(EnoughError):
        answer(asked(clips=[wave(8000)], given={"length": "70%"}), stop)


def test_warnings_are_handed_on():
    still = Signal(("x",), np.ones((60, 1)), 25)
    found = answer(asked(clips=[still], given={"length": "80%"}))
    assert any("nothing changes" in said for said in found.warnings)


def test_words_say_lengths_speeds_and_where_it_was_squeezed():
    found = answer(asked(given={"length": "75%"}))
    lines = summary(found.timing, wave(), found.found)
    assert lines[0] == "200 → 150 frames (6.00 s), 75%"
    assert lines[1].startswith("speed ")
    (squeezed,) = [line for line in lines if line.startswith("squeezed most: frames ")]
    first, last = (int(number) for number in re.findall(r"\d+(?= to|,)", squeezed))
    warp = found.timing.warp
    speed = (last - first) / (
        np.interp(last, warp.input_times, warp.output_times) - np.interp(first, warp.input_times, warp.output_times)
    )
    # It is squeezed more than the whole, and as much as the line says.
    assert speed > 1.25 * 200 / 150
    assert float(squeezed.rpartition(" ")[2].rstrip("×")) == pytest.approx(speed, rel=0.05)


def test_the_editor_solves_what_the_panel_asks(tmp_path):
    one = asked(keys=[(151, 141, "")], locks=[(201, 211, "")], given={"length": "75%"})
    place = write_project(one, tmp_path, "")
    assert place.name.endswith("_from_101.retime")
    project = read_project(place)
    solved = DocumentSolver().solve(project.document).warp
    mine = answer(one).timing.in_seconds()
    times = np.linspace(0, mine.output_end, 99)
    np.testing.assert_allclose(solved(times), mine(times), atol=1e-6)
