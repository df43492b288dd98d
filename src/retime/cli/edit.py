"""`retime edit`: open the editor's page on a clip or a project."""

from __future__ import annotations

import contextlib
import hashlib
import importlib.util
import shlex
import warnings
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Literal

import click

from retime.cli.clip_options import PATH, UP_WHERE_LEFT_OUT, parsed
from retime.cli.help_sections import Option, SectionedCommand
from retime.cli.terminal import say
from retime.errors import MissingExtraError, MissingPageError, OptionError, RetimeWarning
from retime.motion.grammar import read_time

if TYPE_CHECKING:
    from retime.project.allowed_places import AllowedPlaces
    from retime.server.app import Editor, EditorServer

_EXAMPLES = (
    "\b\nExamples\n"
    "  retime edit\n"
    "  retime edit walk.bvh\n"
    "  retime edit walk.bvh camera.csv --reference limp.bvh --project limping.retime\n"
    "  retime edit dance.bvh --media take.mp4 --media-offset 0.5s --beats song.wav\n"
    "  retime edit limping.retime"
)


def _offset(text: str) -> str:
    """Check a time; it is kept as it was typed, for the clip's rate is not known yet."""
    read_time(text.removeprefix("+"))
    return text


@click.command("edit", cls=SectionedCommand, short_help="Edit the timing of a clip in your browser.", epilog=_EXAMPLES)
@click.argument("clips", type=PATH, metavar="[CLIP]...", nargs=-1)
@click.option(
    "--reference",
    "references",
    cls=Option,
    section="Input",
    metavar="CLIP",
    type=PATH,
    multiple=True,
    default_text="the clip itself",
    help="Imitate the timing of this clip; repeat for more.",
)
@click.option(
    "--up",
    cls=Option,
    section="Input",
    metavar="AXIS",
    type=click.Choice(["y", "z"]),
    default_text=UP_WHERE_LEFT_OUT,
    help="The axis that is up in the files.",
)
@click.option(
    "--media",
    cls=Option,
    section="Input",
    metavar="FILE",
    type=PATH,
    help="Show this video, or play this sound, beside the stage: the take that the motion was captured with.",
)
@click.option(
    "--media-offset",
    cls=Option,
    section="Input",
    metavar="TIME",
    callback=parsed(_offset),
    default_text="0",
    help="When it begins, counted from the first frame of the clip: 0.5s, -12f.",
)
@click.option(
    "--beats",
    cls=Option,
    section="Input",
    metavar="FILE",
    type=PATH,
    help="Snap keytimes to these moments of the output: a table of times, or the beats of sound.",
)
@click.option(
    "--project",
    cls=Option,
    section="Input",
    metavar="FILE.retime",
    type=PATH,
    help="Open this project; where there is no such file, begin it with the clips.",
)
@click.option(
    "--new",
    "anew",
    cls=Option,
    section="Input",
    is_flag=True,
    help="Begin anew with these clips; left out, go on with what was done to them before.",
)
@click.option(
    "--folder",
    "folders",
    cls=Option,
    section="Page",
    metavar="DIR",
    type=click.Path(path_type=Path, file_okay=False, exists=True),
    multiple=True,
    help="Let the page read and write in this folder too, beside the current one and those of the files named; repeat "
    "for more.",
)
@click.option(
    "--port",
    cls=Option,
    section="Page",
    metavar="N",
    type=click.IntRange(0, 65535),
    default=0,
    default_text="any that is free",
    help="Port of the loopback address.",
)
@click.option("--no-browser", cls=Option, section="Page", is_flag=True, help="Print the address, and open nothing.")
def command(
    *,
    clips: tuple[Path, ...],
    references: tuple[Path, ...],
    up: Literal["y", "z"] | None,
    media: Path | None,
    media_offset: str | None,
    beats: Path | None,
    project: Path | None,
    anew: bool,
    folders: tuple[Path, ...],
    port: int,
    no_browser: bool,
) -> None:
    """Edit the timing of CLIP in a page in your browser; further clips get the same warp.

    Without a CLIP and a project the page begins with the sample, and with what was opened last.

    The page is served at a loopback address, to this machine alone. Ctrl-C ends it; all that was done is there again
    when the same clips or the same project are opened next.
    """
    clips, project = _project_among(clips, project)
    if anew and project is not None:
        raise OptionError("--new begins anew with clips; a project is begun anew under another name")
    for option, value in (("--reference", references), ("--media", media), ("--beats", beats)):
        if not clips and value:
            raise OptionError(f"{option} needs a clip")
    if media is None and media_offset is not None:
        raise OptionError("--media-offset needs --media")
    for package in ("starlette", "uvicorn", "websockets"):
        if importlib.util.find_spec(package) is None:
            raise MissingExtraError("the editor", package=package, extra="edit")
    from retime.server import PAGE, no_page

    if not (PAGE / "index.html").is_file():
        raise MissingPageError(no_page())
    from retime.files import resolved
    from retime.media.process import check_media
    from retime.project.allowed_places import AllowedPlaces
    from retime.project.document import BeatsFile, MediaFile
    from retime.project.file import files_of
    from retime.project.recent import note_recent, recent
    from retime.project.runs import Run, leave_to_next, run_before
    from retime.project.workspace import new_document, open_document, open_project, state_folder
    from retime.server.app import Editor

    state = state_folder()
    welcome = not clips and project is None
    named = [*clips, *references, *(path for path in (media, beats, project) if path is not None)]
    again = _command(clips, references, up, media, media_offset, beats, project, folders)
    places = AllowedPlaces([Path.cwd(), *folders, *(path.resolve().parent for path in named)], named, command=again)
    document = None
    if welcome:
        sample = _own_sample(state)
        # What was opened before was named by who opened it then.
        for path in (sample, *recent(state)):
            places.add_folder(path.parent)
        document = new_document([str(sample)])
    if clips:
        document = new_document([str(clip) for clip in clips], [str(path) for path in references], up=up)
        if media is not None:
            check_media(media)
            document = replace(document, media=MediaFile(str(resolved(media)), media_offset))
        if beats is not None:
            document = replace(document, beats=BeatsFile(str(resolved(beats))))
    if project is not None:
        if document is not None and project.exists():
            raise OptionError(f"{project} is there already, with clips of its own: open it without naming others")
        workspace = open_project(project, document)
        _hint_at_folders(files_of(workspace.history.present), places)
    else:
        assert document is not None
        workspace = open_document(document, anew=anew)
        to_begin_anew = f"(to begin anew: {shlex.join([*again, '--new'])})"
        if workspace.resumed:
            say(f"going on with {workspace.path}, where these clips were saved {to_begin_anew}")
        elif workspace.recovered:
            say(f"going on with what was not saved of these clips {to_begin_anew}")

    left = state / "runs" / f"{hashlib.sha256(repr((Path.cwd(), again)).encode()).hexdigest()[:16]}.json"
    before = run_before(left)
    editor = Editor(workspace, places, state, welcome=welcome, command=shlex.join(again), key=before.key)
    try:
        server = _server_on(editor, port, before.port)
    except OSError:
        workspace.close()
        raise
    if not welcome:
        note_recent(resolved(clips[0] if project is None else project), state)
    # A page that can't come back shows the command, and does no harm.
    with contextlib.suppress(OSError):
        leave_to_next(left, Run(server.port, before.key))
    say(f"editing at {server.guard.address}")
    if not no_browser:
        click.launch(server.guard.address)
    # Ctrl-C is the usual way to end the editor: no error.
    with contextlib.suppress(KeyboardInterrupt):
        server.serve_until_interrupted()


