"""Live Link Face: timecodes and the weights of blend shapes."""

from __future__ import annotations

from dataclasses import replace

from retime.formats.tables import plain
from retime.formats.tables.layout import Head, Layout


def find(head: Head) -> Layout | None:
    """Know it by the first two names. How many shapes there are says nothing of a frame, so that isn't read."""
    if [name.lower() for name in head.rows[0].fields[:2]] != ["timecode", "blendshapecount"]:
        return None
    return replace(plain.find(head), dialect="Live Link Face", clock=0)
