"""A whole library: what is to be done, the doing of it, and what is left at the end."""

from __future__ import annotations

import os
import time
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from os import PathLike
from pathlib import Path, PurePosixPath
from typing import TYPE_CHECKING, Any

from retime.batch.engine import CHUNK, Bounds, connect, run_on, run_serially
from retime.batch.manifest import Known, Manifest, failure_key
from retime.batch.recipe import Recipe
from retime.batch.task import ClipTask, Record
from retime.batch.treatment import Treatment, settings
from retime.batch.tree import FRAME_CUTS, FoundClip, Tree, find_clips, output_names, remapped_cuts
from retime.brief import brief_repr
from retime.errors import OptionError
from retime.file_names import name_key
from retime.files import remove_left_overs, write_bytes
from retime.formats.compressed import plain_path

if TYPE_CHECKING:
    from distributed import Client


@dataclass(frozen=True)
class Plan:
    """What a run will do.

    Attributes
    ----------
    tasks : tuple of ClipTask
        A task a clip.
    tree : Tree
        Where the clips are.
    out : Path
        Where their outputs go.
    sizes : dict of str to int
        Bytes of each clip, by its name.
    n_left_out : int
        Clips that the recipe leaves out.
    """

    tasks: tuple[ClipTask, ...]
    tree: Tree
    out: Path
    sizes: Mapping[str, int] = field(default_factory=dict)
    n_left_out: int = 0

    __repr__ = brief_repr


@dataclass(frozen=True)
class BatchResult:
    """What became of a library.

    Attributes
    ----------
    records : tuple of Record
        One for each output or failed clip, by name.
    n_clips : int
        Clips that there were.
    seconds : float
        That the run took.
    """

    records: tuple[Record, ...]
    n_clips: int
    seconds: float

    __repr__ = brief_repr

    @property
    def failures(self) -> tuple[Record, ...]:
        """The clips that failed."""
        return tuple(record for record in self.records if record.status == "failed")

    @property
    def counts(self) -> dict[str, int]:
        """How many outputs were done and kept, and how many clips failed."""
        found = Counter(record.status for record in self.records)
        return {status: found[status] for status in ("done", "kept", "failed")}


def plan(
    folder: Path,
    out: Path,
    recipe: Recipe,
    known: Known,
    *,
    restart: bool = False,
    retry: bool = False,
    force: bool = False,
) -> Plan:
    """Say what is to be done for each clip of a folder.

    Parameters
    ----------
    folder, out : Path
        Where the clips are, and where their outputs go.
    recipe : Recipe
        What each gets.
    known : Known
        What earlier runs left.
    restart : bool
        Do everything again.
    retry : bool
        Try again what failed, though nothing has changed.
    force : bool
        Replace files in `out` that no run wrote.

    Raises
    ------
    OptionError
        One folder lies in the other, the recipe speaks of clips that are not there, or two clips have one output.
    """
    real_in, real_out = Path(os.path.realpath(folder)), Path(os.path.realpath(out))
    if real_in == real_out or real_in in real_out.parents or real_out in real_in.parents:
        raise OptionError(
            f"{out} and {folder} lie in one another: outputs would be taken for clips; choose another place"
        )
    patterns = {name for one in (recipe.base, *_treatments(recipe)) for name in one.beside}
    tree = find_clips(folder, beside=tuple(sorted(patterns)))
    recipe.refuse_unknown([clip.name for clip in tree.clips])
    treatments = {clip.name: recipe.treatment_of(clip.name) for clip in tree.clips}
    names = {
        ending: output_names(
            replace(tree, clips=tuple(c for c in tree.clips if _ending(treatments[c.name]) == ending)), ending
        )
        for ending in {_ending(one) for one in treatments.values()}
    }
    tasks, taken = [], dict[str, str]()
    for clip in tree.clips:
        treatment = treatments[clip.name]
        if treatment is None:
            continue
        output = names[treatment.format][clip.name]
        if name_key(output) in taken:
            raise OptionError(f"{taken[name_key(output)]} and {clip.name} would both be written as {output}")
        taken[name_key(output)] = clip.name
        tasks.append(_task(clip, output, treatment, out, known, restart=restart, retry=retry, force=force))
    sizes = {clip.name: clip.size for clip in tree.clips}
    return Plan(tuple(tasks), tree, out, sizes, len(tree.clips) - len(tasks))


def _treatments(recipe: Recipe) -> Iterator[Treatment]:
    for given in (*(rule.settings for rule in recipe.rules), *recipe.rows.values()):
        if "beside" in given:
            yield Treatment(beside=given["beside"])


def _ending(treatment: Treatment | None) -> str | None:
    return None if treatment is None else treatment.format


