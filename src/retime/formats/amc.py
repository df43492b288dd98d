"""AMC, joint angles frame by frame, on the skeleton of an ASF (see `retime.formats.asf`).

An AMC is a list of frames: a line with the frame's number, then a line for each bone with its name and values. It
names neither its skeleton nor its rate. The ASF is looked for beside it, and the rate is the reader's to give; where
nobody does it is taken for 120 Hz, with a warning. When a motion of another rate is written, a comment before the
keywords says so, which this reader takes up again and others skip.
"""

from __future__ import annotations

import warnings
from pathlib import Path

import numpy as np

from retime.arrays import FloatArray
from retime.errors import FormatError, FormatWarning, InvalidMotionError
from retime.formats.amc_declaration import ASSUMED_RATE, AsfDeclaration
from retime.formats.amc_frames import FrameReader
from retime.formats.amc_writer import write
from retime.formats.asf import (
    Asf,
    axis_of,
    compose_turns,
    find_asf,
    refuse_other_kinds,
    split_channels,
    subject_problem,
)
from retime.formats.asf_reader import parse_asf
from retime.formats.compressed import plain_path, read_plain
from retime.formats.read_options import ReadOptions
from retime.formats.text_lines import without_byte_order_mark, without_end_padding
from retime.motion import rotation
from retime.motion.motion import Motion

__all__ = ["read", "write"]

_CHANNEL_NAMES = {
    "tx": "Xposition",
    "ty": "Yposition",
    "tz": "Zposition",
    "rx": "Xrotation",
    "ry": "Yrotation",
    "rz": "Zrotation",
}


def read(path: Path, data: bytes, options: ReadOptions) -> Motion:
    """Read an AMC and its ASF.

    Parameters
    ----------
    path : Path
        The file; its ASF is looked for beside it: the same stem, the same subject number (``02.asf`` of
        ``02_04.amc``), or the only one there. ``options.skeleton`` names another.
    data : bytes
        What it holds.
    options : ReadOptions
        What the reader was told.

    Returns
    -------
    Motion
        Lengths are in the file's own numbers; ``metres_per_unit`` is known where the ASF's length unit is not 1.

    Raises
    ------
    FormatError
        One of the two files is not what it claims to be, or the ASF can't be found.
    OSError
        The ASF can't be opened.

    Warns
    -----
    FormatWarning
        The rate was assumed, the ASF is another subject's by its name, joints were left out of frames, or a damaged end
        was cut (``options.repair``).
    """
    data = without_end_padding(without_byte_order_mark(path, data))
    refuse_other_kinds(path, data, "an AMC motion")
    asf_path = options.skeleton
    if asf_path is None:
        asf_path, searched = find_asf(plain_path(path))
        if asf_path is None:
            raise FormatError(f"its ASF skeleton was not found: {searched}; name it with --skeleton", path=path)
    asf_data = read_plain(asf_path, options.limits)
    asf = parse_asf(asf_path, asf_data, options.limits)
    for note in asf.notes:
        warnings.warn(f"{asf_path}: {note}", FormatWarning, stacklevel=3)
    if problem := subject_problem(path, asf_path):
        warnings.warn(f"{path}: {problem}", FormatWarning, stacklevel=3)
    reader = FrameReader(path, data, options, asf, asf_path)
    reader.run()
    for note in reader.notes:
        warnings.warn(f"{path}: {note}", FormatWarning, stacklevel=3)
    rate = options.rate or reader.rate
    if rate is None:
        rate = ASSUMED_RATE
        warnings.warn(
            f"{path}: AMC files carry no rate; 120 Hz assumed (most CMU trials); --fps sets it",
            FormatWarning,
            stacklevel=3,
        )
    rotations, translations, angles = _pose(asf, reader.joint_values(), degrees=reader.degrees)
    declaration = AsfDeclaration(
        format="amc",
        channels=tuple(tuple(_CHANNEL_NAMES[name] for name in names) for names in asf.channels),
        asf=asf_data,
        asf_name=plain_path(asf_path).name,
        header=tuple(reader.header),
        degrees=reader.degrees,
        joint_order=tuple(reader.order),
        counts_from=reader.first_frame,
        line_end=reader.line_end,
    )
    try:
        return Motion(
            asf.skeleton,
            rotations,
            translations,
            rate=rate,
            name=path.stem,
            first_frame=reader.first_frame,
            metres_per_unit=asf.metres_per_unit,
            declaration=declaration,
            declared_angles=angles,
        )
    except InvalidMotionError as error:
        raise FormatError(str(error), path=path) from None


def _pose(asf: Asf, values: list[FloatArray], *, degrees: bool) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Turn the values of an AMC into local rotations, local translations and declared angles."""
    n_frames, n_joints = len(values[0]), len(values)
    rotations = np.empty((n_frames, n_joints, 4))
    translations = np.empty((n_frames, n_joints, 3))
    angles = np.zeros((n_frames, n_joints, 3))
    for joint, channels in enumerate(asf.channels):
        moves, turns = split_channels(channels)
        place = asf.skeleton.offsets[joint]
        if moves:
            shift = np.zeros((n_frames, 3))
            shift[:, [axis_of(channels[i]) for i in moves]] = values[joint][:, moves]
            # Numbers near the largest may overflow; Motion refuses what is not finite and says where.
            with np.errstate(over="ignore", invalid="ignore"):
                place = place + rotation.rotate(asf.before[joint], shift)
        translations[:, joint] = place
        turned = rotation.radians(values[joint][:, turns], degrees=degrees)
        angles[:, joint, : len(turns)] = turned
        rotations[:, joint] = compose_turns(asf, joint, turned)
    return rotations, translations, angles
