"""Keypoints of OpenPose and MediaPipe."""

from __future__ import annotations

import json
import warnings
from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from retime import Signal, read
from retime.errors import FormatError, FormatWarning, OptionError
from retime.formats.keypoints.layouts import BODY_25, COCO_17, COCO_18, HAND_21, MEDIAPIPE_33, MPI_15
from retime.formats.keypoints.people import apart, follow
from retime.formats.registry import format_of, write
from tests.formats.keypoint_files import landmarks, moving, openpose_people, write_openpose


def dump(path: Path, document: Any) -> Path:
    path.write_text(json.dumps(document))
    return path


def values_of(signal: Signal, person: str = "") -> np.ndarray:
    """Return the places of a person's points, (n_frames, n_points, n_axes)."""
    n_axes = 3 if any(name.endswith(".z") for name in signal.names) else 2
    columns = [place for place, name in enumerate(signal.names) if name.startswith(person)]
    return signal.values[:, columns].reshape(signal.n_frames, -1, n_axes)


# OpenPose.


@pytest.mark.parametrize(("n_points", "names"), [(25, BODY_25), (18, COCO_18), (17, COCO_17), (15, MPI_15)])
def test_a_folder_of_openpose(tmp_path, n_points, names) -> None:
    poses = moving(20, n_points, seed=n_points, n_axes=2)
    sure = np.full(n_points, 0.8)
    folder = write_openpose(tmp_path / "out", [openpose_people([pose], [sure]) for pose in poses], first=7)
    signal = read(folder, rate=30)
    assert signal.names == tuple(f"{name}.{axis}" for name in names for axis in "xy")
    np.testing.assert_array_equal(values_of(signal), poses)
    assert (signal.rate, signal.first_frame) == (30, 7)
    assert signal.dialect.startswith("OpenPose")
    by_pattern = read(folder / "take_%012d_keypoints.json", rate="30000/1001")
    np.testing.assert_array_equal(by_pattern.values, signal.values)
    assert by_pattern.rate == Fraction(30000, 1001)


def test_places_of_both_sides_are_not_swapped() -> None:
    # From the lists of points in OpenPose's and MediaPipe's documentation.
    assert (BODY_25.index("right_wrist"), BODY_25.index("left_wrist"), BODY_25.index("mid_hip")) == (4, 7, 8)
    assert (BODY_25.index("left_big_toe"), BODY_25.index("right_heel")) == (19, 24)
    assert (COCO_18.index("right_hip"), COCO_18.index("left_ear")) == (8, 17)
    assert (COCO_17.index("left_eye"), COCO_17.index("right_ankle")) == (1, 16)
    assert (MEDIAPIPE_33.index("left_shoulder"), MEDIAPIPE_33.index("right_foot_index")) == (11, 32)
    assert (MEDIAPIPE_33.index("left_ankle"), HAND_21.index("pinky_tip")) == (27, 20)
    assert len(set(MEDIAPIPE_33)) == 33
    assert len(set(HAND_21)) == 21


@pytest.mark.parametrize("seed", range(5))
def test_people_are_followed_whatever_their_order(tmp_path, seed) -> None:
    """Two walk past each other, a third is there for a while; each frame names them in any order."""
    chance = np.random.default_rng(seed)
    body = chance.uniform(0, 100, (25, 2)) + np.array([0, 200])
    n_frames = 60
    paths = [lambda f: (4.0 * f, 0.0), lambda f: (600 - 4.0 * f, 150.0), lambda f: (900.0, 2.0 * f)]
    there = [range(n_frames), range(n_frames), range(10, 40)]
    frames = []
    for frame in range(n_frames):
        who = [one for one in range(3) if frame in there[one]]
        chance.shuffle(who)
        poses = [body + np.array(paths[one](frame)) for one in who]
        frames.append(openpose_people(poses, [np.full(25, 0.9)] * len(who)))
    folder = write_openpose(tmp_path / "out", frames)
    with pytest.warns(FormatWarning, match="kept gaps|bridged gaps"):
        signal = read(folder, rate=30, gaps="keep")
    # They are numbered by when they come, in one frame by the file: so find each by where they stand.
    assert len(signal.names) == 3 * 50
    for one in range(3):
        at = there[one][0]
        wanted = body + np.array(paths[one](at))
        person = next(
            f"person{number}."
            for number in (1, 2, 3)
            if np.allclose(values_of(signal, f"person{number}.")[at], wanted, equal_nan=True)
        )
        found = values_of(signal, person)
        for frame in range(n_frames):
            expected = body + np.array(paths[one](frame)) if frame in there[one] else np.full((25, 2), np.nan)
            np.testing.assert_allclose(found[frame], expected)


