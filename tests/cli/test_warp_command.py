"""`retime warp`: every option changes what it says it changes."""

from __future__ import annotations

import json
from fractions import Fraction
from pathlib import Path

import numpy as np
import pytest

import retime
from retime import read, read_warp, write
from retime.search.options import OPTIONS
from tests.cli.figures import curve, figure


def found(run, clip: Path, *options: str | Path) -> dict:
    """Search, and return what --json says."""
    result = run("warp", clip, "--json", *options)
    assert result.stdout.count("\n") == 1
    return json.loads(result.stdout)


def test_the_summary_says_what_happened_and_how_to_keep_it(run, clips, tmp_path) -> None:
    result = run("warp", clips.bvh, "--length", "65%")
    lines = dict(line.split(maxsplit=1) for line in result.stdout.splitlines())
    assert lines["input"] == f"{clips.bvh}, frames 0:240: 241 frames, 4.02 s at 60 Hz"
    assert lines["output"] == "157 frames, 2.62 s (65.1% of the input)"
    assert lines["search"] == "n_input 481, n_output 79, n_reference 121, max_skip 32, upsample 4 at 30 Hz"
    assert lines["speed"] == "1.00 to 8.00; 76% of the output at unit speed"
    assert lines["flights"] == "1 of 1 kept at unit speed"
    assert "-o OUT" in lines["Nothing"]
    assert "--save WARP.json" in lines["Nothing"]
    assert list(tmp_path.iterdir()) == []
    assert result.stderr == ""


def test_a_linear_warp_says_that_it_plays_the_flight_faster(run, clips) -> None:
    lines = run("warp", clips.bvh, "--length", "50%", "--method", "linear").stdout.splitlines()
    assert "flights  0 of 1 kept at unit speed; input 1.78-2.22 s at 2.02" in lines
    assert "speed    2.02 to 2.02; 0% of the output at unit speed" in lines
    assert not any(line.startswith("search") for line in lines)


def test_one_json_object_holds_every_number(run, clips, tmp_path) -> None:
    options = ("--length", "65%", "-o", "out.bvh", "--save", "warp.json", "--plot", "warp.png")
    document = found(run, clips.bvh, *options)
    path, seconds = document.pop("path"), document.pop("seconds")
    # This figure has no feet that stand.
    assert document.pop("slip") is None
    total, bound = document.pop("total"), document.pop("lower_bound")
    assert 0 < bound <= total < 1e6
    assert document == {
        "method": "guided",
        "input": str(clips.bvh),
        "references": [],
        "input_frames": 241,
        "input_rate": 60.0,
        "input_seconds": 241 / 60,
        "output_frames": 157,
        "output_rate": 60.0,
        "output_seconds": 157 / 60,
        "n_input": 481,
        "n_output": 79,
        "n_reference": 121,
        "max_skip": 32,
        "n_neighbors": 3,
        "rate": 30.0,
        "upsample": 4,
        "upsamples": [4],
        "optimal": True,
        "excess": None,
        "output": "out.bvh",
        "warp": "warp.json",
        "plot": "warp.png",
        "explain": None,
        "also": [],
        "beside": [],
    }
    assert len(path) == 79
    assert (path[0], path[-1]) == (0, 480)
    assert {"read", "features", "scores", "path", "apply", "write", "slip", "plot", "other"} <= set(seconds)
    assert all(value >= 0 for value in seconds.values())
    assert read(tmp_path / "out.bvh").n_frames == 157
    assert (tmp_path / "warp.png").read_bytes().startswith(b"\x89PNG")


@pytest.mark.parametrize("method", ["linear", "spline"])
def test_json_has_no_numbers_of_a_search_that_was_not_made(run, clips, method) -> None:
    document = found(run, clips.bvh, "--length", "65%", "--method", method)
    search = ("n_input", "n_output", "n_reference", "max_skip", "n_neighbors", "rate", "upsample", "total", "path")
    assert {name: document[name] for name in search} == dict.fromkeys(search)
    assert document["method"] == method
    assert document["output_frames"] == 157
    assert set(document["seconds"]) == {"read", "search", "other"}


@pytest.mark.parametrize(
    ("options", "input_frames", "output_frames"),
    [
        (["--length", "65%"], 241, 157),
        (["--length", "2.5s"], 241, 150),
        (["--length", "140f"], 241, 140),
        (["--frames", "10:109", "--length", "80%"], 100, 80),
        (["--drop-first", "40", "--length", "50%"], 201, 100),
        (["--drop-first", "40", "--frames", "40:139", "--length", "50%"], 100, 50),
        (["--fps", "30", "--length", "4s"], 241, 120),
        (["--fps", "29.97", "--length", "50%"], 241, 120),
    ],
)
def test_frames_and_lengths(run, clips, options, input_frames, output_frames) -> None:
    document = found(run, clips.bvh, *options)
    assert (document["input_frames"], document["output_frames"]) == (input_frames, output_frames)


