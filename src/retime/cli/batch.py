"""`retime batch`: every clip below a folder gets new timing."""

from __future__ import annotations

import os
import re
import sys
import time
from collections import Counter
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from retime.cli.clip_options import PATH
from retime.cli.exit_codes import EXIT_NONE_DONE, EXIT_SOME_FAILED
from retime.cli.help_sections import Option, SectionedCommand
from retime.cli.search_options import search_options
from retime.cli.terminal import live_line, report_error, say, say_json, say_table
from retime.errors import OptionError

if TYPE_CHECKING:
    from retime.batch.engine import Bounds
    from retime.batch.run import Plan
    from retime.batch.task import ClipTask, Record

_EXAMPLES = (
    "\b\nExamples\n"
    "  retime batch clips --out shorter --length 80%\n"
    "  retime batch clips --out shorter --recipe recipe.toml --dry-run\n"
    "  retime batch clips --out varied --variants 8 --speed 0.8..1.25 --seed 1 --beside {stem}_labels.csv\n"
)

_SIZE = re.compile(r"([0-9]{1,15}(?:\.[0-9]{1,15})?)\s*(k|m|g|t)?i?b?", re.IGNORECASE)
_UNITS = {None: 1, "k": 1 << 10, "m": 1 << 20, "g": 1 << 30, "t": 1 << 40}


def _size(text: str) -> int:
    match = _SIZE.fullmatch(text.strip())
    if match is None:
        raise OptionError(f"expected a size of memory such as 2GB, found {text!r}")
    return int(float(match[1]) * _UNITS[match[2].lower() if match[2] else None])


# Settings of `retime.batch.treatment.Treatment` on the command line: name, flag, what stands for its value, its
# section, and help. What has no value is a flag; `*` may be given several times.
_SETTINGS = (
    ("key", "--key*", "IN=OUT[@SPEED]", "Keytimes", "As of retime warp."),
    ("lock", "--lock*", "A..B[=SPEED]", "Control", "As of retime warp."),
    ("keep", "--keep*", "A..B", "Control", "As of retime warp."),
    ("method", "--method", "NAME", "Method", "guided, linear or spline, as of retime warp."),
    ("reference", "--reference*", "CLIP", "Reference", "Imitate the timing of this clip; repeat for more."),
    ("reference_frames", "--reference-frames", "A:B", "Reference", "Frames of the reference that count."),
    ("mirror", "--mirror", "", "Reference", "Imitate the reference's mirror image too."),
    ("frames", "--frames", "A:B", "Input", "Use only these frames of each clip, as its file numbers them."),
    ("drop_first", "--drop-first", "N", "Input", "Leave out the first N frames of each clip."),
    ("fps", "--fps", "R", "Input", "Frames a second, in place of what files declare."),
    ("skeleton", "--skeleton", "ASF", "Input", "The skeleton of AMCs, where it can't be found beside them."),
    ("repair", "--repair", "", "Input", "Keep the undamaged part of damaged files."),
    ("decimal_comma", "--decimal-comma", "", "Input", "Numbers are written with a comma (0,5)."),
    ("up", "--up", "AXIS", "Input", "Which axis of the files is vertical: y, or z."),
    ("root", "--root", "NAME", "Input", "The joint that carries the body."),
    ("channel", "--channel*", "NAME=KIND", "Input", "What a channel of tables holds, as of retime warp."),
    ("gaps", "--gaps", "HOW", "Input", "Values that tables lack: bridge, bridge:0.2 or keep."),
    ("array", "--array*", "NAME", "Input", "Which array of an NPZ is meant."),
    ("animation", "--animation", "NAME", "Input", "Which animation of scenes; left out, all."),
    ("average", "--no-average", "", "Output", "Show single moments of the input where the motion is sped up."),
    ("on", "--on", "N", "Output", "Hold each pose for N frames."),
    ("format", "--format", "ENDING", "Output", "Write files of this ending, such as .bvh; left out, each clip's own."),
    (
        "beside",
        "--beside*",
        "NAME",
        "Output",
        "A file beside a clip, such as {stem}_labels.csv, that goes through the same warp: ranges, moments, or a row a "
        "frame (.csv, .json).",
    ),
    (
        "variants",
        "--variants",
        "N",
        "Variants",
        "Find N different natural timings of each clip, drawn by its name: OUT has walk_1.bvh, walk_2.bvh ... With "
        "them --speed LO..HI says between which mean speeds their lengths are drawn.",
    ),
    ("seed", "--seed", "S", "Variants", "Another seed, other variants."),
    (
        "draw_references",
        "--draw-references",
        "",
        "Variants",
        "Each variant imitates one of the references, drawn, in place of all of them.",
    ),
)
_TYPES = {"drop_first": int, "on": int, "variants": int, "seed": int}