def _own_sample(state: Path) -> Path:
    """Put the sample where what is made of it can be written, too; return its place."""
    from retime.data import SAMPLE
    from retime.files import write_bytes

    place = state / "sample" / SAMPLE.name
    data = SAMPLE.read_bytes()
    place.parent.mkdir(parents=True, exist_ok=True, mode=0o700)
    if not place.is_file() or place.read_bytes() != data:
        write_bytes(place, data, overwrite=True)
    return place


def _project_among(clips: tuple[Path, ...], project: Path | None) -> tuple[tuple[Path, ...], Path | None]:
    """Take a project that is named like a clip for what it is."""
    named = [clip for clip in clips if clip.suffix.lower() == ".retime"]
    if not named:
        return clips, project
    if project is not None or len(clips) > 1:
        raise OptionError(f"{named[0]} is a project: open it alone, as retime edit {shlex.quote(str(named[0]))}")
    return (), named[0]


def _server_on(editor: Editor, port: int, before: int) -> EditorServer:
    """Listen on the port that was asked for; else where the last run did, for its pages look there; else anywhere."""
    from retime.server.app import EditorServer

    if port == 0 and before:
        with contextlib.suppress(OSError):
            return EditorServer(editor, port=before)
    return EditorServer(editor, port=port)


def _command(
    clips: tuple[Path, ...],
    references: tuple[Path, ...],
    up: str | None,
    media: Path | None,
    media_offset: str | None,
    beats: Path | None,
    project: Path | None,
    folders: tuple[Path, ...],
) -> list[str]:
    """Write down how this editor was started, for a message that says how to start it again."""
    words = ["retime", "edit", *map(str, clips)]
    for option, values in (
        ("--reference", references),
        ("--up", [up]),
        ("--media", [media]),
        ("--media-offset", [media_offset]),
        ("--beats", [beats]),
        ("--project", [project]),
        ("--folder", folders),
    ):
        words += [word for value in values if value is not None for word in (option, str(value))]
    return words


def _hint_at_folders(files: list[str], places: AllowedPlaces) -> None:
    """Say at once what the page would say about a project whose files lie elsewhere."""
    try:
        for file in files:
            places.find(file, reading=True, beside=files)
    except OptionError as error:
        warnings.warn(str(error), RetimeWarning, stacklevel=2)