def test_who_is_hardly_ever_there_is_left_out(tmp_path) -> None:
    poses = moving(40, 25, n_axes=2)
    frames = [openpose_people([pose], [np.ones(25)]) for pose in poses]
    frames[5] = openpose_people([poses[5] + 30, poses[5]], [np.ones(25)] * 2)
    with pytest.warns(FormatWarning, match="1 more people"):
        signal = read(write_openpose(tmp_path / "out", frames), rate=30)
    np.testing.assert_array_equal(values_of(signal), poses)


def test_points_of_little_confidence_are_missing(tmp_path) -> None:
    poses = moving(30, 25, n_axes=2)
    sure = np.full((30, 25), 0.9)
    sure[10:15, 4] = 0.25
    sure[20, 7] = 0
    sure[:, 24] = 0
    folder = write_openpose(tmp_path / "out", [openpose_people([p], [s]) for p, s in zip(poses, sure, strict=True)])

    def told(**how: Any) -> tuple[np.ndarray, str]:
        with warnings.catch_warnings(record=True) as caught:
            warnings.simplefilter("always")
            signal = read(folder, rate=30, **how)
        return values_of(signal), " ".join(str(one.message) for one in caught)

    wanted = poses[:, :24].copy()
    wanted[10:15, 4] = wanted[20, 7] = np.nan
    found, words = told(gaps="keep")
    np.testing.assert_array_equal(found, wanted)
    assert "left out: right_heel" in words
    assert "kept gaps: right_wrist.x, right_wrist.y frames 10:14; left_wrist.x, left_wrist.y frames 20" in words
    wanted[10:15, 4] = poses[10:15, 4]
    found, words = told(gaps="keep", confidence=0.2)
    np.testing.assert_array_equal(found, wanted)
    assert "right_wrist" not in words
    # Short gaps are bridged where nothing is said, from side to side: the paths bend a little between.
    found, words = told()
    assert "bridged gaps: right_wrist" in words
    np.testing.assert_allclose(found, poses[:, :24], atol=0.03)
    with pytest.raises(OptionError, match="confidence"):
        read(folder, rate=30, confidence=1.5)


def test_a_frame_with_nobody_is_a_gap(tmp_path) -> None:
    poses = moving(12, 18, n_axes=2)
    frames = [openpose_people([pose], [np.ones(18)]) for pose in poses]
    frames[0] = frames[6] = {"version": 1.3, "people": []}
    with pytest.warns(FormatWarning, match="gaps"):
        found = values_of(read(write_openpose(tmp_path / "out", frames), rate=30, gaps="keep"))
    poses[[0, 6]] = np.nan
    np.testing.assert_array_equal(found, poses)


def test_three_axes_of_openpose(tmp_path) -> None:
    poses = moving(8, 25)
    people = [
        {"people": [{"pose_keypoints_2d": [], "pose_keypoints_3d": np.column_stack([p, np.ones(25)]).ravel().tolist()}]}
        for p in poses
    ]
    np.testing.assert_array_equal(values_of(read(write_openpose(tmp_path / "out", people), rate=30)), poses)
    # The same frames in one file.
    whole = dump(tmp_path / "all.json", {"fps": 24, "frames": people})
    np.testing.assert_array_equal(values_of(read(whole)), poses)
    assert read(whole).rate == 24