def _setting_options(function: Any) -> Any:
    for name, flag, metavar, section, help_text in reversed(_SETTINGS):
        several, flag = flag.endswith("*"), flag.rstrip("*")
        more: dict[str, Any] = {"cls": Option, "section": section, "help": help_text, "default": None}
        if not metavar:
            more |= {"is_flag": True, "flag_value": name != "average"}
        else:
            more |= {"metavar": metavar, "multiple": several, "type": _TYPES.get(name, str)}
        if several:
            del more["default"]
        function = click.option(flag, name, **more)(function)
    return function


@click.command(
    "batch",
    cls=SectionedCommand,
    short_help="Give every clip below a folder new timing; broken ones are reported.",
    epilog=_EXAMPLES,
)
@click.argument("folder", type=PATH, metavar="IN_DIR")
@click.option("--out", cls=Option, metavar="OUT_DIR", type=PATH, required=True, help="Where the same tree is written.")
@click.option(
    "--recipe",
    cls=Option,
    section="Recipe",
    metavar="FILE",
    type=PATH,
    help="Settings by pattern of names (.toml), or by clip (.csv with a column clip); they go before options.",
)
@search_options(usual={"length": "as the keytimes say; without any, as the input"}, as_text=True)
@_setting_options
@click.option(
    "--workers",
    cls=Option,
    section="Run",
    metavar="N",
    type=click.IntRange(min=0),
    default_text="one a processor",
    help="Processes on this machine; 0 does one clip after the other and needs no Dask.",
)
@click.option(
    "--scheduler",
    cls=Option,
    section="Run",
    metavar="ADDRESS",
    help="Use the Dask cluster whose scheduler is at tcp://HOST:PORT; its workers see the same folders.",
)
@click.option(
    "--chunk",
    cls=Option,
    section="Run",
    metavar="N",
    type=click.IntRange(min=1),
    default=8,
    default_text="8",
    help="Clips of one task of Dask's.",
)
@click.option(
    "--memory",
    cls=Option,
    section="Run",
    metavar="SIZE",
    default_text="an equal share",
    help="Memory that a process at work may take, such as 2GB; a clip that wants more fails.",
)
@click.option(
    "--time-limit",
    cls=Option,
    section="Run",
    metavar="S",
    type=click.FloatRange(min=0, min_open=True),
    default=600.0,
    default_text="600",
    help="Seconds that a clip may take.",
)
@click.option(
    "--resume/--restart",
    cls=Option,
    section="Run",
    default=True,
    default_text="--resume",
    help="Keep what an earlier run made of the same bytes by the same settings, or do everything again.",
)
@click.option("--retry", cls=Option, section="Run", is_flag=True, help="Try again what failed, though nothing changed.")
@click.option(
    "--dry-run",
    cls=Option,
    section="Run",
    is_flag=True,
    help="Say what would be done, how long it takes and how large it gets; a few clips are tried, nothing is written.",
)
@click.option("--report", cls=Option, metavar="PAGE.html", type=PATH, help="Write a page about the run.")
@click.option("--force", cls=Option, is_flag=True, help="Replace files in OUT_DIR that no run has written.")
@click.option("--json", "as_json", cls=Option, is_flag=True, help="Print one JSON object instead of the summary.")
@click.option("-q", "--quiet", cls=Option, is_flag=True, help="Print nothing but warnings and errors.")
def command(
    *,
    folder: Path,
    out: Path,
    recipe: Path | None,
    search: dict[str, Any],
    workers: int | None,
    scheduler: str | None,
    chunk: int,
    memory: str | None,
    time_limit: float,
    resume: bool,
    retry: bool,
    dry_run: bool,
    report: Path | None,
    force: bool,
    as_json: bool,
    quiet: bool,
    **given: Any,
) -> None:
    """Give every clip below IN_DIR the same treatment, or that of a recipe, and write the same tree below OUT_DIR.

    A clip that fails, never ends or ends its process is reported, and the others go on. The same command goes on where
    an earlier run ended. OUT_DIR/manifest.jsonl says what became of each; the exit code is 0 where all is well, 4 where
    some clips failed, 5 where all did.
    """
    from retime.batch.engine import Bounds, connect, count_threads, disconnect, share_of_memory
    from retime.batch.manifest import Known, Manifest
    from retime.batch.recipe import Recipe, read_recipe
    from retime.batch.report import refuse_bad_place, report_html
    from retime.batch.run import do_plan, plan, survey
    from retime.batch.treatment import Treatment, settings
    from retime.files import write_bytes

    begun = time.perf_counter()
    if scheduler is not None and workers is not None:
        raise OptionError("--workers is of a cluster on this machine, --scheduler names another: give one of them")
    if report is not None:
        refuse_bad_place(report, out, force=force)
    own_share = share_of_memory(workers) if scheduler is None else None
    bounds = Bounds(own_share if memory is None else _size(memory), time_limit)
    written = {name: value for name, value in given.items() if value not in (None, ())} | search
    for name in ("reference", "skeleton"):
        if name in written:
            value = written[name]
            written[name] = str(Path(value).absolute()) if isinstance(value, str) else _absolute(value)
    base = Treatment().with_(settings(written))
    chosen = Recipe(base) if recipe is None else read_recipe(recipe, base)
    surveyed = survey(folder, out, chosen)
    if not surveyed.tasks:
        raise OptionError(f"{folder} holds no clip of a known format" + " that the recipe means" * (recipe is not None))
    choices: dict[str, Any] = {"bounds": bounds, "restart": not resume, "retry": retry, "force": force}
    if dry_run:
        processes = 1 if workers == 0 else workers or os.cpu_count() or 1
        if scheduler is not None:
            client = connect(scheduler, workers=0)
            processes = count_threads(client)
            disconnect(client, keep_cluster=True)
        planned = plan(surveyed, Manifest.look(out) if out.is_dir() else Known(), **choices)
        _say_plan(planned, bounds, min(processes, len(planned.tasks)), as_json=as_json)
        return
    out.mkdir(parents=True, exist_ok=True)
    manifest = Manifest(out)
    client = None
    try:
        planned = plan(surveyed, manifest.known, **choices)
        if workers != 0:
            client = connect(scheduler, workers=min(workers or os.cpu_count() or 1, len(planned.tasks)))
            if not quiet and not as_json:
                say(f"Dask dashboard: {client.dashboard_link}")
        shown = _Progress(planned, quiet=quiet or as_json)
        records = do_plan(planned, manifest, bounds, client=client, workers=workers, chunk=chunk, progress=shown.step)
    finally:
        live_line.clear()
        if client is not None:
            disconnect(client, keep_cluster=scheduler is not None)
        manifest.close()
    seconds = time.perf_counter() - begun
    if report is not None:
        page = report_html(records, title=f"{folder} to {out}", seconds=seconds)
        write_bytes(report, page.encode(errors="backslashreplace"), overwrite=True)
    _say_end(records, out, report, seconds, as_json=as_json, quiet=quiet)
    failed = sum(record.status == "failed" for record in records)
    if failed:
        raise click.exceptions.Exit(EXIT_NONE_DONE if failed == len(records) else EXIT_SOME_FAILED)


