"""The sound of an output: retimed, and encoded as a stream."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from fractions import Fraction
from typing import Any

import numpy as np

from retime.media.encoding import encoder_for, keep_names
from retime.media.extras import needed
from retime.media.job import Job, Report
from retime.media.sound import Samples, retimed_sound, sound_length
from retime.media.sound_reader import SoundReader
from retime.media.tracks import Ahead, Track, say_other_codec

# Bits a second of a channel whose samples were plain before, so that hardly anything of them is lost.
_OF_PLAIN = {"aac": 96_000, "libopus": 80_000, "libmp3lame": 128_000}


def sound_track(job: Job, output: Any, source: Any, sound: SoundReader, tail: float, report: Report) -> Track:
    """Add a stream for sound, and what makes it; of sound from another file in the format's usual codec."""
    av = needed("av")
    codec = source.codec_context.codec.canonical_name
    encoder = encoder_for("audio", codec if job.sound is None else None, output, None, job.place)
    rates = av.Codec(encoder, "w").audio_rates
    rate = sound.rate if not rates or sound.rate in rates else max(rates)
    stream = output.add_stream(encoder, rate=rate, layout=sound.layout)
    say_other_codec(job, report, source, stream)
    made = stream.codec_context
    formats = [one.name for one in av.Codec(encoder, "w").audio_formats or []]
    form = source.codec_context.format.name if source.codec_context.format is not None else "fltp"
    made.format = form if form in formats else (formats[0] if formats else form)
    if job.sound is None and source.codec_context.bit_rate and not codec.startswith("pcm"):
        made.bit_rate = max(6000, min(int(source.codec_context.bit_rate), 512_000))
    elif encoder in _OF_PLAIN:
        made.bit_rate = min(_OF_PLAIN[encoder] * sound.n_channels, 512_000)
    warp, offset = (job.warp, round(job.options.offset * sound.rate)) if job.sound is None else (job.sound.warp, 0)
    if job.sound is None:
        keep_names(source, stream)
    blocks = retimed_sound(
        lambda first, count: sound.read(first - offset, count),
        sound.n_channels,
        sound.rate,
        warp,
        keep_pitch=job.options.sound == "keep-pitch",
        tail=tail,
    )
    total = sound_length(warp, sound.rate, tail) / sound.rate
    return Track(stream, _encoded_sound(stream, Ahead(blocks), sound, rate, total))


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
