"""One clip of many: read, given its timing, written, and what became of it.

`retime_clip` is all that an engine calls, and whoever has an engine of their own (Ray, Spark, Airflow, `datasets.map`)
calls it too: plain data in, plain data out, nothing kept but references that were read before.
"""

from __future__ import annotations

import hashlib
import json
import os
import time
import traceback
import warnings
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import replace
from fractions import Fraction
from functools import lru_cache
from pathlib import Path
from typing import Any

from retime.batch.labels import ShownFrames, retimed_beside
from retime.batch.manifest import run_at_work
from retime.batch.task import ClipTask, Record, own_version
from retime.batch.treatment import Treatment
from retime.errors import (
    FormatError,
    InfeasibleWarpError,
    InvalidMotionError,
    MissingExtraError,
    OptionError,
    OutputExistsError,
    RetimeError,
    RetimeWarning,
    words_of,
)
from retime.evaluate.metrics.flights import flight_spans, flight_timing
from retime.evaluate.metrics.speeds import fastest_speed
from retime.files import noting_reads, noting_writes, write_bytes
from retime.formats.in_place import retime_file
from retime.formats.read_options import ReadOptions
from retime.formats.registry import animation_names, read_with, refuse_unfit, stays_in_place, write
from retime.motion.any_motion import AnyMotion
from retime.motion.channels import parse_channel
from retime.motion.gaps import GapPolicy
from retime.motion.grammar import parse_frame_range, parse_speeds, read_key, read_lock, read_span
from retime.motion.rate import parse_rate
from retime.search.guided import guided_warp
from retime.search.joined import joined_warp
from retime.search.options import BY_NAME
from retime.search.poses.references import Reference
from retime.search.result import GuidedWarp
from retime.search.variants import drawn_references, variants
from retime.search.wishes.locks import Lock
from retime.search.written import option_reader, search_arguments
from retime.svg import thinned
from retime.warp.curve import Warp
from retime.warp.retimed import retimed


class _Superseded(RetimeError):
    """The run that asked is over."""


# What an error is called in a manifest, by its class; the first that fits. "killed" and "timeout" are the engine's.
_CODES: tuple[tuple[type[BaseException], str], ...] = (
    (_Superseded, "superseded"),
    (FormatError, "format"),
    (InvalidMotionError, "motion"),
    (InfeasibleWarpError, "infeasible"),
    (OutputExistsError, "exists"),
    (MissingExtraError, "extra"),
    (OptionError, "option"),
    (RetimeError, "retime"),
    (MemoryError, "memory"),
    (OSError, "system"),
)
# Failures that come of what is around a clip, a full disk or a file in the way: it is tried again in any case.
_OF_SURROUNDINGS = ("exists", "extra", "superseded", "system")
# Knots of a warp that a record keeps, for its picture.
_KNOTS = 60
# References that a process keeps at hand.
_KEPT_REFERENCES = 16


def retime_clip(task: ClipTask, *, begun: Callable[[], None] = lambda: None) -> tuple[Record, ...]:
    """Give one clip its timing, and write it.

    Parameters
    ----------
    task : ClipTask
        The clip, and what is to become of it.
    begun : function
        Called once where there is something to do, before anything is written: not where all outputs are there already.

    Returns
    -------
    tuple of Record
        One for each output; a single one where the clip failed. No error of a clip is raised.
    """
    start = time.perf_counter()
    with noting_reads() as files:
        try:
            kept = kept_as_it_is(task)
            if kept is not None:
                return kept
            begun()
            with warnings.catch_warnings(record=True) as caught:
                warnings.simplefilter("ignore")
                warnings.simplefilter("always", RetimeWarning)
                records = _done(task, files)
            said = tuple(dict.fromkeys(_named_shortly(str(one.message), task) for one in caught))
            seconds = (time.perf_counter() - start) / len(records)
            return tuple(replace(record, seconds=seconds, warnings=said) for record in records)
        except Exception as error:
            # Whatever is wrong with one clip is reported with it, and the others go on.
            code = _code(error)
            return (failed(task, code, _words(error, code), time.perf_counter() - start, files),)


