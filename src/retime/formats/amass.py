"""AMASS and other archives of SMPL bodies: read as motions, retimed in place.

An archive holds ``poses``, a rotation vector (axis times angle) for each joint and frame, ``trans``, where the body is,
the rate, and what is the same in all frames: the body's shape, its gender. Z is up. Which body it is, the number of
joints says (`retime.formats.smpl_body`).
"""

from __future__ import annotations

import math
import struct
import warnings
import zipfile
import zlib
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from fractions import Fraction
from io import BytesIO
from pathlib import Path
from typing import BinaryIO

import numpy as np

from retime.arrays import FloatArray, IntArray
from retime.brief import brief_repr
from retime.errors import FormatError, FormatWarning, InvalidMotionError
from retime.formats.npy_arrays import (
    MAGIC,
    RATES,
    StoredArray,
    archive_of,
    array_bytes,
    floats_of,
    header_shape,
    member_bytes,
    parse_array,
    rate_of,
    texts_of,
)
from retime.formats.read_options import ReadOptions
from retime.formats.smpl_body import BODIES
from retime.frames import frame_positions
from retime.motion import rotation
from retime.motion.any_motion import AnyMotion
from retime.motion.channels import find_kinds, with_chosen
from retime.motion.motion import Motion
from retime.motion.signal import Signal
from retime.warp.apply import apply_warp, quietly_applied
from retime.warp.curve import Warp, output_frame_times
from retime.warp.resampling import held as held_frames

_POSES, _PLACES = ("poses", "fullpose", "smpl_poses"), ("trans", "transl", "smpl_trans")
# What tells an archive of a body from one that holds some other array called poses.
_TELLING = (*_PLACES, *RATES, "betas", "gender", "surface_model_type", "dmpls")
# The same in all frames, whatever its length.
_FIXED = {
    *("betas", "gender", "surface_model_type", "num_betas", "v_template", "labels", "marker_labels", "smpl_scaling"),
    *("markers_latent", "latent_labels", "markers_latent_vids", *RATES),
}
# How long the take is, which follows the frames.
_LENGTHS = {"mocap_time_length"}
# Rotation vectors.
_ROTATIONS = {
    *("root_orient", "global_orient", "pose_body", "body_pose", "pose_hand", "pose_jaw", "pose_eye"),
    *("left_hand_pose", "right_hand_pose", "jaw_pose", "leye_pose", "reye_pose"),
}
_HEAD_BYTES = 1 << 13


@dataclass(frozen=True, eq=False)
class _Archive:
    """The members of an archive, by name without ``.npy``, in their order; arrays where they are plain ones."""

    members: list[tuple[zipfile.ZipInfo, bytes]]
    arrays: dict[str, StoredArray]

    __repr__ = brief_repr


def claims(file: BinaryIO) -> bool:
    """Tell whether an NPZ holds a body: poses of a known number of joints, and something else that bodies have."""
    try:
        with zipfile.ZipFile(file) as archive:
            names = {name.removesuffix(".npy"): name for name in archive.namelist()}
            poses = next((name for name in _POSES if name in names), None)
            if poses is None or not _tell_a_body(names):
                return False
            with archive.open(names[poses]) as member:
                shape = header_shape(member.read(_HEAD_BYTES))
    except (zipfile.BadZipFile, zlib.error, struct.error, RuntimeError, ValueError, OSError, EOFError):
        # The reader of arrays will say what is wrong.
        return False
    return shape is not None and _n_joints(shape) in BODIES


def _tell_a_body(names: Iterable[str]) -> bool:
    return not set(_TELLING).isdisjoint(names)


def _n_joints(shape: tuple[int, ...]) -> int:
    """Count the joints of poses: (n_frames, 3 * n_joints) or (n_frames, n_joints, 3); 0 where they are neither."""
    if len(shape) == 3 and shape[2] == 3:
        return shape[1]
    return shape[1] // 3 if len(shape) == 2 and shape[1] % 3 == 0 else 0


def read(path: Path, data: bytes, options: ReadOptions) -> Motion:
    """Read a body as a motion, in metres, Z up; the pelvis stands at ``trans``.

    Parameters
    ----------
    path : Path
        The file, for messages.
    data : bytes
        What it holds.
    options : ReadOptions
        What the reader was told; a ``rate``, where the file has none.

    Returns
    -------
    Motion
        On an approximate skeleton (`retime.formats.smpl_body`).

    Raises
    ------
    FormatError
        Not a plain archive of arrays, poses that are none, or no rate.
    """
    return _motion(path, _parse(path, data, options), options)