def test_fps_overrides_the_rate_of_the_file(run, clips, tmp_path) -> None:
    document = found(run, clips.bvh, "--fps", "23.976", "--length", "90%", "-o", "film.bvh")
    assert document["input_rate"] == 24000 / 1001
    assert read(tmp_path / "film.bvh").rate == Fraction(24000, 1001)


@pytest.mark.parametrize("key", ["2.0=1.25", "120f=75f", "0:02.000=1.25s"])
def test_a_key_stands_where_it_was_asked_for(run, clips, tmp_path, key) -> None:
    run("warp", clips.bvh, "--length", "3s", "--key", key, "--save", "warp.json")
    warp = read_warp(tmp_path / "warp.json")
    assert float(warp(1.25)) == pytest.approx(2.0, abs=1e-12)
    assert warp.output_end == pytest.approx(3 - 1 / 60)
    assert warp.name == "jump"


def test_several_keys_are_all_met_by_every_method(run, clips, tmp_path) -> None:
    for method in ("guided", "linear", "spline"):
        run("warp", clips.bvh, "--key", "1=1.2", "--key", "3=2.4", "--method", method, "--save", f"{method}.json")
        warp = read_warp(tmp_path / f"{method}.json")
        assert warp.method == method
        np.testing.assert_allclose(warp([1.2, 2.4]), [1.0, 3.0], atol=1e-12)
    straight, spline = read_warp(tmp_path / "linear.json"), read_warp(tmp_path / "spline.json")
    assert len(straight.slopes) == 3
    assert len(spline.slopes) > 100


@pytest.mark.parametrize(
    ("options", "changed"),
    [
        (["--rate", "15"], {"rate": 15.0, "n_input": 241, "n_output": 40}),
        (["--max-skip", "3"], {"max_skip": 3, "upsample": 1}),
        (["--evenness", "0"], {}),
        (["--content", "2"], {}),
        (["--ends", "0.2"], {}),
        (["--own-timing", "0.5"], {}),
        (["--keep-flights", "0", "--evenness", "1"], {}),
        (["--paper"], {"max_skip": 8, "upsample": 1, "n_input": 121}),
        (["--upsample", "2"], {"upsample": 2, "n_input": 241}),
        (["--neighbors", "1"], {"n_neighbors": 1}),
        (["--time-scale", "0.5"], {}),
        (["--low-pass", "0"], {}),
        (["--features", "torso"], {}),
        (["--reference", "{clip}", "--reference-frames", "0:99"], {"n_reference": 50, "upsample": 8}),
        (["--reference", "{clip}", "--reference-fps", "120"], {"n_reference": 61, "upsample": 8}),
        (["--reference", "{clip}", "--reference-fps", "120", "--match-tempo"], {"n_reference": 61, "upsample": 8}),
    ],
)
def test_an_option_of_the_search_changes_the_search(run, clips, options, changed) -> None:
    plain = found(run, clips.bvh, "--length", "65%")
    other = found(run, clips.bvh, "--length", "65%", *(option.format(clip=clips.bvh) for option in options))
    assert {name: other[name] for name in changed} == changed
    assert other["total"] != plain["total"]


def test_max_skip_bounds_the_steps(run, clips) -> None:
    assert max(np.diff(found(run, clips.bvh, "--length", "65%", "--max-skip", "3")["path"])) == 3


def test_smoothing_0_leaves_the_steps_of_the_path(run, clips, tmp_path) -> None:
    run("warp", clips.bvh, "--length", "65%", "--save", "smooth.json")
    run("warp", clips.bvh, "--length", "65%", "--smoothing", "0", "--save", "steps.json")
    smooth, steps = read_warp(tmp_path / "smooth.json"), read_warp(tmp_path / "steps.json")
    assert np.abs(np.diff(steps.slopes)).max() > 1.5 * np.abs(np.diff(smooth.slopes)).max()


def test_features_of_a_signal(run, clips, tmp_path) -> None:
    document = found(run, clips.csv, "--length", "80%", "--features", "signal", "-o", "short.csv")
    assert (document["n_input"], document["output_frames"]) == (60, 48)
    assert read(tmp_path / "short.csv").names == ("pan", "tilt")
    assert "flights" not in run("warp", clips.csv, "--length", "80%").stdout


