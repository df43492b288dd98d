"""Time the retiming of a video against PyAV's own filters, and measure how memory grows with its length.

    python benchmarks/bench_video.py [--quick] [--only speed|memory] [--size 1920x1080] [--seconds 20]
        [--minutes 1,3,10] [--rounds 3]

Needs the extra ``video``. The peer changes the speed of the same clip, by the same encoder with the same settings, with
FFmpeg's filters setpts and fps (nearest frames) or framerate (blended). Both take turns, and the best of each counts,
on the clock and in processor time of all processes. A ratio below 1 means that retime is the faster one. Memory is the
most of both processes, added up; its takes have no grain, so that they are encoded quickly.
"""

from __future__ import annotations

import argparse
import resource
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

import av
import numpy as np

from retime.media.apply import retime_media
from retime.media.options import MediaOptions
from retime.warp.curve import Warp

RATE, QUALITY = 30, 23


def write_take(path: Path, size: tuple[int, int], seconds: float, *, noise: int = 12) -> None:
    """Write a clip that moves and has grain (of `noise` levels), with a tone."""
    chance = np.random.default_rng(0)
    width, height = size
    grain = chance.integers(0, noise, (4, height, width), dtype=np.uint8)
    slope = np.linspace(60, 160, width * 3)[None, :]
    with av.open(str(path), "w") as output:
        stream = output.add_stream("libx264", rate=RATE, options={"crf": str(QUALITY), "preset": "ultrafast"})
        stream.width, stream.height, stream.pix_fmt = width, height, "yuv420p"
        sound = output.add_stream("aac", rate=48_000, layout="mono")
        for number in range(round(seconds * RATE)):
            start = 7 * number % (2 * width)
            luma = (slope[:, start : start + width] + grain[number % 4]).astype(np.uint8)
            chroma = np.full((height // 2, width), 128, np.uint8)
            frame = av.VideoFrame.from_ndarray(np.concatenate([luma, chroma]), format="yuv420p")
            frame.pts = number
            output.mux(stream.encode(frame))
            times = (np.arange(48_000 // RATE) + number * 48_000 // RATE) / 48_000
            tone = av.AudioFrame.from_ndarray(
                (0.3 * np.sin(2 * np.pi * 220 * times)).astype(np.float32)[None], format="fltp", layout="mono"
            )
            tone.sample_rate, tone.pts = 48_000, number * 48_000 // RATE
            output.mux(sound.encode(tone))
        output.mux(stream.encode(None))
        output.mux(sound.encode(None))


def by_filters(path: Path, place: Path, speed: float, kind: str) -> None:
    """Change a clip's speed by FFmpeg's filters, without its sound."""
    with av.open(str(path)) as source, av.open(str(place), "w") as output:
        given = source.streams.video[0]
        given.thread_type = "AUTO"
        stream = output.add_stream("libx264", rate=RATE, options={"crf": str(QUALITY)})
        stream.width, stream.height, stream.pix_fmt = given.width, given.height, "yuv420p"
        graph = av.filter.Graph()
        steps = [graph.add_buffer(template=given), graph.add("setpts", f"PTS/{speed}")]
        steps.append(graph.add("fps", str(RATE)) if kind == "nearest" else graph.add("framerate", f"fps={RATE}"))
        steps.append(graph.add("buffersink"))
        graph.link_nodes(*steps).configure()

        def drain() -> None:
            while True:
                try:
                    frame = graph.pull()
                except (av.BlockingIOError, av.EOFError):
                    return
                frame.pict_type = 0
                output.mux(stream.encode(frame))

        for frame in source.decode(given):
            graph.push(frame)
            drain()
        graph.push(None)
        drain()
        output.mux(stream.encode(None))


def processor_time() -> float:
    """Return the seconds that this process and those that it has waited for took of processors."""
    used = [resource.getrusage(who) for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN)]
    return sum(one.ru_utime + one.ru_stime for one in used)


def turns(tasks: dict[str, Callable[[], None]], rounds: int) -> dict[str, tuple[float, float]]:
    """Time tasks in turns; the best of each, seconds of the clock and of processors."""
    best = dict.fromkeys(tasks, (float("inf"), float("inf")))
    for _ in range(rounds):
        for name, task in tasks.items():
            begun, used = time.perf_counter(), processor_time()
            task()
            taken = time.perf_counter() - begun, processor_time() - used
            best[name] = min(best[name][0], taken[0]), min(best[name][1], taken[1])
    return best


_PEAK = """
import resource, sys
from retime.media.apply import retime_media
from retime.media.options import MediaOptions
from retime.warp.curve import Warp
seconds = float(sys.argv[3])
retime_media(sys.argv[1], sys.argv[2], Warp([0, seconds * 0.2, seconds * 0.65], [0, seconds * 0.5, seconds]),
             MediaOptions(quality=40), overwrite=True)
print(sum(resource.getrusage(who).ru_maxrss for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN)))
"""


def peak_megabytes(path: Path, place: Path, seconds: float) -> float:
    """Return the most memory that the process that asks, and the one that does the work, had in all."""
    run = subprocess.run(
        [sys.executable, "-W", "ignore", "-c", _PEAK, str(path), str(place), str(seconds)],
        capture_output=True,
        text=True,
        check=True,
    )
    place.unlink()
    return int(run.stdout) / 1024


def main() -> None:
    """Measure and print."""
    options = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    options.add_argument("--size", default="1920x1080")
    options.add_argument("--seconds", type=float, default=20.0)
    options.add_argument("--minutes", default="1,3,10")
    options.add_argument("--rounds", type=int, default=3)
    options.add_argument("--only", choices=["speed", "memory"])
    options.add_argument("--quick", action="store_true")
    given = options.parse_args()
    width, height = map(int, ("160x120" if given.quick else given.size).split("x"))
    with tempfile.TemporaryDirectory() as folder:
        if given.only != "memory":
            compare_speed(
                Path(folder), (width, height), 1.0 if given.quick else given.seconds, 1 if given.quick else given.rounds
            )
        if given.only != "speed":
            lengths = [1.0, 2.0] if given.quick else [60 * float(text) for text in given.minutes.split(",")]
            measure_memory(Path(folder), (width, height), lengths)


def compare_speed(folder: Path, size: tuple[int, int], seconds: float, rounds: int) -> None:
    """Print how long both take."""
    take, out = folder / "take.mp4", folder / "out.mp4"
    write_take(take, size, seconds)
    end = seconds - 1 / RATE
    for speed in (0.5, 1.5, 3.0):
        warp = Warp([0, end / speed], [0, end])
        for kind in ("nearest", "blend"):
            chosen = MediaOptions(frames=kind, quality=QUALITY, sound="drop")
            found = turns(
                {
                    "retime": lambda chosen=chosen, warp=warp: retime_media(take, out, warp, chosen, overwrite=True),
                    "filters": lambda speed=speed, kind=kind: by_filters(take, out, speed, kind),
                },
                rounds,
            )
            (clock, used), (peer_clock, peer_used) = found["retime"], found["filters"]
            print(
                f"{kind:<8} speed {speed:<4} retime {clock:6.2f} s ({used:6.2f} s of processors)   filters "
                f"{peer_clock:6.2f} s ({peer_used:6.2f} s)   ratio {clock / peer_clock:.2f} ({used / peer_used:.2f})",
                flush=True,
            )


def measure_memory(folder: Path, size: tuple[int, int], lengths: list[float]) -> None:
    """Print how much memory takes of several lengths need."""
    take, out = folder / "take.mp4", folder / "out.mp4"
    for length in lengths:
        write_take(take, size, length, noise=1)
        begun = time.perf_counter()
        peak = peak_megabytes(take, out, length - 1 / RATE)
        print(f"{length:6.0f} s of video: peak {peak:5.0f} MB, {time.perf_counter() - begun:.0f} s", flush=True)


if __name__ == "__main__":
    main()