def _parse(path: Path, data: bytes, options: ReadOptions) -> _Archive:
    members, arrays = [], {}
    with archive_of(path, data, options.limits) as archive:
        for member in archive.infolist():
            content = member_bytes(archive, member)
            members.append((member, content))
            name = member.filename.removesuffix(".npy")
            try:
                if content.startswith(MAGIC):
                    arrays[name] = parse_array(path, content, name, options)
            except FormatError:
                # What is no plain array (Python objects, records) is kept as it is; poses must be one.
                if name in (*_POSES, *_PLACES, *RATES):
                    raise
    if not _tell_a_body(member.filename.removesuffix(".npy") for member, _ in members):
        raise FormatError(f"the archive tells no body: it has none of {', '.join(_TELLING)}", path=path)
    return _Archive(members, arrays)


def _key(arrays: Mapping[str, StoredArray], names: tuple[str, ...]) -> str | None:
    return next((name for name in names if name in arrays), None)


def _vectors(path: Path, archive: _Archive, options: ReadOptions) -> FloatArray:
    """Return the rotation vectors, shape (n_frames, n_joints, 3)."""
    name = _key(archive.arrays, _POSES)
    if name is None:
        raise FormatError(f"the archive has no plain array called {' or '.join(_POSES)}", path=path)
    shape = archive.arrays[name].shape
    n_joints = _n_joints(shape)
    if n_joints not in BODIES or not shape[0]:
        known = ", ".join(f"{3 * count} ({body.title})" for count, body in BODIES.items())
        raise FormatError(f"{name} have shape {shape}; expected frames of {known}", path=path)
    limits = options.limits
    if shape[0] > limits.frames or shape[0] * n_joints > limits.joint_poses:
        raise FormatError(
            f"{shape[0]} frames of {n_joints} joints, the limits are {limits.frames} frames (Limits.frames) and "
            f"{limits.joint_poses} poses of joints (Limits.joint_poses)",
            path=path,
        )
    return floats_of(path, name, archive.arrays[name]).reshape(shape[0], n_joints, 3)


def _motion(path: Path, archive: _Archive, options: ReadOptions) -> Motion:
    vectors = _vectors(path, archive, options)
    if not np.isfinite(vectors).all():
        frame, joint, _ = (int(i) for i in np.argwhere(~np.isfinite(vectors))[0])
        raise FormatError(f"the rotation of joint {joint} at frame {frame} is not a number", path=path)
    if np.abs(vectors).max() > 1e6:
        raise FormatError("a rotation of more than a hundred thousand turns: poses are rotation vectors", path=path)
    skeleton = BODIES[vectors.shape[1]].skeleton
    translations = np.tile(skeleton.offsets, (len(vectors), 1, 1))
    name = _key(archive.arrays, _PLACES)
    if name is not None:
        places = floats_of(path, name, archive.arrays[name])
        if places.shape != (len(vectors), 3):
            raise FormatError(f"{name} have shape {places.shape}; expected ({len(vectors)}, 3)", path=path)
        translations[:, 0] = places
    try:
        return Motion(
            skeleton,
            rotation.from_rotation_vectors(vectors),
            translations,
            _rate(path, archive, options),
            path.stem,
            metres_per_unit=1.0,
            up="z",
        )
    except InvalidMotionError as error:
        raise FormatError(str(error), path=path) from None


def _rate(path: Path, archive: _Archive, options: ReadOptions) -> Fraction:
    if options.rate is not None:
        return options.rate
    name = _key(archive.arrays, RATES)
    if name is None:
        raise FormatError("the file holds no rate, so it must be given (--fps)", path=path)
    return rate_of(path, archive.arrays[name], name)


def write(motion: AnyMotion, path: Path, *, overwrite: bool) -> None:
    """Refuse to write a motion as a body, which it has no shape for; raise FormatError."""
    raise FormatError("an archive of a body is made by retiming one, not from another motion", path=path)


