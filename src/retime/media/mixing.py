"""Frames mixed from frames, in the format that they have: averages, and in-betweens by optical flow."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from retime.arrays import FloatArray
from retime.media.extras import needed

Samples = NDArray[Any]

# Where the two sides of an in-between differ by more than this share of white, in the mean, there was a cut.
_CUT = 0.15


@dataclass(frozen=True)
class PixelLayout:
    """How a pixel format lies in memory.

    Attributes
    ----------
    name : str
        FFmpeg's name of it.
    dtype : numpy type
        Of its samples.
    channels : tuple of int
        Components in each plane, side by side.
    alpha : tuple of int, optional
        The plane of the alpha, and its place in there.
    white : float
        The largest sample.
    """

    name: str
    dtype: Any
    channels: tuple[int, ...]
    alpha: tuple[int, int] | None
    white: float


def layout_of(name: str) -> PixelLayout | None:
    """Return how a format lies in memory; None where its samples can't be mixed one by one.

    Examples
    --------
    >>> layout_of("yuv420p").channels, layout_of("rgba").alpha, layout_of("pal8")  # doctest: +SKIP
    ((1, 1, 1), (0, 3), None)
    """
    av = needed("av")
    form = av.VideoFormat(name, 16, 16)
    components = form.components
    if form.has_palette or form.is_bit_stream or not components:
        return None
    bits = {component.bits for component in components}
    if len(bits) != 1:
        return None
    (depth,) = bits
    if depth == 8:
        dtype: Any = np.uint8
    elif "f32le" in name:
        dtype = np.float32
    elif 8 < depth <= 16 and name.endswith("le"):
        dtype = np.uint16
    else:
        return None
    frame = av.VideoFrame(16, 16, name)
    channels = []
    for number in range(len(frame.planes)):
        inside = [component for component in components if component.plane == number]
        # Samples for which no component stands (bgr0) are padding; a plane is read in whole pixels.
        width = inside[0].width if inside else 16
        if not inside or {component.width for component in inside} != {width}:
            return None
        count = _samples_of_pixel(form, inside, dtype)
        if count < len(inside):
            return None
        channels.append(count)
    alpha = None
    for component in components:
        if component.is_alpha:
            places = [one for one in components if one.plane == component.plane]
            # Component places of packed formats: FFmpeg orders alpha last but for argb and abgr.
            first = name in ("argb", "abgr")
            alpha = (component.plane, 0 if first else len(places) - 1)
    return PixelLayout(name, dtype, tuple(channels), alpha, 1.0 if dtype is np.float32 else float(2**depth - 1))


def _samples_of_pixel(form: Any, inside: Sequence[Any], dtype: Any) -> int:
    """Count the samples side by side in a plane, for each pixel; of packed formats some may mean nothing."""
    if form.is_planar or len(inside) < len(form.components):
        return len(inside)
    bits, size = int(form.padded_bits_per_pixel), 8 * np.dtype(dtype).itemsize
    return bits // size if bits % size == 0 else 0


def working_format(name: str) -> str:
    """Return the format in which frames of a format are mixed: itself, or one that loses nothing that it has."""
    if layout_of(name) is not None:
        return name
    av = needed("av")
    form = av.VideoFormat(name, 16, 16)
    deep = any(component.bits > 8 for component in form.components)
    alpha = any(component.is_alpha for component in form.components) or form.has_palette
    if form.is_rgb or form.has_palette:
        return ("rgba64le" if alpha else "rgb48le") if deep else ("rgba" if alpha else "rgb24")
    return ("yuva444p16le" if alpha else "yuv444p16le") if deep else ("yuva444p" if alpha else "yuv444p")


def planes_of(frame: Any, layout: PixelLayout) -> list[Samples]:
    """View a frame's planes as arrays (height, width, components)."""
    views = []
    size = np.dtype(layout.dtype).itemsize
    for plane, count in zip(frame.planes, layout.channels, strict=True):
        rows = np.frombuffer(plane, np.uint8).reshape(-1, plane.line_size)[: plane.height]
        row_bytes = plane.width * count * size
        views.append(rows[:, :row_bytes].view(layout.dtype).reshape(plane.height, plane.width, count))
    return views


def empty_like(frame: Any) -> Any:
    """Make a frame of the size, format and colours of another."""
    av = needed("av")
    made = av.VideoFrame(frame.width, frame.height, frame.format.name)
    copy_colours(frame, made)
    return made


def copy_colours(source: Any, made: Any) -> None:
    """Say of a frame how another one's samples mean colours."""
    made.colorspace, made.color_range = source.colorspace, source.color_range
    made.color_primaries, made.color_trc = source.color_primaries, source.color_trc


def average(frames: Sequence[Any], weights: FloatArray) -> Any:
    """Average frames of one size and format.

    Parameters
    ----------
    frames : sequence of VideoFrame
        Of PyAV, in a format that `layout_of` knows.
    weights : float array
        One for each, summing to 1. Where there is alpha, what is transparent counts less, as its colour can't be seen.
    """
    if len(frames) == 1:
        return frames[0]
    layout = layout_of_frame(frames[0])
    made = empty_like(frames[0])
    stacks = [planes_of(frame, layout) for frame in frames]
    for number, target in enumerate(planes_of(made, layout)):
        if layout.alpha is not None:
            target[...] = _with_alpha(stacks, number, weights, layout)
        else:
            _weighted([planes[number] for planes in stacks], weights, target)
    return made


_LAYOUTS: dict[str, PixelLayout] = {}