def test_folders_that_are_none(tmp_path) -> None:
    with pytest.raises(FormatError, match=r"no file in it is called …_keypoints\.json"):
        read(tmp_path, rate=30)
    person = openpose_people([moving(1, 25, n_axes=2)[0]], [np.ones(25)])
    folder = write_openpose(tmp_path / "out", [person] * 3)
    with pytest.raises(FormatError, match=r"how many frames a second.*--fps"):
        read(folder)
    one = folder / "take_000000000001_keypoints.json"
    with pytest.raises(FormatError, match=r"one frame of OpenPose: .*take_%012d_keypoints\.json"):
        read(one, rate=30)
    with pytest.raises(FormatError, match="no file is called so"):
        read(folder / "other_%012d_keypoints.json", rate=30)
    write_openpose(folder, [person] * 2, take="second")
    with pytest.raises(FormatError, match="holds 2 takes"):
        read(folder, rate=30)
    assert read(folder / "second_%012d_keypoints.json", rate=30).n_frames == 2
    one.write_text('{"people": [{"pose_keypoints_2d": [1, 2]}]}')
    with pytest.raises(FormatError, match="3 numbers for each point") as caught:
        read(folder / "take_%012d_keypoints.json", rate=30)
    assert caught.value.path == str(one)
    one.unlink()
    with pytest.raises(FormatError, match="frame 1 is missing between 0 and 2"):
        read(folder / "take_%012d_keypoints.json", rate=30)


def test_far_apart_is_somebody_else() -> None:
    body = np.random.default_rng(0).uniform(0, 1, (5, 2))
    people = follow([(0, [body]), (1, [body + 0.01, body + 5]), (2, [body + 5.02])])
    assert [sorted(one.poses) for one in people] == [[0, 1], [1, 2]]
    assert apart(body, body + np.array([0, 3])) == pytest.approx(3 / np.hypot(*np.ptp(body, axis=0)))
    # After long nobody is the same.
    assert len(follow([(0, [body]), (500, [body])])) == 2


# MediaPipe.


POSES = moving(16, 33, seed=3)
LISTS = landmarks(POSES)
SHAPES: dict[str, Any] = {
    "a list of lists": LISTS,
    "frames of an object": {"fps": 30, "frames": LISTS},
    "data of an object with metadata": {"metadata": {"fps": 30, "width": 640}, "data": LISTS},
    "objects with landmarks": [{"frame": n, "landmarks": one} for n, one in enumerate(LISTS)],
    "what the Python solutions are called": [{"frame_number": n, "pose_landmarks": o} for n, o in enumerate(LISTS)],
    "what the page's solutions are called": [{"poseLandmarks": one, "faceLandmarks": []} for one in LISTS],
    "messages as JSON": [{"poseLandmarks": {"landmark": one}} for one in LISTS],
    "the tasks, a list of people": [{"landmarks": [one], "worldLandmarks": [one]} for one in LISTS],
    "by number": {str(number): {"landmarks": one} for number, one in enumerate(LISTS)},
    "lists of numbers": [[[*p.tolist(), 0.9] for p in pose] for pose in POSES],
    "all numbers in a row": [
        {"pose": np.column_stack([pose, np.full(33, 0.9)]).ravel().tolist()} for pose in POSES
    ],
    "by name": [
        {"landmarks": {name.upper(): point for name, point in zip(MEDIAPIPE_33, one, strict=True)}} for one in LISTS
    ],
    "with names": [
        [{"name": name, **point} for name, point in zip(MEDIAPIPE_33, one, strict=True)][:: -1 if n % 2 else 1]
        for n, one in enumerate(LISTS)
    ],
}  # fmt: skip


@pytest.mark.parametrize("shape", SHAPES)
def test_ways_to_write_what_mediapipe_finds(tmp_path, shape) -> None:
    document = SHAPES[shape]
    path = dump(tmp_path / "a.json", document)
    signal = read(path, rate=30)
    assert [name.lower() for name in signal.names] == [f"{name}.{axis}" for name in MEDIAPIPE_33 for axis in "xyz"]
    np.testing.assert_array_equal(values_of(signal), POSES)
    if "fps" in json.dumps(document):
        assert read(path).rate == 30
        assert read(path, rate=25).rate == 25
    else:
        with pytest.raises(FormatError, match="--fps"):
            read(path)


def test_times_tell_the_rate(tmp_path) -> None:
    for key, scale in (
        ("timestamp_ms", 1000),
        ("timestamp", 1),
        ("timestamp", 1000),
        ("time", 1),
        ("timestampUs", 1e6),
    ):
        frames = [{key: round(n * scale / 25, 3), "landmarks": one} for n, one in enumerate(LISTS)]
        assert read(dump(tmp_path / "a.json", frames)).rate == 25, (key, scale)


