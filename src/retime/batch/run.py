"""A whole library: what is to be done, the doing of it, and what is left at the end."""

from __future__ import annotations

import os
import time
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from os import PathLike
from pathlib import Path, PurePosixPath
from typing import TYPE_CHECKING, Any

from retime.batch.engine import CHUNK, Bounds, connect, disconnect, run_on, run_serially, share_of_memory
from retime.batch.manifest import MANIFEST, STATE, TABLE, Known, Manifest, failure_key
from retime.batch.recipe import Recipe
from retime.batch.task import ClipTask, Record, places_with
from retime.batch.treatment import Treatment, settings
from retime.batch.tree import FoundClip, Tree, find_clips, output_names, remapped_cuts
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


@dataclass(frozen=True)
class Survey:
    """What there is, and what each clip gets, whatever earlier runs have done.

    Attributes
    ----------
    tree : Tree
        Where the clips are.
    out : Path
        Where their outputs go.
    tasks : tuple of ClipTask
        A task a clip that is not left out.
    """

    tree: Tree
    out: Path
    tasks: tuple[ClipTask, ...]

    __repr__ = brief_repr


def survey(clips: Path | Sequence[Path], out: Path, recipe: Recipe) -> Survey:
    """Look at clips, and say what each of them gets. Nothing is written.

    Parameters
    ----------
    clips : Path or sequence of Path
        The folder that they are in; or they themselves, which are named by their places below the folder they share.
    out : Path
        Where their outputs go.
    recipe : Recipe
        What each gets.

    Raises
    ------
    OptionError
        One folder lies in the other, the recipe speaks of clips or references that are not there, or two files would
        be written under one name.
    """
    # A worker may stand elsewhere.
    out = out.absolute()
    if isinstance(clips, Path):
        folder, only = clips.absolute(), None
        real_in, real_out = Path(os.path.realpath(folder)), Path(os.path.realpath(out))
        if real_in == real_out or real_in in real_out.parents or real_out in real_in.parents:
            raise OptionError(
                f"{out} and {folder} lie in one another: outputs would be taken for clips; choose another place"
            )
    else:
        folder, only = _listed(clips)
    patterns = {name for one in (recipe.base, *_treatments(recipe)) for name in one.beside}
    tree = find_clips(folder, beside=tuple(sorted(patterns)), only=only)
    recipe.refuse_unknown([clip.name for clip in tree.clips])
    treatments = {clip.name: _with_places(recipe.treatment_of(clip.name)) for clip in tree.clips}
    _refuse_missing(treatments.values())
    names = {
        ending: output_names(
            replace(tree, clips=tuple(c for c in tree.clips if _ending(treatments[c.name]) == ending)), ending
        )
        for ending in {_ending(one) for one in treatments.values()}
    }
    tasks = [
        _task(clip, names[treatment.format][clip.name], treatment, out)
        for clip in tree.clips
        if (treatment := treatments[clip.name]) is not None
    ]
    _refuse_shared_places(tasks, tree)
    if only is not None:
        _refuse_inputs(tasks)
    return Survey(tree, out, tuple(tasks))


def _listed(clips: Sequence[Path]) -> tuple[Path, list[Path]]:
    """Return the folder that clips share, and where they are."""
    # Points between folders are no names; links stay what they are called.
    only = [Path(os.path.normpath(one.absolute())) for one in clips]
    if not only:
        raise OptionError("no clip was named")
    try:
        return Path(os.path.commonpath([one.parent for one in only])), only
    except ValueError:
        # Windows, where a drive shares nothing with another.
        raise OptionError("the clips lie on several drives: do those of each by themselves") from None


def _refuse_inputs(tasks: Iterable[ClipTask]) -> None:
    """Raise OptionError where an output would replace a clip, or what lies beside it."""
    tasks = list(tasks)
    read = {os.path.realpath(one) for task in tasks for one in (task.clip, *(source for source, _ in task.beside))}
    for task in tasks:
        for number in range(len(task.places)):
            for place in places_with(task, number):
                if os.path.realpath(Path(task.out, place)) in read:
                    raise OptionError(f"{place} of {task.out} is read here, and never replaced; choose another place")


def plan(
    surveyed: Survey,
    known: Known,
    *,
    bounds: Bounds | None = None,
    restart: bool = False,
    retry: bool = False,
    force: bool = False,
) -> Plan:
    """Say what is to be done, after what earlier runs have left.

    Parameters
    ----------
    surveyed : Survey
        What each clip gets.
    known : Known
        What earlier runs left.
    bounds : Bounds, optional
        What a clip may take now: one that met a narrower bound is tried again.
    restart : bool
        Do everything again.
    retry : bool
        Try again what failed, though nothing has changed.
    force : bool
        Replace files in `out` that no run wrote.
    """
    bounds = bounds or Bounds()
    tasks = []
    for task in surveyed.tasks:
        before = {} if restart else {place: known.records[place] for place in task.places if place in known.records}
        failed = None if restart or retry else known.records.get(failure_key(task.name))
        if failed is not None and bounds.wider_than(failed):
            failed = None
        tasks.append(replace(task, before=before, failed_before=failed, overwrite=force or known.may_replace(task)))
    sizes = {clip.name: clip.size for clip in surveyed.tree.clips}
    return Plan(tuple(tasks), surveyed.tree, surveyed.out, sizes, len(surveyed.tree.clips) - len(tasks))


def _treatments(recipe: Recipe) -> Iterator[Treatment]:
    for given in (*(rule.settings for rule in recipe.rules), *recipe.rows.values()):
        if "beside" in given:
            yield Treatment(beside=given["beside"])


