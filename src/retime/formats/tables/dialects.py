"""The dialects of tables, and which one a file is written in: what its first rows show decides, not its name."""

from __future__ import annotations

from retime.formats.tables import deeplabcut, kinect, live_link, motive, opensim, plain, trc
from retime.formats.tables.layout import Head, Layout

# The first that knows the table reads it; the last one takes any.
_FINDERS = (motive.find, deeplabcut.find, opensim.find, trc.find, kinect.find, live_link.find, plain.find)


def find_layout(head: Head) -> Layout:
    """Tell how a table is laid out by its first rows; raise FormatError where they make no sense."""
    return next(layout for find in _FINDERS if (layout := find(head)) is not None)
