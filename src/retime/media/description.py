"""What a media file holds, told without retiming it: streams, sizes, rates, lengths, colours, chapters."""

from __future__ import annotations

from fractions import Fraction
from os import PathLike
from pathlib import Path
from typing import Any, BinaryIO

from retime.checks import path_of
from retime.errors import FormatError
from retime.files import resolved
from retime.media.extras import needed, refuse_without
from retime.media.kinds import is_sequence
from retime.media.process import check_media, run
from retime.motion.rate import parse_rate

MOST_STREAMS, MOST_CHAPTERS = 64, 1000
"""Of a file that are described one by one; others are counted."""

# What FFmpeg, and most tools after it, call the numbers of ITU-T H.273.
_MATRICES = {
    0: "rgb", 1: "bt709", 4: "fcc", 5: "bt470bg", 6: "smpte170m", 7: "smpte240m", 8: "ycgco", 9: "bt2020nc",
    10: "bt2020c",
}  # fmt: skip
_PRIMARIES = {
    1: "bt709", 4: "bt470m", 5: "bt470bg", 6: "smpte170m", 7: "smpte240m", 8: "film", 9: "bt2020", 10: "smpte428",
    11: "smpte431", 12: "smpte432", 22: "ebu3213",
}  # fmt: skip
_CURVES = {
    1: "bt709", 4: "gamma22", 5: "gamma28", 6: "smpte170m", 7: "smpte240m", 8: "linear", 9: "log100", 10: "log316",
    11: "iec61966-2-4", 12: "bt1361e", 13: "iec61966-2-1", 14: "bt2020-10", 15: "bt2020-12", 16: "smpte2084",
    17: "smpte428", 18: "arib-std-b67",
}  # fmt: skip
_RANGES = {1: "limited", 2: "full"}


def describe_media(path: str | PathLike[str], *, fps: Fraction | str | float | None = None) -> dict[str, Any]:
    """Say what a video, numbered pictures or a sound holds.

    Parameters
    ----------
    path : path-like
        The file; ``take.%04d.png`` stands for numbered pictures.
    fps : Fraction, str or float, optional
        Frames a second, in place of what the file says.

    Returns
    -------
    dict
        As JSON has it: ``container``, ``n_streams``, ``streams`` (a dict each, with its ``type``: "video", "cover",
        "audio", "subtitle" or another) and ``chapters``. A stream of video has ``codec``, ``width``, ``height`` (before
        it is turned), ``pixel_format``, ``bits``, ``alpha``, ``rate``, ``exact_rate``, ``variable_rate``, ``frames``,
        ``seconds``, ``pixel_aspect``, ``rotation`` (degrees, clockwise, by which players turn it), ``interlaced``,
        ``range``, ``matrix``, ``primaries``, ``transfer`` and ``hdr`` (None where nothing is said). One of sound has
        ``codec``, ``rate`` (Hz), ``channels``, ``layout``, ``seconds``.

    Raises
    ------
    FormatError, OSError, MissingExtraError
        As of `retime.media.apply.retime_media`.
    """
    path = path_of(path, "describe_media(path)")
    refuse_without("av", "cv2")
    check_media(path)
    told: dict[str, Any] = {}

    def take(fact: dict[str, Any]) -> None:
        if "media" in fact:
            told.update(fact["media"])

    rate = None if fps is None else str(parse_rate(fps))
    run({"do": "describe", "path": str(resolved(path)), "fps": rate}, path, take)
    return told