def _named_shortly(said: str, task: ClipTask) -> str:
    """Name a clip in a message by its place in the library."""
    return said.replace(task.clip, task.name)


def _code(error: Exception) -> str:
    # A reader that ran out of memory names the file.
    cause = error.__cause__ if isinstance(error.__cause__, MemoryError) else error
    return next((code for kind, code in _CODES if isinstance(cause, kind)), "unexpected")


def failed(
    task: ClipTask, code: str, message: str, seconds: float, files: Sequence[Path] = (), *, limit: float = 0.0
) -> Record:
    """Return the record of a clip that failed, whose files are as they are now."""
    files = list(files) or [Path(task.clip)]
    try:
        known = "" if code in _OF_SURROUNDINGS else _hash(task, 0, files)
    except OSError:
        # It can't be read, so nobody can tell whether it changes.
        known = ""
    return Record(
        task.name,
        "",
        "failed",
        hash=known,
        files=tuple(map(str, files)),
        seconds=seconds,
        code=code,
        message=_named_shortly(message, task),
        limit=limit,
    )


def _words(error: Exception, code: str) -> str:
    words = words_of(error)
    if code != "unexpected":
        return words
    last = traceback.extract_tb(error.__traceback__)[-1:]
    place = f" ({Path(last[0].filename).name}:{last[0].lineno})" if last else ""
    return f"{type(error).__name__}: {words}{place}"


def kept_as_it_is(task: ClipTask) -> tuple[Record, ...] | None:
    """Return what an earlier run recorded, where nothing has changed since; else None.

    A clip that failed then, and would again, has its failure.
    """
    if task.failed_before is not None and _unchanged(task, 0, task.failed_before):
        return (Record.from_json(task.failed_before),)
    found = []
    for number, place in enumerate(task.places):
        before = task.before.get(place)
        if before is None or not _unchanged(task, number, before):
            return None
        try:
            if Path(task.out, place).stat().st_size != before["bytes_out"]:
                return None
        except OSError:
            return None
        others = [*before.get("others", ()), *(places[number] for _, places in task.beside)]
        if not all(Path(task.out, other).is_file() for other in others):
            return None
        found.append(replace(Record.from_json(before), status="kept"))
    return tuple(found)


def _unchanged(task: ClipTask, number: int, before: Mapping[str, Any]) -> bool:
    """Tell whether all that a record was made of is as it was."""
    try:
        return bool(before["hash"]) and _hash(task, number, [Path(path) for path in before["files"]]) == before["hash"]
    except (OSError, ValueError, TypeError):
        # A file that is gone; a line that no run wrote.
        return False


def _hash(task: ClipTask, number: int, files: Sequence[Path]) -> str:
    """Hash all that an output depends on: bytes, treatment, and, where something is drawn, the clip's name."""
    treatment = task.treatment.to_json()
    # Of a reference and a skeleton counts what they hold now, not what they are called. Those that an earlier run has
    # read stand among its files; which of them are asked for today only the treatment tells.
    named = {name: _digests(treatment.pop(name)) for name in ("reference", "skeleton") if name in treatment}
    what = {
        "version": own_version(),
        "treatment": treatment,
        "named": named,
        "ending": Path(task.places[number]).suffix.lower(),
        "drawn": [task.name, number] if task.treatment.variants else None,
        "files": [_digest(path) for path in (*files, *(Path(path) for path, _ in task.beside))],
    }
    return hashlib.sha256(json.dumps(what, sort_keys=True).encode()).hexdigest()


def _digests(paths: str | Sequence[str]) -> list[str]:
    return [_digest(Path(path)) for path in ([paths] if isinstance(paths, str) else paths)]


def _stamps(paths: Iterable[str]) -> list[tuple[int, int]]:
    """Return what tells, without reading, that a file was not written to meanwhile."""
    return [(status.st_mtime_ns, status.st_size) for status in map(os.stat, paths)]


