"""Make the table of docs/formats.md from the registry: ``python tools/make_formats.py``."""

from __future__ import annotations

import re
from pathlib import Path

from retime.formats.registry import FORMATS

PAGE = Path(__file__).resolve().parents[1] / "docs" / "formats.md"
_MARKS = re.compile(r"(<!-- formats: [^\n]*-->\n).*?(<!-- /formats -->)", flags=re.DOTALL)


def page() -> str:
    """Return the page with its table made anew."""
    rows = ["| format | endings | holds | read | written |", "|---|---|---|---|---|"]
    for known in FORMATS:
        in_place = "retimed in place" if known.curves or known.frames else ""
        written = "; ".join(part for part in ("yes" if known.writes else "", in_place) if part) or "no"
        endings = ", ".join(f"`{suffix}`" for suffix in known.suffixes)
        read = f"yes, with the extra `{known.extra}`" if known.extra else "yes"
        rows.append(f"| {known.title} | {endings} | a {known.holds} | {read} | {written} |")
    table = "\n".join(rows)
    return _MARKS.sub(lambda found: f"{found[1]}{table}\n{found[2]}", PAGE.read_text(encoding="utf-8"))


if __name__ == "__main__":
    PAGE.write_text(page(), encoding="utf-8")
