"""What a run of the editor leaves to the next one of the same command, so that its pages find that."""

from __future__ import annotations

import json
import os
import secrets
import time
from dataclasses import dataclass
from pathlib import Path

from retime.errors import FormatError
from retime.files import write_bytes
from retime.strict_json import parse_json

# Seconds for which a page may come back.
_DAYS = 7 * 86400.0


@dataclass(frozen=True)
class Run:
    """What a run of the editor leaves to the next one of the same command.

    Attributes
    ----------
    port : int
        On which it listened; 0 where none did.
    key : str
        Which its pages hold.
    """

    port: int
    key: str


def run_before(place: Path) -> Run:
    """Return what the last run left; a new key and no port where there was none, or long ago.

    Parameters
    ----------
    place : Path
        The file.
    """
    try:
        status = place.stat()
        found = parse_json(place.read_bytes())
    except (OSError, FormatError):
        # There is none, or it is no file of ours.
        return Run(0, secrets.token_urlsafe(32))
    own = os.name == "nt" or (status.st_uid == os.getuid() and not status.st_mode & 0o077)
    port, key = (found.get("port"), found.get("key")) if isinstance(found, dict) else (None, None)
    fits = isinstance(port, int) and 0 < port < 65536 and isinstance(key, str) and len(key) >= 32
    if not own or not fits or time.time() - status.st_mtime > _DAYS:
        return Run(0, secrets.token_urlsafe(32))
    assert isinstance(port, int)
    assert isinstance(key, str)
    return Run(port, key)


def leave_to_next(place: Path, run: Run) -> None:
    """Write down what the next run needs, for this user alone."""
    place.parent.mkdir(parents=True, exist_ok=True, mode=0o700)
    before = os.umask(0o077)
    try:
        write_bytes(place, json.dumps({"port": run.port, "key": run.key}).encode(), overwrite=True)
    finally:
        os.umask(before)
    if os.name != "nt":
        place.chmod(0o600)
