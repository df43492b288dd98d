"""How long a run will take, and how large its outputs will be: a few clips are done elsewhere, and count for all."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from tempfile import TemporaryDirectory

from retime.batch.clip import retime_clip
from retime.batch.task import ClipTask

# Clips that are tried.
_TRIED = 5


@dataclass(frozen=True)
class Estimate:
    """What a run will come to.

    Attributes
    ----------
    seconds : float
        Of one process; that many share them.
    n_bytes : float
        Of all outputs.
    n_tried, n_failed : int
        Clips that were tried, and how many of them failed.
    """

    seconds: float
    n_bytes: float
    n_tried: int
    n_failed: int


def estimate(tasks: Sequence[ClipTask], sizes: dict[str, int]) -> Estimate:
    """Do some clips, from the smallest to the largest, into a folder that is removed again.

    Parameters
    ----------
    tasks : sequence of ClipTask
        What is to be done.
    sizes : dict of str to int
        Bytes of the clips, by their names.
    """
    ordered = sorted(tasks, key=lambda task: sizes[task.name])
    n = min(_TRIED, len(ordered))
    tried = [ordered[round(i * (len(ordered) - 1) / max(1, n - 1))] for i in range(n)]
    seconds = n_bytes = read = 0.0
    n_failed = 0
    with TemporaryDirectory() as folder:
        for task in tried:
            records = retime_clip(replace(task, out=folder, before={}, failed_before=None, overwrite=True))
            if records[0].status == "failed":
                n_failed += 1
                continue
            seconds += sum(record.seconds for record in records)
            n_bytes += sum((Path(folder) / record.output).stat().st_size for record in records)
            read += sizes[task.name]
    share = sum(sizes[task.name] for task in tasks) / read if read else 0.0
    return Estimate(seconds * share, n_bytes * share, n, n_failed)
