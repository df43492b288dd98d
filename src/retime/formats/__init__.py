"""Files: one small module a format, and the registry. The only place that opens motion files."""

from retime.formats.read_options import Limits, ReadOptions
from retime.formats.registry import FORMATS, Format, format_of, read, write

__all__ = ["FORMATS", "Format", "Limits", "ReadOptions", "format_of", "read", "write"]
