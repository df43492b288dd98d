"""`retime warp`: what shapes the timing beyond keytimes shows in the warp that is saved."""

from __future__ import annotations

import csv
import json
from dataclasses import replace

import numpy as np
import pytest

from retime import Warp, read, read_warp, write
from tests.cli.figures import curve


@pytest.fixture
def saved(run, clips, tmp_path):
    """Search on the short curve, and return the saved warp."""

    def call(*options: str) -> Warp:
        run("warp", clips.csv, *options, "--save", "warp.json", "--force", "-q")
        return read_warp(tmp_path / "warp.json")

    return call


@pytest.fixture
def told(run, clips):
    """Search on the short curve, and return what --json says."""

    def call(*options: str) -> dict:
        return json.loads(run("warp", clips.csv, *options, "--json").stdout)

    return call


def slopes_in(warp: Warp, start: float, end: float) -> np.ndarray:
    """Speeds of the pieces that lie in a span of input time."""
    low, high = np.sort([warp.input_times[:-1], warp.input_times[1:]], axis=0)
    inside = (low >= start - 1e-9) & (high <= end + 1e-9)
    assert inside.any()
    return warp.slopes[inside]


@pytest.mark.parametrize(
    "options",
    [
        ("--length", "1.6", "--key", "1=0.75"),
        ("--length", "0:01.6", "--key", "0:01=0:00.75"),
        ("--length", "00:00:01:18", "--key", "00:00:01:00 = 22.5f"),
        ("--length", "48F", "--key", "30f=22.5f", "--time-scale", "0.2s", "--low-pass", "4 Hz"),
    ],
)
def test_a_time_says_the_same_in_every_form(saved, options) -> None:
    plain = saved("--length", "1.6s", "--key", "1s=0.75s")
    warp = saved(*options)
    np.testing.assert_array_equal(warp.output_times, plain.output_times)
    np.testing.assert_array_equal(warp.input_times, plain.input_times)


@pytest.mark.parametrize(("lock", "slowest", "fastest"), [("0.5..1=1/2", 0.5, 0.5), ("15f..30f=1/2..1", 0.5, 1)])
def test_a_locked_span_plays_at_its_speed(saved, lock, slowest, fastest) -> None:
    plain, locked = saved("--length", "80%"), saved("--length", "80%", "--lock", lock)
    assert slopes_in(plain, 0.5, 1).max() > 1.01
    speeds = slopes_in(locked, 0.5, 1)
    assert slowest - 1e-6 <= speeds.min() <= speeds.max() <= fastest + 1e-6


def test_a_kept_span_is_slowed_down_at_most(saved) -> None:
    assert slopes_in(saved("--length", "80%", "--keep", "0.5..1"), 0.5, 1).max() <= 1 + 1e-6


def test_speed_limits_hold_and_set_the_steps(saved, told) -> None:
    speeds = saved("--length", "100%", "--key", "1=0.8", "--speed", "1/2..2").slopes
    assert 0.5 - 1e-6 <= speeds.min() <= speeds.max() <= 2 + 1e-6
    document = told("--length", "100%", "--key", "1=0.8", "--speed", "1/2..2")
    assert document["max_skip"] == 2 * document["upsample"]


def test_a_key_has_the_speed_that_it_was_given(saved) -> None:
    warp = saved("--length", "80%", "--key", "1=0.8@1/2")
    np.testing.assert_allclose(warp.speed([0.799, 0.801]), 0.5, atol=1e-6)
    assert float(warp(0.8)) == pytest.approx(1.0, abs=1e-12)


def test_equal_input_times_hold_and_decreasing_ones_run_backward(saved) -> None:
    hold = saved("--length", "120%", "--key", "1=0.8", "--key", "1=1.2")
    np.testing.assert_allclose(hold([0.8, 1.0, 1.2]), 1.0, atol=1e-12)
    back = saved("--length", "150%", "--key", "1.2=1", "--key", "0.8=1.4")
    np.testing.assert_allclose(back([1.0, 1.4]), [1.2, 0.8], atol=1e-12)
    assert back.slopes[(back.output_times[:-1] > 1.05) & (back.output_times[1:] < 1.35)].max() < 0


def test_smoothness_evens_the_speeds_out(told) -> None:
    def changes(document: dict) -> float:
        return float(np.abs(np.diff(np.log(np.diff(document["path"])))).sum())

    assert changes(told("--length", "80%", "--smoothness", "5")) < 0.5 * changes(told("--length", "80%"))


def test_influence_goes_from_the_spline_to_the_guided_warp(saved) -> None:
    keys = ("--length", "80%", "--key", "1=0.9")
    times = np.linspace(0, 1.55, 50)
    spline, guided = saved(*keys, "--method", "spline")(times), saved(*keys)(times)
    assert np.abs(guided - spline).max() > 0.02
    np.testing.assert_allclose(saved(*keys, "--influence", "0")(times), spline, atol=1e-6)
    half = saved(*keys, "--influence", "0.5")(times)
    np.testing.assert_allclose(half, (spline + guided) / 2, atol=0.01)
    early = saved(*keys, "--influence", "0s=0,0.5s=0,1s=1")(times)
    np.testing.assert_allclose(early[times < 0.4], spline[times < 0.4], atol=1e-6)
    np.testing.assert_allclose(early[times > 1.1], guided[times > 1.1], atol=1e-6)