def layout_of_frame(frame: Any) -> PixelLayout:
    """Return the layout of a frame that is in a working format."""
    name = frame.format.name
    if name not in _LAYOUTS:
        layout = layout_of(name)
        assert layout is not None, name
        _LAYOUTS[name] = layout
    return _LAYOUTS[name]


def _weighted(arrays: Sequence[Samples], weights: FloatArray, target: Samples) -> None:
    """Put the weighted mean of arrays into another."""
    cv2 = needed("cv2")
    flat = [array.reshape(len(array), -1) for array in arrays]
    out = target.reshape(len(target), -1)
    if len(flat) == 2 and target.dtype != np.float32:
        cv2.addWeighted(flat[0], float(weights[0]), flat[1], float(weights[1]), 0.0, dst=out)
        return
    total = np.zeros(out.shape, np.float32)
    done = 0.0
    for array, weight in zip(flat, weights.tolist(), strict=True):
        done += weight
        # A running mean: each frame moves it by its share of the weight so far.
        cv2.accumulateWeighted(array, total, weight / done)
    if target.dtype == np.uint8:
        cv2.convertScaleAbs(total, dst=out)
    elif target.dtype == np.float32:
        out[...] = total
    else:
        np.rint(total, out=total)
        out[...] = total


def _with_alpha(stacks: Sequence[list[Samples]], number: int, weights: FloatArray, layout: PixelLayout) -> Samples:
    """Return the mean of a plane, colours weighted by the alpha that they are seen with."""
    assert layout.alpha is not None
    plane, place = layout.alpha
    dtype = stacks[0][number].dtype
    seen, colours, plain = 0.0, 0.0, 0.0
    for planes, weight in zip(stacks, weights.tolist(), strict=True):
        values = planes[number].astype(np.float32)
        alpha = planes[plane][:, :, place].astype(np.float32)
        # Of planes with fewer samples (chroma) by the alpha there.
        steps = (alpha.shape[0] // values.shape[0] or 1, alpha.shape[1] // values.shape[1] or 1)
        alpha = alpha[:: steps[0], :: steps[1]][: values.shape[0], : values.shape[1], None] * weight
        seen, colours, plain = seen + alpha, colours + alpha * values, plain + weight * values
    mean = np.where(seen > 0, colours / np.maximum(seen, 1e-9), plain)
    if number == plane:
        mean[:, :, place] = np.asarray(plain)[:, :, place]
    return np.asarray(mean if dtype == np.float32 else np.rint(mean)).astype(dtype)


def between(before: Any, after: Any, share: float) -> Any:
    """Make the frame at a share of the way from one frame to the next, by optical flow (OpenCV DIS).

    What moves is found between the two, at half the size, in both directions, and each is moved toward the moment asked
    for. Where the two differ in the whole picture, as at a cut, the nearer one is shown.
    """
    cv2 = needed("cv2")
    layout = layout_of_frame(before)
    first, second = planes_of(before, layout), planes_of(after, layout)
    small = [_grey(planes[0], layout) for planes in (first, second)]
    flow = cv2.DISOpticalFlow_create(cv2.DISOPTICAL_FLOW_PRESET_FAST)
    forth, back = flow.calc(small[0], small[1], None), flow.calc(small[1], small[0], None)
    # Where what is seen at the moment between was in each frame, as if motion were even about the place.
    to_first = -share * (1 - share) * forth + share * share * back
    to_second = (1 - share) ** 2 * forth - share * (1 - share) * back
    height, width = small[0].shape
    if _differ(cv2, small, (to_first, to_second)) > _CUT * 255:
        return before if share < 0.5 else after
    made = empty_like(before)
    for number, target in enumerate(planes_of(made, layout)):
        rows, columns, count = target.shape
        sides = []
        for planes, field in ((first, to_first), (second, to_second)):
            grown = cv2.resize(field, (columns, rows), interpolation=cv2.INTER_LINEAR)
            grown *= np.array([columns / width, rows / height], np.float32)
            grown += _grid(columns, rows)
            source = np.ascontiguousarray(planes[number])
            moved = cv2.remap(source, grown, None, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)
            sides.append(moved.reshape(rows, columns * count))
        mixed = np.empty((rows, columns * count), target.dtype)
        _weighted(sides, np.array([1 - share, share]), mixed)
        target[...] = mixed.reshape(target.shape)
    return made


_GRIDS: dict[tuple[int, int], Samples] = {}


def _grid(columns: int, rows: int) -> Samples:
    if (columns, rows) not in _GRIDS:
        x, y = np.meshgrid(np.arange(columns, dtype=np.float32), np.arange(rows, dtype=np.float32))
        _GRIDS[columns, rows] = np.stack([x, y], axis=-1)
    return _GRIDS[columns, rows]


def _grey(plane: Samples, layout: PixelLayout) -> Samples:
    """Make a half-size picture of bytes, for finding motion."""
    cv2 = needed("cv2")
    half = (max(16, plane.shape[1] // 2), max(16, plane.shape[0] // 2))
    picture = cv2.resize(np.ascontiguousarray(plane[:, :, :3]), half, interpolation=cv2.INTER_AREA)
    if picture.ndim == 3:
        picture = picture.mean(axis=2)
    scaled = picture.astype(np.float32) * (255 / layout.white)
    return np.asarray(np.clip(np.rint(scaled), 0, 255).astype(np.uint8))


def _differ(cv2: Any, small: Sequence[Samples], fields: Sequence[Samples]) -> float:
    rows, columns = small[0].shape
    grid = _grid(columns, rows)
    sides = [
        cv2.remap(picture, (grid + field).astype(np.float32), None, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)
        for picture, field in zip(small, fields, strict=True)
    ]
    return float(cv2.absdiff(sides[0], sides[1]).mean())
