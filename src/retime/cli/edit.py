"""`retime edit`: open the editor's page on a clip or a project."""

from __future__ import annotations

import contextlib
import importlib.util
import warnings
from pathlib import Path
from typing import TYPE_CHECKING, Literal

import click

from retime.cli.clip_options import PATH
from retime.cli.help_sections import Option, SectionedCommand
from retime.cli.terminal import say
from retime.errors import MissingExtraError, MissingPageError, OptionError, RetimeWarning

if TYPE_CHECKING:
    from retime.project.allowed_places import AllowedPlaces

_EXAMPLES = (
    "\b\nExamples\n"
    "  retime edit walk.bvh\n"
    "  retime edit walk.bvh camera.csv --reference limp.bvh --project limping.retime\n"
    "  retime edit --project limping.retime"
)


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
    default_text="as the format says",
    help="The axis that is up in the files.",
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
    project: Path | None,
    folders: tuple[Path, ...],
    port: int,
    no_browser: bool,
) -> None:
    """Edit the timing of CLIP in a page in your browser; further clips get the same warp.

    The page is served at a loopback address, to this machine alone. Ctrl-C ends it; what was not saved is there again
    when the same clips or the same project are opened next.
    """
    if not clips and project is None:
        raise OptionError("name a clip to edit, or a project: --project FILE.retime")
    if not clips and references:
        raise OptionError("--reference needs a clip")
    for package in ("starlette", "uvicorn", "websockets"):
        if importlib.util.find_spec(package) is None:
            raise MissingExtraError("the editor", package=package, extra="edit")
    from retime.server import PAGE, no_page

    if not (PAGE / "index.html").is_file():
        raise MissingPageError(no_page())
    from retime.project.allowed_places import AllowedPlaces
    from retime.project.file import files_of
    from retime.project.workspace import new_document, open_document, open_project, state_folder
    from retime.server.app import Editor, EditorServer

    named = [*clips, *references, *([] if project is None else [project])]
    again = _command(clips, references, up, project, folders)
    places = AllowedPlaces([Path.cwd(), *folders, *(path.resolve().parent for path in named)], named, command=again)
    document = None
    if clips:
        document = new_document([str(clip) for clip in clips], [str(path) for path in references], up=up)
    if project is not None:
        if document is not None and project.exists():
            raise OptionError(f"{project} is there already, with clips of its own: open it without naming others")
        workspace = open_project(project, document)
        _hint_at_folders(files_of(workspace.history.present), places)
    else:
        assert document is not None
        workspace = open_document(document)

    try:
        server = EditorServer(Editor(workspace, places, state_folder()), port=port)
    except OSError:
        workspace.close()
        raise
    say(f"editing at {server.guard.address}")
    if not no_browser:
        click.launch(server.guard.address)
    # Ctrl-C is the usual way to end the editor: no error.
    with contextlib.suppress(KeyboardInterrupt):
        server.serve_until_interrupted()


def _command(
    clips: tuple[Path, ...],
    references: tuple[Path, ...],
    up: str | None,
    project: Path | None,
    folders: tuple[Path, ...],
) -> list[str]:
    """Write down how this editor was started, for a message that says how to start it again."""
    words = ["retime", "edit", *map(str, clips)]
    for option, values in (
        ("--reference", references),
        ("--up", [up]),
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
