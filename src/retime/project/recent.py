"""What was opened last, for the page that is shown where nothing is named."""

from __future__ import annotations

import contextlib
import json
from pathlib import Path

from retime.errors import FormatError
from retime.files import read_bytes, write_bytes
from retime.strict_json import parse_json

MOST = 12
_MOST_BYTES = 1 << 20


def recent(folder: Path) -> list[Path]:
    """List the files opened last that are still there, the last first.

    Parameters
    ----------
    folder : Path
        Where the list is: the state folder.
    """
    try:
        value = parse_json(read_bytes(folder / "recent.json", _MOST_BYTES))
    except (FormatError, OSError):
        # None was opened yet; or another program wrote there, and the list begins anew.
        return []
    paths = value.get("paths") if isinstance(value, dict) else None
    if not isinstance(paths, list):
        return []
    found = [Path(path) for path in paths[:MOST] if isinstance(path, str) and "\0" not in path]
    return [path for path in found if path.is_absolute() and path.is_file()]


def note_recent(path: Path, folder: Path) -> None:
    """Put a file first in the list of what was opened last; where the list can't be written, it stays as it was."""
    paths = [str(path), *(str(other) for other in recent(folder) if other != path)][:MOST]
    # It is a convenience: nothing that is asked for fails for it.
    with contextlib.suppress(OSError, FormatError):
        folder.mkdir(parents=True, exist_ok=True, mode=0o700)
        write_bytes(folder / "recent.json", json.dumps({"paths": paths}).encode(), overwrite=True)
