"""HumanML3D: frames of 263 numbers that text-to-motion models learn from, as a NPY array; read as a signal.

A frame holds the root's turn and steps, the root's height, the places of 21 joints as seen from it, their rotations as
six numbers each, what 22 joints move by, and whether the feet stand. What moves is told by the frame, not the second.
"""

from __future__ import annotations

import warnings
from fractions import Fraction
from pathlib import Path
from typing import BinaryIO

import numpy as np

from retime.errors import FormatError, FormatWarning, OptionError
from retime.formats.channel_meaning import make_signal
from retime.formats.npy_arrays import MAGIC, StoredArray, array_bytes, floats_of, header_shape, parse_array
from retime.formats.read_options import ReadOptions
from retime.formats.smpl_body import BODIES
from retime.motion.any_motion import AnyMotion
from retime.motion.channels import LINEAR, ChannelKind
from retime.motion.signal import Signal
from retime.warp.apply import apply_warp
from retime.warp.curve import Warp, output_frame_times

_JOINTS = BODIES[22].skeleton.names
_NAMES = (
    *("root.turn", "root.step_x", "root.step_z", "root.y"),
    *(f"{joint}.{axis}" for joint in _JOINTS[1:] for axis in "xyz"),
    *(f"{joint}.r{number}" for joint in _JOINTS[1:] for number in range(6)),
    *(f"{joint}.step_{axis}" for joint in _JOINTS for axis in "xyz"),
    *(f"{side}_{part}.contact" for side in ("left", "right") for part in ("ankle", "foot")),
)
# By how much something goes on from one frame to the next.
_STEPS = [place for place, name in enumerate(_NAMES) if name == "root.turn" or ".step_" in name]
_KINDS = [ChannelKind("label") if name.endswith(".contact") else LINEAR for name in _NAMES]
_RATE = Fraction(20)
_HEAD_BYTES = 1 << 13


def claims(file: BinaryIO) -> bool:
    """Tell whether an array has frames of 263 numbers."""
    shape = header_shape(file.read(_HEAD_BYTES))
    return shape is not None and len(shape) == 2 and shape[1] == len(_NAMES)


def _parse(path: Path, data: bytes, options: ReadOptions) -> StoredArray:
    if not data.startswith(MAGIC):
        raise FormatError("expected a NumPy array (NPY)", path=path, byte=0)
    array = parse_array(path, data, "the array", options)
    if len(array.shape) != 2 or array.shape[1] != len(_NAMES):
        raise FormatError(f"expected frames of {len(_NAMES)} numbers, found shape {array.shape}", path=path)
    if array.kind != "f":
        # Blended, they would be cut off to whole numbers.
        raise FormatError(
            f"frames of HumanML3D are real numbers, these are of type {array.dtype}; --array values reads them as any "
            "other array",
            path=path,
        )
    return array


def read(path: Path, data: bytes, options: ReadOptions) -> Signal:
    """Read the frames as a signal, called by joint and what is told of it (``left_knee.x``, ``root.step_x``).

    Raises
    ------
    FormatError
        Not an array of frames of 263 finite numbers.

    Warns
    -----
    FormatWarning
        No rate was given, and so it is that of the data set, 20 Hz.
    """
    return _signal(path, _parse(path, data, options), options)


def _signal(path: Path, array: StoredArray, options: ReadOptions) -> Signal:
    rate = options.rate
    if rate is None:
        rate = _RATE
        warnings.warn(
            f"{path}: frames of {len(_NAMES)} numbers are taken for HumanML3D, at {rate} Hz; --fps says another rate, "
            "and --array values reads them as any other array",
            FormatWarning,
            stacklevel=4,
        )
    if not array.shape[0] or array.shape[0] > options.limits.frames:
        raise FormatError(f"{array.shape[0]} frames, the limit is {options.limits.frames} (Limits.frames)", path=path)
    return make_signal(
        path,
        _NAMES,
        floats_of(path, "the array", array),
        rate,
        options,
        dict(enumerate(_KINDS)),
        dialect="HumanML3D features",
    )


def write(signal: AnyMotion, path: Path, *, overwrite: bool) -> None:
    """Refuse to make such frames of something else; raise FormatError."""
    raise FormatError("frames of HumanML3D are made by retiming such, not from another motion", path=path)


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
    """Give the frames new timing: what is told by the frame is what the output's frame goes on by.

    Parameters
    ----------
    path, data, warp, options, frames, average
        As of `retime.formats.amass.retime_frames`.
    held : int
        1: a frame tells how it goes on, and so can't be held.

    Raises
    ------
    FormatError
        The file is not what it claims to be.
    OptionError
        Frames are to be held.
    """
    if held > 1:
        raise OptionError(f"{path.name}: each frame tells how it goes on, so it can't be held")
    array = _parse(path, data, options)
    signal = _signal(path, array, options)
    if frames is not None:
        signal = signal.frames(frames[0], frames[1] + 1)
    shown = apply_warp(signal, warp, average=average)
    values = shown.values.copy()
    # Summed up, steps are places, which a warp shows at other times; their differences are the steps of the output.
    rate = float(signal.rate)
    times = np.append(output_frame_times(warp, rate), warp.output_end + 1 / rate)
    onward = float(np.sign(warp.input_times[-1] - warp.input_times[-2])) / rate
    longer = Warp(np.append(warp.output_times, times[-1]), np.append(warp.input_times, warp.input_times[-1] + onward))
    grid = np.arange(signal.n_frames + 1) / rate
    for place in _STEPS:
        sums = np.concatenate([[0.0], np.cumsum(signal.values[:, place])])
        values[:, place] = np.diff(np.interp(longer(times), grid, sums))
    return array_bytes(values.astype(array.dtype))