def _absolute(paths: Sequence[str]) -> list[str]:
    return [str(Path(path).absolute()) for path in paths]


class _Progress:
    """Says how far a run is, and what fails as it does."""

    def __init__(self, planned: Plan, *, quiet: bool) -> None:
        self._sizes = planned.sizes
        self._clips, self._bytes = len(planned.tasks), sum(planned.sizes[task.name] for task in planned.tasks)
        self._done = self._read = 0
        self._failed = Counter[str]()
        self._begun = self._said = time.perf_counter()
        self._quiet = quiet
        self._live = not quiet and sys.stderr is not None and sys.stderr.isatty()

    def step(self, task: ClipTask, records: tuple[Record, ...]) -> None:
        """One clip is done."""
        self._done += 1
        self._read += self._sizes[task.name]
        if records[0].status == "failed":
            self._failed[records[0].code] += 1
            if not self._quiet:
                live_line.clear()
                report_error(f"{task.name}: {records[0].code}: {records[0].message}")
        now = time.perf_counter()
        if self._live and now - self._said > 0.2:
            self._said = now
            left = (now - self._begun) * (self._bytes - self._read) / max(1, self._read)
            live_line.show(
                f"{self._done:,} of {self._clips:,} clips, {_bytes(self._read)} of {_bytes(self._bytes)}, "
                f"{_kinds(self._failed)} failed, {_clock(left)} left"
            )