def test_without_average_poses_come_straight_from_the_input(run, clips, tmp_path) -> None:
    run("warp", clips.bvh, "--length", "120f", "--method", "linear", "-o", "average.bvh")
    run("warp", clips.bvh, "--length", "120f", "--method", "linear", "-o", "straight.bvh", "--no-average")
    motion = read(clips.bvh)
    straight, average = read(tmp_path / "straight.bvh"), read(tmp_path / "average.bvh")
    picked = motion.at(np.arange(120) * motion.end_time / 119)
    np.testing.assert_allclose(straight.local_translations, picked.local_translations, atol=1e-5)
    assert np.abs(average.rotations - straight.rotations).max() > 1e-3


def test_a_reference_lends_its_timing(run, clips, tmp_path) -> None:
    # The same walk, slowed to two thirds over its first 1.5 s; what it should do is play the input at that speed.
    slow = figure("slow", seconds=5.0, swing=0.8)
    write(slow, tmp_path / "slow.bvh")
    document = found(
        run, clips.bvh, "--frames", "0:89", "--reference", "slow.bvh", "--reference-frames", "0:89",
        "--length", "135f", "--save", "warp.json",
    )  # fmt: skip
    assert document["references"] == ["slow.bvh"]
    assert document["n_reference"] == 45
    assert np.median(read_warp(tmp_path / "warp.json").slopes) == pytest.approx(2 / 3, abs=0.1)


def test_skeleton_names_the_asf_of_an_amc(run, clips, tmp_path) -> None:
    write(read(clips.bvh), tmp_path / "jump.amc")
    (tmp_path / "asf").mkdir()
    (tmp_path / "jump.asf").rename(tmp_path / "asf" / "elsewhere.asf")
    assert "asf" in run("warp", "jump.amc", "--fps", "60", "--length", "65%", code=1).stderr
    document = found(run, tmp_path / "jump.amc", "--fps", "60", "--length", "65%", "--skeleton", "asf/elsewhere.asf")
    assert document["input_frames"] == 241


def test_decimal_comma(run, tmp_path) -> None:
    (tmp_path / "comma.csv").write_text("x;y\n" + "".join(f"{i};{i % 7},5\n" for i in range(40)))
    assert "decimal" in run("warp", "comma.csv", "--fps", "30", "--length", "80%", code=1).stderr
    assert found(run, Path("comma.csv"), "--fps", "30", "--length", "80%", "--decimal-comma")["input_frames"] == 40


