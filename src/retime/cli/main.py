"""The command `retime`: finds its commands, and turns every ending into a message and an exit code."""

from __future__ import annotations

import contextlib
import importlib
import os
import sys
from collections.abc import Sequence
from typing import Any, NoReturn

import click

from retime.cli import terminal
from retime.cli.exit_codes import (
    EXIT_FILE,
    EXIT_INFEASIBLE,
    EXIT_INTERRUPTED,
    EXIT_NONE_DONE,
    EXIT_OK,
    EXIT_SOME_FAILED,
    EXIT_USAGE,
    exit_code,
)
from retime.errors import RetimeError, words_of

# In the order of their use. Each is `command` in a module, mostly of its name.
COMMANDS = (
    *("warp", "imitate", "apply", "export", "import", "plot", "info", "convert"),
    *("batch", "demo", "edit", "report"),
)
# Where the module has another name than the command; one is a word of Python's own.
_MODULES = {"export": "export_curve", "import": "import_curve"}

_EPILOG = f"""\b
Times    2.5 or 2.5s (seconds), 120f (frames), 1:02.500 (mm:ss.mmm), 1:01:02.500,
         00:01:02:12 (timecode at the clip's rate; 00:01:02;12 is drop-frame)
Lengths  65% (of the input), or a time: 9.3 (seconds), 280f; with a search also free
Ranges   1:1980 (frames as the file numbers them, both included)
Spans    2.1..3.4 or 60f..90f (input time)
Speeds   2, 1/2, 150%, or from the slowest to the fastest: 1/4..8, uncut (at most 1)

\b
Exit codes
  {EXIT_OK}    it worked
  {EXIT_FILE}    a file could not be read or written, or an optional package is missing
  {EXIT_USAGE}    the options are wrong, or contradict each other or the data
  {EXIT_INFEASIBLE}    no warp meets the keytimes within the limits
  {EXIT_SOME_FAILED}    of many clips (batch), some failed
  {EXIT_NONE_DONE}    of many clips, all failed
  {EXIT_INTERRUPTED}  interrupted (Ctrl-C)

\b
Results go to standard output; progress, warnings and errors to standard error."""


class _Commands(click.Group):
    """A group that imports a command when it is called, and reports every error in one manner."""

    def list_commands(self, ctx: click.Context) -> list[str]:
        return list(COMMANDS)

    def get_command(self, ctx: click.Context, cmd_name: str) -> click.Command | None:
        if cmd_name not in COMMANDS:
            return None
        command: click.Command = importlib.import_module(f"retime.cli.{_MODULES.get(cmd_name, cmd_name)}").command
        return command

    def main(self, args: Sequence[str] | None = None, prog_name: str | None = None, **extra: Any) -> NoReturn:  # type: ignore[override]
        extra["standalone_mode"] = False
        if not (sys.argv[1:] if args is None else args):
            args = ["--help"]
        code = EXIT_FILE
        try:
            with terminal.showing_warnings():
                code = super().main(args, prog_name or "retime", **extra) or EXIT_OK
        except click.Abort:
            code = EXIT_INTERRUPTED
        except click.UsageError as error:
            path = error.ctx.command_path if error.ctx is not None else "retime"
            terminal.report_error(f"{error.format_message()}\nSee {path} --help.")
            code = EXIT_USAGE
        except click.ClickException as error:
            terminal.report_error(error.format_message())
        except (RetimeError, OSError) as error:
            terminal.report_error(words_of(error))
            code = exit_code(error)
        except MemoryError as error:
            terminal.report_error(
                f"not enough memory ({error}): take fewer frames, or a lower rate, max_skip or upsample"
            )
        finally:
            _leave_stdout()
        sys.exit(code)


def _leave_stdout() -> None:
    """Flush now; what can't be written then must not fail again when Python ends."""
    if sys.stdout is None:
        return
    try:
        sys.stdout.flush()
    except OSError:
        with contextlib.suppress(OSError, ValueError):
            os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())


@click.group("retime", cls=_Commands, epilog=_EPILOG, context_settings={"help_option_names": ["-h", "--help"]})
@click.version_option(package_name="retime", prog_name="retime")
def main() -> None:
    """Give a motion new timing, its poses untouched (guided time warping).

    Walking, waiting and turning are sped up or slowed down; what has its own timing, such as the flight of a jump,
    keeps it.
    """


if __name__ == "__main__":
    main()
