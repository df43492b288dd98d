"""The editor's server: messages, the solver, the session, the guard and the app."""

from pathlib import Path

# Where npm builds the page and the notebook's widget.
PAGE = Path(__file__).parent / "page"


def no_page() -> str:
    """Say why there is no page, and how to get it."""
    try:
        # tools/build_backend.py writes the reason there.
        reason = (PAGE / "missing.txt").read_text(encoding="utf-8").strip()
        why = f": when retime was installed, {reason}"
    except OSError:
        why = ", which npm builds"
    if (PAGE.parents[3] / "web" / "package.json").is_file():
        return f"the editor has no page in this checkout{why}. With Node.js 20.19 or newer: make page"
    return (
        f"the editor has no page here{why}. With Node.js 20.19 or newer, which brings npm, install retime from its "
        "source again: pip install --force-reinstall --no-deps PATH"
    )
