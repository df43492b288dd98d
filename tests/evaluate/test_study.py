"""The study: warps by hand, baselines, known answers, tables, and the page; and its promises on real captures."""

from __future__ import annotations

import base64
import itertools
import json
import math
import re
from fractions import Fraction
from pathlib import Path

import numpy as np
import pytest

from retime.errors import InfeasibleWarpError, OptionError
from retime.evaluate.metrics import flight_spans, flight_timing, match_warps, path_warp
from retime.evaluate.sensitivity import CHOSEN, Imitated, Preserved, Row, Setting, measure, row_of, settings
from retime.evaluate.study import EVALUATIONS, PAPER, v5, v8
from retime.evaluate.study_answers import answer_all
from retime.evaluate.study_baselines import (
    align,
    align_warp,
    cut_idle,
    keyed_spline,
    spans_to_keep,
    spline_through,
)
from retime.evaluate.study_choices import AS_PRINTED, SETTINGS
from retime.evaluate.study_figures import simplified
from retime.evaluate.study_motions import (
    ANSWERS,
    SOURCES,
    Library,
    example_of,
    fast_spans,
    from_log_speed,
    limp,
    part_of,
    read_sample,
    slow_flights,
    steps,
    walking_spans,
)
from retime.evaluate.study_player import camera_player_html, player_data, player_html, player_script
from retime.evaluate.study_prototype import ACROSS, compare
from retime.evaluate.study_report import numbers, write_study
from retime.evaluate.study_run import PARTS, Results, chosen_parts, run
from retime.evaluate.study_signals import bouncing_ball, falls, warp_camera, warp_curve, warp_signal
from retime.evaluate.study_tables import Table, losses_table, number, plain, sensitivity_table, text_values
from retime.motion.signal import Signal
from retime.warp.curve import Warp
from retime.warp.session import Session
from tests.evaluate.figures import jumper

ROOT = Path(__file__).resolve().parents[2]
SAMPLE = read_sample()


@pytest.fixture(scope="module")
def captures(mocap: Path) -> Library:
    return Library(mocap)


def test_a_part_of_a_warp_does_what_the_whole_does() -> None:
    whole = Warp([0.0, 1.0, 3.0, 4.0], [0.0, 2.0, 3.0, 4.0])
    part = part_of(whole, 1.0, 3.5)
    assert (part.input_times[0], part.input_times[-1]) == (0.0, 2.5)
    times = np.linspace(0.0, part.output_end, 50)
    assert part(times) == pytest.approx(whole(times + 0.5) - 1.0)


def test_a_log_speed_is_played_as_such() -> None:
    warp = from_log_speed(np.full(SAMPLE.n_frames, math.log(2.0)), SAMPLE)
    assert warp.output_span == pytest.approx(SAMPLE.end_time / 2)


def test_slowed_flights_play_at_half_speed_and_the_rest_as_it_was() -> None:
    warp = slow_flights(SAMPLE)
    spans = flight_spans(SAMPLE)
    assert len(spans) == 2
    for start, end in spans:
        inside = warp.inverse()(np.array([start + 0.02, end - 0.02]))
        assert (end - start - 0.04) / (inside[1] - inside[0]) == pytest.approx(0.5, rel=1e-3)
    assert warp.slopes[:30] == pytest.approx(np.ones(30))


def test_steps_of_a_walk_alternate() -> None:
    for start, end in walking_spans(SAMPLE):
        sides = [step.side for step in steps(SAMPLE) if start - 1e-9 <= step.time <= end + 1e-9]
        assert all(a != b for a, b in itertools.pairwise(sides))
        assert len(sides) >= 3


def test_a_limp_hurries_one_step_and_lingers_over_the_next() -> None:
    warp = limp(SAMPLE)
    start, end = walking_spans(SAMPLE)[0]
    inside = warp.slopes[(warp.input_times[:-1] > start) & (warp.input_times[1:] < end)]
    assert inside.max() == pytest.approx(1.7, rel=0.02)
    assert inside.min() == pytest.approx(1 / 1.7, rel=0.02)


def test_an_example_is_the_stretch_with_the_answers_timing() -> None:
    truth = slow_flights(SAMPLE)
    start, end = flight_spans(SAMPLE)[0]
    stretch = example_of(SAMPLE, truth, start, end)
    assert stretch.end_time == pytest.approx(2 * (end - start), rel=0.02)