def _ending(treatment: Treatment | None) -> str | None:
    return None if treatment is None else treatment.format


def _with_places(treatment: Treatment | None) -> Treatment | None:
    """Say of references and a skeleton where they are, for a worker that stands elsewhere."""
    if treatment is None or not (treatment.reference or treatment.skeleton):
        return treatment
    skeleton = treatment.skeleton and str(Path(treatment.skeleton).absolute())
    return replace(
        treatment, reference=tuple(str(Path(one).absolute()) for one in treatment.reference), skeleton=skeleton
    )


def _refuse_missing(treatments: Iterable[Treatment | None]) -> None:
    """Raise OptionError where a file that clips need is not there: each of them would fail of it."""
    given = [one for one in treatments if one is not None]
    named = {path: "reference" for one in given for path in one.reference}
    named |= {one.skeleton: "skeleton" for one in given if one.skeleton is not None}
    for path, name in named.items():
        if not Path(path).is_file():
            raise OptionError(f"the {name} {path} is not there")


def _refuse_shared_places(tasks: Iterable[ClipTask], tree: Tree) -> None:
    """Raise OptionError where two files would be written under one name: one of them would be lost."""
    taken = {name_key(name): "the run itself" for name in (MANIFEST, TABLE, STATE, *(cuts.name for cuts in tree.cuts))}
    for task in tasks:
        for number in range(len(task.places)):
            for place, source in zip(
                places_with(task, number),
                (task.name, *(f"what lies beside {task.name}" for _ in task.beside)),
                strict=True,
            ):
                other = taken.setdefault(name_key(place), source)
                if other is not source:
                    raise OptionError(
                        f"{other} and {source} would both be written as {place}: leave one of them out (a rule of a "
                        "recipe with skip = true, or beside = []), or rename it"
                    )


def _task(clip: FoundClip, output: str, treatment: Treatment, out: Path) -> ClipTask:
    if clip.cut is not None and treatment.frames is None:
        treatment = replace(treatment, frames=f"{clip.cut[0]}:{clip.cut[1]}")
    places = tuple(_numbered(output, treatment.variants))
    stem = plain_path(PurePosixPath(clip.name)).stem
    beside = []
    for pattern in dict.fromkeys(treatment.beside):
        source = clip.path.with_name(pattern.replace("{stem}", stem))
        if source.is_file():
            # Named by the clip that it then belongs to: of a variant, that.
            names = (place.with_name(pattern.replace("{stem}", place.stem)) for place in map(PurePosixPath, places))
            beside.append((str(source), tuple(map(str, names))))
    return ClipTask(str(clip.path), clip.name, str(out), places, treatment, tuple(beside))


def _numbered(name: str, variants: int) -> list[str]:
    """Return the names of variants: a number of equal width before the ending."""
    if not variants:
        return [name]
    path, width = PurePosixPath(name), len(str(variants))
    return [str(path.with_name(f"{path.stem}_{i:0{width}d}{path.suffix}")) for i in range(1, variants + 1)]


def run(
    clips: str | PathLike[str] | Sequence[str | PathLike[str]],
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
    """Give many clips new timing; broken ones are reported, and the others go on.

    Outputs stand below `out` as the clips stand below their folder. What an earlier run has done of the same bytes
    by the same settings is not done again.

    Parameters
    ----------
    clips : path-like, or sequence of path-like
        The folder below which all clips are meant; or the clips themselves, whose folder is the one that they share.
    out : path-like
        Where their outputs go.
    recipe : Recipe or mapping, optional
        What each gets; a mapping of settings (``{"length": "80%"}``) holds for all.
    client : distributed.Client, optional
        The Dask cluster to use; left out, one is made on this machine for the time of the run.
    workers : int, optional
        Processes of the cluster on this machine; left out, one a processor. 0: one after the other, without Dask.
    chunk : int
        Clips of a task of Dask's.
    most_memory : int, optional
        Bytes that a process at work may take; left out, an equal share of this machine's, or of what the client's
        workers may take.
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
    if most_memory is None and client is None:
        most_memory = share_of_memory(workers)
    bounds = Bounds(most_memory, most_seconds)
    listed = Path(clips) if isinstance(clips, str | PathLike) else [Path(one) for one in clips]
    surveyed = survey(listed, Path(out), recipe)
    surveyed.out.mkdir(parents=True, exist_ok=True)
    manifest = Manifest(surveyed.out)
    try:
        planned = plan(surveyed, manifest.known, bounds=bounds, restart=restart, retry=retry, force=force)
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
    tasks = {task.name: replace(task, run=manifest.run) for task in planned.tasks}
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
            disconnect(own)
    ordered = [record for name in tasks for record in found[name]]
    for folder in {Path(task.out, place).parent for task in tasks.values() for place in task.places}:
        if folder.is_dir():
            remove_left_overs(folder)
    _write_cuts(planned, ordered)
    manifest.finish(ordered)
    return ordered


def _write_cuts(planned: Plan, records: Iterable[Record]) -> None:
    """Write the tree's tables of cuts for the outputs, where it has such."""
    found: dict[str, list[tuple[int, int]]] = {}
    for record in records:
        found.setdefault(record.name, [])
        if record.status != "failed":
            found[record.name].append((record.variant, record.frames_out))
    for cuts in planned.tree.cuts:
        outputs = {
            plain_path(PurePosixPath(name)).stem: tuple(one)
            for name, one in found.items()
            if PurePosixPath(cuts.name).parent in PurePosixPath(name).parents
        }
        place = planned.out / cuts.name
        if outputs and place.parent.is_dir():
            write_bytes(place, remapped_cuts(cuts.rows, outputs).encode(), overwrite=True)