def test_frames_that_were_left_out_are_gaps(tmp_path) -> None:
    """Many write only frames in which somebody was found: by their numbers the others are known."""
    kept = [n for n in range(16) if n not in (4, 5, 9)]
    frames = [{"frame": n + 3, "timestamp": n / 30, "landmarks": LISTS[n]} for n in kept]
    with pytest.warns(FormatWarning, match="kept gaps"):
        signal = read(dump(tmp_path / "a.json", frames), gaps="keep")
    wanted = POSES.copy()
    wanted[[4, 5, 9]] = np.nan
    np.testing.assert_array_equal(values_of(signal), wanted)
    assert (signal.rate, signal.first_frame) == (30, 3)
    written = [{"landmarks": None if n in (4, 5, 9) else LISTS[n]} for n in range(16)]
    with pytest.warns(FormatWarning, match="kept gaps"):
        again = read(dump(tmp_path / "b.json", written), rate=30, gaps="keep")
    np.testing.assert_array_equal(again.values, signal.values)


def test_uneven_times_are_laid_on_even_frames(tmp_path) -> None:
    times = [0, 0.033, 0.067, 0.133, 0.167, 0.2, 0.31]
    frames = [{"t": t, "landmarks": LISTS[n]} for n, t in enumerate(times)]
    with pytest.warns(FormatWarning, match="uneven|gaps"):
        signal = read(dump(tmp_path / "a.json", frames), gaps="keep")
    assert signal.rate == 30
    wanted = np.full((10, 33, 3), np.nan)
    for place, frame in zip((0, 1, 2, 4, 5, 6, 9), range(7), strict=True):
        wanted[place] = POSES[frame]
    np.testing.assert_array_equal(values_of(signal), wanted)


def test_visibility_counts_as_confidence(tmp_path) -> None:
    frames = landmarks(POSES)
    frames[3][15]["visibility"] = 0.1
    with pytest.warns(FormatWarning, match=r"kept gaps: left_wrist\.x, .* frames 3"):
        signal = read(dump(tmp_path / "a.json", frames), rate=30, gaps="keep")
    assert np.isnan(values_of(signal)[3, 15]).all()
    assert int(np.isnan(signal.values).sum()) == 3


def test_hands_are_read_where_there_is_no_body(tmp_path) -> None:
    poses = moving(6, 21)
    frames = [{"hand_landmarks": [one], "handedness": "Left"} for one in landmarks(poses)]
    signal = read(dump(tmp_path / "a.json", frames), rate=30)
    assert signal.names[:3] == ("wrist.x", "wrist.y", "wrist.z")
    np.testing.assert_array_equal(values_of(signal), poses)


def test_no_visibility_of_hands_is_none(tmp_path) -> None:
    """MediaPipe says 0 for all points of hands; a body's are never all 0."""
    poses = moving(6, 21)
    frames = [{"hand_landmarks": one} for one in landmarks(poses, visibility=0.0)]
    np.testing.assert_array_equal(values_of(read(dump(tmp_path / "a.json", frames), rate=30)), poses)


def test_the_body_is_read_in_all_frames_or_nobody_is_there(tmp_path) -> None:
    """Dumps leave out what was not found, so that one frame may have but a hand."""
    hand = landmarks(moving(1, 21))[0]
    frames = [{"left_hand_landmarks": hand}, *({"pose_landmarks": one, "left_hand_landmarks": hand} for one in LISTS)]
    frames[5] = {"left_hand_landmarks": hand, "pose_landmarks": None}
    with pytest.warns(FormatWarning, match="kept gaps"):
        signal = read(dump(tmp_path / "a.json", frames), rate=30, gaps="keep")
    wanted = np.concatenate([np.full((1, 33, 3), np.nan), POSES])
    wanted[5] = np.nan
    np.testing.assert_array_equal(values_of(signal), wanted)