def test_a_loop_has_one_speed_at_both_ends(saved) -> None:
    plain, loop = saved("--length", "80%"), saved("--length", "80%", "--loop")
    assert abs(plain.slopes[0] - plain.slopes[-1]) > 0.01
    assert loop.slopes[0] == pytest.approx(loop.slopes[-1], abs=1e-6)


def test_a_free_length_obeys_its_bounds(told) -> None:
    free = told("--length", "free")["output_frames"]
    short = told("--length", "free", "--max-length", "50%")["output_frames"]
    long = told("--length", "free", "--min-length", "75f", "--max-length", "3s")["output_frames"]
    assert short <= 30 < free
    assert 75 <= long <= 90
    # With a short time scale the plain sum has every reason to hurry.
    neutral, plain = (
        told("--length", "free", "--time-scale", "0.03", "--free-weight", weight)["output_frames"]
        for weight in ("neutral", "sum")
    )
    assert plain < neutral


@pytest.mark.parametrize(
    "options",
    [("--score", "conditional"), ("--joints", "pan"), ("--joint-weight", "tilt=3"), ("--joints", "tilt, pan")],
)
def test_what_is_looked_at_changes_the_scores(told, options) -> None:
    same = options == ("--joints", "tilt, pan")
    assert (told("--length", "80%", *options)["total"] == pytest.approx(told("--length", "80%")["total"])) == same


def test_exact_searches_agree_and_the_heuristic_says_its_excess(run, clips, told) -> None:
    exact, layered, heuristic = (
        told("--length", "80%", "--search", name) for name in ("priced", "layered", "heuristic")
    )
    assert exact["total"] == pytest.approx(layered["total"])
    assert (exact["excess"], exact["optimal"]) == (None, True)
    assert heuristic["total"] == pytest.approx(exact["total"] * (1 + heuristic["excess"]))
    lines = run("warp", clips.csv, "--length", "80%", "--search", "heuristic").stdout.splitlines()
    assert f"excess  {heuristic['excess']:.2%} over the optimum (heuristic search)" in lines


def test_the_explanation_has_a_row_for_each_output_frame(run, clips, tmp_path) -> None:
    options = ("--length", "80%", "--key", "1=0.8", "--lock", "0.2..0.5=1/2", "--explain", "why.csv", "--json")
    document = json.loads(run("warp", clips.csv, *options).stdout)
    assert document["explain"] == "why.csv"
    with (tmp_path / "why.csv").open(newline="") as file:
        rows = list(csv.DictReader(file))
    assert len(rows) == document["n_output"]
    assert rows[0]["binding"] == "key"
    assert [float(row["input_time"]) for row in rows if "key" in row["binding"]][1] == pytest.approx(1.0)
    locked = [float(row["speed"]) for row in rows if row["binding"] == "lock"]
    assert len(locked) > 3
    assert locked[1] == 0.5
    assert sum(float(row["cost"]) for row in rows if row["cost"]) == pytest.approx(document["total"], rel=1e-4)
    assert {row["reference_1"] for row in rows[1:-1]} == {"camera"}


def test_other_clips_get_the_same_warp_and_a_group_is_searched_together(run, clips, tmp_path) -> None:
    other = replace(curve("prop"), values=curve().values[::-1] ** 2)
    write(other, tmp_path / "prop.csv")
    common = ("--length", "80%", "--also", "prop.csv=prop_out.csv", "--json", "--force")
    alone = json.loads(run("warp", clips.csv, *common, "-o", "alone.csv").stdout)
    assert alone["also"] == ["prop_out.csv"]
    first = read(tmp_path / "prop_out.csv").values
    assert len(first) == read(tmp_path / "alone.csv").n_frames == 48
    together = json.loads(run("warp", clips.csv, *common, "--group").stdout)
    assert together["path"] != alone["path"]
    assert np.abs(read(tmp_path / "prop_out.csv").values - first).max() > 1e-3


def test_a_mirrored_reference_is_seen_both_ways(run, clips) -> None:
    options = ("--frames", "0:89", "--length", "90%", "--json")
    plain, both = (json.loads(run("warp", clips.bvh, *options, *mirror).stdout) for mirror in ((), ("--mirror",)))
    assert both["n_reference"] == 2 * plain["n_reference"]
    assert both["total"] <= plain["total"] + 1e-9


