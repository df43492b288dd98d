"""Frames turned as they are to be seen, for outputs that can't say beside the picture how it is to be turned."""

from __future__ import annotations

from typing import Any

import numpy as np

from retime.media.encoding import side_data
from retime.media.extras import needed
from retime.media.mixing import copy_colours, layout_of_frame, planes_of, working_format
from retime.media.reader import FrameReader

# Formats (as PyAV calls them) that say how a picture is to be turned.
SAY_TURNS = {"mp4", "mov", "ipod", "3gp", "matroska", "webm"}


def turn_of(frame: Any) -> tuple[bool, bool, bool] | None:
    """Return how a frame is to be turned: whether rows become columns, and which ways are mirrored after that.

    Returns
    -------
    (bool, bool, bool), optional
        Transposed; then mirrored from left to right; then from top to bottom. None where nothing is to be done, or
        where it is not by quarters of a circle.
    """
    matrix = side_data(frame, "DISPLAYMATRIX")
    if matrix is None:
        return None
    a, b, _, c, d = np.frombuffer(matrix, np.int32)[:5].astype(np.float64)
    if not b and not c and a and d:
        turn = (False, bool(a < 0), bool(d < 0))
    elif not a and not d and b and c:
        turn = (True, bool(c < 0), bool(b < 0))
    else:
        return None
    return turn if any(turn) else None


class Upright:
    """Frames of another reader, turned.

    Parameters
    ----------
    reader : FrameReader
        The frames as they lie in the file.
    turn : (bool, bool, bool)
        As `turn_of` returns it.
    """

    def __init__(self, reader: FrameReader, turn: tuple[bool, bool, bool]) -> None:
        self._reader, self._turn = reader, turn
        self.times, self.seconds = reader.times, reader.seconds

    def get(self, frame: int) -> Any:
        """Return a frame of PyAV."""
        return turned(self._reader.get(frame), self._turn)


def upright(reader: FrameReader, first: Any) -> tuple[FrameReader, tuple[bool, bool, bool] | None]:
    """Return a reader of frames as they are to be seen, and how they were turned for that, if they were."""
    turn = turn_of(first)
    return (reader, None) if turn is None else (Upright(reader, turn), turn)


def turned(picture: Any, turn: tuple[bool, bool, bool]) -> Any:
    """Return a frame that is turned, in its own format or the one in which such frames are mixed."""
    av = needed("av")
    transposed, from_left, from_top = turn
    kept = working_format(picture.format.name)
    form = av.VideoFormat(kept, 64, 64)
    # Colour that is sharper one way than the other would be so the other way.
    even = kept
    if transposed and form.chroma_width() != form.chroma_height() and form.chroma_width():
        even = working_format(kept.replace("422", "444").replace("411", "444").replace("440", "444"))
    source = picture if picture.format.name == even else picture.reformat(format=even)
    width, height = (source.height, source.width) if transposed else (source.width, source.height)
    made = av.VideoFrame(width, height, even)
    layout = layout_of_frame(source)
    for plane, target in zip(planes_of(source, layout), planes_of(made, layout), strict=True):
        view = plane.swapaxes(0, 1) if transposed else plane
        target[...] = view[:: -1 if from_top else 1, :: -1 if from_left else 1]
    if even != kept:
        made = made.reformat(format=kept)
    copy_colours(picture, made)
    return made
