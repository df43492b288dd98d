"""The work on one file: decoded, warped and encoded, each at its own pace. Runs in a process that may die of it."""

from __future__ import annotations

from fractions import Fraction
from typing import Any, BinaryIO

from retime.errors import FormatError, OptionError
from retime.media.copied import KEPT_METADATA, add_copied_streams, copy_packets, write_chapters
from retime.media.encoding import CONTAINERS
from retime.media.extras import needed
from retime.media.job import Job, Report
from retime.media.kinds import find_sequence, is_sequence, is_sound
from retime.media.losses import Looks, say_losses
from retime.media.opening import OutputAgain, SharedFile, open_media
from retime.media.reader import FrameReader, VideoReader
from retime.media.sound_reader import SoundReader
from retime.media.sound_track import sound_track
from retime.media.streams import streams_of, uncontained_frames
from retime.media.times import FramePlan, plan_frames
from retime.media.tracks import Track, run_tracks
from retime.media.video_track import Picture, video_track, write_pictures
from retime.warp.sampling import range_problem

MOST_SOUNDS = 16
"""Streams of sound that a file may have."""
# Formats, as PyAV calls them: of pictures that move, without sound; and of sound in one stream.
_PICTURES_ALONE = ("gif", "webp", "apng")
_ONE_SOUND = ("wav", "flac", "mp3", "adts", "aiff", "opus")


def retime_file(
    job: Job,
    source: BinaryIO | None,
    target: BinaryIO,
    spools: list[BinaryIO],
    report: Report,
    heard_source: BinaryIO | None = None,
) -> None:
    """Retime one file into another, which is open; `spools` are files for sound, `heard_source` that of `job.sound`.

    Raises
    ------
    FormatError, OptionError
        The input is not what it should be, or can't become what is asked for.
    """
    reader = uncontained_frames(job.path, source, job.options.fps, report.beat)
    if reader is not None:
        first_number = find_sequence(job.path).numbers[0] if is_sequence(job.path) else 1
        picture = Picture(None, reader, None)
        if job.sound is None or heard_source is None:
            _write(job, [picture], [], [], None, target, report, first_number=first_number)
            return
        other = SharedFile(heard_source)
        with open_media(other, job.sound.path) as container:
            stream = next(iter(container.streams.audio), None)
            if stream is None:
                raise FormatError("no sound in it", path=job.sound.path)
            # Its time 0 is that of its first frame, where it has any: as of the input of a video.
            pictures = streams_of(container).pictures
            begin = container.streams[pictures[0]].start_time if pictures else None
            origin = None if begin is None else begin * container.streams[pictures[0]].time_base
            sound = SoundReader(other, job.sound.path, stream.index, origin, spools[0], report.beat)
            if sound.damaged:
                report.warn(f"{job.sound.path}: a part of its sound is damaged")
            _write(job, [picture], [(stream, sound)], [], None, target, report, first_number=first_number)
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
            tracks.append(Picture(container.streams[index], reader, reader.scanned.n_bytes / length))
        origin = None
        if tracks:
            stream = container.streams[pictures[0]]
            assert isinstance(tracks[0].reader, VideoReader)
            # AVI says no time of showing, and what is in it begins together.
            if not tracks[0].reader.scanned.counted and container.format.name != "avi":
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


def _write(
    job: Job,
    pictures: list[Picture],
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
    options, place = job.options, job.place
    if not pictures and (is_sequence(place) or place.suffix.lower() in (".gif", ".webp", ".apng")):
        raise OptionError(f"{job.path} holds sound alone, and {place} holds pictures")
    report.total = job.warp.output_span or 1.0
    plans = [
        plan_frames(
            picture.reader.times,
            job.warp,
            offset=options.offset,
            rate=options.rate,
            mode=options.frames,
            shutter=options.averaged,
        )
        for picture in pictures
    ]
    _compare_ranges(job, pictures[0].reader if pictures else None, sounds[0][1] if sounds else None, report)
    if is_sequence(place):
        write_pictures(job, plans[0], pictures[0], target, report, first_number)
        return
    av = needed("av")
    if is_sound(place) and not sounds:
        raise OptionError(f"{place} holds sound, and there is none to write")
    name = CONTAINERS[place.suffix.lower()]
    again = OutputAgain(target)
    with av.open(
        target, "w", format=name, options=_container_options(name, plans), io_open=lambda *_: again.view()
    ) as output:
        if container is not None:
            output.metadata.update({key: value for key, value in container.metadata.items() if key in KEPT_METADATA})
        tracks, looks = _tracks(job, output, list(zip(pictures, plans, strict=True)), sounds, report)
        texts = add_copied_streams(job, output, container, copied, report) if container is not None else None
        if container is not None:
            write_chapters(job, output, container)
        output.start_encoding()
        if texts is not None and texts.streams:
            assert shared is not None
            copy_packets(job, output, shared, texts, origin or Fraction(0))
        run_tracks(tracks, output, report)
    say_losses(job, looks, target, report)
    for picture in pictures:
        _warn_of_frames(job, picture, report)


def _tracks(
    job: Job,
    output: Any,
    pictures: list[tuple[Picture, FramePlan]],
    sounds: list[tuple[Any, SoundReader]],
    report: Report,
) -> tuple[list[Track], list[Looks]]:
    """Add the output's streams of frames and of sound: as many of the input's as its format holds.

    Returns
    -------
    (list of Track, list of Looks)
        And how those of frames should look.
    """
    name, only_sound = CONTAINERS[job.place.suffix.lower()], is_sound(job.place)
    tracks: list[Track] = []
    looks: list[Looks] = []
    if not only_sound:
        for picture, plan in pictures[:1] if name in _PICTURES_ALONE else pictures:
            track, look = video_track(job, output, picture, plan, report)
            tracks.append(track)
            looks.append(look)
    if name in _PICTURES_ALONE:
        return tracks, looks
    tail = _seconds_after(job, pictures[0][1]) if pictures else 0.0
    for stream, sound in sounds[:1] if only_sound and name in _ONE_SOUND else sounds:
        tracks.append(sound_track(job, output, stream, sound, tail, report))
    return tracks, looks


def _seconds_after(job: Job, plan: FramePlan) -> float:
    """For how long the last frame is shown after the warp's end: sound goes on as long."""
    if plan.base != 1 / plan.rate:
        return max(0.0, float(plan.end * plan.base) - job.warp.output_span)
    return 0.0 if job.options.rate == "variable" else float(1 / plan.rate)


def _warn_of_frames(job: Job, picture: Picture, report: Report) -> None:
    """Warn of frames that are made of fields, and of those that can't be decoded."""
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
            f"is {min(missing)}); those next to them stand for them"
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


def _container_options(name: str, plans: list[FramePlan]) -> dict[str, str]:
    if name in ("mp4", "mov", "ipod", "3gp"):
        return {"movflags": "+faststart"}
    if name == "apng":
        # Left out, the last frame would be shown for as long as the one before it.
        last = (plans[0].end - int(plans[0].stamps[-1])) * plans[0].base
        return {"plays": "0", "final_delay": str(last.limit_denominator(10_000))}
    return {"loop": "0"} if name in _PICTURES_ALONE else {}
