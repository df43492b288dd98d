"""Curves for every host: read back they are the warp; what a host can't play, or has no use for, is refused."""

from __future__ import annotations

import itertools
import math
import re
from fractions import Fraction
from pathlib import Path

import numpy as np
import pytest

from retime import Keytime, export_curve, import_curve
from retime.errors import FormatError, OptionError, OutputExistsError
from retime.hosts.registry import HOST_NAMES, HOSTS, Host, host_named
from retime.warp.curve import Warp
from tests.hosts.material import ITEMS, RATES, drawn_warp, frame_times, most_error, suits

_TOLERANCE = 0.001
# Of numbers with twelve decimals, of rational seconds, of JSON.
_ROUNDING = 2e-7
HOLDS = Warp([0.0, 1.0, 2.0, 3.0], [0.0, 2.0, 2.0, 1.0])


def written(tmp_path: Path, warp: Warp, host: Host, rate: Fraction, **options) -> tuple[Path, object]:
    place = tmp_path / f"curve{host.suffixes[0]}"
    options.setdefault("item", ITEMS.get(host.name, ""))
    return place, export_curve(warp, place, host.name, rate=rate, overwrite=True, **options)


@pytest.mark.parametrize("host", HOSTS, ids=HOST_NAMES)
def test_what_is_written_is_within_the_error_that_is_said(tmp_path, host) -> None:
    for seed, rate in zip(range(12), itertools.cycle(RATES), strict=False):
        warp = drawn_warp(seed, forward=seed % 2 == 0)
        if not suits(host, warp):
            continue
        place, done = written(tmp_path, warp, host, rate)
        assert done.error_frames == pytest.approx(done.error * float(rate))
        assert done.error <= most_error(host, rate, _TOLERANCE) + _ROUNDING
        if not host.imports:
            continue
        told = {} if host.says_rate or host.name == "csv" else {"rate": rate}
        back = import_curve(place, host.name, **told)
        at = frame_times(warp, rate)
        if not (host.every_frame or host.whole_frames):
            at = np.concatenate([at, warp.output_times, back.output_times])
        assert np.abs(back(at) - warp(at)).max() == pytest.approx(done.error, abs=1e-12)


@pytest.mark.parametrize("name", [host.name for host in HOSTS if host.imports])
def test_a_second_round_trip_changes_nothing(tmp_path, name) -> None:
    host = host_named(name)
    for seed in range(4):
        told = {} if host.says_rate or name == "csv" else {"rate": 24}
        place, _ = written(tmp_path, drawn_warp(seed, forward=False), host, Fraction(24))
        first = import_curve(place, name, **told)
        place, done = written(tmp_path, first, host, Fraction(24), **({} if host.every_frame else {"tolerance": 0.0}))
        again = import_curve(place, name, **told)
        assert done.error < _ROUNDING
        at = frame_times(first, Fraction(24))
        np.testing.assert_allclose(again(at), first(at), atol=_ROUNDING)


@pytest.mark.parametrize(
    ("one", "other"), list(itertools.permutations(["csv", "framecurve", "otio", "lottie", "nuke", "maya", "fcpxml"], 2))
)
def test_a_curve_goes_from_host_to_host(tmp_path, one, other) -> None:
    warp = drawn_warp(7, forward=False)
    rate = Fraction(24)
    back = warp
    for name in (one, other):
        host = host_named(name)
        place, _ = written(tmp_path, back, host, rate)
        back = import_curve(place, name, **({} if host.says_rate or name == "csv" else {"rate": rate}))
    at = frame_times(warp, rate)
    # A curve with keys on whole frames ends with the last of them.
    assert np.abs(back(at) - warp(at)).max() <= 2 * _TOLERANCE + _ROUNDING


