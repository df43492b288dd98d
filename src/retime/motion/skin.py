"""A character's own skin: a mesh whose points follow joints, to look at. The search knows nothing of it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from retime.arrays import FloatArray
from retime.brief import brief_repr

MOST_POINTS = 300_000
"""Points that are drawn at most: a page has to draw them, and a person to look at them."""


# Single precision, in which a mesh is drawn, ends at 3e38.
_LARGEST = 1e30


def is_usable(*arrays: FloatArray) -> bool:
    """Tell whether all numbers are finite, and small enough to be drawn."""
    return all(bool((np.abs(array) <= _LARGEST).all()) for array in arrays)


@dataclass(frozen=True, eq=False)
class Skin:
    """Triangles whose corners follow up to four joints each.

    A corner is, at any time, the sum over what it follows of ``weight * (turn @ (bone[:, :3] @ point + bone[:, 3]) +
    place)``, with the global turn and place of the bone's joint.

    Attributes
    ----------
    points : float array, shape (n_points, 3)
        In the mesh's own space.
    triangles : int array, shape (n_triangles, 3)
        Corners, by their places in `points`.
    bones : float array, shape (n_bones, 3, 4)
        From the mesh's space to that of a joint, in the motion's units.
    joints : int array, shape (n_bones,)
        The joint of each bone, in the motion's skeleton.
    follows : int array, shape (n_points, 4)
        Bones that a point follows.
    weights : float array, shape (n_points, 4)
        How much; each row adds up to 1.
    """

    points: FloatArray
    triangles: NDArray[np.int32]
    bones: FloatArray
    joints: NDArray[np.int32]
    follows: NDArray[np.int32]
    weights: FloatArray

    __repr__ = brief_repr

    def kept(self, joints: list[int]) -> Skin | None:
        """Return it for a motion that has some of the joints, by their new places; None where nothing follows those.

        Points that follow a joint which is not among them are left out, and their triangles with them.
        """
        place = np.full(max([*joints, *self.joints.tolist(), 0]) + 1, -1)
        place[joints] = np.arange(len(joints))
        found = place[self.joints]
        held = ((found[self.follows] >= 0) | (self.weights == 0)).all(axis=1)
        triangles = self.triangles[held[self.triangles].all(axis=1)]
        if len(triangles) == 0:
            return None
        return Skin(
            self.points, triangles, self.bones, np.maximum(found, 0).astype(np.int32), self.follows, self.weights
        )
