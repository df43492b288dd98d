"""The work on one file: decoded, warped and encoded, each at its own pace. Runs in a process that may die of it."""

from __future__ import annotations

import io
import queue
import threading
from collections.abc import Callable, Generator, Iterable, Iterator
from dataclasses import dataclass, field
from fractions import Fraction
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np

from retime.errors import FormatError, OptionError
from retime.media.encoding import (
    CONTAINERS,
    add_video,
    encoder_for,
    encoder_for_pictures,
    pixel_format_for,
    range_of,
    set_quality,
)
from retime.media.extras import needed
from retime.media.kinds import find_sequence, is_sequence, is_sound, numbered
from retime.media.mixing import average, between, copy_colours, working_format
from retime.media.opening import FileView, SharedFile, open_media
from retime.media.options import MediaOptions
from retime.media.pieces import spans_shown
from retime.media.reader import FrameReader, VideoReader
from retime.media.sound import Samples, retimed_sound, sound_length
from retime.media.sound_reader import SoundReader
from retime.media.streams import streams_of, uncontained_frames
from retime.media.times import FramePlan, plan_frames
from retime.warp.curve import Warp
from retime.warp.sampling import range_problem

# Frames that wait for the encoder.
_AHEAD = 6
MOST_SOUNDS = 16
"""Streams of sound that a file may have."""


@dataclass
class Report:
    """What the work tells: that it lives, how far it is, what a person should know.

    Attributes
    ----------
    tell : function
        Takes one fact at a time, as JSON has it.
    """

    tell: Callable[[dict[str, Any]], None]
    total: float = 1.0
    done: float = 0.0
    warnings: set[str] = field(default_factory=set)

    def beat(self) -> None:
        """Say that something was done."""
        self.tell({"beat": 1})

    def share(self, seconds: float) -> None:
        """Say how many seconds of the output there are."""
        self.done = max(self.done, seconds)
        self.tell({"share": min(1.0, self.done / self.total)})

    def warn(self, text: str) -> None:
        """Say something that a person should know, once."""
        if text not in self.warnings:
            self.warnings.add(text)
            self.tell({"warning": text})


class _Ahead:
    """An iterator that another thread goes through, some steps ahead."""

    def __init__(self, source: Iterator[Any]) -> None:
        self._queue: queue.Queue[Any] = queue.Queue(_AHEAD)
        self._thread = threading.Thread(target=self._go, args=(source,), daemon=True)
        self._thread.start()

    def _go(self, source: Iterator[Any]) -> None:
        try:
            for item in source:
                self._queue.put((item, None))
        except BaseException as error:
            # It is raised again where the items are taken.
            self._queue.put((None, error))
        else:
            self._queue.put((None, StopIteration()))

    def __iter__(self) -> Generator[Any, None, None]:
        while True:
            item, error = self._queue.get()
            if isinstance(error, StopIteration):
                return
            if error is not None:
                raise error
            yield item


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
class Job:
    """What is to be done.

    Attributes
    ----------
    path, place : Path
        The input, and where the output will be.
    warp : Warp
        From output time to input time.
    options : MediaOptions
        How.
    """

    path: Path
    place: Path
    warp: Warp
    options: MediaOptions


def retime_file(job: Job, source: BinaryIO | None, target: BinaryIO, spools: list[BinaryIO], report: Report) -> None:
    """Retime one file into another, which is open; `spools` are files for sound.

    Raises
    ------
    FormatError, OptionError
        The input is not what it should be, or can't become what is asked for.
    """
    reader = uncontained_frames(job.path, source, job.options.fps, report.beat)
    if reader is not None:
        first_number = find_sequence(job.path).numbers[0] if is_sequence(job.path) else 1
        _write(job, [_Picture(None, reader, None)], [], [], None, target, report, first_number=first_number)
        return
    assert source is not None
    shared = SharedFile(source)
    with open_media(shared, job.path) as container:
        pictures, covers, sounds, texts, others = streams_of(container)
        if not pictures and not sounds:
            raise FormatError("no video and no sound", path=job.path)
        if others:
            kinds = ", ".join(sorted({str(container.streams[index].type) for index in others}))
            report.warn(f"{job.path}: what is neither seen nor heard was left out (streams of {kinds}: {len(others)})")
        tracks = []
        for index in pictures:
            reader = VideoReader(shared, job.path, index, job.options.fps, report.beat, whole=job.options.deinterlace)
            length = len(reader.times.stamps) / float(reader.times.rate)
            tracks.append(_Picture(container.streams[index], reader, reader.scanned.n_bytes / length))
        origin = None
        if tracks:
            stream = container.streams[pictures[0]]
            assert isinstance(tracks[0].reader, VideoReader)
            if not tracks[0].reader.scanned.counted:
                origin = Fraction(int(tracks[0].reader.first_stamp)) * stream.time_base
        heard = [container.streams[index] for index in sounds]
        sound_readers = []
        if job.options.sound != "drop" and not is_sequence(job.place):
            if len(heard) > len(spools):
                raise FormatError(f"{len(heard)} streams of sound; {len(spools)} are the most", path=job.path)
            sound_readers = [
                (stream, SoundReader(shared, job.path, stream.index, origin, spool, report.beat))
                for stream, spool in zip(heard, spools, strict=False)
            ]
        for _, sound in sound_readers:
            if sound.damaged:
                report.warn(f"{job.path}: a part of its sound is damaged")
        _write(job, tracks, sound_readers, [*covers, *texts], container, target, report, shared=shared, origin=origin)


