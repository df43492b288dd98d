"""A figure as the search sees it, made of the matrices that Blender has for its bones. bpy is not needed."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from retime.arrays import BoolArray, FloatArray
from retime.brief import brief_repr
from retime.motion import rotation
from retime.motion.motion import Motion
from retime.motion.skeleton import EndSite, Skeleton

# Fewer deforming bones than this are no figure: then all bones count.
_FEWEST = 3
# Metres. A figure that stands lower or higher than this was brought in at some scale, such as centimetres.
_SMALLEST, _LARGEST = 0.2, 10.0
# A box of three unit vectors that holds less than this is flat.
_FLAT = 1e-6


@dataclass(frozen=True, eq=False)
class Bones:
    """The bones of an armature at rest, parents before children.

    Attributes
    ----------
    names : sequence of str
    parents : sequence of int
        -1 for a bone without.
    rest : float array, shape (n_bones, 4, 4)
        In the armature's space.
    lengths : float array, shape (n_bones,)
        A bone points along its own Y axis, so far.
    deforms : bool array, shape (n_bones,)
        Whether it moves a mesh.
    """

    names: Sequence[str]
    parents: Sequence[int]
    rest: FloatArray
    lengths: FloatArray
    deforms: BoolArray

    __repr__ = brief_repr

    def deforming(self) -> Bones:
        """Return the bones that move meshes, each below the next one above it that does; all, where hardly one does."""
        if self.deforms.sum() < _FEWEST:
            return self
        chosen = np.flatnonzero(self.deforms).tolist()
        place = {bone: i for i, bone in enumerate(chosen)}
        parents = []
        for bone in chosen:
            parent = self.parents[bone]
            while parent >= 0 and parent not in place:
                parent = self.parents[parent]
            parents.append(place.get(parent, -1))
        return Bones(
            [self.names[bone] for bone in chosen],
            parents,
            self.rest[chosen],
            self.lengths[chosen],
            self.deforms[chosen],
        )


def figure_of(
    bones: Bones,
    matrices: FloatArray,
    world: FloatArray,
    *,
    rate: float,
    name: str,
    metres_per_unit: float = 1.0,
    root: str | None = None,
) -> Motion:
    """Make the motion of a figure.

    Parameters
    ----------
    bones : Bones
        Which of them, and at rest.
    matrices : float array, shape (n_frames, n_bones, 4, 4)
        Each pose bone in the armature's space.
    world : float array, shape (n_frames, 4, 4)
        The armature in the scene.
    rate : float
        Frames a second.
    name : str
        What to call it.
    metres_per_unit : float
        The scene's unit. A figure whose size says that nobody minded the unit is measured by itself.
    root : str, optional
        The bone that carries the body; left out, it is found.

    Returns
    -------
    Motion
        Z is up. The armature itself is the first joint, so that there is one root. Scale is left out: it makes no pose.
        What is scaled to nothing for a while keeps the turn that it had.
    """
    all_parents = [-1, *(parent + 1 for parent in bones.parents)]
    local = np.concatenate([world[:, None], np.einsum("fij,fbjk->fbik", world, matrices)], axis=1)
    turns = turns_of(local[..., :3, :3])
    places = local[..., :3, 3]
    above = np.array(all_parents[1:], dtype=np.intp)
    inverse = turns[:, above].swapaxes(-1, -2)
    rotations = np.empty((*turns.shape[:2], 4))
    rotations[:, 0] = rotation.from_matrix(turns[:, 0])
    rotations[:, 1:] = rotation.from_matrix(inverse @ turns[:, 1:])
    translations = places.copy()
    translations[:, 1:] = np.einsum("fbij,fbj->fbi", inverse, places[:, 1:] - places[:, above])
    leaves = sorted(set(range(1, len(all_parents))) - set(all_parents))
    scale = np.linalg.norm(world[0, :3, :3], axis=0).mean()
    sites = tuple(EndSite(leaf, (0.0, float(bones.lengths[leaf - 1] * scale), 0.0)) for leaf in leaves)
    # Two joints must not share a name that the root is found by.
    tall = float(np.ptp(places[0, 1:, 2]))
    known = metres_per_unit if _SMALLEST < tall * metres_per_unit < _LARGEST else None
    skeleton = Skeleton((f"{name} (object)", *bones.names), tuple(all_parents), _offsets(bones, scale), sites)
    return Motion(skeleton, rotations, translations, rate, name, metres_per_unit=known, up="z", root=root or None)


def turns_of(matrices: FloatArray) -> FloatArray:
    """Take scale out of matrices of many frames, shape (n_frames, ..., 3, 3): what is left is a turn.

    A mirror image is turned by as much as it can be. What has no size in a frame has the turn of the frame before, or
    of the next one that has any; that of no frame has none.
    """
    lengths = np.linalg.norm(matrices, axis=-2, keepdims=True)
    turns = matrices / np.where(lengths > 0, lengths, 1.0)
    sides = np.linalg.det(turns)
    turns *= np.where(sides < 0, -1.0, 1.0)[..., None, None]
    # Flat ones are as little a turn as those of no size.
    known = np.abs(sides) > _FLAT
    if known.all():
        return np.asarray(turns)
    n = len(matrices)
    frame = np.arange(n).reshape(-1, *[1] * (known.ndim - 1))
    before = np.maximum.accumulate(np.where(known, frame, -1), axis=0)
    after = np.minimum.accumulate(np.where(known, frame, n)[::-1], axis=0)[::-1]
    near = np.where(before >= 0, before, np.where(after < n, after, 0))
    turns = np.take_along_axis(turns, near[..., None, None], axis=0)
    never = np.broadcast_to(~known.any(axis=0), known.shape)
    turns[never] = np.eye(3)
    return np.asarray(turns)


def _offsets(bones: Bones, scale: float) -> FloatArray:
    offsets = np.zeros((len(bones.names) + 1, 3))
    for bone, parent in enumerate(bones.parents):
        above = np.eye(4) if parent < 0 else bones.rest[parent]
        offsets[bone + 1] = scale * (np.linalg.inv(above) @ bones.rest[bone])[:3, 3]
    return offsets