def test_cutting_keeps_what_moves() -> None:
    motion = jumper(lead=1.0, rest=1.0)
    warp = cut_idle(motion, motion.n_frames - 40)
    ((start, end),) = flight_spans(motion)
    assert flight_timing(warp, [(start, end)]).n_kept == flight_timing(warp, [(start, end)]).n_frames
    assert (warp.input_times[0], warp.input_times[-1]) == (0.0, motion.end_time)
    assert warp.output_span == pytest.approx((motion.n_frames - 41) / 60)
    with pytest.raises(InfeasibleWarpError, match="asked for 1000"):
        cut_idle(motion, 1000)


def test_a_keyed_spline_keeps_the_duration_of_what_it_is_keyed_for() -> None:
    motion = jumper(lead=1.0, rest=1.0)
    keep = spans_to_keep(motion, [(1.1, 1.4)])
    warp = keyed_spline(motion, keep, 1.8)
    back = warp.inverse()
    assert float(back(keep[0][1]) - back(keep[0][0])) == pytest.approx(0.5)
    assert warp.output_end == pytest.approx(1.8)
    with pytest.raises(InfeasibleWarpError, match="to be kept"):
        keyed_spline(motion, keep, 0.4)


def test_a_keyed_spline_may_play_what_it_is_keyed_for_at_another_speed() -> None:
    motion = jumper(lead=1.0, rest=1.0)
    warp = keyed_spline(motion, [(1.0, 1.5)], 3.0, speed=0.5)
    back = warp.inverse()
    assert float(back(1.5) - back(1.0)) == pytest.approx(1.0)
    assert warp.output_end == pytest.approx(3.0)


def test_a_spline_through_a_known_answer_meets_it_where_it_is_keyed() -> None:
    truth = slow_flights(SAMPLE)
    warp = spline_through(truth, [0.0, 3.0, 6.0, 99.0], rate=60.0)
    assert [key.input_time for key in warp.keytimes] == [0.0, 3.0, 6.0, SAMPLE.end_time]
    assert warp.inverse()(6.0) == pytest.approx(float(truth.inverse()(6.0)), abs=1e-6)
    assert warp.output_end == pytest.approx(truth.output_end)


def test_blows_are_where_a_joint_is_fastest() -> None:
    motion = jumper(lead=1.0, rest=1.0)
    feet = [name for name in motion.skeleton.names if "Foot" in name]
    # A thrown body is fastest when it leaves the ground and when it meets it again, after half a second.
    (up, slower), (faster, down) = fast_spans(motion, feet)
    assert (up, down) == pytest.approx((1.0, 1.5), abs=0.04)
    assert slower - up == pytest.approx(down - faster, abs=0.02)
    assert slower - up + down - faster == pytest.approx(0.15 * motion.end_time, abs=0.04)


def test_a_simplified_curve_is_near_the_curve_and_keeps_its_ends_and_gaps() -> None:
    x = np.linspace(0.0, 10.0, 4001)
    y = np.exp(np.sin(3 * x))
    y[2000:2010] = np.nan
    few_x, few_y = simplified(x, y, reach=10.0)
    assert len(few_x) < 400
    assert (few_x[0], few_x[-1]) == (0.0, 10.0)
    assert np.isnan(few_y).any()
    for part in (slice(0, 2000), slice(2010, 4001)):
        there = (few_x >= x[part][0]) & (few_x <= x[part][-1]) & ~np.isnan(few_y)
        again = np.interp(x[part], few_x[there], np.log10(few_y[there]))
        assert np.abs(again - np.log10(y[part])).max() < 0.06


def test_stretches_that_meet_are_one() -> None:
    motion = jumper(lead=1.0, rest=1.0)
    assert spans_to_keep(motion, [(0.05, 0.5), (0.65, 0.9)], margin=0.1) == ((0.0, pytest.approx(1.0)),)


def every_path(n: int, m: int) -> list[list[tuple[int, int]]]:
    """List all alignments of n frames with m by walking all of them."""
    found: list[list[tuple[int, int]]] = []
    walks = [[(0, 0)]]
    while walks:
        walk = walks.pop()
        i, j = walk[-1]
        if (i, j) == (n - 1, m - 1):
            found.append(walk)
        for a, b in ((1, 0), (0, 1), (1, 1)):
            if i + a < n and j + b < m:
                walks.append([*walk, (i + a, j + b)])
    return found


@pytest.mark.parametrize("seed", range(6))
def test_an_alignment_is_the_best_of_all(seed: int) -> None:
    generator = np.random.default_rng(seed)
    here, there = generator.normal(size=(5, 2)), generator.normal(size=(4, 2))

    def cost(path: list[tuple[int, int]]) -> float:
        return sum(float(np.linalg.norm(here[i] - there[j])) for i, j in path)

    best = min(map(cost, every_path(5, 4)))
    assert cost([(int(i), int(j)) for i, j in align(here, there)]) == pytest.approx(best)


