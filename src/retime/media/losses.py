"""What an output does not hold of the input's looks, found by reading it again."""

from __future__ import annotations

from collections.abc import Iterator
from fractions import Fraction
from typing import Any, NamedTuple

from retime.errors import FormatError
from retime.media.encoding import is_rgb, side_data
from retime.media.extras import needed
from retime.media.job import Job, Report
from retime.media.opening import SharedFile, open_media
from retime.media.reader import decoder_of
from retime.media.streams import streams_of
from retime.media.upright import turn_of

# Numbers of colours (as of H.273) that are one and the same to the eye: those of television and of screens.
_USUAL_PRIMARIES, _USUAL_TRANSFERS = {1, 2, 5, 6, 7}, {1, 2, 6, 13, 14, 15}
_UNSAID = 2
# As many packets as a first frame may take.
_MOST_PACKETS = 64


class Looks(NamedTuple):
    """How a stream's frames look.

    Attributes
    ----------
    alpha : bool
        Whether anything of its first frame can be seen through.
    bits : int
        Of a sample.
    aspect : Fraction
        Width of a pixel, over its height.
    turned : bool
        Whether it is to be turned.
    matrix, primaries, transfer : int
        As H.273 numbers them; of the matrix 0 for red, green and blue, and 2 where none is said, of the others 1 for
        all that are one to the eye.
    usual_matrix : int
        What players take where none is said.
    light : bool
        Whether it says how light it is, and which screen it was made on (HDR).
    """

    alpha: bool
    bits: int
    aspect: Fraction
    turned: bool
    matrix: int
    primaries: int
    transfer: int
    usual_matrix: int
    light: bool


def looks_of(stream: Any, frame: Any) -> Looks:
    """Return how a stream looks whose first frame is given."""
    form = frame.format
    matrix = 0 if is_rgb(form) else int(frame.colorspace)
    primaries, transfer = int(frame.color_primaries), int(frame.color_trc)
    return Looks(
        _seen_through(frame),
        8 if form.has_palette else max((component.bits for component in form.components), default=8),
        Fraction((stream.sample_aspect_ratio if stream is not None else None) or 1),
        turn_of(frame) is not None,
        {3: 2, 5: 6}.get(matrix, matrix),
        1 if primaries in _USUAL_PRIMARIES else primaries,
        1 if transfer in _USUAL_TRANSFERS else transfer,
        1 if min(frame.width, frame.height) >= 720 else 6,
        any(side_data(frame, name) for name in ("MASTERING_DISPLAY_METADATA", "CONTENT_LIGHT_LEVEL")),
    )


def _seen_through(frame: Any) -> bool:
    """Say whether a frame has alpha that hides something: many have some that hides nothing."""
    form = frame.format
    if not form.has_palette and not any(component.is_alpha for component in form.components):
        return False
    return bool((frame.to_ndarray(format="rgba")[:, :, 3] < 255).any())


def lost(before: Looks, after: Looks, *, format_told: bool) -> list[str]:
    """Name what is lost, in words; what a person asked for with a pixel format is no loss.

    Examples
    --------
    >>> plain = Looks(False, 8, Fraction(1), False, 1, 1, 1, 1, False)
    >>> lost(plain._replace(alpha=True, bits=10), plain, format_told=False)
    ['its alpha', '2 of 10 bits a sample']
    """
    found = []
    if not format_told:
        if before.alpha and not after.alpha:
            found.append("its alpha")
        if after.bits < before.bits:
            found.append(f"{before.bits - after.bits} of {before.bits} bits a sample")
    if abs(before.aspect / after.aspect - 1) > Fraction(1, 100):
        found.append(f"the shape of its pixels ({before.aspect})")
    if before.turned and not after.turned:
        found.append("how it is turned")
    matrix = after.usual_matrix if after.matrix == _UNSAID else after.matrix
    changed = {
        "matrix": matrix != 0 and before.matrix not in (0, _UNSAID, matrix),
        "primaries": before.primaries != after.primaries,
        "transfer": before.transfer != after.transfer,
    }
    if any(changed.values()):
        found.append(f"what its colours mean ({', '.join(name for name, is_so in changed.items() if is_so)})")
    if before.light and not after.light:
        found.append("its light (HDR)")
    return found


def say_losses(job: Job, seen: list[Looks], target: Any, report: Report) -> None:
    """Read an output again that is written, and warn of what it doesn't hold.

    Parameters
    ----------
    job : Job
        What was done.
    seen : list of Looks
        Of the streams that were written, as they should look.
    target : file
        The output, to be read.
    report : Report
        Is told.
    """
    try:
        found = list(_first_looks(job, SharedFile(target)))
    except FormatError:
        # A format that is written here and not read (animated WebP).
        return
    for before, (codec, after) in zip(seen, found, strict=False):
        words = lost(before, after, format_told=job.options.pixel_format is not None)
        if words:
            what = " and ".join([", ".join(words[:-1]), words[-1]] if words[1:] else words)
            report.warn(
                f"{job.place}: not kept, as {codec} in {job.place.suffix} can't hold it here: {what}. Another ending "
                "or --codec may: HEVC in .mp4, FFV1 in .mkv, ProRes in .mov"
            )


def _first_looks(job: Job, shared: SharedFile) -> Iterator[tuple[str, Looks]]:
    """Decode the first frame of each stream of video; the names of their codecs, and their looks."""
    av = needed("av")
    with open_media(shared, job.place) as container:
        indices = streams_of(container).pictures
    for index in indices:
        with open_media(shared, job.place) as container:
            stream = container.streams[index]
            decode = decoder_of(stream)
            packets = container.demux(stream)
            for _ in range(_MOST_PACKETS):
                try:
                    packet = next(packets, None)
                    pictures = decode(packet) if packet is not None else []
                except av.FFmpegError:
                    return
                if pictures:
                    yield stream.codec_context.codec.canonical_name, looks_of(stream, pictures[0])
                    break
                if packet is None:
                    return
