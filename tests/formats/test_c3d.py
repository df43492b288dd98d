"""C3D files: read as the c3d library reads them, retimed in place, written."""

from __future__ import annotations

import io
import warnings
from dataclasses import replace
from fractions import Fraction
from pathlib import Path

import numpy as np
import pytest

from retime.errors import FormatError, FormatWarning, OptionError, OutputExistsError, RetimeWarning
from retime.formats import c3d
from retime.formats.c3d_numbers import DEC, Numbers
from retime.formats.in_place import retime_file
from retime.formats.read_options import Limits, ReadOptions
from retime.formats.registry import facts_of, read, write
from retime.motion.signal import Signal
from retime.warp.curve import Warp
from tests.formats.c3d_files import FORMS, Capture, drawn, real_bytes
from tests.reference.c3d_frames import shown_point, shown_sample

PATH = Path("take.c3d")
PLAIN = ReadOptions()
ANALOG = ReadOptions(arrays=("analog",))


def by_library(data: bytes) -> tuple[np.ndarray, np.ndarray, object]:
    """Points (n_frames, n_points, 5) and analog (n_frames * n_samples, n_channels) as the c3d library has them."""
    library = pytest.importorskip("c3d")
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        reader = library.Reader(io.BytesIO(data))
        frames = [(points, analog) for _, points, analog in reader.read_frames()]
    points = np.array([points for points, _ in frames])
    analog = [analog.T if analog.size else np.zeros((1, 0)) for _, analog in frames]
    return points, np.concatenate(analog), reader


def quiet_read(data: bytes, options: ReadOptions = PLAIN) -> Signal:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", FormatWarning)
        return c3d.read(PATH, data, options)


def retimed(data: bytes, warp: Warp, options: ReadOptions = PLAIN, **more: object) -> bytes:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", RetimeWarning)
        return c3d.retime_frames(PATH, data, warp, options, **more)  # type: ignore[arg-type]


def drawn_warp(rng: np.random.Generator, end: float) -> Warp:
    """A warp that speeds up, holds and runs backward."""
    count = int(rng.integers(2, 6))
    outputs = np.cumsum(rng.uniform(0.05, 0.3, count))
    inputs = rng.uniform(0, end, count)
    if count > 2:
        inputs[1] = inputs[0]
    return Warp(outputs - outputs[0], inputs)


@pytest.mark.parametrize("seed", range(24))
def test_files_are_read_as_the_library_reads_them(seed: int) -> None:
    capture = drawn(seed, *FORMS[seed % 6])
    data = capture.build()
    points, analog, reader = by_library(data)
    signal = quiet_read(data)
    places = np.where(points[..., 3:4] < 0, np.nan, points[..., :3])
    np.testing.assert_allclose(signal.values, places.reshape(len(places), -1), rtol=1e-6)
    labels = [label.strip() for label in reader.point_labels]  # type: ignore[attr-defined]
    assert signal.names == tuple(f"{label}.{axis}" for label in labels for axis in "xyz")
    assert (signal.rate, signal.first_frame) == (Fraction(capture.rate), capture.first)
    assert signal.start_time == pytest.approx((capture.first - 1) / capture.rate)
    assert {str(kind) for kind in signal.kinds} == {"linear:mm"}
    if capture.analog.shape[1]:
        channels = quiet_read(data, ANALOG)
        np.testing.assert_allclose(channels.values, analog, rtol=1e-6)
        assert channels.rate == Fraction(capture.rate) * capture.samples
        assert channels.names == tuple(f"ch{i}" for i in range(capture.analog.shape[1]))
        assert channels.start_time == signal.start_time
    told = c3d.facts(PATH, data, PLAIN)
    assert (
        told["stored"] == f"{['Intel', 'DEC', 'SGI'][capture.machine - 84]}, {['16-bit', 'real'][capture.real]} numbers"
    )
    said = told["events"].split(": ", 1)[1].split(", ") if capture.events else []
    assert said == [f"Left {label} {np.float32(time):.3f} s" for time, label, _ in capture.events]


@pytest.mark.parametrize("seed", range(12))
def test_nothing_changes_by_a_warp_that_changes_nothing(seed: int) -> None:
    capture = drawn(seed, *FORMS[seed % 6])
    end = (capture.n_frames - 1) / capture.rate
    assert retimed(capture.build(), Warp([0.0, end], [0.0, end])) == capture.build()