def test_an_alignment_may_begin_and_end_anywhere_in_the_other() -> None:
    there = np.array([[9.0], [1.0], [2.0], [9.0]])
    assert align(np.array([[1.0], [2.0]]), there, anywhere=True).tolist() == [[0, 1], [1, 2]]


def test_aligned_with_itself_a_motion_keeps_its_timing() -> None:
    found = align_warp(SAMPLE, SAMPLE)
    assert match_warps(found, Warp([0.0, SAMPLE.end_time], [0.0, SAMPLE.end_time])).largest_error < 1.0


def test_a_ball_falls_as_made_and_keeps_its_flights_when_guided() -> None:
    ball, spans = bouncing_ball()
    same = Warp([0.0, ball.end_time], [0.0, ball.end_time])
    assert falls(ball, same, spans) == pytest.approx(np.ones(len(spans)))
    result = warp_signal()
    assert result.timing.n_kept == result.timing.n_frames > 0
    assert result.linear_timing.n_kept == 0
    assert result.linear_gravity == pytest.approx((ball.end_time / result.linear.output_span) ** 2, rel=0.02)


def test_one_warp_keeps_a_camera_on_its_figure() -> None:
    result = warp_camera(SAMPLE, Warp([0.0, SAMPLE.end_time * 0.7], [0.0, SAMPLE.end_time]))
    assert result.before < 1e-6
    assert result.together < 1.0 < result.motion_alone


def test_one_warp_keeps_a_curve_on_its_figure() -> None:
    warp = Warp([0.0, SAMPLE.end_time * 0.7], [0.0, SAMPLE.end_time])
    result = warp_curve(SAMPLE, warp)
    assert result.together < 0.01 < 0.1 < result.motion_alone
    assert (result.n_input, result.n_output) == (680, 476)


def test_a_player_looks_through_the_camera() -> None:
    result = warp_camera(SAMPLE, Warp([0.0, SAMPLE.end_time * 0.7], [0.0, SAMPLE.end_time]))
    (text,) = re.findall(r'<script type="application/json">(.*?)</script>', camera_player_html(result), flags=re.DOTALL)
    data = json.loads(text)
    along, left = (np.array(one["camera"]) for one in data["versions"])
    assert along.shape == left.shape == (data["versions"][0]["count"], 6)
    assert np.linalg.norm(along[:, :3] - along[:, 3:], axis=1) == pytest.approx(np.full(len(along), 4.12), abs=0.01)
    assert np.abs(along[-1] - left[-1]).max() > 0.2


def test_parts_are_chosen_by_name_in_the_studys_order() -> None:
    assert chosen_parts(None) == PARTS
    assert chosen_parts("signals, v4,V1") == ("V1", "V4", "signals")
    with pytest.raises(OptionError, match="no part 'V9'; it has V1, V2"):
        chosen_parts("V1,V9")
    with pytest.raises(OptionError, match="no part of the study is named"):
        chosen_parts(" , ")


def row(label: str, kept: int, ratio: float) -> Row:
    return Row(
        Setting(label, label),
        (Preserved("clip", "65%", 10, kept, 4, min(kept, 4)),),
        (Imitated("case", "limp", "neutral", 0.9, 0.1, 1.0, ratio),),
    )


def test_means_over_cases_count_what_could_not_be_had_as_nothing() -> None:
    one = row(CHOSEN, 4, 1.1)
    assert one.kept() == (4, 10)
    assert row(CHOSEN, 9, 1.0).kept_high("65%") == (4, 4)
    assert row(CHOSEN, 9, 1.0).kept_high("80%") == (0, 0)
    assert one.mean("length_ratio") == pytest.approx(100 * math.log(1.1))
    assert math.isnan(one.mean("correlation", kind="boxing"))
    lost = Row(one.setting, (), (Imitated("case", "limp", "given", math.nan, 0.1, 1.0, 1.0),))
    assert lost.mean("correlation") == 0.0


def test_a_length_and_its_inverse_are_equally_far_off() -> None:
    assert row("a", 1, 2.0).mean("length_ratio") == pytest.approx(row("a", 1, 0.5).mean("length_ratio"))


def test_tables_of_settings_name_every_clip_and_mark_the_recommended() -> None:
    rows = [row("the paper", 1, 1.0), row(CHOSEN, 9, 1.0)]
    assert sensitivity_table(rows).marked == frozenset({1})
    assert losses_table(rows).rows == (("clip", "9 of 10", "1 of 10"),)


