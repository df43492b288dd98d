"""Make docs/cli.md from the help of the command line: ``python tools/make_cli_docs.py``."""

from __future__ import annotations

from pathlib import Path

import click

from retime.cli.main import main

PAGE = Path(__file__).resolve().parents[1] / "docs" / "cli.md"
WIDTH = 100

INTRODUCTION = """\
# The command line

This is what `retime --help` and the help of each command print. Made by `tools/make_cli_docs.py`; a test compares.
"""


JSON = """\
## The JSON of `retime warp --json` and `retime imitate --json`

One object on one line; with `--variants`, one for each. Without a search (`--method linear` or `spline`) its numbers
are null.

| key | meaning |
|---|---|
| `method` | `guided`, `align`, `linear` or `spline` |
| `input`, `references` | the files read; no references where the clip is its own, the saved warp for `imitate` |
| `example` | of `imitate` only: the frames retimed by hand, as given |
| `example_clip` | of `imitate` only: the clip in which they lie, where that is another; else null |
| `coverage` | of `imitate` only: how much of the clip the example speaks for (below); null with `--paper` |
| `beats` | with `--keys-from` only: for each beat its time, and the `accent` that falls on it (null: none) |
| `variant` | with `--variants` only, where each has a line: its number, from 1 |
| `input_frames`, `input_rate`, `input_seconds` | frames used of the input, rate in Hz, and length: frames / rate |
| `output_frames`, `output_rate`, `output_seconds` | the same of the output |
| `n_input`, `n_output`, `n_reference` | frames offered to the search, selected, and imitated, at the analysis rate |
| `max_skip`, `n_neighbors`, `rate`, `upsample` | the search's options as they were used; `rate` in Hz |
| `total` | the sum of the path's costs: its local scores, and charges for changes of speed where asked for |
| `lower_bound`, `optimal` | no path totals less than the bound; whether the path is proved to be the best |
| `excess` | of `--search heuristic` only, else null: by what share the total exceeds the optimum |
| `upsamples` | for each span between keytimes the frames offered per analysis period; `upsample` is the most of them |
| `path` | the selected frames, from 0 to `n_input` - 1; `upsamples` of them make one analysis period |
| `slip` | contacts, mean mm of slip: input, output, all averaged; whether the figure's size is guessed; or null |
| `seconds` | time that each stage took; `other` is the rest of the command, from its start on |
| `output`, `warp`, `plot`, `explain` | the files written; null where none was asked for |
| `beside` | what was written beside the output: layers of a scene, a buffer, a skeleton |
| `also` | the other clips' files |

`coverage` holds the `share` of the clip that the example speaks for, from 0 to 1; `unspoken`, the stretches of which it
says little, in input seconds; `closed`, whether its ends meet, and `period`, the seconds of the cycle that was found
around it where they don't, or null; `tempo`, how many times as fast the clip moves as the one of the example; and
`warnings`, in words.
"""


def help_of(context: click.Context) -> str:
    """Return a command's help as a section of the page."""
    lines = "\n".join(line.rstrip() for line in context.get_help().splitlines())
    return f"## {context.command_path}\n\n```text\n{lines}\n```\n"


def page() -> str:
    """Return the page."""
    parts = [INTRODUCTION]
    settings = {"terminal_width": WIDTH, "max_content_width": WIDTH}
    with click.Context(main, info_name="retime", **settings, **main.context_settings) as context:
        parts.append(help_of(context))
        for name in main.list_commands(context):
            command = main.get_command(context, name)
            assert command is not None
            with click.Context(command, info_name=name, parent=context) as inner:
                parts.append(help_of(inner))
    return "\n".join([*parts, JSON])


if __name__ == "__main__":
    PAGE.write_text(page(), encoding="utf-8")
