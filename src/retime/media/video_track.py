"""The frames of an output: made by a plan, and encoded as a stream or as numbered pictures."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from fractions import Fraction
from typing import Any, BinaryIO

import numpy as np

from retime.errors import FormatError
from retime.media.encoding import add_video, encoder_for_pictures, is_rgb, pixel_format_for, range_of, set_quality
from retime.media.extras import needed
from retime.media.job import Job, Report
from retime.media.kinds import numbered
from retime.media.losses import Looks, looks_of
from retime.media.mixing import average, between, copy_colours, working_format
from retime.media.reader import FrameReader
from retime.media.times import FramePlan
from retime.media.tracks import Ahead, Track, say_other_codec
from retime.media.upright import SAY_TURNS, upright


def frames_of(plan: FramePlan, reader: FrameReader, working: str, size: tuple[int, int]) -> Iterator[tuple[int, Any]]:
    """Make the frames of an output, each with its stamp.

    Parameters
    ----------
    plan : FramePlan
        What each shows.
    reader : FrameReader
        The input.
    working : str
        The format in which frames are mixed.
    size : (int, int)
        Width and height.
    """

    def fitting(frame: int) -> Any:
        picture = reader.get(frame)
        if (picture.width, picture.height) != size or picture.format.name != working:
            fitted = picture.reformat(*size, format=working)
            copy_colours(picture, fitted)
            return fitted
        return picture

    n_input = len(reader.times.stamps)
    # The last mixture: a frame that is held is made once.
    last: tuple[Any, Any] = (None, None)
    for number, stamp in enumerate(plan.stamps.tolist()):
        frames, weights = plan.shown(number, n_input)
        what = (frames.tobytes(), weights.tobytes())
        if last[0] != what:
            pictures = [fitting(frame) for frame in frames.tolist()]
            if plan.mode == "flow" and len(pictures) == 2 and plan.halves[number] == 0:
                made = between(pictures[0], pictures[1], float(weights[1]))
            else:
                made = average(pictures, weights)
            last = (what, made)
        yield stamp, last[1]


@dataclass(frozen=True)
class Picture:
    """A stream of frames: of PyAV, where there is one; its frames; and its bytes a second."""

    stream: Any
    reader: FrameReader
    bytes_a_second: float | None


def video_track(job: Job, output: Any, picture: Picture, plan: FramePlan, report: Report) -> tuple[Track, Looks]:
    """Add a stream for frames, and what makes them; and how it should look."""
    number = round(float(plan.places[0]))
    # What lies beside a frame (rotation, light) is the decoder's.
    beside = picture.reader.get(number)
    looks = looks_of(picture.stream, beside)
    reader, turn = picture.reader, None
    if output.format.name not in SAY_TURNS:
        reader, turn = upright(reader, beside)
    if turn is not None:
        looks = looks._replace(turned=False, aspect=1 / looks.aspect if turn[0] else looks.aspect)
    first = reader.get(number)
    # Where nobody says it, the shape of pixels is left unsaid too.
    aspect = looks.aspect if picture.stream is not None and picture.stream.sample_aspect_ratio else None
    stream = add_video(
        output,
        picture.stream,
        first,
        beside,
        aspect,
        plan.rate,
        plan.base,
        picture.bytes_a_second,
        job.options,
        job.place,
    )
    say_other_codec(job, report, picture.stream, stream)
    form = stream.codec_context.pix_fmt
    steps = Ahead(frames_of(plan, reader, working_format(first.format.name), (first.width, first.height)))
    return Track(stream, _encoded_frames(stream, steps, plan, form)), looks


def _encoded_frames(stream: Any, steps: Iterable[tuple[int, Any]], plan: FramePlan, form: str) -> Iterator[Any]:
    """Encode frames; the packets, with the time that is reached."""
    palette = _Palette() if form == "pal8" else None
    ends = np.append(plan.stamps[1:], plan.end)
    lengths = dict(zip(plan.stamps.tolist(), (ends - plan.stamps).tolist(), strict=True))
    wanted = int(stream.codec_context.color_range) or 1
    for (stamp, picture), end in zip(steps, ends.tolist(), strict=True):
        shown = picture
        if palette is not None:
            shown = palette.applied(picture)
        elif picture.format.name != form or range_of(picture) != wanted:
            shown = picture.reformat(format=form, src_color_range=range_of(picture), dst_color_range=wanted)
        # The encoder decides on kinds of frames by itself, and keeps a reference of its own.
        shown.pict_type, shown.pts, shown.time_base, shown.duration = 0, stamp, plan.base, end - stamp
        yield float(end * plan.base), _lasting(stream.encode(shown), lengths, plan.base)
    yield float(plan.end * plan.base), _lasting(stream.encode(None), lengths, plan.base)


def _lasting(packets: list[Any], lengths: dict[int, int], base: Fraction) -> list[Any]:
    """Say in packets how long their frames are shown: encoders guess it, and the last one may be held for long."""
    for packet in packets:
        length = None if packet.pts is None else lengths.get(round(packet.pts * packet.time_base / base))
        if length is not None:
            packet.duration = round(length * base / packet.time_base)
    return packets


class _Palette:
    """Colours of a GIF, chosen for each frame by itself."""

    def __init__(self) -> None:
        self._graphs: dict[tuple[int, int, str], Any] = {}

    def applied(self, picture: Any) -> Any:
        av = needed("av")
        key = (picture.width, picture.height, picture.format.name)
        if key not in self._graphs:
            graph = av.filter.Graph()
            source = graph.add_buffer(
                width=key[0], height=key[1], format=av.VideoFormat(key[2], *key[:2]), time_base=Fraction(1, 1000)
            )
            split = graph.add("split")
            found = graph.add("palettegen", "stats_mode=single")
            used = graph.add("paletteuse", "new=1:dither=bayer:bayer_scale=4")
            sink = graph.add("buffersink")
            source.link_to(split)
            split.link_to(used, 0, 0)
            split.link_to(found, 1, 0)
            found.link_to(used, 0, 1)
            used.link_to(sink)
            graph.configure()
            self._graphs[key] = (graph, source, sink, [0])
        graph, source, sink, count = self._graphs[key]
        # A time of its own for each, though it may be shown again.
        count[0] += 1
        picture.pts, picture.time_base = count[0], Fraction(1, 1000)
        source.push(picture)
        return sink.pull()


def write_pictures(
    job: Job, plan: FramePlan, picture: Picture, target: BinaryIO, report: Report, first_number: int
) -> None:
    """Write pictures one after the other into a file, and tell how long each is: who has asked parts them."""
    av = needed("av")
    encoder = encoder_for_pictures(job.place)
    number = round(float(plan.places[0]))
    reader, _ = upright(picture.reader, picture.reader.get(number))
    first = reader.get(number)
    working = working_format(first.format.name)
    form = pixel_format_for(encoder, working, job.options.pixel_format)
    has_full_range = is_rgb(av.VideoFormat(form, 16, 16)) or (encoder == "mjpeg" and not form.startswith("yuvj"))
    for number, (_, shown) in enumerate(Ahead(frames_of(plan, reader, working, (first.width, first.height)))):
        context = av.CodecContext.create(encoder, "w")
        context.width, context.height, context.pix_fmt = first.width, first.height, form
        context.time_base = Fraction(1, 25)
        wanted: dict[str, str] = {}
        set_quality(context, None, encoder, None, job.options, wanted)
        if has_full_range:
            context.color_range = 2
        context.options = wanted
        one = shown if shown.format.name == form else shown.reformat(format=form)
        if is_rgb(one.format):
            # PNG says it in words of video (cICP).
            one.color_range = 2
        one.pict_type, one.pts, one.time_base = 0, 0, Fraction(1, 25)
        data = b"".join(bytes(packet) for packet in (*context.encode(one), *context.encode(None)))
        if not data:
            raise FormatError(f"{encoder} made nothing of a picture", path=job.place)
        target.write(data)
        report.tell({"picture": [numbered(job.place.name, first_number + number), len(data)]})
        report.share(float((number + 1) / plan.rate))