def test_settings_hold_the_papers_own_and_each_row_once() -> None:
    rows = settings(SETTINGS)
    assert rows[0].options == AS_PRINTED
    assert row_of([Row(one, (), ()) for one in rows], {**SETTINGS, "time_scale": 0.1}).setting.label.endswith("0.1 s")
    with pytest.raises(KeyError, match="999"):
        row_of([], {"time_scale": 999})
    assert len({(one.group, one.label) for one in rows}) == len(rows)


def test_tables_are_written_for_both_kinds_of_page() -> None:
    table = Table(("a", "b"), (("x<y", "1"), ("z", "2")), marked=frozenset({1}))
    assert table.markdown() == "| a | b |\n| :-- | --: |\n| x<y | 1 |\n| **z** | **2** |\n"
    assert "x&lt;y" in table.html()
    assert table.html().count("class=marked") == 1


def test_numbers_that_do_not_exist_are_said_so() -> None:
    assert [number(value) for value in (None, math.nan, math.inf, 1.005)] == ["–", "–", "lost", "1.00"]
    assert plain({"a": math.inf, "b": [np.float64(1.5), np.int64(2)]}) == {"a": None, "b": [1.5, 2]}
    assert plain(Signal(("x",), np.zeros((3, 1)), Fraction(30), name="s")) == {"name": "s", "n_frames": 3, "rate": "30"}


def test_the_sample_has_known_answers_that_the_method_finds() -> None:
    (found,) = answer_all(Library(Path("unused")), SETTINGS, names=["sample, jump"])
    guided, aligned = found.attempt("guided, free"), found.attempt("aligned")
    assert guided is not None
    assert aligned is not None
    assert guided.inside.correlation > 0.85
    assert guided.inside.mean_error < found.attempts[0].inside.mean_error
    assert guided.inside.correlation > aligned.inside.correlation


def test_imitating_one_jump_is_the_same_as_being_guided_by_it() -> None:
    (found,) = answer_all(Library(Path("unused")), SETTINGS, names=["sample, jump"])
    guided, imitated = found.attempt("guided, free"), found.attempt("imitate()")
    assert guided is not None
    assert imitated is not None
    assert imitated.inside.correlation == pytest.approx(guided.inside.correlation, abs=0.02)


def test_the_study_runs_with_the_packages_own_choices() -> None:
    by_itself, said = Session(SAMPLE).solve(length="65%"), Session(SAMPLE, **SETTINGS).solve(length="65%")
    assert np.array_equal(by_itself.path.frames, said.path.frames)
    assert by_itself.total == said.total


def test_the_samples_flights_are_kept_at_every_length() -> None:
    chosen = [Setting(CHOSEN, "", SETTINGS)]
    (found,) = measure(Library(Path("unused")), chosen, jumps=["sample"], answers=[])
    assert found.kept()[0] == found.kept()[1] > 0


def test_every_evaluation_of_the_paper_is_run() -> None:
    assert set(PAPER) == {f"V{i}" for i in range(1, 9)} <= set(EVALUATIONS) <= set(PARTS)


def test_the_prototypes_questions_are_answered_one_by_one(captures: Library) -> None:
    kept = tuple(Preserved("clip", length, 10, 9, 4, 3) for length in ("80%", "65%", "50%"))
    ratios = tuple(
        Imitated(case, "jump", weight, 0.9, 0.1, 1.0, 1.1)
        for case in ("01_01", "49_02")
        for weight in ("neutral", "sum")
    )
    rows = [
        Row(Setting(CHOSEN if options == SETTINGS else "other", "", options), kept, ratios)
        for options in (
            {**SETTINGS, "score": score, "time_scale": scale}
            for score in ("joint", "conditional")
            for scale in (1 / 30, 0.1, 0.2)
        )
    ]
    found = {one.what: one.here for one in compare(captures, rows, SETTINGS)}
    assert len(ACROSS) == 3
    assert found["in-flight frames kept at 65%"] == "3 of 4"
    assert found["clips that lose some with τ = 1/30 s, 65%"] == "1 of 1"
    low, high = map(float, found["… with the right length given"].split("–"))
    assert 0.9 < low <= high <= 1.0
    (neutral,) = [here for what, here in found.items() if "neutral, joint, τ = 0.2" in what]
    assert neutral == "110 %, 110 %"