def retime_frames(
    path: Path,
    data: bytes,
    warp: Warp,
    options: ReadOptions,
    *,
    frames: tuple[int, int] | None = None,
    average: bool = True,
    held: int = 1,
) -> bytes:
    """Give a body new timing: every array of frame length is resampled, all others stay as they are, to the byte.

    Poses are turned on the sphere and averaged as `retime.apply_warp` does it for a motion, standing feet exempt; each
    rotation vector is written as the one, of the many that mean the same rotation, that is nearest to the input's.
    Other numbers are blended and averaged; whole numbers, truths and texts are those of the nearest frame. Types of
    numbers stay.

    Parameters
    ----------
    path : Path
        The file, for messages.
    data : bytes
        What it holds.
    warp : Warp
        Its input time 0 is the first frame that is meant.
    options : ReadOptions
        As it was read; a ``rate`` is written where the file has its own.
    frames : (int, int), optional
        The first frame that is meant and the last one, counted from 0.
    average : bool
        Average where sped up.
    held : int
        For how many frames each pose is held.

    Returns
    -------
    bytes
        The new archive.

    Raises
    ------
    FormatError
        The file is not what it claims to be.

    Warns
    -----
    FormatWarning
        Python objects of frame length are kept as they are: they are never loaded.
    """
    archive = _parse(path, data, options)
    whole = _motion(path, archive, options)
    start, stop = (0, whole.n_frames) if frames is None else (frames[0], frames[1] + 1)
    motion = whole.frames(start, stop)
    part = _Part(path, warp, options, start, stop, whole.n_frames, motion.rate, average, held)
    shown = held_frames(apply_warp(motion, warp, average=average), held)
    poses_name, places_name = _key(archive.arrays, _POSES), _key(archive.arrays, _PLACES)
    assert poses_name is not None
    old = _vectors(path, archive, options)
    poses = part.vectors(old[start:stop], shown.rotations, motion.rotations)
    file = BytesIO()
    with zipfile.ZipFile(file, "w") as out:
        for member, content in archive.members:
            name = member.filename.removesuffix(".npy")
            array = archive.arrays.get(name)
            if array is None:
                _warn_of_objects(path, name, content, whole.n_frames)
            elif name == poses_name:
                content = part.stored(array, poses)
            elif name == places_name:
                content = part.stored(array, shown.local_translations[:, 0])
            elif name in RATES and options.rate is not None:
                content = _with_rate(path, array, options.rate, content)
            elif name in _LENGTHS and array.kind in "iuf" and math.prod(array.shape) == 1:
                length = floats_of(path, name, array) * (shown.n_frames / whole.n_frames)
                if array.kind in "iu":
                    length = np.clip(np.rint(length), 0, np.iinfo(array.dtype).max)
                content = part.stored(array, length)
            elif array.shape[:1] == (whole.n_frames,) and name not in _FIXED and name not in _LENGTHS:
                own = _columns_of(path, name, array, old)
                content = part.stored(array, poses[:, own]) if own is not None else part.other(name, array)
            # The date is the member's own, so that the same input gives the same bytes.
            info = zipfile.ZipInfo(member.filename, member.date_time)
            info.compress_type, info.external_attr = member.compress_type, member.external_attr
            out.writestr(info, content)
    return file.getvalue()


def _columns_of(path: Path, name: str, array: StoredArray, poses: FloatArray) -> slice | None:
    """Find the joints whose rotations an array repeats, as that of SMPL-X (pose_body ...) do; None where it doesn't."""
    if name not in _ROTATIONS or array.kind != "f" or _n_joints(array.shape) == 0:
        return None
    values = floats_of(path, name, array).reshape(len(poses), -1, 3)
    count = values.shape[1]
    for first in range(poses.shape[1] - count + 1):
        if np.array_equal(values, poses[:, first : first + count]):
            return slice(first, first + count)
    return None


def _warn_of_objects(path: Path, name: str, content: bytes, n_frames: int) -> None:
    shape = header_shape(content[:_HEAD_BYTES])
    if name not in _FIXED and shape is not None and shape[:1] == (n_frames,):
        warnings.warn(
            f"{path}: {name} holds no plain numbers and is kept as it is, though it has a row for each of the "
            f"{n_frames} frames before",
            FormatWarning,
            stacklevel=5,
        )


def _with_rate(path: Path, array: StoredArray, rate: Fraction, content: bytes) -> bytes:
    if array.kind in "SU":
        return array_bytes(np.full(array.shape, str(rate)))
    if array.kind in "iu" and rate.denominator != 1:
        raise FormatError(f"the file keeps its rate as a whole number, which {rate} is not", path=path)
    return array_bytes(np.full(array.shape, float(rate)).astype(array.dtype)) if array.kind in "iuf" else content


