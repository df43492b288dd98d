from __future__ import annotations

import numpy as np
import pytest

from retime.errors import InvalidMotionError
from retime.motion.skeleton import EndSite, Skeleton

OFFSETS = np.arange(12.0).reshape(4, 3)


def skeleton(**changes) -> Skeleton:
    parts = {"names": ("hip", "left", "right", "foot"), "parents": (-1, 0, 0, 1), "offsets": OFFSETS, **changes}
    return Skeleton(**parts)


def test_joints_are_found_by_name_and_by_parent() -> None:
    body = skeleton()
    assert body.n_joints == 4
    assert body.index("foot") == 3
    assert [body.children(joint) for joint in range(4)] == [(1, 2), (3,), (), ()]


def test_of_a_repeated_name_the_first_joint_is_found() -> None:
    assert skeleton(names=("a", "b", "b", "a")).index("b") == 1


def test_an_unknown_name_is_answered_with_the_known_ones() -> None:
    with pytest.raises(KeyError, match="no joint is called 'knee'; there are hip, left, right, foot"):
        skeleton().index("knee")


def test_a_lone_root_is_a_skeleton() -> None:
    lone = Skeleton(("root",), (-1,), np.zeros((1, 3)))
    assert (lone.n_joints, lone.children(0)) == (1, ())


def test_offsets_cannot_be_changed_from_outside_nor_inside() -> None:
    offsets = OFFSETS.copy()
    body = skeleton(offsets=offsets)
    offsets[0, 0] = 99.0
    assert body.offsets[0, 0] == 0.0
    with pytest.raises(ValueError, match="read-only"):
        body.offsets[0, 0] = 1.0


def test_offsets_may_be_given_as_lists_of_integers() -> None:
    assert skeleton(offsets=OFFSETS.astype(int).tolist()).offsets.dtype == np.float64


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"names": (), "parents": (), "offsets": np.zeros((0, 3))}, "0 names, 0 parents"),
        ({"names": ("hip", "left", "right")}, "3 names, 4 parents"),
        ({"parents": (-1, 0, 0)}, "4 names, 3 parents"),
        ({"offsets": np.zeros((4, 2))}, r"offsets of shape \(4, 2\)"),
        ({"offsets": np.zeros((3, 3))}, r"offsets of shape \(3, 3\)"),
        ({"parents": (-1, 0, -1, 1)}, r"joint 'right' \(2\) has parent -1"),
        ({"parents": (-1, 0, 3, 1)}, r"joint 'right' \(2\) has parent 3"),
        ({"parents": (-1, 0, 2, 1)}, r"joint 'right' \(2\) has parent 2"),
        ({"parents": (-1, 0, -2, 1)}, r"joint 'right' \(2\) has parent -2"),
        ({"parents": (0, 0, 0, 1)}, r"joint 'hip' \(0\) has parent 0"),
        ({"offsets": np.where(OFFSETS == 7, np.nan, OFFSETS)}, "offset of joint 'right' is not finite"),
        ({"offsets": np.where(OFFSETS == 9, np.inf, OFFSETS)}, "offset of joint 'foot' is not finite"),
        ({"end_sites": (EndSite(4, (0, 0, 0)),)}, "an end site belongs to joint 4, of 4"),
        ({"end_sites": (EndSite(-1, (0, 0, 0)),)}, "an end site belongs to joint -1, of 4"),
        ({"end_sites": (EndSite(3, (0, np.nan, 0)),)}, "the end site of 'foot' is not finite"),
        ({"end_sites": (EndSite(3, (0, 0)),)}, "the end site of 'foot' has 2 coordinates, not 3"),
    ],
)
def test_what_is_no_tree_is_refused(changes, message: str) -> None:
    with pytest.raises(InvalidMotionError, match=message):
        skeleton(**changes)
