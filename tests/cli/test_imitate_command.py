"""`retime imitate`: a stretch retimed by hand, and the rest follows."""

from __future__ import annotations

import json
from fractions import Fraction

import numpy as np
import pytest

from retime import OptionError, Signal, Warp, read, read_warp, write, write_warp
from retime.search.imitate import imitate


@pytest.fixture
def swing(tmp_path):
    """Write five seconds of a swing, one in two seconds."""
    t = np.arange(151) / 30
    values = np.stack([np.sin(np.pi * t), np.cos(np.pi * t)], axis=1)
    write(Signal(("x", "y"), values, Fraction(30), "swing"), tmp_path / "swing.csv")
    return tmp_path / "swing.csv"


@pytest.mark.parametrize("speed", [0.5, 3.0])
def test_the_rest_of_the_clip_plays_at_the_speed_of_the_hand(run, swing, tmp_path, speed) -> None:
    write_warp(Warp([0.0, 3 / speed], [0.0, 3.0]), tmp_path / "hand.json")
    result = run(
        "imitate", "swing.csv", "--example", "0:90", "--warp", "hand.json", "--fps", "30", "--neighbors", "1",
        "-o", "out.csv", "--save", "warp.json", "--plot", "warp.svg", "--explain", "why.csv",
    )  # fmt: skip
    warp = read_warp(tmp_path / "warp.json")
    assert np.median(warp.slopes) == pytest.approx(speed, rel=0.1)
    assert read(tmp_path / "out.csv").n_frames == pytest.approx(151 / speed, rel=0.1)
    assert "swing by hand" in (tmp_path / "why.csv").read_text()
    assert [line.split()[-1] for line in result.stdout.splitlines() if line.startswith("wrote")] == [
        "out.csv", "warp.json", "warp.svg", "why.csv",
    ]  # fmt: skip
    assert warp.name == "swing"


def test_the_command_finds_what_the_library_finds(run, clips, tmp_path) -> None:
    run("warp", clips.csv, "--frames", "10:39", "--length", "60%", "--save", "hand.json", "-q")
    options = ("--example", "10:39", "--warp", "hand.json", "--json")
    document = json.loads(run("imitate", clips.csv, *options).stdout)
    found = imitate(read(clips.csv), (10, 40), read_warp(tmp_path / "hand.json"))
    assert document["path"] == found.path.frames.tolist()
    assert (document["references"], document["example"]) == (["hand.json"], "10:39")
    assert document["n_reference"] == 18
    # Frames are counted in what is used of the file.
    assert json.loads(run("imitate", clips.csv, *options, "--frames", "10:39").stdout)["n_input"] < document["n_input"]


def test_length_keys_and_control_are_those_of_warp(run, clips, tmp_path) -> None:
    run("warp", clips.csv, "--frames", "0:29", "--length", "60%", "--save", "hand.json", "-q")
    options = ("--example", "0:29", "--warp", "hand.json", "--force", "--save", "warp.json", "--json")
    keyed = ("--length", "80%", "--key", "1=0.8", "--lock", "1.2..1.5=1/2")
    assert json.loads(run("imitate", clips.csv, *options, *keyed).stdout)["output_frames"] == 48
    assert float(read_warp(tmp_path / "warp.json")(0.8)) == pytest.approx(1.0)
    assert json.loads(run("imitate", clips.csv, *options, "--max-length", "20f").stdout)["output_frames"] <= 20
    assert json.loads(run("imitate", clips.csv, *options, "--max-skip", "5").stdout)["max_skip"] == 5


@pytest.mark.parametrize(
    ("options", "code", "says"),
    [
        (["--example", "0:29"], 2, "--warp"),
        (["--warp", "hand.json"], 2, "--example"),
        (["--example", "30", "--warp", "hand.json"], 2, "1:1980"),
        (["--example", "0:99", "--warp", "hand.json"], 2, "0:59"),
        (["--example", "0:9", "--warp", "hand.json"], 2, "has its last one at 0.3 s"),
        (["--example", "0:29", "--warp", "{clip}"], 1, "camera.csv"),
        (["--example", "0:29", "--warp", "hand.json", "--save", "hand.json", "--force"], 2, "never overwritten"),
        (["--example", "0:29", "--warp", "hand.json", "--mirror"], 2, "--mirror"),
    ],
)
def test_wrong_options_are_named(run, clips, tmp_path, options, code, says) -> None:
    write_warp(Warp([0.0, 0.5], [0.0, 29 / 30]), tmp_path / "hand.json")
    result = run("imitate", clips.csv, *(option.format(clip=clips.csv) for option in options), code=code)
    assert result.stderr.startswith("error: ")
    assert says in result.stderr


def test_a_hand_that_leaves_its_example_is_refused(clips) -> None:
    with pytest.raises(OptionError, match="counted from their first"):
        imitate(read(clips.csv), (30, 60), Warp([0.0, 1.0], [1.0, 2.0]))


def test_holds_and_reversals_of_the_hand_do_no_harm(clips) -> None:
    hand = Warp([0.0, 0.2, 0.5, 0.9, 1.2], [0.0, 0.6, 0.6, 0.1, 29 / 30])
    found = imitate(read(clips.csv), (0, 30), hand)
    assert found.max_skip / found.upsample >= 3.0
