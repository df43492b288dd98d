"""The frames of a C3D as arrays, and back: points with their residuals, analog samples at their own rate."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from retime.arrays import BoolArray, FloatArray
from retime.brief import brief_repr
from retime.formats.c3d_file import C3dFile
from retime.motion.joint_signal import distinct_names


@dataclass(frozen=True, eq=False)
class Frames:
    """The numbers of frames as they are stored: nothing is scaled.

    Attributes
    ----------
    points : float array, shape (n_frames, n_points, 4)
        Coordinates, and the number that holds residual and cameras: below 0 the point is missing.
    analog : float array, shape (n_frames * n_samples, n_channels)
        Samples of the analog channels.
    """

    points: FloatArray
    analog: FloatArray

    __repr__ = brief_repr

    @property
    def missing(self) -> BoolArray:
        """Which points are missing, shape (n_frames, n_points): said by the residual, or no numbers at all."""
        return np.asarray(~(self.points[..., 3] >= 0) | ~np.isfinite(self.points[..., :3]).all(axis=2))

    def places(self) -> FloatArray:
        """Coordinates, shape (n_frames, n_points, 3), not a number where a point is missing."""
        return np.where(self.missing[..., None], np.nan, self.points[..., :3])

    def cut(self, start: int, stop: int) -> Frames:
        """Cut frames ``start`` to ``stop - 1`` out."""
        samples = len(self.analog) // len(self.points)
        return Frames(self.points[start:stop], self.analog[start * samples : stop * samples])


def unsigned_analog(file: C3dFile) -> bool:
    """Tell whether analog samples that are whole numbers have no sign."""
    return not file.real and any(text.upper() == "UNSIGNED" for text in file.texts("ANALOG:FORMAT"))


def read_frames(file: C3dFile) -> Frames:
    """Read all frames."""
    layout, n_frames = file.layout, file.n_frames
    raw = file.data[file.data_start : file.data_start + n_frames * file.frame_bytes]
    values = file.numbers.reals(raw) if file.real else file.numbers.words(raw, signed=True)
    rows = values.reshape(n_frames, layout.numbers)
    points = rows[:, : 4 * layout.points].reshape(n_frames, layout.points, 4)
    analog = rows[:, 4 * layout.points :].reshape(n_frames * layout.samples, layout.channels)
    if unsigned_analog(file):
        analog = np.where(analog < 0, analog + (1 << 16), analog)
    return Frames(points, analog)


def pack_frames(file: C3dFile, frames: Frames) -> bytes:
    """Store frames in a file's own kind of numbers."""
    n_frames = len(frames.points)
    if file.real:
        rows = [frames.points.reshape(n_frames, -1), frames.analog.reshape(n_frames, -1)]
        return file.numbers.pack_reals(np.concatenate(rows, axis=1))
    analog = np.rint(frames.analog)
    if unsigned_analog(file):
        analog = np.clip(analog, 0, (1 << 16) - 1)
        analog = np.where(analog >= 1 << 15, analog - (1 << 16), analog)
    rows = [frames.points.reshape(n_frames, -1), analog.reshape(n_frames, -1)]
    return file.numbers.pack_words(np.concatenate(rows, axis=1), signed=True)


def analog_scales(file: C3dFile) -> tuple[FloatArray, FloatArray]:
    """Return what analog samples are multiplied by, and what is taken off them first, each of shape (n_channels,)."""
    n_channels = file.layout.channels
    scales, offsets = np.ones(n_channels), np.zeros(n_channels)
    general = file.number("ANALOG:GEN_SCALE")
    for name, into in (("ANALOG:SCALE", scales), ("ANALOG:OFFSET", offsets)):
        at = 0
        for numbered in file.continued(name):
            own = file.values(numbered)
            if own is None:
                continue
            one = file.parameters[numbered]
            if name == "ANALOG:OFFSET" and one.kind == 2 and not unsigned_analog(file):
                own = np.where(own >= 1 << 15, own - (1 << 16), own)
            own = own[: n_channels - at]
            into[at : at + len(own)] = own
            at += len(own)
    return scales * (1.0 if general is None else general), offsets


def point_labels(file: C3dFile) -> list[str]:
    """Name the points, no two alike."""
    return _labels(file.texts("POINT:LABELS"), file.layout.points, "M")


def analog_labels(file: C3dFile) -> list[str]:
    """Name the analog channels, no two alike."""
    return _labels(file.texts("ANALOG:LABELS"), file.layout.channels, "A")


def _labels(said: list[str], count: int, letter: str) -> list[str]:
    padded = [*said[:count], *[""] * (count - len(said))]
    return distinct_names([label or f"{letter}{number}" for number, label in enumerate(padded, start=1)])
