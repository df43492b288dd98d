"""What an output takes over as it is, at its new times: covers, subtitles, chapters, the names of its makers."""

from __future__ import annotations

from fractions import Fraction
from typing import Any

from retime.media.extras import needed
from retime.media.job import Job, Report
from retime.media.opening import SharedFile, open_media
from retime.media.pieces import spans_shown

# Names of the work and its makers; what speaks of the file's own bytes is written anew.
KEPT_METADATA = {"title", "artist", "album", "comment", "date", "creation_time", "copyright", "description", "genre"}


def add_copied_streams(job: Job, output: Any, container: Any, copied: list[int], report: Report) -> dict[int, Any]:
    """Add streams whose packets are copied: covers, and subtitles at their new times."""
    added = {}
    for index in copied:
        stream = container.streams[index]
        codec = stream.codec_context.codec.canonical_name if stream.codec_context is not None else ""
        if codec not in output.supported_codecs:
            report.warn(f"{job.place.suffix} holds no {stream.type} of the kind {codec or 'unknown'}: it was left out")
            continue
        made = output.add_stream_from_template(stream, opaque=True)
        made.disposition = stream.disposition
        made.metadata.update(stream.metadata)
        added[index] = made
    return added


def copy_packets(job: Job, output: Any, shared: SharedFile, added: dict[int, Any], origin: Fraction) -> None:
    """Copy packets of covers and subtitles; these at all times at which the warp shows theirs."""
    with open_media(shared, job.path) as container:
        found = []
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
            made = av.Packet(bytes(packet))
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