@dataclass(frozen=True)
class _Picture:
    """A stream of frames: of PyAV, where there is one; its frames; and its bytes a second."""

    stream: Any
    reader: FrameReader
    bytes_a_second: float | None


class _Track:
    """Frames or samples on their way into one stream of the output.

    Attributes
    ----------
    time : float
        Seconds of the output that were encoded.
    """

    def __init__(self, stream: Any, steps: Iterable[Any]) -> None:
        self.stream, self.steps, self.time, self.ended = stream, iter(steps), 0.0, False


def _write(
    job: Job,
    pictures: list[_Picture],
    sounds: list[tuple[Any, SoundReader]],
    copied: list[int],
    container: Any,
    target: BinaryIO,
    report: Report,
    *,
    first_number: int = 1,
    shared: SharedFile | None = None,
    origin: Fraction | None = None,
) -> None:
    """Write the output: numbered pictures, or a container of streams."""
    job_options, place = job.options, job.place
    if not pictures and (is_sequence(place) or place.suffix.lower() in (".gif", ".webp", ".apng")):
        raise OptionError(f"{job.path} holds sound alone, and {place} holds pictures")
    report.total = job.warp.output_span or 1.0
    plans = [
        plan_frames(
            picture.reader.times,
            job.warp,
            offset=job_options.offset,
            rate=job_options.rate,
            mode=job_options.frames,
            shutter=job_options.averaged,
        )
        for picture in pictures
    ]
    _compare_ranges(job, pictures[0].reader if pictures else None, sounds[0][1] if sounds else None, report)
    if is_sequence(place):
        _write_pictures(job, plans[0], pictures[0], target, report, first_number)
        return
    av = needed("av")
    only_sound = is_sound(place)
    if only_sound and not sounds:
        raise OptionError(f"{place} holds sound, and there is none to write")
    name = CONTAINERS[place.suffix.lower()]
    again = _OutputAgain(target)
    with av.open(target, "w", format=name, options=_container_options(name), io_open=lambda *_: again.view()) as output:
        if container is not None:
            output.metadata.update({key: value for key, value in container.metadata.items() if key in _KEPT_METADATA})
        tracks: list[_Track] = []
        if not only_sound:
            for picture, plan in zip(pictures, plans, strict=True):
                tracks.append(_video_track(job, output, picture, plan, report))
                if name in ("gif", "webp", "apng"):
                    break
        tail = float(1 / plans[0].rate) if plans and job_options.rate != "variable" else 0.0
        if plans and plans[0].base != 1 / plans[0].rate:
            tail = max(0.0, float(plans[0].end * plans[0].base) - job.warp.output_span)
        if sounds and name not in ("gif", "webp", "apng"):
            for stream, sound in sounds:
                tracks.append(_sound_track(job, output, stream, sound, tail, report))
                if only_sound and name in ("wav", "flac", "mp3", "adts", "aiff", "opus"):
                    break
        texts = _copied_streams(job, output, container, copied, report) if container is not None else {}
        if container is not None:
            _chapters(job, output, container)
        output.start_encoding()
        if texts:
            assert shared is not None
            _copy(job, output, shared, texts, origin or Fraction(0))
        _run(tracks, output, report)
    for picture in pictures:
        if getattr(picture.reader, "in_fields", False):
            report.warn(
                f"{job.path}: interlaced; whole frames were made of its fields (--no-deinterlace takes its frames as "
                "they are)"
                if job.options.deinterlace
                else f"{job.path}: interlaced, and its frames were taken as they are: moving edges look like combs "
                "wherever the speed changes"
            )
        missing = getattr(picture.reader, "missing", ())
        if missing:
            report.warn(
                f"{job.path}: {len(missing)} of {len(picture.reader.times.stamps)} frames can't be decoded (the first "
                f"is {min(missing)}); those before them stand for them"
            )