def test_repair_keeps_what_is_whole_and_warns(run, clips, tmp_path) -> None:
    whole = clips.bvh.read_text()
    (tmp_path / "cut.bvh").write_text(whole[: whole.rindex("\n", 0, len(whole) * 3 // 4) + 20])
    assert run("warp", "cut.bvh", "--length", "80%", code=1).stderr.startswith("error: cut.bvh:")
    result = run("warp", "cut.bvh", "--length", "80%", "--repair", "--json")
    assert 100 < json.loads(result.stdout)["input_frames"] < 200
    assert result.stderr.startswith("warning: cut.bvh")
    assert result.stderr.count("\n") == 1


def test_quiet_prints_nothing(run, clips, tmp_path) -> None:
    result = run("warp", clips.bvh, "--length", "80%", "-q", "-o", "out.bvh")
    assert result.output == ""
    assert (tmp_path / "out.bvh").exists()


def test_plot_compares_with_the_baselines(run, clips, tmp_path) -> None:
    run("warp", clips.bvh, "--length", "65%", "--plot", "two.svg")
    run("warp", clips.bvh, "--length", "65%", "--key", "2=1.4", "--plot", "three.svg")
    two, three = ((tmp_path / name).read_text() for name in ("two.svg", "three.svg"))
    assert "guided" in two
    assert "linear" in two
    assert "spline" not in two
    assert "spline" in three


def test_the_written_motion_is_what_the_library_gives(run, clips, tmp_path) -> None:
    from retime import apply_warp, guided_warp

    run("warp", clips.bvh, "--length", "65%", "-o", "out.bvh")
    motion = read(clips.bvh)
    write(apply_warp(motion, guided_warp(motion, length="65%").warp), tmp_path / "library.bvh")
    assert (tmp_path / "out.bvh").read_bytes() == (tmp_path / "library.bvh").read_bytes()


def test_the_same_command_writes_the_same_bytes(run, clips, tmp_path) -> None:
    for name in ("a", "b"):
        run("warp", clips.bvh, "--length", "65%", "-o", f"{name}.bvh", "--save", f"{name}.json")
    assert (tmp_path / "a.bvh").read_bytes() == (tmp_path / "b.bvh").read_bytes()
    assert (tmp_path / "a.json").read_bytes() == (tmp_path / "b.json").read_bytes()


def test_help_says_the_default_of_every_option(run) -> None:
    help_text = " ".join(run("warp", "--help").stdout.split())
    for option in OPTIONS:
        assert option.on_command_line in help_text
        if option.kind != "flag" and option.usual != "none" and option.name != "length":
            assert f"{option.help} [default: {option.default_words}]" in help_text
    assert "[default: as the input]" in help_text


@pytest.mark.parametrize(
    ("options", "says"),
    [
        (["--length", "fast"], "--length"),
        (["--length", "0.01s"], "at least 2"),
        (["--length", "1f"], "at least 2"),
        (["--length", "999999999999f"], "no output is longer than"),
        (["--rate", "12000", "--max-skip", "255"], "sees no more of a clip at 60 Hz than one at 240 Hz"),
        (["--length", "-5%"], "--length"),
        (["--key", "2.5"], "--key"),
        (["--key", "1=-1"], "--key"),
        (["--key", "=2"], "--key"),
        (["--key", "1=99"], "beyond the output's last frame"),
        (["--rate", "0"], "--rate"),
        (["--fps", "abc"], "--fps"),
        (["--max-skip", "0"], "--max-skip"),
        (["--max-skip", "256"], "--max-skip"),
        (["--features", "signal"], "'torso' or 'heading'"),
        (["--features", "nose"], "--features"),
        (["--frames", "1-10"], "1:1980"),
        (["--frames", "0:241"], "0:240"),
        (["--drop-first", "241"], "--drop-first 241 leaves nothing"),
        (["--neighbors", "200"], "n_neighbors=200"),
        (["--time-scale", "nan"], "a plain number of at least 0"),
        (["--time-scale", "1e300"], "a plain number of at least 0"),
        (["--low-pass", "-1"], "--low-pass"),
        (["--method", "linear", "--max-skip", "4", "--neighbors", "2"], "--max-skip, --neighbors would have no effect"),
        (["--method", "spline", "--reference", "x.bvh"], "--reference would have no effect"),
        (["--reference-frames", "1:2"], "needs at least 5"),
        (["--reference-frames", "0:99", "--method", "linear"], "--reference-frames would have no effect"),
        (["--reference-fps", "30"], "--reference-fps needs --reference"),
        (["--plot", "warp.gif"], ".svg or .pdf or .png"),
        (["--lenght", "65%"], "--length"),
        (["--flight", "2..1"], "a span begins before it ends"),
        (["--no-flight", "soon"], "expected a span of input time"),
        (["--flight", "1..99"], "is no stretch of the clip"),
        (["--flight", "1..2", "--method", "linear"], "--flight would have no effect"),
        (["--no-flight", "1..2", "--variants", "2"], "can't be combined with --variants"),
    ],
)
def test_wrong_options_are_named(run, clips, options, says) -> None:
    length = [] if "--length" in options else ["--length", "65%"]
    result = run("warp", clips.bvh, *length, *options, code=2)
    assert result.stderr.startswith("error: ")
    assert says in result.stderr
    assert result.stdout == ""


def test_an_infeasible_warp_says_what_would_do(run, clips) -> None:
    result = run("warp", clips.bvh, "--length", "10%", "--max-skip", "4", code=3)
    assert result.stderr.startswith("error: cannot fit")
    assert "max_skip >= " in result.stderr


def test_a_motion_can_not_imitate_a_signal(run, clips) -> None:
    error = run("warp", clips.bvh, "--reference", clips.csv, "--length", "80%", code=2).stderr
    assert "jump is a motion, camera is a signal" in error
    write(curve("other"), Path("other.npz"))
    assert run("warp", clips.csv, "--reference", "other.npz", "--length", "80%").exit_code == 0


def test_flights_are_put_right(run, clips, tmp_path) -> None:
    clip = read(clips.bvh)
    found = [(first / float(clip.rate), last / float(clip.rate)) for first, last in clip.flights()]
    corrections = {
        ("--no-flight", f"{found[0][0]!r}..{found[0][1]!r}"): found[1:],
        ("--flight", "0.2..30f"): [(0.2, 0.5), *found],
    }
    for options, flights in corrections.items():
        run("warp", clips.bvh, "--length", "60%", *options, "--save", "warp.json", "--force", "-q")
        expected = retime.guided_warp(clip, length="60%", flights=flights).warp
        np.testing.assert_array_equal(read_warp(tmp_path / "warp.json").input_times, expected.input_times)
        assert not np.array_equal(expected.input_times, retime.guided_warp(clip, length="60%").warp.input_times)
