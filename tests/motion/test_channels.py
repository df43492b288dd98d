from __future__ import annotations

import numpy as np
import pytest

from retime.errors import InvalidMotionError, OptionError
from retime.motion.channels import (
    LINEAR,
    ChannelKind,
    find_kinds,
    matching,
    parse_channel,
    quaternion_groups,
    text_label,
)
from retime.motion.signal import Signal


def found(name: str, *values: float) -> str:
    return str(find_kinds([name], np.array(values, dtype=float)[:, None])[0])


@pytest.mark.parametrize(
    ("name", "values", "kind"),
    [
        ("yaw_deg", (10, 20, 30), "angle:deg"),
        ("head yaw (deg)", (10, 20, 30), "angle:deg"),
        ("bend_rad", (0.1, 0.2), "angle:rad"),
        # A radius or a radiation is none.
        ("wheel_rad", (300.5, 301.5), "linear"),
        ("yaw", (178, 179, -179, -178), "angle:deg"),
        ("Heading", (359, 1, 2), "angle:deg"),
        ("camYaw", (3.1, -3.1), "angle:rad"),
        # It doesn't go round: linear shows the same.
        ("yaw", (10, 20, 30), "linear"),
        ("pitch", (110.5, 440.25, 108.0), "linear"),
        ("left_contact", (0, 0, 1, 1), "label"),
        ("LeftFootContact", (0, 0, 1, 1), "label"),
        ("action_id", (0, 7, 7, 0, 0, 0), "label"),
        ("action_id", (0, 7.5), "linear"),
        # So many different whole numbers are counts.
        ("id", tuple(range(100)), "linear"),
        ("x", (0, 1, 1, 0), "linear"),
        ("snout.likelihood", (0.9, 1.0, 0.2), "linear:likelihood"),
        ("likelihood", (0.9, -12.0), "linear"),
        ("score", (90, 80), "linear"),
        ("timestamp", (0.1, 0.2, 0.3), "time:s"),
        ("timestamp", (0.3, 0.2, 0.3), "linear"),
        ("events", (0, 1, *([0] * 18)), "event"),
        ("", (0, 1), "linear"),
    ],
)
def test_kinds_are_found_where_name_and_values_agree(name: str, values: tuple[float, ...], kind: str) -> None:
    assert found(name, *values) == kind


@pytest.mark.parametrize(
    "names",
    [("qw", "qx", "qy", "qz"), ("rot.x", "rot.y", "rot.z", "rot.w"), ("Head_QX", "Head_QY", "Head_QZ", "Head_QW")],
)
def test_four_columns_of_unit_length_are_a_rotation(names) -> None:
    values = np.random.default_rng(3).normal(size=(20, 4))
    unit = values / np.linalg.norm(values, axis=1, keepdims=True)
    assert find_kinds(names, unit) == (ChannelKind("quaternion"),) * 4
    assert set(find_kinds(names, values)) == {LINEAR}


def test_rotations_are_put_together_by_name_in_any_order() -> None:
    names = ["a.qx", "b.qx", "x", "a.qy", "b.qy", "a.qz", "b.qz", "b.qw", "a.qw"]
    kinds = [LINEAR if name == "x" else ChannelKind("quaternion") for name in names]
    groups = {tuple(sorted(names[place] for place in four)) for four in quaternion_groups(names, kinds)}
    assert groups == {tuple(f"{joint}.q{axis}" for axis in "wxyz") for joint in "ab"}
    numbered = [f"c{i}" for i in range(8)]
    assert quaternion_groups(numbered, [ChannelKind("quaternion")] * 8) == [(0, 1, 2, 3), (4, 5, 6, 7)]
    with pytest.raises(OptionError, match="four columns; found 3: c0, c1, c2"):
        quaternion_groups(numbered[:3], [ChannelKind("quaternion")] * 3)


def test_kinds_are_told_by_patterns() -> None:
    values = np.arange(12.0).reshape(4, 3)
    signal = Signal(("a_yaw", "b_yaw", "x"), values, kinds={"*_yaw": "angle:rad", "b_yaw": "label"})
    assert list(map(str, signal.kinds)) == ["angle:rad", "label", "linear"]
    with pytest.raises(OptionError, match=r"no channel is called 'z\*'; there are a_yaw, b_yaw, x"):
        Signal(("a_yaw", "b_yaw", "x"), values, kinds={"z*": "label"})
    # A name with signs of a pattern is a name first.
    assert matching("a[0]", ["a0", "a[0]"]) == [1]


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("yaw", "expected a channel and its kind"),
        ("=label", "expected a channel and its kind"),
        ("yaw=turn", "the kind of a channel is one of linear, angle"),
        ("yaw=angle:grad", "an angle is in deg or rad; found 'grad'"),
        ("yaw=label:deg", "a label has no unit"),
        ("t=time:h", "a time is in s or ms or us or frames"),
    ],
)
def test_a_kind_that_is_none_is_refused(text: str, message: str) -> None:
    with pytest.raises(OptionError, match=message):
        parse_channel(text)


def test_a_channel_is_told_in_a_word() -> None:
    assert parse_channel("a=b = angle") == ("a=b", ChannelKind("angle", "deg"))
    assert parse_channel("x=linear:cm") == ("x", ChannelKind("linear", "cm"))


@pytest.mark.parametrize(
    ("texts", "codes", "words"),
    [
        (["walk", "run", "walk"], [0, 1, 0], ("walk", "run")),
        (["TRUE", "FALSE"], [1, 0], ("FALSE", "TRUE")),
        (["True", "True"], [1, 1], ("False", "True")),
    ],
)
def test_words_are_numbered(texts, codes, words) -> None:
    found, kind = text_label(texts)
    assert (found.tolist(), kind.words) == (codes, words)
    signal = Signal(("said",), found[:, None], kinds=[kind])
    assert signal.texts("said") == texts
    # What is said of it leaves its words.
    assert Signal(("said",), found[:, None], kinds=signal.kinds).kinds[0].words == words
    with pytest.raises(InvalidMotionError, match=rf"'said' at frame 0 is {len(words)}, but it has {len(words)} words"):
        Signal(("said",), [[len(words)]], kinds=[kind])


def test_only_text_has_words() -> None:
    with pytest.raises(OptionError, match="channel 'x' holds no text: it is linear"):
        Signal(("x",), [[1.0]]).texts("x")
    with pytest.raises(OptionError, match="only a label has words"):
        ChannelKind("linear", words=("a",))


def test_a_rotation_of_no_length_is_refused() -> None:
    values = np.array([[1.0, 0, 0, 0], [0, 0, 0, 0]])
    with pytest.raises(InvalidMotionError, match="qw, qx, qy, qz at frame 1 are all 0, which is no rotation"):
        Signal(("qw", "qx", "qy", "qz"), values, kinds=["quaternion"] * 4)