def tell_description(path: Path, source: BinaryIO | None, fps: Fraction | None, report: Any) -> None:
    """Tell what a file holds. Runs in the process that may die of it."""
    from retime.media.opening import SharedFile, open_media
    from retime.media.reader import VideoReader
    from retime.media.streams import streams_of, uncontained_frames

    reader = uncontained_frames(path, source, fps, report.beat)
    if reader is not None:
        container = "numbered pictures" if is_sequence(path) else "webp"
        codec = path.suffix.lower()[1:]
        pictures = {"index": 0, "type": "video", "codec": codec, **_of_frames(reader, None)}
        report.tell({"media": {"container": container, "n_streams": 1, "streams": [pictures], "chapters": []}})
        return
    assert source is not None
    shared = SharedFile(source)
    with open_media(shared, path) as container:
        kinds = streams_of(container)
        if not (kinds.pictures or kinds.sounds or kinds.covers):
            raise FormatError("no video and no sound", path=path)
        streams = list(container.streams)[:MOST_STREAMS]
        lengths = _lengths(container, [stream for stream in streams if stream.type == "audio"], report)
        described = []
        for stream in streams:
            one = {"index": stream.index, "type": stream.type, "codec": _codec(stream)}
            if stream.index in kinds.covers:
                one |= {"type": "cover", "width": stream.codec_context.width, "height": stream.codec_context.height}
            elif stream.index in kinds.pictures:
                frames = VideoReader(shared, path, stream.index, fps, report.beat)
                one |= _of_frames(frames, stream)
                frames.close()
            elif stream.type == "audio" and stream.codec_context is not None:
                one |= {
                    "rate": int(stream.rate or 0),
                    "channels": int(stream.layout.nb_channels),
                    "layout": stream.layout.name,
                    "seconds": lengths[stream.index],
                }
            one |= {key: str(stream.metadata[key]) for key in ("language", "title") if stream.metadata.get(key)}
            described.append(one)
        name = container.format.name.partition(",")[0]
        report.tell(
            {
                "media": {
                    "container": path.suffix.lower()[1:] if name == "mov" else name,
                    "n_streams": len(container.streams),
                    "streams": described,
                    "chapters": _chapters(container),
                }
            }
        )


def _codec(stream: Any) -> str:
    """Name a stream's codec; that of one that nothing here can decode is not known."""
    return "unknown" if stream.codec_context is None else str(stream.codec_context.codec.canonical_name)


def _lengths(container: Any, streams: list[Any], report: Any) -> dict[int, float]:
    """Say how long streams of sound are, seconds, by what their packets say."""
    av = needed("av")
    spans: dict[int, tuple[Fraction, Fraction]] = {}
    if streams:
        try:
            for packet in container.demux(*streams):
                report.beat()
                if packet.pts is None or not packet.size:
                    continue
                start = packet.pts * packet.time_base
                stop = start + (packet.duration or 0) * packet.time_base
                low, high = spans.get(packet.stream.index, (start, stop))
                spans[packet.stream.index] = min(low, start), max(high, stop)
        except av.FFmpegError:
            # What is whole of a damaged file counts, as it does where the file is retimed.
            pass
    return {
        stream.index: float(spans[stream.index][1] - max(Fraction(0), spans[stream.index][0]))
        if stream.index in spans
        else 0.0
        for stream in streams
    }


def _of_frames(reader: Any, stream: Any) -> dict[str, Any]:
    """Describe a stream by its times and its first frame."""
    from retime.media.encoding import light_parameters

    first, times = reader.get(0), reader.times
    context = None if stream is None else stream.codec_context
    form = first.format
    depths = [component.bits for component in form.components]

    def said(name: str) -> int:
        """Return what the frame says, or else the stream."""
        value = int(getattr(first, name))
        if value in ((0,) if name == "color_range" else (0, 2)) and context is not None:
            value = int(getattr(context, name))
        return value

    rate = times.rate
    aspect = None if context is None else context.sample_aspect_ratio
    transfer = _CURVES.get(said("color_trc"))
    return {
        "width": first.width,
        "height": first.height,
        "pixel_format": form.name,
        "bits": 8 if form.has_palette else max(depths, default=8),
        "alpha": bool(form.has_palette or any(component.is_alpha for component in form.components)),
        "rate": float(rate),
        "exact_rate": str(rate),
        "variable_rate": not times.even,
        "frames": len(times.stamps),
        "seconds": reader.seconds,
        "pixel_aspect": str(aspect) if aspect else "1",
        "rotation": -int(first.rotation) % 360,
        "interlaced": bool(first.interlaced_frame),
        "range": _RANGES.get(said("color_range")),
        "matrix": "rgb" if form.is_rgb else _MATRICES.get(said("colorspace")),
        "primaries": _PRIMARIES.get(said("color_primaries")),
        "transfer": transfer,
        "hdr": {"smpte2084": "PQ", "arib-std-b67": "HLG"}.get(transfer or ""),
        "light": light_parameters(first),
    }


def _chapters(container: Any) -> list[dict[str, Any]]:
    """List a container's chapters."""
    found = []
    for chapter in container.chapters()[:MOST_CHAPTERS]:
        base = chapter["time_base"] or Fraction(1, 1000)
        start, end = (float(chapter[edge] * base) for edge in ("start", "end"))
        found.append({"start": start, "end": end, "title": str(chapter["metadata"].get("title", ""))})
    return found