def _digest(path: Path) -> str:
    status = path.stat()
    return _digest_of(str(path), status.st_mtime_ns, status.st_size)


@lru_cache(maxsize=256)
def _digest_of(path: str, mtime_ns: int, size: int) -> str:
    # The cache is for references: of a clip, only this run looks twice.
    with Path(path).open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()


# What is known of an output before it is written, what writes it (given its place, and whether it may replace), and
# which frames of the clip it shows.
_Found = tuple[Record, Callable[[Path, bool], None], ShownFrames | None]


def _done(task: ClipTask, noted: list[Path]) -> list[Record]:
    """Find the timing of each output, and write it; `noted` are the files that were read so far."""
    given, path = task.treatment, Path(task.clip)
    inputs = [task.clip, *(source for source, _ in task.beside), *given.reference, *filter(None, [given.skeleton])]
    stamps = _stamps(inputs)
    found = _variants(task, path) if given.variants else [_single(task, path)]
    files = list(noted)
    for reference in given.reference:
        files += [one for one in _reference_of(Path(reference), given)[1] if one not in files]
    # What can't be said of the labels is known before the first of all these files is written.
    labels = [_labels(task, shown) for _, _, shown in found]
    if task.run and run_at_work(Path(task.out)) != task.run:
        # A worker outlives the client that was killed, and the next run may ask for something else.
        raise _Superseded(f"the run that asked for it is over: another one writes to {task.out} by now, or none")
    records = []
    for number, (record, write_to, _) in enumerate(found):
        place = Path(task.out, task.places[number])
        place.parent.mkdir(parents=True, exist_ok=True)
        with noting_writes() as written:
            for (_, places), data in zip(task.beside, labels[number], strict=True):
                write_bytes(Path(task.out, places[number]), data, overwrite=task.overwrite)
            write_to(place, task.overwrite)
        others = [one.relative_to(task.out).as_posix() for one in written if one != place]
        records.append(
            replace(
                record,
                output=task.places[number],
                hash=_hash(task, number, files),
                files=tuple(map(str, files)),
                others=tuple(others),
                bytes_out=place.stat().st_size,
                variant=number + 1 if given.variants else 0,
            )
        )
    if _stamps(inputs) != stamps:
        # Somebody wrote to them meanwhile: which bytes this was made of nobody knows, and the next run makes it again.
        records = [replace(record, hash="") for record in records]
    return records


def _labels(task: ClipTask, shown: ShownFrames | None) -> list[bytes]:
    """Take the files beside a clip through its warp."""
    if shown is None and task.beside:
        raise OptionError(
            f"{task.beside[0][0]}: several animations have several warps, and labels would go through one"
        )
    return [retimed_beside(Path(source), shown) for source, _ in task.beside if shown is not None]


def _single(task: ClipTask, path: Path) -> _Found:
    """Find the warp of a clip, or of each animation of a scene that is retimed in place."""
    given = task.treatment
    known = stays_in_place(path, Path(task.places[0]), arrays=given.array)
    if known is None or not known.curves:
        whole, clip = _read_clip(path, given)
        return _found(task, path, whole, clip, *_warp_of(clip, given))
    names = animation_names(path, animation=given.animation)
    if len(names) == 1:
        whole, clip = _read_clip(path, replace(given, animation=names[0]))
        return _found(task, path, whole, clip, *_warp_of(clip, given))
    if given.frames is not None or given.drop_first:
        raise OptionError(f"frames and drop_first are of one animation; there are {', '.join(names)}")
    warps: dict[str, Warp] = {}
    records = []
    for name in names:
        _, clip = _read_clip(path, replace(given, animation=name))
        warps[name], search = _warp_of(clip, given)
        records.append(_record(task, clip, warps[name], search))
    totals = [record.total for record in records if record.total is not None]
    together = replace(
        records[0],
        frames_in=sum(record.frames_in for record in records),
        frames_out=sum(record.frames_out for record in records),
        total=sum(totals) if totals else None,
        optimal=all(record.optimal for record in records) if totals else None,
        flights=sum(record.flights for record in records),
        flights_kept=sum(record.flights_kept for record in records),
        fastest=0.0,
    )

    def write_to(place: Path, overwrite: bool) -> None:
        retime_file(path, place, warps, animation=given.animation, rate=_rate(given.fps), overwrite=overwrite)

    return together, write_to, None


