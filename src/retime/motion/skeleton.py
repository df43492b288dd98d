"""The skeleton: joint names, parents and rest offsets."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from retime.arrays import FloatArray, as_real
from retime.brief import kind_of
from retime.errors import InvalidMotionError
from retime.motion.size import size_problem, within_size


@dataclass(frozen=True)
class EndSite:
    """The far end of a joint that has no children.

    Attributes
    ----------
    parent : int
        The joint that it belongs to.
    offset : tuple of float
        Its place in that joint's space, in the motion's length unit.
    """

    parent: int
    offset: tuple[float, float, float]


@dataclass(frozen=True, eq=False)
class Skeleton:
    """A tree of joints.

    Parameters
    ----------
    names : tuple of str
        Joint names, root first. Files may repeat a name; `index` finds the first.
    parents : tuple of int
        Each joint's parent, which stands before it; -1 for the root.
    offsets : float array, shape (n_joints, 3)
        Rest offset of each joint from its parent, in the motion's length unit.
    end_sites : tuple of EndSite
        Far ends of the last joints.

    Raises
    ------
    InvalidMotionError
        The lengths differ, a parent does not stand before its child, there is not exactly one root, or an offset is not
        finite or beyond 1e100.
    """

    names: tuple[str, ...]
    parents: tuple[int, ...]
    offsets: FloatArray
    end_sites: tuple[EndSite, ...] = ()

    # What the constructor takes. A dataclass alone could declare only what its fields hold afterwards.
    if TYPE_CHECKING:

        def __init__(
            self,
            names: Sequence[str],
            parents: Sequence[int],
            offsets: ArrayLike,
            end_sites: Sequence[EndSite] = (),
        ) -> None: ...

    def __post_init__(self) -> None:
        if isinstance(self.names, str):
            raise InvalidMotionError(f"a skeleton's names are a text for each joint, found {kind_of(self.names)}")
        for what in ("names", "parents", "end_sites"):
            object.__setattr__(self, what, tuple(getattr(self, what)))
        offsets = as_real(self.offsets, "offsets").copy()
        n_joints = len(self.names)
        if n_joints == 0 or len(self.parents) != n_joints or offsets.shape != (n_joints, 3):
            raise InvalidMotionError(
                f"a skeleton needs as many names, parents and offsets: {n_joints} names, "
                f"{len(self.parents)} parents, offsets of shape {offsets.shape}"
            )
        for joint, parent in enumerate(self.parents):
            if (parent == -1) != (joint == 0) or not -1 <= parent < joint:
                raise InvalidMotionError(
                    f"joint {self.names[joint]!r} ({joint}) has parent {parent}: the root comes first, and every "
                    "parent before its children"
                )
        for site in self.end_sites:
            if not 0 <= site.parent < n_joints:
                raise InvalidMotionError(f"an end site belongs to joint {site.parent}, of {n_joints}")
            if len(site.offset) != 3:
                raise InvalidMotionError(
                    f"the end site of {self.names[site.parent]!r} has {len(site.offset)} coordinates, not 3"
                )
            if not within_size(as_real(site.offset, "the offset of an end site")).all():
                problem = size_problem(site.offset)
                raise InvalidMotionError(f"the offset of the end site of {self.names[site.parent]!r} {problem}")
        if not within_size(offsets).all():
            joint = int(np.argwhere(~within_size(offsets))[0, 0])
            raise InvalidMotionError(f"the offset of joint {self.names[joint]!r} {size_problem(offsets[joint])}")
        offsets.setflags(write=False)
        object.__setattr__(self, "offsets", offsets)

    def __repr__(self) -> str:
        few = self.names if len(self.names) <= 5 else (*self.names[:4], "…")
        return f"Skeleton({len(self.names)} joints: {', '.join(few)}; {len(self.end_sites)} end sites)"

    @property
    def n_joints(self) -> int:
        """Number of joints, end sites not counted."""
        return len(self.names)

    def index(self, name: str) -> int:
        """Return the first joint of a name; raise KeyError where there is none."""
        try:
            return self.names.index(name)
        except ValueError:
            raise KeyError(f"no joint is called {name!r}; there are {', '.join(self.names)}") from None

    def children(self, joint: int) -> tuple[int, ...]:
        """Return the joints whose parent is `joint`."""
        return tuple(child for child, parent in enumerate(self.parents) if parent == joint)