def _compare_ranges(job: Job, frames: FrameReader | None, sound: SoundReader | None, report: Report) -> None:
    """Warn where the warp and the media don't cover the same times."""
    low, high = (float(edge) - job.options.offset for edge in (job.warp.input_times.min(), job.warp.input_times.max()))
    if frames is not None:
        rate = float(frames.times.rate)
        # As of a motion; the last frame may be shown for longer than the others.
        end = frames.seconds - 1 / rate
    elif sound is not None:
        # To a twentieth of a second: sound has no frames.
        end, rate = sound.seconds, 10.0
    else:
        return
    problem = range_problem(low, high, end, rate, job.path.name)
    if problem:
        report.warn(problem)


# Names of the work and its makers; what speaks of the file's own bytes is written anew.
_KEPT_METADATA = {"title", "artist", "album", "comment", "date", "creation_time", "copyright", "description", "genre"}


class _OutputAgain:
    """The output, which MP4 and MOV read again to lay their table of contents before it, so that it plays at once."""

    def __init__(self, target: BinaryIO) -> None:
        self._target = target
        self.size = 0

    def read(self, start: int, count: int) -> bytes:
        """Read bytes at a place; the place at which the output is written stays."""
        place = self._target.tell()
        self._target.seek(start)
        data = self._target.read(count)
        self._target.seek(place)
        return data

    def view(self) -> FileView:
        """Return a reader of what there is by now."""
        place = self._target.tell()
        self.size = self._target.seek(0, io.SEEK_END)
        self._target.seek(place)
        return FileView(self)


def _container_options(name: str) -> dict[str, str]:
    if name in ("mp4", "mov", "ipod", "3gp"):
        return {"movflags": "+faststart"}
    if name in ("gif", "webp", "apng"):
        return {"loop": "0"} if name != "apng" else {"plays": "0"}
    return {}


def _say_other_codec(job: Job, report: Report, source: Any, made: Any) -> None:
    """Say that a stream is encoded otherwise than the input's, where the output is a file of the same kind."""
    if source is None or job.options.codec is not None or job.path.suffix.lower() != job.place.suffix.lower():
        return
    before, after = (one.codec_context.codec.canonical_name for one in (source, made))
    if before != after:
        kind = {"video": "video", "audio": "sound"}[source.type]
        report.warn(f"{job.path}: its {kind} is {before}, which can't be written so; the output's is {after}")


def _video_track(job: Job, output: Any, picture: _Picture, plan: FramePlan, report: Report) -> _Track:
    """Add a stream for frames, and what makes them."""
    first = picture.reader.get(round(float(plan.places[0])))
    working = working_format(first.format.name)
    size = (first.width, first.height)
    # What lies beside a frame (rotation, light) is the decoder's.
    stream = add_video(
        output, picture.stream, first, plan.rate, plan.base, picture.bytes_a_second, job.options, job.place
    )
    _say_other_codec(job, report, picture.stream, stream)
    form = stream.codec_context.pix_fmt
    steps = _Ahead(frames_of(plan, picture.reader, working, size))
    return _Track(stream, _encoded_frames(stream, steps, plan, form))


def _encoded_frames(stream: Any, steps: Iterable[tuple[int, Any]], plan: FramePlan, form: str) -> Iterator[Any]:
    """Encode frames; the packets, with the time that is reached."""
    palette = _Palette() if form == "pal8" else None
    ends = np.append(plan.stamps[1:], plan.end)
    wanted = int(stream.codec_context.color_range)
    for (stamp, picture), end in zip(steps, ends.tolist(), strict=True):
        shown = picture
        if palette is not None:
            shown = palette.applied(picture)
        elif picture.format.name != form or (wanted and range_of(picture) != wanted):
            shown = picture.reformat(format=form, src_color_range=range_of(picture), dst_color_range=wanted)
        # The encoder decides on kinds of frames by itself, and keeps a reference of its own.
        shown.pict_type, shown.pts, shown.time_base, shown.duration = 0, stamp, plan.base, end - stamp
        yield float(end * plan.base), stream.encode(shown)
    yield float(plan.end * plan.base), stream.encode(None)


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


