"""Write ``docs/options.md``, every option of the search as it is declared: ``python tools/make_option_docs.py``."""

from __future__ import annotations

import math
from pathlib import Path

from retime.search.options import OPTIONS, Option

PAGE = Path(__file__).resolve().parents[1] / "docs" / "options.md"

_HEAD = """\
# The options of the search

What `retime.guided_warp` takes beside clips, keytimes, locks and flights, which are in [the guide](guide.md). The same
options are those of `retime warp` on the command line, of a project, and the fields at the right of the editor. [Which
to move when](choosing.md). Generated from `search/options.py` by `tools/make_option_docs.py`.
"""
_KINDS = {
    "length": 'a length: `"65%"`, `9.3` seconds, `"280f"`, or `"free"`',
    "rate": 'a rate: `29.97`, `"30000/1001"`',
    "speeds": 'a range of speeds: `"1/4..8"`',
    "influence": "from 0 to 1, or a curve of output times and shares",
    "number": "a number",
    "whole": "a whole number",
    "choice": "one of",
    "flag": "true or false",
}
_METHODS = {"hand": "`retime imitate`"}


def section(option: Option) -> str:
    """Return what the page says of an option."""
    kind = _KINDS[option.kind]
    if option.kind == "choice":
        kind += " " + ", ".join(f'`"{choice.value}"` ({choice.label})' for choice in option.choices)
    if option.unit:
        kind += f", in {option.unit}"
    bounds = [
        f"{word} {bound:g}"
        for word, bound in (("at least", option.least), ("at most", option.most))
        if math.isfinite(bound)
    ]
    if bounds:
        kind += f", {', '.join(bounds)}"
    methods = ", ".join(_METHODS.get(one, f"`{one}`") for one in option.methods)
    rows = [
        ("is", kind),
        ("where left out", option.default_words),
        ("command line", f"`{option.on_command_line}`"),
        ("editor", f"{option.label}: {option.hint}"),
        ("counts for", methods + ("; with a free length" if option.needs_free else "")),
    ]
    table = "\n".join(f"| {name} | {' '.join(text.split()).replace('|', chr(92) + '|')} |" for name, text in rows)
    return f"## `{option.name}`\n\n{option.help}\n\n| | |\n| :-- | :-- |\n{table}\n"


def page() -> str:
    """Return the page."""
    return "\n".join([_HEAD, *(section(option) for option in OPTIONS)])


if __name__ == "__main__":
    PAGE.write_text(page(), encoding="utf-8")
