"""Clips with a known answer: frames that carry their number, a click track, a tone."""

from __future__ import annotations

from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np

WIDTH, HEIGHT, BITS = 96, 64, 10


def picture(number: int, *, width: int = WIDTH, height: int = HEIGHT) -> np.ndarray:
    """Draw a frame, grey: its number in blocks at the top, and a bar that moves two pixels a frame."""
    grey = np.full((height, width), 40, np.uint8)
    block = width // BITS
    for bit in range(BITS):
        grey[: height // 4, bit * block : (bit + 1) * block] = 235 if number >> bit & 1 else 16
    place = (2 * number) % (width - 8)
    grey[height // 2 :, place : place + 8] = 220
    return grey


def number_of(frame: Any) -> int:
    """Read the number in a frame."""
    grey = frame.reformat(format="gray").to_ndarray()
    block, top = grey.shape[1] // BITS, grey.shape[0] // 4
    means = [grey[2 : top - 2, bit * block + 2 : (bit + 1) * block - 2].mean() for bit in range(BITS)]
    return sum(1 << bit for bit, mean in enumerate(means) if mean > 128)


def sound(seconds: float, *, rate: int = 48_000, every: float = 0.5, first: float = 0.25) -> np.ndarray:
    """Make clicks on the left, and a tone of 440 Hz on the right."""
    n = round(seconds * rate)
    made = np.zeros((2, n), np.float32)
    for start in np.arange(first, seconds - 0.01, every):
        at = round(start * rate)
        made[0, at : at + 24] = 0.8 * np.hanning(24) * np.cos(np.arange(24) * 1.5)
    made[1] = 0.4 * np.sin(2 * np.pi * 440 * np.arange(n) / rate)
    return made


def write_clip(
    path: Path,
    n_frames: int = 60,
    *,
    rate: Fraction = Fraction(30),
    codec: str = "ffv1",
    form: str = "yuv420p",
    stamps: list[int] | None = None,
    base: Fraction | None = None,
    samples: np.ndarray | None = None,
    sound_codec: str = "pcm_s16le",
    size: tuple[int, int] = (WIDTH, HEIGHT),
    gop: int = 12,
    prepare: Any = None,
    change: Any = None,
    options: dict[str, str] | None = None,
) -> Path:
    """Write a clip of numbered frames; `stamps` in ticks of `base`, `prepare` gets the stream, `change` each frame."""
    import av

    with av.open(str(path), "w") as output:
        stream = output.add_stream(codec, rate=rate, options=options or {})
        stream.width, stream.height, stream.pix_fmt = *size, form
        stream.codec_context.gop_size = gop
        stream.codec_context.time_base = base or 1 / rate
        if codec in ("libx264", "libx265"):
            stream.options = {"crf": "12", **(options or {})}
        if prepare is not None:
            prepare(stream)
        heard = None
        if samples is not None:
            heard = output.add_stream(sound_codec, rate=48_000, layout="stereo" if len(samples) == 2 else "mono")
        for number in range(n_frames):
            frame = av.VideoFrame.from_ndarray(picture(number, width=size[0], height=size[1]), format="gray")
            frame = frame.reformat(format=form)
            frame.pts = number if stamps is None else stamps[number]
            frame.time_base = base or 1 / rate
            if change is not None:
                frame = change(number, frame)
            output.mux(stream.encode(frame))
        output.mux(stream.encode(None))
        if heard is not None:
            layout = "stereo" if len(samples) == 2 else "mono"
            resampler = av.AudioResampler(
                format=heard.codec_context.format.name,
                layout=layout,
                rate=48_000,
                frame_size=heard.codec_context.frame_size or 1024,
            )
            frame = av.AudioFrame.from_ndarray(np.ascontiguousarray(samples), format="fltp", layout=layout)
            frame.sample_rate, frame.pts = 48_000, 0
            for one in (*resampler.resample(frame), *resampler.resample(None)):
                output.mux(heard.encode(one))
            output.mux(heard.encode(None))
    return path


def write_sound(path: Path, samples: np.ndarray, *, codec: str = "pcm_s16le", rate: int = 48_000) -> Path:
    """Write sound alone."""
    import av

    with av.open(str(path), "w") as output:
        stream = output.add_stream(codec, rate=rate, layout="stereo" if len(samples) == 2 else "mono")
        layout = "stereo" if len(samples) == 2 else "mono"
        frame = av.AudioFrame.from_ndarray(np.ascontiguousarray(samples), format="fltp", layout=layout)
        frame.sample_rate, frame.pts = rate, 0
        resampler = av.AudioResampler(
            format=stream.codec_context.format.name,
            layout=layout,
            rate=rate,
            frame_size=stream.codec_context.frame_size or 1024,
        )
        for one in (*resampler.resample(frame), *resampler.resample(None)):
            output.mux(stream.encode(one))
        output.mux(stream.encode(None))
    return path


def read_frames(path: Path) -> tuple[list[int], list[Fraction], list[Any]]:
    """Read a clip: the numbers of its frames, their times, and the frames."""
    import av

    with av.open(str(path)) as container:
        frames = list(container.decode(video=0))
    return [number_of(frame) for frame in frames], [frame.pts * frame.time_base for frame in frames], frames


def read_sound(path: Path) -> tuple[np.ndarray, int]:
    """Read the samples of a file, from its time 0 on."""
    import av

    with av.open(str(path)) as container:
        stream = container.streams.audio[0]
        resampler = av.AudioResampler(format="fltp", layout=stream.layout.name, rate=stream.rate)
        parts, start = [], None
        for frame in container.decode(stream):
            if start is None:
                start = round(float(frame.pts * frame.time_base) * stream.rate)
            frame.pts = None
            parts += [one.to_ndarray() for one in resampler.resample(frame)]
        parts += [one.to_ndarray() for one in resampler.resample(None)]
        samples = np.concatenate(parts, axis=1)
        return (samples[:, -start:] if start < 0 else np.pad(samples, ((0, 0), (start, 0)))), stream.rate


def clicks_in(samples: np.ndarray, rate: int, *, least: float = 0.1) -> np.ndarray:
    """Find when clicks are loudest, in seconds."""
    size = np.abs(samples)
    found = []
    while size.max() > least:
        at = int(np.argmax(size))
        found.append(at / rate)
        size[max(0, at - rate // 50) : at + rate // 50] = 0
    return np.array(sorted(found))


def pitch_of(samples: np.ndarray, rate: int) -> float:
    """Measure the frequency of a tone, Hz."""
    power = np.abs(np.fft.rfft(samples * np.hanning(len(samples)), 1 << 19))
    return float(np.argmax(power)) * rate / (1 << 19)