@pytest.mark.parametrize("host", [host for host in HOSTS if host.first_frame is not None], ids=lambda host: host.name)
def test_frames_are_counted_from_where_the_shot_begins(tmp_path, host) -> None:
    warp = drawn_warp(3, forward=True)
    place, done = written(tmp_path, warp, host, Fraction(24), start=1001)
    assert done.error <= most_error(host, Fraction(24), _TOLERANCE) + _ROUNDING
    assert "1001" in place.read_text()
    if host.imports:
        told = {} if host.says_rate else {"rate": 24}
        begins = import_curve(place, host.name, start=1001, **told)
        assert begins.output_start == pytest.approx(0.0, abs=1e-9)
        other = import_curve(place, host.name, start=1, **told)
        np.testing.assert_allclose(other.output_times, begins.output_times + (0 if host.name == "otio" else 1000 / 24))


def test_a_script_for_curves_of_maya_comes_back(tmp_path) -> None:
    place = tmp_path / "a.py"
    for rate in RATES:
        export_curve(HOLDS, place, "maya", rate=rate, start=101, item="hips_tx, ns:hips_ty", overwrite=True)
        for item in ("", "hips_tx", "ns:hips_ty"):
            back = import_curve(place, start=101, item=item)
            np.testing.assert_allclose(back.output_times, HOLDS.output_times, atol=_ROUNDING)
            np.testing.assert_allclose(back.input_times, HOLDS.input_times, atol=_ROUNDING)
    with pytest.raises(OptionError, match="no animation curve is called head_tx; there is hips_tx, ns:hips_ty"):
        import_curve(place, start=101, item="head_tx")
    place.write_text(place.read_text().replace("UNIT =", "UNITY ="))
    with pytest.raises(FormatError, match=r"a\.py: expected a script that retime wrote, with UNIT"):
        import_curve(place, start=101)


def test_fewer_keys_where_more_error_is_allowed(tmp_path) -> None:
    times = np.linspace(0, 10, 500)
    warp = Warp(times, times**2 / 10)
    counts = [export_curve(warp, tmp_path / f"{n}.csv", "csv", tolerance=10.0**-n).keys for n in range(1, 5)]
    assert counts == sorted(counts)
    assert counts[0] < 8 < 80 < counts[-1]


def test_keytimes_keep_their_keys(tmp_path) -> None:
    warp = Warp([0.0, 1.0, 2.0], [0.0, 1.0001, 2.0], keytimes=(Keytime(input_time=1.0001, output_time=1.0),))
    export_curve(warp, tmp_path / "a.csv", "csv", tolerance=0.01)
    assert import_curve(tmp_path / "a.csv").output_times.tolist() == [0.0, 1.0, 2.0]


def test_the_error_is_measured_against_the_warp_itself_and_not_against_the_simplified_one(tmp_path) -> None:
    warp = Warp([0.0, 1.0, 2.0], [0.0, 1.02, 2.0])
    done = export_curve(warp, tmp_path / "a.csv", "csv", rate=10, tolerance=0.05)
    assert (done.keys, done.error, done.error_frames) == (2, pytest.approx(0.02), pytest.approx(0.2))


@pytest.mark.parametrize(("name", "off"), [("frames", 0.5), ("ffmpeg", 0.5), ("mlt", 0.75), ("framecurve", 0.0)])
def test_where_whole_frames_are_shown_the_error_is_of_those(tmp_path, name, off) -> None:
    # The output asks for the input frames 0, 0.75, 1.5, 2.25, 3, ...: shown is the nearest, or the last that has begun.
    _, done = written(tmp_path, Warp([0.0, 10.0], [0.0, 7.5]), host_named(name), Fraction(24))
    assert done.error_frames == pytest.approx(off, abs=1e-5)


@pytest.mark.parametrize("rate", [*RATES, Fraction(30000, 1001), Fraction(60000, 1001)], ids=str)
def test_mlt_shows_each_frame_once_where_nothing_is_retimed(tmp_path, rate) -> None:
    # As the link does it: a line between two keys, times the clip's rate, cut off to a whole frame. A second that was
    # rounded down by a hair would show the frame before.
    for speed in (1, -1, 2):
        n = 1000
        frames = np.arange(n + 1)
        shows = frames * speed - min(0, n * speed)
        warp = Warp(frames[[0, n]] / float(rate), shows[[0, n]] / float(rate))
        place, done = written(tmp_path, warp, host_named("mlt"), rate)
        keys = re.search(r'name="time_map">([^<]*)<', place.read_text())
        at, seconds = np.array([key.split("=") for key in keys[1].split(";")], dtype=float).T
        assert (np.floor(np.interp(frames, at, seconds) * float(rate)) == shows).all()
        assert done.error_frames < 1e-6


