"""`retime imitate`: a stretch retimed by hand, and the rest follows."""

from __future__ import annotations

import json
import warnings
from fractions import Fraction

import numpy as np
import pytest

from retime import OptionError, RetimeWarning, Signal, Warp, read, read_warp, write, write_warp
from retime.cli.help_sections import Option
from retime.cli.imitate import command
from retime.search.imitate import imitate
from retime.search.options import OPTIONS


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
    assert "swing, the example" in (tmp_path / "why.csv").read_text()
    assert [line.split()[-1] for line in result.stdout.splitlines() if line.startswith("wrote")] == [
        "out.csv", "warp.json", "warp.svg", "why.csv",
    ]  # fmt: skip
    assert warp.name == "swing"


def test_the_command_finds_what_the_library_finds(run, clips, tmp_path) -> None:
    run("warp", clips.csv, "--frames", "10:39", "--length", "60%", "--save", "hand.json", "-q")
    options = ("--example", "10:39", "--warp", "hand.json", "--json")
    document = json.loads(run("imitate", clips.csv, *options).stdout)
    with pytest.warns(RetimeWarning, match="ends don't meet"):
        found = imitate(read(clips.csv), (10, 40), read_warp(tmp_path / "hand.json"))
    assert document["path"] == found.path.frames.tolist()
    assert (document["references"], document["example"]) == (["hand.json"], "10:39")
    assert document["n_reference"] == 30
    assert (document["example_clip"], document["coverage"]["share"]) == (None, found.example.share)
    assert document["coverage"]["warnings"] == list(found.example.warnings)
    # Frames are counted in what is used of the file.
    assert json.loads(run("imitate", clips.csv, *options, "--frames", "10:39").stdout)["n_input"] < document["n_input"]


def test_help_says_which_options_need_the_papers_way() -> None:
    marked = {one.name for one in command.params if isinstance(one, Option) and "needs --paper" in one.default_text}
    # Of the searches only one of three is refused.
    assert marked == {one.name for one in OPTIONS if "hand" not in one.methods} | {"search"}


@pytest.mark.parametrize(
    "option", [("--match-tempo",), ("--evenness", "2"), ("--score", "conditional"), ("--search", "heuristic")]
)
def test_what_needs_the_papers_way_is_refused_without_it(run, swing, tmp_path, option) -> None:
    write_warp(Warp([0.0, 2.5], [0.0, 3.0]), tmp_path / "hand.json")
    given = ("imitate", swing, "--example", "0:90", "--warp", "hand.json", "--fps", "30", "--length", "100%", "--json")
    assert "--paper" in run(*given, *option, code=2).stderr
    assert json.loads(run(*given, *option, "--paper").stdout)["coverage"] is None


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
        (["--example", "0:29", "--warp", "hand.json", "--example-fps", "30"], 2, "--example-fps needs --example-clip"),
        (["--example", "0:29", "--warp", "hand.json", "--score", "conditional"], 2, "--paper"),
        (["--example", "0:29", "--warp", "hand.json", "--example-clip", "hand.json"], 1, "no keypoints"),
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
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", RetimeWarning)
        found = imitate(read(clips.csv), (0, 30), hand)
    # What is shown three times lasts three times as long, whichever way it runs.
    shown = np.interp([0.2, 0.5], found.warp.input_times, found.warp.output_times)
    assert shown[1] - shown[0] == pytest.approx(0.4 + 3 / 13 * 0.9, rel=0.5)
    paper = imitate(read(clips.csv), (0, 30), hand, paper=True)
    assert paper.max_skip / paper.upsample >= 3.0


def test_the_papers_way_is_an_option_away(run, clips, tmp_path) -> None:
    run("warp", clips.csv, "--frames", "10:39", "--length", "60%", "--save", "hand.json", "-q")
    document = json.loads(
        run("imitate", clips.csv, "--example", "10:39", "--warp", "hand.json", "--paper", "--json").stdout
    )
    found = imitate(read(clips.csv), (10, 40), read_warp(tmp_path / "hand.json"), paper=True)
    assert document["path"] == found.path.frames.tolist()
    assert (document["n_reference"], document["coverage"]) == (18, None)


def test_the_summary_says_how_much_the_example_speaks_for(run, tmp_path) -> None:
    t = np.arange(241) / 30
    values = np.stack([np.sin(np.pi * t), np.cos(np.pi * t)], axis=1)
    values[(t > 4) & (t < 6)] += 5.0
    write(Signal(("x", "y"), values, Fraction(30), "swing"), tmp_path / "swing.csv")
    write_warp(Warp([0.0, 4.0], [0.0, 2.0]), tmp_path / "hand.json")
    result = run("imitate", "swing.csv", "--example", "0:60", "--warp", "hand.json", "--fps", "30")
    (row,) = [line for line in result.stdout.splitlines() if line.startswith("example")]
    assert "speaks for 7" in row
    assert "not for input seconds 3.97..6.03" in row
    assert "warning: of 2" in result.stderr
    document = json.loads(
        run("imitate", "swing.csv", "--example", "0:60", "--warp", "hand.json", "--fps", "30", "--json").stdout
    )
    assert document["coverage"]["unspoken"] == [[pytest.approx(3.97, abs=0.01), pytest.approx(6.03, abs=0.01)]]


def test_the_example_may_lie_in_another_clip(run, swing, tmp_path) -> None:
    # Twice as brisk, and numbered by its own frames.
    t = np.arange(61) / 30
    values = np.stack([np.sin(2 * np.pi * t), np.cos(2 * np.pi * t)], axis=1)
    write(Signal(("x", "y"), values, Fraction(30), "brisk"), tmp_path / "brisk.csv")
    write_warp(Warp([0.0, 2.0], [0.0, 1.0]), tmp_path / "hand.json")
    result = run(
        "imitate", "swing.csv", "--example", "30:60", "--example-clip", "brisk.csv", "--example-fps", "30",
        "--warp", "hand.json", "--fps", "30", "--save", "warp.json", "--json",
    )  # fmt: skip
    document = json.loads(result.stdout)
    assert document["example_clip"] == "brisk.csv"
    assert document["coverage"]["tempo"] == pytest.approx(0.5, rel=0.05)
    assert "another clip, which moves 2 times as fast" in result.stderr
    assert np.median(read_warp(tmp_path / "warp.json").slopes) == pytest.approx(0.5, rel=0.05)