def _sound_track(job: Job, output: Any, source: Any, sound: SoundReader, tail: float, report: Report) -> _Track:
    """Add a stream for sound, and what makes it."""
    av = needed("av")
    codec = source.codec_context.codec.canonical_name
    encoder = encoder_for("audio", codec, output, None, job.place)
    rates = av.Codec(encoder, "w").audio_rates
    rate = sound.rate if not rates or sound.rate in rates else max(rates)
    stream = output.add_stream(encoder, rate=rate, layout=sound.layout)
    _say_other_codec(job, report, source, stream)
    made = stream.codec_context
    formats = [one.name for one in av.Codec(encoder, "w").audio_formats or []]
    form = source.codec_context.format.name if source.codec_context.format is not None else "fltp"
    made.format = form if form in formats else (formats[0] if formats else form)
    if source.codec_context.bit_rate and not codec.startswith("pcm"):
        made.bit_rate = max(6000, min(int(source.codec_context.bit_rate), 512_000))
    stream.metadata.update({key: value for key, value in source.metadata.items() if key in ("language", "title")})
    offset = round(job.options.offset * sound.rate)
    blocks = retimed_sound(
        lambda first, count: sound.read(first - offset, count),
        sound.n_channels,
        sound.rate,
        job.warp,
        keep_pitch=job.options.sound == "keep-pitch",
        tail=tail,
    )
    total = sound_length(job.warp, sound.rate, tail) / sound.rate
    return _Track(stream, _encoded_sound(stream, _Ahead(blocks), sound, rate, total))


def _encoded_sound(
    stream: Any, blocks: Iterable[Samples], sound: SoundReader, rate: int, total: float
) -> Iterator[Any]:
    av = needed("av")
    made = stream.codec_context
    resampler = None
    done = 0
    for block in blocks:
        for at in range(0, block.shape[1], sound.rate):
            some = np.ascontiguousarray(np.clip(block[:, at : at + sound.rate], -1, 1))
            frame = av.AudioFrame.from_ndarray(some, format="fltp", layout=sound.layout)
            frame.sample_rate, frame.pts, frame.time_base = sound.rate, done, Fraction(1, sound.rate)
            done += some.shape[1]
            if resampler is None:
                # The encoder is open by now, and says how many samples it takes at a time.
                resampler = av.AudioResampler(
                    format=made.format.name, layout=sound.layout, rate=rate, frame_size=made.frame_size or None
                )
            packets = [packet for one in resampler.resample(frame) for packet in stream.encode(one)]
            yield done / sound.rate, packets
    rest = [packet for one in resampler.resample(None) for packet in stream.encode(one)] if resampler else []
    yield total, [*rest, *stream.encode(None)]


def _run(tracks: list[_Track], output: Any, report: Report) -> None:
    """Encode all tracks side by side, the one that is behind first."""
    while True:
        running = [track for track in tracks if not track.ended]
        if not running:
            return
        track = min(running, key=lambda one: one.time)
        step = next(track.steps, None)
        if step is None:
            track.ended = True
            continue
        track.time, packets = step
        for packet in packets:
            if output.format.name == "adts" and packet.pts is not None and packet.pts < 0:
                # What an encoder puts before the first sample; this format can't say that it is there.
                continue
            output.mux(packet)
        report.share(min(one.time for one in tracks))


def _copied_streams(job: Job, output: Any, container: Any, copied: list[int], report: Report) -> dict[int, Any]:
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


def _copy(job: Job, output: Any, shared: SharedFile, added: dict[int, Any], origin: Fraction) -> None:
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


def _chapters(job: Job, output: Any, container: Any) -> None:
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


def _write_pictures(
    job: Job, plan: FramePlan, picture: _Picture, target: BinaryIO, report: Report, first_number: int
) -> None:
    """Write pictures one after the other into a file, and tell how long each is: who has asked parts them."""
    av = needed("av")
    encoder = encoder_for_pictures(job.place)
    first = picture.reader.get(round(float(plan.places[0])))
    working = working_format(first.format.name)
    form = pixel_format_for(encoder, working, job.options.pixel_format)
    for number, (_, shown) in enumerate(_Ahead(frames_of(plan, picture.reader, working, (first.width, first.height)))):
        context = av.CodecContext.create(encoder, "w")
        context.width, context.height, context.pix_fmt = first.width, first.height, form
        context.time_base = Fraction(1, 25)
        wanted: dict[str, str] = {}
        set_quality(context, None, encoder, None, job.options, wanted)
        if encoder == "mjpeg" and not form.startswith("yuvj"):
            context.color_range = 2
        context.options = wanted
        one = shown if shown.format.name == form else shown.reformat(format=form)
        one.pict_type, one.pts, one.time_base = 0, 0, Fraction(1, 25)
        data = b"".join(bytes(packet) for packet in (*context.encode(one), *context.encode(None)))
        if not data:
            raise FormatError(f"{encoder} made nothing of a picture", path=job.place)
        target.write(data)
        report.tell({"picture": [numbered(job.place.name, first_number + number), len(data)]})
        report.share(float((number + 1) / plan.rate))
