"""What a run will do, how long it will take, and how large its outputs will be: a few clips are done elsewhere."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace
from pathlib import Path
from tempfile import TemporaryDirectory

from retime.batch.child import ChildRunner
from retime.batch.clip import kept_as_it_is
from retime.batch.engine import Bounds
from retime.batch.task import ClipTask, places_with

# Clips that are tried.
_TRIED = 5


@dataclass(frozen=True)
class Estimate:
    """What a run will come to.

    Attributes
    ----------
    n_kept : int
        Clips that an earlier run has done, and nothing has changed since.
    n_failed_before : int
        Clips that failed, and are not tried again, for nothing has changed.
    n_left : int
        Clips that are to be done.
    in_the_way : tuple of str
        Files that no run wrote where outputs are to be; their clips fail.
    seconds, n_bytes : float, optional
        Of one process, for what is to be done; of its outputs. None where nothing that was tried could be done.
    n_tried, n_failed : int
        Clips that were tried, and how many of them failed.
    """

    n_kept: int
    n_failed_before: int
    n_left: int
    in_the_way: tuple[str, ...]
    seconds: float | None
    n_bytes: float | None
    n_tried: int
    n_failed: int


def estimate(tasks: Sequence[ClipTask], sizes: Mapping[str, int], bounds: Bounds) -> Estimate:
    """Find what is to be done, and do some of it, from the smallest to the largest, into a folder that goes again.

    Parameters
    ----------
    tasks : sequence of ClipTask
        What is asked for.
    sizes : mapping of str to int
        Bytes of the clips, by their names.
    bounds : Bounds
        What one clip may take: those that are tried are no tamer than the others.
    """
    # What was done is known by its bytes, which are read here and now.
    with ThreadPoolExecutor(os.cpu_count()) as threads:
        kept = list(threads.map(kept_as_it_is, tasks))
    left = [task for task, records in zip(tasks, kept, strict=True) if records is None]
    failed_before = sum(records is not None and records[0].status == "failed" for records in kept)
    in_the_way = tuple(
        place
        for task in left
        if not task.overwrite
        for number in range(len(task.places))
        for place in places_with(task, number)
        if os.path.lexists(Path(task.out, place))
    )
    ordered = sorted(left, key=lambda task: sizes[task.name])
    n = min(_TRIED, len(ordered))
    tried = [ordered[round(i * (len(ordered) - 1) / max(1, n - 1))] for i in range(n)]
    seconds = n_bytes = read = 0.0
    n_failed = 0
    with TemporaryDirectory() as folder:
        runner = ChildRunner(Path(folder), most_memory=bounds.memory, most_seconds=bounds.seconds)
        try:
            for task in tried:
                records = runner.run(replace(task, out=folder, before={}, failed_before=None, overwrite=True))
                if records[0].status == "failed":
                    n_failed += 1
                    continue
                seconds += sum(record.seconds for record in records)
                n_bytes += sum(
                    Path(folder, place).stat().st_size
                    for record in records
                    for place in (record.output, *record.others)
                )
                read += sizes[task.name]
        finally:
            runner.close()
    share = sum(sizes[task.name] for task in left) / read if read else None if left else 0.0
    return Estimate(
        len(tasks) - len(left) - failed_before,
        failed_before,
        len(left),
        in_the_way,
        None if share is None else seconds * share,
        None if share is None else n_bytes * share,
        n,
        n_failed,
    )