def test_final_cut_shows_the_nearest_frame(tmp_path) -> None:
    # Times are rounded to parts of a second: the last frame that has begun would now and then be the one before.
    warp = Warp([0.0, 1 / 3, 1.0], [0.0, 1.0, 1.0 + 4 / 3])
    place, _ = written(tmp_path, warp, host_named("fcpxml"), Fraction(24))
    assert '<timeMap frameSampling="nearest-neighbor" ' in place.read_text()


@pytest.mark.parametrize(
    "host", [host for host in HOSTS if host.every_frame or host.whole_frames], ids=lambda host: host.name
)
def test_an_output_of_a_single_frame_is_refused_where_frames_are_written(tmp_path, host) -> None:
    short = Warp([0.0, 0.02], [0.0, 0.04])
    with pytest.raises(OptionError, match=r"a single frame at 24 frames a second.*higher rate"):
        written(tmp_path, short, host, Fraction(24))
    assert list(tmp_path.iterdir()) == []
    _, done = written(tmp_path, short, host, Fraction(100))
    assert done.keys >= 2


@pytest.mark.parametrize("host", [host for host in HOSTS if not host.holds], ids=lambda host: host.name)
def test_holds_and_reverse_are_refused_with_what_would_do(tmp_path, host) -> None:
    with pytest.raises(OptionError, match=r"holds from output time 1 to 2 s.*can't express.*--speed"):
        written(tmp_path, HOLDS, host, Fraction(24))
    back = Warp([0.0, 1.0, 2.0, 3.0], [0.0, 2.0, 1.0, 1.5])
    with pytest.raises(OptionError, match=r"runs backward from output time 1 to 2 s.*frames \(a list.*nuke"):
        written(tmp_path, back, host, Fraction(24))
    assert list(tmp_path.iterdir()) == []


def test_speeds_above_a_host_s_own_are_refused(tmp_path) -> None:
    warp = Warp([0.0, 1.0, 1.5, 2.0], [0.0, 1.0, 7.0, 0.5])
    with pytest.raises(
        OptionError, match=r"from output time 1 to 2 s the warp plays at 13x, and premiere at 10x at most"
    ):
        written(tmp_path, warp, host_named("premiere"), Fraction(24))
    _, done = written(tmp_path, warp, host_named("fcpxml"), Fraction(24))
    assert done.error <= _ROUNDING
    slower = Warp([0.0, 1.0, 1.5, 2.0], [0.0, 1.0, 6.0, 1.0])
    assert written(tmp_path, slower, host_named("premiere"), Fraction(24))[1].error <= _ROUNDING


@pytest.mark.parametrize("host", [host for host in HOSTS if not host.before_clip], ids=lambda host: host.name)
def test_times_before_the_clip_are_refused_where_there_are_none(tmp_path, host) -> None:
    with pytest.raises(OptionError, match=r"input time -0.5 s, before the clip's first frame"):
        written(tmp_path, Warp([0.0, 1.0], [-0.5, 1.0]), host, Fraction(24))
    with pytest.raises(OptionError, match=r"output begins at -1 s"):
        written(tmp_path, Warp([-1.0, 1.0], [0.0, 1.0]), host, Fraction(24))


@pytest.mark.parametrize(
    "host", [host for host in HOSTS if host.before_clip and host.begins_late], ids=lambda host: host.name
)
def test_others_play_them(tmp_path, host) -> None:
    _, done = written(tmp_path, Warp([-1.0, 1.0], [-0.5, 1.0]), host, Fraction(24))
    assert done.error <= _ROUNDING