def _task(
    clip: FoundClip,
    output: str,
    treatment: Treatment,
    out: Path,
    known: Known,
    *,
    restart: bool,
    retry: bool,
    force: bool,
) -> ClipTask:
    if clip.cut is not None and treatment.frames is None:
        treatment = replace(treatment, frames=f"{clip.cut[0]}:{clip.cut[1]}")
    places = tuple(_numbered(output, treatment.variants))
    stem = plain_path(PurePosixPath(clip.name)).stem
    beside = []
    for pattern in treatment.beside:
        source = clip.path.with_name(pattern.replace("{stem}", stem))
        if source.is_file():
            # Named by the clip that it then belongs to: of a variant, that.
            names = (place.with_name(pattern.replace("{stem}", place.stem)) for place in map(PurePosixPath, places))
            beside.append((str(source), tuple(map(str, names))))
    return ClipTask(
        str(clip.path),
        clip.name,
        str(out),
        places,
        treatment,
        tuple(beside),
        {} if restart else {place: known.records[place] for place in places if place in known.records},
        None if restart or retry else known.records.get(failure_key(clip.name)),
        force or known.may_write(out, places),
    )


def _numbered(name: str, variants: int) -> list[str]:
    """Return the names of variants: a number of equal width before the ending."""
    if not variants:
        return [name]
    path, width = PurePosixPath(name), len(str(variants))
    return [str(path.with_name(f"{path.stem}_{i:0{width}d}{path.suffix}")) for i in range(1, variants + 1)]


def run(
    folder: str | PathLike[str],
    out: str | PathLike[str],
    recipe: Recipe | Mapping[str, Any] | None = None,
    *,
    client: Client | None = None,
    workers: int | None = None,
    chunk: int = CHUNK,
    most_memory: int | None = None,
    most_seconds: float = 600.0,
    restart: bool = False,
    retry: bool = False,
    force: bool = False,
    progress: Callable[[ClipTask, tuple[Record, ...]], None] | None = None,
) -> BatchResult:
    """Give every clip below a folder new timing; broken ones are reported, and the others go on.

    Outputs stand below `out` as the clips stand below `folder`. What an earlier run has done of the same bytes by the
    same settings is not done again.

    Parameters
    ----------
    folder, out : path-like
        Where the clips are, and where their outputs go.
    recipe : Recipe or mapping, optional
        What each gets; a mapping of settings (``{"length": "80%"}``) holds for all.
    client : distributed.Client, optional
        The Dask cluster to use; left out, one is made on this machine for the time of the run.
    workers : int, optional
        Processes of the cluster on this machine; left out, one a processor. 0: one after the other, without Dask.
    chunk : int
        Clips of a task of Dask's.
    most_memory : int, optional
        Bytes that a process at work may take.
    most_seconds : float
        Seconds that a clip may take.
    restart : bool
        Do everything again.
    retry : bool
        Try again what failed, though nothing has changed.
    force : bool
        Replace files in `out` that no run wrote.
    progress : function of (ClipTask, tuple of Record), optional
        Called for each clip as it is done.

    Returns
    -------
    BatchResult

    Raises
    ------
    OptionError
        The recipe or the folders can't be.
    MissingExtraError
        There is no Dask; ``workers=0`` does without.
    """
    start = time.perf_counter()
    recipe = recipe if isinstance(recipe, Recipe) else Recipe(Treatment().with_(settings(recipe or {})))
    folder, out = Path(folder), Path(out)
    bounds = Bounds(most_memory, most_seconds)
    out.mkdir(parents=True, exist_ok=True)
    manifest = Manifest(out)
    try:
        planned = plan(folder, out, recipe, manifest.known, restart=restart, retry=retry, force=force)
        records = list(
            do_plan(planned, manifest, bounds, client=client, workers=workers, chunk=chunk, progress=progress)
        )
    finally:
        manifest.close()
    return BatchResult(tuple(records), len(planned.tasks), time.perf_counter() - start)


def do_plan(
    planned: Plan,
    manifest: Manifest,
    bounds: Bounds,
    *,
    client: Client | None = None,
    workers: int | None = None,
    chunk: int = CHUNK,
    progress: Callable[[ClipTask, tuple[Record, ...]], None] | None = None,
) -> list[Record]:
    """Do what was planned; return all records, by the clips' order."""
    tasks = {task.name: task for task in planned.tasks}
    found: dict[str, tuple[Record, ...]] = {}
    own = None
    try:
        if client is None and workers != 0 and tasks:
            own = connect(None, workers=min(workers or os.cpu_count() or 1, len(tasks)))
        if (used := client or own) is not None:
            answers = run_on(used, list(tasks.values()), planned.out, bounds, manifest.refreshed, chunk=chunk)
        else:
            answers = run_serially(tasks.values(), planned.out, bounds)
        for records in answers:
            manifest.add(records)
            found[records[0].name] = records
            if progress is not None:
                progress(tasks[records[0].name], records)
    finally:
        if own is not None:
            cluster = own.cluster
            own.close()
            cluster.close()
    ordered = [record for name in tasks for record in found[name]]
    for folder in {Path(task.out, place).parent for task in tasks.values() for place in task.places}:
        if folder.is_dir():
            remove_left_overs(folder)
    _write_cuts(planned, ordered)
    manifest.finish(ordered)
    return ordered


def _write_cuts(planned: Plan, records: Iterable[Record]) -> None:
    """Write the tree's table of cuts for the outputs, where it has one."""
    if not planned.tree.cuts:
        return
    lengths = {PurePosixPath(record.name).stem: record.frames_out for record in records if record.status != "failed"}
    write_bytes(planned.out / FRAME_CUTS, remapped_cuts(planned.tree.cuts, lengths).encode(), overwrite=True)
