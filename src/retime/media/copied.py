"""What an output takes over as it is, at its new times: covers, subtitles, chapters, the names of its makers."""

from __future__ import annotations

import re
from fractions import Fraction
from typing import Any, NamedTuple

from retime.media.extras import needed
from retime.media.job import Job, Report
from retime.media.opening import SharedFile, open_media
from retime.media.pieces import spans_shown

# Kinds of subtitles that are text and little else; the first that an output holds is written in place of another.
_TEXTS = ("subrip", "mov_text", "webvtt", "text")
_TAGS = re.compile(rb"</?[a-zA-Z][^<>]*>|\{\\[^{}]*\}")
_MOST_TEXT = 0xFFFF
# Names of the work and its makers; what speaks of the file's own bytes is written anew.
KEPT_METADATA = {"title", "artist", "album", "comment", "date", "creation_time", "copyright", "description", "genre"}


class Copied(NamedTuple):
    """Streams whose packets are copied.

    Attributes
    ----------
    streams : dict
        Of the output, by the number of the input's.
    written : dict
        Of subtitles that the output holds in another way: the names of the input's, and of the output's.
    """

    streams: dict[int, Any]
    written: dict[int, tuple[str, str]]


def add_copied_streams(job: Job, output: Any, container: Any, copied: list[int], report: Report) -> Copied:
    """Add streams whose packets are copied: covers, and subtitles at their new times."""
    added = {}
    written: dict[int, tuple[str, str]] = {}
    for index in copied:
        stream = container.streams[index]
        codec = stream.codec_context.codec.canonical_name if stream.codec_context is not None else ""
        if codec in output.supported_codecs:
            made = output.add_stream_from_template(stream, opaque=True)
        else:
            other = next((name for name in _TEXTS if codec in _TEXTS and name in output.supported_codecs), None)
            if other is None:
                kind = codec or "unknown"
                report.warn(f"{job.place.suffix} holds no {stream.type} of the kind {kind}: it was left out")
                continue
            made = output.add_mux_stream(other)
            written[index] = (codec, other)
        made.disposition = stream.disposition
        made.metadata.update(stream.metadata)
        added[index] = made
    return Copied(added, written)


def _text_written(data: bytes, kinds: tuple[str, str]) -> bytes:
    """Write the text of a subtitle as another kind does."""
    before, after = kinds
    text = data[2 : 2 + int.from_bytes(data[:2], "big")] if before == "mov_text" else data
    if after != "mov_text":
        return text
    # What is slanted or bold is said elsewhere there.
    plain = _TAGS.sub(b"", text)[:_MOST_TEXT]
    return len(plain).to_bytes(2, "big") + plain


def copy_packets(job: Job, output: Any, shared: SharedFile, copied: Copied, origin: Fraction) -> None:
    """Copy packets of covers and subtitles; these at all times at which the warp shows theirs."""
    with open_media(shared, job.path) as container:
        found = []
        added = copied.streams
        for packet in container.demux(*[container.streams[index] for index in added]):
            if not packet.size:
                continue
            if packet.stream.type != "subtitle":
                packet.stream = added[packet.stream.index]
                output.mux(packet)
                continue
            if packet.pts is None:
                continue
            start = float(packet.pts * packet.time_base - origin) + job.options.offset
            stop = start + float((packet.duration or 0) * packet.time_base)
            index = packet.stream.index
            for begin, end in spans_shown(job.warp, start, max(stop, start + 1e-3)):
                found.append((begin - job.warp.output_start, end - begin, index, packet))
        av = needed("av")
        for begin, length, index, packet in sorted(found, key=lambda one: one[:3]):
            data = bytes(packet)
            if index in copied.written:
                data = _text_written(data, copied.written[index])
                if not data:
                    # MP4 writes that there is none, where there is none.
                    continue
            made = av.Packet(data)
            made.stream, made.time_base = added[index], Fraction(1, 1000)
            made.pts = made.dts = round(begin * 1000)
            made.duration, made.is_keyframe = max(1, round(length * 1000)), True
            output.mux(made)


def write_chapters(job: Job, output: Any, container: Any) -> None:
    """Lay chapters where the warp shows their beginnings and ends."""
    found = []
    for chapter in container.chapters():
        base = chapter["time_base"] or Fraction(1, 1000)
        start, stop = (float(chapter[edge] * base) + job.options.offset for edge in ("start", "end"))
        for begin, end in spans_shown(job.warp, start, stop):
            if end > begin:
                found.append((begin - job.warp.output_start, end - job.warp.output_start, chapter["metadata"]))
    if found:
        output.set_chapters(
            [
                {
                    "id": number,
                    "start": round(begin * 1000),
                    "end": round(end * 1000),
                    "time_base": Fraction(1, 1000),
                    "metadata": dict(metadata),
                }
                for number, (begin, end, metadata) in enumerate(sorted(found, key=lambda one: one[:2]))
            ]
        )