def _variants(task: ClipTask, path: Path) -> list[_Found]:
    """Draw different timings, by the clip's name."""
    given = task.treatment
    whole, clip = _read_clip(path, given)
    low, high = parse_speeds(given.speeds) if given.speeds is not None else (1 / 1.2, 1 / 0.8)
    seed = _seed(task.name, given.seed)
    if given.draw_references and not given.reference:
        raise OptionError("to draw references some must be named (reference)")
    takes = variants(
        clip,
        given.variants,
        lengths=(1 / high, 1 / low),
        seed=seed,
        draw_references=given.draw_references,
        **_arguments(clip, given),
    )
    found = [_found(task, path, whole, clip, take.warp, take) for take in takes]
    if not given.draw_references:
        return found
    drawn = [given.reference[place] for place in drawn_references(len(found), len(given.reference), seed)]
    return [
        (replace(record, reference=reference), write_to, shown)
        for (record, write_to, shown), reference in zip(found, drawn, strict=True)
    ]


def _seed(name: str, seed: int) -> int:
    """Return a seed of a clip's own: the same wherever and in whichever order clips are done."""
    return int.from_bytes(hashlib.sha256(f"{seed}/{name}".encode()).digest()[:7], "big")


def _found(
    task: ClipTask, path: Path, whole: AnyMotion, clip: AnyMotion, warp: Warp, search: GuidedWarp | None
) -> _Found:
    given = task.treatment
    warp = replace(warp, name=clip.name)
    skipped = clip.first_frame - whole.first_frame

    def write_to(place: Path, overwrite: bool) -> None:
        known = stays_in_place(path, place, arrays=given.array)
        if known is not None and known.frames:
            if given.array and clip is not whole:
                raise OptionError(f"{path.name}: frames and drop_first cut its points, and array counts other frames")
            retime_file(
                path,
                place,
                warp,
                rate=_rate(given.fps),
                average=given.average,
                frames=None if clip is whole else (clip.first_frame, clip.first_frame + clip.n_frames - 1),
                held=given.on,
                kinds=dict(map(parse_channel, given.channel)),
                repair=given.repair,
                overwrite=overwrite,
            )
            return
        if known is not None:
            moved = replace(warp, input_times=warp.input_times + skipped / float(clip.rate), keytimes=())
            retime_file(
                path,
                place,
                moved if skipped else warp,
                animation=given.animation,
                rate=_rate(given.fps),
                overwrite=overwrite,
            )
            return
        write(retimed(clip, warp, average=given.average, held=given.on), place, overwrite=overwrite)

    shown = ShownFrames(warp, clip.rate, whole.n_frames, skipped, clip.n_frames)
    return _record(task, clip, warp, search), write_to, shown


def _record(task: ClipTask, clip: AnyMotion, warp: Warp, search: GuidedWarp | None) -> Record:
    flights = flight_timing(warp if search is None else search.staircase, flight_spans(clip), rate=float(clip.rate))
    kept = thinned(len(warp.output_times), _KNOTS)
    return Record(
        task.name,
        "",
        "done",
        rate=float(clip.rate),
        frames_in=clip.n_frames,
        frames_out=warp.count_frames(clip.rate),
        total=None if search is None else search.total,
        optimal=None if search is None else search.path.optimal,
        flights=flights.n_flights,
        flights_kept=flights.n_flights_kept,
        fastest=fastest_speed(warp),
        knots=tuple(
            (round(float(warp.output_times[i]), 4), round(float(warp.input_times[i]), 4)) for i in kept.tolist()
        ),
    )


def _rate(text: str | None) -> Fraction | None:
    return None if text is None else parse_rate(text)