@pytest.mark.parametrize("seed", range(36))
def test_frames_are_those_of_the_literal_twin(seed: int) -> None:
    capture = drawn(100 + seed, *FORMS[seed % 6])
    rng = np.random.default_rng(seed)
    warp = drawn_warp(rng, (capture.n_frames - 1) / capture.rate)
    data = retimed(capture.build(), warp, average=False)
    points, analog, reader = by_library(data)
    n_frames = warp.count_frames(capture.rate)
    assert reader.frame_count == n_frames  # type: ignore[attr-defined]
    scale = 1.0 if capture.real else capture.scale
    step = 1e-5 * np.abs(capture.points).max() if capture.real else 0.51 * scale
    for frame in range(n_frames):
        time = warp.output_end if frame == n_frames - 1 > 0 else warp.output_start + frame / capture.rate
        place = float(warp(time)) * capture.rate
        for point in range(capture.points.shape[1]):
            expected = shown_point(capture.points[:, point].tolist(), place)
            found = points[frame, point]
            if expected is None:
                assert found[3] == -1
                continue
            np.testing.assert_allclose(found[:3], np.array(expected[0]) * scale, atol=step)
            word = int(expected[1])
            assert found[3] == pytest.approx((word & 0xFF) * capture.scale, rel=1e-6)
            assert found[4] == word >> 8
    rate = capture.rate * capture.samples
    longer = np.append(warp.input_times, warp.input_times[-1] + np.sign(np.diff(warp.input_times)[-1]) / capture.rate)
    shown = np.append(warp.output_times, warp.output_end + 1 / capture.rate)
    for channel in range(capture.analog.shape[1]):
        column = capture.analog[:, channel].tolist()
        for sample in range(n_frames * capture.samples):
            place = float(np.interp(warp.output_start + sample / rate, shown, longer)) * rate
            raw = shown_sample(column, place)
            expected_value = (raw - capture.offsets[channel]) * capture.scales[channel] * 0.5
            slack = 0.51 * capture.scales[channel] * 0.5 if not capture.real else 1e-3 * (1 + abs(expected_value))
            assert analog[sample, channel] == pytest.approx(expected_value, abs=slack)