def test_numbers_of_the_text_are_those_of_the_rows() -> None:
    torso = Row(Setting("", "", {**SETTINGS, "features": "torso"}), row("", 2, 1.0).preserved, ())
    chosen = Row(Setting(CHOSEN, "", SETTINGS), row("", 9, 1.0).preserved, row("", 9, 1.0).imitated)
    values = text_values([torso, chosen], ())
    assert (values["kept-default"], values["share-torso"], values["kept-high"]) == ("9 of 10", "20 %", "4 of 4")
    assert values["limps-default"] == "0.90"
    assert values["jumps-default"] == "–"


@pytest.fixture(scope="module")
def lengthened(captures: Library):
    return v5(captures, 1)


def test_v5_has_the_papers_sizes_and_keeps_its_jump(lengthened) -> None:
    size = lengthened.row
    assert (size.n_input, size.n_reference, size.max_skip) == (401, 101, 4)
    guided, linear = lengthened.version("guided").figures, lengthened.version("linear").figures
    assert guided.flight_frames_kept == guided.flight_frames > 10
    assert guided.gravity == pytest.approx(1.0, abs=0.02)
    assert linear.gravity == pytest.approx(1 / 1.5**2, rel=0.03)
    assert guided.keytimes_missed == pytest.approx(0.0, abs=1e-9)
    with pytest.raises(KeyError):
        lengthened.version("no such")


def test_v8_slows_every_flight_to_half(captures: Library) -> None:
    evaluation = v8(captures, 1)
    assert (evaluation.row.n_input, evaluation.row.heuristic) == (1524, None)
    figures = evaluation.version("guided").figures
    assert (figures.flight_slowest, figures.flight_fastest) == pytest.approx((0.5, 0.5), abs=0.05)
    path = path_warp(evaluation.guided)
    assert path.slopes.min() >= 0.25


def test_a_player_holds_the_poses_that_are_written(lengthened) -> None:
    data = player_data(lengthened)
    version = data["versions"][-1]
    poses = np.frombuffer(base64.b64decode(version["poses"]), "<i2").reshape(version["count"], data["nodes"], 3)
    assert [one["label"] for one in data["versions"]] == [one.label for one in lengthened.versions]
    assert len(version["speeds"]) == len(version["aloft"]) == version["count"]
    # A man: no taller than two metres and a half on his jump, no shorter than one.
    heights = np.ptp(poses[:, :, 1] * data["grain"], axis=1)
    assert 1.0 < np.median(heights) < 2.0
    assert all(0 <= node < data["nodes"] for _, line in data["chains"] for node in line)
    assert sum(version["aloft"]) / data["rate"] == pytest.approx(0.5, abs=0.1)


def test_a_player_can_stand_in_a_page(lengthened) -> None:
    text = player_html(lengthened)
    (data,) = re.findall(r'<script type="application/json">(.*?)</script>', text, flags=re.DOTALL)
    assert json.loads(data)["key"] == "V5"
    assert text.count("</script>") == 1


@pytest.fixture(scope="module")
def written(captures: Library, tmp_path_factory: pytest.TempPathFactory):
    results = run(captures, ("V5",), quick=True)
    return results, write_study(results, tmp_path_factory.mktemp("study"))


def test_the_page_asks_no_other_place_for_anything(written) -> None:
    _, found = written
    page = found.page.read_text(encoding="utf-8")
    assert "<canvas" not in page
    assert player_script() in page
    assert not re.findall(r"""(?:src|href)=["'](?!data:|#)""", page)
    assert not re.findall(r"https?://|@import|url\(", page)


def test_the_numbers_are_json_without_nan(written) -> None:
    results, found = written
    document = json.loads(found.numbers.read_text(encoding="utf-8"), parse_constant=pytest.fail)
    assert document["evaluations"][0]["key"] == "V5"
    assert document["machine"].keys() == {"python", "processor", "cores", "processor time"}
    assert document["values"].keys() == {"excess"}
    assert document["tables"].keys() == {"V5", "sizes"}
    assert numbers(results)["settings"] == SETTINGS


def test_pictures_are_written_for_what_was_run(written) -> None:
    _, found = written
    assert [place.name for place in found.figures] == ["v5.png", "speeds.svg"]
    assert all(place.stat().st_size > 1000 for place in found.figures)


def test_a_study_of_nothing_has_no_tables() -> None:
    empty = Results((), (), (), (), None, None, None, 0.0, {})
    assert numbers(empty)["tables"] == numbers(empty)["values"] == {}


def test_answers_name_clips_that_are_there(mocap: Path) -> None:
    assert all((mocap / source.path).is_file() for source in SOURCES.values())
    assert {"29_01", "01_01", "boxing", "sample, limp", "sample, jump"} <= set(ANSWERS)