@pytest.mark.parametrize("host", HOSTS, ids=HOST_NAMES)
def test_an_output_that_begins_late_stays_there(tmp_path, host) -> None:
    warp = Warp([2.0, 3.0], [1.0, 4.0])
    if not host.begins_late:
        with pytest.raises(OptionError, match=r"output begins at 2 s, after time 0"):
            written(tmp_path, warp, host, Fraction(24))
        return
    _, done = written(tmp_path, warp, host, Fraction(24))
    assert done.error <= _ROUNDING


def test_what_has_no_use_is_refused(tmp_path) -> None:
    warp = Warp([0.0, 1.0], [0.0, 1.0])
    for host, options, said in (
        ("nuke", {}, "name the shot's frames a second"),
        ("nuke", {"rate": 24, "tolerance": 0.1}, "exact time of every frame"),
        ("lottie", {"rate": 24, "start": 1}, "--start would have no effect"),
        ("csv", {"item": "walk"}, "nothing to name"),
        ("usd-clips", {"rate": 24}, "needs --item"),
        ("csv", {"tolerance": math.nan}, "tolerance"),
        ("csv", {"tolerance": -1}, "tolerance"),
        ("nuke", {"rate": 24, "start": 10**12}, "no shot begins"),
        ("nuke", {"rate": 24, "item": "a\nb"}, "can't be printed"),
        ("nuke", {"rate": 24, "item": "a b}"}, "a node's name"),
        ("nuke", {"rate": 24, "item": "1st"}, "begins with no digit"),
        ("fcpxml", {"rate": 24, "item": "  "}, "--item is blank"),
        ("usd-clips", {"rate": 24, "item": "walk.usd"}, "a layer and a prim"),
        ("maya", {"rate": Fraction(100, 3)}, "Maya has no time unit of 33.3333"),
        ("premiere", {"rate": Fraction(100, 3)}, "premiere has no sequence"),
        ("resolve", {}, "no host is called 'resolve'; there are nuke, maya"),
    ):
        suffix = next((known.suffixes[0] for known in HOSTS if known.name == host), ".x")
        with pytest.raises(OptionError, match=said):
            export_curve(warp, tmp_path / f"a{suffix}", host, **options)
    assert list(tmp_path.iterdir()) == []


def test_the_ending_is_the_host_s(tmp_path) -> None:
    warp = Warp([0.0, 1.0], [0.0, 1.0])
    with pytest.raises(FormatError, match=r"a file for nuke ends in \.nk"):
        export_curve(warp, tmp_path / "a.txt", "nuke", rate=24)
    with pytest.raises(FormatError, match=r"with --item, a script"):
        export_curve(warp, tmp_path / "a.ma", "maya", rate=24, item="hips_translateX")


def test_knots_that_the_digits_of_a_file_do_not_tell_apart_are_refused(tmp_path) -> None:
    # A jump, nearly: no tolerance that anybody would take for granted lets go of it.
    warp = Warp([0.0, 1.0, 1.00000001, 2.0], [0.0, 1.0, 3.0, 4.0])
    with pytest.raises(
        OptionError, match=r"fcpxml can't hold this warp: two of its knots are 1e-08 s apart.*--host csv"
    ):
        written(tmp_path, warp, host_named("fcpxml"), Fraction(24))
    assert list(tmp_path.iterdir()) == []
    _, done = written(tmp_path, warp, host_named("csv"), Fraction(24))
    assert done.error == 0


def test_a_file_is_not_replaced_unless_told(tmp_path) -> None:
    warp = Warp([0.0, 1.0], [0.0, 1.0])
    export_curve(warp, tmp_path / "a.csv", "csv")
    with pytest.raises(OutputExistsError):
        export_curve(warp, tmp_path / "a.csv", "csv")


def test_a_warp_that_is_too_long_for_its_rate_is_refused(tmp_path) -> None:
    with pytest.raises(OptionError, match="1000000 keys"):
        export_curve(Warp([0.0, 9000.0], [0.0, 1.0]), tmp_path / "a.nk", "nuke", rate=1000)
