"""Tables as programs write them: what stands above their rows of numbers, and how they count time."""

from retime.formats.tables.dialects import find_layout
from retime.formats.tables.layout import Head, Layout

__all__ = ["Head", "Layout", "find_layout"]