def _read(path: Path, given: Treatment) -> AnyMotion:
    """Read a file as a treatment says; channels and a root that it hasn't got are passed over."""
    options = ReadOptions(
        rate=_rate(given.fps),
        skeleton=None if given.skeleton is None else Path(given.skeleton),
        repair=given.repair,
        decimal_comma=given.decimal_comma,
        channels=dict(map(parse_channel, given.channel)),
        gaps=None if given.gaps is None else GapPolicy.parse(given.gaps),
        arrays=given.array,
        animation=given.animation,
    )
    clip = read_with(path, options, up=given.up, root=given.root)  # type: ignore[arg-type]
    return clip if clip.name else replace(clip, name=path.stem)


def _read_clip(path: Path, given: Treatment) -> tuple[AnyMotion, AnyMotion]:
    """Read a clip; return it whole, and the part that is used."""
    whole = _read(path, given)
    refuse_unfit(whole, dict(map(parse_channel, given.channel)), given.root)
    if given.drop_first >= whole.n_frames:
        raise OptionError(f"drop_first {given.drop_first} leaves nothing: there are {whole.n_frames} frames")
    clip = whole.frames(given.drop_first, whole.n_frames) if given.drop_first else whole
    if given.frames is not None:
        clip = clip.frames(*parse_frame_range(given.frames, clip.n_frames, clip.first_frame))
    return whole, clip


def _reference_of(path: Path, given: Treatment) -> tuple[AnyMotion, list[Path]]:
    """Read a reference, or return what was read of it for another clip; and the files that it was read from."""
    how = Treatment(
        **{name: getattr(given, name) for name in ("skeleton", "up", "root", "gaps", "channel", "array", "repair")},
        decimal_comma=given.decimal_comma,
    )
    status = path.stat()
    key = (str(path), status.st_mtime_ns, status.st_size, json.dumps(how.to_json(), sort_keys=True))
    if key not in _references:
        while len(_references) >= _KEPT_REFERENCES:
            del _references[next(iter(_references))]
        with noting_reads() as files:
            motion = _read(path, how)
        _references[key] = motion, files
    return _references[key]


_references: dict[tuple[str, int, int, str], tuple[AnyMotion, list[Path]]] = {}


def _references_of(clip: AnyMotion, given: Treatment) -> list[Reference]:
    if not given.reference and given.reference_frames is None and not given.mirror:
        return []
    motions = [_reference_of(Path(path), given)[0] for path in given.reference] or [clip]
    if given.reference_frames is not None:
        motions = [
            one.frames(*parse_frame_range(given.reference_frames, one.n_frames, one.first_frame)) for one in motions
        ]
    return [Reference(motion, mirror=given.mirror) for motion in motions]


def _arguments(clip: AnyMotion, given: Treatment) -> dict[str, Any]:
    """Return the options of a search as its functions take them."""
    read = {
        name: option_reader(BY_NAME[name])(value) if isinstance(value, str) else value
        for name, value in given.search.items()
    }
    found = search_arguments(read, clip.rate)
    if given.lock or given.keep:
        kept = [Lock(*read_span(text).at(clip.rate), 0.0, 1.0) for text in given.keep]
        found["locks"] = [*(Lock(*read_lock(text).at(clip.rate)) for text in given.lock), *kept]
    references = _references_of(clip, given)
    if references:
        found["reference"] = references
    return found


def _warp_of(clip: AnyMotion, given: Treatment) -> tuple[Warp, GuidedWarp | None]:
    """Find the warp by the treatment's method."""
    keys = [read_key(text).at(clip.rate) for text in given.key]
    if given.method == "guided":
        search = guided_warp(clip, keys=keys, **_arguments(clip, given))
        return search.warp, search
    useless = [name for name in given.search if name != "length"]
    if useless or given.reference or given.lock or given.keep:
        raise OptionError(
            f"method {given.method} has no search: {', '.join(useless) or 'references and locks'} would have no effect"
        )
    return joined_warp(clip, given.search.get("length"), keys, given.method), None