def test_several_references_have_weights_frames_and_a_map(run, clips, tmp_path) -> None:
    renamed = replace(curve("other", first=0.3), names=("yaw", "pitch"))
    write(renamed, tmp_path / "other.csv")
    (tmp_path / "map.json").write_text('{"pan": "yaw", "tilt": "pitch"}')
    write(replace(renamed, values=renamed.values[::-1]), tmp_path / "reverse.csv")
    two = ("--reference", "other.csv", "--reference", "reverse.csv", "--length", "80%", "--json")
    assert "yaw" in run("warp", clips.csv, *two, code=2).stderr
    mapped = (*two, "--joint-map", "map.json")
    plain = json.loads(run("warp", clips.csv, *mapped).stdout)
    assert plain["references"] == ["other.csv", "reverse.csv"]
    assert plain["n_reference"] == 120
    weights = ("--reference-weight", "1", "--reference-weight", "3")
    assert json.loads(run("warp", clips.csv, *mapped, *weights).stdout)["total"] != pytest.approx(plain["total"])
    frames = ("--reference-frames", "0:29", "--reference-frames", "10:19")
    assert json.loads(run("warp", clips.csv, *mapped, *frames).stdout)["n_reference"] == 40


def test_each_reference_may_have_a_map_of_its_own(run, clips, tmp_path) -> None:
    plain, other = curve("plain", first=0.1), replace(curve("other", first=0.3), names=("yaw", "pitch"))
    third = replace(curve("third", first=0.5), names=("a", "b"))
    for clip in (plain, other, third):
        write(clip, tmp_path / f"{clip.name}.csv")
    (tmp_path / "yaw.json").write_text('{"pan": "yaw", "tilt": "pitch"}')
    (tmp_path / "ab.csv").write_text("pan,a\ntilt,b\n")
    three = ("--reference", "plain.csv", "--reference", "other.csv", "--reference", "third.csv", "--length", "80%")
    maps = ("--joint-map", "-", "--joint-map", "yaw.json", "--joint-map", "ab.csv")
    mapped = json.loads(run("warp", clips.csv, *three, *maps, "--json").stdout)
    # The same as with names that need no map.
    for clip in (other, third):
        write(replace(clip, names=plain.names), tmp_path / f"{clip.name}.csv", overwrite=True)
    named = json.loads(run("warp", clips.csv, *three, "--json").stdout)
    assert (mapped["path"], mapped["total"]) == (named["path"], named["total"])
    error = run("warp", clips.csv, *three, *maps[:4], code=2).stderr
    assert "--joint-map is given 2 times, for 3 references" in error
    assert "- where names say it" in error


def test_frames_of_the_clip_itself_can_be_the_reference(told) -> None:
    assert told("--length", "80%", "--reference-frames", "10:39")["n_reference"] == 30


@pytest.mark.parametrize(
    ("options", "says"),
    [
        (["--lock", "1"], "2.1..3.4"),
        (["--lock", "1..0.5"], "a span begins before it ends"),
        (["--lock", "0.5..9"], "lock"),
        (["--lock", "0..1=0"], "playback speed"),
        (["--keep", "a..b"], "--keep"),
        (["--speed", "2..1"], "slowest first"),
        (["--speed", "fast"], "--speed"),
        (["--smoothness", "-1"], "--smoothness"),
        (["--influence", "2"], "from 0 to 1"),
        (["--influence", "0s=0,x=1"], "--influence"),
        (["--score", "best"], "--score"),
        (["--search", "quick"], "--search"),
        (["--search", "heuristic", "--loop"], "heuristic"),
        (["--length", "free", "--search", "heuristic"], "given length"),
        (["--min-length", "50%"], "free length"),
        (["--length", "free", "--min-length", "80%", "--max-length", "50%"], "more than the most"),
        (["--length", "free", "--method", "linear"], "needs a search"),
        (["--joints", "nose"], "nose"),
        (["--joint-weight", "pan"], "LeftHand=2"),
        (["--joint-weight", "pan=-1"], "a plain number of at least 0"),
        (["--key", "1=0.8@0"], "playback speed"),
        (["--mirror"], "mirror"),
        (["--joint-map", "x.json"], "--joint-map needs --reference"),
        (["--reference-weight", "2"], "--reference-weight needs --reference"),
        (["--reference", "{clip}", "--reference-weight", "0"], "above 0"),
        (["--reference", "{clip}", "--reference-weight", "1", "--reference-weight", "2"], "given 2 times, for 1"),
        (["--group"], "--also CLIP=OUT"),
        (["--also", "camera.csv"], "camera_retimed.csv"),
        (["--also", "{clip}=out.csv", "--group", "--reference", "{clip}"], "can't be combined"),
        (["--method", "spline", "--lock", "0..1", "--loop", "--explain", "x.csv"], "--explain, --loop, --lock would"),
    ],
)
def test_bad_combinations_are_refused_clearly(run, clips, options, says) -> None:
    length = [] if "--length" in options else ["--length", "80%"]
    result = run("warp", clips.csv, *length, *(option.format(clip=clips.csv) for option in options), code=2)
    assert result.stderr.startswith("error: ")
    assert says in result.stderr
    assert result.stdout == ""


def test_an_explanation_is_not_written_over_the_clip(run, clips) -> None:
    result = run("warp", clips.csv, "--length", "80%", "--explain", clips.csv, "--force", code=2)
    assert "never overwritten" in result.stderr