BROKEN: dict[str, tuple[Any, str]] = {
    "empty": ("", "empty; expected keypoints"),
    "no JSON": ("frames: 3", "not JSON"),
    "cut": ('[{"landmarks": [{"x": 1,', "not JSON"),
    "NaN": ('[[{"x": NaN, "y": 0}]]', "NaN is not a number"),
    "too large": ('[[{"x": 1e999, "y": 0}, {"x": 1, "y": 0}]]', "too large"),
    "too large, exactly": (f'[[{{"x": {10**300}, "y": 0}}, {{"x": 1, "y": 0}}]]', "too large"),
    "text for a number": ([[{"x": "0.5", "y": 0}]], "expected a number, found '0.5'"),
    "a truth for a number": ([[{"x": True, "y": 0}]], "expected a number, found"),
    "no y": ([[{"x": 1, "z": 2}, {"x": 1, "y": 2}]], "point 0: expected x and y, found an object with x, z"),
    "nothing": ([], "no frame"),
    "nobody": ([None, [], {"landmarks": None}], "nobody is found"),
    "other points later": ([LISTS[0], LISTS[1][:20]], "a person of 20 points .* after one of 33"),
    "a warp": ({"retime_warp": 1, "output_times": [0, 1]}, "no keypoints of OpenPose or MediaPipe.*retime_warp"),
    "a number": ("3", "no keypoints of OpenPose or MediaPipe"),
    "numbers that go back": ([{"frame": 2, "landmarks": LISTS[0]}, {"frame": 1, "landmarks": LISTS[1]}], "increase"),
    "a number too far": ([{"frame": 0, "landmarks": LISTS[0]}, {"frame": 10**9, "landmarks": LISTS[1]}], "limit"),
    "times of some": ([{"time": 0, "landmarks": LISTS[0]}, {"landmarks": LISTS[1]}], "frame 1 has none"),
    "frames of words": (["a", "b"], "frame 0: expected landmarks, found 'a'"),
    "nested deeply": ("[" * 2000 + "]" * 2000, "deep"),
    "a rate that is none": ({"fps": -3, "frames": LISTS}, "fps"),
    "people that are none": ({"frames": [{"people": [3]}]}, "expected an object"),
}


@pytest.mark.parametrize("kind", BROKEN)
def test_what_is_broken_is_refused(tmp_path, kind) -> None:
    content, words = BROKEN[kind]
    path = tmp_path / "a.json"
    path.write_text(content if isinstance(content, str) else json.dumps(content))
    with pytest.raises(FormatError, match=words) as caught:
        read(path, rate=None if "times" in kind or "rate" in kind else 30)
    assert caught.value.path == str(path)


def test_frames_are_not_made_on_the_word_of_one_time(tmp_path) -> None:
    """A time that is hours off would make 300,000 frames of five, of 245 MB; so would a number."""
    times = [0, 33, 66, 99, 1e7]
    content = [{"timestamp_ms": time, "landmarks": one} for time, one in zip(times, LISTS, strict=False)]
    (tmp_path / "a.json").write_text(json.dumps(content))
    with (
        pytest.warns(FormatWarning, match="uneven"),
        pytest.raises(FormatError, match=r"from frame 3 on to 300000 nothing .* 300001 frames .* made of 5; is that"),
    ):
        read(tmp_path / "a.json")
    numbers = [{"frame": number, "landmarks": one} for number, one in zip((7, 8, 90_008), LISTS, strict=False)]
    (tmp_path / "b.json").write_text(json.dumps(numbers))
    with pytest.raises(FormatError, match="from frame 8 on to 90008 nothing"):
        read(tmp_path / "b.json", rate=30)
    # A pause of minutes is no such thing.
    content[4]["timestamp_ms"] = 300_000
    (tmp_path / "a.json").write_text(json.dumps(content))
    with pytest.warns(FormatWarning):
        assert read(tmp_path / "a.json").n_frames == 9001


def test_a_picture_called_json_is_named(tmp_path) -> None:
    (tmp_path / "a.json").write_bytes(b"\x89PNG\r\n\x1a\n....")
    with pytest.raises(FormatError, match="a PNG picture"):
        read(tmp_path / "a.json")


def test_keypoints_are_not_written(tmp_path) -> None:
    signal = Signal(("x",), np.zeros((2, 1)), Fraction(30))
    with pytest.raises(FormatError, match="can be read, but not written"):
        write(signal, tmp_path / "a.json")
    assert format_of(tmp_path).name == "keypoints"