def _kinds(counted: Counter[str]) -> str:
    """Say how many failed, and of what."""
    kinds = ", ".join(f"{n:,} {code}" for code, n in counted.most_common())
    return f"{counted.total():,}" + f" ({kinds})" * bool(kinds)


def _say_plan(planned: Plan, bounds: Bounds, processes: int, *, as_json: bool) -> None:
    from retime.batch.trial import estimate

    tried = estimate(planned.tasks, planned.sizes, bounds)
    seconds = None if tried.seconds is None or not processes else tried.seconds / processes
    outputs = sum(len(task.places) for task in planned.tasks)
    if as_json:
        say_json(
            {
                "clips": len(planned.tasks),
                "left_out": planned.n_left_out,
                "outputs": outputs,
                "kept": tried.n_kept,
                "failed_before": tried.n_failed_before,
                "to_do": tried.n_left,
                "in_the_way": list(tried.in_the_way),
                "seconds": seconds,
                "bytes": tried.n_bytes,
                "tried": tried.n_tried,
                "failed": tried.n_failed,
            }
        )
        return
    size = "nobody knows how large" if tried.n_bytes is None else f"about {_bytes(tried.n_bytes)} are new"
    long = "nobody knows how long: what was tried failed" if tried.seconds is None else "no worker is there"
    if seconds is not None:
        long = f"about {_clock(seconds)} by {processes} process" + "es" * (processes != 1)
    again = ", and not tried again: nothing has changed (--retry)"
    rows = [
        ("clips", f"{len(planned.tasks):,}" + f", {planned.n_left_out:,} left out" * bool(planned.n_left_out)),
        ("outputs", f"{outputs:,}, {size}"),
        ("to do", f"{tried.n_left:,} clips"),
        ("kept", f"{tried.n_kept:,} clips that an earlier run has done"),
        *[("failed", f"{tried.n_failed_before:,} clips in an earlier run" + again)] * bool(tried.n_failed_before),
        *[("in the way", f"{len(tried.in_the_way):,} files that no run has written (--force)")]
        * bool(tried.in_the_way),
        ("time", long),
        ("tried", f"{tried.n_tried} clips, of which {tried.n_failed} failed"),
    ]
    rows += [
        (task.name.replace("\n", "\\n"), f"-> {', '.join(task.places[:3])}" + " ..." * (len(task.places) > 3))
        for task in planned.tasks[:10]
    ]
    say_table(rows)
    if len(planned.tasks) > 10:
        say(f"... and {len(planned.tasks) - 10:,} more clips")


def _say_end(
    records: list[Record], out: Path, report: Path | None, seconds: float, *, as_json: bool, quiet: bool
) -> None:
    counts = Counter(record.status for record in records)
    kinds = Counter(record.code for record in records if record.status == "failed")
    warned = len({record.name for record in records if record.warnings})
    if as_json:
        say_json(
            {
                **{status: counts[status] for status in ("done", "kept", "failed")},
                "failures": dict(kinds),
                "warned": warned,
                "seconds": seconds,
                "manifest": str(out / "manifest.jsonl"),
                "report": None if report is None else str(report),
            }
        )
    elif not quiet:
        rows = [
            ("done", f"{counts['done']:,} outputs in {_clock(seconds)}"),
            ("kept", f"{counts['kept']:,} that were there"),
            ("failed", f"{counts['failed']:,} clips" + "".join(f", {n:,} {code}" for code, n in kinds.most_common())),
            *[("warned", f"of {warned:,} clips; the manifest has the words")] * bool(warned),
            ("wrote", str(out / "manifest.jsonl")),
        ]
        say_table(rows + [("wrote", str(report))] * (report is not None))


def _bytes(count: float) -> str:
    for unit in ("bytes", "KB", "MB", "GB"):
        if count < 1000 or unit == "GB":
            return f"{count:.0f} {unit}" if unit == "bytes" else f"{count:.1f} {unit}"
        count /= 1000
    raise AssertionError


def _clock(seconds: float) -> str:
    if seconds < 60:
        return f"{seconds:.1f} s"
    minutes, seconds = divmod(round(seconds), 60)
    hours, minutes = divmod(minutes, 60)
    return f"{hours}:{minutes:02d}:{seconds:02d}"
