"""The editor's server: messages, the solver, the session, the guard and the app."""

from pathlib import Path

# Where npm builds the page and the notebook's widget.
PAGE = Path(__file__).parent / "page"
NO_PAGE = (
    "This installation has no page for the editor. Wheels have it; in a source checkout build it with npm: make page."
)
