"""Who is who from frame to frame: detectors of several people number them anew in each."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from retime.arrays import FloatArray
from retime.brief import brief_repr

# A person is looked for where they were last seen, for so many frames, within this share of their own size.
_REMEMBERED, _FARTHEST = 90, 0.6


@dataclass(eq=False)
class Person:
    """Somebody who was seen.

    Attributes
    ----------
    poses : dict of int to float array, shape (n_points, n_axes)
        By frames; a point that isn't there is not a number.
    last_frame : int
        The frame in which they were last seen.
    """

    poses: dict[int, FloatArray] = field(default_factory=dict)
    last_frame: int = -1

    __repr__ = brief_repr

    @property
    def last_pose(self) -> FloatArray:
        """The pose in which they were last seen."""
        return self.poses[self.last_frame]

    def see(self, frame: int, pose: FloatArray) -> None:
        """Add a pose."""
        self.poses[frame] = pose
        self.last_frame = frame


def follow(frames: Sequence[tuple[int, Sequence[FloatArray]]]) -> list[Person]:
    """Find the people behind the poses of each frame.

    The pair of a person and a pose that are nearest to one another are the same, then the next ones; a pose that is
    near nobody, or where nobody is left, is somebody new. Near is counted by the points that both have.

    Parameters
    ----------
    frames : sequence of (int, sequence of float array, shape (n_points, n_axes))
        Increasing frames, and the poses in each.

    Returns
    -------
    list of Person
        In the order in which they come into the picture; in one frame, that of the file.
    """
    people: list[Person] = []
    for frame, poses in frames:
        near = [one for one in people if frame - one.last_frame <= _REMEMBERED]
        pairs = sorted(
            (distance, who, which)
            for who, person in enumerate(near)
            for which, pose in enumerate(poses)
            if (distance := apart(person.last_pose, pose)) <= _FARTHEST
        )
        taken_people: set[int] = set()
        taken_poses: set[int] = set()
        for _, who, which in pairs:
            if who not in taken_people and which not in taken_poses:
                near[who].see(frame, poses[which])
                taken_people.add(who)
                taken_poses.add(which)
        for which, pose in enumerate(poses):
            if which not in taken_poses:
                people.append(Person())
                people[-1].see(frame, pose)
    return people


def apart(before: FloatArray, after: FloatArray) -> float:
    """Return how far two poses are apart in the picture (their first two axes), in sizes of the larger one.

    Without a point in common they are infinitely far.

    Examples
    --------
    >>> square = np.array([[0.0, 0], [0, 3], [4, 3], [4, 0]])
    >>> apart(square, square + [2, 0]), apart(square, square * np.nan)
    (0.4, inf)
    """
    both = np.isfinite(before[:, :2]).all(axis=1) & np.isfinite(after[:, :2]).all(axis=1)
    if not both.any():
        return float("inf")
    size = max(_size(before[:, :2]), _size(after[:, :2]), 1e-9)
    return float(np.hypot(*(before[both, :2] - after[both, :2]).T).mean()) / size


def _size(points: FloatArray) -> float:
    """Return the diagonal of what encloses points."""
    low, high = np.nanmin(points, axis=0), np.nanmax(points, axis=0)
    return float(np.hypot(*(high - low)))