@pytest.mark.parametrize("form", FORMS)
def test_only_what_must_changes_before_the_frames(form: tuple[int, bool]) -> None:
    machine, real = form
    capture = Capture(
        machine,
        real,
        rate=100.0,
        first=11,
        points=np.ones((40, 2, 4)),
        analog=np.ones((80, 1)),
        events=[(0.25, "Foot Strike", "Left"), (0.3, "Foot Off", "Right")],
        header_events=[(0.15, "LFS")],
        zero=(1, 5),
    )
    old = capture.build()
    new = retimed(old, Warp([0.0, 0.78], [0.0, 0.39]))
    start = 512 * (2 + len(capture.section(0)) // 512 - 1)
    changed = [at for at in range(start) if old[at] != new[at]]
    named = c3d.parse_c3d(PATH, old, PLAIN).parameters
    allowed = {8, 9, *range(304, 308)}
    for name in ("POINT:FRAMES", "TRIAL:ACTUAL_END_FIELD", "EVENT:TIMES", "FORCE_PLATFORM:ZERO"):
        allowed |= {*range(named[name].start, named[name].start + named[name].n_bytes)}
    assert set(changed) <= allowed
    assert len(changed) >= 5
    told = c3d.facts(PATH, new, PLAIN)
    # Times count from frame 1, which is 0.1 s before the first one here; half as fast, twice as late after that.
    assert told["events"] == "2: Left Foot Strike 0.400 s, Right Foot Off 0.500 s"
    file = c3d.parse_c3d(PATH, new, PLAIN)
    assert (file.first, file.n_frames) == (11, 79)
    values = file.values("FORCE_PLATFORM:ZERO")
    assert values is not None
    assert values.tolist() == [1, 9]
    # That of the header counts from the first frame.
    assert file.numbers.real(new, 304) == pytest.approx(0.3)


def test_events_of_the_header_and_parameters_that_are_no_numbers() -> None:
    capture = Capture(points=np.ones((40, 1, 4)), first=11, rate=10.0, header_events=[(0.5, "LFS"), (1.0, "LTO")])
    assert c3d.facts(PATH, capture.build(), PLAIN)["events"] == "2: LFS 1.500 s, LTO 2.000 s"
    # One that both places have is one event.
    capture.events = [(1.5, "Foot Strike", "Left")]
    assert c3d.facts(PATH, capture.build(), PLAIN)["events"] == "2: Left Foot Strike 1.500 s, LTO 2.000 s"
    capture.more = {"FORCE_PLATFORM": [("ZERO", -1, [2], b"no")]}
    assert quiet_read(retimed(capture.build(), Warp([0.0, 1.0], [0.0, 3.9]))).n_frames == 11


def test_minutes_stay_minutes() -> None:
    capture = Capture(rate=10.0, points=np.ones((1300, 1, 4)), events=[(90.0, "Foot Strike", "Left")], minutes=True)
    new = retimed(capture.build(), Warp([0.0, 64.95], [0.0, 129.9]))
    file = c3d.parse_c3d(PATH, new, PLAIN)
    values = file.values("EVENT:TIMES")
    assert values is not None
    assert values.tolist() == [0.0, 45.0]
    slow = retimed(capture.build(), Warp([0.0, 259.8], [0.0, 129.9]))
    values = c3d.parse_c3d(PATH, slow, PLAIN).values("EVENT:TIMES")
    assert values is not None
    assert values.tolist() == [3.0, 0.0]


def test_no_mean_reaches_across_a_gap() -> None:
    points = np.zeros((60, 2, 4))
    points[30:, :, 0] = 1000.0
    points[28:33, 0] = (0, 0, 0, -1)
    capture = Capture(rate=30.0, points=points)
    found = quiet_read(retimed(capture.build(), Warp([0.0, 59 / 90], [0.0, 59 / 30]))).values
    with_gap, without = found[:, 0], found[:, 3]
    assert np.isnan(with_gap).any()
    assert set(with_gap[~np.isnan(with_gap)]) == {0.0, 1000.0}
    # Where nothing is missing the means do reach across the step.
    assert len(set(without)) > 2


def test_a_spike_is_averaged_at_each_own_rate() -> None:
    points, analog = np.zeros((61, 1, 4)), np.zeros((61 * 4, 1))
    points[30, 0, 0], analog[122, 0] = 30.0, 30.0
    data = Capture(rate=30.0, points=points, analog=analog).build()
    fast = Warp([0.0, 20 / 30], [0.0, 2.0])
    once, averaged = (retimed(data, fast, average=average) for average in (False, True))
    assert quiet_read(once).values[:, 0].max() == 30.0
    # The mean over a window of three frames, in which the spike is a triangle two periods wide.
    assert quiet_read(averaged).values[:, 0].max() == pytest.approx(15.0, rel=1e-5)
    channel = quiet_read(averaged, ANALOG).values[:, 0]
    assert len(channel) == 21 * 4
    assert 0 < channel.max() < 0.5 * 15
    assert np.count_nonzero(channel) <= 2


def test_a_switch_among_analog_channels_stays_one() -> None:
    analog = np.repeat([[0.0], [5.0]], 40, axis=0)
    data = Capture(rate=20.0, points=np.zeros((40, 1, 4)), analog=analog, analog_labels=["gate"]).build()
    slow = Warp([0.0, 5.0], [0.0, 39 / 20])
    kinds = ReadOptions(channels={"gate": c3d.ChannelKind("label")})
    assert set(quiet_read(retimed(data, slow, kinds), ANALOG).values[:, 0]) == {0.0, 2.5}
    assert len(set(quiet_read(retimed(data, slow), ANALOG).values[:, 0])) > 2


@pytest.mark.parametrize("frames_as", ["word", "real"])
def test_more_frames_than_the_header_can_count(frames_as: str) -> None:
    points = np.zeros((40_000, 1, 4))
    points[:, 0, 0] = np.arange(40_000) % 1000
    capture = Capture(real=False, scale=1.0, rate=100.0, points=points, frames_as=frames_as)
    slow = Warp([0.0, 799.98], [0.0, 399.99])
    new = retimed(capture.build(), slow)
    signal = quiet_read(new)
    assert (signal.n_frames, signal.first_frame) == (79_999, 1)
    assert signal.values[::2, 0].tolist() == points[:, 0, 0].tolist()
    assert len(by_library(new)[0]) == 79_999
    # And back again.
    again = retimed(new, slow.inverse(), average=False)
    assert again == capture.build()
    unable = replace(capture, trial=False)
    if frames_as == "word":
        with pytest.raises(FormatError, match="no place for one above 65535"):
            retimed(unable.build(), slow)
    else:
        assert quiet_read(retimed(unable.build(), slow)).n_frames == 79_999


def test_part_of_a_take_keeps_its_numbers() -> None:
    points = np.zeros((50, 1, 4))
    points[:, 0, 0] = np.arange(50)
    analog = np.arange(100.0)[:, None]
    capture = Capture(
        rate=10.0,
        first=5,
        points=points,
        analog=analog,
        events=[(2.2, "Foot Strike", "Left"), (0.1, "Foot Off", "Left")],
        header_events=[(1.8, "LFS")],
    )
    # Frames 15 to 24: the first one is 1.4 s after frame 1.
    new = retimed(capture.build(), Warp([0.0, 1.8], [0.0, 0.9]), frames=(15, 24), average=False)
    signal, channel = quiet_read(new), quiet_read(new, ANALOG)
    assert (signal.first_frame, signal.n_frames) == (15, 19)
    np.testing.assert_allclose(signal.values[:, 0], 10 + np.arange(19) / 2, atol=1e-5)
    # The last frame's second sample follows the last frame, as fast as the take.
    np.testing.assert_allclose(channel.values[:, 0] * 2, [*(20 + np.arange(37) / 2), 39.0], atol=1e-4)
    assert c3d.facts(PATH, new, PLAIN)["events"] == "2: Left Foot Off 0.100 s, Left Foot Strike 3.000 s"
    assert c3d.parse_c3d(PATH, new, PLAIN).numbers.real(new, 304) == pytest.approx(1.6)
    with pytest.raises(FormatError, match="frames 15 to 60 are not among 5 to 54"):
        retimed(capture.build(), Warp([0.0, 1.8], [0.0, 0.9]), frames=(15, 60))


def test_poses_are_held_and_analog_goes_on() -> None:
    points = np.zeros((20, 1, 4))
    points[:, 0, 0] = np.arange(20)
    capture = Capture(rate=10.0, points=points, analog=np.arange(20.0)[:, None])
    new = retimed(capture.build(), Warp([0.0, 1.9], [0.0, 1.9]), held=2)
    assert quiet_read(new).values[:5, 0].tolist() == [0, 0, 2, 2, 4]
    np.testing.assert_allclose(quiet_read(new, ANALOG).values[:3, 0] * 2, [0, 1, 2])


def test_another_rate_is_written_where_it_was_given() -> None:
    capture = drawn(3, 86, True)
    new = retimed(capture.build(), Warp([0.0, 0.1], [0.0, 0.1]), ReadOptions(rate=Fraction(30)))
    assert quiet_read(new).rate == 30
    assert by_library(new)[2].point_rate == 30  # type: ignore[attr-defined]


@pytest.mark.parametrize("form", FORMS)
def test_a_file_that_was_cut_short_is_noticed(form: tuple[int, bool]) -> None:
    machine, real = form
    points = np.arange(30 * 3 * 4, dtype=np.float64).reshape(30, 3, 4)
    capture = Capture(machine, real, points=points)
    data = capture.build()
    start = c3d.parse_c3d(PATH, data, PLAIN).data_start
    size = 12 * (4 if real else 2)
    for whole in (0, 1, 17, 29):
        cut = data[: start + whole * size + 5]
        with pytest.raises(FormatError, match=f"30 frames are claimed, and {whole} are there"):
            c3d.read(PATH, cut, PLAIN)
        if not whole:
            continue
        with pytest.warns(FormatWarning, match=f"{whole} of 30 frames are there and were kept"):
            assert c3d.read(PATH, cut, ReadOptions(repair=True)).n_frames == whole
    with pytest.warns(FormatWarning, match="17 of 30 frames"):
        new = c3d.retime_frames(
            PATH, data[: start + 17 * size + 5], Warp([0, 0.16], [0, 0.16]), ReadOptions(repair=True)
        )
    assert quiet_read(new).n_frames == 17


def test_counts_that_disagree_are_settled_by_the_size() -> None:
    capture = Capture(points=np.ones((200, 4, 4)), trial=False)
    data = bytearray(capture.build())
    data[8:10] = (150).to_bytes(2, "little")
    at = c3d.parse_c3d(PATH, bytes(data), PLAIN).parameters["POINT:FRAMES"].start
    data[at : at + 2] = (150).to_bytes(2, "little")
    with pytest.warns(FormatWarning, match="150 frames are claimed, but there is room for"):
        assert c3d.read(PATH, bytes(data), PLAIN).n_frames == 150
    data[8:10] = (200).to_bytes(2, "little")
    with pytest.warns(FormatWarning, match="disagree about points, samples or frames; 200 frames of 4 points"):
        assert c3d.read(PATH, bytes(data), PLAIN).n_frames == 200


def _at(data: bytes, place: int, new: bytes) -> bytes:
    return data[:place] + new + data[place + len(new) :]


def _broken() -> dict[str, tuple[bytes, str]]:
    data = Capture(points=np.ones((4, 2, 4))).build()
    file = c3d.parse_c3d(PATH, data, PLAIN)
    used, labels = file.parameters["POINT:USED"], file.parameters["POINT:LABELS"]
    return {
        "empty": (b"", "the file is empty; expected a C3D capture"),
        "picture": (b"\x89PNG\r\n\x1a\n" + bytes(2000), "expected a C3D capture, a PNG picture"),
        "only_a_header": (data[:512], "ends after 512 bytes, before its parameters"),
        "parameters_far_away": (_at(data, 0, b"\xff"), "the parameters begin in block 255, of"),
        "unknown_machine": (_at(data, 515, b"\x07"), "numbers of an unknown machine, 7; known are 84"),
        "a_kind_of_no_number": (_at(data, used.start - 2, b"\x03"), "a parameter of kind 3"),
        "labels_past_the_end": (_at(data, labels.start - 2, b"\xff\xff"), "runs past the end of its section"),
        "data_past_the_end": (_at(data, 16, b"\xff\xff"), "the frames begin at byte"),
        "no_rate": (_at(data, file.parameters["POINT:RATE"].start, bytes(4)), "a rate of 0 frames a second"),
        "nan_rate": (
            _at(data, file.parameters["POINT:RATE"].start, b"\x00\x00\xc0\x7f"),
            "a rate of nan frames a second; --fps",
        ),
        "a_step_inside_itself": (_at(data, 516 + 2 + 5, b"\x01\x00"), "inside itself"),
    }


@pytest.mark.parametrize("name", _broken())
def test_damage_is_named(name: str) -> None:
    data, message = _broken()[name]
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", FormatWarning)
        with pytest.raises(FormatError, match=message.replace("(", r"\(")):
            c3d.read(PATH, data, PLAIN)


@pytest.mark.parametrize("value", [np.nan, np.inf, -3.0, 0.5, 1e30])
@pytest.mark.parametrize("name", ["POINT:USED", "ANALOG:USED", "POINT:FRAMES", "EVENT:USED", "FORCE_PLATFORM:USED"])
def test_counts_that_are_none_are_passed_over(name: str, value: float) -> None:
    capture = Capture(points=np.ones((9, 2, 4)), analog=np.ones((18, 1)), events=[(0.03, "Foot Off", "Left")])
    group, own = name.split(":")
    kept = [one for one in capture.groups(9).get(group, []) if one[0] != own]
    capture.more = {group: [*kept, (own, 4, [], real_bytes(capture.machine, value))]}
    data = capture.build()
    assert quiet_read(data).n_frames == 9
    assert c3d.facts(PATH, data, PLAIN)["points"] == "2, in mm"
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", FormatWarning)
        assert quiet_read(retimed(data, Warp([0.0, 0.16], [0.0, 0.08]))).n_frames == 17


def test_limits_hold() -> None:
    data = Capture(points=np.ones((40, 2, 4))).build()
    with pytest.raises(FormatError, match=r"Limits\.channels"):
        c3d.read(PATH, data, ReadOptions(limits=Limits(channels=5)))
    with pytest.raises(FormatError, match=r"Limits\.frames"):
        c3d.read(PATH, data, ReadOptions(limits=Limits(frames=39)))


def test_what_is_never_there_is_left_out() -> None:
    points = np.ones((30, 3, 4))
    points[:, 1] = (0, 0, 0, -1)
    capture = Capture(points=points, labels=["A", "B", "C"])
    with pytest.warns(FormatWarning, match="never there, and so left out: B"):
        signal = c3d.read(PATH, capture.build(), PLAIN)
    assert signal.names[2:4] == ("A.z", "C.x")
    # In the file it stays.
    assert by_library(retimed(capture.build(), Warp([0, 0.5], [0, 0.29])))[0].shape[1] == 3
    capture.points[...] = (0, 0, 0, -1)
    with pytest.raises(FormatError, match="none of the 3 points is there"):
        c3d.read(PATH, capture.build(), PLAIN)


def test_gaps_are_kept_unless_they_are_to_be_bridged() -> None:
    points = np.ones((30, 1, 4))
    points[:, 0, 0] = np.arange(30)
    points[10:13, 0] = (0, 0, 0, -1)
    data = Capture(points=points).build()
    with pytest.warns(FormatWarning, match=r"kept gaps: P0\.x, P0\.y, P0\.z frames 11:13"):
        assert np.isnan(c3d.read(PATH, data, PLAIN).values[10:13]).all()
    with pytest.warns(FormatWarning, match="bridged gaps"):
        bridged = c3d.read(PATH, data, ReadOptions(gaps=c3d.GapPolicy(1.0)))
    np.testing.assert_allclose(bridged.values[:, 0], np.arange(30))


def test_a_part_that_is_not_there() -> None:
    data = Capture(points=np.ones((4, 2, 4))).build()
    with pytest.raises(FormatError, match="--array names points of this file"):
        c3d.read(PATH, data, ANALOG)
    only = Capture(points=np.zeros((4, 0, 4)), analog=np.arange(8.0)[:, None]).build()
    assert quiet_read(only).names == ("ch0",)
    assert quiet_read(retimed(only, Warp([0, 0.06], [0, 0.03]))).n_frames == 14


def test_results_of_a_model_have_units_of_their_own() -> None:
    def texts(items: list[str]) -> tuple[int, list[int], bytes]:
        return -1, [6, len(items)], b"".join(item.encode().ljust(6) for item in items)

    more = [("ANGLES", *texts(["LKnee"])), ("ANGLE_UNITS", *texts(["deg"]))]
    capture = Capture(points=np.ones((4, 2, 4)), labels=["LKnee", "LANK"])
    named = capture.groups(9)["POINT"]
    capture.more = {"POINT": named + more}
    kinds = quiet_read(capture.build()).kinds
    assert [str(kind) for kind in kinds] == ["linear:deg"] * 3 + ["linear:mm"] * 3


def test_numbers_of_dec_machines() -> None:
    rng = np.random.default_rng(0)
    values = np.concatenate([rng.normal(size=500) * 10.0 ** rng.integers(-30, 30, 500), [0.0, 1.0, -1.0, 2.0**-120]])
    single = values.astype(np.float32).astype(np.float64)
    packed = Numbers(DEC).pack_reals(single)
    assert packed == b"".join(real_bytes(DEC, value) for value in single)
    assert np.array_equal(Numbers(DEC).reals(packed), single)
    # Every pattern of bits is some number, and comes back; what is reserved is none.
    bits = rng.integers(0, 2**32, 4000, dtype=np.uint32).astype("<u4").tobytes()
    found = Numbers(DEC).reals(bits)
    again = Numbers(DEC).reals(Numbers(DEC).pack_reals(found))
    assert np.array_equal(found, again, equal_nan=True)


def test_a_table_becomes_a_capture(tmp_path: Path) -> None:
    rng = np.random.default_rng(4)
    names = [f"{label}.{axis}" for label in ("LANK", "RANK") for axis in "xyz"] + ["force"]
    values = rng.normal(size=(50, 7)).astype(np.float32).astype(np.float64)
    values[5:9, 1] = np.nan
    kinds = ["linear:m"] * 6 + ["linear:N"]
    signal = Signal(names, values, "60000/1001", kinds=kinds, gaps="keep")
    write(signal, tmp_path / "a.c3d")
    with pytest.raises(OutputExistsError):
        write(signal, tmp_path / "a.c3d")
    points, analog, reader = by_library((tmp_path / "a.c3d").read_bytes())
    assert reader.get("POINT:UNITS").string_value.strip() == "m"  # type: ignore[attr-defined]
    with pytest.warns(FormatWarning, match=r"LANK\.x, LANK\.y, LANK\.z frames 6:9"):
        again = read(tmp_path / "a.c3d")
    assert isinstance(again, Signal)
    assert (again.rate, again.names) == (signal.rate, signal.names[:6])
    expected = values[:, :6].copy()
    expected[5:9, :3] = np.nan
    np.testing.assert_array_equal(again.values, expected)
    np.testing.assert_array_equal(np.where(points[..., 3:4] < 0, np.nan, points[..., :3]).reshape(50, 6), expected)
    channel = read(tmp_path / "a.c3d", array="analog")
    assert isinstance(channel, Signal)
    np.testing.assert_array_equal(channel.values[:, 0], values[:, 6])
    np.testing.assert_array_equal(analog[:, 0], values[:, 6])
    assert str(channel.kinds[0]) == "linear:N"


def test_many_markers_need_several_lists(tmp_path: Path) -> None:
    names = [f"marker {i:03}.{axis}" for i in range(600) for axis in "xyz"]
    signal = Signal(names, np.arange(3600.0).reshape(2, 1800), 30)
    write(signal, tmp_path / "many.c3d")
    again = read(tmp_path / "many.c3d")
    assert isinstance(again, Signal)
    assert again.names == signal.names
    assert np.array_equal(again.values, signal.values)


def test_long_takes_are_written(tmp_path: Path) -> None:
    signal = Signal(["m.x", "m.y", "m.z"], np.arange(210_000.0).reshape(70_000, 3) % 1000, 100)
    write(signal, tmp_path / "long.c3d")
    again = read(tmp_path / "long.c3d")
    assert isinstance(again, Signal)
    assert np.array_equal(again.values, signal.values)
    assert len(by_library((tmp_path / "long.c3d").read_bytes())[0]) == 70_000


@pytest.mark.parametrize(
    ("signal", "message"),
    [
        (Signal(["pan", "tilt"], np.ones((4, 2))), "no three channels are called NAME.x, NAME.y, NAME.z"),
        (
            Signal(
                ["m.x", "m.y", "m.z", "word"], np.zeros((4, 4)), kinds={"word": c3d.ChannelKind("label", words=("a",))}
            ),
            "channel 'word' holds text",
        ),
        (Signal([f"{'m' * 200}.{axis}" for axis in "xyz"], np.ones((4, 3))), "a name of more than 127 bytes"),
        (Signal(["m.x", "m.y", "m.z"], np.full((4, 3), 1e50)), "beyond what single precision"),
    ],
)
def test_what_a_capture_cannot_hold(tmp_path: Path, signal: Signal, message: str) -> None:
    with pytest.raises(FormatError, match=message):
        write(signal, tmp_path / "a.c3d")
    assert not (tmp_path / "a.c3d").exists()


def test_in_place_by_the_registry(tmp_path: Path) -> None:
    source, place = tmp_path / "a.c3d", tmp_path / "b.c3d"
    source.write_bytes(Capture(rate=20.0, points=np.ones((40, 2, 4))).build())
    warp = Warp([0.0, 39 / 40], [0.0, 39 / 20])
    retime_file(source, place, warp)
    assert quiet_read(place.read_bytes()).n_frames == 20 + (round(39 / 40 * 20) + 1 - 20)
    with pytest.raises(OutputExistsError):
        retime_file(source, place, warp)
    with pytest.raises(OptionError, match="is one capture, and gets one warp"):
        retime_file(source, place, {"a": warp}, overwrite=True)
    with pytest.raises(FormatError, match=r"retimed in place, a \.c3d file stays one"):
        retime_file(source, tmp_path / "b.csv", warp)
    assert facts_of(source, PLAIN)["points"] == "2, in mm"


def test_real_captures_by_the_library(mocap: Path) -> None:
    for path in sorted((mocap / "c3d").glob("*.c3d")):
        data = path.read_bytes()
        points, _, _ = by_library(data)
        for share in (0.7, 1.5):
            end = (len(points) - 1) / 50
            warp = Warp([0.0, end * share], [0.0, end])
            new, _, reader = by_library(retimed(data, warp, average=False))
            assert len(new) == warp.count_frames(50)
            assert reader.point_used == points.shape[1]  # type: ignore[attr-defined]
            # Frames of both ends are the input's own.
            assert np.array_equal(new[0], points[0])
            assert np.array_equal(new[-1], points[-1])