@dataclass(frozen=True, eq=False)
class _Part:
    """The frames that are meant, and how they are shown."""

    path: Path
    warp: Warp
    options: ReadOptions
    start: int
    stop: int
    n_whole: int
    rate: Fraction
    average: bool
    held: int

    __repr__ = brief_repr

    def nearest(self) -> IntArray:
        """Return the frame, counted from `start`, that is nearest to what each output frame shows."""
        times = output_frame_times(self.warp, float(self.rate))
        before, after, share = frame_positions(self.warp(times), self.rate, self.stop - self.start)
        kept = np.arange(len(times)) // self.held * self.held
        return np.where(share < 0.5, before, after)[kept]

    def vectors(self, old: FloatArray, rotations: FloatArray, before: FloatArray) -> FloatArray:
        """Write rotations (n_output, n_joints, 4) as vectors near `old`, whose rotations were `before`."""
        near = self.nearest()
        same = (rotations == before[near]).all(axis=-1, keepdims=True)
        return np.where(same, old[near], rotation.to_rotation_vectors(rotations, near=old[near]))

    def stored(self, array: StoredArray, values: FloatArray) -> bytes:
        """Store values in the type and the shape of an array, but for its length."""
        return (
            array_bytes(np.ascontiguousarray(values).reshape(-1, *array.shape[1:]).astype(array.dtype))
            if (array.shape)
            else array_bytes(np.asarray(values).reshape(()).astype(array.dtype))
        )

    def other(self, name: str, array: StoredArray) -> bytes:
        """Resample an array of frame length by what it holds."""
        if array.kind != "f" or math.prod(array.shape) == 0:
            return self._taken(array)
        values = floats_of(self.path, name, array).reshape(self.n_whole, -1)[self.start : self.stop]
        if np.isinf(values).any() or np.nanmax(np.abs(values), initial=0.0) > 1e100:
            return self._taken(array)
        if name in _ROTATIONS and values.shape[1] % 3 == 0 and np.isfinite(values).all():
            old = values.reshape(len(values), -1, 3)
            before = rotation.from_rotation_vectors(old)
            names = [f"{joint}.{axis}" for joint in range(old.shape[1]) for axis in "wxyz"]
            turns = Signal(names, before.reshape(len(before), -1), self.rate, kinds=["quaternion"] * len(names))
            shown = self._shown(turns).reshape(-1, *before.shape[1:])
            return self.stored(array, self.vectors(old, shown, before))
        names = [f"{name}.{column}" for column in range(values.shape[1])]
        kinds = with_chosen(find_kinds(names, values), names, self.options.channels, all_fit=False)
        return self.stored(array, self._shown(Signal(names, values, self.rate, kinds=kinds, gaps="keep")))

    def _shown(self, signal: Signal) -> FloatArray:
        return held_frames(quietly_applied(signal, self.warp, average=self.average), self.held).values

    def _taken(self, array: StoredArray) -> bytes:
        """Take whole rows: between whole numbers, truths and texts there is nothing."""
        rows = np.frombuffer(array.data, dtype=array.dtype).reshape(array.shape, order="F" if array.fortran else "C")
        return array_bytes(rows[self.start + self.nearest()])


def facts(path: Path, data: bytes, options: ReadOptions) -> dict[str, str]:
    """Say which body it is, and which arrays are retimed and which are kept."""
    archive = _parse(path, data, options)
    n_frames, n_joints, _ = _vectors(path, archive, options).shape
    retimed, kept = [], []
    for member, _ in archive.members:
        name = member.filename.removesuffix(".npy")
        array = archive.arrays.get(name)
        if array is not None and array.shape[:1] == (n_frames,) and name not in _FIXED:
            retimed.append(f"{name} {array.shape}")
        else:
            kept.append(name if array is None or not array.shape else f"{name} {array.shape}")
    said = {"body": f"{BODIES[n_joints].title}, {n_joints} joints, on an approximate skeleton"}
    gender = archive.arrays.get("gender")
    if gender is not None and gender.kind in "SU" and math.prod(gender.shape) == 1:
        said["gender"] = texts_of(path, "gender", gender)[0]
    return {**said, "arrays": f"{', '.join(retimed)}; the same in all frames: {', '.join(kept) or 'none'}"}
