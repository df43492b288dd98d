"""Streams of the output on their way: each is made ahead by its own thread, and encoded in its turn."""

from __future__ import annotations

import queue
import threading
from collections.abc import Generator, Iterable, Iterator
from typing import Any

from retime.media.job import Job, Report

# Frames that wait for the encoder.
_AHEAD = 6


class Ahead:
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


class Track:
    """Frames or samples on their way into one stream of the output.

    Attributes
    ----------
    time : float
        Seconds of the output that were encoded.
    """

    def __init__(self, stream: Any, steps: Iterable[Any]) -> None:
        self.stream, self.steps, self.time, self.ended = stream, iter(steps), 0.0, False


def run_tracks(tracks: list[Track], output: Any, report: Report) -> None:
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


def say_other_codec(job: Job, report: Report, source: Any, made: Any) -> None:
    """Say that a stream is encoded otherwise than the input's, where the output is a file of the same kind."""
    if source is None or job.options.codec is not None or job.path.suffix.lower() != job.place.suffix.lower():
        return
    before, after = (one.codec_context.codec.canonical_name for one in (source, made))
    if before != after:
        kind = {"video": "video", "audio": "sound"}[source.type]
        report.warn(f"{job.path}: its {kind} is {before}, which can't be written so; the output's is {after}")
